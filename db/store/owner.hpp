// Files that root makes for a service that runs as another user.
#pragma once
#include <filesystem>

#include "db/store/result.hpp"

namespace hoist::db {

/// As root: gives a file that was just made to the owner of `like`, or, when there is no such file, to the owner of the folder it lies in. Nothing
/// happens for another user, or to a link. Error: io.
Status give_to_owner(const std::filesystem::path& made, const std::filesystem::path& like = {});

}  // namespace hoist::db
