// The last check of every frame that leaves. It judges frames alone, not what the controller wanted: against the mode,
// the limits, the age of the sensor data, and the frames it passed before (hazard H1). Every condition is covered by a
// test (deploy/dev cover).
#pragma once
#include <array>
#include <cmath>
#include <cstdint>

#include "control/contract/alarms.hpp"
#include "control/contract/can_dictionary.hpp"
#include "control/contract/classify.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/firmware_image.hpp"
#include "control/contract/params.hpp"
#include "control/core/base/derived.hpp"
#include "control/core/output/wheel_mixing.hpp"

namespace hoist::core {

/// The gate's inputs, from the sensors and not from the controller.
struct GateView {
  contract::Mode mode = contract::Mode::init;
  bool tilts_lost = true;     // patient-led walking without a tilt
  bool drives_unfit = true;   // either drive silent or in fault
  bool driver_fresh = false;  // a held driving command younger than remote_stop_age_s
  bool service = false;       // nodes get new programs
  std::uint8_t bumpers = 0;   // pressed ones, bits as in io_sensor.hpp: 0 front, 1 rear, 2 left, 3 right

  /// No acceleration and no faster turn: the tilts that lead are lost, there is no driver, or a drive does not follow.
  [[nodiscard]] bool blind() const noexcept {
    if (drives_unfit || mode == contract::Mode::protective_stop) return true;
    return mode == contract::Mode::user ? tilts_lost : !driver_fresh;
  }
};

class SafetyGate {
 public:
  /// What the hoist was last told, or is to be told now.
  struct Motion {
    double speed_m_s = 0, yaw_rate_rad_s = 0;
  };

  /// Whether this frame may leave: a row of kMaySend, in the length of the dictionary, and the row's check agrees. The two drive commands
  /// are judged as the pair that they are, by judge_drives().
  [[nodiscard]] static bool judge(const contract::CanFrame& frame, const GateView& view) noexcept {
    const contract::FrameClass what = contract::classify(frame);
    if (!what.fits) return false;
    for (const MaySend& row : kMaySend)
      if (row.kind == what.kind) return row.check(frame, what, view);
    return false;
  }

  /// Whether these two drive commands may leave together: each alone would hide a hoist that is spun about one wheel. A pair that may is
  /// remembered as the last one sent.
  [[nodiscard]] bool judge_drives(const contract::CanFrame& left, const contract::CanFrame& right, const GateView& view,
                                  const contract::Params& params, const Derived& derived, double dt_s) noexcept {
    Pair next;
    if (!read_drive(left, kLeftId, derived.left_motor_per_m, view, next.left)) return false;
    if (!read_drive(right, kRightId, derived.right_motor_per_m, view, next.right)) return false;
    if (next.left.enabled && next.right.enabled) {
      if (!may_go(next, view, params, dt_s)) return false;
    } else if (next.left.enabled) {
      if (!may_go_alone(next.left.m_s, sent_.left, view, params, dt_s)) return false;
    } else if (next.right.enabled) {
      if (!may_go_alone(next.right.m_s, sent_.right, view, params, dt_s)) return false;
    }
    // Without power a target means nothing; what the drive does then is its own ramp.
    sent_ = next;
    if (next.left.enabled == next.right.enabled) {
      alone_ticks_ = 0;
    } else if (alone_ticks_ < kAloneTicks) {
      ++alone_ticks_;
    }
    return true;
  }

  /// What leaves instead of a refused pair: both wheels brake together from what they were last told, in the same proportion, so that the
  /// hoist stays on its curve and no wheel brakes harder than a protective stop. A drive that was to be off stays off. Where the mode lets
  /// no drive run both are switched off. Returns the motion that is left, for the stop that follows.
  [[nodiscard]] Motion brake(contract::CanFrame& left, contract::CanFrame& right, const GateView& view, const contract::Params& params,
                             const Derived& derived, double dt_s) noexcept {
    const double largest_m_s = std::fmax(std::fabs(sent_.left.m_s), std::fabs(sent_.right.m_s));
    const double step_m_s = params.protective_deceleration_m_s2 * dt_s;
    const double share = largest_m_s > step_m_s ? 1.0 - step_m_s / largest_m_s : 0.0;
    braked(left, kLeftId, derived.left_motor_per_m, share, view, sent_.left);
    braked(right, kRightId, derived.right_motor_per_m, share, view, sent_.right);
    if (sent_.left.enabled && sent_.right.enabled) return motion(sent_, params);
    // The one wheel that still runs is all the motion there is.
    return {sent_.left.m_s + sent_.right.m_s, 0};
  }

