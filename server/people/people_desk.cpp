#include "server/people/people_desk.hpp"

#include <sodium.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <utility>

#include "server/contract/audit.hpp"

namespace hoist::server {

namespace {
// While the disk refuses, asked again this often.
constexpr auto kRetry = std::chrono::seconds(1);

db::Result<KnownPeople> people_of(const db::Accounts& accounts) {
  KnownPeople known;
  auto sign_ins = accounts.sign_ins();
  if (!sign_ins) return sign_ins.error();
  known.sign_ins = std::move(*sign_ins);
  auto tokens = accounts.tokens();
  if (!tokens) return tokens.error();
  known.tokens = std::move(*tokens);
  const auto engineer = accounts.has_engineer();
  if (!engineer) return engineer.error();
  known.has_engineer = *engineer;
  return known;
}

// The row in the place of those that were lost; its time is that of the first of them.
db::AuditEntry lost_entry(const db::AuditEntry& first) {
  return {.utc_ms = first.utc_ms,
          .steady_ns = first.steady_ns,
          .user = "hoist-server",
          .role = "server",
          .address = "-",
          .action = std::string{AuditName("lose_rows").text},
          .target = "/api/v1/audit",
          .before = {},
          .after = {},
          .result = "done"};
}
}  // namespace

PeopleDesk::PeopleDesk(std::filesystem::path file, HashLimits limits, Post post)
    : AnswerDesk([this](std::function<void(PeopleRoom&)> work) { return run(std::move(work)); }, post),
      file_(std::move(file)),
      limits_(limits),
      post_(post),
      // Far fewer than rows may wait.
      after_log_([this](std::function<void(PeopleRoom&)> work) { return run_after_rows(std::move(work)); }, std::move(post)) {}

PeopleDesk::~PeopleDesk() { stop(); }

std::optional<KnownPeople> PeopleDesk::open() {
  auto opened = ::sodium_init() < 0 ? db::Result<db::Accounts>(db::Error{db::ErrorKind::internal, "libsodium does not work", {}})
                                    : db::Accounts::open(file_);
  auto known = opened ? people_of(*opened) : opened.error();
  std::string problem;
  if (!known) problem = "The accounts cannot be used: " + known.error().message + ". This is tried again each second.";
  // Who is signed in, and who may say STOP, does not depend on a disk that takes data.
  if (!opened && !known_)
    if (const auto read = db::Accounts::read(file_)) known = people_of(*read);
  const std::lock_guard lock(mutex_);
  if (problem.empty()) accounts_ = std::move(*opened);
  set_problem(problem_, std::move(problem));
  if (!known || std::exchange(known_, true)) return std::nullopt;
  return std::move(*known);
}

void PeopleDesk::start() {
  thread_ = std::thread([this] { serve(); });
}

void PeopleDesk::stop() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::string PeopleDesk::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}
std::string PeopleDesk::not_stored() const {
  const std::lock_guard lock(mutex_);
  return problem_.empty() ? rows_problem_ : problem_;
}

// Under the lock.
void PeopleDesk::set_problem(std::string& problem, std::string text) {
  if (problem == text) return;
  problem = std::move(text);
  if (!problem.empty()) std::cerr << "hoist-server: " << problem << std::endl;
  changes_.fetch_add(1, std::memory_order_release);
}

bool PeopleDesk::run(std::function<void(PeopleRoom&)> work) {
  {
    const std::lock_guard lock(mutex_);
    if (!accounts_ || ending_ || work_.size() >= kPeopleWorkLimit) return false;
    work_.push_back(std::move(work));
  }
  wake_.notify_all();
  return true;
}

bool PeopleDesk::run_after_rows(std::function<void(PeopleRoom&)> work) {
  {
    const std::lock_guard lock(mutex_);
    if (!accounts_ || ending_ || after_rows_.size() >= kPeopleWorkLimit) return false;
    after_rows_.emplace_back(rows_logged_, std::move(work));
  }
  wake_.notify_all();
  return true;
}

void PeopleDesk::log(db::AuditEntry entry) {
  {
    const std::lock_guard lock(mutex_);
    const bool lost = rows_.size() >= kAuditWaitLimit;
    if (!lost || rows_.back().lost == 0) {
      rows_.push_back({.entry = lost ? lost_entry(entry) : std::move(entry)});
      ++rows_logged_;
    }
    if (lost) ++rows_.back().lost;
  }
  wake_.notify_all();
}

void PeopleDesk::write_row(std::unique_lock<std::mutex>& lock, db::Accounts& accounts) {
  db::AuditEntry entry = rows_.front().entry;
  if (const std::uint64_t lost = rows_.front().lost; lost > 0) entry.after = std::to_string(lost) + (lost == 1 ? " row" : " rows");
  lock.unlock();
  const db::Status logged = accounts.log(entry);
  lock.lock();
  if (logged) {
    rows_.pop_front();
    ++rows_done_;
    set_problem(rows_problem_, {});
  } else {
    rows_again_ = std::chrono::steady_clock::now() + kRetry;
    set_problem(rows_problem_, "The audit log cannot be written: " + logged.error().message + ". This is tried again each second.");
  }
}

bool PeopleDesk::do_next(std::unique_lock<std::mutex>& lock, PeopleRoom& room) {
  // At the end all that wait are tried, up to the first that is refused.
  const bool row = !rows_.empty() && (ending_ || std::chrono::steady_clock::now() >= rows_again_);
  std::function<void(PeopleRoom&)> work;
  if (!work_.empty()) {
    work = std::move(work_.front());
    work_.pop_front();
  } else if (!after_rows_.empty() && (!row || rows_done_ >= after_rows_.front().first)) {
    work = std::move(after_rows_.front().second);
    after_rows_.pop_front();
  } else if (row) {
    write_row(lock, room.accounts);
    if (ending_ && !rows_problem_.empty()) give_up_rows();
    return true;
  } else {
    return false;
  }
  lock.unlock();
  work(room);
  work = nullptr;
  lock.lock();
  return true;
}

// The server ends: a disk that refuses now is not asked again.
void PeopleDesk::give_up_rows() {
  std::uint64_t lost = 0;
  for (const Row& row : rows_) lost += std::max<std::uint64_t>(row.lost, 1);
  rows_.clear();
  if (lost > 0) std::cerr << "hoist-server: rows of the audit log that were never stored: " << lost << std::endl;
}

void PeopleDesk::serve() {
  // Before the priority is lowered: on a busy computer the end of the server waited for it, more than 20 s as measured.
  const std::string nobody = hash_secret("no password of anybody", limits_);
  // This thread only: setpriority takes a thread's number on Linux.
  (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::syscall(SYS_gettid)), 19);
  std::unique_lock lock(mutex_);
  while (!accounts_ && !ending_) {
    if (wake_.wait_for(lock, kRetry, [this] { return ending_; })) break;
    lock.unlock();
    if (auto known = open())
      post_([this, known = std::move(*known)] {
        if (on_known_) on_known_(known);
      });
    lock.lock();
  }
  if (!accounts_) return give_up_rows();
  PeopleRoom room{*accounts_, limits_, nobody};
  for (;;) {
    if (do_next(lock, room)) continue;
    if (ending_) return;
    if (rows_.empty())
      wake_.wait(lock);
    else
      wake_.wait_until(lock, rows_again_);
  }
}

}  // namespace hoist::server
