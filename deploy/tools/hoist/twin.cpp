// hoist twin: a simulated patient fitted to a recorded session, and other parameters tried on it.
#include <charconv>
#include <cstdio>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "db/store/session_reader.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/parameter_change.hpp"
#include "deploy/tools/hoist/recording_file.hpp"
#include "deploy/tools/hoist/twin/led_session.hpp"
#include "deploy/tools/hoist/twin/twin_file.hpp"
#include "deploy/tools/hoist/twin/what_if.hpp"

namespace hoist::tool {

namespace {

using twin::FittedValue;
using twin::Twin;

constexpr const char* kHelp =
    "usage: hoist twin DB SESSION [--seed S] [--out TWIN]\n"
    "       hoist twin TWIN --set NAME=VALUE [--set …] [--walks N] [--seed S]\n"
    "       hoist twin --schema\n\n"
    "The first form fits the simulated patient to a session in which the patient led along an exercise: delay, stiffness, cadence, "
    "asymmetry and\n"
    "turning lead, each with its spread and with the value it is told from least. The patient is put into a hoist that moves as recorded, "
    "and its\n"
    "lean and turn are brought to the recorded ones (least squares; starts drawn from the seed). Then the twin walks the exercise, and its "
    "C and\n"
    "speed are held against the recorded ones. --out writes the twin as JSON.\n"
    "The second tries other parameters (SI units) on a twin: shipped core, nodes, simulated machine; the same N patients and seeds before "
    "and\n"
    "after, the patients drawn from the fit's spread. It changes nothing on any hoist. Exit code 3: the twin does not walk as its session "
    "did, or\n"
    "walks did not come to their end.\n";

constexpr const char* kCannotTell =
    "What a twin cannot tell: pain, fear, tiredness, learning, and how a person changes the way of walking with other settings; falls, "
    "slips and\n"
    "anything that the session did not hold; the real machine's friction and the real floor. A therapist decides, and stays beside the "
    "patient.\n";

struct Request {
  std::vector<std::string_view> places;
  std::vector<ParameterChange> changes;
  std::string out;
  std::uint64_t seed = 1;
  int walks = 10;
};

template <class Number>
bool read_whole(std::string_view text, Number& out, Number least, Number most) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size() && out >= least && out <= most;
}

// The sentence that says what is wrong, or nothing.
std::string read_request(std::span<const std::string_view> arguments, Request& out) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view name = arguments[i];
    if (!name.starts_with("--")) {
      out.places.push_back(name);
      continue;
    }
    if (name != "--set" && name != "--out" && name != "--seed" && name != "--walks") return "there is no option " + std::string(name);
    if (++i == arguments.size()) return std::string(name) + " needs a value";
    const std::string_view value = arguments[i];
    if (name == "--out") {
      out.out = value;
    } else if (name == "--seed") {
      if (!read_whole<std::uint64_t>(value, out.seed, 0, 1'000'000'000)) return "--seed: 0 to 1000000000";
    } else if (name == "--walks") {
      if (!read_whole(value, out.walks, 1, 200)) return "--walks: 1 to 200";
    } else if (std::string problem = parse_change(value, out.changes); !problem.empty()) {
      return problem;
    }
  }
  return {};
}

std::string text_of(std::string_view text) { return std::string(text); }

void print_value(const FittedValue& value) {
  std::string told = value.told() ? "told" : "not told by this session: stays as usual";
  if (value.told() && !value.told_apart()) {
    char sentence[100];
    std::snprintf(sentence, sizeof sentence, "told, but not apart from %s (correlation %.2f)", text_of(value.alike).c_str(),
                  value.alike_norm);
    told = sentence;
  }
  std::printf("%-20s %9.3f ± %-8.3f %-6s %9.3f ± %-8.3f  %s\n", text_of(value.name).c_str(), value.value, value.spread,
              text_of(value.unit).c_str(), value.usual, value.usual_spread, told.c_str());
}

void print_fit(const Twin& twin) {
  std::printf("Session %lld, %s, led for %.0f s; seed %llu\n\n", static_cast<long long>(twin.session), text_of(twin.scenario->name).c_str(),
              twin.led_s, static_cast<unsigned long long>(twin.seed));
  std::printf("%-20s %9s   %-8s %-6s %9s   %-8s\n", "value", "fitted", "spread", "unit", "usual", "spread");
  for (const FittedValue& value : twin.fit.derived) print_value(value);
  std::printf("\nof these and beside them, found together:\n");
  for (const FittedValue& value : twin.fit.values) print_value(value);
  std::printf("\nNot explained, of averages over a stride: lean %.1f mm, turn %.2f deg. %d of %d starts ended at the same fit.\n",
              1000 * twin.fit.rms_lean_m, twin.fit.rms_turn_rad * 180 / 3.14159265358979, twin.fit.starts_agreed, twin.fit.starts);
  std::printf("The twin's own walk: C %.3f (recorded %.3f), speed %.3f m/s root mean square (recorded %.3f): %s\n", twin.check.c_twin,
              twin.check.c_recorded, twin.check.speed_rms_twin_m_s, twin.check.speed_rms_recorded_m_s,
              twin.check.holds() ? "it walks as the session did." : "it does NOT walk as the session did: use it for nothing.");
}

int fit(const Request& request) {
  const auto session = parse_session(request.places[1]);
  if (!session) return bad_usage("twin", "name a database and a session's number");
  db::Result<db::Database> database = db::Database::attach(std::string(request.places[0]));
  if (!database) return refuse("twin", database.error());
  const db::Result<twin::LedSession> led = twin::read_led_session(*database, *session);
  if (!led) return refuse("twin", led.error());
  const db::Result<db::SessionInfo> info = db::SessionReader(*database).get(*session);
  if (!info) return refuse("twin", info.error());
  Twin made = twin::make_twin(*led, request.seed);
  made.session = *session;
  made.started_utc_ns = info->started_utc_ns;
  print_fit(made);
  if (!request.out.empty()) {
    std::ofstream file(request.out);
    file << twin::twin_text(made);
    if (!file.flush()) return refuse("twin", {db::ErrorKind::io, "cannot write " + request.out, {}});
  }
  return made.check.holds() ? kDone : kPartly;
}

int unfinished(const char* when, std::span<const twin::WalkOutcome> walks) {
  int count = 0;
  std::string why;
  for (const twin::WalkOutcome& walk : walks) {
    if (walk.unfinished.empty()) continue;
    ++count;
    why = walk.unfinished;
  }
  if (count > 0) std::printf("%s: %d of %zu walks did not come to their end (%s)\n", when, count, walks.size(), why.c_str());
  return count;
}

void print_what_if(const Twin& twin, const contract::Params& after, const Request& request, const twin::WhatIf& tried) {
  std::printf("Twin of session %lld, %d walks of %s, seed %llu\n", static_cast<long long>(twin.session), request.walks,
              text_of(twin.scenario->name).c_str(), static_cast<unsigned long long>(request.seed));
  for (const auto& [index, value] : request.changes) {
    const contract::ParamInfo& info = contract::kParams[index];
    std::printf("  %s: %g -> %g %s\n", text_of(info.name).c_str(), contract::get_param(twin.params, index),
                contract::get_param(after, index), text_of(info.unit).c_str());
  }
  std::printf("\n%-20s %9s   %-8s %9s   %-8s %9s   %-8s\n", "", "before", "spread", "after", "spread", "change", "spread");
  for (std::size_t i = 0; i < twin::kTold.size(); ++i) {
    const twin::Spread before = spread_of(tried.before, i), later = spread_of(tried.after, i),
                       change = change_of(tried.before, tried.after, i);
    if (before.walks == 0 || later.walks == 0) continue;
    std::printf("%-20s %9.3f ± %-8.3f %9.3f ± %-8.3f %+9.3f ± %-8.3f %-4s %s: %s\n", text_of(twin::kTold[i].name).c_str(), before.mean,
                before.spread, later.mean, later.spread, change.mean, change.spread, text_of(twin::kTold[i].unit).c_str(),
                twin::clear(change) ? "changes" : "no clear change", text_of(twin::kTold[i].doc).c_str());
  }
}

int try_out(const Request& request) {
  std::ifstream file{std::string(request.places[0])};
  std::stringstream text;
  text << file.rdbuf();
  if (!file) return refuse("twin", {db::ErrorKind::io, "cannot read " + std::string(request.places[0]), {}});
  std::string problem;
  const std::optional<Twin> twin = twin::read_twin(text.str(), problem);
  if (!twin) return refuse("twin", {db::ErrorKind::bad_value, std::string(request.places[0]) + ": " + problem, {}});
  contract::Params after = twin->params;
  for (const auto& [index, value] : request.changes) contract::set_param_unchecked(after, index, value);
  if (const char* sentence = contract::check_param_set(after); sentence != nullptr) return bad_usage("twin", sentence);
  const twin::WhatIf tried = twin::what_if(twin->fit, *twin->scenario, twin->params, after, request.walks, request.seed);
  print_what_if(*twin, after, request, tried);
  const int missing = unfinished("before", tried.before) + unfinished("after", tried.after);
  if (!twin->check.holds()) std::printf("\nThis twin does NOT walk as its session did: these figures say nothing of the patient.\n");
  std::printf("\n%s", kCannotTell);
  return twin->check.holds() && missing == 0 ? kDone : kPartly;
}

}  // namespace

int run_twin(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(kHelp, stdout);
    return kDone;
  }
  if (arguments.size() == 1 && arguments[0] == "--schema") {
    std::fputs(twin::twin_schema().c_str(), stdout);
    return kDone;
  }
  Request request;
  if (const std::string wrong = read_request(arguments, request); !wrong.empty()) return bad_usage("twin", wrong);
  if (request.places.size() == 2 && request.changes.empty()) return fit(request);
  if (request.places.size() == 1 && !request.changes.empty() && request.out.empty()) return try_out(request);
  return bad_usage("twin", "name a database and a session, or a twin and what to --set");
}

}  // namespace hoist::tool
