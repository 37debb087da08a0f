// The runs of a study, walked by virtual subjects and recorded as any session is.
#pragma once

#include <cstdint>
#include <functional>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_writer.hpp"
#include "db/store/studies.hpp"
#include "deploy/tools/hoist/study/protocol.hpp"
#include "deploy/tools/hoist/study/virtual_run.hpp"

namespace hoist::tool::study {

/// 2026-01-05 08:00 UTC: without another begin, the same study gives the same file.
inline constexpr std::int64_t kUsualBegin_ns = 1'767'600'000'000'000'000;

struct StudyRequest {
  int subjects = 1;        ///< 1 to kMostSubjects
  std::uint64_t seed = 1;  ///< the same seed gives the same recordings
  /// Wall clock of the first session. Each one begins five minutes after the one before: nobody walks in virtual time.
  std::int64_t begin_utc_ns = kUsualBegin_ns;
  std::function<void(int done, int all)> progress = {};  ///< after each run
};

/// One run as a session, and its number. `start` says date, note and exercise; the rest of it is of the run, which has records.
[[nodiscard]] db::Result<db::SessionId> record_run(db::SessionWriter& writer, const VirtualRun& run, db::SessionStart start);

/// Subjects 1 to `subjects`, each with the runs and the order of the protocol, as sessions of a new study of `database`; finish_study is the
/// caller's. Uses two threads.
[[nodiscard]] db::Result<db::StudyId> walk_all(db::Database& database, const Protocol& protocol, const StudyRequest& request);

}  // namespace hoist::tool::study
