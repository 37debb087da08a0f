// The numbered files of db/accounts/schema, in order; db/CMakeLists.txt writes the definition.
#pragma once
#include <span>
#include <string_view>

namespace hoist::db {

std::span<const std::string_view> accounts_schema_list();

}  // namespace hoist::db
