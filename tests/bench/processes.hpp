// Starts the real programs for a measurement and ends them with it.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace hoist::bench {

// A folder that goes with its contents.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

// A program with its output in a file; SIGTERM at the end, SIGKILL if it does not listen.
class Process {
 public:
  Process(const std::vector<std::string>& command, const std::string& output_path);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  [[nodiscard]] pid_t pid() const { return pid_; }
  // CPU time of all its threads so far, in nanoseconds, from the scheduler's own accounts.
  [[nodiscard]] std::uint64_t cpu_ns() const;
  [[nodiscard]] bool running() const;

 private:
  pid_t pid_ = -1;
};

}  // namespace hoist::bench
