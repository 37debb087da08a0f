#include "control/run/parameter_file.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

namespace hoist::run {
using nlohmann::json;

namespace {
std::string outside(std::size_t index, const json& value) {
  const contract::ParamInfo& info = contract::kParams[index];
  char text[200];
  std::snprintf(text, sizeof text, "stored parameter %.*s is %s, not a number from %g to %g %.*s; its default %g holds",
                static_cast<int>(info.name.size()), info.name.data(), value.dump().substr(0, 40).c_str(), info.min, info.max,
                static_cast<int>(info.unit.size()), info.unit.data(), contract::get_param(contract::Params{}, index));
  return text;
}

// A default that takes the place of a machine's own value was never measured or checked there.
void forget_calibration(LoadedParams& loaded) {
  for (std::size_t i = 0; i < contract::kParamCount; ++i)
    if (contract::kParams[i].name.starts_with("calibrated_")) contract::set_param_unchecked(loaded.params, i, 0.0);
  loaded.remarks.push_back("the calibration no longer counts: check these parameters, then calibrate and check the parts again");
}
}  // namespace

LoadedParams load_parameter_file(const std::string& path) {
  LoadedParams loaded;
  const StoredValues stored = load_values(path, "parameter file");
  loaded.problem = stored.problem;
  loaded.usable = stored.missing;
  if (stored.missing || !stored.problem.empty()) return loaded;
  bool calibrated = true;
  for (const auto& [name, value] : stored.values.items()) {
    const auto index = contract::find_param(name);
    if (!index) {
      loaded.remarks.push_back("stored parameter " + name + " is unknown to this version and was left out");
      continue;
    }
    const double number = value.is_number() ? value.get<double>() : 0.0;
    if (!value.is_number() || contract::check_param(*index, number) != contract::ParamCheck::ok) {
      loaded.remarks.push_back(outside(*index, value));
      calibrated = false;
      continue;
    }
    contract::set_param_unchecked(loaded.params, *index, number);
  }
  if (!calibrated) forget_calibration(loaded);
  if (const char* conflict = contract::check_param_set(loaded.params)) {
    loaded.problem = path + ": " + conflict;
    loaded.params = contract::Params{};
    return loaded;
  }
  loaded.usable = true;
  return loaded;
}

Saved save_parameter_file(const std::string& path, const contract::Params& params) {
  json values = json::object();
  for (std::size_t i = 0; i < contract::kParamCount; ++i) values[std::string(contract::kParams[i].name)] = contract::get_param(params, i);
  return save_values(path, values);
}

ParameterStore::ParameterStore(std::string path, const contract::Params& started_with, const contract::Params& stored)
    : path_(std::move(path)), started_with_(started_with), stored_(stored) {
  synced_.emplace();
  for (std::size_t i = 0; i < contract::kParamCount; ++i) (*synced_)[i] = contract::get_param(started_with, i);
}

const contract::StoreReport& ParameterStore::look(const contract::ParamsInForce& in_force, std::uint64_t sequence, std::uint64_t now_ns) {
  if (in_force.defaults_after_damage != 0 || synced_ == in_force.kept) {
    report_ = {.stored = sequence, .tried = sequence};
    problem_.clear();
  } else if (sequence != report_.tried || now_ns >= retry_ns_) {
    store(in_force.kept, sequence);
    retry_ns_ = now_ns + kRetry_ns;
  }
  return report_;
}

contract::Params ParameterStore::file_content(const Values& kept) const {
  contract::Params content = stored_;
  for (std::size_t i = 0; i < contract::kParamCount; ++i) {
    const double started = contract::get_param(started_with_, i);
    const bool only_this_run = kept[i] == started && started != contract::get_param(stored_, i);
    if (!only_this_run) contract::set_param_unchecked(content, i, kept[i]);
  }
  return content;
}

void ParameterStore::store(const Values& kept, std::uint64_t sequence) {
  using contract::StoreProblem;
  report_.tried = sequence;
  if (path_.empty()) {
    report_.problem = StoreProblem::no_file;
    return;
  }
  const Saved saved = save_parameter_file(path_, file_content(kept));
  problem_ = saved.problem;
  if (problem_.empty()) {
    synced_ = kept;
    report_ = {.stored = sequence, .tried = sequence};
    return;
  }
  synced_.reset();
  report_.problem = store_problem(saved);
}

}  // namespace hoist::run
