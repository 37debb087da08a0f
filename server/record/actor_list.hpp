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

// The account of everybody, until there are user accounts.
inline constexpr const char* kLocalUser = "local";

// Any thread.
class ActorList {
 public:
  // Actors that stay known after their connection has ended: their last events reach the recorder later.
  static constexpr std::size_t kGoneKept = 256;

  // Numbers rise from `start`. A core that outlives a server must not take a new client for an old one, so it is random.
  explicit ActorList(std::uint32_t start) : last_(start) {}

  // The number of a new client; never used twice, never 0, which is the server itself.
  [[nodiscard]] std::uint32_t enter(db::Actor actor) {
    const std::lock_guard lock(mutex_);
    actors_.emplace(++last_, std::move(actor));
    return last_;
  }
  // The client has gone.
  void leave(std::uint32_t client) {
    const std::lock_guard lock(mutex_);
    gone_.push_back(client);
    if (gone_.size() <= kGoneKept) return;
    actors_.erase(gone_.front());
    gone_.pop_front();
  }
  [[nodiscard]] std::optional<db::Actor> find(std::uint32_t client) const {
    const std::lock_guard lock(mutex_);
    const auto at = actors_.find(client);
    return at == actors_.end() ? std::nullopt : std::optional(at->second);
  }

  // Known, and not gone.
  [[nodiscard]] bool is_here(std::uint32_t client) const {
    const std::lock_guard lock(mutex_);
    return actors_.contains(client) && std::ranges::find(gone_, client) == gone_.end();
  }
  // The newest client of this account that is still there.
  [[nodiscard]] std::optional<std::uint32_t> client_of(const std::string& user) const {
    const std::lock_guard lock(mutex_);
    for (auto at = actors_.rbegin(); at != actors_.rend(); ++at)
      if (at->second.user == user && std::ranges::find(gone_, at->first) == gone_.end()) return at->first;
    return std::nullopt;
  }

 private:
  mutable std::mutex mutex_;
  std::uint32_t last_;
  std::map<std::uint32_t, db::Actor> actors_;
  std::deque<std::uint32_t> gone_;
};

}  // namespace hoist::server
