#include "tests/chaos/judge/deadlines.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "control/contract/guided_path.hpp"

namespace hoist::chaos {
namespace {
constexpr double kRest_m_s = 0.02;

using contract::Mode;
using contract::Node;
using HoistFault = contract::Fault;

constexpr double kRolls_m_s = 0.12;  // the core's rules begin at 0.1 m/s
// What the tilt filter hides of a lean (H15).
constexpr double kFiltered_rad = 2.0 * kDegree_rad;
// One step passes between a cause and the next look at it.
constexpr double kLook_s = 0.011;

template <typename... F>
constexpr contract::FaultBits any(F... faults) {
  return (contract::fault_bit(faults) | ...);
}
constexpr contract::FaultBits kBus = any(HoistFault::bus_down);
constexpr contract::FaultBits kDrives = any(HoistFault::drive_left_fault, HoistFault::drive_right_fault);
constexpr contract::FaultBits kTilts = any(HoistFault::tilt_implausible, HoistFault::tilt_frozen, HoistFault::tilt_sensor_fault);

// Budgets of the hazard table (SOURCES 2.2), with one step to look. Where the true value passes a filter before anybody can see it, the limit in
// holds() lies beyond the alarm's own by what the filter hides (H15: 2 degrees and 4 degrees a second).
constexpr std::array kRules{
    RuleInfo{Rule::silent_drive_left, "I1: the silent left drive is not missed within 60 ms", kLook_s,
             any(HoistFault::drive_left_lost) | kBus, 1.0},
    RuleInfo{Rule::silent_drive_right, "I1: the silent right drive is not missed within 60 ms", kLook_s,
             any(HoistFault::drive_right_lost) | kBus, 1.0},
    RuleInfo{Rule::silent_io, "I1: the silent input node is not missed within 60 ms", kLook_s, any(HoistFault::io_lost) | kBus, 1.0},
    RuleInfo{Rule::silent_tilt_left, "I1: the silent left strut is not missed within 60 ms", kLook_s,
             any(HoistFault::tilt_left_lost) | kBus, 1.0},
    RuleInfo{Rule::silent_tilt_right, "I1: the silent right strut is not missed within 60 ms", kLook_s,
             any(HoistFault::tilt_right_lost) | kBus, 1.0},
    RuleInfo{Rule::silent_tilt_base, "I1: the silent chassis sensor is not missed within 60 ms", kLook_s,
             any(HoistFault::tilt_base_lost) | kBus, 1.0},
    RuleInfo{Rule::bus_gone, "I1: a bus without any node is not told of within 60 ms", kLook_s, kBus, 1.0},
    RuleInfo{Rule::two_of_one, "I1: two nodes under one number are not found within 500 ms", 0.5 + kLook_s,
             any(HoistFault::node_duplicate, HoistFault::node_babbling), 1.0},
    RuleInfo{Rule::flood, "I1: a flood of strange frames is not found", 0.25, any(HoistFault::node_babbling, HoistFault::node_duplicate),
             1.0},
    RuleInfo{Rule::left_drive_fails, "I1: the left drive's fault is not taken up within 100 ms", 0.1 + kLook_s,
             any(HoistFault::drive_left_fault), 1.0},
    RuleInfo{Rule::right_drive_fails, "I1: the right drive's fault is not taken up within 100 ms", 0.1 + kLook_s,
             any(HoistFault::drive_right_fault), 1.0},
    RuleInfo{Rule::left_drive_drops, "I1: the left drive does not run without an alarm", 0.1 + kLook_s,
             any(HoistFault::drive_left_fault, HoistFault::drive_left_lost, HoistFault::emergency_stop) | kBus, 1.0, true},
    RuleInfo{Rule::right_drive_drops, "I1: the right drive does not run without an alarm", 0.1 + kLook_s,
             any(HoistFault::drive_right_fault, HoistFault::drive_right_lost, HoistFault::emergency_stop) | kBus, 1.0, true},
    RuleInfo{Rule::blind_encoder, "I1: a wheel turns behind a broken encoder for longer than 150 ms", 0.15 + kLook_s, 0, 1.0, true},
    RuleInfo{Rule::nonsense, "I1: a sensor gives nonsense for longer than 100 ms", 0.1 + kLook_s, kTilts | any(HoistFault::fall_detected),
             1.0},
    RuleInfo{Rule::beyond_stops, "I1: an angle beyond the stops passes", 0.03 + kLook_s, any(HoistFault::tilt_implausible), 1.0},
    RuleInfo{Rule::stuck, "I1: a stuck sensor is not found within 500 ms of rolling", 0.5 + kLook_s, kTilts, 1.0, true},
    RuleInfo{Rule::invalid, "I1: invalid samples of a sensor are not found within 60 ms", 0.06 + kLook_s,
             any(HoistFault::tilt_sensor_fault), 1.0},
    RuleInfo{Rule::wrong_lean, "I1: led by a lean that is wrong by 5 degrees", 1.0 + kLook_s, 0, 0, true},
    RuleInfo{Rule::half_led, "I1: a patient walks with one strap cut", 8.0 + kLook_s, any(HoistFault::tilt_implausible), 1.0, true},
    RuleInfo{Rule::touched, "I1: a bumper is not felt within 30 ms", 0.03 + kLook_s, any(HoistFault::bumper_pressed), 1.5},
    RuleInfo{Rule::falling, "I1: a fall is not found within 80 ms", 0.08 + kLook_s, any(HoistFault::fall_detected), 1.0, true},
    RuleInfo{Rule::lying, "I1: a body in the stops is not found", 0.2 + kLook_s, any(HoistFault::fall_detected), 1.0, true},
    RuleInfo{Rule::leaning, "I1: a patient who hangs leaning is not found within 2.6 s", 2.6 + kLook_s,
             any(HoistFault::patient_hanging, HoistFault::fall_detected), 0.5},
    // 2.6 s after the last swing that the sensors show. A body that goes limp swings back.
    RuleInfo{Rule::dragged, "I1: a patient who is dragged without a step is not found within 3.0 s", 3.0 + kLook_s,
             any(HoistFault::patient_hanging, HoistFault::fall_detected), 0.5},
    RuleInfo{Rule::rolls_away, "I1: a body in the stops pushes the hoist away on standby", 0.2 + kLook_s, any(HoistFault::fall_detected),
             1.0},
    RuleInfo{Rule::lies_stopped, "I1: a body that stays in the stops of a stopped hoist is not told of", 0.8 + kLook_s,
             any(HoistFault::fall_detected), 0},
    RuleInfo{Rule::empty, "I1: empty batteries are not found within 2 s", 0.5 + kLook_s, any(HoistFault::battery_empty), 0.5},
    RuleInfo{Rule::high, "I1: a supply at which the drives brake less is not found within 2 s", 0.5 + kLook_s, any(HoistFault::supply_high),
             0.5},
    RuleInfo{Rule::weak, "I1: low batteries are not told of within 2 s", 0.5 + kLook_s, any(HoistFault::battery_low)},
    RuleInfo{Rule::uneven, "I1: uneven batteries are not told of within 2 s", 0.5 + kLook_s, any(HoistFault::battery_uneven)},
    RuleInfo{Rule::steep, "I1: a chassis beyond 8 degrees is not found within 200 ms", 0.2 + kLook_s, any(HoistFault::base_tilted), 1.0},
    RuleInfo{Rule::sloping, "I1: a chassis beyond 5 degrees is not told of within 200 ms", 0.2 + kLook_s,
             any(HoistFault::base_tilt_high, HoistFault::base_tilted)},
    RuleInfo{Rule::no_commands, "I1: lost driving commands are not told of within 270 ms", kLook_s, any(HoistFault::remote_command_lost),
             0.8},
    RuleInfo{Rule::no_server, "I1: a lost server is not told of within 270 ms", kLook_s, any(HoistFault::server_lost)},
    RuleInfo{Rule::beside_command, "I1: a wheel beside its command is not found within 150 ms", 0.15 + kLook_s,
             kDrives | any(HoistFault::overspeed, HoistFault::drive_left_lost, HoistFault::drive_right_lost) | kBus, 1.0},
    RuleInfo{Rule::runaway, "I1: a wheel runs away for longer than 1.2 s", kLook_s, 0},
    RuleInfo{Rule::late, "I1: a late step is not found within 40 ms", 0.0, any(HoistFault::loop_overrun), 1.0},
    RuleInfo{Rule::chain_open, "I1: the emergency stop is not seen within 30 ms", 0.03 + kLook_s, any(HoistFault::emergency_stop), 0.7},
    RuleInfo{Rule::unpowered, "I1: motors without power are not told of within 1.2 s", 1.2, any(HoistFault::emergency_stop), 0.7},
    RuleInfo{Rule::over_voltage, "I1: a supply above 32.5 V is not found within 100 ms", 0.1 + kLook_s, kDrives | kBus, 0.7, true},
    RuleInfo{Rule::slipping, "I1: wheels that slip are not found within 1.2 s", 1.5, any(HoistFault::wheel_slip), 0.5, true},
    // The drives leave operation 250 ms after the last one, and are missed then.
    RuleInfo{Rule::unheard, "I1: a computer without a heartbeat drives on for longer than 310 ms", 0.31 + kLook_s,
             kDrives | any(HoistFault::drive_left_lost, HoistFault::drive_right_lost) | kBus, 1.0, true},
    RuleInfo{Rule::zero_lost, "I1: a sensor that has lost its zero calls its angles valid for longer than 6.2 s", 6.2 + kLook_s, 0},
};
static_assert([] {
  for (std::size_t i = 0; i < kRules.size(); ++i)
    if (kRules[i].rule != static_cast<Rule>(i)) return false;
  return kRules.size() == kRuleCount;
}());

constexpr std::string_view kSilence = "silent node; bus gone", kSensor = "nonsense, beyond stops, invalid; wrong lean",
                           kBusHealth = "two of one; flood; silent node", kHand = "no commands; I6", kOutside = "I12: not felt";
constexpr std::array kJudged{
    Judged{Kind::unplug, kSilence},
    Judged{Kind::loose_plug, kSilence},
    Judged{Kind::freeze, kSilence},
    Judged{Kind::reboot, "silent node; drive drops"},
    Judged{Kind::bus_off, kSilence},
    Judged{Kind::drop, kSilence},
    Judged{Kind::corrupt, kSilence},
    Judged{Kind::delay, kSilence},
    Judged{Kind::duplicate, kBusHealth},
    Judged{Kind::babble, kBusHealth},
    Judged{Kind::garbage_frames, kBusHealth},
    Judged{Kind::serial_noise, kSilence},
    Judged{Kind::sensor_stuck, "stuck"},
    Judged{Kind::sensor_offset, kSensor},
    Judged{Kind::sensor_garbage, kSensor},
    Judged{Kind::sensor_slow, kSensor},
    Judged{Kind::sensor_silent, "invalid"},
    Judged{Kind::gyro_jump, kSensor},
    Judged{Kind::encoder_lost, "blind encoder"},
    Judged{Kind::encoder_reversed, "blind encoder"},
    Judged{Kind::slip, "slipping"},
    Judged{Kind::wheel_blocked, "beside its command"},
    Judged{Kind::bridge_shorted, "runaway; beside its command"},
    Judged{Kind::battery, "empty, weak"},
    Judged{Kind::power_cut, "unpowered"},
    Judged{Kind::emergency_stop, "chain open"},
    Judged{Kind::bumper, "touched"},
    Judged{Kind::obstacle, "touched"},
    Judged{Kind::slope, "steep, sloping"},
    Judged{Kind::trip, "falling, lying, lies stopped, rolls away"},
    Judged{Kind::collapse, "falling, lying, lies stopped, rolls away"},
    Judged{Kind::hang, "leaning, dragged"},
    Judged{Kind::pelvis_turned, "beyond stops; I7"},
    Judged{Kind::core_bus_off, "bus gone; I8"},
    Judged{Kind::core_late, "late"},
    Judged{Kind::core_stall, "late; I8"},
    Judged{Kind::core_crash, "I8"},
    Judged{Kind::server_hang, "no server; no commands; I12"},
    Judged{Kind::server_crash, "no server; no commands; I12"},
    Judged{Kind::link_loss, kHand},
    Judged{Kind::link_stall, kHand},
    Judged{Kind::link_jitter, kHand},
    Judged{Kind::tab_freeze, kHand},
    Judged{Kind::second_client, "I3, I6, I10"},
    Judged{Kind::take_over, "I3, I6"},
    Judged{Kind::replay, "I3, I6, I10"},
    Judged{Kind::parameter_push, "I10"},
    Judged{Kind::logout, "I3; no commands"},
    Judged{Kind::disk_full, kOutside},
    Judged{Kind::disk_slow, kOutside},
    Judged{Kind::disk_error, kOutside},
    Judged{Kind::disk_power_cut, kOutside},
    Judged{Kind::clock_jump, kOutside},
    Judged{Kind::battery_weak, "uneven"},
    Judged{Kind::skid, "slipping"},
    Judged{Kind::fall_aside, "falling, lying"},
    Judged{Kind::faint, "falling, lying, dragged"},
    Judged{Kind::shove, "beside its command; rest; rolls away"},
    Judged{Kind::held, "beside its command; rest"},
    Judged{Kind::battery_full, "over voltage"},
    Judged{Kind::bridges_shorted, "runaway; beside its command"},
    Judged{Kind::sill, "nothing of its own: every rule as without"},
    Judged{Kind::step_down, "nothing of its own: every rule as without"},
    Judged{Kind::wrong_part, "silent node; I7: no motion"},
    Judged{Kind::strap_cut, "half led, dragged"},
    Judged{Kind::loose_strut, "every rule of the wheels"},
    Judged{Kind::touch_in_stop, "touched"},
    Judged{Kind::mute_core, "unheard"},
    Judged{Kind::lone_therapist, "I5; I11"},
    Judged{Kind::other_console, "I3"},
    Judged{Kind::held_before, "I7"},
    Judged{Kind::tuned_twice, "I10"},
    Judged{Kind::supply_rises, "high"},
};
static_assert([] {
  for (std::size_t i = 0; i < kJudged.size(); ++i)
    if (kJudged[i].kind != static_cast<Kind>(i)) return false;
  return kJudged.size() == static_cast<std::size_t>(Kind::count);
}());

// Brakes closed or servo holding: each wheel withstands this at the rim. Brake 8 N m, gear 0.6, rolling 0.3, on 0.10 m: 89 N. The servo's 6 A
// give 207 N.
constexpr double kBrake_n = 89.0, kHeld_n = 85.0;
// A wheel that was pushed beyond its brakes rolls out: from 0.5 m/s at half of the brakes' 2.2 m/s2, and the drive's own ramp.
constexpr double kRollsOut_s = 0.5;
constexpr int kSilent_steps = 6;  // 60 ms
constexpr int kTold_steps = 15;   // the io node tells of the batteries every 100 ms
// From a shorted bridge to rest: REACTIONS.gen.md, 0.96 s.
constexpr double kRunaway_s = 1.2;
// Alarms that end a motion led by hand as gently as its own end.
constexpr contract::FaultBits kSoftStops =
    any(HoistFault::patient_hanging, HoistFault::battery_empty, HoistFault::supply_high, HoistFault::wheel_slip, HoistFault::server_lost);

// Modes in which every alarm has its meaning: INIT checks everything when it ends; out of service only the cause stays.
bool watched(Mode mode) { return mode != Mode::init && mode != Mode::fault && mode != Mode::emergency_stop && mode != Mode::calibrate; }

}  // namespace

const RuleInfo& rule_info(Rule rule) { return kRules[static_cast<std::size_t>(rule)]; }
const Judged& judged_by(Kind kind) { return kJudged[static_cast<std::size_t>(kind)]; }

void Deadlines::restart() {
  since_s_ = none();
  in_force_s_ = never();
  holds_ = ends_ = false;
  acknowledged_bumpers_ = 0;
  battery_known_ = false;
  moving_s_ = follow_s_ = 0;
  muted_in_motion_ = false;
  barred_s_ = {};
}

double Deadlines::rest_m_s(const Truth& truth) {
  // A servo at zero gives way to a body that shakes the struts, and swings back.
  constexpr double kGives_m_s_n = 0.06 / 85.0;
  return kRest_m_s + kGives_m_s_n * std::min(truth.shaken_n, kHeld_n);
}

bool Deadlines::silent(Node node) const { return ears_.age(node) >= kSilent_steps; }

bool Deadlines::sensors_heard() const {
  return ears_.age(Node::tilt_left) <= 1 && ears_.age(Node::tilt_right) <= 1 && ears_.age(Node::tilt_base) <= 1 &&
         ears_.tilt(Node::tilt_left).valid && ears_.tilt(Node::tilt_right).valid && ears_.tilt(Node::tilt_base).valid;
}

bool Deadlines::drives_follow() const { return ears_.age(Node::drive_left) <= 1 && ears_.age(Node::drive_right) <= 1 && follow_s_ > 0.3; }

// The lean that the frames of the three sensors tell, against the true one.
bool Deadlines::lean_told_rightly() const { return judged_s_ - wrong_s_ > 0.3; }

void Deadlines::see(const Truth& truth) {
  seen_s_ = truth.time_s;
  const sim::Plant& plant = world_.plant();
  // A body is thrown along the way when the hoist brakes, against it when it speeds up: m a / k, 7 degrees for 75 kg at 0.5 m/s2.
  if (std::fabs(truth.acceleration_m_s2) > 0.3) {
    braked_s_ = seen_s_;
    throws_forward_ = truth.acceleration_m_s2 < 0;
  }
  // From 30 to 32 V a servo holds less and less (2231h:1).
  const double held_n = kHeld_n * std::clamp((32.0 - plant.supply_v()) / 2.0, 0.0, 1.0);
  if (truth.hardest_n > held_n) pushed_s_ = seen_s_;
  if (truth.touches) touch_s_ = seen_s_;
  const bool hands = plant.shove().forward_n != 0.0 || plant.shove().turn_n_m != 0.0;
  if (std::exchange(hands_, hands) && !hands) let_go_s_ = seen_s_;
  if (truth.lean_rad > 8.0 * kDegree_rad) leant_s_ = seen_s_;
  if (truth.chassis_rad > 4.0 * kDegree_rad) sloped_s_ = seen_s_;
  // Half the difference of the struts; the alarm's limit is 25 degrees between them.
  if (std::fabs(truth.turn_rad) > 0.9 * 12.5 * kDegree_rad) twisted_s_ = seen_s_;
  // The zero goes, or comes back.
  const bool off = board_.now(Kind::gyro_jump);
  if (std::exchange(zero_off_, off) != off) zero_s_ = seen_s_;
  // A strut that stands upright beside one that leans, and a box that tips forward, may both be those of a patient who turns.
  if (truth.strap_off || board_.now(Kind::loose_strut)) zero_s_ = seen_s_;
  for (const Node drive : {Node::drive_left, Node::drive_right}) {
    if (board_.now(Kind::freeze, drive)) frozen_s_ = seen_s_;
    if (board_.now(Kind::wheel_blocked, drive)) blocked_s_ = seen_s_;
    if (board_.shorted(drive) && plant.supply_v() > 1.0) short_s_ = seen_s_;
    if (board_.now(Kind::encoder_lost, drive) || board_.now(Kind::encoder_reversed, drive)) blind_s_ = seen_s_;
  }
  if (sways_.back(truth.side_m, 0.004)) swung_s_ = seen_s_;
  // Of a step the sensors' filter shows three quarters; what takes longer than half a stride is no step.
  constexpr double kStep_m = 0.008, kWide_m = 0.020, kStepless_s = 1.8, kHalfStride_s = 1.2;
  drawn_s_ = std::fabs(truth.speed_m_s) > 0.09 ? drawn_s_ + kStep_s : 0;
  if (drawn_s_ > kStepless_s) stepless_s_ = seen_s_;
  // Of the same step the sensors may show enough as soon as it turns.
  if (steps_.back(truth.side_m, kStep_m, kHalfStride_s)) drawn_s_ = std::min(drawn_s_, steps_.took_s());
  if (wide_steps_.back(truth.side_m, kWide_m)) widely_s_ = seen_s_;
  // The rim of a wheel against the floor under it.
  const double turn_m_s = truth.yaw_rate_rad_s * plant.params().track_width_m / 2.0;
  if (std::max(std::fabs(truth.wheel_m_s[0] - truth.speed_m_s + turn_m_s), std::fabs(truth.wheel_m_s[1] - truth.speed_m_s - turn_m_s)) >
      kRest_m_s)
    slid_s_ = seen_s_;
  // What a push left, or the supply when it went: it falls as the brakes slow a wheel, less what still pulls at it.
  constexpr double kBrakes_m_s2 = 1.2;
  const bool cut = board_.now(Kind::power_cut), goes = !std::exchange(cut_, cut) && cut;
  // Between its bridge and its brake a wheel is free. A bridge that comes on opens the brake at once, and what rolls out goes on until the current
  // has risen.
  constexpr double kRises_s = 0.05;
  const double brake_s = plant.params().brake_close_s + kStep_s;
  for (const sim::Side side : {sim::Side::left, sim::Side::right}) {
    const bool on = plant.bridge_enabled(side), was_on = std::exchange(bridge_on_[static_cast<std::size_t>(side)], on);
    if (was_on && !on) free_until_s_ = seen_s_ + brake_s;
    if (!was_on && on && coast_m_s_ > 0) free_until_s_ = std::max(free_until_s_, seen_s_ + kRises_s);
  }
  const bool pulled = goes || seen_s_ < free_until_s_ || seen_s_ - std::max({pushed_s_, touch_s_, slid_s_}) < kRollsOut_s;
  coast_m_s_ = pulled ? truth.fastest_m_s : coast_m_s_ - kStep_s * kBrakes_m_s2 * std::max(0.0, 1.0 - truth.hardest_n / kBrake_n);
}

void Deadlines::take_frames(const Truth& truth) {
  const sim::Plant& plant = world_.plant();
  // As long as the core is told of them.
  const double sum_v = plant.battery_v(0) + plant.battery_v(1), apart_v = plant.battery_v(0) - plant.battery_v(1);
  if (!battery_known_) battery_v_ = {sum_v, apart_v};
  battery_known_ = true;
  // A line that damages characters also damages voltages, which are believed within their range.
  if (ears_.battery_age() == 0 &&
      (std::fabs(ears_.battery_v(0) - plant.battery_v(0)) > 0.5 || std::fabs(ears_.battery_v(1) - plant.battery_v(1)) > 0.5))
    battery_wrong_s_ = seen_s_;
  if (ears_.battery_age() < kTold_steps) {
    battery_v_[0] += (sum_v - battery_v_[0]) * kStep_s;
    battery_v_[1] += (apart_v - battery_v_[1]) * kStep_s;
  }
  // What the frames say of the lean.
  const auto& left = ears_.tilt(Node::tilt_left);
  const auto& right = ears_.tilt(Node::tilt_right);
  const auto& base = ears_.tilt(Node::tilt_base);
  const double forward_rad = (left.forward_rad + right.forward_rad) / 2.0 - base.forward_rad;
  const double right_rad = (left.right_rad + right.right_rad) / 2.0 - base.right_rad;
  // The filter shows a quick fall to the side up to a degree later still: 35 ms at 29 degrees a second.
  const bool quick = truth.outward_rad_s > 25.0 * kDegree_rad;
  const double hidden_rad = quick ? kFiltered_rad + 1.0 * kDegree_rad : kFiltered_rad;
  if (!sensors_heard() || std::hypot(forward_rad - truth.forward_rad, right_rad - truth.right_rad) > hidden_rad) wrong_s_ = judged_s_;
  bool follow = true;
  for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
    const auto& drive = ears_.drive(side);
    const bool runs = contract::canopen::drive::state(drive.status) == contract::canopen::drive::State::operation_enabled;
    follow = follow && runs && drive.told_to_run;
    // Also while it ends a stop of its own, which no command interrupts, as long as the other one is driven on.
    const bool driven = drive.told_to_run || ears_.drive(1 - side).told_to_run;
    dropped_s_[side] = moves(mode_) && driven && !runs ? dropped_s_[side] + kStep_s : 0;
  }
  follow_s_ = follow ? follow_s_ + kStep_s : 0;
}

