// What actions are made of, for the files of this folder.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/actions/action_table.hpp"
#include "server/actions/outcome.hpp"
#include "server/services.hpp"

namespace hoist::server {

// What the audit log says beside the action's name: nothing of a patient but numbers, and no secret.
struct AuditDetails {
  std::string target;  // what it is about
  std::optional<std::string> before = {}, after = {};
};
// Where every action begins, for every protocol: what the table says about role and sign-in holds, and `done` becomes one that also writes the
// audit log. False: `done` has been told.
[[nodiscard]] bool begin_action(Services& services, const Asker& asker, Action action, AuditDetails details, OutcomeDone& done);
// For an action that asks for more than its row says. False: `done` has been told.
[[nodiscard]] bool may(Services& services, const Asker& asker, contract::Role least, const OutcomeDone& done);
// All or nothing, by ids of parameters.
struct ValueSet {
  std::vector<std::pair<std::uint32_t, double>> rows;
  std::uint32_t version = 0;  // of the parameters it was made for; 0 = whichever are in force
  ChangeOrigin origin = {};
  double revert_after_s = 0;
};
void set_values(Services& services, const Asker& asker, ValueSet set, OutcomeDone done);
[[nodiscard]] Outcome store_outcome(const db::Error& error);
// On the recorder's thread; `work` is given a database that is open.
using StoreWork = std::function<db::Status(Records&, db::Database&)>;
void ask_store(Services& services, StoreWork work, OutcomeDone done);
// The same for work that has more to tell than done or not.
using StoreQuestion = std::function<Outcome(Records&, db::Database&)>;
void ask_store_for(Services& services, StoreQuestion work, OutcomeDone done);

}  // namespace hoist::server
