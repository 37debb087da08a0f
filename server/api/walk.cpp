// /walk, /exercise: what is walked, and where it has led; /rehearsal: what staff rehearse on the way.
#include <nlohmann/json.hpp>

#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"

namespace hoist::server::api {

void get_walk(const CallPtr& call) { call->respond(call->services.state.walk().told()); }
void choose_task(const CallPtr& call) { act_choose_task(call->services, asker_of(*call), *call->body, answer_done(call)); }
void get_rehearsal(const CallPtr& call) { call->respond(call->services.rehearsals.told()); }
void choose_rehearsal(const CallPtr& call) { act_choose_rehearsal(call->services, asker_of(*call), *call->body, answer_done(call)); }
void choose_exercise(const CallPtr& call) { act_choose(call->services, asker_of(*call), *call->body, answer_done(call)); }

}  // namespace hoist::server::api
