// The files of db/tasks in the order of their names, built into the program (see db/CMakeLists.txt).
#pragma once
#include <span>
#include <string_view>

namespace hoist::db {

std::span<const std::string_view> task_list();

}  // namespace hoist::db
