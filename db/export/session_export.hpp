// A session as CSV or JSON, piece by piece, so that nobody holds an hour in memory. Numbers are the stored integers, printed with their
// decimal point: no floating point takes part.
//
// CSV: lines starting with '#' (provenance.hpp; the last two say each column's direction and unit), one row of column names, one row per sample:
//   utc, time_s, gap_before, then the columns of the session. gap_before is 1 when samples are missing before the row.
//   Every line is a record of RFC 4180. A text with '#' is quoted, so that a reader that drops comments keeps it.
// Events as CSV: '#' lines, names, then one row per event or marker. Texts are quoted and cannot start a formula.
// JSON: {"session": …, "directions", "columns": [{"name", "unit", "lsb", "axis"}], "rows": n, "data": {"time_s": […], …}, "gaps": …,
//   "events": …, "markers": …, "parameters": …}
// candump: the raw frames (bus_log.hpp).
#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

enum class ExportFormat : std::uint8_t { csv, events_csv, json, candump };
std::optional<ExportFormat> find_export_format(std::string_view name);  ///< "csv", "events", "json", "candump"

struct ExportOptions {
  ExportFormat format = ExportFormat::csv;
  std::vector<std::string> columns;  ///< csv and json: these in this order; empty = all
  bool comments = true;              ///< csv and events: the '#' lines
};

class SessionExport {
 public:
  /// Errors: not_found, bad_value (field columns).
  static Result<SessionExport> open(Database& database, SessionId session, const ExportOptions& options = {});
  SessionExport(SessionExport&&) noexcept;
  SessionExport& operator=(SessionExport&&) noexcept;
  ~SessionExport();

  /// Replaces `out` by the next piece (usually below 100 kB). False at the end, with `out` empty. After an error the export is over.
  Result<bool> next_chunk(std::string& out);
  /// "text/csv; charset=utf-8" or "application/json", and a file name such as hoist_session_12.csv.
  [[nodiscard]] std::string content_type() const;
  [[nodiscard]] std::string file_name() const;

 private:
  struct State;
  explicit SessionExport(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// "a,b" as asked on a command line or in a query: one name per comma, an empty one where there is none.
std::vector<std::string> column_names(std::string_view text);
/// A text as one CSV cell: quoted where needed, and with an apostrophe in front when a spreadsheet would take it for a formula.
std::string csv_cell(std::string_view text);

}  // namespace hoist::db
