// The gateway's serial line as a pseudo terminal, so that a program can open it like a USB-UART converter.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace hoist::sim {

class SerialLine {
 public:
  SerialLine() = default;
  ~SerialLine();
  SerialLine(const SerialLine&) = delete;
  SerialLine& operator=(const SerialLine&) = delete;

  /// Opens a pseudo terminal in raw mode and, when `link` is not empty, puts a symbolic link to it there (replacing an older link in one
  /// step, never anything else). Empty when it worked, otherwise the sentence for people.
  [[nodiscard]] std::string open(const std::string& link);
  [[nodiscard]] const std::string& path() const { return path_; }

  /// Whether the other end is open. `changed`: this differs from the previous call.
  struct Presence {
    bool there{false};
    bool changed{false};
  };
  [[nodiscard]] Presence presence();

  /// Never block. Returns how much was taken; the rest stays with the caller.
  std::size_t read(std::span<char> bytes);
  std::size_t write(std::span<const char> bytes);

 private:
  int master_{-1};
  int slave_{-1};  // kept open: the terminal would fall back to echo and line mode each time its last user closes it
  int watch_{-1};  // inotify on the slave; without it the other end counts as open
  int openings_{};
  bool was_there_{false};
  std::string path_;
  std::string link_;
};

}  // namespace hoist::sim
