// How long driving takes through the running programs: from the step that reads a strut's tilt to the browser, and from the joystick's message
// to the command on the bus.
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstring>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/signals.hpp"
#include "control/contract/slcan_codec.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/processes.hpp"
#include "tests/bench/statistics.hpp"

namespace hoist::bench {
namespace {
constexpr double kSeconds = 8;
constexpr std::size_t kBatchHeader = 16;
constexpr double kEvery_ms = 40;  // between two messages of the joystick, as the console's
constexpr int kMoves = 60;
constexpr double kDeflection_norm = 0.1;

double now_ms() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

// A therapist's page.
class Console {
 public:
  Console(std::uint16_t port, const std::string& token) : fd_(open_websocket(port, token)) { send(kAskWholeRecords); }
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
  void send(const std::string& message) {
    const std::string frame = client_frame(message);
    (void)!::send(fd_, frame.data(), frame.size(), MSG_NOSIGNAL);
  }
  // Whether a request is granted; `fields` are those behind type and request.
  bool ask(const std::string& type, const std::string& fields) {
    reply_.clear();
    send("{\"type\":\"" + type + "\",\"request\":" + std::to_string(++request_) + fields + "}");
    for (const double end = now_ms() + 3000; reply_.empty() && now_ms() < end;) read_for(20);
    return reply_.find("\"ok\":true") != std::string::npos;
  }
  void drive(double speed_norm) {
    send("{\"type\":\"drive\",\"sequence\":" + std::to_string(++sequence_) + ",\"echo\":" + std::to_string(newest_ns_) +
         ",\"speed\":" + std::to_string(speed_norm) + ",\"yaw\":0,\"held\":true}");
  }
  bool start() { return ask("mode", ",\"mode\":\"remote\",\"exercise\":{\"shape\":\"free\"},\"echo\":" + std::to_string(newest_ns_)); }
  [[nodiscard]] const std::string& reply() const { return reply_; }
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
    if (kind == 1 && payload.find("\"type\":\"reply\"") != std::string::npos) reply_ = payload;
    // What comes before the answer are blocks of topics.
    if (kind != 2 || payload[0] != 1 || payload.size() < kBatchHeader + sizeof(contract::TickRecord)) return;
    const auto time_ns = [&](std::size_t record_at) {
      std::uint64_t time = 0;
      std::memcpy(&time, payload.data() + record_at + offsetof(contract::TickRecord, time_ns), sizeof time);
      return time;
    };
    newest_ns_ = time_ns(payload.size() - sizeof(contract::TickRecord));
    batch_ms.push_back(now_ms() - static_cast<double>(time_ns(kBatchHeader)) * 1e-6);
  }
  int fd_;
  int request_ = 0, sequence_ = 0;
  std::uint64_t newest_ns_ = 0;
  std::string bytes_, reply_;
};

void make_raw(int fd) {
  termios raw{};
  if (::tcgetattr(fd, &raw) != 0) throw std::runtime_error("no serial line");
  ::cfmakeraw(&raw);
  ::tcsetattr(fd, TCSANOW, &raw);
}

// A tap in the serial line between core and simulator: forwards both directions and records commands to the left drive with their arrival
// time.
class Tap {
 public:
  struct Command {
    double at_ms = 0;
    std::int32_t velocity = 0;  // motor, 0.001 rad/s
  };
  Tap() : far_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    if (far_ < 0 || ::grantpt(far_) != 0 || ::unlockpt(far_) != 0) throw std::runtime_error("no pseudo-terminal");
    device_ = ::ptsname(far_);
    held_ = ::open(device_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);  // kept open: otherwise the pseudo terminal reports a hang-up
    make_raw(held_);
  }
  ~Tap() {
    done_ = true;
    if (passing_.joinable()) passing_.join();
    for (const int fd : {far_, held_, simulator_})
      if (fd >= 0) ::close(fd);
  }
  Tap(const Tap&) = delete;
  Tap& operator=(const Tap&) = delete;
  [[nodiscard]] const std::string& device() const { return device_; }  // for the core
  // Starts once the simulator's line exists.
  void connect(const std::string& line) {
    for (int i = 0; i < 500 && simulator_ < 0; ++i, ::poll(nullptr, 0, 10))
      simulator_ = ::open(line.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    make_raw(simulator_);
    passing_ = std::thread([this] { pass(); });
  }
  [[nodiscard]] std::vector<Command> commands() const {
    const std::lock_guard lock(mutex_);
    return commands_;
  }

 private:
  void pass() {
    std::array<char, 4096> text{};
    while (!done_) {
      std::array<pollfd, 2> waits{pollfd{far_, POLLIN, 0}, pollfd{simulator_, POLLIN, 0}};
      if (::poll(waits.data(), waits.size(), 100) <= 0) continue;
      for (std::size_t i = 0; i < waits.size(); ++i) {
        if ((waits[i].revents & POLLIN) == 0) continue;
        const ssize_t got = ::read(waits[i].fd, text.data(), text.size());
        if (got <= 0) continue;
        const std::span<const char> piece(text.data(), static_cast<std::size_t>(got));
        if (i == 0) note(piece, now_ms());
        (void)!::write(waits[1 - i].fd, piece.data(), piece.size());
      }
    }
  }
  void note(std::span<const char> text, double at_ms) {
    decoder_.feed(text, [&](const contract::SlcanLine& line) {
      constexpr std::uint32_t kCommand = contract::pdo_cob_id(contract::Pdo::drive_rx1, contract::Node::drive_left);
      if (line.kind != contract::SlcanKind::frame || line.frame.id != kCommand || line.frame.dlc != 6) return;
      Command command{at_ms, 0};
      std::memcpy(&command.velocity, line.frame.data.data() + 2, sizeof command.velocity);  // behind the control word
      const std::lock_guard lock(mutex_);
      commands_.push_back(command);
    });
  }

  int far_, held_ = -1, simulator_ = -1;
  std::string device_;
  contract::SlcanDecoder decoder_;
  mutable std::mutex mutex_;
  std::vector<Command> commands_;
  std::atomic<bool> done_{false};
  std::thread passing_;
};

void start_remote(Console& console) {
  for (const double end = now_ms() + 30'000; now_ms() < end; console.read_for(200))
    if (console.ask("lease_take", ",\"take_over\":true") && console.start()) return;
  throw std::runtime_error("remote driving did not start: " + console.reply());
}
void hold(Console& console, double speed_norm, double ms) {
  double next_ms = 0;
  for (const double end = now_ms() + ms; now_ms() < end; console.read_for(5)) {
    if (now_ms() < next_ms) continue;
    console.drive(speed_norm);
    next_ms = now_ms() + kEvery_ms;
  }
}
// Time from a move of the joystick at `moved_ms` to the first changed command; NaN without one.
double answered_after_ms(const std::vector<Tap::Command>& commands, double moved_ms) {
  for (std::size_t i = 1; i < commands.size(); ++i)
    if (commands[i].at_ms > moved_ms && commands[i].velocity != commands[i - 1].velocity) return commands[i].at_ms - moved_ms;
  return std::nan("");
}

void measure_joystick(Report& report, Console& console, const Tap& tap) {
  start_remote(console);
  hold(console, 0, 3 * kEvery_ms);  // pressed in the middle first
  std::vector<double> moved_ms, late_ms;
  for (int i = 0; i < kMoves; ++i) {
    moved_ms.push_back(now_ms());
    // Long enough that the speed is reached, and each time at another place between two steps.
    hold(console, i % 2 == 0 ? kDeflection_norm : 0, 250 + i * 7 % 40);
  }
  const std::vector<Tap::Command> commands = tap.commands();
  for (const double at_ms : moved_ms)
    if (const double late = answered_after_ms(commands, at_ms); late < 250) late_ms.push_back(late);
  if (late_ms.size() < kMoves * 9 / 10)
    throw std::runtime_error("only " + std::to_string(late_ms.size()) + " of " + std::to_string(kMoves) + " moves reached the bus");
  report.add({"driving.joystick", "joystick's message to the command on the bus, median", median(late_ms), "ms", 0, ""});
  report.add({"driving.joystick_p90",
              "joystick's message to the command on the bus, 90 %",
              percentile(late_ms, 0.9),
              "ms",
              0,
              "",
              {12},
              false,
              "goal: 1 tick + 2 ms; latest of " + std::to_string(late_ms.size()) + ": " +
                  std::to_string(percentile(late_ms, 1.0)).substr(0, 4) + " ms"});
}

}  // namespace

void measure_driving(Report& report, const std::string& bin) {
  Tap tap;
  const RunningHoist hoist(bin, {.core_line = tap.device()});
  tap.connect(hoist.line());
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
  measure_joystick(report, console, tap);
}

}  // namespace hoist::bench
