// One value handed from one writer to any number of readers without locks, fences or system calls.
//
// Writer:  sequence = odd (relaxed); every word (release); sequence = even (release).
// Reader:  sequence (acquire), must be even; every word (acquire); sequence again (relaxed), must be unchanged.
//
// Why that is enough. Suppose a reader picks up a word of a write that is still going on. Its acquire load then synchronises with
// the writer's release store of that word, and the odd sequence was stored before that word; so the reader's second look at the
// sequence sees the odd number or a later one, never the even number it started from, and the copy is thrown away. The other way
// round, seeing the new even number (acquire) makes all words of that write visible. No fence is needed, so thread sanitizers,
// which do not understand fences, can check it; on x86 it costs the same as the fenced form (measured).
//
// Race that remains by design: a writer that never pauses can starve a reader. At 100 Hz a retry has odds of about 5e-6; readers
// still bound their tries.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "control/contract/shared_memory.hpp"

namespace hoist::publish {

// Stores `value` as number `number` (counted from 0). One writer only.
template <typename T>
void seq_write(contract::SeqSlot<T>& slot, std::uint64_t number, const T& value) noexcept {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % 8 == 0, "values travel as whole 64-bit words");
  slot.sequence.store(2 * number + 1, std::memory_order_relaxed);
  const auto* from = reinterpret_cast<const unsigned char*>(&value);
  for (std::size_t i = 0; i < slot.words.size(); ++i) {
    std::uint64_t word;
    std::memcpy(&word, from + 8 * i, 8);
    slot.words[i].store(word, std::memory_order_release);
  }
  slot.sequence.store(2 * number + 2, std::memory_order_release);
}

// Copies the value out. Returns its sequence (even, at least 2), or 0 when it was being written or never written.
template <typename T>
[[nodiscard]] std::uint64_t seq_read(const contract::SeqSlot<T>& slot, T& value) noexcept {
  const std::uint64_t before = slot.sequence.load(std::memory_order_acquire);
  if (before == 0 || (before & 1U) != 0) return 0;
  auto* to = reinterpret_cast<unsigned char*>(&value);
#pragma GCC unroll 8
  for (std::size_t i = 0; i < slot.words.size(); ++i) {
    const std::uint64_t word = slot.words[i].load(std::memory_order_acquire);
    std::memcpy(to + 8 * i, &word, 8);
  }
  return slot.sequence.load(std::memory_order_relaxed) == before ? before : 0;
}

// The sequence of the newest whole value, 0 before the first: whether there is something new, without copying it.
template <typename T>
[[nodiscard]] std::uint64_t seq_newest(const contract::SeqSlot<T>& slot) noexcept {
  return slot.sequence.load(std::memory_order_acquire) & ~std::uint64_t{1};
}

// As seq_read, with a bounded number of tries.
inline constexpr int kReadTries = 8;
template <typename T>
[[nodiscard]] std::uint64_t seq_read_retry(const contract::SeqSlot<T>& slot, T& value) noexcept {
  for (int i = 0; i < kReadTries; ++i)
    if (const std::uint64_t sequence = seq_read(slot, value)) return sequence;
  return 0;
}

}  // namespace hoist::publish