// A wheel that a shorted bridge turns while nothing may move, and no body. The core sees it in the drive's own words, so what a silent drive's
// bridge does on a hoist that stands is not seen (README.md). Without a bus or an input node, which feeds the relay, its circuit opens it a second
// after the last feed, and the brake does the rest.
void Deadlines::take_runaway(const Truth& truth) {
  constexpr double kRelayAlone_s = 1.6;
  const bool unfed = !ears_.bus_up() || silent(Node::io);
  for (const Node drive : {Node::drive_left, Node::drive_right}) {
    const std::size_t side = drive == Node::drive_left ? 0 : 1;
    const bool away = !moves(mode_) && board_.shorted(drive) && std::fabs(truth.wheel_m_s[side]) > 0.05;
    if (!away) {
      away_s_[side] = 0;
      unfed_left_s_[side] = kRelayAlone_s;
    } else if (unfed && unfed_left_s_[side] > 0) {
      unfed_left_s_[side] -= kStep_s;
    } else if (!dragged(truth) && (unfed || !silent(drive))) {
      away_s_[side] += kStep_s;
    }
  }
}

void Deadlines::take_bars(const Truth& truth) {
  const sim::Plant& plant = world_.plant();
  bool silence = false, blind = false;
  for (std::size_t n = 0; n < contract::kRemoteNodeCount; ++n) silence = silence || silent(static_cast<Node>(n));
  for (const Node node : {Node::tilt_left, Node::tilt_right, Node::tilt_base})
    blind = blind || (ears_.age(node) <= 1 && !ears_.tilt(node).valid);
  // A wheel is believed to rest by what its encoder says.
  const bool turns = truth.fastest_m_s > 0.1 && !beyond_the_hoist(truth);
  const std::array<bool, kBarCount> now{plant.bumpers() != 0,
                                        (plant.bumpers() & ~acknowledged_bumpers_) != 0,
                                        plant.emergency_stop(),
                                        silence,
                                        blind,
                                        (battery_v_[0] < 21.8 || battery_v_[0] > 29.7) && battery_told_rightly(),
                                        turns,
                                        board_.now(Kind::wrong_part)};
  for (std::size_t bar = 0; bar < kBarCount; ++bar) barred_s_[bar] = now[bar] ? barred_s_[bar] + kStep_s : 0;
}

