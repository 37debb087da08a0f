#include "deploy/tools/hoist/study/report.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

namespace hoist::tool::study {

namespace {

using nlohmann::json;

constexpr std::size_t kPaperSubjects = 11, kPaperRuns = 6;
constexpr double kNo = -9;  // a dash in the paper
using PaperTable = std::array<std::array<double, kPaperRuns>, kPaperSubjects>;

// As printed, page 8.
constexpr PaperTable kTableII{{{0.09, 0.60, 0.95, kNo, kNo, kNo},
                               {-0.05, 0.23, 0.91, kNo, kNo, kNo},
                               {0.05, 0.42, 0.86, 0.11, 0.47, 0.92},
                               {0.15, 0.76, 0.91, 0.10, 0.88, 0.91},
                               {0.06, 0.49, 0.77, 0.10, 0.65, 0.81},
                               {0.01, 0.18, 0.70, 0.14, 0.69, 0.92},
                               {0.09, 0.39, 0.89, 0.11, 0.45, 0.87},
                               {0.05, 0.24, 0.91, kNo, kNo, kNo},
                               {0.10, 0.70, 0.86, kNo, kNo, kNo},
                               {0.12, 0.35, 0.86, 0.12, 0.51, 0.93},
                               {0.12, 0.56, 0.95, 0.11, 0.77, 0.91}}};
constexpr PaperTable kTableIII{{{30.35, 9.42, 3.78, kNo, kNo, kNo},
                                {32.38, 8.41, 5.88, kNo, kNo, kNo},
                                {30.57, 29.73, 3.56, 30.92, 5.58, 2.12},
                                {36.93, 4.06, 3.41, 110.63, 11.12, 3.61},
                                {50.06, 6.80, 17.80, 31.17, 13.30, 9.87},
                                {29.83, 3.58, 7.05, 72.55, 3.63, 7.79},
                                {30.34, 5.01, 7.29, 32.15, 12.39, 4.43},
                                {10.64, 6.84, 5.05, kNo, kNo, kNo},
                                {31.79, 24.76, 4.78, kNo, kNo, kNo},
                                {34.96, 14.36, 6.62, 40.52, 31.22, 7.40},
                                {74.01, 12.20, 8.68, 78.78, 8.58, 7.72}}};

Column paper_column(const PaperTable& table, int run) {
  Column out;
  if (run < 1 || run > static_cast<int>(kPaperRuns)) return out;
  for (const auto& row : table) {
    const double value = row[static_cast<std::size_t>(run) - 1];
    out.push_back(value == kNo ? std::nullopt : std::optional{value});
  }
  return out;
}

struct Told {
  std::string_view figure, title;
  const PaperTable* paper;
  int decimals;
};
constexpr Told kTables[] = {
    {"C", "Table II: C at zero lag, pelvis turn against the path's turn (higher is better)", &kTableII, 2},
    {"J_N", "Table III: J_N, squared error per metre of path at 100 Hz (lower is better)", &kTableIII, 2},
};
struct Other {
  std::string_view figure, name;
  double factor;
  int decimals;
};
constexpr Other kOthers[] = {{"C_best", "C at its best lag", 1, 2},
                             {"rms_position_m", "path error RMS, cm", 100, 1},
                             {"rms_heading_rad", "heading error RMS, deg", 57.29577951308232, 1},
                             {"walking_speed_m_s", "speed while walking, m/s", 1, 3},
                             {"lap_time_mean_s", "time for a lap, s", 1, 1}};

Table table_of(const Protocol& protocol, const Results& results, const Told& told) {
  Table table{.figure = told.figure, .title = told.title, .decimals = told.decimals};
  table.subjects = results.subjects;
  table.subjects.resize(std::max(results.subjects.size(), kPaperSubjects), "-");
  for (const Run& run : protocol.runs) {
    table.own.push_back(results.column(told.figure, run.number));
    table.paper.push_back(paper_column(*told.paper, run.number));
    table.own_mean.push_back(mean_of(table.own.back()));
    table.paper_mean.push_back(mean_of(table.paper.back()));
    for (Column* column : {&table.own.back(), &table.paper.back()}) column->resize(table.subjects.size());
  }
  return table;
}

// The mean over all subjects and those runs.
std::optional<double> mean_where(const Protocol& protocol, const Results& results, std::string_view figure, bool square, bool by_patient) {
  Column all;
  for (const Run& run : protocol.runs) {
    if ((run.shape == contract::ExerciseShape::square) != square || run.by_patient != by_patient) continue;
    const Column& column = results.column(figure, run.number);
    all.insert(all.end(), column.begin(), column.end());
  }
  return mean_of(all);
}

json column_json(const Column& column) {
  json out = json::array();
  for (const std::optional<double>& value : column) out.push_back(value ? json(*value) : json(nullptr));
  return out;
}
json columns_json(const std::vector<Column>& columns) {
  json out = json::array();
  for (const Column& column : columns) out.push_back(column_json(column));
  return out;
}
json or_null(const std::optional<double>& value) { return value ? json(*value) : json(nullptr); }
json test_json(const db::PairedTest& test) {
  return {{"pairs", test.pairs}, {"up", test.up}, {"down", test.down}, {"mean_first", test.mean_first}, {"mean_second", test.mean_second},
          {"p", or_null(test.p)}};
}

json assumed_json(const Assumptions& a) {
  return {{"wish_m_s", a.wish_m_s},
          {"anticipation_norm", a.anticipation_norm},
          {"learning_norm", a.learning_norm},
          {"trailing_s", a.trailing_s},
          {"limp_norm", a.limp_norm},
          {"injured_sway_norm", a.injured_sway_norm},
          {"therapist_m_s", a.therapist_m_s},
          {"therapist_delay_s", a.therapist_delay_s},
          {"misjudgement_m", a.misjudgement_m},
          {"misjudgement_rad", a.misjudgement_rad}};
}

}  // namespace

Report report_of(const Protocol& protocol, const Results& results) {
  Report report;
  for (const Told& told : kTables) report.tables.push_back(table_of(protocol, results, told));
  for (const auto& [from, to] : protocol.compared)
    for (const Told& told : kTables)
      report.comparisons.push_back({.figure = told.figure,
                                    .from = from,
                                    .to = to,
                                    .decimals = told.decimals,
                                    .own = db::paired_test(results.column(told.figure, from), results.column(told.figure, to)),
                                    .paper = db::paired_test(paper_column(*told.paper, from), paper_column(*told.paper, to))});
  for (const Other& other : kOthers) {
    OtherMeans means{.figure = other.figure, .name = other.name, .factor = other.factor, .decimals = other.decimals, .means = {}};
    for (const Run& run : protocol.runs) means.means.push_back(mean_of(results.column(other.figure, run.number)));
    report.others.push_back(std::move(means));
  }
  const auto j_square = mean_where(protocol, results, "J_N", true, false), j_eight = mean_where(protocol, results, "J_N", false, false);
  report.findings = {.c_square = mean_where(protocol, results, "C", true, false),
                     .c_led = mean_where(protocol, results, "C", false, true),
                     .j_ratio = j_square && j_eight ? std::optional(*j_square / *j_eight) : std::nullopt};
  return report;
}

json report_json(const Protocol& protocol, const Results& results, const Report& report, const Origin& origin) {
  json runs = json::array(), tables = json::array(), compared = json::array(), others = json::array();
  for (const Run& run : protocol.runs)
    runs.push_back({{"run", run.number},
                    {"shape", contract::find_exercise(run.shape)->name},
                    {"led_by", run.by_patient ? "patient" : "therapist"},
                    {"injured", run.injured}});
  for (const Table& table : report.tables)
    tables.push_back({{"figure", table.figure},
                      {"decimals", table.decimals},
                      {"subjects", table.subjects},
                      {"own", columns_json(table.own)},
                      {"paper", columns_json(table.paper)},
                      {"own_mean", column_json(table.own_mean)},
                      {"paper_mean", column_json(table.paper_mean)}});
  for (const Comparison& one : report.comparisons)
    compared.push_back({{"figure", one.figure},
                        {"from", one.from},
                        {"to", one.to},
                        {"decimals", one.decimals},
                        {"own", test_json(one.own)},
                        {"paper", test_json(one.paper)}});
  for (const OtherMeans& one : report.others) others.push_back({{"figure", one.figure}, {"means", column_json(one.means)}});
  json left_out = json::array();
  for (const LeftOut& one : results.left_out)
    left_out.push_back({{"subject", one.subject},
                        {"run", one.run},
                        {"figure", one.figure.empty() ? json(nullptr) : json(one.figure)},
                        {"reason_code", one.figure.empty() ? json(nullptr) : json(db::no_figure_name(one.why))},
                        {"laps", one.figure.empty() ? json(one.laps) : json(nullptr)}});
  return {{"title", protocol.title},
          {"virtual_subjects", origin.virtual_subjects},
          {"subjects", results.subjects.size()},
          {"seed", origin.seed ? json(*origin.seed) : json(nullptr)},
          {"preset", protocol.preset},
          {"laps", protocol.laps},
          {"runs", std::move(runs)},
          {"tables", std::move(tables)},
          {"compared", std::move(compared)},
          {"others", std::move(others)},
          {"findings",
           {{"c_square", or_null(report.findings.c_square)},
            {"c_led", or_null(report.findings.c_led)},
            {"j_ratio", or_null(report.findings.j_ratio)}}},
          {"assumed", origin.virtual_subjects ? assumed_json(protocol.assumed) : json(nullptr)},
          {"left_out", std::move(left_out)}};
}

}  // namespace hoist::tool::study
