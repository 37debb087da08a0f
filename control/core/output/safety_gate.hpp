// The last word on every frame that leaves. The gate is not told what the controller wanted: it judges the frame alone, against the mode,
// the limits, the age of what the hoist knows, and what it let through before (hazard H1).
#pragma once
#include <array>
#include <cmath>
#include <cstdint>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/firmware_image.hpp"
#include "control/contract/params.hpp"
#include "control/core/derived.hpp"
#include "control/core/output/bumper_room.hpp"
#include "control/core/output/wheel_mixing.hpp"

namespace hoist::core {

/// The facts the gate goes by, taken from the senses and not from the controller.
struct GateView {
  contract::Mode mode = contract::Mode::init;
  bool tilts_lost = true;     // patient-led walking without a tilt
  bool drives_lost = true;    // either drive silent
  bool driver_fresh = false;  // a held driving command younger than remote_stop_age_s
  bool service = false;       // nodes get new programs
  std::uint8_t bumpers = 0;   // pressed now: 0 front, 1 rear, 2 left, 3 right
};

class SafetyGate {
 public:
  /// Whether this frame may leave. A drive command that may is remembered as the last one sent.
  [[nodiscard]] bool judge(const contract::CanFrame& frame, const GateView& view, const contract::Params& params, const Derived& derived,
                           double dt_s) noexcept {
    namespace canopen = contract::canopen;
    if (frame.flags != 0) return false;
    if (frame.id == contract::pdo_cob_id(contract::Pdo::drive_rx1, contract::Node::drive_left))
      return judge_drive(frame, 0, derived.left_motor_per_m, view, params, dt_s);
    if (frame.id == contract::pdo_cob_id(contract::Pdo::drive_rx1, contract::Node::drive_right))
      return judge_drive(frame, 1, derived.right_motor_per_m, view, params, dt_s);
    if (frame.id == canopen::kSync) return frame.dlc == 0;
    if (frame.id == canopen::kHeartbeatBase + contract::node_id(contract::Node::core))
      return frame.dlc == 1 && frame.data[0] == static_cast<std::uint8_t>(canopen::NmtState::operational);
    if (frame.id == canopen::kNmt) return judge_nmt(frame);
    // Of the input node's outputs only the feed of the motors' relay is the core's to switch.
    if (frame.id == contract::pdo_cob_id(contract::Pdo::io_rx1, contract::Node::io))
      return frame.dlc == contract::pdo_bytes(contract::Pdo::io_rx1) && (frame.data[0] & ~canopen::kRelayFeed) == 0;
    if (frame.id > canopen::kSdoRequestBase && frame.id < canopen::kHeartbeatBase) return judge_sdo(frame, view);
    return false;
  }

  /// What an engineer's tool may send while nodes get new programs: to one node of ours, to hold or start it, to ask it anything, and to
  /// write the objects of the program (CiA 302-3) and nothing else. A segment needs no look: the transfer it belongs to had one.
  [[nodiscard]] static bool is_service_frame(const contract::CanFrame& frame) noexcept {
    namespace canopen = contract::canopen;
    if (frame.flags != 0) return false;
    if (frame.id == canopen::kNmt) return judge_nmt(frame);
    if (frame.id <= canopen::kSdoRequestBase || frame.id >= canopen::kHeartbeatBase || frame.dlc != 8) return false;
    const auto node = contract::find_node(static_cast<std::uint8_t>(frame.id - canopen::kSdoRequestBase));
    if (!node || *node == contract::Node::core) return false;
    const auto index = static_cast<std::uint16_t>(contract::read_le(&frame.data[1], 2));
    switch (frame.data[0] >> 5U) {
      case 0:  // a segment to the node
      case 2:  // the beginning of an upload
      case 3:  // a segment from the node
        return true;
      case 1:  // the beginning of a download
        return index >= contract::kProgramData && index <= contract::kFlashStatus && frame.data[3] == 1;
      case 4:
        return frame.data[0] == canopen::kSdoAbort;
      default:  // block transfers, which no node of ours knows
        return false;
    }
  }

