#include "db/report/words.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numbers>

#include "control/contract/calibration.hpp"

namespace hoist::db {

namespace report {

namespace {
struct Both {
  std::string_view en, de;
};

// The text of a row of a table that is in the order of its enumeration.
template <std::size_t kCount, typename Row>
std::string_view row_text(const std::array<Both, kCount>& rows, Row row, Language language) {
  const Both& both = rows[static_cast<std::size_t>(row)];
  return either(language, both.en, both.de);
}

std::string with_unit(const std::string& number, std::string_view unit) {
  return number + (unit.empty() || unit == "°" ? "" : "\u00a0") + std::string(unit);
}

// One more in the last digit of a number in decimal digits and at most one point.
void round_up(std::string& digits) {
  for (std::size_t i = digits.size(); i-- > 0;) {
    if (digits[i] == '.') continue;
    if (digits[i] != '9') {
      ++digits[i];
      return;
    }
    digits[i] = '0';
  }
  digits.insert(0, "1");
}
}  // namespace

std::string word(Word name, Language language, std::initializer_list<std::string_view> values) {
  static constexpr std::array kWords{
#define HOIST_REPORT_WORD(name, text_en, text_de) Both{text_en, text_de},
#include "db/report/words.def"
#undef HOIST_REPORT_WORD
  };
  const Both& row = kWords[static_cast<std::size_t>(name)];
  std::string text(either(language, row.en, row.de));
  std::size_t at = 0;
  for (const std::string_view value : values) {
    at = text.find("{}", at);
    if (at == std::string::npos) break;
    text.replace(at, 2, value);
    at += value.size();
  }
  return text;
}

std::string number_text(double value, int decimals, Language language) {
  // Exactly the double, cut afterwards: printf rounds halves to even, browsers away from zero.
  constexpr int kAll = 60;
  std::array<char, 512> exact{};
  std::snprintf(exact.data(), exact.size(), "%.*f", kAll, std::fabs(value));
  std::string text = exact.data();
  const std::size_t kept = text.size() - static_cast<std::size_t>(kAll - decimals);
  const bool up = text[kept] >= '5';
  // Without decimals the point goes, too.
  text.resize(decimals > 0 ? kept : kept - 1);
  if (up) round_up(text);
  const bool zero = text.find_first_not_of("0.") == std::string::npos;
  if (language == Language::de) std::ranges::replace(text, '.', ',');
  return (value < 0 && !zero ? "\u2212" : "") + text;
}

std::string figure_text(const MetricInfo& figure, double value, Language language) {
  return with_unit(number_text(value * screen_factor(figure), figure.digits, language), figure.screen_unit);
}

namespace {
// A unit that is a word; others are signs.
std::string unit_text(std::string_view unit, Language language) {
  if (unit == "units") return word(Word::unit_units, language);
  if (unit == "counts") return word(Word::unit_counts, language);
  return std::string(unit);
}

bool is_date(const contract::ParamInfo& setting) {
  return std::ranges::any_of(contract::kCalibrationSteps, [&](const contract::CalibrationStepInfo& step) {
    return contract::kParams[contract::param_index(step.date)].name == setting.name;
  });
}

std::string local_text(std::time_t utc_s, const char* format) {
  std::tm local{};
  ::localtime_r(&utc_s, &local);
  std::array<char, 64> text{};
  std::strftime(text.data(), text.size(), format, &local);
  return text.data();
}

std::string date_text(double utc_s, Language language) {
  if (!(utc_s > 0)) return word(Word::never, language);
  return day_text(local_text(static_cast<std::time_t>(utc_s), "%Y-%m-%d"), language);
}
}  // namespace

std::string setting_text(const contract::ParamInfo& setting, double value, Language language) {
  constexpr int kSignificant = 4, kMost = 9;
  if (is_date(setting)) return date_text(value, language);
  std::string unit = unit_text(setting.unit, language);
  if (unit == "rad" || unit.starts_with("rad/")) {
    value *= 180 / std::numbers::pi;
    unit.replace(0, 3, "°");
  }
  const int whole = value == 0 ? 0 : static_cast<int>(std::floor(std::log10(std::fabs(value))));
  std::string text = number_text(value, std::clamp(kSignificant - 1 - whole, 0, kMost), language);
  if (text.find_first_of(".,") != std::string::npos) {
    text.resize(text.find_last_not_of('0') + 1);
    if (text.ends_with('.') || text.ends_with(',')) text.pop_back();
  }
  return with_unit(text, unit);
}

std::string_view no_figure_text(NoFigure why, Language language) {
  static constexpr std::array kRows{
      Both{"", ""},
#define HOIST_NO_FIGURE(name, text_en, text_de) Both{text_en, text_de},
#include "db/metrics/no_figure.def"
#undef HOIST_NO_FIGURE
  };
  return row_text(kRows, why, language);
}

std::string_view no_change_text(NoChange why, Language language) {
  static constexpr std::array kRows{
      Both{"", ""},
#define HOIST_NO_CHANGE(name, text_en, text_de) Both{text_en, text_de},
#include "db/metrics/no_change.def"
#undef HOIST_NO_CHANGE
  };
  return row_text(kRows, why, language);
}

std::string marker_kind_text(std::string_view kind, Language language) {
  static constexpr std::array kKinds{std::pair{"note", Word::mark_note}, std::pair{"help", Word::mark_help},
                                     std::pair{"stumble", Word::mark_stumble}, std::pair{"rest", Word::mark_rest},
                                     std::pair{"good", Word::mark_good}};
  const auto at = std::ranges::find(kKinds, kind, [](const auto& row) { return std::string_view(row.first); });
  return word(at == kKinds.end() ? Word::mark_note : at->second, language);
}

std::string clock_text(double seconds) {
  const long whole = std::lround(std::max(0.0, seconds));
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%ld:%02ld", whole / 60, whole % 60);
  return text.data();
}

std::string time_text(std::int64_t utc_ns, Language language) {
  return local_text(static_cast<std::time_t>(utc_ns / 1'000'000'000), language == Language::de ? "%d.%m.%Y %H:%M" : "%Y-%m-%d %H:%M");
}

std::string day_text(std::string_view day, Language language) {
  if (language == Language::en || day.size() != 10) return std::string(day);
  return std::string(day.substr(8)) + "." + std::string(day.substr(5, 2)) + "." + std::string(day.substr(0, 4));
}

std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  return out;
}

}  // namespace report
}  // namespace hoist::db
