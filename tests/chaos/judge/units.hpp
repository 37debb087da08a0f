// What the whole judge measures with.
#pragma once

namespace hoist::chaos {

inline constexpr double kStep_s = 0.01;  // of the core
inline constexpr double kDegree_rad = 3.14159265358979323846 / 180.0;

}  // namespace hoist::chaos
