// From a request to its handler, through the table of routes: host, route, session, origin, body, role, in this order. What is no route is a page.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "server/api/download_log.hpp"
#include "server/api/idempotency.hpp"
#include "server/api/rest_context.hpp"
#include "server/http/exchange.hpp"
#include "server/http/listener.hpp"
#include "server/http/static_files.hpp"

namespace hoist::server {

class Router final : public RequestHandler {
 public:
  // Reads the pages of `--web`.
  explicit Router(RestContext& rest);
  void handle(Request request, std::function<void(Response)> answer) override;
  // The newest step of the core; 1, before every step, while none is known.
  [[nodiscard]] std::uint64_t stamp() const override;
  [[nodiscard]] bool may_enter(const Request& request) override;
  // Of the audit log: what was downloaded in parts is told when it is over (download_log.hpp).
  void tell_downloads(std::uint64_t now_ns) { downloads_.tick(now_ns); }
  void tell_all_downloads() { downloads_.flush(); }

 private:
  RestContext& rest_;
  const StaticFiles pages_;
  IdempotencyKeys keys_;
  DownloadLog downloads_;
};

}  // namespace hoist::server
