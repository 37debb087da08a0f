// Acknowledging a stop (control/DECISIONS.md, 13, 37, 43, 61, 74, 80 and 83): what opens the way, what it covers, and what the answer waits
// for.
#include <gtest/gtest.h>

#include <bit>
#include <optional>

#include "control/core/supervise/refusals.hpp"
#include "control/core/supervise/release.hpp"
#include "tests/unit/core/test_supervise_bench.hpp"

namespace hoist::core::test::supervise {
namespace {

using contract::Role;

/// A stop with its causes; what they are about is often still there.
Facts set_stop(CoreState& state, Dice& dice) {
  constexpr Mode kStops[] = {Mode::protective_stop, Mode::protective_stop, Mode::fault, Mode::emergency_stop};
  const Mode mode = dice.chance(0.1) ? kEveryMode[dice.below(std::size(kEveryMode))] : kStops[dice.below(std::size(kStops))];
  const Facts facts = set_situation(state, mode, dice);
  if (mode == Mode::fault && dice.chance(0.8)) {
    state.latched = kTooMany;
    // What led there: plugs, or something else beside them.
    for (const contract::FaultInfo& row : contract::kFaults)
      if (dice.chance((kPlugs >> row.bit & 1U) != 0 ? 0.15 : 0.01)) state.latched |= FaultBits{1} << row.bit;
  }
  if (mode == Mode::emergency_stop && dice.chance(0.3)) state.latched |= power_offs() | (dice.chance(0.5) ? breakdowns() : 0);
  if (dice.chance(0.5)) state.conditions &= dice.of<FaultBits>({0, kDrives, kLeftDrive | kTouch, kPlugs, kTouch});
  state.in_mode.epoch = 99;
  state.stops_changed = false;
  if (dice.chance(0.5)) state.relay.cut();
  EXPECT_FALSE(state.repeats.note(3, state.time_ns, state.params));
  return facts;
}

struct WayOut {
  std::optional<Mode> to;
  std::uint32_t against = 0;
};
/// Which way an acknowledgement opens, or what is against the first one.
WayOut way_rule(const CoreState& state, Role role, FaultBits seen) {
  WayOut way;
  switch (state.mode) {
    case Mode::protective_stop: {
      const std::uint32_t on = guard_refusals(state, Guard::cause_gone);
      const bool silence = on != 0 && guard_refusals(state, Guard::only_silence) == 0;
      way = {silence ? Mode::init : Mode::standby, silence ? 0U : on};
      break;
    }
    case Mode::fault: {
      way = {Mode::init, guard_refusals(state, Guard::checked)};
      // A therapist may leave it when plugs explain it, else an engineer.
      const FaultBits causes = state.latched & stops() & ~kNoMachine;
      const bool plugs = causes != 0 && (causes & ~kPlugs) == 0 && (state.latched & breakdowns()) == kTooMany;
      if (role != Role::engineer && !plugs) way.against |= refusal_bit(Refusal::not_allowed);
      break;
    }
    case Mode::emergency_stop:
      way = {Mode::init, guard_refusals(state, Guard::chain_closed)};
      break;
    default:
      return {std::nullopt, refusal_bit(Refusal::unknown_item)};
  }
  // A request may name the faults that were shown: a latched fault not among them refuses it.
  if (seen != 0 && (state.latched & kept_faults() & ~seen) != 0) way.against |= refusal_bit(Refusal::cause_not_seen);
  return way;
}

/// What is left of the faults, where it leads, and what else is forgotten.
void expect_left(const CoreState& before, const CoreState& state, Mode to, const Told& told) {
  EXPECT_EQ(state.mode, to);
  // Out of service stays so through the emergency stop: only an acknowledgement of FAULT itself ends it.
  const bool checked = before.mode == Mode::fault;
  const bool stays_broken = before.mode == Mode::emergency_stop && (before.latched & breakdowns()) != 0;
  const FaultBits gone = to == Mode::standby ? stops() : (stays_broken ? power_offs() : kept_faults());
  EXPECT_EQ(state.latched, before.latched & ~gone);
  EXPECT_EQ(told.faults(EventKind::fault_cleared), before.latched & gone);
  EXPECT_EQ(state.repeats.history().count, checked ? 0U : before.repeats.history().count);
  EXPECT_EQ(state.stops_changed, checked);
  EXPECT_EQ(state.relay.is_cut(), before.relay.is_cut() && !checked);
  EXPECT_EQ(state.master.all_running(), to == Mode::standby && before.master.all_running()) << "INIT meets every node again";
  const auto modes = told.of(EventKind::mode_changed);
  ASSERT_EQ(modes.size(), 1U);
  EXPECT_EQ(modes[0].code, static_cast<std::uint32_t>(to));
}
void expect_unchanged(const CoreState& before, const CoreState& state) {
  EXPECT_EQ(state.mode, before.mode);
  EXPECT_EQ(state.latched, before.latched);
  EXPECT_EQ(state.in_mode.epoch, before.in_mode.epoch);
  EXPECT_EQ(state.relay.is_cut(), before.relay.is_cut());
  EXPECT_EQ(state.repeats.history().count, before.repeats.history().count);
  EXPECT_EQ(state.master.all_running(), before.master.all_running());
  EXPECT_EQ(state.stops_changed, before.stops_changed);
}
/// A drive leaves its fault only when it is reset: one that is in it now, or whose fault was found in this step.
void expect_resets(const CoreState& before, const CoreState& state, const Facts& facts, bool pressed) {
  EXPECT_EQ(state.left_control.resetting(), pressed && (facts.left_in_fault || (before.conditions & kLeftDrive) != 0));
  EXPECT_EQ(state.right_control.resetting(), pressed && (facts.right_in_fault || (before.conditions & kRightDrive) != 0));
}

TEST(SuperviseRelease, APressEndsTheStopOrWaitsForADriveOrSaysWhyNot) {
  Dice dice(2);
  int refused = 0, waited = 0, ended[9]{};
  for (int i = 0; i < 3500 && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState before = bases().ready;
    const Facts facts = set_stop(before, dice);
    const FaultBits seen = dice.of<FaultBits>({0, 0, before.latched, before.latched | kTouch, some_faults(dice)});
    const Press press{41, 7, dice.chance(0.5) ? Role::engineer : Role::therapist, seen};
    const WayOut way = way_rule(before, press.role, seen);
    CoreState state = before;
    const Told told(state);
    ASSERT_EQ(press_release(state, press), way.against);
    const bool drives = (before.conditions & stops() & ~kTouch) != 0;
    const bool waits = way.against == 0 && way.to == Mode::standby && drives;
    expect_resets(before, state, facts, way.against == 0);
    ASSERT_EQ(state.acknowledgement.waits(), waits);
    EXPECT_EQ(state.acknowledgement.bumpers(),
              way.against == 0 && way.to == Mode::standby && !waits ? facts.touching : facts.known_touching);
    if (way.against != 0 || waits) {
      expect_unchanged(before, state);
      EXPECT_EQ(told.count(), 0U);
    } else {
      expect_left(before, state, *way.to, told);
      ++ended[static_cast<std::size_t>(before.mode)];
    }
    if (waits) {
      const Acknowledgement::Waiting& kept = state.acknowledgement.pressed();
      EXPECT_EQ(kept.request_id, 41U);
      EXPECT_EQ(kept.client, 7U);
      EXPECT_EQ(kept.lease_epoch, before.lease.epoch);
      EXPECT_EQ(kept.bumpers, facts.touching);
      EXPECT_EQ(kept.ticks_left, 50) << "half a second";
      EXPECT_FALSE(kept.overtaken);
      ++waited;
    }
    refused += way.against != 0 ? 1 : 0;
  }
  EXPECT_GT(refused, 400);
  EXPECT_GT(waited, 20);
  for (const Mode mode : {Mode::protective_stop, Mode::fault, Mode::emergency_stop}) EXPECT_GT(ended[static_cast<std::size_t>(mode)], 40);
}

// The answer comes when the drive has left its fault, after half a second, with a further cause, or with a change of the lease.
TEST(SuperviseRelease, APressThatWaitsIsAnsweredByTheRule) {
  Dice dice(3);
  int waited = 0, done = 0, refused = 0;
  for (int i = 0; i < 3500 && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState before = bases().ready;
    const Facts facts = set_stop(before, dice);
    if (dice.chance(0.8)) before.mode = Mode::protective_stop;
    before.in_mode.silent.ticks = dice.chance(0.8) ? 0 : 250;
    const bool presses = dice.chance(0.9);
    const std::uint8_t left = dice.of<std::uint8_t>({1, 2, 30, 50}), pressed = static_cast<std::uint8_t>(dice.below(16));
    const std::uint32_t epoch = dice.chance(0.8) ? before.lease.epoch : before.lease.epoch - 1;
    if (presses) before.acknowledgement.wait({41, 7, epoch, pressed, left, false});
    const bool overtaken = dice.chance(0.1);
    if (overtaken) before.acknowledgement.overtake();
    CoreState state = before;
    const Told told(state);
    serve_release(state);
    if (!presses) {
      expect_unchanged(before, state);
      EXPECT_EQ(told.count(), 0U);
      continue;
    }
    const bool cleared = (before.conditions & stops() & ~kTouch) == 0;
    const bool given_up = overtaken || epoch != before.lease.epoch;
    if (before.mode == Mode::protective_stop && !cleared && !given_up && left > 1) {
      EXPECT_EQ(state.acknowledgement.pressed().ticks_left, left - 1);
      expect_unchanged(before, state);
      EXPECT_EQ(told.count(), 0U);
      ++waited;
      continue;
    }
    std::uint32_t bits = overtaken || !cleared ? refusal_bit(Refusal::cause_not_cleared) : 0U;
    if (epoch != before.lease.epoch) bits |= refusal_bit(Refusal::no_lease);
    const WayOut way = way_rule(before, Role::therapist, 0);
    if (bits == 0) bits = way.against;
    EXPECT_FALSE(state.acknowledgement.waits());
    EXPECT_EQ(state.commands_refused, before.commands_refused + (bits != 0 ? 1 : 0));
    const auto answers = told.of(bits == 0 ? EventKind::command_done : EventKind::command_refused);
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_EQ(answers[0].request_id, 41U);
    EXPECT_EQ(answers[0].client, 7U);
    EXPECT_EQ(answers[0].bits, bits);
    EXPECT_EQ(answers[0].code, bits == 0 ? 0U : static_cast<std::uint32_t>(std::countr_zero(bits)));
    expect_resets(before, state, facts, bits == 0);
    EXPECT_EQ(state.acknowledgement.bumpers(), bits == 0 ? pressed : facts.known_touching) << "a later touch is not acknowledged";
    if (bits == 0) {
      expect_left(before, state, *way.to, told);
    } else {
      expect_unchanged(before, state);
    }
    ++(bits == 0 ? done : refused);
  }
  EXPECT_GT(waited, 100);
  EXPECT_GT(done, 100);
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace hoist::core::test::supervise
