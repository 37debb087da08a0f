// A session as MCAP, profile ros2: what Foxglove, Lichtblick, PlotJuggler and `ros2 bag` open.
//
//   /hoist/record    all chosen live values of each sample, numbers as in the CSV (JSON)
//   /hoist/events    events and markers (JSON)
//   /odom, /imu/*    each sample; /tf, /pose, /joint_states each second one; /battery_state, /diagnostics once a second and when one of their
//                    values changes (CDR, db/export/ros)
// Times are the session's start by the wall clock plus steady time: they never run backwards. The attachment manifest.json holds the manifest,
// parameters.json the parameters at the start; the Metadata record "hoist" names session, programs and patient code.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "control/contract/program_version.hpp"
#include "db/export/fixed_point.hpp"
#include "db/export/manifest.hpp"
#include "db/export/mcap_file.hpp"
#include "db/export/ros/messages.hpp"
#include "db/summary/provenance.hpp"

namespace hoist::db {
namespace {

using nlohmann::json;

constexpr std::size_t kSamplesPerPiece = 512;
// Of the topics that change slowly.
constexpr std::int64_t kSlow_ns = 1'000'000'000;
constexpr std::uint64_t kHalfRate = 2;

// A live value of ros::Sample and the column that holds it.
struct RosColumn {
  double ros::Sample::*member;
  std::size_t column;
  double scale;
};

class McapExport : public FormatWriter {
 public:
  explicit McapExport(ExportSource& source) : source_(source), file_(source.database.file().parent_path()) {
    for (const std::size_t c : source.chosen) needed(c);
#define HOIST_ROS_VALUE(name) ros_value(#name, &ros::Sample::name);
    HOIST_ROS_VALUES(HOIST_ROS_VALUE)
#undef HOIST_ROS_VALUE
    tick_ = needed(source.tick_column);
    time_ = needed(source.time_column);
    for (const std::size_t c : source.chosen) keys_.push_back("," + dumped(source.layout[c].name) + ":");
  }

  bool next(std::string& out) override {
    switch (step_) {
      case Step::head:
        step_ = Step::body;
        head(out);
        return true;
      case Step::body:
        if (samples(out)) return true;
        step_ = Step::summary;
        events_until(out, ~std::uint64_t{0}, std::numeric_limits<std::int64_t>::max());
        return true;
      case Step::summary:
        if (!file_.end(out)) step_ = Step::over;
        return true;
      case Step::over:
        break;
    }
    return false;
  }

 private:
  enum class Step : std::uint8_t { head, body, summary, over };

  // The place of a column in `values`.
  std::size_t needed(std::size_t column) {
    const auto at = std::ranges::find(which_, column);
    if (at != which_.end()) return static_cast<std::size_t>(at - which_.begin());
    which_.push_back(column);
    return which_.size() - 1;
  }
  void ros_value(std::string_view name, double ros::Sample::*member) {
    const auto column = find_column(source_.layout, name);
    if (column)
      ros_columns_.push_back({member, needed(*column), decimal_scale(source_.layout[*column].decimals)});
    else
      sample_.*member = std::nan("");
  }

  void head(std::string& out) {
    const SessionInfo& info = source_.info;
    file_.begin(out, "ros2", "hoist " + std::string(contract::program_version()));
    const json manifest = manifest_json(source_);
    const auto program = [&manifest](const char* name) {
      const json& told = manifest["programs"][name];
      return told.is_null() ? std::string() : told.get<std::string>();
    };
    for (const auto& [name, value] : source_.parameters()) ros::set_parameter(geometry_, name, value);
    const auto start = static_cast<std::uint64_t>(info.started_utc_ns);
    file_.attachment(out, start, "parameters.json", "application/json", dumped(manifest["parameters"]));
    file_.attachment(out, start, "manifest.json", "application/json", dumped(manifest));
    file_.metadata(out, "hoist",
                   {{"session", std::to_string(info.id)},
                    {"subject", info.subject.value_or("")},
                    {"simulated", info.simulated ? "true" : "false"},
                    {"recorded_by", program("recorded_by")},
                    {"controlled_by", program("controlled_by")},
                    {"layout_hash", manifest["layout_hash"].get<std::string>()}});
    channels(manifest);
    moments_.emplace(source_);
  }

  void channels(const json& manifest) {
    json properties{{"timestamp", {{"type", "object"}, {"properties", {{"sec", {{"type", "integer"}}}, {"nsec", {{"type", "integer"}}}}}}},
                    {"time_s", {{"type", "number"}}},
                    {"gap_before", {{"type", "integer"}}}};
    for (const json& column : manifest["columns"])
      properties[column["name"]] = {{"type", "number"}, {"description", column["doc"]}, {"x-unit", column["unit"]}};
    record_ = file_.add_channel(
        file_.add_schema("hoist.Record", "jsonschema", dumped({{"title", "hoist.Record"}, {"type", "object"}, {"properties", properties}})),
        "/hoist/record", "json");
    json event_properties;
    for (const char* name : {"kind", "name", "text"}) event_properties[name] = {{"type", "string"}};
    for (const char* name : {"tick", "code", "item", "value", "before"}) event_properties[name] = {{"type", "number"}};
    events_ = file_.add_channel(file_.add_schema("hoist.Event", "jsonschema",
                                                 dumped({{"title", "hoist.Event"}, {"type", "object"}, {"properties", event_properties}})),
                                "/hoist/events", "json");
    std::map<std::string_view, std::uint16_t> schemas;
    for (const ros::TopicInfo& topic : ros::topics()) {
      auto [at, fresh] = schemas.try_emplace(topic.type, 0);
      if (fresh) at->second = file_.add_schema(topic.type, "ros2msg", topic.definition);
      ros_channels_[static_cast<std::size_t>(topic.topic)] = file_.add_channel(at->second, topic.name, "cdr");
    }
  }

