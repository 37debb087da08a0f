// Every hazard that has a budget is answered within it, and the committed page does not say better than it is.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "tests/reactions/reactions.hpp"

namespace hoist::reactions {
namespace {

// Fewer than behind the page: each is one of those.
constexpr int kTries = 4;

TEST(Reactions, EveryFaultIsAnsweredWithinItsBudgetAndAsThePageSays) {
  std::ifstream in(std::string(HOIST_SOURCE_DIR) + "/" + std::string(kPage), std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  for (const Reaction& row : measure(kTries)) {
    SCOPED_TRACE(row.hazard + ": " + row.fault);
    EXPECT_EQ(row.missed, 0) << "tries without a stop";
    EXPECT_LE(row.worst_ms, row.budget_ms);
    const Reaction told = read_row(text, row.fault);
    ASSERT_EQ(told.tries, 1) << "not on the page: deploy/dev trace --write";
    EXPECT_EQ(told.budget_ms, row.budget_ms);
    // One step more or less is another moment of the stride, not another answer.
    EXPECT_LE(row.worst_ms, told.worst_ms + 10);
    EXPECT_LE(row.stopped_ms, told.stopped_ms + 100);
    EXPECT_LE(row.distance_cm, told.distance_cm + 3);
  }
}

}  // namespace
}  // namespace hoist::reactions
