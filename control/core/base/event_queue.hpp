// Events wait here for their step to end. A set of parameters may bring more of them than one step hands out; the rest follows in the next.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "control/contract/commands.hpp"
#include "control/core/types.hpp"

namespace hoist::core {

class EventQueue {
 public:
  /// Dropped and counted when the queue is full; the state they tell of is in every record anyway.
  void push(const contract::Event& event) noexcept {
    if (count_ == kRoom) {
      ++dropped_;
      return;
    }
    items_[(first_ + count_) % kRoom] = event;
    ++count_;
  }

  template <std::size_t N>
  void drain(FixedVector<contract::Event, N>& out) noexcept {
    while (count_ > 0 && !out.full()) {
      static_cast<void>(out.push_back(items_[first_]));
      first_ = (first_ + 1) % kRoom;
      --count_;
    }
  }

  [[nodiscard]] std::uint32_t dropped() const noexcept { return dropped_; }

 private:
  static constexpr std::size_t kRoom = 256;

  std::array<contract::Event, kRoom> items_{};
  std::size_t first_ = 0, count_ = 0;
  std::uint32_t dropped_ = 0;
};

}  // namespace hoist::core
