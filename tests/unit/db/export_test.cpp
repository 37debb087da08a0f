#include <gtest/gtest.h>
#include <sqlite3.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <sstream>

#include "control/bus/candump_log.hpp"
#include "control/contract/axes.hpp"
#include "control/contract/can_dictionary.hpp"
#include "control/contract/reference_path.hpp"
#include "db/export/fixed_point.hpp"
#include "db/export/session_export.hpp"
#include "db/export/source.hpp"
#include "db/metrics/metric_list.hpp"
#include "db/store/alarms.hpp"
#include "db/store/markers.hpp"
#include "db/store/sqlite.hpp"
#include "db/summary/session_json.hpp"
#include "db/summary/session_metrics.hpp"
#include "tests/support/shell.hpp"
#include "tests/unit/db/export_support.hpp"

namespace hoist::db::test {
namespace {

using contract::TickRecord;
using nlohmann::json;

std::string fixed(std::int64_t value, int decimals) {
  std::array<char, kMaxNumber_chars> text;
  return {text.data(), print_fixed(text.data(), value, decimals)};
}

TEST(FixedPoint, prints_the_stored_integer_exactly) {
  EXPECT_EQ(fixed(0, 0), "0");
  EXPECT_EQ(fixed(0, 3), "0.000");
  EXPECT_EQ(fixed(-1, 5), "-0.00001");
  EXPECT_EQ(fixed(12345, 2), "123.45");
  EXPECT_EQ(fixed(-12345, 5), "-0.12345");
  EXPECT_EQ(fixed(100000, 5), "1.00000");
  EXPECT_EQ(fixed(std::numeric_limits<std::int64_t>::min(), 0), "-9223372036854775808");
  EXPECT_EQ(fixed(std::numeric_limits<std::int64_t>::min(), 15), "-9223.372036854775808");
  EXPECT_EQ(fixed(std::numeric_limits<std::int64_t>::max(), 9), "9223372036.854775807");
}

TEST(FixedPoint, reading_the_text_gives_the_value_that_the_store_gives) {
  std::mt19937_64 random(1);
  for (int round = 0; round < 200000; ++round) {
    const auto value = static_cast<std::int64_t>(random() >> (random() % 40 + 11)) * (round % 2 == 0 ? 1 : -1);
    const int decimals = static_cast<int>(random() % 10);
    ASSERT_EQ(std::strtod(fixed(value, decimals).c_str(), nullptr), static_cast<double>(value) / std::pow(10.0, decimals))
        << value << " " << decimals;
  }
}

TEST(FixedPoint, utc_is_iso_8601_also_before_1970) {
  UtcPrinter printer;
  std::array<char, kMaxNumber_chars> text;
  const auto utc = [&](std::int64_t ns) { return std::string(text.data(), printer.print(text.data(), ns)); };
  EXPECT_EQ(utc(0), "1970-01-01T00:00:00.000000Z");
  EXPECT_EQ(utc(kStartUtc_ns), "2026-09-21T14:13:20.123456Z");
  EXPECT_EQ(utc(-1), "1969-12-31T23:59:59.999999Z");
}

TEST(Csv, no_text_can_start_a_formula_or_leave_its_cell) {
  EXPECT_EQ(csv_cell("plain"), "plain");
  EXPECT_EQ(csv_cell(""), "");
  EXPECT_EQ(csv_cell("=1+1"), "\"'=1+1\"");
  EXPECT_EQ(csv_cell("+49"), "\"'+49\"");
  EXPECT_EQ(csv_cell("-2"), "\"'-2\"");
  EXPECT_EQ(csv_cell("@SUM(A1)"), "\"'@SUM(A1)\"");
  EXPECT_EQ(csv_cell("\tx"), "\"'\tx\"");
  EXPECT_EQ(csv_cell("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_cell("say \"ah\""), "\"say \"\"ah\"\"\"");
  EXPECT_EQ(csv_cell("two\nlines"), "\"two\nlines\"");
}

std::string run(const std::string& command);

struct Csv {
  std::vector<std::string> comments, names;
  std::vector<std::vector<std::string>> rows;
};
Csv parse_csv(const std::string& text) {
  Csv csv;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with('#')) {
      EXPECT_TRUE(csv.names.empty()) << "comments only before the names";
      csv.comments.push_back(line);
      continue;
    }
    std::vector<std::string> cells;
    std::istringstream cells_stream(line);
    for (std::string cell; std::getline(cells_stream, cell, ',');) cells.push_back(cell);
    if (csv.names.empty())
      csv.names = cells;
    else
      csv.rows.push_back(cells);
  }
  return csv;
}

std::vector<TickRecord> walk_with_gap() {
  Walk walk(21);
  std::vector<TickRecord> records = walk.records(0, 3200);
  records.erase(records.begin() + 1000, records.begin() + 1040);
  return records;
}

TEST(Csv, every_value_reads_back_as_it_was_stored) {
  Fixture f;
  SessionStart start = start_of_walk();
  start.note = "first\nsecond, with \"quotes\"";
  const std::vector<TickRecord> records = walk_with_gap();
  f.record(start, records);
  f.end();
  std::size_t largest = 0;
  const Csv csv = parse_csv(whole(f.database, f.id, {}, &largest));
  EXPECT_LT(largest, 200000U) << "a piece is small whatever the session's length";
  EXPECT_EQ(csv.comments.front(), "# hoist session," + std::to_string(f.id));
  EXPECT_NE(std::ranges::find(csv.comments, "# simulated,true"), csv.comments.end());
  EXPECT_NE(std::ranges::find(csv.comments, "# node programs,not recorded"), csv.comments.end());
  EXPECT_NE(std::ranges::find(csv.comments, "# note,\"first\\nsecond, with \"\"quotes\"\"\""), csv.comments.end());
  EXPECT_TRUE(csv.comments.back().starts_with("# units: UTC,s,,,ns,,rad,"));
  ASSERT_EQ(csv.names.size(), contract::kSignalCount + 3);
  EXPECT_EQ(csv.names[0], "utc");
  EXPECT_EQ(csv.names[1], "time_s");
  EXPECT_EQ(csv.names[2], "gap_before");
  EXPECT_EQ(csv.names[3], "tick");
  ASSERT_EQ(csv.rows.size(), records.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    ASSERT_EQ(csv.rows[i].size(), csv.names.size());
    EXPECT_EQ(csv.rows[i][2], i == 1000 ? "1" : "0");
    for (std::size_t c = 0; c < contract::kSignalCount; ++c)
      ASSERT_EQ(std::strtod(csv.rows[i][c + 3].c_str(), nullptr), kept(records[i], csv.names[c + 3])) << csv.names[c + 3] << " row " << i;
    EXPECT_NEAR(std::strtod(csv.rows[i][1].c_str(), nullptr), static_cast<double>(records[i].time_ns - kStart_ns) / 1e9, 0.51e-6);
  }
  EXPECT_EQ(csv.rows[0][0].substr(0, 19), "2026-09-21T14:13:20");
  EXPECT_EQ(csv.rows[100][0].substr(0, 21), "2026-09-21T14:13:21.1");
}

