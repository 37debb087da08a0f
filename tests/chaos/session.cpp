#include "tests/chaos/session.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string_view>

#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"
#include "control/contract/signals.hpp"
#include "control/core/output/supervisor.hpp"
#include "tests/support/closed_loop.hpp"

namespace hoist::chaos {
namespace {

using contract::CommandKind;
using contract::Fault;
using contract::Mode;
using contract::Node;
using contract::TickRecord;

// splitmix64: the standard library's distributions differ between libraries, and a seed must mean the same session everywhere.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }
  double norm() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  double between(double low, double high) { return low + (high - low) * norm(); }
  int below(int limit) { return static_cast<int>(next() % static_cast<std::uint64_t>(limit)); }
  bool chance(double share) { return norm() < share; }

 private:
  std::uint64_t state_;
};

enum class Kind : std::uint8_t {
  unplug,
  freeze,
  freeze_sensor,
  encoder_lost,
  encoder_reversed,
  drop,
  corrupt,
  delay,
  bumper,
  trip,
  collapse,
  hang,
  battery,
  gyro_jump,
  slip,
  server_hang,
  core_stall,
  core_crash,
  link_loss,
  power_cut,
  obstacle,
  lurch,
  count
};
constexpr std::array<const char*, static_cast<std::size_t>(Kind::count)> kKindNames{"node unplugged",
                                                                                    "node frozen",
                                                                                    "sensor frozen",
                                                                                    "encoder lost",
                                                                                    "encoder reversed",
                                                                                    "frames dropped",
                                                                                    "frames corrupted",
                                                                                    "frames delayed",
                                                                                    "bumper",
                                                                                    "trip",
                                                                                    "collapse",
                                                                                    "hang",
                                                                                    "battery",
                                                                                    "gyro bias jump",
                                                                                    "wheel slips",
                                                                                    "server hangs",
                                                                                    "core stalls",
                                                                                    "core crashes",
                                                                                    "link to the stick lost",
                                                                                    "power cut",
                                                                                    "obstacle",
                                                                                    "pelvis turned"};

struct Event {
  Kind kind{};
  Node node{};
  double start_s{}, end_s{}, size{};
  bool on{false}, done{false};
};

constexpr std::array kTilts{Node::tilt_left, Node::tilt_right, Node::tilt_base};
constexpr std::array kDrives{Node::drive_left, Node::drive_right};
constexpr std::array kNodes{Node::drive_left, Node::drive_right, Node::io, Node::tilt_left, Node::tilt_right, Node::tilt_base};

constexpr double kRest_m_s = 0.08;  // a wheel this slow has stopped: a patient who still walks shakes the brakes of a hoist that holds
constexpr double kEps = 1e-6;

class Session {
 public:
  explicit Session(const SessionOptions& options) : options_(options), dice_(options.seed), loop_(loop_options()) {
    report_.seed = options.seed;
    plan_faults();
    loop_.world().set_frame_fault([this](std::size_t, const contract::CanFrame& frame, std::uint64_t) { return frame_fault(frame); });
  }

  SessionReport run() {
    const double settle_s = 12.0;
    while (loop_.time_s() < options_.length_s) step();
    // Everything is mended; whoever can still be helped must come to standby by the therapist's acknowledgement.
    finish_faults();
    mending_ = true;
    const double end_s = loop_.time_s() + settle_s;
    while (loop_.time_s() < end_s && loop_.mode() != Mode::standby) step();
    if (loop_.mode() != Mode::standby && !hopeless()) broken("I14: not back on standby within 12 s of mending");
    report_.digest = loop_.digest();
    return std::move(report_);
  }

 private:
  tests::ClosedLoopOptions loop_options() {
    tests::ClosedLoopOptions o;
    o.world.seed = dice_.next();
    o.world.patient = sim::PatientParams::random(dice_.next());
    o.world.patient.wish_m_s = dice_.between(0.2, 0.6);
    o.world.scenario = &sim::kScenarios[static_cast<std::size_t>(dice_.below(4))];
    o.world.worst_stuffing = dice_.chance(0.5);
    constexpr std::array kCaps{0.2, 0.5, 0.8, 1.0};
    o.params.speed_cap_norm = kCaps[static_cast<std::size_t>(dice_.below(4))];
    return o;
  }

