#include "db/export/session_export.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "control/contract/axes.hpp"
#include "db/export/bus_log.hpp"
#include "db/export/exercise_names.hpp"
#include "db/export/fixed_point.hpp"
#include "db/export/provenance.hpp"
#include "db/store/chunk_source.hpp"
#include "db/store/column_layouts.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

constexpr std::size_t kRowsPerPiece = 256, kNumbersPerPiece = 8192;
constexpr int kSeconds_decimals = 6;
// Text of a foreign file may be broken UTF-8: replaced, not thrown.
constexpr auto kBrokenText = nlohmann::json::error_handler_t::replace;

struct Anchor {
  std::int64_t time_ns, utc_ns;
};

// Steady time as microseconds since the start, rounded half up: what time_s prints.
std::int64_t microseconds_since(std::int64_t start_time_ns, std::int64_t time_ns) {
  const std::int64_t since_ns = time_ns - start_time_ns;
  return since_ns >= 0 ? (since_ns + 500) / 1000 : -((-since_ns + 500) / 1000);
}

// Shortest text that reads back as the same double; JSON and CSV have no NaN: empty or null.
std::string number_text(double value, std::string_view absent) {
  if (!std::isfinite(value)) return std::string(absent);
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

}  // namespace

std::optional<ExportFormat> find_export_format(std::string_view name) {
  if (name == "csv") return ExportFormat::csv;
  if (name == "events") return ExportFormat::events_csv;
  if (name == "json") return ExportFormat::json;
  if (name == "candump") return ExportFormat::candump;
  return std::nullopt;
}

std::string csv_cell(std::string_view text) {
  std::string cell;
  // What OWASP lists as starting a formula, and what some programs skip before looking.
  if (!text.empty() && std::string_view("=+-@\t\r\n").find(text.front()) != std::string_view::npos) cell = "'";
  cell += text;
  // '#' outside quotes begins a comment for pandas.read_csv(comment="#"); inside quotes it is text.
  if (cell.find_first_of(",\"\r\n'#") == std::string::npos) return cell;
  std::string quoted = "\"";
  for (const char c : cell) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  quoted += '"';
  return quoted;
}

std::vector<std::string> column_names(std::string_view text) {
  std::vector<std::string> names;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    names.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return names;
}

struct SessionExport::State {
  State(Database& session_database, SessionInfo session_info, std::vector<ColumnInfo> session_layout, ExportOptions export_options)
      : database(session_database),
        handle(database.handle()),
        reader(database),
        info(std::move(session_info)),
        layout(std::move(session_layout)),
        options(std::move(export_options)),
        source(handle, info.id, layout.size()) {}

  Database& database;
  sqlite3* handle;
  SessionReader reader;
  SessionInfo info;
  std::vector<ColumnInfo> layout;
  ExportOptions options;
  ChunkSource source;
  std::vector<NodeProgram> nodes;
  std::optional<BusLog> bus_log;  // of its format
  std::vector<Anchor> anchors;
  std::vector<std::size_t> chosen;  // columns to write
  std::size_t tick_column = 0, time_column = 0;
  std::uint64_t last_tick = 0;  // of the session when the export began: one that is being recorded must not grow under our hands
  bool any_samples = false;
  std::uint64_t sample_count = 0;

  enum class Step : std::uint8_t { head, body, tail, over };
  Step step = Step::head;
  // CSV position.
  std::uint64_t next_tick = 0;
  std::optional<StoredChunk> chunk;
  std::vector<std::vector<std::int64_t>> values;  // chosen columns, then tick and time
  std::size_t row = 0;
  std::optional<std::uint64_t> written_tick;
  UtcPrinter utc;
  struct Cell {
    std::int64_t value = 0;
    std::size_t length = 0;  // 0 = nothing printed yet
    std::array<char, 32> text{};
  };
  std::vector<Cell> cells;
  // JSON position: 0 = time_s, 1 = gap_before, then the chosen columns.
  std::size_t json_column = 0;
  bool first_number = true;

