// What the server may ask of the core, and what the core tells back. Plain bytes that lie in shared memory.
// The core treats every field that comes from the server as hostile: it copies once, then checks range, finiteness, age and lease.
#pragma once
#include <bit>
#include <cstdint>
#include <string_view>
#include <type_traits>

namespace hoist::contract {

enum class CommandKind : std::uint32_t {
  none = 0,
  stop = 1,  // anyone; protective stop, never refused
  // a = Mode: one that standby leads to, lease holder only; standby: anyone while the hoist is led. bits = echo (put_echo).
  request_mode = 2,
  // leave PROTECTIVE_STOP, FAULT or EMERGENCY_STOP once the cause is gone; role in b, bits = faults that the client was
  // shown, 0 = not named; v0 = echo (put_echo); lease holder only
  acknowledge = 3,
  // client asks to be the driver; granted when free, or when standing still and a = kTakeOver, or kHandOver: the holder gives it to this
  // client, lease_epoch = that of the lease handed over
  take_lease = 4,
  release_lease = 5,  // by its holder, or by the server for a client that is gone; from its holder: a = kConsoleGone, its connection ended
  stage_parameter = 6,  // a = parameter id, v0 = value, b = position in the set, counted from 0
  // a = number of staged rows, role in b, bits = ParamSetSeal over them; v0 = 0, or the seconds after which the values before come back
  // unless confirmed; all or nothing
  commit_parameters = 7,
  // A start mark: v0 = x_m, v1 = y_m, v2 = psi_rad; standing still only. a = key of the exercise that begins there, 0 = none. With the key
  // of the newest mark the exercise goes on and the pose stays, unless b = kStartAgain. bits = echo where it belongs to a start.
  set_pose = 8,
  // v0 = seconds since 1970 UTC: take the mean of the last second as neutral; standing still only; stored as parameters with their date
  set_neutral = 9,
  // Service: nodes are in their loaders, the drives off, INIT stays until it ends. Engineer with the lease only.
  begin_service = 10,  // role in b; in STANDBY or INIT; repeated while it is on, it lasts another two seconds
  service_frame = 11,  // a = CAN id, v0 = the eight data bytes as they are (std::bit_cast), v1 = how many of them; one a step
  end_service = 12,
  // Calibration (control/contract/calibration.hpp). The wheels never turn by themselves; lease holder with the step's role only.
  // a = CalibrationStep, role in b, v0 = 1: the operator confirms that nobody is strapped in; on standby, or again while one is under way
  begin_calibration = 20,
  measure_calibration = 21,  // v0, v1, v2 = what the operator measured, a = CalibrationPart; taken as soon as everything rests
  use_calibration = 22,      // v0 = seconds since 1970 UTC; the result becomes parameters, and CALIBRATE ends
  cancel_calibration = 23,   // the old values stay
  confirm_parameters = 30,   // keeps the values on trial; role in b, a = the version that was shown, 0 = any
  revert_parameters = 31,    // reverts the values on trial now; role in b
  pause_alarm = 32,  // a = 1: the alarms in force stop sounding for kAudioPause_s; 0: they sound again; role in b, therapist or engineer
  // Exercises (guided_path.hpp): a = shape, with bit 8 for clockwise, b = laps, v0 = size_m, v1 = radius_m, v2 = speed_m_s, bits = echo;
  // lease holder only.
  begin_guided = 25,
};

inline constexpr std::uint32_t kStartAgain = 1;
inline constexpr std::uint32_t kTakeOver = 1;
inline constexpr std::uint32_t kHandOver = 2;
inline constexpr std::uint32_t kConsoleGone = 1;

// One request of a client, in order. `request_id` comes back in the event that answers it.
struct Command {
  std::uint64_t sequence = 0;  // rises by one; another number is refused as out_of_order, except for STOP and ending motion
  CommandKind kind = CommandKind::none;
  std::uint32_t request_id = 0;
  std::uint32_t client = 0;       // number the server gave to the connection; 0 is the server itself
  std::uint32_t lease_epoch = 0;  // what the client believes
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  double v0 = 0, v1 = 0, v2 = 0;
  std::uint64_t bits = 0;  // acknowledge: FaultBits; commit_parameters: ParamSetSeal; of a start: echo
};
static_assert(sizeof(Command) == 64 && std::is_trivially_copyable_v<Command>);

/// An echo is the time_ns of the newest telemetry record that the sender of a command had seen, so its age is counted on the core's clock alone.
/// Whether it is at most `most_s` seconds old; one from the future is not.
[[nodiscard]] constexpr bool is_fresh_echo(std::uint64_t echo_time_ns, std::uint64_t now_ns, double most_s) {
  return echo_time_ns <= now_ns && static_cast<double>(now_ns - echo_time_ns) * 1e-9 <= most_s;
}
/// A start or an acknowledgement whose echo is older than this is refused as stale_command: its sender may be gone.
inline constexpr double kEchoAge_s_max = 1.0;
/// Puts the echo into a command that begins motion or leaves a stop, where its kind has room; others have none. 0: not told, its age is not judged.
constexpr void put_echo(Command& command, std::uint64_t echo_time_ns) {
  if (command.kind == CommandKind::acknowledge) command.v0 = std::bit_cast<double>(echo_time_ns);
  if (command.kind == CommandKind::request_mode || command.kind == CommandKind::begin_guided || command.kind == CommandKind::set_pose)
    command.bits = echo_time_ns;
}
/// The echo of a command; 0 where it has none.
[[nodiscard]] constexpr std::uint64_t echo_of(const Command& command) {
  if (command.kind == CommandKind::acknowledge) return std::bit_cast<std::uint64_t>(command.v0);
  const bool begins =
      command.kind == CommandKind::request_mode || command.kind == CommandKind::begin_guided || command.kind == CommandKind::set_pose;
  return begins ? command.bits : 0;
}

// The newest driving command; only the latest counts. Speeds are shares of the driving limits, -1 to 1.
struct DriveCommand {
  std::uint32_t lease_epoch = 0;
  std::uint32_t client = 0;
  std::uint64_t sequence = 0;      // rises with every command of one lease
  std::uint64_t echo_time_ns = 0;  // the command's age counts from it
  double speed_norm = 0;
  double yaw_norm = 0;
  std::uint64_t held = 0;  // 1 while hold-to-run is held; any other value is a release
};
static_assert(sizeof(DriveCommand) == 48 && std::is_trivially_copyable_v<DriveCommand>);

enum class EventKind : std::uint32_t {
  none = 0,
  command_done = 1,       // answers request_id
  command_refused = 2,    // answers request_id; code = first Refusal, bits = all of them; for parameters item = id
  mode_changed = 3,       // code = new mode, item = old mode
  fault_raised = 4,       // code = Fault
  fault_cleared = 5,      // code = Fault
  parameter_changed = 6,  // item = parameter id, value and before; code = InEffect
  lease_changed = 7,      // client = holder (0 nobody), code = epoch
  node_changed = 8,       // item = Node, code = 1 answers, 0 lost
  pose_set = 9,           // code = number of the start mark
  neutral_set = 10,
  core_started = 11,
  parameters_on_trial = 30,   // code = version, value = seconds
  parameters_confirmed = 31,  // code = version
  parameters_reverted = 32,   // code = version; request_id 0: nobody confirmed in time
  parameter_settled = 33,     // item = parameter id, value: a gain has arrived where an earlier parameter_changed has sent it
  alarm_paused = 34,          // code = 1: no sound for `value` seconds; 0: sounds again, or nothing is left to sound
  emergency = 12,  // item: node, code: EMCY code (0 = an error has ended), bits: error register, value: its five further bytes, as a number
  // Calibration; code = CalibrationStep.
  calibration_sample = 20,  // item = how many so far, value = what was measured
  calibration_result = 21,  // one for each parameter that would change: item = parameter id, value and before
  calibration_ended = 22,   // bits = 1 used, 0 the old values stay; item = CalibrationReason
  guided_ended = 25,        // code = GuidedEnd (guided_path.hpp), value = metres that were left
  sync_input = 26,          // code = 1 on, 0 off: the synchronisation input of another system (canopen::kSyncInput) has changed
};
/// When the value of a parameter_changed event acts; 0 in events of older cores, which do not say.
enum class InEffect : std::uint32_t { not_told = 0, at_once = 1, gradually = 2 };

constexpr std::string_view event_name(EventKind kind) {
  switch (kind) {
    case EventKind::command_done:
      return "command_done";
    case EventKind::command_refused:
      return "command_refused";
    case EventKind::mode_changed:
      return "mode_changed";
    case EventKind::fault_raised:
      return "fault_raised";
    case EventKind::fault_cleared:
      return "fault_cleared";
    case EventKind::parameter_changed:
      return "parameter_changed";
    case EventKind::lease_changed:
      return "lease_changed";
    case EventKind::node_changed:
      return "node_changed";
    case EventKind::pose_set:
      return "pose_set";
    case EventKind::neutral_set:
      return "neutral_set";
    case EventKind::core_started:
      return "core_started";
    case EventKind::emergency:
      return "emergency";
    case EventKind::calibration_sample:
      return "calibration_sample";
    case EventKind::calibration_result:
      return "calibration_result";
    case EventKind::calibration_ended:
      return "calibration_ended";
    case EventKind::parameters_on_trial:
      return "parameters_on_trial";
    case EventKind::parameters_confirmed:
      return "parameters_confirmed";
    case EventKind::parameters_reverted:
      return "parameters_reverted";
    case EventKind::parameter_settled:
      return "parameter_settled";
    case EventKind::guided_ended:
      return "guided_ended";
    case EventKind::sync_input:
      return "sync_input";
    case EventKind::alarm_paused:
      return "alarm_paused";
    case EventKind::none:
      break;
  }
  return "none";
}

struct Event {
  std::uint64_t tick = 0;
  std::uint64_t time_ns = 0;
  EventKind kind = EventKind::none;
  std::uint32_t request_id = 0;
  std::uint32_t client = 0;
  std::uint32_t code = 0;
  std::uint32_t bits = 0;
  std::uint32_t item = 0;
  double value = 0;
  double before = 0;
  std::uint64_t reserved = 0;
};
static_assert(sizeof(Event) == 64 && std::is_trivially_copyable_v<Event>);

// One frame as it crossed the bus, for the recording.
struct BusRecord {
  std::uint64_t time_ns = 0;
  std::uint32_t id = 0;
  std::uint8_t dlc = 0;
  std::uint8_t flags = 0;
  std::uint8_t sent = 0;  // 1 = by the core
  std::uint8_t reserved = 0;
  std::uint64_t data = 0;  // little endian
};
static_assert(sizeof(BusRecord) == 24 && std::is_trivially_copyable_v<BusRecord>);

}  // namespace hoist::contract
