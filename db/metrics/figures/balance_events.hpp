// Sudden leans far out, faster than this walk's own: losses of balance and catches.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct BalanceEvents {
  static constexpr MetricInfo kInfo{
      .key = "balance_events",
      .version = 2,
      .unit = "1",
      .nullable = true,
      .inputs = "mode lean_norm dx_m dy_m speed_m_s parameter_version gaps parameters",
      .formula =
          "samples with tilt asin(sqrt(dx² + dy²) / strut_length_m) beyond 0.7 lean_range_rad whose change over 0.1 s, per second, is "
          "larger than its median + 4 × 1.4826 × its median absolute deviation; those less than 1 s apart are one",
      .gate = "20 s under way; settings not changed since the session's begin; at most 0.5 s missing",
      .source = "after near falls by trunk sensors; exploratory",
      .doc = "Sudden leans far out, faster than this walk's own: losses of balance and catches",
      .title_en = "Losses of balance",
      .title_de = "Gleichgewichtsverluste",
      .group = MetricGroup::control,
      .screen_unit = "",
      .digits = 0,
  };
  static Figure of(const Analysis& a) {
    return a.lead.why_no_balance == NoFigure::none ? figure(a.lead.balance_events) : no_figure(a.lead.why_no_balance);
  }
};

}  // namespace hoist::db::figures
