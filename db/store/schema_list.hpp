// The SQL files of db/schema in order, built into the program (see db/CMakeLists.txt).
#pragma once
#include <span>
#include <string_view>

namespace hoist::db {

std::span<const std::string_view> schema_list();

}  // namespace hoist::db
