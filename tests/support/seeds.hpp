// How many seeds a property is tried with.
#pragma once
#include <cstdlib>

namespace hoist::tests {

/// Long proofs in full (HOIST_THOROUGH, set by `deploy/dev check`), or the share of them that finds a break while one works on it.
inline bool thorough() { return std::getenv("HOIST_THOROUGH") != nullptr; }  // NOLINT(concurrency-mt-unsafe): nothing sets it meanwhile

/// `n` in the normal tree. Under sanitizers everything takes ten times as long, and they look for other mistakes than more seeds find:
/// `sanitized` there.
constexpr int seeds_for([[maybe_unused]] int n, [[maybe_unused]] int sanitized) {
#ifdef HOIST_SANITIZED
  return sanitized;
#else
  return n;
#endif
}

}  // namespace hoist::tests
