// A data set as the Brain Imaging Data Structure lays out motion data (BIDS 1.10, "Motion"): TSV files with JSON beside them.
// It holds patient codes and no free text that may name a person: no notes, no names of own lines, no user names.
#pragma once
#include <memory>
#include <vector>

#include "db/export/bundle_plan.hpp"
#include "db/store/database.hpp"

namespace hoist::db {

std::unique_ptr<BundlePlan> make_bids_plan(Database& database, const std::vector<SessionId>& sessions);

}  // namespace hoist::db
