#include "db/report/report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "db/metrics/metric_list.hpp"
#include "db/metrics/table_mean.hpp"
#include "db/report/pictures.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/patients.hpp"
#include "db/store/session_reader.hpp"

namespace hoist::db {

namespace {

using report::either;
using report::escaped;
using report::figure_text;
using report::Word;

/// The figures of the patient's page, as the console's trend shows them.
constexpr std::array<std::string_view, 8> kMain{"walked_m",         "motion_s",       "walking_speed_m_s", "cadence_steps_min",
                                                "patient_led_norm", "rms_position_m", "C",                 "J_N"};

constexpr std::string_view kStyle =
    "@page{size:A4;margin:14mm}"
    "body{font:10.5pt/1.4 system-ui,sans-serif;color:#171b26;background:#fff;margin:0 auto;max-width:190mm;padding:4mm}"
    "h1{font-size:17pt;margin:0 0 2mm}h2{font-size:12.5pt;margin:6mm 0 2mm;break-after:avoid}"
    "table{border-collapse:collapse;width:100%}th,td{text-align:left;vertical-align:top;padding:1mm 2mm;border-bottom:1px solid #d9dde6}"
    "tr{break-inside:avoid}thead{display:table-header-group}th{font-weight:600}td.n{white-space:nowrap;text-align:right}"
    "th.n{text-align:right}.head{display:flex;flex-wrap:wrap;gap:1mm 8mm;margin:0 0 3mm}.head span{white-space:nowrap}"
    ".small{font-size:8.5pt;color:#555e72}.absent{color:#555e72;white-space:normal;text-align:left!important}"
    ".mark{border:1.5pt solid #171b26;padding:2mm 3mm;font-weight:600}"
    ".main{display:grid;grid-template-columns:repeat(auto-fit,minmax(42mm,1fr));gap:3mm}.main div{border:1px solid #d9dde6;padding:2mm "
    "3mm}"
    ".main b{display:block;font-size:15pt}.cols{display:grid;grid-template-columns:repeat(auto-fit,minmax(80mm,1fr));gap:4mm}"
    "svg{width:100%;max-height:105mm}figure{margin:0;break-inside:avoid}.line{border-bottom:1px solid #7a8295;display:inline-block;"
    "min-width:60mm}.wide{overflow-x:auto}";

std::string language_name(Language language) { return language == Language::de ? "de" : "en"; }

class Page {
 public:
  Page(const std::string& title, const ReportOptions& options) : options_(options) {
    text_ = "<!doctype html>\n<html lang=\"" + language_name(options.language) +
            "\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\"><title>" + escaped(title) +
            "</title><style>" + std::string(kStyle) + "</style></head><body>\n<h1>" + escaped(title) + "</h1>\n";
  }
  [[nodiscard]] std::string w(Word name, std::initializer_list<std::string> values = {}) const {
    return escaped(report::word(name, options_.language, values));
  }
  void add(const std::string& html) { text_ += html + "\n"; }
  void heading(Word name) { add("<h2>" + w(name) + "</h2>"); }
  void small(const std::string& words) { add("<p class=\"small\">" + words + "</p>"); }
  [[nodiscard]] Language language() const { return options_.language; }
  [[nodiscard]] bool full() const { return options_.kind == ReportKind::full; }
  [[nodiscard]] std::string whole(const std::string& recorded_by, const std::string& core) {
    if (full()) small(w(Word::provenance, {recorded_by, core, options_.program}));
    small(w(Word::no_device));
    return text_ + "</body></html>\n";
  }

