// Counts heap requests per thread in the shipped program: after the start, steps must make none.
#pragma once
#include <cstdint>

namespace hoist::run {
/// Requests of the calling thread so far. Needs heap_watch.cpp in the program.
[[nodiscard]] std::uint64_t heap_requests() noexcept;
}  // namespace hoist::run
