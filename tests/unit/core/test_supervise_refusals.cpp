// Which mode follows which, and what speaks against it: the table in control/README.md ("Modes"), the words of transitions.hpp and of the
// refusals in faults.def, written a second time. Every reason is told at once.
#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <utility>

#include "control/core/modes/mode_list.hpp"
#include "control/core/supervise/refusals.hpp"
#include "tests/unit/core/test_supervise_bench.hpp"

namespace hoist::core::test::supervise {
namespace {

constexpr bool stopped(Mode mode) { return mode == Mode::protective_stop || mode == Mode::fault || mode == Mode::emergency_stop; }

/// What must hold before `asker` may lead from one mode to the other; none when that way does not exist.
std::optional<Guard> way_rule(Mode from, Mode to, Asker asker) {
  const auto when = [](bool open, Guard guard) { return open ? std::optional{guard} : std::nullopt; };
  const bool ends = to == Mode::standby;
  switch (asker) {
    case Asker::hardware:  // from everywhere
      return when(to == Mode::emergency_stop && from != to, Guard::none);
    case Asker::fault:  // what is not stopped yet
      return when(to == Mode::protective_stop && !stopped(from), Guard::none);
    case Asker::breakdown:  // drives that are off already need no stop; one that brakes stands for a second first
      if (to != Mode::fault) return std::nullopt;
      if (from == Mode::init) return Guard::none;
      if (from == Mode::protective_stop) return Guard::stood;
      return when(from == Mode::standby || from == Mode::calibrate, Guard::at_rest);
    case Asker::acknowledgement:
      if (from == Mode::protective_stop && ends) return Guard::cause_gone;
      if (to != Mode::init) return std::nullopt;
      if (from == Mode::protective_stop) return Guard::only_silence;
      if (from == Mode::fault) return Guard::checked;
      return when(from == Mode::emergency_stop, Guard::chain_closed);
    case Asker::engineer:
      return when(from == Mode::standby && to == Mode::init, Guard::at_rest);
    case Asker::core:
      if (from == Mode::init || from == Mode::calibrate) return when(ends, Guard::finished);
      return when(moves(from) && ends, Guard::ramp_first);
    case Asker::driver:
      if (from != Mode::standby)
        return when(ends && (moves(from) || from == Mode::calibrate), moves(from) ? Guard::ramp_first : Guard::none);
      if (to == Mode::calibrate) return Guard::at_rest;
      if (to == Mode::remote) return Guard::ready_off_a_bumper;
      if (to == Mode::guided) return Guard::ready_with_a_path;
      return when(to == Mode::user, Guard::ready);
  }
  return std::nullopt;
}

TEST(SuperviseRefusals, ModesFollowEachOtherAsTheTableOfTheReadmeSays) {
  for (const Mode from : kEveryMode)
    for (const Mode to : kEveryMode)
      for (std::uint8_t asker = 0; asker <= static_cast<std::uint8_t>(Asker::acknowledgement); ++asker) {
        SCOPED_TRACE(testing::Message() << int(from) << " to " << int(to) << " by " << int(asker));
        const std::optional<Guard> guard = way_rule(from, to, Asker{asker});
        const Transition* row = find_transition(from, to, Asker{asker});
        ASSERT_EQ(row != nullptr, guard.has_value());
        if (row == nullptr) continue;
        EXPECT_TRUE(row->from == from && row->to == to && row->asker == Asker{asker});
        EXPECT_EQ(row->guard, *guard);
      }
  for (const Mode mode : kEveryMode) {
    EXPECT_EQ(is_moving(mode), moves(mode));
    EXPECT_EQ(mode_row_of(mode).mode, mode);
    EXPECT_EQ(mode_row_of(mode).drives, moves(mode) || mode == Mode::protective_stop) << "the drives hold a protective stop";
  }
}

/// The words of each refusal in faults.def.
std::uint32_t start_rule(const CoreState& state, const Facts& facts) {
  std::uint32_t bits = 0;
  const auto against = [&bits](Refusal refusal, bool holds) { bits |= holds ? refusal_bit(refusal) : 0U; };
  against(Refusal::not_standby, state.mode != Mode::standby);
  against(Refusal::nodes_missing,
          !facts.running || facts.angles_ms >= 30 || facts.rates_ms >= 30 || facts.drive_lost || facts.io_lost || !facts.volts_known);
  against(Refusal::fault_active, (state.latched & ~all_with(Reaction::warn)) != 0);
  against(Refusal::not_neutral, !facts.upright);
  against(Refusal::moving, !at_rest(state));
  against(Refusal::battery_empty_start, (state.latched & set_of({Fault::battery_empty})) != 0);
  against(Refusal::sensors_settling, !facts.settled);
  against(Refusal::no_lease, state.lease.holder == 0);
  against(Refusal::stick_not_neutral, facts.pushed);
  against(Refusal::bumper_start, facts.touching != 0);
  against(Refusal::fault_mode, state.mode == Mode::fault || (state.latched & breakdowns()) != 0);
  against(Refusal::emergency_stop_open, state.mode == Mode::emergency_stop || (state.conditions & power_offs()) != 0);
  against(Refusal::node_version, facts.other_version);
  against(Refusal::not_calibrated, !facts.zeroed);
  against(Refusal::parts_unchecked, !facts.checked);
  return bits;
}
std::uint32_t start_rule(const CoreState& state, const Facts& facts, Mode to) {
  std::uint32_t bits = start_rule(state, facts);
  // H13: REMOTE may drive away from a bumper that was acknowledged while it touched.
  if (to == Mode::remote && (facts.touching & ~facts.known_touching) == 0) bits &= ~refusal_bit(Refusal::bumper_start);
  if (to == Mode::guided && !facts.path) bits |= refusal_bit(Refusal::no_exercise);
  if (to == Mode::guided && facts.held) bits |= refusal_bit(Refusal::release_first);
  return bits;
}

/// The words of the guards in transitions.hpp.
std::uint32_t guard_rule(const CoreState& state, const Facts& facts, Guard guard) {
  const bool stood = state.still.ticks >= 100, silent = state.in_mode.silent.ticks >= 250;
  // A drive's own fault ends with the acknowledgement; a bumper is left by driving.
  const FaultBits causes = state.conditions & stops() & ~kDrives & ~kTouch;
  const auto all = [](std::initializer_list<std::pair<bool, Refusal>> reasons) {
    std::uint32_t bits = 0;
    for (const auto& [holds, refusal] : reasons) bits |= holds ? refusal_bit(refusal) : 0U;
    return bits;
  };
  const bool broken = (state.latched & breakdowns()) != 0;
  switch (guard) {
    case Guard::none:
    case Guard::finished:
    case Guard::ramp_first:
      return 0;
    case Guard::at_rest:
      return all({{!at_rest(state), Refusal::moving}});
    case Guard::stood:
    case Guard::checked:
      return all({{!stood, Refusal::moving}});
    case Guard::ready:
      return start_rule(state, facts, Mode::user);
    case Guard::ready_off_a_bumper:
      return start_rule(state, facts, Mode::remote);
    case Guard::ready_with_a_path:
      return start_rule(state, facts, Mode::guided);
    case Guard::cause_gone:
      return all({{causes != 0, Refusal::cause_not_cleared}, {broken, Refusal::fault_mode}, {!stood, Refusal::moving}});
    case Guard::only_silence:
      return all(
          {{(causes & ~kPlugs) != 0 || !silent, Refusal::cause_not_cleared}, {broken, Refusal::fault_mode}, {!stood, Refusal::moving}});
    case Guard::chain_closed:
      return all({{(state.conditions & power_offs()) != 0, Refusal::emergency_stop_open}, {!at_rest(state), Refusal::moving}});
  }
  return refusal_bit(Refusal::unknown_item);
}

constexpr Guard kEveryGuard[] = {Guard::none,
                                 Guard::finished,
                                 Guard::ramp_first,
                                 Guard::at_rest,
                                 Guard::stood,
                                 Guard::ready,
                                 Guard::ready_off_a_bumper,
                                 Guard::ready_with_a_path,
                                 Guard::cause_gone,
                                 Guard::only_silence,
                                 Guard::checked,
                                 Guard::chain_closed,
                                 Guard{99}};

TEST(SuperviseRefusals, EveryReasonIsToldAtOnce) {
  Dice dice(1);
  std::map<std::uint32_t, int> alone, free;
  for (int i = 0; i < 2500 && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState state = bases().ready;
    const Mode mode = dice.chance(0.5) ? Mode::standby : kEveryMode[dice.below(std::size(kEveryMode))];
    const Facts facts = set_situation(state, mode, dice);
    const std::uint32_t start = start_refusals(state);
    ASSERT_EQ(start, start_rule(state, facts));
    ++alone[start];
    for (const Mode to : kEveryMode) ASSERT_EQ(start_refusals(state, to), start_rule(state, facts, to)) << int(to);
    for (const Guard guard : kEveryGuard) {
      const std::uint32_t bits = guard_refusals(state, guard);
      ASSERT_EQ(bits, guard_rule(state, facts, guard)) << int(guard);
      free[static_cast<std::uint32_t>(guard)] += bits == 0 ? 1 : 0;
    }
  }
  EXPECT_GT(alone.size(), 200U) << "the situations differ";
  EXPECT_GT(alone[0], 3);
  for (const Guard guard : kEveryGuard)
    if (guard != Guard{99}) {
      EXPECT_GT(free[static_cast<std::uint32_t>(guard)], 5) << int(guard);
    }
}

// A request from elsewhere also learns where the hoist stands.
TEST(SuperviseRefusals, AModeThatIsNoStandbySaysWhatItIs) {
  const std::map<Mode, std::uint32_t> words{{Mode::init, refusal_bit(Refusal::nodes_missing)},
                                            {Mode::protective_stop, refusal_bit(Refusal::fault_active)},
                                            {Mode::fault, refusal_bit(Refusal::fault_mode)},
                                            {Mode::emergency_stop, refusal_bit(Refusal::emergency_stop_open)}};
  CoreState state;
  for (const Mode mode : kEveryMode) {
    state.mode = mode;
    EXPECT_EQ(where_it_stands(state), words.contains(mode) ? words.at(mode) : 0U) << int(mode);
  }
}

}  // namespace
}  // namespace hoist::core::test::supervise
