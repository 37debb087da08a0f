// The bus's load and response times: the computation against figures from another program and from simulation (SOURCES
// 4), and the present tables against the limits of the plan.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <string>

#include "control/contract/bus_load.hpp"
#include "deploy/tools/gen/bus_load.hpp"

namespace hoist::contract {
namespace {

double rounded_ms(const BusPlan& plan, std::size_t which, const BusConditions& conditions) {
  const auto bits = response_bits(plan, which, conditions);
  return bits ? std::round(100.0 * bits_ms(*bits)) / 100.0 : -1.0;
}
std::size_t at(const BusPlan& plan, std::uint32_t id) {
  for (std::size_t i = 0; i < plan.size; ++i)
    if (plan.frames[i].id == id) return i;
  ADD_FAILURE() << "no frame " << std::hex << id;
  return 0;
}

// The frames of that computation: without those added to the tables since.
BusPlan research_plan() {
  const std::set<std::uint32_t> ids = {0x080, 0x081, 0x082, 0x088, 0x091, 0x092, 0x093, 0x181, 0x182, 0x188, 0x191, 0x192, 0x193,
                                       0x201, 0x202, 0x281, 0x282, 0x288, 0x580, 0x701, 0x702, 0x708, 0x711, 0x712, 0x713, 0x77F};
  const BusPlan now = bus_plan(SwitchedPdos::none);
  BusPlan plan;
  for (const BusFrame& f : now)
    if (ids.count(f.id) != 0) {
      plan.frames[plan.size] = f;
      // There the computer's heartbeat came as often as a node's.
      if (f.id == 0x77F) plan.frames[plan.size].period *= 2;
      ++plan.size;
    }
  EXPECT_EQ(plan.size, ids.size());
  return plan;
}

TEST(BusLoad, WorstFramesAreThoseOfTheLiterature) {
  const std::array<std::uint64_t, 9> worst = {55, 65, 75, 85, 95, 105, 115, 125, 135}, plain = {47, 55, 63, 71, 79, 87, 95, 103, 111};
  for (std::size_t bytes = 0; bytes <= 8; ++bytes) {
    EXPECT_EQ(worst_frame_bits(bytes), worst[bytes]);
    EXPECT_EQ(plain_frame_bits(bytes), plain[bytes]);
  }
}

TEST(BusLoad, ReproducesTheResearchedLoad) {
  const BusPlan plan = research_plan();
  EXPECT_NEAR(100 * bus_load(plan, false).worst, 46.8, 0.05);
  EXPECT_NEAR(100 * bus_load(plan, false).plain, 38.7, 0.05);
  EXPECT_NEAR(bus_load(plan, false).frames_per_s, 1080, 0.5);
  EXPECT_NEAR(100 * bus_load(plan, true).worst, 71.8, 0.05);
  EXPECT_NEAR(100 * bus_load(plan, true).plain, 59.3, 0.05);
  EXPECT_NEAR(bus_load(plan, true).frames_per_s, 1543, 0.5);
}

TEST(BusLoad, ReproducesTheResearchedResponseTimes) {
  struct Row {
    std::uint32_t id;
    double quiet, storm, errors;
  };
  const BusPlan plan = research_plan();
  for (const Row& row :
       {Row{0x080, 1.26, 1.26, 1.92},   Row{0x081, 0, 1.30, 1.96},      Row{0x082, 0, 1.84, 2.50},      Row{0x088, 0, 2.38, 3.04},
        Row{0x091, 0, 2.92, 3.58},      Row{0x092, 0, 3.46, 4.12},      Row{0x093, 0, 4.00, 4.66},      Row{0x181, 2.30, 5.54, 6.20},
        Row{0x182, 2.84, 6.08, 6.74},   Row{0x188, 2.14, 5.38, 6.04},   Row{0x191, 3.60, 6.84, 7.50},   Row{0x192, 4.06, 7.30, 7.96},
        Row{0x193, 4.52, 7.76, 8.42},   Row{0x201, 5.98, 9.22, 9.88},   Row{0x202, 6.44, 9.68, 10.34},  Row{0x281, 5.98, 9.22, 14.45},
        Row{0x282, 6.52, 13.66, 14.99}, Row{0x288, 7.06, 14.20, 15.53}, Row{0x580, 6.32, 13.46, 14.79}, Row{0x701, 9.20, 18.50, 26.55},
        Row{0x77F, 16.02, 25.86, 28.39}}) {
    const std::size_t i = at(plan, row.id);
    if (row.quiet != 0) {
      EXPECT_DOUBLE_EQ(rounded_ms(plan, i, {false, false, true}), row.quiet) << std::hex << row.id;
    }
    EXPECT_DOUBLE_EQ(rounded_ms(plan, i, {true, false, true}), row.storm) << std::hex << row.id;
    EXPECT_DOUBLE_EQ(rounded_ms(plan, i, {true, true, true}), row.errors) << std::hex << row.id;
  }
}

TEST(BusLoad, TheTablesOfTodayKeepTheLimitsOfThePlan) {
  const BusPlan plan = bus_plan();
  EXPECT_LE(bus_load(plan, true).worst, 0.80);
  for (std::size_t i = 0; i < plan.size; ++i) {
    const BusFrame& f = plan.frames[i];
    const auto quiet = response_bits(plan, i, {false, false, true}), worst = response_bits(plan, i, {true, true, true});
    ASSERT_TRUE(quiet && worst) << f.what;
    // Service frames follow each other: the limit is their client's retry time.
    EXPECT_LE(*quiet, f.kind == FrameKind::service ? f.deadline : f.period) << f.what;
    EXPECT_LE(*worst, f.deadline) << f.what;
  }
}

TEST(BusLoad, AllThreeSensorsMaySendTheirRates) {
  const BusPlan plan = bus_plan(SwitchedPdos::all);
  EXPECT_EQ(plan.size, bus_plan().size + kPdosOff.size());
  EXPECT_LE(bus_load(plan, false).worst, 0.80);
  EXPECT_LE(bus_load(plan, true).worst, 1.0);
  for (std::size_t i = 0; i < plan.size; ++i) {
    const BusFrame& f = plan.frames[i];
    const auto quiet = response_bits(plan, i, {false, false, true}), no_service = response_bits(plan, i, {true, true, false}),
               worst = response_bits(plan, i, {true, true, true});
    ASSERT_TRUE(quiet && no_service && worst) << f.what;
    EXPECT_LE(*quiet, f.kind == FrameKind::service ? f.deadline : f.period) << f.what;
    EXPECT_LE(*no_service, f.deadline) << f.what;
    // All worst cases together cost the heartbeats only the tolerance of one lost frame.
    if (f.kind != FrameKind::heartbeat) {
      EXPECT_LE(*worst, f.deadline) << f.what;
    }
    if (f.kind == FrameKind::heartbeat) {
      EXPECT_LE(*worst, f.deadline + f.period) << f.what;
    }
  }
}

// Mailboxes instead of an object for each identifier make frames later, but none so late that its absence is acted upon.
TEST(BusLoad, ThreeMailboxesKeepTheDeadlines) {
  constexpr BusConditions kWorst{true, true, true};
  const BusPlan plan = bus_plan();
  for (std::size_t i = 0; i < plan.size; ++i) {
    const auto bits = response_bits(plan, i, kWorst), wait = mailbox_wait_bits(plan, i, kWorst);
    ASSERT_TRUE(bits && wait) << plan.frames[i].what;
    EXPECT_LE(*bits + *wait, plan.frames[i].deadline) << std::hex << plan.frames[i].id;
  }
  // 181h waits for 281h, and for one frame that was in its mailbox first; 293h has no lower PDO on its board.
  EXPECT_EQ(mailbox_wait_bits(plan, at(plan, 0x181), kWorst), *response_bits(plan, at(plan, 0x281), kWorst) + worst_frame_bits(8));
  EXPECT_EQ(mailbox_wait_bits(plan, at(plan, 0x293), kWorst), worst_frame_bits(8));
  EXPECT_EQ(mailbox_wait_bits(plan, at(plan, 0x080), kWorst), 0U);
}

// A longer or more frequent frame must delay others; this shows that the test of the limits can fail.
TEST(BusLoad, TooMuchIsFound) {
  BusPlan plan = bus_plan();
  for (std::size_t i = 0; i < plan.size; ++i)
    if (plan.frames[i].kind == FrameKind::process) plan.frames[i].period = std::min(plan.frames[i].period, 5 * kBitsPerMs);
  EXPECT_GT(bus_load(plan, true).worst, 1.0);
  EXPECT_FALSE(response_bits(plan, plan.size - 1, {false, false, true}).has_value());
  BusPlan late = bus_plan();
  const auto before = *response_bits(late, at(late, 0x202), {false, false, true});
  late.frames[at(late, 0x201)].bytes = 8;
  EXPECT_EQ(*response_bits(late, at(late, 0x202), {false, false, true}), before + 20);
}

TEST(BusLoad, ThePageShowsEveryFrame) {
  const std::string page = gen::bus_load_page();
  for (const BusFrame& f : bus_plan(SwitchedPdos::all)) {
    char id[16];
    std::snprintf(id, sizeof id, "| %03X |", f.id);
    if (f.kind != FrameKind::service) {
      EXPECT_NE(page.find(id), std::string::npos) << id;
    }
  }
  EXPECT_EQ(page.find("no bound"), std::string::npos);
}

}  // namespace
}  // namespace hoist::contract
