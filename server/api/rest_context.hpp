// What every REST handler may use.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "server/api/trust.hpp"
#include "server/http/auth.hpp"
#include "server/services.hpp"
#include "server/stream/stream.hpp"

namespace hoist::server {

// Takes over a WebSocket whose handshake is done.
using OpenSocket = std::function<void(std::unique_ptr<Stream>, std::shared_ptr<void> seat, SessionPtr)>;

// What REST needs besides the services of the actions.
struct RestContext {
  Services& services;
  Auth& auth;
  OpenSocket open_live, open_foxglove, open_rosbridge;
  std::string base_url = {};         // http://127.0.0.1:8080
  const TrustPage* trust = nullptr;  // of the hoist's own authority, if it has one
};

}  // namespace hoist::server
