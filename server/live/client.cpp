#include "server/live/client.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "server/text/json_text.hpp"

namespace hoist::server {

using nlohmann::json;

Client::Client(ClientOwner& hub, std::unique_ptr<Stream> stream, SessionPtr session, std::uint32_t number, std::shared_ptr<void> seat)
    : SocketConnection({hub.services().counters, hub.services().now_ns}, std::move(stream), std::move(seat)),
      hub_(hub),
      session_(std::move(session)),
      number_(number),
      allowance_ns_(hub.services().now_ns()) {}

bool Client::holds_lease() const { return number_ != 0 && hub_.services().core.lease_holder() == number_; }

void Client::send(const json& message) { send(make_frame(Opcode::text, dump_json(message))); }

void Client::on_text(std::string text) {
  counters().add(Count::ws_messages);
  hub_.use(*session_);
  // A full bucket of one second's messages, refilled evenly.
  const std::uint64_t now = now_ns();
  const std::uint64_t earned = (now - allowance_ns_) * kMessagesPerSecond / 1'000'000'000;
  if (earned > 0) {
    allowance_ = std::min(kMessagesPerSecond, allowance_ + earned);
    allowance_ns_ = now;
  }
  JsonError error;
  auto message = parse_json(text, error);
  const bool is_stop = message && message->is_object() && message->value("type", json()) == "stop";
  // STOP is heard before anything else is judged.
  if (is_stop) {
    handle_message(*this, *message, std::nullopt);
    return;
  }
  if (allowance_ == 0) {
    counters().add(Count::ws_refused);
    counters().add(Count::ws_refused_rate);
    close(CloseCode::policy, "too many messages");
    return;
  }
  --allowance_;
  if (!message || !message->is_object()) {
    counters().add(Count::ws_refused);
    counters().add(Count::ws_refused_json);
    close(CloseCode::policy, "not a JSON object");
    return;
  }
  handle_message(*this, *message, repeated_name(text));
}

}  // namespace hoist::server
