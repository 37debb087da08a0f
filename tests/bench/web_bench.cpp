// CPU of hoist-server per delivered WebSocket message, with telemetry of a running core, beside a bare epoll sender in the same seconds.
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <vector>

#include "tests/bench/bench.hpp"
#include "tests/bench/processes.hpp"

namespace hoist::bench {
namespace {
constexpr double kSettle_s = 1, kIdle_s = 5, kMeasured_s = 8;

// The floor: sends `size` bytes to each client 20 times a second with one plain send() each, and nothing else. Never returns.
void bare_sender(std::uint16_t port, std::size_t size) {
  const std::string frame(size, 'x');
  const int door = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0), one = 1;
  ::setsockopt(door, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::bind(door, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 || ::listen(door, 128) != 0) return;
  const int timer = ::timerfd_create(CLOCK_MONOTONIC, 0), poller = ::epoll_create1(0);
  const itimerspec every{{0, 50'000'000}, {0, 50'000'000}};
  ::timerfd_settime(timer, 0, &every, nullptr);
  for (const int fd : {door, timer}) {
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.fd = fd;
    ::epoll_ctl(poller, EPOLL_CTL_ADD, fd, &event);
  }
  std::vector<int> clients;
  for (epoll_event event{}; ::epoll_wait(poller, &event, 1, -1) == 1;) {
    if (event.data.fd == door) {
      const int client = ::accept4(door, nullptr, nullptr, SOCK_NONBLOCK);
      ::setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
      clients.push_back(client);
      continue;
    }
    std::uint64_t times = 0;
    if (::read(timer, &times, sizeof times) != sizeof times) return;
    std::erase_if(clients, [&](int fd) {
      const bool gone = ::send(fd, frame.data(), frame.size(), MSG_NOSIGNAL) < 0 && errno != EAGAIN;
      if (gone) ::close(fd);
      return gone;
    });
  }
}
// The client's end of a connection, plain or under TLS. The certificate is not checked.
class Wire {
 public:
  explicit Wire(int fd, SSL_CTX* tls = nullptr) : fd_(fd), tls_(tls == nullptr ? nullptr : SSL_new(tls)) {
    if (tls_ == nullptr) return;
    SSL_set_fd(tls_.get(), fd);
    if (SSL_connect(tls_.get()) != 1) throw std::runtime_error("the TLS handshake failed");
  }
  ~Wire() { ::close(fd_); }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;
  [[nodiscard]] int fd() const { return fd_; }
  // -1: nothing now; 0: closed.
  ssize_t read(void* into, std::size_t size) {
    if (tls_ == nullptr) return ::recv(fd_, into, size, 0);
    const int got = SSL_read(tls_.get(), into, static_cast<int>(size));
    if (got > 0) return got;
    return SSL_get_error(tls_.get(), got) == SSL_ERROR_WANT_READ ? -1 : 0;
  }
  void write(const void* data, std::size_t size) {
    if (tls_ == nullptr)
      ::send(fd_, data, size, MSG_NOSIGNAL);
    else
      SSL_write(tls_.get(), data, static_cast<int>(size));
  }

 private:
  struct Free {
    void operator()(SSL* tls) const { SSL_free(tls); }
  };
  int fd_;
  std::unique_ptr<SSL, Free> tls_;
};
using WirePtr = std::unique_ptr<Wire>;
WirePtr ask_whole_records(WirePtr wire) {
  const std::string frame = client_frame(kAskWholeRecords);
  wire->write(frame.data(), frame.size());
  return wire;
}
WirePtr open_plain(const RunningHoist& hoist) {
  return ask_whole_records(std::make_unique<Wire>(open_websocket(hoist.port(), hoist.token())));
}
WirePtr open_secure(const RunningHoist& hoist, SSL_CTX* tls) {
  auto wire = std::make_unique<Wire>(connect_to(hoist.port()), tls);
  const std::string request = websocket_request(hoist.port(), hoist.token());
  wire->write(request.data(), request.size());
  std::string answer;
  for (char byte = 0; answer.find("\r\n\r\n") == std::string::npos && wire->read(&byte, 1) == 1;) answer += byte;
  if (answer.find(" 101 ") == std::string::npos) throw std::runtime_error("hoist-server refused a WebSocket: " + answer.substr(0, 60));
  return ask_whole_records(std::move(wire));
}

// Walks over the frames of one stream and counts them; a ping is answered, so that the server does not think us dead.
class FrameCounter {
 public:
  void feed(Wire& wire, const unsigned char* data, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      if (skip_ > 0) {
        const std::size_t step = std::min<std::size_t>(skip_, size - i);
        skip_ -= step;
        i += step - 1;
        continue;
      }
      head_[have_++] = data[i];
      if (have_ < 2) continue;
      const std::size_t length7 = head_[1] & 0x7FU;
      const std::size_t need = length7 == 126 ? 4 : length7 == 127 ? 10 : 2;
      if (have_ < need) continue;
      std::size_t length = length7;
      if (need > 2) {
        length = 0;
        for (std::size_t k = 2; k < need; ++k) length = (length << 8) | head_[k];
      }
      if ((head_[0] & 0x0FU) == 2) {
        ++binary;
        binary_bytes += length + need;
      }
      if ((head_[0] & 0x0FU) == 9) {
        const std::array<unsigned char, 6> pong{0x8A, 0x80, 0, 0, 0, 0};
        wire.write(pong.data(), pong.size());
      }
      skip_ = length;
      have_ = 0;
    }
  }
  std::uint64_t binary = 0, binary_bytes = 0;

