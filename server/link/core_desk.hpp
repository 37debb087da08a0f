// The server's link to the core: passes requests of clients on and matches the answers, reads what the core publishes,
// once per poll.
//
// One thread, no clock and no network of its own: `poll` is called by a timer and told the steady time, so tests run it in virtual time.
#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/commands.hpp"
#include "control/contract/shared_memory.hpp"
#include "control/contract/signals.hpp"
#include "control/contract/step_line.hpp"
#include "control/publish/server_link.hpp"
#include "server/contract/reasons.hpp"
#include "server/counters.hpp"
#include "server/link/clock_speed.hpp"

namespace hoist::server {

// How long a client waits for the core's answer. The core answers within two ticks; half a second is a core that is gone or stuck.
inline constexpr std::uint64_t kAnswerLimit_ns = 500'000'000;
// An acknowledgement waits for the drives to leave their fault state, which the core gives half a second.
inline constexpr std::uint64_t kAcknowledgeLimit_ns = 1'000'000'000;
// Commands that wait for room in the ring; more are refused at once.
inline constexpr std::size_t kOutboxLimit = 256;
// How long the answer to a change of settings waits for the disk. With kAnswerLimit_ns it stays below the 2 s for which the console waits.
inline constexpr std::uint64_t kStoreLimit_ns = 1'000'000'000;
// The core has said nothing for this long: it counts as not connected, whatever the socket says.
inline constexpr std::uint64_t kCoreSilence_ns = 500'000'000;
// In lock-step a busy computer may hold simulator or core up for as long as each waits for its partner (kStepSilence_ms); after twice that the
// core itself is stuck.
inline constexpr std::uint64_t kLockStepSilence_ns = 2'000'000ULL * contract::kStepSilence_ms;

struct CoreAnswer {
  enum class Kind : std::uint8_t { done, refused, unanswered, no_core, busy };
  Kind kind = Kind::no_core;
  std::uint32_t code = 0;  // first Refusal
  std::uint32_t bits = 0;  // all refusals
  std::uint32_t item = 0;  // the parameter in question
  double value = 0;
  std::optional<bool> stored = {};  // of a change of settings: false = in force, and not on the disk
  [[nodiscard]] bool done() const { return kind == Kind::done; }
};

// Hears what the core says. Called from within poll, in this order: ticks, state changes, events, answers. Of several
// listeners each hears one thing before the next thing is told, in the order in which they were added.
class CoreListener {
 public:
  virtual ~CoreListener() = default;
  virtual void on_core(bool connected) = 0;
  virtual void on_ticks(std::span<const contract::TickRecord> records, std::uint64_t lost) = 0;
  virtual void on_parameters(const contract::ParamsInForce& parameters) = 0;
  virtual void on_lease(std::uint32_t epoch, std::uint32_t holder) = 0;
  virtual void on_event(const contract::Event& event) = 0;
};

class CoreDesk {
 public:
  using Done = std::function<void(const CoreAnswer&)>;

  CoreDesk(std::string socket_path, Counters& counters);
  void add_listener(CoreListener& listener) { listeners_.push_back(&listener); }
  void clear_listeners() { listeners_.clear(); }
  // Called when something is asked, so that a timer that sleeps longer than a step is brought forward.
  void set_wake(std::function<void()> wake) { wake_ = std::move(wake); }

  // Attaches if needed, counts the heartbeat up, reads ticks, events and parameters, answers pending requests or times
  // them out.
  void poll(std::uint64_t now_ns);

  // Answers everything that is pending: at the end of the program.
  void close() { answer_all(CoreAnswer::Kind::no_core); }

  // Asks one thing. `done` is called exactly once, from a later poll or, when the core is away, before this returns. What changes settings is
  // answered when they are on the disk, or when they cannot be brought there. Returns the number that the core's events about it carry, 0 when
  // the core was not asked.
  std::uint32_t ask(contract::Command command, Done done);
  // Stages each value and commits them: all or nothing, one answer. Sealed for this version of the parameters, 0 = whichever is in force.
  std::uint32_t ask_parameters(const std::vector<std::pair<std::uint32_t, double>>& id_values, std::uint32_t version,
                               contract::Command commit, Done done);
  // STOP overtakes everything that waits. Never refused here; false only when no core is attached. While a STOP waits, another one is answered
  // with it and takes no room (decision 275).
  bool stop(std::uint32_t client, Done done);
  // The newest driving command. Not queued: only the latest counts. False when no core is connected.
  bool drive(const contract::DriveCommand& command);
  // Whether the newest driving command holds hold-to-run and its hand is no older than this (RemoteDrive::age_s).
  [[nodiscard]] bool hand_holds(std::uint64_t within_ns) const;

