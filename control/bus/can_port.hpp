// The interface between the core and any CAN bus. A back end never blocks, never allocates after open(), never throws; the control thread
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

// State of our own CAN controller (CiA 301, ISO 11898: from 96 errors a warning, from 128 passive, above 255 off).
enum class BusState : std::uint8_t { active, warning, passive, off };

struct PortCounters {
  std::uint32_t received = 0;      // frames handed to the core
  std::uint32_t refused = 0;       // lines or frames dropped as malformed, and frames lost by full buffers
  std::uint32_t sent = 0;          // frames given to the device
  std::uint32_t send_refused = 0;  // frames not sent: bus down, window full, device busy, or refused by the adapter
  std::uint32_t reopened = 0;      // times the device had to be opened again
  std::uint32_t overflows = 0;     // frames that kernel, controller or adapter lost before this port could read them
  std::uint32_t bus_errors = 0;    // error reports of the controller of any kind
  std::uint32_t bus_offs = 0;      // times the controller went off the bus
  std::uint16_t tx_errors = 0;     // the controller's last reported error counters; 0 if it reports none
  std::uint16_t rx_errors = 0;
  BusState state = BusState::active;  // as last reported
};

class CanPort {
 public:
  virtual ~CanPort() = default;
  // Copies the frames that have arrived; at most out.size(), later ones are counted as refused. Also reopens a device that went away.
  virtual std::size_t receive(std::span<contract::CanFrame> out, std::uint64_t now_ns) noexcept = 0;
  // Sends in order; returns how many were taken. The rest is dropped and counted: an old command must not be sent.
  virtual std::size_t send(std::span<const contract::CanFrame> frames, std::uint64_t now_ns) noexcept = 0;
  // True while frames can pass.
  [[nodiscard]] virtual bool up() const noexcept = 0;
  [[nodiscard]] virtual const PortCounters& counters() const noexcept = 0;
  // Why up() is false, as half a sentence for people; empty while it is true. The text is static, and any thread may call this.
  [[nodiscard]] virtual const char* problem() const noexcept { return ""; }
  // What about the device should be set otherwise although frames pass, in the same form.
  [[nodiscard]] virtual const char* remark() const noexcept { return ""; }
};

// Receive filter: the core gets data frames with 11-bit ids only, tools get everything.
enum class PortUse : std::uint8_t { core, tool };

// Opens one of
//   socketcan:can0                      a CAN interface of the kernel
//   slcan:/dev/ttyUSB0[@1000000]        the UART gateway or any SLCAN adapter, with the rate of its serial line
//   replay:FILE                         a recording in candump's log format, in its original timing
// Null with the reason in `error` for a wrong name, an unreadable recording or a kernel without CAN. A missing device is no error: the port
// keeps trying and returns up() == false.
std::unique_ptr<CanPort> open_port(std::string_view address, std::string& error, PortUse use = PortUse::tool);

}  // namespace hoist::bus
