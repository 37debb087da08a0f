// The control step between a hostile bus and a hostile server, from its start and in motion: wheel commands never exceed the limits, and are zero
// in modes that do not move.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/param_set.hpp"
#include "control/core/output/wheel_mixing.hpp"
#include "control/core/tick.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::fuzz {

std::uint32_t core_modes_driven = 0;

namespace {

using contract::CanFrame;
using contract::Command;
using contract::CommandKind;
using contract::Mode;
using core::test::ScriptedHoist;

constexpr std::size_t kStepsMax = 400;
// Of an input's first byte, beside the start: the nodes answer nothing, only the input's frames come.
constexpr std::uint8_t kSilentNodes = 0x80;

ScriptedHoist prepared(Mode mode) {
  ScriptedHoist hoist;
  if (mode == Mode::init) return hoist;
  must(mode == Mode::standby ? hoist.ready() : hoist.start(mode), "the scripted hoist starts");
  if (mode == Mode::user) hoist.lean_gently(6, 100);
  if (mode == Mode::remote || mode == Mode::guided) hoist.drive_for(60, 0.8, 0.3);
  must(hoist.state.mode == mode, "the scripted hoist is in its mode");
  hoist.events.clear();
  return hoist;
}

constexpr std::array kStarts{Mode::init, Mode::standby, Mode::user, Mode::remote, Mode::guided};
ScriptedHoist started(std::uint8_t first) {
  static const std::array<ScriptedHoist, kStarts.size()> hoists{prepared(kStarts[0]), prepared(kStarts[1]), prepared(kStarts[2]),
                                                                prepared(kStarts[3]), prepared(kStarts[4])};
  return hoists[(first & ~kSilentNodes) % hoists.size()];
}

struct Bench {
  explicit Bench(std::uint8_t first) : hoist(started(first)) {
    if ((first & kSilentNodes) != 0) hoist.each([](contract::Node, core::test::FakeNode& node) { node.silent = true; });
  }
  ScriptedHoist hoist;

  void step() {
    hoist.step();
    hoist.events.clear();
    check();
  }

  void check() const {
    for (const CanFrame& frame : hoist.sent)
      must(frame.dlc <= 8 && frame.id <= 0x7FF && frame.flags == 0, "only frames that can exist are sent");
    const contract::Params& params = hoist.state.params;
    const Wheel left = wheel(contract::Node::drive_left, hoist.state.derived.left_motor_per_m);
    const Wheel right = wheel(contract::Node::drive_right, hoist.state.derived.right_motor_per_m);
    const auto mode = static_cast<Mode>(hoist.out.record.mode);
    const bool turns = left.m_s != 0 || right.m_s != 0;
    if (turns) core_modes_driven |= 1U << static_cast<unsigned>(mode);
    must(!turns || contract::kModes[hoist.out.record.mode].moving || mode == Mode::protective_stop,
         "nothing moves in a mode that does not move");
    const double turn_m_s = params.yaw_rate_rad_s_max * params.track_width_m / 2;
    must(std::max(std::abs(left.m_s), std::abs(right.m_s)) <= params.speed_m_s_max + turn_m_s + kRounding_m_s,
         "no wheel exceeds the limits");
    if (left.runs && right.runs) {
      must(std::abs(left.m_s + right.m_s) / 2 <= params.speed_m_s_max + kRounding_m_s, "no speed exceeds its limit");
      must(std::abs(right.m_s - left.m_s) / 2 <= turn_m_s + kRounding_m_s, "no turn exceeds its limit");
    }
    must(std::isfinite(hoist.out.record.speed_m_s) && std::isfinite(hoist.out.record.yaw_rate_rad_s), "the record holds numbers");
  }

 private:
  static constexpr double kRounding_m_s = 5e-5;  // two steps of 60FFh at the largest wheel, as the gate allows
  struct Wheel {
    double m_s = 0;
    bool runs = false;
  };
  [[nodiscard]] Wheel wheel(contract::Node node, double motor_per_m) const {
    using contract::Pdo;
    for (const CanFrame& frame : hoist.sent)
      if (frame.id == contract::pdo_cob_id(Pdo::drive_rx1, node))
        return {
            core::wheel_m_s(static_cast<std::int32_t>(contract::read_slot(frame, contract::pdo_slot(Pdo::drive_rx1, 0x60FF))), motor_per_m),
            contract::read_slot(frame, contract::pdo_slot(Pdo::drive_rx1, 0x6040)) == contract::canopen::drive::kEnable};
    must(false, "each drive is commanded in each step");
    return {};
  }
};

CanFrame frame_from(Pieces& pieces) {
  CanFrame frame{static_cast<std::uint32_t>(pieces.number(2) & 0x7FFU), static_cast<std::uint8_t>(pieces.u8() % 9), 0, {}};
  const Bytes data = pieces.take(frame.dlc);
  std::copy(data.begin(), data.end(), frame.data.begin());
  return frame;
}
void append(Input& input, const CanFrame& frame) {
  input.insert(input.end(), {static_cast<std::uint8_t>(frame.id), static_cast<std::uint8_t>(frame.id >> 8), frame.dlc});
  input.insert(input.end(), frame.data.begin(), frame.data.begin() + frame.dlc);
}

}  // namespace

