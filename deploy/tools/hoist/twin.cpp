// hoist twin: a simulated patient fitted to a recorded session, and other parameters tried on it.
#include <charconv>
#include <cstdio>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/parameter_change.hpp"
#include "deploy/tools/hoist/recording_file.hpp"
#include "deploy/tools/hoist/twin/led_session.hpp"
#include "deploy/tools/hoist/twin/what_if.hpp"

namespace hoist::tool {

namespace {

using twin::Check;
using twin::Fit;
using twin::FittedValue;
using twin::LedSession;

constexpr const char* kTwinHelp =
    "usage: hoist twin DB SESSION [--set NAME=VALUE …] [--against SESSION …] [--walks K] [--seed S]\n\n"
    "Fits the simulated patient to a session in which the patient led along an exercise: delay, stiffness, cadence, asymmetry and turning\n"
    "lead, each with its spread and with the value it is told from least. The patient is put into a hoist that moves as recorded, and its\n"
    "lean and turn are brought to the recorded ones (least squares; starts drawn from the seed). Then the twin walks the exercise, and "
    "its\n"
    "C and speed are held against the recorded ones; --against: also against those of other sessions of this patient.\n"
    "--set: other parameters (SI units) tried on the twin: shipped core, nodes and simulated machine, K walks (10 if not given) with the\n"
    "same patients and seeds before and after, the patients drawn from the fit's spread; only with a twin that walks as its sessions did.\n"
    "Nothing is changed on any hoist.\n"
    "Exit code 1: this session cannot bear a fit, and why. 3: the twin does not walk as a session did (C within 0.05, speed within 10 %),\n"
    "or walks did not come to their end.\n";

constexpr const char* kCannotTell =
    "What a twin cannot tell: pain, fear, tiredness, learning, and how a person changes the way of walking with other settings; falls,\n"
    "slips and anything that the session did not hold; the real machine's friction and the real floor. A therapist decides, and stays\n"
    "beside the patient.\n";

struct Request {
  std::string_view database;
  db::SessionId session = 0;
  std::vector<db::SessionId> against;
  std::vector<ParameterChange> changes;
  std::uint64_t seed = 1;
  int walks = 10;
};

template <class Number>
bool read_whole(std::string_view text, Number& out, Number least, Number most) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size() && out >= least && out <= most;
}

// The sentence that says what is wrong, or nothing.
std::string read_option(std::string_view name, std::string_view value, Request& out) {
  if (name == "--against") {
    const auto session = parse_session(value);
    if (!session) return "--against needs a session's number";
    out.against.push_back(*session);
    return {};
  }
  if (name == "--seed") return read_whole<std::uint64_t>(value, out.seed, 0, 1'000'000'000) ? "" : "--seed: 0 to 1000000000";
  if (name == "--walks") return read_whole(value, out.walks, 1, 200) ? "" : "--walks: 1 to 200";
  if (name == "--set") return parse_change(value, out.changes);
  return "there is no option " + std::string(name);
}

std::string read_request(std::span<const std::string_view> arguments, Request& out) {
  const auto session = arguments.size() < 2 ? std::nullopt : parse_session(arguments[1]);
  if (!session) return "name a database and a session's number";
  out.database = arguments[0];
  out.session = *session;
  for (std::size_t i = 2; i < arguments.size(); i += 2) {
    if (i + 1 == arguments.size()) return std::string(arguments[i]) + " needs a value";
    if (std::string wrong = read_option(arguments[i], arguments[i + 1], out); !wrong.empty()) return wrong;
  }
  return {};
}

std::string text_of(std::string_view text) { return std::string(text); }

// No number for what the session does not tell: it would be the usual one, shown as if measured.
void print_value(const FittedValue& value) {
  const std::string name = text_of(value.name), unit = text_of(value.unit);
  if (!value.told()) {
    std::printf("%-20s %9s   %-8s %-6s not told by this session (usual: %.3f ± %.3f)\n", name.c_str(), "-", "", unit.c_str(), value.usual,
                value.usual_spread);
    return;
  }
  std::printf("%-20s %9.3f ± %-8.3f %-6s", name.c_str(), value.value, value.spread, unit.c_str());
  if (!value.told_apart()) std::printf(" hardly told apart from %s (correlation %.2f)", text_of(value.alike).c_str(), value.alike_norm);
  std::printf("\n");
}

void print_fit(const Request& request, const LedSession& session, const Fit& fit) {
  std::printf("A simulation: figures of a simulated patient fitted to session %lld, not measurements of the patient.\n",
              static_cast<long long>(request.session));
  if (session.simulated)
    std::printf("Session %lld was recorded on a SIMULATED hoist: no person walked in it.\n", static_cast<long long>(request.session));
  std::printf("Session %lld, %s, led for %.0f s; seed %llu\n\n", static_cast<long long>(request.session),
              text_of(session.scenario->name).c_str(), session.led_s(), static_cast<unsigned long long>(request.seed));
  std::printf("%-20s %9s   %-8s %-6s\n", "value", "fitted", "spread", "unit");
  for (const FittedValue& value : fit.derived) print_value(value);
  std::printf("\nof these and beside them, found together:\n");
  for (const FittedValue& value : fit.values) print_value(value);
  std::printf("\nNot explained, of averages over a stride: lean %.1f mm, turn %.2f deg.\n", 1000 * fit.rms_lean_m,
              fit.rms_turn_rad * 180 / std::numbers::pi);
}

bool print_check(db::SessionId session, const char* how, const Check& check) {
  std::printf(
      "Session %lld (%s): C %.3f recorded, %.3f ± %.3f of the twin; speed %.3f m/s root mean square recorded, %.3f ± %.3f of the twin "
      "(%d walks): ",
      static_cast<long long>(session), how, check.c_recorded, check.c_twin.mean, check.c_twin.spread, check.speed_rms_recorded_m_s,
      check.speed_rms_twin_m_s.mean, check.speed_rms_twin_m_s.spread, check.c_twin.walks);
  if (check.holds())
    std::printf("it walks as the session did.\n");
  else
    std::printf("it does NOT walk as the session did%s: use it for nothing.\n",
                check.unfinished.empty() ? "" : (" (" + check.unfinished + ")").c_str());
  return check.holds();
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

void print_what_if(const Request& request, const contract::Params& before_set, const contract::Params& after_set,
                   const twin::WhatIf& tried) {
  std::printf("\n%d walks before and after\n", request.walks);
  for (const auto& [index, value] : request.changes) {
    const contract::ParamInfo& info = contract::kParams[index];
    std::printf("  %s: %g -> %g %s\n", text_of(info.name).c_str(), contract::get_param(before_set, index),
                contract::get_param(after_set, index), text_of(info.unit).c_str());
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

// True when all walks came to their end.
bool try_out(const Request& request, const LedSession& session, const contract::Params& after, const Fit& fit) {
  const twin::WhatIf tried = twin::what_if(fit, *session.scenario, session.params, after, request.walks, request.seed);
  print_what_if(request, session.params, after, tried);
  return unfinished("before", tried.before) + unfinished("after", tried.after) == 0;
}

int run(const Request& request) {
  db::Result<db::Database> database = db::Database::attach(std::string(request.database));
  if (!database) return refuse("twin", database.error());
  const db::Result<LedSession> session = twin::read_led_session(*database, request.session);
  if (!session) return refuse("twin", session.error());
  contract::Params after = session->params;
  for (const auto& [index, value] : request.changes) contract::set_param_unchecked(after, index, value);
  if (const char* sentence = contract::check_param_set(after); sentence != nullptr) return bad_usage("twin", sentence);
  std::vector<LedSession> others;
  for (const db::SessionId other : request.against) {
    db::Result<LedSession> read = twin::read_led_session(*database, other);
    if (!read) return refuse("twin", read.error());
    others.push_back(std::move(*read));
  }
  const Fit fit = twin::fit_patient(*session, request.seed);
  print_fit(request, *session, fit);
  bool holds = print_check(request.session, "fitted to", check_twin(fit.patient, *session, request.seed));
  for (std::size_t i = 0; i < others.size(); ++i)
    holds = print_check(request.against[i], "held out", check_twin(fit.patient, others[i], request.seed)) && holds;
  if (others.empty()) std::printf("No session was held out: --against SESSION names another walk of this patient.\n");
  if (request.changes.empty()) return holds ? kDone : kPartly;
  if (!holds) {
    std::printf(
        "\nNot tried: this twin does not walk as its sessions did, so what it does with other settings says nothing of the patient.\n");
    return kPartly;
  }
  const bool whole = try_out(request, *session, after, fit);
  std::printf("\n%s", kCannotTell);
  return whole ? kDone : kPartly;
}

}  // namespace

int run_twin(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(kTwinHelp, stdout);
    return kDone;
  }
  Request request;
  if (const std::string wrong = read_request(arguments, request); !wrong.empty()) return bad_usage("twin", wrong);
  return run(request);
}

}  // namespace hoist::tool
