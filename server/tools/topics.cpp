#include "server/tools/topics.hpp"

#include <algorithm>
#include <cmath>

#include "control/contract/faults.hpp"
#include "db/export/ros/encode.hpp"

namespace hoist::server {

namespace {
constexpr std::size_t kPath = db::ros::kTopicCount, kScene = kPath + 1, kIntent = kPath + 2, kTiming = kPath + 3;
constexpr std::uint32_t kOften_ticks = 2, kPath_ticks = 50, kScene_ticks = 10, kSeldom_ticks = 10;
// Points of a path message at most: every n-th of the walk's, and the newest.
constexpr std::size_t kPathPoints = 256;

constexpr std::string_view kPathDefinition =
    "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n"
    "================================================================================\nMSG: geometry_msgs/PoseStamped\n"
    "std_msgs/Header header\nPose pose\n"
    "================================================================================\nMSG: geometry_msgs/Pose\n"
    "Point position\nQuaternion orientation\n"
    "================================================================================\nMSG: geometry_msgs/Point\n"
    "float64 x\nfloat64 y\nfloat64 z\n"
    "================================================================================\nMSG: geometry_msgs/Quaternion\n"
    "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"
    "================================================================================\nMSG: std_msgs/Header\n"
    "builtin_interfaces/Time stamp\nstring frame_id\n"
    "================================================================================\nMSG: builtin_interfaces/Time\n"
    "int32 sec\nuint32 nanosec\n";

#define HOIST_TIME R"({"type":"object","title":"time","properties":{"sec":{"type":"integer"},"nsec":{"type":"integer"}}})"
#define HOIST_DURATION R"({"type":"object","title":"duration","properties":{"sec":{"type":"integer"},"nsec":{"type":"integer"}}})"
#define HOIST_VECTOR R"({"type":"object","properties":{"x":{"type":"number"},"y":{"type":"number"},"z":{"type":"number"}}})"
#define HOIST_TURN \
  R"({"type":"object","properties":{"x":{"type":"number"},"y":{"type":"number"},"z":{"type":"number"},"w":{"type":"number"}}})"
#define HOIST_POSE R"({"type":"object","properties":{"position":)" HOIST_VECTOR R"(,"orientation":)" HOIST_TURN "}}"
#define HOIST_COLOUR \
  R"({"type":"object","properties":{"r":{"type":"number"},"g":{"type":"number"},"b":{"type":"number"},"a":{"type":"number"}}})"
// The part of foxglove.SceneUpdate that we send.
constexpr std::string_view kSceneSchema =
    R"({"type":"object","title":"foxglove.SceneUpdate","properties":{"deletions":{"type":"array","items":{"type":"object","properties":{)"
    R"("timestamp":)" HOIST_TIME R"(,"type":{"type":"integer"},"id":{"type":"string"}}}},)"
    R"("entities":{"type":"array","items":{"type":"object","title":"foxglove.SceneEntity","properties":{"timestamp":)" HOIST_TIME
    R"(,"frame_id":{"type":"string"},"id":{"type":"string"},"lifetime":)" HOIST_DURATION R"(,"frame_locked":{"type":"boolean"},)"
    R"("cubes":{"type":"array","items":{"type":"object","properties":{"pose":)" HOIST_POSE R"(,"size":)" HOIST_VECTOR
    R"(,"color":)" HOIST_COLOUR R"(}}},"cylinders":{"type":"array","items":{"type":"object","properties":{"pose":)" HOIST_POSE
    R"(,"size":)" HOIST_VECTOR R"(,"bottom_scale":{"type":"number"},"top_scale":{"type":"number"},"color":)" HOIST_COLOUR
    R"(}}},"texts":{"type":"array","items":{"type":"object","properties":{"pose":)" HOIST_POSE
    R"(,"billboard":{"type":"boolean"},"font_size":{"type":"number"},"scale_invariant":{"type":"boolean"},"color":)" HOIST_COLOUR
    R"(,"text":{"type":"string"}}}}}}}}})";
#define HOIST_NUMBER(name) "\"" name "\":{\"type\":\"number\"}"
constexpr std::string_view kIntentSchema =
    R"({"type":"object","title":"hoist.Intent","properties":{"timestamp":)" HOIST_TIME "," HOIST_NUMBER("lean_norm") "," HOIST_NUMBER(
        "turn_norm") "," HOIST_NUMBER("dx_m") "," HOIST_NUMBER("dy_m") ","
        HOIST_NUMBER("dpsi_rad") "," HOIST_NUMBER("speed_wish_m_s") "," HOIST_NUMBER("yaw_rate_wish_rad_s") ","
        HOIST_NUMBER("speed_command_m_s") "," HOIST_NUMBER("yaw_rate_command_rad_s") "}}";
constexpr std::string_view kTimingSchema =
    R"({"type":"object","title":"hoist.Timing","properties":{"timestamp":)" HOIST_TIME "," HOIST_NUMBER("tick") "," HOIST_NUMBER(
        "wake_lateness_s") "," HOIST_NUMBER("tick_duration_s") "," HOIST_NUMBER("missed_ticks") "," HOIST_NUMBER("remote_age_s") "}}";

struct Stamp {
  std::int32_t s;
  std::uint32_t ns;
};
Stamp stamp_of(std::int64_t utc_ns) {
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  return {static_cast<std::int32_t>(utc_ns / kSecond_ns), static_cast<std::uint32_t>(utc_ns % kSecond_ns)};
}

template <typename Writer>
void header(Writer& out, const Stamp& stamp) {
  out.begin("header");
  out.begin("stamp");
  out.integer("sec", stamp.s);
  out.natural("nanosec", stamp.ns);
  out.end();
  out.text("frame_id", "odom");
  out.end();
}

template <typename Writer>
void write_path(Writer& out, const PathTrace& path, const Stamp& stamp) {
  const std::size_t points = path.x_m().size();
  const std::size_t every = points / kPathPoints + 1;
  header(out, stamp);
  out.begin_list("poses", (points + every - 1) / every);
  // Counted back from the newest, which is always among them.
  for (std::size_t i = points == 0 ? 0 : (points - 1) % every; i < points; i += every) {
    out.begin_item();
    header(out, stamp);
    out.begin("pose");
    out.begin("position");
    out.number("x", path.x_m()[i]);
    out.number("y", path.y_m()[i]);
    out.number("z", 0);
    out.end();
    out.begin("orientation");
    for (const char* part : {"x", "y", "z"}) out.number(part, 0);
    out.number("w", 1);
    out.end();
    out.end();
    out.end();
  }
  out.end_list();
}

using db::ros::JsonMessage;

void timestamp(JsonMessage& out, const Stamp& stamp) {
  out.begin("timestamp");
  out.integer("sec", stamp.s);
  out.natural("nsec", stamp.ns);
  out.end();
}
void vector(JsonMessage& out, std::string_view name, std::array<double, 3> v) {
  out.begin(name);
  out.number("x", v[0]);
  out.number("y", v[1]);
  out.number("z", v[2]);
  out.end();
}
void upright_pose(JsonMessage& out, double z_m) {
  out.begin("pose");
  vector(out, "position", {0, 0, z_m});
  out.begin("orientation");
  for (const char* part : {"x", "y", "z"}) out.number(part, 0);
  out.number("w", 1);
  out.end();
  out.end();
}
void colour(JsonMessage& out, std::array<double, 3> rgb) {
  out.begin("color");
  out.number("r", rgb[0]);
  out.number("g", rgb[1]);
  out.number("b", rgb[2]);
  out.number("a", 1);
  out.end();
}
void begin_entity(JsonMessage& out, std::string_view id, std::string_view frame, const Stamp& stamp) {
  out.begin_item();
  timestamp(out, stamp);
  out.text("frame_id", frame);
  out.text("id", id);
  out.begin("lifetime");
  out.natural("sec", 0);
  out.natural("nsec", 0);
  out.end();
  out.truth("frame_locked", true);  // moves with its frame
  for (const char* unused : {"metadata", "arrows", "spheres", "lines", "triangles", "models"}) {
    out.begin_list(unused, 0);
    out.end_list();
  }
}
void no_shapes(JsonMessage& out, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    out.begin_list(name, 0);
    out.end_list();
  }
}

// Sizes for the eye only.
constexpr double kStrut_m = 1.0, kStrutWidth_m = 0.05, kChassis_m = 0.2, kText_m = 1.3;
void write_scene(JsonMessage& out, const contract::TickRecord& record, const db::ros::Geometry& geometry, const Stamp& stamp) {
  no_shapes(out, {"deletions"});
  out.begin_list("entities", 0);
  begin_entity(out, "chassis", "chassis", stamp);
  out.begin_list("cubes", 0);
  out.begin_item();
  upright_pose(out, kChassis_m / 2);
  vector(out, "size", {0.8, geometry.strut_spacing_m, kChassis_m});
  colour(out, {0.6, 0.65, 0.7});
  out.end();
  out.end_list();
  no_shapes(out, {"cylinders", "texts"});
  out.end();
  for (const char* strut : {"strut_left", "strut_right"}) {
    begin_entity(out, strut, strut, stamp);
    no_shapes(out, {"cubes", "texts"});
    out.begin_list("cylinders", 0);
    out.begin_item();
    upright_pose(out, kStrut_m / 2);
    vector(out, "size", {kStrutWidth_m, kStrutWidth_m, kStrut_m});
    out.number("bottom_scale", 1);
    out.number("top_scale", 1);
    colour(out, {0.1, 0.45, 0.8});
    out.end();
    out.end_list();
    out.end();
  }
  begin_entity(out, "mode", "base_link", stamp);
  no_shapes(out, {"cubes", "cylinders"});
  out.begin_list("texts", 0);
  out.begin_item();
  upright_pose(out, kText_m);
  out.truth("billboard", true);
  out.number("font_size", 0.15);
  out.truth("scale_invariant", false);
  colour(out, {0.1, 0.1, 0.1});
  const std::string mode = record.mode < contract::kModes.size() ? std::string{contract::kModes[record.mode].title_en} : "unknown mode";
  out.text("text", record.simulated != 0 ? mode + " (simulated)" : mode);
  out.end();
  out.end_list();
  out.end();
  out.end_list();
}

void write_intent(JsonMessage& out, const contract::TickRecord& r) {
#define HOIST_VALUE(name) out.number(#name, static_cast<double>(r.name));
  HOIST_VALUE(lean_norm)
  HOIST_VALUE(turn_norm)
  HOIST_VALUE(dx_m)
  HOIST_VALUE(dy_m)
  HOIST_VALUE(dpsi_rad)
  HOIST_VALUE(speed_wish_m_s)
  HOIST_VALUE(yaw_rate_wish_rad_s)
  HOIST_VALUE(speed_command_m_s)
  HOIST_VALUE(yaw_rate_command_rad_s)
}
void write_timing(JsonMessage& out, const contract::TickRecord& r){
    HOIST_VALUE(tick) HOIST_VALUE(wake_lateness_s) HOIST_VALUE(tick_duration_s) HOIST_VALUE(missed_ticks) HOIST_VALUE(remote_age_s)
#undef HOIST_VALUE
}

std::uint32_t every_ticks(db::ros::Topic topic) {
  return topic == db::ros::Topic::battery_state || topic == db::ros::Topic::diagnostics ? kSeldom_ticks : kOften_ticks;
}
}  // namespace

