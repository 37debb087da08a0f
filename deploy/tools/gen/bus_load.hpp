// The load and response-time table as a page: written by hoist-gen, printed by `hoist bus load --markdown`.
#pragma once

#include <string>

namespace hoist::gen {

std::string bus_load_page();

}  // namespace hoist::gen