  /// What leaves instead of a refused drive command: no motion, and the drive holds zero if the mode lets it hold.
  [[nodiscard]] contract::CanFrame zero_command(std::uint32_t id, const GateView& view) noexcept {
    contract::CanFrame frame{id, kDriveBytes, 0, {}};
    const std::uint16_t control = may_enable(view.mode) ? contract::canopen::drive::kEnable : contract::canopen::drive::kShutdown;
    contract::write_slot(frame, kControl, control);
    sent_[id == contract::pdo_cob_id(contract::Pdo::drive_rx1, contract::Node::drive_left) ? 0 : 1] = {};
    return frame;
  }

 private:
  struct Sent {
    double wheel_m_s = 0;
    bool enabled = false;
  };
  static constexpr contract::PdoSlot kControl = contract::pdo_slot(contract::Pdo::drive_rx1, 0x6040),
                                     kTarget = contract::pdo_slot(contract::Pdo::drive_rx1, 0x60FF);
  static constexpr std::uint8_t kDriveBytes = contract::pdo_bytes(contract::Pdo::drive_rx1);
  // Two steps of 60FFh in ground speed at the largest wheel, plus rounding: what a legal ramp may differ from its own arithmetic.
  static constexpr double kRounding_m_s = 5e-5;
  // The stop after the driver let go or was lost has no parameter (research on safety: H17, R1 at 0.8).
  static constexpr double kLettingGo_m_s2 = 0.8;

  [[nodiscard]] static constexpr bool may_enable(contract::Mode mode) noexcept {
    return contract::kModes[static_cast<std::size_t>(mode)].moving || mode == contract::Mode::protective_stop;
  }

  [[nodiscard]] bool judge_drive(const contract::CanFrame& frame, std::size_t side, double motor_per_m, const GateView& view,
                                 const contract::Params& params, double dt_s) noexcept {
    namespace drive = contract::canopen::drive;
    if (frame.dlc != kDriveBytes) return false;
    const auto control = static_cast<std::uint16_t>(contract::read_slot(frame, kControl));
    const double wheel = wheel_m_s(static_cast<std::int32_t>(contract::read_slot(frame, kTarget)), motor_per_m);
    Sent& sent = sent_[side];
    const bool enable = control == drive::kEnable || control == drive::kSwitchOn;
    const bool rest =
        control == drive::kShutdown || control == drive::kDisableVoltage || control == drive::kQuickStop || control == drive::kFaultReset;
    if (!enable && !rest) return false;
    if (enable && !may_enable(view.mode)) return false;
    if (wheel != 0.0 && control != drive::kEnable) return false;
    const double turn_m_s = derived_turn_m_s(params.yaw_rate_rad_s_max, params);
    if (std::fabs(wheel) > params.speed_m_s_max + turn_m_s + kRounding_m_s) return false;
    const double turn_step_m_s = derived_turn_m_s(params.yaw_acceleration_rad_s2_max, params) * dt_s;
    if (control != drive::kEnable) {
      // Without power the target means nothing; what the drive does then is its own ramp.
      sent = {};
      return true;
    }
    // H13: with a bumper pressed each wheel may only lead away from it, slowly. A stop ends on its ramp, whatever touches.
    if (view.bumpers != 0 && view.mode != contract::Mode::protective_stop &&
        std::fabs(wheel - BumperRoom(view.bumpers).speed_m_s(wheel)) > kRounding_m_s)
      return false;
    if (sent.enabled) {
      if (std::fabs(wheel - sent.wheel_m_s) > hardest_stop_m_s2(params) * dt_s + turn_step_m_s + kRounding_m_s) return false;
    } else if (wheel != 0.0 && view.mode != contract::Mode::protective_stop) {
      // Motion begins at rest. Only a stop may begin on the move: it takes over a hoist that is being pushed.
      if (std::fabs(wheel) > params.acceleration_m_s2_max * dt_s + turn_step_m_s + kRounding_m_s) return false;
    }
    const bool faster = std::fabs(wheel) > std::fabs(sent.wheel_m_s) + kRounding_m_s;
    if (faster && sent.enabled) {
      // Nothing speeds up while the hoist is blind or nobody leads it, but for one wheel while the hoist brakes in a turn: the inner one
      // runs backward faster when the speed falls faster than the turn, the outer one when the turn is ended first.
      const bool blind = (view.mode == contract::Mode::user && view.tilts_lost) || view.drives_lost ||
                         (contract::led_by_hand(view.mode) && !view.driver_fresh) || view.mode == contract::Mode::protective_stop;
      const double gain_m_s = std::fabs(wheel) - std::fabs(sent.wheel_m_s);
      const double inner_m_s = hardest_stop_m_s2(params) * dt_s - turn_step_m_s;
      const double stopping_m_s = inner_m_s > turn_step_m_s ? inner_m_s : turn_step_m_s;
      const double driving_m_s = params.acceleration_m_s2_max * dt_s + turn_step_m_s;
      if (gain_m_s > (blind || driving_m_s < stopping_m_s ? stopping_m_s : driving_m_s) + kRounding_m_s) return false;
    }
    sent = {wheel, true};
    return true;
  }

