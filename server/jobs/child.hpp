// A program of its own for heavy work of a job: niced like the jobs' thread, without the server's files and sockets, killed with its owner.
#pragma once
#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "db/store/result.hpp"

namespace hoist::server {

class Child {
 public:
  /// Starts `arguments`, of which the first is the program's path. What it prints, also on stderr, is read by `line`.
  /// Errors: io (with the reason).
  static db::Result<Child> start(const std::vector<std::string>& arguments);
  Child(Child&& other) noexcept;
  Child& operator=(Child&&) = delete;
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  /// Kills what still runs.
  ~Child();

  /// The next line that it printed, waiting for at most `wait_ms`. Nothing: none came, or (`ended()`) there will be none.
  std::optional<std::string> line(int wait_ms);
  [[nodiscard]] bool ended() const { return ended_; }
  /// After `ended()`: its exit code; 128 and the signal's number when a signal ended it.
  int exit_code();
  /// Its processes use no processor time from here on, until told otherwise.
  void pause(bool paused);

 private:
  Child(pid_t pid, int output) : pid_(pid), output_(output) {}
  std::optional<std::string> taken_line();

  pid_t pid_ = -1;
  int output_ = -1;
  std::string read_;
  bool ended_ = false, paused_ = false;
};

}  // namespace hoist::server
