#include "db/export/ros/messages.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

#include "control/contract/faults.hpp"
#include "db/export/ros/encode.hpp"

namespace hoist::db::ros {
namespace {

// The definitions are those of ROS 2 (common_interfaces, geometry2): the names and their order are the wire format.
#define HOIST_ROS_PART(type, text) "================================================================================\nMSG: " type "\n" text
#define HOIST_ROS_TIME HOIST_ROS_PART("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n")
#define HOIST_ROS_HEADER HOIST_ROS_PART("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n") HOIST_ROS_TIME
#define HOIST_ROS_POINT HOIST_ROS_PART("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n")
#define HOIST_ROS_QUATERNION HOIST_ROS_PART("geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n")
#define HOIST_ROS_VECTOR HOIST_ROS_PART("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n")
#define HOIST_ROS_POSE HOIST_ROS_PART("geometry_msgs/Pose", "Point position\nQuaternion orientation\n") HOIST_ROS_POINT HOIST_ROS_QUATERNION

constexpr std::string_view kOdometry =
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance "
    "twist\n" HOIST_ROS_HEADER HOIST_ROS_PART("geometry_msgs/PoseWithCovariance", "Pose pose\nfloat64[36] covariance\n")
        HOIST_ROS_POSE HOIST_ROS_PART("geometry_msgs/TwistWithCovariance", "Twist twist\nfloat64[36] covariance\n")
            HOIST_ROS_PART("geometry_msgs/Twist", "Vector3 linear\nVector3 angular\n") HOIST_ROS_VECTOR;
constexpr std::string_view kImu =
    "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
    "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
    "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n" HOIST_ROS_HEADER HOIST_ROS_QUATERNION
        HOIST_ROS_VECTOR;
constexpr std::string_view kTf = "geometry_msgs/TransformStamped[] transforms\n" HOIST_ROS_PART(
    "geometry_msgs/TransformStamped", "std_msgs/Header header\nstring child_frame_id\nTransform transform\n")
    HOIST_ROS_HEADER HOIST_ROS_PART("geometry_msgs/Transform", "Vector3 translation\nQuaternion rotation\n")
        HOIST_ROS_VECTOR HOIST_ROS_QUATERNION;
constexpr std::string_view kPose = "std_msgs/Header header\ngeometry_msgs/Pose pose\n" HOIST_ROS_HEADER HOIST_ROS_POSE;
constexpr std::string_view kJointState =
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n" HOIST_ROS_HEADER;
constexpr std::string_view kBattery =
    "std_msgs/Header header\nfloat32 voltage\nfloat32 temperature\nfloat32 current\nfloat32 charge\nfloat32 capacity\n"
    "float32 design_capacity\nfloat32 percentage\nuint8 power_supply_status\nuint8 power_supply_health\nuint8 power_supply_technology\n"
    "bool present\nfloat32[] cell_voltage\nfloat32[] cell_temperature\nstring location\nstring serial_number\n" HOIST_ROS_HEADER;
constexpr std::string_view kDiagnostics = "std_msgs/Header header\nDiagnosticStatus[] status\n" HOIST_ROS_HEADER HOIST_ROS_PART(
    "diagnostic_msgs/DiagnosticStatus",
    "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\nstring hardware_id\n"
    "KeyValue[] values\n") HOIST_ROS_PART("diagnostic_msgs/KeyValue", "string key\nstring value\n");

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
constexpr std::string_view kHardware = "hoist";

struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;
};
Quaternion about_z(double angle_rad) { return {0, 0, std::sin(angle_rad / 2), std::cos(angle_rad / 2)}; }

// alpha and beta are angles of the vertical seen from the side and from behind: tan(alpha) = tan(pitch) / cos(roll), beta = roll.
Quaternion tilted(double alpha_rad, double beta_rad) {
  const double pitch_rad = std::atan(std::tan(alpha_rad) * std::cos(beta_rad));
  const double sp = std::sin(pitch_rad / 2), cp = std::cos(pitch_rad / 2), sr = std::sin(beta_rad / 2), cr = std::cos(beta_rad / 2);
  return {cp * sr, sp * cr, -sp * sr, cp * cr};
}

template <typename Writer>
void header(Writer& out, std::int64_t utc_ns, std::string_view frame) {
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  std::int64_t seconds = utc_ns / kSecond_ns, rest_ns = utc_ns % kSecond_ns;
  if (rest_ns < 0) {
    rest_ns += kSecond_ns;
    --seconds;
  }
  out.begin("header");
  out.begin("stamp");
  out.integer("sec", static_cast<std::int32_t>(seconds));
  out.natural("nanosec", static_cast<std::uint32_t>(rest_ns));
  out.end();
  out.text("frame_id", frame);
  out.end();
}
template <typename Writer>
void vector(Writer& out, std::string_view name, double x, double y, double z) {
  out.begin(name);
  out.number("x", x);
  out.number("y", y);
  out.number("z", z);
  out.end();
}
template <typename Writer>
void quaternion(Writer& out, std::string_view name, const Quaternion& q) {
  out.begin(name);
  out.number("x", q.x);
  out.number("y", q.y);
  out.number("z", q.z);
  out.number("w", q.w);
  out.end();
}
template <typename Writer>
void pose(Writer& out, const Sample& s) {
  out.begin("pose");
  vector(out, "position", s.x_m, s.y_m, 0);
  quaternion(out, "orientation", about_z(s.psi_rad));
  out.end();
}
// Zeros: the covariance is not known.
constexpr std::array<double, 36> kNoCovariance{};

template <typename Writer>
void odometry(Writer& out, const Sample& s) {
  header(out, s.utc_ns, "odom");
  out.text("child_frame_id", "base_link");
  out.begin("pose");
  pose(out, s);
  out.fixed("covariance", kNoCovariance);
  out.end();
  out.begin("twist");
  out.begin("twist");
  vector(out, "linear", s.speed_m_s, 0, 0);
  vector(out, "angular", 0, 0, s.yaw_rate_rad_s);
  out.end();
  out.fixed("covariance", kNoCovariance);
  out.end();
}

struct Rates {
  double x_rad_s, y_rad_s, z_rad_s;
};
// A covariance that begins with -1 says, in sensor_msgs/Imu, that the sensor does not give this vector.
template <typename Writer>
void imu(Writer& out, const Sample& s, std::string_view frame, const Quaternion& tilt, const std::optional<Rates>& rates) {
  constexpr std::array<double, 9> kUnknown{}, kNotMeasured{-1};
  header(out, s.utc_ns, frame);
  quaternion(out, "orientation", tilt);
  out.fixed("orientation_covariance", kUnknown);
  const Rates told = rates.value_or(Rates{});
  vector(out, "angular_velocity", told.x_rad_s, told.y_rad_s, told.z_rad_s);
  out.fixed("angular_velocity_covariance", rates ? kUnknown : kNotMeasured);
  vector(out, "linear_acceleration", 0, 0, 0);
  out.fixed("linear_acceleration_covariance", kNotMeasured);
}

template <typename Writer>
void transforms(Writer& out, const Sample& s, const Geometry& geometry) {
  struct Frame {
    std::string_view parent, name;
    double x_m, y_m;
    Quaternion turn;
  };
  const double side_m = geometry.strut_spacing_m / 2;
  const std::array frames{Frame{"odom", "base_link", s.x_m, s.y_m, about_z(s.psi_rad)},
                          Frame{"base_link", "strut_left", 0, side_m, tilted(s.left_alpha_rad, s.left_beta_rad)},
                          Frame{"base_link", "strut_right", 0, -side_m, tilted(s.right_alpha_rad, s.right_beta_rad)},
                          Frame{"base_link", "chassis", 0, 0, tilted(s.base_alpha_rad, s.base_beta_rad)}};
  out.begin_list("transforms", frames.size());
  for (const Frame& frame : frames) {
    out.begin_item();
    header(out, s.utc_ns, frame.parent);
    out.text("child_frame_id", frame.name);
    out.begin("transform");
    vector(out, "translation", frame.x_m, frame.y_m, 0);
    quaternion(out, "rotation", frame.turn);
    out.end();
    out.end();
  }
  out.end_list();
}

template <typename Writer>
void joints(Writer& out, const Sample& s, const Geometry& geometry) {
  constexpr std::array<std::string_view, 2> kNames{"wheel_left", "wheel_right"};
  const double per_count_rad = 2 * std::numbers::pi / geometry.encoder_counts_per_turn;
  header(out, s.utc_ns, "base_link");
  out.texts("name", kNames);
  out.numbers("position", std::array{s.left_counts * per_count_rad, s.right_counts * per_count_rad});
  out.numbers("velocity", std::array{s.wheel_left_m_s / geometry.wheel_radius_m, s.wheel_right_m_s / geometry.wheel_radius_m});
  out.numbers("effort", {});
}

// Two batteries in series. What is not measured is NaN, as sensor_msgs/BatteryState asks.
template <typename Writer>
void battery(Writer& out, const Sample& s) {
  constexpr std::uint8_t kUnknown = 0;
  header(out, s.utc_ns, "base_link");
  out.single("voltage", s.battery_a_v + s.battery_b_v);
  for (const char* name : {"temperature", "current", "charge", "capacity", "design_capacity", "percentage"}) out.single(name, kNotKnown);
  for (const char* name : {"power_supply_status", "power_supply_health", "power_supply_technology"}) out.byte(name, kUnknown);
  out.truth("present", true);
  out.singles("cell_voltage", std::array{s.battery_a_v, s.battery_b_v});
  out.singles("cell_temperature", {});
  out.text("location", "");
  out.text("serial_number", "");
}

// A live value that counts; 0 when it was not recorded.
std::uint64_t whole(double value) { return std::isfinite(value) && value > 0 ? static_cast<std::uint64_t>(value) : 0; }

struct Status {
  std::uint8_t level = 0;
  std::string_view name, message;
};
constexpr std::uint8_t kOk = 0, kWarn = 1, kError = 2;
std::uint8_t level_of(const contract::FaultInfo& fault) { return fault.reaction == contract::Reaction::warn ? kWarn : kError; }

// The hoist itself first, then one status per active fault.
template <typename Writer>
void diagnostics(Writer& out, const Sample& s) {
  const contract::FaultBits faults = whole(s.fault_bits);
  const std::uint64_t mode = whole(s.mode);
  Status hoist{kOk, kHardware, mode < contract::kModes.size() ? contract::kModes[mode].title_en : "unknown mode"};
  std::size_t count = 1;
  for (const contract::FaultInfo& fault : contract::kFaults)
    if ((faults & contract::fault_bit(fault)) != 0) {
      ++count;
      hoist.level = std::max(hoist.level, level_of(fault));
    }
  const auto value = [&out](std::string_view key, const std::string& text) {
    out.begin_item();
    out.text("key", key);
    out.text("value", text);
    out.end();
  };
  const auto begin = [&out](const Status& status, std::size_t values) {
    out.begin_item();
    out.byte("level", status.level);
    out.text("name", status.name);
    out.text("message", status.message);
    out.text("hardware_id", kHardware);
    out.begin_list("values", values);
  };
  header(out, s.utc_ns, "");
  out.begin_list("status", count);
  begin(hoist, 4);
  value("mode", mode < contract::kModes.size() ? std::string(contract::kModes[mode].name) : std::to_string(mode));
  value("simulated", s.simulated == 0 ? "false" : "true");
  value("bus_load_percent", std::to_string(whole(s.bus_load_norm * 100)));
  value("missed_ticks", std::to_string(whole(s.missed_ticks)));
  out.end_list();
  out.end();
  for (const contract::FaultInfo& fault : contract::kFaults) {
    if ((faults & contract::fault_bit(fault)) == 0) continue;
    begin({level_of(fault), fault.name, fault.text_en}, 1);
    value("action", std::string(fault.action_en));
    out.end_list();
    out.end();
  }
  out.end_list();
}

template <typename Writer>
void write(Writer& out, Topic topic, const Sample& s, const Geometry& geometry) {
  switch (topic) {
    case Topic::odom:
      return odometry(out, s);
    case Topic::imu_left:
      return imu(out, s, "strut_left", tilted(s.left_alpha_rad, s.left_beta_rad), std::nullopt);
    case Topic::imu_right:
      return imu(out, s, "strut_right", tilted(s.right_alpha_rad, s.right_beta_rad), std::nullopt);
    case Topic::imu_base:
      return imu(out, s, "chassis", tilted(s.base_alpha_rad, s.base_beta_rad),
                 Rates{s.base_roll_rate_rad_s, s.base_pitch_rate_rad_s, s.base_yaw_rate_rad_s});
    case Topic::tf:
      return transforms(out, s, geometry);
    case Topic::pose:
      header(out, s.utc_ns, "odom");
      return pose(out, s);
    case Topic::joint_states:
      return joints(out, s, geometry);
    case Topic::battery_state:
      return battery(out, s);
    case Topic::diagnostics:
      return diagnostics(out, s);
  }
}

}  // namespace