  /// No stop brakes harder: usually the bumper's, unless its parameter was set below the others.
  [[nodiscard]] static double hardest_stop_m_s2(const contract::Params& params) noexcept {
    const double harder = params.bumper_deceleration_m_s2 > params.protective_deceleration_m_s2 ? params.bumper_deceleration_m_s2
                                                                                                : params.protective_deceleration_m_s2;
    return harder > kLettingGo_m_s2 ? harder : kLettingGo_m_s2;
  }

  [[nodiscard]] static double derived_turn_m_s(double turn, const contract::Params& params) noexcept {
    return turn * params.track_width_m / 2.0;
  }

  [[nodiscard]] static bool judge_nmt(const contract::CanFrame& frame) noexcept {
    using contract::canopen::NmtCommand;
    if (frame.dlc != 2) return false;
    const auto node = contract::find_node(frame.data[1]);
    if (!node || *node == contract::Node::core) return false;
    // The core only ever starts nodes, one by one, or brings a stopped one back to where it answers. It never resets a running drive.
    return frame.data[0] == static_cast<std::uint8_t>(NmtCommand::start) ||
           frame.data[0] == static_cast<std::uint8_t>(NmtCommand::pre_operational);
  }

  [[nodiscard]] static bool judge_sdo(const contract::CanFrame& frame, const GateView& view) noexcept {
    namespace canopen = contract::canopen;
    if (frame.dlc != 8) return false;
    if (view.service && view.mode == contract::Mode::init && is_service_frame(frame)) return true;
    const auto node = contract::find_node(static_cast<std::uint8_t>(frame.id - canopen::kSdoRequestBase));
    if (!node || *node == contract::Node::core) return false;
    const contract::NodeKind kind = contract::kNodes[static_cast<std::size_t>(*node)].kind;
    const auto index = static_cast<std::uint16_t>(contract::read_le(&frame.data[1], 2));
    if (frame.data[0] == canopen::kSdoUploadRequest) return contract::find_object(kind, index, frame.data[3]) != nullptr;
    // Only the parameters that belong into nodes are ever written, only in their range, and those that need standstill only in a mode
    // without motion.
    for (const contract::ParamObject& object : contract::kParamObjects) {
      if (object.kind != kind || object.index != index || object.sub != frame.data[3]) continue;
      if (frame.data[0] != canopen::sdo_download_command(4)) return false;
      const contract::ParamInfo& info = contract::kParams[contract::param_index(object.param)];
      const auto value = static_cast<double>(std::bit_cast<float>(contract::read_le(&frame.data[4], 4)));
      if (contract::check_param(contract::param_index(object.param), value) != contract::ParamCheck::ok && !near_edge(value, info))
        return false;
      return info.edit == contract::EditRule::live || !contract::kModes[static_cast<std::size_t>(view.mode)].moving;
    }
    return false;
  }

  /// A value on the edge of its range may round to the other side as a 32-bit float.
  [[nodiscard]] static bool near_edge(double value, const contract::ParamInfo& info) noexcept {
    const double slack = 1e-6 * (info.max - info.min);
    return value >= info.min - slack && value <= info.max + slack;
  }

  std::array<Sent, 2> sent_{};
};

}  // namespace hoist::core