  // The columns to write, or which of the asked ones cannot be.
  Status choose() {
    const auto refuse = [](const std::string& why) { return Error{ErrorKind::bad_value, why, "columns"}; };
    if (!options.columns.empty() && options.format != ExportFormat::csv && options.format != ExportFormat::json)
      return refuse("columns can be chosen in csv and json only");
    std::string unknown;
    for (const std::string& name : options.columns) {
      const auto found = find_column(layout, name);
      if (!found)
        unknown += (unknown.empty() ? "" : ", ") + (name.empty() ? "(empty)" : on_one_line(name));
      else if (std::ranges::find(chosen, *found) != chosen.end())
        return refuse("column " + name + " is named twice");
      else
        chosen.push_back(*found);
    }
    if (!unknown.empty()) return refuse("this session has no column " + unknown);
    if (options.columns.empty())
      for (std::size_t c = 0; c < layout.size(); ++c) chosen.push_back(c);
    return {};
  }

  [[nodiscard]] std::int64_t utc_of(std::int64_t time_ns) const {
    auto anchor = anchors.begin();
    for (auto next = anchors.begin(); next != anchors.end() && next->time_ns <= time_ns; ++next) anchor = next;
    return anchor->utc_ns + (time_ns - anchor->time_ns);
  }

  [[nodiscard]] bool gap_before(std::uint64_t tick) const {
    return written_tick ? tick != *written_tick + 1 : gap_ends_before(handle, info.id, tick);
  }

  void prepare() {
    Result<std::vector<NodeProgram>> told = reader.node_programs(info.id);
    if (!told) throw SqlFailure{told.error()};
    nodes = std::move(*told);
    if (options.format == ExportFormat::candump) bus_log.emplace(database, info);
    anchors.push_back({static_cast<std::int64_t>(info.start_time_ns), info.started_utc_ns});
    Statement jump(handle, "SELECT time_ns, utc_ns FROM utc_anchors WHERE session_id = ?1 AND time_ns > ?2 ORDER BY time_ns");
    jump.integer(1, info.id).unsigned_integer(2, info.start_time_ns);
    while (jump.step()) anchors.push_back({jump.integer_at(0), jump.integer_at(1)});
    Statement newest(handle, "SELECT max(last_tick), coalesce(sum(samples), 0) FROM chunks WHERE session_id = ?1");
    if (newest.integer(1, info.id).step() && !newest.is_null(0)) {
      last_tick = newest.unsigned_at(0);
      sample_count = newest.unsigned_at(1);
      any_samples = true;
    }
  }

  void csv_head(std::string& out) {
    if (options.comments) out += provenance_lines(info, nodes);
  }

  // What each column is, under its place in the row of names.
  void column_line(std::string& out, std::string_view first, auto text_of) {
    out += first;
    for (const std::size_t c : chosen) out += ',' + csv_cell(text_of(layout[c]));
    out += '\n';
  }

  void csv_names(std::string& out) {
    csv_head(out);
    if (options.comments) {
      column_line(out, "# axes:,,", [](const ColumnInfo& column) { return contract::axis_of(column.name); });
      column_line(out, "# units: UTC,s,", [](const ColumnInfo& column) { return std::string_view(column.unit); });
    }
    column_line(out, "utc,time_s,gap_before", [](const ColumnInfo& column) { return std::string_view(column.name); });
  }

  // Makes the next samples available in `values`; false at the end.
  bool next_samples(std::span<const std::size_t> which) {
    chunk = any_samples && next_tick <= last_tick ? source.at_or_after(next_tick) : std::nullopt;
    if (!chunk || chunk->first_tick > last_tick) return false;
    source.load(*chunk, which, values);
    next_tick = chunk->last_tick + 1;
    row = 0;
    return true;
  }