const std::array<TopicInfo, kTopicCount>& topics() {
  static constexpr std::array<TopicInfo, kTopicCount> kTopics{
      {{Topic::odom, "/odom", "nav_msgs/msg/Odometry", kOdometry},
       {Topic::imu_left, "/imu/left", "sensor_msgs/msg/Imu", kImu},
       {Topic::imu_right, "/imu/right", "sensor_msgs/msg/Imu", kImu},
       {Topic::imu_base, "/imu/base", "sensor_msgs/msg/Imu", kImu},
       {Topic::tf, "/tf", "tf2_msgs/msg/TFMessage", kTf},
       {Topic::pose, "/pose", "geometry_msgs/msg/PoseStamped", kPose},
       {Topic::joint_states, "/joint_states", "sensor_msgs/msg/JointState", kJointState},
       {Topic::battery_state, "/battery_state", "sensor_msgs/msg/BatteryState", kBattery},
       {Topic::diagnostics, "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", kDiagnostics}}};
  return kTopics;
}

std::string short_type(std::string_view type) {
  constexpr std::string_view kMiddle = "/msg/";
  const std::size_t at = type.find(kMiddle);
  if (at == std::string_view::npos) return std::string(type);
  return std::string(type.substr(0, at + 1)) + std::string(type.substr(at + kMiddle.size()));
}

void set_parameter(Geometry& geometry, std::string_view name, double value) {
  if (name == "strut_spacing_m") geometry.strut_spacing_m = value;
  if (name == "wheel_radius_m") geometry.wheel_radius_m = value;
  if (name == "encoder_counts_per_turn") geometry.encoder_counts_per_turn = value;
}

void append_cdr(std::string& out, Topic topic, const Sample& sample, const Geometry& geometry) {
  CdrWriter writer(out);
  write(writer, topic, sample, geometry);
}

void append_json(std::string& out, Topic topic, const Sample& sample, const Geometry& geometry) {
  JsonMessage writer(out);
  write(writer, topic, sample, geometry);
}

}  // namespace hoist::db::ros
