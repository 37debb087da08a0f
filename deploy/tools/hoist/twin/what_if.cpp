#include "deploy/tools/hoist/twin/what_if.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "deploy/tools/hoist/study/virtual_run.hpp"
#include "deploy/tools/hoist/twin/led_session.hpp"
#include "firmware/sim/random.hpp"

namespace hoist::tool::twin {

namespace {

/// As in the paper's protocol: twice along the line; an open line once.
constexpr double kLaps = 2.0, kOnce = 0.98;

Spread spread_of(const std::vector<double>& values) {
  Spread out;
  out.walks = static_cast<int>(values.size());
  if (values.empty()) return out;
  for (const double value : values) out.mean += value / out.walks;
  double squares = 0;
  for (const double value : values) squares += (value - out.mean) * (value - out.mean);
  out.spread = out.walks > 1 ? std::sqrt(squares / (out.walks - 1)) : 0.0;
  return out;
}

}  // namespace

Outcome outcome_of(const std::vector<contract::TickRecord>& records, const contract::ReferencePath& path) {
  const db::Figures figures = db::figures_of(analysis_of(records, path));
  Outcome out{};
  for (std::size_t i = 0; i < kFiguresTold; ++i) out[i] = figure_of(figures, kTold[i].name).value;
  double squares = 0, lean = 0, turn = 0, stop_m = 0;
  std::size_t moving = 0;
  for (const contract::TickRecord& r : records) {
    if (static_cast<contract::Mode>(r.mode) != contract::Mode::user || std::fabs(static_cast<double>(r.speed_m_s)) < kStands_m_s) continue;
    ++moving;
    squares += static_cast<double>(r.speed_m_s) * static_cast<double>(r.speed_m_s);
    lean += std::fabs(static_cast<double>(r.lean_norm));
    turn += std::fabs(static_cast<double>(r.turn_norm));
    stop_m = std::max(stop_m, static_cast<double>(r.stop_distance_m));
  }
  if (moving == 0) return out;
  const auto count = static_cast<double>(moving);
  out[static_cast<std::size_t>(Told::speed_rms_m_s)] = std::sqrt(squares / count);
  out[static_cast<std::size_t>(Told::lean_mean_norm)] = lean / count;
  out[static_cast<std::size_t>(Told::turn_mean_norm)] = turn / count;
  out[static_cast<std::size_t>(Told::stop_m)] = stop_m;
  return out;
}

WalkOutcome walk_twin(const sim::PatientParams& walker, const sim::Scenario& scenario, const contract::Params& params, std::uint64_t seed) {
  loop::ClosedLoopOptions options;
  options.world.seed = seed;
  options.world.patient = walker;
  options.world.scenario = &scenario;
  options.params = params;
  const contract::ReferencePath path = sim::scenario_path(scenario);
  const study::VirtualRun run = study::walk_led(options, path.closed() ? kLaps : kOnce);
  WalkOutcome out;
  out.unfinished = run.unfinished;
  if (run.unfinished.empty()) out.told = outcome_of(run.records, path);
  return out;
}

Spread spread_of(std::span<const WalkOutcome> walks, std::size_t told) {
  std::vector<double> values;
  for (const WalkOutcome& walk : walks)
    if (walk.told[told]) values.push_back(*walk.told[told]);
  return spread_of(values);
}

Spread change_of(std::span<const WalkOutcome> before, std::span<const WalkOutcome> after, std::size_t told) {
  std::vector<double> values;
  for (std::size_t i = 0; i < std::min(before.size(), after.size()); ++i)
    if (before[i].told[told] && after[i].told[told]) values.push_back(*after[i].told[told] - *before[i].told[told]);
  return spread_of(values);
}

bool clear(const Spread& change) {
  constexpr int kFewest = 5;
  return change.walks >= kFewest && std::fabs(change.mean) > 2.0 * change.spread / std::sqrt(static_cast<double>(change.walks));
}

bool Check::holds() const {
  return unfinished.empty() && std::fabs(c_twin.mean - c_recorded) <= kCheckC &&
         std::fabs(speed_rms_twin_m_s.mean - speed_rms_recorded_m_s) <= kCheckSpeed_norm * speed_rms_recorded_m_s;
}

Check check_twin(const sim::PatientParams& twin, const LedSession& session, std::uint64_t seed) {
  constexpr int kWalks = 3;
  Check out{
      .c_recorded = session.c, .speed_rms_recorded_m_s = session.speed_rms_m_s(), .c_twin = {}, .speed_rms_twin_m_s = {}, .unfinished = {}};
  std::vector<WalkOutcome> walks;
  for (std::uint64_t walk = 1; walk <= kWalks; ++walk) {
    walks.push_back(walk_twin(twin, *session.scenario, session.params, seed * 100 + walk));
    if (!walks.back().unfinished.empty()) out.unfinished = walks.back().unfinished;
  }
  out.c_twin = spread_of(walks, static_cast<std::size_t>(Told::c));
  out.speed_rms_twin_m_s = spread_of(walks, static_cast<std::size_t>(Told::speed_rms_m_s));
  if (out.c_twin.walks < kWalks && out.unfinished.empty()) out.unfinished = "a walk had no C";
  return out;
}

std::vector<sim::PatientParams> likely_patients(const Fit& fit, int count, std::uint64_t seed) {
  const auto size = static_cast<Eigen::Index>(fit.values.size());
  Eigen::MatrixXd covariance(size, size);
  for (Eigen::Index a = 0; a < size; ++a)
    for (Eigen::Index b = 0; b < size; ++b) {
      const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
      covariance(a, b) = fit.alike_norm[i][j] * fit.values[i].spread * fit.values[j].spread;
    }
  const Eigen::MatrixXd root = covariance.llt().matrixL();
  sim::Random random(seed ^ 0x4C696B656CULL);
  std::vector<sim::PatientParams> out;
  for (int number = 0; number < count; ++number) {
    Eigen::VectorXd off = Eigen::VectorXd::Zero(size);
    if (number > 0)
      for (Eigen::Index k = 0; k < size; ++k) off[k] = random.normal();
    off = root * off;
    std::vector<double> values;
    for (Eigen::Index k = 0; k < size; ++k) values.push_back(fit.values[static_cast<std::size_t>(k)].value + off[k]);
    out.push_back(with_values(fit.patient, values));
  }
  return out;
}

WhatIf what_if(const Fit& fit, const sim::Scenario& scenario, const contract::Params& before, const contract::Params& after, int walks,
               std::uint64_t seed) {
  WhatIf out;
  std::uint64_t number = 0;
  for (const sim::PatientParams& patient : likely_patients(fit, walks, seed)) {
    const std::uint64_t walk_seed = sim::Random(seed * 1000 + ++number).next();
    out.before.push_back(walk_twin(patient, scenario, before, walk_seed));
    out.after.push_back(walk_twin(patient, scenario, after, walk_seed));
  }
  return out;
}

}  // namespace hoist::tool::twin
