// What the server counts, so that nothing is refused silently: shown under /api/v1/status.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

namespace hoist::server {

enum class Count : std::uint8_t {
#define HOIST_COUNTER(name) name,
#include "server/counters.def"
#undef HOIST_COUNTER
};

inline constexpr std::array kCounterNames{
#define HOIST_COUNTER(name) std::string_view{#name},
#include "server/counters.def"
#undef HOIST_COUNTER
};

// Only touched by the network thread.
class Counters {
 public:
  void add(Count count, std::uint64_t by = 1) { values_[static_cast<std::size_t>(count)] += by; }
  [[nodiscard]] std::uint64_t get(std::size_t index) const { return values_[index]; }
  [[nodiscard]] std::uint64_t get(Count count) const { return values_[static_cast<std::size_t>(count)]; }

 private:
  std::array<std::uint64_t, kCounterNames.size()> values_{};
};

}  // namespace hoist::server
