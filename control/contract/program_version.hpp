// Which source a program was built from; link hoist_program_version (deploy/cmake/program_version.cmake).
#pragma once
#include <cstddef>
#include <string_view>

namespace hoist::contract {

/// "0.1.0+b203cfc0a1b2": version of the project and commit, as semantic versioning writes build metadata. Ends with ".modified" when the tree
/// held changes beyond the commit; "0.1.0+unknown" when it was built without a git history. At most kProgramVersion_chars long.
std::string_view program_version();
inline constexpr std::size_t kProgramVersion_chars = 48;

}  // namespace hoist::contract
