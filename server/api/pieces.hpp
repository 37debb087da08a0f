// What takes long to read, in pieces on the recorder's thread: between two of them it stores what the core publishes and others get their answers.
#pragma once
#include <functional>
#include <memory>
#include <utility>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "server/api/answers.hpp"

namespace hoist::server::api {

/// The database, for one piece of work on the recorder's thread. Errors: busy while the recorder is behind; io where it could not be opened.
[[nodiscard]] db::Result<db::Database*> database_for_piece(Records& records);

namespace detail {
template <typename Reading, typename Done>
void read_next(const CallPtr& call, std::shared_ptr<Reading> reading, Done done) {
  const auto piece = [reading](Records& records) -> db::Result<bool> {
    const auto database = database_for_piece(records);
    return database ? reading->piece(**database) : db::Result<bool>(database.error());
  };
  ask_recorder<db::Result<bool>>(call, piece, [call, reading, done = std::move(done)](db::Result<bool> more) mutable {
    if (!more) return done(more.error());
    if (*more) return read_next(call, std::move(reading), std::move(done));
    done(reading->take());
  });
}
}  // namespace detail

/// Gives what a reading of this session yields, or its error. `Reading` holds nothing of the database between two pieces (db::MetricsReading).
template <typename Reading>
void read_in_pieces(const CallPtr& call, db::SessionId session,
                    std::function<void(db::Result<decltype(std::declval<Reading&>().take())>)> done) {
  using Opened = db::Result<std::shared_ptr<Reading>>;
  const auto open = [session](Records& records) -> Opened {
    const auto database = database_for_piece(records);
    if (!database) return database.error();
    auto reading = Reading::open(**database, session);
    return reading ? Opened(std::make_shared<Reading>(std::move(*reading))) : Opened(reading.error());
  };
  ask_recorder<Opened>(call, open, [call, done = std::move(done)](Opened opened) {
    if (!opened) return done(opened.error());
    detail::read_next(call, std::move(*opened), done);
  });
}

}  // namespace hoist::server::api
