#include "tests/chaos/watch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <span>

#include "control/contract/guided_path.hpp"
#include "control/contract/params.hpp"
#include "control/core/supervise/supervisor.hpp"

namespace hoist::chaos {
namespace {

using contract::CommandKind;
using contract::EventKind;
using contract::Mode;
using contract::Node;
using contract::TickRecord;
using HoistFault = contract::Fault;

constexpr double kRest_m_s = 0.08;   // a wheel this slow has stopped: a walking patient shakes the brakes of a standing hoist
constexpr double kStill_m_s = 0.02;  // and is at rest when this slow for this long
constexpr int kRestedTicks = 10;
constexpr double kEps = 1e-6;
// Time between braking and standstill in addition to v/a: the drives' lag, and 50 ms of I1.
constexpr double kRollOut_s = 0.35;
// What the filter may show beyond the guard's 10 degrees (2 less, tests/reactions), and a stop from the fastest drive after the guard's time.
constexpr double kFarOut_m = 0.8 * 0.1405, kHangAndStop_s = 5.0;
constexpr double kShove_s = 1.0;  // how long a falling body, or a shorted bridge, moves a hoist with closed brakes

bool moves(Mode mode) { return contract::kModes[static_cast<std::size_t>(mode)].moving != 0; }

// Only drives that say they follow commands can be held to the ramp; others brake by themselves.
bool enabled(std::uint16_t status_word) {
  return contract::canopen::drive::state(status_word) == contract::canopen::drive::State::operation_enabled;
}
bool has(const TickRecord& record, HoistFault fault) { return (record.fault_bits & contract::fault_bit(fault)) != 0; }

const char* not_finite(const TickRecord& record) {
  const auto* bytes = reinterpret_cast<const char*>(&record);
  for (const contract::SignalInfo& signal : contract::kSignals) {
    if (signal.type != contract::SignalType::f32) continue;
    float value = 0;
    std::memcpy(&value, bytes + signal.offset, sizeof value);
    if (!std::isfinite(value)) return signal.name.data();
  }
  return nullptr;
}

contract::FaultBits lost_bit(Node node) {
  constexpr std::array kLost{HoistFault::drive_left_lost, HoistFault::drive_right_lost, HoistFault::io_lost,
                             HoistFault::tilt_left_lost,  HoistFault::tilt_right_lost,  HoistFault::tilt_base_lost};
  return contract::fault_bit(kLost[static_cast<std::size_t>(node)]);
}

}  // namespace

bool Board::now(Kind kind) const {
  return std::any_of(rows.begin(), rows.end(), [kind](const Planned& r) { return r.fault.kind == kind && r.on; });
}
bool Board::ever(Kind kind) const {
  return std::any_of(rows.begin(), rows.end(), [kind](const Planned& r) { return r.fault.kind == kind && (r.on || r.done); });
}
bool Board::ever(Kind kind, contract::NodeKind node) const {
  return std::any_of(rows.begin(), rows.end(), [kind, node](const Planned& r) {
    return r.fault.kind == kind && (r.on || r.done) && contract::kNodes[static_cast<std::size_t>(r.fault.node)].kind == node;
  });
}
bool Board::any_yet() const {
  return std::any_of(rows.begin(), rows.end(), [](const Planned& r) { return r.on || r.done; });
}
bool Board::any_inside_yet() const {
  return std::any_of(rows.begin(), rows.end(), [](const Planned& r) { return (r.on || r.done) && !info(r.fault.kind).outside; });
}
bool Board::alone(const Planned& row, double now_s, double quiet_s) const {
  return std::all_of(rows.begin(), rows.end(),
                     [&](const Planned& r) { return &r == &row || (!r.on && (!r.done || now_s - r.fault.end_s > quiet_s)); });
}

Watch::Watch(tests::ClosedLoop& loop, const Board& board, const SessionOptions& options, SessionReport& report)
    : loop_(loop), board_(board), options_(options), report_(report), params_(loop.core().params) {}

void Watch::core_restarted() {
  last_mode_ = Mode::init;
  last_speed_m_s_ = 0;
  moving_end_s_ = loop_.time_s();
  raised_ = 0;
  events_seen_ = loop_.events().size();
  params_ = loop_.core().params;
  parameter_version_ = loop_.core().parameter_version;
  next_sequence_ = drive_sequence_ = drive_epoch_ = lease_epoch_ = lease_holder_ = 0;
  staged_.clear();
  must_raise_.clear();
  ran_ = false;
}

bool Watch::fallen() const { return loop_.time_s() - fell_s_ < kShove_s; }

double Watch::fastest_wheel() const {
  const sim::Plant& plant = loop_.world().plant();
  return std::max(std::fabs(plant.wheel_speed_m_s(sim::Side::left)), std::fabs(plant.wheel_speed_m_s(sim::Side::right)));
}

// Cases in which the hoist cannot control its wheels: unknown motion, a patient falling against it, a shorted bridge (distance tested in
// tests/loop), or a frozen simulated processor that keeps its outputs (a real one has a watchdog; tests/machine).
bool Watch::odd() const {
  return board_.ever(Kind::encoder_lost) || board_.ever(Kind::encoder_reversed) || fallen() || board_.ever(Kind::slip) ||
         loop_.time_s() - shorted_s_ < kShove_s || board_.ever(Kind::wheel_blocked) || board_.ever(Kind::obstacle) ||
         board_.ever(Kind::slope) || board_.ever(Kind::freeze, contract::NodeKind::drive);
}

void Watch::tell(const std::string& what) {
  if (!options_.tell) return;
  char time[24];
  std::snprintf(time, sizeof time, "%8.2f s  ", loop_.time_s());
  report_.story.push_back(time + what);
}

void Watch::broken(std::string_view what, double value, std::string_view name) {
  // One line for each invariant: its first violation.
  if (std::find(told_.begin(), told_.end(), what) != told_.end()) return;
  told_.emplace_back(what);
  char text[240];
  std::snprintf(text, sizeof text, "%8.2f s  %.*s%.*s (%g)", loop_.time_s(), static_cast<int>(what.size()), what.data(),
                static_cast<int>(name.size()), name.data(), value);
  if (report_.broken.empty()) report_.broken_s = loop_.time_s();
  report_.broken.emplace_back(text);
  tell(std::string("BROKEN ") + text);
}

void Watch::must_stop(const char* cause, double budget_s, double braking_m_s2) {
  if (!loop_.core_runs() || !moves(loop_.mode())) return;
  const double now_s = loop_.time_s();
  must_stop_.push_back({cause, now_s, now_s + budget_s + fastest_wheel() / braking_m_s2 + kRollOut_s});
}

// The required reaction to a single fault, and its time (SOURCES 2.2). Several at once hide each other; then only the other invariants apply.
void Watch::fault_begins(const Planned& row) {
  const Fault& f = row.fault;
  const double now_s = loop_.time_s(), length_s = f.end_s - f.start_s;
  if (!board_.alone(row, now_s, 6.0) || !loop_.core_runs()) return;
  // Out of service only its causes are latched: INIT checks everything again.
  if (loop_.mode() == Mode::init || loop_.mode() == Mode::fault || loop_.mode() == Mode::emergency_stop) return;
  const auto raise = [&](contract::FaultBits bits, const char* what, double budget_s) {
    must_raise_.push_back({bits, what, now_s + budget_s, f.end_s});
  };
  switch (f.kind) {
    case Kind::unplug:
    case Kind::bus_off:
    case Kind::freeze:
      if (length_s < 0.12 || (raised_ & lost_bit(f.node)) != 0) break;
      // A frozen drive keeps its outputs: only its loss can be checked. If the bus fails meanwhile, all nodes are lost at once.
      raise(lost_bit(f.node) | contract::fault_bit(HoistFault::bus_down), "I1: a silent node is not missed within 60 ms", 0.06 + 0.011);
      if (f.kind != Kind::freeze || contract::kNodes[static_cast<std::size_t>(f.node)].kind != contract::NodeKind::drive)
        must_stop("a node fell silent", 0.07, 1.0);
      break;
    case Kind::bumper:
      // One that touches already, a post left behind and acknowledged, is no new touch.
      if (length_s < 0.1 || loop_.core().sensed.io.bumpers() != 0) break;
      raise(contract::fault_bit(HoistFault::bumper_pressed), "I1: a bumper is not felt within 30 ms", 0.03 + 0.011);
      must_stop("a bumper", 0.04, 1.0);
      break;
    case Kind::core_bus_off:
      if (length_s < 0.1) break;
      must_stop("the bus is gone", 0.07, 1.0);
      break;
    case Kind::emergency_stop:
      if (length_s < 0.1) break;
      raise(contract::fault_bit(HoistFault::emergency_stop), "I1: the emergency stop is not seen within 30 ms", 0.03 + 0.011);
      must_stop("the emergency stop", 0.03, 0.7);
      break;
    case Kind::power_cut:
      must_stop("the drives' power is gone", 0.1, 0.7);
      break;
    default:
      break;
  }
}

void Watch::before_step(const core::TickInputs& inputs) {
  commands_.assign(inputs.commands.begin(), inputs.commands.end());
  last_tick_ = inputs.tick;
  // The holder when the command is handled: after a sign-out or a new server, earlier in the same step, there is none.
  std::uint32_t holder = inputs.server_life == server_life_ ? lease_holder_ : 0;
  if (inputs.server_life != server_life_) next_sequence_ = 0;
  server_life_ = inputs.server_life;
  for (const contract::Command& c : commands_) {
    const bool repeated = c.sequence < next_sequence_;
    if (!repeated) next_sequence_ = c.sequence + 1;
    // Anyone may end a motion.
    if (c.kind == CommandKind::request_mode && c.a == static_cast<std::uint32_t>(Mode::standby)) must_stop("the end of motion", 0.01, 0.5);
    if (holder == 0) continue;
    const bool by_holder = c.client == holder && c.lease_epoch == lease_epoch_;
    if (c.kind == CommandKind::acknowledge && by_holder && !repeated) acknowledged_s_ = loop_.time_s();
    if (c.kind == CommandKind::release_lease && !repeated && (c.client == 0 || c.client == holder)) holder = 0;
  }
  if (!inputs.drive_fresh) return;
  // What may act: from the holder, under its number, newer than the last, held, and about a picture of the hoist not older than 250 ms.
  const contract::DriveCommand& d = inputs.drive;
  if (lease_holder_ == 0 || d.client != lease_holder_ || d.lease_epoch != lease_epoch_) return;
  if (drive_epoch_ != lease_epoch_) drive_sequence_ = 0;
  if (d.sequence <= drive_sequence_) return;
  const bool fresh = d.echo_time_ns <= inputs.time_ns && inputs.time_ns - d.echo_time_ns <= 250'000'000;
  if (d.held == 1 && !fresh) return;
  drive_epoch_ = lease_epoch_;
  drive_sequence_ = d.sequence;
  // Hold-to-run was held when the client had seen that record; later is not certain.
  if (d.held == 1) driven_s_ = loop_.time_s() - static_cast<double>(inputs.time_ns - d.echo_time_ns) * 1e-9;
}

void Watch::after_step(bool core_ran) {
  watch_truth(core_ran);
  // A suspended core notices no loss, nor events that end before it continues; it must report its own delay (H22).
  if (!core_ran)
    std::erase_if(must_raise_, [](MustRaise& must) {
      must.by_s += core::kTick_s;
      return must.by_s > must.over_s;
    });
  if (core_ran) watch_record();
  commands_.clear();
}

void Watch::watch_truth(bool core_ran) {
  const double now_s = loop_.time_s();
  const sim::Plant& plant = loop_.world().plant();
  if (loop_.world().patient().state() >= sim::PatientState::tripping) fell_s_ = now_s;
  if (board_.now(Kind::pelvis_turned)) twisted_s_ = now_s;
  if (board_.now(Kind::bridge_shorted)) shorted_s_ = now_s;
  const sim::HarnessMotion& harness = loop_.world().patient().harness();
  if (std::hypot(harness.dx_m, harness.dy_m) > kFarOut_m) leaned_s_ = now_s;
  if (!odd()) {
    // What the wheels do: a body that is thrown against the stop of the struts may drag the chassis over wheels that stand.
    const double left_m_s = plant.wheel_speed_m_s(sim::Side::left), right_m_s = plant.wheel_speed_m_s(sim::Side::right);
    const double speed_m_s = (left_m_s + right_m_s) / 2.0, yaw_rate_rad_s = (right_m_s - left_m_s) / plant.params().track_width_m;
    if (std::fabs(speed_m_s) > 0.75) broken("I2: faster than 0.75 m/s", speed_m_s);
    if (std::fabs(yaw_rate_rad_s) > 1.1) broken("I2: turns faster than 63 degrees a second", yaw_rate_rad_s);
  }
  // I8: without the core the drives brake by themselves: 50 ms, then the ramp.
  if (core_ran) {
    core_silent_s_ = now_s;
    wheels_at_silence_m_s_ = fastest_wheel();
  } else if (now_s - core_silent_s_ > 0.06 + wheels_at_silence_m_s_ + kRollOut_s && !odd() && fastest_wheel() > kRest_m_s) {
    broken("I8: a wheel still turns after the core's last command", fastest_wheel());
  }
  // I1: each cause of a stop has its time.
  for (std::size_t i = 0; i < must_stop_.size();) {
    const MustStop& stop = must_stop_[i];
    const bool rested = fastest_wheel() <= kRest_m_s;
    if (!rested && now_s > stop.by_s && !odd()) broken(std::string("I1: a wheel turns too long after ") + stop.cause, fastest_wheel());
    if (rested || now_s > stop.by_s)
      must_stop_.erase(must_stop_.begin() + static_cast<std::ptrdiff_t>(i));
    else
      ++i;
  }
}

void Watch::watch_record() {
  const double now_s = loop_.time_s();
  const TickRecord& record = loop_.record();
  const Mode mode = loop_.mode();
  if (const char* name = not_finite(record)) broken("I13: the record holds no number in ", 0.0, name);
  watch_limits(record, mode);
  if (contract::led_by_hand(mode)) watch_driver(record);
  watch_parameters(mode);
  // I1: standstill soon after the end of motion, for any cause.
  if (moves(mode)) moving_end_s_ = now_s;
  // A post at the bumper pushes back while the hoist touches it. A body twisted beyond the struts' limit drags braked wheels.
  if (!moves(mode) && now_s - moving_end_s_ > 1.3 && now_s - twisted_s_ > kShove_s && fastest_wheel() > kRest_m_s && !odd())
    broken("I1: a wheel turns 1.3 s after motion ended", fastest_wheel());
  // A stop at standstill moves nothing again, also not by a remaining ramp speed after the drives have braked by
  // themselves.
  const double fastest_m_s = fastest_wheel();
  if (mode != Mode::protective_stop)
    rested_ticks_ = 0;
  else if (fastest_m_s <= kStill_m_s)
    ++rested_ticks_;
  else if (rested_ticks_ < kRestedTicks)
    rested_ticks_ = 0;
  if (rested_ticks_ >= kRestedTicks && fastest_m_s > kRest_m_s && !odd()) broken("I1: a stop sets a standing wheel in motion", fastest_m_s);
  if (moves(mode)) report_.walked_s += 0.01;
  watch_events();
  watch_deadlines(record);
  if (record.tick != last_tick_) broken("I9: the record's tick is not the step's", static_cast<double>(record.tick));
  lease_epoch_ = record.lease_epoch;
  lease_holder_ = record.lease_holder;
  last_mode_ = mode;
  last_speed_m_s_ = static_cast<double>(record.speed_command_m_s);
  followed_ = enabled(record.left_status_word) && enabled(record.right_status_word);
  ran_ = true;
}

void Watch::watch_limits(const TickRecord& record, Mode mode) {
  const double wheels = std::max(std::fabs(static_cast<double>(record.wheel_left_command_m_s)),
                                 std::fabs(static_cast<double>(record.wheel_right_command_m_s)));
  if (!moves(mode) && mode != Mode::protective_stop && wheels > 0.0) broken("I4: wheels commanded in a mode that does not move", wheels);
  const double speed = static_cast<double>(record.speed_command_m_s);
  if (std::fabs(speed) > 0.65 + kEps) broken("I2: commanded above the top speed", speed);
  const bool follow = enabled(record.left_status_word) && enabled(record.right_status_word);
  // With one drive out, the command of the other is no turn of the hoist.
  if (follow && std::fabs(static_cast<double>(record.yaw_rate_command_rad_s)) > 0.872664626 + 1e-4)
    broken("I2: commanded above the top turn rate", static_cast<double>(record.yaw_rate_command_rad_s));
  if (!ran_ || mode != last_mode_ || !follow || !followed_) return;
  const double change = std::fabs(speed) - std::fabs(last_speed_m_s_);
  const double braking = has(record, HoistFault::bumper_pressed) ? 1.5 : 1.0;
  if (change > 0.5 * 0.01 + 1e-5) broken("I2: speeds up faster than 0.5 m/s2", change / 0.01);
  if (-change > braking * 0.01 + 1e-5) broken("I2: brakes harder than allowed", -change / 0.01);
}

// I3, I6: checked by the commands that reached the core, not by its own report.
void Watch::watch_driver(const TickRecord& record) {
  const bool wished = record.speed_wish_m_s != 0 || record.yaw_rate_wish_rad_s != 0;
  if (!wished) return;
  if (record.lease_holder == 0) broken("I3: drives without a driver");
  if (record.remote_age_s > 0.26F) broken("I6: an old command acts", static_cast<double>(record.remote_age_s));
  if (loop_.time_s() - driven_s_ > 0.27) broken("I6: acts on nothing fresh from its driver", loop_.time_s() - driven_s_);
}

// I10: parameters in force change only by a complete committed set, with one number per set, and only to allowed values.
void Watch::watch_parameters(Mode mode) {
  const core::CoreState& core = loop_.core();
  const auto events = std::span(loop_.events()).subspan(events_seen_);
  std::vector<contract::Command> given;  // rows of every set that was committed in this step, in their order
  std::size_t rows = 0;
  for (const contract::Command& c : commands_) {
    // Refused rows are not part of a set: old numbers, rows of other clients, invalid values.
    const bool taken = std::any_of(events.begin(), events.end(), [&c](const contract::Event& e) {
      return e.kind == EventKind::command_done && e.request_id == c.request_id && e.client == c.client;
    });
    if (!taken) continue;
    if (c.kind == CommandKind::stage_parameter) {
      if (c.b == 0) staged_.clear();
      staged_.push_back(c);
    } else if (c.kind == CommandKind::commit_parameters) {
      given.insert(given.end(), staged_.begin(), staged_.end());
      rows += c.a;
    }
  }
  const bool changed = std::memcmp(&core.params, &params_, sizeof params_) != 0;
  if (changed != (core.parameter_version != parameter_version_) && parameter_version_ != 0 && changed)
    broken("I10: parameters changed without a new version");
  if (changed) {
    std::size_t count = 0;
    for (const contract::Event& e : events) count += e.kind == EventKind::parameter_changed ? 1U : 0U;
    if (given.empty()) broken("I10: parameters changed without a commit");
    bool whole = count == rows && given.size() == rows;
    for (std::size_t i = 0; i < contract::kParamCount; ++i) {
      const double before = contract::get_param(params_, i), now = contract::get_param(core.params, i);
      if (contract::check_param(i, now) != contract::ParamCheck::ok)
        broken("I10: a value in force is not allowed: ", now, contract::kParams[i].name);
      const auto last =
          std::find_if(given.rbegin(), given.rend(), [&](const contract::Command& c) { return c.a == contract::kParams[i].id; });
      whole = whole && (last == given.rend() || last->v0 == now);
      if (now == before) continue;
      if (last == given.rend() || last->v0 != now) broken("I10: a value is in force that nobody gave: ", now, contract::kParams[i].name);
      if (moves(mode) && moves(last_mode_) && contract::kParams[i].edit != contract::EditRule::live)
        broken("I10: changed while moving: ", now, contract::kParams[i].name);
    }
    if (contract::check_param_set(core.params) != nullptr) broken("I10: the values in force contradict each other");
    if (!whole) broken("I10: a set is in force in part", static_cast<double>(count));
    params_ = core.params;
  }
  parameter_version_ = core.parameter_version;
}

void Watch::watch_events() {
  raised_now_ = 0;
  const auto& events = loop_.events();
  for (; events_seen_ < events.size(); ++events_seen_) {
    const contract::Event& e = events[events_seen_];
    const contract::FaultBits bit = e.code < contract::kFaultPlaces ? contract::fault_bit(static_cast<HoistFault>(e.code)) : 0U;
    const bool about_fault = e.kind == EventKind::fault_raised || e.kind == EventKind::fault_cleared;
    const std::string_view name = about_fault ? contract::fault_info(static_cast<HoistFault>(e.code)).name : std::string_view{};
    if (e.kind == EventKind::fault_raised) {
      tell("fault " + std::string(name));
      if ((raised_ & bit) != 0) broken("I11: a fault is raised twice: ", 0.0, name);
      raised_ |= bit;
      raised_now_ |= bit;
    } else if (e.kind == EventKind::fault_cleared) {
      if ((raised_ & bit) == 0) broken("I11: a fault is cleared that was not raised: ", 0.0, name);
      raised_ &= ~bit;
    } else if (e.kind == EventKind::mode_changed) {
      watch_mode_change(static_cast<Mode>(e.item), static_cast<Mode>(e.code));
    }
  }
  // Every fault in force has an event, and every such event a fault.
  if (raised_ != loop_.record().fault_bits)
    broken("I11: faults in force and faults told of differ", static_cast<double>(raised_ ^ loop_.record().fault_bits));
}

void Watch::watch_mode_change(Mode from, Mode to) {
  const double now_s = loop_.time_s();
  tell("mode " + std::string(contract::kModes[static_cast<std::size_t>(from)].name) + " to " +
       std::string(contract::kModes[static_cast<std::size_t>(to)].name));
  const TickRecord& record = loop_.record();
  const bool allowed = std::any_of(core::kTransitions.begin(), core::kTransitions.end(),
                                   [&](const core::Transition& t) { return t.from == from && t.to == to; });
  if (!allowed) broken("I5: a change of mode that no table allows");
  // An acknowledgement may wait half a second for a drive to leave its fault.
  const bool released = (from == Mode::protective_stop && (to == Mode::standby || to == Mode::init)) ||
                        (from == Mode::fault && to != Mode::emergency_stop) || from == Mode::emergency_stop;
  if (released && now_s - acknowledged_s_ > 0.6) broken("I5: a stop ended without acknowledgement");
  if (moves(to)) {
    ++report_.starts;
    if (std::fabs(record.lean_norm) > 0.2F + 1e-3F || std::fabs(record.turn_norm) > 0.2F + 1e-3F)
      broken("I7: a start away from neutral", static_cast<double>(record.lean_norm));
  }
  if (to == Mode::protective_stop || to == Mode::emergency_stop) ++report_.stops;
  const bool ended = moves(from) && !moves(to);
  const bool excused = from == Mode::user ? board_.any_inside_yet() : board_.any_yet();
  if (ended && !excused && now_s - asked_stop_s_ > 4.0) {
    // A patient who is driven may rightly trip the fall monitor; one who leads must never. The same for a lean beyond the hanging monitor's
    // limit; a walking patient below it must not count as hanging.
    const bool leant = has(record, HoistFault::patient_hanging) && now_s - leaned_s_ < kHangAndStop_s;
    if (contract::led_by_hand(from) && (has(record, HoistFault::fall_detected) || leant)) return;
    // An exercise also ends at its end.
    if (from == Mode::guided && record.guided_end == static_cast<std::uint8_t>(contract::GuidedEnd::finished)) return;
    ++report_.false_stops;
    if (options_.frame_loss == 0.0)
      broken("false stop: ", 0.0,
             record.stop_cause > 0 ? contract::fault_info(static_cast<HoistFault>(record.stop_cause - 1U)).name : "soft stop");
  }
}

void Watch::watch_deadlines(const TickRecord& record) {
  const double now_s = loop_.time_s();
  for (std::size_t i = 0; i < must_raise_.size();) {
    const MustRaise& must = must_raise_[i];
    // One that is acknowledged in the step in which it is found was in force, too.
    const contract::FaultBits found = record.fault_bits | (now_s - acknowledged_s_ < 1.5 * core::kTick_s ? raised_now_ : 0U);
    const bool raised = (found & must.any_of) != 0 || loop_.mode() == Mode::init;
    if (!raised && now_s > must.by_s) broken(must.what, now_s - must.by_s);
    if (raised || now_s > must.by_s)
      must_raise_.erase(must_raise_.begin() + static_cast<std::ptrdiff_t>(i));
    else
      ++i;
  }
}

}  // namespace hoist::chaos
