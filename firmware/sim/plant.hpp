// The machine: differential-drive platform, two geared motors, two sprung struts, three tilt sensors, batteries and bumpers.
//
// Physics only: it knows nothing of the control laws, the bus or the clock, and the same seed and inputs give the same numbers. One step
// integrates 1 ms. While both wheels roll, wheels and platform are one rigid mechanism with two degrees of freedom, solved exactly (no
// stiff contact spring, so 1 ms is enough); a wheel beyond the grip limit slides with the floor's friction.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "firmware/sim/battery.hpp"
#include "firmware/sim/floor_edge.hpp"
#include "firmware/sim/imu.hpp"
#include "firmware/sim/model.hpp"
#include "firmware/sim/motor.hpp"

namespace hoist::sim {

/// By how much a sensor sits askew on its strut, as alpha and beta.
struct MountingError {
  double alpha_rad{};
  double beta_rad{};
};

/// Not in the paper (D31): values of SOURCES 3, "assumed until a machine is measured", unless a line says otherwise.
struct PlantParams {
  double strut_length_m{0.80};   ///< d
  double strut_spacing_m{0.60};  ///< d_s
  double track_width_m{0.70};    ///< d_ww
  double wheel_radius_m{0.10};
  double gear_ratio{30.0};  ///< 2000 counts at the motor, 60000 at the wheel
  MotorConfig motor{};
  /// As the bench's `motor`, whose shaft also carries half of 60 kg: too much (README, "Not modelled").
  /// Each motor's own (assumed). `motor` is a bench's: its 4.3e-4 hold half of this machine, 30 kg on 0.1 m behind the gear, as well.
  double rotor_inertia_kg_m2{1.0e-4};
  double mass_kg{60.0};           ///< chassis, batteries, struts; THERA-Trainer e-go class (assumed)
  double yaw_inertia_kg_m2{8.0};  ///< 60 kg spread over 0.9 x 0.8 m (assumed)
  double wheel_inertia_kg_m2{0.01};
  double caster_ahead_m{0.8};           ///< of the driven axle, two of them, as far apart as the wheels; the frame is 0.9 m long (assumed)
  double caster_radius_m{0.05};         ///< assumed
  double rolling_n{3.0};                ///< rolling resistance, each side
  double grip_norm{0.7};                ///< rubber on linoleum
  double driven_load_norm{0.85};        ///< share of the weight on the two driven wheels: the batteries are above them (assumed)
  double pull_height_m{0.8};            ///< at which the harness pulls: a pull forward takes load off the driven wheels
  double cg_height_m{0.4};              ///< of the machine: so does braking (assumed)
  double brake_n_m{8.0};                ///< holding brake at the wheel, closed while the bridge is off: about 2.2 m/s2
  double brake_close_s{0.05};           ///< after its current went off; spring-applied brakes of this size take 20 to 60 ms (assumed)
  double spring_n_m{300.0};             ///< K, both struts together, at the harness
  double damping_n_s_m{60.0};           ///< both struts together
  double stop_rad{15.0 * kDegree_rad};  ///< M2: deflection mechanically limited
  double stop_spring_n_m{8000.0};       ///< rubber of the stop with harness and body behind it, each strut (assumed)
  double stop_damping_n_s_m{200.0};
  /// 0: the bar's ends slide, the struts stay parallel sideways; 1: a bar of fixed width draws them inward when it turns, 2.2 deg each at
  /// 25 deg. The paper does not say; the plausibility rule of hazard H7 (left and right lean alike sideways) supposes 0.
  double bar_stiff_norm{0.0};
  double sensor_height_m{0.40};  ///< up the strut
  double sensor_base_height_m{0.15};
  /// Chassis on its casters: 0.3 deg for 0.5 m/s2, and for 100 N at the harness (assumed), with an 80 ms lag.
  double pitch_rad_per_m_s2{0.0105};
  double pitch_rad_per_n{0.00005};
  double pitch_lag_s{0.08};
  // Deviations set by hidden_errors.hpp; exact by default.
  std::array<MountingError, kPlaceCount> mounting{};
  std::array<Place, kPlaceCount> sensor_at{Place::left_strut, Place::right_strut, Place::chassis};  ///< where each one is screwed on
  std::array<bool, kPlaceCount> sensor_reversed{};       ///< and there turned by half a turn about its strut
  std::array<double, 2> wheel_norm{1.0, 1.0};            ///< true radius of each wheel / wheel_radius_m
  std::array<std::uint8_t, 4> bumper_wires{0, 1, 2, 3};  ///< which input bit each strip is wired to; 255: to none
  double electronics_a{1.5};                             ///< computer, router and nodes
  double bumper_middle_m{0.40};                          ///< ahead of the axle: from behind the wheels to ahead of the casters
  double bumper_half_length_m{0.45};
  double bumper_half_width_m{0.40};
  ImuParams imu{};
  BatteryParams battery{};
};

/// A round post standing on the floor.
struct Obstacle {
  double x_m{};
  double y_m{};
  double radius_m{};
};
inline constexpr std::size_t kObstacleLimit = 8;

class Plant {
 public:
  Plant(const PlantParams& params, std::uint64_t seed);

