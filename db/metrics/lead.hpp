// How the patient leads: the lean against the dead band, setting off, stopping, and losses of balance. Samples come one by one, none is kept.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "db/metrics/bouts.hpp"
#include "db/metrics/median.hpp"
#include "db/metrics/no_figure.hpp"
#include "db/metrics/walk.hpp"

namespace hoist::db {

/// Parameters that figures refer to, as they were in force when the session began.
struct WalkSettings {
  double lean_dead_band_norm = 0, lean_range_rad = 0, strut_length_m = 0;
};

/// Standing before a start, and after a stop.
inline constexpr double kRest_s = 0.5, kStopped_m_s = 0.01;
/// The way that makes an effort per metre one.
inline constexpr double kLedLeast_m = 1.0;
/// A loss of balance: beyond this share of the lean's range and, over so long, faster outwards than the walk's own median by four deviations
/// (median absolute deviation times 1.4826). Those closer together than a second are one.
inline constexpr double kBalanceShare_norm = 0.7, kBalanceOver_s = 0.1, kBalanceDeviations = 4.0, kBalanceApart_s = 1.0;
/// Less says nothing of what is usual.
inline constexpr double kBalanceLeast_s = 20.0;

struct MeanOf {
  double sum = 0;
  std::uint64_t count = 0;
  void add(double value) { sum += value, ++count; }
  [[nodiscard]] double value() const { return sum / static_cast<double>(count); }
};

struct Lead {
  NoFigure why = NoFigure::not_led;  ///< none: the patient led and the lean can be judged
  std::optional<double> dead_band_norm, effort_s_m;
  MeanOf latency_s, stopping_m;  ///< of the starts and the stops
  NoFigure why_no_balance = NoFigure::not_led;
  int balance_events = 0;
};

/// Setting off and stopping.
class StartsAndStops {
 public:
  explicit StartsAndStops(const WalkSettings& settings) : settings_(settings) {}
  void add(const WalkSample& sample, Lead& out);
  void end(Lead& out);

 private:
  // From the lean's return into the dead band, for one sense of the way: the stretch of led samples inside it that ends here.
  struct Return {
    bool whole = true;  // it reaches back to the bout's begin, or to a sample that was not led
    std::size_t samples = 0;
    double way_m = 0;
    void add(bool led, bool inside, double step_m);
  };
  struct Stop {
    double way = 1;
    Return back;
  };
  void begin_bout(const WalkSample& sample);
  void end_bout();

  WalkSettings settings_;
  FastRun run_;
  std::optional<std::uint64_t> tick_;
  // Consecutive samples until here, in this stretch without gaps: all, led, slow before this one, led with the lean beyond the dead band.
  std::size_t samples_ = 0, led_ = 0, slow_ = 0, beyond_ = 0;
  std::size_t in_bout_ = 0;
  std::optional<double> latency_s_;  // of the run under way
  std::array<Return, 2> returns_;    // backward, forward
  double speed_m_s_ = 0;
  std::vector<Stop> stops_;  // bouts that have ended, before the hoist rests
};

/// Losses of balance. Takes the samples several times: what is usual must be known first.
class BalanceJudge {
 public:
  explicit BalanceJudge(const WalkSettings& settings) : settings_(settings) {}
  void add(const WalkSample& sample);
  bool again();
  [[nodiscard]] std::uint64_t rates() const { return median_.count(); }
  [[nodiscard]] int events() const { return events_; }

 private:
  enum class Pass : std::uint8_t { median, deviation, events, over };
  static constexpr std::size_t kOver = samples_in(kBalanceOver_s);
  WalkSettings settings_;
  Pass pass_ = Pass::median;
  MedianSearch median_, deviation_;
  std::optional<std::uint64_t> tick_, latest_;
  std::array<double, kOver + 1> tilt_rad_{};  // by place in the stretch, modulo its size
  std::size_t place_ = 0;
  double limit_rad_s_ = 0;
  int events_ = 0;
};

class LeadJudge {
 public:
  explicit LeadJudge(const std::optional<WalkSettings>& settings);
  /// The next sample that counts.
  void add(const WalkSample& sample);
  /// After the last sample: whether all are needed again.
  bool again();
  [[nodiscard]] Lead result(const Walk& walk) const;

 private:
  bool first_ = true;
  std::optional<WalkSettings> settings_;
  std::optional<StartsAndStops> starts_;
  std::optional<BalanceJudge> balance_;
  Lead out_;
  double lean_s_ = 0, way_m_ = 0;
  std::uint64_t led_ = 0, inside_ = 0;
};

}  // namespace hoist::db
