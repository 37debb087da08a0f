#include "db/summary/session_metrics.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <vector>

#include "control/contract/check.hpp"
#include "control/contract/faults.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/session_reader.hpp"
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

void hash_column(std::uint64_t& hash, const std::vector<std::uint64_t>& ticks, const std::vector<double>& values) {
  for (std::size_t i = 0; i < ticks.size(); ++i)
    hash = contract::hash_number(contract::hash_number(hash, ticks[i]), std::bit_cast<std::uint64_t>(values[i]));
}

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

// Places of the columns that are read; kNone for one that the recording does not have.
struct Places {
  static constexpr std::size_t kNone = SIZE_MAX;
  std::vector<std::string> names;
  std::size_t mode, x_m, y_m, psi_rad, dpsi_rad, dy_m, speed_m_s, standing_still, distance_m, start_mark, lean_norm, dx_m, version;

  Places(const std::vector<ColumnInfo>& recorded, bool fused) {
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
    start_mark = has(recorded, "start_mark") ? add("start_mark") : kNone;
    dy_m = has(recorded, "dy_m") ? add("dy_m") : kNone;
    lean_norm = has(recorded, "lean_norm") ? add("lean_norm") : kNone;
    dx_m = has(recorded, "dx_m") ? add("dx_m") : kNone;
    version = has(recorded, "parameter_version") ? add("parameter_version") : kNone;
  }
  static bool has(const std::vector<ColumnInfo>& recorded, std::string_view name) {
    return std::any_of(recorded.begin(), recorded.end(), [name](const ColumnInfo& column) { return column.name == name; });
  }

 private:
  std::size_t add(std::string name) {
    names.push_back(std::move(name));
    return names.size() - 1;
  }
};

// Joins the samples of a session, piece by piece.
class Joiner {
 public:
  Joiner(const Places& places, std::vector<Gap> gaps, RecordedWalk& out) : places_(places), missing_(std::move(gaps)), out_(out) {
    out_.walk.has_sway = places.dy_m != Places::kNone;
    out_.walk.has_lean = places.lean_norm != Places::kNone && places.dx_m != Places::kNone;
    for (const std::string& name : places.names) out_.inputs[name] = contract::kHashStart;
  }
  void add(const Columns& columns) {
    for (std::size_t c = 0; c < places_.names.size(); ++c) hash_column(out_.inputs[places_.names[c]], columns.tick, columns.values[c]);
    for (std::size_t i = 0; i < columns.tick.size(); ++i) add(columns, i);
  }
  void end() { out_.walk.missing_samples = missing_.all(); }

 private:
  void add(const Columns& columns, std::size_t i) {
    const auto at = [&](std::size_t place) { return place == Places::kNone ? 0.0 : columns.values[place][i]; };
    const auto mode = static_cast<std::size_t>(at(places_.mode));
    if (mode >= contract::kModes.size()) return missing_.sample(columns.tick[i], false);
    const bool moving = contract::kModes[mode].moving;
    missing_.sample(columns.tick[i], moving);
    Walk& walk = out_.walk;
    if (moving) {
      const double distance_m = at(places_.distance_m);
      if (walk.count() == 0) walk.from_mark = distance_m <= kAtMark_m;
      walk.several_walks = one_walk_.broken(mode, distance_m, at(places_.start_mark)) || walk.several_walks;
      walk.settings_changed = (walk.count() > 0 && at(places_.version) != version_) || walk.settings_changed;
      version_ = at(places_.version);
    }
    walk.add({columns.tick[i], static_cast<contract::Mode>(mode), at(places_.standing_still) != 0.0, at(places_.x_m), at(places_.y_m),
              at(places_.psi_rad), at(places_.dpsi_rad), at(places_.dy_m), at(places_.speed_m_s), at(places_.lean_norm), at(places_.dx_m)});
  }

  const Places& places_;
  MissingSteps missing_;
  OneWalk one_walk_;
  double version_ = 0;
  RecordedWalk& out_;
};

}  // namespace

const Figure& SessionMetrics::operator[](std::string_view key) const {
  for (std::size_t i = 0; i < kMetrics.size(); ++i)
    if (kMetrics[i].key == key) return figures[i];
  std::abort();
}

namespace {
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
}  // namespace

Result<RecordedWalk> recorded_walk(Database& database, SessionId session) {
  // Read piece by piece, so that a long session is not refused; an hour is 10 pieces.
  constexpr double kPiece_s = 360.0;
  const SessionReader reader(database);
  const Result<SessionInfo> info = reader.get(session);
  if (!info) return info.error();
  const Result<std::vector<ColumnInfo>> recorded = reader.columns(session);
  if (!recorded) return recorded.error();
  RecordedWalk out;
  out.fused = Places::has(*recorded, "fused_psi_rad");
  Result<Overview> whole = reader.overview(session, {}, 1);
  if (!whole) return whole.error();
  if (whole->from_s.empty()) return out;
  Result<std::vector<Gap>> gaps = reader.gaps(session);
  if (!gaps) return gaps.error();
  const auto parameters = reader.parameters(session);
  if (!parameters) return parameters.error();
  out.inputs["gaps"] = hash_of(*gaps);
  const Places places(*recorded, out.fused);
  Joiner joiner(places, std::move(*gaps), out);
  out.walk.settings = settings_of(*parameters, out.inputs);
  const double end_s = whole->to_s.back();
  for (double from_s = whole->from_s.front(); from_s <= end_s; from_s += kPiece_s) {
    const Result<Columns> columns = reader.read_columns(session, places.names, {from_s, from_s + kPiece_s});
    if (!columns) return columns.error();
    joiner.add(*columns);
  }
  joiner.end();
  return out;
}

Result<SessionMetrics> session_metrics(Database& database, SessionId session) {
  Result<RecordedWalk> recorded = recorded_walk(database, session);
  if (!recorded) return recorded.error();
  const Result<SessionInfo> info = SessionReader(database).get(session);
  if (!info) return info.error();
  SessionMetrics out;
  out.session = session;
  out.track = recorded->fused ? "fused" : "encoders";
  out.inputs = std::move(recorded->inputs);
  if (info->exercise_json) {
    if (Status checked = check_exercise(*info->exercise_json); !checked)
      return Error{ErrorKind::corrupt, "session " + std::to_string(session) + ": its exercise is not one: " + checked.error().message, {}};
    out.shape = exercise_as_told(info->exercise_json)["shape"].get<std::string>();
    out.inputs["exercise"] = contract::hash_bytes(contract::kHashStart, *info->exercise_json);
    if (const contract::ReferencePath line = figure_of_stored(*info->exercise_json); line.valid()) recorded->walk.path = line;
    if (const auto task = task_of_stored(info->exercise_json)) recorded->walk.task = WalkTask{task->ends, task->goal, task->edge_m};
  }
  const Analysis analysis = analyse(std::move(recorded->walk));
  out.figures = figures_of(analysis);
  out.start_m = analysis.comparison.start_m;
  out.why_absent = out["C"].value ? out["J_N"].why : out["C"].why;
  return out;
}

}  // namespace hoist::db
