#include "tests/chaos/session.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <sstream>
#include <utility>

#include "control/contract/faults.hpp"
#include "control/contract/guided_path.hpp"
#include "control/contract/params.hpp"
#include "control/contract/signals.hpp"
#include "control/core/supervise/supervisor.hpp"
#include "firmware/nodes/tilt/tilt_node.hpp"
#include "firmware/sim/patient_family.hpp"
#include "tests/chaos/judge/watch.hpp"
#include "tests/chaos/moments.hpp"
#include "tests/chaos/storage.hpp"
#include "tests/support/closed_loop.hpp"

namespace hoist::chaos {
namespace {

using contract::CanFrame;
using contract::Command;
using contract::CommandKind;
using contract::Mode;
using contract::Node;
using contract::TickRecord;

// Random streams of a session: independent of each other.
constexpr std::uint64_t kWorldStream = 2, kTherapistStream = 3, kFrameStream = 4, kFaultStream = 5, kLinkStream = 6, kSerialStream = 7,
                        kStorageStream = 8, kDefianceStream = 10, kPatientStream = 11, kRescueStream = 15, kEchoStream = 17,
                        kMomentStream = 22;
constexpr double kUnevenShare = 0.5;  // of the sessions: walked by one of the family
// The longest way back: a tilt node's start with every try of the self-test, its still 2 s, the hoist's second of standing, the therapist's tries.
constexpr double kMending_s = 1e-3 * firmware::kTiltStart_ms + 2.0 + 1.0 + 1.0;
// A tilt filter unlearns a full scale of 4.36 rad/s with 6.7 s (30 s to 3 degrees a second); what it sends meanwhile, added up by the core with a
// memory of 10 s, is below 30 degrees after 51 s.
constexpr double kUnlearning_s = 60.0;
constexpr std::size_t kRemembered = 64;
constexpr double kNever_s = 1e9;

class Session {
 public:
  explicit Session(const SessionOptions& options)
      : options_(options),
        faults_(options.faults ? *options.faults : plan_faults(options.seed, options.faults_max, options.length_s, options.outside_only)),
        board_(faults_),
        therapist_dice_(options.seed, kTherapistStream),
        frame_dice_(options.seed, kFrameStream),
        fault_dice_(options.seed, kFaultStream),
        link_dice_(options.seed, kLinkStream),
        serial_dice_(options.seed, kSerialStream),
        defiance_dice_(options.seed, kDefianceStream),
        rescue_dice_(options.seed, kRescueStream),
        echo_dice_(options.seed, kEchoStream),
        loop_(loop_options()),
        moments_(loop_, Dice(options.seed, kMomentStream)),
        watch_(loop_.world(), board_, {options_.tell, options_.frame_loss > 0.0}, loop_.core().params, report_) {
    report_.seed = options.seed;
    report_.faults = faults_;
    report_.patient = patient_of(options);
    report_.length_s = options.length_s;
    report_.hashes.reserve(static_cast<std::size_t>(options.length_s) + 20);
    const bool frames_fail = options_.frame_loss > 0 || planned(Kind::drop) || planned(Kind::corrupt) || planned(Kind::delay) ||
                             planned(Kind::duplicate) || planned(Kind::bus_off) || planned(Kind::mute_core) || planned(Kind::tuned_twice);
    if (frames_fail)
      loop_.world().set_frame_fault([this](std::size_t port, const CanFrame& frame, std::uint64_t) { return frame_fault(port, frame); });
    loop_.on_inputs([this](const core::TickInputs& inputs) { see(inputs); });
    loop_.on_sent([this](const CanFrame& frame) {
      watch_.sent(frame);
      // The drives' commands alone: alarm signals to the input node may differ.
      if (frame.id != contract::pdo_cob_id(contract::Pdo::drive_rx1, contract::Node::drive_left) &&
          frame.id != contract::pdo_cob_id(contract::Pdo::drive_rx1, contract::Node::drive_right))
        return;
      std::uint64_t word = frame.id;
      for (const std::uint8_t byte : frame.data) word = word << 8 ^ byte;
      report_.motion = (report_.motion ^ word) * 0x9E3779B97F4A7C15ULL;
      report_.motion ^= report_.motion >> 29;
    });
    loop_.on_millisecond([this] { watch_.see_millisecond(); });
    if (options_.sabotage)
      loop_.break_core([this](core::CoreState& core, core::TickOutputs& out) { options_.sabotage(loop_.time_s(), core, out); });
    if (options_.storage && (options_.record || options_.lying_disk ||
                             std::any_of(faults_.begin(), faults_.end(), [](const Fault& f) { return info(f.kind).disk; })))
      begin_storage();
    if (options_.link_jitter_s > 0) delay_commands(options_.link_jitter_s);
  }

