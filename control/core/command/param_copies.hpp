// The copies of the parameters beside those in force: the sealed one, by which damage is found, and the one before a trial.
#pragma once
#include <array>
#include <cstdint>
#include <cstring>

#include "control/contract/crc32.hpp"
#include "control/contract/params.hpp"
#include "control/core/base/derived.hpp"

namespace hoist::core {

// Nothing but doubles: no padding that a checksum would see.
static_assert(sizeof(contract::Params) == contract::kParamCount * sizeof(double));

/// A second copy, also of what follows from it, and the checksum that both copies of the parameters must have.
struct ParamSeal {
  contract::Params copy;
  Derived derived;
  std::uint32_t crc = 0;
};
[[nodiscard]] inline std::uint32_t params_crc(const contract::Params& params) noexcept {
  std::array<std::uint8_t, sizeof(contract::Params)> bytes{};
  std::memcpy(bytes.data(), &params, sizeof(contract::Params));
  contract::Crc32 crc;
  crc.add(bytes);
  return crc.value();
}

struct Trial {
  double left_s = 0;                                   // 0: nothing is on trial
  contract::Params before;                             // what comes back
  std::array<bool, contract::kParamCount> on_trial{};  // which rows
};

}  // namespace hoist::core
