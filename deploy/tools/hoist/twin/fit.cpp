#include "deploy/tools/hoist/twin/fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "deploy/tools/hoist/twin/replay.hpp"
#include "firmware/sim/plant.hpp"
#include "firmware/sim/random.hpp"

namespace hoist::tool::twin {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using sim::PatientParams;
using sim::PatientRange;

/// A value to be found by replay. Without a field it is not of the patient, and is found beside the others only so that their spread counts it.
struct Unknown {
  std::string_view name, unit;
  double PatientParams::*field;
  PatientRange usual;
  double step;  ///< for the slope of the residuals; of the reaction time two of the patient's own steps, which it is rounded to
};

constexpr sim::PatientRanges kUsual = sim::kUsualPatients;
constexpr std::array kUnknowns{
    Unknown{"wish_m_s", "m/s", &PatientParams::wish_m_s, kUsual.wish_m_s, 0.005},
    Unknown{"speed_lead_m_s", "m/s", &PatientParams::speed_lead_m_s, kUsual.speed_lead_m_s, 0.002},
    Unknown{"compensation_norm", "", &PatientParams::compensation_norm, kUsual.compensation_norm, 0.01},
    Unknown{"drive_n_s_m",
            "N s/m",
            &PatientParams::drive_n_s_m,
            {kUsual.mass_kg.least * kUsual.drive_per_s.least, kUsual.mass_kg.most* kUsual.drive_per_s.most},
            5.0},
    Unknown{"mass_kg", "kg", &PatientParams::mass_kg, kUsual.mass_kg, 2.0},
    Unknown{"reaction_s", "s", &PatientParams::reaction_s, kUsual.reaction_s, 0.02},
    Unknown{"yaw_lag_s", "s", &PatientParams::yaw_lag_s, kUsual.yaw_lag_s, 0.01},
    Unknown{"foresight_s", "s", &PatientParams::foresight_s, kUsual.foresight_s, 0.02},
    Unknown{"look_ahead_m", "m", &PatientParams::look_ahead_m, kUsual.look_ahead_m, 0.01},
    Unknown{"reach_m", "m", &PatientParams::reach_m, kUsual.reach_m, 0.002},
    // What the struts show of an upright patient: what calibration leaves (assumed; simulated hoists: up to 2 mm and 0.1 degrees).
    Unknown{"upright_m", "m", nullptr, {-0.005, 0.005}, 0.001},
    Unknown{"upright_rad", "rad", nullptr, {-0.008, 0.008}, 0.002},
};
constexpr Eigen::Index kCount = kUnknowns.size(), kOfPatient = kCount - 2;
static_assert(kUnknowns[kOfPatient].name == "upright_m");
/// Comfort ends at this share of the reach (PatientParams::lean_for); one session hardly tells both.
constexpr double kComfortOfReach_norm = 0.745 / 1.17;

double middle(const PatientRange& range) { return 0.5 * (range.least + range.most); }
/// Of an even distribution.
double deviation(const PatientRange& range) { return (range.most - range.least) / std::sqrt(12.0); }
/// A fitted value may lie outside of the usual range by half of it, but stays above a tenth of its least value.
double bounded(const PatientRange& range, double value) {
  const double half = 0.5 * (range.most - range.least), least = range.least - half;
  return std::clamp(value, range.least > 0 ? std::max(least, 0.1 * range.least) : least, range.most + half);
}

// ---- Gait ----------------------------------------------------------------------------------------------------------------------------

std::vector<double> averaged(const std::vector<double>& x, std::size_t half) {
  std::vector<double> sum(x.size() + 1, 0.0), out(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) sum[i + 1] = sum[i] + x[i];
  for (std::size_t i = 0; i < x.size(); ++i) {
    const std::size_t reach = std::min({half, i, x.size() - 1 - i});
    out[i] = (sum[i + reach + 1] - sum[i - reach]) / static_cast<double>(2 * reach + 1);
  }
  return out;
}

/// Root mean square about the mean over a stride, while the hoist rolls.
double sway_rms(const LedSession& session, const std::vector<double>& x, std::size_t half) {
  constexpr double kFullGait_m_s = 0.15;
  const std::vector<double> middle = averaged(x, half);
  double squares = 0;
  std::size_t count = 0;
  for (std::size_t i = half; i + half < session.steps.size(); ++i) {
    if (session.steps[i].speed_m_s < kFullGait_m_s) continue;
    squares += (x[i] - middle[i]) * (x[i] - middle[i]);
    ++count;
  }
  return count == 0 ? 0.0 : std::sqrt(squares / static_cast<double>(count));
}

std::vector<double> column(const LedSession& session, double LedStep::*member) {
  std::vector<double> out;
  out.reserve(session.steps.size());
  for (const LedStep& step : session.steps) out.push_back(step.*member);
  return out;
}

/// Standard deviation of the mean of 30 to 120 strides whose variation is 1 (StrideSeries: 0.53 to 0.39).
constexpr double kMeanWanders_norm = 0.45;
/// More than this the warped phase would run backward.
constexpr double kMostLimp_norm = 1.0;

struct Gait {
  double stride_hz_spread = 0, limp_spread = 0;
  std::size_t half_stride = 0;  ///< steps
};

/// step_asymmetry_norm of a patient who limps like this: the time between the levels of the root mean square on both ways across. The warped
/// phase (firmware/sim/patient.cpp) is there at 45° from the extremes.
double asymmetry_of(double limp_norm) {
  constexpr double kPi = std::numbers::pi;
  const auto way = [](double warp) {
    double phase = kPi / 4.0;
    for (int round = 0; round < 30; ++round) phase = kPi / 4.0 - warp * std::cos(phase);
    return kPi - 2.0 * phase;
  };
  const double warp = kPi / 4.0 * limp_norm, to_right = way(warp), to_left = way(-warp);
  return 2.0 * (to_left - to_right) / (to_left + to_right);
}

double limp_of(double asymmetry_norm) {
  double least = -kMostLimp_norm, most = kMostLimp_norm;
  for (int round = 0; round < 40; ++round) {
    const double middle = 0.5 * (least + most);
    (asymmetry_of(middle) > asymmetry_norm ? least : most) = middle;  // falls as the limp grows
  }
  return 0.5 * (least + most);
}

// The stride's rate rises with the speed by a slope that is assumed; the rest of it is the patient's own.
Gait fit_gait(const LedSession& session, PatientParams& patient) {
  Gait gait;
  patient.stride_hz = 1.0 / session.stride_s - patient.stride_hz_per_m_s * session.mean_speed_m_s();
  // The error that the figure of cadence is held to on walks of known truth: a step a minute. Strides wander over hundreds of them
  // (firmware/sim/PATIENTS.md), so that the mean of a walk is off by a share of their variation that hardly falls with its length.
  gait.stride_hz_spread = std::hypot(1.0 / 120.0, kMeanWanders_norm * session.stride_cv_norm / session.stride_s);
  patient.limp_norm = session.asymmetry_norm ? limp_of(*session.asymmetry_norm) : 0.0;
  // Two points; and four times the standard error of a stride, because it compares two parts of the same one, which wander together. Without
  // enough strides: what people show.
  const double stride_norm = session.stride_cv_norm * std::sqrt(session.stride_s / session.led_s());
  gait.limp_spread = session.asymmetry_norm ? std::hypot(0.02, 4.0 * stride_norm) : 0.1;
  gait.half_stride = db::samples_in(session.stride_s / 2);
  return gait;
}

// The body gives way to its own sway, so the amplitudes are those whose replay sways as recorded.
void fit_sway(const LedSession& session, std::size_t half, PatientParams& patient) {
  const double forward_m = sway_rms(session, column(session, &LedStep::dx_m), half);
  const double lateral_m = sway_rms(session, column(session, &LedStep::dy_m), half);
  const double turn_rad = sway_rms(session, column(session, &LedStep::dpsi_rad), half);
  for (int round = 0; round < 2; ++round) {
    const Response now = replay(session, patient);
    const auto scaled = [&](double& amplitude, double recorded, double replayed) {
      if (replayed > 0) amplitude *= std::clamp(recorded / replayed, 0.2, 5.0);
    };
    scaled(patient.sway_forward_m, forward_m, sway_rms(session, now.dx_m, half));
    scaled(patient.sway_lateral_m, lateral_m, sway_rms(session, now.dy_m, half));
    scaled(patient.sway_yaw_rad, turn_rad, sway_rms(session, now.dpsi_rad, half));
  }
}

// ---- Lean and turn -------------------------------------------------------------------------------------------------------------------

/// Every tenth step counts: an average over a stride does not change within 0.1 s.
constexpr std::size_t kEvery = 10;
/// Block over which residuals are taken for related.
constexpr std::size_t kBlock = 50;
/// The linear spread is too narrow by this factor, measured on simulated patients of known values (hoist README): by more where the
/// strides are uneven, which the twin's are not, and leave more than this of the lean unexplained.
constexpr double kEvenWider_norm = 2.0, kUnevenWider_norm = 3.0, kUnevenLean_m = 0.002;
/// Not less than the sensors' own error, so that a perfect fit does not make the spread zero.
constexpr double kLeastLean_m = 0.0005, kLeastTurn_rad = 0.001;

struct Weights {
  double lean_m = 0.005, turn_rad = 0.01;
};

class Problem {
 public:
  Problem(LedSession session, const PatientParams& gait, std::size_t half_stride)
      : session_(std::move(session)),
        gait_(gait),
        half_(half_stride),
        lean_m_(smooth(column(session_, &LedStep::dx_m))),
        turn_rad_(smooth(column(session_, &LedStep::dpsi_rad))) {}

