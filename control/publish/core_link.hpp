// The core's end: the state segment it writes, the command segment it reads, and the socket where a server attaches.
//
// Three threads use it. The control thread calls the functions of the first group: no system call, no lock, no allocation.
// A helper thread calls serve(): it accepts one server at a time, checks its segment and swaps it in. The storing thread says how far the
// parameters are on the disk, which neither of the others waits for.
#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "control/contract/commands.hpp"
#include "control/publish/segment.hpp"

namespace hoist::publish {

class CoreLink {
 public:
  // Creates the state segment; listens on `socket_path` when it is not empty. Null on failure, with the reason in `error`.
  static std::unique_ptr<CoreLink> create(const std::string& socket_path, std::uint64_t start_time_ns, std::uint64_t start_utc_ns,
                                          std::string& error, contract::ClockKind clock = contract::ClockKind::steady);
  ~CoreLink();
  CoreLink(const CoreLink&) = delete;
  CoreLink& operator=(const CoreLink&) = delete;

  // The run of this core: the steady clock and the wall clock at its start.
  [[nodiscard]] std::uint64_t start_time_ns() const { return state().header.start_time_ns.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t start_utc_ns() const { return state().header.start_utc_ns.load(std::memory_order_relaxed); }

  // ---- control thread
  void publish_tick(const contract::TickRecord& record) noexcept;
  void publish_event(const contract::Event& event) noexcept;
  void publish_bus(const contract::BusRecord& record) noexcept;
  void publish_journal(const contract::JournalStep& step) noexcept;
  void publish_journal(const contract::JournalCommand& command) noexcept;
  void publish_image(const contract::CoreImage& image) noexcept;
  void publish_params(const contract::ParamsInForce& params) noexcept;
  void publish_loop(const contract::LoopReport& report) noexcept;
  // Begins one look at the server's memory; everything below then speaks of the same server. False when none is attached.
  // Each begin() must be followed by end(), after which the memory may be let go by the helper thread.
  bool begin() noexcept;
  void end() noexcept;
  // Number of the attached server, counted from 1; a new number means a new life with its own sequences.
  [[nodiscard]] std::uint64_t server_life() const noexcept { return life_; }
  [[nodiscard]] std::uint64_t heartbeat() const noexcept;
  // The commands since the last call, oldest first. A server that sent more than the ring holds loses the oldest; `lost` counts them.
  std::size_t read_commands(std::span<contract::Command> out, std::uint64_t& lost) noexcept;
  // True when the server stored a driving command since the last call.
  bool read_drive(contract::DriveCommand& command) noexcept;

  // ---- helper thread
  // Waits up to timeout_ms for something to do; returns a line for the log when something happened, else an empty
  // string. A socket that was deleted from its folder is created again, else no server could find this core.
  std::string serve(int timeout_ms);
  // Maps a command segment directly, for programs that hold both ends (tests, benchmarks).
  bool attach(int command_fd, std::string& error);
  void detach();
  /// Why the newest stops are not stored.
  void publish_stops_problem(contract::StoreProblem problem) noexcept;
  [[nodiscard]] int state_descriptor() const { return state_.descriptor.get(); }

  // ---- storing thread
  // What is in force, read back from the segment; its sequence, 0 when there is none yet.
  std::uint64_t params(contract::ParamsInForce& params) const;
  /// The sequence alone; odd while they are being written.
  [[nodiscard]] std::uint64_t params_sequence() const noexcept { return state().params.sequence.load(std::memory_order_acquire); }
  void publish_store(const contract::StoreReport& report) noexcept;

 private:
  CoreLink() = default;
  bool listen(std::string& error);
  [[nodiscard]] bool owns_path() const;
  std::string mend_socket();
  std::string refused(const std::string& why);
  [[nodiscard]] contract::StateSegment& state() const { return *state_.mapping->as<contract::StateSegment>(); }

  OwnedSegment state_;
  std::string socket_path_;
  Descriptor listener_, peer_;
  std::uint64_t socket_device_ = 0, socket_inode_ = 0;  // of the socket that this core made at socket_path_
  std::string socket_problem_, refusal_;                // as told last
  std::shared_ptr<Mapping> command_;                    // helper thread's hold on the attached segment

  // The swap: the helper publishes a pointer and waits until the control thread is not inside begin()..end() before it unmaps.
  std::atomic<const contract::CommandSegment*> offered_{nullptr};
  std::atomic<std::uint64_t> offered_life_{0};
  std::atomic<bool> inside_{false};

  const contract::CommandSegment* current_ = nullptr;  // control thread only, from here on
  std::uint64_t life_ = 0;
  std::uint64_t cursor_ = 0;
  std::uint64_t drive_sequence_ = 0;
  std::uint64_t params_number_ = 0;
  std::uint64_t loop_number_ = 0;
  std::uint64_t store_number_ = 0;  // storing thread only
};

}  // namespace hoist::publish
