// hoist tune-advice: settings suggested from the noise of a recorded session.
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "db/advice/preference.hpp"
#include "db/advice/tuning.hpp"
#include "db/advice/tuning_json.hpp"
#include "db/store/session_reader.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/recording_file.hpp"

namespace hoist::tool {

namespace {

constexpr const char* kTuneAdviceHelp =
    "usage: hoist tune-advice DB SESSION [--json]\n"
    "       hoist tune-advice next DB SESSION [better|worse|same …]\n\n"
    "Suggested dead bands and gains, from how still the patient stood and how far the patient leaned and turned to walk. For each: what\n"
    "was measured, the formula, and what to expect. Nothing is changed; a therapist decides and sets the value. Exit code 3: some\n"
    "settings get no suggestion from this session, and why.\n"
    "next: compares sets of settings. It begins with the set in force in the session and names the set to walk with next; add the\n"
    "patient's answer to each set tried so far, new against the one liked best before. One setting changes at a time, inside 40 % of the\n"
    "start. One answer may be chance: ask again where it matters.\n";

void print(const db::TuningRule& rule, const db::Suggestion& suggestion) {
  const contract::ParamInfo& info = contract::kParams[contract::param_index(rule.param)];
  const std::string name(info.name), unit(info.unit);
  if (suggestion.why != db::NoAdvice::none) {
    std::printf("%s: no suggestion. %s\n\n", name.c_str(), std::string(db::no_advice_info(suggestion.why).text_en).c_str());
    return;
  }
  const std::string of(rule.measured_unit);
  const bool stays = suggestion.now == suggestion.suggested;
  if (stays)
    std::printf("%s: %g %s may stay\n", name.c_str(), suggestion.now, unit.c_str());
  else
    std::printf("%s: %g -> %g %s\n", name.c_str(), suggestion.now, suggestion.suggested, unit.c_str());
  std::printf("  measured: %s %.3f %s\n  formula:  %s\n", std::string(rule.reason_en).c_str(), suggestion.measured, of.c_str(),
              std::string(rule.formula).c_str());
  std::printf("  expected: %s %.3f -> %.3f %s\n\n", std::string(rule.effect_en).c_str(), suggestion.effect_now, suggestion.effect_then,
              of.c_str());
}

int print_advice(const db::TuningAdvice& advice, bool as_json) {
  const bool whole = std::ranges::all_of(advice.suggestions, [](const db::Suggestion& s) { return s.why == db::NoAdvice::none; });
  if (as_json) {
    std::printf("%s\n", db::tuning_json(advice).dump().c_str());
    return whole ? kDone : kPartly;
  }
  std::printf("Session %lld: %.0f s standing, %.0f s walking led by the patient\n\n", static_cast<long long>(advice.session),
              advice.standing_s, advice.walking_s);
  for (std::size_t i = 0; i < db::kTuningRules.size(); ++i) print(db::kTuningRules[i], advice.suggestions[i]);
  std::printf("Advice only: a therapist decides, sets one value at a time, and watches the patient.\n");
  return whole ? kDone : kPartly;
}

void print_set(const char* title, const db::PreferenceSet& set) {
  std::printf("%s:", title);
  for (std::size_t k = 0; k < set.size(); ++k) {
    const contract::ParamInfo& info = contract::kParams[contract::param_index(db::kPreferred[k])];
    std::printf("  %s=%g", std::string(info.name).c_str(), set[k]);
  }
  std::printf("\n");
}

int print_next(db::Database& database, db::SessionId session, std::span<const std::string_view> words) {
  std::vector<db::Preference> answers;
  for (const std::string_view word : words) {
    const auto at = std::ranges::find(db::kPreferenceNames, word);
    if (at == db::kPreferenceNames.end()) return bad_usage("tune-advice", "an answer is better, worse or same, not " + std::string(word));
    answers.push_back(static_cast<db::Preference>(at - db::kPreferenceNames.begin()));
  }
  const auto stored = db::SessionReader(database).parameters(session);
  if (!stored) return refuse("tune-advice", stored.error());
  db::PreferenceSet start{};
  for (std::size_t k = 0; k < start.size(); ++k) {
    const std::string_view name = contract::kParams[contract::param_index(db::kPreferred[k])].name;
    const auto at = std::ranges::find(*stored, name, [](const auto& row) { return std::string_view(row.first); });
    if (at == stored->end()) return refuse("tune-advice", {db::ErrorKind::bad_value, "the settings of this session were not recorded", {}});
    start[k] = at->second;
  }
  const db::PreferenceState state = db::preference_after(start, answers);
  if (state.answered < answers.size())
    return bad_usage("tune-advice", "the search ended after " + std::to_string(state.answered) + " answers");
  print_set("liked best so far", state.best);
  if (state.finished)
    std::printf("Nothing nearby is left to try. A therapist decides whether this set stays.\n");
  else
    print_set("walk next with   ", state.next);
  return kDone;
}

}  // namespace

int run_tune_advice(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(kTuneAdviceHelp, stdout);
    return kDone;
  }
  const bool next = !arguments.empty() && arguments[0] == "next";
  const bool as_json = arguments.size() == 3 && arguments[2] == "--json";
  const std::span<const std::string_view> places = arguments.subspan(next ? 1 : 0);
  const auto session = places.size() >= 2 && (next || as_json || places.size() == 2) ? parse_session(places[1]) : std::nullopt;
  if (!session) return bad_usage("tune-advice", "name a database and a session's number");
  db::Result<db::Database> database = db::Database::attach(std::string(places[0]));
  if (!database) return refuse("tune-advice", database.error());
  if (next) return print_next(*database, *session, places.subspan(2));
  const db::Result<db::TuningAdvice> advice = db::tuning_advice(*database, *session);
  if (!advice) return refuse("tune-advice", advice.error());
  return print_advice(*advice, as_json);
}

}  // namespace hoist::tool
