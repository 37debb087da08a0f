// Passwords and PINs: what may be one, and Argon2id over them.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace hoist::server {

inline constexpr std::size_t kPasswordLeast = 12, kPasswordMost = 128, kPinLeast = 4, kPinMost = 8;

// What one hash costs. 64 MiB and 2 passes: libsodium's "interactive" limits, three times OWASP's floor of 19 MiB; 60 ms on a two-core computer.
struct HashLimits {
  unsigned long long passes = 2;
  std::size_t memory_bytes = 64U * 1024U * 1024U;
};

// Why this may not be the password of this user, in a sentence; empty when it may. Length and a list of common ones, no rules of composition
// (NIST SP 800-63B 5.1.1.2).
[[nodiscard]] std::string password_fault(std::string_view password, std::string_view user);
[[nodiscard]] std::string pin_fault(std::string_view pin);

// Argon2id with a new salt, as text that names its limits. Empty when the memory is not to be had.
[[nodiscard]] std::string hash_secret(std::string_view secret, const HashLimits& limits);
// In the time of one hash, whatever the result.
[[nodiscard]] bool secret_matches(std::string_view secret, const std::string& hash);

}  // namespace hoist::server
