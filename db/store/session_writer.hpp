// Records one session at a time. Appending only buffers (and commits by itself after half a second of samples); `commit` makes durable.
// Nothing is acknowledged before COMMIT has returned with synchronous = FULL. An error never loses what is buffered: it stays for the next
// commit, up to the limits below; beyond them new data is dropped and the gap is recorded. The caller goes on either way.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/commands.hpp"
#include "control/contract/journal.hpp"
#include "control/contract/signals.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

/// append_ticks commits by itself when this many samples wait: 0.5 s at 100 Hz.
inline constexpr std::size_t kCommitSamples = 50;
/// A stored chunk is complete with this many samples while recording (1 s), and after folding at the session's end (30 s).
inline constexpr std::size_t kLiveChunkSamples = 100, kFoldedChunkSamples = 3000;
/// Frames per stored bus chunk: while recording, and folded.
inline constexpr std::size_t kLiveBusFrames = 1000, kFoldedBusFrames = 30000;
/// What may wait in memory while the disk refuses: one minute of samples and frames.
inline constexpr std::size_t kMaxPendingSamples = 6000, kMaxPendingFrames = 120000, kMaxPendingRows = 10000, kMaxPendingImages = 16;

/// Ticks between two stored images of the core: one minute.
inline constexpr std::uint64_t kImageTicks = 6000;

/// What is safe on disk.
struct Durable {
  SessionId session = 0;
  std::uint64_t samples = 0;               ///< of this session
  std::optional<std::uint64_t> last_tick;  ///< newest durable tick
};

/// Why `missing` steps are not there, of which the core says that it never made `left_out`: "step_left_out" for all of
/// them, `otherwise` for none, "not_received+step_left_out" (with `otherwise` in the first place) when it cannot be
/// decided.
std::string missing_reason(std::uint64_t missing, std::uint64_t left_out, std::string_view otherwise = "not_received");

/// A record as its columns store it, in their order; false when it cannot be stored (not finite, out of range).
bool stored_row(const contract::TickRecord& record, std::span<std::int64_t, contract::kSignalCount> row);

class SessionWriter {
 public:
  /// `database` must outlive the writer and be used by this thread only. Sessions that an earlier run left open are closed with the reason
  /// "interrupted"; `interrupted()` names them. What an earlier run has not folded waits for fold_piece.
  static Result<SessionWriter> create(Database& database);

  SessionWriter(SessionWriter&&) noexcept;
  SessionWriter& operator=(SessionWriter&&) noexcept;
  ~SessionWriter();

  /// Starts a session; durable when it returns. Errors: wrong_state (one is open), bad_value, disk_full, io, busy.
  Result<SessionId> begin(const SessionStart& start);
  [[nodiscard]] bool recording() const;
  [[nodiscard]] SessionId session() const;  ///< 0 when none

  /// Samples in rising order of tick and time. A jump of the tick number is recorded as a gap: "step_left_out" as far as `missed_ticks` rose with
  /// it, else "not_received". A record with a NaN, an infinity or a value beyond the stored integers is left out and recorded as gap
  /// "not_finite" or "out_of_range"; both are counted, neither is an error. A tick that does not rise is bad_value and nothing after it is taken.
  Status append_ticks(std::span<const contract::TickRecord> records);
  Status append_events(std::span<const contract::Event> events);
  /// Names the actor of an event by its client's number, when the event is written; nothing for a number it does not know.
  using ActorOf = std::function<std::optional<Actor>(std::uint32_t client)>;
  void set_actor_of(ActorOf actor_of);
  Status append_bus(std::span<const contract::BusRecord> frames);
  /// What the steps were given, in rising order (else bad_value), with all their commands. Beyond one minute that waits, steps are left out: their
  /// numbers show it.
  Status append_journal(std::span<const contract::JournalStep> steps, std::span<const contract::JournalCommand> commands);
  /// After the journal up to its step. Stored are the first one, one each minute, and the first one after a hole in journal or frames, so that
  /// all but what is missing can be run again; any other is dropped.
  Status append_image(const contract::CoreImage& image);
  /// Says why ticks (inclusive) are missing; for stream "ticks" the samples go on at to_tick + 1.
  Status append_gap(std::string_view stream, std::uint64_t from_tick, std::uint64_t to_tick, std::string_view reason);
  Status append_marker(std::uint64_t tick, std::int64_t utc_ns, std::string_view text, std::optional<Actor> actor = {},
                       std::string_view kind = kMarkerKinds.front());
  /// A marker that is answered: commits it, or takes it back, so that what was refused is not stored by a later commit.
  Status store_marker(std::uint64_t tick, std::int64_t utc_ns, std::string_view text, std::optional<Actor> actor = {},
                      std::string_view kind = kMarkerKinds.front());
  /// The wall clock was set: from this moment of the steady clock on, this UTC counts.
  Status append_utc_anchor(std::uint64_t time_ns, std::int64_t utc_ns);

  /// Writes what waits and returns after COMMIT. Call at least each 0.5 s. With nothing waiting it costs nothing.
  Result<Durable> commit();
  [[nodiscard]] Durable durable() const;
  /// Commits and closes the session, which then waits for fold_piece. When it fails, the session stays open and the call may be repeated.
  Status close(CloseReason reason, std::int64_t ended_utc_ns);
  /// Joins the stored chunks of one group (30 s of samples, or as many frames or steps) of a session that has ended, in one transaction.
  /// The session reads the same before, between and after. False when nothing is left. After an error that session stays as
  /// it is until the next start.
  Result<bool> fold_piece();
  /// close and all pieces, for callers that have nothing else to do meanwhile.
  Status end(CloseReason reason, std::int64_t ended_utc_ns);

  [[nodiscard]] const std::vector<SessionId>& interrupted() const;
  [[nodiscard]] std::uint64_t refused_samples() const;  ///< left out: not finite, out of range, or no room
  [[nodiscard]] std::uint64_t failed_commits() const;

 private:
  struct State;
  explicit SessionWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace hoist::db
