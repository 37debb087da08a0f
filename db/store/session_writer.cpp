#include "db/store/session_writer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <string>
#include <utility>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/guided_path.hpp"
#include "control/contract/params.hpp"
#include "db/codec/bus_chunk.hpp"
#include "db/codec/column_chunk.hpp"
#include "db/codec/journal_chunk.hpp"
#include "db/store/actor_rows.hpp"
#include "db/store/chunk_source.hpp"
#include "db/store/column_layouts.hpp"
#include "db/store/deletion.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/session_checks.hpp"
#include "db/store/session_number.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/visits.hpp"

namespace hoist::db {
namespace {

using contract::BusRecord;
using contract::CoreImage;
using contract::Event;
using contract::EventKind;
using contract::JournalCommand;
using contract::JournalStep;
using contract::kSignalCount;
using contract::kSignals;
using contract::SignalInfo;
using contract::SignalType;
using contract::TickRecord;

// A step is a power of ten, so that a stored integer prints as an exact decimal.
consteval int decimals_of(double lsb) {
  double step = 1;
  for (int decimals = 0; decimals <= 9; ++decimals, step *= 10)
    if (lsb * step > 1 - 1e-9 && lsb * step < 1 + 1e-9) return decimals;
  throw "signals.def: a step must be a power of ten from 1e-9 to 1";
}
consteval std::array<int, kSignalCount> all_decimals() {
  std::array<int, kSignalCount> decimals{};
  for (std::size_t i = 0; i < kSignalCount; ++i) decimals[i] = decimals_of(kSignals[i].lsb);
  return decimals;
}
constexpr std::array kDecimals = all_decimals();
constexpr std::uint64_t kTick_ns = 10'000'000;
constexpr std::size_t kTickColumn = *contract::find_signal("tick"), kTimeColumn = *contract::find_signal("time_ns");
static_assert(kSignalCount <= kMaxChunkColumns);

constexpr std::string_view type_name(SignalType type) {
  switch (type) {
    case SignalType::u64:
      return "u64";
    case SignalType::u32:
      return "u32";
    case SignalType::i32:
      return "i32";
    case SignalType::f32:
      return "f32";
    case SignalType::u16:
      return "u16";
    case SignalType::u8:
      break;
  }
  return "u8";
}

std::vector<ColumnInfo> todays_layout() {
  std::vector<ColumnInfo> layout;
  for (std::size_t c = 0; c < kSignalCount; ++c)
    layout.push_back({std::string(kSignals[c].name), std::string(kSignals[c].unit), std::string(type_name(kSignals[c].type)),
                      kSignals[c].lsb, kDecimals[c]});
  return layout;
}

template <typename T>
T read_as(const TickRecord& record, const SignalInfo& signal) {
  T value;
  std::memcpy(&value, reinterpret_cast<const unsigned char*>(&record) + signal.offset, sizeof value);
  return value;
}

enum class Fit : std::uint8_t { ok, not_finite, out_of_range };
// Beyond 2^53 a double no longer counts in ones.
constexpr double kLargestScaled = 9007199254740992.0;

Fit to_integers(const TickRecord& record, std::span<std::int64_t, kSignalCount> out) {
  for (std::size_t c = 0; c < kSignalCount; ++c) {
    const SignalInfo& signal = kSignals[c];
    switch (signal.type) {
      case SignalType::u64: {
        const auto value = read_as<std::uint64_t>(record, signal);
        if (value > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) return Fit::out_of_range;
        out[c] = static_cast<std::int64_t>(value);
        break;
      }
      case SignalType::u32:
        out[c] = read_as<std::uint32_t>(record, signal);
        break;
      case SignalType::i32:
        out[c] = read_as<std::int32_t>(record, signal);
        break;
      case SignalType::f32: {
        const double scaled = static_cast<double>(read_as<float>(record, signal)) * decimal_scale(kDecimals[c]);
        if (!std::isfinite(scaled)) return Fit::not_finite;
        if (std::fabs(scaled) > kLargestScaled) return Fit::out_of_range;
        out[c] = std::llrint(scaled);
        break;
      }
      case SignalType::u16:
        out[c] = read_as<std::uint16_t>(record, signal);
        break;
      case SignalType::u8:
        out[c] = read_as<std::uint8_t>(record, signal);
        break;
    }
  }
  return Fit::ok;
}

// What `code` or `item` of an event means today; stored with it, because the tables may change.
std::string meaning(const Event& event) {
  switch (event.kind) {
    case EventKind::mode_changed:
      if (event.code < contract::kModes.size()) return std::string(contract::kModes[event.code].name);
      break;
    case EventKind::fault_raised:
    case EventKind::fault_cleared:
      for (const contract::FaultInfo& fault : contract::kFaults)
        if (fault.bit == event.code) return std::string(fault.name);
      break;
    case EventKind::command_refused:
      for (const contract::RefusalInfo& refusal : contract::kRefusals)
        if (refusal.bit == event.code) return std::string(refusal.name);
      break;
    case EventKind::guided_ended:
      return std::string(contract::guided_end_name(event.code));
    case EventKind::sync_input:
    case EventKind::alarm_paused:
      return event.code != 0 ? "on" : "off";
    case EventKind::parameter_changed:
    case EventKind::parameter_settled:
      if (const auto index = contract::find_param_id(event.item)) return std::string(contract::kParams[*index].name);
      break;
    case EventKind::node_changed:
    case EventKind::emergency:
      if (event.item < contract::kNodes.size()) return std::string(contract::kNodes[event.item].name);
      break;
    default:
      break;
  }
  return {};
}

struct PendingGap {
  std::string stream, reason;
  std::uint64_t from_tick = 0, to_tick = 0;
};
struct PendingAnchor {
  std::uint64_t time_ns = 0;
  std::int64_t utc_ns = 0;
};

}  // namespace

bool stored_row(const TickRecord& record, std::span<std::int64_t, kSignalCount> row) { return to_integers(record, row) == Fit::ok; }

struct SessionWriter::State {
  explicit State(Database& database)
      : handle(database.handle()),
        put_chunk(handle,
                  "INSERT INTO chunks (session_id, first_tick, last_tick, first_time_ns, last_time_ns, samples, directory, body) "
                  "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8) ON CONFLICT (session_id, first_tick) DO UPDATE SET last_tick = ?3, "
                  "first_time_ns = ?4, "
                  "last_time_ns = ?5, samples = ?6, directory = ?7, body = ?8"),
        put_bus(
            handle,
            "INSERT INTO bus_chunks (session_id, first_frame, frames, first_time_ns, last_time_ns, body) VALUES (?1, ?2, ?3, ?4, ?5, ?6) "
            "ON CONFLICT (session_id, first_frame) DO UPDATE SET frames = ?3, first_time_ns = ?4, last_time_ns = ?5, body = ?6"),
        put_journal(handle, "INSERT INTO journal_chunks (session_id, first_step, steps, body) VALUES (?1, ?2, ?3, ?4)"),
        put_image(handle, "INSERT INTO core_images (session_id, step, tick, bytes, body) VALUES (?1, ?2, ?3, ?4, ?5)"),
        put_event(handle,
                  "INSERT INTO events (session_id, number, tick, time_ns, kind, kind_name, code, bits, item, value, before, request_id, "
                  "name, actor_id) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14)"),
        put_gap(handle, "INSERT INTO gaps (session_id, number, stream, from_tick, to_tick, reason) VALUES (?1, ?2, ?3, ?4, ?5, ?6)"),
        put_marker(handle,
                   "INSERT INTO markers (session_id, number, tick, utc_ns, text, actor_id, kind) VALUES (?1, ?2, ?3, ?4, ?5, ?6, "
                   "nullif(?7, 'note'))"),
        put_anchor(handle, "INSERT OR REPLACE INTO utc_anchors (session_id, time_ns, utc_ns) VALUES (?1, ?2, ?3)"),
        count_commit(handle, "UPDATE seal SET commits = commits + 1 RETURNING file_id, commits"),
        seal(database.seal()),
        tail(kSignalCount) {}

