// The patient's preference between two sets of settings, and the set to try next. Advice only: a therapist sets each set, and the patient
// walks with it for a while before answering.
//
// One setting at a time, in the order of kPreferred: up by a fifth of its starting value, again while that is better; else down the same way.
// When all have been tried, once more with half of the step. "Same" keeps the set before. So each answer has one cause, and a set never
// leaves kPreferenceReach around the set at the start, nor a parameter's range. A search of this kind finds what is better nearby, not what is
// best, and one answer of a person may be chance (field.md 4, preference tuner).
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "control/contract/params.hpp"

namespace hoist::db {

/// The settings that are compared: of therapists, changed while the patient walks.
inline constexpr std::array kPreferred{contract::ParamName::lean_gain_filtered_units, contract::ParamName::lean_tau_normal_s,
                                       contract::ParamName::turn_gain_filtered_units, contract::ParamName::turn_tau_normal_s};
/// In the order of kPreferred, SI units.
using PreferenceSet = std::array<double, kPreferred.size()>;

/// Of the new set against the one before.
enum class Preference : std::uint8_t { better, worse, same };
inline constexpr std::array<std::string_view, 3> kPreferenceNames{"better", "worse", "same"};

/// Share of a starting value: first and second step, and how far from it a value may come.
inline constexpr std::array kPreferenceSteps_norm{0.20, 0.10};
inline constexpr double kPreferenceReach_norm = 0.40;

struct PreferenceState {
  PreferenceSet best{};      ///< liked best so far
  PreferenceSet next{};      ///< to try against it; equal to it when finished
  bool finished = false;     ///< nothing nearby is left to try
  std::size_t changed = 0;   ///< which of kPreferred `next` changes
  std::size_t answered = 0;  ///< answers that were used; more are refused by the caller
};

/// The same start and answers give the same state.
[[nodiscard]] PreferenceState preference_after(const PreferenceSet& start, std::span<const Preference> answers);

}  // namespace hoist::db
