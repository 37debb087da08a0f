// Reports: every number is the stored one, no figure stands where its gate is closed, and no text becomes markup.
#include "db/report/batch.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <regex>
#include <sstream>

#include "control/contract/calibration.hpp"
#include "control/contract/program_version.hpp"
#include "db/export/bundle.hpp"
#include "db/report/definitions.hpp"
#include "db/report/pictures.hpp"
#include "db/report/words.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/tasks.hpp"
#include "db/store/visits.hpp"
#include "db/summary/session_json.hpp"
#include "tests/support/shell.hpp"
#include "tests/unit/db/db_support.hpp"

namespace hoist::db::test {

using nlohmann::json;

namespace {

constexpr const char* kEvil = "<script>alert(1)</script>";
constexpr std::array kLanguages{Language::en, Language::de};

// A patient's walks of one eight, none of them simulated.
struct Recorded {
  TemporaryFolder dir;
  Database database = std::move(*Database::open(dir / "hoist.db"));
  SessionWriter writer = std::move(*SessionWriter::create(database));
  std::vector<SessionId> sessions;

  void walk(std::string subject, std::string note, bool simulated = false,
            std::string exercise = R"({"shape":"eight","centre_m":1.0,"radius_m":0.8})", std::optional<double> after_days = {}) {
    const auto seed = static_cast<std::uint32_t>(sessions.size() + 1);
    SessionStart start;
    start.subject = std::move(subject);
    start.started_utc_ns = kStartUtc_ns + static_cast<std::int64_t>(after_days.value_or(seed) * 86'400e9);
    start.start_time_ns = kStart_ns;
    start.software_version = "1.0";
    start.note = std::move(note);
    start.simulated = simulated;
    start.exercise_json = std::move(exercise);
    std::vector<double> values;
    for (const contract::ParamInfo& param : contract::kParams) values.push_back(param.default_value);
    start.parameter_values = values;
    sessions.push_back(*writer.begin(start));
    EXPECT_TRUE(writer.append_ticks(Walk(seed).records(1, 3000)).ok());
  }
  void end() { EXPECT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns).ok()); }
  [[nodiscard]] std::string report(SessionId id, ReportKind kind = ReportKind::full, Language language = Language::en) {
    const auto page = session_report(database, id, {kind, language, "test"});
    EXPECT_TRUE(page.ok()) << (page.ok() ? "" : page.error().message);
    return page.ok() ? *page : std::string();
  }
};

std::string unescaped(std::string text) {
  for (const auto& [from, to] : {std::pair{"&lt;", "<"}, std::pair{"&gt;", ">"}, std::pair{"&quot;", "\""}, std::pair{"&amp;", "&"}})
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + 1))
      text.replace(at, std::string(from).size(), to);
  return text;
}

// What stands in the full report as the value of this figure.
std::string shown(const std::string& page, const MetricInfo& figure) {
  const std::string mark = ">" + std::string(figure.key) + " v";
  const std::size_t definition = page.find(mark);
  if (definition == std::string::npos) return "no row";
  const std::size_t end = page.rfind("</td>", definition), begin = page.rfind('>', end) + 1;
  return unescaped(page.substr(begin, end - begin));
}

// By the stream of the standard library, from the unit's name alone.
std::string expected(const MetricInfo& figure, double value, Language language) {
  const std::string unit(figure.screen_unit);
  const bool hundred = unit == "%" || (unit == "cm" && figure.unit == "m");
  std::ostringstream out;
  out << std::fixed << std::setprecision(figure.digits) << std::fabs(value) * (unit == "°" ? 180 / std::numbers::pi : hundred ? 100 : 1);
  std::string text = out.str();
  if (value < 0 && text.find_first_of("123456789") != std::string::npos) text.insert(0, "\u2212");
  if (language == Language::de) std::ranges::replace(text, '.', ',');
  return text + (unit.empty() || unit == "°" ? "" : "\u00a0") + unit;
}

