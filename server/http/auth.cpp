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

// Only a file that nobody else could have written or read is believed.
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
// Whether nothing but a token of ours is lost by writing this file anew: it is missing, empty or holds a token.
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

std::unique_ptr<Auth> Auth::create(Options options, std::uint64_t utc_s, std::string& error) {
  std::unique_ptr<Auth> auth(new Auth(std::move(options)));
  if (!auth->load(error)) return nullptr;
  for (auto it = auth->sessions_.begin(); it != auth->sessions_.end();) {
    const auto session = it++;
    if ((*session)->used_utc_s + kSessionLife_s < utc_s || (*session)->used_utc_s > utc_s + 3600) auth->end(session);
  }
  auth->link_ = random_hex(kLinkBytes);
  if (!auth->save(error)) return nullptr;
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
      session->written_utc_s = session->used_utc_s;
      sessions_.push_back(std::move(session));
    }
  }
  if (bearer_->secret.empty()) {
    bearer_->secret = random_hex(kTokenBytes);
    if (!options_.token_file.empty()) return write_private(options_.token_file, bearer_->secret + "\n", error);
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

std::string Auth::cookie_of(const Session& session) const {
  return std::string{cookie_name()} + "=" + session.secret +
         "; Path=/; HttpOnly; SameSite=Strict; Max-Age=" + std::to_string(kCookieLife_s) + (options_.secure ? "; Secure" : "");
}

std::string client_name(const Session& session) {
  if (session.bearer) return "script";
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  ::SHA256(reinterpret_cast<const unsigned char*>(session.secret.data()), session.secret.size(), digest.data());
  std::array<char, 9> text{};
  std::snprintf(text.data(), text.size(), "%02x%02x%02x%02x", digest[0], digest[1], digest[2], digest[3]);
  return "device-" + std::string(text.data());
}

void Auth::end(std::list<SessionPtr>::iterator session) {
  past_.splice(past_.end(), sessions_, session);
  if (past_.size() > kPastLimit) past_.pop_front();
}

void Auth::use(Session& session, std::uint64_t utc_s) {
  session.used_utc_s = utc_s;
  if (session.bearer || session.written_utc_s + kSessionWrite_s > utc_s) return;
  // Also when the file cannot be written: it is not tried at every use.
  session.written_utc_s = utc_s;
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
}  // namespace

SessionPtr Auth::find_for_stop(const Request& request, std::uint64_t utc_s) {
  if (SessionPtr session = find(request, utc_s)) return session;
  if (!request.header("authorization").empty()) return nullptr;
  std::string_view rest = request.header("cookie");
  while (const auto secret = next_cookie(rest, cookie_name()))
    for (const SessionPtr& session : past_)
      if (same_secret(session->secret, *secret)) return session;
  return nullptr;
}

SessionPtr Auth::find(const Request& request, std::uint64_t utc_s) {
  const std::string_view authorization = request.header("authorization");
  if (!authorization.empty()) {
    constexpr std::string_view kBearer = "Bearer ";
    if (!authorization.starts_with(kBearer) || !same_secret(authorization.substr(kBearer.size()), bearer_->secret)) return nullptr;
    return bearer_;
  }
  std::string_view rest = request.header("cookie");
  while (const auto secret = next_cookie(rest, cookie_name())) {
    for (auto it = sessions_.begin(); it != sessions_.end(); ++it) {
      if (!same_secret((*it)->secret, *secret)) continue;
      if ((*it)->used_utc_s + kSessionLife_s < utc_s) {
        end(it);
        break;
      }
      use(**it, utc_s);
      return *it;
    }
  }
  return nullptr;
}

SessionPtr Auth::find_token(const Request& request) {
  constexpr std::string_view kBearer = "Bearer ";
  std::string_view token = request.header("authorization");
  if (token.starts_with(kBearer)) {
    token.remove_prefix(kBearer.size());
  } else if (const auto given = request.query.find("token"); token.empty() && given != request.query.end()) {
    token = given->second;
  } else {
    return nullptr;
  }
  return same_secret(token, bearer_->secret) ? bearer_ : nullptr;
}

SessionPtr Auth::use_link(std::string_view token, std::uint64_t utc_s) {
  if (!same_secret(token, link_)) return nullptr;
  link_ = random_hex(kLinkBytes);
  auto session = std::make_shared<Session>();
  session->secret = random_hex(kTokenBytes);
  session->used_utc_s = session->written_utc_s = utc_s;
  if (sessions_.size() >= kSessionLimit) end(sessions_.begin());
  sessions_.push_back(session);
  std::string error;
  // When the file cannot be written the session still works; it only ends with this process.
  if (!save(error)) return session;
  return session;
}

}  // namespace hoist::server
