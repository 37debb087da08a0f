// The runs of a study, walked by virtual subjects and recorded as any session is.
#pragma once

#include <cstdint>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_writer.hpp"
#include "deploy/tools/hoist/study/protocol.hpp"
#include "deploy/tools/hoist/study/virtual_run.hpp"

namespace hoist::tool::study {

/// One run as a session. `start` says subject, date, note and exercise; the rest of it is of the run. A run without records is none.
[[nodiscard]] db::Status record_run(db::SessionWriter& writer, const VirtualRun& run, db::SessionStart start);

/// Subjects 1 to `subjects`, each with the runs and the order of the protocol. The same seed gives the same recordings. Uses two threads.
[[nodiscard]] db::Status walk_all(db::Database& database, const Protocol& protocol, int subjects, std::uint64_t seed);

}  // namespace hoist::tool::study
