// The head of a request, from what Beast's parser has read.
#pragma once
#include <boost/beast/http/message.hpp>
#include <string>
#include <string_view>

#include "server/http/exchange.hpp"

namespace hoist::server {

struct RequestHead {
  Request request;        // without address and body
  bool readable = false;  // its target
  bool version_10 = false;
  std::string_view fault;  // what makes it ambiguous, or nothing (header_fault)
};
/// `complete`: there is no body to come.
[[nodiscard]] RequestHead take_head(const boost::beast::http::request_header<>& message, bool complete);

}  // namespace hoist::server
