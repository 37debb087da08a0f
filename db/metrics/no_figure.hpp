// The rows of no_figure.def, and a figure: a number, or why there is none.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace hoist::db {

enum class NoFigure : std::uint8_t {
  none,
#define HOIST_NO_FIGURE(name, text_en, text_de) name,
#include "db/metrics/no_figure.def"
#undef HOIST_NO_FIGURE
};
[[nodiscard]] std::string_view no_figure_name(NoFigure why);      ///< as REST tells it
[[nodiscard]] std::string_view no_figure_sentence(NoFigure why);  ///< in English, empty for none

/// Exactly one of both: a finite value, or why there is none.
struct Figure {
  std::optional<double> value;
  NoFigure why = NoFigure::none;
};
/// A number that is not finite is no figure.
[[nodiscard]] Figure figure(double value);
[[nodiscard]] inline Figure no_figure(NoFigure why) { return {std::nullopt, why}; }

}  // namespace hoist::db
