// A Unix stream socket for requests: lines in, lines out, several clients, never blocks.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace hoist::sim {

class RequestSocket {
 public:
  RequestSocket() = default;
  ~RequestSocket();
  RequestSocket(const RequestSocket&) = delete;
  RequestSocket& operator=(const RequestSocket&) = delete;

  /// Listens at `path`, for this user only. A stale socket is replaced; any other file stays. Empty when it worked.
  [[nodiscard]] std::string open(const std::string& path);

  /// Answers waiting requests. `answer` gets a line without its end and returns one. Without open() it does nothing.
  void serve(const std::function<std::string(std::string_view)>& answer);

 private:
  struct Client {
    int fd{-1};
    std::string in;
    std::string out;
  };
  static constexpr std::size_t kClientsMax = 8;
  static constexpr std::size_t kOutMax = 65536;  // a client that reads nothing is closed

  void serve_client(Client& client, const std::function<std::string(std::string_view)>& answer);
  static void close_client(Client& client);

  int listener_{-1};
  std::string path_;
  std::array<Client, kClientsMax> clients_;
};

}  // namespace hoist::sim