  sqlite3* handle;
  Statement put_chunk, put_bus, put_journal, put_image, put_event, put_gap, put_marker, put_anchor, count_commit;
  std::shared_ptr<Seal> seal;  // null on a disk that has none
  Seal::Content sealed;        // as of the commit that is counted
  ChunkEncoder encoder;
  EncodedChunk encoded;
  Bytes bus_blob;
  JournalEncoder journal_encoder;
  Bytes journal_blob;
  std::vector<SessionId> interrupted;
  std::uint64_t refused_samples = 0, failed_commits = 0;

  // Sessions that have ended and are not folded, the oldest first, and where the next piece of that one begins.
  std::deque<SessionId> unfolded;
  enum class FoldStream : std::uint8_t { samples, frames, journal, none } fold_stream = FoldStream::samples;
  std::uint64_t fold_from = 0;  // tick, number of the frame, or step

  // The open session.
  SessionId session = 0;
  std::int64_t started_utc_ns = 0;
  std::uint64_t start_time_ns = 0;
  std::vector<std::vector<std::int64_t>> tail;  // samples since the newest complete chunk, by column; its first ones may be durable already
  std::size_t tail_durable = 0;
  std::size_t retry_at = 0;  // samples waiting at which append_ticks commits by itself
  std::uint64_t durable_samples = 0;
  std::optional<std::uint64_t> durable_tick;
  std::optional<std::uint64_t> last_tick, last_time_ns;
  std::uint64_t last_step_ns = 0;            // when last_tick was
  std::optional<std::uint32_t> last_missed;  // steps the core had left out by last_tick; absent when that is not known
  std::vector<BusRecord> bus_tail;           // frames since the newest complete bus chunk
  std::size_t bus_durable = 0;
  std::uint64_t bus_first = 0;
  std::uint64_t event_step = 0, frame_step = 0;  // of the newest one that came, stored or not
  std::vector<JournalStep> journal;
  std::vector<JournalCommand> journal_commands;
  std::vector<CoreImage> images;
  std::uint64_t journal_least = 0;            // least number that the next step may have
  std::optional<std::uint64_t> journal_next;  // step that comes next; absent at the beginning and after a hole
  std::uint64_t journal_whole_from = 0;       // step from which on nothing is missing
  struct {
    std::uint64_t step, tick;
  } last_image{};
  bool image_stored = false;
  std::vector<Event> events;
  ActorOf actor_of = [](std::uint32_t) { return std::optional<Actor>{}; };
  std::vector<PendingGap> gaps;
  std::vector<Marker> markers;
  std::vector<PendingAnchor> anchors;
  std::uint64_t event_number = 0, gap_number = 0, marker_number = 0;

  [[nodiscard]] std::size_t tail_samples() const { return tail[kTickColumn].size(); }
  [[nodiscard]] std::uint64_t newest_in_tail() const { return static_cast<std::uint64_t>(tail[kTickColumn].back()); }
  [[nodiscard]] std::size_t waiting() const { return tail_samples() - tail_durable; }
  [[nodiscard]] bool anything_waiting() const {
    return waiting() > 0 || bus_tail.size() > bus_durable || !events.empty() || !gaps.empty() || !markers.empty() || !anchors.empty() ||
           !journal.empty() || !images.empty();
  }

