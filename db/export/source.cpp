#include "db/export/source.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "db/store/column_layouts.hpp"
#include "db/store/session_times.hpp"
#include "db/store/sqlite.hpp"
#include "db/summary/provenance.hpp"

namespace hoist::db {
namespace {

std::size_t needed_column(const ExportSource& source, std::string_view name) {
  if (const auto at = find_column(source.layout, name)) return *at;
  throw SqlFailure{Error{ErrorKind::corrupt, "session " + std::to_string(source.info.id) + " has no column " + std::string(name), {}}};
}

}  // namespace

ExportSource::ExportSource(Database& session_database, SessionInfo session_info, ExportOptions export_options)
    : database(session_database),
      info(std::move(session_info)),
      layout(layout_of(database.handle(), info.id)),
      options(std::move(export_options)),
      reader_(database),
      source_(database.handle(), info.id, layout.size()) {
  tick_column = needed_column(*this, "tick");
  time_column = needed_column(*this, "time_ns");
  nodes = or_throw(reader_.node_programs(info.id));
  anchors.push_back({start_ns(), info.started_utc_ns});
  Statement jump(database.handle(), "SELECT time_ns, utc_ns FROM utc_anchors WHERE session_id = ?1 AND time_ns > ?2 ORDER BY time_ns");
  jump.integer(1, info.id).unsigned_integer(2, info.start_time_ns);
  while (jump.step()) anchors.push_back({jump.integer_at(0), jump.integer_at(1)});
  Statement newest(database.handle(), "SELECT max(last_tick), coalesce(sum(samples), 0) FROM chunks WHERE session_id = ?1");
  if (newest.integer(1, info.id).step() && !newest.is_null(0)) {
    last_tick = newest.unsigned_at(0);
    sample_count = newest.unsigned_at(1);
    any_samples = true;
  }
  Statement newest_event(database.handle(), "SELECT coalesce(max(number), -1) FROM events WHERE session_id = ?1");
  if (newest_event.integer(1, info.id).step()) last_event_ = newest_event.integer_at(0);
}

Status ExportSource::choose() {
  const auto refuse = [](std::string_view field, std::string why) {
    return Error{ErrorKind::bad_value, std::move(why), std::string(field)};
  };
  const bool choice = export_format_info(options.format).columns == ExportColumns::chosen;
  if (!options.columns.empty() && !choice)
    return refuse("columns", "the format " + std::string(export_format_info(options.format).name) + " has no choice of columns");
  std::string unknown;
  for (const std::string& name : options.columns) {
    const auto found = find_column(layout, name);
    if (!found)
      unknown += (unknown.empty() ? "" : ", ") + (name.empty() ? "(empty)" : on_one_line(name));
    else if (std::ranges::find(chosen, *found) != chosen.end())
      return refuse("columns", "column " + name + " is named twice");
    else
      chosen.push_back(*found);
  }
  if (!unknown.empty()) return refuse("columns", "this session has no column " + unknown);
  if (options.columns.empty())
    for (std::size_t c = 0; c < layout.size(); ++c) chosen.push_back(c);
  if (!options.constant) {
    const std::vector<ColumnRange> range = ranges();
    std::erase_if(chosen, [&](std::size_t c) { return !range.empty() && range[c].min == range[c].max; });
  }
  return {};
}

std::int64_t ExportSource::utc_of(std::int64_t time_ns) const {
  auto anchor = anchors.begin();
  for (auto next = anchors.begin(); next != anchors.end() && next->time_ns <= time_ns; ++next) anchor = next;
  return anchor->utc_ns + (time_ns - anchor->time_ns);
}

std::int64_t ExportSource::time_of_tick(std::uint64_t tick) const {
  Statement time(database.handle(), "SELECT " + time_of_step_sql("?2") + " FROM sessions AS s WHERE s.id = ?1");
  return time.integer(1, info.id).unsigned_integer(2, tick).step() ? time.integer_at(0) : start_ns();
}

bool ExportSource::next_samples(std::span<const std::size_t> which) {
  // The recorder may fold between a chunk's row and its body: a job reads with a connection of its own.
  std::optional<Transaction> reading;
  if (sqlite3_get_autocommit(database.handle()) != 0) reading.emplace(database.handle(), Transaction::Kind::read);
  chunk = any_samples && next_tick_ <= last_tick ? source_.at_or_after(next_tick_) : std::nullopt;
  if (!chunk || chunk->first_tick > last_tick) {
    chunk.reset();
    return false;
  }
  source_.load(*chunk, which, values);
  next_tick_ = chunk->last_tick + 1;
  row = 0;
  return true;
}

void ExportSource::rewind() {
  chunk.reset();
  written_tick.reset();
  next_tick_ = 0;
  row = 0;
}

bool ExportSource::gap_before(std::uint64_t tick) const {
  return written_tick ? tick != *written_tick + 1 : gap_ends_before(database.handle(), info.id, tick);
}

std::vector<ColumnRange> ExportSource::ranges() {
  std::vector<ColumnRange> range;
  std::uint64_t tick = 0;
  while (any_samples) {
    const std::optional<StoredChunk> at = source_.at_or_after(tick);
    if (!at || at->first_tick > last_tick) break;
    if (range.empty())
      for (const ChunkColumn& column : at->directory.columns) range.push_back({column.range.min, column.range.max});
    for (std::size_t c = 0; c < range.size() && c < at->directory.columns.size(); ++c) {
      range[c].min = std::min(range[c].min, at->directory.columns[c].range.min);
      range[c].max = std::max(range[c].max, at->directory.columns[c].range.max);
    }
    tick = at->last_tick + 1;
  }
  return range;
}

std::vector<StoredEvent> ExportSource::events_after(std::int64_t after) const {
  constexpr std::int64_t kAtOnce = 256;
  std::vector<StoredEvent> some = or_throw(reader_.events(info.id, {.after = after, .limit = kAtOnce}));
  std::erase_if(some, [this](const StoredEvent& event) { return event.number > last_event_; });
  return some;
}
std::vector<Marker> ExportSource::markers() const { return or_throw(reader_.markers(info.id)); }
std::vector<Gap> ExportSource::gaps() const { return or_throw(reader_.gaps(info.id)); }
std::vector<std::pair<std::string, double>> ExportSource::parameters() const { return or_throw(reader_.parameters(info.id)); }

bool ExportSource::figures_piece() {
  if (info.recording) return false;
  if (!reading_) {
    auto opened = FiguresReading::open(database, info.id);
    if (!opened) return false;
    reading_.emplace(std::move(*opened));
  }
  const Result<bool> more = reading_->piece(database);
  if (more && *more) return true;
  if (more) figures = reading_->take();
  reading_.reset();
  return false;
}

Moments::Moments(const ExportSource& source) : source_(&source), markers_(source.markers()), events_(source.events_after(-1)) {
  std::ranges::stable_sort(markers_, {}, &Marker::tick);
}

std::optional<Moments::Moment> Moments::next(std::uint64_t until_tick) {
  if (next_event_ == events_.size() && !events_.empty()) {
    events_ = source_->events_after(events_.back().number);
    next_event_ = 0;
  }
  Moment moment;
  if (next_marker_ < markers_.size()) moment = {markers_[next_marker_].tick, nullptr, &markers_[next_marker_]};
  if (next_event_ < events_.size() && (moment.marker == nullptr || events_[next_event_].tick <= moment.tick))
    moment = {events_[next_event_].tick, &events_[next_event_], nullptr};
  if ((moment.event == nullptr && moment.marker == nullptr) || moment.tick > until_tick) return std::nullopt;
  ++(moment.event != nullptr ? next_event_ : next_marker_);
  return moment;
}

std::int64_t microseconds_since(std::int64_t start_time_ns, std::int64_t time_ns) {
  const std::int64_t since_ns = time_ns - start_time_ns;
  return since_ns >= 0 ? (since_ns + 500) / 1000 : -((-since_ns + 500) / 1000);
}

std::string number_text(double value, std::string_view absent) {
  if (!std::isfinite(value)) return std::string(absent);
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

std::string csv_cell(std::string_view text, char separator) {
  std::string cell;
  // What OWASP lists as starting a formula, and what some programs skip before looking.
  if (!text.empty() && std::string_view("=+-@\t\r\n").find(text.front()) != std::string_view::npos) cell = "'";
  cell += text;
  // '#' outside quotes begins a comment for pandas.read_csv(comment="#"); inside quotes it is text.
  if (cell.find_first_of(",\"\r\n'#") == std::string::npos && cell.find(separator) == std::string::npos) return cell;
  std::string quoted = "\"";
  for (const char c : cell) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  quoted += '"';
  return quoted;
}

}  // namespace hoist::db
