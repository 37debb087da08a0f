// The rows of jobs.def.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "control/contract/params.hpp"

namespace hoist::server {

enum class JobKind : std::uint8_t {
#define HOIST_JOB(name, role, doc) name,
#include "server/contract/jobs.def"
#undef HOIST_JOB
};

struct JobKindInfo {
  std::string_view name;
  contract::Role role;
};
inline constexpr std::array kJobKinds{
#define HOIST_JOB(name, role, doc) JobKindInfo{#name, contract::Role::role},
#include "server/contract/jobs.def"
#undef HOIST_JOB
};
// Whether a deletion must interrupt it (Jobs::hold). A study reads the recordings for moments only, and it would begin again from its start.
constexpr bool gives_way_to_deletion(JobKind kind) { return kind != JobKind::study && kind != JobKind::study_recorded; }
// Whether what it has made of sessions is kept in memory or in a file, so that it must go with them (Jobs::forget_recordings).
constexpr bool keeps_recordings(JobKind kind) { return kind == JobKind::export_sessions || kind == JobKind::recompute_metrics; }
constexpr const JobKindInfo& job_kind_info(JobKind kind) { return kJobKinds[static_cast<std::size_t>(kind)]; }
constexpr std::optional<JobKind> find_job_kind(std::string_view name) {
  for (std::size_t i = 0; i < kJobKinds.size(); ++i)
    if (kJobKinds[i].name == name) return static_cast<JobKind>(i);
  return std::nullopt;
}

}  // namespace hoist::server
