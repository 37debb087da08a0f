// The judge keeps its teeth: for every monitor each session of masks.tsv fails while that monitor is off, and passes while it is on.
#include <gtest/gtest.h>

#include <string>

#include "control/contract/faults.hpp"
#include "tests/chaos/masks.hpp"
#include "tests/chaos/session.hpp"
#include "tests/chaos/shrink.hpp"

namespace hoist::chaos {
namespace {

TEST(ChaosMasks, EveryMonitorThatIsOffIsFound) {
  const std::vector<KnownMask> rows = read_masks(HOIST_SOURCE_DIR "/tests/chaos/masks.tsv");
  for (const contract::Fault fault : masks()) {
    const std::string name(contract::fault_info(fault).name);
    int found = 0;
    for (const KnownMask& row : rows) {
      if (row.monitor != name) continue;
      ++found;
      const std::string words = name + " in " + replay_words(row.session);
      const SessionReport whole = run_session(row.session);
      EXPECT_TRUE(whole.broken.empty()) << words << " fails with every monitor on: " << whole.broken.front();
      EXPECT_TRUE(fails_masked(fault, row.session)) << "nobody notices that it is off: " << words;
    }
    EXPECT_GT(found, 0) << "masks.tsv has no session for " << name << "; deploy/dev chaos --masks finds one";
  }
}

}  // namespace
}  // namespace hoist::chaos
