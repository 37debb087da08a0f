#include "deploy/tools/hoist/study/protocol.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "control/contract/params.hpp"

namespace hoist::tool::study {

namespace {

using nlohmann::json;

constexpr std::string_view kPaper = R"json({
  "title": "Bosnjak & Skrjanc, Tables I to III",
  "preset": "walk",
  "laps": 2,
  "order": "listed",
  "runs": [
    {"run": 1, "shape": "square", "led_by": "therapist", "injured": false},
    {"run": 2, "shape": "eight", "led_by": "therapist", "injured": false},
    {"run": 3, "shape": "eight", "led_by": "patient", "injured": false},
    {"run": 4, "shape": "square", "led_by": "therapist", "injured": true},
    {"run": 5, "shape": "eight", "led_by": "therapist", "injured": true},
    {"run": 6, "shape": "eight", "led_by": "patient", "injured": true}
  ],
  "excluded": [
    {"subject": 1, "runs": [4, 5, 6]}, {"subject": 2, "runs": [4, 5, 6]},
    {"subject": 8, "runs": [4, 5, 6]}, {"subject": 9, "runs": [4, 5, 6]}
  ],
  "compared": [[2, 3], [5, 6], [2, 5], [3, 6]],
  "drawn": {"subjects": [3, 4, 5], "runs": [2, 3, 5, 6]},
  "assumed": {
    "wish_m_s": [0.20, 0.28],
    "anticipation_norm": [0.5, 0.9],
    "learning_norm": 0.04,
    "trailing_s": 0.2,
    "limp_norm": 0.2,
    "injured_sway_norm": 1.2,
    "therapist_m_s": 0.25,
    "therapist_delay_s": 0.35,
    "misjudgement_m": 0.15,
    "misjudgement_rad": 0.0872664626
  }
}
)json";

/// A field that is not as it must be.
struct Wrong : std::runtime_error {
  Wrong(const std::string& field, const std::string& what) : std::runtime_error(field + ": " + what) {}
};

const json& member(const json& in, const std::string& name, const std::string& where) {
  if (!in.is_object()) throw Wrong(where, "must be an object");
  const auto at = in.find(name);
  if (at == in.end()) throw Wrong(where.empty() ? name : where + "." + name, "is missing");
  return *at;
}

double number(const json& value, const std::string& field, double least, double most) {
  if (!value.is_number() || !(value.get<double>() >= least && value.get<double>() <= most))
    throw Wrong(field, "must be a number from " + json(least).dump() + " to " + json(most).dump());
  return value.get<double>();
}
int whole(const json& value, const std::string& field, int least, int most) {
  const double read = number(value, field, least, most);
  if (read != static_cast<int>(read)) throw Wrong(field, "must be a whole number");
  return static_cast<int>(read);
}
std::string one_of(const json& value, const std::string& field, const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : " or ") + word;
  if (!value.is_string() || std::ranges::find(words, value.get<std::string>()) == words.end()) throw Wrong(field, "must be " + all);
  return value.get<std::string>();
}
const json& list(const json& value, const std::string& field, std::size_t most) {
  if (!value.is_array() || value.size() > most) throw Wrong(field, "must be a list of at most " + std::to_string(most));
  return value;
}

Run read_run(const json& value, const std::string& where) {
  Run run;
  run.number = whole(member(value, "run", where), where + ".run", 1, kMostRuns);
  // The simulated hoist has these on its floor, with their usual sizes.
  const std::string shape = one_of(member(value, "shape", where), where + ".shape", {"square", "eight"});
  run.shape = contract::find_exercise(shape)->shape;
  run.by_patient = one_of(member(value, "led_by", where), where + ".led_by", {"patient", "therapist"}) == "patient";
  const json& injured = member(value, "injured", where);
  if (!injured.is_boolean()) throw Wrong(where + ".injured", "must be true or false");
  run.injured = injured.get<bool>();
  return run;
}

Range range(const json& value, const std::string& field, double least, double most) {
  if (!value.is_array() || value.size() != 2) throw Wrong(field, "must be two numbers");
  const Range read{number(value[0], field + "[0]", least, most), number(value[1], field + "[1]", least, most)};
  if (read[0] > read[1]) throw Wrong(field, "must rise");
  return read;
}

