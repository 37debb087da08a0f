// Everything that needs the file of accounts or a password hash happens on one thread of its own, at low priority: a hash takes 60 ms and 64 MiB,
// and a flood of sign-ins must cost neither driving nor memory. A disk that cannot be written is asked again once a second.
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "db/accounts/accounts.hpp"
#include "server/people/passwords.hpp"
#include "server/threads/answer_desk.hpp"

namespace hoist::server {

// What work on the people's thread may use.
struct PeopleRoom {
  db::Accounts& accounts;
  const HashLimits& limits;
  // A hash of no password, in the same limits: who does not exist is answered as slowly as who does.
  const std::string& nobody_hash;
};

// What a file of accounts says of those who may come.
struct KnownPeople {
  std::vector<db::SignIn> sign_ins;  // newest use first
  std::vector<db::Token> tokens;
  bool has_engineer = false;
};

// Work that waits; beyond it requests are refused (503) and audit entries are lost, which a row then says.
inline constexpr std::size_t kPeopleWorkLimit = 64, kAuditWaitLimit = 1000;

// When work has its turn: before the rows of the audit log that wait, or after them, so that who did something finds it in the log.
enum class Turn : std::uint8_t { first, after_log };

class PeopleDesk : public AnswerDesk<PeopleRoom> {
 public:
  PeopleDesk(std::filesystem::path file, HashLimits limits, Post post);
  ~PeopleDesk();

  // Opens the file, before `start`; the thread tries again later. Its people, also when it can only be read; nothing when it cannot be read.
  std::optional<KnownPeople> open();
  // Called once on the network thread when the thread has read the people whom `open` could not read. Before `start`.
  void set_on_known(std::function<void(KnownPeople)> on_known) { on_known_ = std::move(on_known); }
  void start();
  // What waits is still done, and each row that waits is tried once more.
  void stop();

  // Why the accounts cannot be used; empty when they can.
  [[nodiscard]] std::string problem() const;
  // Why accounts or rows of the audit log are not stored; empty when they are.
  [[nodiscard]] std::string not_stored() const;
  // Counts up whenever not_stored() is another.
  [[nodiscard]] std::uint64_t changes() const { return changes_.load(std::memory_order_acquire); }

  // Work without an answer; false when too much waits.
  bool tell(std::function<void(PeopleRoom&)> work) { return run(std::move(work)); }
  // Where work of this turn is asked for.
  [[nodiscard]] AnswerDesk& at(Turn turn) { return turn == Turn::first ? *this : after_log_; }
  // Adds a row to the audit log, in order, without an answer. A row that the disk refuses stays first and is tried again.
  void log(db::AuditEntry entry);

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct Row {
    db::AuditEntry entry;
    std::uint64_t lost = 0;  // not 0: this row says that so many were lost here
  };
  bool run(std::function<void(PeopleRoom&)> work);
  bool run_after_rows(std::function<void(PeopleRoom&)> work);
  // One thing that waits, or false; under the lock, which is open while it is done.
  bool do_next(std::unique_lock<std::mutex>& lock, PeopleRoom& room);
  void write_row(std::unique_lock<std::mutex>& lock, db::Accounts& accounts);
  void give_up_rows();
  void set_problem(std::string& problem, std::string text);
  void serve();

  const std::filesystem::path file_;
  const HashLimits limits_;
  const Post post_;
  std::function<void(KnownPeople)> on_known_;
  std::optional<db::Accounts> accounts_;  // open for writing
  bool known_ = false;                    // the people were read
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::string problem_, rows_problem_;
  std::atomic<std::uint64_t> changes_ = 0;
  std::deque<std::function<void(PeopleRoom&)>> work_;
  std::deque<Row> rows_;  // written when no other work waits
  Time rows_again_{};     // the first of them is tried again then
  std::uint64_t rows_logged_ = 0, rows_done_ = 0;
  // Each done when as many rows are, or none can be written now.
  std::deque<std::pair<std::uint64_t, std::function<void(PeopleRoom&)>>> after_rows_;
  AnswerDesk<PeopleRoom> after_log_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace hoist::server