 private:
  const ReportOptions& options_;
  std::string text_;
};

std::string exercise_text(const std::optional<std::string>& stored, Language language) {
  const nlohmann::json told = exercise_as_told(stored);
  const auto* info = told.is_object() ? contract::find_exercise(told.value("shape", "free")) : contract::find_exercise("free");
  if (info == nullptr) return {};
  std::string text(either(language, info->title_en, info->title_de));
  if (!told.is_object()) return text;
  for (const contract::ExerciseSize& size : contract::kExerciseSizes)
    if (size.shape == info->shape && told.contains(size.name) && told[std::string(size.name)].is_number())
      text += ", " + std::string(either(language, size.title_en, size.title_de)) + " " +
              report::number_text(told[std::string(size.name)].get<double>(), 1, language) + " m";
  return text;
}

// A figure's number, or why there is none.
std::string cell(const Page& page, const MetricInfo& figure, const Figure& value) {
  if (value.value) return "<td class=\"n\">" + escaped(figure_text(figure, *value.value, page.language())) + "</td>";
  const std::string why(report::no_figure_text(value.why, page.language()));
  return "<td class=\"absent\">" + page.w(Word::not_valid, {why}) + "</td>";
}

std::string_view title_of(const Page& page, const MetricInfo& figure) { return either(page.language(), figure.title_en, figure.title_de); }

void main_figures(Page& page, const SessionMetrics& metrics) {
  page.heading(Word::main);
  std::string boxes = "<div class=\"main\">";
  for (std::size_t i = 0; i < kMetrics.size(); ++i) {
    if (std::ranges::find(kMain, kMetrics[i].key) == kMain.end()) continue;
    const Figure& one = metrics.figures[i];
    boxes += "<div>" + escaped(title_of(page, kMetrics[i]));
    if (one.value)
      boxes += "<b>" + escaped(figure_text(kMetrics[i], *one.value, page.language())) + "</b>";
    else
      boxes += "<br><span class=\"small\">" + page.w(Word::not_valid, {std::string(report::no_figure_text(one.why, page.language()))}) + "</span>";
    boxes += "</div>";
  }
  page.add(boxes + "</div>");
}

void all_figures(Page& page, const SessionMetrics& metrics) {
  for (std::size_t g = 0; g < kMetricGroups.size(); ++g) {
    const MetricGroupInfo& group = kMetricGroups[g];
    page.add("<h2>" + escaped(either(page.language(), group.title_en, group.title_de)) + "</h2>");
    std::string table = "<table><thead><tr><th>" + page.w(Word::figure) + "</th><th class=\"n\">" + page.w(Word::value) + "</th><th>" +
                        page.w(Word::definition) + "</th><th>" + page.w(Word::gate) + "</th></tr></thead><tbody>";
    for (std::size_t i = 0; i < kMetrics.size(); ++i) {
      const MetricInfo& figure = kMetrics[i];
      if (static_cast<std::size_t>(figure.group) != g) continue;
      table += "<tr><td>" + escaped(title_of(page, figure)) + "</td>" + cell(page, figure, metrics.figures[i]) +
               "<td class=\"small\" lang=\"en\">" + escaped(figure.key) + " v" + std::to_string(figure.version) + ": " +
               escaped(figure.formula) + "</td><td class=\"small\"" + (figure.gate.empty() ? ">" : " lang=\"en\">") +
               (figure.gate.empty() ? page.w(Word::every_session) : escaped(figure.gate)) + "</td></tr>";
    }
    page.add(table + "</tbody></table>");
  }
}

void settings(Page& page, const std::vector<std::pair<std::string, double>>& values) {
  if (values.empty()) return;
  page.heading(Word::settings);
  std::string words;
  for (const auto& [name, value] : values) {
    const nlohmann::json number = value;
    words += (words.empty() ? "" : ", ") + escaped(name) + "\u00a0" + number.dump();
  }
  page.small(words);
}

// Every change of a figure, or only those of the main ones that can be told.
void changes(Page& page, std::span<const TrendEntry> entries) {
  const std::vector<FigureChange> all = changes_in(entries);
  if (all.empty()) return;
  page.heading(Word::changes);
  page.small(page.w(Word::changes_help));
  std::string table = "<table><thead><tr><th>" + page.w(Word::figure) + "</th><th class=\"n\">" + page.w(Word::first) +
                      "</th><th class=\"n\">" + page.w(Word::last) + "</th><th class=\"n\">" + page.w(Word::least) + "</th><th>" +
                      page.w(Word::basis) + "</th><th></th></tr></thead>";
  std::optional<std::string> exercise;
  bool begun = false;
  for (const FigureChange& one : all) {
    const MetricInfo& figure = *std::ranges::find(kMetrics, one.figure, &MetricInfo::key);
    if (!page.full() && std::ranges::find(kMain, one.figure) == kMain.end()) continue;
    if (!begun || exercise != one.exercise_json)
      table += "<tbody><tr><th colspan=\"6\">" + escaped(exercise_text(one.exercise_json, page.language())) + "</th></tr>";
    begun = true;
    exercise = one.exercise_json;
    const Change& change = one.change;
    std::string basis;
    if (change.published != nullptr)
      basis = std::string(change.published->source) + ": " +
              std::string(either(page.language(), change.published->whom_en, change.published->whom_de));
    else if (change.least)
      basis = report::word(Word::own_repeats, page.language(), {std::to_string(change.repeats)});
    const bool up = change.difference() > 0;
    const std::string verdict =
        change.why == NoChange::none ? (up ? "\u2191 " : "\u2193 ") + report::word(up ? Word::more : Word::less, page.language())
                                     : std::string(report::no_change_text(no_change_name(change.why), page.language()));
    table += "<tr><td>" + escaped(title_of(page, figure)) + "</td><td class=\"n\">" +
             escaped(figure_text(figure, change.first.value, page.language())) + "</td><td class=\"n\">" +
             escaped(figure_text(figure, change.last.value, page.language())) + "</td><td class=\"n\">" +
             (change.least ? escaped(figure_text(figure, *change.least, page.language())) : "") + "</td><td class=\"small\">" +
             escaped(basis) + "</td><td>" + escaped(verdict) + "</td></tr>";
  }
  page.add(table + "</table>");
}

void progress(Page& page, std::span<const TrendEntry> entries) {
  std::string pictures;
  for (std::size_t i = 0; i < kMetrics.size(); ++i) {
    if (std::ranges::find(kMain, kMetrics[i].key) == kMain.end()) continue;
    std::vector<report::ProgressPoint> points;
    // Of the exercise walked last only: others are not comparable.
    for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry)
      if (entry->metrics && entry->session.exercise_json == entries.front().session.exercise_json && entry->metrics->figures[i].value)
        points.push_back({entry->session.day, *entry->metrics->figures[i].value});
    if (const std::string picture = report::progress_picture(kMetrics[i], points, page.language()); !picture.empty())
      pictures += "<figure>" + escaped(title_of(page, kMetrics[i])) +
                  (kMetrics[i].screen_unit.empty() ? "" : ", " + escaped(kMetrics[i].screen_unit)) + picture + "</figure>";
  }
  if (pictures.empty()) return;
  page.heading(Word::progress);
  page.small(escaped(exercise_text(entries.front().session.exercise_json, page.language())));
  page.add("<div class=\"cols\">" + pictures + "</div>");
}

Status path(Page& page, Database& database, const SessionInfo& session) {
  const auto picture = report::path_picture(database, session);
  if (!picture) return picture.error();
  if (picture->empty()) return {};
  page.heading(Word::path);
  page.add("<figure>" + *picture + "</figure>");
  page.small(page.w(Word::path_key));
  return {};
}

void head_of_session(Page& page, const SessionInfo& session) {
  std::string head = "<div class=\"head\"><span>" + page.w(Word::patient) + ": <b>" + escaped(session.subject.value_or("\u2013")) +
                     "</b></span>";
  if (!page.full()) head += "<span>" + page.w(Word::name) + ": <span class=\"line\">&nbsp;</span></span>";
  head += "<span>" + page.w(Word::date) + ": <b>" + escaped(report::time_text(session.started_utc_ns, page.language())) + "</b></span><span>" +
          page.w(Word::exercise) + ": <b>" + escaped(exercise_text(session.exercise_json, page.language())) + "</b></span><span>" +
          page.w(Word::session) + ": <b>" + std::to_string(session.id) + "</b></span></div>";
  page.add(head);
  if (session.simulated) page.add("<p class=\"mark\">" + page.w(Word::simulated) + "</p>");
  if (!session.note.empty()) page.add("<p>" + page.w(Word::note) + ": " + escaped(session.note) + "</p>");
}

}  // namespace

