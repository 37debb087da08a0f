// What carries the characters of an SLCAN adapter: a serial line of the computer, or the simulator in lock-step.
#pragma once
#include <sys/types.h>

#include <span>

namespace hoist::bus {

/// Never blocks, allocates or throws after construction.
class SerialDevice {
 public:
  virtual ~SerialDevice() = default;
  /// Null when open, otherwise the reason as half a sentence, a static text.
  virtual const char* open() noexcept = 0;
  virtual void close() noexcept = 0;
  /// As read(2) and write(2) of a non-blocking descriptor, errno included; a read of 0 is a device that went away.
  virtual ssize_t read(std::span<char> text) noexcept = 0;
  virtual ssize_t write(std::span<const char> text) noexcept = 0;
  /// Drops what was written and has not left; for a device that keeps nothing, nothing to do.
  virtual void discard() noexcept {}
};

}  // namespace hoist::bus
