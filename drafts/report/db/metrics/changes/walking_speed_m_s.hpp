// Gait speed over 10 m, people after a stroke. They walked without a hoist: on it, the least change may be another.
#pragma once
#include <limits>

#include "db/metrics/change.hpp"

namespace hoist::db::changes {

inline constexpr std::array kWalkingSpeed{
    PublishedChange{"walking_speed_m_s", 0.0, 0.4, 0.05, "people after a stroke, 10 m", "Menschen nach Schlaganfall, 10 m", "Hosoi 2023"},
    PublishedChange{"walking_speed_m_s", 0.4, 0.8, 0.11, "people after a stroke, 10 m", "Menschen nach Schlaganfall, 10 m", "Hosoi 2023"},
    PublishedChange{"walking_speed_m_s", 0.8, std::numeric_limits<double>::infinity(), 0.21, "people after a stroke, 10 m",
                    "Menschen nach Schlaganfall, 10 m", "Hosoi 2023"}};

}  // namespace hoist::db::changes
