#include "db/summary/session_metrics.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "control/contract/check.hpp"
#include "control/contract/faults.hpp"
#include "db/metrics/analysis.hpp"
#include "db/store/chunk_source.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/tasks.hpp"

namespace hoist::db {
// With a name: MetricsReading::State, which other files know of, holds some of these.
inline namespace session_figures {

// Adds up the steps missing in gaps that touch motion, while the samples go by.
class MissingSteps {
 public:
  explicit MissingSteps(std::vector<Gap> gaps) : gaps_(std::move(gaps)) {
    std::erase_if(gaps_, [](const Gap& gap) { return gap.stream != "ticks"; });
    std::ranges::sort(gaps_, {}, &Gap::from_tick);
  }
  void sample(std::uint64_t tick, bool moving) {
    for (; next_ < gaps_.size() && gaps_[next_].from_tick < tick; ++next_) add(moving || moving_);
    moving_ = moving;
  }
  std::uint64_t all() {
    for (; next_ < gaps_.size(); ++next_) add(moving_);
    return missing_;
  }

 private:
  void add(bool counts) {
    if (counts) missing_ += gaps_[next_].to_tick - gaps_[next_].from_tick + 1;
  }
  std::vector<Gap> gaps_;
  std::size_t next_ = 0;
  bool moving_ = false;
  std::uint64_t missing_ = 0;
};

std::uint64_t hash_of(const std::vector<Gap>& gaps) {
  std::uint64_t hash = contract::kHashStart;
  for (const Gap& gap : gaps)
    hash = contract::hash_number(contract::hash_number(contract::hash_bytes(hash, gap.stream), gap.from_tick), gap.to_tick);
  return hash;
}

// Samples of one piece: a few milliseconds' work. More than one chunk, because each piece prepares its statements.
constexpr std::size_t kPieceSamples = 30'000;

/// From here on a walk that has not been recorded before lies between mark and sample.
constexpr double kAtMark_m = 0.05;

// Whether the samples that go by belong to one walk: one start mark, one mode in charge.
class OneWalk {
 public:
  bool broken(std::size_t mode, double distance_m, double mark) {
    const bool other = known_ && (mode != mode_ || mark != mark_ || distance_m < distance_m_);
    known_ = true;
    mode_ = mode;
    distance_m_ = distance_m;
    mark_ = mark;
    return other;
  }

 private:
  bool known_ = false;
  std::size_t mode_ = 0;
  double distance_m_ = 0, mark_ = 0;
};

// The columns that are read; kNone for one that the recording does not have.
struct Places {
  static constexpr std::size_t kNone = SIZE_MAX;
  std::vector<std::string> names;
  std::size_t mode, x_m, y_m, psi_rad, dpsi_rad, dy_m, speed_m_s, standing_still, distance_m, start_mark, lean_norm, dx_m, version;

  Places(std::span<const ColumnInfo> recorded, bool fused) {
    const std::string of = fused ? "fused_" : "";
    mode = add("mode");
    x_m = add(of + "x_m");
    y_m = add(of + "y_m");
    psi_rad = add(of + "psi_rad");
    dpsi_rad = add("dpsi_rad");
    speed_m_s = add("speed_m_s");
    standing_still = add("standing_still");
    distance_m = add("distance_m");
    // Older recordings have no number of the start mark; a new mark shows in the distance, which begins at zero with it.
    start_mark = find_column(recorded, "start_mark") ? add("start_mark") : kNone;
    dy_m = find_column(recorded, "dy_m") ? add("dy_m") : kNone;
    lean_norm = find_column(recorded, "lean_norm") ? add("lean_norm") : kNone;
    dx_m = find_column(recorded, "dx_m") ? add("dx_m") : kNone;
    version = find_column(recorded, "parameter_version") ? add("parameter_version") : kNone;
  }

 private:
  std::size_t add(std::string name) {
    names.push_back(std::move(name));
    return names.size() - 1;
  }
};

// The stored samples of a session, piece by piece: what is recorded or folded meanwhile changes nothing. Nothing of the database is held between
// two pieces. Throws SqlFailure.
class StoredWalk {
 public:
  StoredWalk(Database& database, const SessionInfo& session, std::span<const ColumnInfo> layout, const Places& places)
      : session_(session.id), started_utc_ns_(session.started_utc_ns), columns_(layout.size()) {
    for (const std::string_view name : {std::string_view("tick"), std::string_view("time_ns")}) add(layout, name);
    for (const std::string& name : places.names) add(layout, name);
    Statement newest(database.handle(), "SELECT max(last_tick) FROM chunks WHERE session_id = ?1");
    if (newest.integer(1, session_).step() && !newest.is_null(0)) last_tick_ = newest.unsigned_at(0);
  }
  [[nodiscard]] bool empty() const { return !last_tick_; }
  void rewind() { next_tick_ = 0; }

  // Calls `use(tick, values)` with the next samples, the values in the order of Places; false after the last ones.
  template <typename Use>
  bool piece(Database& database, Use use) {
    const Transaction transaction(database.handle(), Transaction::Kind::read);
    check_there(database.handle());
    ChunkSource source(database.handle(), session_, columns_);
    for (std::size_t read = 0; read < kPieceSamples && next_tick_ <= *last_tick_; read += stored_[0].size()) {
      const std::optional<StoredChunk> chunk = source.at_or_after(next_tick_);
      if (!chunk || chunk->first_tick > *last_tick_) return false;
      source.load(*chunk, which_, stored_);
      give(use);
      next_tick_ = chunk->last_tick + 1;
    }
    return next_tick_ <= *last_tick_;
  }

 private:
  void add(std::span<const ColumnInfo> layout, std::string_view name) {
    const auto found = find_column(layout, name);
    if (!found) throw SqlFailure{Error{ErrorKind::bad_value, "this session has no column " + std::string(name), "columns"}};
    which_.push_back(*found);
    scale_.push_back(decimal_scale(layout[*found].decimals));
  }
  // Between two pieces the session may be deleted, or a backup with another session of this number put in the place of the file.
  void check_there(sqlite3* handle) const {
    Statement row(handle, "SELECT 1 FROM sessions WHERE id = ?1 AND started_utc_ns = ?2");
    if (!row.integer(1, session_).integer(2, started_utc_ns_).step())
      throw SqlFailure{Error{ErrorKind::not_found, "session " + std::to_string(session_) + " was deleted meanwhile", {}}};
  }
  template <typename Use>
  void give(Use& use) {
    std::vector<double> values(which_.size() - 2);
    for (std::size_t i = 0; i < stored_[0].size(); ++i) {
      const auto tick = static_cast<std::uint64_t>(stored_[0][i]);
      if (tick < next_tick_ || tick > *last_tick_) continue;
      for (std::size_t c = 0; c < values.size(); ++c) values[c] = static_cast<double>(stored_[c + 2][i]) / scale_[c + 2];
      use(tick, std::span<const double>(values));
    }
  }
  SessionId session_;
  std::int64_t started_utc_ns_;
  std::size_t columns_;
  std::vector<std::size_t> which_;  // tick, time_ns, then the others
  std::vector<double> scale_;
  std::vector<std::vector<std::int64_t>> stored_;
  std::optional<std::uint64_t> last_tick_;
  std::uint64_t next_tick_ = 0;
};

std::optional<WalkSample> sample_of(const Places& places, std::uint64_t tick, std::span<const double> values) {
  const auto at = [&](std::size_t place) { return place == Places::kNone ? 0.0 : values[place]; };
  const auto mode = static_cast<std::size_t>(at(places.mode));
  if (mode >= contract::kModes.size()) return std::nullopt;
  return WalkSample{tick,
                    static_cast<contract::Mode>(mode),
                    at(places.standing_still) != 0.0,
                    at(places.x_m),
                    at(places.y_m),
                    at(places.psi_rad),
                    at(places.dpsi_rad),
                    at(places.dy_m),
                    at(places.speed_m_s),
                    at(places.lean_norm),
                    at(places.dx_m)};
}

// The first reading of a walk: what was read, and how the samples belong together.
class FirstReading {
 public:
  FirstReading(const Places& places, std::vector<Gap> gaps, Analyser& analyser)
      : places_(places), missing_(std::move(gaps)), analyser_(analyser), hashes_(places.names.size(), contract::kHashStart) {
    analyser_.walk().has_sway = places.dy_m != Places::kNone;
    analyser_.walk().has_lean = places.lean_norm != Places::kNone && places.dx_m != Places::kNone;
  }
  void add(std::uint64_t tick, std::span<const double> values) {
    for (std::size_t c = 0; c < values.size(); ++c)
      hashes_[c] = contract::hash_number(contract::hash_number(hashes_[c], tick), std::bit_cast<std::uint64_t>(values[c]));
    if (!version_) version_ = version_in(values);
    const std::optional<WalkSample> sample = sample_of(places_, tick, values);
    missing_.sample(tick, sample && counts(*sample));
    if (!sample) return;
    if (counts(*sample)) join(*sample, values);
    analyser_.add(*sample);
  }
  void end(InputHashes& inputs) {
    analyser_.walk().missing_samples = missing_.all();
    for (std::size_t c = 0; c < hashes_.size(); ++c) inputs[places_.names[c]] = hashes_[c];
  }

 private:
  void join(const WalkSample& sample, std::span<const double> values) {
    Walk& walk = analyser_.walk();
    const double distance_m = values[places_.distance_m];
    const double mark = places_.start_mark == Places::kNone ? 0.0 : values[places_.start_mark];
    if (walk.samples == 0) walk.from_mark = distance_m <= kAtMark_m;
    walk.several_walks = one_walk_.broken(static_cast<std::size_t>(sample.mode), distance_m, mark) || walk.several_walks;
    walk.settings_changed = version_in(values) != *version_ || walk.settings_changed;
  }
  [[nodiscard]] double version_in(std::span<const double> values) const {
    return places_.version == Places::kNone ? 0.0 : values[places_.version];
  }

  const Places& places_;
  MissingSteps missing_;
  OneWalk one_walk_;
  std::optional<double> version_;  // of the settings at the session's begin, also in standby
  Analyser& analyser_;
  std::vector<std::uint64_t> hashes_;
};

// The parameters that figures refer to. Nothing where one is not recorded.
std::optional<WalkSettings> settings_of(const std::vector<std::pair<std::string, double>>& parameters, InputHashes& inputs) {
  WalkSettings settings;
  std::uint64_t hash = contract::kHashStart;
  for (const auto& [name, place] :
       {std::pair{"lean_dead_band_norm", &settings.lean_dead_band_norm}, std::pair{"lean_range_rad", &settings.lean_range_rad},
        std::pair{"strut_length_m", &settings.strut_length_m}}) {
    const auto row = std::ranges::find(parameters, name, &std::pair<std::string, double>::first);
    if (row == parameters.end()) return std::nullopt;
    *place = row->second;
    hash = contract::hash_number(contract::hash_bytes(hash, name), std::bit_cast<std::uint64_t>(row->second));
  }
  inputs["parameters"] = hash;
  return settings;
}

}  // namespace session_figures

const Figure& SessionMetrics::operator[](std::string_view key) const {
  for (std::size_t i = 0; i < kMetrics.size(); ++i)
    if (kMetrics[i].key == key) return figures[i];
  std::abort();
}

struct MetricsReading::State {
  State(Database& database, SessionInfo of, std::span<const ColumnInfo> layout)
      : info(std::move(of)), places(layout, find_column(layout, "fused_psi_rad").has_value()), stored(database, info, layout, places) {}

