// Who drives. One holder at a time; every change of holder counts the epoch up, so that what the former one still has on its way is void.
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