  /// What an engineer's tool may send while nodes get new programs: to one of our nodes, NMT stop or start, any SDO
  /// upload, and downloads to the objects of the program (CiA 302-3) only. Segments pass: the first frame of their
  /// transfer was checked.
  [[nodiscard]] static bool is_service_frame(const contract::CanFrame& frame) noexcept {
    const contract::FrameClass what = contract::classify(frame);
    if (!what.fits) return false;
    const GateView not_looked_at;
    if (what.kind == contract::CobKind::nmt) return starts_a_node(frame, what, not_looked_at);
    if (what.kind != contract::CobKind::sdo_request) return false;
    const auto index = static_cast<std::uint16_t>(contract::read_le(&frame.data[1], 2));
    switch (frame.data[0] >> 5U) {
      case 0:  // a segment to the node
      case 2:  // the beginning of an upload
      case 3:  // a segment from the node
        return true;
      case 1:  // the beginning of a download
        return index >= contract::kProgramData && index <= contract::kFlashStatus && frame.data[3] == 1;
      case 4:
        return frame.data[0] == contract::canopen::kSdoAbort;
      default:  // block transfers, which no node of ours knows
        return false;
    }
  }

 private:
  struct Wheel {
    double m_s = 0;
    bool enabled = false;
  };
  struct Pair {
    Wheel left, right;
  };
  static constexpr contract::PdoSlot kControl = contract::pdo_slot(contract::Pdo::drive_rx1, 0x6040),
                                     kTarget = contract::pdo_slot(contract::Pdo::drive_rx1, 0x60FF);
  static constexpr std::uint8_t kDriveBytes = contract::pdo_bytes(contract::Pdo::drive_rx1);
  static constexpr std::uint32_t kLeftId = contract::pdo_cob_id(contract::Pdo::drive_rx1, contract::Node::drive_left),
                                 kRightId = contract::pdo_cob_id(contract::Pdo::drive_rx1, contract::Node::drive_right);
  // Two steps of 60FFh in ground speed at the largest wheel, plus rounding: what a legal ramp may differ from its own arithmetic.
  static constexpr double kRounding_m_s = 5e-5;
  // The stop after the driver let go or was lost has no parameter (SOURCES 2.2, H17).
  static constexpr double kLettingGo_m_s2 = 0.8;
  // Away from what a bumper touches, and not faster (H13).
  static constexpr double kAway_m_s = 0.1;
  static constexpr unsigned kFront = 1U, kRear = 2U;
  // A drive that drops out is noticed within 50 ms (H2, kDroppedTicksMax); twice that.
  static constexpr std::uint8_t kAloneTicks = 10;

  [[nodiscard]] static constexpr bool moves(contract::Mode mode) noexcept {
    return contract::kModes[static_cast<std::size_t>(mode)].moving != 0;
  }
  [[nodiscard]] static constexpr bool may_enable(contract::Mode mode) noexcept {
    return moves(mode) || mode == contract::Mode::protective_stop;
  }
  [[nodiscard]] static constexpr bool runs(std::uint16_t control) noexcept {
    return control == contract::canopen::drive::kEnable || control == contract::canopen::drive::kSwitchOn;
  }
  [[nodiscard]] static constexpr bool rests(std::uint16_t control) noexcept {
    namespace drive = contract::canopen::drive;
    return control == drive::kShutdown || control == drive::kDisableVoltage || control == drive::kQuickStop ||
           control == drive::kFaultReset;
  }

  /// The form of one drive's command: known words, no target without power, no power where the mode gives none.
  [[nodiscard]] static bool read_drive(const contract::CanFrame& frame, std::uint32_t id, double motor_per_m, const GateView& view,
                                       Wheel& wheel) noexcept {
    if (frame.flags != 0 || frame.id != id || frame.dlc != kDriveBytes) return false;
    const auto control = static_cast<std::uint16_t>(contract::read_slot(frame, kControl));
    if (!runs(control) && !rests(control)) return false;
    if (runs(control) && !may_enable(view.mode)) return false;
    wheel.m_s = wheel_m_s(static_cast<std::int32_t>(contract::read_slot(frame, kTarget)), motor_per_m);
    wheel.enabled = control == contract::canopen::drive::kEnable;
    return wheel.enabled || wheel.m_s == 0.0;
  }

  [[nodiscard]] static Motion motion(const Pair& pair, const contract::Params& params) noexcept {
    return {(pair.left.m_s + pair.right.m_s) / 2.0, (pair.right.m_s - pair.left.m_s) / params.track_width_m};
  }