  void plan_faults() {
    const int count = options_.faults_max == 0 ? 0 : dice_.below(options_.faults_max + 1);
    for (int i = 0; i < count; ++i) {
      Event e;
      e.kind = static_cast<Kind>(dice_.below(static_cast<int>(Kind::count)));
      e.start_s = dice_.between(6.0, options_.length_s - 5.0);
      e.end_s = e.start_s + (dice_.chance(0.5) ? dice_.between(0.02, 1.0) : dice_.between(1.0, 15.0));
      e.size = dice_.norm();
      switch (e.kind) {
        case Kind::freeze_sensor:
        case Kind::gyro_jump:
          e.node = kTilts[static_cast<std::size_t>(dice_.below(3))];
          break;
        case Kind::encoder_lost:
        case Kind::encoder_reversed:
        case Kind::slip:
          e.node = kDrives[static_cast<std::size_t>(dice_.below(2))];
          break;
        default:
          e.node = kNodes[static_cast<std::size_t>(dice_.below(6))];
      }
      events_.push_back(e);
    }
  }

  // ---- faults

  void apply(Event& e, bool on) {
    sim::World& world = loop_.world();
    const auto side = e.node == Node::drive_right ? sim::Side::right : sim::Side::left;
    switch (e.kind) {
      case Kind::unplug:
        world.unplug(e.node, on);
        break;
      case Kind::freeze:
        world.freeze(e.node, on);
        break;
      case Kind::freeze_sensor:
        world.freeze_sensor(e.node, on);
        break;
      case Kind::encoder_lost:
      case Kind::encoder_reversed:
        world.break_encoder(e.node, !on                            ? sim::World::EncoderFault::none
                                    : e.kind == Kind::encoder_lost ? sim::World::EncoderFault::lost
                                                                   : sim::World::EncoderFault::reversed);
        break;
      case Kind::bumper:
        world.plant().force_bumper(static_cast<int>(e.size * 4.0), on);
        break;
      case Kind::trip:
        if (on) world.patient().trip();
        break;
      case Kind::collapse:
        if (on) world.patient().collapse();
        break;
      case Kind::hang:
        if (on) world.patient().hang();
        break;
      case Kind::battery:
        world.plant().force_battery(on ? std::optional<double>(18.0 + 6.0 * e.size) : std::nullopt);
        break;
      case Kind::gyro_jump: {
        const std::size_t place = static_cast<std::size_t>(std::find(kTilts.begin(), kTilts.end(), e.node) - kTilts.begin());
        world.plant().jump_gyro_bias(static_cast<sim::Place>(place), (on ? 1.0 : -1.0) * (e.size - 0.5) * 0.35);
        break;
      }
      case Kind::slip:
        world.plant().set_grip(side, on ? 0.02 + 0.3 * e.size : 1.0);
        break;
      case Kind::server_hang:
        on ? loop_.stop_server() : loop_.resume_server();
        break;
      case Kind::core_stall:
        on ? loop_.kill_core() : loop_.resume_core();
        break;
      case Kind::core_crash:
        if (on) {
          loop_.kill_core();
        } else {
          loop_.restart_core();
          core_restarted();
        }
        break;
      case Kind::link_loss:
        if (on) loop_.fall_silent();
        link_lost_ = on;
        break;
      case Kind::power_cut:
        world.plant().cut_power(on);
        break;
      case Kind::obstacle: {
        if (!on) break;
        const sim::PlatformMotion& at = world.plant().platform();
        (void)world.plant().add_obstacle({at.x_m + 1.0 * std::cos(at.psi_rad), at.y_m + 1.0 * std::sin(at.psi_rad), 0.1});
        break;
      }
      case Kind::lurch:
        on ? world.patient().hold_turn((e.size - 0.5) * 1.2) : world.patient().release_turn();
        break;
      case Kind::drop:
      case Kind::corrupt:
      case Kind::delay:
      case Kind::count:
        break;
    }
  }

  bus::BusFault frame_fault(const contract::CanFrame&) {
    if (options_.frame_loss > 0 && dice_.chance(options_.frame_loss)) return {bus::BusFault::Kind::drop};
    for (const Event& e : events_) {
      if (!e.on) continue;
      if (e.kind == Kind::drop && dice_.chance(0.6 * e.size)) return {bus::BusFault::Kind::drop};
      if (e.kind == Kind::corrupt && dice_.chance(0.6 * e.size)) return {bus::BusFault::Kind::corrupt};
      if (e.kind == Kind::delay && dice_.chance(0.2)) return {bus::BusFault::Kind::delay, static_cast<std::uint64_t>(e.size * 40e6)};
    }
    return {};
  }

