#include "server/ws/connection.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>
#include <vector>

namespace hoist::server {

SocketConnection::SocketConnection(Surroundings surroundings, std::unique_ptr<Stream> stream, std::shared_ptr<void> seat)
    : surroundings_(surroundings),
      stream_(std::move(stream)),
      closing_timer_(stream_->executor()),
      seat_(std::move(seat)),
      reader_(surroundings.takes_binary) {}

void SocketConnection::start() {
  stream_->set_send_buffer(kSendBuffer_bytes);
  heard_ns_ = now_ns();
  wait();
}

void SocketConnection::wait() {
  stream_->wait_readable([self = shared_from_this()](bool ready) {
    if (self->gone_) return;
    if (ready)
      self->read();
    else
      self->gone();
  });
}

void SocketConnection::read() {
  std::vector<Incoming> messages;
  const bool good = read_turn(messages);
  take(messages);
  if (!good && !closing_) refuse_frame();
  if (stream_ended_) gone();
  if (!gone_) wait();
}

bool SocketConnection::read_turn(std::vector<Incoming>& messages) {
  std::array<char, 4096> incoming;
  bool good = true;
  for (std::size_t count = 0; good && count < kReadTurn_bytes;) {
    const Stream::Taken taken = stream_->read(incoming);
    stream_ended_ = taken.ended;
    if (taken.count == 0) break;
    count += taken.count;
    heard_ns_ = now_ns();
    if (closing_) late_bytes_ += taken.count;
    // What comes later still is thrown away: read all the same, so that our own close is not lost to a reset.
    if (!ended_ && late_bytes_ <= kLateRead_bytes) good = reader_.feed({incoming.data(), taken.count}, messages);
  }
  ended_ = ended_ || stream_ended_ || std::ranges::any_of(messages, [](const Incoming& m) { return m.kind == Incoming::Kind::close; });
  return good;
}

void SocketConnection::take(std::vector<Incoming>& messages) {
  for (Incoming& message : messages) {
    if (gone_ || (closing_ && message.kind == Incoming::Kind::close)) return;
    if (closing_ && message.kind != Incoming::Kind::text && message.kind != Incoming::Kind::binary) continue;
    switch (message.kind) {
      case Incoming::Kind::text:
      case Incoming::Kind::binary:
        // One client's message must never end the server, which others stop the hoist with.
        try {
          message.kind == Incoming::Kind::text ? on_text(std::move(message.payload)) : on_binary(std::move(message.payload));
        } catch (const std::exception&) {
          counters().add(Count::ws_failed);
          close(CloseCode::internal, "the server could not read this");
        }
        break;
      case Incoming::Kind::ping:
        send(make_frame(Opcode::pong, message.payload));
        break;
      case Incoming::Kind::pong:
        on_pong(message.payload);
        break;
      case Incoming::Kind::close:
        // With the code that the client gave (RFC 6455 5.5.1), and without its reason.
        close_with(make_frame(Opcode::close, std::string_view(message.payload).substr(0, 2)));
        return;
    }
  }
}

void SocketConnection::refuse_frame() {
  const CloseCode code = reader_.error();
  counters().add(Count::ws_refused);
  counters().add(code == CloseCode::too_big    ? Count::ws_refused_too_big
                 : code == CloseCode::not_text ? Count::ws_refused_not_text
                                               : Count::ws_refused_protocol);
  close(code, code == CloseCode::too_big ? "at most 4096 bytes" : code == CloseCode::not_text ? "text only" : "");
}

void SocketConnection::send(const SharedFrame& frame) {
  if (gone_ || closing_) return;
  if (control_bytes_ + frame->size() > kControlQueue_bytes) {
    counters().add(Count::ws_closed_slow);
    forget_all();
    close(CloseCode::try_later, "too slow");
    return;
  }
  control_.push_back(frame);
  control_bytes_ += frame->size();
  flush();
}

void SocketConnection::send_telemetry(const SharedFrame& frame, const Steps& steps) {
  if (gone_ || closing_) return;
  if (!waiting_ && !sending_ && control_.empty() && telemetry_.empty()) {
    // The usual case needs no queue.
    sent_ = 0;
    sending_ = frame;
    counters().add(Count::telemetry_frames_sent);
    flush();
    return;
  }
  telemetry_.push_back({frame, steps});
  flush();
  while (telemetry_.size() > surroundings_.telemetry_queue) {
    on_dropped(telemetry_.front().steps);
    telemetry_.pop_front();
    counters().add(Count::telemetry_frames_dropped);
  }
}

bool SocketConnection::next_frame() {
  sent_ = 0;
  if (!control_.empty()) {
    sending_ = std::move(control_.front());
    control_.pop_front();
    control_bytes_ -= sending_->size();
    return true;
  }
  if (!telemetry_.empty()) {
    sending_ = before_telemetry();
    if (sending_) return true;
    sending_ = std::move(telemetry_.front().frame);
    telemetry_.pop_front();
    counters().add(Count::telemetry_frames_sent);
    return true;
  }
  sending_.reset();
  return false;
}

void SocketConnection::forget_all() {
  control_.clear();
  control_bytes_ = 0;
  telemetry_.clear();
}

// A plain send per frame; only when less than all of it is taken, wait until more is. A frame that was begun is always finished before
// another one, so that nothing lands inside it.
void SocketConnection::flush() {
  while (!waiting_ && !gone_ && (sending_ || next_frame())) {
    const Stream::Taken taken = stream_->write(std::string_view(*sending_).substr(sent_));
    if (taken.ended) {
      // Noticed by the pending read as well; from there the client is taken off the list.
      stream_->abort();
      sending_.reset();
      forget_all();
      return;
    }
    sent_ += taken.count;
    if (sent_ == sending_->size()) {
      sending_.reset();
      continue;
    }
    if (taken.count > 0) continue;
    waiting_ = true;
    stream_->wait_writable([self = shared_from_this()](bool ready) {
      self->waiting_ = false;
      if (ready) self->flush();
    });
  }
  if (closing_ && !gone_ && !waiting_ && !sending_ && control_.empty()) stream_->shutdown_send();
}

void SocketConnection::visit(std::uint64_t now_ns) {
  if (gone_ || closing_) return;
  if (now_ns - heard_ns_ > kSilence_ns) {
    counters().add(Count::ws_closed_silent);
    gone();
    return;
  }
  // One at a time: a client that takes nothing is found silent without filling its queue.
  ping("");
}

void SocketConnection::ping(std::string_view payload) {
  if (!waiting_) send(make_frame(Opcode::ping, payload));
}

void SocketConnection::close(CloseCode code, std::string_view reason) { close_with(make_close_frame(code, reason)); }

void SocketConnection::close_with(SharedFrame last) {
  if (gone_ || closing_) return;
  telemetry_.clear();
  control_.push_back(std::move(last));
  control_bytes_ += control_.back()->size();
  closing_ = true;
  leave();
  closing_timer_.expires_after(std::chrono::seconds(1));
  closing_timer_.async_wait([self = shared_from_this()](const boost::system::error_code& error) {
    if (!error) self->gone();
  });
  flush();
}

void SocketConnection::gone() {
  if (gone_) return;
  gone_ = true;
  closing_timer_.cancel();
  stream_->close();
  forget_all();
  seat_.reset();
  leave();
}

void SocketConnection::leave() {
  if (std::exchange(left_, true)) return;
  on_leave();
}

}  // namespace hoist::server
