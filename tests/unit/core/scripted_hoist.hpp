// A scripted hoist: answers the core's frames as nodes do, with values set by the test. Its only physics are wheels with a lag, and it has no
// firmware: any error found here is the core's.
#pragma once
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/commands.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/guided_path.hpp"
#include "control/contract/param_set.hpp"
#include "control/core/tick.hpp"

namespace hoist::core::test {

using contract::CommandKind;
using contract::EventKind;
using contract::Fault;
using contract::Mode;
using contract::Refusal;
using contract::refusal_bit;

inline constexpr double kDeg = std::numbers::pi / 180.0;

// 1018h:3 of the table: what a node's program of today says.
inline constexpr auto kRevision = static_cast<std::uint32_t>(contract::find_object(contract::NodeKind::tilt, 0x1018, 3)->default_value);

struct FakeNode {
  bool silent = false;  // unplugged
  contract::canopen::NmtState nmt = contract::canopen::NmtState::pre_operational;
  bool booted = false;
  std::vector<std::pair<std::uint32_t, float>> written;        // index << 8 | sub, value
  std::vector<std::pair<std::uint32_t, std::uint32_t>> words;  // the same, in the order of writing; what the node tells back
  std::uint32_t sdo_requests = 0;
  std::uint32_t revision = kRevision;  // of its program
  std::uint32_t serial = 0;            // 0: it has none
  std::uint32_t garble = 0;            // bits that the line turns over in its next answer about 1018h:garbled_sub
  std::uint8_t garbled_sub = 2;
  bool sdo_deaf = false;
  bool sdo_aborts = false;
  std::uint32_t product_bits = 0;  // besides those of a node at work
};

struct FakeTilt : FakeNode {
  double alpha_deg = 0, beta_deg = 0;  // where the strut goes, no faster than slew_deg per step
  double alpha_now_deg = 0, beta_now_deg = 0;
  double slew_deg = 1;
  double yaw_rate_deg_s = 0;    // of the chassis' gyroscope, beyond what the wheels turn
  double pitch_rate_deg_s = 0;  // as the gyroscope says, sent by the chassis
  std::uint8_t status = 3;      // valid, converged
  std::uint8_t counter = 0;
  bool frozen = false;
  bool rates_silent = false;  // of the chassis: sends its angles, but no rates
  bool dither = true;
};

struct FakeDrive : FakeNode {
  std::uint16_t status = 0x40;
  bool fault = false;
  bool ignores_reset = false;
  bool deaf = false;        // reports, but does not follow
  double wheel_m_s = 0;     // what the wheel does
  double forced_m_s = NAN;  // when set, the wheel does this for any command
  double counts = 0;
  double supply_v = 25.6;
  double current_a = 0.6;
  double target_m_s = 0;
  std::uint16_t last_control = 0;
};

struct FakeIo : FakeNode {
  std::uint8_t bumpers = 0;
  std::uint8_t switches = 0;
  double battery_a_v = 12.8, battery_b_v = 12.8;
  bool battery_silent = false;  // the bumpers still come
};

class ScriptedHoist {
 public:
  ScriptedHoist() : ScriptedHoist(contract::Params{}) {}
  explicit ScriptedHoist(const contract::Params& params) : state(params) {}

  CoreState state;
  TickOutputs out;
  FakeTilt tilt_left, tilt_right, tilt_base;
  FakeDrive drive_left, drive_right;
  FakeIo io;
  bool bus_up = true;
  bool floor_grips = true;  // the chassis turns with the wheels; false: only as tilt_base says
  bool server_up = true;
  /// Sway of a walking patient: by so much to either side, once in two seconds, while the wheels turn.
  double sway_deg = 0.4;
  bool real = false;  // its nodes do not say that they are simulated
  std::uint64_t heartbeat = 1;
  std::uint64_t tick_number = 0;
  std::uint64_t time_ns = 1'000'000'000;
  float lateness_s = 0;
  std::vector<contract::CanFrame> extra;    // delivered in the next step as they are
  std::vector<contract::Command> commands;  // delivered in the next step
  std::vector<contract::Event> events;      // all that came out so far
  std::vector<contract::CanFrame> sent;     // by the core, in the last step
  contract::ParamSetSeal seal;              // over what was staged, as an honest client works it out
  std::uint64_t sequence = 0, drive_sequence = 0;
  std::uint32_t next_request = 1;
  bool drive_fresh = false;
  contract::DriveCommand drive_command;
  double worst_deceleration_m_s2 = 0;  // commanded, over all steps
  bool ever_not_finite = false;

  void step(int n = 1) {
    for (int i = 0; i < n; ++i) one_step();
  }

