#include "db/accounts/accounts.hpp"

#include <fcntl.h>
#include <openssl/sha.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "db/accounts/schema_list.hpp"
#include "db/store/owner.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

constexpr int kBusyTimeout_ms = 2000;
constexpr const char* kUserColumns = "id, name, display_name, role, enabled, password_hash, pin_hash";

User user_at(const Statement& row) {
  return {row.integer_at(0),      row.text_at(1), row.text_at(2),         row.text_at(3),
          row.integer_at(4) != 0, row.text_at(5), row.optional_text_at(6)};
}

std::int64_t number_of(sqlite3* handle, const char* sql) {
  Statement statement(handle, sql);
  return statement.step() ? statement.integer_at(0) : 0;
}

Status check_display_name(std::string_view text) {
  const bool plain = std::none_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; });
  if (text.empty() || text.size() > kMaxDisplayName_bytes || !plain)
    return Error{ErrorKind::bad_value, "display_name must be one line of 1 to 64 bytes", "display_name"};
  return {};
}
Status check_role(std::string_view text) {
  if (text != "viewer" && text != "therapist" && text != "engineer")
    return Error{ErrorKind::bad_value, "role must be viewer, therapist or engineer", "role"};
  return {};
}

// Fields with their lengths, so that no two entries have the same bytes.
std::string digest_of(const AuditEntry& entry, std::string_view previous) {
  std::string bytes;
  const auto add = [&bytes](std::string_view text) { bytes.append(std::to_string(text.size())).append(":").append(text); };
  const auto add_optional = [&](const std::optional<std::string>& text) { text ? add(*text) : void(bytes += "-"); };
  add(previous);
  add(std::to_string(entry.utc_ms));
  add(std::to_string(entry.steady_ns));
  for (const std::string* text : {&entry.user, &entry.role, &entry.address, &entry.action, &entry.target}) add(*text);
  add_optional(entry.before);
  add_optional(entry.after);
  add(entry.result);
  return sha256_hex(bytes);
}

const std::string kNoPrevious(64, '0');

constexpr const char* kAuditColumns =
    "id, utc_ms, steady_ns, user, role, address, action, target, before, after, result, previous, digest FROM audit";
AuditRow audit_at(const Statement& row) {
  return {row.integer_at(0),
          {row.integer_at(1), row.unsigned_at(2), row.text_at(3), row.text_at(4), row.text_at(5), row.text_at(6), row.text_at(7),
           row.optional_text_at(8), row.optional_text_at(9), row.text_at(10)},
          row.text_at(12)};
}

// An empty file of mode 0600 where there is none, so that SQLite never makes one that others may read.
void make_private(const std::filesystem::path& file) {
  const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (fd < 0) return;  // SQLite says what is wrong
  (void)::fchmod(fd, 0600);
  ::close(fd);
  (void)give_to_owner(file);
}

}  // namespace

bool is_user_name(std::string_view text) {
  return text.size() >= 2 && text.size() <= kMaxUserName_bytes && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '_' || c == '-';
         });
}

std::string sha256_hex(std::string_view bytes) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  ::SHA256(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), digest.data());
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string out;
  for (const unsigned char byte : digest) {
    out.push_back(kDigits[byte >> 4]);
    out.push_back(kDigits[byte & 15]);
  }
  return out;
}

