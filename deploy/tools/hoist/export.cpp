// hoist export: a recorded session as a file that other programs read.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "db/export/session_export.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/recording_file.hpp"

namespace hoist::tool {

namespace {

void print_help(std::FILE* out) {
  std::string text = "usage: hoist export DB SESSION [--format " + std::string(db::kExportFormatNames) +
                     "]\n                    [--columns NAME,NAME] [--no-constant] [--no-comments] [--out FILE]\n\n"
                     "Writes a session to FILE, or to standard output. Numbers are printed exactly as they were stored.\n\n";
  for (const db::ExportFormatInfo& format : db::kExportFormats) {
    text += "  " + std::string(format.name);
    text.append(10 - std::min<std::size_t>(9, format.name.size()), ' ');
    text += std::string(format.doc) + "\n";
  }
  text +=
      "\n  --columns      these live values only\n"
      "  --no-constant  without the live values that never changed\n"
      "  --no-comments  without the '#' lines\n";
  std::fputs(text.c_str(), out);
}

struct CloseFile {
  void operator()(std::FILE* file) const { (void)std::fclose(file); }
};

}  // namespace

int run_export(std::span<const std::string_view> arguments) {
  std::vector<std::string_view> places;
  db::ExportOptions options;
  std::string out_file;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view argument = arguments[i];
    const auto value = [&]() -> std::optional<std::string_view> {
      if (i + 1 >= arguments.size()) return std::nullopt;
      return arguments[++i];
    };
    if (argument == "--help") {
      print_help(stdout);
      return kDone;
    }
    if (argument == "--format") {
      const auto name = value();
      const auto format = name ? db::find_export_format(*name) : std::nullopt;
      if (!format) return bad_usage("export", "--format is one of " + std::string(db::kExportFormatNames));
      options.format = *format;
    } else if (argument == "--columns") {
      const auto names = value();
      if (!names) return bad_usage("export", "--columns needs names");
      options.columns = db::column_names(*names);
    } else if (argument == "--no-comments") {
      options.comments = false;
    } else if (argument == "--no-constant") {
      options.constant = false;
    } else if (argument == "--out") {
      const auto file = value();
      if (!file) return bad_usage("export", "--out needs a file");
      out_file = *file;
    } else if (argument.starts_with("--")) {
      return bad_usage("export", "there is no option " + std::string(argument));
    } else {
      places.push_back(argument);
    }
  }
  const auto session = places.size() == 2 ? parse_session(places[1]) : std::nullopt;
  if (!session) return bad_usage("export", "name a database and a session's number");

  db::Result<db::Database> database = db::Database::attach(std::string(places[0]));
  if (!database) return refuse("export", database.error());
  db::Result<db::SessionExport> session_export = db::SessionExport::open(*database, *session, options);
  if (!session_export) return refuse("export", session_export.error());

  std::unique_ptr<std::FILE, CloseFile> file;
  std::FILE* out = stdout;
  if (!out_file.empty()) {
    file.reset(std::fopen(out_file.c_str(), "wb"));
    if (!file) return refuse("export", {db::ErrorKind::io, "cannot write " + out_file, {}});
    out = file.get();
  }
  std::string piece;
  for (;;) {
    const db::Result<bool> more = session_export->next_chunk(piece);
    if (!more) return refuse("export", more.error());
    if (!*more) break;
    if (std::fwrite(piece.data(), 1, piece.size(), out) != piece.size())
      return refuse("export", {db::ErrorKind::io, "the file could not be written", {}});
  }
  if (std::fflush(out) != 0) return refuse("export", {db::ErrorKind::io, "the file could not be written", {}});
  return kDone;
}

}  // namespace hoist::tool
