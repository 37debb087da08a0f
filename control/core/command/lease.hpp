// The lease: one holder at a time. Each change of holder increments the epoch, which voids commands of the former
// holder that are still under way.
#pragma once
#include <cstdint>

namespace hoist::core {

struct Lease {
  std::uint32_t epoch = 0;
  std::uint32_t holder = 0;  // client number, 0 = nobody

  [[nodiscard]] bool held_by(std::uint32_t client, std::uint32_t client_epoch) const noexcept {
    return holder != 0 && holder == client && epoch == client_epoch;
  }
};

}  // namespace hoist::core
