// Who asks for an action, and what came of it.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "control/contract/faults.hpp"
#include "server/contract/reasons.hpp"
#include "server/jobs/jobs.hpp"
#include "server/text/field_error.hpp"

namespace hoist::server {

struct Outcome {
  enum class Kind : std::uint8_t { done, refused, invalid, unknown, outdated, unreachable };
  Kind kind = Kind::done;
  std::vector<std::string> refusals;  // names of the refusal table
  std::vector<FieldError> errors;
  std::string detail;
  std::optional<Reason> reason;  // where `kind` does not say it all
  std::uint32_t epoch = 0;       // of a lease just taken
  JobId job = 0;                 // of a job just started
  std::optional<bool> stored;    // of a change of settings: false = in force, and lost at the next start unless the disk takes it later
  std::string row;               // of a change of a stored row: the row as it is now, JSON
  [[nodiscard]] bool done() const { return kind == Kind::done; }
};
[[nodiscard]] Reason reason_of(const Outcome& outcome);
using OutcomeDone = std::function<void(const Outcome&)>;

// Who asks: the number the core knows, the lease epoch it believes, the role.
struct Asker {
  std::uint32_t client = 0;
  std::uint32_t epoch = 0;
  contract::Role role = contract::Role::viewer;
  bool over = false;                  // its sign-in has run out: it may go on with what it holds and end it, and begin nothing
  std::shared_ptr<bool> logged = {};  // set when an action writes the audit log for this request; may be null
  // Only of what begins motion or leaves a stop: the time_ns of the newest step that its sender had seen (contract::put_echo), 0 = not told.
  std::uint64_t echo_time_ns = 0;
  bool gone = false;  // the end of its connection has been read: it begins no motion and leaves no stop
};

}  // namespace hoist::server
