#include "tests/chaos/judge/watch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <span>
#include <utility>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/guided_path.hpp"
#include "control/contract/params.hpp"

namespace hoist::chaos {
namespace {

using contract::CommandKind;
using contract::EventKind;
using contract::Mode;
using contract::Node;
using contract::ParamName;
using contract::TickRecord;
using HoistFault = contract::Fault;

constexpr double kStill_m_s = 0.02;  // a wheel is at rest when this slow for this long
constexpr int kRestedTicks = 5;
constexpr double kEps = 1e-6;
// From the end of the ramp to rest: I1.
constexpr double kRollOut_s = 0.05;
constexpr double kAlone_s = 0.05;  // a drive brakes by itself this long after the last command
// After a fault that touches driving: its end, the acknowledgement and the sensors' settling belong to it. Longer for a tilt filter that unlearns.
constexpr double kAftermath_s = 5.0, kUnlearning_s = 60.0;

// The judge's own list of the changes of mode that the hazard table 2.3 allows. Any mode may lose its power.
constexpr std::array kChanges{
    std::pair{Mode::init, Mode::standby},
    std::pair{Mode::init, Mode::protective_stop},
    std::pair{Mode::init, Mode::fault},
    std::pair{Mode::standby, Mode::user},
    std::pair{Mode::standby, Mode::remote},
    std::pair{Mode::standby, Mode::guided},
    std::pair{Mode::standby, Mode::calibrate},
    std::pair{Mode::standby, Mode::init},
    std::pair{Mode::standby, Mode::protective_stop},
    std::pair{Mode::standby, Mode::fault},
    std::pair{Mode::user, Mode::standby},
    std::pair{Mode::user, Mode::protective_stop},
    std::pair{Mode::remote, Mode::standby},
    std::pair{Mode::remote, Mode::protective_stop},
    std::pair{Mode::guided, Mode::standby},
    std::pair{Mode::guided, Mode::protective_stop},
    std::pair{Mode::calibrate, Mode::standby},
    std::pair{Mode::calibrate, Mode::protective_stop},
    std::pair{Mode::calibrate, Mode::fault},
    std::pair{Mode::protective_stop, Mode::standby},
    std::pair{Mode::protective_stop, Mode::init},
    std::pair{Mode::protective_stop, Mode::fault},
    std::pair{Mode::fault, Mode::init},
    std::pair{Mode::emergency_stop, Mode::init},
};
bool may_change(Mode from, Mode to) {
  if (to == Mode::emergency_stop) return from != Mode::emergency_stop;
  return std::any_of(kChanges.begin(), kChanges.end(), [&](const auto& row) { return row.first == from && row.second == to; });
}

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

}  // namespace

Watch::Watch(const sim::World& world, const Board& board, Options options, const contract::Params& first, SessionReport& report)
    : world_(world),
      board_(board),
      options_(options),
      report_(report),
      deadlines_(world, board, ears_),
      sound_(world, ears_),
      alarms_(world, board, ears_, [this](std::string_view what, double value, std::string_view name) { broken(what, value, name); }),
      params_(first) {}

void Watch::core_restarted(const contract::Params& params, std::uint64_t version, std::size_t events) {
  mode_ = Mode::init;
  last_speed_m_s_ = 0;
  moving_end_s_ = world_.time_s();
  raised_ = 0;
  events_seen_ = events;
  params_ = params;
  parameter_version_ = version;
  next_sequence_ = drive_sequence_ = drive_epoch_ = lease_epoch_ = lease_holder_ = 0;
  staged_.clear();
  ears_.restart();
  deadlines_.restart();
  persons_.restart();
  settings_.restart();
  sound_.restart();
  alarms_.restart();
  motion_.restart();
  ran_ = false;
}

void Watch::tell(const std::string& what) {
  if (!options_.tell) return;
  char time[24];
  std::snprintf(time, sizeof time, "%8.2f s  ", world_.time_s());
  report_.story.push_back(time + what);
}

void Watch::broken(std::string_view what, double value, std::string_view name) {
  // One line for each invariant: its first violation.
  if (std::find(told_.begin(), told_.end(), what) != told_.end()) return;
  told_.emplace_back(what);
  char text[240];
  std::snprintf(text, sizeof text, "%8.2f s  %.*s%.*s (%g)", world_.time_s(), static_cast<int>(what.size()), what.data(),
                static_cast<int>(name.size()), name.data(), value);
  if (report_.broken.empty()) report_.broken_s = world_.time_s();
  report_.broken.emplace_back(text);
  tell(std::string("BROKEN ") + text);
}

void Watch::must_stop(std::string_view cause, double budget_s, double braking_m_s2) {
  if (core_runs_ && moves(mode_)) must_rest(cause, budget_s, braking_m_s2);
}
void Watch::must_rest(std::string_view cause, double budget_s, double braking_m_s2) {
  const Truth& truth = sampler_.now();
  const double turn_rad_s = std::fabs(truth.wheel_m_s[1] - truth.wheel_m_s[0]) / world_.plant().params().track_width_m;
  // A turn on the spot has a ramp of its own, softer at the wheels than a bumper's stop.
  const double ramp_s = std::max(reached_m_s(budget_s) / braking_m_s2, turn_rad_s / params_.yaw_acceleration_rad_s2_max);
  must_stop_.push_back({cause, world_.time_s() + budget_s + ramp_s + kRollOut_s});
}

// What speeds up follows a stop as late as everything else, and not before its budget is over, so it becomes faster first.
double Watch::reached_m_s(double budget_s) const {
  const Truth& truth = sampler_.now();
  double reached_m_s = 0;
  for (std::size_t i = 0; i < truth.wheel_m_s.size(); ++i) {
    const double speed_m_s = std::fabs(truth.wheel_m_s[i]), gain_m_s2 = std::copysign(1.0, truth.wheel_m_s[i]) * truth.wheel_m_s2[i];
    reached_m_s = std::max(reached_m_s, speed_m_s + (budget_s + kRollOut_s) * std::max(0.0, gain_m_s2));
  }
  return reached_m_s;
}

// Signed out, or a new server without any sign-in.
void Watch::driver_gone() {
  if (!contract::led_by_hand(mode_)) return;
  must_stop("its driver is gone", 0.02, 0.8);
  deadlines_.ending();
}

void Watch::before_step(const Given& inputs) {
  ears_.before_step(inputs);
  commands_.assign(inputs.commands.begin(), inputs.commands.end());
  persons_.before_step(commands_, lease_holder_, lease_epoch_);
  sound_.before_step(commands_);
  last_tick_ = inputs.tick;
  // The holder when the command is handled: after a sign-out or a new server, earlier in the same step, there is none.
  std::uint32_t holder = inputs.server_life == server_life_ ? lease_holder_ : 0;
  if (inputs.server_life != server_life_) {
    next_sequence_ = 0;
    driver_gone();
  }
  freed_ = inputs.server_life != server_life_;
  server_life_ = inputs.server_life;
  for (const contract::Command& c : commands_) {
    const bool repeated = c.sequence < next_sequence_;
    if (!repeated) next_sequence_ = c.sequence + 1;
    // Anyone may end a motion.
    if (c.kind == CommandKind::request_mode && c.a == static_cast<std::uint32_t>(Mode::standby)) {
      must_stop("the end of motion", 0.01, 0.5);
      deadlines_.ending();
    }
    if (holder == 0) continue;
    const bool by_holder = c.client == holder && c.lease_epoch == lease_epoch_;
    if (c.kind == CommandKind::begin_guided && by_holder && !repeated && !moves(mode_)) motion_.exercise(contract::guided_of(c).speed_m_s);
    if (c.kind == CommandKind::acknowledge && by_holder && !repeated) {
      acknowledged_s_ = world_.time_s();
      deadlines_.acknowledged();
      alarms_.acknowledged();
    }
    if (c.kind == CommandKind::release_lease && !repeated && (c.client == 0 || c.client == holder)) {
      holder = 0;
      freed_ = true;
      driver_gone();
    }
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
  alarms_.hand(world_.time_s() - static_cast<double>(inputs.time_ns - std::min(d.echo_time_ns, inputs.time_ns)) * 1e-9, d.held == 1);
  // Hold-to-run was held when the client had seen that record; later is not certain.
  if (d.held == 1) driven_s_ = std::max(driven_s_, world_.time_s() - static_cast<double>(inputs.time_ns - d.echo_time_ns) * 1e-9);
  persons_.button(d.held == 1, driven_s_);
  if (d.held == 1)
    deadlines_.held(driven_s_);
  else
    deadlines_.released();
  hand_holds(d.held == 1);
}

// A hand that lets go stops the hoist at once; one that holds again drives on.
void Watch::hand_holds(bool holds) {
  constexpr std::string_view kLetGo = "letting go";
  const bool before = std::exchange(hand_holds_, holds);
  if (holds) std::erase_if(must_stop_, [&](const MustStop& stop) { return stop.cause == kLetGo; });
  if (!holds && before && contract::led_by_hand(mode_)) must_stop(kLetGo, 0.01, 0.8);
}

void Watch::after_step(const Told* told) {
  core_runs_ = told != nullptr;
  watch_truth(told != nullptr);
  if (told != nullptr) watch_record(*told);
  commands_.clear();
}

void Watch::watch_truth(bool core_ran) {
  const double now_s = world_.time_s();
  const Truth& truth = sampler_.sample(world_);
  deadlines_.see(truth);
  if (board_.inside(now_s, 0.0) || (mode_ != Mode::user && board_.any(now_s, 0.0)) || truth.on_edge || truth.strap_off)
    disturbed_s_ = now_s;
  watch_platform(core_ran);
  // I1: each cause of a stop has its time.
  for (std::size_t i = 0; i < must_stop_.size();) {
    const MustStop& stop = must_stop_[i];
    const bool rested = truth.fastest_m_s <= Deadlines::rest_m_s(truth);
    if (!rested && now_s > stop.by_s && !deadlines_.beyond_the_hoist(truth))
      broken("I1: a wheel turns too long after " + std::string(stop.cause), truth.fastest_m_s);
    if (rested || now_s > stop.by_s)
      must_stop_.erase(must_stop_.begin() + static_cast<std::ptrdiff_t>(i));
    else
      ++i;
  }
}

void Watch::watch_platform(bool core_ran) {
  const double now_s = world_.time_s();
  const Truth& truth = sampler_.now();
  const bool excused = deadlines_.beyond_the_hoist(truth);
  if (!excused) {
    // What the wheels do: a body that is thrown against the stop of the struts may drag the chassis over wheels that stand.
    const double speed_m_s = (truth.wheel_m_s[0] + truth.wheel_m_s[1]) / 2.0;
    const double yaw_rate_rad_s = (truth.wheel_m_s[1] - truth.wheel_m_s[0]) / world_.plant().params().track_width_m;
    if (std::fabs(speed_m_s) > 0.75) broken("I2: faster than 0.75 m/s", speed_m_s);
    if (std::fabs(yaw_rate_rad_s) > 1.1) broken("I2: turns faster than 63 degrees a second", yaw_rate_rad_s);
  }
  // I8: without the core the drives brake by themselves: 50 ms, then the ramp. What a body's push has turned has the ramp before it, too.
  if (core_ran || excused) {
    core_silent_s_ = now_s;
    reached_at_silence_m_s_ = reached_m_s(kAlone_s);
  } else if (now_s - core_silent_s_ > kAlone_s + 0.01 + reached_at_silence_m_s_ + kRollOut_s &&
             truth.fastest_m_s > Deadlines::rest_m_s(truth)) {
    broken("I8: a wheel still turns after the core's last command", truth.fastest_m_s);
  }
}

void Watch::watch_record(const Told& told) {
  const double now_s = world_.time_s();
  const TickRecord& record = told.record;
  const Mode mode = static_cast<Mode>(record.mode);
  const bool moved = now_s - moving_end_s_ < 0.5;
  if (const char* name = not_finite(record)) broken("I13: the record holds no number in ", 0.0, name);
  watch_limits(record);
  if (contract::led_by_hand(mode)) watch_driver(record);
  watch_parameters(told);
  if (moves(mode)) {
    moving_end_s_ = now_s;
    report_.walked_s += kStep_s;
    report_.moved_s[static_cast<std::size_t>(mode)] += kStep_s;
  }
  watch_events(told);
  persons_.after_step(record);
  if (const auto missed = sound_.after_step(record.fault_bits, raised_now_))
    broken("I11: an alarm is not heard: ", 0.0, contract::fault_info(*missed).name);
  const Rule rule = deadlines_.after_step(told, sampler_.now(), raised_now_);
  if (rule != Rule::count) broken(rule_info(rule).what, sampler_.now().fastest_m_s);
  // A late step commands late; without a bus no command to stop reaches a drive, and it brakes by itself 50 ms after the last one.
  if (const Rule due = deadlines_.due(); due != Rule::count && moved) {
    must_rest(rule_info(due).what, ears_.bus_up() ? std::min(ears_.lateness_s(), kAlone_s) : kAlone_s, rule_info(due).braking_m_s2);
    // When a drive falls silent in the middle of a stop, each wheel goes on to rest as its own drive brakes, and that stop has its time.
    if (due == Rule::silent_drive_left || due == Rule::silent_drive_right)
      for (MustStop& stop : must_stop_) stop.by_s = std::max(stop.by_s, must_stop_.back().by_s);
  }
  if (record.tick != last_tick_) broken("I9: the record's tick is not the step's", static_cast<double>(record.tick));
  alarms_.after_step(told, sampler_.now(), lease_holder_, freed_);
  if (record.lease_epoch != lease_epoch_) alarms_.hand_gone();
  lease_epoch_ = record.lease_epoch;
  lease_holder_ = record.lease_holder;
  mode_ = mode;
  watch_rest();
  watch_motion(told);
  last_speed_m_s_ = static_cast<double>(record.speed_command_m_s);
  followed_ = enabled(record.left_status_word) && enabled(record.right_status_word);
  ran_ = true;
}

void Watch::watch_motion(const Told& told) {
  const Truth& truth = sampler_.now();
  const bool free = !deadlines_.beyond_the_hoist(truth) && !deadlines_.comes_free() && !truth.on_edge && !truth.strap_off;
  const Motion::Broken wrong = motion_.after_step(told, truth, !board_.inside(world_.time_s(), kAftermath_s), free);
  if (!wrong.what.empty()) broken(wrong.what, wrong.value);
}

void Watch::watch_rest() {
  const Truth& truth = sampler_.now();
  const double rest_m_s = Deadlines::rest_m_s(truth);
  const bool excused = deadlines_.beyond_the_hoist(truth) || deadlines_.comes_free();
  // I1: standstill soon after the end of motion, for any cause: the ramp of 1.0 m/s2 from 0.65 m/s, 50 ms, and one budget.
  if (!moves(mode_) && world_.time_s() - moving_end_s_ > 1.0 && truth.fastest_m_s > rest_m_s && !excused)
    broken("I1: a wheel turns 1 s after motion ended", truth.fastest_m_s);
  // A stop at standstill moves nothing again, also not by a remaining ramp speed after the drives have braked by
  // themselves.
  if (mode_ != Mode::protective_stop)
    rested_ticks_ = 0;
  else if (truth.fastest_m_s <= kStill_m_s)
    ++rested_ticks_;
  else if (rested_ticks_ < kRestedTicks)
    rested_ticks_ = 0;
  if (rested_ticks_ >= kRestedTicks && truth.fastest_m_s > rest_m_s && !excused)
    broken("I1: a stop sets a standing wheel in motion", truth.fastest_m_s);
}

void Watch::watch_limits(const TickRecord& record) {
  const Mode mode = static_cast<Mode>(record.mode);
  const double wheels = std::max(std::fabs(static_cast<double>(record.wheel_left_command_m_s)),
                                 std::fabs(static_cast<double>(record.wheel_right_command_m_s)));
  if (!moves(mode) && mode != Mode::protective_stop && wheels > 0.0) broken("I4: wheels commanded in a mode that does not move", wheels);
  const double speed = static_cast<double>(record.speed_command_m_s);
  if (std::fabs(speed) > 0.65 + kEps) broken("I2: commanded above the top speed", speed);
  const bool follow = enabled(record.left_status_word) && enabled(record.right_status_word);
  // With one drive out, the command of the other is no turn of the hoist.
  if (follow && std::fabs(static_cast<double>(record.yaw_rate_command_rad_s)) > 0.872664626 + 1e-4)
    broken("I2: commanded above the top turn rate", static_cast<double>(record.yaw_rate_command_rad_s));
  if (!ran_ || mode != mode_ || !follow || !followed_) return;
  const double change = std::fabs(speed) - std::fabs(last_speed_m_s_);
  const double braking = has(record, HoistFault::bumper_pressed) ? 1.5 : 1.0;
  if (change > 0.5 * 0.01 + 1e-5) broken("I2: speeds up faster than 0.5 m/s2", change / 0.01);
  // A stop without effect ends with the motors' supply: no command brakes after that.
  if (-change > braking * 0.01 + 1e-5 && !has(record, HoistFault::control_fault)) broken("I2: brakes harder than allowed", -change / 0.01);
}

// I3, I6: checked by the commands that reached the core, not by its own report.
void Watch::watch_driver(const TickRecord& record) {
  const bool wished = record.speed_wish_m_s != 0 || record.yaw_rate_wish_rad_s != 0;
  if (!wished) return;
  if (const std::string_view why = persons_.led(record); !why.empty()) broken(why);
  if (record.lease_holder == 0) broken("I3: drives without a driver");
  if (record.remote_age_s > 0.26F) broken("I6: an old command acts", static_cast<double>(record.remote_age_s));
  if (world_.time_s() - driven_s_ > 0.27) broken("I6: acts on nothing fresh from its driver", world_.time_s() - driven_s_);
}

// I10: parameters in force change only by a complete committed set, with one number per set, and only to allowed values.
void Watch::watch_parameters(const Told& told) {
  const Mode mode = static_cast<Mode>(told.record.mode);
  const auto events = told.events.subspan(events_seen_);
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
    } else if (c.kind == CommandKind::set_neutral) {
      // A set of two rows whose values the core measures, and their date.
      for (const ParamName name : {ParamName::neutral_lean_m, ParamName::neutral_turn_rad, ParamName::calibrated_neutral_s}) {
        contract::Command row;
        row.a = contract::kParams[contract::param_index(name)].id;
        row.v0 = name == ParamName::calibrated_neutral_s ? c.v0 : contract::get_param(told.params, contract::param_index(name));
        given.push_back(row);
        ++rows;
      }
    }
  }
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): any other bit is a change
  const bool changed = std::memcmp(&told.params, &params_, sizeof params_) != 0;
  if (changed != (told.parameter_version != parameter_version_) && parameter_version_ != 0 && changed)
    broken("I10: parameters changed without a new version");
  if (changed) {
    std::size_t count = 0;
    for (const contract::Event& e : events) count += e.kind == EventKind::parameter_changed ? 1U : 0U;
    if (given.empty()) broken("I10: parameters changed without a commit");
    bool whole = count == rows && given.size() == rows;
    for (std::size_t i = 0; i < contract::kParamCount; ++i) {
      const double before = contract::get_param(params_, i), now = contract::get_param(told.params, i);
      if (contract::check_param(i, now) != contract::ParamCheck::ok)
        broken("I10: a value in force is not allowed: ", now, contract::kParams[i].name);
      const auto last =
          std::find_if(given.rbegin(), given.rend(), [&](const contract::Command& c) { return c.a == contract::kParams[i].id; });
      whole = whole && (last == given.rend() || last->v0 == now);
      if (now == before) continue;
      if (last == given.rend() || last->v0 != now)
        broken("I10: a value is in force that no command gave: ", now, contract::kParams[i].name);
      if (moves(mode) && moves(mode_) && contract::kParams[i].edit != contract::EditRule::live)
        broken("I10: changed while moving: ", now, contract::kParams[i].name);
    }
    if (contract::check_param_set(told.params) != nullptr) broken("I10: the values in force contradict each other");
    if (!whole) broken("I10: a set is in force in part", static_cast<double>(count));
    params_ = told.params;
  }
  parameter_version_ = told.parameter_version;
}

