// What actions are made of, for the files of this folder.
#pragma once
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "server/actions/outcome.hpp"
#include "server/services.hpp"

namespace hoist::server {

// The one place that enforces roles, for every protocol. False: `done` has been told.
[[nodiscard]] bool may(Services& services, const Asker& asker, contract::Role least, const OutcomeDone& done);
// All or nothing, by ids of parameters.
void set_values(Services& services, const Asker& asker, std::vector<std::pair<std::uint32_t, double>> rows, double revert_after_s,
                std::uint32_t version, OutcomeDone done);
[[nodiscard]] Outcome store_outcome(const db::Error& error);
// On the recorder's thread; `work` is given a database that is open.
using StoreWork = std::function<db::Status(Records&, db::Database&)>;
void ask_store(Services& services, StoreWork work, OutcomeDone done);
// The same for work that has more to tell than done or not.
using StoreQuestion = std::function<Outcome(Records&, db::Database&)>;
void ask_store_for(Services& services, StoreQuestion work, OutcomeDone done);

}  // namespace hoist::server
