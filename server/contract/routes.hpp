// Typed view of api.def, without the handlers: for OpenAPI and tests.
#pragma once
#include <array>
#include <string_view>

#include "control/contract/check.hpp"
#include "db/export/formats.hpp"
#include "server/contract/method.hpp"

namespace hoist::server {

enum class Access : std::uint8_t { open, viewer, therapist, engineer };
constexpr std::string_view access_name(Access access) {
  constexpr std::array<std::string_view, 4> kNames{"open", "viewer", "therapist", "engineer"};
  return kNames[static_cast<std::size_t>(access)];
}

struct Route {
  std::string_view operation;
  Method method;
  std::string_view path;
  Access access;
  unsigned success;
  std::string_view errors;
  std::string_view request;
  std::string_view response;
  std::string_view summary;
};
constexpr bool body_may_be_empty(const Route& route) {
  return route.request == "Empty" || route.request == "LeaseRequest" || route.request == "KeepRequest" ||
         route.request == "AcknowledgeRequest";
}
// STOP is never refused, so its body is not checked.
constexpr bool takes_body(const Route& route) { return !route.request.empty() && route.operation != "stop"; }
struct RouteInput {
  std::string_view operation;
  std::string_view name;
  std::string_view type;     // of a query field; empty for a header
  std::string_view allowed;  // of a query field: "1..200", "a|b", or nothing
  bool required;
  std::string_view summary;
};

#define HOIST_ROUTE(...)
#define HOIST_QUERY(...)
#define HOIST_HEADER(...)
inline constexpr std::array kRoutes{
#undef HOIST_ROUTE
#define HOIST_ROUTE(operation, method, path, access, success, errors, request, response, summary) \
  Route{#operation, Method::method, path, Access::access, success, errors, request, response, summary},
#include "server/contract/api.def"
#undef HOIST_ROUTE
#define HOIST_ROUTE(...)
};
inline constexpr std::array kRouteInputs{
#undef HOIST_QUERY
#undef HOIST_HEADER
#define HOIST_QUERY(operation, name, type, allowed, summary) RouteInput{#operation, name, type, allowed, false, summary},
#define HOIST_HEADER(operation, name, required, summary) RouteInput{#operation, name, "", "", required, summary},
#include "server/contract/api.def"
};
#undef HOIST_ROUTE
#undef HOIST_QUERY
#undef HOIST_HEADER

static_assert(contract::unique_by(kRoutes, [](const Route& r) { return r.operation; }), "api.def: an operation is named twice");
static_assert(contract::all_rows(kRouteInputs,
                                 [](const RouteInput& input) {
                                   for (const Route& r : kRoutes)
                                     if (r.operation == input.operation) return true;
                                   return false;
                                 }),
              "api.def: an input belongs to no route");

// Whether a request may carry a key under which its answer is kept (server/api/idempotency.hpp).
constexpr bool takes_idempotency_key(const Route& route) {
  for (const RouteInput& input : kRouteInputs)
    if (input.operation == route.operation && input.name == "Idempotency-Key") return true;
  return false;
}
// What is made must not be made twice.
static_assert(contract::all_rows(kRoutes,
                                 [](const Route& r) {
                                   const bool makes = r.method == Method::post && (r.success == 201 || r.success == 202);
                                   return !makes || r.operation == "update_firmware" || takes_idempotency_key(r);
                                 }),
              "api.def: a route that makes something takes no Idempotency-Key");

// Whether a request must say which state it was made for (If-Match).
constexpr bool needs_tag(const Route& route) {
  for (const RouteInput& input : kRouteInputs)
    if (input.operation == route.operation && input.name == "If-Match") return input.required;
  return false;
}
// What acts on the hoist or on one's own sign-in as it is now: the newest counts, as of the messages of hoist.v1.
inline constexpr auto kActsNow = std::to_array<std::string_view>({"sign_out", "change_password", "change_pin", "set_time", "choose_patient",
                                                                  "choose_task", "choose_exercise", "choose_rehearsal", "pause_alarm",
                                                                  "release_lease", "withdraw_lease", "cancel_calibration", "cancel_job"});
constexpr bool acts_now(const Route& route) {
  for (const std::string_view operation : kActsNow)
    if (operation == route.operation) return true;
  return false;
}
// One rule for all that can be edited.
static_assert(contract::all_rows(kRoutes,
                                 [](const Route& r) {
                                   const bool edits = r.method == Method::patch || r.method == Method::put || r.method == Method::del;
                                   const bool told = r.errors.find("412") != r.errors.npos && r.errors.find("428") != r.errors.npos;
                                   return !edits || acts_now(r) ? !needs_tag(r) : needs_tag(r) && told;
                                 }),
              "api.def: what changes something that is stored needs If-Match, and tells 412 and 428");

}  // namespace hoist::server
