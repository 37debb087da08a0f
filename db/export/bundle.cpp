#include "db/export/bundle.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "db/export/bids.hpp"
#include "db/export/manifest.hpp"
#include "db/export/session_export.hpp"
#include "db/export/source.hpp"
#include "db/export/sqlite.hpp"
#include "db/export/zip_file.hpp"
#include "db/report/batch.hpp"
#include "db/store/session_times.hpp"
#include "db/store/sqlite.hpp"
#include "db/summary/session_json.hpp"

namespace hoist::db {
namespace {

// More than a sample takes in any format.
constexpr std::uint64_t kSample_bytes = 8192, kFourGigabytes = 0xFFFFFFFFU;

BundleFile export_file(Database& database, const SessionInfo& info, const std::string& folder, ExportFormat format) {
  BundleFile file;
  file.name = folder + "session" + std::string(export_format_info(format).ending);
  file.utc_ns = info.started_utc_ns;
  file.large = info.sample_count * kSample_bytes >= kFourGigabytes;
  file.open = [&database, id = info.id, format] {
    ExportOptions options;
    options.format = format;
    // The manifest stands in a file of its own.
    options.comments = false;
    auto opened = std::make_shared<SessionExport>(or_throw(SessionExport::open(database, id, options)));
    return [opened](std::string& out) {
      std::string piece;
      const bool more = or_throw(opened->next_chunk(piece));
      out += piece;
      return more;
    };
  };
  return file;
}

// session_12/session.csv, session_events.csv, session_can.log, session.mcap, manifest.json, figures.json
std::vector<BundleFile> session_files(Database& database, SessionId session, const std::string& folder) {
  const SessionInfo info = or_throw(SessionReader(database).get(session));
  std::vector<BundleFile> files;
  for (const ExportFormat format : {ExportFormat::csv, ExportFormat::events, ExportFormat::candump, ExportFormat::mcap})
    files.push_back(export_file(database, info, folder, format));
  files.push_back(text_file(folder + "manifest.json", info.started_utc_ns, [&database, info] {
    ExportSource source(database, info, {});
    if (Status chosen = source.choose(); !chosen) throw SqlFailure{chosen.error()};
    return manifest_json(source).dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  }));
  files.push_back(text_file(folder + "figures.json", info.started_utc_ns, [&database, session] {
    const auto figures = session_metrics_json(database, session);
    return (figures ? figures->dump(1, ' ', false, nlohmann::json::error_handler_t::replace) : std::string("null")) + "\n";
  }));
  return files;
}

class FilesPlan : public BundlePlan {
 public:
  explicit FilesPlan(Database& database) : database_(database) {}
  std::vector<BundleFile> first() override { return {}; }
  std::vector<BundleFile> of_session(SessionId session) override {
    return session_files(database_, session, "session_" + std::to_string(session) + "/");
  }
  std::vector<BundleFile> last() override { return {}; }

 private:
  Database& database_;
};

// session-12.html, and group.html of all when there are several. In the place of a session that has no report stands the reason.
class ReportsPlan : public BundlePlan {
 public:
  ReportsPlan(Database& database, const ReportOptions& options) : database_(database), batch_(database, options) {}
  std::vector<BundleFile> first() override { return {}; }
  std::vector<BundleFile> of_session(SessionId session) override {
    const SessionInfo info = or_throw(SessionReader(database_).get(session));
    newest_utc_ns_ = std::max(newest_utc_ns_, info.started_utc_ns);
    const std::string name = "session-" + std::to_string(session);
    Result<std::string> page = batch_.page(session);
    if (page) return {text_file(name + ".html", info.started_utc_ns, [text = std::move(*page)] { return text; })};
    if (page.error().kind == ErrorKind::busy || page.error().kind == ErrorKind::io) throw SqlFailure{page.error()};
    return {text_file(name + ".txt", info.started_utc_ns, [text = page.error().message + "\n"] { return text; })};
  }
  std::vector<BundleFile> last() override {
    if (batch_.size() < 2) return {};
    return {text_file("group.html", newest_utc_ns_, [this] { return batch_.group(); })};
  }

 private:
  Database& database_;
  ReportBatch batch_;
  std::int64_t newest_utc_ns_ = 0;
};

std::unique_ptr<BundlePlan> plan_of(Database& database, const std::vector<SessionId>& sessions, BundleLayout layout,
                                    const ReportOptions& reports) {
  if (layout == BundleLayout::bids) return make_bids_plan(database, sessions);
  if (layout == BundleLayout::reports) return std::make_unique<ReportsPlan>(database, reports);
  return std::make_unique<FilesPlan>(database);
}

// The archive of a plan, piece by piece.
class BundleWriter : public BundleSource {
 public:
  BundleWriter(std::unique_ptr<BundlePlan> plan, std::vector<SessionId> sessions) : plan_(std::move(plan)), sessions_(std::move(sessions)) {
    take(plan_->first());
  }

  bool next(std::string& out) override {
    if (over_) return false;
    if (pieces_) {
      piece_.clear();
      const bool more = pieces_(piece_);
      if (!piece_.empty()) zip_.write(out, piece_);
      if (!more) {
        zip_.end_file(out);
        pieces_ = nullptr;
      }
      return true;
    }
    if (files_.empty()) refill();
    if (files_.empty()) {
      over_ = true;
      zip_.end(out);
      return true;
    }
    const BundleFile file = std::move(files_.front());
    files_.pop_front();
    zip_.begin_file(out, file.name, file.utc_ns, file.large);
    pieces_ = file.open();
    return true;
  }
  [[nodiscard]] double progress() const override {
    return sessions_.empty() ? 1 : static_cast<double>(next_ > 0 ? next_ - 1 : 0) / static_cast<double>(sessions_.size());
  }

