#include "tests/chaos/judge/truth.hpp"

#include <algorithm>
#include <cmath>

namespace hoist::chaos {
namespace {

constexpr double kGravity_m_s2 = 9.80665;

}  // namespace

const Truth& TruthSampler::sample(const sim::World& world) {
  const sim::Plant& plant = world.plant();
  const sim::Patient& patient = world.patient();
  const sim::PlantParams& machine = plant.params();
  const Truth before = now_;
  Truth t;
  t.time_s = world.time_s();
  t.wheel_m_s = {plant.wheel_speed_m_s(sim::Side::left), plant.wheel_speed_m_s(sim::Side::right)};
  t.fastest_m_s = std::max(std::fabs(t.wheel_m_s[0]), std::fabs(t.wheel_m_s[1]));
  t.speed_m_s = plant.platform().speed_m_s;
  t.yaw_rate_rad_s = plant.platform().yaw_rate_rad_s;
  const double left_rad = plant.body_alpha_rad(sim::Side::left), right_rad = plant.body_alpha_rad(sim::Side::right);
  t.forward_rad = (left_rad + right_rad) / 2.0;
  t.right_rad = (plant.body_beta_rad(sim::Side::left) + plant.body_beta_rad(sim::Side::right)) / 2.0;
  t.lean_rad = std::hypot(t.forward_rad, t.right_rad);
  t.turn_rad = (right_rad - left_rad) / 2.0;
  t.side_m = patient.harness().dy_m;
  t.strap_off = !plant.strap_holds(sim::Side::left) || !plant.strap_holds(sim::Side::right);
  t.held = plant.holds_body();
  if (!t.held) t.forward_rad = t.right_rad = t.lean_rad = t.turn_rad = t.side_m = 0.0;
  t.chassis_forward_rad = plant.chassis_alpha_rad();
  t.chassis_right_rad = plant.chassis_beta_rad();
  t.chassis_rad = std::hypot(t.chassis_forward_rad, t.chassis_right_rad);
  const sim::HarnessForce push = plant.harness_force(patient.harness());
  const double downhill_n =
      (machine.mass_kg * kGravity_m_s2 + patient.carried_n()) * std::sin(t.chassis_forward_rad - plant.edge_pitch_rad());
  const sim::HarnessForce hands = plant.shove();
  const sim::HarnessForce edge = plant.edge_force();
  t.on_edge = plant.on_edge();
  const double ahead_n = push.forward_n + hands.forward_n + downhill_n + edge.forward_n;
  const double twist_n = (push.turn_n_m + hands.turn_n_m + edge.turn_n_m) / machine.track_width_m;
  t.push_n = {ahead_n / 2.0 - twist_n, ahead_n / 2.0 + twist_n};
  t.hardest_n = std::max(std::fabs(t.push_n[0]), std::fabs(t.push_n[1]));
  constexpr double kFades_n_s = 300.0;
  t.shaken_n = std::max(t.hardest_n, before.shaken_n - kFades_n_s * kStep_s);
  t.touches = plant.touches_post();
  if (begun_) {
    for (std::size_t i = 0; i < 2; ++i) t.wheel_m_s2[i] = (t.wheel_m_s[i] - before.wheel_m_s[i]) / kStep_s;
    t.acceleration_m_s2 = (t.wheel_m_s2[0] + t.wheel_m_s2[1]) / 2.0;
    t.outward_rad_s = (t.lean_rad - before.lean_rad) / kStep_s;
  }
  begun_ = true;
  now_ = t;
  return now_;
}

}  // namespace hoist::chaos
