// The words that HTTP has for a status.
#pragma once
#include <string_view>

namespace hoist::server {

[[nodiscard]] std::string_view reason_phrase(unsigned status);

}  // namespace hoist::server