  void clear_session() {
    session = 0;
    for (auto& column : tail) column.clear();
    tail_durable = 0;
    retry_at = kCommitSamples;
    durable_samples = 0;
    durable_tick.reset();
    last_tick.reset();
    last_time_ns.reset();
    last_step_ns = 0;
    last_missed.reset();
    bus_tail.clear();
    bus_durable = 0;
    bus_first = 0;
    event_step = frame_step = 0;
    journal.clear();
    journal_commands.clear();
    images.clear();
    journal_least = 0;
    journal_next.reset();
    journal_whole_from = 0;
    image_stored = false;
    events.clear();
    gaps.clear();
    markers.clear();
    anchors.clear();
    event_number = gap_number = marker_number = 0;
  }

  void note_gap(std::string_view stream, std::uint64_t from_tick, std::uint64_t to_tick, std::string_view reason) {
    // Neighbours of one stream and reason become one row, also when the streams take turns: a disk that stays full costs a row per stream.
    const auto like =
        std::find_if(gaps.rbegin(), gaps.rend(), [&](const PendingGap& gap) { return gap.stream == stream && gap.reason == reason; });
    if (like != gaps.rend() && from_tick <= like->to_tick + 1 && from_tick >= like->from_tick) {
      like->to_tick = std::max(like->to_tick, to_tick);
      return;
    }
    // Many different gaps while the disk refuses: the newest row of the stream is stretched rather than memory grown.
    const auto same = std::find_if(gaps.rbegin(), gaps.rend(), [&](const PendingGap& gap) { return gap.stream == stream; });
    if (gaps.size() >= kMaxPendingRows && same != gaps.rend()) {
      same->from_tick = std::min(same->from_tick, from_tick);
      same->to_tick = std::max(same->to_tick, to_tick);
      return;
    }
    gaps.push_back({std::string(stream), std::string(reason), from_tick, to_tick});
  }

  // The step of a moment, counted from the newest step: steps follow the clock also where some were left out.
  [[nodiscard]] std::uint64_t step_at(std::uint64_t time_ns) const {
    if (!last_tick) return 0;
    const std::uint64_t ago = time_ns < last_step_ns ? (last_step_ns - time_ns) / kTick_ns : 0;
    return *last_tick - std::min(*last_tick, ago);
  }

  void write_tail() {
    const std::size_t total = tail_samples();
    std::vector<std::vector<std::int64_t>> part(kSignalCount);
    for (std::size_t begin = 0; begin < total; begin += kLiveChunkSamples) {
      const std::size_t count = std::min(kLiveChunkSamples, total - begin);
      if (begin + count <= tail_durable) continue;
      std::span<const std::vector<std::int64_t>> columns(tail);
      if (begin > 0) {
        for (std::size_t c = 0; c < kSignalCount; ++c)
          part[c].assign(tail[c].begin() + static_cast<std::ptrdiff_t>(begin),
                         tail[c].begin() + static_cast<std::ptrdiff_t>(begin + count));
        columns = part;
      }
      put_samples(columns, count, ChunkLayout::one_frame);
    }
  }

  void put_samples(std::span<const std::vector<std::int64_t>> columns, std::size_t count, ChunkLayout layout, SessionId into = 0,
                   std::size_t tick_column = kTickColumn, std::size_t time_column = kTimeColumn) {
    if (const CodecError error = encoder.encode(columns, count, layout, encoded); error != CodecError::none)
      throw SqlFailure{Error{ErrorKind::internal, std::string("packing samples: ") + codec_error_text(error), {}}};
    put_chunk.integer(1, into == 0 ? session : into)
        .integer(2, columns[tick_column][0])
        .integer(3, columns[tick_column][count - 1])
        .integer(4, columns[time_column][0])
        .integer(5, columns[time_column][count - 1])
        .unsigned_integer(6, count)
        .blob(7, encoded.directory)
        .blob(8, encoded.body)
        .run();
  }

  void write_bus_tail() {
    for (std::size_t begin = 0; begin < bus_tail.size(); begin += kLiveBusFrames) {
      const std::size_t count = std::min(kLiveBusFrames, bus_tail.size() - begin);
      if (begin + count <= bus_durable) continue;
      put_frames(std::span(bus_tail).subspan(begin, count), bus_first + begin, session);
    }
  }

  void put_frames(std::span<const BusRecord> frames, std::uint64_t first_frame, SessionId into) {
    if (const CodecError error = encode_bus(frames, bus_blob); error != CodecError::none)
      throw SqlFailure{Error{ErrorKind::internal, std::string("packing bus frames: ") + codec_error_text(error), {}}};
    put_bus.integer(1, into)
        .unsigned_integer(2, first_frame)
        .unsigned_integer(3, frames.size())
        .unsigned_integer(4, frames.front().time_ns)
        .unsigned_integer(5, frames.back().time_ns)
        .blob(6, bus_blob)
        .run();
  }

  void write_journal() {
    std::span<const JournalCommand> commands(journal_commands);
    for (std::size_t begin = 0; begin < journal.size(); begin += kFoldedChunkSamples) {
      const auto steps = std::span<const JournalStep>(journal).subspan(begin, std::min(kFoldedChunkSamples, journal.size() - begin));
      const auto later = std::ranges::upper_bound(commands, steps.back().step, {}, &JournalCommand::step);
      const auto count = static_cast<std::size_t>(later - commands.begin());
      put_steps(steps, commands.first(count), session);
      commands = commands.subspan(count);
    }
    for (const CoreImage& image : images) {
      const Bytes body = pack_bytes(ByteView(image.memory).first(image.bytes));
      if (body.empty()) throw SqlFailure{Error{ErrorKind::internal, "packing an image of the core: zstd failed", {}}};
      put_image.integer(1, session)
          .unsigned_integer(2, image.step)
          .unsigned_integer(3, image.tick)
          .unsigned_integer(4, image.bytes)
          .blob(5, body)
          .run();
    }
  }

