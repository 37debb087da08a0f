// Who may speak: sessions (cookie), one bearer token for scripts, one-time links, and the Host and Origin checks.
// Until users exist, whoever can read this computer's terminal or token file is the engineer.
#pragma once
#include <cstdint>
#include <filesystem>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/params.hpp"
#include "server/http/exchange.hpp"

namespace hoist::server {

inline constexpr std::size_t kSessionLimit = 32;
// A working day; nobody is logged out of a WebSocket that is already open.
inline constexpr std::uint64_t kSessionLife_s = 12 * 3600;
// A lease taken over REST is given back this long after the session's last request.
inline constexpr std::uint64_t kRestLease_ns = 10'000'000'000;

struct Session {
  std::string secret;  // the cookie's value, or the bearer token
  bool bearer = false;
  contract::Role role = contract::Role::engineer;
  std::uint64_t created_utc_s = 0;
  std::uint32_t client = 0;  // number towards the core; 0 until it first asks the core for something
  std::uint64_t used_ns = 0;
};
using SessionPtr = std::shared_ptr<Session>;

class Auth {
 public:
  struct Options {
    std::filesystem::path token_file;  // empty = not written (tests)
    std::vector<std::string> hosts;    // further host names
  };
  // Reads the token file's sessions of an earlier run so that a restarted server knows its people; makes a new token if there is none.
  // Errors are returned as a sentence in `error`; then nothing works.
  static std::unique_ptr<Auth> create(Options options, std::uint64_t utc_s, std::string& error);

  [[nodiscard]] bool host_allowed(std::string_view host) const;
  // Exactly the origin that this request's own Host stands for.
  [[nodiscard]] static bool origin_matches(std::string_view origin, std::string_view host);

  // The session of a request: Authorization first, then the cookie. Null when there is none that is valid.
  [[nodiscard]] SessionPtr find(const Request& request, std::uint64_t utc_s);
  // Uses up a link. The new session, or null for a bad or used token; `link_token()` is fresh afterwards.
  [[nodiscard]] SessionPtr use_link(std::string_view token, std::uint64_t utc_s);
  [[nodiscard]] const std::string& link_token() const { return link_; }
  [[nodiscard]] const std::string& bearer_token() const { return bearer_->secret; }
  [[nodiscard]] std::vector<SessionPtr> sessions() const;

 private:
  explicit Auth(Options options) : options_(std::move(options)) {}
  bool load(std::string& error);
  bool save(std::string& error) const;

  Options options_;
  SessionPtr bearer_;
  std::list<SessionPtr> sessions_;
  std::string link_;
};

// `bytes` random bytes from the kernel as lower-case hexadecimal.
[[nodiscard]] std::string random_hex(std::size_t bytes);
// Compares in a time that does not depend on where the texts differ.
[[nodiscard]] bool same_secret(std::string_view a, std::string_view b);

}  // namespace hoist::server
