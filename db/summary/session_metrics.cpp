#include "db/summary/session_metrics.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "control/contract/check.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/reference_path.hpp"
#include "db/metrics/evaluate.hpp"
#include "db/metrics/run_summary.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/session_reader.hpp"

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

// Where on the figure the walk began; nothing when that is not clear.
std::optional<double> start_of(const contract::ReferencePath& path, const MovingPart& part) {
  constexpr double kBegin_m = 0.25, kBegin_rad = 0.5;
  const contract::PathPose first{part.x_m.front(), part.y_m.front(), part.psi_rad.front(), 0.0};
  if (!part.from_mark) return place_on(path, first);
  const contract::PathPose start = path.pose(0.0);
  const bool there = std::hypot(first.x_m - start.x_m, first.y_m - start.y_m) <= kBegin_m &&
                     std::fabs(wrap_angle_rad(first.psi_rad - start.psi_rad)) <= kBegin_rad;
  return there ? std::optional{0.0} : std::nullopt;
}

RunColumns run_of(const MovingPart& part, double start_m) {
  return {kSample_s, part.x_m, part.y_m, part.psi_rad, part.dpsi_rad, part.tick, start_m};
}

// C, J_N, L and the deviations, or why there are none.
NoFigure compare(const contract::ReferencePath& path, const MovingPart& part, SessionMetrics& out) {
  if (part.x_m.empty()) return NoFigure::no_motion;
  if (part.several_walks) return NoFigure::several_walks;
  if (out.missing_s > kMissingMost_s) return NoFigure::part_missing;
  const std::optional<double> start_m = start_of(path, part);
  if (!start_m) return NoFigure::start_unclear;
  out.start_m = *start_m;
  const RunColumns run = run_of(part, out.start_m);
  const std::optional<Evaluation> evaluation = evaluate(path, run);
  if (!evaluation) return NoFigure::not_comparable;
  out.correlation = evaluation->c;
  if (evaluation->ise) {
    out.normalised_ise = evaluation->ise->j;
    out.path_length_m = evaluation->ise->length_m;
    if (const std::optional<RunDeviation> off = run_deviation(path, run)) {
      out.rms_position_m = off->position_rms_m;
      out.rms_heading_rad = off->heading_rms_rad;
    }
  }
  return out.correlation && out.normalised_ise ? NoFigure::none : NoFigure::too_short;
}

}  // namespace

std::string_view no_figure_name(NoFigure why) {
  constexpr std::array kNames{
      std::string_view{"none"},
#define HOIST_NO_FIGURE(name, text_en, text_de) std::string_view{#name},
#include "db/summary/no_figure.def"
#undef HOIST_NO_FIGURE
  };
  return kNames[static_cast<std::size_t>(why)];
}

std::string_view no_figure_sentence(NoFigure why) {
  constexpr std::array kSentences{
      std::string_view{},
#define HOIST_NO_FIGURE(name, text_en, text_de) std::string_view{text_en},
#include "db/summary/no_figure.def"
#undef HOIST_NO_FIGURE
  };
  return kSentences[static_cast<std::size_t>(why)];
}

