// What is wrong, in the order in which it is to be told.
#pragma once
#include <nlohmann/json.hpp>

#include "control/contract/signals.hpp"

namespace hoist::server {

/// The faults in force: what endangers the patient first, then what stopped the hoist, each followed by its consequences.
[[nodiscard]] nlohmann::json alarms_json(const contract::TickRecord& record);

}  // namespace hoist::server
