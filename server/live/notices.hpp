// The standing notices that hold now (contract/notices.def), from every part of the server.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "server/record/recorder.hpp"
#include "server/services.hpp"

namespace hoist::server {

[[nodiscard]] std::vector<StandingNotice> standing_notices(const Services& services);
[[nodiscard]] nlohmann::json notices_json(const std::vector<StandingNotice>& notices);

}  // namespace hoist::server
