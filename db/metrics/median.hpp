// The median of many numbers that come one by one, several times in the same order: exact, and in memory of fixed size.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace hoist::db {

/// Element number n / 2 of n in rising order. do { add() of each; } while (again()); then value(). Finds sixteen of the number's 64 bits in
/// each of four passes, from the counts of all numbers that agree in the bits found before.
class MedianSearch {
 public:
  /// Finite.
  void add(double value);
  bool again();
  [[nodiscard]] std::uint64_t count() const { return count_; }
  /// 0 without numbers.
  [[nodiscard]] double value() const;

 private:
  static constexpr unsigned kBits = 16, kPasses = 4;
  unsigned pass_ = 0;
  std::uint64_t found_ = 0, count_ = 0, rank_ = 0;
  std::vector<std::uint64_t> counts_ = std::vector<std::uint64_t>(std::size_t{1} << kBits);
};

}  // namespace hoist::db
