#include "db/store/identity_key.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace hoist::db {
namespace {

constexpr std::size_t kNonce_bytes = crypto_aead_xchacha20poly1305_ietf_NPUBBYTES;
constexpr std::size_t kTag_bytes = crypto_aead_xchacha20poly1305_ietf_ABYTES;

bool ready() { return sodium_init() >= 0; }

std::string bound_to(std::int64_t row) { return "hoist patient identity " + std::to_string(row); }
const std::uint8_t* bytes_of(const std::string& text) { return reinterpret_cast<const std::uint8_t*>(text.data()); }

class File {
 public:
  File(const std::filesystem::path& path, int flags) : descriptor_(::open(path.c_str(), flags | O_CLOEXEC, 0600)) {}
  ~File() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  [[nodiscard]] int get() const { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace

IdentityKey::~IdentityKey() { sodium_memzero(bytes_.data(), bytes_.size()); }

std::optional<IdentityKey> IdentityKey::read(const std::filesystem::path& database) {
  if (!ready()) return std::nullopt;
  const File file(beside(database), O_RDONLY);
  IdentityKey key;
  std::uint8_t beyond = 0;
  const bool whole = file.get() >= 0 &&
                     ::read(file.get(), key.bytes_.data(), key.bytes_.size()) == static_cast<ssize_t>(key.bytes_.size()) &&
                     ::read(file.get(), &beyond, 1) == 0;
  return whole ? std::optional(key) : std::nullopt;
}

Result<IdentityKey> IdentityKey::make(const std::filesystem::path& database) {
  const std::filesystem::path target = beside(database);
  const std::filesystem::path fresh = target.string() + ".new";
  const auto failed = [&](const char* doing) {
    const int code = errno;
    ::unlink(fresh.c_str());
    return Error{
        code == ENOSPC ? ErrorKind::disk_full : ErrorKind::io, std::string(doing) + " " + target.string() + ": " + std::strerror(code), {}};
  };
  if (!ready()) return Error{ErrorKind::internal, "libsodium does not start", {}};
  IdentityKey key;
  randombytes_buf(key.bytes_.data(), key.bytes_.size());
  ::unlink(fresh.c_str());
  {
    const File file(fresh, O_WRONLY | O_CREAT | O_EXCL);
    if (file.get() < 0) return failed("making");
    // The umask takes bits away only; 0600 it is.
    if (::write(file.get(), key.bytes_.data(), key.bytes_.size()) != static_cast<ssize_t>(key.bytes_.size()) || ::fsync(file.get()) != 0)
      return failed("writing");
  }
  // link, not rename: an existing key is never replaced.
  if (::link(fresh.c_str(), target.c_str()) != 0) return failed("making");
  ::unlink(fresh.c_str());
  const File folder(target.has_parent_path() ? target.parent_path() : std::filesystem::path("."), O_RDONLY | O_DIRECTORY);
  if (folder.get() < 0 || ::fsync(folder.get()) != 0) return failed("syncing the folder of");
  return key;
}

IdentityKey::Id IdentityKey::id() const {
  // Keyed with the key itself: the number cannot be turned back into it. Of at least 16 bytes, as BLAKE2b wants.
  static constexpr std::string_view kContext = "hoist identity key";
  std::array<std::uint8_t, crypto_generichash_BYTES_MIN> digest{};
  crypto_generichash(digest.data(), digest.size(), reinterpret_cast<const std::uint8_t*>(kContext.data()), kContext.size(), bytes_.data(),
                     bytes_.size());
  Id id{};
  std::memcpy(id.data(), digest.data(), id.size());
  return id;
}

std::vector<std::uint8_t> IdentityKey::seal(std::int64_t row, const std::string& text) const {
  std::vector<std::uint8_t> out(kNonce_bytes + text.size() + kTag_bytes);
  randombytes_buf(out.data(), kNonce_bytes);
  const std::string bound = bound_to(row);
  crypto_aead_xchacha20poly1305_ietf_encrypt(out.data() + kNonce_bytes, nullptr, bytes_of(text), text.size(), bytes_of(bound), bound.size(),
                                             nullptr, out.data(), bytes_.data());
  return out;
}

std::optional<std::string> IdentityKey::open(std::int64_t row, ByteView sealed) const {
  if (sealed.size() < kNonce_bytes + kTag_bytes) return std::nullopt;
  std::string text(sealed.size() - kNonce_bytes - kTag_bytes, '\0');
  const std::string bound = bound_to(row);
  const int refused = crypto_aead_xchacha20poly1305_ietf_decrypt(reinterpret_cast<std::uint8_t*>(text.data()), nullptr, nullptr,
                                                                 sealed.data() + kNonce_bytes, sealed.size() - kNonce_bytes,
                                                                 bytes_of(bound), bound.size(), sealed.data(), bytes_.data());
  return refused == 0 ? std::optional(std::move(text)) : std::nullopt;
}

}  // namespace hoist::db
