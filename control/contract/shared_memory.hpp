// The two segments between the core and the server, as they lie in memory. Both are sealed memfds handed over a Unix socket:
// the state segment is written by the core only (the server's mapping is read-only by seal), the command segment by the server.
// Everything is a 64-bit atomic word, written in the fence-free order that control/publish/seq_cell.hpp explains.
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "control/contract/check.hpp"
#include "control/contract/commands.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/journal.hpp"
#include "control/contract/loop_report.hpp"
#include "control/contract/params.hpp"
#include "control/contract/program_version.hpp"
#include "control/contract/signals.hpp"

namespace hoist::contract {

using Word = std::atomic<std::uint64_t>;
static_assert(Word::is_always_lock_free && sizeof(Word) == 8);

template <typename T>
inline constexpr std::size_t kWordsOf = (sizeof(T) + 7) / 8;

// One value with its sequence: odd while being written. `sequence / 2` is the number of the value, counted from 1.
template <typename T>
struct SeqSlot {
  Word sequence;
  std::array<Word, kWordsOf<T>> words;
};
// The last `Slots` values; number n (from 0) lies in slot n % Slots and carries sequence 2 (n + 1).
template <typename T, std::size_t Slots>
struct SeqRing {
  static constexpr std::size_t kSlots = Slots;
  alignas(64) Word written;  // values written so far
  alignas(64) std::array<SeqSlot<T>, Slots> slots;
};

struct ParamsInForce {
  std::uint64_t version = 0;                // rises by one with each change; those of two runs of the core do not meet
  std::uint64_t defaults_after_damage = 0;  // 1: defaults that replace damaged settings; must not be stored
  std::array<double, kParamCount> values{};
  std::array<double, kParamCount> kept{};  // the same, without what is only on trial: what the next start begins with
};

/// Why the newest attempt to store something has failed.
enum class StoreProblem : std::uint64_t { none = 0, no_file = 1, disk_full = 2, failed = 3 };
// How far the core's storing thread has come with ParamsInForce; the numbers are the sequences of that slot (SeqSlot).
struct StoreReport {
  std::uint64_t stored = 0;                   // the next start begins with the `kept` of this one: file and folder are synced
  std::uint64_t tried = 0;                    // newest attempt, successful or not
  StoreProblem problem = StoreProblem::none;  // of the newest attempt
};

constexpr std::uint64_t kStateMagic = 0x3145544154534948ULL;    // "HISTATE1", little endian
constexpr std::uint64_t kCommandMagic = 0x31444E414D4D4348ULL;  // "HCMMAND1"
// 20.48 s of ticks: a recorder that hangs for less loses nothing.
constexpr std::size_t kTickSlots = 2048, kEventSlots = 1024, kBusSlots = 16384, kCommandSlots = 64;
// As far back as the ticks; an image of the core comes each second, and before a step that may begin a motion.
constexpr std::size_t kJournalSlots = kTickSlots, kJournalCommandSlots = 1024, kImageSlots = 24;

/// What the core's times count: this computer's steady clock, or in lock-step the simulator's time, which a busy computer slows down.
enum class ClockKind : std::uint64_t { steady = 0, simulated = 1 };

struct SegmentHeader {
  Word magic;
  Word layout_hash;
  Word bytes;
  Word writer_pid;
  Word start_time_ns;           // the steady clock at the core's start; also tells two lives of the core apart
  Word start_utc_ns;            // wall clock at that moment: the anchor for people's time
  Word commands_taken;          // state segment only: how many commands of the attached server the core has read
  Word clock;                   // state segment only: ClockKind
  std::array<Word, 6> program;  // program_version() of the writer: text, ended by zeros
};
static_assert(sizeof(SegmentHeader::program) == kProgramVersion_chars);

struct StateSegment {
  SegmentHeader header;
  SeqSlot<ParamsInForce> params;
  alignas(64) SeqSlot<LoopReport> loop;    // once a second
  alignas(64) SeqSlot<StoreReport> store;  // written by the storing thread
  Word stops_problem;                      // StoreProblem of the stops that the next start must know (H22); written by the main thread
  SeqRing<TickRecord, kTickSlots> ticks;   // the newest slot is also the snapshot: one copy per tick
  SeqRing<Event, kEventSlots> events;
  SeqRing<BusRecord, kBusSlots> bus;
  SeqRing<JournalStep, kJournalSlots> journal;
  SeqRing<JournalCommand, kJournalCommandSlots> journal_commands;
  SeqRing<CoreImage, kImageSlots> images;
};

struct CommandSegment {
  SegmentHeader header;
  alignas(64) Word heartbeat;  // the server counts this up at every poll
  SeqSlot<DriveCommand> drive;
  SeqRing<Command, kCommandSlots> commands;
};

constexpr std::uint64_t layout_hash() {
  std::uint64_t hash = kHashStart;
  for (std::uint64_t part :
       {params_hash(), signals_hash(), faults_hash(), std::uint64_t{sizeof(StateSegment)}, std::uint64_t{sizeof(CommandSegment)},
        std::uint64_t{sizeof(ParamsInForce)}, std::uint64_t{sizeof(Command)}, std::uint64_t{kTickSlots}})
    hash = hash_number(hash, part);
  return hash;
}

}  // namespace hoist::contract
