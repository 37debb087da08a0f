// What jobs that delete sessions share.
#pragma once
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::server {
struct JobTools;
}

namespace hoist::server::job {

// Whole: it is soon done. Between two pieces others have the file for as long as a piece took. A session that is gone already is no error.
db::Status delete_session(const JobTools& tools, db::Database& database, db::SessionId session);

}  // namespace hoist::server::job
