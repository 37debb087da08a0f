// hoist sql: SQL over a file of recordings, with the samples as plain rows.
#include <unistd.h>

#include <cstdio>
#include <iostream>
#include <optional>
#include <string>
#include <utility>

#include "db/export/source.hpp"
#include "db/export/sql.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/recording_file.hpp"

namespace hoist::tool {

namespace {

void print_sql_help(std::FILE* out) {
  std::fputs(
      "usage: hoist sql DB [\"SELECT …\"]\n\n"
      "Runs the statements, or those from standard input (each ends with ;), and prints their rows as CSV. Only reading is allowed.\n"
      "The table `samples` holds the samples of all sessions: session_id, time_s, utc, gap_before and each live value. Name the "
      "session:\n\n"
      "  hoist sql hoist.db \"SELECT time_s, speed_m_s FROM samples WHERE session_id = 12 AND time_s < 10\"\n",
      out);
}

void add_line(std::string& out, auto cells, auto text_of) {
  bool first = true;
  for (const auto& cell : cells) {
    if (!std::exchange(first, false)) out += ',';
    // Numbers may begin with a minus: only texts that a spreadsheet would run are marked.
    const std::string text = text_of(cell);
    const bool number = text.find_first_not_of("0123456789.+-eE") == std::string::npos;
    out += number ? text : db::csv_cell(text);
  }
  out += '\n';
}

// A row of names before the first row of each statement.
bool print(const db::SqlRow& row) {
  std::string text;
  if (row.first) add_line(text, row.names, [](const std::string& name) { return name; });
  add_line(text, row.cells, [](const std::optional<std::string>& cell) { return cell.value_or(""); });
  return std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
}

db::Status run(db::Database& database, std::string_view text) { return db::run_sql(database, text, &print); }

// Statement by statement; at a keyboard an error is told and the next one is asked for.
int run_input(db::Database& database) {
  const bool keyboard = ::isatty(STDIN_FILENO) == 1;
  std::string statement;
  const auto prompt = [&] {
    if (keyboard) std::cerr << (statement.empty() ? "hoist> " : "  ...> ") << std::flush;
  };
  int code = kDone;
  prompt();
  for (std::string line; std::getline(std::cin, line); prompt()) {
    statement += line + '\n';
    if (!db::is_complete_sql(statement)) continue;
    if (const db::Status done = run(database, statement); !done) {
      code = refuse("sql", done.error());
      if (!keyboard) return code;
    }
    std::fflush(stdout);
    statement.clear();
  }
  if (statement.find_first_not_of(" \t\r\n") == std::string::npos) return code;
  const db::Status done = run(database, statement);
  return done ? code : refuse("sql", done.error());
}

}  // namespace

int run_sql_command(std::span<const std::string_view> arguments) {
  for (const std::string_view argument : arguments)
    if (argument == "--help") {
      print_sql_help(stdout);
      return kDone;
    }
  if (arguments.empty() || arguments.size() > 2 || arguments[0].starts_with("--"))
    return bad_usage("sql", "name a database, and perhaps a statement in quotes");
  db::Result<db::Database> database = db::Database::attach(std::string(arguments[0]));
  if (!database) return refuse("sql", database.error());
  if (const db::Status enabled = db::enable_sql(*database); !enabled) return refuse("sql", enabled.error());
  if (arguments.size() == 1) return run_input(*database);
  const db::Status done = run(*database, arguments[1]);
  return done ? kDone : refuse("sql", done.error());
}

}  // namespace hoist::tool
