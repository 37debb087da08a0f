// /firmware: what programs the nodes run, and a new one for a node, through the running core.
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "control/contract/firmware_image.hpp"
#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"
#include "server/link/firmware_desk.hpp"
#include "server/state/views.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
json state_json(const FirmwareDesk& desk) {
  json nodes = json::array();
  for (std::size_t i = 0; i < contract::kRemoteNodeCount; ++i) {
    const NodeSaid& said = desk.said(static_cast<contract::Node>(i));
    json node{{"name", contract::kNodes[i].name},
              {"title", contract::kNodes[i].title},
              {"in_loader", nullptr},
              {"version", nullptr},
              {"crc", nullptr}};
    if (said.product) node["in_loader"] = (*said.product & contract::kLoaderProduct) != 0;
    // A node whose program knows nothing of versions answers 0.
    if (said.version && *said.version != 0) node["version"] = version_text(*said.version);
    if (said.crc && *said.crc != 0) {
      std::array<char, 9> text{};
      std::snprintf(text.data(), text.size(), "%08X", static_cast<unsigned>(*said.crc));
      node["crc"] = text.data();
    }
    nodes.push_back(std::move(node));
  }
  return {{"nodes", std::move(nodes)}, {"update", firmware_update_json(desk)}};
}

// "length: too short …" as the field and what is wrong with it.
Problem not_a_program(std::string_view text) {
  const std::size_t colon = text.find(':');
  return {.status = 422,
          .name = "invalid",
          .title = "This is no program for this node",
          .detail = std::string{text.substr(colon + 2)},
          .errors = {{std::string{text.substr(0, colon)}, std::string{text.substr(colon + 2)}}}};
}
}  // namespace

void get_firmware(const CallPtr& call) { call->respond(state_json(call->services.firmware)); }

void update_firmware(const CallPtr& call) {
  Services& services = call->services;
  std::optional<contract::Node> node;
  for (std::size_t i = 0; i < contract::kRemoteNodeCount; ++i)
    if (contract::kNodes[i].name == call->path_values.at(0)) node = static_cast<contract::Node>(i);
  if (!node) {
    call->fail({.status = 404, .name = "unknown", .title = "There is no such node", .detail = "GET /api/v1/firmware lists them."});
    return;
  }
  const auto force = call->request.query.find("force");
  if (force != call->request.query.end() && force->second != "0" && force->second != "1") {
    call->fail(not_a_program("force: must be 0 or 1"));
    return;
  }
  std::vector<std::uint8_t> image(call->request.body.begin(), call->request.body.end());
  contract::ImageError error = contract::check_image_file(image);
  if (error == contract::ImageError::none &&
      contract::read_image_header(image).kind != static_cast<std::uint8_t>(contract::kNodes[static_cast<std::size_t>(*node)].kind))
    error = contract::ImageError::kind;
  if (error != contract::ImageError::none) {
    services.counters.add(Count::http_refused_body);
    call->fail(not_a_program(contract::image_error_text(error)));
    return;
  }
  const auto asker = driver(call);
  if (!asker) return;
  if (services.firmware.busy()) {
    call->fail(
        {.status = 409, .name = "busy", .title = "Another update is under way", .detail = "Wait for its end: GET /api/v1/firmware."});
    return;
  }
  act_update_firmware(services, *asker, std::move(image), *node, force != call->request.query.end() && force->second == "1",
                      [call](const Outcome& outcome) {
                        if (outcome.done())
                          call->respond(state_json(call->services.firmware), 202);
                        else
                          call->fail(problem_of(outcome));
                      });
}

}  // namespace hoist::server::api
