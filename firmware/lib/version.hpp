// The version of the nodes' programs, as in object 100Ah; the same number as the project's in CMakeLists.txt (a test compares).
#pragma once
#include <string_view>

namespace hoist::firmware {

inline constexpr std::string_view kSoftwareVersion = "0.1.0";

}  // namespace hoist::firmware