  SessionReport run() {
    while (loop_.time_s() < options_.length_s) step();
    if (!options_.only_walk) {
      // All faults are removed; every recoverable session must reach STANDBY by the therapist's acknowledgement.
      for (Planned& row : board_.rows) {
        row.done = true;
        if (std::exchange(row.on, false)) apply(row, false);
      }
      mending_ = true;
      next_s_ = loop_.time_s();  // the therapist does only this now
      // The published tilt filter takes long to unlearn the bias of a sensor that lied, or of a gyroscope whose zero came back.
      const bool unlearns = board_.ever(Kind::sensor_stuck) || board_.ever(Kind::sensor_offset) || board_.ever(Kind::sensor_garbage) ||
                            board_.ever(Kind::sensor_slow) || board_.ever(Kind::gyro_jump);
      double end_s = loop_.time_s() + kMending_s + (unlearns ? kUnlearning_s : 0.0);
      bool switched_off = false;
      while (loop_.mode() != Mode::standby) {
        if (loop_.time_s() >= end_s) {
          // A gyroscope whose zero was off while it was being measured, and came back, marks its samples invalid until
          // the hoist is switched off and on, as its alarm says. A core that was started meanwhile waits for them in INIT.
          const bool doubts =
              (loop_.core().conditions & contract::fault_bit(contract::Fault::tilt_sensor_fault)) != 0 || loop_.mode() == Mode::init;
          const bool was_off = board_.ever(Kind::gyro_jump) || board_.ever(Kind::sensor_offset);
          if (switched_off || !doubts || !was_off) break;
          switched_off = true;
          for (const contract::Node node : {contract::Node::tilt_left, contract::Node::tilt_right, contract::Node::tilt_base}) {
            loop_.world().unplug(node, true);
            loop_.world().unplug(node, false);
          }
          end_s = loop_.time_s() + kMending_s;
        }
        step();
      }
      if (loop_.mode() != Mode::standby && !hopeless()) {
        const core::CoreState& core = loop_.core();
        std::ostringstream why;
        why << "I14: not back on standby soon after mending; faults in force " << std::hex << core.latched << ", found now "
            << core.conditions << ", start blocked by " << core::start_refusals(core);
        watch_.broken(why.str());
      }
    }
    report_.digest = loop_.digest();
    if (storage_ != nullptr) {
      Dice dice(options_.seed, kStorageStream);
      // The core that is run again is the whole one, unless the test is about a broken one.
      const bool again = options_.record || !options_.sabotage;
      for (const std::string& line : storage_->verify(options_.lying_disk || dice.chance(0.5), again)) watch_.broken(line);
      report_.samples = storage_->samples();
      report_.samples_again = storage_->samples_again();
      report_.samples_not_run = storage_->samples_not_run();
    }
    return std::move(report_);
  }

 private:
  tests::ClosedLoopOptions loop_options() {
    Dice dice(options_.seed, kWorldStream);
    tests::ClosedLoopOptions o;
    o.world.seed = dice.next();
    o.world.patient = sim::PatientParams::random(dice.next());
    o.world.patient.wish_m_s = dice.between(0.2, 0.6);
    if (const sim::FamilyMember* member = sim::find_patient(patient_of(options_))) {
      o.world.patient = member->params;
      o.world.patient.variation.seed = options_.seed;
    }
    o.world.patient.yields_after_s = sim::PatientParams::kStubborn_s;
    o.world.scenario = &sim::kScenarios[static_cast<std::size_t>(dice.below(4))];
    if (options_.only_walk) o.world.scenario = &sim::kScenarios[static_cast<std::size_t>(dice.below(2))];
    o.world.worst_stuffing = dice.chance(0.5);
    constexpr std::array kCaps{0.2, 0.5, 0.8, 1.0};
    o.params.speed_cap_norm = kCaps[static_cast<std::size_t>(dice.below(4))];
    if (planned(Kind::wrong_part)) be_a_checked_hoist(o);
    o.through_gateway = dice.chance(0.05) || planned(Kind::serial_noise);
    return o;
  }
  // Not a simulator's parts, which need no check, but numbered ones that were checked as they are built.
  static void be_a_checked_hoist(tests::ClosedLoopOptions& o) {
    constexpr double kToday_s = 1.8e9;
    o.world.numbered = true;
    o.params.calibrated_zero_s = o.params.calibrated_encoders_s = o.params.calibrated_bumpers_s = o.params.calibrated_struts_s = kToday_s;
    // As the core sums them up (FNV-1a), each byte of each number in its place.
    std::uint32_t id = 0x811C9DC5U;
    for (std::size_t n = 0; n < contract::kRemoteNodeCount; ++n)
      for (unsigned shift = 0; shift < 32; shift += 8)
        id = (id ^ (sim::World::first_serial(static_cast<Node>(n)) >> shift & 0xFFU)) * 0x01000193U;
    o.params.calibrated_nodes_id = static_cast<double>(id);
  }
  [[nodiscard]] bool planned(Kind kind) const {
    return std::any_of(faults_.begin(), faults_.end(), [kind](const Fault& f) { return f.kind == kind; });
  }