  // Time of a marker's step, also in a gap. Recorded times carry the loop's jitter, which a step's own time lacks: it stays between the samples
  // beside it, so that log times never run backwards.
  [[nodiscard]] std::int64_t utc_of_marker(std::uint64_t tick, std::int64_t next_sample_utc_ns) const {
    const std::int64_t own_ns = source_.even_utc_of(source_.time_of_tick(tick));
    return std::max(last_utc_ns_.value_or(own_ns), std::min(own_ns, next_sample_utc_ns));
  }

  void events_until(std::string& out, std::uint64_t tick, std::int64_t utc_ns) {
    while (const auto moment = moments_->next(tick)) {
      json told = moment_json(*moment);
      told.erase("time_ns");
      const std::int64_t at_ns = moment->event != nullptr ? source_.even_utc_of(static_cast<std::int64_t>(moment->event->time_ns))
                                                          : utc_of_marker(moment->tick, utc_ns);
      file_.message(out, events_, static_cast<std::uint64_t>(at_ns), dumped(told));
    }
  }

  bool samples(std::string& out) {
    if (!source_.chunk && !source_.next_samples(which_)) return false;
    const std::size_t rows = source_.values[tick_].size(), end = std::min(source_.row + kSamplesPerPiece, rows);
    for (; source_.row < end; ++source_.row) {
      const auto tick = static_cast<std::uint64_t>(source_.values[tick_][source_.row]);
      if (!source_.wanted(tick)) continue;
      const std::int64_t time_ns = source_.values[time_][source_.row], utc_ns = source_.even_utc_of(time_ns);
      events_until(out, tick, utc_ns);
      last_utc_ns_ = utc_ns;
      record(out, tick, time_ns, utc_ns);
      ros_messages(out, tick, utc_ns);
      source_.written_tick = tick;
    }
    if (source_.row >= rows) source_.chunk.reset();
    return true;
  }

  void record(std::string& out, std::uint64_t tick, std::int64_t time_ns, std::int64_t utc_ns) {
    std::array<char, kMaxNumber_chars> digits;
    const auto fixed = [&](std::int64_t value, int decimals) { text_.append(digits.data(), print_fixed(digits.data(), value, decimals)); };
    text_ = "{\"timestamp\":{\"sec\":" + std::to_string(utc_ns / 1'000'000'000) + ",\"nsec\":" + std::to_string(utc_ns % 1'000'000'000) +
            "},\"time_s\":";
    fixed(microseconds_since(source_.start_ns(), time_ns), kSeconds_decimals);
    text_ += source_.gap_before(tick) ? ",\"gap_before\":1" : ",\"gap_before\":0";
    for (std::size_t c = 0; c < source_.chosen.size(); ++c) {
      text_ += keys_[c];
      fixed(source_.values[c][source_.row], source_.layout[source_.chosen[c]].decimals);
    }
    text_ += '}';
    file_.message(out, record_, static_cast<std::uint64_t>(utc_ns), text_);
  }

  void ros_messages(std::string& out, std::uint64_t tick, std::int64_t utc_ns) {
    using ros::Topic;
    sample_.utc_ns = utc_ns;
    for (const RosColumn& value : ros_columns_)
      sample_.*value.member = static_cast<double>(source_.values[value.column][source_.row]) / value.scale;
    for (const Topic topic : {Topic::odom, Topic::imu_left, Topic::imu_right, Topic::imu_base}) ros_message(out, topic, utc_ns);
    if (tick % kHalfRate == 0)
      for (const Topic topic : {Topic::tf, Topic::pose, Topic::joint_states}) ros_message(out, topic, utc_ns);
    const bool due = !slow_ns_ || utc_ns - *slow_ns_ >= kSlow_ns || sample_.fault_bits != slow_.fault_bits || sample_.mode != slow_.mode;
    if (!due) return;
    slow_ns_ = utc_ns;
    slow_ = sample_;
    for (const Topic topic : {Topic::battery_state, Topic::diagnostics}) ros_message(out, topic, utc_ns);
  }
  void ros_message(std::string& out, ros::Topic topic, std::int64_t utc_ns) {
    text_.clear();
    ros::append_cdr(text_, topic, sample_, geometry_);
    file_.message(out, ros_channels_[static_cast<std::size_t>(topic)], static_cast<std::uint64_t>(utc_ns), text_);
  }

  ExportSource& source_;
  McapFile file_;
  Step step_ = Step::head;
  std::vector<std::size_t> which_;  // columns in `values`: the chosen ones first
  std::vector<std::string> keys_;
  std::size_t tick_ = 0, time_ = 0;
  std::vector<RosColumn> ros_columns_;
  ros::Sample sample_, slow_;
  std::optional<std::int64_t> slow_ns_, last_utc_ns_;
  ros::Geometry geometry_;
  std::uint16_t record_ = 0, events_ = 0;
  std::array<std::uint16_t, ros::kTopicCount> ros_channels_{};
  std::optional<Moments> moments_;
  std::string text_;
};

}  // namespace

std::unique_ptr<FormatWriter> make_mcap(ExportSource& source) { return std::make_unique<McapExport>(source); }

}  // namespace hoist::db
