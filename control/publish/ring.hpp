// A ring of sequence-locked slots: the writer never waits and overwrites the oldest; a reader that fell behind learns how many it lost.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/publish/seq_cell.hpp"

namespace hoist::publish {

// Writer side. One writer only; `written` is its own counter, so it is read relaxed.
template <typename T, std::size_t Slots>
void ring_write(contract::SeqRing<T, Slots>& ring, const T& value) noexcept {
  const std::uint64_t number = ring.written.load(std::memory_order_relaxed);
  seq_write(ring.slots[number % Slots], number, value);
  ring.written.store(number + 1, std::memory_order_release);
}

struct RingRead {
  std::size_t count = 0;   // values copied out
  std::uint64_t lost = 0;  // values that were overwritten before they could be read, all older than the ones copied
};

// Reader side: copies the values from `cursor` on, oldest first, and moves the cursor.
// The counter and the slots may lie in memory that another process writes: a counter that runs backwards or leaps is taken as
// "everything before is lost", never as an index to trust.
template <typename T, std::size_t Slots>
RingRead ring_read(const contract::SeqRing<T, Slots>& ring, std::uint64_t& cursor, std::span<T> out) noexcept {
  RingRead result;
  const std::uint64_t written = ring.written.load(std::memory_order_acquire);
  if (written < cursor) {
    cursor = written;
    return result;
  }
  if (written - cursor > Slots) {
    result.lost = written - cursor - Slots;
    cursor = written - Slots;
  }
  while (result.count < out.size() && cursor < written) {
    const std::uint64_t sequence = seq_read(ring.slots[cursor % Slots], out[result.count]);
    if (sequence == 2 * cursor + 2) {
      ++result.count;
    } else if (result.count > 0) {
      break;  // overwritten while we copied: hand out what is whole, find out about the loss at the next call
    } else {
      ++result.lost;
    }
    ++cursor;
  }
  return result;
}

// The newest value, or false when there is none yet.
template <typename T, std::size_t Slots>
bool ring_newest(const contract::SeqRing<T, Slots>& ring, T& value) noexcept {
  for (int i = 0; i < kReadTries; ++i) {
    const std::uint64_t written = ring.written.load(std::memory_order_acquire);
    if (written == 0) return false;
    if (seq_read(ring.slots[(written - 1) % Slots], value) == 2 * written) return true;
  }
  return false;
}

}  // namespace hoist::publish
