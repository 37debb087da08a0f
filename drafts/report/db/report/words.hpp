// The words of reports, and numbers as a page shows them.
#pragma once
#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include "db/metrics/metric.hpp"

namespace hoist::db {

enum class Language : std::uint8_t { en, de };
/// "en" or "de".
[[nodiscard]] std::optional<Language> find_language(std::string_view name);

namespace report {

enum class Word : std::uint8_t {
#define HOIST_REPORT_WORD(name, text_en, text_de) name,
#include "db/report/words.def"
#undef HOIST_REPORT_WORD
};
/// The text with each {} filled in, in order.
[[nodiscard]] std::string word(Word name, Language language, std::initializer_list<std::string> values = {});
[[nodiscard]] inline std::string_view either(Language language, std::string_view en, std::string_view de) {
  return language == Language::de ? de : en;
}

/// A number with a fixed count of decimals, 0 to 9, as the console shows it: halves away from zero, decimal comma in German, never "-0.0".
[[nodiscard]] std::string number_text(double value, int decimals, Language language);
/// A figure in its screen's unit, as the console shows it.
[[nodiscard]] std::string figure_text(const MetricInfo& figure, double value, Language language);
/// Why a figure is not valid, in words.
[[nodiscard]] std::string_view no_figure_text(NoFigure why, Language language);
[[nodiscard]] std::string_view no_change_text(std::string_view name, Language language);
/// "2026-11-25 14:05" as the computer's clock shows it.
[[nodiscard]] std::string time_text(std::int64_t utc_ns, Language language);
/// Text for HTML, also inside an attribute.
[[nodiscard]] std::string escaped(std::string_view text);

}  // namespace report
}  // namespace hoist::db
