// The seam between the core and any CAN bus. A back end never blocks, never allocates after open(), never throws; the control thread
// calls it once for reading and once for writing in each step.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "control/contract/can_frame.hpp"

namespace hoist::bus {

struct PortCounters {
  std::uint32_t received = 0;      // frames handed to the core
  std::uint32_t refused = 0;       // lines or frames dropped because they were malformed, and frames lost for want of room
  std::uint32_t sent = 0;          // frames given to the device
  std::uint32_t send_refused = 0;  // frames not sent: bus down, window full, device busy, or refused by the adapter
  std::uint32_t reopened = 0;      // times the device had to be opened again
};

class CanPort {
 public:
  virtual ~CanPort() = default;
  // Copies the frames that have arrived; at most out.size(), later ones are counted as refused. Also reopens a device that went away.
  virtual std::size_t receive(std::span<contract::CanFrame> out, std::uint64_t now_ns) noexcept = 0;
  // Sends in order; returns how many were taken. What is not taken is dropped and counted: an old command is worth nothing.
  virtual std::size_t send(std::span<const contract::CanFrame> frames, std::uint64_t now_ns) noexcept = 0;
  // True while frames can pass.
  [[nodiscard]] virtual bool up() const noexcept = 0;
  [[nodiscard]] virtual const PortCounters& counters() const noexcept = 0;
};

// Opens "slcan:/dev/ttyUSB0" (the UART gateway or any SLCAN adapter). Null with the reason in `error` when the words are wrong; a device
// that is not there yet is no error: the port keeps trying and says up() == false.
std::unique_ptr<CanPort> open_port(std::string_view address, std::string& error);

}  // namespace hoist::bus
