#include "db/advice/tuning.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "control/contract/faults.hpp"
#include "db/metrics/lead.hpp"
#include "db/metrics/walk.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/visits.hpp"
#include "db/summary/session_metrics.hpp"

namespace hoist::db {

// With a name: TuningReading::State, which other files know of, holds some of these.
inline namespace tuning_samples {

using contract::Mode;
using contract::ParamName;

/// Of each time of standing, this much at both ends belongs to the motion before and after it.
constexpr std::size_t kSettled = samples_in(1.0);
/// Older tilts are repetitions, not measurements: ticks.
constexpr double kFresh_ticks = 2.0;
/// Faster than this the patient walks.
constexpr double kWalks_m_s = 0.05;

constexpr std::array kUsedColumns{"mode",
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

/// Lean and turn mean the same only with the same values of these.
constexpr std::array kIntentParams{ParamName::lean_range_rad,   ParamName::turn_range_rad, ParamName::neutral_lean_m,
                                   ParamName::neutral_turn_rad, ParamName::strut_length_m, ParamName::strut_spacing_m};

struct Sample {
  std::uint64_t tick = 0;
  Mode mode = Mode::init;
  bool still = false, fresh = false;
  double lean_norm = 0, turn_norm = 0, speed_m_s = 0, yaw_rate_rad_s = 0, yaw_command_rad_s = 0, version = 0;
};

// The samples of a session in order, from this time on, piece by piece: the memory does not grow with the session.
class SampleReading {
 public:
  static Result<SampleReading> open(const SessionReader& reader, SessionId session, double begin_s) {
    const Result<Overview> whole = reader.overview(session, {}, 1);
    if (!whole) return whole.error();
    SampleReading out;
    out.session_ = session;
    if (whole->from_s.empty()) return out;
    out.next_s_ = std::max(begin_s, whole->from_s.front());
    out.end_s_ = whole->to_s.back();
    return out;
  }
  // Calls `use` with those of the next piece; false when there is none left.
  template <class Use>
  Result<bool> piece(const SessionReader& reader, Use use) {
    constexpr double kPiece_s = 120.0;
    if (next_s_ > end_s_) return false;
    const std::vector<std::string> names(kUsedColumns.begin(), kUsedColumns.end());
    const Result<Columns> columns = reader.read_columns(session_, names, {next_s_, next_s_ + kPiece_s});
    if (!columns) return columns.error();
    for (std::size_t i = 0; i < columns->tick.size(); ++i) {
      const auto at = [&](std::size_t c) { return columns->values[c][i]; };
      use(Sample{columns->tick[i], static_cast<Mode>(static_cast<int>(at(0))), at(1) != 0,
                 at(8) <= kFresh_ticks && at(9) <= kFresh_ticks && at(10) <= kFresh_ticks, at(2), at(3), at(4), at(5), at(6), at(7)});
    }
    next_s_ += kPiece_s;
    return true;
  }

 private:
  SessionId session_ = 0;
  double next_s_ = 0, end_s_ = -1;
};

/// Of the samples that go by: in standby, or while the patient leads, the wheels at rest. No wish moves the hoist then.
class StandingNoise {
 public:
  NormCounts lean, turn;

  void add(const Sample& s) {
    const bool stands = s.still && s.fresh && (s.mode == Mode::standby || s.mode == Mode::user);
    if (!stands || s.tick != next_tick_) end_stretch();
    next_tick_ = s.tick + 1;
    if (!stands) return;
    if (++samples_ <= kSettled) return;
    held_.emplace_back(s.lean_norm, s.turn_norm);
    if (held_.size() <= kSettled) return;
    lean.add(held_.front().first);
    turn.add(held_.front().second);
    held_.pop_front();
  }
  void end_stretch() {
    samples_ = 0;
    held_.clear();
  }

 private:
  std::uint64_t next_tick_ = 0;
  std::size_t samples_ = 0;
  std::deque<std::pair<double, double>> held_;  // may be the motion that follows
};

/// Lean while walking, turn of the pelvis in curves.
struct WalkingMeans {
  MeanOf lean_norm, turn_norm;
  void add(const Sample& s) {
    if (s.mode != Mode::user || s.speed_m_s < kWalks_m_s) return;
    lean_norm.add(std::fabs(s.lean_norm));
    if (std::fabs(s.yaw_rate_rad_s) >= kTurning_rad_s) turn_norm.add(std::fabs(s.turn_norm));
  }
};

/// Root mean square of the commanded turn rate about its mean over a stride.
class StrayTurn {
 public:
  explicit StrayTurn(double stride_s) : half_(samples_in(stride_s / 2)) {}
  void add(const Sample& s) {
    const bool walks = s.mode == Mode::user && s.speed_m_s >= kWalks_m_s;
    if (!walks || s.tick != next_tick_) {
      window_.clear();
      sum_ = 0;
    }
    next_tick_ = s.tick + 1;
    if (!walks) return;
    window_.push_back(s.yaw_command_rad_s);
    sum_ += s.yaw_command_rad_s;
    if (window_.size() < 2 * half_ + 1) return;
    const double left = window_[half_] - sum_ / static_cast<double>(window_.size());
    squares_.add(left * left);
    sum_ -= window_.front();
    window_.pop_front();
  }
  [[nodiscard]] std::optional<double> rms_rad_s() const {
    return squares_.count == 0 ? std::nullopt : std::optional{std::sqrt(squares_.value())};
  }

 private:
  std::size_t half_;
  std::uint64_t next_tick_ = 0;
  std::deque<double> window_;
  double sum_ = 0;
  MeanOf squares_;
};

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

Suggestion cadence_advice(const Figure& stride_s, const std::optional<StrayTurn>& stray, double now) {
  if (!stride_s.value || !stray) return none(NoAdvice::no_rhythm);
  const std::optional<double> rms_rad_s = stray->rms_rad_s();
  if (!rms_rad_s) return none(NoAdvice::little_walking);
  Suggestion out;
  out.measured = out.effect_now = out.effect_then = *rms_rad_s;
  out.now = out.suggested = now;
  // With the option on, the stray that is left says nothing of what it would be without.
  if (now > 0 || *rms_rad_s < kStray_rad_s) return out;
  out.suggested = 1.0;
  out.effect_then = kStrayLeft_norm * *rms_rad_s;
  return out;
}

// Absent: not recorded.
Result<std::optional<contract::Params>> params_of(const SessionReader& reader, SessionId session) {
  const auto stored = reader.parameters(session);
  if (!stored) return stored.error();
  if (stored->empty()) return std::optional<contract::Params>{};
  contract::Params params;
  for (const auto& [name, value] : *stored)
    if (const auto index = contract::find_param(name)) contract::set_param_unchecked(params, *index, value);
  return std::optional{params};
}

Result<bool> has_columns(const SessionReader& reader, SessionId session) {
  const Result<std::vector<ColumnInfo>> recorded = reader.columns(session);
  if (!recorded) return recorded.error();
  return std::ranges::all_of(kUsedColumns, [&](std::string_view name) {
    return std::ranges::any_of(*recorded, [name](const ColumnInfo& column) { return column.name == name; });
  });
}

// The patient's standby that ended where this session began; nothing without one, or with another meaning of lean and turn.
Result<std::optional<SessionInfo>> standby_before(Database& database, const SessionInfo& session, const contract::Params& params) {
  const SessionReader reader(database);
  const std::array asked{session.id};
  const auto visits = VisitReader(database).of_sessions(asked);
  if (!visits) return visits.error();
  if (visits->empty()) return std::optional<SessionInfo>{};
  const Result<VisitInfo> visit = VisitReader(database).visit(visits->begin()->second.id);
  if (!visit) return visit.error();
  for (const SessionId id : visit->standby) {
    Result<SessionInfo> info = reader.get(id);
    if (!info) return info.error();
    const double end_ns = static_cast<double>(info->start_time_ns) + info->duration_s * 1e9;
    const double apart_s = (static_cast<double>(session.start_time_ns) - end_ns) * 1e-9;
    if (info->core_start_time_ns != session.core_start_time_ns || apart_s < -0.5 || apart_s > kStandbyApart_s) continue;
    const Result<bool> whole = has_columns(reader, id);
    if (!whole) return whole.error();
    const auto then = params_of(reader, id);
    if (!then) return then.error();
    const auto same = [&](ParamName name) {
      const std::size_t index = contract::param_index(name);
      return contract::get_param(**then, index) == contract::get_param(params, index);
    };
    if (*whole && *then && std::ranges::all_of(kIntentParams, same)) return std::optional{std::move(*info)};
  }
  return std::optional<SessionInfo>{};
}

/// What the samples of a session say.
struct Measured {
  StandingNoise standing;
  WalkingMeans walking;
  std::optional<StrayTurn> stray;
  bool settings_changed = false;
};

// Of the time just before the walk: earlier, the patient was perhaps not yet in the harness.
Status add_standby(Database& database, const SessionInfo& session, const contract::Params& params, StandingNoise& standing) {
  const auto before = standby_before(database, session, params);
  if (!before || !*before) return before ? Status() : before.error();
  const SessionReader reader(database);
  auto samples = SampleReading::open(reader, (*before)->id, (*before)->duration_s - kStandbyLast_s);
  if (!samples) return samples.error();
  for (;;) {
    const auto more = samples->piece(reader, [&standing](const Sample& s) { standing.add(s); });
    if (!more) return more.error();
    if (!*more) break;
  }
  standing.end_stretch();
  return {};
}

TuningAdvice advice_from(SessionId session, const contract::Params& now, const Figure& stride_s, const Measured& measured) {
  if (measured.settings_changed) return refused(session, NoAdvice::settings_changed);
  TuningAdvice out;
  out.session = session;
  const auto& [lean, turn] = measured.walking;
  out.standing_s = static_cast<double>(measured.standing.lean.count()) * kSample_s;
  out.walking_s = static_cast<double>(lean.count) * kSample_s;
  const bool walked = out.walking_s >= kLeastWalking_s;
  const bool turned = static_cast<double>(turn.count) * kSample_s >= kLeastTurning_s;
  out.suggestions = {
      band_advice(measured.standing.lean, now.lean_dead_band_norm),
      band_advice(measured.standing.turn, now.turn_dead_band_norm),
      walked ? gain_advice(lean.value(), now.lean_gain_direct_units, now.lean_gain_filtered_units, ParamName::lean_gain_filtered_units)
             : none(NoAdvice::little_walking),
      turned ? gain_advice(turn.value(), now.turn_gain_direct_units, now.turn_gain_filtered_units, ParamName::turn_gain_filtered_units)
             : none(NoAdvice::no_turning),
      walked ? cadence_advice(stride_s, measured.stray, now.cadence_cancel_norm) : none(NoAdvice::little_walking),
  };
  return out;
}

}  // namespace tuning_samples

void NormCounts::add(double norm) {
  const double place = std::round(std::clamp(norm, -1.0, 1.0) * kSteps);
  ++counts_[static_cast<std::size_t>(place + kSteps)];
  ++count_;
}

double NormCounts::middle() const {
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i)
    if ((seen += counts_[i]) > (count_ - 1) / 2) return (static_cast<double>(i) - kSteps) / kSteps;
  return 0;
}

double NormCounts::apart(double share) const {
  const auto rank = static_cast<std::uint64_t>(share * static_cast<double>(count_ - 1));
  const auto centre = static_cast<std::ptrdiff_t>(std::lround(middle() * kSteps + kSteps));
  const auto size = static_cast<std::ptrdiff_t>(counts_.size());
  std::uint64_t seen = 0;
  for (std::ptrdiff_t apart = 0; apart < size; ++apart) {
    if (centre + apart < size) seen += counts_[static_cast<std::size_t>(centre + apart)];
    if (apart > 0 && centre - apart >= 0) seen += counts_[static_cast<std::size_t>(centre - apart)];
    if (seen > rank) return static_cast<double>(apart) / kSteps;
  }
  return 0;
}

double NormCounts::share_beyond(double band_norm) const {
  std::uint64_t beyond = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i)
    if (std::fabs(static_cast<double>(i) - kSteps) >= band_norm * kSteps - 1e-6) beyond += counts_[i];
  return static_cast<double>(beyond) / static_cast<double>(count_);
}

