// gzip for JSON answers (RFC 9110, 8.4 and 12.5.3).
#pragma once
#include "server/http/exchange.hpp"

namespace hoist::server {

// Shorter bodies fit in one packet anyway.
inline constexpr std::size_t kCompressFrom_bytes = 1400;

// Compresses the body of a good JSON answer when the request accepts gzip; says in any case that the answer varies. Problems stay as they
// are: they repeat parts of the request (decision 53).
void compress_json(const Request& request, Response& response);

}  // namespace hoist::server
