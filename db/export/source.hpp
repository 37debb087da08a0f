// What every format writes from: the session, its columns and its samples in order, chunk by chunk.
// Inside db a failure is thrown as SqlFailure; SessionExport turns it into an Error.
#pragma once
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "db/export/formats.hpp"
#include "db/store/chunk_source.hpp"
#include "db/store/session_reader.hpp"
#include "db/summary/session_json.hpp"

namespace hoist::db {

/// The wall clock at a moment of the steady one.
struct ClockAnchor {
  std::int64_t time_ns = 0, utc_ns = 0;
};
/// Smallest and largest stored integer of a column.
struct ColumnRange {
  std::int64_t min = 0, max = 0;
};

class ExportSource {
 public:
  /// Inside a read transaction: what is recorded later does not belong to it.
  ExportSource(Database& session_database, SessionInfo session_info, ExportOptions export_options);

  /// The columns to write, or which of the asked ones cannot be.
  Status choose();

  [[nodiscard]] std::int64_t start_ns() const { return static_cast<std::int64_t>(info.start_time_ns); }
  /// By the wall clock as it was set at that moment.
  [[nodiscard]] std::int64_t utc_of(std::int64_t time_ns) const;
  /// By the wall clock of the session's start: never runs backwards.
  [[nodiscard]] std::int64_t even_utc_of(std::int64_t time_ns) const { return info.started_utc_ns + (time_ns - start_ns()); }

  /// Steady time of a step (session_times.hpp).
  [[nodiscard]] std::int64_t time_of_tick(std::uint64_t tick) const;

  /// Makes the next stored samples of these columns available in `values`; false at the end.
  bool next_samples(std::span<const std::size_t> which);
  /// From the first sample again.
  void rewind();
  /// Whether this row of `values` is to be written: folding may have joined chunks meanwhile, so that rows come twice.
  [[nodiscard]] bool wanted(std::uint64_t tick) const { return !(written_tick && tick <= *written_tick) && tick <= last_tick; }
  [[nodiscard]] bool gap_before(std::uint64_t tick) const;
  /// The whole session's, from the chunks' directories alone. Empty without samples.
  [[nodiscard]] std::vector<ColumnRange> ranges();

  /// Behind the number `after` a few of those that there were when the export began; empty at the end. A failed read is thrown.
  [[nodiscard]] std::vector<StoredEvent> events_after(std::int64_t after) const;
  /// Calls `use(event)` for each event, of which a few are in memory at a time.
  template <typename Use>
  void each_event(Use use) const {
    for (std::vector<StoredEvent> some = events_after(-1); !some.empty(); some = events_after(some.back().number))
      for (const StoredEvent& event : some) use(event);
  }
  /// All of them: people set them.
  [[nodiscard]] std::vector<Marker> markers() const;
  [[nodiscard]] std::vector<Gap> gaps() const;
  [[nodiscard]] std::vector<std::pair<std::string, double>> parameters() const;
  /// Reads a piece of what the figures are computed from; false once they are in `figures`. A session that is being recorded has no final ones; one
  /// whose columns cannot be judged is exported without: null.
  bool figures_piece();

  Database& database;
  SessionInfo info;
  std::vector<ColumnInfo> layout;
  ExportOptions options;
  std::vector<NodeProgram> nodes;
  std::vector<ClockAnchor> anchors;  // the first one is the session's start
  std::vector<std::size_t> chosen;   // columns to write
  std::size_t tick_column = 0, time_column = 0;
  std::uint64_t last_tick = 0;  // of the session when the export began: one that is being recorded must not grow meanwhile
  bool any_samples = false;
  std::uint64_t sample_count = 0;

  nlohmann::json figures;

  // Position.
  std::optional<StoredChunk> chunk;
  std::vector<std::vector<std::int64_t>> values;  // of the columns asked for
  std::size_t row = 0;
  std::optional<std::uint64_t> written_tick;

 private:
  SessionReader reader_;
  ChunkSource source_;
  std::uint64_t next_tick_ = 0;
  std::int64_t last_event_ = -1;
  std::optional<FiguresReading> reading_;  // of the figures
};

/// Events and markers of a session in the order of their steps, an event before a marker. A few events are in memory at a time.
class Moments {
 public:
  explicit Moments(const ExportSource& source);
  /// One of both is there.
  struct Moment {
    std::uint64_t tick = 0;
    const StoredEvent* event = nullptr;
    const Marker* marker = nullptr;
  };
  /// The next one, valid until the next call; nothing when there is none up to this step.
  std::optional<Moment> next(std::uint64_t until_tick = ~std::uint64_t{0});

 private:
  const ExportSource* source_;
  std::vector<Marker> markers_;
  std::vector<StoredEvent> events_;
  std::size_t next_marker_ = 0, next_event_ = 0;
};

/// One export under way in one format.
class FormatWriter {
 public:
  FormatWriter() = default;
  virtual ~FormatWriter() = default;
  FormatWriter(const FormatWriter&) = delete;
  FormatWriter& operator=(const FormatWriter&) = delete;
  /// Appends the next piece, perhaps nothing; false at the end. Throws SqlFailure.
  virtual bool next(std::string& out) = 0;
};

// One function per row of formats.def.
#define HOIST_EXPORT(name, ...) std::unique_ptr<FormatWriter> make_##name(ExportSource& source);
#include "db/export/formats.def"
#undef HOIST_EXPORT

/// Steady time as microseconds since the start, rounded half up: what time_s prints.
std::int64_t microseconds_since(std::int64_t start_time_ns, std::int64_t time_ns);
inline constexpr int kSeconds_decimals = 6;
/// Shortest text that reads back as the same double; CSV and JSON have no NaN: `absent` then.
std::string number_text(double value, std::string_view absent);
/// A text as one CSV cell: quoted where needed, and with an apostrophe in front when a spreadsheet would take it for a formula.
std::string csv_cell(std::string_view text, char separator = ',');

}  // namespace hoist::db