TEST(Csv, chosen_columns_come_in_the_asked_order_and_unknown_ones_are_refused) {
  Fixture f;
  f.record(start_of_walk(), Walk(22).records(0, 50));
  f.end();
  ExportOptions options;
  options.columns = {"y_m", "x_m"};
  options.comments = false;
  const Csv csv = parse_csv(whole(f.database, f.id, options));
  EXPECT_TRUE(csv.comments.empty());
  EXPECT_EQ(csv.names, (std::vector<std::string>{"utc", "time_s", "gap_before", "y_m", "x_m"}));
  EXPECT_EQ(csv.rows.size(), 50U);
  options.columns = {"x_m", "secret_m", "other_m"};
  const Result<SessionExport> refused = SessionExport::open(f.database, f.id, options);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "columns");
  EXPECT_EQ(refused.error().message, "this session has no column secret_m, other_m");
  options.columns = {"x_m", "x_m"};
  EXPECT_EQ(SessionExport::open(f.database, f.id, options).error().field, "columns");
  EXPECT_EQ(SessionExport::open(f.database, f.id + 1, {}).error().kind, ErrorKind::not_found);
}

// H26
TEST(Csv, a_clock_that_was_set_moves_utc_and_nothing_else) {
  Fixture f;
  const std::vector<TickRecord> records = Walk(23).records(0, 300);
  f.record(start_of_walk(), records);
  ASSERT_TRUE(f.writer.append_utc_anchor(records[200].time_ns, kStartUtc_ns + 3'600'000'000'000).ok());
  f.end();
  const Csv csv = parse_csv(whole(f.database, f.id, {}));
  EXPECT_EQ(csv.rows[199][0].substr(11, 5), "14:13");
  EXPECT_EQ(csv.rows[200][0], "2026-09-21T15:13:20.123456Z");
  EXPECT_EQ(csv.rows[299][0].substr(11, 5), "15:13");
  EXPECT_NEAR(std::stod(csv.rows[200][1]), 2.0, 0.001);
}