  void drive_faults() {
    const double now_s = loop_.time_s();
    for (Event& e : events_) {
      if (!e.on && !e.done && now_s >= e.start_s) {
        e.on = true;
        tell(std::string(kKindNames[static_cast<std::size_t>(e.kind)]) + " begins, node " + std::to_string(contract::node_id(e.node)));
        apply(e, true);
      } else if (e.on && now_s >= e.end_s) {
        e.on = false;
        e.done = true;
        tell(std::string(kKindNames[static_cast<std::size_t>(e.kind)]) + " ends");
        apply(e, false);
      }
    }
  }
  void finish_faults() {
    for (Event& e : events_) {
      if (e.on) apply(e, false);
      e.on = false;
      e.done = true;
    }
  }
  [[nodiscard]] bool ever(Kind kind) const {
    return std::any_of(events_.begin(), events_.end(), [kind](const Event& e) { return e.kind == kind && (e.on || e.done); });
  }
  [[nodiscard]] bool now(Kind kind) const {
    return std::any_of(events_.begin(), events_.end(), [kind](const Event& e) { return e.kind == kind && e.on; });
  }
  [[nodiscard]] bool any_fault_yet() const {
    return std::any_of(events_.begin(), events_.end(), [](const Event& e) { return e.on || e.done; });
  }
  // A simulated processor that stands still keeps its outputs; a real one has a watchdog (tests/machine).
  [[nodiscard]] bool frozen_drive() const {
    return std::any_of(events_.begin(), events_.end(), [](const Event& e) {
      return e.kind == Kind::freeze && (e.on || e.done) && (e.node == Node::drive_left || e.node == Node::drive_right);
    });
  }
  [[nodiscard]] bool fallen() { return loop_.world().patient().state() >= sim::PatientState::tripping; }
  // What no acknowledgement can mend: a patient on the floor, a post against a bumper.
  [[nodiscard]] bool hopeless() {
    return ever(Kind::trip) || ever(Kind::collapse) || ever(Kind::hang) || loop_.world().plant().bumpers() != 0;
  }

  // ---- the therapist, ten times a second

  void ask(CommandKind kind, std::uint32_t a = 0, double v0 = 0.0) { loop_.ask(kind, a, v0); }

