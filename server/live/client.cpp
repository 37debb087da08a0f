#include "server/live/client.hpp"

#include <sys/socket.h>

#include <boost/beast/websocket.hpp>
#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "server/http/json_text.hpp"
#include "server/live/adopt.hpp"

namespace hoist::server {

namespace asio = boost::asio;
namespace beast = boost::beast;
using tcp = asio::ip::tcp;
using nlohmann::json;

Client::Client(Hub& hub, tcp::socket socket, SessionPtr session, std::uint32_t number, std::shared_ptr<void> seat)
    : hub_(hub),
      socket_(std::move(socket)),
      closing_timer_(socket_.get_executor()),
      session_(std::move(session)),
      number_(number),
      seat_(std::move(seat)) {}

bool Client::holds_lease() const { return number_ != 0 && hub_.services().core.lease_holder() == number_; }

void Client::start() {
  beast::error_code ignored;
  socket_.set_option(asio::socket_base::send_buffer_size(kSendBuffer_bytes), ignored);
  socket_.set_option(tcp::no_delay(true), ignored);
  socket_.non_blocking(true, ignored);
  heard_ns_ = allowance_ns_ = hub_.services().now_ns();
  read();
}

void Client::read() {
  socket_.async_read_some(asio::buffer(incoming_), [self = shared_from_this()](beast::error_code error, std::size_t count) {
    if (self->gone_) return;
    if (error) {
      self->gone();
      return;
    }
    self->heard_ns_ = self->hub_.services().now_ns();
    if (self->closing_) {
      self->read();
      return;
    }
    std::vector<Incoming> messages;
    const bool good = self->reader_.feed({self->incoming_.data(), count}, messages);
    for (Incoming& message : messages) {
      if (self->closing_ || self->gone_) break;
      switch (message.kind) {
        case Incoming::Kind::text:
          self->on_message(std::move(message.payload));
          break;
        case Incoming::Kind::ping:
          self->send(make_frame(Opcode::pong, message.payload));
          break;
        case Incoming::Kind::pong:
          break;
        case Incoming::Kind::close:
          self->close(CloseCode::normal, "");
          break;
      }
    }
    if (!good && !self->closing_) {
      Counters& counters = self->hub_.services().counters;
      counters.add(Count::ws_refused);
      const CloseCode code = self->reader_.error();
      counters.add(code == CloseCode::too_big    ? Count::ws_refused_too_big
                   : code == CloseCode::not_text ? Count::ws_refused_not_text
                                                 : Count::ws_refused_protocol);
      self->close(code, code == CloseCode::too_big ? "at most 4096 bytes" : code == CloseCode::not_text ? "text only" : "");
    }
    if (!self->gone_) self->read();
  });
}

void Client::on_message(std::string text) {
  Services& services = hub_.services();
  services.counters.add(Count::ws_messages);
  services.auth.use(*session_, static_cast<std::uint64_t>(services.utc_ns() / 1'000'000'000));
  // A full bucket of one second's messages, refilled evenly.
  const std::uint64_t now = services.now_ns();
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
    services.counters.add(Count::ws_refused);
    services.counters.add(Count::ws_refused_rate);
    close(CloseCode::policy, "too many messages");
    return;
  }
  --allowance_;
  if (!message || !message->is_object()) {
    services.counters.add(Count::ws_refused);
    services.counters.add(Count::ws_refused_json);
    close(CloseCode::policy, "not a JSON object");
    return;
  }
  handle_message(*this, *message, repeated_name(text));
}

void Client::send(const json& message) { send(make_frame(Opcode::text, dump_json(message))); }

void Client::send(const SharedFrame& frame) {
  if (gone_ || closing_) return;
  if (control_bytes_ + frame->size() > kControlQueue_bytes) {
    hub_.services().counters.add(Count::ws_closed_slow);
    control_.clear();
    control_bytes_ = 0;
    telemetry_.clear();
    close(CloseCode::try_later, "too slow");
    return;
  }
  control_.push_back(frame);
  control_bytes_ += frame->size();
  flush();
}

void Client::send_telemetry(const SharedFrame& frame) {
  if (gone_ || closing_) return;
  if (!waiting_ && !sending_ && control_.empty() && telemetry_.empty()) {
    // The usual case needs no queue.
    sent_ = 0;
    sending_ = frame;
    hub_.services().counters.add(Count::telemetry_frames_sent);
    flush();
    return;
  }
  telemetry_.push_back(frame);
  flush();
  while (telemetry_.size() > kTelemetryQueue) {
    telemetry_.pop_front();
    hub_.services().counters.add(Count::telemetry_frames_dropped);
  }
}

bool Client::next_frame() {
  sent_ = 0;
  if (!control_.empty()) {
    sending_ = std::move(control_.front());
    control_.pop_front();
    control_bytes_ -= sending_->size();
    return true;
  }
  if (!telemetry_.empty()) {
    sending_ = std::move(telemetry_.front());
    telemetry_.pop_front();
    hub_.services().counters.add(Count::telemetry_frames_sent);
    return true;
  }
  sending_.reset();
  return false;
}

// A plain send per frame; only when the kernel takes less than all of it, wait until it takes more. A frame that was begun is always
// finished before another one, so that nothing lands inside it.
void Client::flush() {
  while (!waiting_ && !gone_ && (sending_ || next_frame())) {
    const ssize_t count = ::send(socket_.native_handle(), sending_->data() + sent_, sending_->size() - sent_, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno != EAGAIN && errno != EWOULDBLOCK) {
      // Noticed by the pending read as well; from there the client is taken off the list.
      beast::error_code ignored;
      socket_.shutdown(tcp::socket::shutdown_both, ignored);
      sending_.reset();
      control_.clear();
      control_bytes_ = 0;
      telemetry_.clear();
      return;
    }
    if (count > 0) sent_ += static_cast<std::size_t>(count);
    if (sent_ == sending_->size()) {
      sending_.reset();
      continue;
    }
    waiting_ = true;
    socket_.async_wait(tcp::socket::wait_write, [self = shared_from_this()](beast::error_code error) {
      self->waiting_ = false;
      if (!error) self->flush();
    });
  }
  if (closing_ && !gone_ && !waiting_ && !sending_ && control_.empty()) {
    beast::error_code ignored;
    socket_.shutdown(tcp::socket::shutdown_send, ignored);
  }
}

void Client::visit(std::uint64_t now_ns) {
  if (gone_ || closing_) return;
  if (now_ns - heard_ns_ > kSilence_ns) {
    hub_.services().counters.add(Count::ws_closed_silent);
    gone();
    return;
  }
  // One at a time: a client that takes nothing is found silent without filling its queue.
  static const SharedFrame kPing = make_frame(Opcode::ping, "");
  if (!waiting_) send(kPing);
}

void Client::close(CloseCode code, std::string_view reason) {
  if (gone_ || closing_) return;
  telemetry_.clear();
  control_.push_back(make_close_frame(code, reason));
  control_bytes_ += control_.back()->size();
  closing_ = true;
  hub_.remove(this);
  closing_timer_.expires_after(std::chrono::seconds(1));
  closing_timer_.async_wait([self = shared_from_this()](beast::error_code error) {
    if (!error) self->gone();
  });
  flush();
}

void Client::gone() {
  if (gone_) return;
  gone_ = true;
  closing_timer_.cancel();
  beast::error_code ignored;
  socket_.close(ignored);
  control_.clear();
  telemetry_.clear();
  seat_.reset();
  hub_.remove(this);
}

void adopt_socket(Hub& hub, tcp::socket socket, beast::http::request<beast::http::string_body> request, std::shared_ptr<LiveTicket> ticket,
                  std::shared_ptr<void> seat) {
  using Stream = beast::websocket::stream<tcp::socket>;
  auto stream = std::make_shared<Stream>(std::move(socket));
  auto kept = std::make_shared<beast::http::request<beast::http::string_body>>(std::move(request));
  stream->set_option(beast::websocket::stream_base::decorator([](beast::websocket::response_type& response) {
    response.set(beast::http::field::sec_websocket_protocol, "hoist.v1");
    response.set(beast::http::field::server, "Hoist");
  }));
  beast::websocket::stream_base::timeout limits{};
  limits.handshake_timeout = std::chrono::seconds(5);
  limits.idle_timeout = beast::websocket::stream_base::none();
  stream->set_option(limits);
  stream->async_accept(*kept, [stream, kept, &hub, ticket = std::move(ticket), seat = std::move(seat)](beast::error_code error) {
    if (error) return;
    Services& services = hub.services();
    services.counters.add(Count::ws_opened);
    // Beast has done the handshake; from here the socket is ours, because its sending costs a third more than a plain send.
    auto client = std::make_shared<Client>(hub, std::move(stream->next_layer()), ticket->session, services.next_client(), seat);
    client->start();
    hub.add(std::move(client));
  });
}

}  // namespace hoist::server
