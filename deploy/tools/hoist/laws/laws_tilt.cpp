// The tilt sensors: angles from gravity, the filter, its gain.
#include <array>
#include <nlohmann/json.hpp>

#include "control/core/law/kalman_gain.hpp"
#include "control/core/law/tilt_kalman.hpp"
#include "deploy/tools/hoist/laws/law_list.hpp"

namespace hoist::tool {

using nlohmann::json;

namespace {

json acc_angles(Fields& in, Fields&) {
  const double ax = in.number("ax");
  const double ay = in.number("ay");
  const auto angles = law::acc_angles(ax, ay, in.number("az"));
  if (!angles.valid) throw Refusal("ax, ay, az: all zero, which has no direction");
  return {{"alpha", angles.alpha_rad}, {"beta", angles.beta_rad}};
}

json kalman_gain(Fields& in, Fields&) {
  const auto variance = in.numbers("V", kNotNegative);
  const auto start = in.has("P0") ? in.numbers("P0", kNotNegative) : std::vector<double>{1.0, 1.0};
  if (variance.size() != 2 || !(variance[1] > 0.0)) throw Refusal("V: must be [angle >= 0, bias > 0]");
  if (start.size() != 2) throw Refusal("P0: must be [angle >= 0, bias >= 0]");
  const law::KalmanGainProblem<double> problem{variance[0], variance[1], in.number("N", kPositive), in.number("dt", kPositive),
                                               start[0],    start[1]};
  const auto solution = law::solve_kalman_gain(problem);
  if (!solution.converged) throw Refusal("V, N, dt: the iteration found no standing gain");
  return {{"K1", solution.k_angle}, {"K2", solution.k_bias}};
}

json tilt_seq(Fields& in, Fields&) {
  const auto rate_rad_s = in.numbers("rate");
  const auto angle_rad = in.numbers("phi_s");
  same_length("phi_s", angle_rad.size(), "rate", rate_rad_s.size());
  if (rate_rad_s.empty()) throw Refusal("rate: must have at least one element");
  const law::TiltGain<double> printed;
  const law::TiltGain<double> gain{in.number_or("K1", printed.k_angle), in.number_or("K2", printed.k_bias)};
  const double dt_s = in.number("dt", kPositive);
  auto state = law::tilt_start(in.number("phi0"), in.number("b0"), rate_rad_s.front());
  json phi = {state.angle_rad};
  json bias = {state.bias_rad_s};
  for (std::size_t k = 1; k < rate_rad_s.size(); ++k) {
    if (!law::tilt_step(gain, state, rate_rad_s[k], angle_rad[k], dt_s)) throw Refusal("rate, phi_s: too large to be computed");
    phi.push_back(state.angle_rad);
    bias.push_back(state.bias_rad_s);
  }
  return {{"phi", std::move(phi)}, {"b", std::move(bias)}};
}

constexpr std::array kLaws = {
    Law{"acc_angles", "tilt from gravity, equations (17)-(18) with z up", "ax, ay, az: specific force in the sensor, m/s^2", "",
        "alpha, beta rad", &acc_angles},
    Law{"kalman_gain", "static gain of one axis, the three steps under (12)", "V: [angle, bias], N, dt, P0: [angle, bias]", "",
        "K1, K2 (the truth about (13), not the printed (14))", &kalman_gain},
    Law{"tilt_seq", "the tilt filter, equations (15)-(16), one axis", "rate: array rad/s, phi_s: array rad, phi0, b0, K1, K2, dt", "",
        "phi, b: arrays, element 0 is the start", &tilt_seq},
};

}  // namespace

std::span<const Law> tilt_laws() { return kLaws; }

}  // namespace hoist::tool
