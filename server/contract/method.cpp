#include "server/contract/method.hpp"

namespace hoist::server {

std::string_view method_name(Method method) {
  switch (method) {
    case Method::get:
      return "GET";
    case Method::head:
      return "HEAD";
    case Method::post:
      return "POST";
    case Method::put:
      return "PUT";
    case Method::patch:
      return "PATCH";
    case Method::del:
      return "DELETE";
    case Method::other:
      break;
  }
  return "OTHER";
}

Method parse_method(std::string_view text) {
  for (Method m : {Method::get, Method::head, Method::post, Method::put, Method::patch, Method::del})
    if (text == method_name(m)) return m;
  return Method::other;
}

}  // namespace hoist::server