const std::array<ToolTopic, kToolTopics>& tool_topics() {
  static const auto kAll = [] {
    std::array<ToolTopic, kToolTopics> all{};
    for (std::size_t i = 0; i < db::ros::kTopicCount; ++i) {
      const db::ros::TopicInfo& info = db::ros::topics()[i];
      all[i] = {info.name, info.type, info.definition, true, every_ticks(info.topic)};
    }
    all[kPath] = {"/path", "nav_msgs/msg/Path", kPathDefinition, true, kPath_ticks};
    all[kScene] = {"/scene", "foxglove.SceneUpdate", kSceneSchema, false, kScene_ticks};
    all[kIntent] = {"/hoist/intent", "hoist.Intent", kIntentSchema, false, kOften_ticks};
    all[kTiming] = {"/hoist/timing", "hoist.Timing", kTimingSchema, false, kSeldom_ticks};
    return all;
  }();
  return kAll;
}

std::optional<std::size_t> find_tool_topic(std::string_view name) {
  const auto& all = tool_topics();
  const auto at = std::find_if(all.begin(), all.end(), [name](const ToolTopic& topic) { return topic.name == name; });
  return at == all.end() ? std::nullopt : std::optional(static_cast<std::size_t>(at - all.begin()));
}

void Moment::begin(const contract::TickRecord& record, std::int64_t utc_ns, const db::ros::Geometry& geometry) {
  record_ = record;
  sample_ = db::ros::sample_of(record, utc_ns);
  geometry_ = geometry;
  due_ = 0;
  for (std::size_t i = 0; i < kToolTopics; ++i) {
    if (record.tick % tool_topics()[i].every_ticks == 0) due_ |= TopicMask{1} << i;
    cdr_[i].clear();
    json_[i].clear();
  }
}

const std::string& Moment::cdr(std::size_t topic) {
  if (!tool_topics()[topic].cdr) return json(topic);
  std::string& out = cdr_[topic];
  if (!out.empty()) return out;
  if (topic < db::ros::kTopicCount) {
    db::ros::append_cdr(out, static_cast<db::ros::Topic>(topic), sample_, geometry_);
  } else {
    db::ros::CdrWriter writer(out);
    write_path(writer, path_, stamp_of(sample_.utc_ns));
  }
  return out;
}

const std::string& Moment::json(std::size_t topic) {
  if (json_[topic].empty()) write_json(json_[topic], topic);
  return json_[topic];
}

void Moment::write_json(std::string& out, std::size_t topic) const {
  if (topic < db::ros::kTopicCount) return db::ros::append_json(out, static_cast<db::ros::Topic>(topic), sample_, geometry_);
  const Stamp stamp = stamp_of(sample_.utc_ns);
  JsonMessage writer(out);
  if (topic == kPath) return write_path(writer, path_, stamp);
  if (topic == kScene) return write_scene(writer, record_, geometry_, stamp);
  timestamp(writer, stamp);
  if (topic == kIntent)
    write_intent(writer, record_);
  else
    write_timing(writer, record_);
}

}  // namespace hoist::server
