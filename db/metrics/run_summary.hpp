// The deviation beside J_N, which alone punishes slow walking (D29).
#pragma once

#include <optional>

#include "db/metrics/evaluate.hpp"

namespace hoist::db {

/// How far the track was from the reference, root mean square.
struct RunDeviation {
  double position_rms_m{};
  double heading_rms_rad{};
};

/// No value for an empty run, columns of different length, a dt that is not positive or a sample that is not finite.
[[nodiscard]] std::optional<RunDeviation> run_deviation(const contract::ReferencePath& path, const RunColumns& run,
                                                        double window_m = contract::kProjectionWindow_m);

}  // namespace hoist::db
