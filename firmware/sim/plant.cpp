#include "firmware/sim/plant.hpp"

#include <algorithm>
#include <cmath>

namespace hoist::sim {
namespace {

constexpr double kBlocked_n_m = 200.0;  // at the wheel: more than any motor of this size has
constexpr double kStepLongest_s = 0.001;
/// The two impulses of friction hardly feel each other: three rounds settle them to 1e-6.
constexpr int kFrictionRounds = 3;
/// Sliding is rare and stiffer: contact and axle friction act on the same light wheel.
constexpr int kSlidingRounds = 40;
constexpr double kObstacleSpring_n_m = 8000.0;
constexpr double kObstacleDamping_n_s_m = 1500.0;
/// A bumper strip yields by this much; it reports from the first touch.
constexpr double kObstacleForceLimit_n = 2000.0;
/// A strut with its box (assumed), and how close to the body it is as good as fastened.
constexpr double kStrut_kg = 1.0, kFastened_m = 0.002;
/// A loose box tips over once its strut leans by this much, and no faster than that (assumed).
constexpr double kTips_rad = 1.0 * kDegree_rad, kTipping_rad_s = 1.0;
/// Below the casters' radius. A tyre that drops on the floor comes up with this share of its speed (assumed).
constexpr double kEdgeHighest_m = 0.04, kBounce_norm = 0.4;
/// Pushing by hand along a tape: slower than walking.
constexpr double kPushPace_m_s = 0.4, kPushTurn_rad_s = 0.35, kPushShortest_s = 0.5;

/// The same motion in the axes of a board that sits askew: turned forward about y, then to the right about x.
ImuReading seen_askew(const ImuReading& truth, const MountingError& askew) {
  const double sin_a = std::sin(askew.alpha_rad), cos_a = std::cos(askew.alpha_rad);
  const double sin_b = std::sin(askew.beta_rad), cos_b = std::cos(askew.beta_rad);
  ImuReading seen;
  seen.ax_m_s2 = truth.ax_m_s2 * cos_a - truth.az_m_s2 * sin_a;
  const double up_m_s2 = truth.ax_m_s2 * sin_a + truth.az_m_s2 * cos_a;
  seen.ay_m_s2 = truth.ay_m_s2 * cos_b + up_m_s2 * sin_b;
  seen.az_m_s2 = up_m_s2 * cos_b - truth.ay_m_s2 * sin_b;
  // Rates about x, y and z turn like any vector.
  seen.beta_rate_rad_s = truth.beta_rate_rad_s * cos_a - truth.yaw_rate_rad_s * sin_a;
  const double yaw_rad_s = truth.beta_rate_rad_s * sin_a + truth.yaw_rate_rad_s * cos_a;
  seen.alpha_rate_rad_s = truth.alpha_rate_rad_s * cos_b + yaw_rad_s * sin_b;
  seen.yaw_rate_rad_s = yaw_rad_s * cos_b - truth.alpha_rate_rad_s * sin_b;
  return seen;
}
/// Half a metre of wheelbase rolls onto a ramp of 8 degrees in a second and a half at 0.4 m/s; steps of a tilting floor are no quicker.
constexpr double kFloorTilting_rad_s = 10.0 * kDegree_rad;
constexpr double kFloorSteepest_rad = 30.0 * kDegree_rad;

double clamp_abs(double value, double limit) { return std::clamp(value, -limit, limit); }

}  // namespace

Plant::Plant(const PlantParams& params, std::uint64_t seed)
    : params_(params),
      motors_{Motor(params.motor), Motor(params.motor)},
      grip_norm_{params.grip_norm, params.grip_norm},
      battery_(params.battery),
      imus_{Imu(params.imu, seed * 4 + 1), Imu(params.imu, seed * 4 + 2), Imu(params.imu, seed * 4 + 3)} {
  stop_m_ = params.strut_length_m * std::tan(params.stop_rad);
  const double r_m = params.wheel_radius_m;
  const double b_m = params.track_width_m;
  rotor_inertia_kg_m2_ = params.wheel_inertia_kg_m2 + params.rotor_inertia_kg_m2 * params.gear_ratio * params.gear_ratio;
  // Kinetic energy in wheel speeds: v = r (wl + wr) / 2, omega = r (wr - wl) / b.
  const double own = rotor_inertia_kg_m2_ + r_m * r_m * (params.mass_kg / 4.0 + params.yaw_inertia_kg_m2 / (b_m * b_m));
  const double cross = r_m * r_m * (params.mass_kg / 4.0 - params.yaw_inertia_kg_m2 / (b_m * b_m));
  const double determinant = own * own - cross * cross;
  inverse_own_ = own / determinant;
  inverse_cross_ = -cross / determinant;
}

void Plant::set_bridge(Side side, bool enabled, double duty_norm) {
  Bridge& bridge = bridges_[index(side)];
  bridge.enabled = enabled;
  bridge.duty_norm = enabled && std::isfinite(duty_norm) ? clamp_abs(duty_norm, 1.0) : 0.0;
}

void Plant::short_bridge(Side side, std::optional<double> duty_norm) {
  if (duty_norm && !std::isfinite(*duty_norm)) duty_norm.reset();
  shorted_[index(side)] = duty_norm ? std::optional<double>(clamp_abs(*duty_norm, 1.0)) : std::nullopt;
}

double Plant::body_forward_m(Side side) const {
  const double half_m = params_.strut_spacing_m / 2.0 * std::sin(harness_.yaw_rad);
  return harness_.dx_m + (side == Side::left ? -half_m : half_m);
}

double Plant::body_forward_rate_m_s(Side side) const {
  const double half_m_s = params_.strut_spacing_m / 2.0 * std::cos(harness_.yaw_rad) * harness_.yaw_rate_rad_s;
  return harness_.dx_rate_m_s + (side == Side::left ? -half_m_s : half_m_s);
}

double Plant::body_left_m(Side side) const {
  const double inward_m = params_.bar_stiff_norm * params_.strut_spacing_m / 2.0 * (1.0 - std::cos(harness_.yaw_rad));
  return harness_.dy_m + (side == Side::left ? -inward_m : inward_m);
}

double Plant::strut_forward_m(Side side) const { return free_[index(side)].free ? free_[index(side)].forward_m : body_forward_m(side); }

double Plant::strut_forward_rate_m_s(Side side) const {
  return free_[index(side)].free ? free_[index(side)].forward_rate_m_s : body_forward_rate_m_s(side);
}

double Plant::strut_left_m(Side side) const { return free_[index(side)].free ? free_[index(side)].left_m : body_left_m(side); }

double Plant::strut_left_rate_m_s(Side side) const {
  if (free_[index(side)].free) return free_[index(side)].left_rate_m_s;
  const double inward_rate_m_s =
      params_.bar_stiff_norm * params_.strut_spacing_m / 2.0 * std::sin(harness_.yaw_rad) * harness_.yaw_rate_rad_s;
  return harness_.dy_rate_m_s + (side == Side::left ? -inward_rate_m_s : inward_rate_m_s);
}

double Plant::strut_alpha_rad(Side side) const { return std::atan(strut_forward_m(side) / params_.strut_length_m); }
double Plant::strut_beta_rad(Side side) const { return std::atan(-strut_left_m(side) / params_.strut_length_m); }
double Plant::body_alpha_rad(Side side) const { return std::atan(body_forward_m(side) / params_.strut_length_m); }
double Plant::body_beta_rad(Side side) const { return std::atan(-body_left_m(side) / params_.strut_length_m); }

void Plant::cut_strap(Side side, bool cut) {
  FreeStrut& strut = free_[index(side)];
  if (!strut.free)
    strut = {false, true, strut_forward_m(side), strut_forward_rate_m_s(side), strut_left_m(side), strut_left_rate_m_s(side)};
  strut.cut = cut;
}

// Half of the springs and dampers on a strut of 1 kg: upright again in half a second. Fastened, it is led to the body as quickly.
void Plant::move_free_strut(Side side, double dt_s) {
  FreeStrut& strut = free_[index(side)];
  if (!strut.free) return;
  const double goal_m = strut.cut ? 0.0 : body_forward_m(side), left_goal_m = strut.cut ? 0.0 : body_left_m(side);
  const auto accelerate = [&](double off_m, double rate_m_s) {
    return -(0.5 * params_.spring_n_m * off_m + 0.5 * params_.damping_n_s_m * rate_m_s) / kStrut_kg;
  };
  strut.forward_rate_m_s += (accelerate(strut.forward_m - goal_m, strut.forward_rate_m_s) - platform_.acceleration_m_s2) * dt_s;
  strut.left_rate_m_s += accelerate(strut.left_m - left_goal_m, strut.left_rate_m_s) * dt_s;
  strut.forward_m += strut.forward_rate_m_s * dt_s;
  strut.left_m += strut.left_rate_m_s * dt_s;
  strut.free = strut.cut || std::hypot(strut.forward_m - goal_m, strut.left_m - left_goal_m) > kFastened_m;
}

HarnessForce Plant::harness_force(const HarnessMotion& harness) const {
  const double half_m = params_.strut_spacing_m / 2.0;
  const double sine = std::sin(harness.yaw_rad);
  const double cosine = std::sqrt(1.0 - sine * sine);
  const double limit_m = stop_m_;
  HarnessForce force;
  for (const double sense : {-1.0, 1.0}) {  // left strut, right strut
    if (!strap_holds(sense < 0.0 ? Side::left : Side::right)) continue;
    const double x_m = harness.dx_m + sense * half_m * sine;
    const double x_rate_m_s = harness.dx_rate_m_s + sense * half_m * cosine * harness.yaw_rate_rad_s;
    const double y_m = harness.dy_m + sense * half_m * params_.bar_stiff_norm * (1.0 - cosine);
    const double y_rate_m_s = harness.dy_rate_m_s;
    double forward_n = 0.5 * (params_.spring_n_m * x_m + params_.damping_n_s_m * x_rate_m_s);
    double left_n = 0.5 * (params_.spring_n_m * y_m + params_.damping_n_s_m * y_rate_m_s);
    const double out_square = x_m * x_m + y_m * y_m;
    if (out_square > limit_m * limit_m) {
      const double out_m = std::sqrt(out_square);
      const double out_rate_m_s = (x_m * x_rate_m_s + y_m * y_rate_m_s) / out_m;
      // Rubber pushes back; it never pulls.
      const double stop_n = std::max(0.0, params_.stop_spring_n_m * (out_m - limit_m) + params_.stop_damping_n_s_m * out_rate_m_s);
      forward_n += stop_n * x_m / out_m;
      left_n += stop_n * y_m / out_m;
    }
    force.forward_n += forward_n;
    force.left_n += left_n;
    force.turn_n_m += sense * half_m * cosine * forward_n;
  }
  return force;
}

double Plant::friction_n_m(Side side) const {
  const double running_n_m = params_.gear_ratio * params_.motor.coulomb_n_m + params_.rolling_n * params_.wheel_radius_m +
                             (blocked_[index(side)] ? kBlocked_n_m : 0.0);
  return bridge_enabled(side) || brake_open_s_[index(side)] > 0.0 ? running_n_m : running_n_m + params_.brake_n_m;
}

void Plant::close_brakes(double dt_s) {
  for (std::size_t i = 0; i < 2; ++i)
    brake_open_s_[i] = bridge_enabled(static_cast<Side>(i)) ? params_.brake_close_s : std::max(0.0, brake_open_s_[i] - dt_s);
}

// The casters are ahead of the axle and nothing is behind it: moments about the points where they stand.
double Plant::grip_n(Side side) const {
  const double weight_n = params_.mass_kg * kGravity_m_s2 + carried_n_;
  const double tipping_n_m = pull_n_ * params_.pull_height_m - params_.mass_kg * platform_.acceleration_m_s2 * params_.cg_height_m;
  const double axle_n = std::clamp(params_.driven_load_norm * weight_n - tipping_n_m / params_.caster_ahead_m, 0.0, weight_n);
  return pressed_norm_[index(side)] * grip_norm_[index(side)] * 0.5 * axle_n;
}

void Plant::step_rolling(const std::array<double, 2>& drive_n_m, double forward_n, double turn_n_m, double dt_s) {
  const double r_m = params_.wheel_radius_m;
  const std::array<double, 2> outside_n_m{r_m * (forward_n / 2.0 - turn_n_m / params_.track_width_m),
                                          r_m * (forward_n / 2.0 + turn_n_m / params_.track_width_m)};
  const double left_n_m = drive_n_m[0] + outside_n_m[0];
  const double right_n_m = drive_n_m[1] + outside_n_m[1];
  const double free_left = wheel_rad_s_[0] + dt_s * (inverse_own_ * left_n_m + inverse_cross_ * right_n_m);
  const double free_right = wheel_rad_s_[1] + dt_s * (inverse_own_ * right_n_m + inverse_cross_ * left_n_m);
  // Dry friction stops a wheel and holds it, up to its limit.
  const double limit_left = friction_n_m(Side::left) * dt_s;
  const double limit_right = friction_n_m(Side::right) * dt_s;
  double p_left = clamp_abs(friction_impulse_[0], limit_left);
  double p_right = clamp_abs(friction_impulse_[1], limit_right);
  for (int round = 0; round < kFrictionRounds; ++round) {
    p_left = clamp_abs(-(free_left + inverse_cross_ * p_right) / inverse_own_, limit_left);
    p_right = clamp_abs(-(free_right + inverse_cross_ * p_left) / inverse_own_, limit_right);
  }
  const double next_left = free_left + inverse_own_ * p_left + inverse_cross_ * p_right;
  const double next_right = free_right + inverse_own_ * p_right + inverse_cross_ * p_left;
  // What the floor had to give for that.
  const double floor_left_n = (drive_n_m[0] + (p_left - rotor_inertia_kg_m2_ * (next_left - wheel_rad_s_[0])) / dt_s) / r_m;
  const double floor_right_n = (drive_n_m[1] + (p_right - rotor_inertia_kg_m2_ * (next_right - wheel_rad_s_[1])) / dt_s) / r_m;
  if (std::fabs(floor_left_n) > grip_n(Side::left) || std::fabs(floor_right_n) > grip_n(Side::right)) {
    sliding_ = true;
    step_sliding(drive_n_m, forward_n, turn_n_m, dt_s);
    return;
  }
  friction_impulse_ = {p_left, p_right};
  wheel_rad_s_ = {next_left, next_right};
  const double speed_m_s = r_m * (next_left + next_right) / 2.0;
  const double yaw_rate_rad_s = r_m * (next_right - next_left) / params_.track_width_m;
  platform_.acceleration_m_s2 = (speed_m_s - platform_.speed_m_s) / dt_s;
  platform_.yaw_acceleration_rad_s2 = (yaw_rate_rad_s - platform_.yaw_rate_rad_s) / dt_s;
  platform_.speed_m_s = speed_m_s;
  platform_.yaw_rate_rad_s = yaw_rate_rad_s;
}

void Plant::step_sliding(const std::array<double, 2>& drive_n_m, double forward_n, double turn_n_m, double dt_s) {
  const double r_m = params_.wheel_radius_m;
  const double half_track_m = params_.track_width_m / 2.0;
  const std::array<double, 2> arm_m{-half_track_m, half_track_m};
  double speed_m_s = platform_.speed_m_s + forward_n * dt_s / params_.mass_kg;
  double yaw_rate_rad_s = platform_.yaw_rate_rad_s + turn_n_m * dt_s / params_.yaw_inertia_kg_m2;
  std::array<double, 2> wheel{wheel_rad_s_[0] + drive_n_m[0] * dt_s / rotor_inertia_kg_m2_,
                              wheel_rad_s_[1] + drive_n_m[1] * dt_s / rotor_inertia_kg_m2_};
  std::array<double, 2> axle{};     // impulses of dry friction, N m s
  std::array<double, 2> contact{};  // impulses of the floor, N s
  const double give = r_m * r_m / rotor_inertia_kg_m2_ + 1.0 / params_.mass_kg + half_track_m * half_track_m / params_.yaw_inertia_kg_m2;
  for (int round = 0; round < kSlidingRounds; ++round) {
    for (std::size_t i = 0; i < 2; ++i) {
      const Side side = static_cast<Side>(i);
      const double axle_before = axle[i];
      axle[i] = clamp_abs(axle_before - wheel[i] * rotor_inertia_kg_m2_, friction_n_m(side) * dt_s);
      wheel[i] += (axle[i] - axle_before) / rotor_inertia_kg_m2_;
      const double slip_m_s = wheel[i] * r_m - (speed_m_s + arm_m[i] * yaw_rate_rad_s);
      const double contact_before = contact[i];
      contact[i] = clamp_abs(contact_before + slip_m_s / give, grip_n(side) * dt_s);
      const double change = contact[i] - contact_before;
      wheel[i] -= change * r_m / rotor_inertia_kg_m2_;
      speed_m_s += change / params_.mass_kg;
      yaw_rate_rad_s += change * arm_m[i] / params_.yaw_inertia_kg_m2;
    }
  }
  bool gripping = true;
  for (std::size_t i = 0; i < 2; ++i) gripping = gripping && std::fabs(contact[i]) < grip_n(static_cast<Side>(i)) * dt_s;
  sliding_ = !gripping;
  if (gripping) {
    // Both wheels roll again: what the rounds left over is taken out.
    wheel = {(speed_m_s - half_track_m * yaw_rate_rad_s) / r_m, (speed_m_s + half_track_m * yaw_rate_rad_s) / r_m};
  }
  friction_impulse_ = axle;
  wheel_rad_s_ = wheel;
  platform_.acceleration_m_s2 = (speed_m_s - platform_.speed_m_s) / dt_s;
  platform_.yaw_acceleration_rad_s2 = (yaw_rate_rad_s - platform_.yaw_rate_rad_s) / dt_s;
  platform_.speed_m_s = speed_m_s;
  platform_.yaw_rate_rad_s = yaw_rate_rad_s;
}

void Plant::feel_obstacles(double& forward_n, double& turn_n_m) {
  touched_ = 0;
  if (obstacle_count_ == 0) return;
  const double sine = std::sin(platform_.psi_rad);
  const double cosine = std::cos(platform_.psi_rad);
  for (std::size_t i = 0; i < obstacle_count_; ++i) {
    const Obstacle& post = obstacles_[i];
    const double ahead_m = cosine * (post.x_m - platform_.x_m) + sine * (post.y_m - platform_.y_m) - params_.bumper_middle_m;
    const double left_m = -sine * (post.x_m - platform_.x_m) + cosine * (post.y_m - platform_.y_m);
    const double gap_x_m = std::max(0.0, std::fabs(ahead_m) - params_.bumper_half_length_m);
    const double gap_y_m = std::max(0.0, std::fabs(left_m) - params_.bumper_half_width_m);
    const double press_m = post.radius_m - std::sqrt(gap_x_m * gap_x_m + gap_y_m * gap_y_m);
    if (press_m <= 0.0) continue;
    // Which strip: the side on which the post is farther out.
    const bool lengthwise = std::fabs(ahead_m) / params_.bumper_half_length_m >= std::fabs(left_m) / params_.bumper_half_width_m;
    if (!lengthwise) {
      touched_ |= left_m > 0.0 ? 0x04 : 0x08;
      continue;  // the casters roll along it; sideways the wheels hold anyway
    }
    touched_ |= ahead_m > 0.0 ? 0x01 : 0x02;
    const double sense = ahead_m > 0.0 ? 1.0 : -1.0;
    const double touch_m = std::clamp(left_m, -params_.bumper_half_width_m, params_.bumper_half_width_m);
    const double towards_m_s = sense * (platform_.speed_m_s - platform_.yaw_rate_rad_s * touch_m);
    const double push_n = std::clamp(kObstacleSpring_n_m * press_m + kObstacleDamping_n_s_m * towards_m_s, 0.0, kObstacleForceLimit_n);
    forward_n -= sense * push_n;
    turn_n_m += sense * touch_m * push_n;
  }
}

bool Plant::lay_edge(const FloorEdge& edge) {
  const bool finite = std::isfinite(edge.x_m) && std::isfinite(edge.y_m) && std::isfinite(edge.psi_rad) && std::isfinite(edge.length_m);
  const double high_m = std::fabs(edge.height_m);
  if (on_edge_ || !finite || !(high_m >= 0.001 && high_m <= kEdgeHighest_m) || edge.length_m < 0.0) return false;
  level_floor();
  edge_ = edge;
  edge_goes_ = false;
  return true;
}

// Wheels 0 and 1 are the driven ones, 2 and 3 the casters, each pair left and right.
void Plant::feel_wheel_on_edge(std::size_t i, double weight_n, std::array<double, 4>& height_m, double dt_s) {
  const bool driven = i < 2;
  const double ahead_m = driven ? 0.0 : params_.caster_ahead_m;
  const double left_m = (i % 2 == 0 ? 0.5 : -0.5) * params_.track_width_m;
  const double sine = std::sin(platform_.psi_rad), cosine = std::cos(platform_.psi_rad);
  const WheelPath path = over(*edge_, platform_.x_m + cosine * ahead_m - sine * left_m, platform_.y_m + sine * ahead_m + cosine * left_m,
                              driven ? params_.wheel_radius_m : params_.caster_radius_m);
  const double way_norm = std::cos(edge_->psi_rad - platform_.psi_rad);
  const double push_n = -weight_n * path.slope_norm * way_norm;
  height_m[i] = path.height_m;
  edge_force_.forward_n += push_n;
  edge_force_.turn_n_m -= left_m * push_n;
  if (!driven) return;
  const double along_m_s = way_norm * (platform_.speed_m_s - platform_.yaw_rate_rad_s * left_m);
  const double drop_m_s = std::max(0.0, -path.slope_norm * along_m_s);
  if (path.slope_norm == 0.0 && drop_m_s_[i] > 0.0) bounce_s_[i] = 2.0 * kBounce_norm * drop_m_s_[i] / kGravity_m_s2;
  // While the tyre meets the lower floor the slope fades.
  drop_m_s_[i] = path.slope_norm == 0.0 ? 0.0 : std::max(drop_m_s, drop_m_s_[i]);
  bounce_s_[i] = std::max(0.0, bounce_s_[i] - dt_s);
  pressed_norm_[i] = bounce_s_[i] > 0.0 ? 0.0 : std::clamp(1.0 + along_m_s * along_m_s * path.curve_per_m / kGravity_m_s2, 0.0, 1.0);
}

void Plant::feel_edge(double dt_s) {
  if (!edge_) return;
  edge_force_ = {};
  const double weight_n = params_.mass_kg * kGravity_m_s2 + carried_n_;
  std::array<double, 4> height_m{};
  for (std::size_t i = 0; i < height_m.size(); ++i)
    feel_wheel_on_edge(i, 0.5 * weight_n * (i < 2 ? params_.driven_load_norm : 1.0 - params_.driven_load_norm), height_m, dt_s);
  const double axle_m = (height_m[0] + height_m[1]) / 2.0, casters_m = (height_m[2] + height_m[3]) / 2.0;
  edge_pitch_rad_ = (axle_m - casters_m) / params_.caster_ahead_m;
  edge_roll_rad_ = (height_m[0] - height_m[1]) / params_.track_width_m;
  edge_height_m_ = axle_m;
  const auto [lowest, highest] = std::minmax_element(height_m.begin(), height_m.end());
  on_edge_ = *highest > *lowest || edge_force_.forward_n != 0.0;
  if (edge_goes_ && !on_edge_) level_floor();
}

// From here on the floor is level, at the height at which the hoist stands.
void Plant::level_floor() {
  edge_.reset();
  height_m_ -= edge_height_m_;
  edge_height_m_ = edge_pitch_rad_ = edge_roll_rad_ = 0.0;
  edge_force_ = {};
  bounce_s_ = drop_m_s_ = {};
  pressed_norm_ = {1.0, 1.0};
}

double Plant::floor_pitch_rad() const { return floor_rad_ * std::cos(downhill_rad_ - platform_.psi_rad); }
double Plant::floor_roll_rad() const { return -floor_rad_ * std::sin(downhill_rad_ - platform_.psi_rad); }

void Plant::lean_chassis(double forward_n, double dt_s) {
  floor_rad_ += clamp_abs(floor_goal_rad_ - floor_rad_, kFloorTilting_rad_s * dt_s);
  const double keep = dt_s / params_.pitch_lag_s;
  const double pitch_goal_rad =
      -params_.pitch_rad_per_m_s2 * platform_.acceleration_m_s2 + params_.pitch_rad_per_n * forward_n + floor_pitch_rad() + edge_pitch_rad_;
  const double roll_goal_rad =
      params_.pitch_rad_per_m_s2 * platform_.speed_m_s * platform_.yaw_rate_rad_s + floor_roll_rad() + edge_roll_rad_;
  pitch_rate_rad_s_ = (pitch_goal_rad - pitch_rad_) / params_.pitch_lag_s;
  roll_rate_rad_s_ = (roll_goal_rad - roll_rad_) / params_.pitch_lag_s;
  pitch_rad_ += keep * (pitch_goal_rad - pitch_rad_);
  roll_rad_ += keep * (roll_goal_rad - roll_rad_);
  height_rate_m_s_ = (edge_height_m_ - height_m_) / params_.pitch_lag_s;
  height_m_ += dt_s * height_rate_m_s_;
}

void Plant::step(const HarnessMotion& harness, double dt_s) {
  if (!(dt_s > 0.0) || !std::isfinite(dt_s)) return;
  harness_ = harness;
  double left_s = dt_s;
  while (left_s > 1e-9) {
    const double h_s = std::min(left_s, kStepLongest_s);
    left_s -= h_s;
    time_s_ += h_s;

    // Motors. A bridge that is off leaves the winding open: no current, the brake holds.
    std::array<double, 2> drive_n_m{};
    double supply_a = params_.electronics_a;
    for (std::size_t i = 0; i < 2; ++i) {
      const bool driven = (bridges_[i].enabled || shorted_[i]) && powered();
      const double duty_norm = shorted_[i].value_or(bridges_[i].duty_norm);
      const double shaft_rad_s = wheel_rad_s_[i] * gear(i);
      const double terminal_v = driven ? duty_norm * battery_.both_v() : params_.motor.constant_v_s_rad * shaft_rad_s;
      const double torque_n_m = motors_[i].step_imposed(terminal_v, shaft_rad_s, h_s);
      drive_n_m[i] = gear(i) * (torque_n_m - params_.motor.viscous_n_m_s * shaft_rad_s);
      if (driven) supply_a += duty_norm * motors_[i].current_a();
    }
    battery_.step(supply_a, h_s);
    close_brakes(h_s);

    for (const Side side : {Side::left, Side::right}) move_free_strut(side, h_s);
    HarnessForce push = harness_force(harness_);
    pull_n_ = push.forward_n;
    push.forward_n += shove_n_;
    push.turn_n_m += shove_n_m_;
    double forward_n = push.forward_n + (params_.mass_kg * kGravity_m_s2 + carried_n_) * std::sin(floor_pitch_rad());
    feel_obstacles(forward_n, push.turn_n_m);
    feel_edge(h_s);
    forward_n += edge_force_.forward_n;
    push.turn_n_m += edge_force_.turn_n_m;
    const double speed_before_m_s = platform_.speed_m_s;
    const double turn_before_rad_s = platform_.yaw_rate_rad_s;
    if (bridge_enabled(Side::left) || bridge_enabled(Side::right) || runs_by_itself()) push_left_s_ = 0.0;
    if (pushed()) {
      step_pushed(h_s);
    } else if (sliding_) {
      step_sliding(drive_n_m, forward_n, push.turn_n_m, h_s);
    } else {
      step_rolling(drive_n_m, forward_n, push.turn_n_m, h_s);
    }
    lean_chassis(push.forward_n, h_s);

    const double turn_rad = 0.5 * (turn_before_rad_s + platform_.yaw_rate_rad_s) * h_s;
    const double way_m = 0.5 * (speed_before_m_s + platform_.speed_m_s) * h_s;
    const double mean_psi_rad = platform_.psi_rad + 0.5 * turn_rad;
    platform_.x_m += way_m * std::cos(mean_psi_rad);
    platform_.y_m += way_m * std::sin(mean_psi_rad);
    platform_.psi_rad += turn_rad;
  }
}

Plant::Vector Plant::sensor_velocity(Place place) const {
  if (place == Place::chassis) {
    return {platform_.speed_m_s + pitch_rate_rad_s_ * params_.sensor_base_height_m, -roll_rate_rad_s_ * params_.sensor_base_height_m,
            height_rate_m_s_};
  }
  const Side side = place == Place::left_strut ? Side::left : Side::right;
  const double up = params_.sensor_height_m / params_.strut_length_m;
  const double beside_m = side == Side::left ? params_.strut_spacing_m / 2.0 : -params_.strut_spacing_m / 2.0;
  return {
      platform_.speed_m_s - platform_.yaw_rate_rad_s * (beside_m + up * strut_left_m(side)) + up * strut_forward_rate_m_s(side) +
          pitch_rate_rad_s_ * params_.sensor_height_m,
      platform_.yaw_rate_rad_s * up * strut_forward_m(side) + up * strut_left_rate_m_s(side) - roll_rate_rad_s_ * params_.sensor_height_m,
      height_rate_m_s_};
}

ImuReading Plant::read_imu(Place sensor) {
  const auto index = static_cast<std::size_t>(sensor);
  const Place place = params_.sensor_at[index];
  SensorMemory& memory = sensors_[index];
  const Vector velocity = sensor_velocity(place);
  const double age_s = time_s_ - memory.time_s;
  // Acceleration against the floor, in the platform's axes: the rotating frame adds omega x v.
  Vector acceleration{};
  if (age_s > 1e-6) {
    const double vx = 0.5 * (velocity.x + memory.velocity_m_s.x);
    const double vy = 0.5 * (velocity.y + memory.velocity_m_s.y);
    acceleration.x = (velocity.x - memory.velocity_m_s.x) / age_s - platform_.yaw_rate_rad_s * vy;
    acceleration.y = (velocity.y - memory.velocity_m_s.y) / age_s + platform_.yaw_rate_rad_s * vx;
    acceleration.z = (velocity.z - memory.velocity_m_s.z) / age_s;
  }
  memory.velocity_m_s = velocity;
  memory.time_s = time_s_;

  // Direction of the sensor's z axis; x stays in the plane of the lean, y completes it.
  double lean = pitch_rad_;
  double lean_left = -roll_rad_;
  double alpha_rate_rad_s = pitch_rate_rad_s_;
  double beta_rate_rad_s = roll_rate_rad_s_;
  if (place != Place::chassis) {
    const Side side = place == Place::left_strut ? Side::left : Side::right;
    const double forward = strut_forward_m(side) / params_.strut_length_m;
    const double aside = strut_left_m(side) / params_.strut_length_m;
    lean += forward;
    lean_left += aside;
    alpha_rate_rad_s += strut_forward_rate_m_s(side) / params_.strut_length_m / (1.0 + forward * forward);
    beta_rate_rad_s -= strut_left_rate_m_s(side) / params_.strut_length_m / (1.0 + aside * aside);
  }
  const double z_length = std::sqrt(1.0 + lean * lean + lean_left * lean_left);
  const Vector z_axis{lean / z_length, lean_left / z_length, 1.0 / z_length};
  const double x_length = std::sqrt(1.0 + lean * lean);
  const Vector x_axis{1.0 / x_length, 0.0, -lean / x_length};
  const Vector y_axis{z_axis.y * x_axis.z - z_axis.z * x_axis.y, z_axis.z * x_axis.x - z_axis.x * x_axis.z,
                      z_axis.x * x_axis.y - z_axis.y * x_axis.x};
  const auto along = [](const Vector& axis, double x, double y, double z) { return axis.x * x + axis.y * y + axis.z * z; };

  ImuReading truth;
  truth.ax_m_s2 = along(x_axis, acceleration.x, acceleration.y, kGravity_m_s2 + acceleration.z);
  truth.ay_m_s2 = along(y_axis, acceleration.x, acceleration.y, kGravity_m_s2 + acceleration.z);
  truth.az_m_s2 = along(z_axis, acceleration.x, acceleration.y, kGravity_m_s2 + acceleration.z);
  // A strut that leans turns part of the platform's yaw into its own pitch and roll: the filter must live with that.
  truth.alpha_rate_rad_s = along(y_axis, beta_rate_rad_s, alpha_rate_rad_s, platform_.yaw_rate_rad_s);
  truth.beta_rate_rad_s = along(x_axis, beta_rate_rad_s, alpha_rate_rad_s, platform_.yaw_rate_rad_s);
  truth.yaw_rate_rad_s = along(z_axis, beta_rate_rad_s, alpha_rate_rad_s, platform_.yaw_rate_rad_s);
  // A chip's low-pass tells a rate some milliseconds late: between this sample and the one before.
  const Vector rates{truth.alpha_rate_rad_s, truth.beta_rate_rad_s, truth.yaw_rate_rad_s};
  if (params_.imu.gyro_late_s > 0.0 && age_s > 1e-6) {
    const double late_norm = std::min(1.0, params_.imu.gyro_late_s / age_s);
    truth.alpha_rate_rad_s += late_norm * (memory.rates_rad_s.x - rates.x);
    truth.beta_rate_rad_s += late_norm * (memory.rates_rad_s.y - rates.y);
    truth.yaw_rate_rad_s += late_norm * (memory.rates_rad_s.z - rates.z);
  }
  memory.rates_rad_s = rates;
  if (params_.sensor_reversed[index]) {
    for (double* value : {&truth.ax_m_s2, &truth.ay_m_s2, &truth.alpha_rate_rad_s, &truth.beta_rate_rad_s}) *value = -*value;
  }
  if (play_rad_[index] != 0.0 || tipped_rad_[index] != 0.0) tip_box(index, lean, age_s, truth);
  const MountingError& askew = params_.mounting[index];
  if (askew.alpha_rad != 0.0 || askew.beta_rad != 0.0) truth = seen_askew(truth, askew);
  return imus_[index].corrupt(truth, std::clamp(age_s, 0.0, 1.0));
}

void Plant::tip_box(std::size_t place, double lean_rad, double age_s, ImuReading& truth) {
  double& tipped_rad = tipped_rad_[place];
  const double goal_rad = std::fabs(lean_rad) > kTips_rad || play_rad_[place] == 0.0 || tipped_rad == 0.0
                              ? std::copysign(play_rad_[place], lean_rad)
                              : std::copysign(play_rad_[place], tipped_rad);
  const double change_rad = clamp_abs(goal_rad - tipped_rad, kTipping_rad_s * age_s);
  tipped_rad += change_rad;
  if (age_s > 1e-6) truth.alpha_rate_rad_s += change_rad / age_s;
  truth = seen_askew(truth, {tipped_rad, 0.0});
}

void Plant::push_by_hand(double way_m, double turn_rad) {
  if (!std::isfinite(way_m) || !std::isfinite(turn_rad)) return;
  const double slowest_s = std::max(std::fabs(way_m) / kPushPace_m_s, std::fabs(turn_rad) / kPushTurn_rad_s);
  push_total_s_ = push_left_s_ = std::max(slowest_s, kPushShortest_s);
  push_way_m_ = way_m;
  push_turn_rad_ = turn_rad;
}

void Plant::step_pushed(double dt_s) {
  push_left_s_ = std::max(0.0, push_left_s_ - dt_s);
  // Speed over the path is half a sine; its mean is 2 / pi of its peak.
  const double share = std::sin(kPi * push_left_s_ / push_total_s_) * kPi / 2.0 / push_total_s_;
  const double speed_m_s = push_left_s_ > 0.0 ? push_way_m_ * share : 0.0;
  const double yaw_rate_rad_s = push_left_s_ > 0.0 ? push_turn_rad_ * share : 0.0;
  platform_.acceleration_m_s2 = (speed_m_s - platform_.speed_m_s) / dt_s;
  platform_.yaw_acceleration_rad_s2 = (yaw_rate_rad_s - platform_.yaw_rate_rad_s) / dt_s;
  platform_.speed_m_s = speed_m_s;
  platform_.yaw_rate_rad_s = yaw_rate_rad_s;
  const double half_m_s = yaw_rate_rad_s * params_.track_width_m / 2.0;
  wheel_rad_s_ = {(speed_m_s - half_m_s) / params_.wheel_radius_m, (speed_m_s + half_m_s) / params_.wheel_radius_m};
  friction_impulse_ = {};
  sliding_ = false;
}

std::uint8_t Plant::bumpers() const {
  const auto touched = static_cast<unsigned>(touched_ | forced_bumpers_);
  unsigned wired = 0;
  for (std::size_t strip = 0; strip < params_.bumper_wires.size(); ++strip)
    if (((touched >> strip) & 1U) != 0 && params_.bumper_wires[strip] < 8) wired |= 1U << params_.bumper_wires[strip];
  return static_cast<std::uint8_t>(wired);
}

void Plant::force_bumper(int bit, bool pressed) {
  if (bit < 0 || bit > 3) return;
  const auto mask = static_cast<std::uint8_t>(1U << bit);
  forced_bumpers_ = static_cast<std::uint8_t>(pressed ? (forced_bumpers_ | mask) : (forced_bumpers_ & ~mask));
}

void Plant::tilt_floor(double slope_rad, double downhill_rad) {
  if (!(std::fabs(slope_rad) <= kFloorSteepest_rad) || !std::isfinite(downhill_rad)) return;
  floor_goal_rad_ = slope_rad;
  downhill_rad_ = downhill_rad;
}

bool Plant::add_obstacle(const Obstacle& obstacle) {
  if (obstacle_count_ == kObstacleLimit || !(obstacle.radius_m > 0.0) || !std::isfinite(obstacle.x_m) || !std::isfinite(obstacle.y_m))
    return false;
  obstacles_[obstacle_count_++] = obstacle;
  return true;
}

void Plant::place(double x_m, double y_m, double psi_rad) {
  platform_ = {x_m, y_m, psi_rad, 0.0, 0.0, 0.0, 0.0};
  wheel_rad_s_ = {};
  friction_impulse_ = {};
  sliding_ = false;
}

}  // namespace hoist::sim
