// record_walks FILE: records the walks on standard input, for against_numpy.py. A walk: a line "walk EXERCISE" (JSON, or "free"), then a line per sample:
// tick, mode, standing still, x, y, psi, dpsi, dy, speed, distance, lean_norm, dx, parameter_version. SI units.
#include <cstdio>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/unit/db/db_support.hpp"

namespace {
using namespace hoist;

contract::TickRecord record_of(const std::string& line) {
  contract::TickRecord r;
  std::istringstream in(line);
  unsigned mode = 0, standing = 0;
  in >> r.tick >> mode >> standing >> r.x_m >> r.y_m >> r.psi_rad >> r.dpsi_rad >> r.dy_m >> r.speed_m_s >> r.distance_m >> r.lean_norm >>
      r.dx_m >> r.parameter_version;
  r.mode = static_cast<std::uint8_t>(mode);
  r.standing_still = static_cast<std::uint8_t>(standing);
  r.time_ns = db::test::kStart_ns + r.tick * 10'000'000;
  r.fused_x_m = r.x_m, r.fused_y_m = r.y_m, r.fused_psi_rad = r.psi_rad;
  return r;
}

bool store(db::SessionWriter& writer, const std::string& exercise, const std::vector<contract::TickRecord>& records) {
  db::SessionStart start = db::test::start_of_walk();
  std::vector<double> values;
  for (const contract::ParamInfo& info : contract::kParams) values.push_back(info.default_value);
  start.parameter_values = values;
  if (exercise != "free") start.exercise_json = exercise;
  return writer.begin(start).ok() && writer.append_ticks(records).ok() &&
         writer.end(db::CloseReason::finished, start.started_utc_ns + 1'000'000'000).ok();
}
}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 || argv[1][0] == '-') {
    std::fputs("usage: record_walks FILE: records walks from standard input into FILE\n", stderr);
    return 2;
  }
  auto database = db::Database::open(argv[1]);
  if (!database) return 1;
  auto writer = db::SessionWriter::create(*database);
  if (!writer) return 1;
  std::string exercise;
  std::vector<contract::TickRecord> records;
  const auto end = [&] { return exercise.empty() || store(*writer, exercise, records); };
  for (std::string line; std::getline(std::cin, line);) {
    if (!line.starts_with("walk ")) {
      records.push_back(record_of(line));
      continue;
    }
    if (!end()) return 1;
    exercise = line.substr(5);
    records.clear();
  }
  return end() ? 0 : 1;
}
