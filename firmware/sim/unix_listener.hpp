// A listening Unix socket of this program.
#pragma once

#include <string>

namespace hoist::sim {

/// Listens at `path`, for this user only, with a socket of `type` (SOCK_STREAM, SOCK_SEQPACKET). A socket that no program answers on is
/// replaced; anything else there stays. Empty when `listener` is the descriptor, otherwise the sentence for people.
[[nodiscard]] std::string listen_at(const std::string& path, int type, int backlog, int& listener);

}  // namespace hoist::sim
