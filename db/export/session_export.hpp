// A session in one of the formats of formats.def, piece by piece, so that memory stays constant.
#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "db/export/formats.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

class SessionExport {
 public:
  /// Errors: not_found, bad_value (field columns).
  static Result<SessionExport> open(Database& database, SessionId session, const ExportOptions& options = {});
  SessionExport(SessionExport&&) noexcept;
  SessionExport& operator=(SessionExport&&) noexcept;
  ~SessionExport();

  /// Replaces `out` by the next piece (usually below 100 kB, perhaps empty: the work of one call is short). False at the end, with `out`
  /// empty. After an error the export is over.
  Result<bool> next_chunk(std::string& out);
  [[nodiscard]] SessionId session() const;
  /// A strong entity tag: two exports with the same one have the same bytes.
  [[nodiscard]] std::string etag() const;
  [[nodiscard]] std::string content_type() const;
  /// Such as hoist_session_12.csv.
  [[nodiscard]] std::string file_name() const;

 private:
  struct State;
  explicit SessionExport(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// "a,b" as asked on a command line or in a query: one name per comma, an empty one where there is none.
std::vector<std::string> column_names(std::string_view text);

}  // namespace hoist::db