 private:
  std::array<unsigned char, 10> head_{};
  std::size_t have_ = 0, skip_ = 0;
};

// The receiving end of one sender: all its clients.
class Clients {
 public:
  explicit Clients(const std::function<WirePtr()>& open, std::size_t count) : counters_(count) {
    for (std::size_t i = 0; i < count; ++i) {
      wires_.push_back(open());
      ::fcntl(wires_.back()->fd(), F_SETFL, O_NONBLOCK);
    }
  }
  void watch(int poller, std::uint64_t tag) const {
    for (std::size_t i = 0; i < wires_.size(); ++i) {
      epoll_event event{};
      event.events = EPOLLIN;
      event.data.u64 = tag + i;
      ::epoll_ctl(poller, EPOLL_CTL_ADD, wires_[i]->fd(), &event);
    }
  }
  void read(std::size_t i) {
    const ssize_t got = wires_[i]->read(buffer_.data(), buffer_.size());
    if (got == 0) throw std::runtime_error("a connection was closed while measuring");
    if (got < 0) return;
    bytes += static_cast<std::uint64_t>(got);
    if (parsed) counters_[i].feed(*wires_[i], buffer_.data(), static_cast<std::size_t>(got));
  }
  [[nodiscard]] std::uint64_t messages() const {
    std::uint64_t sum = 0;
    for (const FrameCounter& counter : counters_) sum += counter.binary;
    return sum;
  }
  [[nodiscard]] std::uint64_t message_bytes() const {
    std::uint64_t sum = 0;
    for (const FrameCounter& counter : counters_) sum += counter.binary_bytes;
    return sum;
  }
  std::uint64_t bytes = 0;
  bool parsed = true;  // false: only bytes are counted

 private:
  std::vector<WirePtr> wires_;
  std::vector<FrameCounter> counters_;
  std::vector<unsigned char> buffer_ = std::vector<unsigned char>(65536);
};

constexpr std::uint64_t kFloorTag = 1000;
void pump(int poller, Clients& served, Clients& floor, double seconds) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  std::array<epoll_event, 128> events;
  while (Clock::now() < end) {
    const int ready = ::epoll_wait(poller, events.data(), static_cast<int>(events.size()), 20);
    for (int e = 0; e < ready; ++e) {
      const std::uint64_t tag = events[static_cast<std::size_t>(e)].data.u64;
      tag < kFloorTag ? served.read(tag) : floor.read(tag - kFloorTag);
    }
  }
}

// CPU per message of the server and of the bare sender, which serve as many clients in the same seconds.
void measure_clients(Report& report, const RunningHoist& hoist, std::size_t count, double idle_us_per_s, std::size_t frame_bytes) {
  report.progress(std::to_string(count) + " clients");
  const std::uint16_t port = free_port();
  const Process sender([&] { bare_sender(port, frame_bytes); });
  Clients served([&] { return open_plain(hoist); }, count), floor([&] { return std::make_unique<Wire>(connect_to(port)); }, count);
  floor.parsed = false;
  const int poller = ::epoll_create1(EPOLL_CLOEXEC);
  served.watch(poller, 0);
  floor.watch(poller, kFloorTag);
  pump(poller, served, floor, kSettle_s);
  const std::uint64_t messages_before = served.messages(), bytes_before = floor.bytes;
  const std::uint64_t server_before = hoist.server().cpu_ns(), sender_before = sender.cpu_ns();
  pump(poller, served, floor, kMeasured_s);
  const double server_us = static_cast<double>(hoist.server().cpu_ns() - server_before) * 1e-3;
  const double sender_us = static_cast<double>(sender.cpu_ns() - sender_before) * 1e-3;
  ::close(poller);
  const double messages = static_cast<double>(served.messages() - messages_before);
  const double sent = static_cast<double>(floor.bytes - bytes_before) / static_cast<double>(frame_bytes);
  if (messages < 1 || sent < 1) throw std::runtime_error("no messages arrived");
  const std::string n = std::to_string(count), clients = n + (count == 1 ? " client" : " clients");
  Goal goal;
  if (count > 1) goal.limit = 1.07;
  report.add({"websocket.whole_" + n, "CPU per message, idle work included, " + clients, server_us / messages, "us", sender_us / sent,
              "bare sender", goal, false, std::to_string(frame_bytes) + " B"});
  report.add({"websocket.marginal_" + n, "CPU per message without idle work, " + clients,
              (server_us - idle_us_per_s * kMeasured_s) / messages, "us", sender_us / sent, "bare sender"});
}

