// Suggested settings from the noise of a recorded session: how still the patient stood, how the gait swings, how far the patient leans and
// turns to walk. Advice only: nothing here changes a parameter, a person does. Each suggestion is inside its parameter's range, or refused
// with the reason.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "control/contract/params.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

/// Why a session gives no suggestion for a setting.
enum class NoAdvice : std::uint8_t {
  none,
  little_standing,
  not_upright,
  no_sway,
  little_walking,
  no_rhythm,
  no_turning,
  settings_changed,
  not_recorded
};

struct NoAdviceInfo {
  std::string_view name, text_en, text_de;
};
inline constexpr std::array kNoAdvice{
    NoAdviceInfo{"none", "", ""},
    NoAdviceInfo{"little_standing", "The patient stood still for less than 10 s.", "Der Patient stand weniger als 10 s still."},
    NoAdviceInfo{"not_upright", "The patient did not stand upright by these settings: take neutral first.",
                 "Der Patient stand nach diesen Einstellungen nicht aufrecht: Zuerst die Neutralstellung übernehmen."},
    NoAdviceInfo{"no_sway", "The harness did not sway: the patient was perhaps not in it.",
                 "Der Gurt bewegte sich nicht: Der Patient war vielleicht nicht darin."},
    NoAdviceInfo{"little_walking", "The patient led for less than 20 s of walking.", "Der Patient ging weniger als 20 s selbst geführt."},
    NoAdviceInfo{"no_rhythm", "The steps were too few or too irregular.", "Es waren zu wenige oder zu unregelmäßige Schritte."},
    NoAdviceInfo{"no_turning", "The patient led for less than 5 s of turning.", "Der Patient führte weniger als 5 s lang eine Drehung."},
    NoAdviceInfo{"settings_changed", "The settings changed during this recording.",
                 "Während dieser Aufzeichnung wurden Einstellungen geändert."},
    NoAdviceInfo{"not_recorded", "This recording lacks a value that is needed.", "Dieser Aufzeichnung fehlt ein nötiger Wert."},
};
[[nodiscard]] constexpr const NoAdviceInfo& no_advice_info(NoAdvice why) { return kNoAdvice[static_cast<std::size_t>(why)]; }

/// One suggestion: what is measured, and what follows from it.
struct TuningRule {
  contract::ParamName param;
  std::string_view measured_unit;  ///< of `measured`, `effect_now`, `effect_then`
  std::string_view formula;        ///< of the suggested value
  std::string_view reason_en, reason_de;
  std::string_view effect_en, effect_de;  ///< what effect_now and effect_then are
};

/// Bounds of the advice, narrower than those of the parameters (assumed): a dead band below kBandLeast is within the sensors' own error, one
/// above kBandMost takes more than a fifth of the patient's wish away.
inline constexpr double kBandLeast_norm = 0.03, kBandMost_norm = 0.20, kBandStep_norm = 0.01;
/// Less than this is the noise of the sensors (0.3 mrad, 0.002 of the lean) with an empty harness: a person sways ten times as far.
inline constexpr double kLeastSway_norm = 0.006;
/// Standing further from upright than this is no noise.
inline constexpr double kUprightMost_norm = 0.10;
/// A lean or turn in this range is comfortable (assumed); the suggestion aims at its aim.
inline constexpr double kEaseLeast_norm = 0.20, kEaseAim_norm = 0.30, kEaseMost_norm = 0.45;
/// A gain changes by no more than this share at once.
inline constexpr double kGainStep_norm = 0.25;
/// Stray turning of the hoist at the rhythm of the steps from which its removal is suggested; what is left of it with the option
/// (tests/loop/gait_test.cpp holds 40 %).
inline constexpr double kStray_rad_s = 0.0087266463, kStrayLeft_norm = 0.4;
inline constexpr double kLeastStanding_s = 10.0, kLeastWalking_s = 20.0, kLeastTurning_s = 5.0;
/// Standing counts also from the patient's standby before the walk, when it ended at most so long before: its last minute.
inline constexpr double kStandbyApart_s = 3.0, kStandbyLast_s = 60.0;
/// The hoist turns at more than this: 5 degrees a second.
inline constexpr double kTurning_rad_s = 0.0872664626;

