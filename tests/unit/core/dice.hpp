// Seeded chance for tests that compare a rule with its second writing over random situations.
#pragma once
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <random>

namespace hoist::core::test {

class Dice {
 public:
  explicit Dice(std::uint32_t seed) : random_(seed) {}
  double any(double least, double most) { return std::uniform_real_distribution<double>(least, most)(random_); }
  bool chance(double norm) { return any(0, 1) < norm; }
  std::size_t below(std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_); }
  template <typename T>
  T of(std::initializer_list<T> all) {
    return std::data(all)[below(all.size())];
  }

 private:
  std::mt19937 random_;
};

}  // namespace hoist::core::test
