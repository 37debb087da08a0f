// One REST call on its way through a handler. A handler answers exactly once, now or later; a call that is dropped unanswered answers 500.
#pragma once
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "server/api/rest_context.hpp"
#include "server/http/exchange.hpp"
#include "server/http/problem.hpp"
#include "server/services.hpp"

namespace hoist::server {

class Call {
 public:
  Call(const RestContext& rest_in, Request request_in, std::function<void(Response)> answer)
      : rest(rest_in), services(rest_in.services), request(std::move(request_in)), answer_(std::move(answer)) {}
  ~Call();
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

  void respond(Response response);
  void respond(const nlohmann::json& value, unsigned status = 200) { respond(json_response(value, status)); }
  void fail(const Problem& problem) { respond(problem_response(problem, request.path)); }

  const RestContext& rest;
  Services& services;
  const Request request;
  SessionPtr session;                              // null only on open routes
  std::vector<std::string> path_values;            // what stood for {name}, {id} …
  std::shared_ptr<const nlohmann::json> body;      // an object, when the route has a request schema
  std::function<void(const Response&)> on_answer;  // sees the answer before it leaves; may be empty
  // True: an action has written its row of the audit log for this call. Null until the caller is known.
  mutable std::shared_ptr<bool> logged;

 private:
  std::function<void(Response)> answer_;
};
using CallPtr = std::shared_ptr<Call>;

[[nodiscard]] Problem recorder_busy();

// Runs `work` on the recorder's thread and gives what it returns to `then`, which answers the call. `work` must hold plain values only, not
// the call (recorder_desk.hpp).
template <typename Result>
void ask_recorder(const CallPtr& call, std::function<Result(Records&)> work, std::function<void(Result)> then) {
  if (!call->services.records.ask<Result>(std::move(work), std::move(then))) call->fail(recorder_busy());
}
// The same on the people's thread. False when the call was refused at once.
template <typename Result>
bool ask_people(const CallPtr& call, std::function<Result(PeopleRoom&)> work, std::function<void(Result)> then, Turn turn = Turn::first) {
  PeopleDesk& people = call->services.people;
  if (const std::string problem = people.problem(); !problem.empty()) {
    call->fail({.status = 503, .name = "accounts", .title = "The accounts cannot be used", .detail = problem});
    return false;
  }
  if (people.at(turn).ask<Result>(std::move(work), std::move(then))) return true;
  call->fail({.status = 503, .name = "busy", .title = "Too many people sign in at once", .detail = "Try again in a moment."});
  return false;
}
// The same for work that makes the whole answer.
void in_background(const CallPtr& call, std::function<Response(Records&)> work);

}  // namespace hoist::server
