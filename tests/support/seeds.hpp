// How many seeds a property is tried with.
#pragma once
#include <cstdlib>

namespace hoist::tests {

/// Long tests in full (HOIST_THOROUGH, set by `deploy/dev check`), or a share of them for everyday runs.
inline bool thorough() { return std::getenv("HOIST_THOROUGH") != nullptr; }  // NOLINT(concurrency-mt-unsafe): nothing sets it meanwhile

/// `in_full` in the thorough run, `everyday` otherwise. Under sanitizers everything takes ten times as long, and they look for other mistakes than
/// more seeds find: `few` there, and where a mutant is to be noticed, for which a test may take a second (tests/mutants).
inline int seeds_for([[maybe_unused]] int in_full, [[maybe_unused]] int everyday, [[maybe_unused]] int few) {
#if defined(HOIST_SANITIZED) || defined(HOIST_MUTANTS)
  return few;
#else
  return thorough() ? in_full : everyday;
#endif
}

/// As many as the environment variable NAME says, for a measurement; `otherwise` without it.
inline int asked_for(const char* name, int otherwise) {
  const char* asked = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): nothing sets it meanwhile
  const int n = asked != nullptr ? std::atoi(asked) : 0;
  return n > 0 ? n : otherwise;
}

}  // namespace hoist::tests