  /// Steps until the mode is reached; false after `limit` steps.
  bool reach(contract::Mode mode, int limit = 500) {
    for (int i = 0; i < limit && state.mode != mode; ++i) step();
    return state.mode == mode;
  }

  // ----- what clients do -----
  std::uint32_t send(contract::CommandKind kind, std::uint32_t client = 7, std::uint32_t a = 0, std::uint32_t b = 0, double v0 = 0,
                     double v1 = 0, double v2 = 0) {
    contract::Command c;
    c.sequence = ++sequence;
    c.kind = kind;
    c.request_id = next_request++;
    c.client = client;
    c.lease_epoch = state.lease.epoch;
    c.a = a;
    c.b = b;
    c.v0 = v0;
    c.v1 = v1;
    c.v2 = v2;
    if (kind == contract::CommandKind::stage_parameter) {
      if (b == 0) seal = {};
      seal.add(a, v0);
    }
    if (kind == contract::CommandKind::commit_parameters) c.bits = seal.value();
    if (kind == contract::CommandKind::acknowledge) c.bits = a;  // the faults that were seen
    commands.push_back(c);
    return c.request_id;
  }
  /// Sends and steps once; the refusal bits of the answer, 0 when it was done, ~0 when there was no answer.
  std::uint32_t ask(contract::CommandKind kind, std::uint32_t client = 7, std::uint32_t a = 0, std::uint32_t b = 0, double v0 = 0,
                    double v1 = 0, double v2 = 0) {
    const std::uint32_t id = send(kind, client, a, b, v0, v1, v2);
    step();
    return answer(id);
  }
  [[nodiscard]] std::uint32_t answer(std::uint32_t request_id) const {
    for (const contract::Event& e : events) {
      if (e.request_id != request_id) continue;
      if (e.kind == contract::EventKind::command_done) return 0;
      if (e.kind == contract::EventKind::command_refused) return e.bits;
    }
    return ~0U;
  }
  std::uint32_t ask_guided(const contract::GuidedPath& path, std::uint32_t client = 7) {
    contract::Command c;
    contract::put_guided(c, path);
    return ask(c.kind, client, c.a, c.b, c.v0, c.v1, c.v2);
  }
  /// GUIDED is requested with an exercise: two metres straight on.
  std::uint32_t ask_mode(contract::Mode mode, std::uint32_t client = 7) {
    if (mode == contract::Mode::guided) return ask_guided({contract::GuidedShape::straight, false, 2.0, 0, 0.2, 1}, client);
    return ask(contract::CommandKind::request_mode, client, static_cast<std::uint32_t>(mode));
  }
  /// The therapist's hand: a command with the newest telemetry stamp.
  void hold(double speed_norm, double yaw_norm = 0, bool held = true) {
    drive_command = {state.lease.epoch, state.lease.holder, ++drive_sequence, time_ns, speed_norm, yaw_norm, held ? 1U : 0U};
    drive_fresh = true;
  }
  /// Holds the stick for n steps, a command every fourth step (25 Hz).
  void drive_for(int n, double speed_norm, double yaw_norm = 0) {
    for (int i = 0; i < n; ++i) {
      if (i % 4 == 0) hold(speed_norm, yaw_norm);
      step();
    }
  }

  /// Calls this for each node.
  template <typename F>
  void each(F&& f) {
    using contract::Node;
    f(Node::drive_left, static_cast<FakeNode&>(drive_left));
    f(Node::drive_right, static_cast<FakeNode&>(drive_right));
    f(Node::io, static_cast<FakeNode&>(io));
    f(Node::tilt_left, static_cast<FakeNode&>(tilt_left));
    f(Node::tilt_right, static_cast<FakeNode&>(tilt_right));
    f(Node::tilt_base, static_cast<FakeNode&>(tilt_base));
  }

  bool to_standby() { return reach(contract::Mode::standby); }
  /// Standby with client 7 as the driver and the patient upright for long enough.
  bool ready() {
    if (!to_standby()) return false;
    step(120);
    return ask(contract::CommandKind::take_lease) == 0;
  }
  bool start(contract::Mode mode) { return ready() && ask_mode(mode) == 0 && run_until_powered(); }
  bool run_until_powered() {
    for (int i = 0; i < 60 && !state.in_mode.powered; ++i) step();
    return state.in_mode.powered;
  }
  void lean(double alpha_deg, double twist_deg = 0) {
    tilt_left.alpha_deg = alpha_deg - twist_deg / 2;
    tilt_right.alpha_deg = alpha_deg + twist_deg / 2;
  }
  /// A lean that grows slowly enough not to be a fall, then walks n steps.
  void lean_gently(double alpha_deg, int n) {
    const double from = tilt_left.alpha_deg;
    for (int i = 1; i <= 100; ++i) {
      lean(from + (alpha_deg - from) * i / 100.0);
      step();
    }
    step(n);
  }

