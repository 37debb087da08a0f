// hoist sessions: what a database holds, one JSON object per line, newest first.
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "db/store/session_reader.hpp"
#include "db/summary/session_json.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/recording_file.hpp"

namespace hoist::tool {

int run_sessions(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs("usage: hoist sessions DB\n\nOne line of JSON per recorded session, newest first, with the names of GET /api/v1/sessions.\n",
               stdout);
    return kDone;
  }
  if (arguments.size() != 1) return bad_usage("sessions", "name a database");
  db::Result<db::Database> database = db::Database::attach(std::string(arguments[0]));
  if (!database) return refuse("sessions", database.error());
  const db::SessionReader reader(*database);
  db::SessionQuery query;
  query.limit = db::kMaxPage;
  query.standby = true;
  do {
    const db::Result<db::SessionPage> page = reader.list(query);
    if (!page) return refuse("sessions", page.error());
    for (const db::SessionInfo& session : page->sessions)
      std::printf("%s\n", db::session_json(session).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
    query.before = page->next;
  } while (query.before);
  return kDone;
}

}  // namespace hoist::tool
