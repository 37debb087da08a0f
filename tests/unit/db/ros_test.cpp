#include "db/export/ros/messages.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>

#include "control/contract/faults.hpp"

namespace hoist::db::ros::test {
namespace {

using nlohmann::json;

json as_json(Topic topic, const Sample& sample, const Geometry& geometry = {}) {
  std::string text;
  append_json(text, topic, sample, geometry);
  return json::parse(text);
}

// Reads CDR by the definition's text alone, as a foreign reader does: what it finds must equal the JSON.
class CdrReader {
 public:
  CdrReader(std::string_view definition, std::string_view bytes) : bytes_(bytes) {
    EXPECT_EQ(bytes.substr(0, 4), std::string_view("\0\1\0\0", 4));
    std::string name;
    for (std::string_view rest = definition; !rest.empty();) {
      const std::size_t end = rest.find('\n');
      const std::string line(rest.substr(0, end));
      rest.remove_prefix(end + 1);
      if (line.starts_with('='))
        continue;
      else if (line.starts_with("MSG: "))
        name = line.substr(line.find('/') + 1);
      else if (line.find('=') == std::string::npos)
        types_[name].push_back(line);
    }
  }
  json message() { return read_struct(""); }
  [[nodiscard]] bool at_end() const { return at_ == bytes_.size(); }

