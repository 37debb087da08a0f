#include "tests/tidy/rules.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <regex>
#include <set>
#include <sstream>

namespace hoist::tidy {
namespace {

bool starts_with(std::string_view text, std::string_view prefix) { return text.substr(0, prefix.size()) == prefix; }
bool ends_with(std::string_view text, std::string_view suffix) {
  return text.size() >= suffix.size() && text.substr(text.size() - suffix.size()) == suffix;
}

bool is_cpp(std::string_view path) {
  return ends_with(path, ".cpp") || ends_with(path, ".hpp") || ends_with(path, ".h") || ends_with(path, ".cc");
}
bool is_generated(std::string_view path) { return path.find(".gen.") != std::string_view::npos; }

constexpr std::string_view kCore = "control/core/";

// Allowed includes. The first row whose prefix fits a file decides: its includes from this tree must begin with one of the allowed
// prefixes. `std_only` also refuses headers that are not the standard library's.
struct Layer {
  std::string_view prefix;
  std::vector<std::string_view> may_include;
  bool std_only;
};

const std::vector<Layer>& layers() {
  static const std::vector<Layer> table = {
      {"control/core/law/", {"control/core/law/"}, true},
      {"control/core/", {"control/core/", "control/contract/"}, true},
      {"control/contract/", {"control/contract/"}, true},
      {"control/safety/", {"control/safety/", "control/contract/"}, false},
      {"control/bus/", {"control/bus/", "control/core/", "control/contract/"}, false},
      {"control/publish/", {"control/publish/", "control/core/", "control/contract/"}, false},
      // run is the place that wires the others together. The bus master speaks CANopen with the nodes' own stack.
      {"control/run/", {"control/", "firmware/lib/"}, false},
      {"firmware/lib/", {"firmware/lib/", "control/contract/"}, true},
      {"firmware/boot/host/", {"firmware/boot/", "firmware/lib/", "control/contract/"}, true},
      {"firmware/boot/", {"firmware/boot/", "firmware/boards/", "firmware/lib/", "control/contract/"}, true},
      {"firmware/nodes/", {"firmware/nodes/", "firmware/lib/", "control/core/law/", "control/contract/"}, true},
      {"firmware/boards/",
       {"firmware/boards/", "firmware/nodes/", "firmware/lib/", "control/core/law/", "control/contract/", "control/bus/"},
       false},
      // The physics must not share code with the controller: a shared mistake would cancel itself.
      {"firmware/sim/", {"firmware/", "control/contract/", "control/bus/"}, false},
      // Inside the server includes run one way: stream -> http | ws -> a protocol (api, live) -> actions -> state -> core link, database.
      {"server/contract/",
       {"server/contract/", "control/contract/", "db/metrics/no_figure.def", "db/metrics/no_change.def", "db/metrics/metric_list.hpp",
        "db/export/formats.hpp", "db/store/change_reasons.hpp", "db/store/patient_code.hpp", "db/store/session_types.hpp",
        "server/text/field_error.hpp"},
       false},
      {"server/text/", {"server/text/"}, false},
      {"server/stream/", {"server/stream/"}, false},
      {"server/http/",
       {"server/http/", "server/stream/", "server/text/", "server/contract/", "server/counters.", "control/contract/"},
       false},
      {"server/ws/", {"server/ws/", "server/stream/", "server/counters."}, false},
      // The update of a node's program is frames in, frames out, without a bus; the tool and the server must not have two of them.
      {"server/link/",
       {"server/link/", "server/contract/", "server/counters.", "control/contract/", "control/publish/", "control/bus/firmware_update.hpp"},
       false},
      {"server/threads/", {"server/threads/"}, false},
      {"server/people/",
       {"server/people/", "server/threads/", "server/http/auth.hpp", "server/contract/", "control/contract/", "db/accounts/"},
       false},
      {"server/record/", {"server/record/", "server/threads/", "server/contract/", "control/contract/", "control/publish/", "db/"}, false},
      {"server/jobs/", {"server/jobs/", "server/record/reason.hpp", "server/contract/", "control/contract/", "db/"}, false},
      {"server/state/",
       {"server/state/", "server/jobs/", "server/link/", "server/people/", "server/record/", "server/text/", "server/contract/",
        "server/settings.hpp", "control/contract/", "db/"},
       false},
      {"server/services.hpp",
       {"server/state/", "server/jobs/", "server/link/", "server/people/", "server/record/", "server/counters.", "server/settings.hpp"},
       false},
      {"server/actions/",
       {"server/actions/", "server/state/", "server/jobs/", "server/link/", "server/record/", "server/text/", "server/contract/",
        "server/services.hpp", "control/contract/", "db/"},
       false},
      // The protocols know nothing of each other.
      {"server/api/",
       {"server/api/", "server/actions/", "server/state/", "server/jobs/", "server/http/", "server/ws/", "server/stream/", "server/link/",
        "server/people/", "server/record/", "server/text/", "server/contract/", "server/services.hpp", "control/contract/",
        "control/publish/", "db/"},
       false},
      {"server/live/",
       {"server/live/", "server/actions/", "server/state/", "server/jobs/", "server/http/", "server/ws/", "server/stream/", "server/link/",
        "server/record/", "server/text/", "server/contract/", "server/services.hpp", "control/contract/", "db/"},
       false},
      {"server/tools/",
       {"server/tools/", "server/actions/", "server/state/", "server/http/", "server/ws/", "server/stream/", "server/link/", "server/text/",
        "server/contract/", "server/services.hpp", "control/contract/", "db/export/ros/"},
       false},
      {"server/", {"server/", "control/contract/", "control/publish/", "db/"}, false},
      // The recorded frames are exported in the format that the captures have.
      {"db/", {"db/", "control/contract/", "control/bus/candump_log.hpp"}, false},
      {"deploy/tools/",
       {"deploy/tools/", "control/core/", "control/contract/", "control/safety/", "control/bus/", "control/publish/", "db/", "firmware/",
        "server/"},
       false},
      // Who judges a random session must not share the core's tables: a mistake in one would excuse itself.
      {"tests/chaos/judge/", {"tests/chaos/judge/", "tests/chaos/faults.hpp", "control/contract/", "firmware/sim/"}, false},
      {"tests/", {"tests/", "control/", "firmware/", "server/", "db/", "deploy/tools/"}, false},
  };
  return table;
}

// THE order of the rooms of the core: a file includes its own room and the rooms before it, never a later one. Up to `state.` the rooms are
// parts that do not know the state; from there on they act on it. A name with a dot is a file of the core's own folder.
const std::vector<std::string_view>& core_rooms() {
  static const std::vector<std::string_view> table = {
      "law/",   "types.",  "base/",       "estimate/", "health/",    "intent/", "output/",  "monitor/",       "command/", "calibrate/",
      "state.", "events.", "standstill.", "modes/",    "supervise/", "serve/",  "receive.", "stop_distance.", "record.",  "tick."};
  return table;
}

// The place of a file of the core in that order; the number of rooms when it is in none.
std::size_t core_room_of(std::string_view path) {
  const std::string_view name = path.substr(kCore.size());
  const auto room = std::find_if(core_rooms().begin(), core_rooms().end(), [&](std::string_view row) { return starts_with(name, row); });
  return static_cast<std::size_t>(room - core_rooms().begin());
}

const std::set<std::string_view>& standard_headers() {
  static const std::set<std::string_view> table = {
      "algorithm", "array",     "atomic",    "bit",        "bitset",           "cassert",  "cctype",      "cerrno",  "cfloat",
      "charconv",  "cinttypes", "climits",   "cmath",      "compare",          "complex",  "concepts",    "cstddef", "cstdint",
      "cstdlib",   "cstring",   "exception", "functional", "initializer_list", "iterator", "limits",      "new",     "numbers",
      "numeric",   "optional",  "ratio",     "span",       "string_view",      "tuple",    "type_traits", "utility", "variant",
      "version",   "stdint.h",  "stddef.h",  "string.h",   "source_location"};
  return table;
}

// Words that the pure parts (control/core and the firmware that runs on the Cortex-M0) may not use, with the reason.
struct Forbidden {
  std::string_view pattern;
  std::string_view why;
};
const std::vector<Forbidden>& forbidden_in_pure_code() {
  static const std::vector<Forbidden> table = {
      {R"(\bnew\b)", "heap"},
      {R"((^|[^=\s])\s*\bdelete\b)", "heap"},
      {R"(\b(malloc|calloc|realloc|free)\s*\()", "heap"},
      {R"(\bstd::(vector|string|wstring|map|set|unordered_map|unordered_set|deque|list|function|any|unique_ptr|shared_ptr|make_unique|make_shared)\b)",
       "heap"},
      {R"(\b(chrono|clock_gettime|gettimeofday)\b)", "a clock"},
      {R"(\bstd::time\b)", "a clock"},
      {R"(\b(throw|try|catch)\b)", "exceptions"},
      {R"(\b(iostream|std::cout|std::cerr|printf|fprintf|fopen|puts)\b)", "input or output"},
      {R"(\b(thread|mutex|condition_variable)\b)", "threads"},
      {R"(\b(rand|srand|random_device|getenv)\b)", "what no replay can repeat"},
  };
  return table;
}

bool is_pure(std::string_view path) {
  return starts_with(path, "control/core/") || starts_with(path, "firmware/nodes/") || starts_with(path, "firmware/lib/") ||
         starts_with(path, "firmware/boot/");
}

// Hazard H26: the wall clock may jump, so only these look at it, and only for dates that people read. Everything that decides, ends or
// expires goes by the steady clock.
const std::map<std::string_view, std::string_view>& may_read_the_wall_clock() {
  static const std::map<std::string_view, std::string_view> table = {
      {"control/run/main.cpp", "the anchor of a core's life, and the dates of a capture, once at the start"},
      {"server/http/listener.cpp", "the Date header"},
      {"server/app.cpp", "dates of sessions and events"},
      {"server/settings.cpp", "--set-clock: an engineer sets it"},
      {"server/actions/records.cpp", "who keeps it, by the name of the reason"},
  };
  return table;
}

// Tests wait for events or use virtual time. Exceptions, each with the reason.
const std::map<std::string_view, std::string_view>& may_sleep() {
  static const std::map<std::string_view, std::string_view> table = {
      {"tests/support/slow_disk.hpp", "a disk that takes its time: what waits for it must really wait"},
      {"tests/unit/server/fixture.hpp", "a job has nice 19: a test that asks without a pause takes its processor"},
  };
  return table;
}

struct Line {
  int number;
  std::string text;
};
std::vector<Line> lines_of(std::string_view text) {
  std::vector<Line> lines;
  int number = 0;
  std::istringstream stream{std::string(text)};
  for (std::string line; std::getline(stream, line);) lines.push_back({++number, line});
  return lines;
}

bool known(const std::vector<std::string>& paths, const std::string& path) { return std::binary_search(paths.begin(), paths.end(), path); }

void check_includes(const File& file, const std::vector<std::string>& all_paths, std::vector<Finding>& findings) {
  static const std::regex include_line(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  static const std::regex from_top(R"(^(control|firmware|server|db|deploy|tests)/)");
  const auto layer = std::find_if(layers().begin(), layers().end(), [&](const Layer& row) { return starts_with(file.path, row.prefix); });
  const bool in_core = starts_with(file.path, kCore);
  if (in_core && core_room_of(file.path) == core_rooms().size())
    findings.push_back({file.path, 0, "room", "is in no room of the core (core_rooms)"});
  for (const auto& [number, text] : lines_of(without_comments(file.text, true))) {
    std::smatch match;
    if (!std::regex_search(text, match, include_line)) continue;
    const std::string target = match[2];
    if (match[1] == "<") {
      // Fixed-size matrices: only arithmetic, no heap, no clock.
      const bool matrices = target == "Eigen/Core" && starts_with(file.path, "control/core/estimate/");
      if (layer != layers().end() && layer->std_only && !matrices && standard_headers().count(target) == 0) {
        findings.push_back({file.path, number, "layer",
                            "<" + target + "> is not among the standard headers that " + std::string(layer->prefix) + " may use"});
      }
      continue;
    }
    if (!std::regex_search(target, from_top)) {
      findings.push_back({file.path, number, "include-from-top", "\"" + target + "\" is not written from the top of the tree"});
      continue;
    }
    if (!known(all_paths, target))
      findings.push_back({file.path, number, "include-exists", "\"" + target + "\" is not a file of this tree"});
    if (starts_with(target, "control/run/") && !starts_with(file.path, "control/run/") && !starts_with(file.path, "tests/")) {
      findings.push_back({file.path, number, "layer", "nothing includes control/run/"});
      continue;
    }
    if (layer == layers().end()) continue;
    const bool allowed = std::any_of(layer->may_include.begin(), layer->may_include.end(),
                                     [&](std::string_view prefix) { return starts_with(target, prefix); });
    if (!allowed) {
      findings.push_back({file.path, number, "layer", std::string(layer->prefix) + " may not include \"" + target + "\""});
    } else if (in_core && starts_with(target, kCore) && core_room_of(file.path) < core_room_of(target)) {
      findings.push_back({file.path, number, "room", "\"" + target + "\" is in a later room of the core (core_rooms)"});
    }
  }
}

void check_pure_words(const File& file, std::vector<Finding>& findings) {
  static const auto rules = [] {
    std::vector<std::pair<std::regex, std::string_view>> compiled;
    for (const auto& row : forbidden_in_pure_code()) compiled.emplace_back(std::regex(std::string(row.pattern)), row.why);
    return compiled;
  }();
  for (const auto& [number, text] : lines_of(without_comments(file.text, false))) {
    if (text.find("#include <new>") != std::string::npos) continue;
    std::smatch match;
    for (const auto& [pattern, why] : rules) {
      if (std::regex_search(text, match, pattern)) {
        findings.push_back({file.path, number, "pure", "'" + match.str() + "' brings in " + std::string(why)});
      }
    }
  }
}

// In the core and the nodes a function fits on a screen: who judges its safety sees it whole.
constexpr int kLongestFunction_lines = 60;
bool has_short_functions(std::string_view path) {
  return starts_with(path, "control/core/") || starts_with(path, "control/run/") || starts_with(path, "firmware/nodes/") ||
         starts_with(path, "firmware/lib/");
}

// A body is a brace behind `(...)`, unless a word of the language stands before the parenthesis. Only the outermost counts.
void check_function_lengths(const File& file, std::vector<Finding>& findings) {
  static const std::regex opens_function(R"(\)\s*(const)?\s*(noexcept)?\s*(override|final)?\s*(->\s*[\w:<>]+\s*)?$)");
  static const std::regex opens_block(R"(^\s*(\}|if|for|while|switch|else)\b)");
  std::vector<int> begun;  // line of each open brace that begins a function, 0 for any other
  for (const auto& [number, text] : lines_of(without_comments(file.text, false))) {
    for (std::size_t at = 0; at < text.size(); ++at) {
      if (text[at] == '{') {
        const std::string head = text.substr(0, at);
        const bool inside = std::any_of(begun.begin(), begun.end(), [](int line) { return line != 0; });
        begun.push_back(!inside && std::regex_search(head, opens_function) && !std::regex_search(head, opens_block) ? number : 0);
      } else if (text[at] == '}' && !begun.empty()) {
        const int lines = begun.back() == 0 ? 0 : number - begun.back() + 1;
        if (lines > kLongestFunction_lines)
          findings.push_back({file.path, begun.back(), "long-function",
                              std::to_string(lines) + " lines; at most " + std::to_string(kLongestFunction_lines)});
        begun.pop_back();
      }
    }
  }
}

void check_wall_clock(const File& file, std::vector<Finding>& findings) {
  static const std::regex wall_clock(
      R"(\b(CLOCK_REALTIME\w*|gettimeofday|(system|file|utc|tai|gps)_clock|std::time|timespec_get)\b|::time\s*\(|)"
      R"(\btime\s*\(\s*(nullptr|NULL|0|&\w+)\s*\))");
  // What SQLite asks the clock for; in a program it stands in a string.
  static const std::regex of_sql(R"('now'|\bCURRENT_(DATE|TIME|TIMESTAMP)\b|\b(unixepoch|julianday)\s*\(\s*\))", std::regex::icase);
  if (may_read_the_wall_clock().count(file.path) != 0) return;
  const auto look = [&](const std::string& code, const std::regex& clock) {
    for (const auto& [number, text] : lines_of(code)) {
      std::smatch match;
      if (std::regex_search(text, match, clock))
        findings.push_back({file.path, number, "wall-clock", "'" + match.str() + "': it may jump; the steady clock does not"});
    }
  };
  look(without_comments(file.text, false), wall_clock);
  look(without_comments(file.text, true), of_sql);
}

// Sentences that no file may hold. The patterns are put together from halves so that this file does not hold them either.
void check_words(const File& file, std::vector<Finding>& findings) {
  static const std::regex unfinished(std::string("\\b(TO") + "DO|FIX" + "ME|XX" + "X)\\b");
  static const std::regex machine_path(std::string("(^|[^a-zA-Z0-9_.$}-])/(wo") + "rk|fa" + "rm|ro" + "ot|home/[a-z]+)/");
  static const std::regex registry(std::string("registry\\.np") + "mjs|(deb|security)\\.deb" + "ian\\.org");
  const bool lock_file = ends_with(file.path, "package-lock.json");
  for (const auto& [number, text] : lines_of(file.text)) {
    std::smatch match;
    if (!lock_file && std::regex_search(text, match, unfinished)) findings.push_back({file.path, number, "unfinished", match.str()});
    if (!lock_file && std::regex_search(text, match, machine_path)) findings.push_back({file.path, number, "machine-path", match.str()});
    if (std::regex_search(text, match, registry)) findings.push_back({file.path, number, "registry-host", match.str()});
    if (text.size() > 4000) continue;
    // Conflict marks never belong in a commit.
    if (text.rfind(std::string(7, '<') + " ", 0) == 0 || text.rfind(std::string(7, '>') + " ", 0) == 0) {
      findings.push_back({file.path, number, "conflict", "an unresolved merge"});
    }
  }
}

void check_test_habits(const File& file, std::vector<Finding>& findings) {
  static const std::regex sleeping(R"(\b(sleep_for|sleep_until|usleep|nanosleep)\b)");
  static const std::regex empty_skip(R"(GTEST_SKIP\s*\(\s*\)\s*;)");
  static const std::regex empty_assertion(R"((EXPECT|ASSERT)_(TRUE\s*\(\s*true|FALSE\s*\(\s*false|EQ\s*\(\s*(\d+)\s*,\s*\3)\s*\))");
  for (const auto& [number, text] : lines_of(without_comments(file.text, false))) {
    if (std::regex_search(text, sleeping) && may_sleep().count(file.path) == 0)
      findings.push_back({file.path, number, "sleep", "tests wait for events or use virtual time"});
    if (std::regex_search(text, empty_skip)) findings.push_back({file.path, number, "skip-reason", "a skip says why"});
    if (std::regex_search(text, empty_assertion)) findings.push_back({file.path, number, "empty-assertion", "this assertion cannot fail"});
  }
}

void check_web_imports(const File& file, std::vector<Finding>& findings) {
  static const std::regex import_line(R"((from|import)\s*\(?\s*['"](\.\.?/[^'"]*)['"])");
  for (const auto& [number, text] : lines_of(file.text)) {
    std::smatch match;
    if (!std::regex_search(text, match, import_line)) continue;
    // A file may use as many "../" as its depth under web/.
    const auto depth = std::count(file.path.begin(), file.path.end(), '/') - 1;
    const std::string target = match[2];
    std::ptrdiff_t climbs = 0;
    for (std::size_t at = 0; target.compare(at, 3, "../") == 0; at += 3) ++climbs;
    if (climbs > depth) findings.push_back({file.path, number, "layer", "web/ imports only from web/: " + target});
  }
}

}  // namespace

std::string without_comments(std::string_view text, bool keep_strings) {
  std::string out(text);
  const auto blank = [&](std::size_t from, std::size_t to) {
    for (std::size_t at = from; at < to && at < out.size(); ++at) {
      if (out[at] != '\n') out[at] = ' ';
    }
  };
  for (std::size_t at = 0; at < text.size();) {
    if (text.compare(at, 2, "//") == 0) {
      const auto end = std::min(text.find('\n', at), text.size());
      blank(at, end);
      at = end;
    } else if (text.compare(at, 2, "/*") == 0) {
      const auto end = text.find("*/", at + 2);
      const auto stop = end == std::string_view::npos ? text.size() : end + 2;
      blank(at, stop);
      at = stop;
    } else if (text.compare(at, 2, "R\"") == 0) {
      const auto open = text.find('(', at);
      if (open == std::string_view::npos) break;
      const std::string close = ")" + std::string(text.substr(at + 2, open - at - 2)) + "\"";
      const auto end = text.find(close, open);
      const auto stop = end == std::string_view::npos ? text.size() : end + close.size();
      if (!keep_strings) blank(at, stop);
      at = stop;
    } else if (text[at] == '"' || (text[at] == '\'' && (at == 0 || std::isalnum(static_cast<unsigned char>(text[at - 1])) == 0))) {
      const char quote = text[at];
      std::size_t end = at + 1;
      while (end < text.size() && text[end] != quote && text[end] != '\n') end += text[end] == '\\' ? 2 : 1;
      if (!keep_strings) blank(at + 1, end);
      at = end + 1;
    } else {
      ++at;
    }
  }
  return out;
}

std::vector<Finding> check_file(const File& file, const std::vector<std::string>& all_paths) {
  std::vector<Finding> findings;
  if (file.path != "LICENSE") check_words(file, findings);
  if (is_generated(file.path)) {
    // JSON has no comments; there the sentence is a field that may stand anywhere.
    const std::string head = ends_with(file.path, ".json") ? file.text : file.text.substr(0, 400);
    if (head.find("deploy/dev ") == std::string::npos)
      findings.push_back({file.path, 1, "generated", "does not name the command that makes it"});
  }
  if (is_cpp(file.path)) {
    check_includes(file, all_paths, findings);
    if (!ends_with(file.path, ".cpp") && file.text.find("#pragma once") == std::string::npos)
      findings.push_back({file.path, 1, "pragma-once", "a header without #pragma once"});
    if (is_pure(file.path)) check_pure_words(file, findings);
    if (has_short_functions(file.path)) check_function_lengths(file, findings);
    if (starts_with(file.path, "tests/") && !starts_with(file.path, "tests/tidy/")) check_test_habits(file, findings);
  }
  const bool runs = starts_with(file.path, "control/") || starts_with(file.path, "server/") || starts_with(file.path, "db/") ||
                    starts_with(file.path, "firmware/");
  if (runs && (is_cpp(file.path) || ends_with(file.path, ".sql"))) check_wall_clock(file, findings);
  if (starts_with(file.path, "web/src/") && (ends_with(file.path, ".ts") || ends_with(file.path, ".tsx")))
    check_web_imports(file, findings);
  return findings;
}

std::vector<Finding> check_tree(const std::vector<File>& files) {
  static const std::regex top_level(R"(^(CMakeLists\.txt|README\.md|LICENSE|server|control|firmware|web|db|tests|deploy|\..*)$)");
  constexpr std::size_t kLargestFileBytes = 2U << 20U;
  std::vector<Finding> findings = check_circles(files);
  std::set<std::string> tops;
  std::map<std::string, const File*> by_path;
  for (const auto& file : files) {
    tops.insert(file.path.substr(0, file.path.find('/')));
    by_path[file.path] = &file;
    if (file.text.size() > kLargestFileBytes) findings.push_back({file.path, 0, "size", "larger than 2 MiB"});
  }
  for (const auto& top : tops) {
    if (!std::regex_match(top, top_level)) findings.push_back({top, 0, "top-level", "the top level holds fixed folders only"});
  }
  for (const std::string area : {"control", "db", "deploy", "firmware", "server", "tests", "web"}) {
    if (tops.count(area) != 0 && by_path.count(area + "/README.md") == 0)
      findings.push_back({area, 0, "readme", "the area has no README.md"});
  }
  for (const std::string path : {"README.md", "LICENSE"}) {
    if (by_path.count(path) == 0) findings.push_back({path, 0, "top-level", "is missing"});
  }
  for (const std::string path : {"deploy/dev", ".ci/run"}) {
    const auto found = by_path.find(path);
    if (found == by_path.end() || !found->second->runnable) findings.push_back({path, 0, "run-bit", "is missing or cannot be run"});
  }
  // A source in no CMakeLists above it is dead code.
  for (const auto& file : files) {
    if (!ends_with(file.path, ".cpp")) continue;
    const std::string name = file.path.substr(file.path.rfind('/') + 1);
    bool named = false;
    for (std::size_t slash = file.path.rfind('/'); slash != std::string::npos && !named;
         slash = slash == 0 ? std::string::npos : file.path.rfind('/', slash - 1)) {
      const auto list = by_path.find(file.path.substr(0, slash) + "/CMakeLists.txt");
      if (list == by_path.end()) continue;
      const auto& text = list->second->text;
      named = text.find(name) != std::string::npos || text.find("GLOB") != std::string::npos;
    }
    if (!named) findings.push_back({file.path, 0, "dead-source", "no CMakeLists.txt above it names it"});
  }
  return findings;
}

}  // namespace hoist::tidy
