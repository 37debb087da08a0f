// Everything that needs the file of accounts or a password hash happens on one thread of its own, at low priority: a hash takes 60 ms and 64 MiB,
// and a flood of sign-ins must cost neither driving nor memory.
#pragma once
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

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

// Work that waits; beyond it requests are refused (503) and audit entries are counted as lost.
inline constexpr std::size_t kPeopleWorkLimit = 64, kAuditWaitLimit = 1000;

// When work has its turn: before the rows of the audit log that wait, or after them, so that who did something finds it in the log.
enum class Turn : std::uint8_t { first, after_log };

class PeopleDesk : public AnswerDesk<PeopleRoom> {
 public:
  PeopleDesk(std::filesystem::path file, HashLimits limits, Post post);
  ~PeopleDesk();

  // Opens the file; before `start`. An error leaves the server without accounts: `problem` says why.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  bool open();
  // Before `start` only.
  [[nodiscard]] db::Accounts& accounts() { return *accounts_; }
  void start();
  // What waits is still done.
  void stop();

  // Work without an answer; false when too much waits.
  bool tell(std::function<void(PeopleRoom&)> work) { return run(work_, std::move(work), kPeopleWorkLimit); }
  // Where work of this turn is asked for.
  [[nodiscard]] AnswerDesk& at(Turn turn) { return turn == Turn::first ? *this : after_log_; }
  // Adds a row to the audit log, in order, without an answer.
  void log(db::AuditEntry entry);
  [[nodiscard]] std::uint64_t lost_entries() const { return lost_entries_; }

 private:
  using Work = std::deque<std::function<void(PeopleRoom&)>>;
  bool run(Work& queue, std::function<void(PeopleRoom&)> work, std::size_t limit);
  void serve();

  const std::filesystem::path file_;
  const HashLimits limits_;
  std::string problem_;
  std::optional<db::Accounts> accounts_;
  std::mutex mutex_;
  std::condition_variable wake_;
  Work work_;
  Work audit_;  // done when no other work waits
  AnswerDesk<PeopleRoom> after_log_;
  bool ending_ = false;
  std::uint64_t lost_entries_ = 0;
  std::thread thread_;
};

}  // namespace hoist::server
