// Counts every allocation of the program that links allocation_counter.cpp.
#pragma once
#include <cstdint>

namespace hoist::test {
std::uint64_t allocations();
}
