// The application's interface to the loader: its identity, and when it may be ended for a new program (1F51h:1).
#pragma once
#include <cstdint>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/firmware_image.hpp"

namespace hoist::firmware {

// The running program, from its header in flash; the CRC is 0 when it was never packed.
struct ProgramInfo {
  std::uint32_t version = 0;  // major << 16 | minor << 8 | patch
  std::uint32_t crc = 0;
};
// Boards with a loader under them have `ProgramInfo program() const`; a node of another board says 0 for both.
template <class B>
concept LoadableBoard = requires(B board, const B constant, bool into_loader) {
  constant.program().version;
  constant.program().crc;
  board.restart(into_loader);
};

// Whether a write to 1F51h:1 may end the application now. `standing_safely`: nothing moves or is held (a drive: bridge off and wheel at
// rest). A running program accepts stop and reset only, and both lead into the loader.
[[nodiscard]] constexpr contract::canopen::SdoAbort check_program_control(std::uint32_t raw, contract::canopen::NmtState state,
                                                                          bool standing_safely) {
  using contract::canopen::SdoAbort;
  if (raw != static_cast<std::uint32_t>(contract::ProgramCommand::stop) &&
      raw != static_cast<std::uint32_t>(contract::ProgramCommand::reset))
    return SdoAbort::range;
  return state == contract::canopen::NmtState::pre_operational && standing_safely ? SdoAbort::none : SdoAbort::device_state;
}

// How long the answer to that write may take to get onto the bus before the restart comes all the same.
inline constexpr std::uint16_t kProgramAnswer_ms = 20;

}  // namespace hoist::firmware
