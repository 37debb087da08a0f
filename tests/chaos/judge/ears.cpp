#include "tests/chaos/judge/ears.hpp"

#include <cmath>

#include "control/contract/classify.hpp"

namespace hoist::chaos {
namespace {

using contract::CobKind;
using contract::Node;
using contract::Pdo;

constexpr double kRadPerMilliDegree = kDegree_rad / 1000.0;
// Wheel of 0.10 m, gear 30; the target is in 1/1000 rad/s at the motor.
constexpr double kMetresPerTarget = 0.001 / 30.0 * 0.10;
// How a drive follows its target: measured lag of servo, bus and encoder together (REACTIONS.gen.md, time to rest).
constexpr double kFollow_s = 0.1;
constexpr double kLate_s = 0.005, kFarTooLate_s = 0.030;
constexpr int kLateWindow_steps = 100;
constexpr std::uint16_t kEnable = 0x000F;
// Of a tilt sensor's status 2120h.
constexpr unsigned kValid = 1, kSettled = 2, kSaturated = 8, kSelfTestFailed = 16;

}  // namespace

void Ears::take(const contract::CanFrame& frame) {
  const contract::FrameClass what = contract::classify(frame);
  if (!what.is_remote() || what.bytes == contract::kNotPlanned) {
    ++stranger_counts_[static_cast<std::size_t>(steps_) % kWindow];
    ++strangers_;
    return;
  }
  if (!what.fits) return;
  const auto node = static_cast<Node>(what.node);
  const contract::NodeKind kind = contract::kNodes[what.node].kind;
  if (what.kind == CobKind::tpdo1) {
    age_[what.node] = 0;
    ++answers_[what.node];
    if (kind == contract::NodeKind::tilt) {
      Tilt& tilt = tilts_[what.node];
      const auto status = static_cast<unsigned>(contract::read_slot(frame, contract::pdo_slot(Pdo::tilt_tx1, 0x2120)));
      tilt.valid = (status & kValid) != 0;
      if ((status & kSettled) == 0) tilt.settled_steps = 0;
      if (!tilt.valid || (status & (kSaturated | kSelfTestFailed)) != 0) doubt_age_ = 0;
      tilt.forward_rad = static_cast<double>(contract::read_slot(frame, contract::pdo_slot(Pdo::tilt_tx1, 0x6010))) * kRadPerMilliDegree;
      tilt.right_rad = static_cast<double>(contract::read_slot(frame, contract::pdo_slot(Pdo::tilt_tx1, 0x6020))) * kRadPerMilliDegree;
    } else if (kind == contract::NodeKind::drive) {
      drives_[node == Node::drive_left ? 0 : 1].status =
          static_cast<std::uint16_t>(contract::read_slot(frame, contract::pdo_slot(Pdo::drive_tx1, 0x6041)));
    } else {
      bumpers_ = static_cast<std::uint8_t>(contract::read_slot(frame, contract::pdo_slot(Pdo::io_tx1, 0x6000, 1)));
    }
  } else if (what.kind == CobKind::tpdo2) {
    if (node == Node::io) {
      battery_age_ = 0;
      battery_v_ = {0.01 * static_cast<double>(contract::read_slot(frame, contract::pdo_slot(Pdo::io_tx2, 0x6401, 1))),
                    0.01 * static_cast<double>(contract::read_slot(frame, contract::pdo_slot(Pdo::io_tx2, 0x6401, 2)))};
    } else if (kind == contract::NodeKind::drive) {
      drives_[node == Node::drive_left ? 0 : 1].supply_v =
          0.01 * static_cast<double>(contract::read_slot(frame, contract::pdo_slot(Pdo::drive_tx2, 0x2211)));
    } else if (node == Node::tilt_base) {
      rates_age_ = 0;
    }
  }
}

void Ears::before_step(const Given& given) {
  ++steps_;
  for (int& age : age_)
    if (age < kNever) ++age;
  if (battery_age_ < kNever) ++battery_age_;
  if (rates_age_ < kNever) ++rates_age_;
  if (doubt_age_ < kNever) ++doubt_age_;
  for (Tilt& tilt : tilts_)
    if (tilt.settled_steps < kNever) ++tilt.settled_steps;
  bus_age_ = given.bus_up ? bus_age_ + 1 : 0;
  answers_ = {};
  int& oldest = stranger_counts_[static_cast<std::size_t>(steps_) % kWindow];
  strangers_ -= oldest;
  oldest = 0;
  for (const contract::CanFrame& frame : given.frames) take(frame);
  for (std::size_t n = 0; n < answers_.size(); ++n) twice_[n] = answers_[n] >= 2 ? twice_[n] + 1 : 0;
  // A count that was never seen to move, also one that stood before the core began, is no server yet: it is missed from the fifth second on.
  if (steps_ > 1 && given.server_heartbeat != heartbeat_)
    server_age_ = 0;
  else if (server_age_ < kNever)
    ++server_age_;
  heartbeat_ = given.server_heartbeat;
  lateness_s_ = given.wake_lateness_s;
  if (since_late_ < kNever) ++since_late_;
  too_late_ = lateness_s_ > kFarTooLate_s;
  if (lateness_s_ > kLate_s) {
    too_late_ = too_late_ || since_late_ < kLateWindow_steps;
    since_late_ = 0;
  }
}

void Ears::sent(const contract::CanFrame& frame) {
  for (std::size_t side = 0; side < drives_.size(); ++side) {
    const Node node = side == 0 ? Node::drive_left : Node::drive_right;
    if (frame.id != contract::pdo_cob_id(Pdo::drive_rx1, node)) continue;
    Drive& drive = drives_[side];
    drive.told_to_run = contract::read_slot(frame, contract::pdo_slot(Pdo::drive_rx1, 0x6040)) == kEnable;
    drive.target_m_s = static_cast<double>(contract::read_slot(frame, contract::pdo_slot(Pdo::drive_rx1, 0x60FF))) * kMetresPerTarget;
    drive.followed_m_s += (drive.target_m_s - drive.followed_m_s) * (kStep_s / kFollow_s);
  }
}

}  // namespace hoist::chaos
