// Runs a recorded session again: the same core, given what each step was given. For `hoist verify`, `hoist replay` and the tests.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "control/contract/signals.hpp"
#include "db/store/session_reader.hpp"
#include "deploy/tools/hoist/parameter_change.hpp"

namespace hoist::tool {

/// Ticks (inclusive) that could not be run again, and why.
struct NotRun {
  std::uint64_t from_tick = 0, to_tick = 0;
  std::string reason;
};

/// A step that was run again. `row` is as stored_row gives it; `recorded` is empty when the session has no sample of this tick.
struct RerunStep {
  std::uint64_t tick = 0, time_ns = 0;
  bool same_bits = false;  ///< the whole record has the digest that hoist-control had published
  std::span<const std::int64_t> row, recorded;
};

struct RerunReport {
  std::uint64_t steps = 0;                     ///< run again
  std::uint64_t samples = 0, samples_run = 0;  ///< that are stored, and those of them whose step was run again
  std::vector<NotRun> not_run;
};

/// Calls `see` for each step that can be run. The core begins with the first stored image, and after each hole with the next one; `changes` come
/// into force there. Errors: not_found, wrong_state (no journal, or recorded by another build than `program`), bad_value (the changed set
/// contradicts itself), corrupt, io (no confined child process). The file is not trusted: the core runs it in a child process that can do
/// nothing but compute.
db::Result<RerunReport> rerun(db::Database& database, db::SessionId session, std::string_view program,
                              std::span<const ParameterChange> changes, const std::function<void(const RerunStep&)>& see);

struct Difference {
  std::uint64_t tick = 0, time_ns = 0;
  std::string signal;  ///< empty: below the resolution with which samples are stored
  double recorded = 0, again = 0;
};
struct Verification {
  RerunReport run;
  std::uint64_t different = 0;      ///< steps
  std::optional<Difference> first;  ///< absent: every field of every step that was run is the same
  [[nodiscard]] bool whole() const { return !first && run.samples_run == run.samples; }
};
/// Errors: as rerun.
db::Result<Verification> verify_session(db::Database& database, db::SessionId session, std::string_view program);

}  // namespace hoist::tool
