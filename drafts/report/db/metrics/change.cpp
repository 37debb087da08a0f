#include "db/metrics/change.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "db/metrics/changes/cadence_steps_min.hpp"
#include "db/metrics/changes/walking_speed_m_s.hpp"

namespace hoist::db {
namespace {

template <std::size_t... Sizes>
constexpr auto joined(const std::array<PublishedChange, Sizes>&... parts) {
  std::array<PublishedChange, (Sizes + ...)> all{};
  auto at = all.begin();
  ((at = std::copy(parts.begin(), parts.end(), at)), ...);
  return all;
}
constexpr auto kPublished = joined(changes::kWalkingSpeed, changes::kCadence);

const PublishedChange* published_for(std::string_view figure, double first) {
  const auto at = std::ranges::find_if(
      kPublished, [&](const PublishedChange& one) { return one.figure == figure && first >= one.from && first < one.to; });
  return at == kPublished.end() ? nullptr : &*at;
}

struct Repeats {
  double squares = 0;
  std::size_t degrees = 0;
};
// Of each visit: the squares of the distances from its mean.
Repeats repeats_in(std::span<const Measured> values) {
  struct Visit {
    double sum = 0, squares = 0;
    std::size_t count = 0;
  };
  std::map<std::int64_t, Visit> visits;
  for (const Measured& one : values) {
    Visit& visit = visits[one.visit];
    // Welford: no difference of large numbers.
    const double before = visit.count > 0 ? visit.sum / static_cast<double>(visit.count) : one.value;
    visit.sum += one.value;
    ++visit.count;
    visit.squares += (one.value - before) * (one.value - visit.sum / static_cast<double>(visit.count));
  }
  Repeats out;
  for (const auto& [id, visit] : visits) {
    out.squares += visit.squares;
    out.degrees += visit.count - 1;
  }
  return out;
}

}  // namespace

std::span<const PublishedChange> published_changes() { return kPublished; }

std::string_view no_change_name(NoChange why) {
  switch (why) {
    case NoChange::none:
      return "";
#define HOIST_NO_CHANGE(name, text_en, text_de) \
  case NoChange::name:                          \
    return #name;
#include "db/metrics/no_change.def"
#undef HOIST_NO_CHANGE
  }
  return "";
}

std::optional<double> own_least_change(std::span<const Measured> values) {
  constexpr double kTwoSided95 = 1.96;
  const Repeats repeats = repeats_in(values);
  if (repeats.degrees < kLeastRepeats) return std::nullopt;
  return kTwoSided95 * std::sqrt(2.0 * repeats.squares / static_cast<double>(repeats.degrees));
}

std::optional<Change> change_of(std::string_view figure, std::span<const Measured> values) {
  if (values.empty()) return std::nullopt;
  Change change{.first = values.front(), .last = values.back()};
  change.repeats = repeats_in(values).degrees;
  change.published = published_for(figure, change.first.value);
  change.least = change.published != nullptr ? std::optional(change.published->least) : own_least_change(values);
  if (change.first.visit == change.last.visit)
    change.why = NoChange::one_visit;
  else if (!change.least)
    change.why = NoChange::few_repeats;
  else if (!(std::fabs(change.difference()) > *change.least))
    change.why = NoChange::within_noise;
  return change;
}

}  // namespace hoist::db
