// One client that speaks hoist.v1 (contract/messages.def) over its WebSocket.
#pragma once
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "server/http/auth.hpp"
#include "server/services.hpp"
#include "server/ws/connection.hpp"

namespace hoist::server {

inline constexpr std::uint64_t kMessagesPerSecond = 60;

class Client;

// What a client needs of the hub that owns it.
class ClientOwner {
 public:
  [[nodiscard]] virtual Services& services() const = 0;
  // A session was used by a message.
  virtual void use(Session& session) = 0;
  virtual void remove(const Client* client) = 0;
  // Changes how often a client gets values, between two batches, so that it sees each step once.
  virtual void set_every_tick(Client& client, bool on) = 0;

 protected:
  ~ClientOwner() = default;
};

class Client final : public SocketConnection {
 public:
  Client(ClientOwner& hub, std::unique_ptr<Stream> stream, SessionPtr session, std::uint32_t number, std::shared_ptr<void> seat);

  using SocketConnection::send;
  void send(const nlohmann::json& message);

  [[nodiscard]] std::uint32_t number() const { return number_; }
  [[nodiscard]] const SessionPtr& session() const { return session_; }
  [[nodiscard]] ClientOwner& hub() const { return hub_; }
  [[nodiscard]] bool every_tick() const { return every_tick_; }
  void set_every_tick(bool on) { every_tick_ = on; }
  [[nodiscard]] bool holds_lease() const;

  // State of the drive handler: the newest sequence and when a refusal was last told.
  std::uint64_t drive_sequence = 0;
  std::uint64_t drive_notice_ns = 0;

 private:
  void on_text(std::string text) override;
  void on_leave() override { hub_.remove(this); }

  ClientOwner& hub_;
  SessionPtr session_;
  std::uint32_t number_;
  bool every_tick_ = false;
  std::uint64_t allowance_ = kMessagesPerSecond;
  std::uint64_t allowance_ns_;
};

// Handles one parsed message of a client (server/live/messages.cpp).
void handle_message(Client& client, const nlohmann::json& message, const std::optional<std::string>& repeated);

}  // namespace hoist::server