void Watch::watch_events(const Told& told) {
  raised_now_ = 0;
  const auto& events = told.events;
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
      alarms_.raised(static_cast<HoistFault>(e.code));
      // No fault of a part, a person or a network makes the core's own commands wrong.
      if (bit == contract::fault_bit(HoistFault::gate_refused)) broken("I2: the core made a command that its gate refused");
    } else if (e.kind == EventKind::fault_cleared) {
      if ((raised_ & bit) == 0) broken("I11: a fault is cleared that was not raised: ", 0.0, name);
      raised_ &= ~bit;
      alarms_.cleared(static_cast<HoistFault>(e.code), mode_, sampler_.now(), deadlines_.lean_told_rightly());
    } else if (e.kind == EventKind::mode_changed) {
      watch_mode_change(told, static_cast<Mode>(e.item), static_cast<Mode>(e.code));
    }
  }
  // Every fault in force has an event, and every such event a fault.
  if (raised_ != told.record.fault_bits)
    broken("I11: faults in force and faults told of differ", static_cast<double>(raised_ ^ told.record.fault_bits));
}

void Watch::watch_mode_change(const Told& told, Mode from, Mode to) {
  const double now_s = world_.time_s();
  tell("mode " + std::string(contract::kModes[static_cast<std::size_t>(from)].name) + " to " +
       std::string(contract::kModes[static_cast<std::size_t>(to)].name));
  if (!may_change(from, to)) broken("I5: a change of mode that no table allows");
  // An acknowledgement may wait half a second for a drive to leave its fault.
  const bool released = (from == Mode::protective_stop && (to == Mode::standby || to == Mode::init)) ||
                        (from == Mode::fault && to != Mode::emergency_stop) || from == Mode::emergency_stop;
  if (released && now_s - acknowledged_s_ > 0.6) broken("I5: a stop ended without acknowledgement");
  if (from == Mode::fault && to == Mode::init)
    if (const std::string_view why = persons_.back_in_service(); !why.empty()) broken(why);
  if (moves(to)) watch_start(told, to);
  if (to == Mode::protective_stop || to == Mode::emergency_stop) ++report_.stops;
  if (moves(from) && !moves(to)) count_end(told.record, from);
}

