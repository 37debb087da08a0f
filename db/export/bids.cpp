#include "db/export/bids.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "control/contract/axes.hpp"
#include "control/contract/program_version.hpp"
#include "db/export/fixed_point.hpp"
#include "db/export/manifest.hpp"
#include "db/export/source.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/session_times.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/visits.hpp"

namespace hoist::db {
namespace {

using nlohmann::json;

constexpr std::size_t kBidsRowsPerPiece = 256;
constexpr double kNominal_hz = 100;
constexpr std::uint64_t kSample_bytes = 8192, kFourGigabytes = 0xFFFFFFFFU;

std::string pretty(const json& value) { return value.dump(2, ' ', false, json::error_handler_t::replace) + "\n"; }

// Labels are letters and digits only.
std::string label_of(std::string_view text) {
  std::string label;
  for (const char c : text)
    if ((c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z')) label += c;
  return label;
}
// One cell of a TSV file: no tab, no line end.
std::string cell(std::string_view text) {
  std::string out(text);
  std::ranges::replace_if(
      out, [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
  return out.empty() ? "n/a" : out;
}

// What a channel measures, by its unit, its direction and its name.
struct Channel {
  std::string_view component, type;
  std::string point;
};
Channel channel_of(const ColumnInfo& column) {
  namespace axis = contract::axis_meaning;
  Channel channel{"n/a", "MISC", "n/a"};
  const std::string_view meaning = contract::axis_of(column.name);
  if (meaning.empty()) return channel;
  channel.component = meaning == axis::x || meaning == axis::x_start || meaning == axis::beta    ? "x"
                      : meaning == axis::y || meaning == axis::y_start || meaning == axis::alpha ? "y"
                                                                                                 : "z";
  const std::string_view name = column.name;
  channel.point = name.starts_with("left_")    ? "strut_left"
                  : name.starts_with("right_") ? "strut_right"
                  : name.starts_with("base_")  ? "chassis"
                  : name.starts_with("wheel_") ? std::string(name.substr(0, name.find('_', 6)))
                                               : "hoist";
  if (column.unit == "m") channel.type = "POS";
  if (column.unit == "m/s") channel.type = "VEL";
  if (column.unit == "rad") channel.type = "ORNT";
  if (column.unit == "rad/s" && name.starts_with("base_")) channel.type = "GYRO";
  return channel;
}

// Where the files of one session stand.
struct Place {
  std::string folder, stem, task;
};

// The samples: one row each, columns as channels.tsv lists them, no head. What is missing is left out; the latency tells.
class MotionTsv {
 public:
  MotionTsv(Database& database, const SessionInfo& info) : source_(database, info, {}) {
    if (Status chosen = source_.choose(); !chosen) throw SqlFailure{chosen.error()};
    which_ = source_.chosen;
    which_.push_back(source_.tick_column);
    which_.push_back(source_.time_column);
  }
  bool next(std::string& out) {
    if (!source_.chunk && !source_.next_samples(which_)) return false;
    const std::vector<std::int64_t>& ticks = source_.values[which_.size() - 2];
    const std::vector<std::int64_t>& times = source_.values[which_.size() - 1];
    std::array<char, kMaxNumber_chars> digits;
    for (const std::size_t end = std::min(source_.row + kBidsRowsPerPiece, ticks.size()); source_.row < end; ++source_.row) {
      const auto tick = static_cast<std::uint64_t>(ticks[source_.row]);
      if (!source_.wanted(tick)) continue;
      if (!source_.written_tick) begin_ns_ = times[source_.row];
      out.append(digits.data(), print_fixed(digits.data(), microseconds_since(begin_ns_, times[source_.row]), kSeconds_decimals));
      for (std::size_t c = 0; c < source_.chosen.size(); ++c) {
        out += '\t';
        const int decimals = source_.layout[source_.chosen[c]].decimals;
        out.append(digits.data(), print_fixed(digits.data(), source_.values[c][source_.row], decimals));
      }
      out += '\n';
      source_.written_tick = tick;
    }
    if (source_.row >= ticks.size()) source_.chunk.reset();
    return true;
  }

 private:
  ExportSource source_;
  std::vector<std::size_t> which_;
  std::int64_t begin_ns_ = 0;
};

// The table of events, row by row. Times count from the first sample, which is time 0 of all channels.
class EventsTsv {
 public:
  EventsTsv(Database& database, const SessionInfo& info) : source_(database, info, {}), begin_ns_(source_.start_ns()), moments_(source_) {
    if (source_.next_samples(std::array{source_.time_column}) && !source_.values[0].empty()) begin_ns_ = source_.values[0].front();
  }
  bool next(std::string& out) {
    if (!std::exchange(head_written_, true)) out += "onset\tduration\ttrial_type\tname\tvalue\n";
    for (std::size_t i = 0; i < kBidsRowsPerPiece; ++i) {
      const auto moment = moments_.next();
      if (!moment) return false;
      row(out, *moment);
    }
    return true;
  }

 private:
  // A marker's text may name a person; a marker has the time of its step.
  void row(std::string& out, const Moments::Moment& moment) {
    const json event = moment_json(moment);
    const std::int64_t time_ns =
        moment.event != nullptr ? static_cast<std::int64_t>(moment.event->time_ns) : source_.time_of_tick(moment.tick);
    std::array<char, kMaxNumber_chars> digits;
    out.append(digits.data(), print_fixed(digits.data(), microseconds_since(begin_ns_, time_ns), kSeconds_decimals));
    out += "\t0\t" + cell(event["kind"].get<std::string>()) + "\t" + cell(event["name"].get<std::string>()) + "\t" +
           (event["value"].is_null() ? "n/a" : dumped(event["value"])) + "\n";
  }

  ExportSource source_;
  std::int64_t begin_ns_;
  Moments moments_;
  bool head_written_ = false;
};

// Some disks take two names for one that differ in capital letters only, and BIDS allows no such names.
std::string in_small_letters(std::string label) {
  for (char& c : label)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + ('a' - 'A'));
  return label;
}

class BidsPlan : public BundlePlan {
 public:
  BidsPlan(Database& database, const std::vector<SessionId>& sessions) : database_(database) {
    const auto visits = or_throw(VisitReader(database).of_sessions(sessions));
    std::map<std::string, int> runs;
    std::set<std::string> taken;
    for (const SessionId session : sessions) {
      const SessionInfo info = or_throw(SessionReader(database).get(session));
      if (first_utc_ns_ == 0) first_utc_ns_ = info.started_utc_ns;
      const std::string code = info.subject.value_or("");
      // Patients without a code are not one patient, and none of those who have one.
      auto [label, fresh] = info.subject ? labels_.try_emplace({0, code}, label_of(code))
                                         : labels_.try_emplace({session, ""}, "unknown" + std::to_string(session));
      if (fresh) {
        if (label->second.empty()) label->second = "x";
        while (!taken.insert(in_small_letters(label->second)).second) label->second += "x";
        participants_.emplace_back("sub-" + label->second, cell(code));
      }
      const auto visit = visits.find(session);
      const std::string day = visit != visits.end() ? visit->second.day : local_day(info.started_utc_ns);
      Place place;
      place.task = task_of(info);
      const std::string subject = "sub-" + label->second, visit_label = "ses-" + label_of(day);
      place.folder = subject + "/" + visit_label + "/";
      const std::string head = subject + "_" + visit_label + "_task-" + place.task + "_tracksys-hoist";
      place.stem = head + "_run-" + std::to_string(++runs[head]);
      scans_[place.folder + subject + "_" + visit_label + "_scans.tsv"] +=
          "motion/" + place.stem + "_motion.tsv\t" + utc_text(info.started_utc_ns) + "\n";
      places_[session] = std::move(place);
    }
  }

  std::vector<BundleFile> first() override {
    const json description{{"Name", "Walks with a Hoist"},
                           {"BIDSVersion", "1.10.0"},
                           {"DatasetType", "raw"},
                           {"GeneratedBy", json::array({{{"Name", "hoist"}, {"Version", contract::program_version()}}})}};
    std::string participants = "participant_id\tcode\n";
    for (const auto& [id, code] : participants_) participants += id + "\t" + code + "\n";
    const json words{{"code", {{"Description", "Pseudonymous code of the patient in the recordings; n/a when none was given"}}}};
    const std::string readme =
        "Recordings of a motorised walking aid that follows the patient's pelvis.\n\n"
        "Frames: x forward, y left, z up. Samples that are missing are left out of motion.tsv: its first channel is the time since the "
        "first\n"
        "sample. The manifest beside each recording tells programs, parameters, calibration, words for modes and faults, and gaps.\n";
    return {text("dataset_description.json", pretty(description)), text("participants.tsv", participants),
            text("participants.json", pretty(words)), text("README", readme), text(".bidsignore", "*_manifest.json\n")};
  }

  std::vector<BundleFile> of_session(SessionId session) override {
    const SessionInfo info = or_throw(SessionReader(database_).get(session));
    const Place& place = places_.at(session);
    const std::string stem = place.folder + "motion/" + place.stem;
    BundleFile samples;
    samples.name = stem + "_motion.tsv";
    samples.utc_ns = info.started_utc_ns;
    samples.large = info.sample_count * kSample_bytes >= kFourGigabytes;
    samples.open = [&database = database_, info] {
      auto rows = std::make_shared<MotionTsv>(database, info);
      return [rows](std::string& out) { return rows->next(out); };
    };
    std::vector<BundleFile> files{std::move(samples)};
    const auto with_source = [this, &info](std::string name, auto make) {
      return text_file(std::move(name), info.started_utc_ns, [&database = database_, info, make] {
        ExportSource source(database, info, {});
        if (Status chosen = source.choose(); !chosen) throw SqlFailure{chosen.error()};
        return make(source);
      });
    };
    files.push_back(with_source(stem + "_motion.json", [task = place.task](ExportSource& source) { return sidecar(source, task); }));
    files.push_back(with_source(stem + "_channels.tsv", channels));
    BundleFile events;
    events.name = stem + "_events.tsv";
    events.utc_ns = info.started_utc_ns;
    events.open = [&database = database_, info] {
      auto rows = std::make_shared<EventsTsv>(database, info);
      return [rows](std::string& out) { return rows->next(out); };
    };
    files.push_back(std::move(events));
    files.push_back(with_source(stem + "_manifest.json", [](ExportSource& source) {
      json manifest = manifest_json(source);
      json& told = manifest["session"];
      told.erase("note");
      if (told["task"].is_object()) told["task"].erase("line");  // a name that a person has typed
      return pretty(manifest);
    }));
    return files;
  }

  std::vector<BundleFile> last() override {
    std::vector<BundleFile> files;
    for (const auto& [name, rows] : scans_) files.push_back(text(name, "filename\tacq_time\n" + rows));
    return files;
  }

 private:
  [[nodiscard]] BundleFile text(std::string name, std::string content) const {
    return text_file(std::move(name), first_utc_ns_, [content = std::move(content)] { return content; });
  }
  [[nodiscard]] std::string local_day(std::int64_t utc_ns) const {
    Statement row(database_.handle(), "SELECT " + local_day_sql("?1"));
    return row.integer(1, utc_ns).step() ? row.text_at(0) : std::string();
  }
  static std::string utc_text(std::int64_t utc_ns) {
    std::array<char, kMaxNumber_chars> digits;
    return {digits.data(), UtcPrinter().print(digits.data(), utc_ns)};
  }
  static std::string task_of(const SessionInfo& info) {
    const json exercise = exercise_as_told(info.exercise_json);
    const std::string label = exercise.is_object() && exercise.contains("shape") ? label_of(exercise["shape"].get<std::string>()) : "";
    return label.empty() ? "walk" : label;
  }

  static std::string sidecar(ExportSource& source, const std::string& task) {
    std::map<std::string, int> counts{{"LATENCY", 1}};
    std::set<std::string> points;
    for (const std::size_t c : source.chosen) {
      const Channel channel = channel_of(source.layout[c]);
      ++counts[std::string(channel.type)];
      if (channel.point != "n/a") points.insert(channel.point);
    }
    json told{{"TaskName", task},
              {"SamplingFrequency", kNominal_hz},
              {"TrackingSystemName", "hoist"},
              {"Manufacturer", "Hoist"},
              {"SoftwareVersions", source.info.core_version.value_or(source.info.software_version)},
              {"MotionChannelCount", source.chosen.size() + 1},
              {"TrackedPointsCount", points.size()},
              {"SpatialAxes", "FLU"},
              {"RotationRule", "right-hand"},
              {"RotationOrder", "ZYX"},
              {"MissingValues", "Missing samples are left out; see the LATENCY channel"}};
    if (source.info.hoist_id) told["DeviceSerialNumber"] = *source.info.hoist_id;
    if (source.info.duration_s > 0 && source.sample_count > 1)
      told["SamplingFrequencyEffective"] = static_cast<double>(source.sample_count - 1) / source.info.duration_s;
    for (const auto& [type, count] : counts) told[type + "ChannelCount"] = count;
    return pretty(told);
  }

  static std::string channels(ExportSource& source) {
    std::string out =
        "name\tcomponent\ttype\ttracked_point\tunits\tdescription\nlatency_s\tn/a\tLATENCY\tn/a\ts\tTime since the first sample\n";
    for (const std::size_t c : source.chosen) {
      const ColumnInfo& column = source.layout[c];
      const Channel channel = channel_of(column);
      const auto signal = contract::find_signal(column.name);
      const std::string_view doc = signal ? contract::kSignals[*signal].doc : "";
      for (const std::string_view text :
           {std::string_view(column.name), channel.component, channel.type, std::string_view(channel.point), std::string_view(column.unit)})
        out += cell(text) + "\t";
      out += cell(doc) + "\n";
    }
    return out;
  }

  Database& database_;
  std::int64_t first_utc_ns_ = 0;
  std::map<std::pair<SessionId, std::string>, std::string> labels_;  // by code, or by session of those without a code
  std::vector<std::pair<std::string, std::string>> participants_;    // id and code
  std::map<SessionId, Place> places_;
  std::map<std::string, std::string> scans_;  // rows by file
};

}  // namespace

std::unique_ptr<BundlePlan> make_bids_plan(Database& database, const std::vector<SessionId>& sessions) {
  return std::make_unique<BidsPlan>(database, sessions);
}

}  // namespace hoist::db