  [[nodiscard]] std::uint64_t clock_ns() { return 1'000'000'000 + loop_.world().time_ns(); }
  void begin_storage() {
    storage_ = std::make_unique<Storage>(Dice(options_.seed, kStorageStream + 1).next());
    storage_->lie(options_.lying_disk);
    storage_->core_started(clock_ns());
    storage_->tick(clock_ns());
    storage_->start_server();
    loop_.on_step([this](const core::TickInputs& inputs, const core::TickOutputs& outputs) { storage_->publish(inputs, outputs); });
  }

  // ---- faults

  // Server, disk and wall clock, where a session has them.
  void apply_to_storage(const Fault& f, bool on) {
    if (storage_ == nullptr) return;
    switch (f.kind) {
      case Kind::core_crash:
        if (!on) storage_->core_started(clock_ns());
        break;
      case Kind::server_hang:
        storage_->hang(on);
        break;
      case Kind::server_crash:
        on ? storage_->kill_server() : storage_->start_server();
        break;
      case Kind::disk_full:
        storage_->fill_disk(on);
        break;
      case Kind::disk_slow:
        storage_->slow_disk(on ? 0.2 * f.size * f.size : 0.0);
        break;
      case Kind::disk_error:
        storage_->fail_disk(on ? f.size * f.size : 0.0);
        break;
      case Kind::disk_power_cut:
        on ? storage_->cut_power() : storage_->start_server();
        break;
      case Kind::clock_jump:
        storage_->jump_clock((on ? 1.0 : -1.0) * (f.size - 0.5) * 1e5);
        break;
      default:
        break;
    }
  }

  // The part whose defect it is, of those that the simulator breaks in one way at a time; 0: none.
  static int one_at_a_time(Kind kind) {
    switch (kind) {
      case Kind::sensor_offset:
      case Kind::sensor_garbage:
      case Kind::sensor_slow:
      case Kind::sensor_silent:
        return 1;
      case Kind::encoder_lost:
      case Kind::encoder_reversed:
        return 2;
      case Kind::shove:
      case Kind::held:
        return 3;
      case Kind::battery:
      case Kind::battery_full:
      case Kind::supply_rises:
        return 4;
      case Kind::bridge_shorted:
      case Kind::bridges_shorted:
        return 5;
      case Kind::wrong_part:
        return 6;
      default:
        return 0;
    }
  }

  // Full or half duty, ahead or back, both wheels the same way or against each other.
  static double both_duty(double size, sim::Side side) {
    const int which = std::min(static_cast<int>(size * 8.0), 7);
    const double duty_norm = (which & 1) != 0 ? 1.0 : 0.5, way = (which & 2) != 0 ? 1.0 : -1.0;
    return duty_norm * way * ((which & 4) != 0 && side == sim::Side::right ? -1.0 : 1.0);
  }

  // Just ahead of the casters, or behind the wheels of a hoist that rolls back; both wheels, the left or the right; up to 14 degrees askew.
  void lay_edge(const Fault& f) {
    const sim::PlatformMotion& at = loop_.world().plant().platform();
    const bool sill = f.kind == Kind::sill;
    const int which = std::min(static_cast<int>(f.size * 3.0), 2);
    const double share = f.size * 3.0 - which;
    const bool back = at.speed_m_s < -0.02;
    const double ahead_m = back ? -0.12 : loop_.world().plant().params().caster_ahead_m + 0.15;
    sim::FloorEdge edge{at.x_m + ahead_m * std::cos(at.psi_rad), at.y_m + ahead_m * std::sin(at.psi_rad),
                        at.psi_rad + (back ? sim::kPi : 0.0) + (share - 0.5) * 0.5};
    edge.height_m = sill ? 0.004 + 0.016 * share : -(0.005 + 0.025 * share);
    edge.length_m = sill ? 0.03 + 0.12 * (1.0 - share) : 0.0;
    edge.left = which != 1;
    edge.right = which != 2;
    (void)loop_.world().plant().lay_edge(edge);
  }

  void apply(Planned& row, bool on) {
    const Fault& f = row.fault;
    sim::World& world = loop_.world();
    const auto side = f.node == Node::drive_right ? sim::Side::right : sim::Side::left;
    const auto sensor = [&](sim::World::SensorFault fault) {
      world.break_sensor(f.node, on ? fault : sim::World::SensorFault::none, f.size);
    };
    switch (f.kind) {
      case Kind::unplug:
        world.unplug(f.node, on);
        break;
      case Kind::loose_plug:
        world.unplug(f.node, false);
        break;
      case Kind::freeze:
        world.freeze(f.node, on);
        break;
      case Kind::reboot:
        world.freeze(f.node, on);
        if (on) world.freeze(f.node, false);
        break;
      case Kind::sensor_stuck:
        world.freeze_sensor(f.node, on);
        break;
      case Kind::sensor_offset:
        sensor(sim::World::SensorFault::offset);
        break;
      case Kind::sensor_garbage:
        sensor(sim::World::SensorFault::garbage);
        break;
      case Kind::sensor_slow:
        sensor(sim::World::SensorFault::slow);
        break;
      case Kind::sensor_silent:
        sensor(sim::World::SensorFault::silent);
        // A failed sensor stays invalid until a power cycle, which is the repair here.
        if (!on) {
          world.unplug(f.node, true);
          world.unplug(f.node, false);
        }
        break;
      case Kind::encoder_lost:
      case Kind::encoder_reversed:
        world.break_encoder(f.node, !on                            ? sim::World::EncoderFault::none
                                    : f.kind == Kind::encoder_lost ? sim::World::EncoderFault::lost
                                                                   : sim::World::EncoderFault::reversed);
        break;
      case Kind::bumper:
        world.plant().force_bumper(std::min(static_cast<int>(f.size * 4.0), 3), on);
        break;
      case Kind::trip:
        if (on) world.patient().trip();
        break;
      case Kind::collapse:
        if (on) world.patient().collapse();
        break;
      case Kind::fall_aside:  // to any side, as over a slipped foot
        if (on) world.patient().trip((2.0 * f.size - 1.0) * sim::kPi);
        if (on && rescue_dice_.chance(0.8)) rescue_s_ = loop_.time_s() + rescue_dice_.between(0.4, 1.0);
        break;
      case Kind::faint:
        if (on) world.patient().collapse((2.0 * f.size - 1.0) * sim::kPi);
        break;
      case Kind::hang:
        if (on) world.patient().hang();
        break;
      case Kind::shove: {  // hands at the frame: up to 120 N and 25 N m, in any direction
        const double way_rad = 2.0 * sim::kPi * f.size;
        world.plant().set_shove(on ? 120.0 * std::cos(way_rad) : 0.0, on ? 25.0 * std::sin(way_rad) : 0.0);
        break;
      }
      case Kind::held:
        if (!on) world.plant().set_shove(0.0, 0.0);
        break;
      case Kind::battery_full:
        // What braking gives back to a battery that takes no more, or a charger that fails: 32.6 to 36 V; the drives bear 32. From 30 V on they
        // brake less, see README.md.
        world.plant().force_battery(on ? std::optional<double>(32.6 + 3.4 * f.size) : std::nullopt);
        break;
      case Kind::supply_rises:
        world.plant().force_battery(on ? std::optional<double>(28.0) : std::nullopt);
        break;
      case Kind::bridges_shorted:
        for (const sim::Side wheel : {sim::Side::left, sim::Side::right})
          world.plant().short_bridge(wheel, on ? std::optional<double>(both_duty(f.size, wheel)) : std::nullopt);
        break;
      case Kind::battery:
        world.plant().force_battery(on ? std::optional<double>(18.0 + 6.0 * f.size) : std::nullopt);
        break;
      case Kind::battery_weak:
        world.plant().weaken_battery(on ? 2.0 * f.size : 0.0);
        break;
      case Kind::skid:
        // Both wheels on wet floor, and the frame is twisted by up to 7 N m either way, of which the wheels take 4.
        world.slip(
            {.seconds = on ? f.end_s - f.start_s : 0.001, .grip_norm = {0.03, 0.03}, .push_n = 0.0, .twist_n_m = (f.size - 0.5) * 14.0});
        break;
      case Kind::gyro_jump: {
        const auto place = f.node == Node::tilt_left    ? sim::Place::left_strut
                           : f.node == Node::tilt_right ? sim::Place::right_strut
                                                        : sim::Place::chassis;
        world.plant().jump_gyro_bias(place, (on ? 1.0 : -1.0) * (f.size - 0.5) * 0.35);
        break;
      }
      case Kind::slip:
        world.plant().set_grip(side, on ? 0.02 + 0.3 * f.size : world.plant().params().grip_norm);
        break;
      case Kind::wheel_blocked:
        world.plant().block_wheel(side, on);
        break;
      case Kind::bridge_shorted:
        world.plant().short_bridge(side, on ? std::optional<double>(2.0 * f.size - 1.0) : std::nullopt);
        break;
      case Kind::power_cut:
        world.plant().cut_power(on);
        break;
      case Kind::emergency_stop:
        world.plant().press_emergency_stop(on);
        break;
      case Kind::obstacle: {
        if (!on) break;
        const sim::PlatformMotion& at = world.plant().platform();
        (void)world.plant().add_obstacle({at.x_m + 1.0 * std::cos(at.psi_rad), at.y_m + 1.0 * std::sin(at.psi_rad), 0.1});
        break;
      }
      case Kind::slope:
        // Up to 10 degrees in any direction; limited in time, so that the hoist can return to level floor.
        world.plant().tilt_floor(on ? 0.17 * f.size : 0.0, 40.0 * f.size);
        break;
      case Kind::sill:
      case Kind::step_down:
        on ? lay_edge(f) : world.plant().take_edge();
        break;
      case Kind::strap_cut:  // both, the left or the right; fastened when the hoist is at rest
        if (!on) break;
        for (const sim::Side cut : {sim::Side::left, sim::Side::right})
          if (f.size < 0.34 || (f.size < 0.67) == (cut == sim::Side::left)) world.plant().cut_strap(cut, true);
        break;
      case Kind::loose_strut:  // 2 to 14 degrees of play
        world.plant().loosen_box(f.node == Node::tilt_left ? sim::Place::left_strut : sim::Place::right_strut,
                                 on ? (2.0 + 12.0 * f.size) * sim::kDegree_rad : 0.0);
        break;
      case Kind::wrong_part:
        // Another part, the wrong way round or on the wrong side; then the checked one again, in its place.
        on ? world.exchange(f.node, ++strange_serial_, f.size < 0.5 ? sim::World::Assembly::reversed : sim::World::Assembly::swapped)
           : world.exchange(f.node, sim::World::first_serial(f.node), sim::World::Assembly::right);
        break;
      case Kind::pelvis_turned:
        on ? world.patient().hold_turn((f.size - 0.5) * 1.2) : world.patient().release_turn();
        break;
      case Kind::core_bus_off:
        loop_.set_bus_up(!on);
        break;
      case Kind::core_stall:
        on ? loop_.kill_core() : loop_.resume_core();
        // It sees by its clock how long it was away.
        if (!on) loop_.be_late(f.end_s - f.start_s);
        break;
      case Kind::core_crash:
        forget_commands();
        if (on) {
          loop_.kill_core();
        } else {
          loop_.restart_core();
          watch_.core_restarted(loop_.core().params, loop_.core().parameter_version, loop_.events().size());
        }
        break;
      case Kind::server_hang:
        on ? loop_.stop_server() : loop_.resume_server();
        break;
      case Kind::server_crash:
        on ? loop_.stop_server() : loop_.restart_server();
        forget_commands();
        break;
      case Kind::link_loss:
        loop_.cut_link(on);
        break;
      case Kind::link_stall:
        loop_.stall_link(on);
        break;
      case Kind::link_jitter:
        delay_commands(on ? 0.4 * f.size : options_.link_jitter_s);
        break;
      case Kind::tab_freeze:
        if (on) loop_.fall_silent();
        break;
      case Kind::take_over:
        if (!on) loop_.ask_as(kStranger, CommandKind::release_lease);
        break;
      case Kind::logout:
        // The server releases the lease of a client that is signed out.
        if (on) loop_.ask_as(0, CommandKind::release_lease, 1);
        break;
      case Kind::serial_noise:
        if (on)
          loop_.set_serial_noise([this, share = 0.02 * f.size * f.size](char& c) {
            if (serial_dice_.chance(share)) c = static_cast<char>(serial_dice_.below(256));
          });
        else
          loop_.set_serial_noise({});
        break;
      default:
        if (!on) moments_.end(f);
        break;  // acts in each step, or on each frame
    }
    apply_to_storage(f, on);
    // A part has one defect at a time: the other one goes on. Of the older kinds only sensors and encoders, or old seeds would change.
    if (const int part = one_at_a_time(f.kind); !on && part != 0)
      for (Planned& other : board_.rows) {
        if (!other.on || one_at_a_time(other.fault.kind) != part) continue;
        if (part <= 2 ? other.fault.node == f.node : std::max(f.kind, other.fault.kind) >= kFirstLater) return apply(other, true);
      }
    // A held drive command must end by itself when link or server fail.
    const bool cuts = f.kind == Kind::server_hang || f.kind == Kind::server_crash || f.kind == Kind::link_loss ||
                      f.kind == Kind::link_stall || f.kind == Kind::tab_freeze;
    if (on && cuts && contract::led_by_hand(loop_.mode())) {
      watch_.stop_is_wanted();
      if (f.end_s - f.start_s > 0.5) watch_.must_stop("the driver's commands stopped", 0.30, 0.8);
    }
  }

  // Commands waiting in a crashed server or core are lost: shared memory is created again.
  void forget_commands() {
    commands_.clear();
    drives_.clear();
  }

  // The effect of a lasting fault in each step.
  void go_on(const Fault& f) {
    sim::World& world = loop_.world();
    switch (f.kind) {
      case Kind::loose_plug:
        if (fault_dice_.chance(0.08)) world.unplug(f.node, !world.unplugged(f.node));
        break;
      case Kind::babble: {
        CanFrame frame{static_cast<std::uint32_t>(f.size * 2047.0), 8, 0, {}};
        if (frame.id == 0) frame.id = 1;
        for (int i = 0; i < 2 + static_cast<int>(f.size * 20.0); ++i) (void)world.foreign_send(frame);
        break;
      }
      case Kind::garbage_frames: {
        CanFrame frame{static_cast<std::uint32_t>(fault_dice_.below(2048)), static_cast<std::uint8_t>(fault_dice_.below(9)), 0, {}};
        for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(fault_dice_.below(256));
        (void)world.foreign_send(frame);
        break;
      }
      case Kind::duplicate:
        for (const CanFrame& frame : echoes_) (void)world.foreign_send(frame);
        echoes_.clear();
        break;
      case Kind::held: {
        // Arms that give way like a damper, up to 150 N and 40 N m: 60 kg and 8 kg m2 are slowed within two steps.
        const sim::PlatformMotion& at = world.plant().platform();
        const double most_n = 30.0 + 120.0 * f.size, most_n_m = 10.0 + 30.0 * f.size;
        world.plant().set_shove(std::clamp(-3000.0 * at.speed_m_s, -most_n, most_n),
                                std::clamp(-400.0 * at.yaw_rate_rad_s, -most_n_m, most_n_m));
        break;
      }
      case Kind::supply_rises: {
        // Half a volt a second, to 29.9 to 32.3 V: a charger that fails. From 30 V on the drives brake less.
        const double now_v = world.plant().battery_v(0) + world.plant().battery_v(1);
        world.plant().force_battery(std::min(now_v + 0.5 * core::kTick_s, 29.9 + 2.4 * f.size));
        break;
      }
      case Kind::core_late:
        if (fault_dice_.chance(0.1)) loop_.be_late(0.04 * fault_dice_.norm());
        break;
      case Kind::second_client:
        confuse();
        break;
      case Kind::take_over:
        if (fault_dice_.chance(0.05)) loop_.ask_as(kStranger, CommandKind::take_lease, 1);
        break;
      case Kind::replay:
        if (!commands_.empty() && fault_dice_.chance(0.1)) {
          Command old = commands_[static_cast<std::size_t>(fault_dice_.below(static_cast<int>(commands_.size())))];
          loop_.put(old);
        }
        if (!drives_.empty() && fault_dice_.chance(0.2))
          loop_.put_drive(drives_[static_cast<std::size_t>(fault_dice_.below(static_cast<int>(drives_.size())))]);
        break;
      case Kind::parameter_push:
        if (fault_dice_.chance(0.1)) push_parameters();
        break;
      default:
        moments_.go_on(f);
        break;
    }
  }

  // Another client, signed in but not driving.
  void confuse() {
    const TickRecord& record = loop_.record();
    if (fault_dice_.chance(0.3)) {
      contract::DriveCommand drive;
      drive.lease_epoch = record.lease_epoch;
      drive.client = kStranger;
      drive.sequence = 1'000'000'000 + static_cast<std::uint64_t>(loop_.ticks());
      drive.echo_time_ns = record.time_ns;
      drive.speed_norm = fault_dice_.between(-1.5, 1.5);
      drive.yaw_norm = fault_dice_.between(-1.5, 1.5);
      drive.held = static_cast<std::uint64_t>(fault_dice_.below(3));
      loop_.put_drive(drive);
    }
    if (!fault_dice_.chance(0.1)) return;
    constexpr std::array kTried{CommandKind::request_mode,  CommandKind::acknowledge,     CommandKind::take_lease,
                                CommandKind::release_lease, CommandKind::stage_parameter, CommandKind::set_pose,
                                CommandKind::set_neutral,   CommandKind::begin_service};
    const CommandKind kind = kTried[static_cast<std::size_t>(fault_dice_.below(static_cast<int>(kTried.size())))];
    // At standstill the lease may be taken, which "take_over" does.
    if (kind == CommandKind::take_lease && record.lease_holder == 0) return;
    if ((kind == CommandKind::set_neutral || kind == CommandKind::set_pose) && !moves(loop_.mode())) return;
    const std::uint32_t which = fault_dice_.below(5) == 1 ? 3 : 2;
    // The server asks for a hand-over only when the driver gives control away.
    const bool handed_over = kind == CommandKind::take_lease && which == contract::kHandOver;
    loop_.ask_as(kStranger, kind, handed_over ? 3 : which, fault_dice_.norm());
  }

  // Parameter sets of all kinds by the driver: valid, damaged, contradictory, of a role without permission.
  void push_parameters() {
    const int rows = 1 + fault_dice_.below(4);
    for (int i = 0; i < rows; ++i) {
      const auto index = static_cast<std::size_t>(fault_dice_.below(static_cast<int>(contract::kParamCount)));
      const auto& info = contract::kParams[index];
      double value = fault_dice_.between(info.min, info.max);
      if (fault_dice_.chance(0.08)) value = std::numeric_limits<double>::quiet_NaN();
      if (fault_dice_.chance(0.08)) value = info.max * 3.0 + 1.0;
      // Parameters of stops and driving keep their values, because the checker does not read parameters. They are still sent, by a role
      // without permission.
      const std::uint32_t id = fault_dice_.chance(0.03) ? 4095U : info.id;
      loop_.ask(CommandKind::stage_parameter, id, value, 0, 0, static_cast<std::uint32_t>(fault_dice_.chance(0.05) ? i + 1 : i));
    }
    const auto role = fault_dice_.chance(0.5) ? contract::Role::therapist : contract::Role::viewer;
    loop_.ask(CommandKind::commit_parameters, static_cast<std::uint32_t>(fault_dice_.chance(0.1) ? rows + 1 : rows), 0, 0, 0,
              static_cast<std::uint32_t>(role));
  }

  void delay_commands(double most_s) {
    if (most_s <= 0) return loop_.delay_commands({});
    const int steps = static_cast<int>(most_s * 100.0) + 1;
    loop_.delay_commands([this, steps] { return static_cast<std::uint32_t>(link_dice_.below(steps)); });
  }

  bus::BusFault frame_fault(std::size_t port, const CanFrame& frame) {
    if (options_.frame_loss > 0 && frame_dice_.chance(options_.frame_loss)) return {bus::BusFault::Kind::drop};
    std::uint32_t deaf = 0;
    for (const Planned& row : board_.rows) {
      if (!row.on) continue;
      const Fault& f = row.fault;
      const bool own = port == loop_.world().port_of(f.node);
      switch (f.kind) {
        case Kind::drop:  // of one node, or of all
          if ((own || f.size > 0.7) && frame_dice_.chance(0.6 * f.size)) return {bus::BusFault::Kind::drop};
          break;
        case Kind::corrupt:
          if ((own || f.size > 0.7) && frame_dice_.chance(0.6 * f.size)) return {bus::BusFault::Kind::corrupt};
          break;
        case Kind::delay:  // later ones of the same node overtake it
          if ((own || f.size > 0.7) && frame_dice_.chance(0.2))
            return {bus::BusFault::Kind::delay, static_cast<std::uint64_t>(f.size * 40e6)};
          break;
        case Kind::duplicate:
          if (own && echoes_.size() < 4) echoes_.push_back(frame);
          break;
        case Kind::bus_off:
          if (own) return {bus::BusFault::Kind::drop};
          deaf |= 1U << loop_.world().port_of(f.node);
          break;
        case Kind::tuned_twice:  // answers as late as the load plan of the bus allows
          // Offered again after that, and then sent.
          if ((frame.id & 0x780U) == contract::canopen::kSdoReplyBase && ((answers_late_ ^= 1U << port) >> port & 1U) != 0)
            return {bus::BusFault::Kind::delay, static_cast<std::uint64_t>((10.0 + 17.0 * f.size) * 1e6)};
          break;
        case Kind::mute_core:  // its commands still come
          if (frame.id == contract::canopen::kHeartbeatBase + contract::node_id(Node::core)) return {bus::BusFault::Kind::drop};
          break;
        default:
          break;
      }
    }
    bus::BusFault fault;
    fault.deaf_ports = deaf;
    return fault;
  }

  void fasten_straps() {
    sim::World& world = loop_.world();
    const auto cut = [&](sim::Side side) { return !world.plant().strap_holds(side); };
    if (board_.now(Kind::strap_cut) || (!cut(sim::Side::left) && !cut(sim::Side::right))) return;
    if (moves(loop_.mode()) || std::fabs(world.plant().platform().speed_m_s) > 0.01) return;
    for (const sim::Side side : {sim::Side::left, sim::Side::right})
      if (cut(side)) world.plant().cut_strap(side, false);
    world.patient().stand_in_the_middle();
  }

  void drive_faults() {
    fasten_straps();
    const double now_s = loop_.time_s();
    for (Planned& row : board_.rows) {
      if (!row.on && !row.done && now_s >= row.fault.start_s) {
        row.on = true;
        watch_.tell(std::string(info(row.fault.kind).name) + " begins, node " + std::to_string(contract::node_id(row.fault.node)));
        apply(row, true);
      } else if (row.on && now_s >= row.fault.end_s) {
        row.on = false;
        row.done = true;
        watch_.tell(std::string(info(row.fault.kind).name) + " ends");
        apply(row, false);
      }
      if (row.on) go_on(row.fault);
    }
    if (options_.spoof && board_.any_yet()) (void)loop_.world().foreign_send(*options_.spoof);
  }

  // Causes that acknowledgement cannot clear: a patient on the floor, a post against a bumper.
  [[nodiscard]] bool hopeless() {
    return board_.ever(Kind::trip) || board_.ever(Kind::collapse) || board_.ever(Kind::hang) || board_.ever(Kind::fall_aside) ||
           board_.ever(Kind::faint) || loop_.world().plant().bumpers() != 0;
  }

  void see(const core::TickInputs& inputs) {
    watch_.before_step({.tick = inputs.tick,
                        .time_ns = inputs.time_ns,
                        .frames = inputs.frames,
                        .bus_up = inputs.bus_up,
                        .commands = inputs.commands,
                        .drive_fresh = inputs.drive_fresh,
                        .drive = inputs.drive,
                        .server_heartbeat = inputs.server_heartbeat,
                        .server_life = inputs.server_life,
                        .wake_lateness_s = static_cast<double>(inputs.wake_lateness_s)});
    if (storage_ != nullptr) storage_->before_step(loop_.core(), inputs);
    for (const Command& command : inputs.commands) {
      // STOP and ending motion are taken in any order, so a replayed one stops again: that is no fault.
      const bool only_stops = command.kind == CommandKind::stop ||
                              (command.kind == CommandKind::request_mode && command.a == static_cast<std::uint32_t>(Mode::standby));
      if (only_stops) continue;
      if (commands_.size() == kRemembered) commands_.erase(commands_.begin());
      commands_.push_back(command);
    }
    if (!inputs.drive_fresh || inputs.drive.client == kStranger) return;
    if (drives_.size() == kRemembered) drives_.erase(drives_.begin());
    drives_.push_back(inputs.drive);
  }

  // ---- the therapist, ten times a second

  void ask(CommandKind kind, std::uint32_t a = 0, double v0 = 0.0) { loop_.ask(kind, a, v0); }
  void ask_mode(Mode mode) { ask(CommandKind::request_mode, static_cast<std::uint32_t>(mode)); }
  [[nodiscard]] bool console_works() const {
    return !board_.now(Kind::server_hang) && !board_.now(Kind::server_crash) && !board_.now(Kind::tab_freeze) &&
           !board_.now(Kind::link_loss) && !board_.now(Kind::link_stall);
  }

  void therapist() {
    if (!loop_.core_runs() || !console_works()) return;
    const double now_s = loop_.time_s();
    const Mode mode = loop_.mode();
    if (mode != last_mode_ && (mode == Mode::protective_stop || moves(last_mode_))) next_s_ = std::max(next_s_, now_s + pause_s(0.8, 2.5));
    last_mode_ = mode;
    if (options_.only_walk) return start_once(now_s);
    if (now_s >= rescue_s_) return end_for_a_fall(mode);
    if (mode == Mode::standby) return on_standby(now_s);
    if (mode == Mode::user) return while_leading(now_s);
    if (mode == Mode::remote) return while_driving(now_s);
    if (mode == Mode::guided) return while_guiding(now_s);
    if (mode == Mode::protective_stop || mode == Mode::fault || mode == Mode::emergency_stop) return while_stopped(now_s);
    if (mode != Mode::init) ask_mode(Mode::standby);
  }
  [[nodiscard]] bool without_lease() const { return loop_.record().lease_holder != 1; }
  // A therapist reacts with a delay; while recovery is checked only the hoist may take time.
  [[nodiscard]] double pause_s(double least_s, double most_s) {
    const double thought_s = therapist_dice_.between(least_s, most_s);
    return mending_ ? 0.3 : thought_s;
  }
  void wait(double now_s, double least_s, double most_s) { next_s_ = now_s + pause_s(least_s, most_s); }
  void take_lease() { ask(CommandKind::take_lease, loop_.record().lease_holder == 0 ? 0 : 1); }

  // A walk that begins before anything may break and is then left alone.
  void start_once(double now_s) {
    if (loop_.mode() != Mode::standby || started_ || now_s < next_s_) return;
    next_s_ = now_s + 0.3;
    if (without_lease()) return take_lease();
    if (loop_.record().blocked_bits != 0) return;
    started_ = true;
    ask_mode(Mode::user);
  }
  void on_standby(double now_s) {
    loop_.fall_silent();
    if (mending_ || now_s < next_s_) return;
    next_s_ = now_s + 0.5;
    if (without_lease()) return take_lease();
    if (therapist_dice_.chance(0.1)) return tune();
    if (loop_.record().blocked_bits != 0) return press_start_all_the_same();
    const bool leads = therapist_dice_.chance(0.7);
    wait(now_s, 4.0, 25.0);
    if (leads) return ask_mode(Mode::user);
    if (therapist_dice_.chance(0.4)) return begin_exercise(now_s);
    loop_.let_go();  // the driver takes the stick again
    ask_mode(Mode::remote);
  }
  // What the console says forbids a start; someone presses all the same. The hoist has to refuse, so a session goes on as without.
  void press_start_all_the_same() {
    if (defiance_dice_.chance(0.5)) ask_mode(defiance_dice_.chance(0.5) ? Mode::user : Mode::remote);
  }
  void begin_exercise(double now_s) {
    constexpr std::array kShapes{contract::GuidedShape::straight, contract::GuidedShape::square, contract::GuidedShape::circle,
                                 contract::GuidedShape::eight};
    const contract::GuidedShape shape = kShapes[static_cast<std::size_t>(therapist_dice_.below(static_cast<int>(kShapes.size())))];
    const double size_m = therapist_dice_.between(0.8, 3.0);
    const bool rounded = shape == contract::GuidedShape::eight;
    Command command;
    contract::put_guided(command,
                         {shape, therapist_dice_.chance(0.5), size_m, rounded ? 0.5 * size_m : 0.0, therapist_dice_.between(0.1, 0.5), 1});
    loop_.ask(command.kind, command.a, command.v0, command.v1, command.v2, command.b);
    stick_s_ = now_s + 0.5;
  }
  [[nodiscard]] bool ended_by_hand(double now_s) {
    if (!mending_ && now_s < next_s_) return false;
    loop_.let_go();
    ask_mode(Mode::standby);
    watch_.stop_is_wanted();
    wait(now_s, 1.0, 4.0);
    return true;
  }
  // Who sees the patient go down ends the motion, as fast as a hand is: the hoist brakes while the body falls.
  void end_for_a_fall(Mode mode) {
    rescue_s_ = kNever_s;
    if (!moves(mode)) return;
    loop_.let_go();
    ask_mode(Mode::standby);
    watch_.stop_is_wanted();
  }
  // The hand on the button: mostly held, sometimes released, sometimes lost without a release.
  void while_guiding(double now_s) {
    if (ended_by_hand(now_s) || now_s < stick_s_) return;
    stick_s_ = now_s + therapist_dice_.between(0.5, 4.0);
    if (therapist_dice_.chance(0.15)) {
      loop_.let_go();
    } else if (therapist_dice_.chance(0.05)) {
      loop_.fall_silent();
      watch_.stop_is_wanted();
    } else {
      loop_.hold_stick(0.0, 0.0);
    }
  }
  void while_leading(double now_s) {
    if (now_s < next_s_ && !mending_) return;
    if (!mending_ && therapist_dice_.chance(0.3)) {
      tune();
      wait(now_s, 1.0, 10.0);
      return;
    }
    if (therapist_dice_.chance(0.2) || without_lease()) {
      watch_.tell("STOP");
      watch_.stop_is_wanted();
      watch_.must_stop("STOP", 0.01, 0.5);
      wait(now_s, 1.0, 4.0);
      return ask(CommandKind::stop);
    }
    ask_mode(Mode::standby);
    watch_.stop_is_wanted();
    wait(now_s, 1.0, 4.0);
  }
  void while_driving(double now_s) {
    if (ended_by_hand(now_s) || now_s < stick_s_) return;
    stick_s_ = now_s + therapist_dice_.between(0.5, 2.5);
    if (therapist_dice_.chance(0.25)) {
      loop_.let_go();
      if (echo_dice_.chance(0.1)) echo_s_ = now_s + 0.08;
    } else if (therapist_dice_.chance(0.1)) {
      loop_.fall_silent();
      watch_.stop_is_wanted();  // while pushed: that the hoist stops is no false stop
      stick_s_ = now_s + therapist_dice_.between(0.05, 1.5);
    } else {
      // A careful hand: no jumps from full ahead to full astern, which the fall guard rightly stops.
      stick_speed_norm_ = std::clamp(stick_speed_norm_ + therapist_dice_.between(-0.35, 0.35), -0.3, 1.0);
      loop_.hold_stick(stick_speed_norm_, therapist_dice_.between(-0.7, 0.7));
    }
  }
  // The last command of a hand that has let go comes once more, as over a link that sends again what was not answered in time.
  void echo_the_hand() {
    if (loop_.time_s() < echo_s_) return;
    echo_s_ = kNever_s;
    const auto last = std::find_if(drives_.rbegin(), drives_.rend(), [](const contract::DriveCommand& drive) { return drive.held == 1; });
    if (last != drives_.rend()) loop_.put_drive(*last);
  }
  void while_stopped(double now_s) {
    loop_.fall_silent();
    if (now_s < next_s_) return;
    wait(now_s, 0.8, 2.5);
    press_start_all_the_same();
    if (without_lease()) return take_lease();
    // Out of service it takes an engineer.
    loop_.ask(CommandKind::acknowledge, 0, 0, 0, 0,
              static_cast<std::uint32_t>(loop_.mode() == Mode::protective_stop ? contract::Role::therapist : contract::Role::engineer));
  }

  // One changed parameter, sometimes impossible.
  void tune() {
    const auto index = static_cast<std::size_t>(therapist_dice_.below(static_cast<int>(contract::kParamCount)));
    const auto& info = contract::kParams[index];
    const double value = therapist_dice_.chance(0.3) ? info.max * 3.0 + 1.0 : therapist_dice_.between(info.min, info.max);
    if (info.edit != contract::EditRule::live || info.role != contract::Role::therapist) return;
    ask(CommandKind::stage_parameter, info.id, value);
    loop_.ask(CommandKind::commit_parameters, 1, 0, 0, 0, static_cast<std::uint32_t>(contract::Role::therapist));
  }

  void step() {
    drive_faults();
    if (++ticks_ % 10 == 0) therapist();
    echo_the_hand();
    const bool ran = loop_.core_runs();
    loop_.step();
    if (storage_ != nullptr) storage_->tick(clock_ns());
    report_.distance_m += std::fabs(loop_.world().plant().platform().speed_m_s) * 0.01;
    const Told told{loop_.record(), loop_.events(), loop_.core().params, loop_.core().parameter_version};
    watch_.after_step(ran ? &told : nullptr);
    if (ticks_ % 100 == 0) report_.hashes.push_back(loop_.digest());
  }

  SessionOptions options_;
  std::vector<Fault> faults_;
  Board board_;
  Dice therapist_dice_, frame_dice_, fault_dice_, link_dice_, serial_dice_, defiance_dice_, rescue_dice_, echo_dice_;
  tests::ClosedLoop loop_;
  Moments moments_;
  std::unique_ptr<Storage> storage_;
  SessionReport report_;
  Watch watch_;
  std::vector<Command> commands_;               // latest requests
  std::vector<contract::DriveCommand> drives_;  // and driven
  std::vector<CanFrame> echoes_;
  std::uint64_t ticks_{};
  std::uint32_t answers_late_{};  // ports whose answer waits
  std::uint32_t strange_serial_{0x20000000U};
  double next_s_{}, stick_s_{}, rescue_s_{kNever_s}, echo_s_{kNever_s};
  double stick_speed_norm_{};
  Mode last_mode_{Mode::init};
  bool mending_{false}, started_{false};
};

}  // namespace

std::string patient_of(const SessionOptions& options) {
  if (options.patient) return *options.patient;
  Dice dice(options.seed, kPatientStream);
  if (options.faults || !dice.chance(kUnevenShare)) return std::string(kEvenPatient);
  return std::string(sim::kPatientFamily[static_cast<std::size_t>(dice.below(static_cast<int>(sim::kPatientFamily.size())))].name);
}

SessionReport run_session(const SessionOptions& options) { return Session(options).run(); }

SessionReport run_unmoved(const SessionOptions& options) {
  SessionOptions with = options, without = options;
  with.only_walk = without.only_walk = true;
  with.outside_only = true;
  with.patient = without.patient = patient_of(options);
  without.faults = std::vector<Fault>{};
  SessionReport report = run_session(with);
  const SessionReport plain = run_session(without);
  if (report.motion != plain.motion) {
    report.broken.emplace_back("I12: a patient who leads felt what concerns only server, network, disk, clock or other clients");
    if (report.broken_s == 0) report.broken_s = options.length_s;
  }
  return report;
}

}  // namespace hoist::chaos