  Weights weights;

  [[nodiscard]] PatientParams patient(const VectorXd& values) const {
    PatientParams out = gait_;
    for (Eigen::Index k = 0; k < kOfPatient; ++k) out.*(kUnknowns[static_cast<std::size_t>(k)].field) = values[k];
    out.comfort_m = kComfortOfReach_norm * out.reach_m;
    return out;
  }
  /// Lean, then turn, each over its weight.
  [[nodiscard]] VectorXd residuals(const VectorXd& values) const {
    const Response now = replay(session_, patient(values));
    const std::vector<double> lean = smooth(now.dx_m), turn = smooth(now.dpsi_rad);
    VectorXd out(static_cast<Eigen::Index>(2 * lean.size()));
    for (std::size_t i = 0; i < lean.size(); ++i) {
      out[static_cast<Eigen::Index>(i)] = (lean[i] + values[kOfPatient] - lean_m_[i]) / weights.lean_m;
      out[static_cast<Eigen::Index>(i + lean.size())] = (turn[i] + values[kOfPatient + 1] - turn_rad_[i]) / weights.turn_rad;
    }
    return out;
  }
  /// Of the residuals `here` at these values, by one step of each value.
  [[nodiscard]] MatrixXd slopes(const VectorXd& values, const VectorXd& here) const {
    MatrixXd out(here.size(), kCount);
    for (Eigen::Index k = 0; k < kCount; ++k) {
      const double step = kUnknowns[static_cast<std::size_t>(k)].step;
      VectorXd above = values;
      above[k] += step;
      out.col(k) = (residuals(above) - here) / step;
    }
    return out;
  }