 private:
  template <typename Value>
  Value take() {
    while ((at_ - 4) % sizeof(Value) != 0) ++at_;
    Value value{};
    if (at_ + sizeof value > bytes_.size()) throw std::runtime_error("too short");
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  static json finite(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }
  json read_struct(const std::string& name) {
    json told = json::object();
    for (const std::string& line : types_.at(name)) {
      const std::size_t space = line.find(' ');
      std::string type = line.substr(0, space);
      const std::string field = line.substr(space + 1, line.find(' ', space + 1) - space - 1);
      if (const std::size_t bracket = type.find('['); bracket != std::string::npos) {
        const std::string count = type.substr(bracket + 1, type.size() - bracket - 2);
        type.resize(bracket);
        const std::size_t items = count.empty() ? take<std::uint32_t>() : std::stoul(count);
        told[field] = json::array();
        for (std::size_t i = 0; i < items; ++i) told[field].push_back(read(type));
      } else {
        told[field] = read(type);
      }
    }
    return told;
  }
  json read(const std::string& type) {
    if (type == "float64") return finite(take<double>());
    if (type == "float32") return finite(static_cast<double>(take<float>()));
    if (type == "int32") return take<std::int32_t>();
    if (type == "uint32") return take<std::uint32_t>();
    if (type == "uint8" || type == "byte") return take<std::uint8_t>();
    if (type == "bool") return take<std::uint8_t>() != 0;
    if (type == "string") {
      const auto size = take<std::uint32_t>();
      std::string text(bytes_.substr(at_, size - 1));
      EXPECT_EQ(bytes_[at_ + size - 1], '\0');
      at_ += size;
      return text;
    }
    return read_struct(type.substr(type.find('/') + 1));
  }
  std::string_view bytes_;
  std::size_t at_ = 4;
  std::map<std::string, std::vector<std::string>> types_;
};

Sample random_sample(std::mt19937& random) {
  std::uniform_real_distribution<double> small(-0.7, 0.7), large(-1000, 1000);
  Sample sample;
  sample.utc_ns = static_cast<std::int64_t>(random()) * 1'000'000'007 % 4'000'000'000'000'000'000;
#define HOIST_ROS_VALUE(name) sample.name = small(random);
  HOIST_ROS_VALUES(HOIST_ROS_VALUE)
#undef HOIST_ROS_VALUE
  sample.x_m = large(random);
  // Exact as float32, so that both encodings say the same number.
  sample.battery_a_v = 12.5;
  sample.battery_b_v = 12.25;
  sample.mode = static_cast<double>(random() % (contract::kModes.size() + 1));
  sample.fault_bits = static_cast<double>(random() % 4 == 0 ? 0 : (std::uint64_t{random()} << 20 & ((std::uint64_t{1} << 53) - 1)));
  return sample;
}

TEST(RosMessages, CdrReadByItsDefinitionSaysWhatTheJsonSays) {
  std::mt19937 random(7);
  for (int round = 0; round < 200; ++round) {
    const Sample sample = random_sample(random);
    for (const TopicInfo& topic : topics()) {
      std::string bytes;
      append_cdr(bytes, topic.topic, sample, {});
      CdrReader reader(topic.definition, bytes);
      ASSERT_EQ(reader.message(), as_json(topic.topic, sample)) << topic.name;
      ASSERT_TRUE(reader.at_end()) << topic.name;
    }
  }
}

TEST(RosMessages, ValuesStandWhereRosToolsLookForThem) {
  Sample s;
  s.utc_ns = 1'790'000'000'123'456'789;
  s.x_m = 1.5;
  s.y_m = -2.25;
  s.psi_rad = 0.5;
  s.speed_m_s = 0.25;
  s.base_roll_rate_rad_s = 0.1;
  s.base_pitch_rate_rad_s = 0.2;
  s.base_yaw_rate_rad_s = 0.3;
  s.battery_a_v = std::numeric_limits<double>::quiet_NaN();
  s.left_counts = 500;
  s.mode = static_cast<double>(contract::Mode::user);
  const json odom = as_json(Topic::odom, s);
  EXPECT_EQ(odom["header"], (json{{"stamp", {{"sec", 1790000000}, {"nanosec", 123456789}}}, {"frame_id", "odom"}}));
  EXPECT_EQ(odom["child_frame_id"], "base_link");
  EXPECT_EQ(odom["pose"]["pose"]["position"], (json{{"x", 1.5}, {"y", -2.25}, {"z", 0.0}}));
  EXPECT_EQ(odom["pose"]["pose"]["orientation"], (json{{"x", 0.0}, {"y", 0.0}, {"z", std::sin(0.25)}, {"w", std::cos(0.25)}}));
  EXPECT_EQ(odom["twist"]["twist"]["linear"]["x"], 0.25);
  EXPECT_EQ(as_json(Topic::imu_base, s)["angular_velocity"], (json{{"x", 0.1}, {"y", 0.2}, {"z", 0.3}}));
  EXPECT_EQ(as_json(Topic::imu_left, s)["angular_velocity_covariance"][0], -1.0) << "the struts' rates are not measured";
  EXPECT_EQ(as_json(Topic::battery_state, s)["voltage"], nullptr);
  EXPECT_EQ(as_json(Topic::joint_states, s, {.strut_spacing_m = 1, .wheel_radius_m = 1, .encoder_counts_per_turn = 1000})["position"][0],
            M_PI);
  EXPECT_EQ(as_json(Topic::tf, s, {.strut_spacing_m = 0.7})["transforms"][1]["transform"]["translation"]["y"], 0.35);
  const json status = as_json(Topic::diagnostics, s)["status"];
  ASSERT_EQ(status.size(), 1U);
  EXPECT_EQ(status[0]["message"], "Patient leads");
  std::string bytes;
  append_cdr(bytes, Topic::odom, s, {});
  EXPECT_EQ(bytes.size(), 724U);
}

TEST(RosMessages, AFaultIsAnErrorUnlessItOnlyWarns) {
  for (const contract::FaultInfo& fault : contract::kFaults) {
    Sample s;
    s.fault_bits = static_cast<double>(contract::fault_bit(fault));
    const json status = as_json(Topic::diagnostics, s)["status"];
    ASSERT_EQ(status.size(), 2U);
    EXPECT_EQ(status[1]["name"], fault.name);
    EXPECT_EQ(status[0]["level"], fault.reaction == contract::Reaction::warn ? 1 : 2);
    EXPECT_EQ(status[1]["level"], status[0]["level"]);
  }
}

// The sensors' angles are atan2(-ax, az) and atan2(ay, az) of gravity's opposite as they feel it: turning "up" back by the message's
// orientation must give the same two angles.
TEST(RosMessages, OrientationGivesTheAnglesThatTheSensorsMeasured) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(-0.6, 0.6);
  for (int round = 0; round < 1000; ++round) {
    Sample s;
    s.left_alpha_rad = angle(random);
    s.left_beta_rad = angle(random);
    const json q = as_json(Topic::imu_left, s)["orientation"];
    const double x = q["x"], y = q["y"], z = q["z"], w = q["w"];
    ASSERT_NEAR(x * x + y * y + z * z + w * w, 1, 1e-12);
    const double ax = 2 * (x * z - w * y), ay = 2 * (y * z + w * x), az = 1 - 2 * (x * x + y * y);
    ASSERT_NEAR(std::atan2(-ax, az), s.left_alpha_rad, 1e-12);
    ASSERT_NEAR(std::atan2(ay, az), s.left_beta_rad, 1e-12);
  }
}

TEST(RosMessages, NamesForRosbridge) {
  EXPECT_EQ(short_type("nav_msgs/msg/Odometry"), "nav_msgs/Odometry");
  EXPECT_EQ(short_type("nav_msgs/Odometry"), "nav_msgs/Odometry");
}

}  // namespace
}  // namespace hoist::db::ros::test
