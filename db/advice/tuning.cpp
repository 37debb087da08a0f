#include "db/advice/tuning.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "control/contract/faults.hpp"
#include "db/metrics/analysis.hpp"
#include "db/store/session_reader.hpp"
#include "db/summary/session_metrics.hpp"

namespace hoist::db {

namespace {

using contract::Mode;
using contract::ParamName;

/// Of each time of standing, this much at both ends belongs to the motion before and after it.
constexpr std::size_t kSettled = samples_in(1.0);
/// Older tilts are repetitions, not measurements: ticks.
constexpr double kFresh_ticks = 2.0;
/// Faster than this the patient walks.
constexpr double kWalks_m_s = 0.05;

constexpr std::array kColumns{"mode",
                              "standing_still",
                              "lean_norm",
                              "turn_norm",
                              "speed_m_s",
                              "fused_yaw_rate_rad_s",
                              "yaw_rate_command_rad_s",
                              "parameter_version",
                              "tilt_left_age_ticks",
                              "tilt_right_age_ticks",
                              "tilt_base_age_ticks"};

struct Sample {
  std::uint64_t tick = 0;
  Mode mode = Mode::init;
  bool still = false, fresh = false;
  double lean_norm = 0, turn_norm = 0, speed_m_s = 0, yaw_rate_rad_s = 0, yaw_command_rad_s = 0, version = 0;
};

Result<std::vector<Sample>> samples_of(const SessionReader& reader, SessionId session) {
  constexpr double kPiece_s = 360.0;
  std::vector<Sample> out;
  const Result<Overview> whole = reader.overview(session, {}, 1);
  if (!whole) return whole.error();
  if (whole->from_s.empty()) return out;
  const std::vector<std::string> names(kColumns.begin(), kColumns.end());
  const double end_s = whole->to_s.back();
  for (double from_s = whole->from_s.front(); from_s <= end_s; from_s += kPiece_s) {
    const Result<Columns> columns = reader.read_columns(session, names, {from_s, from_s + kPiece_s});
    if (!columns) return columns.error();
    for (std::size_t i = 0; i < columns->tick.size(); ++i) {
      const auto at = [&](std::size_t c) { return columns->values[c][i]; };
      out.push_back({columns->tick[i], static_cast<Mode>(static_cast<int>(at(0))), at(1) != 0,
                     at(8) <= kFresh_ticks && at(9) <= kFresh_ticks && at(10) <= kFresh_ticks, at(2), at(3), at(4), at(5), at(6), at(7)});
    }
  }
  return out;
}

double quantile(std::vector<double>& values, double share) {
  const auto place = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[static_cast<std::size_t>(place)];
}

double share_beyond(const std::vector<double>& values, double band) {
  const auto count = std::ranges::count_if(values, [band](double value) { return std::fabs(value) >= band; });
  return static_cast<double>(count) / static_cast<double>(values.size());
}

struct Standing {
  std::vector<double> lean_norm, turn_norm;
};
// Standing in standby, or standing while leading: the patient is in the harness, and no wish moves the hoist.
Standing standing_in(const std::vector<Sample>& samples) {
  Standing out;
  const auto stands = [](const Sample& s) { return s.still && s.fresh && (s.mode == Mode::standby || s.mode == Mode::user); };
  for (std::size_t first = 0; first < samples.size();) {
    std::size_t end = first;
    while (end < samples.size() && stands(samples[end]) && (end == first || samples[end].tick == samples[end - 1].tick + 1)) ++end;
    for (std::size_t i = first + kSettled; i + kSettled < end; ++i) {
      out.lean_norm.push_back(samples[i].lean_norm);
      out.turn_norm.push_back(samples[i].turn_norm);
    }
    first = std::max(end, first + 1);
  }
  return out;
}

struct Walking {
  std::size_t samples = 0, turning = 0;
  double lean_sum = 0, turn_sum = 0;
};
Walking walking_in(const std::vector<Sample>& samples) {
  Walking out;
  for (const Sample& s : samples) {
    if (s.mode != Mode::user || s.speed_m_s < kWalks_m_s) continue;
    ++out.samples;
    out.lean_sum += std::fabs(s.lean_norm);
    if (std::fabs(s.yaw_rate_rad_s) < kTurning_rad_s) continue;
    ++out.turning;
    out.turn_sum += std::fabs(s.turn_norm);
  }
  return out;
}

// Root mean square of the commanded turn rate about its mean over a stride.
std::optional<double> stray_rad_s(const std::vector<Sample>& samples, double stride_s) {
  const std::size_t half = samples_in(stride_s / 2);
  double squares = 0;
  std::size_t count = 0;
  for (std::size_t first = 0; first < samples.size();) {
    std::size_t end = first;
    const auto walks = [](const Sample& s) { return s.mode == Mode::user && s.speed_m_s >= kWalks_m_s; };
    while (end < samples.size() && walks(samples[end]) && (end == first || samples[end].tick == samples[end - 1].tick + 1)) ++end;
    double sum = 0;
    for (std::size_t i = first; i < end; ++i) {
      sum += samples[i].yaw_command_rad_s;
      if (i < first + 2 * half + 1) continue;
      sum -= samples[i - 2 * half - 1].yaw_command_rad_s;
      const double left = samples[i - half].yaw_command_rad_s - sum / static_cast<double>(2 * half + 1);
      squares += left * left;
      ++count;
    }
    first = std::max(end, first + 1);
  }
  return count == 0 ? std::nullopt : std::optional{std::sqrt(squares / static_cast<double>(count))};
}

Suggestion none(NoAdvice why) {
  Suggestion out;
  out.why = why;
  return out;
}

double in_range(ParamName param, double value) {
  const contract::ParamInfo& info = contract::kParams[contract::param_index(param)];
  return std::clamp(value, info.min, info.max);
}

// All refused for one reason.
TuningAdvice refused(SessionId session, NoAdvice why) {
  TuningAdvice out;
  out.session = session;
  for (Suggestion& suggestion : out.suggestions) suggestion = none(why);
  return out;
}

Suggestion cadence_advice(const Analysis& analysis, const std::vector<Sample>& samples, double now) {
  if (analysis.rhythm.why != NoFigure::none) return none(NoAdvice::no_rhythm);
  const std::optional<double> stray = stray_rad_s(samples, analysis.rhythm.stride_s);
  if (!stray) return none(NoAdvice::little_walking);
  Suggestion out;
  out.measured = out.effect_now = out.effect_then = *stray;
  out.now = out.suggested = now;
  // With the option on, the stray that is left says nothing of what it would be without.
  if (now > 0 || *stray < kStray_rad_s) return out;
  out.suggested = 1.0;
  out.effect_then = kStrayLeft_norm * *stray;
  return out;
}

}  // namespace

Suggestion band_advice(std::vector<double> standing_norm, double now_norm) {
  if (static_cast<double>(standing_norm.size()) * kSample_s < kLeastStanding_s) return none(NoAdvice::little_standing);
  const std::vector<double> all = standing_norm;
  const double middle = quantile(standing_norm, 0.5);
  if (std::fabs(middle) > kUprightMost_norm) return none(NoAdvice::not_upright);
  for (double& value : standing_norm) value = std::fabs(value - middle);
  Suggestion out;
  out.measured = quantile(standing_norm, 0.95);
  out.now = now_norm;
  // A millionth of a step less, so that a whole step is not raised by rounding.
  const double steps = std::ceil((1.25 * out.measured + std::fabs(middle)) / kBandStep_norm - 1e-6);
  out.suggested = std::clamp(kBandStep_norm * steps, kBandLeast_norm, kBandMost_norm);
  // One step is no difference that a patient would feel.
  if (std::fabs(out.suggested - now_norm) < 1.5 * kBandStep_norm) out.suggested = now_norm;
  out.effect_now = share_beyond(all, now_norm);
  out.effect_then = share_beyond(all, out.suggested);
  return out;
}

Suggestion gain_advice(double mean_norm, double direct_units, double filtered_units, ParamName param) {
  Suggestion out;
  out.measured = out.effect_now = out.effect_then = mean_norm;
  out.now = out.suggested = filtered_units;
  if (mean_norm >= kEaseLeast_norm && mean_norm <= kEaseMost_norm) return out;
  const double wanted = (direct_units + filtered_units) * mean_norm / kEaseAim_norm - direct_units;
  const double step = std::clamp(wanted, filtered_units * (1.0 - kGainStep_norm), filtered_units * (1.0 + kGainStep_norm));
  out.suggested = in_range(param, std::round(10.0 * step) / 10.0);
  const double then_units = direct_units + out.suggested;
  if (then_units > 0) out.effect_then = mean_norm * (direct_units + filtered_units) / then_units;
  return out;
}

Result<TuningAdvice> tuning_advice(Database& database, SessionId session) {
  const SessionReader reader(database);
  if (const Result<SessionInfo> info = reader.get(session); !info) return info.error();
  const Result<std::vector<ColumnInfo>> recorded = reader.columns(session);
  if (!recorded) return recorded.error();
  for (const char* name : kColumns)
    if (std::ranges::none_of(*recorded, [name](const ColumnInfo& column) { return column.name == name; }))
      return refused(session, NoAdvice::not_recorded);
  const auto stored = reader.parameters(session);
  if (!stored) return stored.error();
  if (stored->empty()) return refused(session, NoAdvice::not_recorded);
  contract::Params params;
  for (const auto& [name, value] : *stored)
    if (const auto index = contract::find_param(name)) contract::set_param_unchecked(params, *index, value);
  const Result<std::vector<Sample>> samples = samples_of(reader, session);
  if (!samples) return samples.error();
  if (std::ranges::any_of(*samples, [&](const Sample& s) { return s.version != samples->front().version; }))
    return refused(session, NoAdvice::settings_changed);
  Result<RecordedWalk> walk = recorded_walk(database, session);
  if (!walk) return walk.error();
  const Analysis analysis = analyse(std::move(walk->walk));
  TuningAdvice out;
  out.session = session;
  const Standing standing = standing_in(*samples);
  const Walking walking = walking_in(*samples);
  out.standing_s = static_cast<double>(standing.lean_norm.size()) * kSample_s;
  out.walking_s = static_cast<double>(walking.samples) * kSample_s;
  const bool walked = out.walking_s >= kLeastWalking_s;
  const bool turned = static_cast<double>(walking.turning) * kSample_s >= kLeastTurning_s;
  const auto mean = [](double sum, std::size_t count) { return sum / static_cast<double>(count); };
  out.suggestions = {
      band_advice(standing.lean_norm, params.lean_dead_band_norm),
      band_advice(standing.turn_norm, params.turn_dead_band_norm),
      walked ? gain_advice(mean(walking.lean_sum, walking.samples), params.lean_gain_direct_units, params.lean_gain_filtered_units,
                           ParamName::lean_gain_filtered_units)
             : none(NoAdvice::little_walking),
      turned ? gain_advice(mean(walking.turn_sum, walking.turning), params.turn_gain_direct_units, params.turn_gain_filtered_units,
                           ParamName::turn_gain_filtered_units)
             : none(NoAdvice::no_turning),
      walked ? cadence_advice(analysis, *samples, params.cadence_cancel_norm) : none(NoAdvice::little_walking),
  };
  return out;
}

}  // namespace hoist::db
