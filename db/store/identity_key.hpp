// The key of patients' identities, 32 bytes in FILE.key (mode 0600) beside the database. Without it the sealed rows are noise.
#pragma once
#include <sodium.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "db/codec/bytes.hpp"
#include "db/store/result.hpp"

namespace hoist::db {

class IdentityKey {
 public:
  using Id = std::array<std::uint8_t, 8>;
  static std::filesystem::path beside(const std::filesystem::path& database) { return database.string() + ".key"; }
  /// Nothing when there is no such file, or when it is no key.
  static std::optional<IdentityKey> read(const std::filesystem::path& database);
  /// Draws a key and stores it durably; an existing file stays and is an error.
  static Result<IdentityKey> make(const std::filesystem::path& database);

  IdentityKey(const IdentityKey&) = default;
  IdentityKey& operator=(const IdentityKey&) = delete;
  ~IdentityKey();

  /// Identifies the key without revealing it.
  [[nodiscard]] Id id() const;
  /// Nonce and ciphertext (XChaCha20-Poly1305). `row` is bound in: a sealed text cannot be moved to another patient.
  [[nodiscard]] std::vector<std::uint8_t> seal(std::int64_t row, const std::string& text) const;
  /// Nothing when it was sealed with another key or for another row, or is damaged.
  [[nodiscard]] std::optional<std::string> open(std::int64_t row, ByteView sealed) const;

 private:
  IdentityKey() = default;
  std::array<std::uint8_t, crypto_aead_xchacha20poly1305_ietf_KEYBYTES> bytes_{};
};

}  // namespace hoist::db
