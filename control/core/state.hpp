// Everything the core remembers from one step to the next. Plain bytes: copying it copies the whole controller.
#pragma once
#include <cstdint>

#include "control/contract/params.hpp"

namespace hoist::core {

struct CoreState {
  CoreState() = default;
  explicit CoreState(const contract::Params& initial) : params(initial) {}

  contract::Params params;
  std::uint64_t parameter_version = 1;
  bool started = false;
};

}  // namespace hoist::core
