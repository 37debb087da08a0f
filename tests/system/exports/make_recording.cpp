// make_recording FILE: a recording of a made-up walk with a gap, events, markers and CAN frames, for the readers of our exports.
#include <cstdio>

#include "control/contract/params.hpp"
#include "control/core/output/sync_pulses.hpp"
#include "tests/unit/db/db_support.hpp"

namespace {
using namespace hoist;

// The pulses of a core that has been running: their lengths differ.
constexpr std::uint64_t kCoreAge_ticks = 123'456'700;

template <typename Outcome>
bool fine(const Outcome& outcome) {
  if (!outcome.ok()) std::fprintf(stderr, "%s\n", outcome.error().message.c_str());
  return outcome.ok();
}

db::SessionId record(db::SessionWriter& writer, std::uint32_t seed, db::SessionStart start, const char* exercise) {
  std::vector<double> values;
  for (const contract::ParamInfo& info : contract::kParams) values.push_back(info.default_value);
  start.parameter_values = values;
  start.core_version = "0.1.0+ddddeeeeffff";
  start.exercise_json = exercise;
  const auto id = writer.begin(start);
  if (!fine(id)) return 0;
  db::test::Walk walk(seed);
  for (std::uint64_t first : {0U, 1500U}) {
    std::vector<contract::TickRecord> records = walk.records(first, 1400);
    for (std::size_t i = 700; i < 740; ++i) records[i].fault_bits = contract::fault_bit(contract::kFaults.front());
    for (contract::TickRecord& step : records) step.sync_output = core::sync_pulse(step.tick + kCoreAge_ticks) ? 1 : 0;
    if (!fine(writer.append_ticks(records))) return 0;
  }
  contract::Event event;
  event.tick = 50;
  event.time_ns = db::test::kStart_ns + 500'000'000;
  event.kind = contract::EventKind::parameter_changed;
  event.item = contract::kParams[contract::param_index(contract::ParamName::lean_range_rad)].id;
  event.value = 0.125;
  event.before = 0.25;
  const bool good = fine(writer.append_events(std::span(&event, 1))) && fine(writer.append_gap("ticks", 1400, 1499, "not_received")) &&
                    fine(writer.append_marker(1420, start.started_utc_ns + 14'200'000'000, "in the gap")) &&
                    fine(writer.append_marker(60, start.started_utc_ns + 600'000'000, "turned; \"left\", by the ramp")) &&
                    fine(writer.end(db::CloseReason::finished, start.started_utc_ns + 29'000'000'000));
  return good ? *id : 0;
}
}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 || argv[1][0] == '-') {
    std::fputs("usage: make_recording FILE: makes a file of three recorded sessions\n", stderr);
    return 2;
  }
  auto database = db::Database::open(argv[1]);
  if (!fine(database)) return 1;
  auto writer = db::SessionWriter::create(*database);
  if (!fine(writer)) return 1;
  db::SessionStart start = db::test::start_of_walk();
  if (record(*writer, 1, start, R"({"shape":"straight","length_m":10})") == 0) return 1;
  start.started_utc_ns += 86'400'000'000'000;
  if (record(*writer, 2, start, R"({"shape":"square","side_m":3.2})") == 0) return 1;
  start.subject = "P-018";
  const db::SessionId tagged = record(*writer, 3, start, R"({"shape":"square","side_m":3.2})");
  if (tagged == 0) return 1;
  db::SessionPatch patch;
  patch.note = "Walked well (#Baseline), #tired2 in the end; no. #1";
  if (!fine(db::SessionEditor(*database).patch(tagged, patch))) return 1;
  return 0;
}