Accounts::Accounts(Accounts&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
Accounts& Accounts::operator=(Accounts&& other) noexcept {
  std::swap(handle_, other.handle_);
  return *this;
}
Accounts::~Accounts() { sqlite3_close_v2(handle_); }

Result<Accounts> Accounts::open(const std::filesystem::path& file) { return open(file, true); }
Result<Accounts> Accounts::attach(const std::filesystem::path& file) { return open(file, false); }

namespace {
void prepare(sqlite3* handle) {
  sqlite3_extended_result_codes(handle, 1);
  sqlite3_busy_timeout(handle, kBusyTimeout_ms);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  execute(handle, "PRAGMA foreign_keys = ON");
}
int newest_schema() { return static_cast<int>(accounts_schema_list().size()); }
Error older_schema(const std::filesystem::path& file) {
  return {ErrorKind::wrong_state, file.string() + " is an older file of accounts: let the server of this version open it first", {}};
}
// Its schema, of a file that is ours or empty.
int version_of(sqlite3* handle, const std::filesystem::path& file) {
  const std::int64_t id = number_of(handle, "PRAGMA application_id");
  const int version = static_cast<int>(number_of(handle, "PRAGMA user_version"));
  const bool empty = number_of(handle, "SELECT count(*) FROM sqlite_schema") == 0;
  if (id != kAccountsApplicationId && !empty)
    throw SqlFailure{Error{ErrorKind::foreign, file.string() + " is no file of accounts and stays as it is: choose another file", {}}};
  if (version > newest_schema())
    throw SqlFailure{Error{ErrorKind::newer_schema,
                           file.string() + " has schema " + std::to_string(version) + ", this program knows " +
                               std::to_string(newest_schema()) + ": use the newer program",
                           {}}};
  return version;
}
// The SQLite URI of an immutable file: SQLite then looks for neither a log nor locks.
std::string immutable_address(const std::filesystem::path& file) {
  std::string out = "file:";
  for (const char c : file.string()) {
    if (c == '%' || c == '?' || c == '#') {
      constexpr std::string_view kDigits = "0123456789ABCDEF";
      const auto byte = static_cast<unsigned char>(c);
      out.append({'%', kDigits[byte >> 4], kDigits[byte & 15]});
    } else {
      out += c;
    }
  }
  return out + "?immutable=1";
}
}  // namespace

Result<Accounts> Accounts::open(const std::filesystem::path& file, bool create) {
  return guarded([&]() -> Result<Accounts> {
    std::error_code none;
    if (create && !std::filesystem::exists(file, none)) make_private(file);
    Accounts accounts;
    const int code = sqlite3_open_v2(file.c_str(), &accounts.handle_, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, nullptr);
    if (code != SQLITE_OK) throw_sql(accounts.handle_, code, "opening " + file.string());
    sqlite3* handle = accounts.handle_;
    prepare(handle);
    execute(handle, "PRAGMA secure_delete = ON");
    const int version = version_of(handle, file), newest = newest_schema();
    if (!create && version != newest) return older_schema(file);
    // SQLite opens what it may not write for reading, without a word.
    if (sqlite3_db_readonly(handle, "main") == 1)
      return Error{ErrorKind::read_only, file.string() + " cannot be written: its storage is write-protected", {}};
    (void)::chmod(file.c_str(), 0600);
    if (number_of(handle, "PRAGMA application_id") != kAccountsApplicationId)
      execute(handle, ("PRAGMA application_id = " + std::to_string(kAccountsApplicationId)).c_str());
    execute(handle, "PRAGMA journal_mode = WAL");
    execute(handle, "PRAGMA synchronous = FULL");
    for (int next = version; next < newest; ++next) {
      Transaction transaction(handle, Transaction::Kind::write);
      execute(handle, std::string(accounts_schema_list()[static_cast<std::size_t>(next)]).c_str());
      execute(handle, ("PRAGMA user_version = " + std::to_string(next + 1)).c_str());
      transaction.commit();
    }
    return accounts;
  });
}

// The log beside the file is read, too, without the shared index (-shm) that SQLite would have to write: with the lock of a single user, which
// the VFS without locks grants, the index is in this process's memory.
Result<Accounts> Accounts::read(const std::filesystem::path& file) {
  return guarded([&]() -> Result<Accounts> {
    Accounts accounts;
    std::error_code none;
    const bool log = std::filesystem::file_size(file.string() + "-wal", none) > 0 && !none;
    const int code = log ? sqlite3_open_v2(file.c_str(), &accounts.handle_, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, "unix-none")
                         : sqlite3_open_v2(immutable_address(file).c_str(), &accounts.handle_,
                                           SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_URI, nullptr);
    if (code != SQLITE_OK) throw_sql(accounts.handle_, code, "opening " + file.string());
    // Or its end would write the log into the file.
    sqlite3_db_config(accounts.handle_, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
    execute(accounts.handle_, "PRAGMA locking_mode = EXCLUSIVE");
    prepare(accounts.handle_);
    if (version_of(accounts.handle_, file) != newest_schema()) return older_schema(file);
    return accounts;
  });
}

Result<std::vector<User>> Accounts::users(std::string_view after, std::size_t limit) const {
  return guarded([&]() -> Result<std::vector<User>> {
    std::vector<User> out;
    Statement row(handle_, std::string("SELECT ") + kUserColumns + " FROM users WHERE name > ?1 ORDER BY name LIMIT ?2");
    row.text(1, after).unsigned_integer(2, limit);
    while (row.step()) out.push_back(user_at(row));
    return out;
  });
}
Result<std::optional<User>> Accounts::find(std::string_view name) const {
  return guarded([&]() -> Result<std::optional<User>> {
    Statement row(handle_, std::string("SELECT ") + kUserColumns + " FROM users WHERE name = ?1");
    if (!row.text(1, name).step()) return std::optional<User>();
    return std::optional(user_at(row));
  });
}

Status check_user(const User& user) {
  if (!is_user_name(user.name)) return Error{ErrorKind::bad_value, "user must be 2 to 32 of the characters a-z 0-9 . _ -", "user"};
  if (Status checked = check_display_name(user.display_name); !checked) return checked;
  return check_role(user.role);
}

Status Accounts::add(const User& user, std::int64_t now_s) {
  if (Status checked = check_user(user); !checked) return checked;
  return guarded([&]() -> Status {
    Transaction transaction(handle_, Transaction::Kind::write);
    if (static_cast<std::size_t>(number_of(handle_, "SELECT count(*) FROM users")) >= kMaxUsers)
      return Error{ErrorKind::wrong_state, "there are " + std::to_string(kMaxUsers) + " accounts already", {}};
    {
      Statement taken(handle_, "SELECT 1 FROM users WHERE name = ?1");
      if (taken.text(1, std::string_view(user.name)).step())
        return Error{ErrorKind::bad_value, "user " + user.name + " exists already", "user"};
    }
    Statement row(
        handle_,
        "INSERT INTO users (name, display_name, role, enabled, password_hash, pin_hash, created_s) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)");
    row.text(1, std::string_view(user.name)).text(2, std::string_view(user.display_name)).text(3, std::string_view(user.role));
    row.integer(4, user.enabled ? 1 : 0).text(5, std::string_view(user.password_hash)).text(6, user.pin_hash).integer(7, now_s).run();
    transaction.commit();
    return {};
  });
}

Status Accounts::change(std::string_view name, const UserChange& change) {
  if (change.display_name)
    if (Status checked = check_display_name(*change.display_name); !checked) return checked;
  if (change.role)
    if (Status checked = check_role(*change.role); !checked) return checked;
  return guarded([&]() -> Status {
    Transaction transaction(handle_, Transaction::Kind::write);
    Statement row(handle_, std::string("SELECT ") + kUserColumns + " FROM users WHERE name = ?1");
    if (!row.text(1, name).step()) return Error{ErrorKind::not_found, "there is no user " + std::string(name), {}};
    User user = user_at(row);
    row.reset();
    if (change.display_name) user.display_name = *change.display_name;
    if (change.role) user.role = *change.role;
    if (change.enabled) user.enabled = *change.enabled;
    if (change.password_hash) {
      user.password_hash = *change.password_hash;
      // It was set with the old password, maybe by the person whom the new one is to keep out.
      user.pin_hash.reset();
    }
    if (change.pin_hash) user.pin_hash = *change.pin_hash;
    Statement update(handle_,
                     "UPDATE users SET display_name = ?2, role = ?3, enabled = ?4, password_hash = ?5, pin_hash = ?6 WHERE id = ?1");
    update.integer(1, user.id).text(2, std::string_view(user.display_name)).text(3, std::string_view(user.role));
    update.integer(4, user.enabled ? 1 : 0).text(5, std::string_view(user.password_hash)).text(6, user.pin_hash).run();
    if (number_of(handle_, "SELECT count(*) FROM users WHERE enabled AND role = 'engineer'") == 0)
      return Error{ErrorKind::wrong_state, "one enabled engineer must remain: make another one first", {}};
    transaction.commit();
    return {};
  });
}

Result<bool> Accounts::has_engineer() const {
  return guarded(
      [&]() -> Result<bool> { return number_of(handle_, "SELECT count(*) FROM users WHERE enabled AND role = 'engineer'") > 0; });
}

Status Accounts::begin_sign_in(const SignIn& sign_in) {
  return guarded([&]() -> Status {
    Transaction transaction(handle_, Transaction::Kind::write);
    Statement(handle_, "UPDATE sign_ins SET ended = 1 WHERE device = ?1").text(1, std::string_view(sign_in.device)).run();
    Statement row(
        handle_,
        "INSERT INTO sign_ins (secret_sha256, user_id, device, begun_s, used_s) SELECT ?1, id, ?3, ?4, ?5 FROM users WHERE name = ?2");
    row.text(1, std::string_view(sign_in.secret_sha256)).text(2, std::string_view(sign_in.user)).text(3, std::string_view(sign_in.device));
    row.integer(4, sign_in.begun_s).integer(5, sign_in.used_s).run();
    Statement old(
        handle_,
        "DELETE FROM sign_ins WHERE ended AND secret_sha256 NOT IN (SELECT secret_sha256 FROM sign_ins WHERE ended ORDER BY used_s "
        "DESC LIMIT ?1)");
    old.unsigned_integer(1, kEndedSignInsKept).run();
    transaction.commit();
    return {};
  });
}
Status Accounts::use_sign_in(std::string_view secret_sha256, std::int64_t used_s) {
  return guarded([&]() -> Status {
    Statement(handle_, "UPDATE sign_ins SET used_s = ?2 WHERE secret_sha256 = ?1").text(1, secret_sha256).integer(2, used_s).run();
    return {};
  });
}
Status Accounts::end_sign_in(std::string_view secret_sha256) {
  return guarded([&]() -> Status {
    Statement(handle_, "UPDATE sign_ins SET ended = 1 WHERE secret_sha256 = ?1").text(1, secret_sha256).run();
    return {};
  });
}
Status Accounts::end_sign_ins_of(std::string_view user, std::string_view but) {
  return guarded([&]() -> Status {
    Statement row(
        handle_,
        "UPDATE sign_ins SET ended = 1, device = '' WHERE user_id = (SELECT id FROM users WHERE name = ?1) AND secret_sha256 != ?2");
    row.text(1, user).text(2, but).run();
    if (but.empty()) Statement(handle_, "DELETE FROM tokens WHERE user_id = (SELECT id FROM users WHERE name = ?1)").text(1, user).run();
    return {};
  });
}
Result<std::vector<SignIn>> Accounts::sign_ins() const {
  return guarded([&]() -> Result<std::vector<SignIn>> {
    std::vector<SignIn> out;
    Statement row(handle_,
                  "SELECT secret_sha256, name, display_name, role, device, begun_s, used_s, ended OR NOT enabled, pin_hash IS NOT NULL "
                  "FROM sign_ins JOIN users ON "
                  "users.id = user_id ORDER BY used_s DESC");
    while (row.step())
      out.push_back({row.text_at(0), row.text_at(1), row.text_at(2), row.text_at(3), row.text_at(4), row.integer_at(5), row.integer_at(6),
                     row.integer_at(7) != 0, row.integer_at(8) != 0});
    return out;
  });
}

Result<std::int64_t> Accounts::add_token(const Token& token) {
  return guarded([&]() -> Result<std::int64_t> {
    Transaction transaction(handle_, Transaction::Kind::write);
    if (static_cast<std::size_t>(number_of(handle_, "SELECT count(*) FROM tokens")) >= kMaxTokens)
      return Error{ErrorKind::wrong_state, "there are " + std::to_string(kMaxTokens) + " tokens already: remove one first", {}};
    Statement row(handle_,
                  "INSERT INTO tokens (secret_sha256, user_id, name, scope, created_s, expires_s) SELECT ?1, id, ?3, ?4, ?5, ?6 FROM users "
                  "WHERE name = ?2 AND enabled RETURNING id");
    row.text(1, std::string_view(token.secret_sha256)).text(2, std::string_view(token.user)).text(3, std::string_view(token.name));
    row.text(4, std::string_view(token.scope)).integer(5, token.created_s).integer(6, token.expires_s);
    if (!row.step()) return Error{ErrorKind::not_found, "there is no user " + token.user, {}};
    const std::int64_t id = row.integer_at(0);
    row.reset();
    transaction.commit();
    return id;
  });
}
Result<std::vector<Token>> Accounts::tokens(std::string_view user, std::int64_t after, std::size_t limit) const {
  return guarded([&]() -> Result<std::vector<Token>> {
    std::vector<Token> out;
    Statement row(
        handle_,
        "SELECT tokens.id, secret_sha256, users.name, display_name, role, tokens.name, scope, tokens.created_s, expires_s FROM tokens "
        "JOIN users ON users.id = user_id WHERE enabled AND (?1 = '' OR users.name = ?1) AND tokens.id > ?2 ORDER BY tokens.id LIMIT ?3");
    row.text(1, user).integer(2, after).unsigned_integer(3, limit);
    while (row.step())
      out.push_back({row.integer_at(0), row.text_at(1), row.text_at(2), row.text_at(3), row.text_at(4), row.text_at(5), row.text_at(6),
                     row.integer_at(7), row.integer_at(8)});
    return out;
  });
}
Status Accounts::remove_token(std::int64_t id, std::string_view user) {
  return guarded([&]() -> Status {
    Statement row(handle_,
                  "DELETE FROM tokens WHERE id = ?1 AND (?2 = '' OR user_id = (SELECT id FROM users WHERE name = ?2)) RETURNING id");
    if (!row.integer(1, id).text(2, user).step()) return Error{ErrorKind::not_found, "there is no token " + std::to_string(id), {}};
    row.run();
    return {};
  });
}

Status Accounts::log(const AuditEntry& entry) {
  return guarded([&]() -> Status {
    Transaction transaction(handle_, Transaction::Kind::write);
    std::string previous = kNoPrevious;
    {
      Statement newest(handle_, "SELECT digest FROM audit ORDER BY id DESC LIMIT 1");
      if (newest.step()) previous = newest.text_at(0);
    }
    Statement row(
        handle_,
        "INSERT INTO audit (utc_ms, steady_ns, user, role, address, action, target, before, after, result, previous, digest) VALUES "
        "(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12)");
    const std::string digest = digest_of(entry, previous);
    row.integer(1, entry.utc_ms).unsigned_integer(2, entry.steady_ns).text(3, std::string_view(entry.user));
    row.text(4, std::string_view(entry.role)).text(5, std::string_view(entry.address)).text(6, std::string_view(entry.action));
    row.text(7, std::string_view(entry.target)).text(8, entry.before).text(9, entry.after).text(10, std::string_view(entry.result));
    row.text(11, std::string_view(previous)).text(12, std::string_view(digest)).run();
    transaction.commit();
    return {};
  });
}
Result<std::vector<AuditRow>> Accounts::audit(std::optional<std::int64_t> before, std::size_t limit) const {
  return guarded([&]() -> Result<std::vector<AuditRow>> {
    std::vector<AuditRow> out;
    Statement row(handle_, std::string("SELECT ") + kAuditColumns + " WHERE id < ?1 ORDER BY id DESC LIMIT ?2");
    row.integer(1, before.value_or(INT64_MAX)).unsigned_integer(2, limit);
    while (row.step()) out.push_back(audit_at(row));
    return out;
  });
}
Result<AuditCheck> Accounts::check_audit() const {
  return guarded([&]() -> Result<AuditCheck> {
    AuditCheck check;
    check.head = kNoPrevious;
    std::int64_t expected = 1;
    Statement row(handle_, std::string("SELECT ") + kAuditColumns + " ORDER BY id");
    while (row.step()) {
      const AuditRow one = audit_at(row);
      const bool sound = one.id == expected && row.text_at(11) == check.head && one.digest == digest_of(one.entry, check.head);
      if (!sound && !check.first_wrong) check.first_wrong = one.id;
      check.head = one.digest;
      expected = one.id + 1;
      ++check.rows;
    }
    return check;
  });
}

}  // namespace hoist::db
