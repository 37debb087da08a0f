#include "server/api/call.hpp"

#include <exception>
#include <nlohmann/json.hpp>
#include <utility>

namespace hoist::server {

namespace {
const Problem kUnfinished{
    .status = 500, .name = "internal", .title = "Something went wrong in the server", .detail = "Try again; if it stays, call service."};
}

Call::~Call() {
  if (answer_) {
    services.counters.add(Count::http_failed);
    fail(kUnfinished);
  }
}

void Call::respond(Response response) {
  if (!answer_) return;
  // Whatever the API says is true now and for this person only.
  response.set("Cache-Control", "no-store");
  std::exchange(answer_, nullptr)(std::move(response));
}

void in_background(const CallPtr& call, std::function<Response(Records&)> work) {
  Services& services = call->services;
  auto job = [held = call, work = std::move(work), post = services.post, path = call->request.path](Records& records) mutable {
    Response response;
    try {
      response = work(records);
    } catch (const std::exception&) {
      response = problem_response(kUnfinished, path);
    }
    // The call belongs to the network thread and must also end there.
    post([held = std::move(held), answer = std::move(response)]() mutable { held->respond(std::move(answer)); });
  };
  if (!services.recorder.run(std::move(job)))
    call->fail({.status = 503, .name = "busy", .title = "The recorder is busy", .detail = "Try again in a moment."});
}

}  // namespace hoist::server
