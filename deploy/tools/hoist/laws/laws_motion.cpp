// Kinematics (1)-(3), the two controllers, wheels, odometry, and the chain of all of them.
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "control/core/law/differential_drive.hpp"
#include "control/core/law/odometry.hpp"
#include "control/core/law/pelvis.hpp"
#include "control/core/law/pfp.hpp"
#include "control/core/law/pfp_turn.hpp"
#include "deploy/tools/hoist/laws/law_list.hpp"

namespace hoist::tool {

using nlohmann::json;

namespace {

constexpr double kRightAngle_rad = std::numbers::pi / 2.0;
/// Beyond a right angle a strut has no harness displacement.
constexpr Range kTilt{.low = -kRightAngle_rad, .high = kRightAngle_rad, .low_open = true, .high_open = true};
constexpr double kStopAngle_rad = 15.0 * std::numbers::pi / 180.0;
/// The paper's step (page 2).
constexpr double kPaperStep_s = 0.01;

law::StrutAngles<double> read_struts(Fields& in) {
  return {in.number("al", kTilt), in.number("ar", kTilt), in.number("bl", kTilt), in.number("br", kTilt)};
}

law::PelvisGeometry<double> read_geometry(Fields& in) { return {in.number("d", kPositive), in.number("ds", kPositive)}; }

json write(const law::Pelvis<double>& pelvis) {
  return {{"dx", number_out(pelvis.dx_m)}, {"dy", number_out(pelvis.dy_m)}, {"dpsi", number_out(pelvis.dpsi_rad)}};
}

json kin_exact(Fields& in, Fields&) {
  const auto struts = read_struts(in);
  return write(law::pelvis_exact(struts, read_geometry(in)));
}

json kin_small(Fields& in, Fields&) {
  const auto struts = read_struts(in);
  return write(law::pelvis_small_angle(struts, read_geometry(in)));
}

json normalise(Fields& in, Fields&) {
  const law::Pelvis<double> pelvis{in.number("dx"), 0.0, in.number("dpsi")};
  const law::PelvisRange<double> range{in.number("dx_max", kPositive), in.number("dpsi_max", kPositive)};
  const law::PelvisNeutral<double> neutral{in.number("dx0"), in.number("dpsi0")};
  const auto intent = law::normalise(pelvis, range, neutral);
  if (!intent.valid) throw Refusal("dx, dpsi: too far from the range to be computed");
  return {{"u", intent.u_norm}, {"u_psi", intent.u_psi_norm}};
}

json full_range(Fields& in, Fields&) {
  const auto geometry = read_geometry(in);
  const Range below_right_angle{.low = 0.0, .high = kRightAngle_rad, .low_open = true, .high_open = true};
  const auto range = law::full_range(geometry, in.number("lim", below_right_angle));
  return {{"dx_max", number_out(range.dx_max_m)}, {"dpsi_max", number_out(range.dpsi_max_rad)}};
}

constexpr Range kDeadband{.low = 0.0, .high = 1.0, .high_open = true};

struct TransParams {
  law::PfpConfig<double> config;
  double dt_s{};
};

TransParams read_trans(Fields& params) {
  TransParams out;
  auto& config = out.config;
  config.deadband_norm = params.number_or("D", config.deadband_norm, kDeadband);
  config.tau_n_s = params.number_or("tau_n", config.tau_n_s, kPositive);
  config.tau_dec_s = params.number_or("tau_dec", config.tau_dec_s, kPositive);
  config.l_dec = params.number_or("L_dec", config.l_dec, kPositive);
  config.k_2r = params.number_or("K2r", config.k_2r, kNotNegative);
  config.k_p = params.number_or("KP", config.k_p, kNotNegative);
  config.k_pf = params.number_or("KPf", config.k_pf, kNotNegative);
  // The paper gives no number for this one: null or "inf" is "no limit".
  if (const json* limit = params.raw("vf_max"); limit != nullptr && limit->is_null()) {
    config.v_f_max_units = HUGE_VAL;
  } else {
    config.v_f_max_units = params.number_or("vf_max", config.v_f_max_units, {.low = 0.0, .infinite_ok = true});
  }
  config.brake_at_least_as_released = params.flag_or("brake_at_least_as_released", config.brake_at_least_as_released);
  out.dt_s = params.number_or("dT", kPaperStep_s, kPositive);
  return out;
}

const char* branch_name(law::PfpBranch branch) {
  switch (branch) {
    case law::PfpBranch::kDeadband:
      return "deadband";
    case law::PfpBranch::kReversal:
      return "reversal";
    case law::PfpBranch::kNormal:
      return "normal";
    case law::PfpBranch::kRefused:
      break;
  }
  // Only numbers whose product overflows reach this; other errors were checked before.
  throw Refusal("v, vf: too large to be computed");
}

json trans_step(Fields& in, Fields& params) {
  const auto [config, dt_s] = read_trans(params);
  const double u_norm = in.number("u", kUnit);
  law::PfpState<double> state{in.number("v"), in.number("vf")};
  const auto branch = law::pfp_step(config, state, u_norm, dt_s);
  return {{"v", number_out(state.v_units)}, {"vf", number_out(state.v_f_units)}, {"mode", branch_name(branch)}};
}

json trans_seq(Fields& in, Fields& params) {
  const auto [config, dt_s] = read_trans(params);
  const auto u_norm = in.numbers("u", kUnit);
  law::PfpState<double> state;
  json v = json::array();
  json v_f = json::array();
  std::string modes;
  for (const double u : u_norm) {
    modes += branch_name(law::pfp_step(config, state, u, dt_s))[0];
    v.push_back(number_out(state.v_units));
    v_f.push_back(number_out(state.v_f_units));
  }
  return {{"v", std::move(v)}, {"vf", std::move(v_f)}, {"mode", modes}};
}

struct TurnParams {
  law::PfpTurnConfig<double> config;
  double dt_s{};
};

TurnParams read_turn(Fields& params) {
  TurnParams out;
  auto& config = out.config;
  config.deadband_norm = params.number_or("D", config.deadband_norm, kDeadband);
  config.tau_n_s = params.number_or("tau_n", config.tau_n_s, kPositive);
  config.tau_dec_s = params.number_or("tau_dec", config.tau_dec_s, kPositive);
  config.k_p = params.number_or("KP", config.k_p, kNotNegative);
  config.k_pf = params.number_or("KPf", config.k_pf, kNotNegative);
  const bool discard = params.flag_or("discard_input_in_deadband", false);
  config.deadband = discard ? law::TurnDeadband::kDiscardInput : law::TurnDeadband::kLiteral;
  out.dt_s = params.number_or("dT", kPaperStep_s, kPositive);
  return out;
}

void turn(const law::PfpTurnConfig<double>& config, law::PfpTurnState<double>& state, double u_norm, double dt_s) {
  if (law::pfp_turn_step(config, state, u_norm, dt_s) == law::PfpTurnBranch::kRefused) throw Refusal("w, wf: too large to be computed");
}

json rot_step(Fields& in, Fields& params) {
  const auto [config, dt_s] = read_turn(params);
  const double u_norm = in.number("u", kUnit);
  law::PfpTurnState<double> state{in.number("w"), in.number("wf")};
  turn(config, state, u_norm, dt_s);
  return {{"w", number_out(state.omega_units)}, {"wf", number_out(state.omega_f_units)}};
}

json rot_seq(Fields& in, Fields& params) {
  const auto [config, dt_s] = read_turn(params);
  const auto u_norm = in.numbers("u", kUnit);
  law::PfpTurnState<double> state;
  json w = json::array();
  json w_f = json::array();
  for (const double u : u_norm) {
    turn(config, state, u, dt_s);
    w.push_back(number_out(state.omega_units));
    w_f.push_back(number_out(state.omega_f_units));
  }
  return {{"w", std::move(w)}, {"wf", std::move(w_f)}};
}

json tau_brake(Fields& in, Fields&) {
  const double u_norm = in.number("u", kUnit);
  const double deadband_norm = in.number("D", kDeadband);
  const double l_dec = in.number("L_dec", kPositive);
  return {{"tau", number_out(law::tau_brake_s(u_norm, deadband_norm, l_dec, in.number("dT", kPositive)))}};
}

json wheels(Fields& in, Fields&) {
  const double v_units = in.number("v");
  const double omega_units = in.number("w");
  const double track_m = in.number("d_ww", kPositive);
  const law::SpeedScale<double> scale{in.number("s_v", kPositive), in.number("s_w", kPositive)};
  const auto out = law::wheel_speeds(law::platform_speed(v_units, omega_units, scale), track_m);
  return {{"left", number_out(out.left_m_s)}, {"right", number_out(out.right_m_s)}};
}

law::OdometryConfig<double> read_odometry(Fields& in, Fields& params) {
  const double metre_per_count = in.number("Kpm", kPositive);
  law::OdometryConfig<double> config{metre_per_count, metre_per_count, in.number("dww", kPositive)};
  const std::string method = params.text_or("method", "euler");
  if (method == "euler") {
    config.method = law::OdometryMethod::kEuler;
  } else if (method == "midpoint") {
    config.method = law::OdometryMethod::kMidpoint;
  } else if (method == "exact_arc") {
    config.method = law::OdometryMethod::kExactArc;
  } else {
    throw Refusal("method: \"" + method + "\", must be euler, midpoint or exact_arc");
  }
  return config;
}

json odometry(const law::OdometryConfig<double>& config, law::Pose<double> pose, const std::vector<std::int32_t>& left,
              const std::vector<std::int32_t>& right) {
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (!law::odometry_step(config, pose, left[i], right[i])) throw Refusal("Kpm, dww: the pose is too large to be computed");
  }
  return {{"px", pose.x_m}, {"py", pose.y_m}, {"pphi", pose.psi_rad}};
}

json odo_step(Fields& in, Fields& params) {
  const auto config = read_odometry(in, params);
  const law::Pose<double> pose{in.number("px"), in.number("py"), in.number("pphi")};
  return odometry(config, pose, {in.integer("dEL")}, {in.integer("dER")});
}

json odo_seq(Fields& in, Fields& params) {
  const auto config = read_odometry(in, params);
  const auto left = in.integers("dEL");
  const auto right = in.integers("dER");
  same_length("dER", right.size(), "dEL", left.size());
  return odometry(config, {}, left, right);
}

json delta32(Fields& in, Fields&) {
  const auto now = in.integer("now");
  return {{"delta", law::delta32(now, in.integer("before"))}};
}

/// The steps that are reported: the first, then every 25th (a quarter of a second), unless the line names its own.
std::vector<std::size_t> reported_steps(Fields& in, std::size_t count) {
  constexpr std::size_t kEvery = 25;
  std::vector<std::size_t> steps;
  if (in.has("k")) {
    for (const auto k : in.integers("k")) {
      if (k < 0 || static_cast<std::size_t>(k) >= count) throw Refusal("k: " + std::to_string(k) + ", must be an index of al");
      steps.push_back(static_cast<std::size_t>(k));
    }
    return steps;
  }
  if (count > 0) steps.push_back(0);
  for (std::size_t k = kEvery - 1; k < count; k += kEvery) steps.push_back(k);
  return steps;
}

json pipeline(Fields& in, Fields& params) {
  const auto al = in.numbers("al", kTilt);
  const auto ar = in.numbers("ar", kTilt);
  const auto ab = in.numbers("ab", kTilt);
  const auto bl = in.numbers("bl", kTilt);
  const auto br = in.numbers("br", kTilt);
  const auto bb = in.numbers("bb", kTilt);
  const std::size_t count = al.size();
  same_length("ar", ar.size(), "al", count);
  same_length("ab", ab.size(), "al", count);
  same_length("bl", bl.size(), "al", count);
  same_length("br", br.size(), "al", count);
  same_length("bb", bb.size(), "al", count);
  const auto geometry = read_geometry(in);
  const double track_m = in.number("d_ww", kPositive);
  const law::SpeedScale<double> paper_scale;
  const law::SpeedScale<double> scale{in.number_or("s_v", paper_scale.v_m_s_per_unit, kPositive),
                                      in.number_or("s_w", paper_scale.omega_rad_s_per_unit, kPositive)};
  const auto steps = reported_steps(in, count);
  const auto trans = read_trans(params);
  law::PfpTurnConfig<double> turn_config;
  turn_config.deadband = law::TurnDeadband::kLiteral;
  const auto range = law::full_range(geometry, kStopAngle_rad);

  law::PfpState<double> v_state;
  law::PfpTurnState<double> w_state;
  std::array<json, 9> column;
  column.fill(json::array());
  std::vector<std::array<double, 9>> history;
  history.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    // Relative angle: strut minus chassis.
    const auto pelvis = law::pelvis_exact<double>({al[i] - ab[i], ar[i] - ab[i], bl[i] - bb[i], br[i] - bb[i]}, geometry);
    const auto intent = law::normalise(pelvis, range, {});
    if (!intent.valid) throw Refusal("al, ar, ab: element " + std::to_string(i) + " gives no usable displacement");
    static_cast<void>(branch_name(law::pfp_step(trans.config, v_state, intent.u_norm, trans.dt_s)));
    turn(turn_config, w_state, intent.u_psi_norm, trans.dt_s);
    const auto wheel = law::wheel_speeds(law::platform_speed(v_state.v_units, w_state.omega_units, scale), track_m);
    history.push_back({pelvis.dx_m, pelvis.dy_m, pelvis.dpsi_rad, intent.u_norm, intent.u_psi_norm, v_state.v_units, w_state.omega_units,
                       wheel.left_m_s, wheel.right_m_s});
  }
  for (const auto k : steps) {
    for (std::size_t c = 0; c < column.size(); ++c) column[c].push_back(number_out(history[k][c]));
  }
  constexpr std::array kNames = {"dx", "dy", "dpsi", "u", "u_psi", "v", "w", "left", "right"};
  json out = {{"k", steps}};
  for (std::size_t c = 0; c < column.size(); ++c) out[kNames[c]] = std::move(column[c]);
  return out;
}

