// Requests to a running simulator (firmware/sim/requests.hpp), one JSON object per line over its Unix socket. Never blocks.
#pragma once
#include <string>
#include <string_view>

namespace hoist::server {

class SimulatorLine {
 public:
  SimulatorLine() = default;
  ~SimulatorLine() { close(); }
  SimulatorLine(const SimulatorLine&) = delete;
  SimulatorLine& operator=(const SimulatorLine&) = delete;

  // False: no simulator listens there. An open line is closed first.
  [[nodiscard]] bool open(const std::string& path);
  void close();
  // False: the line is not open or has ended.
  bool send(std::string_view request);
  // The next answer that has come, without its end; empty: none.
  [[nodiscard]] std::string answer();

 private:
  int fd_ = -1;
  std::string read_;
};

}  // namespace hoist::server
