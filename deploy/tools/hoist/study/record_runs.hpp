// The runs of a study, walked by virtual subjects and recorded as any session is.
#pragma once

#include <cstdint>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "deploy/tools/hoist/study/protocol.hpp"

namespace hoist::tool::study {

/// Subjects 1 to `subjects`, each with the runs and the order of the protocol. The same seed gives the same recordings. Uses two threads.
[[nodiscard]] db::Status walk_all(db::Database& database, const Protocol& protocol, int subjects, std::uint64_t seed);

}  // namespace hoist::tool::study