  bool csv_rows(std::string& out) {
    std::vector<std::size_t> which = chosen;
    which.push_back(tick_column);
    which.push_back(time_column);
    if (!chunk && !next_samples(which)) return false;
    const std::vector<std::int64_t>& ticks = values[chosen.size()];
    const std::vector<std::int64_t>& times = values[chosen.size() + 1];
    const std::size_t end = std::min(row + kRowsPerPiece, ticks.size());
    out.resize((end - row) * (chosen.size() + 3) * kMaxNumber_chars);
    char* at = out.data();
    for (; row < end; ++row) {
      const auto tick = static_cast<std::uint64_t>(ticks[row]);
      // Folding may have joined chunks since the last piece.
      if ((written_tick && tick <= *written_tick) || tick > last_tick) continue;
      at = utc.print(at, utc_of(times[row]));
      *at++ = ',';
      at = print_fixed(at, microseconds_since(static_cast<std::int64_t>(info.start_time_ns), times[row]), kSeconds_decimals);
      *at++ = ',';
      *at++ = gap_before(tick) ? '1' : '0';
      for (std::size_t c = 0; c < chosen.size(); ++c) {
        // Half of the columns rarely change: their text is copied, not printed anew.
        Cell& cell = cells[c];
        const std::int64_t value = values[c][row];
        if (value != cell.value || cell.length == 0) {
          cell.text[0] = ',';
          cell.length = static_cast<std::size_t>(print_fixed(cell.text.data() + 1, value, layout[chosen[c]].decimals) - cell.text.data());
          cell.value = value;
        }
        std::memcpy(at, cell.text.data(), cell.text.size());
        at += cell.length;
      }
      *at++ = '\n';
      written_tick = tick;
    }
    out.resize(static_cast<std::size_t>(at - out.data()));
    if (row >= ticks.size()) chunk.reset();
    return true;
  }

  void events_csv(std::string& out) {
    csv_head(out);
    out += "utc,time_s,tick,kind,name,code,bits,item,value,before,request_id,user,role,origin,client,text\n";
    struct Line {
      std::uint64_t tick;
      std::string text;
    };
    std::vector<Line> lines;
    const auto stamp = [&](std::int64_t utc_ns, std::int64_t micros) {
      std::array<char, 2 * kMaxNumber_chars> text;
      char* at = utc.print(text.data(), utc_ns);
      *at++ = ',';
      at = print_fixed(at, micros, kSeconds_decimals);
      return std::string(text.data(), at);
    };
    const auto cells_of = [](const std::optional<Actor>& actor) {
      if (!actor) return std::string(",,,,");
      std::string texts;
      for (const std::string& word : {actor->user, actor->role, actor->origin, actor->client}) texts += ',' + csv_cell(word);
      return texts;
    };
    const auto start_ns = static_cast<std::int64_t>(info.start_time_ns);
    const Result<std::vector<StoredEvent>> events = reader.events(info.id);
    if (!events) throw SqlFailure{events.error()};
    for (const StoredEvent& event : *events) {
      const auto time_ns = static_cast<std::int64_t>(event.time_ns);
      std::string line = stamp(utc_of(time_ns), microseconds_since(start_ns, time_ns));
      line += ',' + std::to_string(event.tick) + ',' + csv_cell(event.kind_name) + ',' + csv_cell(event.name);
      for (const std::uint32_t number : {event.code, event.bits, event.item}) line += ',' + std::to_string(number);
      line += ',' + number_text(event.value, "") + ',' + number_text(event.before, "");
      line += ',' + std::to_string(event.request_id) + cells_of(event.actor) + ',';
      lines.push_back({event.tick, std::move(line)});
    }
    const Result<std::vector<Marker>> markers = reader.markers(info.id);
    if (!markers) throw SqlFailure{markers.error()};
    for (const Marker& marker : *markers) {
      const std::int64_t micros = microseconds_since(info.started_utc_ns, marker.utc_ns);
      lines.push_back({marker.tick, stamp(marker.utc_ns, micros) + ',' + std::to_string(marker.tick) + ",marker,,,,,,," +
                                        cells_of(marker.actor) + ',' + csv_cell(marker.text)});
    }
    std::ranges::stable_sort(lines, {}, &Line::tick);
    for (const Line& line : lines) out += line.text + "\n";
  }

