// `hoist firmware update` and `list`: the parts that need a bus.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "control/contract/can_dictionary.hpp"

namespace hoist::tool {

/// Both print all messages and return the exit code of the program.
int update_node(const std::string& address, contract::Node node, const std::vector<std::uint8_t>& image, bool force);
int list_nodes(const std::string& address, bool json);

}  // namespace hoist::tool