std::string_view Deadlines::start_barred(Mode to) const {
  constexpr double kKnown_s = 0.2, kMean_s = 0.6;
  // In REMOTE the hoist may be driven away from what it touches, once that was acknowledged.
  if (barred_s_[to == Mode::remote ? fresh_touch : touching] > kKnown_s) return "I7: a start against a pressed bumper";
  if (barred_s_[chain] > kKnown_s) return "I7: a start with the emergency stop pressed";
  if (barred_s_[silent_node] > kKnown_s) return "I7: a start without one of the nodes";
  if (barred_s_[blind_sensor] > kKnown_s) return "I7: a start with a sensor that knows nothing";
  if (barred_s_[no_battery] > kMean_s) return "I7: a start with empty batteries, or a supply that is too high";
  if (barred_s_[unchecked] > kKnown_s) return "I7: a start with a part that was never checked";
  if (barred_s_[turning] > kKnown_s) return "I7: a start while a wheel turns";
  return {};
}

// A gyroscope whose zero went off by 6.5 degrees a second or more, in a sensor that is heard and has nothing else. One that is measured anew has
// a new zero.
bool Deadlines::believes_lost_zero() const {
  constexpr double kFound_rad_s = 6.5 * kDegree_rad, kJump_rad_s = 0.35;
  return std::any_of(board_.rows.begin(), board_.rows.end(), [&](const Planned& row) {
    const Node node = row.fault.node;
    return row.fault.kind == Kind::gyro_jump && row.on && std::fabs(row.fault.size - 0.5) * kJump_rad_s > kFound_rad_s && !stuck(node) &&
           ears_.age(node) <= 1 && ears_.tilt(node).valid && ears_.tilt(node).settled_steps * kStep_s > seen_s_ - row.fault.start_s;
  });
}