Assumptions read_assumptions(const json& value) {
  const auto at = [&value](const char* name) -> const json& { return member(value, name, "assumed"); };
  const auto read = [&](const char* name, double least, double most) {
    return number(at(name), "assumed." + std::string(name), least, most);
  };
  Assumptions a;
  a.wish_m_s = range(at("wish_m_s"), "assumed.wish_m_s", 0.1, 0.6);
  a.anticipation_norm = range(at("anticipation_norm"), "assumed.anticipation_norm", 0, 2);
  a.learning_norm = read("learning_norm", 0, 0.5);
  a.trailing_s = read("trailing_s", 0, 1);
  a.limp_norm = read("limp_norm", 0, 0.8);
  a.injured_sway_norm = read("injured_sway_norm", 0.5, 2);
  a.therapist_m_s = read("therapist_m_s", 0.1, 0.3);
  a.therapist_delay_s = read("therapist_delay_s", 0, 0.6);
  a.misjudgement_m = read("misjudgement_m", 0, 0.5);
  a.misjudgement_rad = read("misjudgement_rad", 0, 0.5);
  return a;
}

int known_run(const Protocol& protocol, const json& value, const std::string& field) {
  const int run = whole(value, field, 1, kMostRuns);
  if (protocol.find(run) == nullptr) throw Wrong(field, "names no run of the protocol");
  return run;
}

void read_lists(const json& all, Protocol& out) {
  for (const json& one : list(member(all, "excluded", ""), "excluded", kMostSubjects))
    for (const json& run : list(member(one, "runs", "excluded"), "excluded.runs", kMostRuns))
      out.excluded.emplace_back(whole(member(one, "subject", "excluded"), "excluded.subject", 1, kMostSubjects),
                                known_run(out, run, "excluded.runs"));
  for (const json& pair : list(member(all, "compared", ""), "compared", kMostRuns * kMostRuns)) {
    if (!pair.is_array() || pair.size() != 2) throw Wrong("compared", "must be pairs of runs");
    out.compared.emplace_back(known_run(out, pair[0], "compared"), known_run(out, pair[1], "compared"));
  }
  const json& drawn = member(all, "drawn", "");
  for (const json& subject : list(member(drawn, "subjects", "drawn"), "drawn.subjects", kMostSubjects))
    out.drawn_subjects.push_back(whole(subject, "drawn.subjects", 1, kMostSubjects));
  for (const json& run : list(member(drawn, "runs", "drawn"), "drawn.runs", kMostRuns))
    out.drawn_runs.push_back(known_run(out, run, "drawn.runs"));
}

Protocol read(const json& all) {
  Protocol out;
  const json& title = member(all, "title", "");
  if (!title.is_string()) throw Wrong("title", "must be a text");
  out.title = title.get<std::string>();
  std::vector<std::string> presets;
  presets.reserve(contract::kPresets.size());
  for (const contract::PresetInfo& preset : contract::kPresets) presets.emplace_back(preset.name);
  out.preset = one_of(member(all, "preset", ""), "preset", presets);
  out.laps = number(member(all, "laps", ""), "laps", 1, 10);
  out.random_order = one_of(member(all, "order", ""), "order", {"listed", "random"}) == "random";
  for (const json& run : list(member(all, "runs", ""), "runs", kMostRuns)) {
    out.runs.push_back(read_run(run, "runs[" + std::to_string(out.runs.size()) + "]"));
    if (out.find(out.runs.back().number) != &out.runs.back()) throw Wrong("runs", "name a run twice");
  }
  if (out.runs.empty()) throw Wrong("runs", "must not be empty");
  read_lists(all, out);
  out.assumed = read_assumptions(member(all, "assumed", ""));
  return out;
}

}  // namespace

bool Protocol::has(int subject, int run) const { return std::ranges::find(excluded, std::pair{subject, run}) == excluded.end(); }

const Run* Protocol::find(int run) const {
  for (const Run& row : runs)
    if (row.number == run) return &row;
  return nullptr;
}

std::string_view paper_protocol() { return kPaper; }

std::optional<Protocol> read_protocol(std::string_view text, std::string& problem) {
  const json all = json::parse(text, nullptr, false);
  if (all.is_discarded()) {
    problem = "it is not JSON";
    return std::nullopt;
  }
  try {
    return read(all);
  } catch (const Wrong& wrong) {
    problem = wrong.what();
    return std::nullopt;
  }
}

}  // namespace hoist::tool::study
