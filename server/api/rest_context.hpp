// What every REST handler may use.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "server/api/trust.hpp"
#include "server/http/auth.hpp"
#include "server/http/static_files.hpp"
#include "server/services.hpp"
#include "server/stream/stream.hpp"

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

}  // namespace hoist::server
