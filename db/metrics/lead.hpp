// How the patient leads: the lean against the dead band, setting off, stopping, and losses of balance.
#pragma once
#include <optional>
#include <vector>

#include "db/metrics/no_figure.hpp"
#include "db/metrics/walk.hpp"

namespace hoist::db {

/// Standing before a start, and after a stop.
inline constexpr double kRest_s = 0.5, kStopped_m_s = 0.01;
/// The way that makes an effort per metre one.
inline constexpr double kLedLeast_m = 1.0;
/// A loss of balance: beyond this share of the lean's range and, over so long, faster outwards than the walk's own median by four deviations
/// (median absolute deviation times 1.4826). Those closer together than a second are one.
inline constexpr double kBalanceShare_norm = 0.7, kBalanceOver_s = 0.1, kBalanceDeviations = 4.0, kBalanceApart_s = 1.0;
/// Less says nothing of what is usual.
inline constexpr double kBalanceLeast_s = 20.0;

struct Lead {
  NoFigure why = NoFigure::not_led;  ///< none: the patient led and the lean can be judged
  std::optional<double> dead_band_norm, effort_s_m;
  std::vector<double> latencies_s, stopping_m;  ///< of each start and each stop
  NoFigure why_no_balance = NoFigure::not_led;
  int balance_events = 0;
};
[[nodiscard]] Lead lead_of(const Walk& walk, const std::vector<Stretch>& bouts);

}  // namespace hoist::db