  [[nodiscard]] bool has_fault(contract::Fault fault) const { return (state.latched & contract::fault_bit(fault)) != 0; }
  [[nodiscard]] int count(contract::EventKind kind) const {
    int n = 0;
    for (const auto& e : events) n += e.kind == kind ? 1 : 0;
    return n;
  }
  [[nodiscard]] double command_m_s() const { return static_cast<double>(out.record.speed_command_m_s); }

  /// The nodes' frames of this step, for tests that read or change them.
  std::vector<contract::CanFrame> collect() {
    std::vector<contract::CanFrame> frames;
    frames.swap(replies_);
    periodic(frames);
    return frames;
  }

 private:
  void one_step() {
    using contract::Node;
    ++tick_number;
    time_ns += 10'000'000;
    if (server_up) ++heartbeat;
    std::vector<contract::CanFrame> frames = collect();
    frames.insert(frames.end(), extra.begin(), extra.end());
    extra.clear();
    TickInputs in;
    in.tick = tick_number;
    in.time_ns = time_ns;
    in.frames = frames;
    in.bus_up = bus_up;
    if (!bus_up) in.frames = {};
    in.commands = commands;
    in.drive_fresh = drive_fresh;
    in.drive = drive_command;
    in.server_heartbeat = heartbeat;
    in.wake_lateness_s = lateness_s;
    const double before = std::abs(state.limiter.speed_m_s());
    tick(state, in, kTick_s, out);
    const double deceleration = (before - std::abs(state.limiter.speed_m_s())) / kTick_s;
    if (deceleration > worst_deceleration_m_s2) worst_deceleration_m_s2 = deceleration;
    commands.clear();
    drive_fresh = false;
    lateness_s = 0;
    for (const auto& e : out.events) events.push_back(e);
    sent.assign(out.frames.begin(), out.frames.end());
    for (std::size_t s = 0; s < contract::kSignalCount; ++s)
      if (!std::isfinite(contract::signal_value(out.record, s))) ever_not_finite = true;
    if (bus_up)
      for (const auto& f : sent) answer_frame(f);
    move(drive_left);
    move(drive_right);
  }

