// The control step between a hostile bus and a hostile server: wheel commands never exceed the limits, and are zero outside motion modes.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <vector>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/param_set.hpp"
#include "control/core/tick.hpp"
#include "tests/fuzz/targets.hpp"

namespace hoist::fuzz {
namespace {

using contract::CanFrame;
using contract::Command;
using contract::Mode;

constexpr std::size_t kStepsMax = 400;

struct Bench {
  std::unique_ptr<core::CoreState> state = std::make_unique<core::CoreState>(contract::Params{});
  std::unique_ptr<core::TickOutputs> out = std::make_unique<core::TickOutputs>();
  std::uint64_t ticks = 0;

  void step(std::span<const CanFrame> frames, std::span<const Command> commands, const contract::DriveCommand* drive) {
    core::TickInputs inputs;
    inputs.tick = ticks++;
    inputs.time_ns = 1'000'000'000 + inputs.tick * 10'000'000;
    inputs.frames = frames;
    inputs.bus_up = true;
    inputs.commands = commands;
    inputs.server_heartbeat = ticks;
    inputs.server_life = 1;
    if (drive != nullptr) {
      inputs.drive_fresh = true;
      inputs.drive = *drive;
    }
    core::tick(*state, inputs, core::kTick_s, *out);
    check();
  }

  void check() const {
    const auto mode = static_cast<Mode>(out->record.mode);
    for (const CanFrame& frame : out->frames) {
      must(frame.dlc <= 8 && frame.id <= 0x7FF && frame.flags == 0, "only frames that can exist are sent");
      const bool left = frame.id == contract::pdo_cob_id(contract::Pdo::drive_rx1, contract::Node::drive_left);
      const bool right = frame.id == contract::pdo_cob_id(contract::Pdo::drive_rx1, contract::Node::drive_right);
      if (!left && !right) continue;
      const auto target = static_cast<std::int32_t>(contract::read_slot(frame, contract::pdo_slot(contract::Pdo::drive_rx1, 0x60FF)));
      // 0.65 m/s forward and 50 degrees a second together, through the smallest wheel and the largest gear of the table.
      must(std::abs(static_cast<double>(target)) <= 400'000, "no target beyond the object's range");
      must(target == 0 || (mode != Mode::init && mode != Mode::standby), "nothing moves in a mode that does not move");
    }
    must(std::isfinite(out->record.speed_m_s) && std::isfinite(out->record.yaw_rate_rad_s), "the record holds numbers");
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

// First byte of each step: how many frames it gets.
void fuzz_core_frames(Bytes input) {
  Bench bench;
  Pieces pieces(input);
  std::vector<CanFrame> frames;
  for (std::size_t step = 0; step < kStepsMax && !pieces.empty(); ++step) {
    frames.clear();
    for (std::size_t n = pieces.u8() % 32U; n > 0 && !pieces.empty(); --n) frames.push_back(frame_from(pieces));
    bench.step(frames, {}, nullptr);
  }
}
std::vector<Input> seeds_core_frames() {
  Input start, run;
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
  return {start, run, emergency};
}

void fuzz_core_commands(Bytes input) {
  Bench bench;
  Pieces pieces(input);
  std::uint64_t sequence = 0;
  contract::ParamSetSeal seal;
  for (std::size_t step = 0; step < kStepsMax && !pieces.empty(); ++step) {
    const std::uint8_t what = pieces.u8();
    std::vector<Command> commands;
    for (std::size_t n = what & 3U; n > 0; --n) {
      Command command;
      command.sequence = (what & 0x40U) != 0 ? pieces.number(8) : ++sequence;
      command.kind = static_cast<contract::CommandKind>(pieces.u8());
      command.request_id = pieces.u8();
      command.client = pieces.u8();
      command.lease_epoch = pieces.u8();
      command.a = static_cast<std::uint32_t>(pieces.number((what & 0x20U) != 0 ? 4 : 1));
      command.b = static_cast<std::uint32_t>(pieces.number(1));
      command.v0 = std::bit_cast<double>(pieces.number(8));
      command.v1 = std::bit_cast<double>(pieces.number((what & 0x10U) != 0 ? 8 : 0));
      command.v2 = command.v1;
      // With a valid checksum by default, so that the code behind the check is reached.
      if (command.kind == contract::CommandKind::stage_parameter) {
        if (command.b == 0) seal = {};
        seal.add(command.a, command.v0);
      }
      command.bits = (what & 0x08U) != 0 ? pieces.number(8) : seal.value();
      commands.push_back(command);
    }
    contract::DriveCommand drive;
    if ((what & 0x80U) != 0) {
      drive.lease_epoch = pieces.u8();
      drive.client = pieces.u8();
      drive.sequence = pieces.u8();
      drive.echo_time_ns = pieces.number(8);
      drive.speed_norm = std::bit_cast<double>(pieces.number(8));
      drive.yaw_norm = std::bit_cast<double>(pieces.number(8));
      drive.held = pieces.u8();
    }
    bench.step({}, commands, (what & 0x80U) != 0 ? &drive : nullptr);
    for (std::size_t i = 0; i < contract::kParamCount; ++i)
      must(contract::check_param(i, contract::get_param(bench.state->params, i)) == contract::ParamCheck::ok,
           "no parameter leaves its range");
    must(contract::check_param_set(bench.state->params) == nullptr, "no set in force contradicts itself");
  }
}
std::vector<Input> seeds_core_commands() {
  Input input;
  for (std::uint8_t kind = 1; kind <= 9; ++kind) {
    input.push_back(0x01);
    input.insert(input.end(), {kind, kind, 1, 1, 1, 0});
    const auto bits = std::bit_cast<std::uint64_t>(0.5);
    for (int i = 0; i < 8; ++i) input.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
  }
  return {input};
}

}  // namespace hoist::fuzz
