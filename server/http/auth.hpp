// Who a request comes from: sessions (cookie), bearer tokens for scripts, one-time links, and the Host and Origin
// checks. Accounts and their passwords are in people/; this keeps what a request shows of them. A user who can read
// this computer's terminal or token file is the engineer "local".
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "control/contract/params.hpp"
#include "server/http/exchange.hpp"

namespace hoist::server {

inline constexpr std::size_t kSessionLimit = 32;
// Half a day without use; an open WebSocket stays signed in.
inline constexpr std::int64_t kSessionLife_s = 12 * 3600;
// A session's last use is written down when the one on disk is older than this, so that a restarted server knows it, too.
inline constexpr std::int64_t kSessionWrite_s = 3600;
// Ended sessions that may still say STOP: at the patient's side there is no time to sign in first.
inline constexpr std::size_t kPastLimit = 32;
// How long a browser keeps the cookie: the most that browsers allow, since what it is good for is judged here.
inline constexpr std::uint64_t kCookieLife_s = 400 * 24 * 3600;
// A lease taken over REST is given back this long after the session last used it.
inline constexpr std::uint64_t kRestLease_ns = 10'000'000'000;

// An account's sign-in ends after a quarter of an hour without a request and without an open WebSocket, and after a working day.
inline constexpr std::int64_t kAccountIdle_s = 15 * 60, kAccountLife_s = 8 * 3600;
// A use of an account's sign-in is written down when the one on disk is older than this.
inline constexpr std::int64_t kAccountWrite_s = 60;
// A ticket opens one WebSocket, soon.
inline constexpr std::int64_t kTicketLife_s = 30;
inline constexpr std::size_t kTicketLimit = 64;
// Sign-ins of accounts in memory, ended ones included: the oldest use goes first.
inline constexpr std::size_t kAccountSessionLimit = 300, kSignInsPerUser = 20;

// What is on disk and begins or was used further ahead of the wall clock than this is over: the clock was wrong then, or is now.
inline constexpr std::uint64_t kClockAhead_s = 3600;

// Both clocks at one moment. How long a sign-in lasts is counted by the steady one, because the wall clock may be set meanwhile. The wall clock
// counts for what is on disk and for the expiry of a token, which is a date.
struct Clocks {
  std::uint64_t utc_s = 0;
  std::int64_t steady_s = 0;
};
[[nodiscard]] constexpr Clocks clocks_of(std::int64_t utc_ns, std::uint64_t steady_ns) {
  return {static_cast<std::uint64_t>(utc_ns / 1'000'000'000), static_cast<std::int64_t>(steady_ns / 1'000'000'000)};
}

struct Session {
  std::string secret;  // the cookie's value, or the bearer token; empty for an account's: only its digest is known
  std::string digest;  // SHA-256 of it, for accounts and their tokens
  bool bearer = false;
  bool account = false;        // of a person with an account, or of a token
  std::string user = "local";  // for signing in
  std::string display_name;    // as screens show it; empty for "local"
  bool has_pin = false;
  std::string device;                               // stays with a browser over its sign-ins
  std::int64_t token_id = 0;                        // of a token
  contract::Role scope = contract::Role::engineer;  // of a token: the most it may do
  std::uint64_t begun_utc_s = 0, used_utc_s = 0;    // begin and last use as on disk
  std::int64_t begun_s = 0, used_s = 0;             // the same on the steady clock, negative for what was before the computer's start
  std::int64_t written_s = 0;                       // the last use that is on disk, on the steady clock
  std::uint64_t expires_utc_s = 0;                  // of a token
  bool ended = false;                               // signed out, disabled, removed: may say STOP only
  std::size_t sockets = 0;                          // open WebSockets
  contract::Role role = contract::Role::engineer;
  std::uint32_t client = 0;           // number towards the core; 0 until it first asks the core for something
  std::shared_ptr<void> number = {};  // gives `client` back when it goes
  std::uint64_t used_ns = 0;          // last use of the lease
};
using SessionPtr = std::shared_ptr<Session>;
// The sign-in in words, the same over connections and restarts: "script", or "device-" and eight digits from which the secret cannot be found.
[[nodiscard]] std::string client_name(const Session& session);

class Auth {
 public:
  struct Options {
    std::filesystem::path token_file;  // empty = not written (tests)
    std::vector<std::string> hosts;    // further host names
    bool secure = false;               // reached by HTTPS only
    // An account's sign-in was used: to be written down. May be empty.
    std::function<void(const Session&)> used = {};
  };
  // Reads the token file's sessions of an earlier run so that a restarted server knows its people; makes a new token if there is none.
  // Null, with a sentence in `error`, for a file that is none of these. A disk that refuses is no reason not to start, because people of before
  // must be able to say STOP: then `error` says what is not written, and a new token is in no file.
  static std::unique_ptr<Auth> create(Options options, Clocks now, std::string& error);

