// The certificate and key that the server shows, and what it agrees to: TLS 1.2 and 1.3, forward secrecy and authenticated ciphers only.
#pragma once
#include <filesystem>
#include <memory>
#include <string>

struct ssl_ctx_st;
struct ssl_st;

namespace hoist::server {

class TlsContext {
 public:
  // Reads a chain of certificates and its private key, both PEM. Null with a sentence in `error` when one cannot be read, when they do not
  // belong together, or when other users of this computer may read the key or change it.
  static std::unique_ptr<TlsContext> load(const std::filesystem::path& certificate, const std::filesystem::path& key, std::string& error);
  // New connections get what `fresh` has; those that are open keep theirs.
  void take(TlsContext&& fresh) { context_ = std::move(fresh.context_); }
  // The server's end of one connection on this socket, which stays its owner's.
  [[nodiscard]] ssl_st* accept(int socket) const;

 private:
  struct Free {
    void operator()(ssl_ctx_st* context) const;
  };
  std::unique_ptr<ssl_ctx_st, Free> context_;
};

}  // namespace hoist::server