  /// What a drive's bridge does from now on. A bridge that is off leaves the motor without current and closes the holding brake. Duty
  /// that is not finite counts as zero; beyond +-1 it is held there.
  void set_bridge(Side side, bool enabled, double duty_norm);

  /// Moves dt_s ahead (at most 1 ms at a time) with the harness held where the patient has it.
  void step(const HarnessMotion& harness, double dt_s);

  /// What the springs and stops push on the platform for this harness.
  [[nodiscard]] HarnessForce harness_force(const HarnessMotion& harness) const;

  [[nodiscard]] const PlatformMotion& platform() const { return platform_; }
  [[nodiscard]] double wheel_speed_m_s(Side side) const { return wheel_rad_s_[index(side)] * params_.wheel_radius_m; }
  [[nodiscard]] bool slipping() const { return sliding_; }
  [[nodiscard]] bool bridge_enabled(Side side) const { return bridges_[index(side)].enabled && powered(); }
  [[nodiscard]] double duty_norm(Side side) const { return bridges_[index(side)].duty_norm; }

  [[nodiscard]] std::int32_t encoder_counts(Side side) const { return motors_[index(side)].encoder_counts(); }
  [[nodiscard]] double motor_current_a(Side side) const { return motors_[index(side)].current_a(); }
  /// Supply at the drives; 0 after the emergency cut-off relay has opened.
  [[nodiscard]] double supply_v() const { return powered() ? battery_.both_v() : 0.0; }
  [[nodiscard]] double battery_v(int which) const { return battery_.one_v(which); }
  /// A sample as the sensor board reads it: the mean acceleration since the sample before (the chip's own filter), with noise and bias.
  [[nodiscard]] ImuReading read_imu(Place sensor);
  /// Bit set = pressed: 0 front, 1 rear, 2 left, 3 right.
  [[nodiscard]] std::uint8_t bumpers() const;
  /// A post touches the frame, whatever the strips say.
  [[nodiscard]] bool touches_post() const { return touched_ != 0; }
  /// True angle of a strut against the platform, rad.
  [[nodiscard]] double strut_alpha_rad(Side side) const;
  [[nodiscard]] double strut_beta_rad(Side side) const;
  /// Angle at which a strut stands that follows the body: the strut's own, as long as its strap holds.
  [[nodiscard]] double body_alpha_rad(Side side) const;
  [[nodiscard]] double body_beta_rad(Side side) const;

