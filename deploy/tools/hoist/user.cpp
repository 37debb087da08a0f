// hoist user, hoist audit: the file of accounts on this computer, for a user who may read it.
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "db/accounts/accounts.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/recording_file.hpp"
#include "server/people/passwords.hpp"

namespace hoist::tool {

namespace {

constexpr const char* kUserHelp =
    "usage: hoist user list FILE\n"
    "       hoist user add FILE NAME DISPLAY_NAME viewer|therapist|engineer\n"
    "       hoist user password FILE NAME\n"
    "       hoist user enable|disable FILE NAME\n\n"
    "FILE is the server's accounts.db, beside its recordings. A new password is read from the terminal, without showing it, or from\n"
    "standard input. A running server learns of a new password or account at once, of a disabled one at its next start: disable in\n"
    "the console (Settings) to sign a user out now.\n";
constexpr const char* kAuditHelp =
    "usage: hoist audit verify FILE\n"
    "       hoist audit list FILE\n\n"
    "verify: whether a row of the audit log was changed or is missing, and the digest of the newest row. Noted elsewhere, it proves later\n"
    "that no row was cut off. list: one row per line, newest first.\n";

std::int64_t now_s() {
  return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

// From a terminal without echo; from a pipe one line.
std::string read_password() {
  termios before{};
  const bool terminal = ::tcgetattr(STDIN_FILENO, &before) == 0;
  if (terminal) {
    std::fputs("New password: ", stderr);
    termios silent = before;
    silent.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    ::tcsetattr(STDIN_FILENO, TCSANOW, &silent);
  }
  std::string line;
  std::getline(std::cin, line);
  if (terminal) {
    ::tcsetattr(STDIN_FILENO, TCSANOW, &before);
    std::fputc('\n', stderr);
  }
  return line;
}

// The hash of a password that is read now; nothing after a refusal that was printed.
std::optional<std::string> new_hash(const std::string& user) {
  const std::string password = read_password();
  if (const std::string fault = server::password_fault(password, user); !fault.empty()) {
    std::fprintf(stderr, "hoist user: the password %s\n", fault.c_str());
    return std::nullopt;
  }
  std::string hash = server::hash_secret(password, server::HashLimits());
  if (hash.empty()) {
    std::fputs("hoist user: there is no memory for the password\n", stderr);
    return std::nullopt;
  }
  return hash;
}

int list(const db::Accounts& accounts) {
  const auto users = accounts.users();
  if (!users) return refuse("user", users.error());
  for (const db::User& user : *users)
    std::printf("%-20s %-10s %-9s %s\n", user.name.c_str(), user.role.c_str(), user.enabled ? "" : "disabled", user.display_name.c_str());
  return kDone;
}

// A change of an account: logged, and when it removes the secret, sign-ins with it end at the server's next start.
int finish(db::Accounts& accounts, const std::string& name, const std::string& after, const db::Status& status, bool signs_out) {
  if (!status) return refuse("user", status.error());
  if (signs_out)
    if (const db::Status ended = accounts.end_sign_ins_of(name, ""); !ended) return refuse("user", ended.error());
  const db::Status logged = accounts.log({.utc_ms = now_s() * 1000,
                                          .steady_ns = 0,
                                          .user = "local",
                                          .role = "engineer",
                                          .address = "hoist user",
                                          .action = "user",
                                          .target = name,
                                          .before = {},
                                          .after = after,
                                          .result = "done"});
  return logged ? kDone : refuse("user", logged.error());
}

}  // namespace

int run_user(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(kUserHelp, stdout);
    return kDone;
  }
  if (arguments.size() < 2) return bad_usage("user", "say what to do and name the file");
  const std::vector<std::string> words(arguments.begin(), arguments.end());
  auto accounts = words[0] == "add" ? db::Accounts::open(words[1]) : db::Accounts::attach(words[1]);
  if (!accounts) return refuse("user", accounts.error());
  if (words[0] == "list" && words.size() == 2) return list(*accounts);
  if (words[0] == "add" && words.size() == 5) {
    const auto hash = new_hash(words[2]);
    if (!hash) return kRefused;
    return finish(*accounts, words[2], words[4],
                  accounts->add({.id = 0,
                                 .name = words[2],
                                 .display_name = words[3],
                                 .role = words[4],
                                 .enabled = true,
                                 .password_hash = *hash,
                                 .pin_hash = {}},
                                now_s()),
                  false);
  }
  if (words[0] == "password" && words.size() == 3) {
    const auto hash = new_hash(words[2]);
    if (!hash) return kRefused;
    return finish(*accounts, words[2], "new password",
                  accounts->change(words[2], {.display_name = {}, .role = {}, .password_hash = *hash, .enabled = {}, .pin_hash = {}}),
                  true);
  }
  if ((words[0] == "enable" || words[0] == "disable") && words.size() == 3)
    return finish(
        *accounts, words[2], words[0],
        accounts->change(words[2], {.display_name = {}, .role = {}, .password_hash = {}, .enabled = words[0] == "enable", .pin_hash = {}}),
        words[0] == "disable");
  return bad_usage("user", "list, add, password, enable or disable");
}

int run_audit(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(kAuditHelp, stdout);
    return kDone;
  }
  if (arguments.size() != 2 || (arguments[0] != "verify" && arguments[0] != "list")) return bad_usage("audit", "verify FILE or list FILE");
  auto accounts = db::Accounts::attach(std::string(arguments[1]));
  if (!accounts) return refuse("audit", accounts.error());
  if (arguments[0] == "verify") {
    const auto check = accounts->check_audit();
    if (!check) return refuse("audit", check.error());
    std::printf("%llu rows, newest %s\n", static_cast<unsigned long long>(check->rows), check->head.c_str());
    if (!check->first_wrong) return kDone;
    std::printf("row %lld was changed, or rows before it are missing\n", static_cast<long long>(*check->first_wrong));
    return kRefused;
  }
  constexpr std::size_t kPage = 1000;
  std::optional<std::int64_t> before;
  do {
    const auto rows = accounts->audit(before, kPage);
    if (!rows) return refuse("audit", rows.error());
    for (const db::AuditRow& row : *rows)
      std::printf("%lld %lld %s %s %s %s %s %s\n", static_cast<long long>(row.id), static_cast<long long>(row.entry.utc_ms),
                  row.entry.user.c_str(), row.entry.role.c_str(), row.entry.address.c_str(), row.entry.action.c_str(),
                  row.entry.target.c_str(), row.entry.result.c_str());
    before = rows->size() == kPage ? std::optional(rows->back().id) : std::nullopt;
  } while (before);
  return kDone;
}

}  // namespace hoist::tool
