// Whether a figure has changed by more than it varies by itself: the minimal detectable change with 95 % confidence, published where the
// literature has it (changes/, a file for each figure), else from the patient's own repeats.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace hoist::db {

/// A published minimal detectable change (95 %), for first values from `from` to below `to`. SI, as the figure.
struct PublishedChange {
  std::string_view figure;
  double from, to, least;
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
[[nodiscard]] std::string_view no_change_name(NoChange why);  ///< as REST tells it; empty for none

/// A valid value of a figure, of one session.
struct Measured {
  std::int64_t session = 0, visit = 0;
  double value = 0;
};

/// Degrees of freedom that the patient's own repeats must have: walks of one exercise within a visit, one less than walks for each visit. With
/// 5 the 95 % interval of a standard deviation still reaches from 0.6 to 2.5 of it; with fewer it says nothing.
inline constexpr std::size_t kLeastRepeats = 5;

/// The newest value against the first one.
struct Change {
  Measured first, last;
  std::optional<double> least;                 ///< minimal detectable change; none = not known
  const PublishedChange* published = nullptr;  ///< where `least` is from; null: the patient's own repeats
  std::size_t repeats = 0;                     ///< degrees of freedom of these
  NoChange why = NoChange::none;               ///< why no change is told
  [[nodiscard]] double difference() const { return last.value - first.value; }
};

/// 1.96 sqrt(2) s, s: standard deviation within visits, pooled over them (Haley & Fragala-Pinkham 2006). None below kLeastRepeats.
[[nodiscard]] std::optional<double> own_least_change(std::span<const Measured> values);
/// `values`: one exercise, oldest first. None without a value.
[[nodiscard]] std::optional<Change> change_of(std::string_view figure, std::span<const Measured> values);

}  // namespace hoist::db
