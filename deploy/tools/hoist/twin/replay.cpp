#include "deploy/tools/hoist/twin/replay.hpp"

#include <algorithm>
#include <cmath>

#include "control/core/law/pelvis.hpp"
#include "firmware/sim/plant.hpp"

namespace hoist::tool::twin {

namespace {

constexpr int kMillisecondsPerStep = 10;
/// Acceleration is the slope of the recorded speed over this many steps to both sides: the encoders' steps would be noise otherwise.
constexpr std::size_t kSlopeSteps = 4;

double slope_per_s(const std::vector<LedStep>& steps, std::size_t at, double LedStep::*member) {
  const std::size_t first = at > kSlopeSteps ? at - kSlopeSteps : 0, last = std::min(at + kSlopeSteps, steps.size() - 1);
  return last == first ? 0.0 : (steps[last].*member - steps[first].*member) / (static_cast<double>(last - first) * db::kSample_s);
}

// Between two recorded steps everything moves evenly.
sim::PlatformMotion between(const LedStep& from, const LedStep& to, double share) {
  const auto mixed = [&](double LedStep::*member) { return from.*member + share * (to.*member - from.*member); };
  sim::PlatformMotion motion;
  motion.x_m = mixed(&LedStep::x_m);
  motion.y_m = mixed(&LedStep::y_m);
  motion.psi_rad = mixed(&LedStep::psi_rad);
  motion.speed_m_s = mixed(&LedStep::speed_m_s);
  motion.yaw_rate_rad_s = mixed(&LedStep::yaw_rate_rad_s);
  return motion;
}

// The bar's place as the struts show it, by the laws that the core uses.
law::Pelvis<double> shown(const sim::HarnessMotion& harness, const law::PelvisGeometry<double>& geometry) {
  const double twist_m = geometry.strut_spacing_m / 2.0 * std::sin(harness.yaw_rad), d_m = geometry.strut_length_m;
  const double beta_rad = std::atan(-harness.dy_m / d_m);
  return law::pelvis_exact<double>(
      {std::atan((harness.dx_m - twist_m) / d_m), std::atan((harness.dx_m + twist_m) / d_m), beta_rad, beta_rad}, geometry);
}

}  // namespace

Response replay(const LedSession& session, const sim::PatientParams& patient) {
  const sim::PlantParams machine;
  const sim::Plant plant(machine, 1);
  const law::PelvisGeometry<double> geometry{machine.strut_length_m, machine.strut_spacing_m};
  sim::PatientParams person = patient;
  person.always_leads = true;  // as the recorded patient did
  sim::Patient walker(person, *session.scenario);
  Response out;
  const std::size_t count = session.steps.size();
  for (std::vector<double>* column : {&out.dx_m, &out.dy_m, &out.dpsi_rad}) column->reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const law::Pelvis<double> pelvis = shown(walker.harness(), geometry);
    out.dx_m.push_back(pelvis.dx_m);
    out.dy_m.push_back(pelvis.dy_m);
    out.dpsi_rad.push_back(pelvis.dpsi_rad);
    const LedStep& from = session.steps[i];
    const LedStep& to = session.steps[std::min(i + 1, count - 1)];
    const double acceleration_m_s2 = slope_per_s(session.steps, i, &LedStep::speed_m_s);
    const double yaw_acceleration_rad_s2 = slope_per_s(session.steps, i, &LedStep::yaw_rate_rad_s);
    for (int ms = 0; ms < kMillisecondsPerStep; ++ms) {
      sim::PlatformMotion motion = between(from, to, static_cast<double>(ms) / kMillisecondsPerStep);
      motion.acceleration_m_s2 = acceleration_m_s2;
      motion.yaw_acceleration_rad_s2 = yaw_acceleration_rad_s2;
      walker.step_1ms({motion, plant.harness_force(walker.harness()), from.released});
    }
  }
  return out;
}

}  // namespace hoist::tool::twin
