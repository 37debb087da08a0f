// /api/openapi.json and /api/docs.
#include <nlohmann/json.hpp>
#include <string>

#include "server/api/handlers.hpp"
#include "server/contract/openapi.hpp"
#include "server/contract/routes.hpp"

namespace hoist::server::api {

namespace {
// Of the built console: each route can be tried there.
constexpr const char* kPage = "/docs.html";

std::string escaped(std::string_view text) {
  std::string out;
  for (char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '&')
      out += "&amp;";
    else
      out.push_back(c);
  }
  return out;
}

// Without a console only the list.
Response plain_list() {
  std::string rows;
  for (const Route& r : kRoutes)
    rows += "<tr><td>" + std::string{method_name(r.method)} + "</td><td><code>" + escaped(r.path) + "</code></td><td>" +
            std::string{access_name(r.access)} + "</td><td>" + escaped(r.summary) + "</td></tr>\n";
  Response response;
  response.content_type = "text/html; charset=utf-8";
  response.body =
      "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\"><title>Hoist "
      "API</title>\n"
      "<h1>Hoist API</h1><p>The full description: <a href=\"/api/openapi.json\">/api/openapi.json</a> (OpenAPI 3.1). SI units, the unit is "
      "the end of each name.</p>\n"
      "<p>Scripts send <code>Authorization: Bearer TOKEN</code>; the token stands in the file given by --token-file. Errors are "
      "application/problem+json.</p>\n"
      "<table border=\"1\" cellpadding=\"4\"><tr><th>Method</th><th>Path</th><th>Least role</th><th>What it does</th></tr>\n" +
      rows + "</table></html>\n";
  return response;
}
}  // namespace

void get_openapi(const CallPtr& call) {
  static const std::string kText = openapi_document().dump();
  Response response;
  response.content_type = "application/json";
  response.body = kText;
  call->respond(std::move(response));
}

void get_docs(const CallPtr& call) {
  Request wanted;
  wanted.method = Method::get;
  wanted.path = kPage;
  if (call->rest.pages == nullptr) return call->respond(plain_list());
  Response page = call->rest.pages->serve(wanted);
  if (page.status != 200) return call->respond(plain_list());
  // Only the page: how long an answer of the API may be kept is Call's matter.
  Response response;
  response.content_type = std::move(page.content_type);
  response.body = std::move(page.body);
  call->respond(std::move(response));
}

}  // namespace hoist::server::api
