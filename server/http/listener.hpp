// Accepts connections up to the limits, reads requests with time limits, writes answers, hands WebSockets over. Its
// RequestHandler interprets the requests.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "server/counters.hpp"
#include "server/http/exchange.hpp"
#include "server/stream/tls.hpp"

namespace boost::asio {
class io_context;
}

namespace hoist::server {

// Limits of SOURCES 2.2, H31: one slow or hungry address must not keep others out. Seats of HTTP connections:
inline constexpr std::size_t kConnectionLimit = 64;
inline constexpr std::size_t kAddressLimit = 16;
// The last of all seats are for one request each of a client that is signed in, and the very last of these for STOP only.
inline constexpr std::size_t kReservedSeats = 16;
inline constexpr std::size_t kStopSeats = 4;
// WebSockets have seats of their own: an upgrade gives the HTTP seat back, so that no number of them keeps a request out.
inline constexpr std::size_t kLiveLimit = 64;
inline constexpr std::size_t kHeaderLimit_bytes = 8 * 1024;
inline constexpr std::size_t kBodyLimit_bytes = 64 * 1024;
// Of a program for a node, which comes as application/octet-stream.
inline constexpr std::size_t kImageLimit_bytes = 128 * 1024;
inline constexpr int kHeaderTime_s = 5;
inline constexpr int kReservedHeaderTime_s = 2;
inline constexpr int kBodyTime_s = 10;
inline constexpr int kIdleTime_s = 60;
// A client that does not take an answer for this long is gone.
inline constexpr int kWriteTime_s = 20;

// Who answers requests.
class RequestHandler {
 public:
  virtual ~RequestHandler() = default;
  // What dates a request at its first byte (Request::stamp), for a handler that judges its age.
  [[nodiscard]] virtual std::uint64_t stamp() const { return 0; }
  // Answers exactly once, now or later, on the network thread.
  virtual void handle(Request request, std::function<void(Response)> answer) = 0;
  // Whether a seat that is kept for clients who are signed in is for this request, of which the body is still to come.
  [[nodiscard]] virtual bool may_enter(const Request& request) = 0;
};

class Listener {
 public:
  // All of them outlive the listener. `tls` null: plain.
  Listener(boost::asio::io_context& io, Counters& counters, RequestHandler& handler, const TlsContext* tls);
  ~Listener();
  // Which peers are this computer itself; before `open`. Empty: loopback, and the address that the peer itself has called.
  void set_from_here(std::function<bool(const std::string& address)> from_here);
  // Binds and begins to accept; the port that was bound, or 0 with the reason in `error`.
  std::uint16_t open(const std::string& address, std::uint16_t port, std::string& error);
  // No new connections; idle ones end, answers under way get a moment.
  void close();
  // Closes what is still open; the connections go with the next turn of the network thread.
  void drop();
  [[nodiscard]] std::size_t connections() const;

  struct Shared;

 private:
  void accept();
  std::shared_ptr<Shared> shared_;
};

}  // namespace hoist::server
