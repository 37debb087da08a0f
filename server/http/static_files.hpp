// The built console from its folder. Names that carry a hash never change and are kept by the browser; everything else is asked for again.
#pragma once
#include <filesystem>

#include "server/http/exchange.hpp"

namespace hoist::server {

// 200, 304 or 404. Never leaves `folder`, whatever the path says; sends NAME.gz when it lies beside NAME and the browser takes it.
[[nodiscard]] Response serve_static(const std::filesystem::path& folder, const Request& request);

}  // namespace hoist::server
