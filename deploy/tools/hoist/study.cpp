// hoist study: the paper's experiment with virtual subjects, or the evaluation of a recorded one.
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "db/store/database.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/recording_file.hpp"
#include "deploy/tools/hoist/study/drawings.hpp"
#include "deploy/tools/hoist/study/protocol.hpp"
#include "deploy/tools/hoist/study/record_runs.hpp"
#include "deploy/tools/hoist/study/results.hpp"
#include "deploy/tools/hoist/study/tables.hpp"

namespace hoist::tool {

namespace {

using study::Protocol;
using study::Results;

constexpr const char* kHelp =
    "usage: hoist study --subjects N [--seed S] [--protocol FILE] [--out DB] [--svg FOLDER]\n"
    "       hoist study --recorded DB [--protocol FILE] [--svg FOLDER]\n"
    "       hoist study --protocol-text\n\n"
    "Tables II and III of the paper, the paper's own beside them, and paired tests. The first form walks virtual subjects through the "
    "core, the\n"
    "nodes' firmware and the bus in virtual time, as the protocol says (without FILE: the paper's, see --protocol-text), records every run "
    "and\n"
    "evaluates the recordings; --out keeps them in a new database. The second evaluates recorded sessions: those with a patient's code "
    "whose note\n"
    "begins with \"run N\". --svg draws Figures 2, 7 and 8. Exit code 3: runs were left out, and which.\n";

struct Request {
  std::optional<std::string> recorded, protocol, out, svg;
  int subjects = 0;
  std::uint64_t seed = 1;
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

bool write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  return static_cast<bool>(out.flush());
}

int draw(db::Database& database, const Protocol& protocol, const Results& results, const std::string& folder) {
  const db::Result<std::string> tracks = study::tracks_drawing(database, protocol, results);
  if (!tracks) return refuse("study", tracks.error());
  std::error_code ignored;
  std::filesystem::create_directories(folder, ignored);
  const std::filesystem::path to(folder);
  if (!write(to / "figure-2.svg", study::braking_drawing()) || !write(to / "figure-7.svg", study::shapes_drawing(protocol)) ||
      !write(to / "figure-8.svg", *tracks)) {
    std::fprintf(stderr, "hoist study: %s cannot be written\n", folder.c_str());
    return kRefused;
  }
  std::printf("Drawn: %s/figure-2.svg, figure-7.svg, figure-8.svg\n", folder.c_str());
  return kDone;
}

int tell(db::Database& database, const Request& request, const Protocol& protocol) {
  const db::Result<Results> results = study::evaluate(database, protocol);
  if (!results) return refuse("study", results.error());
  if (results->subjects.empty()) {
    std::fprintf(stderr, "hoist study: no session has a patient's code and a note that begins with \"run N\"\n");
    return kRefused;
  }
  const std::string kind = request.recorded ? "recorded sessions" : "virtual subjects, seed " + std::to_string(request.seed);
  std::printf("%s; %zu subjects; %s\n\n%s", protocol.title.c_str(), results->subjects.size(), kind.c_str(),
              study::tables(protocol, *results).c_str());
  if (!request.recorded) std::printf("%s", study::assumptions_and_findings(protocol, *results).c_str());
  if (request.svg)
    if (const int code = draw(database, protocol, *results, *request.svg); code != kDone) return code;
  return results->left_out.empty() ? kDone : kPartly;
}

int walk_and_tell(const Request& request, const Protocol& protocol) {
  const Scratch scratch;
  if (!request.out && scratch.path().empty()) {
    std::fprintf(stderr, "hoist study: no temporary folder can be made\n");
    return kRefused;
  }
  const std::filesystem::path file = request.out ? std::filesystem::path(*request.out) : scratch.path() / "study.db";
  if (std::filesystem::exists(file)) return bad_usage("study", file.string() + " exists already");
  db::Result<db::Database> database = db::Database::open(file);
  if (!database) return refuse("study", database.error());
  if (db::Status walked = study::walk_all(*database, protocol, request.subjects, request.seed); !walked)
    return refuse("study", walked.error());
  return tell(*database, request, protocol);
}

template <class Number>
bool read_number(std::string_view text, Number& out, Number least, Number most) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size() && out >= least && out <= most;
}

// The sentence that says what is wrong, or nothing.
std::string read_request(std::span<const std::string_view> arguments, Request& out) {
  for (std::size_t i = 0; i + 1 < arguments.size(); i += 2) {
    const std::string_view name = arguments[i], value = arguments[i + 1];
    if (name == "--subjects") {
      if (!read_number(value, out.subjects, 1, static_cast<int>(study::kMostSubjects))) return "--subjects: 1 to 99";
    } else if (name == "--seed") {
      if (!read_number<std::uint64_t>(value, out.seed, 0, 1'000'000'000)) return "--seed: 0 to 1000000000";
    } else if (name == "--recorded") {
      out.recorded = value;
    } else if (name == "--protocol") {
      out.protocol = value;
    } else if (name == "--out") {
      out.out = value;
    } else if (name == "--svg") {
      out.svg = value;
    } else {
      return std::string(name) + " is not known";
    }
  }
  if (arguments.size() % 2 != 0) return std::string(arguments.back()) + " needs a value";
  if (out.recorded.has_value() == (out.subjects > 0)) return "say how many virtual subjects, or which recordings";
  if (out.recorded && out.out) return "--out belongs to virtual subjects";
  return {};
}

}  // namespace

int run_study(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(kHelp, stdout);
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
  if (!request.recorded) return walk_and_tell(request, *protocol);
  db::Result<db::Database> database = db::Database::attach(*request.recorded);
  if (!database) return refuse("study", database.error());
  return tell(*database, request, *protocol);
}

}  // namespace hoist::tool
