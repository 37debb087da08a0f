// First set-up, and the way back after a lost password: a person at the hoist turns its configuration switch on and
// reads a code that the server prints (terminal, journal, display). Without both, no one becomes an engineer from the
// network. Network thread only.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace hoist::server {

inline constexpr std::uint64_t kSetUp_ns = 600'000'000'000;  // 10 minutes
inline constexpr int kSetUpTries = 5;

class SetUp {
 public:
  // `make_code`: eight digits; `show`: tells the person at the hoist.
  SetUp(std::function<std::string()> make_code, std::function<void(const std::string&)> show)
      : make_code_(std::move(make_code)), show_(std::move(show)) {}

  // `switch_on`: nothing while no control core is connected. A new code needs the switch turned off and on.
  void poll(std::uint64_t now_ns, std::optional<bool> switch_on) {
    const bool on = switch_on.value_or(false);
    if (on && !on_) {
      code_ = make_code_();
      until_ns_ = now_ns + kSetUp_ns;
      tries_ = 0;
      show_(code_);
    }
    if (!on || now_ns >= until_ns_) code_.clear();
    on_ = on;
  }
  [[nodiscard]] bool open() const { return !code_.empty(); }
  [[nodiscard]] bool switch_on() const { return on_; }
  [[nodiscard]] std::uint64_t seconds_left(std::uint64_t now_ns) const {
    return open() && until_ns_ > now_ns ? (until_ns_ - now_ns) / 1'000'000'000 : 0;
  }
  // Uses up one try, and the code when it is right; after the last one the switch must be turned off and on.
  [[nodiscard]] bool try_code(const std::string& code, const std::function<bool(const std::string&, const std::string&)>& same) {
    if (!open()) return false;
    const bool right = same(code, code_);
    if (right || ++tries_ >= kSetUpTries) code_.clear();
    return right;
  }

 private:
  std::function<std::string()> make_code_;
  std::function<void(const std::string&)> show_;
  std::string code_;
  std::uint64_t until_ns_ = 0;
  int tries_ = 0;
  bool on_ = false;
};

}  // namespace hoist::server
