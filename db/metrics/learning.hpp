// Whether a figure rises or falls from walk to walk within the visits: what is learnt while practising.
#pragma once
#include <cstddef>
#include <optional>
#include <span>

#include "db/metrics/change.hpp"

namespace hoist::db {

/// Per walk, in the figure's unit.
struct Slope {
  double middle = 0;
  double low = 0, high = 0;  ///< 95 %
};
struct Learning {
  std::size_t walks = 0, visits = 0;  ///< those of visits with at least two walks
  std::optional<Slope> slope = {};    ///< none: there are too few walks for an interval
  NoChange why = NoChange::none;      ///< why no learning is told
};

/// The median of all slopes between two walks of one visit, each visit with a level of its own (Hirsch, Slack & Smith 1982, their visits are
/// months); its interval from the exact number of pairs against the order that chance gives (Sen 1968). Equal values make the interval wider.
/// The fewest walks that tell anything: five of one visit, or two of each of six.
/// `values`: of one exercise, oldest first, in each visit with rising places. A walk without a value counts as one between two others.
[[nodiscard]] Learning learning_of(std::span<const Measured> values);

}  // namespace hoist::db
