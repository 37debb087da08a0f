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
  const auto text = [&body](const char* name) -> std::optional<std::string> {
    const auto at = body.find(name);
    return at != body.end() ? std::optional{at->get<std::string>()} : std::nullopt;
  };
  const bool starts = body.at("action") == "start";
  if (starts) call->services.start_anew = true;
  in_background(
      call, [starts, subject = text("subject"), note = text("note").value_or(""), path = call->request.path](Records& records) -> Response {
        const db::Status status = starts ? records.begin_manual(subject, note) : records.end_manual();
        if (!status) {
          if (status.error().kind == db::ErrorKind::disk_full)
            return problem_response({.status = 507, .name = "disk-full", .title = "The disk is full", .detail = status.error().message},
                                    path);
          return store_error(status.error(), path);
        }
        return json_response(recording_json(records.status()));
      });
}

}  // namespace hoist::server::api
