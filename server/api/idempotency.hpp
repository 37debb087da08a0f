// Idempotency-Key (draft-ietf-httpapi-idempotency-key-header): a request that is sent again after a lost answer gets that answer, and nothing is
// made twice. Only what succeeded is kept: after a refusal nothing was made, and trying again is safe.
#pragma once
#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <string>
#include <string_view>

#include "server/http/exchange.hpp"

namespace hoist::server {

// The key of the header's value, a string of RFC 8941 of 1 to 255 characters; nothing when it is none.
[[nodiscard]] std::optional<std::string> read_idempotency_key(std::string_view header);

class IdempotencyKeys {
 public:
  // More than connections may be open: one that runs is never forgotten.
  static constexpr std::size_t kMost = 256;
  static constexpr std::uint64_t kLife_ns = 3'600'000'000'000;
  // Longer answers are not kept.
  static constexpr std::size_t kAnswerMost_bytes = 65536;

  enum class State : std::uint8_t { fresh, running, other_request, answered };
  struct Found {
    State state = State::fresh;
    std::uint64_t ticket = 0;  // fresh: for end()
    Response answer = {};      // answered
  };
  // `owner`: keys of different people are different keys. `request`: a digest of all that the request says. A fresh key runs from here.
  [[nodiscard]] Found begin(std::string owner, std::string key, std::string request, std::uint64_t now_ns);
  void end(std::uint64_t ticket, const Response& answer);
  [[nodiscard]] std::size_t size() const { return kept_.size(); }

 private:
  struct Kept {
    std::uint64_t ticket = 0;
    std::string owner, key, request;
    std::uint64_t begun_ns = 0;
    std::optional<Response> answer;  // nothing: it runs
  };
  std::list<Kept> kept_;  // oldest first
  std::uint64_t last_ticket_ = 0;
};

}  // namespace hoist::server
