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
// {"ok": true} or the problem.
[[nodiscard]] OutcomeDone answer_done(const CallPtr& call);
// Who this call speaks for; gives the session its number on first use.
[[nodiscard]] Asker asker_of(const Call& call);
// The lease epoch of X-Hoist-Lease, else the current one. Nothing when the header is not a number.
[[nodiscard]] std::optional<std::uint32_t> lease_header(const Call& call);
// The asker with that epoch; nothing after a refusal.
[[nodiscard]] std::optional<Asker> driver(const CallPtr& call, bool header_required = false);
// A field of the body, null when it is not there.
[[nodiscard]] const nlohmann::json& field(const Call& call, const char* name);

// As in_background, and notes in the audit who asked for `action` and what came of it.
void audited_in_background(const CallPtr& call, const char* action, std::optional<db::SessionId> session,
                           std::function<Response(Records&)> work);

}  // namespace hoist::server