// The start, then for each step how many frames it gets beside those of the nodes. The therapist holds the stick.
void fuzz_core_frames(Bytes input) {
  Pieces pieces(input);
  Bench bench(pieces.u8());
  for (std::size_t step = 0; step < kStepsMax && !pieces.empty(); ++step) {
    for (std::size_t n = pieces.u8() % 32U; n > 0 && !pieces.empty(); --n) bench.hoist.extra.push_back(frame_from(pieces));
    bench.hoist.hold(0.8, 0.3);
    bench.step();
  }
}
std::vector<Input> seeds_core_frames() {
  Input start{kSilentNodes}, run;
  start.push_back(6);
  for (const std::uint32_t id : {0x701U, 0x702U, 0x708U, 0x711U, 0x712U, 0x713U}) append(start, CanFrame{id, 1, 0, {0}});
  start.push_back(6);
  for (const std::uint32_t id : {0x701U, 0x702U, 0x708U, 0x711U, 0x712U, 0x713U}) append(start, CanFrame{id, 1, 0, {127}});
  run = start;
  for (std::uint8_t step = 0; step < 40; ++step) {
    run.push_back(7);
    for (const std::uint32_t id : {0x181U, 0x182U}) append(run, CanFrame{id, 8, 0, {0x31, 0x02, step, 0, 0, 0, 0, 0}});
    for (const std::uint32_t id : {0x191U, 0x192U, 0x193U}) append(run, CanFrame{id, 6, 0, {0, 0, 0, 0, 3, step}});
    append(run, CanFrame{0x293U, 6, 0, {}});
    append(run, CanFrame{0x188U, 2, 0, {}});
  }
  Input emergency = start;
  emergency.push_back(1);
  append(emergency, CanFrame{0x081U, 8, 0, {0x10, 0x23, 2, 0, 0, 0, 0, 0}});
  std::vector<Input> seeds{start, run, emergency};
  // Each start, with one more frame of each kind between those of the nodes: a position, a tilt, rates, a bumper, a node that boots, an error.
  for (std::uint8_t first = 0; first < kStarts.size(); ++first) {
    Input moving{first};
    for (const CanFrame& frame :
         {CanFrame{0x181U, 8, 0, {0x37, 0x02, 9}}, CanFrame{0x191U, 6, 0, {9, 0, 9, 0, 3, 9}}, CanFrame{0x293U, 6, 0, {9, 9}},
          CanFrame{0x188U, 2, 0, {1, 0}}, CanFrame{0x702U, 1, 0, {0}}, CanFrame{0x081U, 8, 0, {0x10, 0x23, 2}}}) {
      moving.insert(moving.end(), {0, 0, 1});
      append(moving, frame);
    }
    seeds.push_back(moving);
  }
  return seeds;
}

