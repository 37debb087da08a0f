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
    return at != body.end() && at->is_string() ? std::optional{at->get<std::string>()} : std::nullopt;
  };
  const auto action = text("action");
  if (!action || (*action != "start" && *action != "stop")) {
    call->fail({.status = 422,
                .name = "invalid",
                .title = "A value cannot be used",
                .detail = "action must be start or stop.",
                .errors = {{"action", "must be start or stop"}}});
    return;
  }
  for (const char* name : {"subject", "note"}) {
    if (!body.contains(name) || body.at(name).is_string()) continue;
    call->fail({.status = 422,
                .name = "invalid",
                .title = "A value cannot be used",
                .detail = std::string{name} + " must be text.",
                .errors = {{name, "must be text"}}});
    return;
  }
  if (*action == "start") call->services.start_anew = true;
  audited_in_background(call, *action == "start" ? "begin_recording" : "end_recording", call->services.recorder.status().session,
                        [start = *action == "start", subject = text("subject"), note = text("note").value_or(""),
                         path = call->request.path](Records& records) -> Response {
                          const db::Status status = start ? records.begin_manual(subject, note) : records.end_manual();
                          if (!status) {
                            if (status.error().kind == db::ErrorKind::disk_full)
                              return problem_response(
                                  {.status = 507, .name = "disk-full", .title = "The disk is full", .detail = status.error().message},
                                  path);
                            return store_error(status.error(), path);
                          }
                          return json_response(recording_json(records.status()));
                        });
}

}  // namespace hoist::server::api