 private:
  // Twice over a stride: the rest of a sway whose period changes with the speed is second order.
  [[nodiscard]] std::vector<double> smooth(const std::vector<double>& x) const {
    const std::vector<double> once = averaged(x, half_), twice = averaged(once, half_);
    std::vector<double> out;
    for (std::size_t i = 0; i < twice.size(); i += kEvery) out.push_back(twice[i]);
    return out;
  }

  LedSession session_;
  PatientParams gait_;
  std::size_t half_;
  std::vector<double> lean_m_, turn_rad_;
};

VectorXd usual_values() {
  VectorXd out(kCount);
  for (Eigen::Index k = 0; k < kCount; ++k) out[k] = middle(kUnknowns[static_cast<std::size_t>(k)].usual);
  return out;
}
// What is known before the data: inverse variances.
VectorXd usual_weights() {
  VectorXd out(kCount);
  for (Eigen::Index k = 0; k < kCount; ++k) out[k] = 1.0 / std::pow(deviation(kUnknowns[static_cast<std::size_t>(k)].usual), 2);
  return out;
}
VectorXd inside(VectorXd values) {
  for (Eigen::Index k = 0; k < kCount; ++k) values[k] = bounded(kUnknowns[static_cast<std::size_t>(k)].usual, values[k]);
  return values;
}

struct Solution {
  VectorXd values = usual_values();
  double cost = std::numeric_limits<double>::infinity();
};

// `relation`: by how much related residuals say less than as many unrelated ones.
double cost_of(const VectorXd& residuals, const VectorXd& values, double relation) {
  return residuals.squaredNorm() / relation + (usual_weights().array() * (values - usual_values()).array().square()).sum();
}

Solution solve(const Problem& problem, Solution at, double relation, int rounds) {
  VectorXd residuals = problem.residuals(at.values);
  at.cost = cost_of(residuals, at.values, relation);
  double damping = 1e-2, raise = 2.0;
  const VectorXd known = usual_weights();
  for (int round = 0; round < rounds; ++round) {
    const MatrixXd slopes = problem.slopes(at.values, residuals);
    MatrixXd normal = slopes.transpose() * slopes / relation;
    normal += MatrixXd(known.asDiagonal());
    const VectorXd downhill =
        -(slopes.transpose() * residuals / relation + (known.array() * (at.values - usual_values()).array()).matrix());
    bool better = false;
    double gained = 0;
    for (int attempt = 0; attempt < 6 && !better; ++attempt) {
      MatrixXd damped = normal;
      damped.diagonal() *= 1.0 + damping;
      const VectorXd tried = inside(at.values + damped.ldlt().solve(downhill));
      const VectorXd there = problem.residuals(tried);
      const double cost = cost_of(there, tried, relation);
      better = cost < at.cost;
      if (better) {
        gained = (at.cost - cost) / at.cost;
        at = {tried, cost};
        residuals = there;
        damping = std::max(damping / 5.0, 1e-6), raise = 2.0;
      } else {
        damping *= raise, raise *= 2.0;
      }
    }
    if (!better || gained < 1e-3) break;
  }
  return at;
}

double root_mean_square(const VectorXd& x) { return std::sqrt(x.squaredNorm() / static_cast<double>(x.size())); }

// Variance of the sum over a block against that of unrelated residuals; at least 1.
double relation_of(const VectorXd& residuals) {
  const auto half = residuals.size() / 2;
  double sums = 0, squares = 0;
  for (Eigen::Index part = 0; part < 2; ++part) {
    for (Eigen::Index first = 0; first < half; first += kBlock) {
      const auto block = residuals.segment(part * half + first, std::min<Eigen::Index>(kBlock, half - first));
      sums += block.sum() * block.sum();
      squares += block.squaredNorm();
    }
  }
  return squares > 0 ? std::max(sums / squares, 1.0) : 1.0;
}

void add_values(const Problem& problem, const Solution& best, double relation, Fit& out) {
  const MatrixXd slopes = problem.slopes(best.values, problem.residuals(best.values));
  MatrixXd normal = slopes.transpose() * slopes / relation;
  normal += MatrixXd(usual_weights().asDiagonal());
  const double wider_norm = out.rms_lean_m > kUnevenLean_m ? kUnevenWider_norm : kEvenWider_norm;
  const MatrixXd covariance = wider_norm * wider_norm * normal.inverse();
  const VectorXd spread = covariance.diagonal().cwiseSqrt();
  for (Eigen::Index k = 0; k < kOfPatient; ++k) {
    const Unknown& unknown = kUnknowns[static_cast<std::size_t>(k)];
    FittedValue value{unknown.name, unknown.unit, best.values[k], spread[k], middle(unknown.usual), deviation(unknown.usual), {}, 0.0};
    std::vector<double> alike;
    for (Eigen::Index other = 0; other < kOfPatient; ++other) {
      const double correlation = covariance(k, other) / (spread[k] * spread[other]);
      alike.push_back(correlation);
      if (other == k || std::fabs(correlation) <= std::fabs(value.alike_norm)) continue;
      value.alike = kUnknowns[static_cast<std::size_t>(other)].name;
      value.alike_norm = correlation;
    }
    out.values.push_back(value);
    out.alike_norm.push_back(alike);
  }
}

// What is asked for of a patient, from the fitted values.
void add_derived(const LedSession& session, const Gait& gait, Fit& out) {
  const auto covariance = [&out](std::size_t a, std::size_t b) {
    return out.alike_norm[a][b] * out.values[a].spread * out.values[b].spread;
  };
  const auto at = [&out](std::string_view name) { return static_cast<std::size_t>(&out[name] - out.values.data()); };
  const std::size_t reaction = at("reaction_s"), lag = at("yaw_lag_s"), compensation = at("compensation_norm"),
                    foresight = at("foresight_s");
  const auto usual_of = [&out](std::size_t k) { return out.values[k].usual_spread; };
  out.derived.push_back({"delay_s", "s", out.patient.reaction_s + out.patient.yaw_lag_s,
                         std::sqrt(std::max(covariance(reaction, reaction) + covariance(lag, lag) + 2.0 * covariance(reaction, lag), 0.0)),
                         out.values[reaction].usual + out.values[lag].usual, std::hypot(usual_of(reaction), usual_of(lag)),
                         out.values[reaction].alike, 0.0});
  const double spring_n_m = sim::PlantParams{}.spring_n_m;
  out.derived.push_back({"stiffness_n_m", "N/m", (1.0 - out.patient.compensation_norm) * spring_n_m,
                         spring_n_m * out.values[compensation].spread, (1.0 - out.values[compensation].usual) * spring_n_m,
                         spring_n_m * usual_of(compensation), out.values[compensation].alike, out.values[compensation].alike_norm});
  const double speed_m_s = session.mean_speed_m_s();
  const double stride_hz = out.patient.stride_hz + out.patient.stride_hz_per_m_s * speed_m_s;
  out.derived.push_back({"cadence_steps_min",
                         "1/min",
                         120.0 * stride_hz,
                         120.0 * gait.stride_hz_spread,
                         120.0 * (middle(kUsual.stride_hz) + out.patient.stride_hz_per_m_s * speed_m_s),
                         120.0 * deviation(kUsual.stride_hz),
                         {},
                         0.0});
  out.derived.push_back({"asymmetry_norm", "", out.patient.limp_norm, gait.limp_spread, 0.0, 0.1, {}, 0.0});
  FittedValue lead = out.values[foresight];
  lead.name = "turning_lead_s";
  out.derived.push_back(lead);
}

}  // namespace