bool Deadlines::holds(Rule rule, const Truth& truth, Mode mode) const {
  const sim::Plant& plant = world_.plant();
  const auto any_tilt = [&](auto what) { return what(Node::tilt_left) || what(Node::tilt_right) || what(Node::tilt_base); };
  const bool bus_settled = ears_.bus_age() > 60;
  const bool moving = moves(mode);
  // Where the body goes because the hoist itself brakes or starts: along the way, and not mainly to a side.
  const bool along = std::fabs(truth.right_rad) < std::fabs(truth.forward_rad) + kFiltered_rad;
  const bool thrown = seen_s_ - braked_s_ < 0.4 && (truth.forward_rad > 0) == throws_forward_ && along;
  switch (rule) {
    case Rule::silent_drive_left:
    case Rule::silent_drive_right:
    case Rule::silent_io:
    case Rule::silent_tilt_left:
    case Rule::silent_tilt_right:
    case Rule::silent_tilt_base: {
      const auto node = static_cast<Node>(static_cast<std::size_t>(rule));
      return bus_settled && silent(node);
    }
    case Rule::bus_gone: {
      bool all = true;
      for (std::size_t n = 0; n < contract::kRemoteNodeCount; ++n) all = all && silent(static_cast<Node>(n));
      return all || !ears_.bus_up();
    }
    case Rule::two_of_one:
      for (const Node node : {Node::drive_left, Node::drive_right, Node::tilt_left, Node::tilt_right, Node::tilt_base})
        if (ears_.twice_run(static_cast<std::size_t>(node)) >= 10) return true;
      return false;
    case Rule::flood:
      return ears_.strangers() > 45;
    case Rule::left_drive_fails:
    case Rule::right_drive_fails: {
      using State = contract::canopen::drive::State;
      const std::size_t side = rule == Rule::left_drive_fails ? 0 : 1;
      const State state = contract::canopen::drive::state(ears_.drive(side).status);
      // What the core switched off itself reports a fault of its supply.
      return (state == State::fault || state == State::fault_reaction) &&
             ears_.age(side == 0 ? Node::drive_left : Node::drive_right) <= 1 && world_.relay_closed();
    }
    case Rule::left_drive_drops:
    case Rule::right_drive_drops:
      return moving && moving_s_ > 0.6 && dropped_s_[rule == Rule::left_drive_drops ? 0 : 1] > 0.02;
    case Rule::blind_encoder:
      for (const Node drive : {Node::drive_left, Node::drive_right})
        if ((board_.now(Kind::encoder_lost, drive) || board_.now(Kind::encoder_reversed, drive)) &&
            std::fabs(truth.wheel_m_s[drive == Node::drive_left ? 0 : 1]) > 0.12)
          return true;
      return false;
    case Rule::nonsense:
      return any_tilt([&](Node node) {
        // Among frames that come twice, which have an alarm of their own, half of the jumps are lost.
        return board_.now(Kind::sensor_garbage, node) && !board_.now(Kind::sensor_silent, node) && ears_.age(node) <= 1 &&
               ears_.tilt(node).valid && ears_.twice_run(static_cast<std::size_t>(node)) == 0;
      });
    case Rule::beyond_stops: {
      // A body that is thrown into the stops shakes every accelerometer. While the fall alarm holds the hoist, no angle leads it.
      if (!sensors_heard() || in_force(HoistFault::fall_detected)) return false;
      const auto& base = ears_.tilt(Node::tilt_base);
      const auto far = [&](Node node) {
        const auto& strut = ears_.tilt(node);
        return std::max(std::fabs(strut.forward_rad - base.forward_rad), std::fabs(strut.right_rad - base.right_rad)) > 19.0 * kDegree_rad;
      };
      return far(Node::tilt_left) || far(Node::tilt_right);
    }
    case Rule::stuck:
      return moving && std::fabs(truth.wheel_m_s[0]) > kRolls_m_s && std::fabs(truth.wheel_m_s[1]) > kRolls_m_s && sensors_heard() &&
             any_tilt([&](Node node) { return stuck(node); });
    case Rule::invalid:
      return any_tilt([&](Node node) { return ears_.age(node) <= 1 && !ears_.tilt(node).valid; });
    case Rule::wrong_lean: {
      // A gyroscope whose zero is off by 9 degrees a second is found within 2.0 s, by 7 within 5.2 s, by 6 within 6.1 s (H8 asks for 1 s).
      constexpr double kZeroFound_s = 6.2;
      if (!moving || !sensors_heard() || seen_s_ - zero_s_ < kZeroFound_s) return false;
      // A sensor that repeats itself is told from one that is still by rolling: rule `stuck`.
      const bool slow = std::fabs(truth.wheel_m_s[0]) <= kRolls_m_s || std::fabs(truth.wheel_m_s[1]) <= kRolls_m_s;
      if (slow && any_tilt([&](Node node) { return stuck(node); })) return false;
      const auto& left = ears_.tilt(Node::tilt_left);
      const auto& right = ears_.tilt(Node::tilt_right);
      const auto& base = ears_.tilt(Node::tilt_base);
      return std::fabs((left.forward_rad + right.forward_rad) / 2.0 - base.forward_rad - truth.forward_rad) > 5.0 * kDegree_rad;
    }
    case Rule::half_led:
      return moving && plant.strap_holds(sim::Side::left) != plant.strap_holds(sim::Side::right) && sensors_heard() &&
             std::fabs(truth.speed_m_s) > 0.12 && seen_s_ - widely_s_ < 1.6;
    case Rule::touched:
      return (plant.bumpers() & ~acknowledged_bumpers_) != 0 && ears_.age(Node::io) <= 1;
    case Rule::falling:
      return moving && truth.lean_rad > 12.0 * kDegree_rad && truth.outward_rad_s > 29.0 * kDegree_rad && !thrown && lean_told_rightly();
    case Rule::lying:
      return moving && truth.lean_rad > 14.8 * kDegree_rad && seen_s_ - braked_s_ > 0.6 && lean_told_rightly();
    case Rule::leaning:
      return moving && truth.lean_rad > 11.5 * kDegree_rad && lean_told_rightly();
    case Rule::dragged:
      // A hoist that is led by another may be empty, and an empty one does not lean.
      return (mode == Mode::user || (moving && truth.lean_rad > 4.0 * kDegree_rad)) && std::fabs(truth.speed_m_s) > 0.12 &&
             seen_s_ - swung_s_ > 0.05 && lean_told_rightly();
    case Rule::rolls_away:
      return mode == Mode::standby && truth.lean_rad > 14.8 * kDegree_rad && lean_told_rightly() && seen_s_ - blind_s_ > 0.7 &&
             ears_.age(Node::drive_left) <= 1 && ears_.age(Node::drive_right) <= 1 && truth.fastest_m_s > 0.15;
    case Rule::lies_stopped:
      return mode == Mode::protective_stop && truth.lean_rad > 14.8 * kDegree_rad && sensors_heard() && lean_told_rightly();
    case Rule::empty:
      return battery_v_[0] < 21.8 && battery_told_rightly();
    case Rule::high:
      return battery_v_[0] > 29.7 && battery_told_rightly();
    case Rule::weak:
      return battery_v_[0] < 22.8 && battery_told_rightly();
    case Rule::uneven:
      return std::fabs(battery_v_[1]) > 0.55 && battery_told_rightly();
    case Rule::steep:
    case Rule::sloping: {
      const auto& base = ears_.tilt(Node::tilt_base);
      // What the sensor's filter hides; a sensor that lied hides more until it has unlearnt.
      constexpr double kHidden_rad = 0.7 * kDegree_rad;
      const double limit_rad = (rule == Rule::steep ? 8.0 : 5.0) * kDegree_rad + kHidden_rad;
      const bool told = std::hypot(base.forward_rad - truth.chassis_forward_rad, base.right_rad - truth.chassis_right_rad) < kHidden_rad;
      return truth.chassis_rad > limit_rad && ears_.age(Node::tilt_base) <= 1 && base.valid && told;
    }
    case Rule::no_commands:
      // At rest driving ends without an alarm.
      return truth.fastest_m_s > kRest_m_s && holds_ && (mode == Mode::remote || mode == Mode::guided) && truth.time_s - held_s_ > 0.27;
    case Rule::no_server:
      return ears_.server_age() >= 27 && (ears_.server_age() < Ears::kNever || ears_.steps() > 510);
    case Rule::beside_command: {
      if (!drives_follow() || !(moving || mode == Mode::protective_stop)) return false;
      for (const std::size_t side : {std::size_t{0}, std::size_t{1}})
        if (std::fabs(truth.wheel_m_s[side] - ears_.drive(side).followed_m_s) > 0.2) return true;
      return false;
    }
    case Rule::runaway:
      return away_s_[0] > kRunaway_s || away_s_[1] > kRunaway_s;
    case Rule::late:
      return ears_.too_late() && moving;
    case Rule::chain_open:
      return plant.emergency_stop() && ears_.age(Node::io) <= 1;
    case Rule::unpowered:
      return plant.supply_v() < 1.0 && world_.relay_closed() && !plant.emergency_stop() && ears_.age(Node::io) <= 1 &&
             ears_.battery_age() < kTold_steps && ears_.battery_v(0) + ears_.battery_v(1) > 20.5 && ears_.age(Node::drive_left) <= 1 &&
             ears_.age(Node::drive_right) <= 1;
    case Rule::over_voltage:
      return moving && plant.supply_v() > 32.5 && ears_.age(Node::drive_left) <= 1 && ears_.age(Node::drive_right) <= 1;
    case Rule::slipping: {
      const double wheels_rad_s = (truth.wheel_m_s[1] - truth.wheel_m_s[0]) / plant.params().track_width_m;
      return moving && drives_follow() && std::fabs(wheels_rad_s - truth.yaw_rate_rad_s) > 0.2 && ears_.rates_age() <= 1 &&
             ears_.tilt(Node::tilt_base).valid;
    }
    case Rule::unheard:
      return muted_in_motion_;
    case Rule::zero_lost:
      return believes_lost_zero();
    case Rule::count:
      break;
  }
  return false;
}

