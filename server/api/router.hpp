// From a request to its handler, through the table of routes: host, route, session, origin, body, role, in this order. What is no route is a page.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "server/api/idempotency.hpp"
#include "server/api/trust.hpp"
#include "server/http/auth.hpp"
#include "server/http/exchange.hpp"
#include "server/http/listener.hpp"
#include "server/http/static_files.hpp"
#include "server/services.hpp"

namespace hoist::server {

// Takes over a WebSocket of this session, from this address, whose handshake is done.
using OpenSocket = std::function<void(std::unique_ptr<Stream>, std::shared_ptr<void> seat, SessionPtr, const std::string& address)>;

// What REST needs besides the services of the actions.
struct RestContext {
  Services& services;
  Auth& auth;
  OpenSocket open_live, open_foxglove, open_rosbridge;
  std::string base_url = {};         // http://127.0.0.1:8080
  const TrustPage* trust = nullptr;  // of the hoist's own authority, if it has one
  const StaticFiles* pages = nullptr;
};

class Router final : public RequestHandler {
 public:
  // Reads the pages of `--web`.
  explicit Router(RestContext& rest) : rest_(rest), pages_(rest.services.settings.web_dir) { rest_.pages = &pages_; }
  void handle(Request request, std::function<void(Response)> answer) override;
  [[nodiscard]] bool may_enter(const Request& request) override;

 private:
  RestContext& rest_;
  const StaticFiles pages_;
  IdempotencyKeys keys_;
};

}  // namespace hoist::server