  void therapist() {
    if (!core_runs() || now(Kind::server_hang)) return;
    const TickRecord& record = loop_.record();
    const double now_s = loop_.time_s();
    switch (loop_.mode()) {
      case Mode::init:
        return;
      case Mode::standby:
        loop_.fall_silent();
        if (mending_ || now_s < next_s_) return;
        next_s_ = now_s + 0.5;
        if (record.lease_holder == 0) return ask(CommandKind::take_lease);
        if (dice_.chance(0.1)) return tune();
        if (record.blocked_bits != 0) return;
        ask(CommandKind::request_mode, static_cast<std::uint32_t>(dice_.chance(0.7) ? Mode::user : Mode::remote));
        next_s_ = now_s + dice_.between(4.0, 25.0);
        return;
      case Mode::user:
        if (now_s < next_s_ && !mending_) return;
        if (dice_.chance(0.3)) {
          tune();
          next_s_ = now_s + dice_.between(1.0, 10.0);
          return;
        }
        if (dice_.chance(0.2)) {
          tell("STOP");
          asked_stop_s_ = now_s;
          return ask(CommandKind::stop);
        }
        ask(CommandKind::request_mode, static_cast<std::uint32_t>(Mode::standby));
        asked_stop_s_ = now_s;
        next_s_ = now_s + dice_.between(1.0, 4.0);
        return;
      case Mode::remote:
        if (mending_ || now_s >= next_s_) {
          loop_.let_go();
          ask(CommandKind::request_mode, static_cast<std::uint32_t>(Mode::standby));
          asked_stop_s_ = now_s;
          next_s_ = now_s + dice_.between(1.0, 4.0);
          return;
        }
        if (link_lost_) return loop_.fall_silent();
        if (now_s < stick_s_) return;
        stick_s_ = now_s + dice_.between(0.5, 2.5);
        if (dice_.chance(0.25))
          loop_.let_go();
        else if (dice_.chance(0.1)) {
          loop_.fall_silent();
          asked_stop_s_ = now_s;  // the stick fell silent while pushed: that the hoist stops is no false stop
          stick_s_ = now_s + dice_.between(0.05, 1.5);
        } else {
          // A hand that thinks of the patient: no jumps from full ahead to full astern, which the fall guard rightly stops.
          stick_speed_norm_ = std::clamp(stick_speed_norm_ + dice_.between(-0.35, 0.35), -0.3, 1.0);
          loop_.hold_stick(stick_speed_norm_, dice_.between(-0.7, 0.7));
        }
        return;
      case Mode::protective_stop:
        loop_.fall_silent();
        if (now_s < next_s_) return;
        next_s_ = now_s + dice_.between(0.8, 2.5);
        if (record.lease_holder == 0) return ask(CommandKind::take_lease);
        acknowledged_s_ = now_s;
        return ask(CommandKind::acknowledge);
      case Mode::fault:
      case Mode::emergency_stop:
        loop_.fall_silent();
        if (now_s < next_s_) return;
        next_s_ = now_s + dice_.between(0.8, 2.5);
        if (record.lease_holder == 0) return ask(CommandKind::take_lease);
        acknowledged_s_ = now_s;
        loop_.ask(CommandKind::acknowledge, 0, 0, 0, 0, static_cast<std::uint32_t>(contract::Role::engineer));
        return;
      case Mode::calibrate:
      case Mode::guided:
        return ask(CommandKind::request_mode, static_cast<std::uint32_t>(Mode::standby));
    }
  }

  // One changed parameter, sometimes impossible.
  void tune() {
    const std::size_t index = static_cast<std::size_t>(dice_.below(static_cast<int>(contract::kParamCount)));
    const auto& info = contract::kParams[index];
    const double value = dice_.chance(0.3) ? info.max * 3.0 + 1.0 : dice_.between(info.min, info.max);
    if (info.edit != contract::EditRule::live || info.role != contract::Role::therapist) return;
    ask(CommandKind::stage_parameter, info.id, value);
    loop_.ask(CommandKind::commit_parameters, 1, 0, 0, 0, static_cast<std::uint32_t>(contract::Role::therapist));
  }

  // ---- one step and what must hold after it

  [[nodiscard]] bool core_runs() const { return !now(Kind::core_stall) && !now(Kind::core_crash); }
  void core_restarted() {
    last_mode_ = Mode::init;
    last_command_m_s_ = 0;
    moving_end_s_ = loop_.time_s();
    raised_ = 0;
    events_seen_ = loop_.events().size();
    ran_ = false;
  }

  void step() {
    drive_faults();
    if (++ticks_ % 10 == 0) therapist();
    const bool ran = core_runs();
    loop_.step();
    const sim::PlatformMotion& truth = loop_.world().plant().platform();
    report_.distance_m += std::fabs(truth.speed_m_s) * 0.01;
    watch_truth(ran);
    if (ran) watch_core();
  }

  void watch_truth(bool ran) {
    const double now_s = loop_.time_s();
    const sim::Plant& plant = loop_.world().plant();
    const bool odd = ever(Kind::encoder_lost) || ever(Kind::encoder_reversed) || fallen() || ever(Kind::slip) || ever(Kind::power_cut) ||
                     ever(Kind::obstacle) || frozen_drive();
    if (!odd) {
      if (std::fabs(plant.platform().speed_m_s) > 0.75) broken("I2: faster than 0.75 m/s", plant.platform().speed_m_s);
      if (std::fabs(plant.platform().yaw_rate_rad_s) > 1.1)
        broken("I2: turns faster than 63 degrees a second", plant.platform().yaw_rate_rad_s);
    }
    // I8: without the core the drives brake by themselves: 50 ms, then at most 0.75 s of ramp and the time to be sure of standstill.
    if (ran)
      core_silent_s_ = now_s;
    else if (now_s - core_silent_s_ > 1.3 && !odd && fastest_wheel() > kRest_m_s)
      broken("I8: a wheel turns 1.3 s after the core's last command", fastest_wheel());
  }
  [[nodiscard]] double fastest_wheel() {
    const sim::Plant& plant = loop_.world().plant();
    return std::max(std::fabs(plant.wheel_speed_m_s(sim::Side::left)), std::fabs(plant.wheel_speed_m_s(sim::Side::right)));
  }

