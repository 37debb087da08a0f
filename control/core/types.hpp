// The seam of the core: what one control step takes in and gives out. Used by the loop, the replay, the simulator's closed loop and the tests.
//
// Frames: x forward, y left, z up. alpha > 0 leans forward, beta > 0 leans right, psi > 0 turns left. SI units throughout.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/contract/can_frame.hpp"
#include "control/contract/commands.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"
#include "control/contract/signals.hpp"

namespace hoist::core {

/// The control period. Algorithm 1's braking factor is per step (D13 in the paper's readings), so this is a constant and no setting.
inline constexpr double kTick_s = 0.01;

/// A list with a fixed room. Nothing here ever allocates; a full list says so instead of growing.
template <typename T, std::size_t N>
class FixedVector {
 public:
  /// False, and the list unchanged, when it is full.
  [[nodiscard]] constexpr bool push_back(const T& item) noexcept {
    if (size_ == N) return false;
    items_[size_++] = item;
    return true;
  }
  constexpr void clear() noexcept { size_ = 0; }
  constexpr void pop_back() noexcept {
    if (size_ > 0) --size_;
  }
  [[nodiscard]] constexpr std::size_t size() const noexcept { return size_; }
  [[nodiscard]] constexpr bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] constexpr bool full() const noexcept { return size_ == N; }
  [[nodiscard]] static constexpr std::size_t capacity() noexcept { return N; }
  [[nodiscard]] constexpr T& operator[](std::size_t i) noexcept { return items_[i]; }
  [[nodiscard]] constexpr const T& operator[](std::size_t i) const noexcept { return items_[i]; }
  [[nodiscard]] constexpr const T* data() const noexcept { return items_.data(); }
  [[nodiscard]] constexpr T* begin() noexcept { return items_.data(); }
  [[nodiscard]] constexpr T* end() noexcept { return items_.data() + size_; }
  [[nodiscard]] constexpr const T* begin() const noexcept { return items_.data(); }
  [[nodiscard]] constexpr const T* end() const noexcept { return items_.data() + size_; }

 private:
  std::array<T, N> items_;
  std::size_t size_ = 0;
};

/// What the bus back end counts and is told by its controller, since the start (bus::PortCounters, copied: the core knows no back end).
struct BusCounters {
  std::uint32_t refused = 0;       // lines and frames that it refused itself
  std::uint32_t send_refused = 0;  // frames of ours that it did not take
  std::uint32_t reopened = 0;
  std::uint32_t overflows = 0;
  std::uint32_t errors = 0;
  std::uint16_t tx_errors = 0, rx_errors = 0;
  std::uint8_t state = 0;  // 0 active, 1 warning, 2 passive, 3 off
};

/// What the loop around the core measured of itself. Only shown and recorded; what the core reacts to is `wake_lateness_s`.
struct LoopHealth {
  float lateness_p50_s = 0, lateness_p99_s = 0, lateness_max_s = 0;  // of the last ten seconds
  std::uint32_t page_faults = 0, allocations = 0;                    // of the control thread since it settled
  std::uint8_t priority = 0;                                         // under SCHED_FIFO; 0: an ordinary thread
  std::uint8_t cpu = 255;                                            // bound to this one; 255: to none
  bool memory_locked = false;
};

/// Everything a step may know. The caller copies from shared memory once; the core trusts no field of `commands` and `drive`.
struct TickInputs {
  std::uint64_t tick = 0;                      // number of this step since the core started
  std::uint64_t time_ns = 0;                   // the steady clock at its wake-up
  std::span<const contract::CanFrame> frames;  // received since the last step, in order
  BusCounters bus;
  bool bus_up = false;
  std::span<const contract::Command> commands;  // new since the last step, in order
  bool drive_fresh = false;                     // `drive` was written since the last step
  contract::DriveCommand drive;
  std::uint64_t server_heartbeat = 0;  // counts up while the server lives
  std::uint64_t server_life = 0;       // another number: another server, whose command sequence begins at 1 again; 0: none attached
  float wake_lateness_s = 0;
  float previous_duration_s = 0;
  LoopHealth loop;
};

inline constexpr std::size_t kFramesPerTickMax = 48;

/// The ring between the programs holds 64; the loop may add a STOP. What a caller gives beyond them is refused unread, except what only stops.
inline constexpr std::size_t kCommandsPerTick = 65;
/// The most events of one command: a whole set, or a trial that is reverted, has one for each row, and its end; then the answer.
inline constexpr std::size_t kEventsOfCommandMost = contract::kParamCount + 5;
/// What a step may tell by itself: a trial that runs out, gains that arrive, each fault raised and cleared, emergencies of six nodes.
inline constexpr std::size_t kOwnEventsMost = 2 * contract::kParamCount + 2 * contract::kFaults.size() + 6 * 15 + 20;
/// Room that commands leave for the stops among them, and for what the rest of the step tells.
inline constexpr std::size_t kEventsAfterCommands = 64;
inline constexpr std::size_t kEventsPerTickMax = kOwnEventsMost + kCommandsPerTick + kEventsOfCommandMost + kEventsAfterCommands;

/// Everything a step asks for. `frames` are to be sent in their order: drive commands first, SYNC last.
struct TickOutputs {
  FixedVector<contract::CanFrame, kFramesPerTickMax> frames;
  FixedVector<contract::Event, kEventsPerTickMax> events;
  contract::TickRecord record;
  bool params_changed = false;  // the parameters in force differ from those before this step: store and publish them
  bool stops_changed = false;   // what is known of earlier stops differs from what it was before this step: store it (stop_history)
};

}  // namespace hoist::core