bool Deadlines::answered(const RuleInfo& rule, double since_s, Mode mode) const {
  if (rule.rest_answers && !moves(mode)) return true;
  if (rule.rule == Rule::no_commands && ends_) return true;
  for (std::size_t bit = 0; bit < in_force_s_.size(); ++bit)
    if ((rule.answers >> bit & 1U) != 0 && in_force_s_[bit] >= since_s - kLook_s) return true;
  return false;
}

Rule Deadlines::after_step(const Told& told, const Truth& truth, contract::FaultBits raised) {
  judged_s_ += kStep_s;
  const auto mode = static_cast<Mode>(told.record.mode);
  const Mode before = mode_;
  moving_s_ = moves(mode) ? moving_s_ + kStep_s : 0;
  // A hold that is old when a motion begins counts as released.
  if (moves(mode) && !moves(before) && truth.time_s - held_s_ > 0.25) holds_ = false;
  for (std::size_t bit = 0; bit < in_force_s_.size(); ++bit)
    if (((told.record.fault_bits | raised) >> bit & 1U) != 0) in_force_s_[bit] = judged_s_;
  take_frames(truth);
  if (moves(mode) && !moves(before)) ends_ = false;
  const auto exercise = static_cast<contract::GuidedEnd>(told.record.guided_end);
  const bool exercise_over =
      mode == Mode::guided && (exercise == contract::GuidedEnd::finished || exercise == contract::GuidedEnd::off_path);
  ends_ = ends_ || exercise_over || (raised & kSoftStops) != 0;
  acknowledged_bumpers_ &= world_.plant().bumpers();
  mode_ = mode;
  if (const bool muted = board_.now(Kind::mute_core); std::exchange(muted_, muted) != muted) muted_in_motion_ = muted && moves(before);
  muted_in_motion_ = muted_in_motion_ && moves(mode);
  take_runaway(truth);
  take_bars(truth);
  Rule broken = Rule::count;
  due_ = Rule::count;
  for (const RuleInfo& rule : kRules) {
    double& since_s = since_s_[static_cast<std::size_t>(rule.rule)];
    // The mode in which the step began decides what must be found in it.
    if (!watched(mode) || !watched(before) || !holds(rule.rule, truth, rule.rule == Rule::late ? before : mode)) {
      since_s = -1.0;
      continue;
    }
    if (since_s < 0) since_s = judged_s_;
    const double over_s = judged_s_ - since_s - rule.within_s;
    if (over_s > -1e-6 && over_s < kStep_s - 1e-6 && rule.braking_m_s2 > 0 &&
        (due_ == Rule::count || rule.braking_m_s2 > rule_info(due_).braking_m_s2))
      due_ = rule.rule;
    if (judged_s_ - since_s > rule.within_s - 1e-6 && !answered(rule, since_s, mode)) {
      since_s = judged_s_;
      broken = rule.rule;
    }
  }
  return broken;
}