  // Faults and world.
  void force_bumper(int bit, bool pressed);
  void force_battery(std::optional<double> both_v) { battery_.force(both_v); }
  void weaken_battery(double by_v) { battery_.weaken(by_v); }
  /// Weight that hangs in the harness and so presses the wheels to the floor, N.
  void set_carried(double weight_n) { carried_n_ = weight_n; }
  void set_grip(Side side, double grip_norm) { grip_norm_[index(side)] = grip_norm; }
  /// From now on the floor falls by slope_rad toward downhill_rad (a heading), everywhere: as when all wheels have rolled onto a ramp, with
  /// the second or so that this takes. It leans the machine and draws it downhill. Not finite or steeper than 30 degrees: no change.
  void tilt_floor(double slope_rad, double downhill_rad);
  /// A sill or a step, one at a time: false while a wheel is on one, and for one that is no sill of 1 to 40 mm nor a step down of that.
  [[nodiscard]] bool lay_edge(const FloorEdge& edge);
  /// Takes it away as soon as all wheels stand equally high.
  void take_edge() { edge_goes_ = true; }
  /// A wheel or caster is neither as high as the floor was nor as low as all others.
  [[nodiscard]] bool on_edge() const { return on_edge_; }
  /// What the edge pushes on the platform: back where a wheel climbs, on where it drops.
  [[nodiscard]] HarnessForce edge_force() const { return edge_force_; }
  [[nodiscard]] double edge_pitch_rad() const { return edge_pitch_rad_; }
  [[nodiscard]] double floor_slope_rad() const { return floor_rad_; }
  /// True lean of the chassis, forward and to the right, rad.
  [[nodiscard]] double chassis_alpha_rad() const { return pitch_rad_; }
  [[nodiscard]] double chassis_beta_rad() const { return roll_rad_; }
  /// External push of the frame, forward and as a torque to the left, added to the springs.
  void set_shove(double forward_n, double turn_n_m) { shove_n_ = forward_n, shove_n_m_ = turn_n_m; }
  [[nodiscard]] HarnessForce shove() const { return {shove_n_, 0.0, shove_n_m_}; }
  /// An object jams the wheel: it turns only as far as the motor overcomes the jam.
  void block_wheel(Side side, bool blocked) { blocked_[index(side)] = blocked; }
  /// Two transistors of a bridge are shorted: its motor gets this share of the supply, independent of the board. The board still controls
  /// the brake. Only cutting the supply helps. No value: the bridge is intact, also for a duty that is not finite; beyond +-1 it is
  /// clamped.
  void short_bridge(Side side, std::optional<double> duty_norm);
  /// The strap of this side is cut, or its strut has come off its joint: the strut springs upright and holds nothing. Fastened again it is led back.
  void cut_strap(Side side, bool cut);
  [[nodiscard]] bool strap_holds(Side side) const { return !free_[index(side)].cut; }
  [[nodiscard]] bool holds_body() const { return strap_holds(Side::left) || strap_holds(Side::right); }
  /// A strut's tilt box is loose: it tips to the side to which the strut leans, by this play. 0: tight again.
  void loosen_box(Place place, double play_rad) { play_rad_[static_cast<std::size_t>(place)] = play_rad; }
  void cut_power(bool cut) { power_cut_ = cut; }
  /// The second contact in the motors' supply, which the computer keeps closed.
  void open_relay(bool open) { relay_open_ = open; }
  /// The emergency stop button: opens the chain, which the input node sees, and with it the relay. The motors lose their power and the
  /// spring-applied holding brakes close.
  void press_emergency_stop(bool pressed) { emergency_stop_ = pressed; }
  [[nodiscard]] bool emergency_stop() const { return emergency_stop_; }
  /// The configuration switch behind the cover: allows the first set-up of the accounts.
  void turn_configuration_switch(bool on) { configuration_switch_ = on; }
  /// The line of another recording system, such as a motion capture that says "recording".
  void set_sync_input(bool on) { sync_input_ = on; }
  /// As the input node sees them: bit 0 the open chain, bit 1 the configuration switch, bit 2 the synchronisation input.
  [[nodiscard]] std::uint8_t switches() const {
    return static_cast<std::uint8_t>((emergency_stop_ ? 1U : 0U) | (configuration_switch_ ? 2U : 0U) | (sync_input_ ? 4U : 0U));
  }
  void jump_gyro_bias(Place place, double by_rad_s) { imus_[static_cast<std::size_t>(place)].jump_bias(by_rad_s); }
  /// False when the list is full.
  [[nodiscard]] bool add_obstacle(const Obstacle& obstacle);
  void take_obstacles() { obstacle_count_ = 0; }
  /// Wires a strip (0 front, 1 rear, 2 left, 3 right) to another bit of the input node; 255 = to none.
  void wire_bumper(std::size_t strip, std::uint8_t bit) {
    if (strip < params_.bumper_wires.size()) params_.bumper_wires[strip] = bit;
  }
  /// Screws a place's sensor on elsewhere, or there by half a turn the wrong way round.
  void screw_sensor(Place sensor, Place at, bool reversed) {
    params_.sensor_at[static_cast<std::size_t>(sensor)] = at;
    params_.sensor_reversed[static_cast<std::size_t>(sensor)] = reversed;
  }
  /// Brakes released, the machine is pushed by hand along this distance and turned by this angle, evenly and at walking pace. Only while
  /// both bridges are off; ends when one is switched on.
  void push_by_hand(double way_m, double turn_rad);
  [[nodiscard]] bool pushed() const { return push_left_s_ > 0.0; }
  /// Places the machine there, at rest. Encoders keep their counts, as when pushed by hand.
  void place(double x_m, double y_m, double psi_rad);

  [[nodiscard]] const PlantParams& params() const { return params_; }

 private:
  struct Bridge {
    bool enabled{false};
    double duty_norm{};
  };
  struct Vector {
    double x{};
    double y{};
    double z{};
  };
  // A strut that does not follow the body.
  struct FreeStrut {
    bool cut{false}, free{false};
    double forward_m{}, forward_rate_m_s{}, left_m{}, left_rate_m_s{};
  };
  struct SensorMemory {
    Vector velocity_m_s;
    double time_s{};
    Vector rates_rad_s;  // alpha, beta, yaw
  };

