// One REST call on its way through a handler. A handler answers exactly once, now or later; a call that is dropped unanswered answers 500.
#pragma once
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "server/http/exchange.hpp"
#include "server/http/problem.hpp"
#include "server/services.hpp"

namespace hoist::server {

class Call {
 public:
  Call(Services& services_in, Request request_in, std::function<void(Response)> answer)
      : services(services_in), request(std::move(request_in)), answer_(std::move(answer)) {}
  ~Call();
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

  void respond(Response response);
  void respond(const nlohmann::json& value, unsigned status = 200) { respond(json_response(value, status)); }
  void fail(const Problem& problem) { respond(problem_response(problem, request.path)); }

  Services& services;
  const Request request;
  SessionPtr session;                          // null only on open routes
  std::vector<std::string> path_values;        // what stood for {name}, {id} …
  std::shared_ptr<const nlohmann::json> body;  // an object, when the route has a request schema

 private:
  std::function<void(Response)> answer_;
};
using CallPtr = std::shared_ptr<Call>;

// Runs `work` on the recorder's thread and answers with what it returns. `work` must not touch the call.
void in_background(const CallPtr& call, std::function<Response(Records&)> work);

}  // namespace hoist::server
