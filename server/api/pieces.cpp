#include "server/api/pieces.hpp"

namespace hoist::server::api {

db::Result<db::Database*> database_for_piece(Records& records) {
  if (records.late()) return db::Error{db::ErrorKind::busy, "The recorder is busy. Try again in a moment.", {}};
  if (db::Database* database = records.database()) return database;
  return db::Error{db::ErrorKind::io, records.why(), {}};
}

}  // namespace hoist::server::api