double idle_us_per_second(const RunningHoist& hoist) {
  ::poll(nullptr, 0, 2000);
  const std::uint64_t before = hoist.server().cpu_ns();
  ::poll(nullptr, 0, static_cast<int>(kIdle_s * 1000));
  return static_cast<double>(hoist.server().cpu_ns() - before) * 1e-3 / kIdle_s;
}
std::size_t mean_frame_bytes(const RunningHoist& hoist) {
  Clients one([&] { return open_plain(hoist); }, 1), none(nullptr, 0);
  const int poller = ::epoll_create1(EPOLL_CLOEXEC);
  one.watch(poller, 0);
  pump(poller, one, none, 1.0);
  ::close(poller);
  if (one.messages() == 0) throw std::runtime_error("no telemetry arrived");
  return one.message_bytes() / one.messages();
}
// What the server's memory grows by for each of 64 clients that get telemetry.
void measure_memory(Report& report, const RunningHoist& hoist) {
  constexpr std::size_t kClients = 64;
  const double before_kb = hoist.server().resident_kb();
  Clients many([&] { return open_plain(hoist); }, kClients), none(nullptr, 0);
  const int poller = ::epoll_create1(EPOLL_CLOEXEC);
  many.watch(poller, 0);
  pump(poller, many, none, 2.0);
  ::close(poller);
  report.add({"websocket.memory",
              "memory of the server per client, 64 clients",
              (hoist.server().resident_kb() - before_kb) / kClients,
              "kB",
              0,
              "",
              {8}});
}
// CPU per message under TLS, beside the plain server of another hoist with as many clients in the same seconds.
void measure_tls(Report& report, const RunningHoist& plain, const std::string& bin, std::size_t count) {
  report.progress("TLS, " + std::to_string(count) + " clients");
  HoistOptions options;
  options.tls = true;
  const RunningHoist secure(bin, options);
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> tls(SSL_CTX_new(TLS_client_method()), SSL_CTX_free);
  Clients served([&] { return open_secure(secure, tls.get()); }, count), beside([&] { return open_plain(plain); }, count);
  const int poller = ::epoll_create1(EPOLL_CLOEXEC);
  served.watch(poller, 0);
  beside.watch(poller, kFloorTag);
  pump(poller, served, beside, kSettle_s);
  const std::uint64_t served_before = served.messages(), beside_before = beside.messages();
  const std::uint64_t secure_before = secure.server().cpu_ns(), plain_before = plain.server().cpu_ns();
  pump(poller, served, beside, kMeasured_s);
  const double secure_us = static_cast<double>(secure.server().cpu_ns() - secure_before) * 1e-3;
  const double plain_us = static_cast<double>(plain.server().cpu_ns() - plain_before) * 1e-3;
  ::close(poller);
  const double messages = static_cast<double>(served.messages() - served_before);
  const double plain_messages = static_cast<double>(beside.messages() - beside_before);
  if (messages < 1 || plain_messages < 1) throw std::runtime_error("no messages arrived");
  const std::string n = std::to_string(count);
  report.add({"websocket.tls_" + n, "CPU per message under TLS, " + n + " clients", secure_us / messages, "us", plain_us / plain_messages,
              "without TLS"});
}
}  // namespace

void measure_websocket(Report& report, const std::string& bin) {
  const RunningHoist hoist(bin);
  const double idle_us = idle_us_per_second(hoist);
  report.add({"websocket.idle", "hoist-server without clients, CPU per second", idle_us, "us", 0, ""});
  const std::size_t frame_bytes = mean_frame_bytes(hoist);
  measure_memory(report, hoist);
  for (const std::size_t count : {1, 20, 64}) measure_clients(report, hoist, count, idle_us, frame_bytes);
  for (const std::size_t count : {20, 64}) measure_tls(report, hoist, bin, count);
}

}  // namespace hoist::bench