  void put_steps(std::span<const JournalStep> steps, std::span<const JournalCommand> commands, SessionId into) {
    if (const CodecError error = journal_encoder.encode(steps, commands, journal_blob); error != CodecError::none)
      throw SqlFailure{Error{ErrorKind::internal, std::string("packing the journal: ") + codec_error_text(error), {}}};
    put_journal.integer(1, into).unsigned_integer(2, steps.front().step).unsigned_integer(3, steps.size()).blob(4, journal_blob).run();
  }

  void write_rows() {
    std::uint64_t number = event_number;
    for (const Event& event : events) {
      const std::string name = meaning(event);
      bind_actor(put_event, 14, handle, event.client == 0 ? std::nullopt : actor_of(event.client));
      put_event.integer(1, session)
          .unsigned_integer(2, number++)
          .unsigned_integer(3, event.tick)
          .unsigned_integer(4, event.time_ns)
          .integer(5, static_cast<std::int64_t>(event.kind))
          .text(6, contract::event_name(event.kind))
          .integer(7, event.code)
          .integer(8, event.bits)
          .integer(9, event.item)
          .real(10, event.value)
          .real(11, event.before)
          .integer(12, event.request_id)
          .text(13, std::string_view(name))
          .run();
    }
    number = gap_number;
    for (const PendingGap& gap : gaps)
      put_gap.integer(1, session)
          .unsigned_integer(2, number++)
          .text(3, std::string_view(gap.stream))
          .unsigned_integer(4, gap.from_tick)
          .unsigned_integer(5, gap.to_tick)
          .text(6, std::string_view(gap.reason))
          .run();
    number = marker_number;
    for (const Marker& marker : markers) {
      bind_actor(put_marker, 6, handle, marker.actor);
      put_marker.integer(1, session)
          .unsigned_integer(2, number++)
          .unsigned_integer(3, marker.tick)
          .integer(4, marker.utc_ns)
          .text(5, std::string_view(marker.text))
          .text(7, std::string_view(marker.kind))
          .run();
    }
    for (const PendingAnchor& anchor : anchors)
      put_anchor.integer(1, session).unsigned_integer(2, anchor.time_ns).integer(3, anchor.utc_ns).run();
  }

  // Commits what is recorded, and says so beside the file once it is durable.
  void commit_sealed(Transaction& transaction, SessionId of, std::optional<std::uint64_t> newest_tick) {
    count_commit.reset();
    if (!count_commit.step()) throw SqlFailure{Error{ErrorKind::corrupt, "the database has no seal", {}}};
    sealed = {count_commit.text_at(0), count_commit.unsigned_at(1), of, newest_tick.value_or(0)};
    count_commit.run();
    transaction.commit();
    if (seal) seal->write(sealed);
  }

  // Everything that waits, in one transaction. Buffers change only after COMMIT came back.
  Status write_all() {
    if (!anything_waiting()) return {};
    const Status written = guarded([&]() -> Status {
      Transaction transaction(handle, Transaction::Kind::write);
      write_tail();
      write_bus_tail();
      write_journal();
      write_rows();
      commit_sealed(transaction, session, tail_samples() > 0 ? std::optional(newest_in_tail()) : durable_tick);
      return {};
    });
    if (!written) {
      ++failed_commits;
      reset_statements();
      retry_at = waiting() + kCommitSamples;
      return written;
    }
    if (const std::size_t total = tail_samples(); total > 0) {
      durable_samples += total - tail_durable;
      durable_tick = newest_in_tail();
      const std::size_t complete = total / kLiveChunkSamples * kLiveChunkSamples;
      if (complete > 0)
        for (auto& column : tail) column.erase(column.begin(), column.begin() + static_cast<std::ptrdiff_t>(complete));
      tail_durable = total - complete;
    }
    const std::size_t complete_frames = bus_tail.size() / kLiveBusFrames * kLiveBusFrames;
    bus_tail.erase(bus_tail.begin(), bus_tail.begin() + static_cast<std::ptrdiff_t>(complete_frames));
    bus_first += complete_frames;
    bus_durable = bus_tail.size();
    journal.clear();
    journal_commands.clear();
    images.clear();
    event_number += events.size();
    gap_number += gaps.size();
    marker_number += markers.size();
    events.clear();
    gaps.clear();
    markers.clear();
    anchors.clear();
    retry_at = kCommitSamples;
    return {};
  }

  void reset_statements() {
    for (Statement* statement :
         {&put_chunk, &put_bus, &put_journal, &put_image, &put_event, &put_gap, &put_marker, &put_anchor, &count_commit})
      statement->reset();
  }

  // Closes a session in the database: totals, end, reason.
  void close_rows(SessionId id, std::int64_t ended_utc_ns, CloseReason reason) {
    Transaction transaction(handle, Transaction::Kind::write);
    Statement statement(handle,
                        "UPDATE sessions SET ended_utc_ns = ?2, close_reason = ?3, "
                        "sample_count = (SELECT coalesce(sum(samples), 0) FROM chunks WHERE session_id = ?1), "
                        "first_time_ns = (SELECT min(first_time_ns) FROM chunks WHERE session_id = ?1), "
                        "last_time_ns = (SELECT max(last_time_ns) FROM chunks WHERE session_id = ?1) WHERE id = ?1");
    statement.integer(1, id).integer(2, ended_utc_ns).text(3, std::string_view(close_reason_name(reason))).run();
    commit_sealed(transaction, id, durable_tick);
  }

