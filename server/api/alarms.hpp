// What is wrong, in the order in which it is to be told.
#pragma once
#include "control/contract/signals.hpp"
#include "server/text/json_writer.hpp"

namespace hoist::server {

/// The faults in force: what endangers the patient first, then what stopped the hoist, each followed by its consequences.
void write_alarms(JsonWriter& out, const contract::TickRecord& record);

}  // namespace hoist::server
