// How outcomes and store errors become REST answers.
#pragma once
#include <optional>
#include "db/store/result.hpp"
#include "server/actions/actions.hpp"
#include "server/api/call.hpp"

namespace hoist::server {

[[nodiscard]] Problem problem_of(const Outcome& outcome);
[[nodiscard]] Response store_error(const db::Error& error, std::string_view path);
[[nodiscard]] Response no_database(const std::string& why, std::string_view path);
// Gives a good outcome to `answer`, and any other as its problem.
[[nodiscard]] OutcomeDone answer_with(const CallPtr& call, std::function<void(const Outcome&)> answer);
// {"ok": true} or the problem.
[[nodiscard]] OutcomeDone answer_done(const CallPtr& call);
// Who this call speaks for; gives the session its number on first use. The number goes back when the sign-in or the token ends.
[[nodiscard]] Asker asker_of(const Call& call);
// After a change of role or name: what is told of a session that has a number.
void tell_actor(Services& services, const Session& session);
// The lease epoch of X-Hoist-Lease, else the current one. Nothing when the header is not a number.
[[nodiscard]] std::optional<std::uint32_t> lease_header(const Call& call);
// The asker with that epoch; nothing after a refusal.
[[nodiscard]] std::optional<Asker> driver(const CallPtr& call, bool header_required = false);
// The tag of the parameters in force, with the run of the core.
[[nodiscard]] std::string parameters_tag(const Services& services);
// Of a change of parameters that the core has taken, with the core's own numbers.
[[nodiscard]] Response parameters_changed(const Services& services, nlohmann::json values, const Outcome& outcome);
// A field of the body, null when it is not there.
[[nodiscard]] const nlohmann::json& field(const Call& call, const char* name);

}  // namespace hoist::server
