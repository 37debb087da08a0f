#include "db/metrics/lead.hpp"

#include <algorithm>
#include <cmath>

#include "db/metrics/bouts.hpp"
#include "db/metrics/comparison.hpp"

namespace hoist::db {

namespace {
using contract::Mode;

bool led(const Walk& walk, std::size_t i) { return walk.mode[i] == Mode::user; }
bool beyond(const Walk& walk, std::size_t i) { return std::fabs(walk.lean_norm[i]) > walk.settings->lean_dead_band_norm; }

// From the lean's leaving the dead band to the bout; nothing when the patient did not stand before, or leant already when the lead began.
std::optional<double> latency_of(const Walk& walk, const Stretch& whole, const Stretch& bout) {
  constexpr auto kRest = samples_in(kRest_s);
  if (bout.first < whole.first + kRest || !beyond(walk, bout.first)) return std::nullopt;
  for (std::size_t i = bout.first - kRest; i <= bout.first; ++i)
    if (!led(walk, i) || (i < bout.first && std::fabs(walk.speed_m_s[i]) > kBout_m_s)) return std::nullopt;
  std::size_t from = bout.first;
  while (from > whole.first && led(walk, from - 1) && beyond(walk, from - 1)) --from;
  if (from == whole.first || !led(walk, from - 1)) return std::nullopt;
  return static_cast<double>(bout.first - from) * kSample_s;
}

// From the lean's return into the dead band to rest; nothing when the hoist came to rest otherwise.
std::optional<double> stopping_of(const Walk& walk, const Stretch& whole, const Stretch& bout) {
  std::size_t rest = bout.end;
  while (rest < whole.end && led(walk, rest) && std::fabs(walk.speed_m_s[rest]) > kStopped_m_s) ++rest;
  if (rest >= whole.end || !led(walk, rest)) return std::nullopt;
  const double way = walk.speed_m_s[bout.end - 1] < 0 ? -1.0 : 1.0;
  std::size_t from = rest;
  while (from > bout.first && led(walk, from - 1) && way * walk.lean_norm[from - 1] <= walk.settings->lean_dead_band_norm) --from;
  if (from == bout.first || from == rest || !led(walk, from - 1)) return std::nullopt;
  double sum_m = 0;
  for (std::size_t i = from; i < rest; ++i) sum_m += std::fabs(walk.speed_m_s[i]) * kSample_s;
  return sum_m;
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

void count_balance(const Walk& walk, const std::vector<Stretch>& stretches, Lead& out) {
  constexpr auto kOver = samples_in(kBalanceOver_s);
  std::vector<double> tilt_rad(walk.count());
  for (std::size_t i = 0; i < walk.count(); ++i)
    tilt_rad[i] = std::asin(std::min(1.0, std::hypot(walk.dx_m[i], walk.dy_m[i]) / walk.settings->strut_length_m));
  std::vector<std::size_t> where;
  std::vector<double> rate_rad_s;
  for (const Stretch& whole : stretches)
    for (std::size_t i = whole.first + kOver; i < whole.end; ++i) {
      where.push_back(i);
      rate_rad_s.push_back((tilt_rad[i] - tilt_rad[i - kOver]) / kBalanceOver_s);
    }
  if (static_cast<double>(rate_rad_s.size()) * kSample_s < kBalanceLeast_s) {
    out.why_no_balance = NoFigure::too_short;
    return;
  }
  const double median = median_of(rate_rad_s);
  std::vector<double> away;
  away.reserve(rate_rad_s.size());
  for (const double rate : rate_rad_s) away.push_back(std::fabs(rate - median));
  const double limit = median + kBalanceDeviations * 1.4826 * median_of(away);
  std::optional<std::uint64_t> latest;
  for (std::size_t k = 0; k < where.size(); ++k) {
    const std::size_t i = where[k];
    if (tilt_rad[i] <= kBalanceShare_norm * walk.settings->lean_range_rad || rate_rad_s[k] <= limit) continue;
    if (!latest || walk.tick[i] - *latest >= samples_in(kBalanceApart_s)) ++out.balance_events;
    latest = walk.tick[i];
  }
  out.why_no_balance = NoFigure::none;
}

NoFigure why_not(const Walk& walk) {
  if (!walk.has_lean || !walk.has_sway || !walk.settings) return NoFigure::not_recorded;
  return walk.settings_changed ? NoFigure::settings_changed : NoFigure::none;
}
}  // namespace

Lead lead_of(const Walk& walk, const std::vector<Stretch>& bouts) {
  Lead out;
  if (walk.count() == 0) return out;
  out.why = out.why_no_balance = why_not(walk);
  if (out.why != NoFigure::none) return out;
  const std::vector<Stretch> stretches = whole_stretches(walk);
  count_balance(walk, stretches, out);
  if (missing_s(walk) > kMissingMost_s) out.why_no_balance = NoFigure::part_missing;
  double lean = 0, way_m = 0;
  std::size_t samples = 0, inside = 0;
  for (std::size_t i = 0; i < walk.count(); ++i) {
    if (!led(walk, i)) continue;
    ++samples;
    inside += beyond(walk, i) ? 0 : 1;
    lean += std::fabs(walk.lean_norm[i]) * kSample_s;
    way_m += std::fabs(walk.speed_m_s[i]) * kSample_s;
  }
  if (samples == 0) {
    out.why = NoFigure::not_led;
    return out;
  }
  out.dead_band_norm = static_cast<double>(inside) / static_cast<double>(samples);
  if (way_m >= kLedLeast_m) out.effort_s_m = lean / way_m;
  for (const Stretch& bout : bouts) {
    const auto whole = std::ranges::find_if(stretches, [&](const Stretch& s) { return s.first <= bout.first && bout.end <= s.end; });
    if (const auto latency = latency_of(walk, *whole, bout)) out.latencies_s.push_back(*latency);
    if (const auto way = stopping_of(walk, *whole, bout)) out.stopping_m.push_back(*way);
  }
  return out;
}

}  // namespace hoist::db
