// Where a step's events go: straight into its outputs. All of a step leave with that step; none waits for the next.
#pragma once
#include <cstddef>
#include <cstdint>

#include "control/contract/commands.hpp"
#include "control/core/types.hpp"

namespace hoist::core {

class EventSink {
 public:
  using List = FixedVector<contract::Event, kEventsPerTickMax>;

  void begin(List& list) noexcept { list_ = &list; }
  /// Between two steps the core holds no pointer: an image of it is plain bytes.
  void end() noexcept { list_ = nullptr; }

  /// Dropped and counted when the list is full. Commands never fill it (kCommandsPerTick), and a step's own events have their own share.
  void push(const contract::Event& event) noexcept {
    if (list_ == nullptr || !list_->push_back(event)) ++dropped_;
  }
  [[nodiscard]] std::size_t room() const noexcept { return list_ == nullptr ? 0 : List::capacity() - list_->size(); }
  [[nodiscard]] std::uint32_t dropped() const noexcept { return dropped_; }

 private:
  List* list_ = nullptr;
  std::uint32_t dropped_ = 0;
};

}  // namespace hoist::core
