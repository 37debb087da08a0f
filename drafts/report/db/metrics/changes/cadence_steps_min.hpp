// Cadence from one sensor at the trunk, retest.
#pragma once
#include <limits>

#include "db/metrics/change.hpp"

namespace hoist::db::changes {

inline constexpr std::array kCadence{PublishedChange{"cadence_steps_min", 0.0, std::numeric_limits<double>::infinity(), 12.0,
                                                     "one sensor at the trunk, retest", "ein Sensor am Rumpf, Wiederholung",
                                                     "Sensors 2020, 20:4866"}};

}  // namespace hoist::db::changes
