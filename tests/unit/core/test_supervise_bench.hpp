// Random situations for the rules of control/core/supervise, each with what a rule needs to know of it in its own words.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <string>
#include <vector>

#include "control/core/standstill.hpp"
#include "tests/unit/core/dice.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test::supervise {

using contract::Event;
using contract::FaultBits;
using contract::Reaction;

// ----- sets of faults, from faults.def and the words beside each rule -----

constexpr FaultBits set_of(std::initializer_list<Fault> faults) {
  FaultBits bits = 0;
  for (const Fault fault : faults) bits |= FaultBits{1} << static_cast<unsigned>(fault);
  return bits;
}
inline FaultBits all_with(Reaction reaction) {
  FaultBits bits = 0;
  for (const contract::FaultInfo& row : contract::kFaults) bits |= row.reaction == reaction ? FaultBits{1} << row.bit : FaultBits{0};
  return bits;
}
inline FaultBits stops() { return all_with(Reaction::protective_stop); }
inline FaultBits breakdowns() { return all_with(Reaction::out_of_service); }
inline FaultBits power_offs() { return all_with(Reaction::power_off); }
/// Stay until they are acknowledged.
inline FaultBits kept_faults() { return stops() | breakdowns() | power_offs(); }
/// A button, a touch, a fall, a slope.
constexpr FaultBits kNoMachine = set_of({Fault::stop_pressed, Fault::bumper_pressed, Fault::fall_detected, Fault::base_tilted});
constexpr FaultBits kPlugs = set_of({Fault::tilt_left_lost, Fault::tilt_right_lost, Fault::tilt_base_lost, Fault::drive_left_lost,
                                     Fault::drive_right_lost, Fault::io_lost, Fault::bus_down});
constexpr FaultBits kLeftDrive = set_of({Fault::drive_left_fault}), kRightDrive = set_of({Fault::drive_right_fault});
constexpr FaultBits kDrives = kLeftDrive | kRightDrive, kTouch = set_of({Fault::bumper_pressed}), kTooMany = set_of({Fault::control_fault});

inline FaultBits some_faults(Dice& dice) {
  const std::size_t kind = dice.below(5);
  FaultBits bits = 0;
  if (kind < 2) return bits;
  if (kind < 4) return FaultBits{1} << contract::kFaults[dice.below(contract::kFaults.size())].bit;
  for (const contract::FaultInfo& row : contract::kFaults) bits |= dice.chance(0.12) ? FaultBits{1} << row.bit : FaultBits{0};
  return bits;
}

// ----- situations -----

constexpr Mode kEveryMode[] = {Mode::init,      Mode::standby, Mode::user,  Mode::remote,        Mode::protective_stop,
                               Mode::calibrate, Mode::guided,  Mode::fault, Mode::emergency_stop};
constexpr bool moves(Mode mode) { return mode == Mode::user || mode == Mode::remote || mode == Mode::guided; }

/// What the rules ask about a situation.
struct Facts {
  int angles_ms = 0, rates_ms = 0;  // age of the oldest
  bool drive_lost = false, io_lost = false, volts_known = true, settled = true;
  bool running = true, other_version = false, zeroed = true, checked = true;
  bool upright = true, pushed = false, held = false, path = false;
  bool left_in_fault = false, right_in_fault = false;  // a drive that is heard says so
  std::uint8_t touching = 0, known_touching = 0;
};

inline contract::CanFrame angles(double alpha_deg, double beta_deg, std::uint8_t status, std::uint8_t counter = 1) {
  contract::CanFrame frame{0, 6, 0, {}};
  contract::write_slot(frame, contract::pdo_slot(contract::Pdo::tilt_tx1, 0x6010), std::lround(alpha_deg * 1000));
  contract::write_slot(frame, contract::pdo_slot(contract::Pdo::tilt_tx1, 0x6020), std::lround(beta_deg * 1000));
  contract::write_slot(frame, contract::pdo_slot(contract::Pdo::tilt_tx1, 0x2120), status);
  contract::write_slot(frame, contract::pdo_slot(contract::Pdo::tilt_tx1, 0x2121), counter);
  return frame;
}
inline contract::CanFrame drive_state(std::uint16_t status, double current_norm = 0) {
  contract::CanFrame frame{0, 8, 0, {}};
  contract::write_slot(frame, contract::pdo_slot(contract::Pdo::drive_tx1, 0x6041), status);
  contract::write_slot(frame, contract::pdo_slot(contract::Pdo::drive_tx1, 0x6078), std::lround(current_norm * 1000));
  return frame;
}
inline contract::CanFrame supply(std::uint16_t error, double supply_v) {
  contract::CanFrame frame{0, 8, 0, {}};
  contract::write_slot(frame, contract::pdo_slot(contract::Pdo::drive_tx2, 0x603F), error);
  contract::write_slot(frame, contract::pdo_slot(contract::Pdo::drive_tx2, 0x2211), std::lround(supply_v * 100));
  return frame;
}

