// /walk, /exercise: what is walked, and where it has led.
#include <nlohmann/json.hpp>

#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"
#include "server/live/hub.hpp"

namespace hoist::server::api {

void get_walk(const CallPtr& call) { call->respond(call->services.hub.walk().told()); }
void choose_exercise(const CallPtr& call) { act_choose(call->services, *call->body, answer_done(call)); }

}  // namespace hoist::server::api
