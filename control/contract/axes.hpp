// Typed view of axes.def.
#pragma once
#include <array>
#include <string_view>

#include "control/contract/check.hpp"
#include "control/contract/signals.hpp"

namespace hoist::contract {

/// The frame of every value, in a sentence.
inline constexpr std::string_view kAxesText = "x forward, y left, z up; alpha > 0 leans forward, beta > 0 leans right, psi > 0 turns left";

namespace axis_meaning {
#define HOIST_AXIS(id, meaning) inline constexpr std::string_view id = meaning;
#define HOIST_SIGNAL_AXIS(signal, axis)
#include "control/contract/axes.def"
#undef HOIST_AXIS
#undef HOIST_SIGNAL_AXIS
}  // namespace axis_meaning

struct SignalAxis {
  std::string_view signal, meaning;
};
inline constexpr std::array kSignalAxes{
#define HOIST_AXIS(id, meaning)
#define HOIST_SIGNAL_AXIS(signal, axis) SignalAxis{#signal, axis_meaning::axis},
#include "control/contract/axes.def"
#undef HOIST_AXIS
#undef HOIST_SIGNAL_AXIS
};
static_assert(unique_by(kSignalAxes, [](const SignalAxis& row) { return row.signal; }), "axes.def: a live value has two directions");
static_assert(all_rows(kSignalAxes, [](const SignalAxis& row) { return find_signal(row.signal).has_value(); }),
              "axes.def: there is no such live value");

/// What a positive number of this live value means; empty when it has no direction.
constexpr std::string_view axis_of(std::string_view signal) {
  for (const SignalAxis& row : kSignalAxes)
    if (row.signal == signal) return row.meaning;
  return {};
}

}  // namespace hoist::contract
