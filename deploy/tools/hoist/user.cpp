// hoist user, hoist audit: the file of accounts on this computer, for a user who may read it.
#include <signal.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <filesystem>
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
    "       hoist user add FILE NAME DISPLAY_NAME viewer|therapist|engineer [--create]\n"
    "       hoist user password FILE NAME\n"
    "       hoist user enable|disable FILE NAME\n\n"
    "FILE is the server's accounts.db, beside its recordings; --create makes it when there is none. A new password is read twice from the\n"
    "terminal, without showing it, or once from standard input.\n"
    "A running server learns of a new account or password at once. What is signed in stays so, tokens included, until its next start, "
    "also\n"
    "after `password` and `disable`: when a tablet was stolen, restart the server, or do it in the console (Settings) instead.\n";
constexpr const char* kAuditHelp =
    "usage: hoist audit verify FILE\n"
    "       hoist audit list FILE\n\n"
    "verify: whether a row of the audit log was changed or is missing, and the digest of the newest row. Noted elsewhere, it proves later\n"
    "that no row was cut off. list: one row per line, newest first.\n";

std::int64_t now_s() {
  return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

termios terminal_before{};

void restore_terminal_and_end(int signal) {
  ::tcsetattr(STDIN_FILENO, TCSANOW, &terminal_before);
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

// A terminal that does not show what is typed. When the program is ended meanwhile, the terminal shows it again.
class SilentTerminal {
 public:
  SilentTerminal() {
    for (std::size_t i = 0; i < kEnding.size(); ++i) before_[i] = ::signal(kEnding[i], &restore_terminal_and_end);
    // A stopped program would leave it silent.
    stop_before_ = ::signal(SIGTSTP, SIG_IGN);
    termios silent = terminal_before;
    silent.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    ::tcsetattr(STDIN_FILENO, TCSANOW, &silent);
  }
  SilentTerminal(const SilentTerminal&) = delete;
  SilentTerminal& operator=(const SilentTerminal&) = delete;
  ~SilentTerminal() {
    ::tcsetattr(STDIN_FILENO, TCSANOW, &terminal_before);
    ::signal(SIGTSTP, stop_before_);
    for (std::size_t i = 0; i < kEnding.size(); ++i) ::signal(kEnding[i], before_[i]);
  }

 private:
  using Handler = void (*)(int);
  static constexpr std::array kEnding{SIGINT, SIGTERM, SIGHUP, SIGQUIT};
  std::array<Handler, kEnding.size()> before_{};
  Handler stop_before_ = SIG_DFL;
};

// Twice from a terminal, without echo; from a pipe one line. Nothing when the two differ.
std::optional<std::string> read_password() {
  std::string first, again;
  if (::tcgetattr(STDIN_FILENO, &terminal_before) != 0) {
    std::getline(std::cin, first);
    return first;
  }
  {
    const SilentTerminal silent;
    std::fputs("New password: ", stderr);
    std::getline(std::cin, first);
    std::fputs("\nThe same again: ", stderr);
    std::getline(std::cin, again);
    std::fputc('\n', stderr);
  }
  if (first != again) return std::nullopt;
  return first;
}

// The hash of a password that is read now; nothing after a refusal that was printed.
std::optional<std::string> new_hash(const std::string& user) {
  const std::optional<std::string> password = read_password();
  if (!password) {
    std::fputs("hoist user: the two passwords differ\n", stderr);
    return std::nullopt;
  }
  if (const std::string fault = server::password_fault(*password, user); !fault.empty()) {
    std::fprintf(stderr, "hoist user: the password %s\n", fault.c_str());
    return std::nullopt;
  }
  std::string hash = server::hash_secret(*password, server::HashLimits());
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

int add(const std::vector<std::string>& words, bool create) {
  const std::string &file = words[1], &name = words[2], &role = words[4];
  db::User user{.id = 0, .name = name, .display_name = words[3], .role = role, .enabled = true, .password_hash = {}, .pin_hash = {}};
  if (const db::Status checked = db::check_user(user); !checked) return refuse("user", checked.error());
  // A mistyped FILE would become a file of accounts that no server reads.
  std::error_code ignored;
  if (!create && !std::filesystem::exists(file, ignored))
    return refuse("user", {db::ErrorKind::not_found, "there is no file " + file + " (--create makes it)", {}});
  const auto hash = new_hash(name);
  if (!hash) return kRefused;
  user.password_hash = *hash;
  auto accounts = db::Accounts::open(file);
  if (!accounts) return refuse("user", accounts.error());
  return finish(*accounts, name, role, accounts->add(user, now_s()), false);
}

int change(db::Accounts& accounts, const std::string& verb, const std::string& name) {
  db::UserChange change{.display_name = {}, .role = {}, .password_hash = {}, .enabled = {}, .pin_hash = {}};
  if (verb == "password") {
    change.password_hash = new_hash(name);
    if (!change.password_hash) return kRefused;
  } else {
    change.enabled = verb == "enable";
  }
  return finish(accounts, name, verb == "password" ? "new password" : verb, accounts.change(name, change), verb != "enable");
}

}  // namespace

int run_user(std::span<const std::string_view> arguments) {
  std::vector<std::string> words;
  bool create = false;
  for (const std::string_view argument : arguments) {
    if (argument == "--help") {
      std::fputs(kUserHelp, stdout);
      return kDone;
    }
    if (argument == "--create")
      create = true;
    else if (argument.starts_with("--"))
      return bad_usage("user", "there is no option " + std::string(argument));
    else
      words.emplace_back(argument);
  }
  const std::string verb = words.empty() ? "" : words[0];
  if (create && verb != "add") return bad_usage("user", "--create belongs to add");
  if (verb == "add" && words.size() == 5) return add(words, create);
  const bool lists = verb == "list" && words.size() == 2;
  const bool changes = (verb == "password" || verb == "enable" || verb == "disable") && words.size() == 3;
  if (!lists && !changes) return bad_usage("user", "list, add, password, enable or disable, with their words");
  auto accounts = db::Accounts::attach(words[1]);
  if (!accounts) return refuse("user", accounts.error());
  return lists ? list(*accounts) : change(*accounts, verb, words[2]);
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