  bool piece(Database& database) {
    if (!stored.empty() && stored.piece(database, [this](std::uint64_t tick, std::span<const double> values) { add(tick, values); }))
      return true;
    if (first) first->end(out.inputs);
    first.reset();
    if (!stored.empty() && analyser->again()) {
      stored.rewind();
      return true;
    }
    const Analysis analysis = analyser->result();
    out.figures = figures_of(analysis);
    out.start_m = analysis.comparison.start_m;
    out.why_absent = out["C"].value ? out["J_N"].why : out["C"].why;
    return false;
  }
  void add(std::uint64_t tick, std::span<const double> values) {
    if (first)
      first->add(tick, values);
    else if (const auto sample = sample_of(places, tick, values))
      analyser->add(*sample);
  }

  SessionInfo info;
  Places places;
  StoredWalk stored;
  SessionMetrics out;
  std::optional<Analyser> analyser;
  std::optional<FirstReading> first;  // during the first reading
};

MetricsReading::MetricsReading(std::unique_ptr<State> state) : state_(std::move(state)) {}
MetricsReading::MetricsReading(MetricsReading&&) noexcept = default;
MetricsReading& MetricsReading::operator=(MetricsReading&&) noexcept = default;
MetricsReading::~MetricsReading() = default;

Result<MetricsReading> MetricsReading::open(Database& database, SessionId session) {
  return guarded([&]() -> Result<MetricsReading> {
    const SessionReader reader(database);
    const Result<SessionInfo> info = reader.get(session);
    if (!info) return info.error();
    const Result<std::vector<ColumnInfo>> layout = reader.columns(session);
    if (!layout) return layout.error();
    auto state = std::make_unique<State>(database, *info, *layout);
    SessionMetrics& out = state->out;
    out.session = session;
    out.track = find_column(*layout, "fused_psi_rad") ? "fused" : "encoders";
    std::optional<contract::ReferencePath> path;
    std::optional<WalkTask> task;
    if (info->exercise_json) {
      if (Status checked = check_exercise(*info->exercise_json); !checked)
        return Error{
            ErrorKind::corrupt, "session " + std::to_string(session) + ": its exercise is not one: " + checked.error().message, {}};
      out.shape = exercise_as_told(info->exercise_json)["shape"].get<std::string>();
      out.inputs["exercise"] = contract::hash_bytes(contract::kHashStart, *info->exercise_json);
      if (const contract::ReferencePath line = figure_of_stored(*info->exercise_json); line.valid()) path = line;
      if (const auto stored = task_of_stored(info->exercise_json)) task = WalkTask{stored->ends, stored->goal, stored->edge_m};
    }
    const auto parameters = reader.parameters(session);
    if (!parameters) return parameters.error();
    state->analyser.emplace(path, task, info->sample_count > 0 ? settings_of(*parameters, out.inputs) : std::nullopt);
    if (!state->stored.empty()) {
      Result<std::vector<Gap>> gaps = reader.gaps(session);
      if (!gaps) return gaps.error();
      out.inputs["gaps"] = hash_of(*gaps);
      state->first.emplace(state->places, std::move(*gaps), *state->analyser);
    }
    return MetricsReading(std::move(state));
  });
}

Result<bool> MetricsReading::piece(Database& database) {
  return guarded([&]() -> Result<bool> { return state_->piece(database); });
}
SessionMetrics MetricsReading::take() { return std::move(state_->out); }
const SessionInfo& MetricsReading::info() const { return state_->info; }

Result<SessionMetrics> session_metrics(Database& database, SessionId session) {
  auto reading = MetricsReading::open(database, session);
  if (!reading) return reading.error();
  return read_whole(database, *reading);
}

}  // namespace hoist::db
