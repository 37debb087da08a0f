// A session as CSV or JSON, piece by piece, so that nobody holds an hour in memory. Numbers are the stored integers, printed with their
// decimal point: no floating point takes part.
//
// CSV: lines starting with '#' (what was recorded, the last of them the units), one row of column names, then one row per sample:
//   utc, time_s, gap_before, then the columns of the session. gap_before is 1 when samples are missing before the row.
// Events as CSV: '#' lines, names, then one row per event or marker. Texts are quoted and cannot start a formula.
// JSON: {"session": …, "columns": [{"name", "unit", "lsb"}], "rows": n, "data": {"time_s": […], …}, "gaps": …, "events": …, "markers": …, "parameters": …}
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

enum class ExportFormat : std::uint8_t { csv, events_csv, json };
std::optional<ExportFormat> find_export_format(std::string_view name);  ///< "csv", "events", "json"

struct ExportOptions {
  ExportFormat format = ExportFormat::csv;
  std::vector<std::string> columns;  ///< empty = all
  bool comments = true;              ///< CSV: the '#' lines
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

/// A text as one CSV cell: quoted where needed, and with an apostrophe in front when a spreadsheet would take it for a formula.
std::string csv_cell(std::string_view text);

}  // namespace hoist::db