  // What the seal knows and the file does not: the rest of its session is a gap, its number stays taken. Done once: then the file counts as many.
  void note_loss(const LostCommits& lost) {
    Transaction transaction(handle, Transaction::Kind::write);
    Statement gap(
        handle,
        "INSERT INTO gaps (session_id, number, stream, from_tick, to_tick, reason) "
        "SELECT ?1, (SELECT coalesce(max(number) + 1, 0) FROM gaps WHERE session_id = ?1), 'ticks', newest + 1, ?2, 'storage_lost' "
        "FROM (SELECT max(last_tick) AS newest FROM chunks WHERE session_id = ?1) WHERE newest < ?2");
    gap.integer(1, lost.session).unsigned_integer(2, lost.last_tick).run();
    take_session_numbers(handle, lost.session);
    Statement count(handle, "UPDATE seal SET commits = commits + ?1");
    count.unsigned_integer(1, lost.commits).run();
    commit_sealed(transaction, lost.session, lost.last_tick);
  }

  // Small live chunks become large ones with a frame per column, a group of them in each piece. A crash between two pieces leaves a session that
  // reads the same, and the next start goes on. A damaged chunk stays where it is. False once nothing is left.
  bool fold_piece() {
    if (unfolded.empty()) return false;
    const SessionId id = unfolded.front();
    // From the beginning: another connection may delete the session.
    Transaction transaction(handle, Transaction::Kind::write);
    Statement there(handle, "SELECT 1 FROM sessions WHERE id = ?1");
    bool whole = !there.integer(1, id).step();
    there.reset();
    if (!whole && !fold_group(id)) {
      fold_from = 0;
      fold_stream = static_cast<FoldStream>(static_cast<int>(fold_stream) + 1);
      whole = fold_stream == FoldStream::none;
      if (whole) Statement(handle, "UPDATE sessions SET folded = 1 WHERE id = ?1").integer(1, id).run();
    }
    transaction.commit();
    if (!whole) return true;
    leave_fold();
    truncate_log(handle);
    return !unfolded.empty();
  }

  void leave_fold() {
    unfolded.pop_front();
    fold_stream = FoldStream::samples;
    fold_from = 0;
  }

  // The next group of the stream; false when there is none.
  bool fold_group(SessionId id) {
    switch (fold_stream) {
      case FoldStream::samples:
        return fold_samples(id);
      case FoldStream::frames:
        return fold_bus(id);
      case FoldStream::journal:
        return fold_journal(id);
      case FoldStream::none:
        break;
    }
    return false;
  }

  bool fold_samples(SessionId id) {
    const std::vector<ColumnInfo> layout = layout_of(handle, id);
    const auto tick_column = find_column(layout, "tick"), time_column = find_column(layout, "time_ns");
    if (!tick_column || !time_column) return false;
    std::vector<std::size_t> which(layout.size());
    for (std::size_t i = 0; i < which.size(); ++i) which[i] = i;
    Statement rows(handle, "SELECT id, samples, first_tick FROM chunks WHERE session_id = ?1 AND first_tick >= ?2 ORDER BY first_tick");
    rows.integer(1, id).unsigned_integer(2, fold_from);
    ChunkSource source(handle, id, layout.size());
    std::vector<std::vector<std::int64_t>> group(layout.size()), values;
    std::vector<std::int64_t> taken;
    bool any = false, large = false;
    while (rows.step()) {
      if (!taken.empty() && group[0].size() + static_cast<std::size_t>(rows.integer_at(1)) > kFoldedChunkSamples) break;
      any = true;
      const std::uint64_t first_tick = rows.unsigned_at(2);
      fold_from = first_tick + 1;
      try {
        const auto chunk = source.at_or_after(first_tick);
        if (!chunk || chunk->row != rows.integer_at(0)) break;
        source.load(*chunk, which, values);
        large = chunk->directory.layout == ChunkLayout::frame_per_column;
      } catch (const SqlFailure& failure) {
        if (failure.error.kind != ErrorKind::corrupt) throw;
        break;
      }
      for (std::size_t c = 0; c < group.size(); ++c) group[c].insert(group[c].end(), values[c].begin(), values[c].end());
      taken.push_back(rows.integer_at(0));
    }
    rows.reset();
    const bool done = taken.empty() || (taken.size() == 1 && large);
    if (done || group[0].size() > kMaxChunkSamples) return any;
    Statement remove(handle, "DELETE FROM chunks WHERE id = ?1");
    for (const std::int64_t row : taken) remove.integer(1, row).run();
    put_samples(group, group[0].size(), ChunkLayout::frame_per_column, id, *tick_column, *time_column);
    return true;
  }

