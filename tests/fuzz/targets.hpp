// The declarations of everything in targets.def.
#pragma once
#include "tests/fuzz/target.hpp"

namespace hoist::fuzz {

#define HOIST_FUZZ_TARGET(name)  \
  void fuzz_##name(Bytes input); \
  std::vector<Input> seeds_##name();
#include "tests/fuzz/targets.def"
#undef HOIST_FUZZ_TARGET

/// Bit 1 << Mode: the core targets saw a wheel commanded to turn in this mode.
extern std::uint32_t core_modes_driven;

}  // namespace hoist::fuzz
