// /parameters and /presets: read what is in force, change it through the core.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "control/contract/params.hpp"
#include "db/store/edit_tag.hpp"
#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"
#include "server/api/lists.hpp"
#include "server/http/compress.hpp"
#include "server/state/views.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
json parameter_json(std::size_t index, const contract::ParamsInForce& in_force) {
  constexpr std::array<std::string_view, 3> kScopes{"core", "drive", "tilt"};
  const contract::ParamInfo& p = contract::kParams[index];
  return {{"id", p.id},
          {"name", p.name},
          {"unit", p.unit},
          {"value", in_force.values[index]},
          {"default", p.default_value},
          {"min", p.min},
          {"max", p.max},
          {"edit", p.edit == contract::EditRule::live ? "live" : "stopped"},
          {"scope", kScopes[static_cast<std::size_t>(p.scope)]},
          {"role", access_role(p.role)},
          {"source", p.source},
          {"title", {{"en", p.title_en}, {"de", p.title_de}}},
          {"effect", {{"en", p.effect_en}, {"de", p.effect_de}}}};
}

std::string etag(const Services& s) { return etag_of(parameters_tag(s)); }

// For the bytes that this request gets.
std::string list_etag(const Call& call) {
  const std::string plain = etag(call.services);
  return accepts_gzip(call.request.header("accept-encoding")) ? gzip_etag(plain) : plain;
}

bool ready(const CallPtr& call) {
  if (call->services.core.has_parameters()) return true;
  call->fail(
      {.status = 503, .name = "no-core", .title = "The control core does not answer", .detail = "The control core is not connected."});
  return false;
}

Problem changed_meanwhile() {
  return {.status = 412,
          .name = "changed-meanwhile",
          .title = "Somebody else has changed the parameters",
          .detail = "Read them again, then change them."};
}

void change(const CallPtr& call, const NumbersByName& values, std::optional<double> revert_after_s) {
  const std::string given = given_tag(*call);
  if (!db::check_tag(given, parameters_tag(call->services))) {
    call->fail(changed_meanwhile());
    return;
  }
  // The core checks the version again: another client may change a value in between.
  const std::uint32_t version = given.empty() ? 0 : static_cast<std::uint32_t>(call->services.core.parameters().version);
  act_set(call->services, asker_of(*call), values, revert_after_s, version, [call, values, version](const Outcome& outcome) {
    if (version != 0 && std::ranges::find(outcome.refusals, "set_outdated") != outcome.refusals.end()) {
      call->fail(changed_meanwhile());
      return;
    }
    if (!outcome.done()) {
      call->fail(problem_of(outcome));
      return;
    }
    // In force now; the core's own numbers, not what was asked.
    json changed = json::object();
    for (const auto& [name, value] : values)
      if (const auto index = contract::find_param(name)) changed[name] = call->services.core.parameters().values[*index];
    call->respond(parameters_changed(call->services, std::move(changed), outcome));
  });
}
}  // namespace

void list_parameters(const CallPtr& call) {
  if (!ready(call)) return;
  const Services& s = call->services;
  if (const std::string tag = list_etag(*call); names_etag(call->request.header("if-none-match"), tag)) {
    Response response;
    response.status = 304;
    response.set("Vary", "Accept-Encoding");
    response.set("ETag", tag);
    call->respond(std::move(response));
    return;
  }
  json items = json::array();
  for (std::size_t i = 0; i < contract::kParamCount; ++i) items.push_back(parameter_json(i, s.core.parameters()));
  Response response = json_response({{"version", s.core.parameters().version}, {"items", std::move(items)}});
  response.set("ETag", etag(s));
  call->respond(std::move(response));
}

void get_parameter(const CallPtr& call) {
  const auto index = contract::find_param(call->path_values.at(0));
  if (!index) {
    call->fail({.status = 404, .name = "unknown", .title = "There is no such parameter", .detail = "GET /api/v1/parameters lists them."});
    return;
  }
  if (!ready(call)) return;
  Response response = json_response(parameter_json(*index, call->services.core.parameters()));
  response.set("ETag", etag(call->services));
  call->respond(std::move(response));
}

void put_parameter(const CallPtr& call) {
  change(call, {{call->path_values.at(0), number_wish(*call->body, "value").value_or(0)}}, number_wish(*call->body, "revert_after_s"));
}

void change_parameters(const CallPtr& call) {
  json values = *call->body;
  values.erase("revert_after_s");
  change(call, numbers_wish(values), number_wish(*call->body, "revert_after_s"));
}

void keep_parameters(const CallPtr& call) { act_keep_trial(call->services, asker_of(*call), version_wish(*call->body), answer_done(call)); }
void undo_parameters(const CallPtr& call) { act_undo_trial(call->services, asker_of(*call), answer_done(call)); }

void list_presets(const CallPtr& call) {
  json items = json::array();
  for (const contract::PresetInfo& p : contract::kPresets) {
    json values = json::object();
    for (const contract::PresetValue& v : contract::kPresetValues)
      if (v.preset == p.name) values[std::string{contract::kParams[contract::param_index(v.param)].name}] = v.value;
    items.push_back({{"name", p.name},
                     {"title", {{"en", p.title_en}, {"de", p.title_de}}},
                     {"doc", {{"en", p.doc_en}, {"de", p.doc_de}}},
                     {"values", std::move(values)}});
  }
  call->respond(json{{"items", std::move(items)}});
}

void apply_preset(const CallPtr& call) {
  const std::string name = call->path_values.at(0);
  act_preset(call->services, asker_of(*call), name, version_wish(*call->body), [call, name](const Outcome& outcome) {
    if (!outcome.done()) {
      call->fail(problem_of(outcome));
      return;
    }
    json values = json::object();
    for (const contract::PresetValue& v : contract::kPresetValues)
      if (v.preset == name)
        values[std::string{contract::kParams[contract::param_index(v.param)].name}] =
            call->services.core.parameters().values[contract::param_index(v.param)];
    call->respond(parameters_changed(call->services, std::move(values), outcome));
  });
}

}  // namespace hoist::server::api
