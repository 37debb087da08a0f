// The frame of a report: head, style, tables. All text that comes in as text is escaped here.
#pragma once
#include <array>
#include <initializer_list>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "db/metrics/metric_list.hpp"
#include "db/report/options.hpp"
#include "db/report/words.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db::report {

/// What a report shows first, behind the results of its task; a patient's page shows no others.
inline constexpr std::array<std::string_view, 6> kMainFigures{"rms_position_m",    "motion_s",         "walked_m",
                                                              "walking_speed_m_s", "patient_led_norm", "cadence_steps_min"};
[[nodiscard]] bool is_main(const MetricInfo& figure);

/// A cell: its text, and how it stands.
struct Cell {
  enum class Style : std::uint8_t { text, number, small, english, absent };
  std::string text;
  Style style = Style::text;
};

class Table {
 public:
  /// Columns of numbers are aligned to the right, their titles too.
  struct Column {
    std::string title;
    bool number = false;
  };
  explicit Table(std::span<const Column> columns);
  void row(std::span<const Cell> cells);
  /// A row at the end, with a title over the first columns.
  void foot(const std::string& title, std::size_t columns, std::span<const Cell> cells);
  [[nodiscard]] std::string whole() const;

 private:
  std::string head_, body_, foot_;
};

class Page {
 public:
  Page(Word title, const ReportOptions& options) : options_(options), title_(title) {}
  [[nodiscard]] Language language() const { return options_.language; }
  [[nodiscard]] bool full() const { return options_.kind == ReportKind::full; }
  [[nodiscard]] std::string w(Word name, std::initializer_list<std::string_view> values = {}) const {
    return word(name, options_.language, values);
  }
  [[nodiscard]] std::string title_of(const MetricInfo& figure) const {
    return std::string(either(options_.language, figure.title_en, figure.title_de));
  }
  /// The figure's number, or why it has none.
  [[nodiscard]] Cell cell(const MetricInfo& figure, const Figure& value) const;

  void html(const std::string& markup) { body_ += markup + "\n"; }
  void heading(const std::string& text);
  void text(const std::string& text, const char* style = "");
  void table(const Table& table) { html(table.whole()); }
  void picture(const std::string& caption, const std::string& svg);
  /// Names the programs that recorded this session at the page's end.
  void recorded_by(const SessionInfo& session);
  [[nodiscard]] std::string whole() const;

 private:
  const ReportOptions& options_;
  Word title_;
  std::string body_;
  std::set<std::string> origins_;  // a sentence each
};

/// "Square, 3.2 m", or the task with its repetition.
[[nodiscard]] std::string walked_text(const std::optional<std::string>& stored_exercise, Language language);

}  // namespace hoist::db::report
