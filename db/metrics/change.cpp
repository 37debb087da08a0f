#include "db/metrics/change.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace hoist::db {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();
constexpr std::array kPublished{
#define HOIST_PUBLISHED_CHANGE(figure, from, below, minimal, whom_en, whom_de, source) \
  PublishedChange{figure, from, below, minimal, whom_en, whom_de, source},
#include "db/metrics/published_changes.def"
#undef HOIST_PUBLISHED_CHANGE
};

const PublishedChange* published_for(std::string_view figure, double first) {
  const auto at = std::ranges::find_if(
      kPublished, [&](const PublishedChange& one) { return one.figure == figure && first >= one.from && first < one.below; });
  return at == kPublished.end() ? nullptr : &*at;
}

struct Repeats {
  double squares = 0;
  std::size_t degrees = 0;
};
// Of each visit: the squares of the distances from its mean.
Repeats repeats_in(std::span<const Measured> values) {
  struct Visit {
    double mean = 0, squares = 0;
    std::size_t count = 0;
  };
  std::map<std::int64_t, Visit> visits;
  for (const Measured& one : values) {
    Visit& visit = visits[one.visit];
    // Welford: no difference of large numbers.
    const double before = one.value - visit.mean;
    visit.mean += before / static_cast<double>(++visit.count);
    visit.squares += before * (one.value - visit.mean);
  }
  Repeats out;
  for (const auto& [id, visit] : visits) {
    out.squares += visit.squares;
    out.degrees += visit.count - 1;
  }
  return out;
}

std::optional<double> minimal_of(const Repeats& repeats) {
  constexpr double kTwoSided95 = 1.96;
  if (repeats.degrees < kLeastRepeats || repeats.squares == 0) return std::nullopt;
  return kTwoSided95 * std::sqrt(2.0 * repeats.squares / static_cast<double>(repeats.degrees));
}

// `first` and `last` are two of `values`.
Change between(std::string_view figure, std::span<const Measured> values, const Measured& first, const Measured& last) {
  Change change{.first = first, .last = last};
  const Repeats repeats = repeats_in(values);
  change.repeats = repeats.degrees;
  change.minimal = minimal_of(repeats);
  const PublishedChange* published = published_for(figure, change.first.value);
  if (published != nullptr && published->minimal >= change.minimal.value_or(0)) {
    change.published = published;
    change.minimal = published->minimal;
  }
  if (change.first.visit == change.last.visit)
    change.why = NoChange::one_visit;
  else if (!change.minimal)
    change.why = NoChange::few_repeats;
  else if (!(std::fabs(change.difference()) > *change.minimal))
    change.why = NoChange::within_noise;
  return change;
}

}  // namespace

std::span<const PublishedChange> published_changes() { return kPublished; }

std::string_view no_change_name(NoChange why) {
  switch (why) {
    case NoChange::none:
      break;
#define HOIST_NO_CHANGE(name, text_en, text_de) \
  case NoChange::name:                          \
    return #name;
#include "db/metrics/no_change.def"
#undef HOIST_NO_CHANGE
  }
  return "";
}

std::optional<double> own_minimal_change(std::span<const Measured> values) { return minimal_of(repeats_in(values)); }

std::optional<Change> change_of(std::string_view figure, std::span<const Measured> values) {
  if (values.empty()) return std::nullopt;
  return between(figure, values, values.front(), values.back());
}

std::optional<Change> retention_of(std::string_view figure, std::span<const Measured> values) {
  const auto newest =
      std::find_if(values.rbegin(), values.rend(), [&](const Measured& one) { return one.visit != values.back().visit; }).base();
  if (newest == values.begin()) return std::nullopt;
  return between(figure, values, *(newest - 1), *newest);
}

}  // namespace hoist::db
