// What Foxglove and ROS tools can watch: the ROS messages of db/export/ros and, beside them, path, scene, intent and timing. One payload per step
// and encoding, made when the first client needs it.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "control/contract/signals.hpp"
#include "db/export/ros/messages.hpp"
#include "server/state/walk.hpp"

namespace hoist::server {

inline constexpr std::size_t kToolTopics = db::ros::kTopicCount + 4;
using TopicMask = std::uint32_t;
static_assert(kToolTopics <= 32);

struct ToolTopic {
  std::string_view name;
  std::string_view type;    // "nav_msgs/msg/Odometry"
  std::string_view schema;  // ros2msg where `cdr`, else a JSON schema
  bool cdr;
  std::uint32_t every_ticks;  // 2 = 50 Hz, the most that the tools take without complaint
};
[[nodiscard]] const std::array<ToolTopic, kToolTopics>& tool_topics();
[[nodiscard]] std::optional<std::size_t> find_tool_topic(std::string_view name);

// One step, as the tools see it.
class Moment {
 public:
  // `path` belongs to the hub and outlives this.
  explicit Moment(const PathTrace& path) : path_(path) {}
  void begin(const contract::TickRecord& record, std::int64_t utc_ns, const db::ros::Geometry& geometry);

  // Topics whose turn it is.
  [[nodiscard]] TopicMask due() const { return due_; }
  [[nodiscard]] std::int64_t utc_ns() const { return sample_.utc_ns; }
  [[nodiscard]] const std::string& cdr(std::size_t topic);  // JSON for topics that have no CDR
  [[nodiscard]] const std::string& json(std::size_t topic);

 private:
  void write_json(std::string& out, std::size_t topic) const;

  const PathTrace& path_;
  contract::TickRecord record_{};
  db::ros::Sample sample_;
  db::ros::Geometry geometry_;
  TopicMask due_ = 0;
  std::array<std::string, kToolTopics> cdr_, json_;
};

}  // namespace hoist::server
