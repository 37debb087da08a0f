// The recorder's thread: everything the core publishes goes into the database while something is being recorded, and every other use of
// the database runs here too, so that a slow disk never delays the network. Therapy goes on whatever the disk does.
#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "control/contract/shared_memory.hpp"
#include "control/publish/server_link.hpp"
#include "db/export/session_export.hpp"
#include "db/export/spool_file.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/session_types.hpp"
#include "db/store/session_writer.hpp"
#include "server/contract/notices.hpp"

namespace hoist::server {

// Jobs that wait for the recorder's thread; more are refused.
inline constexpr std::size_t kJobLimit = 64;
// A job that has waited longer than this is not done: its client has timed out or was refused.
inline constexpr std::uint64_t kJobWait_ns = 10'000'000'000;
// After motion the recording goes on for this long, so that the roll-out is in it.
inline constexpr double kAfterStandby_s = 3.0;
inline constexpr double kAfterStop_s = 10.0;
// Longest session in standby; the next one follows at once.
inline constexpr double kStandbySession_s = 600.0;

enum class RecordingState : std::uint8_t { idle, recording, failed };
[[nodiscard]] constexpr const char* recording_state_name(RecordingState state) {
  return state == RecordingState::idle ? "idle" : state == RecordingState::recording ? "recording" : "failed";
}
struct StandingNotice {
  NoticeName name{};
  std::string detail;  // for the engineer, English
  int percent = 0;     // fills {percent} in the text
  bool operator==(const StandingNotice&) const = default;
};
struct RecordingStatus {
  RecordingState state = RecordingState::idle;
  std::optional<db::SessionId> session;
  bool standby = false;  // the session is the time in standby with a patient chosen
  std::optional<std::int64_t> started_utc_ms;
  std::uint64_t samples = 0;
  std::optional<std::uint64_t> durable_tick;
  std::string detail;  // why it failed, in a sentence
  std::optional<db::ErrorKind> error;
  std::vector<StandingNotice> notices;
  bool operator==(const RecordingStatus&) const = default;
};

// An export under way, by number: the object itself stays on the recorder's thread.
using ExportId = std::uint64_t;
struct OpenedExport {
  ExportId id = 0;
  std::string content_type, file_name, etag;
};

// A marker as a client asks for it.
struct MarkerWish {
  std::string text;
  std::string kind{db::kMarkerKinds.front()};
};

// What a job may use, on the recorder's thread only. `database` is null while it cannot be opened; `why` says why.
class Records {
 public:
  virtual ~Records() = default;
  virtual db::Database* database() = 0;
  virtual std::string why() = 0;
  // This job has waited for too long: it must change nothing and answer that.
  [[nodiscard]] virtual bool late() const = 0;
  virtual db::Status begin_manual(std::optional<std::string> subject, std::string note) = 0;
  virtual db::Status end_manual() = 0;
  // Stored when it returns without an error, and never otherwise.
  virtual db::Status marker(db::SessionId session, const MarkerWish& wish, std::optional<db::Actor> actor) = 0;
  virtual RecordingStatus status() = 0;
  // Ends the use of the file, puts the prepared one (db/store/backup.hpp) in its place and opens that; where the old one is. Refused while a
  // session is recorded or the hoist moves; after an error the old one is in use again.
  virtual db::Result<std::filesystem::path> replace_file(const std::filesystem::path& prepared) = 0;
  // Needs a database. The export stays open until Recorder::close_export or the recorder's end.
  virtual db::Result<OpenedExport> open_export(db::SessionId session, const db::ExportOptions& options) = 0;
  // Replaces `out` by the next piece. False at the end.
  virtual db::Result<bool> export_piece(ExportId id, std::string& out) = 0;
  // The same export as a whole file, which is made over several calls: null until it is there. Equal ones are made once.
  virtual db::Result<std::shared_ptr<const db::SpoolFile>> export_file(ExportId id) = 0;
};

class Recorder {
 public:
  using Job = std::function<void(Records&)>;
  struct Options {
    std::filesystem::path file;
    std::string version;
    std::function<std::int64_t()> utc_ns;      // wall clock
    std::function<std::uint64_t()> steady_ns;  // the clock that the core uses on a real bus
    // Who is behind a client's number; called on the recorder's thread.
    db::SessionWriter::ActorOf actor_of = [](std::uint32_t) { return std::optional<db::Actor>{}; };
    // For tests: the SQLite VFS to use, and where lines for the log go instead of the error output.
    const char* vfs = nullptr;
    std::function<void(const std::string&)> log = {};
    // On the recorder's thread, when a file is ready to be recorded into: at the start, and a new one in place of a damaged one.
    std::function<void()> opened = {};
    // Keeps other readers away from a file that is being set up, as long as what it gives lives: another connection would find it without tables.
    // Called by start(), and on the recorder's thread for a new file in place of a damaged one; released when the file is ready or has failed.
    std::function<std::shared_ptr<void>()> setting_up = {};
  };
  // The link's readers are made here; the link itself is not used afterwards.
  Recorder(const publish::ServerLink& link, Options options);
  ~Recorder();
  // Takes the database's lock, and keeps it as long as the recorder lives. The error `busy`: another server records into this file, and two
  // would close each other's sessions. Any other error is left for the thread, which tells it and tries again.
  [[nodiscard]] db::Status claim();
  void start();
  // Commits, closes the open session and joins.
  void stop();
  // For a caller with its own clock, instead of start() and stop(): what the thread would do at its start, every 50 ms (one job included),
  // and at its end.
  void open_here();
  void pass_here();
  void finish_here();

