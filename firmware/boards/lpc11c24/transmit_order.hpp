// Which message object sends which identifier. The C_CAN sends the lowest object first (UM10398, chapter 16), and a frame stays in its
// object until it is sent. So a frame waits for one of a lower priority only where both share an object.
//
// Each identifier that a board sends has its own object: EMCY or SYNC, both PDOs, SDO, heartbeat; on the gateway also each of the
// computer's commands. Identifiers moved by 1400h or 1800h may share one.
#pragma once
#include <array>
#include <cstdint>

#include "control/contract/can_frame.hpp"

namespace hoist::firmware::lpc11c24 {

// The lowest identifier of each object, from object 1 on.
inline constexpr std::array<std::uint16_t, 10> kFirstIdOfObject{0x000,   // NMT
                                                                0x080,   // SYNC, EMCY
                                                                0x180,   // first process data of nodes
                                                                0x200,   // command of the left drive
                                                                0x202,   // of the right drive
                                                                0x203,   // outputs
                                                                0x280,   // second process data of nodes
                                                                0x300,   // other process data
                                                                0x580,   // SDO
                                                                0x700};  // heartbeat

// A remote frame can only be sent from a receive object (Bosch C_CAN, 3.3), which then takes the data frames of its identifier. Behind the
// chain that takes every frame it never receives one. Lowest priority: a remote frame is never urgent.
inline constexpr std::uint32_t kTransmitClasses = kFirstIdOfObject.size();
inline constexpr std::uint32_t kReceiveFirst = 17, kReceiveLast = 31, kRemoteObject = 32;
static_assert(kTransmitClasses < kReceiveFirst);

constexpr std::uint32_t transmit_object(const contract::CanFrame& frame) {
  if ((frame.flags & contract::CanFrame::kRemote) != 0) return kRemoteObject;
  const std::uint32_t id = (frame.flags & contract::CanFrame::kExtended) != 0 ? frame.id >> 18 : frame.id;
  std::uint32_t object = 1;
  while (object < kTransmitClasses && id >= kFirstIdOfObject[object]) ++object;
  return object;
}

}  // namespace hoist::firmware::lpc11c24
