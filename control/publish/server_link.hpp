// The server's end: attaches to a running core, comes back by itself when the core was restarted.
//
// ServerLink belongs to one thread. Readers may live in other threads: each has its own cursor and keeps the mapping alive until it
// has drained what a dead core left behind.
#pragma once
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>

#include "control/contract/commands.hpp"
#include "control/publish/ring.hpp"
#include "control/publish/segment.hpp"

namespace hoist::publish {

// The state segment that is attached now, shared by link and readers.
class SharedState {
 public:
  void set(std::shared_ptr<Mapping> mapping) {
    const std::lock_guard lock(mutex_);
    mapping_ = std::move(mapping);
  }
  std::shared_ptr<Mapping> get() const {
    const std::lock_guard lock(mutex_);
    return mapping_;
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<Mapping> mapping_;
};

// Why no core is attached. absent: no process listens on the socket; silent: connected, without an answer; taken: by another server.
enum class LinkProblem : std::uint8_t { none, absent, silent, gone, taken, other_build, refused, unreachable };

class ServerLink {
 public:
  // Of the ring of commands.
  static constexpr std::size_t kSlotsForStop = 8;
  explicit ServerLink(std::string socket_path);
  // Tries to attach when there is no core, notices when it is gone. Never blocks: asks at most every 100 ms, and a later call takes the
  // answer. A core that stands still has the question waiting. Returns attached().
  bool poll_connect();
  [[nodiscard]] bool attached() const { return static_cast<bool>(peer_); }
  // The core's start time: another number is another life of the core. 0 before the first attach.
  [[nodiscard]] std::uint64_t life() const { return life_; }
  [[nodiscard]] std::uint64_t start_time_ns() const { return life_; }
  [[nodiscard]] std::int64_t start_utc_ns() const { return start_utc_ns_; }
  // The core's times are the simulator's (contract::ClockKind).
  [[nodiscard]] bool simulated_clock() const { return simulated_clock_; }
  // Which source the core was built from, of the attached one or the last; empty before the first.
  [[nodiscard]] const std::string& program() const { return program_; }
  // Why no core is attached, in a sentence; empty while one is, and before the first attempt has ended.
  [[nodiscard]] const std::string& last_error() const { return error_; }
  [[nodiscard]] LinkProblem problem() const { return error_.empty() ? LinkProblem::none : problem_; }

  void beat() noexcept;
  // Gives the command its sequence and stores it. Returns the sequence, or 0 when no core is attached or it has not read the last ones: a STOP finds
  // a slot when nothing else does.
  std::uint64_t send(contract::Command& command) noexcept;
  // The request of the newest sent command, while that is a STOP and the core has not taken it; else 0.
  [[nodiscard]] std::uint32_t untaken_stop() const noexcept;
  void drive(const contract::DriveCommand& command) noexcept;
  // Its sequence, 0 when there is none yet.
  std::uint64_t params(contract::ParamsInForce& params) const;
  // The same sequence without the values; params() need not be asked while it stays the same.
  [[nodiscard]] std::uint64_t params_sequence() const;
  // How far the core has come with storing them; false before its first look.
  bool store(contract::StoreReport& report) const;
  // Why the core's newest stops are not stored; none when they are, and without a core.
  [[nodiscard]] contract::StoreProblem stops_problem() const;
  bool newest(contract::TickRecord& record) const;
  // How punctual the core's loop is; false before its first second.
  bool loop(contract::LoopReport& report) const;

  [[nodiscard]] std::shared_ptr<SharedState> shared_state() const { return shared_; }
  // For programs that hold both ends: attaches to a core in the same process.
  bool attach_directly(class CoreLink& core, std::string& error);

 private:
  bool create_commands();
  bool ask();
  bool take_answer();
  void adopt(std::shared_ptr<Mapping> state);
  void lose();
  bool fail(LinkProblem problem);  // what error_ says; false