  /// Both wheels run: speed and turn of the hoist, and how fast they change.
  [[nodiscard]] bool may_go(const Pair& next, const GateView& view, const contract::Params& params, double dt_s) const noexcept {
    const double rounding_rad_s = 2.0 * kRounding_m_s / params.track_width_m;
    const Motion to = motion(next, params);
    const Motion from = motion(sent_, params);
    const double speed = std::fabs(to.speed_m_s);
    const double turn = std::fabs(to.yaw_rate_rad_s);
    if (speed > params.speed_m_s_max + kRounding_m_s || turn > params.yaw_rate_rad_s_max + rounding_rad_s) return false;
    // Motion begins at rest. Only a stop may begin on the move: it takes over a hoist that is being pushed.
    const bool ran = sent_.left.enabled && sent_.right.enabled;
    if (view.mode == contract::Mode::protective_stop && !ran) return true;
    const bool faster = speed > std::fabs(from.speed_m_s) + kRounding_m_s;
    const bool sharper = turn > std::fabs(from.yaw_rate_rad_s) + rounding_rad_s;
    if ((faster || sharper) && view.blind()) return false;
    const double hardest_m_s2 = faster ? params.acceleration_m_s2_max : hardest_stop_m_s2(params);
    if (std::fabs(to.speed_m_s - from.speed_m_s) > hardest_m_s2 * dt_s + kRounding_m_s) return false;
    if (std::fabs(to.yaw_rate_rad_s - from.yaw_rate_rad_s) > params.yaw_acceleration_rad_s2_max * dt_s + rounding_rad_s) return false;
    // A turn sweeps every corner sideways.
    if (sharper && view.bumpers != 0) return false;
    return !faster || clear_of_bumpers(to.speed_m_s, view.bumpers);
  }

  [[nodiscard]] static bool clear_of_bumpers(double speed_m_s, std::uint8_t bumpers) noexcept {
    if (bumpers == 0) return true;
    if (std::fabs(speed_m_s) > kAway_m_s + kRounding_m_s) return false;
    return (bumpers & (speed_m_s > 0 ? kFront : kRear)) == 0;
  }

  /// One wheel runs, the other does not. While a mode begins it stands. If the other has dropped out it may go on as before until that is
  /// noticed (but not faster while a bumper is pressed), and then only comes to rest. In a stop it may end its share of a turn: the inner
  /// wheel runs backward faster when the speed falls faster than the turn, the outer one when the turn is ended first.
  [[nodiscard]] bool may_go_alone(double wheel_m_s, const Wheel& sent, const GateView& view, const contract::Params& params,
                                  double dt_s) const noexcept {
    const bool stop = view.mode == contract::Mode::protective_stop;
    const double half_track_m = params.track_width_m / 2.0;
    if (std::fabs(wheel_m_s) > params.speed_m_s_max + params.yaw_rate_rad_s_max * half_track_m + kRounding_m_s) return false;
    if (!sent.enabled) return stop || wheel_m_s == 0.0;
    const double turn_step_m_s = params.yaw_acceleration_rad_s2_max * half_track_m * dt_s;
    const double step_m_s = hardest_stop_m_s2(params) * dt_s + turn_step_m_s;
    if (std::fabs(wheel_m_s - sent.m_s) > step_m_s + kRounding_m_s) return false;
    double gain_m_s = 0.0;
    if (stop) {
      gain_m_s = std::fmax(step_m_s - 2.0 * turn_step_m_s, turn_step_m_s);
    } else if (!view.blind() && view.bumpers == 0 && alone_ticks_ < kAloneTicks) {
      gain_m_s = params.acceleration_m_s2_max * dt_s + turn_step_m_s;
    }
    return std::fabs(wheel_m_s) <= std::fabs(sent.m_s) + gain_m_s + kRounding_m_s;
  }

  static void braked(contract::CanFrame& frame, std::uint32_t id, double motor_per_m, double share, const GateView& view,
                     Wheel& sent) noexcept {
    namespace drive = contract::canopen::drive;
    const auto asked = static_cast<std::uint16_t>(contract::read_slot(frame, kControl));
    const std::uint16_t control = !may_enable(view.mode) ? drive::kShutdown : rests(asked) ? asked : drive::kEnable;
    const bool enabled = control == drive::kEnable;
    const auto target = enabled ? static_cast<std::int32_t>(std::lround(sent.m_s * share * motor_per_m / kTargetVelocity.scale)) : 0;
    frame = {id, kDriveBytes, 0, {}};
    contract::write_slot(frame, kControl, control);
    contract::write_slot(frame, kTarget, target);
    sent = {wheel_m_s(target, motor_per_m), enabled};
  }

  /// No stop brakes harder: usually the bumper's, unless its parameter was set below the others.
  [[nodiscard]] static double hardest_stop_m_s2(const contract::Params& params) noexcept {
    const double harder = params.bumper_deceleration_m_s2 > params.protective_deceleration_m_s2 ? params.bumper_deceleration_m_s2
                                                                                                : params.protective_deceleration_m_s2;
    return harder > kLettingGo_m_s2 ? harder : kLettingGo_m_s2;
  }

