// gzip for JSON answers (RFC 9110, 8.4 and 12.5.3).
#pragma once
#include "server/http/exchange.hpp"

namespace hoist::server {

// Shorter bodies fit in one packet anyway.
inline constexpr std::size_t kCompressFrom_bytes = 1400;

// Compresses the body of a good JSON answer when the request accepts gzip, and marks its ETag; says in any case that the answer varies.
// Problems stay as they are: they repeat parts of the request (decision 53). For the network thread only.
void compress_json(const Request& request, Response& response);

// The strong entity tag of the same answer as gzip: other bytes need another tag (RFC 9110, 8.8.3).
[[nodiscard]] std::string gzip_etag(std::string_view etag);

}  // namespace hoist::server