  std::string socket_path_;
  std::shared_ptr<SharedState> shared_ = std::make_shared<SharedState>();
  Descriptor peer_;
  OwnedSegment command_;
  std::uint64_t asked_ns_ = 0;
  Descriptor asked_;      // a connection whose answer has not come yet,
  OwnedSegment offered_;  // and what it was offered
  std::shared_ptr<Mapping> state_;
  std::uint64_t life_ = 0;
  std::int64_t start_utc_ns_ = 0;
  bool simulated_clock_ = false;
  std::uint64_t sent_ = 0;
  std::uint32_t newest_stop_ = 0;  // the request of the newest sent command if that is a STOP, else 0
  std::uint64_t driven_ = 0;
  std::uint64_t next_try_ns_ = 0;
  std::string error_, program_;
  LinkProblem problem_ = LinkProblem::unreachable;  // what error_ says
};

enum class ReadFrom : std::uint8_t { newest, oldest };

// One consumer of one ring of the state segment.
template <typename T, auto Ring>
class StateReader {
 public:
  // Begins here and now with the attached core, or with the first one that comes.
  explicit StateReader(const ServerLink& link, ReadFrom from = ReadFrom::newest) : shared_(link.shared_state()), from_(from) {
    adopt(shared_->get());
  }

  struct Result {
    std::size_t count = 0;
    std::uint64_t lost = 0;  // overwritten before they could be read: an explicit gap before the values returned
  };
  // Copies what is new, oldest first. After the core died it first drains what is left, then moves on to the new core.
  Result read(std::span<T> out) {
    std::shared_ptr<Mapping> attached = shared_->get();
    if (mapping_ == nullptr) adopt(attached);
    if (mapping_ == nullptr) return {};
    RingRead got = ring_read(ring(), cursor_, out);
    if (got.count == 0 && got.lost == 0 && attached != mapping_ && attached != nullptr) {
      from_ = ReadFrom::oldest;  // a core that began while we were watching: all it has said counts
      adopt(attached);
      got = ring_read(ring(), cursor_, out);
    }
    return {got.count, got.lost};
  }
  // Which life of the core the values of the last read() came from; 0 before any.
  [[nodiscard]] std::uint64_t life() const { return life_; }
  [[nodiscard]] std::int64_t start_utc_ns() const { return start_utc_ns_; }
  [[nodiscard]] bool simulated_clock() const { return simulated_clock_; }
  [[nodiscard]] const std::string& program() const { return program_; }  // of that core

 private:
  auto& ring() const { return mapping_->template as<const contract::StateSegment>()->*Ring; }
  void adopt(std::shared_ptr<Mapping> mapping) {
    mapping_ = std::move(mapping);
    if (mapping_ == nullptr) return;
    const auto& header = mapping_->template as<const contract::StateSegment>()->header;
    life_ = header.start_time_ns.load(std::memory_order_relaxed);
    start_utc_ns_ = static_cast<std::int64_t>(header.start_utc_ns.load(std::memory_order_relaxed));
    simulated_clock_ = is_simulated_clock(header);
    program_ = program_of(header);
    const std::uint64_t written = ring().written.load(std::memory_order_acquire);
    const std::uint64_t slots = ring().kSlots;
    cursor_ = from_ == ReadFrom::newest ? written : written > slots ? written - slots : 0;
  }

  std::shared_ptr<SharedState> shared_;
  std::shared_ptr<Mapping> mapping_;
  ReadFrom from_;
  std::uint64_t cursor_ = 0;
  std::uint64_t life_ = 0;
  std::int64_t start_utc_ns_ = 0;
  bool simulated_clock_ = false;
  std::string program_;
};

using TickReader = StateReader<contract::TickRecord, &contract::StateSegment::ticks>;
using EventReader = StateReader<contract::Event, &contract::StateSegment::events>;
using BusReader = StateReader<contract::BusRecord, &contract::StateSegment::bus>;
using JournalReader = StateReader<contract::JournalStep, &contract::StateSegment::journal>;
using JournalCommandReader = StateReader<contract::JournalCommand, &contract::StateSegment::journal_commands>;
using ImageReader = StateReader<contract::CoreImage, &contract::StateSegment::images>;

}  // namespace hoist::publish
