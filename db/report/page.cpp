#include "db/report/page.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numbers>

#include "db/store/exercise_json.hpp"
#include "db/store/tasks.hpp"

namespace hoist::db::report {

namespace {

// Printed on white; on a narrow screen tables scroll within themselves.
constexpr std::string_view kStyle =
    "@page{size:A4;margin:14mm}"
    "html{color-scheme:light;background:#fff}"
    "body{font:10.5pt/1.4 system-ui,sans-serif;color:#171b26;margin:0 auto;max-width:182mm;padding:4mm}"
    "@media print{body{padding:0;max-width:none}}"
    "h1{font-size:17pt;margin:0 0 2mm}h2{font-size:12.5pt;margin:5mm 0 2mm;break-after:avoid}p{margin:0 0 2mm}"
    ".head{display:flex;flex-wrap:wrap;gap:1mm 8mm;margin:0 0 2mm}.head b{font-weight:600}"
    ".line{display:inline-block;min-width:60mm;border-bottom:1px solid #7a8295}"
    ".simulated{border:1.5pt solid #171b26;padding:2mm 3mm;font-weight:600}"
    ".main{display:grid;grid-template-columns:repeat(auto-fit,minmax(50mm,1fr));gap:3mm}"
    ".main div{border:1px solid #d9dde6;padding:2mm 3mm;break-inside:avoid}.main b{display:block;font-size:15pt}"
    ".changed{font-size:12.5pt;font-weight:600}.small,.english,.absent{font-size:8.5pt;color:#4b5367}"
    ".wide{overflow-x:auto}table{border-collapse:collapse;width:100%}thead{display:table-header-group}tr{break-inside:avoid}"
    "th,td{text-align:left;vertical-align:top;padding:1mm 2mm 1mm 0;border-bottom:1px solid #d9dde6;font-weight:400}th{font-weight:600}"
    ".number{text-align:right;white-space:nowrap;font-variant-numeric:tabular-nums}"
    ".defined table{table-layout:fixed}.defined th:nth-child(1){width:22%}.defined th:nth-child(2){width:20%}"
    ".defined th:nth-child(4){width:25%}td{overflow-wrap:anywhere}"
    "figure{margin:0 0 3mm;break-inside:avoid}.pictures{display:grid;grid-template-columns:repeat(auto-fit,minmax(75mm,1fr));gap:4mm}"
    "svg{width:100%;max-height:85mm}svg.progress{font-size:11px}footer{margin-top:6mm}";

// A group has many columns: their titles wrap, their words stay whole.
constexpr std::string_view kWideStyle =
    "@page{size:A4 "
    "landscape}body{max-width:269mm;font-size:9pt}th{vertical-align:bottom}th.number{white-space:normal}td{overflow-wrap:normal}";

std::string_view style_name(Cell::Style style) {
  static constexpr std::array<std::string_view, 5> kNames{"", "number", "small", "english", "absent"};
  return kNames[static_cast<std::size_t>(style)];
}

std::string cell_html(const Cell& cell) {
  const std::string_view style = style_name(cell.style);
  return "<td" + (style.empty() ? std::string() : " class=\"" + std::string(style) + "\"") +
         (cell.style == Cell::Style::english ? " lang=\"en\">" : ">") + escaped(cell.text) + "</td>";
}

// How far or how long; empty for a task that the therapist ends.
std::string goal_text(const TaskRecord& record, Language language) {
  switch (record.ends) {
    case TaskEnd::distance:
      return word(Word::laps, language, {number_text(record.goal, 0, language)});
    case TaskEnd::time:
      return clock_text(record.goal) + "\u00a0min";
    case TaskEnd::turn:
      return number_text(record.goal * 180 / std::numbers::pi, 0, language) + "°";
    case TaskEnd::back:
      return number_text(record.goal, 1, language) + "\u00a0m";
    case TaskEnd::hand:
      break;
  }
  return {};
}

std::string task_text(const TaskRecord& record, Language language) {
  std::string title = record.task;
  double usual_goal = 1;  // of a task that this version does not have: once along its line
  if (const TaskInfo* task = find_task(record.task)) {
    title = nlohmann::json::parse(task->text).at("title").at(language == Language::de ? "de" : "en").get<std::string>();
    usual_goal = task->goal.usual;
  }
  if (!record.line.empty()) title = record.line;
  if (const std::string goal = goal_text(record, language); !goal.empty() && record.goal != usual_goal) title += " (" + goal + ")";
  return word(Word::repetition, language, {title, std::to_string(record.repetition), std::to_string(record.repetitions)});
}

}  // namespace

bool is_main(const MetricInfo& figure) { return std::ranges::find(kMainFigures, figure.key) != kMainFigures.end(); }

Table::Table(std::span<const Column> columns) {
  for (const Column& column : columns)
    head_ += std::string("<th scope=\"col\"") + (column.number ? " class=\"number\">" : ">") + escaped(column.title) + "</th>";
}

void Table::row(std::span<const Cell> cells) {
  body_ += "<tr>";
  for (const Cell& cell : cells) body_ += cell_html(cell);
  body_ += "</tr>\n";
}

void Table::foot(const std::string& title, std::size_t columns, std::span<const Cell> cells) {
  foot_ += "<tr><th scope=\"row\" colspan=\"" + std::to_string(columns) + "\">" + escaped(title) + "</th>";
  for (const Cell& cell : cells) foot_ += cell_html(cell);
  foot_ += "</tr>\n";
}

std::string Table::whole() const {
  return "<div class=\"wide\"><table><thead><tr>" + head_ + "</tr></thead><tbody>\n" + body_ + "</tbody>" +
         (foot_.empty() ? "" : "<tfoot>" + foot_ + "</tfoot>") + "</table></div>";
}

Cell Page::cell(const MetricInfo& figure, const Figure& value) const {
  if (value.value) return {figure_text(figure, *value.value, language()), Cell::Style::number};
  return {w(Word::not_valid, {no_figure_text(value.why, language())}), Cell::Style::absent};
}

void Page::heading(const std::string& text) { html("<h2>" + escaped(text) + "</h2>"); }

void Page::text(const std::string& text, const char* style) {
  html("<p" + (*style == '\0' ? std::string() : " class=\"" + std::string(style) + "\"") + ">" + escaped(text) + "</p>");
}

void Page::picture(const std::string& caption, const std::string& svg) {
  html("<figure>" + svg + "<figcaption class=\"small\">" + escaped(caption) + "</figcaption></figure>");
}

void Page::recorded_by(const SessionInfo& session) {
  origins_.insert(w(Word::origin, {session.software_version, session.core_version.value_or(w(Word::unknown))}));
}

std::string Page::whole() const {
  const std::string title = escaped(w(title_)), language = options_.language == Language::de ? "de" : "en";
  std::string out = "<!doctype html>\n<html lang=\"" + language +
                    "\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>" +
                    title + "</title><style>" + std::string(kStyle) + std::string(title_ == Word::group_title ? kWideStyle : "") +
                    "</style></head><body><main>\n<h1>" + title + "</h1>\n" + body_ + "</main>\n<footer class=\"small\">";
  std::string programs;
  for (const std::string& origin : origins_) programs += origin + " ";
  if (!programs.empty()) out += "<p>" + escaped(programs + w(Word::made_by, {options_.program})) + "</p>";
  return out + "<p>" + escaped(w(Word::no_device)) + "</p></footer></body></html>\n";
}

std::string walked_text(const std::optional<std::string>& stored_exercise, Language language) {
  if (const auto task = task_of_stored(stored_exercise)) return task_text(*task, language);
  const nlohmann::json told = exercise_as_told(stored_exercise);
  const contract::ExerciseInfo* info =
      contract::find_exercise(told.is_object() ? told.value("shape", std::string("free")) : std::string("free"));
  if (info == nullptr) return {};
  std::string text(either(language, info->title_en, info->title_de));
  for (const contract::ExerciseSize& size : contract::kExerciseSizes) {
    if (size.shape != info->shape || !told.is_object()) continue;
    const auto at = told.find(size.name);
    if (at != told.end() && at->is_number() && at->get<double>() > 0)
      text += ", " + number_text(at->get<double>(), 1, language) + "\u00a0m";
  }
  return text;
}

}  // namespace hoist::db::report
