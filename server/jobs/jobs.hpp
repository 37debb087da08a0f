// Long work on the database: one job at a time, on a thread and a connection of its own, so that neither recording nor any answer waits for it.
#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "db/store/session_types.hpp"
#include "server/contract/reasons.hpp"
#include "server/jobs/work.hpp"

namespace hoist::server {

// Jobs that wait; more are refused.
inline constexpr std::size_t kJobsWaiting = 8;
// Ended jobs that can still be asked for; the oldest go first.
inline constexpr std::size_t kJobsKept = 16;
// Files of ended exports that can still be fetched, until a session is deleted: the newest ones.
inline constexpr std::size_t kJobFiles = 2;

using JobId = std::uint64_t;
enum class JobState : std::uint8_t { waiting, running, done, failed, cancelled };
constexpr const char* job_state_name(JobState state) {
  constexpr std::array kNames{"waiting", "running", "done", "failed", "cancelled"};
  return kNames[static_cast<std::size_t>(state)];
}
constexpr bool has_ended(JobState state) { return state >= JobState::done; }

struct JobInfo {
  JobId id = 0;
  JobKind kind{};
  JobState state = JobState::waiting;
  double progress = 0;             // 0 to 1
  std::optional<db::Actor> actor;  // nothing: the server itself
  std::int64_t asked_utc_ms = 0;
  std::optional<std::int64_t> ended_utc_ms;
  std::shared_ptr<const std::string> result;  // JSON, when done; figures of sessions only until one is deleted
  std::shared_ptr<const db::SpoolFile> file;  // of export_sessions, as long as it is kept
  std::optional<Reason> reason;               // why it failed
  std::string detail;
  std::uint64_t change = 0;  // of Jobs::changes(), when it changed last
};

// What is known of the file in use.
enum class FileState : std::uint8_t { unchecked, checking, sound, damaged };
constexpr const char* file_state_name(FileState state) {
  constexpr std::array kNames{"unchecked", "checking", "sound", "damaged"};
  return kNames[static_cast<std::size_t>(state)];
}
struct FileHealth {
  FileState state = FileState::unchecked;
  double progress = 0;  // while checking
  std::optional<std::int64_t> checked_utc_ms;
  std::string detail;  // of what is damaged, or why it could not be checked
  std::uint64_t damaged_blobs = 0;
  std::vector<db::SessionId> damaged_sessions;
};

class Jobs {
 public:
  struct Options {
    JobTools tools;
    // On the jobs' thread: the file itself is damaged, not only a recording in it.
    std::function<void(const db::IntegrityReport&)> on_damage = {};
    // For tests, on the jobs' thread: before each step of a job.
    std::function<void(const JobInfo&)> on_step = {};
  };
  explicit Jobs(Options options);
  ~Jobs();
  Jobs(const Jobs&) = delete;
  Jobs& operator=(const Jobs&) = delete;
  void start();
  // What runs ends at its next page, blob or session, as cancelled; what waits is not begun.
  void stop();
  // For a caller without a thread, instead of start() and stop(): does the oldest job. False when none can begin.
  bool work_here();

  // From any thread. Nothing when too many wait.
  std::optional<JobId> add(JobKind kind, JobArguments arguments, std::optional<db::Actor> actor);
  [[nodiscard]] std::optional<JobInfo> find(JobId id) const;
  // Oldest first.
  [[nodiscard]] std::vector<JobInfo> list() const;
  // False when it has ended or there is none. One that waits has ended when this returns; one that runs ends soon.
  bool cancel(JobId id);
  [[nodiscard]] FileHealth file_health() const;
  // Counts up whenever list() or file_health() is another.
  [[nodiscard]] std::uint64_t changes() const { return changes_.load(std::memory_order_acquire); }
  // As long as the handle lives no job reads the database (but for moments, gives_way_to_deletion): a job that ran starts again after it. A deletion
  // needs that, because the log with the deleted data cannot be truncated while a reader still sees them. The handle must not
  // outlive this object.
  [[nodiscard]] std::shared_ptr<void> hold();
  // From any thread, after each deletion: no file and no figures that an ended job has made of recordings can be fetched any more, and a job
  // that has read the deleted session starts again.
  void forget_recordings();

 private:
  struct Entry {
    JobInfo info;
    JobArguments arguments;
    bool cancelled = false;
    std::uint64_t deletions = 0;  // deletions_ when it began
  };
  // The oldest that waits, unless something holds; under the lock.
  Entry* next();
  Entry* entry(JobId id);
  void run(JobId id);
  bool step(JobId id, double share);
  [[nodiscard]] bool overtaken(const Entry& running) const;
  void end(JobId id, JobResult result);
  void changed(Entry& entry);
  void forget_oldest();
  void main();

  Options options_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Entry> entries_;
  FileHealth health_;
  JobId last_id_ = 0;
  int holds_ = 0;
  std::uint64_t deletions_ = 0;
  bool ending_ = false;
  std::atomic<std::uint64_t> changes_ = 0;
  std::thread thread_;
};

}  // namespace hoist::server
