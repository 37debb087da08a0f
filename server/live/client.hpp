// One browser's socket: what it says is read strictly, what it is told goes through one bounded queue.
#pragma once
#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <deque>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "server/live/frame.hpp"
#include "server/live/hub.hpp"

namespace hoist::server {

// Control messages that wait for a slow client; beyond it the connection is closed, telemetry is dropped long before.
inline constexpr std::size_t kControlQueue_bytes = 256 * 1024;
// Telemetry frames that wait; the oldest goes first. Late values are worse than fewer values.
inline constexpr std::size_t kTelemetryQueue = 2;
inline constexpr std::uint64_t kMessagesPerSecond = 60;
inline constexpr std::uint64_t kPing_ns = 1'000'000'000;
inline constexpr std::uint64_t kSilence_ns = 5'000'000'000;
// The kernel's buffer per client: two seconds of telemetry, so that what is shown is never older.
inline constexpr int kSendBuffer_bytes = 32 * 1024;

class Client : public std::enable_shared_from_this<Client> {
 public:
  Client(Hub& hub, boost::asio::ip::tcp::socket socket, SessionPtr session, std::uint32_t number, std::shared_ptr<void> seat);

  void start();
  void send(const SharedFrame& frame);  // control: never dropped, bounded
  void send(const nlohmann::json& message);
  void send_telemetry(const SharedFrame& frame);  // may be dropped for a newer one
  void visit(std::uint64_t now_ns);               // each kPing_ns
  void close(CloseCode code, std::string_view reason);

  [[nodiscard]] std::uint32_t number() const { return number_; }
  [[nodiscard]] const SessionPtr& session() const { return session_; }
  [[nodiscard]] Hub& hub() const { return hub_; }
  [[nodiscard]] bool every_tick() const { return every_tick_; }
  void set_every_tick(bool on) { every_tick_ = on; }
  [[nodiscard]] bool holds_lease() const;

  // State of the drive handler: the newest sequence and when a refusal was last told.
  std::uint64_t drive_sequence = 0;
  std::uint64_t drive_notice_ns = 0;

 private:
  void read();
  void on_message(std::string text);
  void flush();
  bool next_frame();
  void gone();

  Hub& hub_;
  boost::asio::ip::tcp::socket socket_;
  boost::asio::steady_timer closing_timer_;
  SessionPtr session_;
  std::uint32_t number_;
  std::shared_ptr<void> seat_;
  FrameReader reader_;
  std::array<char, 4096> incoming_;
  std::deque<SharedFrame> control_;
  std::deque<SharedFrame> telemetry_;
  std::size_t control_bytes_ = 0;
  SharedFrame sending_;
  std::size_t sent_ = 0;
  bool waiting_ = false;
  bool every_tick_ = false;
  bool closing_ = false;
  bool gone_ = false;
  std::uint64_t heard_ns_ = 0;
  std::uint64_t allowance_ = kMessagesPerSecond;
  std::uint64_t allowance_ns_ = 0;
};

// Handles one parsed message of a client (server/live/messages.cpp).
void handle_message(Client& client, const nlohmann::json& message, const std::optional<std::string>& repeated);

}  // namespace hoist::server
