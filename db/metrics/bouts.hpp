// Bouts of walking: more than 0.05 m/s for a second or longer.
#pragma once
#include <vector>

#include "db/metrics/walk.hpp"

namespace hoist::db {

inline constexpr double kBout_m_s = 0.05, kBout_s = 1.0;

[[nodiscard]] std::vector<Stretch> bouts_of(const Walk& walk);
/// How often walking was interrupted for kBout_s or longer. Steps that are not recorded count as interruption, too.
[[nodiscard]] int pauses_between(const Walk& walk, const std::vector<Stretch>& bouts);

}  // namespace hoist::db
