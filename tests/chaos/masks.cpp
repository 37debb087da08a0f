#include "tests/chaos/masks.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <fstream>
#include <mutex>
#include <sstream>
#include <thread>
#include <utility>

#include "control/core/base/mutation.hpp"
#include "control/core/monitor/monitor_list.hpp"
#include "tests/chaos/session.hpp"
#include "tests/chaos/shrink.hpp"

namespace hoist::chaos {

namespace {

class Off {
 public:
  explicit Off(contract::Fault fault) { core::mutation::off_bits = contract::fault_bit(fault); }
  ~Off() { core::mutation::off_bits = 0; }
  Off(const Off&) = delete;
  Off& operator=(const Off&) = delete;
};

}  // namespace

std::vector<contract::Fault> masks() {
  // No rule of the judge asks for the alarm of a lost console; test_mutants switches this one off, too.
  constexpr auto kNotHere = contract::fault_bit(contract::Fault::console_lost);
  std::vector<contract::Fault> all;
  for (const contract::FaultInfo& fault : contract::kFaults)
    if (((core::kRaisedDirectly | kNotHere) & contract::fault_bit(fault)) == 0) all.push_back(static_cast<contract::Fault>(fault.bit));
  return all;
}

MaskResult run_masked(contract::Fault fault, std::uint64_t first, std::uint64_t most, unsigned jobs) {
  const Off off(fault);
  MaskResult result;
  std::atomic<std::uint64_t> next{0}, found{most};
  std::mutex mutex;
  const auto work = [&] {
    // In order: the first seed that fails is the same however many threads there are.
    for (std::uint64_t i = next++; i < most && i < found; i = next++) {
      SessionReport report = run_session({.seed = first + i, .storage = false});
      if (report.broken.empty()) continue;
      const std::lock_guard lock(mutex);
      if (i >= found) continue;
      found = i;
      result.found = std::move(report);
    }
  };
  std::vector<std::thread> threads;
  for (unsigned i = 1; i < jobs; ++i) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  result.sessions = std::min(found + 1, most);
  if (result.found) {
    const double length_s = std::max(15.0, std::ceil(result.found->broken_s + 1.0));
    result.replay =
        replay_words({.seed = result.found->seed, .length_s = length_s, .faults = result.found->faults, .patient = result.found->patient});
  }
  return result;
}

bool fails_masked(contract::Fault fault, const SessionOptions& session) {
  const Off off(fault);
  return !run_session(session).broken.empty();
}

std::vector<KnownMask> read_masks(const std::string& path) {
  std::vector<KnownMask> rows;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    KnownMask row;
    words >> row.monitor >> std::ws;
    std::string replay;
    std::getline(words, replay, '\t');
    std::optional<SessionOptions> session = read_replay(replay);
    if (!session) continue;
    row.session = *session;
    row.session.storage = false;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace hoist::chaos