  // The checks of kMaySend: the frame has the row's kind and the dictionary's length, and is of a node that has such a frame.
  using Check = bool (*)(const contract::CanFrame&, const contract::FrameClass&, const GateView&) noexcept;

  [[nodiscard]] static bool is_sync(const contract::CanFrame&, const contract::FrameClass&, const GateView&) noexcept { return true; }

  /// The core's own, never with the id of a node.
  [[nodiscard]] static bool is_own_heartbeat(const contract::CanFrame& frame, const contract::FrameClass& what, const GateView&) noexcept {
    return what.is_of(contract::Node::core) && frame.data[0] == static_cast<std::uint8_t>(contract::canopen::NmtState::operational);
  }

  /// The core only ever starts nodes, one by one, or brings a stopped one back to where it answers. It never resets a running drive.
  [[nodiscard]] static bool starts_a_node(const contract::CanFrame& frame, const contract::FrameClass&, const GateView&) noexcept {
    using contract::canopen::NmtCommand;
    const auto node = contract::find_node(frame.data[1]);
    if (!node || *node == contract::Node::core) return false;
    return frame.data[0] == static_cast<std::uint8_t>(NmtCommand::start) ||
           frame.data[0] == static_cast<std::uint8_t>(NmtCommand::pre_operational);
  }

  /// Of the input node's outputs only those of the motors' relay and of the synchronisation are the core's to switch; buzzer and lights are the
  /// node's own, by the alarm that it is told. Nothing sounds that is not lit at least as urgently. A drive's command is none of its own here.
  [[nodiscard]] static bool switches_own_outputs(const contract::CanFrame& frame, const contract::FrameClass& what,
                                                 const GateView&) noexcept {
    namespace canopen = contract::canopen;
    constexpr unsigned kOwn = canopen::kRelayFeed | canopen::kRelayRelease | canopen::kSyncOutput;
    if (!what.is_of(contract::Node::io) || (frame.data[0] & ~kOwn) != 0) return false;
    const contract::AlarmCommand alarm = contract::alarm_command(frame.data[1]);
    return contract::alarm_byte(alarm) == frame.data[1] && alarm.sound <= alarm.light;
  }

  [[nodiscard]] static bool asks_or_sets(const contract::CanFrame& frame, const contract::FrameClass& what, const GateView& view) noexcept {
    namespace canopen = contract::canopen;
    if (view.service && view.mode == contract::Mode::init && is_service_frame(frame)) return true;
    const contract::NodeKind kind = contract::kNodes[what.node].kind;
    const auto index = static_cast<std::uint16_t>(contract::read_le(&frame.data[1], 2));
    if (frame.data[0] == canopen::kSdoUploadRequest) return contract::find_object(kind, index, frame.data[3]) != nullptr;
    // Only the parameters that belong into nodes are ever written, only in their range, and those that need standstill only in a mode
    // without motion; and the objects that hold their default, with nothing else.
    for (const contract::ParamObject& object : contract::kParamObjects) {
      if (object.kind != kind || object.index != index || object.sub != frame.data[3]) continue;
      if (frame.data[0] != canopen::sdo_download_command(4)) return false;
      const contract::ParamInfo& info = contract::kParams[contract::param_index(object.param)];
      if (!in_range(contract::param_value(object, contract::read_le(&frame.data[4], 4)), info)) return false;
      return info.edit == contract::EditRule::live || !contract::kModes[static_cast<std::size_t>(view.mode)].moving;
    }
    for (const contract::ObjectInfo* kept : contract::kKeptObjects) {
      if (!contract::object_applies(*kept, kind) || kept->index != index || kept->sub != frame.data[3]) continue;
      return frame.data[0] == canopen::sdo_download_command(contract::object_bytes(kept->type)) &&
             contract::read_le(&frame.data[4], 4) == contract::raw_word(kept->type, kept->default_value);
    }
    return false;
  }

  /// A value on the edge of its range may round to the other side as a 32-bit float. NaN is in none.
  [[nodiscard]] static bool in_range(double value, const contract::ParamInfo& info) noexcept {
    const double slack = 1e-6 * (info.max - info.min);
    return value >= info.min - slack && value <= info.max + slack;
  }

  struct MaySend {
    contract::CobKind kind;
    Check check;
  };
  /// All that the core may send, the commands of the drives aside.
  static constexpr std::array kMaySend{
      MaySend{contract::CobKind::sync, &is_sync},
      MaySend{contract::CobKind::heartbeat, &is_own_heartbeat},
      MaySend{contract::CobKind::nmt, &starts_a_node},
      MaySend{contract::CobKind::rpdo1, &switches_own_outputs},
      MaySend{contract::CobKind::sdo_request, &asks_or_sets},
  };

  Pair sent_;
  std::uint8_t alone_ticks_ = 0;
};

}  // namespace hoist::core