std::optional<ReportKind> find_report_kind(std::string_view name) {
  if (name == "patient") return ReportKind::patient;
  return name == "full" ? std::optional(ReportKind::full) : std::nullopt;
}

Result<std::string> session_report(Database& database, SessionId id, const ReportOptions& options) {
  const SessionReader reader(database);
  const auto session = reader.get(id);
  if (!session) return session.error();
  const auto metrics = session_metrics(database, id);
  if (!metrics) return metrics.error();
  Page page(report::word(Word::walk, options.language), options);
  head_of_session(page, *session);
  main_figures(page, *metrics);
  if (Status drawn = path(page, database, *session); !drawn) return drawn.error();
  if (page.full()) {
    all_figures(page, *metrics);
    const auto parameters = reader.parameters(id);
    if (!parameters) return parameters.error();
    settings(page, *parameters);
  }
  return page.whole(session->software_version, session->core_version.value_or(report::word(Word::unknown, options.language)));
}

Result<std::string> patient_report(Database& database, std::int64_t patient, const TrendPage& trend, std::span<const TrendEntry> entries,
                                   const ReportOptions& options) {
  const auto info = PatientStore(database).get(patient);
  if (!info) return info.error();
  Page page(report::word(Word::progress, options.language), options);
  std::string recorded_by = report::word(Word::unknown, options.language), core = recorded_by;
  if (entries.empty()) {
    page.add("<p>" + page.w(Word::patient) + ": <b>" + escaped(info->code) + "</b></p><p>" + page.w(Word::no_sessions) + "</p>");
  } else {
    const auto session = SessionReader(database).get(entries.front().session.session);
    if (!session) return session.error();
    head_of_session(page, *session);
    if (entries.front().metrics)
      main_figures(page, *entries.front().metrics);
    else
      page.add("<p>" + page.w(Word::unreadable) + "</p>");
    changes(page, entries);
    progress(page, entries);
    if (Status drawn = path(page, database, *session); !drawn) return drawn.error();
    if (page.full() && entries.front().metrics) all_figures(page, *entries.front().metrics);
    recorded_by = session->software_version;
    core = session->core_version.value_or(core);
  }
  if (trend.simulated > 0) page.small(page.w(Word::simulated_out, {std::to_string(trend.simulated)}));
  return page.whole(recorded_by, core);
}

