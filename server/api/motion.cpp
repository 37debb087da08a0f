// /mode, /stop, /acknowledge, /alarm-pause, /lease, /neutral, /pose: what moves the hoist or keeps it from moving.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "control/contract/faults.hpp"
#include "server/api/alarms.hpp"
#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"
#include "server/state/views.hpp"

namespace hoist::server::api {

using nlohmann::json;

void get_mode(const CallPtr& call) {
  const auto& newest = call->services.core.newest();
  if (!newest || !call->services.core.connected() || newest->mode >= contract::kModes.size()) {
    call->fail(
        {.status = 503, .name = "no-core", .title = "The control core does not answer", .detail = "The control core is not connected."});
    return;
  }
  const contract::ModeInfo& mode = contract::kModes[newest->mode];
  // The core keeps the cause of the last stop; here it is that of the stop the hoist is in.
  const bool stopped = newest->mode == static_cast<std::uint8_t>(contract::Mode::protective_stop) ||
                       newest->mode == static_cast<std::uint8_t>(contract::Mode::fault) ||
                       newest->mode == static_cast<std::uint8_t>(contract::Mode::emergency_stop);
  const bool caused = stopped && newest->stop_cause != 0 && newest->stop_cause <= contract::kFaultPlaces;
  call->respond(json{{"mode", mode.name},
                     {"moving", mode.moving},
                     {"standing_still", newest->standing_still != 0},
                     {"blocked", refusal_names(newest->blocked_bits)},
                     {"stop_cause", caused ? json(fault_names(contract::fault_bit(static_cast<contract::Fault>(newest->stop_cause - 1U))))
                                           : json(nullptr)}});
}

namespace {
// What begins motion or leaves a stop counts from the first byte of its request, or from an older step that its sender had seen.
std::optional<Asker> driver_who_saw(const CallPtr& call, bool header_required = false) {
  auto asker = driver(call, header_required);
  if (!asker) return asker;
  const std::uint64_t echo = echo_wish(*call->body);
  asker->echo_time_ns = echo == 0 ? call->request.stamp : std::min(echo, call->request.stamp);
  asker->gone = call->request.sender_gone;
  return asker;
}
}  // namespace

void set_mode(const CallPtr& call) {
  const bool ends = field(*call, "mode") == "standby";
  if (const auto asker = driver_who_saw(call, !ends))
    act_mode(call->services, *asker, {field(*call, "mode"), field(*call, "exercise"), field(*call, "path"), field(*call, "start_again")},
             answer_done(call));
}

void stop(const CallPtr& call) { act_stop(call->services, asker_of(*call), answer_done(call)); }

void acknowledge(const CallPtr& call) {
  if (const auto asker = driver_who_saw(call)) act_acknowledge(call->services, *asker, field(*call, "seen"), answer_done(call));
}

void take_lease(const CallPtr& call) {
  const Asker asker = asker_of(*call);
  call->session->used_ns = call->services.now_ns();
  act_take_lease(call->services, asker, field(*call, "take_over") == true, [call, client = asker.client](const Outcome& outcome) {
    if (outcome.done())
      call->respond(json{{"epoch", outcome.epoch}, {"holder", client}});
    else
      call->fail(problem_of(outcome));
  });
}

void get_lease(const CallPtr& call) {
  const Services& s = call->services;
  json lease = lease_json(s.core, s.state.asks(), s.actors);
  lease["expires_in_s"] = nullptr;
  const std::uint64_t now = s.now_ns();
  // A client without a WebSocket that asks looks here; it has the usual time to use what it is given.
  if (call->session->client != 0 && s.state.asks().has(call->session->client)) call->session->used_ns = now;
  call->rest.auth.each_session([&](const Session& session) {
    if (session.client == 0 || session.client != s.core.lease_holder()) return;
    const std::uint64_t idle_ns = std::min(now - session.used_ns, kRestLease_ns);
    lease["expires_in_s"] = static_cast<double>(kRestLease_ns - idle_ns) * 1e-9;
  });
  call->respond(lease);
}

void ask_lease(const CallPtr& call) {
  call->session->used_ns = call->services.now_ns();
  act_ask_lease(call->services, asker_of(*call), false, answer_done(call));
}
void withdraw_lease(const CallPtr& call) { act_ask_lease(call->services, asker_of(*call), true, answer_done(call)); }
void keep_lease(const CallPtr& call) {
  if (const auto asker = driver(call)) act_keep_lease(call->services, *asker, answer_done(call));
}
void hand_over(const CallPtr& call) {
  if (const auto asker = driver(call)) act_hand_over(call->services, *asker, hand_over_wish(*call->body), answer_done(call));
}

void release_lease(const CallPtr& call) { act_release_lease(call->services, asker_of(*call), answer_done(call)); }
void pause_alarm(const CallPtr& call) {
  act_pause_alarm(call->services, asker_of(*call), field(*call, "paused") == true, answer_done(call));
}
void set_neutral(const CallPtr& call) { act_neutral(call->services, asker_of(*call), answer_done(call)); }
void set_pose(const CallPtr& call) { act_pose(call->services, asker_of(*call), pose_wish(*call->body), answer_done(call)); }

}  // namespace hoist::server::api