  void json_head(std::string& out) {
    using nlohmann::json;
    json session{{"id", info.id},
                 {"started_utc_ns", info.started_utc_ns},
                 {"start_time_ns", info.start_time_ns},
                 {"simulated", info.simulated},
                 {"software_version", info.software_version},
                 {"core_version", nullptr},
                 {"layout_hash", layout_text(info.layout_hash)},
                 {"nodes", node_programs_json(nodes)},
                 {"note", info.note},
                 {"subject", nullptr},
                 {"exercise", exercise_as_told(info.exercise_json)},
                 {"ended_utc_ns", nullptr},
                 {"close_reason", nullptr}};
    std::array<char, kMaxNumber_chars> text;
    session["started_utc"] = std::string(text.data(), utc.print(text.data(), info.started_utc_ns));
    if (info.subject) session["subject"] = *info.subject;
    if (info.core_version) session["core_version"] = *info.core_version;
    if (info.ended_utc_ns) session["ended_utc_ns"] = *info.ended_utc_ns;
    if (!info.recording) session["close_reason"] = info.close_reason;
    json columns = json::array();
    const auto column = [&columns](std::string_view name, std::string_view unit, double lsb) {
      const std::string_view axis = contract::axis_of(name);
      columns.push_back({{"name", name}, {"unit", unit}, {"lsb", lsb}, {"axis", axis.empty() ? json(nullptr) : json(axis)}});
    };
    column("time_s", "s", 1e-6);
    column("gap_before", "", 1);
    for (const std::size_t c : chosen) column(layout[c].name, layout[c].unit, layout[c].lsb);
    const auto dump = [](const json& value) { return value.dump(-1, ' ', false, kBrokenText); };
    out = "{\"session\":" + dump(session) + ",\n\"directions\":" + dump(contract::kAxesText) + ",\n\"columns\":" + dump(columns) +
          ",\n\"rows\":" + std::to_string(sample_count) + ",\n\"data\":{";
  }

  // One column after the other, so that only one chunk's column is in memory: time_s, gap_before, then the chosen ones.
  bool json_body(std::string& out) {
    if (json_column == chosen.size() + 2) return false;
    const std::size_t first_which = json_column == 0 ? time_column : json_column == 1 ? tick_column : chosen[json_column - 2];
    const std::array which{first_which, tick_column};
    if (first_number && next_tick == 0 && !chunk) {
      const std::string name = json_column == 0 ? "time_s" : json_column == 1 ? "gap_before" : layout[first_which].name;
      out += json_column == 0 ? "\n" : ",\n";
      out += nlohmann::json(name).dump(-1, ' ', false, kBrokenText) + ":[";
    }
    if (!chunk && !next_samples(which)) {
      out += ']';
      ++json_column;
      next_tick = 0;
      written_tick.reset();
      first_number = true;
      return true;
    }
    const std::vector<std::int64_t>&numbers = values[0], &ticks = values[1];
    const std::size_t end = std::min(row + kNumbersPerPiece, numbers.size()), before = out.size();
    out.resize(before + (end - row) * kMaxNumber_chars);
    char* at = out.data() + before;
    for (; row < end; ++row) {
      const auto tick = static_cast<std::uint64_t>(ticks[row]);
      if ((written_tick && tick <= *written_tick) || tick > last_tick) continue;
      if (!first_number) *at++ = ',';
      first_number = false;
      if (json_column == 0)
        at = print_fixed(at, microseconds_since(static_cast<std::int64_t>(info.start_time_ns), numbers[row]), kSeconds_decimals);
      else if (json_column == 1)
        *at++ = gap_before(tick) ? '1' : '0';
      else
        at = print_fixed(at, numbers[row], layout[first_which].decimals);
      written_tick = tick;
    }
    out.resize(static_cast<std::size_t>(at - out.data()));
    if (row >= numbers.size()) chunk.reset();
    return true;
  }

