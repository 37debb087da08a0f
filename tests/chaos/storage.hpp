// The server's side of a session: shared memory, the real recorder and store on a disk in memory that may fail, in the session's own
// virtual time. Invariant I9: acknowledged samples survive any crash, every gap is marked, time rises.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "control/core/types.hpp"
#include "control/publish/core_link.hpp"
#include "control/publish/server_link.hpp"
#include "control/publish/step_publisher.hpp"
#include "server/record/recorder.hpp"
#include "tests/support/crash_disk.hpp"

namespace hoist::chaos {

class Storage {
 public:
  explicit Storage(std::uint64_t seed);
  ~Storage();
  Storage(const Storage&) = delete;
  Storage& operator=(const Storage&) = delete;

  void core_started(std::uint64_t time_ns);
  /// What the control loop publishes before its step, and after it.
  void before_step(const core::CoreState& state, const core::TickInputs& inputs) { publisher_->before(state, inputs); }
  void publish(const core::TickInputs& inputs, const core::TickOutputs& outputs);
  /// Each 10 ms of virtual time; `time_ns` is the core's clock.
  void tick(std::uint64_t time_ns);

  void hang(bool hangs) { hangs_ = hangs; }
  /// The process is killed; another one begins later.
  void kill_server();
  void start_server();
  void fill_disk(bool full) { disk_.fill(full); }
  void fail_disk(double share) { disk_.fail(share); }
  /// Each write, truncation and sync takes this long; 0 ends it.
  void slow_disk(double seconds) { slow_s_ = seconds; }
  void lie(bool lies) { disk_.ignore_syncs(lies); }
  /// Power failure of server and disk; the core has its own fault.
  void cut_power();
  void jump_clock(double seconds) { utc_ns_ += static_cast<std::int64_t>(seconds * 1e9); }

  /// Ends the server as `killed` says and reads everything back; `again`: runs the sessions again, too (I15). What is wrong, or empty.
  [[nodiscard]] std::vector<std::string> verify(bool killed, bool again);
  /// That were acknowledged and found again.
  [[nodiscard]] std::uint64_t samples() const { return samples_; }
  /// Of all that are stored, those whose step was run again and gave the same bits; and those whose step could not be run.
  [[nodiscard]] std::uint64_t samples_again() const { return samples_again_; }
  [[nodiscard]] std::uint64_t samples_not_run() const { return samples_not_run_; }

 private:
  struct Kept {
    std::uint64_t tick, time_ns;
    float x_m, alpha_rad;
  };
  struct Acknowledged {
    std::uint64_t first_tick = 0, last_tick = 0;  // the first acknowledged one, and the newest
  };

  void note_acknowledged();
  void check_session(db::Database& database, std::int64_t session, const Acknowledged& acknowledged, std::vector<std::string>& wrong);

  void run_again(db::Database& database, std::vector<std::string>& wrong);

  tests::CrashDisk disk_;
  std::unique_ptr<publish::CoreLink> core_;
  std::unique_ptr<publish::StepPublisher> publisher_;
  std::unique_ptr<publish::ServerLink> link_;
  std::unique_ptr<server::Recorder> recorder_;
  std::map<std::uint64_t, std::vector<Kept>> published_;  // by life of the core
  std::map<std::int64_t, Acknowledged> acknowledged_;     // by session
  std::vector<std::string> damaged_;
  std::uint64_t life_ = 0, time_ns_ = 0, busy_until_ns_ = 0, ticks_ = 0, samples_ = 0, samples_again_ = 0, samples_not_run_ = 0;
  std::int64_t utc_ns_;
  double slow_s_ = 0;
  bool hangs_ = false, attached_ = false;
};

}  // namespace hoist::chaos
