// The whole server in one object, so that the program and the tests run the same thing.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "server/settings.hpp"

namespace hoist::server {

class App {
 public:
  explicit App(Settings settings);
  ~App();
  App(const App&) = delete;
  App& operator=(const App&) = delete;

  // Reads the token file, opens database and port. False with a sentence in `error`.
  [[nodiscard]] bool start(std::string& error);
  // Serves until stop(), then closes sockets and the recording in order.
  void run();
  // From any thread or a signal handler's follow-up: ends run().
  void stop();

  // From any thread: the hoist's own certificate is checked now instead of within a minute.
  void look_at_certificate();

  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] std::string link() const;          // the address with the one-time token; before run()
  [[nodiscard]] std::string bearer_token() const;  // before run()

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace hoist::server