 private:
  void take(std::vector<BundleFile> files) {
    for (BundleFile& file : files) files_.push_back(std::move(file));
  }
  void refill() {
    while (files_.empty() && next_ < sessions_.size()) take(plan_->of_session(sessions_[next_++]));
    if (files_.empty() && !std::exchange(last_taken_, true)) take(plan_->last());
  }

  std::unique_ptr<BundlePlan> plan_;
  std::vector<SessionId> sessions_;
  std::size_t next_ = 0;
  std::deque<BundleFile> files_;
  std::function<bool(std::string&)> pieces_;  // of the file under way
  std::string piece_;
  ZipFile zip_;
  bool last_taken_ = false, over_ = false;
};

bool is_day(const std::string& text) {
  constexpr std::string_view kShape = "dddd-dd-dd";
  return text.size() == kShape.size() &&
         std::ranges::equal(text, kShape, [](char c, char shape) { return shape == 'd' ? c >= '0' && c <= '9' : c == shape; });
}

// Whether the note holds #TAG as a word: letters and digits of any script, - and _.
bool has_tag(std::string_view note, std::string_view tag) {
  constexpr std::string_view kEnds = " \t\r\n#,;.:!?()[]\"'";
  const auto small = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  for (std::size_t at = note.find('#'); at != std::string_view::npos; at = note.find('#', at + 1)) {
    const std::string_view rest = note.substr(at + 1);
    if (std::ranges::equal(rest.substr(0, rest.find_first_of(kEnds)), tag, {}, small, small)) return true;
  }
  return false;
}

}  // namespace

std::unique_ptr<FormatWriter> make_zip(ExportSource& source) {
  return std::make_unique<BundleWriter>(std::make_unique<FilesPlan>(source.database), std::vector{source.info.id});
}

struct Bundle::State {
  std::unique_ptr<BundleSource> writer;
  bool over = false;
};
Bundle::Bundle(std::unique_ptr<State> state) : state_(std::move(state)) {}
Bundle::Bundle(Bundle&&) noexcept = default;
Bundle& Bundle::operator=(Bundle&&) noexcept = default;
Bundle::~Bundle() = default;

Result<Bundle> Bundle::open(Database& database, std::vector<SessionId> sessions, BundleLayout layout, const ReportOptions& reports) {
  return guarded([&]() -> Result<Bundle> {
    if (sessions.empty()) return Error{ErrorKind::bad_value, "no session fits", "sessions"};
    if (layout == BundleLayout::reports && sessions.size() > kMaxReports)
      return Error{ErrorKind::bad_value, "more than " + std::to_string(kMaxReports) + " sessions fit; choose fewer for reports", "reports"};
    for (const SessionId session : sessions)
      if (const auto info = SessionReader(database).get(session); !info) return info.error();
    auto state = std::make_unique<State>();
    if (layout == BundleLayout::sqlite) {
      state->writer = std::make_unique<SqliteWriter>(database, std::move(sessions), ExportOptions{.format = ExportFormat::sqlite});
    } else {
      auto plan = plan_of(database, sessions, layout, reports);
      state->writer = std::make_unique<BundleWriter>(std::move(plan), std::move(sessions));
    }
    return Bundle(std::move(state));
  });
}

Result<bool> Bundle::next_chunk(std::string& out) {
  out.clear();
  Result<bool> more = guarded([&]() -> Result<bool> { return !state_->over && state_->writer->next(out); });
  if (!more) out.clear();
  if (!more || !*more) state_->over = true;
  return more;
}

double Bundle::progress() const { return state_->writer->progress(); }

Result<std::vector<SessionId>> select_sessions(Database& database, const SessionFilter& filter) {
  for (const auto& [day, field] : {std::pair{filter.from_day, "from_day"}, std::pair{filter.to_day, "to_day"}})
    if (day && !is_day(*day)) return Error{ErrorKind::bad_value, std::string(field) + " must be a day as YYYY-MM-DD", field};
  return guarded([&]() -> Result<std::vector<SessionId>> {
    const std::string day = "coalesce(day, " + local_day_sql("started_utc_ns") + ")";
    Statement row(
        database.handle(),
        "SELECT sessions.id, note FROM sessions LEFT JOIN visits ON visits.id = visit_id LEFT JOIN patients ON patients.id = patient_id "
        "WHERE close_reason IS NOT NULL AND standby = 0 AND (?1 IS NULL OR code_same(code, ?1)) "
        "AND (?2 IS NULL OR " +
            day + " >= ?2) AND (?3 IS NULL OR " + day +
            " <= ?3) "
            "AND (?4 IS NULL OR (json_valid(exercise) AND json_extract(exercise, '$.shape') = ?4)) "
            "AND (?5 IS NULL OR visit_id = ?5) AND (?6 OR NOT simulated) ORDER BY sessions.id");
    row.text(1, filter.subject).text(2, filter.from_day).text(3, filter.to_day).text(4, filter.exercise);
    if (filter.visit)
      row.integer(5, *filter.visit);
    else
      row.null(5);
    row.integer(6, filter.simulated ? 1 : 0);
    std::vector<SessionId> ids;
    while (ids.size() <= kMaxBundleSessions && row.step())
      if (!filter.tag || has_tag(row.text_at(1), *filter.tag)) ids.push_back(row.integer_at(0));
    if (ids.size() > kMaxBundleSessions)
      return Error{ErrorKind::bad_value, "more than " + std::to_string(kMaxBundleSessions) + " sessions fit", "sessions"};
    return ids;
  });
}

}  // namespace hoist::db