  bool fold_bus(SessionId id) {
    Statement rows(handle,
                   "SELECT id, first_frame, frames, body FROM bus_chunks WHERE session_id = ?1 AND first_frame >= ?2 ORDER BY first_frame");
    rows.integer(1, id).unsigned_integer(2, fold_from);
    std::vector<BusRecord> group;
    std::vector<std::int64_t> taken;
    std::uint64_t first_frame = 0;
    bool any = false;
    while (rows.step()) {
      if (!taken.empty() && group.size() + static_cast<std::size_t>(rows.integer_at(2)) > kFoldedBusFrames) break;
      any = true;
      fold_from = rows.unsigned_at(1) + 1;
      const std::size_t before = group.size();
      if (decode_bus(rows.blob_at(3), group) != CodecError::none) {
        group.resize(before);
        break;
      }
      if (taken.empty()) first_frame = rows.unsigned_at(1);
      taken.push_back(rows.integer_at(0));
    }
    rows.reset();
    if (taken.size() < 2 || group.size() > kMaxBusChunkFrames) return any;
    Statement remove(handle, "DELETE FROM bus_chunks WHERE id = ?1");
    for (const std::int64_t row : taken) remove.integer(1, row).run();
    put_frames(group, first_frame, id);
    return true;
  }

  bool fold_journal(SessionId id) {
    Statement rows(handle,
                   "SELECT id, first_step, steps, body FROM journal_chunks WHERE session_id = ?1 AND first_step >= ?2 ORDER BY first_step");
    rows.integer(1, id).unsigned_integer(2, fold_from);
    std::vector<JournalStep> steps;
    std::vector<JournalCommand> commands;
    std::vector<std::int64_t> taken;
    bool any = false;
    while (rows.step()) {
      if (!taken.empty() && steps.size() + static_cast<std::size_t>(rows.integer_at(2)) > kFoldedChunkSamples) break;
      any = true;
      fold_from = rows.unsigned_at(1) + 1;
      if (decode_journal(rows.blob_at(3), steps, commands) != CodecError::none) break;
      taken.push_back(rows.integer_at(0));
    }
    rows.reset();
    if (taken.size() < 2 || steps.size() > kMaxChunkSamples || commands.size() > kMaxJournalCommands) return any;
    Statement remove(handle, "DELETE FROM journal_chunks WHERE id = ?1");
    for (const std::int64_t row : taken) remove.integer(1, row).run();
    put_steps(steps, commands, id);
    return true;
  }

  // Sessions an earlier run left open end with their last sample.
  void close_interrupted() {
    struct Open {
      SessionId id;
      std::int64_t ended_utc_ns;
    };
    std::vector<Open> open;
    {
      Statement statement(
          handle,
          "SELECT id, started_utc_ns + coalesce((SELECT max(last_time_ns) FROM chunks WHERE session_id = sessions.id) - start_time_ns, 0) "
          "FROM sessions WHERE ended_utc_ns IS NULL ORDER BY id");
      while (statement.step()) open.push_back({statement.integer_at(0), statement.integer_at(1)});
    }
    for (const Open& one : open) {
      close_rows(one.id, one.ended_utc_ns, CloseReason::interrupted);
      interrupted.push_back(one.id);
    }
    Statement statement(handle, "SELECT id FROM sessions WHERE folded = 0 AND ended_utc_ns IS NOT NULL ORDER BY id");
    while (statement.step()) unfolded.push_back(statement.integer_at(0));
  }
};

SessionWriter::SessionWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
SessionWriter::SessionWriter(SessionWriter&&) noexcept = default;
SessionWriter& SessionWriter::operator=(SessionWriter&&) noexcept = default;
SessionWriter::~SessionWriter() = default;

Result<SessionWriter> SessionWriter::create(Database& database) {
  return guarded([&]() -> Result<SessionWriter> {
    auto state = std::make_unique<State>(database);
    state->clear_session();
    if (database.report().lost) state->note_loss(*database.report().lost);
    state->close_interrupted();
    return SessionWriter(std::move(state));
  });
}

bool SessionWriter::recording() const { return state_->session != 0; }
SessionId SessionWriter::session() const { return state_->session; }
const std::vector<SessionId>& SessionWriter::interrupted() const { return state_->interrupted; }
std::uint64_t SessionWriter::refused_samples() const { return state_->refused_samples; }
std::uint64_t SessionWriter::failed_commits() const { return state_->failed_commits; }
Durable SessionWriter::durable() const { return {state_->session, state_->durable_samples, state_->durable_tick}; }

std::string missing_reason(std::uint64_t missing, std::uint64_t left_out, std::string_view otherwise) {
  constexpr std::string_view kLeftOut = "step_left_out";
  if (left_out >= missing) return std::string(kLeftOut);
  return left_out == 0 ? std::string(otherwise) : std::string(otherwise) + '+' + std::string(kLeftOut);
}

namespace {
void write_nodes(sqlite3* handle, SessionId session, std::span<const NodeProgram> nodes) {
  Statement row(handle,
                "INSERT INTO node_programs (session_id, position, name, product, revision, version, crc) "
                "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)");
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    row.integer(1, session).unsigned_integer(2, n).text(3, std::string_view(nodes[n].name));
    int at = 4;
    for (const auto& number : {nodes[n].product, nodes[n].revision, nodes[n].version, nodes[n].crc}) {
      if (number)
        row.unsigned_integer(at, *number);
      else
        row.null(at);
      ++at;
    }
    row.run();
  }
}

Error no_session() { return {ErrorKind::wrong_state, "no session is being recorded", {}}; }
}  // namespace

