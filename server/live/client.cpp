#include "server/live/client.hpp"

#include <algorithm>
#include <array>
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

void Client::follow(std::shared_ptr<Feed> feed, std::uint64_t newest) {
  feed_ = std::move(feed);
  shown_to_ = newest;
}

void Client::show(const Feed::Batch& batch) {
  Steps steps = batch.steps;
  steps.from = std::max(steps.from, shown_to_ + 1);
  shown_to_ = steps.to;
  send_telemetry(batch.frame, steps);
}

void Client::show_lost(std::uint64_t to) {
  const Steps steps{.from = shown_to_ + 1, .to = to, .samples = feed_->due(shown_to_ + 1, to)};
  shown_to_ = to;
  if (steps.samples == 0) return;
  send_telemetry(make_frame(Opcode::text, dump_json(gap_json(steps.from, steps.to, steps.samples, GapReason::server_late))), steps);
}

void Client::begin_anew() {
  forget_telemetry();
  dropped_.reset();
}

// The oldest goes first, so the steps of several dropped messages follow each other.
void Client::on_dropped(const Steps& steps) {
  if (!dropped_) dropped_ = Steps{.from = steps.from, .to = 0, .samples = 0};
  dropped_->to = steps.to;
  dropped_->samples += steps.samples;
}

SharedFrame Client::before_telemetry() {
  if (!dropped_) return nullptr;
  const json gap = gap_json(dropped_->from, dropped_->to, dropped_->samples, GapReason::slow_client);
  dropped_.reset();
  return make_frame(Opcode::text, dump_json(gap));
}

json gap_json(std::uint64_t from, std::optional<std::uint64_t> to, std::optional<std::uint64_t> count, GapReason reason) {
  static constexpr std::array<std::string_view, 4> kNames{"slow_client", "server_late", "too_old", "core_restarted"};
  return {{"type", "gap"},
          {"from_tick", from},
          {"to_tick", to ? json(*to) : json(nullptr)},
          {"count", count ? json(*count) : json(nullptr)},
          {"reason", kNames[static_cast<std::size_t>(reason)]}};
}

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
  if (is_closing()) return;
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