  // From the network thread.
  void set_parameters(const contract::ParamsInForce& parameters);
  // Whether a core is attached to the link. After kAfterStop_s without one and without a step its session ends with its last step.
  void set_attached(bool attached) { attached_.store(attached, std::memory_order_relaxed); }
  // What the nodes have said of their programs: of sessions that begin from now on.
  void set_nodes(std::vector<db::NodeProgram> nodes);
  // What the next motion walks, as stored in the database; nothing = free.
  void set_exercise(std::optional<std::string> exercise_json);
  // The code of the patient whom motion is recorded for, and standby as long as there is one; nothing = not known. `file`: file() before the
  // patient was looked up; of a file that was replaced since, the patient is not known.
  void set_subject(std::optional<std::string> code, std::uint64_t file = 0);
  // Counts the times that a backup replaced the file. Its patients have other numbers, so the choice of a patient ends.
  [[nodiscard]] std::uint64_t file() const { return file_.load(std::memory_order_acquire); }
  // A check has found the file with this id damaged: it is set aside and a new one begun, as at a start; while a session is being recorded,
  // after its end, or as soon as it can no longer be stored.
  void set_aside(std::string file_id, std::string damage);
  [[nodiscard]] RecordingStatus status() const;
  // Counts up whenever status() is another.
  [[nodiscard]] std::uint64_t changes() const { return changes_.load(std::memory_order_acquire); }
  // False when too many wait; then the job is not run. A job and all that it holds is destroyed on the recorder's thread: nothing that
  // belongs to another thread may be in it (recorder_desk.hpp).
  [[nodiscard]] bool run(Job job);
  // Never refused, however many jobs wait.
  void close_export(ExportId id);

 private:
  class Work;
  void main();
  struct Waiting {
    Job job;
    std::uint64_t since_ns = 0;
  };
  // The oldest job, empty when there is none; under the lock.
  Waiting take_job();

  Options options_;
  std::unique_ptr<Work> work_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Waiting> jobs_;
  std::vector<ExportId> closed_exports_;
  bool ending_ = false;
  RecordingStatus status_;
  std::atomic<std::uint64_t> changes_ = 0;
  std::atomic<std::uint64_t> file_ = 0;
  std::atomic<bool> attached_ = true;
  contract::ParamsInForce parameters_{};
  std::optional<std::string> exercise_, subject_;
  std::vector<db::NodeProgram> nodes_;
  std::string damaged_file_, damage_;  // what set_aside said last; empty = nothing to do
  std::thread thread_;
};

}  // namespace hoist::server
