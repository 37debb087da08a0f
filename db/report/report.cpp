#include "db/report/report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "control/contract/commands.hpp"
#include "control/contract/faults.hpp"
#include "db/report/definitions.hpp"
#include "db/report/page.hpp"
#include "db/report/pictures.hpp"
#include "db/store/alarms.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/markers.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/task_record.hpp"
#include "db/store/tasks.hpp"
#include "db/store/visits.hpp"

namespace hoist::db {

namespace {

using report::Cell;
using report::escaped;
using report::Page;
using report::Table;
using report::Word;

const MetricInfo& info_of(std::string_view figure) { return *std::ranges::find(kMetrics, figure, &MetricInfo::key); }

Cell number(std::string text) { return {std::move(text), Cell::Style::number}; }
Cell small(std::string text) { return {std::move(text), Cell::Style::small}; }

void add_head(Page& page, const SessionInfo& session) {
  const auto item = [&](Word name, const std::string& text) {
    return "<span>" + escaped(page.w(name)) + ": <b>" + escaped(text) + "</b></span> ";
  };
  std::string head = item(Word::patient, session.study ? session.study->subject : session.subject.value_or("–"));
  if (!page.full()) head += "<span>" + escaped(page.w(Word::name)) + ": <span class=\"line\">&nbsp;</span></span> ";
  head += item(Word::date, report::time_text(session.started_utc_ns, page.language())) +
          item(Word::exercise, report::walked_text(session.exercise_json, page.language())) +
          item(Word::session, std::to_string(session.id));
  page.html("<div class=\"head\">" + head + "</div>");
  if (session.simulated) page.text(page.w(Word::simulated), "simulated");
  if (page.full() && !session.note.empty()) page.text(page.w(Word::note) + ": " + session.note);
}

// The results of the session's task, then the main figures.
std::vector<std::size_t> figures_in_short(const SessionInfo& session) {
  std::vector<std::size_t> chosen;
  const auto take = [&](std::string_view key) {
    const auto at = std::ranges::find(kMetrics, key, &MetricInfo::key);
    const auto index = static_cast<std::size_t>(at - kMetrics.begin());
    if (at != kMetrics.end() && std::ranges::find(chosen, index) == chosen.end()) chosen.push_back(index);
  };
  const auto record = task_of_stored(session.exercise_json);
  if (const TaskInfo* task = record ? find_task(record->task) : nullptr) {
    const nlohmann::json text = nlohmann::json::parse(task->text);
    for (const auto& key : text.at("results")) take(key.get_ref<const std::string&>());
  }
  for (const MetricInfo& figure : kMetrics)
    if (report::is_main(figure)) take(figure.key);
  return chosen;
}

// Large numbers are what there is; below them, small, what this session could not bear.
void add_main(Page& page, const SessionInfo& session, const SessionMetrics& metrics) {
  page.heading(page.w(Word::main));
  std::string boxes, absent;
  for (const std::size_t i : figures_in_short(session)) {
    const Cell cell = page.cell(kMetrics[i], metrics.figures[i]);
    const std::string title = escaped(page.title_of(kMetrics[i]));
    if (cell.style == Cell::Style::number)
      boxes += "<div>" + title + "<b>" + escaped(cell.text) + "</b></div>";
    else
      absent += "<div class=\"absent\">" + title + ": " + escaped(cell.text) + "</div>";
  }
  page.html("<div class=\"main\">" + boxes + "</div>" + absent);
}

Status add_path(Page& page, Database& database, const SessionInfo& session) {
  const bool planned = session.exercise_json && figure_of_stored(*session.exercise_json).valid();
  const std::string caption = page.w(planned ? Word::path_planned : Word::path_alone);
  const auto picture = report::path_picture(database, session, caption);
  if (!picture) return picture.error();
  if (picture->empty()) return {};
  page.heading(page.w(Word::path));
  page.picture(caption, *picture);
  return {};
}

std::string day_of(std::span<const TrendEntry> entries, SessionId session, Language language) {
  const auto at = std::ranges::find(entries, session, [](const TrendEntry& entry) { return entry.session.session; });
  return at == entries.end() ? std::string() : report::day_text(at->session.day, language);
}

std::string difference_text(const Page& page, const MetricInfo& figure, const Change& change) {
  return report::figure_text(figure, std::abs(change.difference()), page.language());
}

std::string basis_text(const Page& page, const Change& change) {
  if (change.published != nullptr)
    return page.w(Word::published,
                  {change.published->source, report::either(page.language(), change.published->whom_en, change.published->whom_de)});
  return change.minimal ? page.w(Word::own_repeats, {std::to_string(change.repeats)}) : std::string();
}

// "↑ 0.02 (0.01 to 0.03)", an arrow only where the interval leaves out 0.
Cell learning_cell(const Page& page, const MetricInfo& figure, const Learning& learning) {
  if (!learning.slope) return number("");
  const auto text = [&](double value) { return report::figure_text(figure, value, page.language()); };
  const Slope& slope = *learning.slope;
  const std::string told = page.w(Word::slope, {text(slope.middle), text(slope.low), text(slope.high)});
  return learning.why == NoChange::none ? Cell{page.w(slope.middle > 0 ? Word::up : Word::down, {told})} : small(told);
}

// Every compared figure, an arrow only where there is a change.
void add_change_table(Page& page, std::span<const FigureChange> changes) {
  page.text(page.w(Word::changes_help), "small");
  const std::array<Table::Column, 7> columns{{{page.w(Word::figure)},
                                              {page.w(Word::first), true},
                                              {page.w(Word::now), true},
                                              {page.w(Word::minimal), true},
                                              {page.w(Word::known_from)},
                                              {page.w(Word::change)},
                                              {page.w(Word::learning)}}};
  Table table(columns);
  for (const FigureChange& one : changes) {
    const Change& change = one.change;
    const MetricInfo& figure = info_of(one.figure);
    const auto text = [&](double value) { return number(report::figure_text(figure, value, page.language())); };
    const std::string verdict = change.why == NoChange::none
                                    ? page.w(change.difference() > 0 ? Word::up : Word::down, {difference_text(page, figure, change)})
                                    : std::string(report::no_change_text(change.why, page.language()));
    table.row(std::array{Cell{page.title_of(figure)}, text(change.first.value), text(change.last.value),
                         change.minimal ? text(*change.minimal) : number(""), small(basis_text(page, change)),
                         change.why == NoChange::none ? Cell{verdict} : small(verdict), learning_cell(page, figure, one.learning)});
  }
  page.table(table);
}

// For a patient: only what has changed, in a sentence each.
void add_change_sentences(Page& page, std::span<const FigureChange> changes, std::span<const TrendEntry> entries) {
  bool any = false;
  for (const FigureChange& one : changes) {
    const Change& change = one.change;
    const MetricInfo& figure = info_of(one.figure);
    if (change.why != NoChange::none || !report::is_main(figure)) continue;
    const bool more = change.difference() > 0;
    page.text((more ? "↑ " : "↓ ") + page.w(more ? Word::more : Word::less, {page.title_of(figure), difference_text(page, figure, change),
                                                                             day_of(entries, change.first.session, page.language())}),
              "changed");
    any = true;
  }
  if (!any) page.text(page.w(Word::no_progress));
}

void add_progress_pictures(Page& page, std::span<const TrendEntry> entries) {
  constexpr std::size_t kOfAPatient = 2;
  std::vector<std::string> figures;
  for (std::size_t i = 0; i < kMetrics.size(); ++i) {
    if (!report::is_main(kMetrics[i])) continue;
    std::vector<report::ProgressPoint> points;
    for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry)
      points.push_back(
          {report::day_text(entry->session.day, page.language()), entry->metrics ? entry->metrics->figures[i].value : std::nullopt});
    const std::string unit(kMetrics[i].screen_unit);
    const std::string caption = page.w(Word::over_time, {page.title_of(kMetrics[i]) + (unit.empty() ? "" : " (" + unit + ")")});
    const std::string picture = report::progress_picture(kMetrics[i], points, caption, page.language());
    if (!picture.empty())
      figures.push_back("<figure>" + picture + "<figcaption class=\"small\">" + escaped(caption) + "</figcaption></figure>");
  }
  if (!page.full() && figures.size() > kOfAPatient) figures.resize(kOfAPatient);
  std::string all;
  for (const std::string& one : figures) all += one;
  if (!all.empty()) page.html("<div class=\"pictures\">" + all + "</div>");
}

// This session against the first comparable one. Nothing where this is the first.
void add_progress(Page& page, const SessionInfo& session, std::span<const TrendEntry> trend) {
  std::vector<TrendEntry> entries;
  for (const TrendEntry& entry : trend)
    if (comparable(entry.session, trend.front().session)) entries.push_back(entry);
  if (entries.size() < 2 || entries.front().session.session != session.id) return;
  std::vector<FigureChange> changes = changes_in(entries);
  // A figure that this session lacks says nothing of now.
  std::erase_if(changes,
                [&](const FigureChange& one) { return one.change.last.session != session.id || one.change.first.session == session.id; });
  page.heading(page.w(Word::progress));
  if (page.full())
    add_change_table(page, changes);
  else
    add_change_sentences(page, changes, entries);
  add_progress_pictures(page, entries);
}

// Rows of the figures that `wanted` takes; without any, no heading either.
template <typename Wanted>
void add_figures(Page& page, const std::string& heading, const SessionMetrics& metrics, Wanted wanted) {
  const std::array<Table::Column, 4> columns{
      {{page.w(Word::figure)}, {page.w(Word::value), true}, {page.w(Word::definition)}, {page.w(Word::gate)}}};
  Table table(columns);
  bool any = false;
  for (std::size_t i = 0; i < kMetrics.size(); ++i) {
    const MetricInfo& figure = kMetrics[i];
    if (!wanted(figure, metrics.figures[i].value.has_value())) continue;
    any = true;
    const report::Definition told = report::definition(figure, page.language() == Language::de);
    const std::string text =
        std::string(told.key) + " v" + std::to_string(told.version) + ": " + std::string(told.formula) + ". " + std::string(told.source);
    table.row(std::array{Cell{page.title_of(figure)}, page.cell(figure, metrics.figures[i]), small(text),
                         small(told.gate.empty() ? page.w(Word::every_session) : std::string(told.gate))});
  }
  if (!any) return;
  page.heading(heading);
  page.html("<div class=\"defined\">" + table.whole() + "</div>");
}

// By groups what there is, at the end what there is not: a free walk does not begin with the results of a task.
void add_all_figures(Page& page, const SessionMetrics& metrics) {
  for (std::size_t group = 0; group < kMetricGroups.size(); ++group)
    add_figures(page, std::string(report::either(page.language(), kMetricGroups[group].title_en, kMetricGroups[group].title_de)), metrics,
                [group](const MetricInfo& figure, bool valid) { return valid && static_cast<std::size_t>(figure.group) == group; });
  add_figures(page, page.w(Word::not_here), metrics, [](const MetricInfo&, bool valid) { return !valid; });
}

Status add_alarms(Page& page, Database& database, const SessionInfo& session) {
  const auto alarms = stored_alarms(database, {.limit = kMaxPage, .session = session.id});
  if (!alarms) return alarms.error();
  page.heading(page.w(Word::alarms));
  if (alarms->items.empty()) {
    page.text(page.w(Word::no_alarms));
    return {};
  }
  Table table(std::array<Table::Column, 3>{{{page.w(Word::time), true}, {page.w(Word::alarm)}, {page.w(Word::lasted), true}}});
  for (auto alarm = alarms->items.rbegin(); alarm != alarms->items.rend(); ++alarm) {
    const contract::FaultInfo* fault = contract::find_fault(alarm->fault);
    const std::string text(fault == nullptr ? alarm->fault : report::either(page.language(), fault->text_en, fault->text_de));
    table.row(std::array{
        number(report::clock_text(alarm->time_s)), Cell{text},
        number(alarm->lasted_s ? report::number_text(*alarm->lasted_s, 1, page.language()) + "\u00a0s" : page.w(Word::to_the_end))});
  }
  page.table(table);
  if (alarms->next) page.text(page.w(Word::more_alarms, {std::to_string(kMaxPage)}), "small");
  return {};
}

Status add_marks(Page& page, Database& database, const SessionInfo& session) {
  constexpr std::size_t kAll = std::numeric_limits<std::int32_t>::max();
  const auto marks = MarkerStore(database).list(session.id, -1, kAll);
  if (!marks) return marks.error();
  if (marks->empty()) return {};
  page.heading(page.w(Word::marks));
  Table table(std::array<Table::Column, 3>{{{page.w(Word::time), true}, {page.w(Word::mark)}, {page.w(Word::note)}}});
  for (const MarkerInfo& mark : *marks)
    table.row(std::array{number(report::clock_text(mark.time_s)), Cell{report::marker_kind_text(mark.marker.kind, page.language())},
                         Cell{mark.marker.text}});
  page.table(table);
  return {};
}

// A parameter of today's table by the name it has in a recording; null for one that is gone.
const contract::ParamInfo* setting_of(std::string_view name) {
  const auto index = contract::find_param(name);
  return index ? &contract::kParams[*index] : nullptr;
}
std::string setting_title(const Page& page, std::string_view name) {
  const contract::ParamInfo* setting = setting_of(name);
  return std::string(setting == nullptr ? name : report::either(page.language(), setting->title_en, setting->title_de));
}
Cell setting_cell(const Page& page, std::string_view name, double value) {
  static constexpr contract::ParamInfo kUnknown{};
  const contract::ParamInfo* setting = setting_of(name);
  return number(report::setting_text(setting == nullptr ? kUnknown : *setting, value, page.language()));
}

Status add_settings(Page& page, Database& database, const SessionInfo& session) {
  const SessionReader reader(database);
  const auto settings = reader.parameters(session.id);
  if (!settings) return settings.error();
  page.heading(page.w(Word::settings));
  if (settings->empty()) {
    page.text(page.w(Word::no_settings));
    return {};
  }
  Table table(std::array<Table::Column, 3>{{{page.w(Word::setting)}, {page.w(Word::value), true}, {page.w(Word::definition)}}});
  for (const auto& [name, value] : *settings)
    table.row(std::array{Cell{setting_title(page, name)}, setting_cell(page, name, value), Cell{name, Cell::Style::english}});
  page.table(table);
  return {};
}

Status add_setting_changes(Page& page, Database& database, const SessionInfo& session) {
  const auto events = SessionReader(database).events(session.id);
  if (!events) return events.error();
  Table table(std::array<Table::Column, 4>{
      {{page.w(Word::time), true}, {page.w(Word::setting)}, {page.w(Word::before), true}, {page.w(Word::after), true}}});
  bool any = false;
  for (const StoredEvent& event : *events) {
    if (event.kind_name != contract::event_name(contract::EventKind::parameter_changed)) continue;
    const double time_s = (static_cast<double>(event.time_ns) - static_cast<double>(session.start_time_ns)) * 1e-9;
    table.row(std::array{number(report::clock_text(time_s)), Cell{setting_title(page, event.name)},
                         setting_cell(page, event.name, event.before), setting_cell(page, event.name, event.value)});
    any = true;
  }
  if (!any) return {};
  page.heading(page.w(Word::settings_changed));
  page.table(table);
  return {};
}

}  // namespace