bool Deadlines::dragged(const Truth& truth) const {
  // Wheels that slide are dragged by the platform when they grip again.
  return seen_s_ - std::max({pushed_s_, touch_s_, slid_s_}) < kRollsOut_s || (coast_m_s_ > 0 && truth.fastest_m_s <= coast_m_s_);
}

bool Deadlines::beyond_the_hoist(const Truth& truth) const {
  // The drive finds a shorted bridge or a broken encoder, the core stops and takes the supply away.
  return dragged(truth) || seen_s_ - short_s_ < kRunaway_s || seen_s_ - blind_s_ < 0.7 || seen_s_ - frozen_s_ < 0.7;
}

bool Deadlines::battery_told_rightly() const { return ears_.battery_age() < kTold_steps && seen_s_ - battery_wrong_s_ > 3.0; }

bool Deadlines::comes_free() const { return seen_s_ - std::max(blocked_s_, let_go_s_) < kRollsOut_s; }

bool Deadlines::explained(HoistFault cause) const {
  constexpr double kLately_s = 5.0;
  switch (cause) {
    case HoistFault::patient_hanging:
      return seen_s_ - std::max(leant_s_, stepless_s_) < kLately_s;
    case HoistFault::fall_detected:
      return seen_s_ - leant_s_ < kLately_s;
    case HoistFault::tilt_implausible:
      return seen_s_ - twisted_s_ < kLately_s;
    case HoistFault::bumper_pressed:
      return seen_s_ - touch_s_ < kLately_s;
    case HoistFault::base_tilted:
      return seen_s_ - sloped_s_ < kLately_s;
    case HoistFault::wheel_slip:
      return seen_s_ - slid_s_ < kLately_s;
    case HoistFault::battery_empty:
      return battery_v_[0] < 22.2;
    case HoistFault::supply_high:
      return battery_v_[0] > 29.3;
    default:
      return false;
  }
}

}  // namespace hoist::chaos