  void periodic(std::vector<contract::CanFrame>& frames) {
    namespace canopen = contract::canopen;
    using contract::Node;
    using contract::Pdo;
    each([&](Node node, FakeNode& n) {
      if (n.silent) return;
      if (!n.booted) {
        n.booted = true;
        n.nmt = canopen::NmtState::pre_operational;
        frames.push_back(canopen::heartbeat(contract::node_id(node), canopen::NmtState::boot_up));
      } else if (tick_number % 10 == static_cast<std::uint64_t>(node)) {
        frames.push_back(canopen::heartbeat(contract::node_id(node), n.nmt));
      }
    });
    const auto runs = [](const FakeNode& n) { return !n.silent && n.nmt == canopen::NmtState::operational; };
    const bool walks = std::abs(drive_left.wheel_m_s + drive_right.wheel_m_s) > 0.04;
    const double swayed_deg = walks ? sway_deg * std::sin(std::numbers::pi * static_cast<double>(tick_number) * kTick_s) : 0.0;
    const auto tilt = [&](Node node, FakeTilt& t) {
      if (!runs(t)) return;
      if (!t.frozen) ++t.counter;
      contract::CanFrame f{contract::pdo_cob_id(Pdo::tilt_tx1, node), 6, 0, {}};
      // The last digit of a real filter never rests.
      t.alpha_now_deg += std::clamp(t.alpha_deg - t.alpha_now_deg, -t.slew_deg, t.slew_deg);
      t.beta_now_deg += std::clamp(t.beta_deg - t.beta_now_deg, -t.slew_deg, t.slew_deg);
      const double noise_deg = t.dither && !t.frozen ? 0.001 * static_cast<double>(t.counter % 3) : 0.0;
      const double aside_deg = node != Node::tilt_base && t.dither && !t.frozen ? swayed_deg : 0.0;
      contract::write_slot(f, contract::pdo_slot(Pdo::tilt_tx1, 0x6010), std::lround((t.alpha_now_deg + noise_deg) * 1000));
      contract::write_slot(f, contract::pdo_slot(Pdo::tilt_tx1, 0x6020), std::lround((t.beta_now_deg + aside_deg) * 1000));
      contract::write_slot(f, contract::pdo_slot(Pdo::tilt_tx1, 0x2120), t.status);
      contract::write_slot(f, contract::pdo_slot(Pdo::tilt_tx1, 0x2121), t.counter);
      frames.push_back(f);
    };
    tilt(Node::tilt_left, tilt_left);
    tilt(Node::tilt_right, tilt_right);
    tilt(Node::tilt_base, tilt_base);
    if (runs(tilt_base) && !tilt_base.rates_silent) {
      contract::CanFrame f{contract::pdo_cob_id(Pdo::tilt_tx2, Node::tilt_base), 6, 0, {}};
      constexpr contract::PdoSlot kYaw = contract::pdo_slot(Pdo::tilt_tx2, 0x2110, 1);
      // The floor grips: the chassis turns as the wheels say.
      const double turn_deg_s = tilt_base.yaw_rate_deg_s +
                                (!floor_grips ? 0.0 : (drive_right.wheel_m_s - drive_left.wheel_m_s) / state.params.track_width_m / kDeg);
      contract::write_slot(f, kYaw, std::lround(turn_deg_s / kYaw.scale));
      constexpr contract::PdoSlot kPitch = contract::pdo_slot(Pdo::tilt_tx2, 0x2110, 2);
      contract::write_slot(f, kPitch, std::lround(tilt_base.pitch_rate_deg_s / kPitch.scale));
      // No gyroscope is quiet in its last digit.
      if (tilt_base.dither && !tilt_base.frozen)
        contract::write_slot(f, kYaw, std::lround(turn_deg_s / kYaw.scale) + static_cast<std::int64_t>(tick_number % 3));
      frames.push_back(f);
    }
    const auto drive = [&](Node node, FakeDrive& d) {
      if (!runs(d)) return;
      contract::CanFrame f{contract::pdo_cob_id(Pdo::drive_tx1, node), 8, 0, {}};
      contract::write_slot(f, contract::pdo_slot(Pdo::drive_tx1, 0x6041), d.status);
      contract::write_slot(f, contract::pdo_slot(Pdo::drive_tx1, 0x6064), static_cast<std::int32_t>(static_cast<std::int64_t>(d.counts)));
      contract::write_slot(f, contract::pdo_slot(Pdo::drive_tx1, 0x6078), std::lround(d.current_a / 6.0 * 1000.0));
      frames.push_back(f);
      if (tick_number % 5 == 0) {
        contract::CanFrame g{contract::pdo_cob_id(Pdo::drive_tx2, node), 8, 0, {}};
        contract::write_slot(g, contract::pdo_slot(Pdo::drive_tx2, 0x2211), std::lround(d.supply_v * 100));
        frames.push_back(g);
      }
    };
    drive(Node::drive_left, drive_left);
    drive(Node::drive_right, drive_right);
    if (runs(io)) {
      if (tick_number % (contract::pdo_info(Pdo::io_tx1).period_ms / 10U) == 0 || io.bumpers != last_bumpers_) {
        contract::CanFrame f{contract::pdo_cob_id(Pdo::io_tx1, Node::io), 2, 0, {}};
        f.data[0] = io.bumpers;
        f.data[1] = io.switches;
        frames.push_back(f);
        last_bumpers_ = io.bumpers;
      }
      if (!io.battery_silent && tick_number % (contract::pdo_info(Pdo::io_tx2).period_ms / 10U) == 0) {
        contract::CanFrame g{contract::pdo_cob_id(Pdo::io_tx2, Node::io), 8, 0, {}};
        contract::write_slot(g, contract::pdo_slot(Pdo::io_tx2, 0x6401, 1), std::lround(io.battery_a_v * 100));
        contract::write_slot(g, contract::pdo_slot(Pdo::io_tx2, 0x6401, 2), std::lround(io.battery_b_v * 100));
        frames.push_back(g);
      }
    }
  }