Result<MovingPart> moving_part(Database& database, SessionId session) {
  // Read piece by piece, so that a long session is not refused; an hour is 10 pieces.
  constexpr double kPiece_s = 360.0;
  const SessionReader reader(database);
  const Result<SessionInfo> info = reader.get(session);
  if (!info) return info.error();
  const Result<std::vector<ColumnInfo>> recorded = reader.columns(session);
  if (!recorded) return recorded.error();
  MovingPart part;
  part.fused = std::any_of(recorded->begin(), recorded->end(), [](const ColumnInfo& column) { return column.name == "fused_psi_rad"; });
  const std::string of = part.fused ? "fused_" : "";
  std::vector<std::string> names{"mode", of + "x_m", of + "y_m", of + "psi_rad", "dpsi_rad", "speed_m_s", "standing_still", "distance_m"};
  // Older recordings have no number of the start mark; a new mark shows in the distance, which begins at zero with it.
  const bool numbered =
      std::any_of(recorded->begin(), recorded->end(), [](const ColumnInfo& column) { return column.name == "start_mark"; });
  if (numbered) names.emplace_back("start_mark");
  Result<Overview> whole = reader.overview(session, {}, 1);
  if (!whole) return whole.error();
  if (whole->from_s.empty()) return part;
  Result<std::vector<Gap>> gaps = reader.gaps(session);
  if (!gaps) return gaps.error();
  part.inputs["gaps"] = hash_of(*gaps);
  MissingSteps missing(std::move(*gaps));
  OneWalk walk;
  for (const std::string& name : names) part.inputs[name] = contract::kHashStart;
  const double end_s = whole->to_s.back();
  for (double from_s = whole->from_s.front(); from_s <= end_s; from_s += kPiece_s) {
    const Result<Columns> columns = reader.read_columns(session, names, {from_s, from_s + kPiece_s});
    if (!columns) return columns.error();
    for (std::size_t c = 0; c < names.size(); ++c) hash_column(part.inputs[names[c]], columns->tick, columns->values[c]);
    for (std::size_t i = 0; i < columns->tick.size(); ++i) {
      const auto mode = static_cast<std::size_t>(columns->values[0][i]);
      const bool moving = mode < contract::kModes.size() && contract::kModes[mode].moving;
      missing.sample(columns->tick[i], moving);
      if (!moving) continue;
      const double distance_m = columns->values[7][i];
      if (part.tick.empty()) part.from_mark = distance_m <= kAtMark_m;
      part.several_walks = walk.broken(mode, distance_m, numbered ? columns->values[8][i] : 0.0) || part.several_walks;
      part.in_motion += columns->values[6][i] == 0.0 ? 1 : 0;
      part.tick.push_back(columns->tick[i]);
      part.x_m.push_back(columns->values[1][i]);
      part.y_m.push_back(columns->values[2][i]);
      part.psi_rad.push_back(columns->values[3][i]);
      part.dpsi_rad.push_back(columns->values[4][i]);
      part.speed_m_s.push_back(columns->values[5][i]);
    }
  }
  part.missing_samples = missing.all();
  return part;
}

Result<SessionMetrics> session_metrics(Database& database, SessionId session) {
  const Result<MovingPart> part = moving_part(database, session);
  if (!part) return part.error();
  const Result<SessionInfo> info = SessionReader(database).get(session);
  if (!info) return info.error();
  SessionMetrics out;
  out.session = session;
  out.inputs = part->inputs;
  out.track = part->fused ? "fused" : "encoders";
  out.moving_samples = part->x_m.size();
  out.moving_s = static_cast<double>(out.moving_samples) * kSample_s;
  out.motion_s = static_cast<double>(part->in_motion) * kSample_s;
  out.missing_s = static_cast<double>(part->missing_samples) * kSample_s;
  for (const double speed : part->speed_m_s) {
    out.walked_m += std::fabs(speed) * kSample_s;
    out.max_speed_m_s = std::max(out.max_speed_m_s, std::fabs(speed));
  }
  out.mean_speed_m_s = out.motion_s > 0 ? out.walked_m / out.motion_s : 0;
  if (!info->exercise_json) return out;
  if (Status checked = check_exercise(*info->exercise_json); !checked)
    return Error{ErrorKind::corrupt, "session " + std::to_string(session) + ": its exercise is not one: " + checked.error().message, {}};
  out.shape = exercise_as_told(info->exercise_json)["shape"].get<std::string>();
  out.inputs["exercise"] = contract::hash_bytes(contract::kHashStart, *info->exercise_json);
  out.why_absent = compare(figure_of_stored(*info->exercise_json), *part, out);
  return out;
}

}  // namespace hoist::db
