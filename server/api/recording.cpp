// /recording: what is being recorded; recordings on standby begin and end here.
#include <nlohmann/json.hpp>

#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"
#include "server/state/views.hpp"

namespace hoist::server::api {

using nlohmann::json;

void get_recording(const CallPtr& call) { call->respond(recording_json(call->services.recorder.status())); }

void control_recording(const CallPtr& call) {
  const json& body = *call->body;
  RecordWish wish{.starts = body.at("action") == "start", .subject = {}, .note = body.value("note", "")};
  if (const auto subject = body.find("subject"); subject != body.end()) wish.subject = subject->get<std::string>();
  act_record(call->services, asker_of(*call), std::move(wish),
             answer_with(call, [call](const Outcome&) { call->respond(recording_json(call->services.recorder.status())); }));
}

}  // namespace hoist::server::api