  void answer_frame(const contract::CanFrame& f) {
    namespace canopen = contract::canopen;
    using contract::Node;
    each([&](Node node, FakeNode& n) {
      if (n.silent) return;
      const std::uint8_t id = contract::node_id(node);
      if (f.id == canopen::kNmt && (f.data[1] == id || f.data[1] == 0)) {
        if (f.data[0] == 1) n.nmt = canopen::NmtState::operational;
        if (f.data[0] == 2) n.nmt = canopen::NmtState::stopped;
        if (f.data[0] == 128) n.nmt = canopen::NmtState::pre_operational;
      }
      if (f.id == canopen::kSdoRequestBase + id) {
        ++n.sdo_requests;
        if (n.sdo_deaf) return;
        const auto index = static_cast<std::uint16_t>(contract::read_le(&f.data[1], 2));
        const std::uint32_t reply = canopen::kSdoReplyBase + id;
        if (n.sdo_aborts) {
          replies_.push_back(canopen::sdo(reply, canopen::kSdoAbort, index, f.data[3], 0x08000022));
        } else if (f.data[0] == canopen::kSdoUploadRequest && index != 0x1018) {
          const contract::ObjectInfo* object =
              contract::find_object(contract::kNodes[static_cast<std::size_t>(node)].kind, index, f.data[3]);
          if (object == nullptr) {  // asked for by a service frame
            replies_.push_back(canopen::sdo(reply, canopen::kSdoAbort, index, f.data[3], 0x06020000));
            return;
          }
          // Unwritten objects have a value that is none of the core's.
          const std::uint32_t key = (static_cast<std::uint32_t>(index) << 8) | f.data[3];
          std::uint32_t word = 0x55;
          for (const auto& [name, value] : n.words) word = name == key ? value : word;
          replies_.push_back(
              canopen::sdo(reply, canopen::sdo_upload_reply_command(contract::object_bytes(object->type)), index, f.data[3], word));
        } else if (f.data[0] == canopen::kSdoUploadRequest) {
          const std::uint32_t product = (real ? 0U : canopen::kSimulatedProduct) | n.product_bits | id;
          replies_.push_back(canopen::sdo(reply, canopen::sdo_upload_reply_command(4), index, f.data[3],
                                          (f.data[3] == 4   ? n.serial
                                           : f.data[3] == 3 ? n.revision
                                                            : product) ^
                                              (f.data[3] == n.garbled_sub ? n.garble : 0U)));
          if (f.data[3] == n.garbled_sub) n.garble = 0;
        } else {
          n.written.emplace_back((static_cast<std::uint32_t>(index) << 8) | f.data[3],
                                 std::bit_cast<float>(contract::read_le(&f.data[4], 4)));
          n.words.emplace_back(n.written.back().first, contract::read_le(&f.data[4], 4));
          replies_.push_back(canopen::sdo(reply, canopen::kSdoDownloadReply, index, f.data[3], 0));
        }
      }
    });
    const auto command = [&](Node node, FakeDrive& d) {
      if (d.silent || f.id != contract::pdo_cob_id(contract::Pdo::drive_rx1, node)) return;
      const auto control = static_cast<std::uint16_t>(contract::read_slot(f, contract::pdo_slot(contract::Pdo::drive_rx1, 0x6040)));
      const auto target = contract::read_slot(f, contract::pdo_slot(contract::Pdo::drive_rx1, 0x60FF));
      d.target_m_s = static_cast<double>(target) * 0.001 / 30.0 * 0.1;
      if (d.fault) {
        d.status = 0x08;
        if ((control & 0x80) != 0 && (d.last_control & 0x80) == 0 && !d.ignores_reset) {
          d.fault = false;
          d.status = 0x40;
        }
      } else if (d.status == 0x08) {
        d.status = 0x40;
      } else if (control == 0x06) {
        d.status = 0x21;
      } else if (control == 0x07 && d.status == 0x21) {
        d.status = 0x23;
      } else if (control == 0x0F && (d.status == 0x23 || d.status == 0x27)) {
        d.status = 0x27;
      } else if (control == 0x00) {
        d.status = 0x40;
      }
      d.last_control = control;
    };
    command(Node::drive_left, drive_left);
    command(Node::drive_right, drive_right);
  }

  static void move(FakeDrive& d) {
    const bool runs = d.status == 0x27 && !d.fault && !d.silent;
    const double target = runs && !d.deaf ? d.target_m_s : 0.0;
    d.wheel_m_s += (target - d.wheel_m_s) * 0.25;
    if (std::abs(d.wheel_m_s) < 1e-4 && target == 0.0) d.wheel_m_s = 0;
    if (!std::isnan(d.forced_m_s)) d.wheel_m_s = d.forced_m_s;
    d.counts += d.wheel_m_s * kTick_s / (2 * std::numbers::pi * 0.1) * 60000.0;
  }

  std::vector<contract::CanFrame> replies_;
  std::uint8_t last_bumpers_ = 0;
};

/// Roles that acknowledge.
inline constexpr std::uint32_t kTherapist = 1, kEngineer = 2;
/// By the holder of the lease. Refusal bits.
inline std::uint32_t acknowledge_as(ScriptedHoist& hoist, std::uint32_t role) { return hoist.ask(CommandKind::acknowledge, 7, 0, role); }

}  // namespace hoist::core::test