constexpr std::string_view kStrutInputs = "al, ar, bl, br: strut angles relative to the chassis, rad; d, ds: m";
constexpr std::string_view kTransParameters =
    "D 0.05, tau_n 10, tau_dec 2, L_dec 2, K2r 1e-4, KP 2, KPf 50, vf_max 50 (null: none), dT 0.01, brake_at_least_as_released false";
constexpr std::string_view kTurnParameters = "D 0.05, tau_n 2, tau_dec 0.1, KP 2, KPf 50, dT 0.01, discard_input_in_deadband false";
constexpr std::string_view kOdometryParameters = "method euler (or midpoint, exact_arc)";

constexpr std::array kLaws = {
    Law{"kin_exact", "harness displacement from the strut angles, equations (1)-(3)", kStrutInputs, "", "dx, dy m; dpsi rad", &kin_exact},
    Law{"kin_small", "the small-angle forms of (1)-(3)", kStrutInputs, "", "dx, dy m; dpsi rad", &kin_small},
    Law{"normalise", "displacement to a wish in [-1, 1]", "dx m, dpsi rad, dx_max, dpsi_max: full range, dx0, dpsi0: neutral", "",
        "u, u_psi", &normalise},
    Law{"full_range", "displacement at a limit of the struts' tilt", "d, ds m; lim rad", "", "dx_max m, dpsi_max rad", &full_range},
    Law{"trans_step", "one step of Algorithm 1, equations (4)-(7)", "u in [-1, 1]; v, vf before the step", kTransParameters,
        "v, vf; mode deadband, reversal or normal", &trans_step},
    Law{"trans_seq", "Algorithm 1 from rest", "u: array", kTransParameters, "v, vf: arrays; mode: a letter per step", &trans_seq},
    Law{"rot_step", "one step of Algorithm 2", "u in [-1, 1]; w, wf before the step", kTurnParameters, "w, wf", &rot_step},
    Law{"rot_seq", "Algorithm 2 from rest", "u: array", kTurnParameters, "w, wf: arrays", &rot_seq},
    Law{"tau_brake", "time constant while reversing, second row of (6), Fig. 2", "u, D, L_dec, dT", "",
        "tau s (\"inf\" on the edge, null inside the dead-band)", &tau_brake},
    Law{"wheels", "wheel speeds from the controllers' outputs", "v, w units; d_ww m; s_v m/s, s_w rad/s per unit", "", "left, right m/s",
        &wheels},
    Law{"odo_step", "one step of odometry, equations (19)-(23)", "px, py m, pphi rad; dEL, dER counts; Kpm m/count; dww m",
        kOdometryParameters, "px, py, pphi (not wrapped)", &odo_step},
    Law{"odo_seq", "odometry from the origin", "dEL, dER: arrays of counts; Kpm m/count; dww m", kOdometryParameters,
        "px, py, pphi at the end", &odo_seq},
    Law{"delta32", "difference of a 32-bit counter across its wrap", "now, before", "", "delta", &delta32},
    Law{"pipeline", "tilt angles to wheel speeds: everything above in a chain, ranges at 15 deg",
        "al, ar, ab, bl, br, bb: arrays, rad (left, right, base); d, ds, d_ww m; s_v, s_w and k (steps to report) may be given",
        kTransParameters, "k; dx, dy, dpsi, u, u_psi, v, w, left, right at the steps k", &pipeline},
};

}  // namespace

std::span<const Law> motion_laws() { return kLaws; }

}  // namespace hoist::tool
