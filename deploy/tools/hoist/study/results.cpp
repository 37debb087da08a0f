#include "deploy/tools/hoist/study/results.hpp"

#include <algorithm>
#include <cctype>
#include <set>

#include "db/metrics/table_mean.hpp"
#include "db/store/session_reader.hpp"
#include "db/summary/session_metrics.hpp"

namespace hoist::tool::study {

namespace {

/// A lap counts as walked with this share of it missing: the last step of a therapist or patient is not on the mark.
constexpr double kAlmost = 0.05;

// "run 3" at the begin of a note.
std::optional<int> run_of(const std::string& note) {
  if (note.size() < 5 || note.compare(0, 4, "run ") != 0) return std::nullopt;
  std::size_t at = 4;
  int number = 0;
  while (at < note.size() && std::isdigit(static_cast<unsigned char>(note[at])) != 0 && number <= 99)
    number = 10 * number + (note[at++] - '0');
  return at == 4 ? std::nullopt : std::optional{number};
}

db::Result<std::vector<db::SessionInfo>> newest_first(db::Database& database) {
  std::vector<db::SessionInfo> all;
  db::SessionQuery query{.limit = db::kMaxPage, .before = {}, .subject = {}};
  do {
    db::Result<db::SessionPage> page = db::SessionReader(database).list(query);
    if (!page) return page.error();
    std::ranges::move(page->sessions, std::back_inserter(all));
    query.before = page->next;
  } while (query.before);
  return all;
}

// Why the run does not count; nothing when it does.
std::optional<LeftOut> missing_in(const Protocol& protocol, const db::SessionMetrics& metrics) {
  for (const char* key : {"C", "J_N"})
    if (!metrics[key].value) return LeftOut{.subject = {}, .figure = key, .why = metrics[key].why};
  const double done = *metrics["completion_norm"].value;
  if (done < protocol.laps - kAlmost) return LeftOut{.subject = {}, .figure = {}, .laps = done};
  return {};
}

// Whether `word` stands in the note, with no letter or digit directly before or behind it.
bool has_word(const std::string& note, const std::string& word) {
  const auto inside = [&](std::size_t at) { return at < note.size() && std::isalnum(static_cast<unsigned char>(note[at])) != 0; };
  for (std::size_t at = note.find(word); at != std::string::npos; at = note.find(word, at + 1))
    if ((at == 0 || !inside(at - 1)) && !inside(at + word.size())) return true;
  return false;
}

struct Walked {
  std::string subject;
  int run = 0;
};
// Whose run a session is; nothing when it is none of the study.
std::optional<Walked> walked_in(const db::SessionInfo& session, const Selection& selection) {
  if (!selection.only.empty() && !std::ranges::binary_search(selection.only, session.id)) return {};
  if (selection.tag && !has_word(session.note, *selection.tag)) return {};
  if (selection.study) {
    if (!session.study || session.study->study != *selection.study) return {};
    return Walked{session.study->subject, session.study->run};
  }
  const std::optional<int> run = run_of(session.note);
  if (!run || !session.subject || session.study) return {};
  return Walked{*session.subject, *run};
}

}  // namespace

std::string sentence(const LeftOut& one) {
  const std::string where = one.subject + " run " + std::to_string(one.run) + ": ";
  if (one.figure.empty()) return where + "only " + std::to_string(one.laps).substr(0, 4) + " laps";
  return where + std::string(one.figure) + ": " + std::string(db::no_figure_sentence(one.why));
}

db::Result<Results> evaluate(db::Database& database, const Protocol& protocol, const Selection& selection) {
  const db::Result<std::vector<db::SessionInfo>> sessions = newest_first(database);
  if (!sessions) return sessions.error();
  std::map<std::pair<std::string, int>, db::SessionId> found;
  std::set<std::string> subjects;
  for (const db::SessionInfo& session : *sessions) {
    const std::optional<Walked> walked = walked_in(session, selection);
    if (!walked || protocol.find(walked->run) == nullptr) continue;
    found.emplace(std::pair{walked->subject, walked->run}, session.id);
    subjects.insert(walked->subject);
  }
  Results out;
  out.subjects.assign(subjects.begin(), subjects.end());
  for (const std::string_view figure : kTold)
    for (const Run& run : protocol.runs) out.columns[std::string(figure)][run.number].resize(out.subjects.size());
  for (std::size_t row = 0; row < out.subjects.size(); ++row) {
    for (const Run& run : protocol.runs) {
      const auto at = found.find({out.subjects[row], run.number});
      if (at == found.end()) continue;
      const db::Result<db::SessionMetrics> metrics = db::session_metrics(database, at->second);
      if (!metrics) return metrics.error();
      if (std::optional<LeftOut> why = missing_in(protocol, *metrics)) {
        why->subject = out.subjects[row];
        why->run = run.number;
        out.left_out.push_back(std::move(*why));
        continue;
      }
      out.runs[{row, run.number}] = at->second;
      for (const std::string_view figure : kTold) out.columns[std::string(figure)][run.number][row] = (*metrics)[figure].value;
    }
  }
  return out;
}

std::optional<double> mean_of(const Column& column) {
  std::vector<std::vector<std::optional<double>>> rows;
  for (const std::optional<double>& value : column) rows.push_back({value});
  const auto means = db::table_mean(rows);
  return means.empty() ? std::nullopt : means.front();
}

}  // namespace hoist::tool::study
