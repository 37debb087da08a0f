// The handshakes of the WebSockets, and whether tools of other makers may connect.
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"
#include "server/api/lists.hpp"
#include "server/stream/stream.hpp"
#include "server/ws/handshake.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
// One of `protocols` must be offered and is echoed; an empty list takes a client that names none.
void shake_hands(const CallPtr& call, std::initializer_list<const char*> protocols, OpenSocket RestContext::*open) {
  const Request& request = call->request;
  const char* chosen = nullptr;
  std::string wanted;
  for (const char* protocol : protocols) {
    if (chosen == nullptr && offers(request.header("sec-websocket-protocol"), protocol)) chosen = protocol;
    wanted += (wanted.empty() ? "" : " or ") + std::string{protocol};
  }
  const bool version_13 = request.header("sec-websocket-version") == "13";
  if (!request.wants_upgrade || !version_13 || (chosen == nullptr && protocols.size() != 0)) {
    Response response =
        problem_response({.status = 426,
                          .name = "upgrade",
                          .title = "This address speaks WebSocket",
                          .detail = wanted.empty() ? "Connect by WebSocket." : "Connect with the subprotocol " + wanted + "."},
                         request.path);
    response.set("Upgrade", "websocket");
    response.set("Sec-WebSocket-Version", "13");
    call->respond(std::move(response));
    return;
  }
  const std::optional<std::string> accept = websocket_accept(request.header("sec-websocket-key"));
  if (!accept) {
    call->fail({.status = 400,
                .name = "bad-request",
                .title = "The request cannot be read",
                .detail = "Sec-WebSocket-Key must be 16 bytes in base64."});
    return;
  }
  Response response;
  response.status = 101;
  response.set("Upgrade", "websocket");
  response.set("Sec-WebSocket-Accept", *accept);
  if (chosen != nullptr) response.set("Sec-WebSocket-Protocol", chosen);
  response.upgrade = [&rest = call->rest, open, session = call->session, address = request.address](std::unique_ptr<Stream> stream,
                                                                                                    std::shared_ptr<void> seat) {
    (rest.*open)(std::move(stream), std::move(seat), session, address);
  };
  call->respond(std::move(response));
}

bool switched_on(const CallPtr& call) {
  if (call->services.tools.on()) return true;
  call->fail({.status = 409,
              .name = "tools-off",
              .title = "Foxglove and rosbridge are switched off",
              .detail = "An engineer switches them on: PUT /api/v1/tools."});
  return false;
}
}  // namespace

void open_live(const CallPtr& call) { shake_hands(call, {"hoist.v1"}, &RestContext::open_live); }

void open_foxglove(const CallPtr& call) {
  if (switched_on(call)) shake_hands(call, {"foxglove.sdk.v1", "foxglove.websocket.v1"}, &RestContext::open_foxglove);
}

void open_rosbridge(const CallPtr& call) {
  if (switched_on(call)) shake_hands(call, {}, &RestContext::open_rosbridge);
}

void get_tools(const CallPtr& call) {
  const ToolSwitch& tools = call->services.tools;
  call->respond(row_response({{"enabled", tools.on()},
                              {"foxglove", "/foxglove"},
                              {"rosbridge", "/rosbridge"},
                              {"foxglove_layout", "/foxglove-layout.json"},
                              {"etag", tools.tag()}}));
}

void set_tools(const CallPtr& call) {
  act_set_tools(call->services, asker_of(*call), field(*call, "enabled") == true, given_tag(*call),
                answer_with(call, [call](const Outcome&) { get_tools(call); }));
}

}  // namespace hoist::server::api
