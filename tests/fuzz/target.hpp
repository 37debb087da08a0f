// One decoder under attack. A target takes arbitrary bytes; `must` states its properties, and sanitizers check the rest. The same targets
// run with stored and mutated inputs as a test (regress.cpp), and coverage-guided (`deploy/dev fuzz`).
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string_view>
#include <vector>

namespace hoist::fuzz {

using Bytes = std::span<const std::uint8_t>;
using Input = std::vector<std::uint8_t>;

struct Target {
  std::string_view name;
  void (*run)(Bytes input);
  std::vector<Input> (*seeds)();  // valid start inputs, from our own encoders where they exist
};

// A violated property aborts the process, like a sanitizer's finding: both ways of running then report the input.
inline void must(bool holds, const char* promise) {
  if (holds) return;
  std::fprintf(stderr, "fuzz: broken promise: %s\n", promise);
  std::abort();
}

// Takes numbers off the front of the input; zeros when it is used up.
class Pieces {
 public:
  explicit Pieces(Bytes bytes) : bytes_(bytes) {}
  [[nodiscard]] bool empty() const { return bytes_.empty(); }
  std::uint8_t u8() {
    if (bytes_.empty()) return 0;
    const std::uint8_t value = bytes_[0];
    bytes_ = bytes_.subspan(1);
    return value;
  }
  std::uint64_t number(std::size_t bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value |= std::uint64_t{u8()} << (8 * i);
    return value;
  }
  Bytes take(std::size_t count) {
    const Bytes front = bytes_.first(count < bytes_.size() ? count : bytes_.size());
    bytes_ = bytes_.subspan(front.size());
    return front;
  }

 private:
  Bytes bytes_;
};

inline Input input_of(std::string_view text) { return Input(text.begin(), text.end()); }

const std::vector<Target>& targets();

}  // namespace hoist::fuzz
