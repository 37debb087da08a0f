// The formats beside CSV and JSON, and what every format tells of a session.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "control/contract/params.hpp"
#include "db/export/zip_file.hpp"
#include "db/store/hoist_id.hpp"
#include "db/store/sqlite.hpp"
#include "tests/unit/db/export_support.hpp"

namespace hoist::db::test {
namespace {

using nlohmann::json;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// A session with a gap, a change of a parameter, a marker and a clock that was set.
void record_eventful(Fixture& f) {
  SessionStart start = start_of_walk();
  std::vector<double> values;
  for (const contract::ParamInfo& info : contract::kParams) values.push_back(info.default_value);
  values[contract::param_index(contract::ParamName::calibrated_zero_s)] = 1'780'000'000;
  start.parameter_values = values;
  Walk walk(41);
  std::vector<TickRecord> records = walk.records(0, 300);
  for (const TickRecord& record : walk.records(340, 300)) records.push_back(record);
  f.record(start, records);
  contract::Event event;
  event.tick = 50;
  event.time_ns = kStart_ns + 500'000'000;
  event.kind = contract::EventKind::parameter_changed;
  event.item = contract::kParams[contract::param_index(contract::ParamName::lean_range_rad)].id;
  event.value = 0.125;
  event.before = 0.25;
  event.code = static_cast<std::uint32_t>(contract::InEffect::at_once);
  EXPECT_TRUE(f.writer.append_events(std::span(&event, 1)).ok());
  // A gain that is changed twice while the hoist is driven: the first value is never reached.
  event.item = contract::kParams[contract::param_index(contract::ParamName::lean_gain_direct_units)].id;
  event.code = static_cast<std::uint32_t>(contract::InEffect::gradually);
  for (const double value : {4.0, 3.0}) {
    event.before = value - 2;
    event.value = value;
    event.tick += 10;
    event.time_ns += 100'000'000;
    EXPECT_TRUE(f.writer.append_events(std::span(&event, 1)).ok());
  }
  event.kind = contract::EventKind::parameter_settled;
  event.tick += 100;
  event.time_ns += 1'000'000'000;
  EXPECT_TRUE(f.writer.append_events(std::span(&event, 1)).ok());
  // Another recording system says that it records.
  event = {};
  event.tick = 250;
  event.time_ns = kStart_ns + 2'500'000'000;
  event.kind = contract::EventKind::sync_input;
  event.code = 1;
  EXPECT_TRUE(f.writer.append_events(std::span(&event, 1)).ok());
  EXPECT_TRUE(f.writer.append_marker(60, kStartUtc_ns + 600'000'000, "turn; \"left\"").ok());
  EXPECT_TRUE(f.writer.append_gap("ticks", 300, 339, "not_received").ok());
  f.end();
}

TEST(Manifest, TellsParametersChangesCalibrationWordsGapsAndClockInCsvAndJson) {
  Fixture f;
  record_eventful(f);
  const std::vector<std::string> lines = lines_of(whole(f.database, f.id, {}));
  for (const char* line : {"# parameter,lean_range_rad; 0.157079633; rad",
                           "# parameter change,0.5 s; lean_range_rad; 0.125; rad; before 0.25; in effect at 0.5 s",
                           "# parameter change,0.6 s; lean_gain_direct_units; 4.0; units; before 2.0",
                           "# parameter change,0.7 s; lean_gain_direct_units; 3.0; units; before 1.0; in effect at 1.7 s",
                           "# calibrated,zero; 2026-05-28T20:26:40.000000Z", "# calibrated,track; never", "# mode,2; user; Patient leads",
                           "# gap,ticks; ticks 300 to 339; not_received", "# clock,0.0 s; 2026-09-21T14:13:20.123456Z"})
    EXPECT_NE(std::ranges::find(lines, line), lines.end()) << line;
  EXPECT_TRUE(std::ranges::any_of(lines, [](const std::string& line) { return line.starts_with("# exported by,hoist 0."); }));
  const json told = json::parse(whole(f.database, f.id, {.format = ExportFormat::json}))["manifest"];
  EXPECT_EQ(told["parameters"]["lean_range_rad"], (json{{"value", 0.157079633}, {"unit", "rad"}}));
  const json& changes = told["parameter_changes"];
  ASSERT_EQ(changes.size(), 3U);
  EXPECT_EQ(changes[0], (json{{"tick", 50},
                              {"time_s", 0.5},
                              {"in_effect_s", 0.5},
                              {"name", "lean_range_rad"},
                              {"value", 0.125},
                              {"before", 0.25},
                              {"unit", "rad"}}));
  EXPECT_EQ(changes[1]["in_effect_s"], nullptr) << "another change came before";
  EXPECT_EQ(changes[2]["in_effect_s"], 1.7);
  EXPECT_EQ(told["calibration"]["zero"], "2026-05-28T20:26:40.000000Z");
  EXPECT_EQ(told["calibration"]["track"], nullptr);
  EXPECT_EQ(told["modes"]["2"]["name"], "user");
  EXPECT_EQ(told["gaps"][0]["to_tick"], 339);
  EXPECT_EQ(told["clock"][0]["utc"], "2026-09-21T14:13:20.123456Z");
  EXPECT_EQ(told["faults"].size(), contract::kFaults.size());
  EXPECT_EQ(told["recordings_file"], f.database.file_id());
  const std::string id = hoist_id(f.database.handle());
  EXPECT_EQ(told["hoist"], (json{{"id", id}}));
  EXPECT_NE(std::ranges::find(lines, "# hoist," + id), lines.end());
}

TEST(Manifest, SaysThatTheHoistOfAnOldRecordingIsNotKnown) {
  Fixture f;
  record_eventful(f);
  execute(f.database.handle(), "UPDATE sessions SET hoist_id = NULL");
  EXPECT_EQ(json::parse(whole(f.database, f.id, {.format = ExportFormat::json}))["manifest"]["hoist"], (json{{"id", nullptr}}));
  const std::vector<std::string> lines = lines_of(whole(f.database, f.id, {}));
  EXPECT_NE(std::ranges::find(lines, "# hoist,not recorded"), lines.end());
}

TEST(Events, AnEdgeOfTheSynchronisationHasItsStepTimeAndLevel) {
  Fixture f;
  record_eventful(f);
  const std::vector<std::string> lines = lines_of(whole(f.database, f.id, {.format = ExportFormat::events, .comments = false}));
  EXPECT_TRUE(std::ranges::any_of(
      lines, [](const std::string& line) { return line.starts_with("2026-09-21T14:13:22.623456Z,2.500000,250,sync_input,on,1,"); }));
  const json events = json::parse(whole(f.database, f.id, {.format = ExportFormat::json}))["events"];
  const auto edge = std::ranges::find(events, "sync_input", [](const json& event) { return event["kind"]; });
  ASSERT_NE(edge, events.end());
  EXPECT_EQ((*edge)["tick"], 250);
  EXPECT_EQ((*edge)["name"], "on");
}

TEST(GermanCsv, IsThePlainOneWithOtherSigns) {
  Fixture f;
  record_eventful(f);
  ExportOptions options{.columns = {"tick", "x_m", "psi_rad"}, .comments = false};
  std::string plain = whole(f.database, f.id, options);
  options.format = ExportFormat::csv_de;
  const std::string german = whole(f.database, f.id, options);
  EXPECT_EQ(german.substr(0, 3), "\xEF\xBB\xBF");
  EXPECT_EQ(lines_of(german)[1].substr(0, 20), "2026-09-21T14:13:20.") << "times stay ISO 8601";
  // Times hold a point that stays: both are compared without the first cell.
  const std::vector<std::string> ours = lines_of(german), theirs = lines_of(plain);
  ASSERT_EQ(ours.size(), theirs.size());
  for (std::size_t i = 1; i < ours.size(); ++i) {
    std::string rest = ours[i].substr(ours[i].find(';') + 1);
    ASSERT_EQ(rest.find('.'), std::string::npos) << "numbers have a decimal comma: " << rest;
    std::ranges::replace(rest, ',', '.');
    std::ranges::replace(rest, ';', ',');
    ASSERT_EQ(rest, theirs[i].substr(theirs[i].find(',') + 1));
  }
  options.comments = true;
  EXPECT_NE(whole(f.database, f.id, options).find("# simulated;true\n"), std::string::npos);
}

TEST(Csv, ColumnsThatNeverChangeCanBeLeftOut) {
  Fixture f;
  record_eventful(f);
  const auto names = [&](const ExportOptions& options) { return lines_of(whole(f.database, f.id, options)).front(); };
  const std::string all = names({.comments = false}), some = names({.comments = false, .constant = false});
  EXPECT_NE(all.find(",bus_up"), std::string::npos);
  EXPECT_EQ(some.find(",bus_up"), std::string::npos);
  EXPECT_NE(some.find(",x_m"), std::string::npos);
  EXPECT_EQ(names({.columns = {"bus_up", "x_m"}, .comments = false, .constant = false}), "utc,time_s,gap_before,x_m");
}

// Both ways of telling sizes, read by Python's zipfile.
TEST(Zip, SmallAndLargeFilesAreReadByAnotherProgram) {
  TemporaryFolder dir;
  std::string bytes;
  ZipFile zip;
  for (const bool large : {false, true}) {
    zip.begin_file(bytes, large ? "gro\xC3\x9F/large.txt" : "small.txt", kStartUtc_ns, large);
    for (int i = 0; i < 3000; ++i) zip.write(bytes, "line " + std::to_string(i) + "\n");
    zip.end_file(bytes);
  }
  zip.begin_file(bytes, "empty", 0, false);
  zip.end_file(bytes);
  zip.end(bytes);
  const std::filesystem::path file = dir / "a.zip", out = dir / "told";
  std::ofstream(file, std::ios::binary) << bytes;
  const std::string command =
      "python3 -c 'import sys, zipfile\nz = zipfile.ZipFile(sys.argv[1])\nassert z.testzip() is None\n"
      "for i in z.infolist(): print(i.filename.encode(), i.file_size, i.date_time, i.extract_version)' " +
      file.string() + " > " + out.string();
  ASSERT_EQ(std::system(command.c_str()), 0);
  std::stringstream told;
  told << std::ifstream(out).rdbuf();
  EXPECT_EQ(told.str(),
            "b'small.txt' 28890 (2026, 9, 21, 14, 13, 20) 20\n"
            "b'gro\\xc3\\x9f/large.txt' 28890 (2026, 9, 21, 14, 13, 20) 45\n"
            "b'empty' 0 (1980, 1, 1, 0, 0, 0) 20\n");
}

}  // namespace
}  // namespace hoist::db::test
