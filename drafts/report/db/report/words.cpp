#include "db/report/words.hpp"

#include <cstdio>
#include <ctime>

#include "db/metrics/change.hpp"

namespace hoist::db {

std::optional<Language> find_language(std::string_view name) {
  if (name == "en") return Language::en;
  return name == "de" ? std::optional(Language::de) : std::nullopt;
}

namespace report {

std::string word(Word name, Language language, std::initializer_list<std::string> values) {
  struct Row {
    std::string_view en, de;
  };
  static constexpr std::array kRows{
#define HOIST_REPORT_WORD(name, text_en, text_de) Row{text_en, text_de},
#include "db/report/words.def"
#undef HOIST_REPORT_WORD
  };
  const Row& row = kRows[static_cast<std::size_t>(name)];
  std::string text(either(language, row.en, row.de));
  std::size_t at = 0;
  for (const std::string& value : values) {
    at = text.find("{}", at);
    if (at == std::string::npos) break;
    text.replace(at, 2, value);
    at += value.size();
  }
  return text;
}

std::string number_text(double value, int decimals, Language language) {
  // All digits of the double, of which the last ones are cut here: printf rounds halves to even, browsers away from zero.
  constexpr int kAll = 60;
  std::array<char, 512> exact{};
  std::snprintf(exact.data(), exact.size(), "%.*f", kAll, value < 0 ? -value : value);
  std::string text = exact.data();
  const std::size_t kept = text.size() - static_cast<std::size_t>(kAll - decimals);
  const bool up = text[kept] >= '5';
  // Without decimals the point goes, too.
  text.resize(decimals > 0 ? kept : kept - 1);
  for (std::size_t i = text.size(); up && i-- > 0;) {
    if (text[i] == '.') continue;
    if (text[i] != '9') {
      ++text[i];
      break;
    }
    text[i] = '0';
    if (i == 0) text.insert(0, "1");
  }
  const bool zero = text.find_first_not_of("0.") == std::string::npos;
  if (language == Language::de)
    if (const std::size_t point = text.find('.'); point != std::string::npos) text[point] = ',';
  return (value < 0 && !zero ? "\u2212" : "") + text;
}

std::string figure_text(const MetricInfo& figure, double value, Language language) {
  const std::string number = number_text(value * screen_factor(figure), figure.digits, language);
  if (figure.screen_unit.empty() || figure.screen_unit == "°") return number + std::string(figure.screen_unit);
  return number + " " + std::string(figure.screen_unit);
}

std::string_view no_figure_text(NoFigure why, Language language) {
  struct Row {
    std::string_view en, de;
  };
  static constexpr std::array kRows{
      Row{"", ""},
#define HOIST_NO_FIGURE(name, text_en, text_de) Row{text_en, text_de},
#include "db/metrics/no_figure.def"
#undef HOIST_NO_FIGURE
  };
  const Row& row = kRows[static_cast<std::size_t>(why)];
  return either(language, row.en, row.de);
}

std::string_view no_change_text(std::string_view name, Language language) {
#define HOIST_NO_CHANGE(row, text_en, text_de) \
  if (name == #row) return either(language, text_en, text_de);
#include "db/metrics/no_change.def"
#undef HOIST_NO_CHANGE
  return "";
}

std::string time_text(std::int64_t utc_ns, Language language) {
  const auto seconds = static_cast<std::time_t>(utc_ns / 1'000'000'000);
  std::tm local{};
  localtime_r(&seconds, &local);
  std::array<char, 64> text{};
  std::strftime(text.data(), text.size(), language == Language::de ? "%d.%m.%Y %H:%M" : "%Y-%m-%d %H:%M", &local);
  return text.data();
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '&')
      out += "&amp;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

}  // namespace report
}  // namespace hoist::db
