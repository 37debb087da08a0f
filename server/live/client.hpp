// One client that speaks hoist.v1 (contract/messages.def) over its WebSocket.
#pragma once
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "server/actions/actions.hpp"
#include "server/http/auth.hpp"
#include "server/live/feed.hpp"
#include "server/services.hpp"
#include "server/ws/connection.hpp"

namespace hoist::server {

inline constexpr std::uint64_t kMessagesPerSecond = 60;

class Client;

// Where a client's values of an earlier connection end.
struct Resume {
  std::uint64_t last_tick = 0;
  std::string run;
};

// What a client needs of the hub that owns it.
class ClientOwner {
 public:
  [[nodiscard]] virtual Services& services() const = 0;
  // A session was used by a message.
  virtual void use(Session& session) = 0;
  virtual void remove(const Client* client) = 0;
  // Its sign-in has run out.
  [[nodiscard]] virtual bool over(const Session& session) const = 0;
  // Changes which values a client gets and how often, between two batches, so that it sees each step once. With `resume`, what it has missed
  // since comes first, or is named as missing.
  virtual void choose(Client& client, const StreamChoice& choice, const std::optional<Resume>& resume) = 0;

 protected:
  ~ClientOwner() = default;
};

class Client final : public SocketConnection {
 public:
  Client(ClientOwner& hub, std::unique_ptr<Stream> stream, SessionPtr session, std::uint32_t number, std::shared_ptr<void> seat);

  using SocketConnection::has_ended;
  using SocketConnection::send;
  void send(const nlohmann::json& message);

  [[nodiscard]] std::uint32_t number() const { return number_; }
  [[nodiscard]] const SessionPtr& session() const { return session_; }
  [[nodiscard]] ClientOwner& hub() const { return hub_; }
  [[nodiscard]] bool holds_lease() const;

  // What it has asked to see, and the feed that gives it that.
  StreamChoice asked;
  [[nodiscard]] const std::shared_ptr<Feed>& feed() const { return feed_; }
  // From the step after `newest` on.
  void follow(std::shared_ptr<Feed> feed, std::uint64_t newest);
  void show(const Feed::Batch& batch);
  // The steps that follow those shown are lost to every client.
  void show_lost(std::uint64_t to);
  // What waits or was dropped is told anew from another step on.
  void begin_anew();

  // State of the drive handler: the hand, and when a refusal was last told.
  Hand hand;
  std::uint64_t drive_notice_ns = 0;

 private:
  void on_text(std::string text) override;
  void on_leave() override { hub_.remove(this); }
  void on_dropped(const Steps& steps) override;
  SharedFrame before_telemetry() override;

  ClientOwner& hub_;
  SessionPtr session_;
  std::uint32_t number_;
  std::shared_ptr<Feed> feed_;
  std::uint64_t shown_to_ = 0;  // newest step that was shown or named as missing, or waits for that
  std::optional<Steps> dropped_;
  std::uint64_t allowance_ = kMessagesPerSecond;
  std::uint64_t allowance_ns_;
};

// Why a client gets no values of some steps.
enum class GapReason : std::uint8_t { slow_client, server_late, too_old, core_restarted };
// The message `gap`; `to` and `count` are not known of another core.
[[nodiscard]] nlohmann::json gap_json(std::uint64_t from, std::optional<std::uint64_t> to, std::optional<std::uint64_t> count,
                                      GapReason reason);

// Handles one parsed message of a client (server/live/messages.cpp).
void handle_message(Client& client, const nlohmann::json& message, const std::optional<std::string>& repeated);

}  // namespace hoist::server
