// What an application must know of the loader under it: which program it is, and when it may be ended for a new one (1F51h:1).
#pragma once
#include <cstdint>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/firmware_image.hpp"

namespace hoist::firmware {

// The program that runs, as its header in flash says; the CRC is 0 when it was never packed.
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

// Whether an application may be ended now by a write to 1F51h:1. `standing_safely`: it moves nothing and holds nothing (a drive: bridge
// off and wheel at rest). Only stop and reset mean something to a program that runs, and both lead into the loader: what would clear or
// start a program is the loader's to do.
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
