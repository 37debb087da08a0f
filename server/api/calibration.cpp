// /calibration: what can be calibrated, when it last was, the step under way and its result.
#include "control/contract/calibration.hpp"

#include <array>
#include <nlohmann/json.hpp>

#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"
#include "server/state/views.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
json words(std::string_view en, std::string_view de) { return {{"en", en}, {"de", de}}; }

json step_json(const contract::CalibrationStepInfo& info, const contract::ParamsInForce* params) {
  json entered = nullptr;
  if (!info.unit.empty()) entered = {{"unit", info.unit}, {"least", info.least}, {"most", info.most}};
  const double date_s = params == nullptr ? 0.0 : params->values[contract::param_index(info.date)];
  return {{"name", info.name},
          {"role", access_role(info.role)},
          {"entered", std::move(entered)},
          {"empty_harness", info.empty_harness},
          {"title", words(info.title_en, info.title_de)},
          {"action", words(info.do_en, info.do_de)},
          {"done_utc_s", date_s > 0 ? json(date_s) : json(nullptr)}};
}

json state_json(const contract::TickRecord& record, const HoistState& hoist) {
  const contract::CalibrationStepInfo* info = contract::find_calibration_step(record.calibration_step);
  if (info == nullptr) return nullptr;
  constexpr std::array<std::string_view, 6> kPhases{"none", "resting", "measuring", "operator", "result", "refused"};
  const contract::CalibrationReasonInfo* reason = contract::find_calibration_reason(record.calibration_reason);
  json result = json::array();
  for (const contract::Event& event : hoist.proposed())
    if (const auto index = contract::find_param_id(event.item))
      result.push_back({{"name", contract::kParams[*index].name}, {"value", event.value}, {"before", event.before}});
  return {{"step", info->name},
          {"phase", record.calibration_phase < kPhases.size() ? kPhases[record.calibration_phase] : kPhases[0]},
          {"done_percent", record.calibration_done_percent},
          {"value", record.calibration_value},
          {"reason", reason == nullptr ? json(nullptr) : json(reason->name)},
          {"result", std::move(result)}};
}
}  // namespace

void get_calibration(const CallPtr& call) {
  const CoreDesk& core = call->services.core;
  const contract::ParamsInForce* params = core.has_parameters() ? &core.parameters() : nullptr;
  json items = json::array();
  for (const contract::CalibrationStepInfo& info : contract::kCalibrationSteps) items.push_back(step_json(info, params));
  json reasons = json::array();
  for (const contract::CalibrationReasonInfo& reason : contract::kCalibrationReasons)
    reasons.push_back({{"name", reason.name}, {"text", words(reason.text_en, reason.text_de)}});
  const bool running = core.connected() && core.newest();
  constexpr std::uint32_t kMissing = contract::refusal_bit(contract::Refusal::not_calibrated);
  call->respond(json{{"valid", running ? json((core.newest()->blocked_bits & kMissing) == 0) : json(nullptr)},
                     {"under_way", running ? state_json(*core.newest(), call->services.state) : json(nullptr)},
                     {"items", std::move(items)},
                     {"reasons", std::move(reasons)}});
}

void begin_calibration(const CallPtr& call) {
  if (const auto asker = driver(call)) act_calibrate(call->services, *asker, calibrate_wish(*call->body), answer_done(call));
}
void measure_calibration(const CallPtr& call) {
  if (const auto asker = driver(call)) act_measure(call->services, *asker, measure_wish(*call->body), answer_done(call));
}
void use_calibration(const CallPtr& call) {
  if (const auto asker = driver(call)) act_use_calibration(call->services, *asker, answer_done(call));
}
void cancel_calibration(const CallPtr& call) {
  if (const auto asker = driver(call)) act_cancel_calibration(call->services, *asker, answer_done(call));
}

}  // namespace hoist::server::api
