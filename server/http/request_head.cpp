#include "server/http/request_head.hpp"

#include <boost/beast/websocket/rfc6455.hpp>
#include <optional>
#include <utility>

namespace hoist::server {
namespace {

std::string text_of(boost::beast::string_view text) { return {text.data(), text.size()}; }
std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + ('a' - 'A'));
  return text;
}

}  // namespace

RequestHead take_head(const boost::beast::http::request_header<>& message, bool complete) {
  RequestHead head;
  HeaderFields fields;
  for (const auto& field : message) fields.emplace_back(lower(text_of(field.name_string())), text_of(field.value()));
  head.version_10 = message.version() < 11;
  head.request.method = parse_method(text_of(message.method_string()));
  head.request.wants_upgrade = boost::beast::websocket::is_upgrade(message) && complete;
  std::string target = text_of(message.target());
  const std::optional<std::string> authority = take_authority(target);
  head.readable = parse_target(target, head.request);
  head.fault = header_fault(fields, head.version_10);
  for (auto& [name, value] : fields) {
    auto [at, fresh] = head.request.headers.try_emplace(std::move(name), value);
    if (!fresh) at->second.append(", ").append(value);
  }
  if (head.fault.empty() && !head.version_10 && !head.request.headers.contains("host"))
    head.fault = "HTTP/1.1 needs the header field Host.";
  // It counts instead of the field (RFC 9112, 3.2.2).
  if (authority) head.request.headers["host"] = *authority;
  return head;
}

}  // namespace hoist::server
