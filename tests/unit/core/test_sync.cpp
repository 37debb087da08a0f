// Synchronisation with other recording systems: the pulses out, the edges in.
#include <gtest/gtest.h>

#include <vector>

#include "control/core/output/sync_pulses.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

using contract::EventKind;
namespace canopen = contract::canopen;

std::vector<contract::Event> edges(const ScriptedHoist& hoist) {
  std::vector<contract::Event> told;
  for (const contract::Event& event : hoist.events)
    if (event.kind == EventKind::sync_input) told.push_back(event);
  return told;
}

struct Pulse {
  std::uint64_t begin, length;
};
// What another system records of the output: the pulses in its own time, steps of 10 ms from anywhere.
std::vector<Pulse> pulses(ScriptedHoist& hoist, int steps) {
  std::vector<Pulse> seen;
  bool level = hoist.out.record.sync_output != 0, whole = false;
  for (int i = 0; i < steps; ++i) {
    hoist.step();
    for (const contract::CanFrame& frame : hoist.sent) {
      if (frame.id != contract::pdo_cob_id(contract::Pdo::io_rx1, contract::Node::io)) continue;
      const bool now = (frame.data[0] & canopen::kSyncOutput) != 0;
      if (now && !level) seen.push_back({static_cast<std::uint64_t>(i), 0}), whole = true;
      if (!now && level && whole) seen.back().length = static_cast<std::uint64_t>(i) - seen.back().begin;
      level = now;
    }
    EXPECT_EQ(hoist.out.record.sync_output, level ? 1 : 0) << "the record tells what was sent";
  }
  if (!seen.empty() && seen.back().length == 0) seen.pop_back();
  return seen;
}

TEST(SyncPulses, ThirtyTwoSecondsOfTheLineSayWhichStepsTheyWere) {
  for (const std::uint64_t start : {std::uint64_t{3}, std::uint64_t{777'777}, std::uint64_t{52'428'799 - 5000}}) {
    ScriptedHoist hoist;
    hoist.tick_number = start;
    ASSERT_TRUE(hoist.to_standby());
    const std::uint64_t first_step = hoist.tick_number + 1;
    const std::vector<Pulse> seen = pulses(hoist, 3300);
    ASSERT_GE(seen.size(), 31U);
    std::size_t mark = 0;
    while (mark < seen.size() && seen[mark].length != 80) ++mark;
    ASSERT_LT(mark + 16, seen.size());
    std::uint64_t group = 0;
    for (std::size_t digit = 1; digit < 16; ++digit) {
      EXPECT_EQ(seen[mark + digit].begin - seen[mark].begin, digit * 100);
      ASSERT_TRUE(seen[mark + digit].length == 50 || seen[mark + digit].length == 20) << seen[mark + digit].length;
      if (seen[mark + digit].length == 50) group |= std::uint64_t{1} << (digit - 1);
    }
    EXPECT_EQ(seen[mark + 16].length, 80U);
    const std::uint64_t step = first_step + seen[mark].begin;
    EXPECT_GE(step, group * 1600);
    EXPECT_LE(step, group * 1600 + 4) << "a frame goes each fifth step";
  }
}

TEST(SyncInput, EachEdgeIsAnEventOfItsStep) {
  ScriptedHoist hoist;
  hoist.io.switches = canopen::kSyncInput;
  ASSERT_TRUE(hoist.to_standby());
  EXPECT_TRUE(edges(hoist).empty()) << "where the line begins is no edge";
  hoist.io.switches = 0;
  hoist.step(10);
  hoist.io.switches = canopen::kSyncInput;
  const std::uint64_t before = hoist.tick_number;
  hoist.step(10);
  const auto told = edges(hoist);
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[0].code, 0U);
  EXPECT_EQ(told[1].code, 1U);
  EXPECT_EQ(told[1].tick, before + 1);
  EXPECT_EQ(hoist.out.record.switches, canopen::kSyncInput);
  hoist.io.switches |= 0x0A;
  hoist.step(10);
  EXPECT_EQ(edges(hoist).size(), 2U) << "other switches are no edges";
}

TEST(SyncInput, ALineThatNeverRestsDoesNotFillTheLog) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.to_standby());
  for (int i = 0; i < 1000; ++i) {
    hoist.io.switches ^= canopen::kSyncInput;
    hoist.step();
  }
  EXPECT_GE(edges(hoist).size(), 20U);
  EXPECT_LE(edges(hoist).size(), 20U + 1000 / 50);
  // After a rest the first edges are told again.
  hoist.step(1000);
  const std::size_t so_far = edges(hoist).size();
  hoist.io.switches ^= canopen::kSyncInput;
  hoist.step(2);
  EXPECT_EQ(edges(hoist).size(), so_far + 1);
}

}  // namespace
}  // namespace hoist::core::test
