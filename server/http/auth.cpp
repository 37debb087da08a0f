#include "server/http/auth.hpp"

#include <fcntl.h>
#include <openssl/sha.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <utility>

namespace hoist::server {

namespace {
constexpr std::size_t kTokenBytes = 32;
constexpr std::size_t kLinkBytes = 24;

bool is_token(std::string_view text, std::size_t bytes) {
  return text.size() == 2 * bytes &&
         std::all_of(text.begin(), text.end(), [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

// Written beside the target and renamed, so that a reader never sees half of it; only we may read it.
bool write_private(const std::filesystem::path& file, std::string_view text, std::string& error) {
  const std::string fresh = file.string() + ".new";
  ::unlink(fresh.c_str());
  const int fd = ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (fd < 0) {
    error = "cannot write " + fresh + ": " + std::strerror(errno);
    return false;
  }
  const bool written = ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  ::close(fd);
  if (!written || ::rename(fresh.c_str(), file.c_str()) != 0) {
    error = "cannot write " + file.string() + ": " + std::strerror(errno);
    ::unlink(fresh.c_str());
    return false;
  }
  return true;
}

// The file is believed only when no other user could have read or written it.
std::optional<std::string> read_private(const std::filesystem::path& file) {
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (fd < 0) return std::nullopt;
  struct stat info {};
  std::string text;
  if (::fstat(fd, &info) == 0 && S_ISREG(info.st_mode) && info.st_uid == ::geteuid() && (info.st_mode & 0077) == 0 &&
      info.st_size < 65536) {
    text.resize(static_cast<std::size_t>(info.st_size));
    const ssize_t got = ::read(fd, text.data(), text.size());
    text.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  }
  ::close(fd);
  return text;
}
// Whether rewriting this file loses nothing but a token of ours: it is missing, empty or holds a token.
bool may_replace(const std::filesystem::path& file) {
  std::error_code none;
  const auto state = std::filesystem::symlink_status(file, none);
  if (none || !std::filesystem::exists(state)) return true;
  if (!std::filesystem::is_regular_file(state)) return false;
  std::ifstream in(file, std::ios::binary);
  if (!in) return false;
  std::string text(2 * kTokenBytes + 2, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (!text.empty() && text.back() == '\n') text.pop_back();
  return text.empty() || is_token(text, kTokenBytes);
}
}  // namespace

std::string random_hex(std::size_t bytes) {
  static constexpr std::string_view kDigits = "0123456789abcdef";
  std::string out;
  std::array<unsigned char, 64> raw{};
  while (bytes > 0) {
    const std::size_t want = std::min(bytes, raw.size());
    const ssize_t got = ::getrandom(raw.data(), want, 0);
    if (got <= 0) continue;  // interrupted before the pool was ready: getrandom has no other lasting failure
    for (std::size_t i = 0; i < static_cast<std::size_t>(got); ++i) {
      out.push_back(kDigits[raw[i] >> 4]);
      out.push_back(kDigits[raw[i] & 15]);
    }
    bytes -= static_cast<std::size_t>(got);
  }
  return out;
}

bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned char difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) difference = static_cast<unsigned char>(difference | (a[i] ^ b[i]));
  return difference == 0;
}

namespace {
// Where begin and last use of what comes from the disk are on the steady clock. False: they are ahead of the wall clock.
bool put_on_steady_clock(Session& session, Clocks now) {
  const auto steady_of = [now](std::uint64_t utc_s) {
    return now.steady_s - (utc_s < now.utc_s ? static_cast<std::int64_t>(now.utc_s - utc_s) : 0);
  };
  session.begun_s = steady_of(session.begun_utc_s);
  session.used_s = session.written_s = steady_of(session.used_utc_s);
  return std::max(session.begun_utc_s, session.used_utc_s) <= now.utc_s + kClockAhead_s;
}
}  // namespace

std::unique_ptr<Auth> Auth::create(Options options, Clocks now, std::string& error) {
  std::unique_ptr<Auth> auth(new Auth(std::move(options)));
  if (!auth->load(error)) return nullptr;
  for (auto it = auth->sessions_.begin(); it != auth->sessions_.end();) {
    const auto session = it++;
    if (!put_on_steady_clock(**session, now) || over(**session, now)) auth->end(session);
  }
  auth->link_ = random_hex(kLinkBytes);
  if (std::string refused; !auth->save(refused) && error.empty()) error = refused;
  return auth;
}

bool Auth::load(std::string& error) {
  bearer_ = std::make_shared<Session>();
  bearer_->bearer = true;
  if (!options_.token_file.empty()) {
    if (!may_replace(options_.token_file)) {
      error = options_.token_file.string() + " is not a token file of this program and stays as it is: name another file, or move it away";
      return false;
    }
    std::string token = read_private(options_.token_file).value_or("");
    while (!token.empty() && token.back() == '\n') token.pop_back();
    if (is_token(token, kTokenBytes)) bearer_->secret = token;
    std::string text = read_private(options_.token_file.string() + ".sessions").value_or("");
    std::string_view rest = text;
    while (!rest.empty() && sessions_.size() < kSessionLimit + kPastLimit) {
      const std::size_t end = rest.find('\n');
      const std::string_view line = rest.substr(0, end);
      rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
      const std::size_t space = line.find(' ');
      if (space == std::string_view::npos || !is_token(line.substr(0, space), kTokenBytes)) continue;
      auto session = std::make_shared<Session>();
      session->secret = std::string{line.substr(0, space)};
      const std::string_view number = line.substr(space + 1);
      if (std::from_chars(number.data(), number.data() + number.size(), session->used_utc_s).ec != std::errc{}) continue;
      sessions_.push_back(std::move(session));
    }
  }
  if (bearer_->secret.empty()) {
    bearer_->secret = random_hex(kTokenBytes);
    if (!options_.token_file.empty()) (void)write_private(options_.token_file, bearer_->secret + "\n", error);
  }
  return true;
}

bool Auth::save(std::string& error) const {
  if (options_.token_file.empty()) return true;
  std::string text;
  // A session that has ended is one that was used long ago.
  for (const SessionPtr& s : past_) text += s->secret + " 0\n";
  for (const SessionPtr& s : sessions_) text += s->secret + " " + std::to_string(s->used_utc_s) + "\n";
  return write_private(options_.token_file.string() + ".sessions", text, error);
}

bool Auth::host_allowed(std::string_view host) const {
  std::string_view name = host;
  if (!name.empty() && name.front() == '[') {
    const std::size_t close = name.find(']');
    if (close == std::string_view::npos) return false;
    const std::string_view port = name.substr(close + 1);
    if (!port.empty() && port.front() != ':') return false;
    name = name.substr(0, close + 1);
  } else {
    name = name.substr(0, name.find(':'));
  }
  const std::string_view port = host.substr(name.size());
  if (!port.empty() && (port.size() > 6 || !std::all_of(port.begin() + 1, port.end(), [](char c) { return c >= '0' && c <= '9'; })))
    return false;
  const auto equal = [name](std::string_view other) {
    return name.size() == other.size() && std::equal(name.begin(), name.end(), other.begin(), [](char a, char b) {
             const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; };
             return lower(a) == lower(b);
           });
  };
  if (equal("127.0.0.1") || equal("localhost") || equal("[::1]")) return true;
  return std::any_of(options_.hosts.begin(), options_.hosts.end(), [&equal](const std::string& h) { return equal(h); });
}

bool Auth::origin_matches(std::string_view origin, std::string_view host) const {
  const std::string_view scheme = options_.secure ? "https://" : "http://";
  return origin.size() == scheme.size() + host.size() && origin.starts_with(scheme) && origin.substr(scheme.size()) == host;
}

std::string_view Auth::cookie_name() const { return options_.secure ? "__Host-hoist_session" : "hoist_session"; }

std::string Auth::cookie_of(std::string_view secret) const {
  return std::string{cookie_name()} + "=" + std::string{secret} +
         "; Path=/; HttpOnly; SameSite=Strict; Max-Age=" + std::to_string(kCookieLife_s) + (options_.secure ? "; Secure" : "");
}

std::string digest_of_secret(std::string_view secret) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  ::SHA256(reinterpret_cast<const unsigned char*>(secret.data()), secret.size(), digest.data());
  std::string out;
  for (const unsigned char byte : digest) {
    std::array<char, 3> two{};
    std::snprintf(two.data(), two.size(), "%02x", byte);
    out += two.data();
  }
  return out;
}

std::string client_name(const Session& session) {
  if (session.token_id != 0) return "token-" + std::to_string(session.token_id);
  if (session.bearer) return "script";
  const std::string digest = session.account ? session.digest : digest_of_secret(session.secret);
  return "device-" + digest.substr(0, 8);
}

bool Auth::over(const Session& session, Clocks now) {
  if (session.ended) return true;
  if (session.token_id != 0) return now.utc_s >= session.expires_utc_s;
  if (!session.account) return !session.bearer && session.used_s + kSessionLife_s < now.steady_s;
  return now.steady_s >= session.begun_s + kAccountLife_s || (session.sockets == 0 && session.used_s + kAccountIdle_s < now.steady_s);
}

void Auth::add_account(SessionPtr session, Clocks now) {
  if (!put_on_steady_clock(*session, now)) session->ended = true;
  for (const SessionPtr& one : accounts_)
    if (one->device == session->device && one != session) one->ended = true;
  // One person does not push others out.
  std::size_t live = 1;
  for (auto one = accounts_.rbegin(); one != accounts_.rend(); ++one)
    if ((*one)->user == session->user && !(*one)->ended && ++live > kSignInsPerUser) (*one)->ended = true;
  accounts_.push_back(std::move(session));
  if (accounts_.size() <= kAccountSessionLimit) return;
  // Ended ones go before others.
  auto oldest = std::find_if(accounts_.begin(), accounts_.end(), [](const SessionPtr& one) { return one->ended; });
  if (oldest == accounts_.end()) oldest = accounts_.begin();
  (*oldest)->ended = true;
  accounts_.erase(oldest);
}
void Auth::add_token(SessionPtr session) { tokens_.push_back(std::move(session)); }
bool Auth::remove_token(std::int64_t id) {
  for (auto one = tokens_.begin(); one != tokens_.end(); ++one)
    if ((*one)->token_id == id) {
      (*one)->ended = true;
      tokens_.erase(one);
      return true;
    }
  return false;
}
void Auth::apply(std::string_view user, contract::Role role, std::string_view display_name, bool enabled) {
  for (auto* list : {&accounts_, &tokens_})
    for (const SessionPtr& one : *list) {
      if (one->user != user) continue;
      one->role = std::min(role, one->scope);
      one->display_name = display_name;
      if (!enabled) one->ended = true;
    }
}
void Auth::set_pin(std::string_view user, bool has_pin) {
  for (const SessionPtr& one : accounts_)
    if (one->user == user) one->has_pin = has_pin;
}
void Auth::end_accounts(std::string_view user, const Session* but) {
  for (const SessionPtr& one : accounts_) {
    if (one->user != user || one.get() == but) continue;
    one->ended = true;
    one->device.clear();
  }
  if (but != nullptr) return;
  for (const SessionPtr& one : tokens_)
    if (one->user == user) one->ended = true;
}

void Auth::end(std::list<SessionPtr>::iterator session) {
  past_.splice(past_.end(), sessions_, session);
  if (past_.size() > kPastLimit) past_.pop_front();
}

void Auth::use(Session& session, Clocks now) {
  session.used_utc_s = now.utc_s;
  session.used_s = now.steady_s;
  if (session.account) {
    if (session.bearer || session.ended || session.written_s + kAccountWrite_s > now.steady_s) return;
    session.written_s = now.steady_s;
    if (options_.used) options_.used(session);
    return;
  }
  if (session.bearer || session.written_s + kSessionWrite_s > now.steady_s) return;
  // Also when the file cannot be written: it is not tried at every use.
  session.written_s = now.steady_s;
  std::string ignored;
  static_cast<void>(save(ignored));
}

namespace {
// The value of this cookie in the rest of a cookie header, which it moves on; nothing when there is none left.
std::optional<std::string_view> next_cookie(std::string_view& rest, std::string_view name) {
  while (!rest.empty()) {
    const std::size_t end = rest.find(';');
    std::string_view pair = rest.substr(0, end);
    rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
    while (!pair.empty() && pair.front() == ' ') pair.remove_prefix(1);
    const std::size_t equals = pair.find('=');
    if (equals != std::string_view::npos && pair.substr(0, equals) == name) return pair.substr(equals + 1);
  }
  return std::nullopt;
}

// The person at this computer itself has no account.
SessionPtr only_from_here(SessionPtr session, const Request& request) {
  return session && (session->account || request.from_here) ? std::move(session) : nullptr;
}
}  // namespace

SessionPtr Auth::find_for_stop(const Request& request, Clocks now) {
  if (SessionPtr session = look_up(request, now)) return session;
  if (!request.header("authorization").empty()) return nullptr;
  std::string_view rest = request.header("cookie");
  while (const auto secret = next_cookie(rest, cookie_name())) {
    for (const SessionPtr& session : past_)
      if (same_secret(session->secret, *secret)) return session;
    const std::string digest = digest_of_secret(*secret);
    for (const SessionPtr& session : accounts_)
      if (session->digest == digest) return session;
  }
  return nullptr;
}

SessionPtr Auth::find(const Request& request, Clocks now) { return only_from_here(look_up(request, now), request); }

SessionPtr Auth::token_of(std::string_view secret, Clocks now) const {
  if (same_secret(secret, bearer_->secret)) return bearer_;
  const std::string digest = digest_of_secret(secret);
  for (const SessionPtr& token : tokens_)
    if (token->digest == digest && !over(*token, now)) return token;
  return nullptr;
}

SessionPtr Auth::look_up(const Request& request, Clocks now) {
  const std::string_view authorization = request.header("authorization");
  if (!authorization.empty()) {
    const std::string_view token = server::bearer_token(authorization);
    return token.empty() ? nullptr : token_of(token, now);
  }
  std::string_view rest = request.header("cookie");
  while (const auto secret = next_cookie(rest, cookie_name())) {
    for (auto it = sessions_.begin(); it != sessions_.end(); ++it) {
      if (!same_secret((*it)->secret, *secret)) continue;
      if (over(**it, now)) {
        end(it);
        break;
      }
      use(**it, now);
      return *it;
    }
    const std::string digest = digest_of_secret(*secret);
    for (const SessionPtr& session : accounts_) {
      if (session->digest != digest || over(*session, now)) continue;
      use(*session, now);
      return session;
    }
  }
  return nullptr;
}

std::string Auth::device_of(const Request& request) const {
  std::string_view rest = request.header("cookie");
  while (const auto secret = next_cookie(rest, cookie_name())) {
    const std::string digest = digest_of_secret(*secret);
    for (const SessionPtr& session : accounts_)
      if (session->digest == digest) return session->device;
  }
  return {};
}

std::vector<SessionPtr> Auth::users_of(std::string_view device) const {
  std::vector<SessionPtr> out;
  if (device.empty()) return out;
  for (auto one = accounts_.rbegin(); one != accounts_.rend(); ++one) {
    const auto known = [&](const SessionPtr& newer) { return newer->user == (*one)->user; };
    if ((*one)->device == device && std::none_of(out.begin(), out.end(), known)) out.push_back(*one);
  }
  return out;
}

std::string Auth::issue_ticket(const SessionPtr& session, Clocks now) {
  std::string text = random_hex(kTokenBytes);
  tickets_.remove_if([&](const Ticket& one) { return one.until_s < now.steady_s || one.session.expired(); });
  if (tickets_.size() >= kTicketLimit) tickets_.pop_front();
  tickets_.push_back({digest_of_secret(text), session, now.steady_s + kTicketLife_s});
  return text;
}

bool Auth::use_ticket(std::string_view ticket, const Session& session, Clocks now) {
  const std::string digest = digest_of_secret(ticket);
  for (auto one = tickets_.begin(); one != tickets_.end(); ++one) {
    if (one->digest != digest) continue;
    const bool good = one->until_s >= now.steady_s && one->session.lock().get() == &session;
    tickets_.erase(one);
    return good;
  }
  return false;
}

SessionPtr Auth::find_token(const Request& request, Clocks now) const {
  const std::string_view authorization = request.header("authorization");
  std::string_view token = server::bearer_token(authorization);
  if (const auto given = request.query.find("token"); authorization.empty() && given != request.query.end()) token = given->second;
  if (token.empty()) return nullptr;
  return only_from_here(token_of(token, now), request);
}

SessionPtr Auth::use_link(std::string_view token, Clocks now) {
  if (!same_secret(token, link_)) return nullptr;
  link_ = random_hex(kLinkBytes);
  auto session = std::make_shared<Session>();
  session->secret = random_hex(kTokenBytes);
  session->used_utc_s = now.utc_s;
  session->used_s = session->written_s = now.steady_s;
  if (sessions_.size() >= kSessionLimit) end(sessions_.begin());
  sessions_.push_back(session);
  std::string error;
  // When the file cannot be written the session still works; it only ends with this process.
  if (!save(error)) return session;
  return session;
}

}  // namespace hoist::server
