// From a request to its handler, through the table of routes: host, route, session, origin, body, role, in this order.
#pragma once
#include <functional>

#include "server/http/exchange.hpp"
#include "server/services.hpp"

namespace hoist::server {

// Answers exactly once, now or later, on the network thread.
void dispatch(Services& services, Request request, std::function<void(Response)> answer);

}  // namespace hoist::server
