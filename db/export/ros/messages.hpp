// What a control step says to ROS tools: the messages of ROS 2 made from recorded or live values, as CDR (MCAP, Foxglove) and as JSON (rosbridge).
// One description per message (messages.cpp) feeds both encodings, so that they cannot differ.
//
// Frames (REP 103, REP 105): odom -> base_link is the plane pose, level; base_link -> strut_left, strut_right and chassis carry the measured
// tilts against gravity. Turns about the vertical are unknown for struts and chassis and stay 0.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "control/contract/signals.hpp"

namespace hoist::db::ros {

enum class Topic : std::uint8_t { odom, imu_left, imu_right, imu_base, tf, pose, joint_states, battery_state, diagnostics };
struct TopicInfo {
  Topic topic;
  std::string_view name;        ///< "/odom"
  std::string_view type;        ///< "nav_msgs/msg/Odometry"
  std::string_view definition;  ///< ros2msg: the type's definition with those of its parts
};
inline constexpr std::size_t kTopicCount = 9;
/// In the order of Topic.
const std::array<TopicInfo, kTopicCount>& topics();
/// "nav_msgs/Odometry" of "nav_msgs/msg/Odometry", as rosbridge names it.
std::string short_type(std::string_view type);

/// The live values that the messages use, by their names in signals.def.
// clang-format off
#define HOIST_ROS_VALUES(V) \
  V(left_alpha_rad) V(left_beta_rad) V(right_alpha_rad) V(right_beta_rad) V(base_alpha_rad) V(base_beta_rad) \
  V(base_yaw_rate_rad_s) V(base_pitch_rate_rad_s) V(base_roll_rate_rad_s) V(speed_m_s) V(yaw_rate_rad_s) V(x_m) \
  V(y_m) V(psi_rad) V(wheel_left_m_s) V(wheel_right_m_s) V(left_counts) V(right_counts) \
  V(battery_a_v) V(battery_b_v) V(fault_bits) V(blocked_bits) V(mode) V(bus_load_norm) \
  V(missed_ticks) V(simulated)
// clang-format on
struct Sample {
  std::int64_t utc_ns = 0;  ///< header.stamp
  // NaN: not recorded. Fault bits fit a double (contract::kFaultPlaces).
#define HOIST_ROS_VALUE(name) double name = 0;
  HOIST_ROS_VALUES(HOIST_ROS_VALUE)
#undef HOIST_ROS_VALUE
};
inline Sample sample_of(const contract::TickRecord& record, std::int64_t utc_ns) {
  Sample sample;
  sample.utc_ns = utc_ns;
#define HOIST_ROS_VALUE(name) sample.name = static_cast<double>(record.name);
  HOIST_ROS_VALUES(HOIST_ROS_VALUE)
#undef HOIST_ROS_VALUE
  return sample;
}

/// Sizes of the machine, from its parameters.
struct Geometry {
  double strut_spacing_m = 0.6, wheel_radius_m = 0.1, encoder_counts_per_turn = 60000;
};
/// Takes the parameter if it is one of the above.
void set_parameter(Geometry& geometry, std::string_view name, double value);

/// Appends the message of this topic with its encapsulation header (little endian).
void append_cdr(std::string& out, Topic topic, const Sample& sample, const Geometry& geometry);
/// Appends one JSON object. What is not a number is null.
void append_json(std::string& out, Topic topic, const Sample& sample, const Geometry& geometry);

}  // namespace hoist::db::ros