inline constexpr std::array kTuningRules{
    TuningRule{contract::ParamName::lean_dead_band_norm, "",
               "1.25 q95(|u - median u|) + |median u| while standing, rounded up to 0.01, 0.03 to 0.20", "sway of the lean while standing",
               "Schwanken der Neigung im Stehen", "share of the standing time in which the hoist would react",
               "Anteil der Stehzeit, in dem das Gerät reagieren würde"},
    TuningRule{contract::ParamName::turn_dead_band_norm, "", "the same of u_psi", "sway of the pelvis turn while standing",
               "Schwanken der Beckendrehung im Stehen", "share of the standing time in which the hoist would react",
               "Anteil der Stehzeit, in dem das Gerät reagieren würde"},
    TuningRule{contract::ParamName::lean_gain_filtered_units, "",
               "(K_P + K_Pf) u / 0.30 - K_P, at most a quarter more or less; as it is while the mean lean u is 0.20 to 0.45",
               "mean lean while walking", "mittlere Neigung beim Gehen", "mean lean for the same speed",
               "mittlere Neigung bei gleicher Geschwindigkeit"},
    TuningRule{contract::ParamName::turn_gain_filtered_units, "",
               "(K_P + K_Pf) u_psi / 0.30 - K_P, at most a quarter more or less; as it is while the mean turn u_psi is 0.20 to 0.45",
               "mean turn of the pelvis in curves", "mittlere Beckendrehung in Kurven", "mean turn of the pelvis for the same curve",
               "mittlere Beckendrehung bei gleicher Kurve"},
    TuningRule{contract::ParamName::cadence_cancel_norm, "rad/s",
               "1 from 0.5 deg/s of stray turning on: root mean square of the commanded turn rate about its mean over a stride",
               "stray turning in step", "Pendeln der Drehung im Schritt", "stray turning in step", "Pendeln der Drehung im Schritt"},
};

struct Suggestion {
  NoAdvice why = NoAdvice::none;  ///< none: all below is there
  double measured = 0;            ///< what the formula is given
  double now = 0, suggested = 0;  ///< values of the parameter, SI units; equal: it may stay
  double effect_now = 0, effect_then = 0;
};
/// In the order of kTuningRules.
struct TuningAdvice {
  SessionId session = 0;
  double standing_s = 0, walking_s = 0;  ///< what it is drawn from
  std::array<Suggestion, kTuningRules.size()> suggestions;
};

/// Errors: not_found, corrupt, io. A session that cannot bear a suggestion gives its reason, not an error. Read in pieces as MetricsReading.
class TuningReading {
 public:
  static Result<TuningReading> open(Database& database, SessionId session);
  TuningReading(TuningReading&&) noexcept;
  TuningReading& operator=(TuningReading&&) noexcept;
  ~TuningReading();
  Result<bool> piece(Database& database);
  TuningAdvice take();

 private:
  struct State;
  explicit TuningReading(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};
/// In one piece.
[[nodiscard]] Result<TuningAdvice> tuning_advice(Database& database, SessionId session);

// The formulas by themselves.

/// How often lean or turn (-1 to 1) had each value, in the steps in which they are recorded. Of fixed size.
class NormCounts {
 public:
  void add(double norm);
  [[nodiscard]] std::uint64_t count() const { return count_; }
  // With a count above 0:
  [[nodiscard]] double middle() const;                        ///< median
  [[nodiscard]] double apart(double share) const;             ///< this share (0 to 1) of the values is no further from the median
  [[nodiscard]] double share_beyond(double band_norm) const;  ///< of the values, how many are that far from zero or further

 private:
  static constexpr double kSteps = 10000.0;  ///< of 1: signals.def
  std::vector<std::uint64_t> counts_ = std::vector<std::uint64_t>(20001);
  std::uint64_t count_ = 0;
};

[[nodiscard]] Suggestion band_advice(const NormCounts& standing, double now_norm);
/// `mean_norm`: mean of |lean| or |turn|; direct and filtered gain in units; `param`: the filtered gain's row.
[[nodiscard]] Suggestion gain_advice(double mean_norm, double direct_units, double filtered_units, contract::ParamName param);

}  // namespace hoist::db