  // Whether the next step matters: a client holds the lease, or an answer is due. Else one look per batch of samples is enough.
  [[nodiscard]] bool urgent() const {
    return !connected_ || lease_holder_ != 0 || !pending_.empty() || !outbox_.empty() || !storing_.empty();
  }
  // How often all parameters were copied out of the shared memory: only when they are others (for tests).
  [[nodiscard]] std::uint64_t parameter_copies() const { return parameter_copies_; }
  [[nodiscard]] bool connected() const { return connected_; }
  // Why the core is not connected, in a sentence; empty while it is.
  [[nodiscard]] std::string_view problem() const;
  // The same for programs; nothing while it is connected.
  [[nodiscard]] std::optional<Reason> reason() const;
  [[nodiscard]] const std::optional<contract::TickRecord>& newest() const { return newest_; }
  // The run of the core that the newest step is of: steps of different runs do not compare. 0 before any.
  [[nodiscard]] std::uint64_t run() const { return ticks_.life(); }
  // Passes on the steps from this one to the newest, oldest first, as far as the shared ring still has them.
  void past(std::uint64_t from_tick, const std::function<void(const contract::TickRecord&)>& each) const;
  [[nodiscard]] const contract::ParamsInForce& parameters() const { return parameters_; }
  // Why what is in force is not on the disk; nothing while it is, and while it may still be on its way.
  [[nodiscard]] std::optional<contract::StoreProblem> store_problem() const;
  // Why the core's newest stops are not on the disk, so that a restart would forget them (H22); nothing while they are.
  [[nodiscard]] std::optional<contract::StoreProblem> stops_problem() const;
  [[nodiscard]] bool has_parameters() const { return parameters_.version != 0; }
  [[nodiscard]] std::uint32_t lease_epoch() const { return lease_epoch_; }
  [[nodiscard]] std::uint32_t lease_holder() const { return lease_holder_; }
  [[nodiscard]] const publish::ServerLink& link() const { return link_; }
  // What limits for the core's work are counted on: the steady time told to poll(), or the core's own time when a simulator gives it.
  [[nodiscard]] std::uint64_t clock_ns() const { return clock_ns_; }
  // Percent of real time, while simulated time runs slow.
  [[nodiscard]] std::optional<int> slow_time_percent() const { return speed_.slow_percent(); }

 private:
  struct Pending {
    std::uint64_t deadline_ns = 0;
    Done done;
    bool changes_settings = false;
    std::optional<contract::Event> staging_refusal;  // the staged row that was refused, kept until the set's own answer
  };
  struct Answered {
    Done done;
    CoreAnswer answer;
    bool changes_settings = false;
  };
  // In force with these parameters, and not known to be on the disk.
  struct Storing {
    Done done;
    CoreAnswer answer;
    std::uint64_t sequence = 0;
    std::uint64_t deadline_ns = 0;
  };

  std::uint32_t next_request();
  // The request of a STOP that the core has not taken and that no sent command follows; 0 when there is none.
  [[nodiscard]] std::uint32_t waiting_stop() const;
  void flush_outbox();
  bool send(contract::Command& command);
  void read_ticks(std::uint64_t now_ns);
  void look_at_clock();
  void read_events(std::vector<contract::Event>& events, std::vector<Answered>& answered);
  void read_parameters();
  void answer(Answered& answered);
  void answer_stored();
  void set_connected(bool connected);
  void set_lease(std::uint32_t epoch, std::uint32_t holder);
  void answer_all(CoreAnswer::Kind kind);

  publish::ServerLink link_;
  Counters& counters_;
  std::vector<CoreListener*> listeners_;
  std::function<void()> wake_;
  publish::TickReader ticks_;
  publish::EventReader events_;
  std::vector<contract::TickRecord> tick_buffer_;
  std::vector<contract::Event> event_buffer_;
  std::deque<contract::Command> outbox_;
  std::multimap<std::uint32_t, Pending> pending_;  // by request; several wait for one STOP
  std::map<std::uint32_t, std::uint32_t> staged_;  // request of a staged row -> request of its set
  std::uint32_t last_request_ = 0;
  std::uint64_t now_ns_ = 0, clock_ns_ = 0;
  ClockSpeed speed_;
  std::uint64_t life_ = 0;
  std::uint64_t heard_ns_ = 0;
  std::uint64_t hand_ns_ = 0;  // telemetry stamp that the newest driving command echoed
  bool hand_holds_ = false;
  bool connected_ = false;
  std::optional<contract::TickRecord> newest_;
  contract::ParamsInForce parameters_{};
  std::uint64_t parameters_sequence_ = 0;
  std::uint64_t parameters_ns_ = 0;  // when this sequence was first seen
  std::uint64_t parameter_copies_ = 0;
  contract::StoreReport store_{};
  std::vector<Storing> storing_;
  std::uint32_t lease_epoch_ = 0;
  std::uint32_t lease_holder_ = 0;
};

}  // namespace hoist::server
