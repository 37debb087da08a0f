// The stride, from the sideways sway of the harness: it repeats once a stride (Moe-Nilssen & Helbostad 2004).
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "db/metrics/no_figure.hpp"
#include "db/metrics/walk.hpp"

namespace hoist::db {

/// Strides below which cadence and regularity, and those below which variability and asymmetry are not given.
inline constexpr std::size_t kFewestStrides = 8, kFewestForSpread = 20;
/// A sway smaller than this, root mean square, or less alike from stride to stride (autocorrelation), shows no stride.
inline constexpr double kLeastSway_m = 0.002, kLeastRegularity = 0.3;
/// Of each bout, this much at both ends is setting off and stopping.
inline constexpr double kSettle_s = 2.0;

struct Rhythm {
  NoFigure why = NoFigure::no_motion;  ///< none: the next three are there
  double stride_s = 0;                 ///< first main peak of the autocorrelation A
  double stride_regularity = 0;        ///< A(T) / A(0)
  double step_regularity = 0;          ///< |A(T/2)| / A(0): half a stride later the sway is on the other side
  /// Of each stride, by upward crossings of the middle: standard deviation by the mean.
  double stride_time_cv = 0;
  /// How much longer the mean stride takes from right to left than back, as a share of their mean.
  double asymmetry = 0;
  NoFigure why_no_spread = NoFigure::no_motion;  ///< none: stride_time_cv and asymmetry may be used
};

/// The sway of steady walking, sample by sample: about its mean over `half` samples to either side, without the ends of each bout.
class SwayStream {
 public:
  explicit SwayStream(std::size_t half) : half_(half) {}
  /// The next sample that counts. Gives what is known of the sway now, perhaps nothing: values that follow each other, and the place of the
  /// first one in its stretch of steady walking.
  struct Piece {
    std::size_t place = 0;
    std::vector<double> sway_m;
  };
  const Piece& add(const WalkSample& sample);

 private:
  static constexpr std::size_t kWindow = 512;  // samples
  std::size_t half_;
  FastRun run_;
  // By place in the bout modulo kWindow: the samples, and the sum of all before.
  std::array<double, kWindow> dy_m_{}, sum_m_{};
  std::vector<double> held_;  // until the bout is long enough
  std::size_t place_ = 0;
  Piece piece_;
};

/// Takes the samples of a walk several times: the stride must be known before strides can be told apart.
class RhythmFinder {
 public:
  /// The next sample that counts.
  void add(const WalkSample& sample);
  /// After the last sample: whether all of them are needed again, from the first one. Otherwise the result is known.
  bool again();
  [[nodiscard]] Rhythm result(const Walk& walk, bool any_bout) const;

 private:
  enum class Pass : std::uint8_t { likeness, size, strides, over };
  /// A stride takes 0.6 to 3.5 s: 34 to 200 steps a minute.
  static constexpr std::size_t kShortest = samples_in(0.6), kLongest = samples_in(3.5);
  /// A(m) is needed up to here, both sides of a peak included.
  static constexpr std::size_t kLags = kLongest + 2;
  /// Points of the mean stride.
  static constexpr std::size_t kPoints = 100;

  void add_likeness(std::size_t place, double sway_m);
  void add_stride_sample(std::size_t place, double sway_m);
  void add_stride(double from, double to);
  [[nodiscard]] double sway_at(double place) const;
  bool find_stride();
  void finish();

  Pass pass_ = Pass::likeness;
  Rhythm out_;
  // At first about its mean over three seconds, which follows bends and slow leaning.
  SwayStream sway_{samples_in(1.5)};

  // First pass. The last kLags values stand in a row from next_ on, oldest first: each is written twice, kLags apart.
  std::array<double, 2 * kLags> window_{};
  std::size_t next_ = 0, steady_ = 0, stretches_ = 0;
  std::array<double, kLags> products_{};  // [kLags - 1 - m] of A(m)

  // Second pass.
  std::size_t size_count_ = 0;
  double squares_ = 0;

  // Third pass.
  static constexpr std::size_t kKept = 1024;  // samples: more than the longest stride
  double rms_m_ = 0, stride_ = 0;             // samples
  std::array<double, kKept> kept_m_{};        // by place in the stretch, modulo kKept
  bool swung_ = false;
  std::optional<double> crossing_;
  std::size_t strides_ = 0;
  double beyond_s_ = 0, beyond2_s2_ = 0;  // sums over the strides: by how much longer than stride_s, and its square
  std::array<double, kPoints> mean_{};
};

}  // namespace hoist::db
