#include "deploy/tools/hoist/twin/led_session.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "control/contract/exercises.hpp"
#include "control/contract/faults.hpp"
#include "control/core/types.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/session_reader.hpp"
#include "db/summary/session_metrics.hpp"

namespace hoist::tool::twin {

namespace {

using contract::Mode;

/// CiA 402: a status word of a drive in "operation enabled".
constexpr unsigned kStateMask = 0x6F, kOperationEnabled = 0x27;
/// The twin begins where its exercise begins.
constexpr double kStartMost_m = 0.3;

struct NoTwinInfo {
  std::string_view name, text;
};
// In the order of NoTwin.
constexpr std::array kNoTwin{
    NoTwinInfo{"not_led", "the patient did not lead"},
    NoTwinInfo{"led_again", "the patient led several times; record one walk for each session"},
    NoTwinInfo{"too_short", "the patient led for less than 30 s"},
    NoTwinInfo{"too_long", "the patient led for more than 15 minutes"},
    NoTwinInfo{"off_start", "the walk did not begin at the start of its exercise"},
    NoTwinInfo{"no_exercise", "no exercise was chosen"},
    NoTwinInfo{"other_exercise", "its exercise is not one of the simulator's: eight, square or straight in their usual sizes"},
    NoTwinInfo{"no_parameters", "its parameters were not recorded"},
    NoTwinInfo{"not_recorded", "a value that is needed was not recorded"},
    NoTwinInfo{"no_figure", ""},
};
static_assert(kNoTwin.size() == static_cast<std::size_t>(NoTwin::no_figure) + 1);

db::Error refused(NoTwin why, std::string_view text = {}) {
  const NoTwinInfo& info = kNoTwin[static_cast<std::size_t>(why)];
  return {db::ErrorKind::bad_value,
          "this session cannot bear a twin [" + std::string(info.name) + "]: " + std::string(text.empty() ? info.text : text), "session"};
}

struct Row {
  LedStep step;
  Mode mode = Mode::init;
};

// Keeps the walk that the patient led. An error when there is none or more than one.
db::Result<LedSession> cut(LedSession session, const std::vector<Row>& rows) {
  const auto led = [](const Row& row) { return row.mode == Mode::user && row.step.released; };
  const auto first = std::ranges::find_if(rows, led);
  if (first == rows.end()) return refused(NoTwin::not_led);
  const auto last = std::find_if(first, rows.end(), [&](const Row& row) { return !led(row); });
  if (std::any_of(last, rows.end(), led)) return refused(NoTwin::led_again);
  for (auto row = first; row != last; ++row) session.steps.push_back(row->step);
  if (session.led_s() < kLeastLed_s) return refused(NoTwin::too_short);
  if (session.led_s() > kMostLed_s) return refused(NoTwin::too_long);
  return session;
}

// C needs what the fit needs: one whole walk along its exercise from the mark, with turns in it. The rhythm needs its strides.
db::Result<LedSession> checked(LedSession session, const db::Figures& figures, double start_m) {
  const db::Figure &c = figure_of(figures, "C"), &stride_s = figure_of(figures, "stride_time_s");
  for (const db::Figure* needed : {&c, &stride_s})
    if (!needed->value) return refused(NoTwin::no_figure, db::no_figure_sentence(needed->why));
  const double length_m = sim::scenario_path(*session.scenario).length_m();
  if (std::min(start_m, length_m - start_m) > kStartMost_m) return refused(NoTwin::off_start);
  session.c = *c.value;
  session.stride_s = *stride_s.value;
  // Too few strides for their spread: as people show.
  session.stride_cv_norm = figure_of(figures, "stride_time_cv_norm").value.value_or(0.1);
  session.asymmetry_norm = figure_of(figures, "step_asymmetry_norm").value;
  return session;
}

Row row_of(const contract::TickRecord& r) {
  const auto enabled = [](std::uint16_t word) { return (word & kStateMask) == kOperationEnabled; };
  return {{static_cast<double>(r.fused_x_m), static_cast<double>(r.fused_y_m), static_cast<double>(r.fused_psi_rad),
           static_cast<double>(r.speed_m_s), static_cast<double>(r.fused_yaw_rate_rad_s), static_cast<double>(r.dx_m),
           static_cast<double>(r.dy_m), static_cast<double>(r.dpsi_rad), enabled(r.left_status_word) && enabled(r.right_status_word)},
          static_cast<Mode>(r.mode)};
}

constexpr std::array kColumns{"mode",          "left_status_word", "right_status_word",    "fused_x_m", "fused_y_m",
                              "fused_psi_rad", "speed_m_s",        "fused_yaw_rate_rad_s", "dx_m",      "dy_m",
                              "dpsi_rad"};

Row row_of(const db::Columns& columns, std::size_t i) {
  const auto at = [&](std::size_t column) { return columns.values[column][i]; };
  const auto enabled = [&](std::size_t column) { return (static_cast<unsigned>(at(column)) & kStateMask) == kOperationEnabled; };
  return {{at(3), at(4), at(5), at(6), at(7), at(8), at(9), at(10), enabled(1) && enabled(2)}, static_cast<Mode>(static_cast<int>(at(0)))};
}

// A gap of a few steps is bridged evenly; the comparison refuses longer ones.
void add_bridging(std::vector<Row>& rows, const Row& next, std::uint64_t missing) {
  if (rows.empty()) missing = 0;
  for (std::uint64_t k = 1; k <= missing; ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(missing + 1);
    const LedStep from = rows.back().step;
    Row row = rows.back();
    for (double LedStep::*member : {&LedStep::x_m, &LedStep::y_m, &LedStep::psi_rad, &LedStep::speed_m_s, &LedStep::yaw_rate_rad_s,
                                    &LedStep::dx_m, &LedStep::dy_m, &LedStep::dpsi_rad})
      row.step.*member = from.*member + share * (next.step.*member - from.*member);
    rows.push_back(row);
  }
  rows.push_back(next);
}

db::Result<std::vector<Row>> rows_of(const db::SessionReader& reader, db::SessionId session) {
  constexpr double kPiece_s = 360.0;
  const db::Result<db::Overview> whole = reader.overview(session, {}, 1);
  if (!whole) return whole.error();
  std::vector<Row> rows;
  if (whole->from_s.empty()) return rows;
  const std::vector<std::string> names(kColumns.begin(), kColumns.end());
  std::uint64_t before = 0;
  const double end_s = whole->to_s.back();
  for (double from_s = whole->from_s.front(); from_s <= end_s; from_s += kPiece_s) {
    const db::Result<db::Columns> columns = reader.read_columns(session, names, {from_s, from_s + kPiece_s});
    if (!columns) return columns.error();
    for (std::size_t i = 0; i < columns->tick.size(); ++i) {
      if (!rows.empty() && columns->tick[i] <= before) continue;  // at the border of two pieces
      const std::uint64_t missing = rows.empty() ? 0 : columns->tick[i] - before - 1;
      if (missing > db::samples_in(db::kMissingMost_s)) rows.clear();  // standby before a long gap says nothing of this walk
      add_bridging(rows, row_of(*columns, i), rows.empty() ? 0 : missing);
      before = columns->tick[i];
    }
  }
  return rows;
}

// The scenario that walks this exercise; null when the simulator's floor has no such line.
const sim::Scenario* scenario_of(const contract::Exercise& exercise) {
  for (const sim::Scenario& scenario : sim::kScenarios) {
    const contract::Exercise usual = contract::usual_exercise(scenario.figure);
    const bool plain = scenario.trip_after_s == 0.0 && !scenario.slippery && scenario.figure != sim::Figure::free;
    if (plain && scenario.figure == exercise.shape && !exercise.clockwise && std::fabs(usual.size_m - exercise.size_m) < 1e-6 &&
        std::fabs(usual.radius_m - exercise.radius_m) < 1e-6)
      return &scenario;
  }
  return nullptr;
}

db::Result<contract::Params> params_of(const db::SessionReader& reader, db::SessionId session) {
  const auto stored = reader.parameters(session);
  if (!stored) return stored.error();
  if (stored->empty()) return refused(NoTwin::no_parameters);
  contract::Params params;
  for (const auto& [name, value] : *stored)
    if (const auto index = contract::find_param(name); index && contract::check_param(*index, value) == contract::ParamCheck::ok)
      contract::set_param_unchecked(params, *index, value);
  return params;
}

}  // namespace

db::Result<LedSession> read_led_session(db::Database& database, db::SessionId session) {
  const db::SessionReader reader(database);
  const db::Result<db::SessionInfo> info = reader.get(session);
  if (!info) return info.error();
  if (!info->exercise_json) return refused(NoTwin::no_exercise);
  std::vector<db::ExerciseProblem> problems;
  const auto exercise = db::read_exercise(nlohmann::json::parse(*info->exercise_json, nullptr, false), db::ExerciseNames::stored, problems);
  LedSession out;
  out.simulated = info->simulated;
  out.scenario = exercise ? scenario_of(*exercise) : nullptr;
  if (out.scenario == nullptr) return refused(NoTwin::other_exercise);
  const db::Result<contract::Params> params = params_of(reader, session);
  if (!params) return params.error();
  out.params = *params;
  const db::Result<db::SessionMetrics> metrics = db::session_metrics(database, session);
  if (!metrics) return metrics.error();
  if (metrics->track != "fused") return refused(NoTwin::not_recorded);
  const db::Result<std::vector<Row>> rows = rows_of(reader, session);
  if (!rows) return rows.error();
  db::Result<LedSession> led = cut(std::move(out), *rows);
  return led ? checked(std::move(*led), metrics->figures, metrics->start_m) : led;
}

db::Result<LedSession> led_session_of(const std::vector<contract::TickRecord>& records, const sim::Scenario& scenario,
                                      const contract::Params& params) {
  std::vector<Row> rows;
  rows.reserve(records.size());
  for (const contract::TickRecord& record : records) rows.push_back(row_of(record));
  LedSession out;
  out.scenario = &scenario;
  out.params = params;
  const db::Analysis analysis = analysis_of(records, sim::scenario_path(scenario));
  db::Result<LedSession> led = cut(std::move(out), rows);
  return led ? checked(std::move(*led), db::figures_of(analysis), analysis.comparison.start_m) : led;
}

db::Analysis analysis_of(const std::vector<contract::TickRecord>& records, const contract::ReferencePath& path) {
  db::Analyser analyser(path);
  do {
    for (const contract::TickRecord& r : records)
      analyser.add({.tick = r.tick,
                    .mode = static_cast<Mode>(r.mode),
                    .standing_still = r.standing_still != 0,
                    .x_m = static_cast<double>(r.fused_x_m),
                    .y_m = static_cast<double>(r.fused_y_m),
                    .psi_rad = static_cast<double>(r.fused_psi_rad),
                    .dpsi_rad = static_cast<double>(r.dpsi_rad),
                    .dy_m = static_cast<double>(r.dy_m),
                    .speed_m_s = static_cast<double>(r.speed_m_s),
                    .lean_norm = static_cast<double>(r.lean_norm),
                    .dx_m = static_cast<double>(r.dx_m)});
  } while (analyser.again());
  return analyser.result();
}

const db::Figure& figure_of(const db::Figures& figures, std::string_view key) {
  for (std::size_t i = 0; i < db::kMetrics.size(); ++i)
    if (db::kMetrics[i].key == key) return figures[i];
  std::abort();
}

double LedSession::speed_rms_m_s() const {
  double squares = 0;
  std::size_t moving = 0;
  for (const LedStep& step : steps) {
    if (std::fabs(step.speed_m_s) < kStands_m_s) continue;
    squares += step.speed_m_s * step.speed_m_s;
    ++moving;
  }
  return moving == 0 ? 0.0 : std::sqrt(squares / static_cast<double>(moving));
}

double LedSession::mean_speed_m_s() const {
  double sum = 0;
  std::size_t count = 0;
  for (const LedStep& step : steps) {
    if (std::fabs(step.speed_m_s) <= db::kBout_m_s) continue;
    sum += std::fabs(step.speed_m_s);
    ++count;
  }
  return count == 0 ? 0.0 : sum / static_cast<double>(count);
}

}  // namespace hoist::tool::twin
