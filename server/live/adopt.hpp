// The hand-over of a socket from the HTTP side to the live side.
#pragma once
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <memory>

#include "server/live/hub.hpp"

namespace hoist::server {

// Answers the WebSocket handshake and keeps the socket as a client of the hub. `seat` is held for as long as the socket is open.
void adopt_socket(Hub& hub, boost::asio::ip::tcp::socket socket, boost::beast::http::request<boost::beast::http::string_body> request,
                  std::shared_ptr<LiveTicket> ticket, std::shared_ptr<void> seat);

}  // namespace hoist::server
