// A patient's figures, read one session after the other, so that the recorder stores what it has between two of them.
#pragma once
#include <functional>
#include <vector>

#include "db/summary/trend.hpp"
#include "server/api/answers.hpp"

namespace hoist::server::api {

/// Gives the entries of these sessions in their order, without those that were deleted meanwhile; or answers the call with what went wrong.
void read_trend(const CallPtr& call, std::vector<db::TrendSession> sessions, std::function<void(std::vector<db::TrendEntry>)> done);

}  // namespace hoist::server::api
