// The standing notices that hold now (contract/notices.def), from every part of the server.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "server/jobs/jobs.hpp"
#include "server/link/core_desk.hpp"
#include "server/people/people_desk.hpp"
#include "server/record/recorder.hpp"

namespace hoist::server {

[[nodiscard]] std::vector<StandingNotice> standing_notices(const CoreDesk& core, const Recorder& recorder, const Jobs& jobs,
                                                           const PeopleDesk& people);
[[nodiscard]] nlohmann::json notices_json(const std::vector<StandingNotice>& notices);

}  // namespace hoist::server
