// The words of reports, and numbers as a page shows them: digits and units are those of the console.
#pragma once
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>

#include "control/contract/params.hpp"
#include "db/metrics/change.hpp"
#include "db/metrics/metric.hpp"
#include "db/report/options.hpp"

namespace hoist::db {

namespace report {

enum class Word : std::uint8_t {
#define HOIST_REPORT_WORD(name, text_en, text_de) name,
#include "db/report/words.def"
#undef HOIST_REPORT_WORD
};
/// The text with each {} filled in, in order. Not escaped.
[[nodiscard]] std::string word(Word name, Language language, std::initializer_list<std::string_view> values = {});
[[nodiscard]] inline std::string_view either(Language language, std::string_view en, std::string_view de) {
  return language == Language::de ? de : en;
}

/// With so many decimals (0 to 9), halves away from zero as browsers round, a comma in German, never "−0.0".
[[nodiscard]] std::string number_text(double value, int decimals, Language language);
/// A figure in its screen's unit, as the console shows it.
[[nodiscard]] std::string figure_text(const MetricInfo& figure, double value, Language language);
/// A setting with at most four significant digits of a fraction; angles in degrees, the date of a calibration as a day of this computer's clock.
[[nodiscard]] std::string setting_text(const contract::ParamInfo& setting, double value, Language language);
[[nodiscard]] std::string_view no_figure_text(NoFigure why, Language language);
[[nodiscard]] std::string_view no_change_text(NoChange why, Language language);
/// What a marker of this kind says; "note" for a kind that is not known.
[[nodiscard]] std::string marker_kind_text(std::string_view kind, Language language);
/// 75.4 s as "1:15": rounded as in the console.
[[nodiscard]] std::string clock_text(double seconds);
/// A moment by this computer's clock: "2026-11-25 14:05", "25.11.2026 14:05".
[[nodiscard]] std::string time_text(std::int64_t utc_ns, Language language);
/// YYYY-MM-DD in the language's order.
[[nodiscard]] std::string day_text(std::string_view day, Language language);
/// Text for HTML, also inside an attribute in double quotes.
[[nodiscard]] std::string escaped(std::string_view text);

}  // namespace report
}  // namespace hoist::db
