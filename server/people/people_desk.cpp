#include "server/people/people_desk.hpp"

#include <sodium.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <iostream>
#include <utility>

namespace hoist::server {

PeopleDesk::PeopleDesk(std::filesystem::path file, HashLimits limits, Post post)
    : AnswerDesk([this](std::function<void(PeopleRoom&)> work) { return run(work_, std::move(work), kPeopleWorkLimit); }, post),
      file_(std::move(file)),
      limits_(limits),
      // Far fewer than rows may wait: questions never take a row its place.
      after_log_([this](std::function<void(PeopleRoom&)> work) { return run(audit_, std::move(work), kPeopleWorkLimit); },
                 std::move(post)) {}

PeopleDesk::~PeopleDesk() { stop(); }

bool PeopleDesk::open() {
  if (sodium_init() < 0) {
    problem_ = "libsodium cannot be used on this computer";
    return false;
  }
  db::Result<db::Accounts> opened = db::Accounts::open(file_);
  if (!opened) {
    problem_ = opened.error().message;
    return false;
  }
  accounts_ = std::move(*opened);
  return true;
}

void PeopleDesk::start() {
  if (accounts_) thread_ = std::thread([this] { serve(); });
}

void PeopleDesk::stop() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

bool PeopleDesk::run(Work& queue, std::function<void(PeopleRoom&)> work, std::size_t limit) {
  {
    const std::lock_guard lock(mutex_);
    if (!accounts_ || ending_ || queue.size() >= limit) return false;
    queue.push_back(std::move(work));
  }
  wake_.notify_all();
  return true;
}

void PeopleDesk::log(db::AuditEntry entry) {
  const bool taken = run(
      audit_,
      [entry = std::move(entry)](PeopleRoom& room) {
        if (const db::Status logged = room.accounts.log(entry); !logged)
          std::cerr << "hoist-server: the audit log could not be written: " << logged.error().message << std::endl;
      },
      kAuditWaitLimit);
  if (!taken) ++lost_entries_;
}

void PeopleDesk::serve() {
  // This thread only: setpriority takes a thread's number on Linux.
  (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::syscall(SYS_gettid)), 19);
  const std::string nobody = hash_secret("no password of anybody", limits_);
  PeopleRoom room{*accounts_, limits_, nobody};
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return ending_ || !work_.empty() || !audit_.empty(); });
    Work& queue = work_.empty() ? audit_ : work_;
    if (queue.empty()) return;
    auto work = std::move(queue.front());
    queue.pop_front();
    lock.unlock();
    work(room);
    work = nullptr;
    lock.lock();
  }
}

}  // namespace hoist::server
