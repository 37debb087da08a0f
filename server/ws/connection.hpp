// One WebSocket: what comes is read strictly and given on as messages, what is sent goes through one bounded queue. A protocol derives from it.
#pragma once
#include <array>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "server/counters.hpp"
#include "server/stream/stream.hpp"
#include "server/ws/frame.hpp"

namespace hoist::server {

// Control messages that wait for a slow client; beyond it the connection is closed, telemetry is dropped long before.
inline constexpr std::size_t kControlQueue_bytes = 256 * 1024;
// Telemetry frames that wait; the oldest goes first. Late values are worse than fewer values.
inline constexpr std::size_t kTelemetryQueue = 2;
inline constexpr std::uint64_t kPing_ns = 1'000'000'000;
inline constexpr std::uint64_t kSilence_ns = 5'000'000'000;
// The kernel's buffer per client: two seconds of telemetry, so that what is shown is never older.
inline constexpr int kSendBuffer_bytes = 32 * 1024;
// Taken from one client in one turn: what a driver sends in several seconds, so that its end is known before a request in front of it is judged.
inline constexpr std::size_t kReadTurn_bytes = 64 * 1024;
// Still looked through for STOP after we have begun to close: more than a driver sends in five seconds.
inline constexpr std::size_t kLateRead_bytes = 256 * 1024;

// The steps of the core that a message of telemetry stands for, and how many samples of them it has.
struct Steps {
  std::uint64_t from = 0, to = 0, samples = 0;
};

class SocketConnection : public std::enable_shared_from_this<SocketConnection> {
 public:
  // What every connection uses; outlives them.
  struct Surroundings {
    Counters& counters;
    const std::function<std::uint64_t()>& now_ns;
    std::size_t telemetry_queue = kTelemetryQueue;
    bool takes_binary = false;
  };
  // `seat`: its place in the limits, given back when the socket is gone.
  SocketConnection(Surroundings surroundings, std::unique_ptr<Stream> stream, std::shared_ptr<void> seat);
  virtual ~SocketConnection() = default;
  SocketConnection(const SocketConnection&) = delete;
  SocketConnection& operator=(const SocketConnection&) = delete;

  void start();
  void send(const SharedFrame& frame);  // control: never dropped, bounded
  // May be dropped for a newer one; then on_dropped() is told its steps.
  void send_telemetry(const SharedFrame& frame, const Steps& steps = {});
  void visit(std::uint64_t now_ns);  // each kPing_ns
  void close(CloseCode code, std::string_view reason);

 protected:
  // Messages come also while we close the connection (is_closing): only STOP counts then.
  virtual void on_text(std::string text) = 0;
  // Only with `takes_binary`.
  virtual void on_binary(std::string) {}
  // The answer to a ping, with the bytes that the ping had.
  virtual void on_pong(std::string_view) {}
  // At most 125 bytes; left out while the client takes nothing.
  void ping(std::string_view payload);
  // The oldest telemetry has made room.
  virtual void on_dropped(const Steps&) {}
  // What must be said before the next message of telemetry; nothing: it goes by itself.
  virtual SharedFrame before_telemetry() { return nullptr; }
  // Telemetry that waits is not wanted any more.
  void forget_telemetry() { telemetry_.clear(); }
  // Once, when nothing more is taken from or told to this client; the object is still held.
  virtual void on_leave() = 0;
  [[nodiscard]] bool is_closing() const { return closing_; }
  // The client's end, a close frame or that of its stream, has been read, if not yet judged.
  [[nodiscard]] bool has_ended() const { return ended_; }
  [[nodiscard]] Counters& counters() const { return surroundings_.counters; }
  [[nodiscard]] std::uint64_t now_ns() const { return surroundings_.now_ns(); }

 private:
  void wait();
  void read();
  // True: `messages` follow the protocol; false: it was violated behind them.
  bool read_turn(std::vector<Incoming>& messages);
  void take(std::vector<Incoming>& messages);
  void refuse_frame();
  void flush();
  void close_with(SharedFrame last);
  bool next_frame();
  void forget_all();
  void gone();
  void leave();

  Surroundings surroundings_;
  std::unique_ptr<Stream> stream_;
  boost::asio::steady_timer closing_timer_;
  std::shared_ptr<void> seat_;
  FrameReader reader_;
  std::deque<SharedFrame> control_;
  struct Telemetry {
    SharedFrame frame;
    Steps steps;
  };
  std::deque<Telemetry> telemetry_;
  std::size_t control_bytes_ = 0;
  SharedFrame sending_;
  std::size_t sent_ = 0;
  bool waiting_ = false;
  bool closing_ = false;
  bool gone_ = false;
  bool left_ = false;
  bool stream_ended_ = false;
  bool ended_ = false;
  std::size_t late_bytes_ = 0;  // that have come since we close
  std::uint64_t heard_ns_ = 0;
};

}  // namespace hoist::server
