// The judge keeps its teeth: for every monitor the session of masks.tsv fails while that monitor is off, and passes while it is on.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "control/contract/faults.hpp"
#include "tests/chaos/masks.hpp"
#include "tests/chaos/session.hpp"

namespace hoist::chaos {
namespace {

TEST(ChaosMasks, EveryMonitorThatIsOffIsFound) {
  const std::vector<KnownMask> rows = read_masks(HOIST_SOURCE_DIR "/tests/chaos/masks.tsv");
  for (const contract::Fault fault : masks()) {
    const std::string name(contract::fault_info(fault).name);
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const KnownMask& r) { return r.monitor == name; });
    if (row == rows.end()) {
      ADD_FAILURE() << "masks.tsv has no session for " << name << "; deploy/dev chaos --masks finds one";
      continue;
    }
    const SessionReport whole = run_session(row->session);
    EXPECT_TRUE(whole.broken.empty()) << name << ": its session fails with every monitor on: " << whole.broken.front();
    EXPECT_TRUE(fails_masked(fault, row->session))
        << "nobody notices in its session that " << name << " is off; deploy/dev chaos --masks finds another";
  }
}

}  // namespace
}  // namespace hoist::chaos