Result<std::string> patient_report(Database& database, std::int64_t patient, const ReportOptions& options) {
  const auto page = trend_sessions(database, patient, kReportSessions, {});
  if (!page) return page.error();
  std::vector<TrendEntry> entries;
  for (const TrendSession& session : page->items) {
    auto entry = trend_entry(database, session);
    if (!entry) return entry.error();
    if (*entry) entries.push_back(std::move(**entry));
  }
  return patient_report(database, patient, *page, entries, options);
}

Result<GroupRow> group_row(Database& database, SessionId id) {
  auto session = SessionReader(database).get(id);
  if (!session) return session.error();
  auto metrics = session_metrics(database, id);
  if (!metrics && metrics.error().kind != ErrorKind::corrupt) return metrics.error();
  return GroupRow{std::move(*session), metrics ? std::optional(std::move(*metrics)) : std::nullopt};
}

std::string group_report(std::span<const GroupRow> rows, const ReportOptions& options) {
  Page page(report::word(Word::group, options.language), options);
  page.add("<p>" + page.w(Word::sessions) + ": " + std::to_string(rows.size()) + "</p>");
  std::string table = "<div class=\"wide\"><table><thead><tr><th>" + page.w(Word::session) + "</th><th>" + page.w(Word::patient) +
                      "</th><th>" + page.w(Word::exercise) + "</th>";
  std::vector<std::size_t> shown;
  for (std::size_t i = 0; i < kMetrics.size(); ++i)
    if (std::ranges::find(kMain, kMetrics[i].key) != kMain.end()) shown.push_back(i);
  for (const std::size_t i : shown) table += "<th class=\"n\">" + escaped(title_of(page, kMetrics[i])) + "</th>";
  table += "</tr></thead><tbody>";
  for (const GroupRow& row : rows) {
    table += "<tr><td>" + std::to_string(row.session.id) + "</td><td>" +
             escaped(row.session.study ? row.session.study->subject : row.session.subject.value_or("\u2013")) + "</td><td>" +
             escaped(exercise_text(row.session.exercise_json, page.language())) + "</td>";
    for (const std::size_t i : shown)
      table += row.metrics ? cell(page, kMetrics[i], row.metrics->figures[i]) : "<td class=\"absent\">" + page.w(Word::unreadable) + "</td>";
    table += "</tr>";
  }
  table += "</tbody><tfoot>";
  for (const Word line : {Word::mean, Word::deviation, Word::count}) {
    table += "<tr><th colspan=\"3\">" + page.w(line) + "</th>";
    for (const std::size_t i : shown) {
      double sum = 0, squares = 0;
      std::size_t count = 0;
      for (const GroupRow& row : rows)
        if (row.metrics && row.metrics->figures[i].value) {
          sum += *row.metrics->figures[i].value;
          ++count;
        }
      const double mean = count > 0 ? sum / static_cast<double>(count) : 0;
      for (const GroupRow& row : rows)
        if (row.metrics && row.metrics->figures[i].value) squares += std::pow(*row.metrics->figures[i].value - mean, 2);
      std::string text;
      if (line == Word::count)
        text = std::to_string(count);
      else if (line == Word::mean && count > 0)
        text = figure_text(kMetrics[i], mean, page.language());
      else if (line == Word::deviation && count > 1)
        text = figure_text(kMetrics[i], std::sqrt(squares / static_cast<double>(count - 1)), page.language());
      table += "<td class=\"n\">" + escaped(text) + "</td>";
    }
    table += "</tr>";
  }
  page.add(table + "</tfoot></table></div>");
  const std::string unknown = report::word(Word::unknown, options.language);
  const bool any = !rows.empty();
  return page.whole(any ? rows.front().session.software_version : unknown, any ? rows.front().session.core_version.value_or(unknown) : unknown);
}

}  // namespace hoist::db