Result<SessionId> SessionWriter::begin(const SessionStart& start) {
  State& s = *state_;
  if (s.session != 0) return Error{ErrorKind::wrong_state, "session " + std::to_string(s.session) + " is being recorded already", {}};
  if (Status checked = check_subject(start.subject); !checked) return checked.error();
  if (Status checked = check_note(start.note); !checked) return checked.error();
  if (start.exercise_json)
    if (Status checked = check_exercise(*start.exercise_json); !checked) return checked.error();
  if (!start.parameter_values.empty() && start.parameter_values.size() != contract::kParamCount)
    return Error{ErrorKind::bad_value, "parameter_values must hold " + std::to_string(contract::kParamCount) + " values, or none",
                 "parameter_values"};
  for (const double value : start.parameter_values)
    if (!std::isfinite(value)) return Error{ErrorKind::bad_value, "parameter_values must be finite", "parameter_values"};
  return guarded([&]() -> Result<SessionId> {
    s.clear_session();
    Transaction transaction(s.handle, Transaction::Kind::write);
    Statement insert(s.handle,
                     "INSERT INTO sessions (visit_id, started_utc_ns, start_time_ns, core_start_time_ns, simulated, layout_hash, "
                     "software_version, note, exercise, core_version, columns_hash, standby, hoist_id) "
                     "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, (SELECT id FROM hoist)) RETURNING id");
    if (start.subject)
      insert.integer(1, visit_row(s.handle, *start.subject, start.started_utc_ns));
    else
      insert.null(1);
    insert.integer(2, start.started_utc_ns)
        .unsigned_integer(3, start.start_time_ns)
        .unsigned_integer(4, start.core_start_time_ns)
        .integer(5, start.simulated ? 1 : 0)
        .unsigned_integer(6, start.layout_hash)
        .text(7, std::string_view(start.software_version))
        .text(8, std::string_view(start.note))
        .text(9, start.exercise_json)
        .text(10, start.core_version)
        .integer(11, layout_row(s.handle, todays_layout()))
        .integer(12, start.standby ? 1 : 0);
    if (!insert.step()) throw SqlFailure{Error{ErrorKind::internal, "the new session got no number", {}}};
    const SessionId id = insert.integer_at(0);
    insert.reset();
    Statement parameter(s.handle, "INSERT INTO parameters (session_id, position, name, value) VALUES (?1, ?2, ?3, ?4)");
    for (std::size_t p = 0; p < start.parameter_values.size(); ++p)
      parameter.integer(1, id).unsigned_integer(2, p).text(3, contract::kParams[p].name).real(4, start.parameter_values[p]).run();
    write_nodes(s.handle, id, start.nodes);
    s.commit_sealed(transaction, id, std::nullopt);
    s.session = id;
    s.started_utc_ns = start.started_utc_ns;
    s.start_time_ns = start.start_time_ns;
    return id;
  });
}

Status SessionWriter::append_ticks(std::span<const TickRecord> records) {
  State& s = *state_;
  if (s.session == 0) return no_session();
  Status result;
  std::array<std::int64_t, kSignalCount> row{};
  for (const TickRecord& record : records) {
    if (s.last_tick && record.tick <= *s.last_tick)
      return Error{ErrorKind::bad_value, "tick " + std::to_string(record.tick) + " does not follow tick " + std::to_string(*s.last_tick),
                   "tick"};
    const Fit fit = to_integers(record, row);
    if (s.last_tick && record.tick > *s.last_tick + 1) {
      const std::uint32_t left_out = s.last_missed ? record.missed_ticks - *s.last_missed : 0;
      s.note_gap("ticks", *s.last_tick + 1, record.tick - 1, missing_reason(record.tick - 1 - *s.last_tick, left_out));
    }
    s.last_tick = record.tick;
    s.last_step_ns = record.time_ns;
    s.last_missed = record.missed_ticks;
    const bool time_rises = !s.last_time_ns || record.time_ns > *s.last_time_ns;
    if (fit != Fit::ok || !time_rises || s.waiting() >= kMaxPendingSamples) {
      ++s.refused_samples;
      s.note_gap("ticks", record.tick, record.tick,
                 fit == Fit::not_finite     ? "not_finite"
                 : fit == Fit::out_of_range ? "out_of_range"
                 : !time_rises              ? "time_not_rising"
                                            : "storage");
      continue;
    }
    s.last_time_ns = record.time_ns;
    for (std::size_t c = 0; c < kSignalCount; ++c) s.tail[c].push_back(row[c]);
    // Long spans do not fill the buffer while the disk is well.
    if (result.ok() && s.waiting() >= std::max(s.retry_at, kFoldedChunkSamples)) result = s.write_all();
  }
  if (result.ok() && s.waiting() >= s.retry_at) result = s.write_all();
  return result;
}

Status SessionWriter::append_events(std::span<const Event> events) {
  State& s = *state_;
  if (s.session == 0) return no_session();
  for (const Event& event : events) {
    // From the step after the event before, so that steps without events divide no gap.
    if (s.events.size() >= kMaxPendingRows)
      s.note_gap("events", std::min(event.tick, s.event_step + 1), event.tick, "storage");
    else
      s.events.push_back(event);
    s.event_step = event.tick;
  }
  return {};
}

Status SessionWriter::append_bus(std::span<const BusRecord> frames) {
  State& s = *state_;
  if (s.session == 0) return no_session();
  const std::size_t room = kMaxPendingFrames > s.bus_tail.size() ? kMaxPendingFrames - s.bus_tail.size() : 0;
  const std::size_t taken = std::min(room, frames.size());
  s.bus_tail.insert(s.bus_tail.end(), frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(taken));
  if (taken > 0) s.frame_step = s.step_at(frames[taken - 1].time_ns);
  if (taken < frames.size()) {
    const std::uint64_t from = std::min(s.step_at(frames[taken].time_ns), s.frame_step + 1);
    s.frame_step = s.step_at(frames.back().time_ns);
    s.note_gap("bus", from, std::max(from, s.frame_step), "storage");
    s.journal_next.reset();
  }
  return {};
}

