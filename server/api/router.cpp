#include "server/api/router.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>

#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"
#include "server/api/lists.hpp"
#include "server/contract/audit.hpp"
#include "server/contract/fields.hpp"
#include "server/contract/routes.hpp"
#include "server/state/views.hpp"
#include "server/text/json_text.hpp"

namespace hoist::server {

namespace {
using Handler = void (*)(const CallPtr&);
constexpr std::array kHandlers{
#define HOIST_ROUTE(operation, ...) Handler{&api::operation},
#define HOIST_QUERY(...)
#define HOIST_HEADER(...)
#include "server/contract/api.def"
#undef HOIST_ROUTE
#undef HOIST_QUERY
#undef HOIST_HEADER
};
static_assert(kHandlers.size() == kRoutes.size());

// Takes the first segment off the path; nothing after the last one.
std::optional<std::string_view> next_segment(std::string_view& path, bool& more) {
  if (!more) return std::nullopt;
  const std::size_t slash = path.find('/');
  const std::string_view segment = path.substr(0, slash);
  more = slash != std::string_view::npos;
  path.remove_prefix(more ? slash + 1 : path.size());
  return segment;
}

// Whether `path` is an instance of the pattern; fills in what stood for the {…}.
bool matches(std::string_view pattern, std::string_view path, std::vector<std::string>& values) {
  values.clear();
  for (bool more_wanted = true, more_given = true;;) {
    const auto want = next_segment(pattern, more_wanted);
    const auto have = next_segment(path, more_given);
    if (!want || !have) return !want && !have;
    if (want->starts_with('{')) {
      if (have->empty()) return false;
      values.emplace_back(*have);
    } else if (*want != *have) {
      return false;
    }
  }
}

Problem problem(unsigned status, std::string name, std::string title, std::string detail) {
  return {.status = status, .name = std::move(name), .title = std::move(title), .detail = std::move(detail)};
}

Response link_page() {
  Response page;
  page.status = 401;
  page.content_type = "text/html; charset=utf-8";
  page.set("Cache-Control", "no-store");
  page.body =
      "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\"><title>Hoist</title>"
      "<h1>This link is used up</h1><p>Each link opens the console once. A fresh link stands in the terminal where Hoist was started: open "
      "that one.</p>"
      "<h1 lang=\"de\">Dieser Link ist verbraucht</h1><p lang=\"de\">Jeder Link öffnet die Konsole einmal. Ein neuer Link steht im "
      "Terminal, "
      "in dem Hoist gestartet wurde: bitte diesen öffnen.</p></html>";
  return page;
}

// These show a token in the address and take no cookie.
bool is_for_tools(std::string_view path) { return path == "/foxglove" || path == "/rosbridge"; }

// What other devices reach before there is an account: the set-up with what its page needs, and STOP of devices once signed in. Pages and the
// way to trust the hoist are no routes.
bool is_open_before_set_up(std::string_view operation) { return operation == "who_am_i" || operation == "set_up" || operation == "stop"; }

// GET /?token=…: trades a one-time link for a session cookie.
Response open_link(const RestContext& rest, const std::string& token) {
  Services& services = rest.services;
  const SessionPtr session = rest.auth.use_link(token, clocks_of(services.utc_ns(), services.now_ns()));
  if (!session) {
    services.counters.add(Count::http_refused_link);
    return link_page();
  }
  std::cout << "The link was used. For the next device:\nOpen " << rest.base_url << "/?token=" << rest.auth.link_token() << std::endl;
  Response response;
  response.status = 303;
  response.set("Location", "/");
  response.set("Cache-Control", "no-store");
  response.set("Set-Cookie", rest.auth.cookie_of(session->secret));
  return response;
}

bool is_json_type(std::string_view type) {
  return is_media_type(type, "application/json") || is_media_type(type, "application/merge-patch+json");
}

// Everything that can be refused before the handler. Nothing = go on.
std::optional<Problem> refuse(const Route& route, Call& call) {
  Services& services = call.services;
  Auth& auth = call.rest.auth;
  const Request& request = call.request;
  Counters& counters = services.counters;
  if (!request.from_here && services.needs_set_up && !is_open_before_set_up(route.operation)) {
    counters.add(Count::http_refused_no_session);
    return problem(403, "set-up-first", "The hoist has no accounts yet",
                   "Turn its configuration switch on, open the console and set it up.");
  }
  const bool open = route.access == Access::open;
  const bool unsafe = route.method != Method::get;
  if (open && !unsafe) return std::nullopt;
  const std::string_view origin = request.header("origin");
  // Tools run on pages of other makers and cannot set headers: they show a token in the address. No cookie counts for them, so that no foreign
  // page can borrow one, and their Origin says nothing.
  const bool tool = is_for_tools(route.path);
  if (!tool && !origin.empty() && !auth.origin_matches(origin, request.header("host"))) {
    counters.add(Count::http_refused_origin);
    return problem(403, "foreign-origin", "Another page tried to use this console", "Open the console itself and use it there.");
  }
  const bool stops = route.operation == "stop";
  const Clocks now = clocks_of(services.utc_ns(), services.now_ns());
  call.session = tool ? auth.find_token(request, now) : stops ? auth.find_for_stop(request, now) : auth.find(request, now);
  if (!call.session && !open) {
    counters.add(Count::http_refused_no_session);
    return problem(401, "no-session", "Not signed in",
                   "Sign in, open the link that the terminal shows, or send a token as Authorization: Bearer.");
  }
  // A lease lives by the use of its holder, not by other clients that share the token and only read.
  if (call.session && !request.header("x-hoist-lease").empty() && lease_header(call) == services.core.lease_epoch())
    call.session->used_ns = services.now_ns();
  if (!call.session || !call.session->bearer) {
    // A cookie is sent by the browser on its own; the header and the origin show that it was our page that asked.
    if (route.operation == "open_live" && origin.empty()) {
      counters.add(Count::http_refused_origin);
      return problem(403, "no-origin", "The request does not say which page it comes from",
                     "Use the console, or send the token as Authorization: Bearer.");
    }
    if (unsafe && request.header("x-hoist") != "1") {
      counters.add(Count::http_refused_origin);
      return problem(403, "no-x-hoist", "The header X-Hoist: 1 is missing", "Use the console, or send the token as Authorization: Bearer.");
    }
  }
  // A socket lives long after its handshake: a page that has the cookie must also have asked for this one.
  if (route.operation == "open_live" && call.session && call.session->account && !call.session->bearer) {
    const auto ticket = request.query.find("ticket");
    if (ticket == request.query.end() || !auth.use_ticket(ticket->second, *call.session, now))
      return problem(403, "no-ticket", "The connection needs a fresh ticket", "Ask for one (POST /api/v1/ws-ticket) and use it once.");
  }
  if (!open && static_cast<unsigned>(call.session->role) + 1U < static_cast<unsigned>(route.access))
    return problem(403, "role", "Your role may not do this", "Ask someone with the role " + std::string{access_name(route.access)} + ".");
  if (needs_tag(route) && request.header("if-match").empty())
    return problem(428, "if-match", "The change does not say what it was made for",
                   "Send the ETag that you were shown as If-Match; * stands for any ETag.");
  if (stops) {
    call.body = std::make_shared<const nlohmann::json>(nlohmann::json::object());
    return std::nullopt;
  }
  if (unsafe && call.session && !call.session->bearer && route.request.empty() && !request.header("content-type").empty() &&
      !is_json_type(request.header("content-type"))) {
    counters.add(Count::http_refused_body);
    return problem(415, "not-json", "The body must be JSON", "Send Content-Type: application/json.");
  }
  if (route.request.empty()) return std::nullopt;
  if (const std::string_view coding = request.header("content-encoding"); !coding.empty() && coding != "identity") {
    counters.add(Count::http_refused_body);
    return problem(415, "content-encoding", "The body is encoded", "Send it as it is, without Content-Encoding.");
  }
  if (route.request.find('/') != std::string_view::npos) {
    if (is_media_type(request.header("content-type"), route.request)) return std::nullopt;
    counters.add(Count::http_refused_body);
    return problem(415, "media-type", "The body is of another kind", "Send Content-Type: " + std::string{route.request} + ".");
  }
  const bool may_be_empty = body_may_be_empty(route);
  if (request.body.empty() && may_be_empty) {
    call.body = std::make_shared<const nlohmann::json>(nlohmann::json::object());
    return std::nullopt;
  }
  if (!is_json_type(request.header("content-type"))) {
    counters.add(Count::http_refused_body);
    return problem(415, "not-json", "The body must be JSON", "Send Content-Type: application/json.");
  }
  JsonError error;
  auto body = parse_json(request.body, error);
  if (!body || !body->is_object()) {
    counters.add(Count::http_refused_body);
    return problem(400, "bad-json", "The body cannot be read",
                   body ? "The body must be a JSON object." : "At byte " + std::to_string(error.position) + ": " + error.message + ".");
  }
  // Ending motion is never refused for the form of what does not matter to it.
  const bool ends_motion = route.operation == "set_mode" && body->value("mode", nlohmann::json()) == "standby";
  std::vector<FieldError> errors;
  if (!ends_motion) {
    errors = wrong_fields(route.request, *body);
    if (auto name = repeated_name(request.body)) errors.push_back({std::move(*name), "is given twice"});
  }
  if (!errors.empty()) {
    counters.add(Count::http_refused_body);
    Problem refused =
        problem(422, "invalid", "A field cannot be used", errors.front().field + " " + errors.front().message + "; nothing was done.");
    refused.errors = std::move(errors);
    return refused;
  }
  call.body = std::make_shared<const nlohmann::json>(std::move(*body));
  return std::nullopt;
}

// The query names the format and the columns; no token counts on these routes (decision 214).
std::string target_of(const Call& call, const Route& route) {
  const auto format = is_download(route) ? call.request.query.find("format") : call.request.query.end();
  return call.request.path + (format == call.request.query.end() ? "" : "?format=" + format->second.substr(0, 16));
}

std::string_view header_of(const Response& response, std::string_view name) {
  const auto at = std::ranges::find(response.headers, name, [](const auto& header) { return std::string_view(header.first); });
  return at == response.headers.end() ? std::string_view() : std::string_view(at->second);
}

void audit(const Call& call, const Route& route, const Response& response, DownloadLog& downloads) {
  // Those without a session log what they find out about the person themselves.
  if ((call.logged && *call.logged) || !call.session || route.access == Access::open) return;
  Services& services = call.services;
  db::AuditEntry entry{.utc_ms = services.utc_ns() / 1'000'000,
                       .steady_ns = services.now_ns(),
                       .user = call.session->user,
                       .role = std::string{access_role(call.session->role)},
                       .address = call.request.address,
                       .action = std::string{route.operation},
                       .target = target_of(call, route),
                       .before = {},
                       .after = {},
                       .result = std::to_string(response.status)};
  const std::string_view range = header_of(response, "Content-Range");
  if (is_download(route) && response.status == 206 && response.length) {
    const std::uint64_t of_bytes = api::number<std::uint64_t>(range.substr(range.rfind('/') + 1)).value_or(*response.length);
    downloads.part(std::move(entry), std::string{header_of(response, "ETag")}, *response.length, of_bytes, services.now_ns());
    return;
  }
  if (is_download(route) && response.status == 200 && response.length) entry.after = download_text(*response.length, *response.length, 1);
  services.people.log(std::move(entry));
}

// Whether the call is to run now. A key that was used before answers it here: with the same answer, or that it belongs to another request (422),
// or that the first one still runs (409).
bool goes_on_with_key(IdempotencyKeys& keys, const CallPtr& call, const Route& route) {
  const std::string_view header = call->request.header("idempotency-key");
  if (header.empty() || !takes_idempotency_key(route)) return true;
  auto key = read_idempotency_key(header);
  if (!key) {
    call->fail(problem(400, "idempotency-key", "The Idempotency-Key cannot be read",
                       "It is 1 to 255 printable characters in quotation marks, for example a UUID."));
    return false;
  }
  const auto found = keys.begin(call->session->user + " " + client_name(*call->session), std::move(*key),
                                digest_of_secret(std::string{route.operation} + " " + call->request.path + "\n" + call->request.body),
                                call->services.now_ns());
  switch (found.state) {
    case IdempotencyKeys::State::other_request:
      call->fail(problem(422, "idempotency-key-used", "This Idempotency-Key belongs to another request",
                         "Use a new key for a new request; nothing was done."));
      return false;
    case IdempotencyKeys::State::running:
      call->fail(problem(409, "idempotency-key-running", "The first request with this Idempotency-Key still runs",
                         "Wait a moment, then send it again."));
      return false;
    case IdempotencyKeys::State::answered:
      call->respond(found.answer);
      return false;
    case IdempotencyKeys::State::fresh:
      break;
  }
  call->on_answer = [&keys, ticket = found.ticket, then = std::move(call->on_answer)](const Response& answer) {
    keys.end(ticket, answer);
    if (then) then(answer);
  };
  return true;
}

// Whether the browser is told never to use plain HTTP for this name (RFC 6797). It believes that only once it trusts the authority. Not for
// localhost or a port beside 443, since it would hold for every port of the name, other programs' included; not for longer than a week,
// since a hoist with a new authority could not be reached, not even its plain page.
bool keeps_to_https(const RestContext& rest, const Request& request) {
  return rest.trust != nullptr && rest.trust->port == 443 && request.header("host") == rest.trust->name;
}
}  // namespace

Router::Router(RestContext& rest)
    : rest_(rest),
      pages_(rest.services.settings.web_dir),
      downloads_([&people = rest.services.people](db::AuditEntry entry) { people.log(std::move(entry)); }) {
  rest_.pages = &pages_;
}

std::uint64_t Router::stamp() const {
  const auto& newest = rest_.services.core.newest();
  return newest ? std::max<std::uint64_t>(newest->time_ns, 1) : 1;
}

bool Router::may_enter(const Request& request) {
  const Clocks now = clocks_of(rest_.services.utc_ns(), rest_.services.now_ns());
  const auto token = request.query.find("token");
  const bool link =
      request.from_here && request.path == "/" && token != request.query.end() && same_secret(token->second, rest_.auth.link_token());
  if (is_for_tools(request.path)) return rest_.auth.find_token(request, now) != nullptr;
  return link || rest_.auth.find_for_stop(request, now) != nullptr;
}

void Router::handle(Request request, std::function<void(Response)> answer) {
  Counters& counters = rest_.services.counters;
  counters.add(Count::http_requests);
  const bool head = request.method == Method::head;
  auto finish = [answer = std::move(answer), &counters, strict = keeps_to_https(rest_, request)](Response response) {
    if (response.status >= 400) counters.add(Count::http_refused);
    if (strict) response.set("Strict-Transport-Security", "max-age=604800");
    answer(std::move(response));
  };
  const std::string_view host = request.header("host");
  if (!rest_.auth.host_allowed(host)) {
    counters.add(Count::http_refused_host);
    finish(problem_response(problem(421, "host", "This name does not belong to the hoist", "Open the address that the terminal shows."),
                            request.path));
    return;
  }
  const Method method = head ? Method::get : request.method;
  const bool api_path = request.path == "/ws" || is_for_tools(request.path) || request.path == "/api" || request.path.starts_with("/api/");
  if (rest_.trust != nullptr && method == Method::get) {
    if (auto page = trust_answer(*rest_.trust, request.path)) {
      finish(std::move(*page));
      return;
    }
  }
  if (!api_path && method == Method::get) {
    const auto token = request.query.find("token");
    if (request.path == "/" && token != request.query.end() && !head && request.from_here)
      finish(open_link(rest_, token->second));
    else
      finish(pages_.serve(request));
    return;
  }
  std::vector<std::string> values;
  std::string allowed;
  for (std::size_t i = 0; i < kRoutes.size(); ++i) {
    const Route& route = kRoutes[i];
    if (!matches(route.path, request.path, values)) continue;
    if (route.method != method) {
      allowed += (allowed.empty() ? "" : ", ") + std::string{method_name(route.method)} + (route.method == Method::get ? ", HEAD" : "");
      continue;
    }
    auto call = std::make_shared<Call>(rest_, std::move(request), std::move(finish));
    call->path_values = std::move(values);
    if (const auto refused = refuse(route, *call)) {
      if (call->session && is_audited(route)) audit(*call, route, problem_response(*refused, call->request.path), downloads_);
      Response response = problem_response(*refused, call->request.path);
      if (refused->status == 401) response.set("WWW-Authenticate", "Bearer realm=\"Hoist\"");
      call->respond(std::move(response));
      return;
    }
    if (is_audited(route))
      call->on_answer = [this, call = call.get(), &route](const Response& response) { audit(*call, route, response, downloads_); };
    if (!goes_on_with_key(keys_, call, route)) return;
    try {
      kHandlers[i](call);
    } catch (const std::exception&) {
      // The call answers 500 by itself when the last hold on it goes.
    }
    return;
  }
  if (!allowed.empty() || !api_path) {
    counters.add(Count::http_refused_method);
    Response response = problem_response(
        problem(405, "method", "This cannot be done here", "Allowed: " + (allowed.empty() ? "GET, HEAD" : allowed) + "."), request.path);
    response.set("Allow", allowed.empty() ? "GET, HEAD" : allowed);
    finish(std::move(response));
    return;
  }
  counters.add(Count::http_refused_no_route);
  finish(problem_response(problem(404, "no-route", "There is no such address", "See /api/docs for what there is."), request.path));
}

}  // namespace hoist::server
