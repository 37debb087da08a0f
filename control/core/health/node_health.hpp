// What the bus tells about one node, whatever its frames say: whether frames are missing, its emergencies, and whether two nodes speak as one.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/classify.hpp"
#include "control/core/health/rate_watch.hpp"
#include "control/core/health/stream_watch.hpp"

namespace hoist::core {

/// How often the dictionary plans one kind of frame of one node.
struct FramePlan {
  std::int32_t period = 0;   // in 1/kStreamUnit steps of its clock; 0 = the node does not send this evenly, or not at all
  bool by_sync = false;      // its clock is the SYNC, else the control step
  RateWatch::Budget budget;  // of frames that did not come in their time; of all where there is no period
};

namespace detail {
constexpr FramePlan frame_plan(contract::NodeKind kind, contract::CobKind frame) {
  constexpr std::uint32_t kTicksPerSecond = 100, kMillisecondsPerTick = 10;
  FramePlan plan;
  switch (frame) {
    case contract::CobKind::emergency:  // inhibit time 1015h: 100 ms
      plan.budget = RateWatch::budget(10);
      return plan;
    case contract::CobKind::sdo_reply:  // the core asks at most once a step; a service tool on the same bus may ask each 4.3 ms (load plan)
      plan.budget = RateWatch::budget(2 * kTicksPerSecond);
      return plan;
    case contract::CobKind::heartbeat:  // 1017h: 100 ms
      plan.period = 10 * kStreamUnit;
      plan.budget = RateWatch::budget(10);
      return plan;
    default:
      break;
  }
  for (const contract::PdoInfo& pdo : contract::kPdos) {
    if (pdo.kind != kind || pdo.direction != contract::PdoDirection::tx || pdo.number != static_cast<std::uint8_t>(frame) + 1) continue;
    plan.by_sync = pdo.type >= 1 && pdo.type <= 240;
    const std::uint32_t ticks = plan.by_sync ? pdo.type : pdo.period_ms / kMillisecondsPerTick;
    plan.period = static_cast<std::int32_t>(ticks) * kStreamUnit;
    // With a timer of its own a node also sends on change, with each step at most (inhibit time 10 ms).
    plan.budget = RateWatch::budget(plan.by_sync ? kTicksPerSecond / ticks : kTicksPerSecond);
  }
  return plan;
}
}  // namespace detail

inline constexpr auto kFramePlans = [] {
  std::array<std::array<FramePlan, contract::kNodeCobKinds>, contract::kRemoteNodeCount> plans{};
  for (std::size_t n = 0; n < plans.size(); ++n)
    for (std::size_t kind = 0; kind < contract::kNodeCobKinds; ++kind)
      plans[n][kind] = detail::frame_plan(contract::kNodes[n].kind, static_cast<contract::CobKind>(kind));
  return plans;
}();

/// Suspicion points: one fades in each step; a decision stands for a second after the points last reached it.
class Suspicion {
 public:
  void next_tick() noexcept {
    if (points_ > 0) --points_;
    if (hold_ticks_ > 0) --hold_ticks_;
  }
  void add(std::uint8_t points) noexcept {
    points_ = points_ + points < kMost ? static_cast<std::uint8_t>(points_ + points) : kMost;
    if (points_ >= kVerdict) hold_ticks_ = kHoldTicks;
  }
  [[nodiscard]] bool verdict() const noexcept { return hold_ticks_ > 0; }
  [[nodiscard]] bool none() const noexcept { return points_ == 0 && hold_ticks_ == 0; }

 private:
  static constexpr std::uint8_t kVerdict = 40, kMost = 60, kHoldTicks = 100;

  std::uint8_t points_ = 0, hold_ticks_ = 0;
};

/// The findings about a node.
struct NodeHealth {
  std::uint32_t lost_frames = 0;    // since the core started
  std::uint16_t emcy_code = 0;      // of the latest emergency that was one; 0 = none yet
  std::uint16_t emcy_count = 0;     // messages of errors, not of their end; stays at its largest value
  std::uint8_t error_register = 0;  // 1001h as the latest emergency message told it
  std::uint8_t lost_10s = 0;        // 255 at most
};

/// What the findings are computed from.
struct NodeWatch {
  std::array<StreamWatch, contract::kTpdoMax> tpdo;
  StreamWatch heartbeat;
  std::array<RateWatch, contract::kNodeCobKinds> rate;
  std::array<std::uint8_t, 10> lost_by_second{};  // the running one and the nine before it
  bool booted = false;                            // it has reported a boot-up and was not started since
  std::uint32_t boot_tick = 0;

  void forget_streams() noexcept {
    for (StreamWatch& stream : tpdo) stream.forget();
    heartbeat.forget();
  }
  [[nodiscard]] std::uint8_t lost_lately() const noexcept {
    std::uint32_t sum = 0;
    for (const std::uint8_t lost : lost_by_second) sum += lost;
    return static_cast<std::uint8_t>(sum < 255 ? sum : 255);
  }
};

}  // namespace hoist::core