// I7: by the true struts, with what the filter and the mounting may hide, and by what the therapist could not see. Not by the body: beside a cut
// strap one strut stands upright, and the other may as well.
void Watch::watch_start(const Told& told, Mode to) {
  ++report_.starts;
  if (const std::string_view why = deadlines_.start_barred(to); !why.empty()) broken(why);
  if (told.record.lease_holder == 0) broken("I3: a start without a driver");
  if (const std::string_view why = persons_.started(told.record, to, world_.time_s()); !why.empty()) broken(why);
  if (const auto stale = settings_.stale(told.params))
    broken("I10: a node works with another value than the one in force: ", 0.0, contract::kParams[contract::param_index(*stale)].name);
  constexpr double kHidden_rad = 2.0 * kDegree_rad, kTolerance_norm = 0.2;
  const sim::Plant& plant = world_.plant();
  const double left_rad = plant.strut_alpha_rad(sim::Side::left), right_rad = plant.strut_alpha_rad(sim::Side::right);
  const double lean_rad = (left_rad + right_rad) / 2.0 - told.params.neutral_lean_m / told.params.strut_length_m;
  const double turn_rad =
      (right_rad - left_rad) / 2.0 - told.params.strut_spacing_m / 2.0 / told.params.strut_length_m * told.params.neutral_turn_rad;
  if (std::fabs(lean_rad) > kTolerance_norm * told.params.lean_range_rad + kHidden_rad)
    broken("I7: a start away from neutral: lean", lean_rad);
  if (std::fabs(turn_rad) > kTolerance_norm * told.params.turn_range_rad + kHidden_rad)
    broken("I7: a start away from neutral: turn", turn_rad);
  begun_disturbed_ = world_.time_s() - disturbed_s_ < kAftermath_s || unlearning();
}

