// From a request to its handler, through the table of routes: host, route, session, origin, body, role, in this order. What is no route is a page.
#pragma once
#include <functional>

#include "server/http/exchange.hpp"
#include "server/http/static_files.hpp"
#include "server/services.hpp"

namespace hoist::server {

// Answers exactly once, now or later, on the network thread.
void dispatch(Services& services, const StaticFiles& pages, Request request, std::function<void(Response)> answer);

}  // namespace hoist::server