/// A pelvis turned by 28 degrees, and two wheels that stand while they are to roll and their motors push.
inline MonitorList odd_monitors(CoreState seen) {
  seen.sensed.left_strut.restart();
  seen.sensed.left_strut.take_angles(angles(14, 0, 3));
  seen.sensed.right_strut.restart();
  seen.sensed.right_strut.take_angles(angles(-14, 0, 3));
  for (DriveSensor* drive : {&seen.sensed.left_drive, &seen.sensed.right_drive})
    static_cast<void>(drive->take_state(drive_state(0x27, 0.9), 1e9));
  seen.sensed.odometry = {};
  const MonitorView view{.sensed = seen.sensed,
                         .health = seen.health,
                         .params = seen.params,
                         .mode = Mode::user,
                         .moving = true,
                         .powered = true,
                         .latched = 0,
                         .left_command_m_s = 0.6,
                         .right_command_m_s = 0.6,
                         .left_control = seen.left_control,
                         .right_control = seen.right_control,
                         .bus_up = true,
                         .bus_settled = true,
                         .server_alive = true,
                         .server_seen = true,
                         .console_gone = false,
                         .remote_lost = false,
                         .held_back = false,
                         .relay_cut = false,
                         .bumpers_acknowledged = 0,
                         .wake_lateness_s = 0,
                         .ticks = 1000,
                         .dt_s = 0.01};
  for (int i = 0; i < 20; ++i) static_cast<void>(check_all(seen.monitors, view));
  return seen.monitors;
}

/// A set of nodes that were met.
struct Met {
  BusMaster master;
  bool simulated = false, other_version = false;
};
struct Bases {
  CoreState ready;  // STANDBY, client 7 leads, nothing is against a start
  std::vector<Met> met;
  MonitorList odd;  // they have seen a twisted pelvis and wheels that are held back: detail code 1 of both
};
inline const Bases& bases() {
  static const Bases all = [] {
    Bases made;
    for (const bool real : {false, true})
      for (const bool other : {false, true}) {
        ScriptedHoist hoist;
        hoist.real = real;
        std::uint32_t serial = 0x1001;
        hoist.each([&serial](contract::Node, FakeNode& node) { node.serial = serial++; });
        if (other) hoist.tilt_right.revision = kRevision + 0x00010000;
        EXPECT_TRUE(hoist.ready());
        if (!real && !other) made.ready = hoist.state;
        made.met.push_back({hoist.state.master, !real, other});
      }
    made.odd = odd_monitors(made.ready);
    return made;
  }();
  return all;
}

template <typename Sensor>
void wait(Sensor& sensor, std::size_t steps) {
  for (std::size_t i = 0; i < steps; ++i) sensor.next_tick();
}
/// Steps since a message: mostly none.
inline std::size_t age(Dice& dice) { return dice.chance(0.85) ? 0 : dice.of<std::size_t>({1, 2, 3, 4, 5, 6, 300}); }

inline void set_tilt(TiltSensor& tilt, bool rates, Facts& facts, Dice& dice) {
  std::uint8_t status = tilt_status::kValid;
  if (dice.chance(0.85)) status |= tilt_status::kConverged;
  if (dice.chance(0.1)) status |= tilt_status::kAccelerationOutOfRange;
  if (dice.chance(0.1)) status |= tilt_status::kGyroSaturated;
  if (dice.chance(0.1)) status |= tilt_status::kSelfTestFailed;
  const std::size_t between = age(dice), since = age(dice);
  const bool rates_last = dice.chance(0.5);
  tilt.restart();
  for (const bool first : {true, false}) {
    if (first == rates_last) {
      tilt.take_angles(angles(0, 0, status));
    } else {
      tilt.take_rates({0, 6, 0, {}});
    }
    wait(tilt, first ? between : since);
  }
  const int late_ms = static_cast<int>(since) * 10, later_ms = static_cast<int>(since + between) * 10;
  facts.angles_ms = std::max(facts.angles_ms, rates_last ? later_ms : late_ms);
  if (rates) facts.rates_ms = rates_last ? late_ms : later_ms;
  facts.settled = facts.settled && (status & tilt_status::kConverged) != 0;
}

/// Of CiA 402: on its way, ready, enabled, in its fault or braking for it, in its quick stop.
inline bool set_drive(DriveSensor& drive, Facts& facts, Dice& dice) {
  const auto status = dice.of<std::uint16_t>({0x40, 0x21, 0x27, 0x27, 0x08, 0x0F, 0x07});
  const std::size_t since = age(dice);
  drive.restart();
  static_cast<void>(drive.take_state(drive_state(status), 1e9));
  wait(drive, since);
  facts.drive_lost = facts.drive_lost || since >= 5;
  return since < 5 && (status == 0x08 || status == 0x0F);
}

