// CPU of hoist-server per delivered WebSocket message, with real telemetry of a running core.
#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "tests/bench/bench.hpp"
#include "tests/bench/processes.hpp"

namespace hoist::bench {
namespace {
std::uint16_t free_port() {
  const int probe = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ::bind(probe, reinterpret_cast<sockaddr*>(&address), size);
  ::getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size);
  ::close(probe);
  return ntohs(address.sin_port);
}
std::string read_file(const std::string& path) {
  std::ifstream file(path);
  std::stringstream all;
  all << file.rdbuf();
  std::string text = all.str();
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  return text;
}
// Opens one WebSocket; -1 when the server refuses. Leaves whatever followed the handshake in the socket's way: frames are counted by bytes.
int open_websocket(std::uint16_t port, const std::string& token, std::string& answer) {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
    ::close(fd);
    return -1;
  }
  const std::string request = "GET /ws HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) +
                              "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                              "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: hoist.v1\r\nAuthorization: Bearer " +
                              token + "\r\n\r\n";
  if (::send(fd, request.data(), request.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(request.size())) return -1;
  answer.clear();
  char byte;
  while (answer.find("\r\n\r\n") == std::string::npos && ::recv(fd, &byte, 1, 0) == 1) answer += byte;
  if (answer.find(" 101 ") == std::string::npos) {
    ::close(fd);
    return -1;
  }
  ::fcntl(fd, F_SETFL, O_NONBLOCK);
  return fd;
}
// Walks over the frames of one stream and counts them; a ping is answered, so that the server does not think us dead.
class FrameCounter {
 public:
  void feed(int fd, const unsigned char* data, std::size_t size) {
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
      if ((head_[0] & 0x0FU) == 2) ++binary;
      if ((head_[0] & 0x0FU) == 9) {
        const std::array<unsigned char, 6> pong{0x8A, 0x80, 0, 0, 0, 0};
        ::send(fd, pong.data(), pong.size(), MSG_NOSIGNAL);
      }
      skip_ = length;
      have_ = 0;
    }
  }
  std::uint64_t binary = 0;

 private:
  std::array<unsigned char, 10> head_{};
  std::size_t have_ = 0, skip_ = 0;
};
}  // namespace

Rows measure_websocket(const std::string& bin, int clients, double seconds) {
  const TemporaryFolder folder;
  const std::uint16_t port = free_port();
  const Process sim({bin + "/hoist-sim", "--scenario", "stand", "--pty-link", folder / "can", "--control", folder / "sim.sock"},
                    folder / "log");
  const Process control({bin + "/hoist-control", "--bus", "slcan:" + (folder / "can"), "--socket", folder / "core.sock"}, folder / "log");
  const Process server({bin + "/hoist-server", "--socket", folder / "core.sock", "--port", std::to_string(port), "--web", folder / "",
                        "--db", folder / "hoist.db", "--scenario", "stand", "--token-file", folder / "token"},
                       folder / "log");
  std::string token, answer;
  std::vector<int> sockets;
  for (int i = 0; i < 500 && sockets.empty(); ++i) {
    ::poll(nullptr, 0, 20);
    token = read_file(folder / "token");
    if (token.empty()) continue;
    const int fd = open_websocket(port, token, answer);
    if (fd >= 0) sockets.push_back(fd);
  }
  if (sockets.empty()) throw std::runtime_error("hoist-server did not come up: " + answer + read_file(folder / "log"));
  while (sockets.size() < static_cast<std::size_t>(clients)) {
    const int fd = open_websocket(port, token, answer);
    if (fd < 0) break;  // the server's own limit per address
    sockets.push_back(fd);
  }
  const int poller = ::epoll_create1(EPOLL_CLOEXEC);
  std::vector<FrameCounter> counters(sockets.size());
  for (std::size_t i = 0; i < sockets.size(); ++i) {
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.u64 = i;
    ::epoll_ctl(poller, EPOLL_CTL_ADD, sockets[i], &event);
  }
  using Clock = std::chrono::steady_clock;
  const auto pump = [&](double for_seconds) {
    const auto end = Clock::now() + std::chrono::duration<double>(for_seconds);
    std::array<epoll_event, 64> events;
    std::vector<unsigned char> buffer(65536);
    while (Clock::now() < end) {
      const int ready = ::epoll_wait(poller, events.data(), static_cast<int>(events.size()), 20);
      for (int e = 0; e < ready; ++e) {
        const std::size_t i = events[static_cast<std::size_t>(e)].data.u64;
        const ssize_t got = ::recv(sockets[i], buffer.data(), buffer.size(), 0);
        if (got > 0) counters[i].feed(sockets[i], buffer.data(), static_cast<std::size_t>(got));
      }
    }
  };
  const auto total = [&] {
    std::uint64_t sum = 0;
    for (const FrameCounter& counter : counters) sum += counter.binary;
    return sum;
  };
  pump(2.0);
  const std::uint64_t messages_before = total(), cpu_before = server.cpu_ns();
  pump(seconds);
  const double messages = static_cast<double>(total() - messages_before);
  const double cpu_us = static_cast<double>(server.cpu_ns() - cpu_before) * 1e-3;
  for (const int fd : sockets) ::close(fd);
  ::close(poller);
  if (messages < 1) throw std::runtime_error("no telemetry arrived");
  return {{"server CPU per delivered WebSocket message", cpu_us / messages, "us", 0, "", 0, 0, false,
           std::to_string(sockets.size()) + " clients, 20 messages/s each, recorder idle, whole process"},
          {"WebSocket messages per second and client", messages / seconds / static_cast<double>(sockets.size()), "1/s", 20, "asked", 1.02,
           0, false, ""}};
}

}  // namespace hoist::bench
