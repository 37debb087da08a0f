// The server's half of WebSocket's opening handshake (RFC 6455 section 4.2).
#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace hoist::server {

// The value of Sec-WebSocket-Accept for a Sec-WebSocket-Key; nothing when the key is not 16 bytes in base64.
[[nodiscard]] std::optional<std::string> websocket_accept(std::string_view key);
// Whether a list of names, separated by commas, holds this one (Sec-WebSocket-Protocol).
[[nodiscard]] bool offers(std::string_view protocols, std::string_view wanted);

}  // namespace hoist::server
