// Random sessions with one change to core or nodes in force (tests/mutants/mutate.py or plant.py), until the judge fails one.
//   HOIST_MUTANT=N           the number from the generator's list; none without it
//   --sessions FIRST LAST    seeds
// Prints the seed that failed and its first violation, and ends with 1; with 0 when no session failed.
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/chaos/session.hpp"
#include "tests/mutants/mutant_switch.hpp"

int main(int argc, char** argv) {
  if (const char* number = std::getenv("HOIST_MUTANT")) hoist_mutants::chosen = std::atoi(number);
  if (argc != 4 || std::strcmp(argv[1], "--sessions") != 0) {
    std::fputs("chaos_mutants --sessions FIRST LAST\n", stderr);
    return 2;
  }
  const unsigned long long last = std::strtoull(argv[3], nullptr, 10);
  for (unsigned long long seed = std::strtoull(argv[2], nullptr, 10); seed <= last; ++seed) {
    const hoist::chaos::SessionReport report = hoist::chaos::run_session({.seed = seed, .storage = false});
    if (report.broken.empty()) continue;
    std::printf("%llu\t%s\n", seed, report.broken.front().c_str());
    return 1;
  }
  return 0;
}
