// How a tablet comes to trust the hoist's own certificate authority: a page with its fingerprint and the certificate to install. The same over
// HTTPS and on the plain port, which serves nothing else.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "server/http/auth.hpp"
#include "server/http/listener.hpp"

namespace hoist::server {

struct TrustPage {
  std::string name;         // hoist.local
  std::string fingerprint;  // of the authority, SHA-256
  std::string certificate;  // DER
  std::uint16_t port = 0;   // of HTTPS
};

// The page, its style and the certificate; nothing for any other address.
[[nodiscard]] std::optional<Response> trust_answer(const TrustPage& page, const std::string& path);

// The plain port: answers no method but GET and HEAD, reads no cookie and no body, and sends everything else to HTTPS.
class PlainDoor final : public RequestHandler {
 public:
  PlainDoor(const TrustPage& page, const Auth& auth, Counters& counters) : page_(page), auth_(auth), counters_(counters) {}
  void handle(Request request, std::function<void(Response)> answer) override;
  // No seat is reserved here: there is no sign-in, and STOP uses HTTPS.
  [[nodiscard]] bool may_enter(const Request&) override { return false; }

 private:
  [[nodiscard]] Response answer_to(const Request& request) const;

  const TrustPage& page_;
  const Auth& auth_;
  Counters& counters_;
};

}  // namespace hoist::server
