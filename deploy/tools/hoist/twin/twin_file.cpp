#include "deploy/tools/hoist/twin/twin_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "control/contract/program_version.hpp"
#include "deploy/tools/hoist/twin/what_if.hpp"
#include "firmware/sim/plant.hpp"

namespace hoist::tool::twin {

namespace {

using nlohmann::json;

constexpr const char* kFormat = "hoist-twin";
/// Walks of the check: sensors of three seeds.
constexpr int kCheckWalks = 3;

/// What the gait holds, with the bounds of a person.
struct GaitField {
  const char* name;
  double sim::PatientParams::*field;
  double least, most;
};
constexpr std::array kGait{
    GaitField{"stride_hz", &sim::PatientParams::stride_hz, 0.1, 1.5},
    GaitField{"limp_norm", &sim::PatientParams::limp_norm, -1.0, 1.0},
    GaitField{"sway_forward_m", &sim::PatientParams::sway_forward_m, 0.0, 0.1},
    GaitField{"sway_lateral_m", &sim::PatientParams::sway_lateral_m, 0.0, 0.2},
    GaitField{"sway_yaw_rad", &sim::PatientParams::sway_yaw_rad, 0.0, 0.5},
};

/// A field that is not as it must be.
struct Wrong : std::runtime_error {
  Wrong(const std::string& field, const std::string& what) : std::runtime_error(field + ": " + what) {}
};

const json& member(const json& in, const std::string& name, const std::string& where) {
  const std::string field = where.empty() ? name : where + "." + name;
  if (!in.is_object()) throw Wrong(where, "must be an object");
  const auto at = in.find(name);
  if (at == in.end()) throw Wrong(field, "is missing");
  return *at;
}
double number(const json& value, const std::string& field, double least, double most) {
  if (!value.is_number() || !(value.get<double>() >= least && value.get<double>() <= most))
    throw Wrong(field, "must be a number from " + json(least).dump() + " to " + json(most).dump());
  return value.get<double>();
}
double number_in(const json& in, const char* name, const std::string& where, double least, double most) {
  return number(member(in, name, where), where.empty() ? name : where + "." + name, least, most);
}

json value_json(const FittedValue& value) {
  return {{"name", value.name},
          {"unit", value.unit},
          {"value", value.value},
          {"spread", value.spread},
          {"told", value.told()},
          {"least_told_from", value.alike},
          {"correlation", value.alike_norm}};
}

contract::Params read_parameters(const json& in) {
  if (!in.is_object()) throw Wrong("parameters", "must be an object");
  contract::Params params;
  for (const auto& [name, value] : in.items()) {
    const auto index = contract::find_param(name);
    if (!index) throw Wrong("parameters." + name, "is not known");
    const contract::ParamInfo& info = contract::kParams[*index];
    contract::set_param_unchecked(params, *index, number(value, "parameters." + name, info.min, info.max));
  }
  if (const char* sentence = contract::check_param_set(params); sentence != nullptr) throw Wrong("parameters", sentence);
  return params;
}

// The bounds that the fit itself keeps: values beyond them are of no patient.
void read_fitted(const json& in, Fit& fit) {
  fit.values = fitted_table();
  if (!in.is_array() || in.size() != fit.values.size()) throw Wrong("fitted", "must hold the values of version 1");
  std::vector<double> values;
  for (std::size_t k = 0; k < fit.values.size(); ++k) {
    FittedValue& value = fit.values[k];
    const std::string field = "fitted[" + std::to_string(k) + "]";
    if (member(in[k], "name", field) != value.name) throw Wrong(field + ".name", "must be " + std::string(value.name));
    value.value = number_in(in[k], "value", field, -1e6, 1e6);
    value.spread = number_in(in[k], "spread", field, 0.0, 1e6);
    values.push_back(value.value);
  }
  fit.patient = with_values(fit.patient, values);
  const std::vector<double> kept = fitted_values(fit.patient);
  for (std::size_t k = 0; k < values.size(); ++k)
    if (kept[k] != values[k]) throw Wrong("fitted[" + std::to_string(k) + "].value", "is of no patient");
}

void read_correlation(const json& in, Fit& fit) {
  const std::size_t size = fit.values.size();
  if (!in.is_array() || in.size() != size) throw Wrong("correlation", "must have a row for each fitted value");
  for (std::size_t a = 0; a < size; ++a) {
    const std::string field = "correlation[" + std::to_string(a) + "]";
    if (!in[a].is_array() || in[a].size() != size) throw Wrong(field, "must have a number for each fitted value");
    std::vector<double> row;
    for (std::size_t b = 0; b < size; ++b) row.push_back(number(in[a][b], field + "[" + std::to_string(b) + "]", -1.0 - 1e-9, 1.0 + 1e-9));
    fit.alike_norm.push_back(row);
  }
  for (std::size_t a = 0; a < size; ++a)
    for (std::size_t b = 0; b < size; ++b) {
      if (std::fabs(fit.alike_norm[a][b] - (a == b ? 1.0 : fit.alike_norm[b][a])) > 1e-6)
        throw Wrong("correlation", "must be symmetric, 1 on its diagonal");
      if (a == b || std::fabs(fit.alike_norm[a][b]) <= std::fabs(fit.values[a].alike_norm)) continue;
      fit.values[a].alike = fit.values[b].name;
      fit.values[a].alike_norm = fit.alike_norm[a][b];
    }
}

void read_session(const json& in, Twin& twin) {
  twin.session = static_cast<db::SessionId>(number_in(in, "id", "session", 0, 9e15));
  twin.started_utc_ns = static_cast<std::int64_t>(number_in(in, "started_utc_ns", "session", 0, 9e18));
  twin.led_s = number_in(in, "led_s", "session", kLeastLed_s, kMostLed_s);
  const json& name = member(in, "scenario", "session");
  twin.scenario = name.is_string() ? sim::find_scenario(name.get<std::string>()) : nullptr;
  if (twin.scenario == nullptr || twin.scenario->figure == sim::Figure::free || twin.scenario->trip_after_s > 0.0 ||
      twin.scenario->slippery)
    throw Wrong("session.scenario", "must be figure-eight, square or straight");
}

Twin read(const json& in) {
  if (member(in, "format", "") != kFormat) throw Wrong("format", std::string("must be ") + kFormat);
  if (member(in, "version", "") != kTwinVersion) throw Wrong("version", "must be " + std::to_string(kTwinVersion));
  Twin twin;
  read_session(member(in, "session", ""), twin);
  twin.params = read_parameters(member(in, "parameters", ""));
  twin.seed = static_cast<std::uint64_t>(number_in(in, "seed", "", 0, 1e9));
  twin.fit.patient.lean_for(sim::PlantParams{}.strut_length_m * std::tan(twin.params.lean_range_rad));
  const json& gait = member(in, "gait", "");
  for (const GaitField& field : kGait) twin.fit.patient.*(field.field) = number_in(gait, field.name, "gait", field.least, field.most);
  read_fitted(member(in, "fitted", ""), twin.fit);
  read_correlation(member(in, "correlation", ""), twin.fit);
  const json& residual = member(in, "residual", "");
  twin.fit.rms_lean_m = number_in(residual, "lean_m", "residual", 0, 1);
  twin.fit.rms_turn_rad = number_in(residual, "turn_rad", "residual", 0, 3);
  const json& starts = member(in, "starts", "");
  twin.fit.starts = static_cast<int>(number_in(starts, "run", "starts", 1, 100));
  twin.fit.starts_agreed = static_cast<int>(number_in(starts, "agreed", "starts", 1, 100));
  const json& check = member(in, "check", "");
  twin.check = {number_in(check, "C_recorded", "check", -1, 1), number_in(check, "C_twin", "check", -1, 1),
                number_in(check, "speed_rms_recorded_m_s", "check", 0, 10), number_in(check, "speed_rms_twin_m_s", "check", 0, 10),
                static_cast<int>(number_in(check, "walks", "check", 0, 100))};
  return twin;
}

json schema_of_values(const char* what) {
  return {{"type", "array"},
          {"description", what},
          {"items",
           {{"type", "object"},
            {"required", {"name", "unit", "value", "spread", "told"}},
            {"properties",
             {{"name", {{"type", "string"}}},
              {"unit", {{"type", "string"}}},
              {"value", {{"type", "number"}}},
              {"spread", {{"type", "number"}, {"minimum", 0}, {"description", "standard deviation"}}},
              {"told", {{"type", "boolean"}, {"description", "less than half of the usual spread is left"}}},
              {"least_told_from", {{"type", "string"}}},
              {"correlation", {{"type", "number"}, {"minimum", -1}, {"maximum", 1}}}}}}}};
}

json numbers(std::initializer_list<const char*> names) {
  json properties = json::object(), required = json::array();
  for (const char* name : names) {
    properties[name] = {{"type", "number"}};
    required.push_back(name);
  }
  return {{"type", "object"}, {"required", required}, {"properties", properties}};
}

}  // namespace

bool Check::holds() const {
  return walks > 0 && std::fabs(c_twin - c_recorded) <= kCheckC &&
         std::fabs(speed_rms_twin_m_s - speed_rms_recorded_m_s) <= kCheckSpeed_norm * speed_rms_recorded_m_s;
}

std::string twin_text(const Twin& twin) {
  json out{{"format", kFormat},
           {"version", kTwinVersion},
           {"program", contract::program_version()},
           {"session",
            {{"id", twin.session}, {"started_utc_ns", twin.started_utc_ns}, {"scenario", twin.scenario->name}, {"led_s", twin.led_s}}},
           {"seed", twin.seed},
           {"residual", {{"lean_m", twin.fit.rms_lean_m}, {"turn_rad", twin.fit.rms_turn_rad}}},
           {"starts", {{"run", twin.fit.starts}, {"agreed", twin.fit.starts_agreed}}},
           {"correlation", twin.fit.alike_norm},
           {"check",
            {{"C_recorded", twin.check.c_recorded},
             {"C_twin", twin.check.c_twin},
             {"speed_rms_recorded_m_s", twin.check.speed_rms_recorded_m_s},
             {"speed_rms_twin_m_s", twin.check.speed_rms_twin_m_s},
             {"walks", twin.check.walks},
             {"holds", twin.check.holds()}}}};
  for (std::size_t i = 0; i < contract::kParamCount; ++i)
    out["parameters"][std::string(contract::kParams[i].name)] = contract::get_param(twin.params, i);
  for (const GaitField& field : kGait) out["gait"][field.name] = twin.fit.patient.*(field.field);
  for (const FittedValue& value : twin.fit.values) out["fitted"].push_back(value_json(value));
  out["derived"] = json::array();
  for (const FittedValue& value : twin.fit.derived) out["derived"].push_back(value_json(value));
  return out.dump(2) + "\n";
}

std::optional<Twin> read_twin(std::string_view text, std::string& problem) {
  const json in = json::parse(text, nullptr, false);
  if (in.is_discarded()) {
    problem = "is not JSON";
    return std::nullopt;
  }
  try {
    return read(in);
  } catch (const Wrong& wrong) {
    problem = wrong.what();
    return std::nullopt;
  }
}

std::string twin_schema() {
  json parameters = json::object();
  for (const contract::ParamInfo& info : contract::kParams)
    parameters[std::string(info.name)] = {{"type", "number"}, {"minimum", info.min}, {"maximum", info.max}};
  json gait = json::object(), gait_names = json::array();
  for (const GaitField& field : kGait) {
    gait[field.name] = {{"type", "number"}, {"minimum", field.least}, {"maximum", field.most}};
    gait_names.push_back(field.name);
  }
  const json row{{"type", "array"}, {"items", {{"type", "number"}, {"minimum", -1}, {"maximum", 1}}}};
  json session = numbers({"id", "started_utc_ns", "led_s"});
  session["properties"]["scenario"] = {{"enum", {"figure-eight", "square", "straight"}}};
  session["required"].push_back("scenario");
  json check = numbers({"C_recorded", "C_twin", "speed_rms_recorded_m_s", "speed_rms_twin_m_s", "walks"});
  check["properties"]["holds"] = {{"type", "boolean"}};
  const json properties{{"format", {{"const", kFormat}}},
                        {"version", {{"const", kTwinVersion}}},
                        {"program", {{"type", "string"}}},
                        {"session", session},
                        {"seed", {{"type", "integer"}, {"minimum", 0}}},
                        {"parameters", {{"type", "object"}, {"additionalProperties", false}, {"properties", parameters}}},
                        {"gait", {{"type", "object"}, {"required", gait_names}, {"properties", gait}}},
                        {"fitted", schema_of_values("values found by replay, in this order")},
                        {"derived", schema_of_values("what is asked for of a patient: delay, stiffness, cadence, asymmetry, turning lead")},
                        {"correlation", {{"type", "array"}, {"items", row}}},
                        {"residual", numbers({"lean_m", "turn_rad"})},
                        {"starts", numbers({"run", "agreed"})},
                        {"check", check}};
  json required = json::array();
  for (const auto& [name, value] : properties.items())
    if (name != "program" && name != "derived") required.push_back(name);
  return json{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
              {"title", "twin of a patient, hoist twin"},
              {"type", "object"},
              {"required", required},
              {"properties", properties}}
             .dump(2) +
         "\n";
}

Twin make_twin(const LedSession& session, std::uint64_t seed) {
  Twin twin;
  twin.scenario = session.scenario;
  twin.led_s = session.led_s();
  twin.params = session.params;
  twin.seed = seed;
  twin.fit = fit_patient(session, seed);
  double squares = 0;
  std::size_t moving = 0;
  for (std::size_t i = session.led_from; i < session.led_to; ++i) {
    if (std::fabs(session.steps[i].speed_m_s) < 0.02) continue;
    squares += session.steps[i].speed_m_s * session.steps[i].speed_m_s;
    ++moving;
  }
  twin.check.c_recorded = session.analysis.comparison.c.value_or(0.0);
  twin.check.speed_rms_recorded_m_s = moving == 0 ? 0.0 : std::sqrt(squares / static_cast<double>(moving));
  std::vector<WalkOutcome> walks;
  for (int walk = 0; walk < kCheckWalks; ++walk)
    walks.push_back(walk_twin(twin.fit.patient, *session.scenario, session.params, seed * 100 + static_cast<std::uint64_t>(walk) + 1));
  const Spread c = spread_of(walks, static_cast<std::size_t>(Told::c)),
               speed = spread_of(walks, static_cast<std::size_t>(Told::speed_rms_m_s));
  twin.check.c_twin = c.mean;
  twin.check.speed_rms_twin_m_s = speed.mean;
  twin.check.walks = c.walks;
  return twin;
}

}  // namespace hoist::tool::twin