  void json_tail(std::string& out) {
    using nlohmann::json;
    const auto check = [](const auto& result) {
      if (!result) throw SqlFailure{result.error()};
    };
    const auto finite = [](double value) { return std::isfinite(value) ? json(value) : json(nullptr); };
    const auto gaps = reader.gaps(info.id);
    check(gaps);
    json gap_rows = json::array();
    for (const Gap& gap : *gaps)
      gap_rows.push_back({{"stream", gap.stream}, {"from_tick", gap.from_tick}, {"to_tick", gap.to_tick}, {"reason", gap.reason}});
    const auto events = reader.events(info.id);
    check(events);
    json event_rows = json::array();
    for (const StoredEvent& event : *events)
      event_rows.push_back({{"tick", event.tick},
                            {"time_ns", event.time_ns},
                            {"kind", event.kind_name},
                            {"name", event.name},
                            {"code", event.code},
                            {"bits", event.bits},
                            {"item", event.item},
                            {"value", finite(event.value)},
                            {"before", finite(event.before)},
                            {"request_id", event.request_id},
                            {"actor", actor_json(event.actor)}});
    const auto markers = reader.markers(info.id);
    check(markers);
    json marker_rows = json::array();
    for (const Marker& marker : *markers)
      marker_rows.push_back({{"tick", marker.tick}, {"utc_ns", marker.utc_ns}, {"text", marker.text}, {"actor", actor_json(marker.actor)}});
    const auto parameters = reader.parameters(info.id);
    check(parameters);
    json parameter_rows = json::object();
    for (const auto& [name, value] : *parameters) parameter_rows[name] = finite(value);
    const auto dump = [](const json& value) { return value.dump(-1, ' ', false, kBrokenText); };
    out = "},\n\"gaps\":" + dump(gap_rows) + ",\n\"events\":" + dump(event_rows) + ",\n\"markers\":" + dump(marker_rows) +
          ",\n\"parameters\":" + dump(parameter_rows) + "}\n";
  }

  bool next(std::string& out) {
    if (bus_log && step != Step::over) {
      if (bus_log->next(out)) return true;
      step = Step::over;
    }
    switch (step) {
      case Step::head:
        step = Step::body;
        if (options.format == ExportFormat::json) {
          json_head(out);
        } else if (options.format == ExportFormat::events_csv) {
          events_csv(out);
          step = Step::over;
        } else {
          csv_names(out);
        }
        return true;
      case Step::body:
        if (options.format == ExportFormat::json) {
          if (json_body(out)) return true;
          step = Step::over;
          json_tail(out);
          return true;
        }
        if (csv_rows(out)) return true;
        step = Step::over;
        return false;
      default:
        return false;
    }
  }
};

SessionExport::SessionExport(std::unique_ptr<State> state) : state_(std::move(state)) {}
SessionExport::SessionExport(SessionExport&&) noexcept = default;
SessionExport& SessionExport::operator=(SessionExport&&) noexcept = default;
SessionExport::~SessionExport() = default;

Result<SessionExport> SessionExport::open(Database& database, SessionId session, const ExportOptions& options) {
  return guarded([&]() -> Result<SessionExport> {
    Result<SessionInfo> info = SessionReader(database).get(session);
    if (!info) return info.error();
    Transaction transaction(database.handle(), Transaction::Kind::read);
    auto state = std::make_unique<State>(database, *info, layout_of(database.handle(), session), options);
    const auto tick = find_column(state->layout, "tick"), time = find_column(state->layout, "time_ns");
    if (!tick || !time) return Error{ErrorKind::corrupt, "session " + std::to_string(session) + " has no tick and time columns", {}};
    state->tick_column = *tick;
    state->time_column = *time;
    if (Status chosen = state->choose(); !chosen) return chosen.error();
    state->cells.resize(state->chosen.size());
    state->prepare();
    return SessionExport(std::move(state));
  });
}

Result<bool> SessionExport::next_chunk(std::string& out) {
  out.clear();
  // A piece may hold no rows of its own (all of them known already); the caller must not take that for the end.
  Result<bool> more = guarded([&]() -> Result<bool> {
    while (state_->next(out))
      if (!out.empty()) return true;
    return false;
  });
  if (!more) {
    out.clear();
    state_->step = State::Step::over;
  }
  return more;
}

std::string SessionExport::content_type() const {
  switch (state_->options.format) {
    case ExportFormat::json:
      return "application/json";
    case ExportFormat::candump:
      return "text/plain; charset=utf-8";
    default:
      return "text/csv; charset=utf-8";
  }
}

std::string SessionExport::file_name() const {
  const std::string base = "hoist_session_" + std::to_string(state_->info.id) + (state_->info.simulated ? "_simulated" : "");
  switch (state_->options.format) {
    case ExportFormat::json:
      return base + ".json";
    case ExportFormat::events_csv:
      return base + "_events.csv";
    case ExportFormat::candump:
      return base + "_can.log";
    case ExportFormat::csv:
      break;
  }
  return base + ".csv";
}

}  // namespace hoist::db
