// Classifies a frame by its identifier, flags and length alone. Reception, bus health, safety gate and bus/decode.cpp
// all use this one classification.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/can_frame.hpp"

namespace hoist::contract {

/// Communication objects of CiA 301, predefined connection set. The first seven are what a node sends.
enum class CobKind : std::uint8_t {
  tpdo1,
  tpdo2,
  tpdo3,
  tpdo4,
  emergency,
  sdo_reply,
  heartbeat,
  rpdo1,
  rpdo2,
  rpdo3,
  rpdo4,
  sdo_request,
  nmt,
  sync,
  unknown,  // no standard data frame, or an id without an owner in the dictionary
};
inline constexpr std::size_t kNodeCobKinds = 7, kTpdoMax = 4;

inline constexpr std::uint8_t kNotPlanned = 0xFF;

struct FrameClass {
  CobKind kind = CobKind::unknown;
  std::uint8_t node = static_cast<std::uint8_t>(kNodes.size());  // row of kNodes; kNodes.size() = none
  std::uint8_t pdo = static_cast<std::uint8_t>(kPdos.size());    // row of kPdos; kPdos.size() = none
  std::uint8_t bytes = kNotPlanned;                              // length by the dictionary; kNotPlanned = this node has no such frame
  bool fits = false;                                             // planned, and of this length

  /// From or to this node.
  [[nodiscard]] constexpr bool is_of(Node which) const noexcept { return node == static_cast<std::uint8_t>(which); }
  /// From or to a node other than the core.
  [[nodiscard]] constexpr bool is_remote() const noexcept { return node < kRemoteNodeCount; }
};

namespace detail {
/// The kind of each function code (the upper four bits of an 11-bit id) that carries a node id.
inline constexpr std::array<CobKind, 16> kKindOfFunction = {
    CobKind::unknown,     CobKind::emergency, CobKind::unknown,   CobKind::tpdo1,  CobKind::rpdo1, CobKind::tpdo2,
    CobKind::rpdo2,       CobKind::tpdo3,     CobKind::rpdo3,     CobKind::tpdo4,  CobKind::rpdo4, CobKind::sdo_reply,
    CobKind::sdo_request, CobKind::unknown,   CobKind::heartbeat, CobKind::unknown};

inline constexpr auto kNodeOfId = [] {
  std::array<std::uint8_t, 128> table{};
  table.fill(static_cast<std::uint8_t>(kNodes.size()));
  for (std::size_t i = 0; i < kNodes.size(); ++i) table[kNodes[i].id] = static_cast<std::uint8_t>(i);
  return table;
}();

struct Plan {
  std::uint8_t pdo = static_cast<std::uint8_t>(kPdos.size());
  std::uint8_t bytes = kNotPlanned;
};
constexpr Plan cob_plan(NodeKind kind, std::uint32_t base) {
  Plan plan;
  if (base == canopen::kHeartbeatBase) plan.bytes = 1;
  if (kind == NodeKind::host) return plan;
  if (base == canopen::kEmcyBase || base == canopen::kSdoReplyBase || base == canopen::kSdoRequestBase) plan.bytes = 8;
  for (std::size_t i = 0; i < kPdos.size(); ++i)
    if (kPdos[i].kind == kind && kPdos[i].cob_base == base)
      plan = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(pdo_bytes(kPdos[i].pdo))};
  return plan;
}
inline constexpr auto kCobPlans = [] {
  std::array<std::array<Plan, kKindOfFunction.size()>, kNodes.size()> plans{};
  for (std::size_t n = 0; n < plans.size(); ++n)
    for (std::uint32_t function = 0; function < kKindOfFunction.size(); ++function)
      plans[n][function] = cob_plan(kNodes[n].kind, function << 7);
  return plans;
}();
}  // namespace detail

/// Defined for every frame, also for a length above 8.
[[nodiscard]] constexpr FrameClass classify(const CanFrame& frame) noexcept {
  FrameClass what;
  if (frame.flags != 0 || frame.id > 0x7FF) return what;
  if (frame.id == canopen::kNmt || frame.id == canopen::kSync) {
    what.kind = frame.id == canopen::kNmt ? CobKind::nmt : CobKind::sync;
    what.bytes = frame.id == canopen::kNmt ? 2 : 0;
    what.fits = frame.dlc == what.bytes;
    return what;
  }
  what.node = detail::kNodeOfId[frame.id & 0x7F];
  if (what.node >= kNodes.size()) return what;
  const detail::Plan& plan = detail::kCobPlans[what.node][frame.id >> 7];
  what.kind = detail::kKindOfFunction[frame.id >> 7];
  what.pdo = plan.pdo;
  what.bytes = plan.bytes;
  what.fits = plan.bytes != kNotPlanned && frame.dlc == plan.bytes;
  return what;
}

static_assert(all_rows(kPdos,
                       [](const PdoInfo& p) {
                         const auto first = p.direction == PdoDirection::tx ? CobKind::tpdo1 : CobKind::rpdo1;
                         return p.cob_base <= 0x780 && p.cob_base % 0x80 == 0 &&
                                static_cast<int>(detail::kKindOfFunction[p.cob_base >> 7]) == static_cast<int>(first) + p.number - 1;
                       }),
              "can_dictionary.def: a PDO's COB base is not that of its direction and number in the predefined connection set");

}  // namespace hoist::contract
