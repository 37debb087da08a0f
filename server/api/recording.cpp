// /recording: what is being recorded; recordings on standby begin and end here.
#include <nlohmann/json.hpp>

#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"
#include "server/state/views.hpp"

namespace hoist::server::api {

using nlohmann::json;

void get_recording(const CallPtr& call) { call->respond(recording_json(call->services.recorder.status())); }

void control_recording(const CallPtr& call) {
  act_record(call->services, asker_of(*call), *call->body,
             answer_with(call, [call](const Outcome&) { call->respond(recording_json(call->services.recorder.status())); }));
}

}  // namespace hoist::server::api