// An end of motion that no person asked for while nothing is broken, nor was when it began.
void Watch::count_end(const TickRecord& record, Mode from) {
  const double now_s = world_.time_s();
  if (begun_disturbed_ || now_s - disturbed_s_ < kAftermath_s || now_s - asked_stop_s_ <= 4.0) return;
  // An exercise also ends at its end.
  if (from == Mode::guided && record.guided_end == static_cast<std::uint8_t>(contract::GuidedEnd::finished)) return;
  ++report_.unasked[static_cast<std::size_t>(from)];
  const std::string_view cause =
      record.stop_cause > 0 ? contract::fault_info(static_cast<HoistFault>(record.stop_cause - 1U)).name : "soft stop";
  tell("unasked stop: " + std::string(cause));
  bool explained = record.stop_cause > 0 && deadlines_.explained(static_cast<HoistFault>(record.stop_cause - 1U));
  for (const HoistFault soft : {HoistFault::patient_hanging, HoistFault::battery_empty, HoistFault::supply_high, HoistFault::wheel_slip})
    explained = explained || (has(record, soft) && deadlines_.explained(soft));
  if (explained) return;
  ++report_.false_stops;
  if (!options_.frames_lost) broken("false stop: ", 0.0, cause);
}

// The tilt filter unlearns the bias of a sensor that lied, or of a gyroscope whose zero came back: 4.36 rad/s takes 60 s.
bool Watch::unlearning() const {
  return std::any_of(board_.rows.begin(), board_.rows.end(), [&](const Planned& r) {
    const Kind kind = r.fault.kind;
    const bool lies = kind == Kind::sensor_stuck || kind == Kind::sensor_offset || kind == Kind::sensor_garbage ||
                      kind == Kind::sensor_slow || kind == Kind::gyro_jump || kind == Kind::sensor_silent;
    return lies && r.done && world_.time_s() - r.fault.end_s < kUnlearning_s;
  });
}

}  // namespace hoist::chaos
