#include "server/api/idempotency.hpp"

#include <algorithm>
#include <utility>

namespace hoist::server {

namespace {
constexpr std::size_t kKeyMost = 255;
}  // namespace

std::optional<std::string> read_idempotency_key(std::string_view header) {
  if (header.size() < 3 || header.front() != '"' || header.back() != '"') return std::nullopt;
  header = header.substr(1, header.size() - 2);
  std::string key;
  for (std::size_t i = 0; i < header.size(); ++i) {
    char c = header[i];
    if (c == '"' || c < 0x20 || c > 0x7e) return std::nullopt;
    if (c == '\\') {
      if (++i == header.size() || (header[i] != '"' && header[i] != '\\')) return std::nullopt;
      c = header[i];
    }
    key.push_back(c);
  }
  return key.size() <= kKeyMost ? std::optional(std::move(key)) : std::nullopt;
}

IdempotencyKeys::Found IdempotencyKeys::begin(std::string owner, std::string key, std::string request, std::uint64_t now_ns) {
  std::erase_if(kept_, [&](const Kept& one) { return one.answer && now_ns - one.begun_ns > kLife_ns; });
  const auto at = std::ranges::find_if(kept_, [&](const Kept& one) { return one.owner == owner && one.key == key; });
  if (at != kept_.end()) {
    if (at->request != request) return {.state = State::other_request};
    if (!at->answer) return {.state = State::running};
    return {.state = State::answered, .answer = *at->answer};
  }
  if (kept_.size() >= kMost) {
    const auto oldest = std::ranges::find_if(kept_, [](const Kept& one) { return one.answer.has_value(); });
    if (oldest == kept_.end()) return {.state = State::running};
    kept_.erase(oldest);
  }
  kept_.push_back({++last_ticket_, std::move(owner), std::move(key), std::move(request), now_ns, std::nullopt});
  return {.state = State::fresh, .ticket = last_ticket_};
}

void IdempotencyKeys::end(std::uint64_t ticket, const Response& answer) {
  const auto at = std::ranges::find(kept_, ticket, &Kept::ticket);
  if (at == kept_.end()) return;
  const bool whole = !answer.next_piece && answer.body.size() <= kAnswerMost_bytes;
  if (answer.status < 300 && whole)
    at->answer = answer;
  else
    kept_.erase(at);
}

}  // namespace hoist::server