  void watch_core() {
    const double now_s = loop_.time_s();
    const TickRecord& record = loop_.record();
    const Mode mode = loop_.mode();
    const bool moving_mode = mode == Mode::user || mode == Mode::remote;
    // I13
    if (const char* name = not_finite(record)) broken("I13: the record holds no number in ", 0.0, name);
    // I4
    const double wheels = std::max(std::fabs(static_cast<double>(record.wheel_left_command_m_s)),
                                   std::fabs(static_cast<double>(record.wheel_right_command_m_s)));
    if ((mode == Mode::init || mode == Mode::standby) && wheels > 0.0) broken("I4: wheels commanded in a mode that does not move", wheels);
    // I2: limits of what is commanded.
    const double speed = static_cast<double>(record.speed_command_m_s);
    if (std::fabs(speed) > 0.65 + kEps) broken("I2: commanded above the top speed", speed);
    const bool follow = enabled(record.left_status_word) && enabled(record.right_status_word);
    // With one drive out, what the other one is told is no turn of the hoist.
    if (follow && std::fabs(static_cast<double>(record.yaw_rate_command_rad_s)) > 0.872664626 + 1e-4)
      broken("I2: commanded above the top turn rate", static_cast<double>(record.yaw_rate_command_rad_s));
    if (ran_ && mode == last_mode_ && follow && followed_) {
      const double change = std::fabs(speed) - std::fabs(last_command_m_s_);
      const double braking = contract_fault(record, Fault::bumper_pressed) ? 1.5 : 1.0;
      if (change > 0.5 * 0.01 + 1e-5) broken("I2: speeds up faster than 0.5 m/s2", change / 0.01);
      if (-change > braking * 0.01 + 1e-5) broken("I2: brakes harder than allowed", -change / 0.01);
    }
    // I3, I6
    if (mode == Mode::remote) {
      if (record.lease_holder == 0 && std::fabs(static_cast<double>(record.speed_wish_m_s)) > 0) broken("I3: drives without a driver");
      if (record.remote_age_s > 0.26F && (record.speed_wish_m_s != 0 || record.yaw_rate_wish_rad_s != 0))
        broken("I6: an old command acts", static_cast<double>(record.remote_age_s));
    }
    // I1: at rest soon after motion has ended, whatever ended it.
    if (moving_mode) moving_end_s_ = now_s;
    const bool pushed = fallen() || ever(Kind::encoder_lost) || ever(Kind::encoder_reversed) || frozen_drive();
    if (!moving_mode && now_s - moving_end_s_ > 1.3 && fastest_wheel() > kRest_m_s && !pushed)
      broken("I1: a wheel turns 1.3 s after motion ended", fastest_wheel());
    if (moving_mode) report_.walked_s += 0.01;

    watch_events(now_s);
    last_mode_ = mode;
    last_command_m_s_ = speed;
    followed_ = follow;
    ran_ = true;
  }

  void watch_events(double now_s) {
    const auto& events = loop_.events();
    for (; events_seen_ < events.size(); ++events_seen_) {
      const contract::Event& e = events[events_seen_];
      const std::uint32_t bit = e.code < 32 ? 1U << e.code : 0U;
      if (e.kind == contract::EventKind::fault_raised) {
        tell("fault " + std::string(contract::fault_info(static_cast<Fault>(e.code)).name));
        if ((raised_ & bit) != 0) broken("I11: a fault is raised twice: ", 0.0, contract::fault_info(static_cast<Fault>(e.code)).name);
        raised_ |= bit;
      } else if (e.kind == contract::EventKind::fault_cleared) {
        if ((raised_ & bit) == 0)
          broken("I11: a fault is cleared that was not raised: ", 0.0, contract::fault_info(static_cast<Fault>(e.code)).name);
        raised_ &= ~bit;
      } else if (e.kind == contract::EventKind::mode_changed) {
        watch_mode_change(static_cast<Mode>(e.item), static_cast<Mode>(e.code), now_s);
      }
    }
  }