const FittedValue& Fit::operator[](std::string_view name) const {
  for (const std::vector<FittedValue>* list : {&values, &derived})
    for (const FittedValue& value : *list)
      if (value.name == name) return value;
  std::abort();
}

sim::PatientParams with_values(sim::PatientParams patient, const std::vector<double>& values) {
  for (std::size_t k = 0; k < kOfPatient && k < values.size(); ++k) patient.*(kUnknowns[k].field) = bounded(kUnknowns[k].usual, values[k]);
  patient.comfort_m = kComfortOfReach_norm * patient.reach_m;
  return patient;
}

std::vector<double> fitted_values(const sim::PatientParams& patient) {
  std::vector<double> out;
  for (const Unknown& unknown : std::span(kUnknowns).first(kOfPatient)) out.push_back(patient.*(unknown.field));
  return out;
}

Fit fit_patient(const LedSession& session, std::uint64_t seed) {
  // Starts search along the first lap or so only; the rest costs time and tells them apart no better.
  constexpr int kStarts = 4;
  constexpr std::size_t kBeginning = db::samples_in(60.0);
  Fit out;
  PatientParams patient;
  const Gait gait = fit_gait(session, patient);
  fit_sway(session, gait.half_stride, patient);
  LedSession beginning = session;
  if (beginning.steps.size() > kBeginning) beginning.steps.resize(kBeginning);
  const Problem rough(std::move(beginning), patient, gait.half_stride);
  Problem problem(session, patient, gait.half_stride);
  sim::Random random(seed ^ 0x5477696EULL);
  std::vector<Solution> ends;
  for (int start = 0; start < kStarts; ++start) {
    Solution from;
    if (start > 0)
      for (Eigen::Index k = 0; k < kCount; ++k) {
        const PatientRange& usual = kUnknowns[static_cast<std::size_t>(k)].usual;
        from.values[k] = random.uniform(usual.least, usual.most);
      }
    ends.push_back(solve(rough, from, 1.0, 8));
  }
  Solution best = solve(problem, *std::ranges::min_element(ends, {}, &Solution::cost), 1.0, 8);
  // Again with the weights that the residuals themselves show, and with their relation in time.
  double relation = 1.0;
  for (int round = 0; round < 2; ++round) {
    const VectorXd residuals = problem.residuals(best.values);
    const auto half = residuals.size() / 2;
    out.rms_lean_m = root_mean_square(residuals.head(half)) * problem.weights.lean_m;
    out.rms_turn_rad = root_mean_square(residuals.tail(half)) * problem.weights.turn_rad;
    problem.weights = {std::max(out.rms_lean_m, kLeastLean_m), std::max(out.rms_turn_rad, kLeastTurn_rad)};
    relation = relation_of(residuals);
    best = solve(problem, best, relation, 5);
  }
  out.patient = problem.patient(best.values);
  add_values(problem, best, relation, out);
  add_derived(session, gait, out);
  return out;
}

}  // namespace hoist::tool::twin
