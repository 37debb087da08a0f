#include "db/metrics/no_figure.hpp"

#include <array>
#include <cmath>
#include <cstddef>

namespace hoist::db {

std::string_view no_figure_name(NoFigure why) {
  constexpr std::array kNames{
      std::string_view{"none"},
#define HOIST_NO_FIGURE(name, text_en, text_de) std::string_view{#name},
#include "db/metrics/no_figure.def"
#undef HOIST_NO_FIGURE
  };
  return kNames[static_cast<std::size_t>(why)];
}

std::string_view no_figure_sentence(NoFigure why) {
  constexpr std::array kSentences{
      std::string_view{},
#define HOIST_NO_FIGURE(name, text_en, text_de) std::string_view{text_en},
#include "db/metrics/no_figure.def"
#undef HOIST_NO_FIGURE
  };
  return kSentences[static_cast<std::size_t>(why)];
}

Figure figure(double value) { return std::isfinite(value) ? Figure{value, NoFigure::none} : no_figure(NoFigure::not_comparable); }

}  // namespace hoist::db
