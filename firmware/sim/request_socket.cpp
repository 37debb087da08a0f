#include "firmware/sim/request_socket.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>

#include "firmware/sim/requests.hpp"
#include "firmware/sim/unix_listener.hpp"

namespace hoist::sim {

RequestSocket::~RequestSocket() {
  for (Client& client : clients_) close_client(client);
  if (listener_ >= 0) {
    ::close(listener_);
    ::unlink(path_.c_str());
  }
}

std::string RequestSocket::open(const std::string& path) {
  if (std::string why = listen_at(path, SOCK_STREAM, static_cast<int>(kClientsMax), listener_); !why.empty()) return why;
  path_ = path;
  return {};
}

void RequestSocket::close_client(Client& client) {
  if (client.fd >= 0) ::close(client.fd);
  client = {};
}

void RequestSocket::serve(const std::function<std::string(std::string_view)>& answer) {
  if (listener_ < 0) return;
  const int fd = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (fd >= 0) {
    Client* free_place = nullptr;
    for (Client& client : clients_)
      if (client.fd < 0 && free_place == nullptr) free_place = &client;
    if (free_place != nullptr) {
      free_place->fd = fd;
    } else {
      constexpr std::string_view kFull = "{\"error\":\"too many clients\"}\n";
      [[maybe_unused]] const ssize_t sent = ::send(fd, kFull.data(), kFull.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      ::close(fd);
    }
  }
  for (Client& client : clients_)
    if (client.fd >= 0) serve_client(client, answer);
}

void RequestSocket::serve_client(Client& client, const std::function<std::string(std::string_view)>& answer) {
  std::array<char, 4096> piece{};
  const ssize_t got = ::recv(client.fd, piece.data(), piece.size(), MSG_DONTWAIT);
  const bool ended = got == 0 || (got < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR);
  if (got > 0) client.in.append(piece.data(), static_cast<std::size_t>(got));
  if (got == 0) client.in += '\n';  // who has said all need not end the last line
  for (std::size_t end = client.in.find('\n'); end != std::string::npos; end = client.in.find('\n')) {
    if (end > 0) client.out += answer(std::string_view(client.in).substr(0, end)) + "\n";
    client.in.erase(0, end + 1);
  }
  const bool too_long = client.in.size() > kRequestMax;
  if (too_long) client.out += answer(client.in) + "\n";  // refused by its length
  while (!client.out.empty()) {
    const ssize_t sent = ::send(client.fd, client.out.data(), client.out.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent <= 0) break;
    client.out.erase(0, static_cast<std::size_t>(sent));
  }
  if (ended || too_long || client.out.size() > kOutMax) close_client(client);
}

}  // namespace hoist::sim
