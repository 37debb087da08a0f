#include "server/api/call.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "server/http/compress.hpp"

namespace hoist::server {

namespace {
const Problem kUnfinished{
    .status = 500, .name = "internal", .title = "Something went wrong in the server", .detail = "Try again; if it stays, call service."};
}  // namespace

Call::~Call() {
  if (answer_) {
    services.counters.add(Count::http_failed);
    fail(kUnfinished);
  }
}

void Call::respond(Response response) {
  if (!answer_) return;
  if (on_answer) std::exchange(on_answer, nullptr)(response);
  // Whatever the API says is true now and for this person only.
  response.set("Cache-Control", "no-store");
  compress_json(request, response);
  std::exchange(answer_, nullptr)(std::move(response));
}

Problem recorder_busy() { return {.status = 503, .name = "busy", .title = "The recorder is busy", .detail = "Try again in a moment."}; }

void in_background(const CallPtr& call, std::function<Response(Records&)> work) {
  ask_recorder<Response>(
      call,
      [work = std::move(work), path = call->request.path](Records& records) {
        return records.late() ? problem_response(recorder_busy(), path) : work(records);
      },
      [call](Response response) { call->respond(std::move(response)); });
}

}  // namespace hoist::server
