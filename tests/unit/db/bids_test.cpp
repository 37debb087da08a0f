// The data set of export/bids.hpp, file by file: names and labels, what each table and sidecar says, and what it must not say.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "control/contract/program_version.hpp"
#include "db/export/bids.hpp"
#include "db/store/hoist_id.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/tasks.hpp"
#include "tests/unit/db/db_support.hpp"

namespace hoist::db::test {
namespace {

using nlohmann::json;
using Files = std::map<std::string, std::string>;
using Rows = std::vector<std::vector<std::string>>;

constexpr std::int64_t kDay_ns = 86'400'000'000'000;
constexpr const char* kStraight = R"({"shape":"straight","length_m":10})";
constexpr std::size_t kSamples = 300;  // more than are written at once

std::string content(const BundleFile& file) {
  std::string out;
  const auto more = file.open();
  while (more(out)) continue;
  return out;
}

Rows rows_of(const std::string& text) {
  Rows rows;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    std::vector<std::string> cells(1);
    for (const char c : text.substr(at, end - at))
      if (c == '\t')
        cells.emplace_back();
      else
        cells.back() += c;
    rows.push_back(std::move(cells));
    at = end + 1;
  }
  return rows;
}

class Bids : public ::testing::Test {
 protected:
  // Steps 1 to kSamples but for one, a step each 10 ms from 0.5 s after the session's start on.
  SessionId record(const std::optional<std::string>& code, std::int64_t after_ns, const std::optional<std::string>& exercise) {
    Result<SessionWriter> writer = SessionWriter::create(database_);
    EXPECT_TRUE(writer.ok());
    SessionStart start = start_of_walk();
    start.subject = code;
    start.started_utc_ns += after_ns;
    start.core_version = "0.1.0+abc";
    start.exercise_json = exercise;
    start.note = "Zdenka walked";
    const std::vector<double> parameters(contract::kParamCount, 0.5);
    start.parameter_values = parameters;
    const Result<SessionId> id = writer->begin(start);
    EXPECT_TRUE(id.ok());
    std::vector<contract::TickRecord> records;
    for (std::uint64_t tick = 1; tick <= kSamples; ++tick) {
      contract::TickRecord& r = records.emplace_back();
      r.tick = tick;
      r.time_ns = kStart_ns + 490'000'000 + tick * kTick_ns + (tick == 2 ? 1'234'000 : 0);
      r.x_m = static_cast<float>(tick) * 0.001F;
      r.mode = 4;
    }
    EXPECT_TRUE(writer->append_ticks(std::span(records).first(199)).ok());
    EXPECT_TRUE(writer->append_gap("ticks", 200, 200, "not_received").ok());
    EXPECT_TRUE(writer->append_ticks(std::span(records).subspan(200)).ok());
    std::array<contract::Event, 2> events{};
    events[0].tick = 3;
    events[0].time_ns = kStart_ns + 521'500'000;
    events[0].kind = contract::EventKind::parameter_changed;
    events[0].item = contract::kParams[0].id;
    events[0].value = 0.25;
    events[0].before = 0.5;
    events[1] = events[0];
    events[1].tick = 4;
    events[1].time_ns = kStart_ns + 530'000'000;
    events[1].value = std::nan("");
    EXPECT_TRUE(writer->append_events(events).ok());
    EXPECT_TRUE(writer->store_marker(11, start.started_utc_ns + 600'000'000, "Zdenka fell", std::nullopt, "stumble").ok());
    EXPECT_TRUE(writer->end(CloseReason::finished, start.started_utc_ns + 4'000'000'000).ok());
    return *id;
  }
  Files files_of(const std::vector<SessionId>& sessions) {
    Files all;
    const auto take = [&](const std::vector<BundleFile>& files) {
      for (const BundleFile& file : files) {
        order_.push_back(file.name);
        EXPECT_TRUE(all.emplace(file.name, content(file)).second) << file.name << " twice";
        EXPECT_EQ(file.utc_ns >= kStartUtc_ns, true) << file.name;
        EXPECT_FALSE(file.large) << file.name;
      }
    };
    const auto plan = make_bids_plan(database_, sessions);
    take(plan->first());
    for (const SessionId session : sessions) take(plan->of_session(session));
    take(plan->last());
    return all;
  }
  // The files of one session of P-017 on the straight line, by the end of their name.
  Files one(SessionId session) {
    Files files;
    for (const auto& [name, text] : files_of({session}))
      if (const std::size_t at = name.find("_run-1_"); at != std::string::npos) files[name.substr(at + 7)] = text;
    return files;
  }

  TemporaryFolder dir_;
  Database database_ = std::move(*Database::open(dir_.file("hoist.db")));
  std::vector<std::string> order_;
};

TEST_F(Bids, NamesFollowPatientDayTaskAndRun) {
  std::vector<SessionId> sessions;
  for (const std::int64_t after_ns : {std::int64_t{0}, 60'000'000'000L, kDay_ns}) sessions.push_back(record("P-017", after_ns, kStraight));
  sessions.push_back(record("P-017", 120'000'000'000, R"({"shape":"square","side_m":3.2})"));
  sessions.push_back(record("P.017", 0, kStraight));          // the same letters and digits
  sessions.push_back(record("P0.17", 0, kStraight));          // and once more
  sessions.push_back(record(std::nullopt, 0, std::nullopt));  // two walks without a code are not one patient's
  sessions.push_back(record(std::nullopt, 0, std::nullopt));
  sessions.push_back(record("\xc5\xbd", kDay_ns, kStraight));  // no letter that a label may have
  const Files all = files_of(sessions);

  EXPECT_EQ(all.at("participants.tsv"),
            "participant_id\tcode\nsub-P017\tP-017\nsub-P017x\tP.017\nsub-P017xx\tP0.17\nsub-unknown7\tn/a\nsub-unknown8\tn/"
            "a\nsub-x\t\xc5\xbd\n");
  std::map<std::string, std::string> scans;
  const std::vector<std::pair<std::string, std::string>> walks{
      {"sub-P017/ses-20260921", "straight_tracksys-hoist_run-1"},  {"sub-P017/ses-20260921", "straight_tracksys-hoist_run-2"},
      {"sub-P017/ses-20260922", "straight_tracksys-hoist_run-1"},  {"sub-P017/ses-20260921", "square_tracksys-hoist_run-1"},
      {"sub-P017x/ses-20260921", "straight_tracksys-hoist_run-1"}, {"sub-P017xx/ses-20260921", "straight_tracksys-hoist_run-1"},
      {"sub-unknown7/ses-20260921", "walk_tracksys-hoist_run-1"},  {"sub-unknown8/ses-20260921", "walk_tracksys-hoist_run-1"},
      {"sub-x/ses-20260922", "straight_tracksys-hoist_run-1"},
  };
  const std::vector<std::string> begins{"14:13:20", "14:14:20", "14:13:20", "14:15:20", "14:13:20",
                                        "14:13:20", "14:13:20", "14:13:20", "14:13:20"};
  std::vector<std::string> expected{"dataset_description.json", "participants.tsv", "participants.json", "README", ".bidsignore"};
  for (std::size_t i = 0; i < walks.size(); ++i) {
    const auto& [folder, rest] = walks[i];
    std::string head = folder;
    std::ranges::replace(head, '/', '_');
    const std::string stem = head + "_task-" + rest + "_";
    for (const char* end : {"motion.tsv", "motion.json", "channels.tsv", "events.tsv", "manifest.json"})
      expected.push_back(folder + "/motion/" + stem + end);
    const std::string day = folder.ends_with("21") ? "2026-09-21" : "2026-09-22";
    scans[folder + "/" + head + "_scans.tsv"] += "motion/" + stem + "motion.tsv\t" + day + "T" + begins[i] + ".123456Z\n";
  }
  for (const auto& [name, rows] : scans) {
    expected.push_back(name);
    EXPECT_EQ(all.at(name), "filename\tacq_time\n" + rows) << name;
  }
  EXPECT_EQ(order_, expected);
}

TEST_F(Bids, ADayIsThatOfTheClinicAlsoWithoutACode) {
  const InTimeZone zone("EAST-12");  // 02:13 of the next day
  const Files all = files_of({record("P-017", 0, kStraight), record(std::nullopt, 0, kStraight)});
  EXPECT_TRUE(all.contains("sub-P017/ses-20260922/sub-P017_ses-20260922_scans.tsv"));
  EXPECT_TRUE(all.contains("sub-unknown2/ses-20260922/sub-unknown2_ses-20260922_scans.tsv"));
}

TEST_F(Bids, NamesDifferInMoreThanCapitalLetters) {
  const Files all = files_of({record("A-B", 0, kStraight), record("a.b", 0, kStraight)});
  EXPECT_EQ(all.at("participants.tsv"), "participant_id\tcode\nsub-AB\tA-B\nsub-abx\ta.b\n");
}

TEST_F(Bids, ACodeIsNotTakenForAPatientWithoutOne) {
  const Files all = files_of({record(std::nullopt, 0, kStraight), record("unknown1", 0, kStraight)});
  EXPECT_EQ(all.at("participants.tsv"), "participant_id\tcode\nsub-unknown1\tn/a\nsub-unknown1x\tunknown1\n");
}

TEST_F(Bids, TheDataSetDescribesItself) {
  TaskRecord task{.task = "own_line", .line = "Zdenka's way"};
  const std::string own = stored_with_task(contract::usual_exercise(contract::ExerciseShape::own), task);
  const Files all = files_of({record("P-017", 0, kStraight), record("P-017", 0, own)});
  EXPECT_EQ(json::parse(all.at("dataset_description.json")),
            (json{{"Name", "Walks with a Hoist"},
                  {"BIDSVersion", "1.10.0"},
                  {"DatasetType", "raw"},
                  {"GeneratedBy", json::array({json{{"Name", "hoist"}, {"Version", contract::program_version()}}})}}));
  const json words = json::parse(all.at("participants.json"));
  ASSERT_EQ(words.size(), 1U);
  EXPECT_NE(words["code"]["Description"].get<std::string>().find("Pseudonymous"), std::string::npos);
  EXPECT_NE(all.at("README").find("x forward, y left, z up"), std::string::npos);
  EXPECT_EQ(all.at(".bidsignore"), "*_manifest.json\n");
  for (const auto& [name, text] : all) EXPECT_EQ(text.find("Zdenka"), std::string::npos) << name << " holds free text";
}

TEST_F(Bids, SamplesAreRowsInTheOrderOfTheChannels) {
  const Files files = one(record("P-017", 0, kStraight));
  const Rows channels = rows_of(files.at("channels.tsv")), samples = rows_of(files.at("motion.tsv"));
  ASSERT_EQ(samples.size(), kSamples - 1) << "what is missing is left out";
  std::size_t x = 0, mode = 0;
  for (std::size_t i = 1; i < channels.size(); ++i) {
    if (channels[i][0] == "x_m") x = i - 1;
    if (channels[i][0] == "mode") mode = i - 1;
  }
  std::vector<std::string> times, places;
  for (const std::vector<std::string>& row : samples) {
    ASSERT_EQ(row.size(), channels.size() - 1);
    EXPECT_EQ(row[mode], "4");
    times.push_back(row[0]);
    places.push_back(row[x]);
  }
  EXPECT_EQ((std::vector<std::string>{times.begin(), times.begin() + 3}), (std::vector<std::string>{"0.000000", "0.011234", "0.020000"}));
  EXPECT_EQ(times[198], "1.980000");
  EXPECT_EQ(times[199], "2.000000") << "behind the gap";
  EXPECT_EQ(times.back(), "2.990000");
  EXPECT_EQ(std::stod(places[0]), 0.001);
  EXPECT_EQ(std::stod(places[199]), 0.201);
  EXPECT_EQ(std::stod(places.back()), 0.3);
}

TEST_F(Bids, ChannelsHaveTheirKindsPlacesAndUnits) {
  const Rows channels = rows_of(one(record("P-017", 0, kStraight)).at("channels.tsv"));
  EXPECT_EQ(channels[0], (std::vector<std::string>{"name", "component", "type", "tracked_point", "units", "description"}));
  EXPECT_EQ(channels[1], (std::vector<std::string>{"latency_s", "n/a", "LATENCY", "n/a", "s", "Time since the first sample"}));
  std::map<std::string, std::vector<std::string>> by_name;
  for (const std::vector<std::string>& row : channels) {
    ASSERT_EQ(row.size(), 6U) << row[0];
    by_name[row[0]] = {row[1], row[2], row[3], row[4]};
    EXPECT_TRUE(std::ranges::none_of(row, &std::string::empty)) << row[0];
  }
  const std::map<std::string, std::vector<std::string>> expected{
      {"x_m", {"x", "POS", "hoist", "m"}},
      {"y_m", {"y", "POS", "hoist", "m"}},
      {"psi_rad", {"z", "ORNT", "hoist", "rad"}},
      {"fused_x_m", {"x", "POS", "hoist", "m"}},
      {"left_alpha_rad", {"y", "ORNT", "strut_left", "rad"}},
      {"left_beta_rad", {"x", "ORNT", "strut_left", "rad"}},
      {"right_alpha_rad", {"y", "ORNT", "strut_right", "rad"}},
      {"base_alpha_rad", {"y", "ORNT", "chassis", "rad"}},
      {"base_pitch_rate_rad_s", {"y", "GYRO", "chassis", "rad/s"}},
      {"base_roll_rate_rad_s", {"x", "GYRO", "chassis", "rad/s"}},
      {"base_yaw_rate_rad_s", {"z", "GYRO", "chassis", "rad/s"}},
      {"yaw_rate_rad_s", {"z", "MISC", "hoist", "rad/s"}},
      {"speed_m_s", {"x", "VEL", "hoist", "m/s"}},
      {"wheel_left_m_s", {"x", "VEL", "wheel_left", "m/s"}},
      {"wheel_right_m_s", {"x", "VEL", "wheel_right", "m/s"}},
      {"mode", {"n/a", "MISC", "n/a", "n/a"}},
      {"battery_a_v", {"n/a", "MISC", "n/a", "V"}},
  };
  for (const auto& [name, row] : expected) EXPECT_EQ(by_name[name], row) << name;
}

TEST_F(Bids, TheSidecarCountsAndNamesWhatTheTablesHold) {
  const SessionId session = record("P-017", 0, kStraight);
  const Files files = one(session);
  const Rows channels = rows_of(files.at("channels.tsv"));
  json told = json::parse(files.at("motion.json"));
  std::map<std::string, int> types;
  std::set<std::string> points;
  for (std::size_t i = 1; i < channels.size(); ++i) {
    ++types[channels[i][2] + "ChannelCount"];
    if (channels[i][3] != "n/a") points.insert(channels[i][3]);
  }
  for (const auto& [type, count] : types) {
    EXPECT_EQ(told[type], count) << type;
    told.erase(type);
  }
  EXPECT_EQ(points, (std::set<std::string>{"chassis", "hoist", "strut_left", "strut_right", "wheel_left", "wheel_right"}));
  EXPECT_NEAR(told["SamplingFrequencyEffective"].get<double>(), 298 / 2.99, 1e-6);
  told.erase("SamplingFrequencyEffective");
  EXPECT_EQ(told, (json{{"TaskName", "straight"},
                        {"SamplingFrequency", 100},
                        {"TrackingSystemName", "hoist"},
                        {"Manufacturer", "Hoist"},
                        {"DeviceSerialNumber", hoist_id(database_.handle())},
                        {"SoftwareVersions", "0.1.0+abc"},
                        {"MotionChannelCount", channels.size() - 1},
                        {"TrackedPointsCount", points.size()},
                        {"SpatialAxes", "FLU"},
                        {"RotationRule", "right-hand"},
                        {"RotationOrder", "ZYX"},
                        {"MissingValues", "Missing samples are left out; see the LATENCY channel"}}));
}

TEST_F(Bids, EventsCountFromTheFirstSample) {
  const Files files = one(record("P-017", 0, kStraight));
  const std::string parameter = contract::kParams[0].name.data();
  EXPECT_EQ(files.at("events.tsv"), "onset\tduration\ttrial_type\tname\tvalue\n0.021500\t0\tparameter_changed\t" + parameter +
                                        "\t0.25\n0.030000\t0\tparameter_changed\t" + parameter +
                                        "\tn/a\n0.100000\t0\tmarker\tstumble\tn/a\n");
  const json manifest = json::parse(files.at("manifest.json"));
  EXPECT_FALSE(manifest["session"].contains("note"));
  EXPECT_EQ(manifest["gaps"].size(), 1U);
}

// A file of 4 GB and more has other fields in a ZIP, so it says so before it is written.
TEST_F(Bids, SamplesOfManyHoursMayPassFourGigabytes) {
  const SessionId session = record("P-017", 0, kStraight);
  const auto large = [&](std::uint64_t samples) {
    Statement(database_.handle(), "UPDATE sessions SET sample_count = ?1").unsigned_integer(1, samples).run();
    std::vector<bool> marks;
    for (const BundleFile& file : make_bids_plan(database_, {session})->of_session(session)) marks.push_back(file.large);
    return marks;
  };
  EXPECT_EQ(large(524'287), std::vector<bool>(5, false));
  EXPECT_EQ(large(524'288), (std::vector<bool>{true, false, false, false, false}));
}

}  // namespace
}  // namespace hoist::db::test