// The start, then for each step what it gets: bits 0..1 commands, 0x04 no driving command, 0x08 any seal, 0x10 v1 and v2, 0x20 a wide `a`,
// 0x40 any order, 0x80 a driving command that is not the therapist's next one.
void fuzz_core_commands(Bytes input) {
  Pieces pieces(input);
  Bench bench(pieces.u8());
  ScriptedHoist& hoist = bench.hoist;
  contract::ParamSetSeal seal;
  contract::Params checked;
  for (std::size_t step = 0; step < kStepsMax && !pieces.empty(); ++step) {
    const std::uint8_t what = pieces.u8();
    for (std::size_t n = what & 3U; n > 0; --n) {
      Command command;
      command.sequence = (what & 0x40U) != 0 ? pieces.number(8) : hoist.state.next_sequence + hoist.commands.size();
      command.kind = static_cast<CommandKind>(pieces.u8());
      command.request_id = pieces.u8();
      command.client = pieces.u8();
      command.lease_epoch = hoist.state.lease.epoch + pieces.u8();
      command.a = static_cast<std::uint32_t>(pieces.number((what & 0x20U) != 0 ? 4 : 1));
      command.b = static_cast<std::uint32_t>(pieces.number(1));
      command.v0 = std::bit_cast<double>(pieces.number(8));
      command.v1 = std::bit_cast<double>(pieces.number((what & 0x10U) != 0 ? 8 : 0));
      command.v2 = std::bit_cast<double>(pieces.number((what & 0x10U) != 0 ? 8 : 0));
      // With a valid checksum by default, so that the code behind the check is reached.
      if (command.kind == CommandKind::stage_parameter) {
        if (command.b == 0) seal = {};
        seal.add(command.a, command.v0);
      }
      command.bits = (what & 0x08U) != 0 ? pieces.number(8) : seal.value();
      hoist.commands.push_back(command);
    }
    if ((what & 0x04U) == 0) hoist.hold(0.8, 0.3);
    if ((what & 0x80U) != 0) {
      contract::DriveCommand& drive = hoist.drive_command;
      drive.lease_epoch += pieces.u8();
      drive.client = pieces.u8();
      drive.sequence += pieces.u8();
      drive.echo_time_ns -= pieces.number(8);
      drive.speed_norm = std::bit_cast<double>(pieces.number(8));
      drive.yaw_norm = std::bit_cast<double>(pieces.number(8));
      drive.held = pieces.u8();
    }
    bench.step();
    const contract::Params& params = hoist.state.params;
    if (std::memcmp(&params, &checked, sizeof params) == 0) continue;
    checked = params;
    for (std::size_t i = 0; i < contract::kParamCount; ++i)
      must(contract::check_param(i, contract::get_param(params, i)) == contract::ParamCheck::ok, "no parameter leaves its range");
    must(contract::check_param_set(params) == nullptr, "no set in force contradicts itself");
  }
}
std::vector<Input> seeds_core_commands() {
  const auto number = [](Input& input, double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (int i = 0; i < 8; ++i) input.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
  };
  const auto command = [&](Input& input, CommandKind kind, std::uint8_t a, std::uint8_t b, std::array<double, 3> v) {
    input.insert(input.end(), {0x11, static_cast<std::uint8_t>(kind), 1, 7, 0, a, b});
    for (const double value : v) number(input, value);
  };
  std::vector<Input> seeds;
  for (std::uint8_t first = 0; first < kStarts.size(); ++first) {
    Input driven{first}, set{first}, other{first};
    // A stick on the other side, and one that is let go.
    for (const std::uint8_t held : Input{1, 0}) {
      driven.insert(driven.end(), {0x80, 0, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0});
      number(driven, -1.0);
      number(driven, 1.0);
      driven.push_back(held);
    }
    command(driven, CommandKind::request_mode, static_cast<std::uint8_t>(Mode::user), 0, {});
    command(driven, CommandKind::request_mode, static_cast<std::uint8_t>(Mode::standby), 0, {});
    command(driven, CommandKind::begin_guided, 0, 1, {2.0, 0, 0.2});
    command(driven, CommandKind::stop, 0, 0, {});
    command(driven, CommandKind::acknowledge, 0, 2, {});
    for (const CommandKind kind : {CommandKind::release_lease, CommandKind::take_lease, CommandKind::set_pose})
      command(set, kind, 0, 0, {});
    command(set, CommandKind::set_neutral, 0, 0, {1.0, 0, 0});
    // Allowed while the hoist moves: the fastest of REMOTE, on trial.
    command(set, CommandKind::stage_parameter, 50, 0, {0.6, 0, 0});
    command(set, CommandKind::commit_parameters, 1, 2, {60.0, 0, 0});
    command(set, CommandKind::confirm_parameters, 0, 2, {});
    command(set, CommandKind::revert_parameters, 0, 2, {});
    command(set, CommandKind::pause_alarm, 1, 2, {});
    command(other, CommandKind::begin_service, 0, 2, {});
    // The upload of a node's identity.
    const CanFrame upload = contract::canopen::sdo(0x601U, contract::canopen::kSdoUploadRequest, 0x1018, 2, 0);
    other.insert(other.end(), {0x31, static_cast<std::uint8_t>(CommandKind::service_frame), 1, 7, 0, 0x01, 0x06, 0, 0, 0});
    for (const double value : {std::bit_cast<double>(upload.data), 8.0, 0.0}) number(other, value);
    command(other, CommandKind::end_service, 0, 0, {});
    command(other, CommandKind::begin_calibration, 2, 2, {1.0, 0, 0});
    for (const CommandKind kind : {CommandKind::measure_calibration, CommandKind::use_calibration, CommandKind::cancel_calibration})
      command(other, kind, 0, 2, {1.0, 0, 0});
    seeds.insert(seeds.end(), {driven, set, other});
  }
  return seeds;
}

}  // namespace hoist::fuzz
