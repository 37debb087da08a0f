// Several sessions in one table.
#include <cmath>

#include "db/report/page.hpp"
#include "db/report/report.hpp"

namespace hoist::db {

namespace {

using report::Cell;
using report::Page;
using report::Word;

std::string who(const Page& page, const SessionInfo& session) {
  const std::string code = session.study ? session.study->subject : session.subject.value_or("–");
  return session.simulated ? page.w(Word::of_simulation, {code}) : code;
}

// Over the valid values of a column.
struct Spread {
  std::size_t count = 0;
  double mean = 0, deviation = 0;
};
Spread spread_of(std::span<const ReportSession> sessions, std::size_t figure) {
  Spread out;
  double squares = 0;
  for (const ReportSession& one : sessions) {
    const auto& value = one.metrics.figures[figure].value;
    if (!value) continue;
    const double before = *value - out.mean;
    out.mean += before / static_cast<double>(++out.count);
    squares += before * (*value - out.mean);
  }
  out.deviation = out.count > 1 ? std::sqrt(squares / static_cast<double>(out.count - 1)) : 0;
  return out;
}

void add_feet(const Page& page, report::Table& table, std::span<const ReportSession> sessions, std::span<const std::size_t> figures) {
  std::vector<Cell> means, deviations, counts;
  for (const std::size_t figure : figures) {
    const Spread spread = spread_of(sessions, figure);
    const auto shown = [&](bool known, double value) {
      return Cell{known ? report::figure_text(kMetrics[figure], value, page.language()) : "", Cell::Style::number};
    };
    means.push_back(shown(spread.count > 0, spread.mean));
    deviations.push_back(shown(spread.count > 1, spread.deviation));
    counts.push_back({std::to_string(spread.count), Cell::Style::number});
  }
  constexpr std::size_t kBefore = 4;  // columns before the figures
  table.foot(page.w(Word::mean), kBefore, means);
  table.foot(page.w(Word::deviation), kBefore, deviations);
  table.foot(page.w(Word::count), kBefore, counts);
}

}  // namespace

std::string group_report(std::span<const ReportSession> sessions, const ReportOptions& options) {
  Page page(Word::group_title, options);
  std::vector<std::size_t> figures;
  for (std::size_t i = 0; i < kMetrics.size(); ++i)
    if (report::is_main(kMetrics[i])) figures.push_back(i);
  std::vector<report::Table::Column> columns{
      {page.w(Word::session), true}, {page.w(Word::date)}, {page.w(Word::patient)}, {page.w(Word::exercise)}};
  for (const std::size_t i : figures) columns.push_back({page.title_of(kMetrics[i]), true});
  report::Table table(columns);
  for (const ReportSession& one : sessions) {
    std::vector<Cell> cells{{std::to_string(one.session.id), Cell::Style::number},
                            {report::time_text(one.session.started_utc_ns, page.language())},
                            {who(page, one.session)},
                            {report::walked_text(one.session.exercise_json, page.language())}};
    for (const std::size_t i : figures) cells.push_back(page.cell(kMetrics[i], one.metrics.figures[i]));
    page.recorded_by(one.session);
    table.row(cells);
  }
  add_feet(page, table, sessions, figures);
  page.text(page.w(Word::sessions) + ": " + std::to_string(sessions.size()));
  page.table(table);
  return page.whole();
}

}  // namespace hoist::db