  // Further names under which browsers may call, instead of those before.
  void set_hosts(std::vector<std::string> hosts) { options_.hosts = std::move(hosts); }
  [[nodiscard]] bool host_allowed(std::string_view host) const;
  // Exactly the origin that this request's own Host stands for.
  [[nodiscard]] bool origin_matches(std::string_view origin, std::string_view host) const;
  // Set-Cookie for a session. Under TLS no other name, path or plain page of this computer can set or read it (the prefix __Host-).
  [[nodiscard]] std::string cookie_of(std::string_view secret) const;

  // The session of a request: Authorization first, then the cookie. Null when there is none that is valid. Being found is a use: it puts the
  // session's end off. Link and token file are this computer's own: from elsewhere they do not count.
  [[nodiscard]] SessionPtr find(const Request& request, Clocks now);
  // Of a tool: a token, in ?token= or as Authorization; never a cookie.
  [[nodiscard]] SessionPtr find_token(const Request& request, Clocks now) const;
  // For STOP only: also a session that has ended, which stays so.
  [[nodiscard]] SessionPtr find_for_stop(const Request& request, Clocks now);
  // A session was used other than by a request.
  void use(Session& session, Clocks now);
  // Whether this session may do nothing but STOP any more.
  [[nodiscard]] static bool over(const Session& session, Clocks now);

  // A person has signed in; the sign-in before on the same device ends. Also for those known from before a restart.
  void add_account(SessionPtr session, Clocks now);
  void add_token(SessionPtr session);
  bool remove_token(std::int64_t id);
  // What was changed of an account holds for its sign-ins and tokens at once. Disabled: they end.
  void apply(std::string_view user, contract::Role role, std::string_view display_name, bool enabled);
  void set_pin(std::string_view user, bool has_pin);
  // Ends the sign-ins of a user, but for this one, and forgets that the user was on their devices; with null the tokens, too.
  void end_accounts(std::string_view user, const Session* but);
  void end_account(Session& session) { session.ended = true; }
  // The device whose cookie this request has, also after its sign-in has ended; empty = unknown.
  [[nodiscard]] std::string device_of(const Request& request) const;
  // The latest sign-in on it of each person, latest first.
  [[nodiscard]] std::vector<SessionPtr> users_of(std::string_view device) const;

  // A ticket for one WebSocket of this session.
  [[nodiscard]] std::string issue_ticket(const SessionPtr& session, Clocks now);
  [[nodiscard]] bool use_ticket(std::string_view ticket, const Session& session, Clocks now);

  // Uses up a link. The new session, or null for a bad or used token; `link_token()` is fresh afterwards.
  [[nodiscard]] SessionPtr use_link(std::string_view token, Clocks now);
  [[nodiscard]] const std::string& link_token() const { return link_; }
  [[nodiscard]] const std::string& bearer_token() const { return bearer_->secret; }
  // Calls `use(session)` for all that may hold a lease, those that have ended included.
  template <typename Use>
  void each_session(Use use) const {
    for (const auto* list : {&sessions_, &past_, &accounts_, &tokens_})
      for (const SessionPtr& session : *list) use(*session);
    use(*bearer_);
  }

 private:
  explicit Auth(Options options) : options_(std::move(options)) {}
  [[nodiscard]] std::string_view cookie_name() const;
  bool load(std::string& error);
  bool save(std::string& error) const;
  // Any request that shows a known secret, from anywhere.
  [[nodiscard]] SessionPtr look_up(const Request& request, Clocks now);
  [[nodiscard]] SessionPtr token_of(std::string_view secret, Clocks now) const;
  // The session can only say STOP from here.
  void end(std::list<SessionPtr>::iterator session);

  Options options_;
  SessionPtr bearer_;
  std::list<SessionPtr> sessions_;
  std::list<SessionPtr> past_;
  std::list<SessionPtr> accounts_;  // newest sign-in last
  std::list<SessionPtr> tokens_;
  struct Ticket {
    std::string digest;  // of its text
    std::weak_ptr<const Session> session;
    std::int64_t until_s = 0;  // steady clock
  };
  std::list<Ticket> tickets_;
  std::string link_;
};

// `bytes` random bytes from the kernel as lower-case hexadecimal.
[[nodiscard]] std::string random_hex(std::size_t bytes);
// Compares in a time that does not depend on where the texts differ.
[[nodiscard]] bool same_secret(std::string_view a, std::string_view b);
// SHA-256 as 64 hexadecimal digits.
[[nodiscard]] std::string digest_of_secret(std::string_view secret);

}  // namespace hoist::server
