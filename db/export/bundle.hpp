// Several sessions in one file: a ZIP with a folder per session, one with a data set as Motion-BIDS lays it out (bids.hpp), one with
// reports for print (db/report/batch.hpp), or plain tables (sqlite.hpp). In pieces; the memory does not grow with the sessions' length.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "db/export/formats.hpp"
#include "db/report/options.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

class Bundle {
 public:
  /// `reports`: of the layout of that name. Errors: bad_value (field `sessions`: none; `reports`: more than kMaxReports), not_found.
  static Result<Bundle> open(Database& database, std::vector<SessionId> sessions, BundleLayout layout, const ReportOptions& reports = {});
  Bundle(Bundle&&) noexcept;
  Bundle& operator=(Bundle&&) noexcept;
  ~Bundle();
  /// As SessionExport::next_chunk of a format that is made whole.
  Result<bool> next_chunk(std::string& out);
  /// Share of the sessions that are written, 0 to 1.
  [[nodiscard]] double progress() const;

 private:
  struct State;
  explicit Bundle(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Which sessions a bundle takes; what is absent does not restrict. Days are those of the visit, YYYY-MM-DD.
struct SessionFilter {
  std::optional<std::string> subject;  ///< the whole patient code
  std::optional<std::string> from_day, to_day;
  std::optional<std::string> exercise;  ///< a shape of exercises.def
  std::optional<std::string> tag;       ///< a word of the session's note that begins with #, without the #; capital or small
  std::optional<std::int64_t> visit;
  bool simulated = true;  ///< also recordings of a simulated hoist
};
inline constexpr std::size_t kMaxBundleSessions = 10000;
/// Sessions of one bundle of reports: their figures wait for the table of all, some kilobytes each.
inline constexpr std::size_t kMaxReports = 1000;
/// Closed sessions in the order of recording. Errors: bad_value (a day that is none, more than kMaxBundleSessions).
Result<std::vector<SessionId>> select_sessions(Database& database, const SessionFilter& filter);

}  // namespace hoist::db
