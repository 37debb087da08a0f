// hoist export: a recorded session as a file that other programs read.
#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "control/contract/program_version.hpp"
#include "db/export/bundle.hpp"
#include "db/export/session_export.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/out_file.hpp"
#include "deploy/tools/hoist/recording_file.hpp"

namespace hoist::tool {

namespace {

void print_export_help(std::FILE* out) {
  std::string text =
      "usage: hoist export DB SESSION [--format " + std::string(db::kExportFormatNames) +
      "]\n                    [--columns NAME,NAME] [--no-constant] [--no-comments] [--out FILE]\n\n"
      "       hoist export DB [SESSION…] --bundle files|bids|sqlite|reports [--subject CODE] [--from DAY] [--to DAY] [--exercise SHAPE]\n"
      "                    [--tag TAG] [--visit ID] [--no-simulated] [--out FILE]\n\n"
      "Writes a session to FILE, or to standard output. Numbers are printed exactly as they were stored. An earlier FILE is replaced when "
      "the\nnew one is whole; FILE is readable for its user only.\n\n";
  for (const db::ExportFormatInfo& format : db::kExportFormats) {
    text += "  " + std::string(format.name);
    text.append(10 - std::min<std::size_t>(9, format.name.size()), ' ');
    text += std::string(format.doc) + "\n";
  }
  text +=
      "\n  --columns      these live values only\n"
      "  --no-constant  without the live values that never changed\n"
      "  --no-comments  without the '#' lines\n\n"
      "  --bundle       several sessions in one file, those named or all that the filters leave: a ZIP (bids: as Motion-BIDS lays it out;\n"
      "                 reports: full pages for print in English, see hoist report) or plain tables of SQLite\n"
      "  --tag          sessions whose note holds the word #TAG\n";
  std::fputs(text.c_str(), out);
}

}  // namespace

namespace {

struct Wish {
  std::vector<std::string_view> places;  // DB, SESSION…
  db::ExportOptions options;
  std::optional<db::BundleLayout> bundle;
  db::SessionFilter filter;
  std::string out_file;
  std::string_view filtered_by, formatted_by;  // one of the options of that kind; empty = none
};

// Which sessions go into a bundle, and what the export of one session looks like.
constexpr std::array<std::string_view, 7> kFilterOptions{"--subject", "--from", "--to", "--exercise", "--tag", "--visit", "--no-simulated"};
constexpr std::array<std::string_view, 4> kFormatOptions{"--format", "--columns", "--no-constant", "--no-comments"};

// The last word on an option: nothing, or why it cannot be used.
using Refusal = std::optional<std::string>;

Refusal take_option(Wish& wish, std::string_view option, const std::function<std::optional<std::string_view>()>& value) {
  const auto text = [&](std::optional<std::string>& to) -> Refusal {
    const auto given = value();
    if (!given) return std::string(option) + " needs a value";
    to = std::string(*given);
    return std::nullopt;
  };
  if (option == "--subject") return text(wish.filter.subject);
  if (option == "--from") return text(wish.filter.from_day);
  if (option == "--to") return text(wish.filter.to_day);
  if (option == "--exercise") return text(wish.filter.exercise);
  if (option == "--tag") return text(wish.filter.tag);
  if (option == "--no-comments")
    wish.options.comments = false;
  else if (option == "--no-constant")
    wish.options.constant = false;
  else if (option == "--no-simulated")
    wish.filter.simulated = false;
  else if (option == "--format") {
    const auto name = value();
    const auto format = name ? db::find_export_format(*name) : std::nullopt;
    if (!format) return "--format is one of " + std::string(db::kExportFormatNames);
    wish.options.format = *format;
  } else if (option == "--bundle") {
    const auto name = value();
    wish.bundle = name ? db::find_bundle_layout(*name) : std::nullopt;
    if (!wish.bundle) return "--bundle is files, bids, sqlite or reports";
  } else if (option == "--visit") {
    const auto id = value();
    wish.filter.visit = id ? parse_session(*id) : std::nullopt;
    if (!wish.filter.visit) return "--visit needs the number of a visit";
  } else if (option == "--columns") {
    const auto names = value();
    if (!names) return "--columns needs names";
    wish.options.columns = db::column_names(*names);
  } else if (option == "--out") {
    const auto file = value();
    if (!file) return "--out needs a file";
    wish.out_file = *file;
  } else {
    return "there is no option " + std::string(option);
  }
  return std::nullopt;
}

// Writes every piece to the file, or to standard output.
int write_all(const std::string& out_file, const std::function<db::Result<bool>(std::string&)>& next) {
  OutFile file;
  std::FILE* out = stdout;
  if (!out_file.empty()) {
    if (const db::Status opened = file.open(out_file); !opened) return refuse("export", opened.error());
    out = file.stream();
  }
  std::string piece;
  for (;;) {
    const db::Result<bool> more = next(piece);
    if (!more) return refuse("export", more.error());
    if (!*more) break;
    if (std::fwrite(piece.data(), 1, piece.size(), out) != piece.size()) break;
  }
  if (out_file.empty()) return kDone;
  const db::Status written = file.finish();
  return written ? kDone : refuse("export", written.error());
}

int export_bundle(db::Database& database, const Wish& wish, std::vector<db::SessionId> sessions) {
  if (sessions.empty()) {
    db::Result<std::vector<db::SessionId>> chosen = db::select_sessions(database, wish.filter);
    if (!chosen) return refuse("export", chosen.error());
    sessions = std::move(*chosen);
  }
  db::Result<db::Bundle> bundle =
      db::Bundle::open(database, std::move(sessions), *wish.bundle, {.program = std::string(contract::program_version())});
  if (!bundle) return refuse("export", bundle.error());
  return write_all(wish.out_file, [&](std::string& piece) { return bundle->next_chunk(piece); });
}

}  // namespace

int run_export(std::span<const std::string_view> arguments) {
  Wish wish;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view argument = arguments[i];
    const auto value = [&]() -> std::optional<std::string_view> {
      if (i + 1 >= arguments.size()) return std::nullopt;
      return arguments[++i];
    };
    if (argument == "--help") {
      print_export_help(stdout);
      return kDone;
    }
    if (!argument.starts_with("--"))
      wish.places.push_back(argument);
    else if (const Refusal refusal = take_option(wish, argument, value))
      return bad_usage("export", *refusal);
    if (std::ranges::count(kFilterOptions, argument) > 0) wish.filtered_by = argument;
    if (std::ranges::count(kFormatOptions, argument) > 0) wish.formatted_by = argument;
  }
  std::vector<db::SessionId> sessions;
  for (std::size_t i = 1; i < wish.places.size(); ++i) {
    const auto session = parse_session(wish.places[i]);
    if (!session) return bad_usage("export", std::string(wish.places[i]) + " is no session's number");
    if (std::ranges::count(sessions, *session) == 0) sessions.push_back(*session);
  }
  if (wish.places.empty() || (!wish.bundle && sessions.size() != 1)) return bad_usage("export", "name a database and a session's number");
  // An option that is not looked at would let sessions out that it was meant to keep back.
  if (!wish.filtered_by.empty() && (!wish.bundle || !sessions.empty()))
    return bad_usage("export", std::string(wish.filtered_by) + " chooses the sessions of a --bundle; none may be named beside it");
  if (!wish.formatted_by.empty() && wish.bundle)
    return bad_usage("export", std::string(wish.formatted_by) + " belongs to one session without --bundle");
  db::Result<db::Database> database = db::Database::attach(std::string(wish.places[0]));
  if (!database) return refuse("export", database.error());
  if (wish.bundle) return export_bundle(*database, wish, std::move(sessions));
  db::Result<db::SessionExport> session_export = db::SessionExport::open(*database, sessions.front(), wish.options);
  if (!session_export) return refuse("export", session_export.error());
  return write_all(wish.out_file, [&](std::string& piece) { return session_export->next_chunk(piece); });
}

}  // namespace hoist::tool
