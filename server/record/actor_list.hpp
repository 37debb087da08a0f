// The actor behind each number that the core knows a client by. The core and its events have only the number; records and messages name the actor.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "db/store/session_types.hpp"

namespace hoist::server {

// The account of the person at this computer itself.
inline constexpr const char* kLocalUser = "local";

// Who is behind a number: the actor as records name it, the name that screens show (empty = none), and the address of the latest request.
struct KnownClient {
  db::Actor actor;
  std::string display_name = {}, address = {};
};

// Any thread.
class ActorList {
 public:
  // Actors that stay known after their connection has ended: their last events reach the recorder later.
  static constexpr std::size_t kGoneKept = 256;

  // Numbers rise from `start`. A core that outlives a server must not take a new client for an old one, so it is random.
  explicit ActorList(std::uint32_t start) : last_(start) {}

  // The number of a new client; never used twice, never 0, which is the server itself.
  [[nodiscard]] std::uint32_t enter(KnownClient client) {
    const std::lock_guard lock(mutex_);
    clients_.emplace(++last_, std::move(client));
    return last_;
  }
  // Something about a client has changed: its role, its name on screens, its address.
  void update(std::uint32_t number, KnownClient client) {
    const std::lock_guard lock(mutex_);
    if (const auto at = clients_.find(number); at != clients_.end()) at->second = std::move(client);
  }
  // Another name on screens for all clients of this account.
  void rename(const std::string& user, const std::string& display_name) {
    const std::lock_guard lock(mutex_);
    for (auto& [number, client] : clients_)
      if (client.actor.user == user) client.display_name = display_name;
  }
  // The client has gone.
  void leave(std::uint32_t client) {
    const std::lock_guard lock(mutex_);
    gone_.push_back(client);
    if (gone_.size() <= kGoneKept) return;
    clients_.erase(gone_.front());
    gone_.pop_front();
  }
  [[nodiscard]] std::optional<KnownClient> known(std::uint32_t client) const {
    const std::lock_guard lock(mutex_);
    const auto at = clients_.find(client);
    return at == clients_.end() ? std::nullopt : std::optional(at->second);
  }
  [[nodiscard]] std::optional<db::Actor> find(std::uint32_t client) const {
    const auto found = known(client);
    return found ? std::optional(found->actor) : std::nullopt;
  }
  [[nodiscard]] std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return clients_.size();
  }

  // Known, and not gone.
  [[nodiscard]] bool is_here(std::uint32_t client) const {
    const std::lock_guard lock(mutex_);
    return clients_.contains(client) && std::ranges::find(gone_, client) == gone_.end();
  }
  // The newest client of this account that is still there.
  [[nodiscard]] std::optional<std::uint32_t> client_of(const std::string& user) const {
    const std::lock_guard lock(mutex_);
    for (auto at = clients_.rbegin(); at != clients_.rend(); ++at)
      if (at->second.actor.user == user && std::ranges::find(gone_, at->first) == gone_.end()) return at->first;
    return std::nullopt;
  }

 private:
  mutable std::mutex mutex_;
  std::uint32_t last_;
  std::map<std::uint32_t, KnownClient> clients_;
  std::deque<std::uint32_t> gone_;
};

}  // namespace hoist::server
