// hoist laws: the equations on the command line, to check them against other programs.
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/laws/law_list.hpp"

namespace hoist::tool {

using nlohmann::json;

namespace {

/// An hour of a run at 100 Hz with all columns is about 40 MB of text; a line beyond this is not read into JSON.
constexpr std::size_t kLineLimit = 64U << 20U;

void print_laws_help(std::FILE* out) {
  std::fputs(
      "usage: hoist laws --list              name each law with a line\n"
      "       hoist laws NAME --help         what goes in and comes out\n"
      "       hoist laws NAME [--json PARAMS]\n\n"
      "Reads one JSON object per line from standard input and writes one per line, in order. A line may carry its own\n"
      "\"params\"; PARAMS is an object of parameters for all lines. A line that is no valid input gives {\"error\": \"...\"},\n"
      "and the exit code is 1 at the end. null is NaN or not given, infinities are \"inf\" and \"-inf\".\n",
      out);
}

void print_list() {
  for (const auto group : {motion_laws(), tilt_laws(), metric_laws()}) {
    for (const auto& law : group) std::printf("%-13s %s\n", std::string(law.name).c_str(), std::string(law.summary).c_str());
  }
}

void print_law(const Law& law) {
  std::printf("%s: %s\n  in:     %s\n  params: %s\n  out:    %s\n", std::string(law.name).c_str(), std::string(law.summary).c_str(),
              std::string(law.inputs).c_str(), law.parameters.empty() ? "none" : std::string(law.parameters).c_str(),
              std::string(law.outputs).c_str());
}

json answer(const Law& law, const std::string& line, const json& params, bool& refused) {
  try {
    if (line.size() > kLineLimit) throw Refusal("the line: longer than " + std::to_string(kLineLimit) + " bytes");
    return compute_law(law, json::parse(line), params);
  } catch (const json::exception& error) {
    refused = true;
    return {{"error", std::string("the line: not valid JSON: ") + error.what()}};
  } catch (const Refusal& refusal) {
    refused = true;
    return {{"error", refusal.what()}};
  }
}

int run_law(const Law& law, const json& params) {
  std::ios::sync_with_stdio(false);
  bool refused = false;
  std::string line;
  while (std::getline(std::cin, line)) {
    // Invalid UTF-8 in an error message is replaced, so that the answer stays JSON.
    std::cout << answer(law, line, params, refused).dump(-1, ' ', false, json::error_handler_t::replace) << std::endl;
    if (!std::cout) return kRefused;
  }
  return refused ? kRefused : kDone;
}

}  // namespace

int run_laws(std::span<const std::string_view> arguments) {
  if (arguments.empty()) {
    print_laws_help(stderr);
    return kBadUsage;
  }
  if (arguments.front() == "--help" || arguments.front() == "-h") {
    print_laws_help(stdout);
    return kDone;
  }
  if (arguments.front() == "--list" && arguments.size() == 1) {
    print_list();
    return kDone;
  }
  const Law* law = find_law(arguments.front());
  if (law == nullptr) {
    std::fprintf(stderr, "hoist laws: there is no law \"%s\"; hoist laws --list names them\n", std::string(arguments.front()).c_str());
    return kBadUsage;
  }
  json params = json::object();
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    if (arguments[i] == "--help" || arguments[i] == "-h") {
      print_law(*law);
      return kDone;
    }
    if (arguments[i] != "--json" || i + 1 == arguments.size()) {
      std::fprintf(stderr, "hoist laws: \"%s\" is not understood here\n", std::string(arguments[i]).c_str());
      print_laws_help(stderr);
      return kBadUsage;
    }
    params = json::parse(arguments[++i], nullptr, false);
    if (!params.is_object()) {
      std::fputs("hoist laws: --json takes an object, for example '{\"D\": 0.1}'\n", stderr);
      return kBadUsage;
    }
  }
  return run_law(*law, params);
}

}  // namespace hoist::tool
