// Whether the server lives, by its heartbeat counter (hazard H21: 250 ms).
#pragma once
#include <cstdint>

#include "control/core/base/mutation.hpp"

namespace hoist::core {

class ServerWatch {
 public:
  enum class News : std::uint8_t { none, lost, restarted };

  /// `life` tells servers apart: 0 while none is attached, another number for each one that attaches.
  [[nodiscard]] News update(std::uint64_t heartbeat, std::uint64_t life = 0) noexcept {
    const std::uint64_t before = heartbeat_;
    const bool moved = known_ && heartbeat != before;
    const bool another = life != life_;
    // Of the last server that beat: one that begins at the count of the one before is told of when it beats.
    if (moved || !known_) life_ = life;
    heartbeat_ = heartbeat;
    known_ = true;
    if (moved) {
      const bool restarted = another || (alive_ && heartbeat < before);
      alive_ = true;
      seen_ = true;
      silent_ticks_ = 0;
      // The counter only rises while a server runs: this is a new server, and it has no driver.
      return restarted ? News::restarted : News::none;
    }
    if (!alive_ || ++silent_ticks_ < hold<contract::Fault::server_lost, "silence">(kSilentTicks)) return News::none;
    alive_ = false;
    return News::lost;
  }

  [[nodiscard]] bool alive() const noexcept { return alive_; }
  [[nodiscard]] bool seen() const noexcept { return seen_; }

 private:
  static constexpr std::uint32_t kSilentTicks = 25;

  std::uint64_t heartbeat_ = 0, life_ = 0;
  std::uint32_t silent_ticks_ = 0;
  bool known_ = false, alive_ = false, seen_ = false;
};

}  // namespace hoist::core
