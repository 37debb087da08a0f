#include "tests/fuzz/targets.hpp"

namespace hoist::fuzz {

const std::vector<Target>& targets() {
  static const std::vector<Target> list = {
#define HOIST_FUZZ_TARGET(name) Target{#name, fuzz_##name, seeds_##name},
#include "tests/fuzz/targets.def"
#undef HOIST_FUZZ_TARGET
  };
  return list;
}

}  // namespace hoist::fuzz