TEST(Report, EveryFigureHasTheDigitsOfItsValueOrSaysWhyNot) {
  Recorded r;
  r.walk("P-01", "");
  r.end();
  const json told = *session_metrics_json(r.database, r.sessions.front());
  std::size_t valid = 0, closed = 0;
  for (const Language language : kLanguages) {
    const std::string page = r.report(r.sessions.front(), ReportKind::full, language);
    for (const MetricInfo& figure : kMetrics) {
      const json& value = told.at(std::string(figure.key));
      const std::string text = shown(page, figure);
      if (value.is_number()) {
        EXPECT_EQ(text, expected(figure, value.get<double>(), language)) << figure.key;
        ++valid;
        continue;
      }
      ++closed;
      EXPECT_EQ(text.find_first_of("0123456789"), text.find("45°")) << figure.key << ": " << text;
      const std::string why = told["computed"][std::string(figure.key)]["reason_code"];
      if (language == Language::en) {
        const auto sentence = [&]() -> std::string_view {
#define HOIST_NO_FIGURE(name, text_en, text_de) \
  if (why == #name) return text_en;
#include "db/metrics/no_figure.def"
#undef HOIST_NO_FIGURE
          return "?";
        }();
        EXPECT_EQ(text, "Not valid: " + std::string(sentence)) << figure.key;
      }
    }
  }
  EXPECT_GT(valid, 40U);
  EXPECT_GT(closed, 10U) << "no task, no lap";
}

// In the order of the page: what there is, and at the end what there is not.
TEST(Report, ItBeginsWithWhatTheSessionHas) {
  Recorded r;
  r.walk("P-01", "");
  r.end();
  const SessionMetrics metrics = *session_metrics(r.database, r.sessions.front());
  const std::string page = r.report(r.sessions.front());
  const std::size_t rest = page.find("<h2>Not valid in this session</h2>");
  ASSERT_NE(rest, std::string::npos);
  EXPECT_EQ(page.find("<h2>Task</h2>"), std::string::npos) << "it was no task";
  for (std::size_t i = 0; i < kMetrics.size(); ++i)
    EXPECT_EQ(page.find(">" + std::string(kMetrics[i].key) + " v") < rest, metrics.figures[i].value.has_value()) << kMetrics[i].key;
  const std::string boxes = page.substr(page.find("<div class=\"main\">"), page.find("<h2>Path</h2>") - page.find("<div class=\"main\">"));
  EXPECT_LT(boxes.rfind("<b>"), boxes.find("Not valid")) << "numbers first";
}

// Its results come first: the time of a 10 m walk is what was asked for.
TEST(Report, ATaskBeginsWithItsResults) {
  Recorded r;
  std::vector<ExerciseProblem> problems;
  const TaskChoice choice = *read_task_choice({{"task", "walk_2min"}}, problems);
  r.walk("P-01", "", false, stored_with_task(choice.exercise, task_record(choice, 1)));
  r.end();
  for (const ReportKind kind : {ReportKind::patient, ReportKind::full}) {
    const std::string page = r.report(r.sessions.front(), kind);
    const std::string begin = page.substr(0, page.find("<h2>Path</h2>"));
    EXPECT_NE(begin.find("Distance of the task"), std::string::npos);
    EXPECT_NE(begin.find("The end of the task was not reached."), std::string::npos) << "30 s of 120";
  }
}

TEST(Report, NoTextBecomesMarkup) {
  Recorded r;
  r.walk(kEvil, std::string("\"><img src=x onerror=alert(2)> & ") + kEvil);
  EXPECT_TRUE(r.writer.append_marker(50, kStartUtc_ns + 500'000'000, kEvil, {}, "help").ok());
  r.end();
  for (const ReportKind kind : {ReportKind::patient, ReportKind::full}) {
    const std::string page = r.report(r.sessions.front(), kind);
    EXPECT_EQ(page.find("<script"), std::string::npos);
    EXPECT_EQ(page.find("<img"), std::string::npos);
    EXPECT_NE(page.find("<b>&lt;script&gt;alert(1)&lt;/script&gt;</b>"), std::string::npos);
  }
  const std::string full = r.report(r.sessions.front());
  EXPECT_NE(full.find("Note: &quot;&gt;&lt;img src=x onerror=alert(2)&gt; &amp; &lt;script&gt;"), std::string::npos);
  EXPECT_NE(full.find("<td>Helped</td><td>&lt;script&gt;alert(1)&lt;/script&gt;</td>"), std::string::npos);
  const std::string group = group_report(std::array{*read_report_session(r.database, r.sessions.front())}, {});
  EXPECT_EQ(group.find("<script"), std::string::npos);
  EXPECT_NE(group.find("<td>&lt;script&gt;"), std::string::npos);
}

TEST(Report, BothLanguagesAreWhole) {
  const auto gaps = [](const std::string& text) {
    std::size_t count = 0;
    for (std::size_t at = text.find("{}"); at != std::string::npos; at = text.find("{}", at + 1)) ++count;
    return count;
  };
#define HOIST_REPORT_WORD(name, text_en, text_de) std::pair{report::Word::name, std::string_view(#name)},
  for (const auto& [word, name] : {
#include "db/report/words.def"
       }) {
    const std::string en = report::word(word, Language::en), de = report::word(word, Language::de);
    EXPECT_FALSE(en.empty() || de.empty()) << name;
    EXPECT_EQ(gaps(en), gaps(de)) << name;
  }
#undef HOIST_REPORT_WORD
  Recorded r;
  r.walk("P-01", "");
  r.end();
  const std::string en = r.report(r.sessions.front()), de = r.report(r.sessions.front(), ReportKind::full, Language::de);
  EXPECT_NE(en.find("<html lang=\"en\">"), std::string::npos);
  EXPECT_NE(de.find("<html lang=\"de\">"), std::string::npos);
  for (const MetricInfo& figure : kMetrics) {
    EXPECT_NE(en.find("<td>" + std::string(figure.title_en) + "</td>"), std::string::npos) << figure.key;
    EXPECT_NE(de.find("<td>" + std::string(figure.title_de) + "</td>"), std::string::npos) << figure.key;
  }
  EXPECT_EQ(de.find("nglisch"), std::string::npos);
  for (const MetricInfo& figure : kMetrics) {
    const report::Definition german = report::definition(figure, true);
    // Formulas without words, such as "120 / T", are the same in both.
    for (const auto& [english, translated] : {std::pair(figure.formula, german.formula), std::pair(figure.gate, german.gate)}) {
      EXPECT_NE(unescaped(en).find(english), std::string::npos) << figure.key;
      EXPECT_NE(unescaped(de).find(translated), std::string::npos) << figure.key;
      if (english == translated) continue;
      EXPECT_EQ(unescaped(de).find(english), std::string::npos) << figure.key << ": " << english;
      EXPECT_EQ(unescaped(en).find(translated), std::string::npos) << figure.key << ": " << translated;
    }
    // What English definitions are made of.
    const std::string all = std::string(german.formula) + " " + std::string(german.gate) + " " + std::string(german.source);
    EXPECT_FALSE(std::regex_search(all, std::regex("\\b(the|of|from|mean|sum|sqrt|samples|missing|equation|decision|Table)\\b"))) << all;
  }
  for (const contract::ParamInfo& param : contract::kParams)
    EXPECT_NE(unescaped(de).find("<td>" + std::string(param.title_de) + "</td>"), std::string::npos) << param.name;
}

// A trend that was made up: this session, and earlier ones of the same exercise with one other figure.
std::vector<TrendEntry> trend_of(const ReportSession& now, std::string_view figure, const std::vector<double>& earlier) {
  const auto entry = [&](SessionId id, std::int64_t visit, double value) {
    TrendEntry one{{.session = id, .visit = visit, .day = "2026-09-0" + std::to_string(visit), .exercise_json = now.session.exercise_json},
                   now.metrics};
    one.metrics->figures[static_cast<std::size_t>(std::ranges::find(kMetrics, figure, &MetricInfo::key) - kMetrics.begin())] = {value};
    return one;
  };
  std::vector<TrendEntry> all{entry(now.session.id, 9, now.metrics[figure].value.value())};
  for (std::size_t i = 0; i < earlier.size(); ++i) all.push_back(entry(now.session.id - 1 - static_cast<SessionId>(i), 1, earlier[i]));
  return all;
}

TEST(Report, AnArrowStandsOnlyBeyondTheMinimalDetectableChange) {
  Recorded r;
  r.walk("P-01", "");
  r.end();
  const ReportSession now = *read_report_session(r.database, r.sessions.front());
  const double speed_m_s = now.metrics["walking_speed_m_s"].value.value();
  const auto page = [&](std::string_view figure, double before, ReportKind kind) {
    return *session_report(r.database, now, trend_of(now, figure, {before}), {kind, Language::en, "test"});
  };
  const std::string faster = page("walking_speed_m_s", speed_m_s - 0.25, ReportKind::full);
  EXPECT_NE(faster.find("<td>↑ 0.25\u00a0m/s</td>"), std::string::npos);
  EXPECT_NE(faster.find("Lewek &amp; Sykes 2019"), std::string::npos);
  EXPECT_NE(page("walking_speed_m_s", speed_m_s - 0.25, ReportKind::patient)
                .find("↑ Mean speed while walking: 0.25\u00a0m/s more than on 2026-09-01"),
            std::string::npos);
  for (const ReportKind kind : {ReportKind::patient, ReportKind::full})
    for (const std::string& none : {page("walking_speed_m_s", speed_m_s - 0.05, kind), page("walked_m", 0.1, kind)}) {
      EXPECT_EQ(none.find("↑"), std::string::npos);
      EXPECT_EQ(none.find("↓"), std::string::npos);
      EXPECT_NE(none.find("<svg class=\"progress\""), std::string::npos);
    }
  EXPECT_EQ(r.report(r.sessions.front()).find("<svg class=\"progress\""), std::string::npos) << "the first walk has no progress";
}

TEST(Report, ASimulatedSessionSaysSoAndHasNoProgress) {
  Recorded r;
  for (const bool simulated : {false, false, true}) {
    r.walk("P-01", "", simulated);
    r.end();
  }
  EXPECT_TRUE(report_trend(r.database, *SessionReader(r.database).get(r.sessions[2]))->empty());
  EXPECT_EQ(report_trend(r.database, *SessionReader(r.database).get(r.sessions[0]))->size(), 1U) << "what came later is not of this report";
  EXPECT_EQ(report_trend(r.database, *SessionReader(r.database).get(r.sessions[1]))->size(), 2U);
  EXPECT_NE(r.report(r.sessions[2]).find("Simulation: nobody walked."), std::string::npos);
  EXPECT_EQ(r.report(r.sessions[1]).find("Simulation"), std::string::npos);
  EXPECT_NE(r.report(r.sessions[1]).find("<h2>Progress</h2>"), std::string::npos);
}

// Of a second hoist, whose sessions an archive brought later: they have later numbers.
TEST(Report, WalksAreComparedInTheOrderOfTheirDaysAndStartsNotOfTheirNumbers) {
  Recorded r;
  for (const double after_days : {10.0, 20.0, 5.0, 10.001, 9.999}) {
    r.walk("P-01", "", false, R"({"shape":"square","side_m":3.2})", after_days);
    r.end();
  }
  const std::vector<SessionId> newest_first{2, 4, 1, 5, 3};
  const auto visits = *VisitReader(r.database).of_sessions(r.sessions);
  const std::int64_t patient = visits.begin()->second.patient_id;
  ASSERT_EQ(visits.at(1).id, visits.at(4).id);
  ASSERT_EQ(visits.at(1).id, visits.at(5).id);
  EXPECT_EQ(VisitReader(r.database).visit(visits.at(1).id)->sessions, (std::vector<SessionId>{5, 1, 4}));
  const auto numbers = [](const std::vector<TrendSession>& walks) {
    std::vector<SessionId> all;
    for (const TrendSession& walk : walks) all.push_back(walk.session);
    return all;
  };
  const TrendPage all = *trend_sessions(r.database, patient, {});
  EXPECT_EQ(numbers(all.items), newest_first);
  const std::array<std::int64_t, 5> places{0, 0, -1, -2, 0};
  for (std::size_t i = 0; i < places.size(); ++i) EXPECT_EQ(all.items[i].place, places[i]) << i;
  // Page by page.
  std::vector<SessionId> read;
  TrendQuery query{.limit = 1};
  do {
    const TrendPage page = *trend_sessions(r.database, patient, query);
    for (const TrendSession& walk : page.items) read.push_back(walk.session);
    EXPECT_EQ(numbers(page.firsts), page.next ? std::vector<SessionId>{3} : std::vector<SessionId>{});
    query.before = page.next;
  } while (query.before && read.size() < newest_first.size());
  EXPECT_EQ(read, newest_first);
  // A report compares with what was walked before, not with what came later.
  for (std::size_t i = 0; i < newest_first.size(); ++i)
    EXPECT_EQ(numbers(*report_trend(r.database, *SessionReader(r.database).get(newest_first[i]))),
              std::vector(newest_first.begin() + static_cast<std::ptrdiff_t>(i), newest_first.end()));
}

TEST(Report, APageIsTheSameAmongOthersAndByItself) {
  Recorded r;
  for (const double after_days : {1.0, 1.001, 1.002, 1.003, 1.004}) {
    r.walk("P-01", "", false, R"({"shape":"square","side_m":3.2})", after_days);
    r.end();
  }
  ReportBatch batch(r.database, {ReportKind::full, Language::en, "test"});
  for (const SessionId session : r.sessions) EXPECT_EQ(*batch.page(session), r.report(session)) << session;
}

TEST(Report, ProgressIsToldAgainstTheFirstWalkOfTheSameExerciseHoweverManyCameSince) {
  Recorded r;
  for (const char* exercise : {R"({"shape":"eight","centre_m":1.0,"radius_m":0.8})", R"({"shape":"square","side_m":3.2})"}) {
    r.walk("P-01", "", false, exercise);
    r.end();
  }
  // More of each than a report takes.
  for (const char* session : {"1", "2"})
    execute(r.database.handle(), ("CREATE TEMP TABLE copy AS SELECT * FROM sessions WHERE id = " + std::string(session) +
                                  "; UPDATE copy SET id = NULL; "
                                  "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 55) "
                                  "INSERT INTO sessions SELECT copy.* FROM copy, n; DROP TABLE copy")
                                     .c_str());
  r.walk("P-01", "");
  r.end();
  const auto trend = report_trend(r.database, *SessionReader(r.database).get(r.sessions.back()));
  ASSERT_TRUE(trend.ok()) << trend.error().message;
  ASSERT_EQ(trend->size(), 50U);
  EXPECT_EQ(trend->front().session, 113);
  EXPECT_EQ((*trend)[1].session, 57) << "the squares between are another exercise";
  EXPECT_EQ((*trend)[48].session, 10);
  EXPECT_EQ(trend->back().session, 1);
  EXPECT_EQ(trend->front().place, 0);
  EXPECT_EQ((*trend)[1].place, 0) << "another visit";
  EXPECT_EQ((*trend)[48].place, -47);
  EXPECT_EQ(trend->back().place, -55) << "walks between the page and the first one count";
}

// One more step a minute with each walk of a visit, whether the walks between have a cadence or not.
TEST(Report, WhatAWalkAddsIsOfAllWalksOfTheVisit) {
  Recorded r;
  r.walk("P-01", "");
  r.end();
  const ReportSession now = *read_report_session(r.database, r.sessions.front());
  const auto cadence =
      static_cast<std::size_t>(std::ranges::find(kMetrics, std::string_view("cadence_steps_min"), &MetricInfo::key) - kMetrics.begin());
  for (const std::size_t valid : {10U, 5U}) {
    std::vector<TrendEntry> entries;
    for (std::size_t i = 0; i < 10; ++i) {
      const auto place = static_cast<std::int64_t>(i);
      entries.push_back(
          {{.session = 20 - place, .visit = 1, .day = {}, .started_utc_ns = 0, .exercise_json = {}, .place = -place}, now.metrics});
      entries.back().metrics->figures[cadence] =
          valid == 10 || i % 2 == 0 ? figure(110.0 - static_cast<double>(i)) : no_figure(NoFigure::no_rhythm);
    }
    const std::vector<FigureChange> changes = changes_in(entries);
    const auto found = std::ranges::find(changes, std::string_view("cadence_steps_min"), &FigureChange::figure);
    ASSERT_NE(found, changes.end());
    EXPECT_EQ(found->learning.walks, valid);
    ASSERT_TRUE(found->learning.slope);
    EXPECT_NEAR(found->learning.slope->middle, 1.0, 1e-9) << valid << " valid ones";
  }
}

// A distance in 2 minutes is no progress of one in 6.
TEST(Report, ATaskIsComparedOnlyWithTheSameGoalAndEdges) {
  Recorded r;
  for (const int goal_s : {360, 120, 360, 120}) {
    std::vector<ExerciseProblem> problems;
    const TaskChoice choice = *read_task_choice({{"task", "walk_6min"}, {"goal", goal_s}}, problems);
    r.walk("P-01", "", false, stored_with_task(choice.exercise, task_record(choice, 1)));
    r.end();
  }
  const auto compared = *report_trend(r.database, *SessionReader(r.database).get(r.sessions[3]));
  ASSERT_EQ(compared.size(), 2U);
  EXPECT_EQ(compared[1].session, r.sessions[1]);
  EXPECT_NE(r.report(r.sessions[2]).find("<b>6-minute walk, 1 of 1</b>"), std::string::npos) << "the usual goal";
  EXPECT_NE(r.report(r.sessions[3]).find("<b>6-minute walk (2:00\u00a0min), 1 of 1</b>"), std::string::npos);
  EXPECT_NE(r.report(r.sessions[3], ReportKind::patient, Language::de).find("<b>6-Minuten-Gehtest (2:00\u00a0min), 1 von 1</b>"),
            std::string::npos);

  const std::int64_t patient = VisitReader(r.database).of_sessions(r.sessions)->begin()->second.patient_id;
  const TrendPage all = *trend_sessions(r.database, patient, {}), newest = *trend_sessions(r.database, patient, {.limit = 1});
  ASSERT_EQ(newest.firsts.size(), 1U);
  EXPECT_EQ(newest.firsts[0].session, r.sessions[1]);
  std::vector<TrendEntry> entries;
  for (const TrendSession& session : all.items) entries.push_back(**trend_entry(r.database, session));
  std::map<json, json> firsts;
  for (const FigureChange& change : changes_in(entries))
    if (change.figure == "walked_m") firsts[change_json(change)["ends"]] = change_json(change)["first_session"];
  EXPECT_EQ(firsts, (std::map<json, json>{{{{"by", "time"}, {"goal", 120.0}, {"edge_m", 0.0}}, r.sessions[1]},
                                          {{{"by", "time"}, {"goal", 360.0}, {"edge_m", 0.0}}, r.sessions[0]}}));
  EXPECT_EQ(trend_item_json(entries[0])["ends"]["goal"], 120);

  const auto timed_without = [](double edge_m) {
    TaskRecord task{.task = "walk_10m", .ends = TaskEnd::distance, .goal = 1, .edge_m = edge_m};
    return TrendSession{.day = {}, .exercise_json = stored_with_task(contract::usual_exercise(contract::ExerciseShape::straight), task)};
  };
  EXPECT_FALSE(comparable(timed_without(2), timed_without(1)));
}

std::vector<ReportSession> three_walks(Recorded& r) {
  std::vector<ReportSession> sessions;
  for (int i = 0; i < 3; ++i) {
    r.walk("P-01", "");
    r.end();
    sessions.push_back(*read_report_session(r.database, r.sessions.back()));
  }
  return sessions;
}

TEST(Report, AGroupCountsValidValuesOnly) {
  Recorded r;
  std::vector<ReportSession> sessions = three_walks(r);
  const auto walked = static_cast<std::size_t>(std::ranges::find(kMetrics, "walked_m", &MetricInfo::key) - kMetrics.begin());
  sessions[0].metrics.figures[walked] = {10.0};
  sessions[1].metrics.figures[walked] = {13.0};
  sessions[2].metrics.figures[walked] = no_figure(NoFigure::part_missing);
  const std::string page = group_report(sessions, {.kind = {}, .language = Language::de, .program = "test"});
  EXPECT_NE(page.find("<td class=\"number\">11,5\u00a0m</td>"), std::string::npos) << "mean";
  EXPECT_NE(page.find("<td class=\"number\">2,1\u00a0m</td>"), std::string::npos) << "3 / sqrt(2)";
  EXPECT_NE(page.find("<td class=\"absent\">Nicht gültig: Ein Teil dieses Wegs"), std::string::npos);
  EXPECT_NE(page.find("<td class=\"number\">2</td>"), std::string::npos) << "valid values";
}

TEST(Report, AGroupNamesEveryProgramThatRecorded) {
  Recorded r;
  std::vector<ReportSession> sessions = three_walks(r);
  const auto foot = [&](Language language) {
    const std::string page = group_report(sessions, {.kind = {}, .language = language, .program = "test"});
    const std::size_t begin = page.find("<footer");
    return page.substr(begin, page.find("</p>", begin) - begin);
  };
  EXPECT_EQ(foot(Language::en), "<footer class=\"small\"><p>Recorded by 1.0, control program unknown. Report made by test.");
  sessions[1].session.software_version = "1.1";
  sessions[1].session.core_version = "1.2";
  EXPECT_EQ(foot(Language::en),
            "<footer class=\"small\"><p>Recorded by 1.0, control program unknown. Recorded by 1.1, control program 1.2. "
            "Report made by test.");
  EXPECT_EQ(foot(Language::de),
            "<footer class=\"small\"><p>Aufgezeichnet mit 1.0, Steuerprogramm unbekannt. Aufgezeichnet mit 1.1, "
            "Steuerprogramm 1.2. Bericht erstellt mit test.");
}

TEST(Report, SettingsAreTimesAndUnitsOfTheReader) {
  const InTimeZone zone("EAST-12");
  const auto text = [](std::string_view name, double value, Language language) {
    return report::setting_text(contract::kParams[contract::find_param(name).value()], value, language);
  };
  constexpr double kUtc_s = static_cast<double>(kStartUtc_ns / 1'000'000'000);  // 02:13 of the next day
  for (const contract::CalibrationStepInfo& step : contract::kCalibrationSteps) {
    const std::string_view date = contract::kParams[contract::param_index(step.date)].name;
    EXPECT_EQ(text(date, kUtc_s, Language::en), "2026-09-22") << date;
    EXPECT_EQ(text(date, kUtc_s, Language::de), "22.09.2026") << date;
    EXPECT_EQ(text(date, 0, Language::en), "Never done") << date;
    EXPECT_EQ(text(date, 0, Language::de), "Noch nie") << date;
  }
  EXPECT_EQ(text("slip_stop_s", 1, Language::de), "1\u00a0s");
  EXPECT_EQ(text("encoder_counts_per_turn", 60000, Language::en), "60000\u00a0counts");
  EXPECT_EQ(text("encoder_counts_per_turn", 60000, Language::de), "60000\u00a0Impulse");
  EXPECT_EQ(text("lean_gain_filtered_units", 50, Language::en), "50\u00a0units");
  EXPECT_EQ(text("lean_gain_filtered_units", 50, Language::de), "50\u00a0Einheiten");
  // The German of every unit that is a word.
  for (const contract::ParamInfo& param : contract::kParams)
    if (param.unit.size() > 3 && param.unit.find_first_of(" /") == std::string_view::npos) {
      EXPECT_EQ(text(param.name, 1, Language::de).find(param.unit), std::string::npos) << param.name;
    }
}

TEST(Report, NumbersRoundAsInABrowser) {
  const auto en = [](double value, int decimals) { return report::number_text(value, decimals, Language::en); };
  EXPECT_EQ(en(0.125, 2), "0.13");
  EXPECT_EQ(en(2.5, 0), "3");
  EXPECT_EQ(en(-2.5, 0), "\u22123");
  EXPECT_EQ(en(1.005, 2), "1.00") << "the double is below";
  EXPECT_EQ(en(9.995, 2), "9.99");
  EXPECT_EQ(en(99.96, 1), "100.0");
  EXPECT_EQ(en(-0.04, 1), "0.0");
  EXPECT_EQ(report::number_text(-1234.5, 1, Language::de), "\u22121234,5");
  EXPECT_EQ(report::clock_text(75.4), "1:15");
  EXPECT_EQ(report::clock_text(11.5), "0:12");
  EXPECT_EQ(report::clock_text(59.6), "1:00");
}

TEST(Report, TheToolWritesTheSamePages) {
  Recorded r;
  for (int i = 0; i < 2; ++i) {
    r.walk("P-01", "#trial");
    r.end();
  }
  const std::string out = (r.dir / "out").string();
  const auto result = hoist::test::run_shell(std::string(HOIST_BINARY_DIR) + "/bin/hoist report " + (r.dir / "hoist.db").string() +
                                             " --tag trial --language de --kind patient --out " + out);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("2 of 2 reports written"), std::string::npos);
  const auto file = [&](const std::string& name) {
    std::ifstream in(std::filesystem::path(out) / name);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  for (const SessionId id : r.sessions) {
    const auto page = session_report(r.database, id, {ReportKind::patient, Language::de, std::string(contract::program_version())});
    EXPECT_EQ(file("session-" + std::to_string(id) + ".html"), *page);
  }
  EXPECT_NE(file("group.html").find("Bericht über mehrere Sitzungen"), std::string::npos);
}

// A session without a report is no reason to withhold those of the others.
TEST(Report, ABundleTellsWhyASessionHasNone) {
  Recorded r;
  r.walk("P-01", "");
  r.end();
  r.walk("P-01", "");
  auto bundle = Bundle::open(r.database, r.sessions, BundleLayout::reports, {.kind = ReportKind::patient, .program = "test"});
  ASSERT_TRUE(bundle.ok());
  std::string all, piece;
  for (;;) {
    const auto more = bundle->next_chunk(piece);
    ASSERT_TRUE(more.ok()) << more.error().message;
    if (!*more) break;
    all += piece;
  }
  EXPECT_NE(all.find("session-" + std::to_string(r.sessions[0]) + ".html"), std::string::npos);
  EXPECT_NE(all.find("session-" + std::to_string(r.sessions[1]) + ".txt"), std::string::npos);
  EXPECT_EQ(all.find("group.html"), std::string::npos) << "one page needs no table of all";
  const std::vector<SessionId> many(kMaxReports + 1, r.sessions[0]);
  EXPECT_EQ(Bundle::open(r.database, many, BundleLayout::reports).error().field, "reports");
  EXPECT_EQ(Bundle::open(r.database, {}, BundleLayout::files).error().field, "sessions");
  EXPECT_TRUE(Bundle::open(r.database, many, BundleLayout::files).ok());
}

TEST(Report, ASessionThatIsBeingRecordedHasNone) {
  Recorded r;
  r.walk("P-01", "");
  EXPECT_EQ(read_report_session(r.database, r.sessions.front()).error().kind, ErrorKind::wrong_state);
  EXPECT_EQ(read_report_session(r.database, 99).error().kind, ErrorKind::not_found);
}

}  // namespace
}  // namespace hoist::db::test
