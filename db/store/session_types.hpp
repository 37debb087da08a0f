// What a session is, as the rest of the program sees it.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "control/contract/journal.hpp"

namespace hoist::db {

using SessionId = std::int64_t;

/// Longest texts accepted, in bytes of UTF-8.
inline constexpr std::size_t kMaxSubject_bytes = 64, kMaxNote_bytes = 4000, kMaxMarker_bytes = 500, kMaxExercise_bytes = 1000;

/// What a node has said of its program on the bus; absent = not read.
struct NodeProgram {
  std::string name;
  std::optional<std::uint32_t> product, revision;  ///< 1018h:2 and :3
  std::optional<std::uint32_t> version, crc;       ///< 2F00h:1 and 1F56h:1
  bool operator==(const NodeProgram&) const = default;
};

/// Everything known when a recording begins. `parameter_values` are in the order of contract::kParams, or empty when unknown.
struct SessionStart {
  std::optional<std::string> subject;    ///< pseudonymous code, never a name
  std::int64_t started_utc_ns = 0;       ///< wall clock …
  std::uint64_t start_time_ns = 0;       ///< … at this moment of the core's steady clock: the anchor of all UTC times
  std::uint64_t core_start_time_ns = 0;  ///< SegmentHeader::start_time_ns: which life of the core
  bool simulated = false;
  bool standby = false;  ///< in standby with a patient chosen: no walk
  std::uint64_t layout_hash = 0;
  std::string software_version;             ///< of the program that records
  std::optional<std::string> core_version;  ///< of hoist-control
  std::vector<NodeProgram> nodes;
  std::string note;
  std::optional<std::string> exercise_json;  ///< {"shape": "square", "side_m": 3.2} …, see check_exercise
  std::span<const double> parameter_values;
};

enum class CloseReason : std::uint8_t { finished, core_restarted, interrupted, server_stopped };
constexpr const char* close_reason_name(CloseReason reason) {
  switch (reason) {
    case CloseReason::finished:
      return "finished";
    case CloseReason::core_restarted:
      return "core_restarted";
    case CloseReason::interrupted:
      return "interrupted";
    case CloseReason::server_stopped:
      break;
  }
  return "server_stopped";
}

/// Which run of a study with virtual subjects a session is.
struct StudyRun {
  std::int64_t study = 0;
  std::string subject;  ///< "S01" …: no patient
  int run = 0;          ///< its number in the protocol
};

struct SessionInfo {
  SessionId id = 0;
  std::optional<std::string> subject;
  std::int64_t started_utc_ns = 0;
  std::uint64_t start_time_ns = 0;
  std::uint64_t core_start_time_ns = 0;
  bool simulated = false;
  bool standby = false;                      ///< in standby with a patient chosen: no walk
  bool recording = false;                    ///< not closed yet
  std::optional<std::int64_t> ended_utc_ns;  ///< absent while recording
  std::string close_reason;                  ///< empty while recording
  std::uint64_t layout_hash = 0;
  std::string software_version;             ///< of the program that recorded
  std::optional<std::string> core_version;  ///< of hoist-control; absent in recordings that do not tell
  std::optional<std::string> hoist_id;      ///< which hoist recorded it; absent in recordings from before hoists had an id
  std::string note;
  std::optional<std::string> exercise_json;
  std::uint64_t sample_count = 0;
  std::uint64_t gap_count = 0;
  double duration_s = 0;           ///< from the first to the last sample
  std::uint64_t stored_bytes = 0;  ///< chunk blobs of samples and bus frames
  std::optional<StudyRun> study;   ///< of a virtual subject
  std::string tag;                 ///< of what people may change (edit_tag.hpp)
};

/// A session whose recorder went away while the hoist was moving: where the next one goes on.
struct BrokenOff {
  SessionId session = 0;
  std::optional<std::string> subject, exercise_json;
  std::uint64_t start_time_ns = 0;
  std::uint64_t last_time_ns = 0;          ///< of the newest sample; without one: just before the session's start
  std::optional<std::uint64_t> last_tick;  ///< absent when no sample was stored
  std::uint32_t missed_ticks = 0;          ///< what that sample says: steps the core had left out by then
  std::optional<std::uint64_t> last_event_tick, last_frame_time_ns;
};

struct ColumnInfo {
  std::string name;
  std::string unit;
  std::string type;  ///< as in signals.def: u64, f32 …
  double lsb = 1;    ///< always 10^-decimals
  int decimals = 0;
};

/// Which samples are missing and why. Ticks are inclusive. `stream` says what is missing: ticks, events or bus.
struct Gap {
  std::string stream;
  std::uint64_t from_tick = 0, to_tick = 0;
  std::string reason;
  std::int64_t number = 0;  ///< within its session, rising
};

/// Who asked for something, in words that stay true after the connection has ended.
struct Actor {
  std::string user;    ///< the account
  std::string role;    ///< viewer, therapist, engineer
  std::string origin;  ///< the protocol: rest, hoist.v1
  std::string client;  ///< the sign-in: "script", or "device-" and eight digits
  bool operator==(const Actor&) const = default;
};

struct StoredEvent {
  std::uint64_t tick = 0, time_ns = 0;
  std::uint32_t kind = 0, code = 0, bits = 0, item = 0, request_id = 0;
  double value = 0, before = 0;
  std::string kind_name;       ///< event_name as of the recording
  std::string name;            ///< what code or item meant when it was recorded: fault, mode, parameter, refusal or node name; may be empty
  std::optional<Actor> actor;  ///< absent: not known, or the core's own doing
  std::int64_t number = 0;     ///< within its session, rising
};

/// What kind of moment a marker marks; the first one is a note without a kind.
inline constexpr std::array<std::string_view, 5> kMarkerKinds{"note", "help", "stumble", "rest", "good"};

struct Marker {
  std::uint64_t tick = 0;
  std::int64_t utc_ns = 0;
  std::string text;
  std::optional<Actor> actor;
  std::string kind{kMarkerKinds.front()};  ///< one of kMarkerKinds
};

/// Steps of the journal that are stored together, and what they hold.
struct JournalExtent {
  std::uint64_t first_step = 0, steps = 0;
};
struct JournalRun {
  std::vector<contract::JournalStep> steps;
  std::vector<contract::JournalCommand> commands;  ///< in the order of the steps
};
/// Where an image of the core stands.
struct ImagePlace {
  std::uint64_t step = 0, tick = 0;
};

/// Samples as they are stored: values[c][i] = sample i of column c of SessionReader::columns, times 10^decimals.
struct StoredSamples {
  std::vector<std::vector<std::int64_t>> values;
};

/// Part of a session in seconds since its start (SessionInfo::start_time_ns): from_s <= t < to_s.
struct TimeRange {
  double from_s = -1e18, to_s = 1e18;
};

/// Samples of some columns. All vectors have the same length; values are int / 10^decimals, exactly the number that the CSV prints.
struct Columns {
  std::vector<ColumnInfo> info;
  std::vector<double> time_s;  ///< since the session's start
  std::vector<std::uint64_t> tick;
  std::vector<std::uint8_t> gap_before;     ///< 1 = samples are missing between the one before and this one
  std::vector<std::vector<double>> values;  ///< values[column][sample]
};

/// Smallest and largest value of each run of samples, in order of time. Runs hold whole stored blocks or equal numbers of samples.
struct Overview {
  std::vector<ColumnInfo> info;
  std::vector<double> from_s, to_s;           ///< times of the first and the last sample of each run
  std::vector<std::uint8_t> gap_before;       ///< 1 = samples are missing before or inside this run
  std::vector<std::vector<double>> min, max;  ///< [column][run]
  bool exact_range = false;                   ///< false: whole blocks at both ends were taken, so the range may be a few seconds wider
};

}  // namespace hoist::db
