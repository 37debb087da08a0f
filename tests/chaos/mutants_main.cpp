// Random sessions with one change to core or nodes in force (tests/mutants/mutate.py), until the judge fails one.
//   HOIST_MUTANT=N   the number from mutate.py's list; none without it
//   --sessions N     at most so many, from seed 1 on
// Prints how many it took and the first violation, and ends with 1; with 0 when no session failed.
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/chaos/session.hpp"
#include "tests/mutants/mutant_switch.hpp"

int main(int argc, char** argv) {
  if (const char* number = std::getenv("HOIST_MUTANT")) hoist_mutants::chosen = std::atoi(number);
  const unsigned long long most = argc == 3 && std::strcmp(argv[1], "--sessions") == 0 ? std::strtoull(argv[2], nullptr, 10) : 0;
  if (most == 0) {
    std::fputs("chaos_mutants --sessions N\n", stderr);
    return 2;
  }
  for (unsigned long long seed = 1; seed <= most; ++seed) {
    const hoist::chaos::SessionReport report = hoist::chaos::run_session({.seed = seed, .storage = false});
    if (report.broken.empty()) continue;
    std::printf("%llu\t%s\n", seed, report.broken.front().c_str());
    return 1;
  }
  return 0;
}
