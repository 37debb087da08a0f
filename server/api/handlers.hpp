// One function per row of api.def.
#pragma once
#include "server/api/call.hpp"

namespace hoist::server::api {

#define HOIST_ROUTE(operation, ...) void operation(const CallPtr& call);
#define HOIST_QUERY(...)
#define HOIST_HEADER(...)
#include "server/contract/api.def"
#undef HOIST_ROUTE
#undef HOIST_QUERY
#undef HOIST_HEADER

}  // namespace hoist::server::api
