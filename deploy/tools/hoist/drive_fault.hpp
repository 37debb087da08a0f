// The frames that reset the fault of a drive on a bus without a control computer.
#pragma once

#include <array>
#include <cstdint>

#include "control/contract/can_dictionary.hpp"

namespace hoist::tool {

/// A drive takes commands from its RPDO only, and only while operational: so it is started, gets the rising edge of the reset bit, and
/// returns to pre-operational. No word enables anything: bit 1 (enable voltage) is clear in all of them. One frame each kFaultResetPace_s,
/// all within the drive's command deadline of 45 ms, which would otherwise raise another error.
inline constexpr double kFaultResetPace_s = 0.01;
constexpr std::array<contract::CanFrame, 5> fault_reset_frames(std::uint8_t node_id, std::uint32_t rpdo_cob_id) {
  namespace canopen = contract::canopen;
  const auto command = [rpdo_cob_id](std::uint16_t word) {
    contract::CanFrame frame{
        rpdo_cob_id & ~contract::kPdoNoRemoteBit, static_cast<std::uint8_t>(contract::pdo_bytes(contract::Pdo::drive_rx1)), 0, {}};
    contract::write_slot(frame, contract::pdo_slot(contract::Pdo::drive_rx1, 0x6040), word);
    return frame;
  };
  return {canopen::nmt(canopen::NmtCommand::start, node_id), command(canopen::drive::kDisableVoltage), command(canopen::drive::kFaultReset),
          command(canopen::drive::kDisableVoltage), canopen::nmt(canopen::NmtCommand::pre_operational, node_id)};
}

}  // namespace hoist::tool