  static constexpr std::size_t index(Side side) { return static_cast<std::size_t>(side); }
  [[nodiscard]] bool powered() const { return !power_cut_ && !relay_open_ && !emergency_stop_; }
  [[nodiscard]] bool runs_by_itself() const { return powered() && (shorted_[0] || shorted_[1]); }
  [[nodiscard]] double strut_forward_m(Side side) const;
  [[nodiscard]] double strut_forward_rate_m_s(Side side) const;
  [[nodiscard]] double strut_left_m(Side side) const;
  [[nodiscard]] double strut_left_rate_m_s(Side side) const;
  [[nodiscard]] double body_forward_m(Side side) const;
  [[nodiscard]] double body_forward_rate_m_s(Side side) const;
  [[nodiscard]] double body_left_m(Side side) const;
  void move_free_strut(Side side, double dt_s);
  void tip_box(std::size_t place, double lean_rad, double age_s, ImuReading& truth);
  [[nodiscard]] Vector sensor_velocity(Place place) const;
  void step_rolling(const std::array<double, 2>& drive_n_m, double forward_n, double turn_n_m, double dt_s);
  void step_sliding(const std::array<double, 2>& drive_n_m, double forward_n, double turn_n_m, double dt_s);
  [[nodiscard]] double friction_n_m(Side side) const;
  [[nodiscard]] double grip_n(Side side) const;
  void close_brakes(double dt_s);
  void feel_obstacles(double& forward_n, double& turn_n_m);
  void feel_edge(double dt_s);
  void level_floor();
  void feel_wheel_on_edge(std::size_t i, double weight_n, std::array<double, 4>& height_m, double dt_s);
  void lean_chassis(double forward_n, double dt_s);
  void step_pushed(double dt_s);
  /// Motor turns for each turn of a wheel of the mean radius: a larger wheel goes further for the same turn of its motor.
  [[nodiscard]] double gear(std::size_t i) const { return params_.gear_ratio / params_.wheel_norm[i]; }
  [[nodiscard]] double floor_pitch_rad() const;
  [[nodiscard]] double floor_roll_rad() const;

  PlantParams params_;
  PlatformMotion platform_;
  HarnessMotion harness_;
  std::array<Motor, 2> motors_;
  std::array<Bridge, 2> bridges_{};
  std::array<double, 2> wheel_rad_s_{};
  std::array<double, 2> friction_impulse_{};  // of the step before, where the next solution starts
  std::array<double, 2> grip_norm_{};
  std::array<bool, 2> blocked_{};
  std::array<double, 2> brake_open_s_{};  // until it closes
  double stop_m_;                         // how far the harness may go before the stops
  double rotor_inertia_kg_m2_;            // rotor and wheel, seen at the wheel
  double inverse_own_;                    // inverse of the two-wheel mass matrix: on the diagonal
  double inverse_cross_;                  // and beside it
  bool sliding_{false};
  bool power_cut_{false};
  bool relay_open_{false};
  bool emergency_stop_{false};
  bool configuration_switch_{false};
  bool sync_input_{false};
  double carried_n_{};
  double pull_n_{};     // of the harness, forward
  double floor_rad_{};  // slope of the floor, ramping to floor_goal_rad_
  double floor_goal_rad_{};
  double downhill_rad_{};
  std::optional<FloorEdge> edge_;
  bool edge_goes_{false}, on_edge_{false};
  HarnessForce edge_force_{};
  double edge_pitch_rad_{}, edge_roll_rad_{}, edge_height_m_{};
  std::array<double, 2> drop_m_s_{};              // of a driven wheel that rolls down an edge
  std::array<double, 2> bounce_s_{};              // off the floor for so long
  std::array<double, 2> pressed_norm_{1.0, 1.0};  // what presses a driven wheel to the floor, of its weight
  double height_m_{}, height_rate_m_s_{};         // of the chassis
  std::array<FreeStrut, 2> free_{};
  std::array<double, kPlaceCount> play_rad_{}, tipped_rad_{};
  double shove_n_{};
  double shove_n_m_{};
  double pitch_rad_{};
  double roll_rad_{};
  double pitch_rate_rad_s_{};
  double roll_rate_rad_s_{};
  // Duty of a shorted bridge, independent of its board.
  std::array<std::optional<double>, 2> shorted_{};
  Battery battery_;
  std::array<Imu, kPlaceCount> imus_;
  std::array<SensorMemory, kPlaceCount> sensors_{};
  std::array<Obstacle, kObstacleLimit> obstacles_{};
  std::size_t obstacle_count_{};
  std::uint8_t touched_{};
  std::uint8_t forced_bumpers_{};
  double time_s_{};
  double push_left_s_{}, push_total_s_{};
  double push_way_m_{}, push_turn_rad_{};
};

}  // namespace hoist::sim
