// How long a strut's tilt takes from the step that reads its frame to the browser, through the running programs.
#include <poll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "control/contract/signals.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/processes.hpp"
#include "tests/bench/statistics.hpp"

namespace hoist::bench {
namespace {
constexpr double kSeconds = 8;
constexpr std::size_t kBatchHeader = 16;

double now_ms() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

// A console that only reads.
class Console {
 public:
  Console(std::uint16_t port, const std::string& token) : fd_(open_websocket(port, token)) {}
  ~Console() { ::close(fd_); }
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  void read_for(int ms) {
    pollfd wait{fd_, POLLIN, 0};
    if (::poll(&wait, 1, ms) != 1) return;
    char piece[65536];
    const ssize_t got = ::recv(fd_, piece, sizeof piece, 0);
    if (got <= 0) throw std::runtime_error("the server closed the WebSocket");
    bytes_.append(piece, static_cast<std::size_t>(got));
    while (take_frame()) {
    }
  }
  std::vector<double> batch_ms;  // from the oldest step of a batch to its arrival

 private:
  bool take_frame() {
    if (bytes_.size() < 4) return false;
    const auto byte = [this](std::size_t i) { return static_cast<unsigned char>(bytes_[i]); };
    std::size_t size = byte(1) & 0x7FU, head = 2;
    if (size == 127) throw std::runtime_error("unexpectedly large message");
    if (size == 126) {
      size = static_cast<std::size_t>(byte(2) << 8 | byte(3));
      head = 4;
    }
    if (bytes_.size() < head + size) return false;
    take_payload(byte(0) & 0x0FU, bytes_.substr(head, size));
    bytes_.erase(0, head + size);
    return true;
  }
  void take_payload(unsigned kind, const std::string& payload) {
    if (kind == 9) {
      const unsigned char pong[] = {0x8A, 0x80, 0, 0, 0, 0};
      (void)::send(fd_, pong, sizeof pong, MSG_NOSIGNAL);
    }
    if (kind != 2 || payload.size() < kBatchHeader + sizeof(contract::TickRecord)) return;
    std::uint64_t oldest_ns = 0;
    const std::size_t at = offsetof(contract::TickRecord, time_ns);
    std::memcpy(&oldest_ns, payload.data() + kBatchHeader + at, sizeof oldest_ns);
    batch_ms.push_back(now_ms() - static_cast<double>(oldest_ns) * 1e-6);
  }
  int fd_;
  std::string bytes_;
};

}  // namespace

void measure_driving(Report& report, const std::string& bin) {
  const RunningHoist hoist(bin, "stand", true);
  Console console(hoist.port(), hoist.token());
  for (const double end = now_ms() + kSeconds * 1000; now_ms() < end;) console.read_for(20);
  if (console.batch_ms.empty()) throw std::runtime_error("no telemetry arrived");
  report.add({"driving.tilt",
              "step that reads a tilt frame to browser, 99 %",
              percentile(console.batch_ms, 0.99),
              "ms",
              0,
              "",
              {55},
              false,
              "goal: 1 batch + 5 ms; oldest step of each batch"});
}

}  // namespace hoist::bench