  void watch_mode_change(Mode from, Mode to, double now_s) {
    tell("mode " + std::string(contract::kModes[static_cast<std::size_t>(from)].name) + " to " +
         std::string(contract::kModes[static_cast<std::size_t>(to)].name));
    const auto& record = loop_.record();
    if (to == Mode::protective_stop || from == Mode::user || from == Mode::remote) next_s_ = now_s + dice_.between(0.8, 2.5);
    const bool allowed = std::any_of(core::kTransitions.begin(), core::kTransitions.end(),
                                     [&](const core::Transition& t) { return t.from == from && t.to == to; });
    if (!allowed) broken("I5: a change of mode that no table allows");
    const bool released = (from == Mode::protective_stop && to == Mode::standby) || to == Mode::init;
    if (released && from != Mode::standby && now_s - acknowledged_s_ > 0.6) broken("I5: a stop ended without acknowledgement");
    if (to == Mode::user || to == Mode::remote) {
      ++report_.starts;
      if (std::fabs(record.lean_norm) > 0.2F + 1e-3F || std::fabs(record.turn_norm) > 0.2F + 1e-3F)
        broken("I7: a start away from neutral", static_cast<double>(record.lean_norm));
    }
    if (to == Mode::protective_stop) ++report_.stops;
    const bool ended = (from == Mode::user || from == Mode::remote) && (to == Mode::protective_stop || to == Mode::standby);
    if (ended && !any_fault_yet() && now_s - asked_stop_s_ > 4.0) {
      // A patient who is driven about may rightly trip the fall guard; one who walks as he likes must never.
      if (from == Mode::remote && contract_fault(record, Fault::fall_detected)) return;
      ++report_.false_stops;
      if (options_.frame_loss == 0.0)
        broken("false stop: ", 0.0,
               record.stop_cause > 0 ? contract::fault_info(static_cast<Fault>(record.stop_cause - 1U)).name : "soft stop");
    }
  }

  // Only drives that say they follow commands can be held to the ramp; others brake by themselves.
  static bool enabled(std::uint16_t status_word) {
    return contract::canopen::drive::state(status_word) == contract::canopen::drive::State::operation_enabled;
  }
  static bool contract_fault(const TickRecord& record, Fault fault) {
    return ((record.fault_bits >> contract::fault_info(fault).bit) & 1U) != 0;
  }

  static const char* not_finite(const TickRecord& record) {
    const auto* bytes = reinterpret_cast<const char*>(&record);
    for (const contract::SignalInfo& signal : contract::kSignals) {
      if (signal.type != contract::SignalType::f32) continue;
      float value = 0;
      std::memcpy(&value, bytes + signal.offset, sizeof value);
      if (!std::isfinite(value)) return signal.name.data();
    }
    return nullptr;
  }

  void tell(const std::string& what) {
    if (!options_.tell) return;
    char time[24];
    std::snprintf(time, sizeof time, "%8.2f s  ", loop_.time_s());
    report_.story.push_back(time + what);
  }
  void broken(std::string_view what, double value = 0.0, std::string_view name = {}) {
    // One line for each promise: the first time tells most.
    if (std::find(told_.begin(), told_.end(), what) != told_.end()) return;
    told_.push_back(what);
    char text[200];
    std::snprintf(text, sizeof text, "%8.2f s  %.*s%.*s (%g)", loop_.time_s(), static_cast<int>(what.size()), what.data(),
                  static_cast<int>(name.size()), name.data(), value);
    report_.broken.emplace_back(text);
    tell(std::string("BROKEN ") + text);
  }

  SessionOptions options_;
  Dice dice_;
  tests::ClosedLoop loop_;
  SessionReport report_;
  std::vector<Event> events_;
  std::vector<std::string_view> told_;
  std::uint64_t ticks_{};
  double next_s_{}, stick_s_{}, asked_stop_s_{-100.0}, acknowledged_s_{-100.0};
  double stick_speed_norm_{};
  double moving_end_s_{}, core_silent_s_{}, last_command_m_s_{};
  Mode last_mode_{Mode::init};
  std::size_t events_seen_{};
  std::uint32_t raised_{};
  bool mending_{false}, link_lost_{false}, ran_{false}, followed_{false};
};

}  // namespace

SessionReport run_session(const SessionOptions& options) { return Session(options).run(); }

}  // namespace hoist::chaos
