// Who asks the holder of the lease for it, oldest first. The lease itself is the core's; an ask changes nothing there.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace hoist::server {

class LeaseAsks {
 public:
  static constexpr std::size_t kMost = 8;
  static constexpr std::uint64_t kLife_ns = 60'000'000'000;

  struct Ask {
    std::uint32_t client = 0;
    std::uint64_t since_ns = 0;
  };

  // Once more is the same ask, for another minute. False: too many ask already.
  [[nodiscard]] bool add(std::uint32_t client, std::uint64_t now_ns) {
    const auto at = std::ranges::find(list_, client, &Ask::client);
    if (at == list_.end() && list_.size() >= kMost) return false;
    if (at != list_.end())
      at->since_ns = now_ns;
    else
      list_.push_back({client, now_ns});
    ++changes_;
    return true;
  }
  // It asks no longer.
  void remove(std::uint32_t client) {
    count(std::erase_if(list_, [client](const Ask& ask) { return ask.client == client; }));
  }
  // An ask may have come after `now_ns` was read.
  void expire(std::uint64_t now_ns) {
    count(std::erase_if(list_, [now_ns](const Ask& ask) { return now_ns >= ask.since_ns + kLife_ns; }));
  }
  // The holder keeps control.
  void refuse() {
    for (const Ask& ask : list_) refused_.push_back(ask.client);
    clear();
  }
  // Another holder, or none: nothing is asked of this one.
  void clear() { count(std::exchange(list_, {}).size()); }

  [[nodiscard]] const std::vector<Ask>& list() const { return list_; }
  [[nodiscard]] bool has(std::uint32_t client) const { return std::ranges::find(list_, client, &Ask::client) != list_.end(); }
  // Those who were refused since the last call.
  [[nodiscard]] std::vector<std::uint32_t> take_refused() { return std::exchange(refused_, {}); }
  [[nodiscard]] std::uint64_t changes() const { return changes_; }

 private:
  void count(std::size_t removed) {
    if (removed != 0) ++changes_;
  }

  std::vector<Ask> list_;
  std::vector<std::uint32_t> refused_;
  std::uint64_t changes_ = 0;
};

}  // namespace hoist::server
