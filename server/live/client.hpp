// One client that speaks hoist.v1 (contract/messages.def) over its WebSocket.
#pragma once
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "server/actions/actions.hpp"
#include "server/live/hub.hpp"
#include "server/ws/connection.hpp"

namespace hoist::server {

inline constexpr std::uint64_t kMessagesPerSecond = 60;

class Client final : public SocketConnection {
 public:
  Client(Hub& hub, std::unique_ptr<Stream> stream, SessionPtr session, std::uint32_t number, std::shared_ptr<void> seat);

  using SocketConnection::send;
  void send(const nlohmann::json& message);

  [[nodiscard]] std::uint32_t number() const { return number_; }
  [[nodiscard]] const SessionPtr& session() const { return session_; }
  [[nodiscard]] Hub& hub() const { return hub_; }
  [[nodiscard]] bool every_tick() const { return every_tick_; }
  void set_every_tick(bool on) { every_tick_ = on; }
  [[nodiscard]] bool holds_lease() const;

  // State of the drive handler: the hand, and when a refusal was last told.
  Hand hand;
  std::uint64_t drive_notice_ns = 0;

 private:
  void on_text(std::string text) override;
  void on_leave() override { hub_.remove(this); }

  Hub& hub_;
  SessionPtr session_;
  std::uint32_t number_;
  bool every_tick_ = false;
  std::uint64_t allowance_ = kMessagesPerSecond;
  std::uint64_t allowance_ns_;
};

// Handles one parsed message of a client (server/live/messages.cpp).
void handle_message(Client& client, const nlohmann::json& message, const std::optional<std::string>& repeated);

}  // namespace hoist::server
