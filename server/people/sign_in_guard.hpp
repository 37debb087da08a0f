// Slows guessing down, per account and per address: 1, 2, 4 … 60 s after each failure, and five failures a minute of
// one address. It never locks an account: an attacker who tries in the therapist's name must not keep the therapist
// out, so a browser on which a person has signed in before has a count of its own. Network thread only.
#pragma once
#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <string>

namespace hoist::server {

inline constexpr std::uint64_t kBackOffMost_s = 60, kAddressFailuresPerMinute = 5;
// A row of failures ends after so long without one: a typing error of last week costs nothing today.
inline constexpr std::uint64_t kBackOffForgets_s = 3600;
// Accounts and addresses that are remembered; the one whose latest failure is oldest is forgotten first.
inline constexpr std::size_t kGuardEntries = 1000;

class SignInGuard {
 public:
  // How long this attempt must wait, in whole seconds; 0 = now. Times are of the steady clock.
  [[nodiscard]] std::uint64_t wait_s(const std::string& account, const std::string& address, std::uint64_t now_ns) const {
    std::uint64_t until_ns = 0;
    if (const auto at = accounts_.find(account); at != accounts_.end())
      until_ns = at->second.last_ns +
                 kSecond_ns * std::min(kBackOffMost_s, std::uint64_t{1} << std::min<std::uint64_t>(at->second.failures - 1, 6));
    if (const auto at = addresses_.find(address); at != addresses_.end() && at->second.size() >= kAddressFailuresPerMinute)
      until_ns = std::max(until_ns, at->second[at->second.size() - kAddressFailuresPerMinute] + 60 * kSecond_ns);
    return until_ns > now_ns ? (until_ns - now_ns + kSecond_ns - 1) / kSecond_ns : 0;
  }
  [[nodiscard]] std::uint64_t failures(const std::string& account) const {
    const auto at = accounts_.find(account);
    return at == accounts_.end() ? 0 : at->second.failures;
  }
  // `forgets`: not for a PIN, whose few tries count however far apart they are.
  void failed(const std::string& account, const std::string& address, std::uint64_t now_ns, bool forgets = true) {
    Failures& one = accounts_[account];
    if (forgets && now_ns - one.last_ns > kBackOffForgets_s * kSecond_ns) one.failures = 0;
    ++one.failures;
    one.last_ns = now_ns;
    std::deque<std::uint64_t>& times = addresses_[address];
    times.push_back(now_ns);
    if (times.size() > kAddressFailuresPerMinute) times.pop_front();
    forget(accounts_, [](const Failures& failures) { return failures.last_ns; });
    forget(addresses_, [](const std::deque<std::uint64_t>& list) { return list.back(); });
  }
  // Takes back what was counted before the attempt.
  void succeeded(const std::string& account, const std::string& address) {
    accounts_.erase(account);
    take_back_address(address);
  }
  void forget(const std::string& account) { accounts_.erase(account); }
  // The attempt was not made after all.
  void take_back(const std::string& account, const std::string& address) {
    if (const auto at = accounts_.find(account); at != accounts_.end() && --at->second.failures == 0) accounts_.erase(at);
    take_back_address(address);
  }

 private:
  static constexpr std::uint64_t kSecond_ns = 1'000'000'000;
  void take_back_address(const std::string& address) {
    const auto at = addresses_.find(address);
    if (at == addresses_.end()) return;
    at->second.pop_back();
    if (at->second.empty()) addresses_.erase(at);
  }
  struct Failures {
    std::uint64_t failures = 0, last_ns = 0;
  };
  template <typename Map, typename Last>
  static void forget(Map& map, Last last) {
    if (map.size() <= kGuardEntries) return;
    map.erase(std::min_element(map.begin(), map.end(), [&](const auto& a, const auto& b) { return last(a.second) < last(b.second); }));
  }
  std::map<std::string, Failures> accounts_;
  std::map<std::string, std::deque<std::uint64_t>> addresses_;
};

}  // namespace hoist::server
