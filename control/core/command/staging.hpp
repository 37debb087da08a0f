// A set of parameter values on its way in: gathered row by row, taken over by one commit or not at all (hazard H27).
#pragma once
#include <cstddef>
#include <cstdint>

#include "control/contract/params.hpp"
#include "control/core/types.hpp"

namespace hoist::core {

struct Staging {
  struct Row {
    std::size_t index = 0;  // in contract::kParams
    double value = 0;
  };
  std::uint32_t client = 0;
  FixedVector<Row, contract::kParamCount> rows;
};

}  // namespace hoist::core
