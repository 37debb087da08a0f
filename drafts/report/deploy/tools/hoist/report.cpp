// hoist report: a session, a patient's progress or a group on paper.
#include "db/report/report.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "control/contract/program_version.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/visits.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/recording_file.hpp"
#include "server/jobs/child.hpp"

namespace hoist::tool {

namespace {

constexpr const char* kHelp =
    "usage: hoist report DB SESSION... [--kind patient|full] [--language en|de] [--out FILE | --pdf FILE]\n"
    "       hoist report DB --patient CODE [...]\n\n"
    "A page for print (HTML): of one session, of several (a group, with means), or of a patient's progress. patient: one page in plain "
    "words;\n"
    "full (when not given): every figure with its definition and what makes it valid. Without --out on standard output. --pdf has Chromium "
    "print\n"
    "it, where that is installed (or $CHROME_PATH); elsewhere open the page in a browser and print it from there.\n";

struct Request {
  std::string database;
  std::vector<db::SessionId> sessions;
  std::optional<std::string> patient, out, pdf;
  db::ReportOptions options{.program = std::string(contract::program_version())};
};

// The sentence that says what is wrong, or nothing.
std::string read_option(std::string_view name, std::string_view value, Request& out) {
  if (name == "--kind") {
    const auto kind = db::find_report_kind(value);
    if (!kind) return "--kind: patient or full";
    out.options.kind = *kind;
  } else if (name == "--language") {
    const auto language = db::find_language(value);
    if (!language) return "--language: en or de";
    out.options.language = *language;
  } else if (name == "--patient") {
    out.patient = value;
  } else if (name == "--out") {
    out.out = value;
  } else if (name == "--pdf") {
    out.pdf = value;
  } else {
    return std::string(name) + " is not known";
  }
  return {};
}

std::string read_request(std::span<const std::string_view> arguments, Request& out) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view word = arguments[i];
    if (word.starts_with("--")) {
      if (i + 1 == arguments.size()) return std::string(word) + " needs a value";
      if (std::string wrong = read_option(word, arguments[++i], out); !wrong.empty()) return wrong;
    } else if (out.database.empty()) {
      out.database = word;
    } else if (const auto session = parse_session(word)) {
      out.sessions.push_back(*session);
    } else {
      return std::string(word) + " is no session";
    }
  }
  if (out.database.empty()) return "name the database";
  if (out.patient.has_value() == !out.sessions.empty()) return "name sessions, or a patient";
  if (out.out && out.pdf) return "either --out or --pdf";
  return {};
}

db::Result<std::string> patient_page(db::Database& database, const Request& request) {
  db::VisitQuery query;
  query.limit = db::kMaxPage;
  query.code_part = request.patient;
  const auto found = db::VisitReader(database).patients(query);
  if (!found) return found.error();
  const auto at = std::ranges::find(found->items, *request.patient, &db::PatientInfo::code);
  if (at == found->items.end()) return db::Error{db::ErrorKind::not_found, "there is no patient " + *request.patient, {}};
  return db::patient_report(database, at->id, request.options);
}

db::Result<std::string> group_page(db::Database& database, const Request& request) {
  std::vector<db::GroupRow> rows;
  for (const db::SessionId id : request.sessions) {
    auto row = db::group_row(database, id);
    if (!row) return row.error();
    rows.push_back(std::move(*row));
  }
  return db::group_report(rows, request.options);
}

bool write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  return static_cast<bool>(out.flush());
}

std::optional<std::string> browser() {
  if (const char* given = std::getenv("CHROME_PATH"); given != nullptr) return given;
  for (const char* path : {"/usr/bin/chromium", "/usr/bin/google-chrome"})
    if (::access(path, X_OK) == 0) return path;
  return std::nullopt;
}

int print_pdf(const std::string& page, const std::string& file) {
  const auto program = browser();
  if (!program) {
    std::fprintf(stderr, "hoist report: Chromium is not installed: write the page with --out and print it from any browser\n");
    return kRefused;
  }
  std::string pattern = (std::filesystem::temp_directory_path() / "hoist-report-XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr) return kRefused;
  const std::filesystem::path folder = pattern, html = folder / "report.html";
  std::vector<std::string> words{*program, "--headless", "--disable-gpu", "--no-pdf-header-footer", "--user-data-dir=" + pattern,
                                 "--print-to-pdf=" + std::filesystem::absolute(file).string(), "file://" + html.string()};
  // As root it has no sandbox of its own; the page is this program's and runs no script.
  if (::geteuid() == 0) words.insert(words.begin() + 1, "--no-sandbox");
  int code = 1;
  std::string said;
  if (write(html, page))
    if (auto child = server::Child::start(words)) {
      while (!child->ended())
        while (const auto line = child->line(1000)) said = *line;
      code = child->exit_code();
    }
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  if (code == 0 && std::filesystem::exists(file, ignored)) return kDone;
  std::fprintf(stderr, "hoist report: %s could not print %s: %s\n", program->c_str(), file.c_str(), said.c_str());
  return kRefused;
}

}  // namespace

int run_report(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(kHelp, stdout);
    return kDone;
  }
  Request request;
  if (const std::string wrong = read_request(arguments, request); !wrong.empty()) return bad_usage("report", wrong);
  db::Result<db::Database> database = db::Database::attach(request.database);
  if (!database) return refuse("report", database.error());
  const db::Result<std::string> page = request.patient             ? patient_page(*database, request)
                                       : request.sessions.size() > 1 ? group_page(*database, request)
                                                                     : db::session_report(*database, request.sessions.front(), request.options);
  if (!page) return refuse("report", page.error());
  if (request.pdf) return print_pdf(*page, *request.pdf);
  if (!request.out) {
    std::fwrite(page->data(), 1, page->size(), stdout);
    return kDone;
  }
  if (write(*request.out, *page)) return kDone;
  std::fprintf(stderr, "hoist report: %s cannot be written\n", request.out->c_str());
  return kRefused;
}

}  // namespace hoist::tool