// H26
TEST(Markers, a_clock_that_was_set_moves_their_utc_and_not_their_time) {
  constexpr std::int64_t kHour_ns = 3'600'000'000'000;
  Fixture f;
  std::vector<TickRecord> records = Walk(23).records(0, 300);
  records.front().time_ns = kStart_ns;
  f.record(start_of_walk(), records);
  ASSERT_TRUE(f.writer.append_utc_anchor(kStart_ns + 2'000'000'000, kStartUtc_ns + 2'000'000'000 + kHour_ns).ok());
  ASSERT_TRUE(f.writer.append_marker(250, kStartUtc_ns + 2'500'000'000 + kHour_ns, "after").ok());
  contract::Event alarm;
  alarm.tick = 260;
  alarm.time_ns = kStart_ns + 2'600'000'000;
  alarm.kind = contract::EventKind::fault_raised;
  ASSERT_TRUE(f.writer.append_events(std::span(&alarm, 1)).ok());
  f.end();
  MarkerStore store(f.database);
  EXPECT_DOUBLE_EQ(store.list(f.id, -1, 10)->at(0).time_s, 2.5);
  const std::string csv = whole(f.database, f.id, {.format = ExportFormat::events, .comments = false});
  EXPECT_NE(csv.find("\n2026-09-21T15:13:22.623456Z,2.500000,250,marker,"), std::string::npos) << csv;
  std::ofstream(f.dir / "plain.db") << whole(f.database, f.id, {.format = ExportFormat::sqlite});
  sqlite3* plain = nullptr;
  ASSERT_EQ(sqlite3_open_v2((f.dir / "plain.db").c_str(), &plain, SQLITE_OPEN_READONLY, nullptr), SQLITE_OK);
  {
    Statement row(plain, "SELECT time_s, utc FROM markers");
    ASSERT_TRUE(row.step());
    EXPECT_DOUBLE_EQ(row.real_at(0), 2.5);
    EXPECT_EQ(row.text_at(1), "2026-09-21T15:13:22.623456Z");
  }
  sqlite3_close_v2(plain);
  // Moved to moments before and after.
  EXPECT_EQ(store.change(f.id, 0, {.text = {}, .kind = {}, .time_s = 2.25}, "")->marker.utc_ns, kStartUtc_ns + 2'250'000'000 + kHour_ns);
  EXPECT_EQ(store.change(f.id, 0, {.text = {}, .kind = {}, .time_s = 1.25}, "")->marker.utc_ns, kStartUtc_ns + 1'250'000'000);
  EXPECT_EQ(store.list(f.id, -1, 10)->at(0).marker.tick, 125U);
  const std::int64_t utc_ns = kStartUtc_ns + 2'600'000'000 + kHour_ns;
  EXPECT_EQ(stored_alarms(f.database, {})->items.at(0).utc_ns, utc_ns);
  EXPECT_EQ(stored_alarms(f.database, {.from_utc_ns = utc_ns, .to_utc_ns = utc_ns + 1})->items.size(), 1U);
  EXPECT_TRUE(stored_alarms(f.database, {.to_utc_ns = utc_ns})->items.empty());
}

TEST(Csv, an_export_of_a_running_session_ends_where_it_began_also_when_the_session_is_folded_meanwhile) {
  Fixture f;
  Walk walk(24);
  const std::vector<TickRecord> records = walk.records(0, 2000);
  f.record(start_of_walk(), records);
  ASSERT_TRUE(f.writer.commit().ok());
  for (const ExportFormat format : {ExportFormat::csv, ExportFormat::json}) {
    ExportOptions options;
    options.format = format;
    Result<SessionExport> running = SessionExport::open(f.database, f.id, options);
    ASSERT_TRUE(running.ok());
    std::string all, piece;
    for (int i = 0; i < 4; ++i) {
      ASSERT_TRUE(*running->next_chunk(piece));
      all += piece;
    }
    if (f.writer.recording()) {
      ASSERT_TRUE(f.writer.append_ticks(walk.records(2000, 700)).ok());
      f.end();
    }
    while (*running->next_chunk(piece)) all += piece;
    if (format == ExportFormat::csv) {
      const Csv csv = parse_csv(all);
      ASSERT_EQ(csv.rows.size(), 2000U);
      for (std::size_t i = 0; i < csv.rows.size(); ++i) ASSERT_EQ(csv.rows[i][3], std::to_string(i));
    } else {
      EXPECT_EQ(json::parse(all)["data"]["tick"].size(), 2700U);
    }
  }
}

TEST(EventsCsv, events_and_markers_in_order_with_harmless_texts) {
  Fixture f;
  std::vector<TickRecord> records = Walk(25).records(0, 10);
  records.front().time_ns = kStart_ns;
  f.record(start_of_walk(), records);
  contract::Event event;
  event.tick = 8;
  event.time_ns = kStart_ns + 80'000'000;
  event.kind = contract::EventKind::mode_changed;
  event.code = 2;
  event.value = 0.1;
  event.client = 7;
  f.writer.set_actor_of([](std::uint32_t client) {
    return client == 7 ? std::optional(Actor{"local", "therapist", "hoist.v1", "device-0a1b2c3d"}) : std::nullopt;
  });
  ASSERT_TRUE(f.writer.append_events(std::span(&event, 1)).ok());
  ASSERT_TRUE(f.writer.append_marker(3, kStartUtc_ns + 30'000'000, "=HYPERLINK(\"http://evil\")").ok());
  f.end();
  ExportOptions options;
  options.format = ExportFormat::events;
  options.comments = false;
  EXPECT_EQ(whole(f.database, f.id, options),
            "utc,time_s,tick,kind,name,code,bits,item,value,before,request_id,user,role,origin,client,text\n"
            "2026-09-21T14:13:20.153456Z,0.030000,3,marker,note,,,,,,,,,,,\"'=HYPERLINK(\"\"http://evil\"\")\"\n"
            "2026-09-21T14:13:20.203456Z,0.080000,8,mode_changed,user,2,0,0,0.1,0,0,local,therapist,hoist.v1,device-0a1b2c3d,\n");
}

TEST(Json, holds_everything_column_by_column) {
  Fixture f;
  SessionStart start = start_of_walk();
  start.exercise_json = R"({"shape":"straight","length_m":10})";
  const std::vector<TickRecord> records = walk_with_gap();
  f.record(start, records);
  ASSERT_TRUE(f.writer.append_marker(3, kStartUtc_ns, "ok").ok());
  f.end();
  ExportOptions options;
  options.format = ExportFormat::json;
  const json all = json::parse(whole(f.database, f.id, options));
  EXPECT_EQ(all["session"]["id"], f.id);
  EXPECT_EQ(all["session"]["subject"], "P-017");
  EXPECT_EQ(all["session"]["started_utc"], "2026-09-21T14:13:20.123456Z");
  EXPECT_EQ(all["session"]["exercise"]["length_m"], 10);
  EXPECT_EQ(all["rows"], records.size());
  ASSERT_EQ(all["columns"].size(), contract::kSignalCount + 2);
  for (const json& column : all["columns"]) {
    const std::string name = column["name"];
    ASSERT_EQ(all["data"][name].size(), records.size()) << name;
    if (name == "time_s" || name == "gap_before") continue;
    for (std::size_t i = 0; i < records.size(); ++i) ASSERT_EQ(all["data"][name][i].get<double>(), kept(records[i], name)) << name;
  }
  EXPECT_EQ(all["data"]["gap_before"][1000], 1);
  EXPECT_EQ(all["gaps"][0]["reason"], "not_received");
  EXPECT_EQ(all["gaps"][0]["to_tick"], 1039);
  EXPECT_EQ(all["markers"][0]["text"], "ok");
  EXPECT_EQ(all["markers"][0]["kind"], "note");
}

// A reader of its own for both rules: RFC 4180, and pandas' C parser, for which '#' outside quotes ends the line (pandas issue 27637).
std::vector<std::vector<std::string>> read_rfc4180(const std::string& text, bool drop_comments) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> row;
  std::string cell;
  bool quoted = false, comment = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (comment && c != '\n') continue;
    if (quoted) {
      if (c != '"')
        cell += c;
      else if (i + 1 < text.size() && text[i + 1] == '"')
        cell += text[++i];
      else
        quoted = false;
    } else if (c == '"') {
      EXPECT_TRUE(cell.empty()) << "a quote inside a cell that is not quoted: " << cell;
      quoted = true;
    } else if (drop_comments && c == '#') {
      comment = true;
    } else if (c == ',') {
      row.push_back(std::move(cell));
      cell.clear();
    } else if (c == '\n') {
      if (!(comment && row.empty() && cell.empty())) {
        row.push_back(std::move(cell));
        rows.push_back(std::move(row));
      }
      row.clear();
      cell.clear();
      comment = false;
    } else {
      cell += c;
    }
  }
  EXPECT_FALSE(quoted);
  return rows;
}

TEST(Csv, any_text_survives_readers_with_and_without_comments) {
  Fixture f;
  SessionStart start = start_of_walk();
  const std::string text = "room #4, \"left\"\nnext #5";
  start.note = text;
  f.record(start, Walk(31).records(0, 20));
  ASSERT_TRUE(f.writer.append_marker(3, kStartUtc_ns, text).ok());
  ASSERT_TRUE(f.writer.append_marker(4, kStartUtc_ns, "bed #2").ok());
  f.end();
  for (const bool comments : {true, false}) {
    ExportOptions options;
    options.format = ExportFormat::events;
    options.comments = comments;
    const std::string csv = whole(f.database, f.id, options);
    const auto dropped = read_rfc4180(csv, true);
    ASSERT_EQ(dropped.size(), 3U) << csv;
    EXPECT_EQ(dropped[0].back(), "text");
    ASSERT_EQ(dropped[1].size(), dropped[0].size());
    EXPECT_EQ(dropped[1].back(), text);
    EXPECT_EQ(dropped[2].back(), "bed #2") << "nothing else in it needs quotes";
    auto plain = read_rfc4180(csv, false);
    std::erase_if(plain, [](const auto& row) { return row.front().starts_with("#"); });
    EXPECT_EQ(plain, dropped);
  }
}

TEST(Provenance, both_exports_say_who_recorded_what) {
  Fixture f;
  SessionStart start = start_of_walk();
  start.software_version = "0.1.0+aaaabbbbcccc";
  start.core_version = "0.1.0+ddddeeeeffff.modified";
  start.nodes = {{"tilt_left", 0x80000001U, 0x00020000U, 0x00010203U, 0xDEADBEEFU}, {"io", {}, {}, {}, {}}};
  f.record(start, Walk(32).records(0, 20));
  f.end();
  ExportOptions options;
  options.columns = {"x_m", "psi_rad", "tick"};
  const Csv csv = parse_csv(whole(f.database, f.id, options));
  for (const char* line :
       {"# recorded by,hoist-server 0.1.0+aaaabbbbcccc", "# controlled by,hoist-control 0.1.0+ddddeeeeffff.modified",
        "# layout,fedcba9876543210", "# node program,io; product not read; revision not read; version not read; crc not read",
        "# node program,tilt_left; product 80000001; revision 2.0; version 1.2.3; crc deadbeef",
        "# axes:,,,x forward from the start mark,psi turns left,", "# units: UTC,s,,m,rad,"})
    EXPECT_NE(std::ranges::find(csv.comments, line), csv.comments.end()) << line;
  EXPECT_NE(std::ranges::find(csv.comments, "# directions,\"" + std::string(contract::kAxesText) + '"'), csv.comments.end());
  options.format = ExportFormat::json;
  const json all = json::parse(whole(f.database, f.id, options));
  EXPECT_EQ(all["session"]["software_version"], "0.1.0+aaaabbbbcccc");
  EXPECT_EQ(all["session"]["core_version"], "0.1.0+ddddeeeeffff.modified");
  EXPECT_EQ(all["session"]["layout_hash"], "fedcba9876543210");
  EXPECT_EQ(all["session"]["nodes"][0]["version"], "1.2.3");
  EXPECT_EQ(all["session"]["nodes"][0]["simulated"], true);
  EXPECT_TRUE(all["session"]["nodes"][1]["revision"].is_null());
  EXPECT_EQ(all["directions"], contract::kAxesText);
  EXPECT_EQ(all["columns"][0]["unit"], "s");
  EXPECT_EQ(all["columns"][3]["unit"], "rad");
  EXPECT_EQ(all["columns"][3]["lsb"], contract::kSignals[*contract::find_signal("psi_rad")].lsb);
  EXPECT_EQ(all["columns"][3]["axis"], "psi turns left");
  EXPECT_TRUE(all["columns"][4]["axis"].is_null());
}

// The reader of the tree, and log2asc of can-utils where it is installed.
TEST(BusLogExport, frames_come_back_as_recorded_with_their_gap) {
  Fixture f;
  f.record(start_of_walk(), Walk(33).records(0, 400));
  std::vector<contract::BusRecord> frames;
  for (std::uint32_t i = 0; i < 5000; ++i) {
    contract::BusRecord frame;
    frame.time_ns = kStart_ns + (i < 3000 ? i : i + 500) * 500'000ULL;  // 250 ms are missing after frame 2999
    frame.id = 0x181 + i % 6;
    frame.dlc = static_cast<std::uint8_t>(i % 9);
    frame.sent = i % 5 == 0;
    frame.data = frame.dlc == 0 ? 0 : (i * 0x0101'0101'0101ULL) & (~0ULL >> (64 - 8 * frame.dlc));
    frames.push_back(frame);
  }
  ASSERT_TRUE(f.writer.append_bus(frames).ok());
  ASSERT_TRUE(f.writer.append_gap("bus", 149, 175, "recorder_late").ok());
  ASSERT_TRUE(f.writer.append_gap("ticks", 50, 60, "not_received").ok());  // of samples: no frame is missing
  f.end();
  ExportOptions options;
  options.format = ExportFormat::candump;
  std::size_t largest = 0;
  const std::string text = whole(f.database, f.id, options, &largest);
  EXPECT_LT(largest, 100000U) << "a piece is small whatever the session's length";
  std::ofstream(f.dir / "can.log") << text;
  std::vector<bus::LogEntry> entries;
  ASSERT_EQ(bus::read_log((f.dir / "can.log").string(), entries), "");
  ASSERT_EQ(entries.size(), frames.size() + 1);
  EXPECT_EQ(entries[3000].frame.flags, contract::CanFrame::kError);
  EXPECT_EQ(entries[3000].frame.id, 4U);
  EXPECT_EQ(entries[3000].frame.data[1], 1);
  entries.erase(entries.begin() + 3000);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ASSERT_EQ(entries[i].frame.id, frames[i].id);
    ASSERT_EQ(contract::read_le(entries[i].frame.data.data(), 4), frames[i].data & 0xFFFFFFFFU);
    ASSERT_EQ(entries[i].direction, frames[i].sent != 0 ? bus::Direction::sent : bus::Direction::received);
    ASSERT_EQ(entries[i].time_us,
              static_cast<std::uint64_t>(kStartUtc_ns + static_cast<std::int64_t>(frames[i].time_ns - kStart_ns)) / 1000);
    ASSERT_EQ(std::string_view(entries[i].interface.data()), "vcan0") << "marked as simulated";
  }
  if (std::system("command -v log2asc > /dev/null") != 0) GTEST_SKIP() << "can-utils is not installed";
  const std::string asc = run("log2asc -I " + (f.dir / "can.log").string() + " vcan0");
  EXPECT_EQ(std::ranges::count(asc, '\n'), static_cast<std::ptrdiff_t>(frames.size()) + 1 + 3) << "three lines of head";
  EXPECT_NE(asc.find("ErrorFrame"), std::string::npos);
  options.columns = {"x_m"};
  EXPECT_EQ(SessionExport::open(f.database, f.id, options).error().field, "columns");
}

TEST(Json, an_empty_session_is_valid_json) {
  Fixture f;
  f.record(start_of_walk(), {});
  f.end();
  ExportOptions options;
  options.format = ExportFormat::json;
  const json all = json::parse(whole(f.database, f.id, options));
  EXPECT_EQ(all["rows"], 0);
  EXPECT_EQ(all["data"]["x_m"].size(), 0U);
  EXPECT_EQ(parse_csv(whole(f.database, f.id, {})).rows.size(), 0U);
}

// A patient follows a figure of eight with a wobble; before and after the hoist is in STANDBY.
std::vector<TickRecord> follow(const contract::ReferencePath& path, double length_m) {
  std::vector<TickRecord> records;
  const auto add = [&](double s_m, double offset_m, contract::Mode mode) {
    const std::size_t i = records.size();
    const contract::PathPose pose = path.pose(s_m);
    TickRecord r;
    r.tick = i;
    r.time_ns = kStart_ns + i * kTick_ns;
    r.x_m = static_cast<float>(pose.x_m - offset_m * std::sin(pose.psi_rad));
    r.y_m = static_cast<float>(pose.y_m + offset_m * std::cos(pose.psi_rad));
    r.psi_rad = static_cast<float>(pose.psi_rad + offset_m);
    r.fused_x_m = r.x_m;
    r.fused_y_m = r.y_m;
    r.fused_psi_rad = r.psi_rad;
    r.dpsi_rad = static_cast<float>(0.2 * pose.kappa_per_m + 0.01 * std::sin(static_cast<double>(i)));
    r.speed_m_s = mode == contract::Mode::standby ? 0.0F : 0.4F;
    r.mode = static_cast<std::uint8_t>(mode);
    records.push_back(r);
  };
  for (int i = 0; i < 150; ++i) add(0, 0, contract::Mode::standby);
  for (double s_m = 0; s_m < length_m; s_m += 0.004) add(s_m, 0.05 * std::sin(s_m), contract::Mode::user);
  for (int i = 0; i < 150; ++i) add(length_m, 0, contract::Mode::standby);
  return records;
}

std::string run(const std::string& command) {
  const hoist::test::ShellResult result = hoist::test::run_shell(command);
  EXPECT_EQ(result.exit_code, 0) << command << "\n" << result.output;
  return result.output;
}

TEST(Metrics, agree_with_the_laws_run_on_the_exported_columns) {
  const std::string tool = std::string(HOIST_BINARY_DIR) + "/bin/hoist";
  struct Case {
    const char* exercise;
    contract::ReferencePath path;
    double length_m;
    json shape;
  };
  const std::vector<Case> cases{
      {R"({"shape":"eight","centre_m":1.0,"radius_m":0.8})",
       contract::ReferencePath::eight(1.0, 0.8),
       12.0,
       {{"shape", "eight"}, {"c", 1.0}, {"R", 0.8}}},
      {R"({"shape":"square","side_m":3.2})", contract::ReferencePath::square(3.2), 14.0, {{"shape", "square"}, {"a", 3.2}}}};
  for (const Case& one : cases) {
    Fixture f;
    SessionStart start = start_of_walk();
    start.exercise_json = one.exercise;
    f.record(start, follow(one.path, one.length_m));
    f.end();
    const std::string db = (f.dir / "hoist.db").string(), id = std::to_string(f.id);
    const json metrics = json::parse(run(tool + " metrics " + db + " " + id));
    EXPECT_EQ(metrics, *session_metrics_json(f.database, f.id)) << "what REST answers";
    // The columns as any other program would take them: out of the CSV, moving rows only.
    const Csv csv = parse_csv(run(tool + " export " + db + " " + id + " --columns mode,x_m,y_m,psi_rad,dpsi_rad"));
    json in = one.shape;
    in["dt"] = 0.01;
    for (const auto& row : csv.rows) {
      if (row[3] != "2" && row[3] != "3") continue;
      in["x"].push_back(std::stod(row[4]));
      in["y"].push_back(std::stod(row[5]));
      in["psi"].push_back(std::stod(row[6]));
      in["dpsi"].push_back(std::stod(row[7]));
    }
    ASSERT_GT(in["x"].size(), 2000U);
    EXPECT_NEAR(metrics["under_way_s"].get<double>(), 0.01 * static_cast<double>(in["x"].size()), 1e-9) << "in motion";
    std::ofstream(f.dir / "in.jsonl") << in.dump() << "\n";
    const json laws = json::parse(run(tool + " laws evaluate < " + (f.dir / "in.jsonl").string()));
    EXPECT_EQ(metrics["C"].get<double>(), laws["C"].get<double>());
    EXPECT_EQ(metrics["J_N"].get<double>(), laws["J"].get<double>());
    EXPECT_EQ(metrics["reference_length_m"].get<double>(), laws["L"].get<double>());
    // Only the eight turns all the time; the square's reference turns in its corners alone.
    if (one.shape["shape"] == "eight") {
      EXPECT_GT(metrics["C"].get<double>(), 0.8) << "the wobble is small";
    }
    EXPECT_GT(metrics["J_N"].get<double>(), 0.0);
    EXPECT_NEAR(metrics["rms_position_m"].get<double>(), 0.05 / std::numbers::sqrt2, 0.01) << "the wobble";
    EXPECT_NEAR(metrics["mean_speed_m_s"].get<double>(), 0.4, 1e-9);
    const json listed = json::parse(run(tool + " sessions " + db));
    EXPECT_EQ(listed["id"], f.id);
    EXPECT_EQ(listed["exercise"]["shape"], one.shape["shape"]);
    const json exported = json::parse(run(tool + " export " + db + " " + id + " --format json --columns mode"));
    // The same names and figures everywhere: those of REST.
    EXPECT_EQ(listed["exercise"], metrics["exercise"]);
    EXPECT_EQ(listed["exercise"], exported["session"]["exercise"]);
    EXPECT_EQ(exported["metrics"], metrics);
    EXPECT_EQ(listed["exercise"].contains("c_m"), one.shape["shape"] == "eight");
    EXPECT_EQ(metrics["reason_if_none"], nullptr);
  }
}

TEST(Metrics, AWalkAlongAnOwnSquareHasTheFiguresOfTheSquare) {
  Fixture f;
  const std::vector<TickRecord> walk = follow(contract::ReferencePath::square(3.2), 14.0);
  const auto recorded = [&](const std::string& exercise) {
    SessionStart start = start_of_walk();
    start.exercise_json = exercise;
    f.record(start, walk);
    f.end();
    return f.id;
  };
  const std::string task = R"("version":1,"ends":"distance","goal":1,"edge_m":0,"repetition":1,"repetitions":3,"rest_s":60)";
  const SessionId square = recorded(R"({"shape":"square","side_m":3.2,"task":{"task":"square",)" + task + "}}");
  const SessionId own = recorded(
      R"({"shape":"own","closed":true,"x_m":[-1.6,1.6,1.6,-1.6],"y_m":[-1.6,-1.6,1.6,1.6],"task":{"task":"own_line","line":"Hall",)" +
      task + "}}");
  const Result<SessionMetrics> of_square = session_metrics(f.database, square), of_own = session_metrics(f.database, own);
  ASSERT_TRUE(of_square.ok() && of_own.ok());
  EXPECT_EQ(of_own->shape, "own");
  for (std::size_t i = 0; i < kMetrics.size(); ++i) {
    const Figure &expected = of_square->figures[i], &figure = of_own->figures[i];
    EXPECT_EQ(figure.why, expected.why) << kMetrics[i].key;
    ASSERT_EQ(figure.value.has_value(), expected.value.has_value()) << kMetrics[i].key;
    if (figure.value) {
      EXPECT_NEAR(*figure.value, *expected.value, 1e-9) << kMetrics[i].key;
    }
  }
  for (const char* key : {"C", "J_N", "J_T_m_s", "rms_lateral_m", "rms_heading_rad", "cross_track_mean_m", "cross_track_max_m",
                          "completion_norm", "lap_time_mean_s", "reference_length_m", "task_time_s"})
    EXPECT_TRUE((*of_own)[key].value) << key;
  // The tool tells what REST answers, and every export carries line and name.
  const json told =
      json::parse(run(std::string(HOIST_BINARY_DIR) + "/bin/hoist metrics " + (f.dir / "hoist.db").string() + " " + std::to_string(own)));
  EXPECT_EQ(told, *session_metrics_json(f.database, own));
  const json exported = json::parse(run(std::string(HOIST_BINARY_DIR) + "/bin/hoist export " + (f.dir / "hoist.db").string() + " " +
                                        std::to_string(own) + " --format json --columns mode"));
  EXPECT_EQ(exported["metrics"], told);
  EXPECT_EQ(exported.at("session").at("exercise").at("x_m"), (json{-1.6, 1.6, 1.6, -1.6}));
  EXPECT_EQ(exported.at("session").at("task").at("line"), "Hall");
}

// The recorder's thread reads them: one piece of a session of hours is no longer than one of minutes.
TEST(Metrics, are_read_in_pieces_while_the_session_is_folded) {
  Fixture f;
  Walk walk(7);
  constexpr std::size_t kSamples = 65'000, kPieces = 3;
  f.record(start_of_walk(), walk.records(0, kSamples));
  ASSERT_TRUE(f.writer.close(CloseReason::finished, kStartUtc_ns).ok());
  auto reading = MetricsReading::open(f.database, f.id);
  ASSERT_TRUE(reading.ok());
  std::size_t pieces = 0;
  for (bool more = true; more; ++pieces) {
    more = *reading->piece(f.database);
    ASSERT_TRUE(f.writer.fold_piece().ok());
  }
  EXPECT_EQ(pieces, 3 * kPieces) << "three readings";
  const json figures = metrics_json(reading->take(), {});
  while (*f.writer.fold_piece()) continue;
  EXPECT_EQ(figures, *session_metrics_json(f.database, f.id));
  EXPECT_FALSE(figures.at("walked_m").is_null());

  // Exports tell the same figures, from pieces without a text of their own.
  auto exported = SessionExport::open(f.database, f.id, {.format = ExportFormat::json, .columns = {"mode"}});
  std::string all, piece;
  std::size_t empty = 0;
  while (*exported->next_chunk(piece)) {
    empty += piece.empty() ? 1 : 0;
    all += piece;
  }
  EXPECT_EQ(empty, pieces - 1) << "the last one brings the figures";
  EXPECT_EQ(json::parse(all).at("metrics"), figures);

  auto broken_off = MetricsReading::open(f.database, f.id);
  ASSERT_TRUE(*broken_off->piece(f.database));
  ASSERT_TRUE(SessionEditor(f.database).remove(f.id));
  const Result<bool> rest = broken_off->piece(f.database);
  ASSERT_FALSE(rest.ok()) << "figures of a part";
  EXPECT_EQ(rest.error().kind, ErrorKind::not_found);
}

SessionMetrics metrics_of(const std::vector<TickRecord>& records,
                          const char* exercise = R"({"shape":"eight","centre_m":1.0,"radius_m":0.8})") {
  Fixture f;
  SessionStart start = start_of_walk();
  start.exercise_json = exercise;
  std::vector<double> values;
  for (const contract::ParamInfo& info : contract::kParams) values.push_back(info.default_value);
  start.parameter_values = values;
  f.record(start, records);
  f.end();
  const Result<SessionMetrics> metrics = session_metrics(f.database, f.id);
  EXPECT_TRUE(metrics.ok());
  return metrics.ok() ? *metrics : SessionMetrics{};
}

TEST(Metrics, a_walk_with_a_part_missing_is_not_compared_and_says_how_much) {
  const contract::ReferencePath eight = contract::ReferencePath::eight(1.0, 0.8);
  const std::vector<TickRecord> walk = follow(eight, 12.0);
  std::size_t first = 0;
  while (!contract::kModes[walk[first].mode].moving) ++first;
  struct Case {
    const char* what;
    std::size_t from, count;
    double missing_s;
    bool compared;
  };
  for (const Case& one : {Case{"whole", 0, 0, 0, true}, Case{"a little of the middle", first + 1000, 50, 0.5, true},
                          Case{"more of the middle", first + 1000, 51, 0.51, false}, Case{"before the motion", 1, 10, 0, true}}) {
    ASSERT_GT(first, 12U);
    std::vector<TickRecord> records = walk;
    const auto from = records.begin() + static_cast<std::ptrdiff_t>(one.from);
    records.erase(from, from + static_cast<std::ptrdiff_t>(one.count));
    const SessionMetrics metrics = metrics_of(records);
    EXPECT_NEAR(*metrics["missing_s"].value, one.missing_s, 1e-9) << one.what;
    EXPECT_EQ(metrics["J_N"].value.has_value(), one.compared) << one.what;
    EXPECT_EQ(metrics["C"].value.has_value(), one.compared) << one.what;
    EXPECT_EQ(metrics.why_absent, one.compared ? NoFigure::none : NoFigure::part_missing) << one.what;
  }
}

TEST(Metrics, AShortGapAnywhereHardlyChangesTheFigures) {
  const std::vector<TickRecord> walk = follow(contract::ReferencePath::eight(1.0, 0.8), 12.0);
  const SessionMetrics whole = metrics_of(walk);
  ASSERT_TRUE(whole["C"].value && whole["J_N"].value);
  double most_c = 0, most_j = 0;
  for (std::size_t from = 200; from + 250 < walk.size(); from += 100) {
    std::vector<TickRecord> records = walk;
    records.erase(records.begin() + static_cast<std::ptrdiff_t>(from), records.begin() + static_cast<std::ptrdiff_t>(from) + 50);
    const SessionMetrics gapped = metrics_of(records);
    ASSERT_TRUE(gapped["C"].value && gapped["J_N"].value) << from;
    most_c = std::max(most_c, std::fabs(*gapped["C"].value - *whole["C"].value));
    most_j = std::max(most_j, std::fabs(*gapped["J_N"].value / *whole["J_N"].value - 1));
  }
  RecordProperty("largest_change_of_C", std::to_string(most_c));
  RecordProperty("largest_share_of_J", std::to_string(most_j));
  EXPECT_LE(most_c, 0.02);
  EXPECT_LE(most_j, 0.05);
}

// The timed part is two metres here, and a gap over one of its edges a tenth of its time.
TEST(Metrics, AShortGapOverAnEdgeHardlyChangesTheTimedSpeed) {
  const std::vector<TickRecord> walk = follow(contract::ReferencePath::straight(6.0), 6.3);
  const char* const task = R"({"shape":"straight","length_m":6,"task":{"task":"walk_10m","version":1,"ends":"distance","goal":1,)"
                           R"("edge_m":2,"repetition":1,"repetitions":3,"rest_s":60}})";
  const SessionMetrics whole = metrics_of(walk, task);
  ASSERT_TRUE(whole["timed_speed_m_s"].value && whole["task_time_s"].value);
  EXPECT_NEAR(*whole["timed_speed_m_s"].value, 0.4, 0.004);
  double most = 0, most_s = 0;
  for (std::size_t from = 155; from + 205 < walk.size(); from += 24) {
    std::vector<TickRecord> records = walk;
    records.erase(records.begin() + static_cast<std::ptrdiff_t>(from), records.begin() + static_cast<std::ptrdiff_t>(from) + 49);
    const SessionMetrics gapped = metrics_of(records, task);
    ASSERT_TRUE(gapped["timed_speed_m_s"].value && gapped["task_time_s"].value) << from;
    most = std::max(most, std::fabs(*gapped["timed_speed_m_s"].value / *whole["timed_speed_m_s"].value - 1));
    most_s = std::max(most_s, std::fabs(*gapped["task_time_s"].value - *whole["task_time_s"].value));
  }
  RecordProperty("largest_share_of_timed_speed", std::to_string(most));
  RecordProperty("largest_change_of_task_time_s", std::to_string(most_s));
  EXPECT_LE(most, 0.02);
  EXPECT_LE(most_s, 0.25) << "progress stays at the line's end";
  // A pause before an edge is recorded: the edge is passed after it.
  std::vector<TickRecord> paused = walk;
  const auto edge = std::ranges::find_if(paused, [](const TickRecord& record) { return record.fused_x_m >= 2; });
  TickRecord standing = *std::prev(edge);
  standing.mode = static_cast<std::uint8_t>(contract::Mode::standby);
  paused.insert(edge, 500, standing);
  for (std::size_t i = 0; i < paused.size(); ++i) paused[i].tick = i, paused[i].time_ns = kStart_ns + i * kTick_ns;
  EXPECT_NEAR(*metrics_of(paused, task)["timed_speed_m_s"].value, *whole["timed_speed_m_s"].value, 0.002);
}

TEST(Metrics, AWalkThatGoesOnIsComparedAndANewStartIsNot) {
  const std::vector<TickRecord> walk = follow(contract::ReferencePath::eight(1.0, 0.8), 12.0);
  const SessionMetrics whole = metrics_of(walk);
  // Two seconds of standstill in STANDBY in the middle: pose and distance stay.
  std::vector<TickRecord> paused;
  for (const TickRecord& record : walk) {
    paused.push_back(record);
    for (int i = 0; paused.size() > 1500 && paused.size() < 1700 && i < 200; ++i) {
      paused.push_back(record);
      paused.back().mode = static_cast<std::uint8_t>(contract::Mode::protective_stop);
    }
  }
  for (std::size_t i = 0; i < paused.size(); ++i) {
    paused[i].tick = i;
    paused[i].time_ns = kStart_ns + i * kTick_ns;
  }
  const SessionMetrics went_on = metrics_of(paused);
  ASSERT_TRUE(went_on["C"].value && went_on["J_N"].value);
  EXPECT_NEAR(*went_on["C"].value, *whole["C"].value, 0.01);
  EXPECT_NEAR(*went_on["J_N"].value, *whole["J_N"].value, 0.01 * *whole["J_N"].value);
  EXPECT_EQ(went_on["under_way_s"].value, whole["under_way_s"].value);
  // The same with a new mark behind the pause, or with the therapist leading.
  const std::vector<TickRecord> same = paused;
  for (std::size_t i = 1700; i < paused.size(); ++i) paused[i].start_mark = 1;
  EXPECT_EQ(metrics_of(paused).why_absent, NoFigure::several_walks);
  paused = same;
  for (std::size_t i = 1900; i < paused.size() - 160; ++i) paused[i].mode = static_cast<std::uint8_t>(contract::Mode::remote);
  EXPECT_EQ(metrics_of(paused).why_absent, NoFigure::several_walks);
  EXPECT_FALSE(metrics_of(paused)["J_N"].value.has_value());
  EXPECT_EQ(metrics_json(metrics_of(paused), {})["reason_code"], "several_walks");
  // Recordings without the mark's number: a new mark shows by the distance, which restarts at zero.
  paused = same;
  for (std::size_t i = 200; i < 1700; ++i) paused[i].distance_m = 2;
  EXPECT_EQ(metrics_of(paused).why_absent, NoFigure::several_walks);
}

TEST(Metrics, ARecordingThatBeginsMidwayKnowsItsPlace) {
  const std::vector<TickRecord> walk = follow(contract::ReferencePath::eight(1.0, 0.8), 12.0);
  std::vector<TickRecord> rest(walk.begin() + 1000, walk.end());
  for (TickRecord& record : rest) record.distance_m = 3.4F;
  const SessionMetrics late = metrics_of(rest);
  ASSERT_TRUE(late["J_N"].value);
  EXPECT_NEAR(late.start_m, 0.004 * 850, 0.1);
  EXPECT_NEAR(*late["reference_length_m"].value, 12.0 - 3.4, 0.1);
  // Not at the exercise's start, and not a continuation: the exercise was named afterwards.
  for (TickRecord& record : rest) record.distance_m = 0;
  EXPECT_EQ(metrics_of(rest).why_absent, NoFigure::start_unclear);
  for (TickRecord& record : rest) record.distance_m = 3.4F, record.fused_x_m += 3;
  EXPECT_EQ(metrics_of(rest).why_absent, NoFigure::start_unclear);
}

TEST(Metrics, EachFigureNamesItsDefinitionAndWhatItWasComputedFrom) {
  const std::vector<TickRecord> walk = follow(contract::ReferencePath::eight(1.0, 0.8), 12.0);
  const auto computed = [](const std::vector<TickRecord>& records) { return metrics_json(metrics_of(records), {})["computed"]; };
  const json whole = computed(walk);
  ASSERT_EQ(whole.size(), kMetrics.size());
  EXPECT_EQ(whole, computed(walk));
  // The session has the repaired track; its own number of the mark; an exercise.
  EXPECT_EQ(whole["C"]["inputs"],
            json::array({"mode", "fused_x_m", "fused_y_m", "fused_psi_rad", "dpsi_rad", "distance_m", "start_mark", "gaps", "exercise"}));
  EXPECT_EQ(whole["walked_m"]["inputs"], json::array({"mode", "speed_m_s"}));
  const auto differ = [&whole](const json& other) {
    std::set<std::string> keys;
    for (const auto& [key, one] : whole.items()) {
      EXPECT_EQ(one["version"], other[key]["version"]);
      if (one["hash"] != other[key]["hash"]) keys.insert(key);
    }
    return keys;
  };
  // One step of one sample, and the figures of that column are known to be of something else; the others are not touched.
  const auto of = [](std::string_view column) {
    std::set<std::string> keys;
    for (const MetricInfo& metric : kMetrics)
      if ((" " + std::string(metric.inputs) + " ").find(" " + std::string(column) + " ") != std::string::npos) keys.emplace(metric.key);
    return keys;
  };
  std::vector<TickRecord> other = walk;
  other[1000].speed_m_s += 0.01F;
  EXPECT_EQ(differ(computed(other)), of("speed_m_s"));
  EXPECT_TRUE(of("speed_m_s").contains("walked_m") && !of("speed_m_s").contains("C"));
  other = walk;
  other[1000].fused_psi_rad += 0.001F;
  EXPECT_EQ(differ(computed(other)), of("psi_rad"));
  EXPECT_TRUE(of("psi_rad").contains("J_N") && !of("psi_rad").contains("walked_m"));
  other = walk;
  other[1000].dpsi_rad += 0.001F;
  EXPECT_EQ(differ(computed(other)), of("dpsi_rad"));
  other = walk;
  other[1000].dy_m += 0.001F;
  EXPECT_EQ(differ(computed(other)), of("dy_m"));
  other = walk;
  other.erase(other.begin() + 1000);
  EXPECT_EQ(differ(computed(other)).size(), kMetrics.size());
}

// Every figure is a number or says why not, and never both.
TEST(Metrics, AFigureIsANumberOrAReason) {
  const std::vector<TickRecord> walk = follow(contract::ReferencePath::eight(1.0, 0.8), 12.0);
  const std::vector<TickRecord> nothing(walk.begin(), walk.begin() + 100);
  const std::vector<TickRecord> hardly(walk.begin(), walk.begin() + 160);
  std::size_t numbers = 0;
  for (const std::vector<TickRecord>* records : {&walk, &nothing, &hardly}) {
    const json told = metrics_json(metrics_of(*records), {});
    for (const MetricInfo& metric : kMetrics) {
      const std::string key(metric.key);
      EXPECT_NE(told[key].is_null(), told["computed"][key]["reason_code"].is_null()) << key;
      EXPECT_TRUE(metric.nullable || told[key].is_number()) << key;
      numbers += told[key].is_number() ? 1 : 0;
    }
  }
  EXPECT_GT(numbers, kMetrics.size() / 2);
  // No sway was recorded in this walk: nothing is told of its steps.
  EXPECT_EQ(metrics_of(walk)["cadence_steps_min"].why, NoFigure::no_rhythm);
}

// The reason is the one of this walk: too slow for a bout, led by the therapist, or back without a turn.
TEST(Metrics, AReasonIsThatOfTheWalk) {
  const std::vector<TickRecord> walk = follow(contract::ReferencePath::eight(1.0, 0.8), 12.0);
  std::vector<TickRecord> slow = walk;
  for (TickRecord& record : slow) record.speed_m_s /= 10;
  const SessionMetrics crept = metrics_of(slow);
  EXPECT_GT(*crept["walked_m"].value, 1.0);
  for (const char* key : {"walking_speed_m_s", "stops", "steps", "cadence_steps_min", "stride_time_cv_norm", "sparc", "ldlj"})
    EXPECT_EQ(crept[key].why, NoFigure::no_bout) << key;
  for (TickRecord& record : slow) record.standing_still = 1, record.speed_m_s = 0;
  EXPECT_EQ(metrics_of(slow)["walking_speed_m_s"].why, NoFigure::no_motion);

  std::vector<TickRecord> driven = walk;
  for (TickRecord& record : driven)
    if (contract::kModes[record.mode].moving) record.mode = static_cast<std::uint8_t>(contract::Mode::remote);
  EXPECT_EQ(metrics_of(driven)["interventions"].why, NoFigure::not_led);

  // There and backwards again.
  std::vector<TickRecord> back = follow(contract::ReferencePath::straight(4.0), 4.0);
  for (std::size_t i = back.size() - 150; i-- > 150;) back.insert(back.end() - 150, back[i]);
  for (std::size_t i = 0; i < back.size(); ++i) back[i].tick = i, back[i].time_ns = kStart_ns + i * kTick_ns;
  const SessionMetrics there = metrics_of(back, R"({"shape":"free","task":{"task":"up_and_go","version":1,"ends":"back","goal":3,)"
                                                R"("edge_m":0,"repetition":1,"repetitions":3,"rest_s":60}})");
  EXPECT_TRUE(there["task_time_s"].value);
  for (const char* key : {"out_time_s", "turning_time_s", "back_time_s"}) EXPECT_EQ(there[key].why, NoFigure::no_turn_back) << key;
  for (const char* key : {"timed_speed_m_s", "task_distance_m"}) EXPECT_EQ(there[key].why, NoFigure::no_task) << key;
}

// Breaks of the patient's lead and stops, from the modes alone.
TEST(Metrics, StopsAndBreaksAreCounted) {
  using contract::Mode;
  const std::vector<TickRecord> walk = follow(contract::ReferencePath::eight(1.0, 0.8), 12.0);
  const auto counts = [&walk](std::vector<std::pair<std::size_t, Mode>> changes) {
    std::vector<TickRecord> records = walk;
    for (std::size_t i = 150; i + 150 < records.size(); ++i)
      for (const auto& [from, mode] : changes)
        if (i >= from) records[i].mode = static_cast<std::uint8_t>(mode);
    const SessionMetrics metrics = metrics_of(records);
    return std::pair{*metrics["interventions"].value, *metrics["protective_stops"].value};
  };
  EXPECT_EQ(counts({}), std::pair(0.0, 0.0)) << "the walk's end is no intervention";
  EXPECT_EQ(counts({{800, Mode::protective_stop}}), std::pair(1.0, 1.0));
  EXPECT_EQ(counts({{800, Mode::standby}, {1000, Mode::user}}), std::pair(1.0, 0.0)) << "walked on";
  EXPECT_EQ(counts({{800, Mode::remote}, {1000, Mode::emergency_stop}}), std::pair(1.0, 1.0));
}

// The figures of the lead are judged by the settings of the session's begin, and standby is part of a session that is begun by hand.
TEST(Metrics, SettingsThatChangedBeforeTheWalkAreNoticed) {
  const std::vector<TickRecord> walk = follow(contract::ReferencePath::eight(1.0, 0.8), 12.0);
  const auto changed_from = [&walk](std::size_t step) {
    std::vector<TickRecord> records = walk;
    for (std::size_t i = 0; i < records.size(); ++i) records[i].parameter_version = i < step ? 7 : 8;
    return metrics_of(records);
  };
  for (const std::size_t step : {std::size_t{0}, walk.size() - 100}) {
    const SessionMetrics same = changed_from(step);
    EXPECT_TRUE(same["dead_band_norm"].value && same["effort_s_m"].value && same["balance_events"].value) << step;
  }
  for (const std::size_t step : {100U, 1000U}) {
    const SessionMetrics changed = changed_from(step);
    for (const char* key : {"dead_band_norm", "effort_s_m", "balance_events", "start_latency_s", "stopping_way_m"})
      EXPECT_EQ(changed[key].why, NoFigure::settings_changed) << key << " " << step;
    EXPECT_TRUE(changed["walked_m"].value);
  }
}

// What was told of a recording is what it gives again; a changed number, and another recording, are noticed.
TEST(Metrics, RecomputeFindsWhatDiffers) {
  Fixture f;
  SessionStart start = start_of_walk();
  start.exercise_json = R"({"shape":"eight","centre_m":1.0,"radius_m":0.8})";
  for (const double length_m : {12.0, 6.0}) {
    f.record(start, follow(contract::ReferencePath::eight(1.0, 0.8), length_m));
    f.end();
  }
  const std::string db = (f.dir / "hoist.db").string(), tool = std::string(HOIST_BINARY_DIR) + "/bin/hoist ";
  const std::string told = (f.dir / "told.jsonl").string();
  std::ofstream(told) << run(tool + "metrics " + db + " all");
  const std::string count = std::to_string(2 * kMetrics.size());
  EXPECT_NE(run(tool + "metrics recompute " + db + " " + told).find("2 sessions: " + count + " figures are the same, 0 differ, 0"),
            std::string::npos);
  const std::string exported = (f.dir / "one.json").string();
  std::ofstream(exported) << run(tool + "export " + db + " 1 --format json --columns mode");
  EXPECT_NE(run(tool + "metrics recompute " + db + " " + exported).find("1 sessions: "), std::string::npos);
  const auto code = [&](const json& changed) {
    std::ofstream(told) << changed.dump();
    return WEXITSTATUS(std::system((tool + "metrics recompute " + db + " " + told + " > /dev/null").c_str()));
  };
  const json one = *session_metrics_json(f.database, 1);
  EXPECT_EQ(code(one), 0);
  json changed = one;
  changed["walked_m"] = std::nextafter(changed["walked_m"].get<double>(), 100.0);
  EXPECT_EQ(code(changed), 1);
  changed = one;
  changed["computed"]["C"]["version"] = 0;
  EXPECT_EQ(code(changed), 3);
  changed = one;
  changed["computed"]["C"]["hash"] = "0";
  EXPECT_EQ(code(changed), 3);
  changed = one;
  changed["session"] = 77;
  EXPECT_EQ(code(changed), 1);
}

TEST(Metrics, StandingIsNoMotion) {
  std::vector<TickRecord> walk = follow(contract::ReferencePath::eight(1.0, 0.8), 12.0);
  for (std::size_t i = 500; i < 1500; ++i) walk[i].standing_still = 1, walk[i].speed_m_s = 0;
  const SessionMetrics metrics = metrics_of(walk);
  EXPECT_NEAR(*metrics["under_way_s"].value - *metrics["motion_s"].value, 10.0, 1e-9);
  EXPECT_EQ(metrics_json(metrics, {})["motion_s"], *metrics["motion_s"].value);
  EXPECT_NEAR(*metrics["mean_speed_m_s"].value, 0.4, 1e-5);
}

TEST(Metrics, without_walking_or_exercise_there_are_no_figures_but_a_reason) {
  Fixture f;
  std::vector<TickRecord> still(100);
  for (std::size_t i = 0; i < still.size(); ++i) {
    still[i].tick = i;
    still[i].time_ns = kStart_ns + i * kTick_ns;
    still[i].mode = static_cast<std::uint8_t>(contract::Mode::standby);
  }
  SessionStart start = start_of_walk();
  f.record(start, still);
  f.end();
  const Result<SessionMetrics> plain = session_metrics(f.database, f.id);
  ASSERT_TRUE(plain.ok());
  EXPECT_EQ((*plain)["under_way_s"].value, 0);
  EXPECT_EQ((*plain)["walked_m"].value, 0);
  EXPECT_EQ((*plain)["mean_speed_m_s"].why, NoFigure::no_motion) << "not zero";
  EXPECT_TRUE(plain->shape.empty());
  EXPECT_FALSE((*plain)["C"].value.has_value());
  SessionPatch patch;
  patch.exercise_json = std::optional<std::string>(R"({"shape":"square","side_m":3.2})");
  ASSERT_TRUE(SessionEditor(f.database).patch(f.id, patch).ok());
  const Result<SessionMetrics> asked = session_metrics(f.database, f.id);
  ASSERT_TRUE(asked.ok());
  EXPECT_EQ(asked->shape, "square");
  EXPECT_FALSE((*asked)["J_N"].value.has_value());
  EXPECT_EQ(asked->why_absent, NoFigure::no_motion);
  EXPECT_EQ(session_metrics(f.database, f.id + 1).error().kind, ErrorKind::not_found);
}

}  // namespace
}  // namespace hoist::db::test
