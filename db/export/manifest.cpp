#include "db/export/manifest.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "control/contract/axes.hpp"
#include "control/contract/calibration.hpp"
#include "control/contract/commands.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"
#include "control/contract/program_version.hpp"
#include "db/export/fixed_point.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/task_record.hpp"
#include "db/summary/provenance.hpp"

namespace hoist::db {
namespace {

using nlohmann::json;

template <typename Value>
json or_null(const std::optional<Value>& value) {
  return value ? json(*value) : json(nullptr);
}

std::string utc_text(std::int64_t utc_ns) {
  std::array<char, kMaxNumber_chars> text;
  return {text.data(), UtcPrinter().print(text.data(), utc_ns)};
}
// A parameter that is no longer in the table has no unit.
json unit_of(std::string_view name) {
  for (const contract::ParamInfo& info : contract::kParams)
    if (info.name == name) return info.unit;
  return nullptr;
}
double seconds_of(const ExportSource& source, std::int64_t time_ns) {
  return static_cast<double>(microseconds_since(source.start_ns(), time_ns)) / 1e6;
}

json session_of(const ExportSource& source) {
  const SessionInfo& info = source.info;
  return {{"id", info.id},
          {"subject", or_null(info.subject)},
          {"started_utc", utc_text(info.started_utc_ns)},
          {"started_utc_ns", info.started_utc_ns},
          {"start_time_ns", info.start_time_ns},
          {"ended_utc_ns", or_null(info.ended_utc_ns)},
          {"close_reason", info.recording ? json(nullptr) : json(info.close_reason)},
          {"simulated", info.simulated},
          {"exercise", exercise_as_told(info.exercise_json)},
          {"task", task_as_told(info.exercise_json)},
          {"note", info.note},
          {"samples", source.sample_count}};
}

json columns_of(const ExportSource& source) {
  json rows = json::array();
  for (const std::size_t c : source.chosen) {
    const ColumnInfo& column = source.layout[c];
    const std::string_view axis = contract::axis_of(column.name);
    const auto signal = contract::find_signal(column.name);
    rows.push_back({{"name", column.name},
                    {"unit", column.unit},
                    {"lsb", column.lsb},
                    {"axis", axis.empty() ? json(nullptr) : json(axis)},
                    {"doc", signal ? json(contract::kSignals[*signal].doc) : json(nullptr)}});
  }
  return rows;
}

// Each change, and from when on its value acted: a gain of a hoist that is driven gets there gradually and may be sent elsewhere meanwhile.
json changes_of(const ExportSource& source) {
  using contract::InEffect;
  json rows = json::array();
  std::map<std::string, std::size_t> on_its_way;  // row of the newest change, by parameter
  source.each_event([&](const StoredEvent& event) {
    const double time_s = seconds_of(source, static_cast<std::int64_t>(event.time_ns));
    if (event.kind_name == contract::event_name(contract::EventKind::parameter_changed)) {
      on_its_way.erase(event.name);
      if (event.code == static_cast<std::uint32_t>(InEffect::gradually)) on_its_way[event.name] = rows.size();
      rows.push_back({{"tick", event.tick},
                      {"time_s", time_s},
                      {"in_effect_s", event.code == static_cast<std::uint32_t>(InEffect::at_once) ? json(time_s) : json(nullptr)},
                      {"name", event.name},
                      {"value", finite(event.value)},
                      {"before", finite(event.before)},
                      {"unit", unit_of(event.name)}});
    }
    if (event.kind_name != contract::event_name(contract::EventKind::parameter_settled)) return;
    if (const auto change = on_its_way.find(event.name); change != on_its_way.end()) {
      rows[change->second]["in_effect_s"] = time_s;
      on_its_way.erase(change);
    }
  });
  return rows;
}

}  // namespace

json finite(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

json moment_json(const Moments::Moment& moment) {
  if (moment.event != nullptr) {
    const StoredEvent& event = *moment.event;
    return {{"tick", event.tick}, {"time_ns", event.time_ns}, {"kind", event.kind_name},      {"name", event.name},
            {"code", event.code}, {"item", event.item},       {"value", finite(event.value)}, {"before", finite(event.before)},
            {"text", ""}};
  }
  const Marker& marker = *moment.marker;
  return {{"tick", marker.tick}, {"time_ns", nullptr}, {"kind", "marker"},  {"name", marker.kind}, {"code", 0},
          {"item", 0},           {"value", nullptr},   {"before", nullptr}, {"text", marker.text}};
}

std::string dumped(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

json manifest_json(const ExportSource& source) {
  json told{{"session", session_of(source)},
            {"programs",
             {{"recorded_by", "hoist-server " + source.info.software_version},
              {"controlled_by", source.info.core_version ? json("hoist-control " + *source.info.core_version) : json(nullptr)},
              {"exported_by", "hoist " + std::string(contract::program_version())}}},
            {"hoist", {{"id", or_null(source.info.hoist_id)}}},
            {"nodes", node_programs_json(source.nodes)},
            {"layout_hash", layout_text(source.info.layout_hash)},
            {"recordings_file", source.database.file_id()},
            {"directions", contract::kAxesText},
            {"columns", columns_of(source)},
            {"parameters", json::object()},
            {"parameter_changes", changes_of(source)},
            {"calibration", json::object()},
            {"modes", json::object()},
            {"faults", json::object()},
            {"gaps", json::array()},
            {"clock", json::array()}};
  for (const auto& [name, value] : source.parameters()) {
    told["parameters"][name] = {{"value", finite(value)}, {"unit", unit_of(name)}};
    for (const contract::CalibrationStepInfo& step : contract::kCalibrationSteps)
      if (contract::kParams[contract::param_index(step.date)].name == name)
        told["calibration"][std::string(step.name)] =
            value > 0 ? json(utc_text(static_cast<std::int64_t>(value) * 1'000'000'000)) : json(nullptr);
  }
  for (const contract::ModeInfo& mode : contract::kModes)
    told["modes"][std::to_string(mode.value)] = {{"name", mode.name}, {"text", mode.title_en}};
  for (const contract::FaultInfo& fault : contract::kFaults)
    told["faults"][std::to_string(fault.bit)] = {{"name", fault.name}, {"text", fault.text_en}};
  for (const Gap& gap : source.gaps())
    told["gaps"].push_back({{"stream", gap.stream}, {"from_tick", gap.from_tick}, {"to_tick", gap.to_tick}, {"reason", gap.reason}});
  for (const ClockAnchor& anchor : source.anchors)
    told["clock"].push_back({{"time_s", seconds_of(source, anchor.time_ns)}, {"utc", utc_text(anchor.utc_ns)}});
  return told;
}

namespace {
// "a; b; c", without what is empty.
std::string listed(std::initializer_list<std::string> parts) {
  std::string out;
  for (const std::string& part : parts)
    if (!part.empty()) out += (out.empty() ? "" : "; ") + part;
  return out;
}
std::string text_of(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  return value.is_null() ? "" : dumped(value);
}
}  // namespace

std::string manifest_lines(const ExportSource& source, char separator) {
  const json told = manifest_json(source);
  std::string out;
  const auto line = [&](std::string_view key, std::string_view value) {
    out += "# ";
    out += key;
    out += separator + csv_cell(on_one_line(value), separator) + '\n';
  };
  const json& session = told["session"];
  line("hoist session", text_of(session["id"]));
  line("started", text_of(session["started_utc"]));
  line("simulated", text_of(session["simulated"]));
  if (!session["subject"].is_null()) line("subject", text_of(session["subject"]));
  if (!session["exercise"].is_null()) line("exercise", text_of(session["exercise"]));
  if (const std::string note = text_of(session["note"]); !note.empty()) line("note", note);
  line("hoist", told["hoist"]["id"].is_null() ? "not recorded" : text_of(told["hoist"]["id"]));
  const json& programs = told["programs"];
  line("recorded by", text_of(programs["recorded_by"]));
  line("controlled by", programs["controlled_by"].is_null() ? "not recorded" : text_of(programs["controlled_by"]));
  line("exported by", text_of(programs["exported_by"]));
  line("layout", text_of(told["layout_hash"]));
  if (told["nodes"].empty()) line("node programs", "not recorded");
  for (const json& node : told["nodes"]) {
    std::string text = text_of(node["name"]);
    for (const char* field : {"product", "revision", "version", "crc"})
      text += std::string("; ") + field + ' ' + (node[field].is_null() ? "not read" : text_of(node[field]));
    line("node program", text);
  }
  if (told["parameters"].empty()) line("parameters", "not recorded");
  for (const auto& [name, parameter] : told["parameters"].items())
    line("parameter", listed({name, text_of(parameter["value"]), text_of(parameter["unit"])}));
  for (const json& change : told["parameter_changes"])
    line("parameter change", listed({text_of(change["time_s"]) + " s", text_of(change["name"]), text_of(change["value"]),
                                     text_of(change["unit"]), "before " + text_of(change["before"]),
                                     change["in_effect_s"].is_null() ? "" : "in effect at " + text_of(change["in_effect_s"]) + " s"}));
  for (const auto& [step, when] : told["calibration"].items()) line("calibrated", listed({step, when.is_null() ? "never" : text_of(when)}));
  for (const auto& [number, mode] : told["modes"].items()) line("mode", listed({number, text_of(mode["name"]), text_of(mode["text"])}));
  for (const auto& [bit, fault] : told["faults"].items()) line("fault bit", listed({bit, text_of(fault["name"]), text_of(fault["text"])}));
  for (const json& gap : told["gaps"])
    line("gap",
         listed({text_of(gap["stream"]), "ticks " + text_of(gap["from_tick"]) + " to " + text_of(gap["to_tick"]), text_of(gap["reason"])}));
  for (const json& anchor : told["clock"]) line("clock", listed({text_of(anchor["time_s"]) + " s", text_of(anchor["utc"])}));
  line("directions", text_of(told["directions"]));
  return out;
}

}  // namespace hoist::db
