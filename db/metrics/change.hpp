// Whether a figure has changed by more than it varies by itself: beyond its minimal detectable change (95 %), the published one or that of the
// patient's own repeats. Since the first walk, or from one visit to the next.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace hoist::db {

/// A row of published_changes.def, for first values from `from` to below `below`. SI, as the figure.
struct PublishedChange {
  std::string_view figure;
  double from, below, minimal;
  std::string_view whom_en, whom_de;  ///< it was measured with
  std::string_view source;
};
[[nodiscard]] std::span<const PublishedChange> published_changes();

enum class NoChange : std::uint8_t {
  none,  ///< there is a change
#define HOIST_NO_CHANGE(name, text_en, text_de) name,
#include "db/metrics/no_change.def"
#undef HOIST_NO_CHANGE
};
[[nodiscard]] std::string_view no_change_name(NoChange why);  ///< empty for none

/// A valid value of a figure, of one session.
struct Measured {
  std::int64_t session = 0, visit = 0;
  double value = 0;
  std::int64_t place = 0;  ///< rises by one with each comparable walk of the visit, also with one that has no value
};

/// Degrees of freedom that the patient's own repeats must have: walks of one exercise within a visit, one less than walks for each visit. With
/// 10 the 95 % interval of a standard deviation reaches from 0.7 to 1.8 of it, and 1.96 s is exceeded by chance in 8 % instead of 5 %; with 5
/// it would reach 2.5 times.
inline constexpr std::size_t kLeastRepeats = 10;

/// One value against an earlier one.
struct Change {
  Measured first, last;
  std::optional<double> minimal = {};          ///< minimal detectable change; none: not known
  const PublishedChange* published = nullptr;  ///< where `minimal` is from; null: the patient's own repeats
  std::size_t repeats = 0;                     ///< degrees of freedom of these
  NoChange why = NoChange::none;               ///< why no change is told
  [[nodiscard]] double difference() const { return last.value - first.value; }
};

/// 1.96 sqrt(2) s, s: standard deviation within visits, pooled over them (Haley & Fragala-Pinkham 2006). None below kLeastRepeats,
/// and where all repeats are equal: a count that never varied says nothing of how far it may.
[[nodiscard]] std::optional<double> own_minimal_change(std::span<const Measured> values);
/// The newest value against the first one. `values`: of one exercise, oldest first. Where the published change and the own one are known, the
/// larger one counts. None without a value.
[[nodiscard]] std::optional<Change> change_of(std::string_view figure, std::span<const Measured> values);
/// What was kept: the first value of the newest visit against the last one of the visit before. None without two visits.
[[nodiscard]] std::optional<Change> retention_of(std::string_view figure, std::span<const Measured> values);

}  // namespace hoist::db
