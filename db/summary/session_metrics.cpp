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
namespace {

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

// The stored samples of a session, chunk by chunk: what is recorded or folded meanwhile changes nothing. Throws SqlFailure.
class StoredWalk {
 public:
  StoredWalk(Database& database, SessionId session, std::span<const ColumnInfo> layout, const Places& places)
      : handle_(database.handle()), source_(handle_, session, layout.size()) {
    for (const std::string_view name : {std::string_view("tick"), std::string_view("time_ns")}) add(layout, name);
    for (const std::string& name : places.names) add(layout, name);
    Statement newest(handle_, "SELECT max(last_tick) FROM chunks WHERE session_id = ?1");
    if (newest.integer(1, session).step() && !newest.is_null(0)) last_tick_ = newest.unsigned_at(0);
  }
  [[nodiscard]] bool empty() const { return !last_tick_; }
  void rewind() { next_tick_ = 0; }

  // Calls `use(tick, values)` with the next samples, the values in the order of Places; false at the end.
  template <typename Use>
  bool next(Use use) {
    if (!last_tick_ || next_tick_ > *last_tick_) return false;
    const Transaction transaction(handle_, Transaction::Kind::read);
    const std::optional<StoredChunk> chunk = source_.at_or_after(next_tick_);
    if (!chunk || chunk->first_tick > *last_tick_) return false;
    source_.load(*chunk, which_, stored_);
    std::vector<double> values(which_.size() - 2);
    for (std::size_t i = 0; i < stored_[0].size(); ++i) {
      const auto tick = static_cast<std::uint64_t>(stored_[0][i]);
      if (tick < next_tick_ || tick > *last_tick_) continue;
      for (std::size_t c = 0; c < values.size(); ++c) values[c] = static_cast<double>(stored_[c + 2][i]) / scale_[c + 2];
      use(tick, std::span<const double>(values));
    }
    next_tick_ = chunk->last_tick + 1;
    return true;
  }

 private:
  void add(std::span<const ColumnInfo> layout, std::string_view name) {
    const auto found = find_column(layout, name);
    if (!found) throw SqlFailure{Error{ErrorKind::bad_value, "this session has no column " + std::string(name), "columns"}};
    which_.push_back(*found);
    scale_.push_back(decimal_scale(layout[*found].decimals));
  }
  sqlite3* handle_;
  ChunkSource source_;
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
    const double version = places_.version == Places::kNone ? 0.0 : values[places_.version];
    walk.settings_changed = (walk.samples > 0 && version != version_) || walk.settings_changed;
    version_ = version;
  }

  const Places& places_;
  MissingSteps missing_;
  OneWalk one_walk_;
  double version_ = 0;
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

// Reads the session as often as the analysis needs.
Analysis analysis_of(Database& database, SessionId session, std::span<const ColumnInfo> layout, Analyser& analyser, SessionMetrics& out) {
  const Places places(layout, out.track == "fused");
  StoredWalk stored(database, session, layout, places);
  if (stored.empty()) return analyser.result();
  Result<std::vector<Gap>> gaps = SessionReader(database).gaps(session);
  if (!gaps) throw SqlFailure{gaps.error()};
  out.inputs["gaps"] = hash_of(*gaps);
  FirstReading first(places, std::move(*gaps), analyser);
  while (stored.next([&](std::uint64_t tick, std::span<const double> values) { first.add(tick, values); })) continue;
  first.end(out.inputs);
  while (analyser.again()) {
    stored.rewind();
    while (stored.next([&](std::uint64_t tick, std::span<const double> values) {
      if (const auto sample = sample_of(places, tick, values)) analyser.add(*sample);
    }))
      continue;
  }
  return analyser.result();
}

}  // namespace

const Figure& SessionMetrics::operator[](std::string_view key) const {
  for (std::size_t i = 0; i < kMetrics.size(); ++i)
    if (kMetrics[i].key == key) return figures[i];
  std::abort();
}

Result<SessionMetrics> session_metrics(Database& database, SessionId session) {
  return guarded([&]() -> Result<SessionMetrics> {
    const SessionReader reader(database);
    const Result<SessionInfo> info = reader.get(session);
    if (!info) return info.error();
    const Result<std::vector<ColumnInfo>> layout = reader.columns(session);
    if (!layout) return layout.error();
    SessionMetrics out;
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
    Analyser analyser(path, task, info->sample_count > 0 ? settings_of(*parameters, out.inputs) : std::nullopt);
    const Analysis analysis = analysis_of(database, session, *layout, analyser, out);
    out.figures = figures_of(analysis);
    out.start_m = analysis.comparison.start_m;
    out.why_absent = out["C"].value ? out["J_N"].why : out["C"].why;
    return out;
  });
}

}  // namespace hoist::db
