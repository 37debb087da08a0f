#include "tests/family/guards.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "control/core/monitor/fall.hpp"
#include "control/core/monitor/patient_hanging.hpp"
#include "control/core/monitor/tilt_implausible.hpp"
#include "control/core/state.hpp"

namespace hoist::family {

namespace {

using contract::ParamName;

constexpr double kDegree = sim::kDegree_rad, kMillimetre = 0.001;
// A second alarm within this time would be the same stop.
constexpr double kSameStop_s = 5.0;

using Monitor = std::variant<core::FallDetected, core::PatientHanging, core::TiltImplausible>;

Monitor monitor_of(std::string_view guard) {
  if (guard == "fall_detected") return core::FallDetected{};
  if (guard == "patient_hanging") return core::PatientHanging{};
  return core::TiltImplausible{};
}

// One guard with one value of one threshold, the others as shipped.
struct Shadow {
  std::size_t row, point;
  contract::Params params;
  Monitor monitor;
  bool alarm = false;

  void check(loop::ClosedLoop& loop) {
    const core::CoreState& state = loop.core();
    const bool moving = contract::kModes[static_cast<std::size_t>(state.mode)].moving != 0;
    const core::MonitorView view{.sensed = state.sensed,
                                 .health = state.health,
                                 .params = params,
                                 .mode = state.mode,
                                 .moving = moving,
                                 .powered = state.in_mode.powered,
                                 .latched = 0,
                                 .left_command_m_s = state.left_command_m_s,
                                 .right_command_m_s = state.right_command_m_s,
                                 .left_control = state.left_control,
                                 .right_control = state.right_control,
                                 .bus_up = true,
                                 .bus_settled = true,
                                 .server_alive = true,
                                 .server_seen = true,
                                 .console_gone = false,
                                 .remote_lost = false,
                                 .held_back = state.mode == contract::Mode::guided && state.guided.held_back(),
                                 .relay_cut = false,
                                 .bumpers_acknowledged = 0,
                                 .wake_lateness_s = 0,
                                 .ticks = state.ticks_run,
                                 .dt_s = core::kTick_s};
    alarm = std::visit([&view](auto& one) { return one.check(view); }, monitor);
  }
};

std::vector<Shadow> shadows(const contract::Params& shipped) {
  std::vector<Shadow> all;
  const std::vector<GuardRow>& rows = guard_rows();
  for (std::size_t row = 0; row < rows.size(); ++row) {
    for (std::size_t point = 0; point < rows[row].values.size(); ++point) {
      contract::Params params = shipped;
      contract::set_param_unchecked(params, contract::param_index(rows[row].param), rows[row].values[point] * rows[row].unit);
      all.push_back({row, point, params, monitor_of(rows[row].guard)});
    }
  }
  return all;
}

bool judged_by(const GuardRow& row, FallKind kind) {
  if (row.guard == "tilt_implausible") return false;
  return row.fall == (kind != FallKind::faint_down);
}

}  // namespace

const std::vector<GuardRow>& guard_rows() {
  static const std::vector<GuardRow> kRows{
      {"fall_detected", ParamName::fall_tilt_rad, "lean of a quick fall", kDegree, "deg", {7, 8, 9, 10, 10.5, 11, 11.5, 12, 12.5}, true},
      {"fall_detected", ParamName::fall_rate_rad_s, "outward rate", kDegree, "deg/s", {12, 15, 20, 25, 30, 35, 40, 50}, true},
      {"fall_detected", ParamName::fall_static_tilt_rad, "lasting lean", kDegree, "deg", {10.5, 11, 12, 12.5, 13, 13.5, 14, 14.5}, true},
      {"fall_detected", ParamName::fall_static_s, "time of lasting lean", 1.0, "s", {0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 1.0, 2.0}, true},
      {"patient_hanging", ParamName::hang_tilt_rad, "lean", kDegree, "deg", {7, 8, 9, 10, 11, 12, 13, 14}, false},
      {"patient_hanging", ParamName::hang_tilt_s, "time of lean", 1.0, "s", {0.5, 1.0, 1.5, 2.0, 2.5, 3.0}, false},
      {"patient_hanging", ParamName::hang_still_s, "time without a step", 1.0, "s", {1.5, 2.0, 2.5, 3.0, 3.5, 4.0}, false},
      {"patient_hanging", ParamName::hang_sway_m, "sway of a step", kMillimetre, "mm", {2, 3, 4, 6, 8, 10, 12, 16, 20}, false},
      {"patient_hanging", ParamName::hang_speed_m_s, "speed", 1.0, "m/s", {0.05, 0.08, 0.1, 0.12, 0.15, 0.2}, false},
      {"tilt_implausible", ParamName::strut_apart_rad_max, "struts apart", kDegree, "deg", {2, 2.5, 3, 4, 5, 6, 8}, false},
      {"tilt_implausible", ParamName::tilt_rad_max, "angle", kDegree, "deg", {15, 16, 17, 18, 18.5, 19, 20}, false},
      {"tilt_implausible", ParamName::strut_twist_rad_max, "twist", kDegree, "deg", {15, 18, 20, 22, 25, 30}, false},
  };
  return kRows;
}

std::vector<GuardCurve> empty_curves() {
  std::vector<GuardCurve> curves;
  for (const GuardRow& row : guard_rows()) {
    GuardCurve curve;
    for (const double value : row.values) curve.push_back({.value = value});
    curves.push_back(std::move(curve));
  }
  return curves;
}

contract::Params lax_guards() {
  contract::Params params;
  for (const ParamName name :
       {ParamName::fall_tilt_rad, ParamName::fall_rate_rad_s, ParamName::fall_static_tilt_rad, ParamName::fall_static_s,
        ParamName::hang_tilt_rad, ParamName::hang_tilt_s, ParamName::hang_speed_m_s, ParamName::hang_still_s,
        ParamName::strut_apart_rad_max, ParamName::tilt_rad_max, ParamName::strut_twist_rad_max})
    contract::set_param_unchecked(params, contract::param_index(name), contract::kParams[contract::param_index(name)].max);
  const std::size_t sway = contract::param_index(ParamName::hang_sway_m);
  contract::set_param_unchecked(params, sway, contract::kParams[sway].min);
  return params;
}

void watch_walk(const WalkOptions& options, std::vector<GuardCurve>& curves) {
  std::vector<Shadow> guards = shadows(contract::Params{});
  std::vector<double> last_s(guards.size(), -kSameStop_s);
  double now_s = 0.0;
  WalkOptions mine = options;
  mine.params = lax_guards();
  const WalkTally tally = walk(mine, [&](Walk& one) {
    now_s += core::kTick_s;
    const bool excused = contract::led_by_hand(options.mode) && one.froze_lately();
    for (std::size_t i = 0; i < guards.size(); ++i) {
      guards[i].check(one.loop());
      if (!guards[i].alarm) continue;
      if (now_s - last_s[i] > kSameStop_s && !excused) ++curves[guards[i].row][guards[i].point].false_stops;
      last_s[i] = now_s;
    }
  });
  for (GuardCurve& curve : curves)
    for (GuardPoint& point : curve) point.hours += tally.rolling_s / 3600.0;
}

void watch_fall(const WalkOptions& options, FallKind kind, std::vector<GuardCurve>& curves) {
  std::vector<Shadow> guards = shadows(contract::Params{});
  struct Found {
    double since_s = -1, lean_rad = 0;
  };
  std::vector<Found> found(guards.size());
  WalkOptions mine = options;
  mine.params = lax_guards();
  const FallResult result = fall(mine, kind, [&](Walk& one, double since_s) {
    TrueLean body;
    body.see(one.loop().world().patient().harness(), core::kTick_s);
    for (std::size_t i = 0; i < guards.size(); ++i) {
      guards[i].check(one.loop());
      if (guards[i].alarm && found[i].since_s < 0) found[i] = {since_s, body.lean_rad()};
    }
  });
  if (result.owed_from_s < 0) return;
  for (std::size_t i = 0; i < guards.size(); ++i) {
    if (!judged_by(guard_rows()[guards[i].row], kind)) continue;
    GuardPoint& point = curves[guards[i].row][guards[i].point];
    ++point.falls;
    if (found[i].since_s < 0) continue;
    if (found[i].since_s <= result.owed_by_s) ++point.in_time;
    point.worst_lean_rad = std::max(point.worst_lean_rad, found[i].lean_rad);
    point.worst_after_s = std::max(point.worst_after_s, found[i].since_s);
  }
}

}  // namespace hoist::family