inline void set_sensors(CoreState& state, Facts& facts, Dice& dice) {
  Estimate& sensed = state.sensed;
  set_tilt(sensed.left_strut, false, facts, dice);
  set_tilt(sensed.right_strut, false, facts, dice);
  set_tilt(sensed.base, true, facts, dice);
  facts.left_in_fault = set_drive(sensed.left_drive, facts, dice);
  facts.right_in_fault = set_drive(sensed.right_drive, facts, dice);
  sensed.odometry.standing_still = dice.chance(0.8);
  facts.touching = dice.chance(0.6) ? std::uint8_t{0} : static_cast<std::uint8_t>(dice.below(16));
  facts.known_touching = dice.chance(0.5) ? facts.touching : static_cast<std::uint8_t>(dice.below(16));
  facts.volts_known = dice.chance(0.9);
  sensed.io.restart();
  if (facts.volts_known) sensed.io.take_batteries({0, 8, 0, {}});
  contract::CanFrame inputs{0, 2, 0, {}};
  inputs.data[0] = facts.touching;
  sensed.io.take_inputs(inputs);
  const std::size_t since = age(dice);
  wait(sensed.io, since);
  facts.io_lost = since >= 5;
  state.acknowledgement.accept(facts.known_touching);
}

inline void set_nodes(CoreState& state, Facts& facts, Dice& dice) {
  const Met& met = bases().met[dice.chance(0.5) ? 0 : dice.below(bases().met.size())];
  state.master = met.master;
  facts.running = dice.chance(0.9);
  facts.other_version = met.other_version;
  if (!facts.running) {
    state.master.meet_all_again();
    facts.other_version = false;  // not asked yet
  }
  contract::Params& p = state.params;
  p.calibrated_zero_s = dice.chance(0.5) ? 1.7e9 : 0;
  for (double contract::Params::*const check :
       {&contract::Params::calibrated_encoders_s, &contract::Params::calibrated_bumpers_s, &contract::Params::calibrated_struts_s})
    p.*check = dice.chance(0.8) ? 1.7e9 : 0;
  const bool same = dice.chance(0.7);
  p.calibrated_nodes_id = static_cast<double>(state.master.nodes_id()) + (same ? 0 : 1);
  facts.zeroed = met.simulated || p.calibrated_zero_s > 0;
  facts.checked = met.simulated || (same && p.calibrated_encoders_s > 0 && p.calibrated_bumpers_s > 0 && p.calibrated_struts_s > 0);
}

/// The driver's hand, `lease` already set.
inline void set_hand(CoreState& state, Facts& facts, Dice& dice) {
  constexpr std::uint64_t kSent_ns = 5'000'000'000;
  const double stick = dice.chance(0.5) ? 0.5 : 0.0;
  const bool hold = dice.chance(0.5), fresh = dice.chance(0.7);
  state.remote.reset();
  const Lease lease{3, 7};
  EXPECT_TRUE(state.remote.take({3, 7, 1, kSent_ns, stick, 0, hold ? 1U : 0U}, lease, kSent_ns, 1.0));
  state.params.remote_stop_age_s = dice.any(0.1, 0.25);
  const double age_s = fresh ? dice.any(0, 0.99) * state.params.remote_stop_age_s : state.params.remote_stop_age_s + dice.any(0.001, 0.1);
  state.time_ns = kSent_ns + static_cast<std::uint64_t>(age_s * 1e9);
  facts.held = hold && fresh;
  facts.pushed = facts.held && stick > 0;
}

inline void set_motion(CoreState& state, Dice& dice) {
  state.limiter.reset();
  if (dice.chance(0.2)) state.limiter.start_from(state.params, dice.chance(0.5) ? 0.2 : 0.0, 0.1);
}

/// Anything that may be, in the given mode.
inline Facts set_situation(CoreState& state, Mode mode, Dice& dice) {
  Facts facts;
  state.mode = mode;
  state.in_mode = {};
  state.latched = some_faults(dice);
  state.conditions = some_faults(dice);
  set_sensors(state, facts, dice);
  set_nodes(state, facts, dice);
  set_hand(state, facts, dice);
  set_motion(state, dice);
  state.lease = {dice.of<std::uint32_t>({3, 4}), dice.chance(0.8) ? dice.of<std::uint32_t>({1, 7}) : 0U};
  facts.upright = dice.chance(0.8);
  if (!facts.upright) state.intent.restart();
  facts.path = dice.chance(0.6);
  state.guided = {};
  if (facts.path) state.guided.load({contract::GuidedShape::straight, false, 2.0, 0, 0.2, 1});
  state.still.ticks = dice.of<std::uint16_t>({0, 99, 100, 100, 100});
  state.in_mode.silent.ticks = dice.of<std::uint16_t>({0, 249, 250, 250});
  return facts;
}

/// Collects what a function tells.
class Told {
 public:
  explicit Told(CoreState& state) { state.events.begin(list_); }
  [[nodiscard]] std::vector<Event> of(EventKind kind) const {
    std::vector<Event> some;
    for (const Event& event : list_)
      if (event.kind == kind) some.push_back(event);
    return some;
  }
  [[nodiscard]] FaultBits faults(EventKind kind) const {
    FaultBits bits = 0;
    for (const Event& event : of(kind)) {
      EXPECT_EQ(bits >> event.code & 1U, 0U) << "told twice";
      bits |= FaultBits{1} << event.code;
    }
    return bits;
  }
  [[nodiscard]] std::size_t count() const { return list_.size(); }

 private:
  EventSink::List list_;
};

}  // namespace hoist::core::test::supervise
