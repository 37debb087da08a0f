// A queue between one interrupt and the main loop: one side writes, the other reads, no lock. Size is a power of two.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace hoist::firmware::cortex_m0 {

template <class T, std::size_t kSize>
class Ring {
 public:
  static_assert(kSize >= 2 && (kSize & (kSize - 1)) == 0);

  [[nodiscard]] bool empty() const { return written_ == read_; }
  [[nodiscard]] bool full() const { return written_ - read_ == kSize; }
  [[nodiscard]] std::size_t size() const { return written_ - read_; }

  // The writer's side. False when the ring is full; nothing is stored then.
  bool put(const T& item) {
    if (full()) return false;
    items_[written_ % kSize] = item;
    // The processor writes in order; the compiler must too: the item is stored before the count.
    asm volatile("" ::: "memory");
    written_ = written_ + 1;
    return true;
  }
  // The reader's side. False when the ring is empty.
  bool take(T& item) {
    if (empty()) return false;
    item = items_[read_ % kSize];
    asm volatile("" ::: "memory");
    read_ = read_ + 1;
    return true;
  }

 private:
  std::array<T, kSize> items_{};
  volatile std::uint32_t written_ = 0, read_ = 0;
};

}  // namespace hoist::firmware::cortex_m0