Status SessionWriter::append_journal(std::span<const JournalStep> steps, std::span<const JournalCommand> commands) {
  State& s = *state_;
  if (s.session == 0) return no_session();
  for (const JournalStep& step : steps) {
    if (step.step < s.journal_least) return Error{ErrorKind::bad_value, "steps must rise", "step"};
    s.journal_least = step.step + 1;
    if (s.journal.size() >= kMaxPendingSamples || s.journal_commands.size() + step.commands > kMaxPendingRows) {
      s.journal_next.reset();
      continue;
    }
    if (s.journal_next != step.step) s.journal_whole_from = step.step;
    s.journal_next = step.step + 1;
    s.journal.push_back(step);
    const auto first = std::ranges::lower_bound(commands, step.step, {}, &JournalCommand::step);
    const auto last = std::ranges::upper_bound(commands, step.step, {}, &JournalCommand::step);
    s.journal_commands.insert(s.journal_commands.end(), first, last);
  }
  return {};
}

Status SessionWriter::append_image(const CoreImage& image) {
  State& s = *state_;
  if (s.session == 0) return no_session();
  if (image.bytes > image.memory.size()) return Error{ErrorKind::bad_value, "an image of the core is too large", "bytes"};
  const bool after_hole = !s.image_stored || s.last_image.step < s.journal_whole_from;
  const bool due = after_hole || (image.step > s.last_image.step && image.tick >= s.last_image.tick + kImageTicks);
  if (!s.journal_next || image.step < s.journal_whole_from || !due || s.images.size() == kMaxPendingImages) return {};
  s.images.push_back(image);
  s.last_image = {image.step, image.tick};
  s.image_stored = true;
  return {};
}

Status SessionWriter::append_gap(std::string_view stream, std::uint64_t from_tick, std::uint64_t to_tick, std::string_view reason) {
  State& s = *state_;
  if (s.session == 0) return no_session();
  if (stream != "ticks" && stream != "events" && stream != "bus")
    return Error{ErrorKind::bad_value, "stream must be ticks, events or bus", "stream"};
  if (to_tick < from_tick || to_tick > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
    return Error{ErrorKind::bad_value, "to_tick must be from_tick or later", "to_tick"};
  if (reason.empty() || reason.size() > kMaxMarker_bytes) return Error{ErrorKind::bad_value, "reason must have 1 to 500 bytes", "reason"};
  s.note_gap(stream, from_tick, to_tick, reason);
  if (stream == "bus") s.journal_next.reset();  // a step without its frames cannot be run again
  if (stream == "ticks" && (!s.last_tick || to_tick > *s.last_tick)) {
    if (s.last_tick) s.last_step_ns += (to_tick - *s.last_tick) * kTick_ns;
    s.last_tick = to_tick;
    s.last_missed.reset();
  }
  return {};
}

void SessionWriter::set_actor_of(ActorOf actor_of) { state_->actor_of = std::move(actor_of); }

Status SessionWriter::append_marker(std::uint64_t tick, std::int64_t utc_ns, std::string_view text, std::optional<Actor> actor,
                                    std::string_view kind) {
  State& s = *state_;
  if (s.session == 0) return no_session();
  if (text.size() > kMaxMarker_bytes || text.find('\0') != std::string_view::npos)
    return Error{ErrorKind::bad_value, "a marker's text has at most 500 bytes", "text"};
  if (Status checked = check_marker_kind(kind); !checked) return checked;
  if (s.markers.size() >= kMaxPendingRows) return Error{ErrorKind::disk_full, "too many markers wait for the disk", {}};
  s.markers.push_back({tick, utc_ns, std::string(text), std::move(actor), std::string(kind)});
  return {};
}

Status SessionWriter::store_marker(std::uint64_t tick, std::int64_t utc_ns, std::string_view text, std::optional<Actor> actor,
                                   std::string_view kind) {
  if (Status taken = append_marker(tick, utc_ns, text, std::move(actor), kind); !taken) return taken;
  Status written = state_->write_all();
  if (!written) state_->markers.pop_back();
  return written;
}

Status SessionWriter::append_utc_anchor(std::uint64_t time_ns, std::int64_t utc_ns) {
  State& s = *state_;
  if (s.session == 0) return no_session();
  if (s.anchors.size() >= kMaxPendingRows) return Error{ErrorKind::disk_full, "too many clock jumps wait for the disk", {}};
  s.anchors.push_back({time_ns, utc_ns});
  return {};
}

Result<Durable> SessionWriter::commit() {
  if (state_->session == 0) return no_session();
  if (Status written = state_->write_all(); !written) return written.error();
  return durable();
}

Status SessionWriter::close(CloseReason reason, std::int64_t ended_utc_ns) {
  State& s = *state_;
  if (s.session == 0) return no_session();
  if (Status written = s.write_all(); !written) return written;
  const SessionId id = s.session;
  Status closed = guarded([&]() -> Status {
    s.close_rows(id, ended_utc_ns, reason);
    return {};
  });
  if (!closed) return closed;
  s.clear_session();
  s.unfolded.push_back(id);
  return {};
}

Result<bool> SessionWriter::fold_piece() {
  State& s = *state_;
  auto more = guarded([&]() -> Result<bool> { return s.fold_piece(); });
  if (!more) {
    s.reset_statements();
    s.leave_fold();
    ++s.failed_commits;
  }
  return more;
}

Status SessionWriter::end(CloseReason reason, std::int64_t ended_utc_ns) {
  if (Status closed = close(reason, ended_utc_ns); !closed) return closed;
  while (!state_->unfolded.empty()) (void)fold_piece();
  return {};
}

}  // namespace hoist::db
