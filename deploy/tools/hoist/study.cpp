// hoist study: the paper's experiment with virtual subjects, or the evaluation of a recorded one.
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "db/archive/archive.hpp"
#include "db/store/database.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/out_file.hpp"
#include "deploy/tools/hoist/recording_file.hpp"
#include "deploy/tools/hoist/study/drawings.hpp"
#include "deploy/tools/hoist/study/protocol.hpp"
#include "deploy/tools/hoist/study/record_runs.hpp"
#include "deploy/tools/hoist/study/report.hpp"
#include "deploy/tools/hoist/study/results.hpp"
#include "deploy/tools/hoist/study/tables.hpp"

namespace hoist::tool {

namespace {

using study::Protocol;
using study::Results;

constexpr const char* kStudyHelp =
    "usage: hoist study --subjects N [--seed S] [--protocol FILE] [--out DB] [--figures FOLDER] [--json FILE]\n"
    "       hoist study --recorded DB [--tag WORD | --study N | --sessions N,N,…] [--protocol FILE] [--figures FOLDER] [--json FILE]\n"
    "       hoist study --archive TARGET [--from DAY] [--to DAY] [--tag WORD] [--protocol FILE] [--figures FOLDER] [--json FILE]\n\n"
    "Tables II and III of the paper, the paper's own beside them, and paired tests. The first form walks virtual subjects through the "
    "core, the\n"
    "nodes' firmware and the bus in virtual time, as the protocol says (without FILE: the paper's, see --protocol-text), records every run "
    "and\n"
    "evaluates the recordings; --out keeps them in a new database. The second evaluates recorded sessions: those with a patient's code "
    "whose note\n"
    "begins with \"run N\"; --tag takes only those whose note holds this word, --sessions only\n"
    "these, --study the runs of a study of virtual subjects that the "
    "server has\n"
    "made, or --out. The third evaluates sessions of several hoists in one archive (hoist archive --help): those of these days in UTC, "
    "from a "
    "copy\n"
    "that goes with the command. --figures draws Figures 2, 7 and 8 (SVG), --json writes what the console shows. For programs: "
    "--begin-utc-ms dates "
    "the first "
    "session,\n"
    "--progress 1 prints \"progress DONE ALL\" after each run. Exit code 3: runs were left out, and which.\n";

struct Request {
  std::optional<std::string> recorded, archive, protocol, out, figures, json;
  db::ArchiveQuery days;
  study::Selection selection;
  study::StudyRequest walk{.subjects = 0};
};

std::string file_text(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

/// A folder that is gone when the study has ended.
class Scratch {
 public:
  Scratch() {
    std::string pattern = (std::filesystem::temp_directory_path() / "hoist-study-XXXXXX").string();
    if (::mkdtemp(pattern.data()) != nullptr) path_ = pattern;
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

db::Result<std::vector<db::StudyDrawing>> drawings(db::Database& database, const Protocol& protocol, const Results& results) {
  db::Result<std::string> tracks = study::tracks_drawing(database, protocol, results);
  if (!tracks) return tracks.error();
  return std::vector<db::StudyDrawing>{
      {"figure-2", study::braking_drawing()}, {"figure-7", study::shapes_drawing(protocol)}, {"figure-8", std::move(*tracks)}};
}

int write_drawings(const std::vector<db::StudyDrawing>& drawn, const std::string& folder) {
  std::error_code ignored;
  std::filesystem::create_directories(folder, ignored);
  for (const db::StudyDrawing& one : drawn) {
    const std::filesystem::path file = std::filesystem::path(folder) / (one.name + ".svg");
    if (const db::Status written = write_file(file, one.svg); !written) return refuse("study", written.error());
    std::printf("Drawn: %s\n", file.c_str());
  }
  return kDone;
}

int refuse_empty(const Request& request) {
  std::fprintf(stderr, "hoist study: no session %s\n",
               request.selection.study ? "belongs to this study" : "has a patient's code and a note that begins with \"run N\"");
  return kRefused;
}

// `made`: the study of `database` that this command has walked, which is still to be finished.
int tell(db::Database& database, const Request& request, const Protocol& protocol, std::optional<db::StudyId> made) {
  study::Selection selection = request.selection;
  if (made) selection.study = made;
  const db::Result<Results> results = study::evaluate(database, protocol, selection);
  if (!results) return refuse("study", results.error());
  if (results->subjects.empty()) return refuse_empty(request);
  const bool virtual_subjects = selection.study.has_value();
  const std::string kind = made ? "virtual subjects, seed " + std::to_string(request.walk.seed) : "recorded sessions";
  const study::Report report = study::report_of(protocol, *results);
  std::printf("%s; %zu subjects; %s\n\n%s", protocol.title.c_str(), results->subjects.size(), kind.c_str(),
              study::tables(protocol, *results, report).c_str());
  if (made) std::printf("%s", study::assumptions_and_findings(protocol, report).c_str());
  const study::Origin origin{.virtual_subjects = virtual_subjects, .seed = made ? std::optional(request.walk.seed) : std::nullopt};
  const std::string json = study::report_json(protocol, *results, report, origin).dump();
  const db::Result<std::vector<db::StudyDrawing>> drawn = drawings(database, protocol, *results);
  if (!drawn) return refuse("study", drawn.error());
  if (made)
    if (db::Status finished = db::finish_study(database, *made, json, *drawn); !finished) return refuse("study", finished.error());
  if (request.figures)
    if (const int code = write_drawings(*drawn, *request.figures); code != kDone) return code;
  if (request.json)
    if (const db::Status written = write_file(*request.json, json); !written) return refuse("study", written.error());
  return results->left_out.empty() ? kDone : kPartly;
}

int refuse_scratch() {
  std::fprintf(stderr, "hoist study: no temporary folder can be made\n");
  return kRefused;
}

// Figures need whole sessions: they are fetched into a file that goes with the command.
int tell_archive(const Request& request, const Protocol& protocol) {
  const Scratch scratch;
  if (scratch.path().empty()) return refuse_scratch();
  auto archive = db::Archive::connect(*request.archive);
  if (!archive) return refuse("study", archive.error());
  auto database = db::Database::open(scratch.path() / "archive.db");
  if (!database) return refuse("study", database.error());
  if (const auto pulled = archive->pull(*database, request.days); !pulled) return refuse("study", pulled.error());
  return tell(*database, request, protocol, std::nullopt);
}

int walk_and_tell(const Request& request, const Protocol& protocol) {
  const Scratch scratch;
  if (!request.out && scratch.path().empty()) return refuse_scratch();
  const std::filesystem::path file = request.out ? std::filesystem::path(*request.out) : scratch.path() / "study.db";
  if (std::filesystem::exists(file)) return bad_usage("study", file.string() + " exists already");
  db::Result<db::Database> database = db::Database::open(file);
  if (!database) return refuse("study", database.error());
  const db::Result<db::StudyId> walked = study::walk_all(*database, protocol, request.walk);
  if (!walked) return refuse("study", walked.error());
  return tell(*database, request, protocol, *walked);
}

// At once: a program that ended reads no more, and SIGPIPE ends this one.
void print_progress(int done, int all) {
  std::printf("progress %d %d\n", done, all);
  std::fflush(stdout);
}

template <class Number>
bool read_number(std::string_view text, Number& out, Number least, Number most) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size() && out >= least && out <= most;
}

constexpr db::SessionId kMostSession = 9'007'199'254'740'991;
constexpr std::int64_t kMostBegin_ms = 4'000'000'000'000;

// One option and its value. The sentence that says what is wrong, or nothing.
std::string read_option(std::string_view name, std::string_view value, Request& out) {
  if (name == "--subjects") {
    if (!read_number(value, out.walk.subjects, 1, static_cast<int>(study::kMostSubjects))) return "--subjects: 1 to 99";
  } else if (name == "--seed") {
    if (!read_number<std::uint64_t>(value, out.walk.seed, 0, 1'000'000'000)) return "--seed: 0 to 1000000000";
  } else if (name == "--begin-utc-ms") {
    std::int64_t begin_ms = 0;
    if (!read_number<std::int64_t>(value, begin_ms, 0, kMostBegin_ms)) return "--begin-utc-ms: 0 to " + std::to_string(kMostBegin_ms);
    out.walk.begin_utc_ns = begin_ms * 1'000'000;
  } else if (name == "--progress") {
    if (value != "0" && value != "1") return "--progress: 0 or 1";
    if (value == "1") out.walk.progress = &print_progress;
  } else if (name == "--sessions") {
    for (std::size_t at = 0; at <= value.size();) {
      const std::size_t end = std::min(value.find(',', at), value.size());
      db::SessionId session = 0;
      if (!read_number<db::SessionId>(value.substr(at, end - at), session, 1, kMostSession))
        return "--sessions: numbers with commas between";
      out.selection.only.push_back(session);
      at = end + 1;
    }
    std::ranges::sort(out.selection.only);
  } else if (name == "--study") {
    std::int64_t study = 0;
    if (!read_number<std::int64_t>(value, study, 1, 1'000'000'000)) return "--study: 1 to 1000000000";
    out.selection.study = study;
  } else {
    const std::pair<std::string_view, std::optional<std::string>*> texts[] = {
        {"--recorded", &out.recorded}, {"--archive", &out.archive},   {"--from", &out.days.from_day},
        {"--to", &out.days.to_day},    {"--protocol", &out.protocol}, {"--out", &out.out},
        {"--figures", &out.figures},   {"--json", &out.json},         {"--tag", &out.selection.tag}};
    const auto at = std::ranges::find(texts, name, &std::pair<std::string_view, std::optional<std::string>*>::first);
    if (at == std::end(texts)) return std::string(name) + " is not known";
    if (value.empty()) return std::string(name) + " needs a value";
    *at->second = value;
  }
  return {};
}

// The sentence that says what is wrong, or nothing.
std::string read_request(std::span<const std::string_view> arguments, Request& out) {
  for (std::size_t i = 0; i + 1 < arguments.size(); i += 2)
    if (std::string wrong = read_option(arguments[i], arguments[i + 1], out); !wrong.empty()) return wrong;
  if (arguments.size() % 2 != 0) return std::string(arguments.back()) + " needs a value";
  const bool reads = out.recorded || out.archive;
  if ((out.recorded && out.archive) || reads == (out.walk.subjects > 0)) return "say how many virtual subjects, or which recordings";
  if (reads && out.out) return "--out belongs to virtual subjects";
  if (!out.recorded && !out.selection.only.empty()) return "--sessions belongs to --recorded";
  if (!reads && out.selection.tag) return "--tag belongs to --recorded and --archive";
  if (!out.recorded && out.selection.study) return "--study belongs to --recorded";
  if (!out.archive && (out.days.from_day || out.days.to_day)) return "--from and --to belong to --archive";
  if (out.selection.tag && out.selection.study) return "either --tag or --study";
  return {};
}

}  // namespace

int run_study(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(kStudyHelp, stdout);
    return kDone;
  }
  if (arguments.size() == 1 && arguments[0] == "--protocol-text") {
    std::printf("%s", std::string(study::paper_protocol()).c_str());
    return kDone;
  }
  Request request;
  if (const std::string wrong = read_request(arguments, request); !wrong.empty()) return bad_usage("study", wrong);
  std::string problem;
  const auto protocol =
      study::read_protocol(request.protocol ? file_text(*request.protocol) : std::string(study::paper_protocol()), problem);
  if (!protocol) return bad_usage("study", "the protocol: " + problem);
  if (request.archive) return tell_archive(request, *protocol);
  if (!request.recorded) return walk_and_tell(request, *protocol);
  db::Result<db::Database> database = db::Database::attach(*request.recorded);
  if (!database) return refuse("study", database.error());
  return tell(*database, request, *protocol, std::nullopt);
}

}  // namespace hoist::tool
