// Several sessions in one file: a ZIP with a folder per session, one with a data set as Motion-BIDS lays it out (bids.hpp), or plain tables
// (sqlite.hpp). In pieces; the memory does not grow with the sessions' length.
#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "db/export/source.hpp"
#include "db/export/zip_file.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

/// One file of a bundle: its name, and what appends its next piece (false at the end; throws SqlFailure).
struct BundleFile {
  std::string name;
  std::int64_t utc_ns = 0;
  bool large = false;  ///< may pass 4 GB
  std::function<std::function<bool(std::string&)>()> open;
};
/// A file whose text is made when its turn comes.
BundleFile text_file(std::string name, std::int64_t utc_ns, std::function<std::string()> make);

/// Files from a list of sessions. The description of the whole comes first.
class BundlePlan {
 public:
  BundlePlan() = default;
  virtual ~BundlePlan() = default;
  BundlePlan(const BundlePlan&) = delete;
  BundlePlan& operator=(const BundlePlan&) = delete;
  virtual std::vector<BundleFile> first() = 0;
  virtual std::vector<BundleFile> of_session(SessionId session) = 0;
  virtual std::vector<BundleFile> last() = 0;
};

/// Several sessions under way to one file.
class BundleSource : public FormatWriter {
 public:
  /// Share of the work that is done, 0 to 1.
  [[nodiscard]] virtual double progress() const = 0;
};

class Bundle {
 public:
  /// Errors: bad_value (no session), not_found.
  static Result<Bundle> open(Database& database, std::vector<SessionId> sessions, BundleLayout layout);
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
  std::optional<std::int64_t> visit;
  bool simulated = true;  ///< also recordings of a simulated hoist
};
inline constexpr std::size_t kMaxBundleSessions = 10000;
/// Closed sessions in the order of recording. Errors: bad_value (a day that is none, more than kMaxBundleSessions).
Result<std::vector<SessionId>> select_sessions(Database& database, const SessionFilter& filter);

}  // namespace hoist::db
