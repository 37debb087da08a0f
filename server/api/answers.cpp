#include "server/api/answers.hpp"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "server/state/views.hpp"

namespace hoist::server {

Problem problem_of(const Outcome& outcome) {
  Problem problem;
  problem.detail = outcome.detail;
  problem.errors = outcome.errors;
  problem.refusals = outcome.refusals;
  const auto says = [&problem](Reason reason) {
    problem.name = reason_name(reason);
    std::ranges::replace(problem.name, '_', '-');
    problem.title = kReasons[static_cast<std::size_t>(reason)].text_en;
  };
  switch (outcome.kind) {
    case Outcome::Kind::refused:
      problem.status = 409;
      problem.name = "refused";
      problem.title = "Refused";
      if (outcome.reason) says(*outcome.reason);
      // As the router answers: waiting or taking control would not help.
      if (outcome.reason == Reason::role || std::ranges::find(outcome.refusals, "not_allowed") != outcome.refusals.end()) {
        problem.status = 403;
        says(Reason::role);
      }
      break;
    case Outcome::Kind::invalid:
      problem.status = 422;
      problem.name = "invalid";
      problem.title = "A value cannot be used";
      break;
    case Outcome::Kind::unknown:
      problem.status = 404;
      problem.name = "unknown";
      problem.title = "There is no such thing";
      break;
    case Outcome::Kind::outdated:
      problem.status = 412;
      says(Reason::changed_meanwhile);
      break;
    default:
      problem.status = 503;
      problem.name = "no-core";
      problem.title = "The control core does not answer";
      if (outcome.reason) says(*outcome.reason);
      if (outcome.reason == Reason::disk_full) problem.status = 507;
      break;
  }
  return problem;
}

Response store_error(const db::Error& error, std::string_view path) {
  using db::ErrorKind;
  Problem problem{.status = 503, .name = "storage", .title = "The database does not answer", .detail = error.message};
  if (error.kind == ErrorKind::busy) problem.name = "busy";
  if (error.kind == ErrorKind::disk_full) {
    problem.status = 507;
    problem.name = "disk-full";
  }
  if (error.kind == ErrorKind::not_found)
    problem = {.status = 404, .name = "unknown", .title = "There is no such thing", .detail = error.message};
  if (error.kind == ErrorKind::wrong_state) problem = {.status = 409, .name = "not-now", .title = "Not now", .detail = error.message};
  if (error.kind == ErrorKind::bad_value) {
    problem = {.status = 422, .name = "invalid", .title = "A value cannot be used", .detail = error.message};
    problem.errors.push_back({error.field, error.message});
  }
  return problem_response(problem, path);
}

Response no_database(const std::string& why, std::string_view path) {
  return problem_response({.status = 503, .name = "storage", .title = "The database cannot be opened", .detail = why}, path);
}

OutcomeDone answer_with(const CallPtr& call, std::function<void(const Outcome&)> answer) {
  return [call, answer = std::move(answer)](const Outcome& outcome) {
    if (outcome.done())
      answer(outcome);
    else
      call->fail(problem_of(outcome));
  };
}

OutcomeDone answer_done(const CallPtr& call) {
  return answer_with(call, [call](const Outcome& outcome) {
    nlohmann::json answer{{"ok", true}};
    if (outcome.stored) answer["stored"] = *outcome.stored;
    call->respond(answer);
  });
}

namespace {
KnownClient known_as(const Session& session, std::string address) {
  return {{session.user, std::string{access_role(session.role)}, "rest", client_name(session)}, session.display_name, std::move(address)};
}
}  // namespace

void tell_actor(Services& services, const Session& session) {
  if (const auto known = services.actors.known(session.client)) services.actors.update(session.client, known_as(session, known->address));
}

Asker asker_of(const Call& call) {
  Session& session = *call.session;
  ActorList& actors = call.services.actors;
  KnownClient known = known_as(session, call.request.address);
  if (session.client == 0) {
    session.client = actors.enter(std::move(known));
    session.number = std::shared_ptr<void>(nullptr, [&actors, client = session.client](void*) { actors.leave(client); });
  } else {
    actors.update(session.client, std::move(known));
  }
  if (!call.logged) call.logged = std::make_shared<bool>(false);
  const bool over = Auth::over(session, clocks_of(call.services.utc_ns(), call.services.now_ns()));
  return {session.client, call.services.core.lease_epoch(), session.role, over, call.logged};
}

std::optional<std::uint32_t> lease_header(const Call& call) {
  const std::string_view text = call.request.header("x-hoist-lease");
  if (text.empty()) return call.services.core.lease_epoch();
  std::uint32_t epoch = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), epoch);
  if (code != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return epoch;
}

std::optional<Asker> driver(const CallPtr& call, bool header_required) {
  const auto epoch = lease_header(*call);
  if (!epoch || (header_required && call->request.header("x-hoist-lease").empty())) {
    call->fail({.status = 409,
                .name = "refused",
                .title = "Refused",
                .detail = "Take control first (POST /api/v1/lease) and send its epoch as X-Hoist-Lease.",
                .refusals = {"no_lease"}});
    return std::nullopt;
  }
  Asker asker = asker_of(*call);
  call->session->used_ns = call->services.now_ns();
  asker.epoch = *epoch;
  return asker;
}

const nlohmann::json& field(const Call& call, const char* name) {
  static const nlohmann::json kNull;
  const auto at = call.body->find(name);
  return at == call.body->end() ? kNull : *at;
}

std::string parameters_tag(const Services& services) {
  return std::to_string(services.core.link().life()) + "-" + std::to_string(services.core.parameters().version);
}

Response parameters_changed(const Services& services, nlohmann::json values, const Outcome& outcome) {
  Response response = json_response(
      {{"version", services.core.parameters().version}, {"values", std::move(values)}, {"stored", outcome.stored.value_or(false)}});
  response.set("ETag", "\"" + parameters_tag(services) + "\"");
  return response;
}

}  // namespace hoist::server