Result<ReportReading> ReportReading::open(Database& database, SessionId session) {
  auto metrics = MetricsReading::open(database, session);
  if (!metrics) return metrics.error();
  if (metrics->info().recording)
    return Error{ErrorKind::wrong_state, "session " + std::to_string(session) + " is still being recorded", {}};
  return ReportReading(std::move(*metrics));
}

Result<ReportSession> read_report_session(Database& database, SessionId session) {
  auto reading = ReportReading::open(database, session);
  if (!reading) return reading.error();
  return read_whole(database, *reading);
}

Result<std::vector<TrendSession>> report_trend(Database& database, const SessionInfo& session) {
  constexpr std::size_t kMost = 50;
  if (session.simulated) return std::vector<TrendSession>{};
  const auto visits = VisitReader(database).of_sessions(std::span(&session.id, 1));
  if (!visits) return visits.error();
  if (visits->empty()) return std::vector<TrendSession>{};
  const Visit& visit = visits->begin()->second;
  const WalkOrder behind{visit.day, session.started_utc_ns, session.id + 1};
  auto page = trend_sessions(database, visit.patient_id, {.limit = kMost - 1, .before = behind, .comparable_to = session.id});
  if (!page) return page.error();
  std::ranges::move(page->firsts, std::back_inserter(page->items));
  return std::move(page->items);
}

Result<std::string> session_report(Database& database, const ReportSession& of, std::span<const TrendEntry> trend,
                                   const ReportOptions& options) {
  Page page(options.kind == ReportKind::full ? Word::full_title : Word::sheet_title, options);
  const SessionInfo& session = of.session;
  add_head(page, session);
  add_main(page, session, of.metrics);
  if (Status drawn = add_path(page, database, session); !drawn) return drawn.error();
  if (!trend.empty()) add_progress(page, session, trend);
  if (!page.full()) return page.whole();
  page.recorded_by(session);
  add_all_figures(page, of.metrics);
  for (const auto add : {add_alarms, add_marks, add_settings, add_setting_changes})
    if (Status added = add(page, database, session); !added) return added.error();
  return page.whole();
}

}  // namespace hoist::db