Suggestion band_advice(const NormCounts& standing, double now_norm) {
  if (static_cast<double>(standing.count()) * kSample_s < kLeastStanding_s) return none(NoAdvice::little_standing);
  const double middle = standing.middle();
  if (std::fabs(middle) > kUprightMost_norm) return none(NoAdvice::not_upright);
  Suggestion out;
  out.measured = standing.apart(0.95);
  if (out.measured < kLeastSway_norm) return none(NoAdvice::no_sway);
  out.now = now_norm;
  // A millionth of a step less, so that a whole step is not raised by rounding.
  const double steps = std::ceil((1.25 * out.measured + std::fabs(middle)) / kBandStep_norm - 1e-6);
  out.suggested = std::clamp(kBandStep_norm * steps, kBandLeast_norm, kBandMost_norm);
  // One step is no difference that a patient would feel.
  if (std::fabs(out.suggested - now_norm) < 1.5 * kBandStep_norm) out.suggested = now_norm;
  out.effect_now = standing.share_beyond(now_norm);
  out.effect_then = standing.share_beyond(out.suggested);
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

struct TuningReading::State {
  explicit State(MetricsReading reading) : metrics(std::move(reading)) {}

  Result<bool> piece(Database& database) {
    const SessionInfo& session = metrics.info();
    if (!params) return false;
    if (!samples) return begin(database, session);
    const Result<bool> more = samples->piece(SessionReader(database), [this](const Sample& s) { add(s); });
    if (!more || *more) return more;
    out = advice_from(session.id, *params, stride_s, measured);
    return false;
  }
  // Figures first: how long a stride is.
  Result<bool> begin(Database& database, const SessionInfo& session) {
    const Result<bool> more = metrics.piece(database);
    if (!more || *more) return more;
    stride_s = metrics.take()["stride_time_s"];
    if (stride_s.value) measured.stray.emplace(*stride_s.value);
    if (!session.standby)
      if (const Status added = add_standby(database, session, *params, measured.standing); !added) return added.error();
    auto opened = SampleReading::open(SessionReader(database), session.id, -1e18);
    if (!opened) return opened.error();
    samples = *opened;
    return true;
  }
  void add(const Sample& s) {
    measured.settings_changed = measured.settings_changed || (version && *version != s.version);
    version = s.version;
    measured.standing.add(s);
    measured.walking.add(s);
    if (measured.stray) measured.stray->add(s);
  }

  MetricsReading metrics;
  std::optional<contract::Params> params;  // absent: `out` is there from the start
  Figure stride_s;
  Measured measured;
  std::optional<SampleReading> samples;
  std::optional<double> version;
  TuningAdvice out;
};

TuningReading::TuningReading(std::unique_ptr<State> state) : state_(std::move(state)) {}
TuningReading::TuningReading(TuningReading&&) noexcept = default;
TuningReading& TuningReading::operator=(TuningReading&&) noexcept = default;
TuningReading::~TuningReading() = default;

Result<TuningReading> TuningReading::open(Database& database, SessionId session) {
  auto metrics = MetricsReading::open(database, session);
  if (!metrics) return metrics.error();
  const SessionReader reader(database);
  const Result<bool> whole = has_columns(reader, session);
  if (!whole) return whole.error();
  auto params = params_of(reader, session);
  if (!params) return params.error();
  auto state = std::make_unique<State>(std::move(*metrics));
  if (*whole && *params)
    state->params = **params;
  else
    state->out = refused(session, NoAdvice::not_recorded);
  return TuningReading(std::move(state));
}
Result<bool> TuningReading::piece(Database& database) { return state_->piece(database); }
TuningAdvice TuningReading::take() { return state_->out; }

Result<TuningAdvice> tuning_advice(Database& database, SessionId session) {
  auto reading = TuningReading::open(database, session);
  if (!reading) return reading.error();
  return read_whole(database, *reading);
}

}  // namespace hoist::db
