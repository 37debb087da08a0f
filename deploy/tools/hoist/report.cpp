// hoist report: recorded sessions on paper, one page each, and all of them in one table.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "control/contract/program_version.hpp"
#include "db/export/bundle.hpp"
#include "db/report/batch.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/out_file.hpp"
#include "deploy/tools/hoist/recording_file.hpp"

namespace hoist::tool {

namespace {

constexpr const char* kReportHelp =
    "usage: hoist report DB [--session N]... [--patient CODE] [--tag TAG] --out DIR\n"
    "                    [--kind patient|full] [--language en|de] [--no-simulated]\n\n"
    "Writes session-N.html into DIR for each chosen session, and group.html when there are several: pages for print, made into paper or "
    "PDF\n"
    "by a browser. Patient codes, never names.\n\n"
    "  --session      this session; may be given several times\n"
    "  --patient      all sessions of this patient code\n"
    "  --tag          sessions whose note holds the word #TAG\n"
    "  --kind         patient: one page in plain words; full (when not given): every figure with its definition and what makes it valid\n"
    "  --no-simulated with --patient or --tag: without recordings of a simulated hoist\n";

struct Request {
  std::string database;
  std::filesystem::path out;
  std::vector<db::SessionId> sessions;
  db::SessionFilter filter;
  db::ReportOptions options{.program = std::string(contract::program_version())};
};

// What is wrong with the option, or nothing.
std::string read_option(std::string_view name, std::string_view value, Request& out) {
  if (name == "--session") {
    const auto session = parse_session(value);
    if (!session) return std::string(value) + " is no session's number";
    if (std::ranges::count(out.sessions, *session) == 0) out.sessions.push_back(*session);
  } else if (name == "--kind") {
    const auto kind = db::find_report_kind(value);
    if (!kind) return "--kind is patient or full";
    out.options.kind = *kind;
  } else if (name == "--language") {
    const auto language = db::find_language(value);
    if (!language) return "--language is en or de";
    out.options.language = *language;
  } else if (name == "--patient") {
    out.filter.subject = value;
  } else if (name == "--tag") {
    out.filter.tag = value;
  } else if (name == "--out") {
    out.out = value;
  } else {
    return "there is no option " + std::string(name);
  }
  return {};
}

std::string read_request(std::span<const std::string_view> arguments, Request& out) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view word = arguments[i];
    if (word == "--no-simulated") {
      out.filter.simulated = false;
    } else if (word.starts_with("--")) {
      if (i + 1 == arguments.size()) return std::string(word) + " needs a value";
      if (std::string wrong = read_option(word, arguments[++i], out); !wrong.empty()) return wrong;
    } else if (out.database.empty()) {
      out.database = word;
    } else {
      return "there is no use for " + std::string(word);
    }
  }
  if (out.database.empty()) return "name the database";
  if (out.out.empty()) return "--out names the folder";
  const bool filtered = out.filter.subject || out.filter.tag;
  if (out.sessions.empty() != filtered) return "choose by --session, or by --patient and --tag";
  if (!filtered && !out.filter.simulated) return "--no-simulated belongs to --patient and --tag";
  return {};
}

// One line that counts, on a terminal.
void show_progress(std::size_t done, std::size_t of) {
  if (::isatty(STDERR_FILENO) != 1) return;
  std::fprintf(stderr, "\rhoist report: %zu of %zu%s", done, of, done == of ? "\n" : "");
}

int write_all(db::Database& database, const Request& request, const std::vector<db::SessionId>& sessions) {
  db::ReportBatch batch(database, request.options);
  std::size_t written = 0;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const auto page = batch.page(sessions[i]);
    const db::Status done =
        page ? write_file(request.out / ("session-" + std::to_string(sessions[i]) + ".html"), *page) : db::Status(page.error());
    if (done.ok())
      ++written;
    else
      std::fprintf(stderr, "hoist report: session %lld: %s\n", static_cast<long long>(sessions[i]), done.error().message.c_str());
    show_progress(i + 1, sessions.size());
  }
  if (written > 1)
    if (const db::Status done = write_file(request.out / "group.html", batch.group()); !done.ok()) return refuse("report", done.error());
  std::printf("%zu of %zu reports written to %s\n", written, sessions.size(), request.out.c_str());
  if (written == sessions.size()) return kDone;
  return written == 0 ? kRefused : kPartly;
}

}  // namespace

int run_report(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(kReportHelp, stdout);
    return kDone;
  }
  Request request;
  if (const std::string wrong = read_request(arguments, request); !wrong.empty()) return bad_usage("report", wrong);
  db::Result<db::Database> database = db::Database::attach(request.database);
  if (!database) return refuse("report", database.error());
  std::vector<db::SessionId> sessions = request.sessions;
  if (sessions.empty()) {
    auto chosen = db::select_sessions(*database, request.filter);
    if (!chosen) return refuse("report", chosen.error());
    sessions = std::move(*chosen);
  }
  if (sessions.empty()) return refuse("report", {db::ErrorKind::not_found, "no session is chosen by this", {}});
  std::error_code failed;
  std::filesystem::create_directories(request.out, failed);
  if (failed) return refuse("report", {db::ErrorKind::io, "cannot make the folder " + request.out.string(), {}});
  return write_all(*database, request, sessions);
}

}  // namespace hoist::tool
