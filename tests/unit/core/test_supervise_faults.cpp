// Which faults are in force, what they are about, and what they stop: control/DECISIONS.md (13, 37, 38, 54, 76, 80 to 84), the tables of
// faults.def and the words of fault_latch.hpp, supervisor.hpp and state.hpp, written a second time and compared in one step from any
// situation.
#include <gtest/gtest.h>

#include <array>
#include <tuple>

#include "control/core/supervise/fault_latch.hpp"
#include "control/core/supervise/fault_sets.hpp"
#include "control/core/supervise/supervisor.hpp"
#include "tests/unit/core/test_supervise_bench.hpp"

namespace hoist::core::test::supervise {
namespace {

using Codes = std::array<std::uint16_t, contract::kFaultPlaces>;

constexpr std::uint16_t kBlocked = 0x7121;  // HOIST_DETAIL: a matter of the floor
constexpr std::size_t place(Fault fault) { return static_cast<std::size_t>(fault); }

/// What each fault would be about if it began now.
struct Detail {
  Codes now{};
  std::uint32_t duplicate = 0, babbling = 0;
};

/// The last emergency of a drive tells the error as long as its register does; then 603Fh.
std::uint16_t set_drive_error(CoreState& state, contract::Node node, DriveSensor& drive, bool in_fault, Dice& dice) {
  const auto tell = [&](std::uint16_t code, std::uint8_t error_register) {
    contract::CanFrame frame{0x80U + contract::node_id(node), 8, 0, {}};
    contract::write_le(&frame.data[0], 2, code);
    frame.data[2] = error_register;
    static_cast<void>(state.health.take(frame, contract::classify(frame)));
  };
  const auto emergency = dice.of<std::uint16_t>({0, kBlocked, 0x4310, 0x5000}), error = dice.of<std::uint16_t>({0, kBlocked, 0x2310});
  const bool over = dice.chance(0.3);
  if (emergency != 0) tell(emergency, dice.of<std::uint8_t>({1, 2, 0x80}));
  if (over) tell(0, 0);
  drive.take_supply(supply(error, 25));
  if (!in_fault) return 0;
  return emergency != 0 && !over ? emergency : error;
}

Detail set_details(CoreState& state, const Facts& facts, Dice& dice) {
  Detail detail;
  state.health = {};
  state.health.next_tick(state.time_ns, true);
  detail.now[place(Fault::drive_left_fault)] =
      set_drive_error(state, contract::Node::drive_left, state.sensed.left_drive, facts.left_in_fault, dice);
  detail.now[place(Fault::drive_right_fault)] =
      set_drive_error(state, contract::Node::drive_right, state.sensed.right_drive, facts.right_in_fault, dice);
  const bool odd = dice.chance(0.5);
  state.monitors = odd ? bases().odd : bases().ready.monitors;
  detail.now[place(Fault::tilt_implausible)] = detail.now[place(Fault::overspeed)] = odd ? 1 : 0;
  if (dice.chance(0.3)) {  // a second control computer
    const contract::CanFrame beat =
        contract::canopen::heartbeat(contract::node_id(contract::Node::core), contract::canopen::NmtState::operational);
    for (int i = 0; i < 3; ++i) static_cast<void>(state.health.take(beat, contract::classify(beat)));
    detail.duplicate = contract::node_id(contract::Node::core);
  }
  detail.babbling = BusHealth::kNoId;
  if (dice.chance(0.3)) {
    const contract::CanFrame flood{0x7E5, 8, 0, {}};
    for (int i = 0; i < 200; ++i) static_cast<void>(state.health.take(flood, contract::classify(flood)));
    detail.babbling = 0x7E5;
  }
  for (const contract::DetailInfo& row : contract::kDetails)
    if (dice.chance(0.4)) state.fault_codes[place(row.fault)] = dice.chance(0.7) ? row.code : std::uint16_t{9};
  for (const contract::FaultInfo& row : contract::kFaults)
    if ((state.latched >> row.bit & 1U) == 0 && dice.chance(0.9)) state.fault_codes[row.bit] = 0;
  return detail;
}

bool has_detail(std::size_t bit) {
  return std::any_of(contract::kDetails.begin(), contract::kDetails.end(), [bit](const auto& row) { return place(row.fault) == bit; });
}

/// A fault that ends loses its code; one that begins takes what it is about now; a drive may tell it later, within the first second of the
/// stop.
void keep_rule(Codes& codes, const Detail& detail, FaultBits latched, FaultBits begun, std::uint64_t ticks) {
  for (std::size_t bit = 0; bit < codes.size(); ++bit) {
    if (!has_detail(bit)) continue;
    const FaultBits own = FaultBits{1} << bit;
    const bool late = codes[bit] == 0 && (own & kDrives) != 0 && ticks < 100;
    if ((latched & own) == 0) codes[bit] = 0;
    if ((latched & own) != 0 && ((begun & own) != 0 || late)) codes[bit] = detail.now[bit];
  }
}
void expect_codes(const CoreState& state, const Codes& codes) { EXPECT_EQ(state.fault_codes, codes); }

/// Each fault is told once, with the device or the detail that it is about.
void expect_told(const Told& told, FaultBits raised, FaultBits cleared, const Codes& codes, const Detail& detail) {
  EXPECT_EQ(told.faults(EventKind::fault_raised), raised);
  EXPECT_EQ(told.faults(EventKind::fault_cleared), cleared);
  for (const Event& event : told.of(EventKind::fault_raised)) {
    std::uint32_t item = has_detail(event.code) ? codes[event.code] : 0U;
    if (event.code == place(Fault::node_duplicate)) item = detail.duplicate;
    if (event.code == place(Fault::node_babbling)) item = detail.babbling;
    EXPECT_EQ(event.item, item) << event.code;
  }
  for (const Event& event : told.of(EventKind::fault_cleared)) EXPECT_EQ(event.item, 0U);
}

/// Of these faults those that floor, load or patient caused.
FaultBits outside_rule(const Codes& codes) {
  FaultBits bits = 0;
  for (const contract::DetailInfo& row : contract::kDetails)
    if (row.origin == contract::Origin::outside && codes[place(row.fault)] == row.code) bits |= set_of({row.fault});
  return bits;
}

TEST(SuperviseFaults, EachSetOfFaultsIsWhatItsReactionSays) {
  for (const Reaction reaction :
       {Reaction::warn, Reaction::soft_stop, Reaction::protective_stop, Reaction::out_of_service, Reaction::power_off})
    EXPECT_EQ(faults_with(reaction), all_with(reaction));
  EXPECT_EQ(kCountedStops, stops() & ~kNoMachine);
  EXPECT_EQ(kSilence, kPlugs);
  EXPECT_EQ(kLatching, kept_faults());
  EXPECT_EQ(kSoft, all_with(Reaction::soft_stop));
  EXPECT_EQ(kWarnings, all_with(Reaction::warn));
}

/// Any situation, often one in which a stop is to be judged.
Facts set_faults(CoreState& state, Dice& dice) {
  const Mode mode = dice.chance(0.4) ? Mode::protective_stop : kEveryMode[dice.below(std::size(kEveryMode))];
  const Facts facts = set_situation(state, mode, dice);
  state.stops_changed = false;
  state.in_mode.ticks = dice.of<std::uint64_t>({0, 1, 19, 20, 60, 98, 99, 99, 99, 100, 101, 5000});
  state.in_mode.braking = mode == Mode::protective_stop ? Braking::protective : Braking::none;
  if (moves(mode) && dice.chance(0.4)) {
    state.in_mode.leaving = true;
    state.in_mode.braking = dice.of({Braking::soft, Braking::remote, Braking::protective});
  }
  state.stop_cause = static_cast<std::uint8_t>(dice.below(34));
  if (dice.chance(0.5)) {
    const contract::Explanation& row = contract::kExplanations[dice.below(contract::kExplanations.size())];
    state.latched |= set_of({row.effect}) | (dice.chance(0.8) ? set_of({row.cause}) : 0);
    state.stop_cause = static_cast<std::uint8_t>(place(row.effect) + 1);
  }
  state.in_mode.causes = dice.chance(0.2) ? 0 : state.latched & (dice.chance(0.5) ? ~FaultBits{0} : some_faults(dice));
  StopHistory history;
  const auto now_ns = static_cast<std::int64_t>(state.time_ns);
  if (dice.chance(0.2)) history.stops[history.count++] = {now_ns - 700'000'000'000, 5};
  for (const contract::FaultInfo& row : contract::kFaults)
    for (std::size_t k = dice.chance(0.3) ? dice.below(3) : 0; k > 0 && history.count < history.stops.size(); --k)
      history.stops[history.count++] = {now_ns - 1'000'000'000, row.bit};
  state.repeats.restore(history);
  if (dice.chance(0.2)) state.relay.cut();
  if (dice.chance(0.4)) state.acknowledgement.wait({41, 7, 3, 0, 20, false});
  return facts;
}

/// One step of the rule, on the few things that it speaks of.
class FaultRule {
 public:
  FaultRule(const CoreState& before, Detail detail)
      : mode(before.mode),
        braking(before.in_mode.braking),
        leaving(before.in_mode.leaving),
        ticks(before.in_mode.ticks),
        causes(before.in_mode.causes),
        conditions(before.conditions),
        latched(before.latched),
        codes(before.fault_codes),
        stop_cause(before.stop_cause),
        repeats(before.repeats),
        holder(before.lease.holder),
        waits(before.acknowledgement.waits()),
        silent(before.in_mode.silent.ticks),
        before_(before),
        detail_(detail) {}

  void step(FaultBits found) {
    // Out of service or without power nothing is left to stop; drives without the supply that the core has cut tell nothing new.
    if (mode == Mode::fault || mode == Mode::emergency_stop) found &= ~stops();
    if (before_.relay.is_cut()) found &= ~kDrives;
    overtaken = (found & ~conditions & stops() & ~kTouch) != 0;
    conditions = found;
    // INIT remembers only what puts the hoist out of service.
    const FaultBits now = found | (latched & (mode == Mode::init ? breakdowns() : kept_faults()));
    cleared = latched & ~now;
    raised = now & ~latched;
    latched = now;
    keep_rule(codes, detail_, latched, raised, ticks);
    if ((raised & power_offs()) != 0 && mode != Mode::emergency_stop) lose_power();
    if ((raised & stops()) != 0 && mode != Mode::init) stop(raised & stops());
    if ((raised & all_with(Reaction::soft_stop)) != 0 && moves(mode)) {
      leaving = true;
      braking = std::max(braking, Braking::soft);
    }
    if (mode == Mode::protective_stop && ticks < 100) judge();
    if (repeats.expire(before_.time_ns, before_.params)) changed = true;
    silent = mode != Mode::protective_stop || (found & kPlugs) == 0 ? 0 : std::min(silent + 1, 250);
  }

  void raise(Fault fault) {
    overtaken = true;
    const FaultBits own = set_of({fault});
    if ((latched & own) == 0) {
      raised = own;
      latched |= own;
      keep_rule(codes, detail_, latched, own, ticks);
    }
    // Where nothing is to be braked the hoist goes out of service in this step.
    const bool stands = mode == Mode::init || (!moves(mode) && at_rest(before_));
    if ((own & breakdowns()) == 0 || !stands) stop(own);
  }

  void expect(const CoreState& state, const Told& told) const {
    EXPECT_EQ(state.mode, mode);
    EXPECT_EQ(state.latched, latched);
    EXPECT_EQ(state.conditions, conditions);
    expect_codes(state, codes);
    expect_told(told, raised, cleared, codes, detail_);
    EXPECT_EQ(told.of(EventKind::mode_changed).size(), mode == before_.mode ? 0U : 1U);
    if (moves(mode) || mode == Mode::protective_stop) {
      EXPECT_EQ(state.in_mode.braking, braking);
    }
    EXPECT_EQ(state.in_mode.leaving, leaving);
    EXPECT_EQ(state.in_mode.causes, causes);
    EXPECT_EQ(state.stop_cause, stop_cause);
    EXPECT_EQ(state.stops_changed, changed);
    ASSERT_EQ(state.repeats.history().count, repeats.history().count);
    for (std::size_t i = 0; i < repeats.history().count; ++i)
      EXPECT_EQ(state.repeats.history().stops[i].fault, repeats.history().stops[i].fault);
    EXPECT_EQ(state.lease.holder, holder);
    EXPECT_EQ(state.acknowledgement.waits(), waits);
    EXPECT_EQ(state.acknowledgement.pressed().overtaken, overtaken);
    EXPECT_EQ(state.in_mode.silent.ticks, silent);
  }

  Mode mode;
  Braking braking;
  bool leaving;
  std::uint64_t ticks;
  FaultBits causes, conditions, latched, raised = 0, cleared = 0;
  Codes codes;
  std::uint8_t stop_cause;
  RepeatWatch repeats;
  std::uint32_t holder;
  bool waits, overtaken = false, changed = false;
  int silent;

 private:
  void enter(Mode to) {
    mode = to;
    braking = Braking::none;
    leaving = false;
    ticks = 0;
    causes = 0;
    silent = 0;
  }
  /// The lease is free, and nothing waits.
  void lose_power() {
    // Pressed by a hand, 0.2 s after the stop at the earliest; it is counted at a second at the latest.
    if (mode == Mode::protective_stop && ticks >= 20 && ticks < 100) count();
    enter(Mode::emergency_stop);
    stop_cause = static_cast<std::uint8_t>(place(Fault::emergency_stop) + 1);
    holder = 0;
    waits = overtaken = false;
  }
  void stop(FaultBits by) {
    if (mode != Mode::protective_stop && mode != Mode::fault && mode != Mode::emergency_stop) {
      // A stop in INIT says nothing about the machine.
      const bool counts = mode != Mode::init;
      enter(Mode::protective_stop);
      braking = Braking::protective;
      causes = counts ? by : 0;
      stop_cause = static_cast<std::uint8_t>(place(contract::first_cause(by)) + 1);
    }
    if ((by & kTouch) != 0) braking = Braking::bumper;
  }
  /// A cause that is found in the first second takes the place of its consequence; at the end of it machine faults are counted.
  void judge() {
    for (const contract::Explanation& row : contract::kExplanations)
      if (stop_cause == place(row.effect) + 1 && (latched & set_of({row.cause})) != 0) {
        stop_cause = static_cast<std::uint8_t>(place(row.cause) + 1);
        if (causes != 0) causes |= set_of({row.cause});
      }
    if (ticks == 99) count();
  }
  void count() {
    bool too_many = false;
    for (const contract::FaultInfo& row : contract::kFaults) {
      const FaultBits own = FaultBits{1} << row.bit;
      const bool explained = std::any_of(contract::kExplanations.begin(), contract::kExplanations.end(), [&](const auto& one) {
        return place(one.effect) == row.bit && (latched & set_of({one.cause})) != 0;
      });
      if ((causes & own & stops() & ~kNoMachine) == 0 || explained || (outside_rule(codes) & own) != 0) continue;
      changed = true;
      too_many = repeats.note(row.bit, before_.time_ns, before_.params) || too_many;
    }
    if (!too_many || (latched & kTooMany) != 0) return;
    latched |= kTooMany;
    raised |= kTooMany;
    keep_rule(codes, detail_, latched, kTooMany, ticks);
  }

  const CoreState& before_;
  Detail detail_;
};

TEST(SuperviseFaults, OneStepOfFindingsIsJudgedByTheRule) {
  Dice dice(4);
  std::array<int, 9> into{};
  int counted = 0, out = 0;
  for (int i = 0; i < 3000 && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState before = bases().ready;
    const Facts facts = set_faults(before, dice);
    const Detail detail = set_details(before, facts, dice);
    FaultBits found = some_faults(dice);
    if (dice.chance(0.5)) found |= before.conditions;
    FaultRule rule(before, detail);
    rule.step(found);
    CoreState state = before;
    const Told told(state);
    judge_faults(state, found);
    rule.expect(state, told);
    EXPECT_EQ(from_outside(state), outside_rule(rule.codes));
    if (state.mode != before.mode) ++into[static_cast<std::size_t>(state.mode)];
    counted += state.repeats.history().count > before.repeats.history().count ? 1 : 0;
    out += (rule.raised & kTooMany & ~found) != 0 ? 1 : 0;
  }
  EXPECT_GT(into[static_cast<std::size_t>(Mode::protective_stop)], 150);
  EXPECT_GT(into[static_cast<std::size_t>(Mode::emergency_stop)], 30);
  EXPECT_GT(counted, 30);
  EXPECT_GT(out, 5);
}

TEST(SuperviseFaults, WhatNoMonitorWatchesStopsAtOnce) {
  Dice dice(5);
  int stood = 0;
  for (int i = 0; i < 3000 && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState before = bases().ready;
    const Facts facts = set_faults(before, dice);
    const Detail detail = set_details(before, facts, dice);
    const Fault fault = dice.chance(0.5) ? dice.of({Fault::stop_pressed, Fault::control_fault, Fault::gate_refused, Fault::bumper_pressed})
                                         : static_cast<Fault>(contract::kFaults[dice.below(contract::kFaults.size())].bit);
    FaultRule rule(before, detail);
    rule.raise(fault);
    CoreState state = before;
    const Told told(state);
    raise_fault(state, fault);
    rule.expect(state, told);
    stood += fault == Fault::control_fault && state.mode == before.mode ? 1 : 0;
  }
  EXPECT_GT(stood, 30);
}

// At start and at an acknowledgement: codes of faults that are no longer in force are forgotten, a drive may still tell its own.
TEST(SuperviseFaults, FaultsOfAnEarlierRunAreToldAndAcknowledgedOnesAreCleared) {
  Dice dice(6);
  for (int i = 0; i < 2000 && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState before = bases().ready;
    const Facts facts = set_faults(before, dice);
    const Detail detail = set_details(before, facts, dice);
    const FaultBits some = dice.chance(0.5) ? some_faults(dice) : before.latched & some_faults(dice);
    CoreState state = before;
    const Told cleared(state);
    clear_latched(state, some);
    EXPECT_EQ(state.latched, before.latched & ~some);
    Codes codes = before.fault_codes;
    keep_rule(codes, detail, state.latched, 0, before.in_mode.ticks);
    expect_codes(state, codes);
    expect_told(cleared, 0, before.latched & some, codes, detail);
    CoreState anew = before;
    const Told raised(anew);
    restore_latched(anew, some);
    EXPECT_EQ(anew.latched, some);
    expect_told(raised, some, 0, before.fault_codes, detail);
  }
}

TEST(SuperviseFaults, ADriveIsInItsFaultAsLongAsItIsHeard) {
  for (const auto& [status, fault] :
       {std::pair<std::uint16_t, bool>{0x40, false}, {0x27, false}, {0x07, false}, {0x08, true}, {0x0F, true}})
    for (const std::size_t late : {0U, 4U, 5U}) {
      DriveSensor drive;
      static_cast<void>(drive.take_state(drive_state(status), 1e9));
      wait(drive, late);
      EXPECT_EQ(drive_in_fault(drive), fault && late < 5) << status << ' ' << late;
    }
}

}  // namespace
}  // namespace hoist::core::test::supervise
