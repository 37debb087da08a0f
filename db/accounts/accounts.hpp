// The file of people: accounts, sign-ins, tokens and the audit log. One connection, one thread. It knows no passwords, only their hashes, and of
// secrets only their SHA-256 (as 64 hexadecimal digits).
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "db/store/result.hpp"

struct sqlite3;

namespace hoist::db {

/// "HPEO": in the file's header, so that it is not taken for another program's.
inline constexpr std::int64_t kAccountsApplicationId = 0x4850454F;
inline constexpr std::size_t kMaxUsers = 200, kMaxTokens = 200, kMaxUserName_bytes = 32, kMaxDisplayName_bytes = 64;
/// Ended sign-ins that stay known for STOP and for PINs.
inline constexpr std::size_t kEndedSignInsKept = 500;

struct User {
  std::int64_t id = 0;
  std::string name, display_name, role;
  bool enabled = true;
  std::string password_hash;
  std::optional<std::string> pin_hash;
};
/// What of a user may be changed; absent stays.
struct UserChange {
  std::optional<std::string> display_name, role, password_hash;
  std::optional<bool> enabled;
  std::optional<std::optional<std::string>> pin_hash;  ///< inner absent = take the PIN away
};
struct SignIn {
  std::string secret_sha256;
  std::string user, display_name, role, device;
  std::int64_t begun_s = 0, used_s = 0;
  bool ended = false;
  bool has_pin = false;
};
struct Token {
  std::int64_t id = 0;
  std::string secret_sha256, user, display_name;
  std::string role;  ///< of the user: a token can never do more
  std::string name, scope;
  std::int64_t created_s = 0, expires_s = 0;
};
struct AuditEntry {
  std::int64_t utc_ms = 0;
  std::uint64_t steady_ns = 0;
  std::string user, role, address, action, target;
  std::optional<std::string> before, after;
  std::string result;
};
struct AuditRow {
  std::int64_t id = 0;
  AuditEntry entry;
  std::string digest;
};
/// `first_wrong`: the number of the first row that was changed, or that follows a missing one; absent when the chain is whole.
struct AuditCheck {
  std::uint64_t rows = 0;
  std::optional<std::int64_t> first_wrong;
  std::string head;  ///< digest of the newest row: kept elsewhere, it proves that none was cut off
};

class Accounts {
 public:
  /// Opens or makes the file (mode 0600). Errors: foreign, newer_schema, corrupt, io, busy, disk_full.
  static Result<Accounts> open(const std::filesystem::path& file);
  /// Opens an existing file of the newest schema. Errors as above; io when there is none.
  static Result<Accounts> attach(const std::filesystem::path& file);
  /// What is stored now, from a disk that takes no writes: neither the file nor those beside it are written, and nothing can be changed. Only
  /// for a moment: another program's changes meanwhile are not seen. Errors as above; wrong_state for an older schema or an empty file.
  static Result<Accounts> read(const std::filesystem::path& file);

  Accounts(Accounts&&) noexcept;
  Accounts& operator=(Accounts&&) noexcept;
  ~Accounts();

  /// By name, those behind `after`; empty = from the first one on.
  Result<std::vector<User>> users(std::string_view after = {}, std::size_t limit = kMaxUsers) const;
  Result<std::optional<User>> find(std::string_view name) const;
  /// bad_value (name taken or ill-formed, display name, role), wrong_state (kMaxUsers).
  Status add(const User& user, std::int64_t now_s);
  /// not_found; wrong_state when no enabled engineer would remain. A new password takes the PIN away.
  Status change(std::string_view name, const UserChange& change);
  Result<bool> has_engineer() const;

  /// Ends the device's sign-in before: a browser has one.
  Status begin_sign_in(const SignIn& sign_in);
  Status use_sign_in(std::string_view secret_sha256, std::int64_t used_s);
  Status end_sign_in(std::string_view secret_sha256);
  /// All of a user but this one; their devices no longer count as ones on which the user has signed in. With an empty `but` the user's
  /// tokens go as well.
  Status end_sign_ins_of(std::string_view user, std::string_view but);
  /// All, newest use first, ended ones included.
  Result<std::vector<SignIn>> sign_ins() const;

  /// wrong_state (kMaxTokens), not_found (user). Returns its number.
  Result<std::int64_t> add_token(const Token& token);
  /// Oldest first, of enabled accounts, those with numbers above `after`; of this user only, unless empty.
  Result<std::vector<Token>> tokens(std::string_view user = {}, std::int64_t after = 0, std::size_t limit = kMaxTokens) const;
  /// Of this user only, unless empty. not_found.
  Status remove_token(std::int64_t id, std::string_view user);

  Status log(const AuditEntry& entry);
  /// Newest first, with numbers below `before`.
  Result<std::vector<AuditRow>> audit(std::optional<std::int64_t> before, std::size_t limit) const;
  Result<AuditCheck> check_audit() const;

 private:
  Accounts() = default;
  static Result<Accounts> open(const std::filesystem::path& file, bool create);
  sqlite3* handle_ = nullptr;
};

/// What add() refuses of a name, display name or role before it looks into the file: bad_value.
[[nodiscard]] Status check_user(const User& user);
/// Lower-case letters, digits and . _ - : 2 to kMaxUserName_bytes of them.
[[nodiscard]] bool is_user_name(std::string_view text);
/// SHA-256 as 64 hexadecimal digits.
[[nodiscard]] std::string sha256_hex(std::string_view bytes);

}  // namespace hoist::db
