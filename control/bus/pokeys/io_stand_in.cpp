#include "control/bus/pokeys/io_stand_in.hpp"

#include <algorithm>
#include <cmath>

namespace hoist::bus::pokeys {

using contract::CanFrame;
using contract::Pdo;
namespace canopen = contract::canopen;
using NmtState = canopen::NmtState;

namespace {
constexpr std::uint8_t kId = contract::node_id(IoStandIn::kNode);
constexpr std::uint64_t kNsPerMs = 1'000'000;

// The objects that can be read over SDO; a PoKeys has no others. The core starts no node before its kept objects have told their defaults; here
// nothing acts on them.
constexpr bool is_readable(const contract::ObjectInfo& object) {
  return object.index == 0x1000 || object.index == 0x1001 || object.index == 0x1017 || object.index == 0x1018 ||
         std::ranges::find(contract::kKeptObjects, &object) != contract::kKeptObjects.end();
}

void put(std::span<CanFrame> out, std::size_t& count, const CanFrame& frame) {
  if (count < out.size()) out[count++] = frame;
}
}  // namespace

bool IoStandIn::is_from_node(const CanFrame& frame) {
  if (frame.flags != 0 || (frame.id & 0x7F) != kId) return false;
  const std::uint32_t base = frame.id & 0x780;
  return base == canopen::kEmcyBase || base == 0x180 || base == 0x280 || base == canopen::kSdoReplyBase || base == canopen::kHeartbeatBase;
}

void IoStandIn::boot(std::uint64_t now_ns) {
  state_ = NmtState::boot_up;
  reply_count_ = 0;
  heartbeat_at_ns_ = now_ns;
}

void IoStandIn::on_frame(const CanFrame& frame) {
  if (silent_ || frame.flags != 0) return;
  if (frame.id == canopen::kNmt && frame.dlc == 2 && (frame.data[1] == 0 || frame.data[1] == kId)) {
    switch (static_cast<canopen::NmtCommand>(frame.data[0])) {
      case canopen::NmtCommand::start:
        state_ = NmtState::operational;
        inputs_at_ns_ = batteries_at_ns_ = 0;  // at once
        return;
      case canopen::NmtCommand::stop:
        state_ = NmtState::stopped;
        return;
      case canopen::NmtCommand::pre_operational:
        state_ = NmtState::pre_operational;
        return;
      case canopen::NmtCommand::reset_node:
      case canopen::NmtCommand::reset_communication:
        boot(0);
        return;
    }
    return;
  }
  if (frame.id == canopen::kSdoRequestBase + kId && frame.dlc == 8 && state_ != NmtState::stopped) answer_sdo(frame);
}

void IoStandIn::answer_sdo(const CanFrame& request) {
  if (reply_count_ == replies_.size()) return;
  const auto index = static_cast<std::uint16_t>(contract::read_le(&request.data[1], 2));
  const std::uint8_t sub = request.data[3];
  const contract::ObjectInfo* object = contract::find_object(contract::NodeKind::io, index, sub);
  const std::uint32_t reply_id = canopen::kSdoReplyBase + kId;
  const auto abort = [&](canopen::SdoAbort why) {
    replies_[reply_count_++] = canopen::sdo(reply_id, canopen::kSdoAbort, index, sub, static_cast<std::uint32_t>(why));
  };
  if (request.data[0] == canopen::kSdoAbort) return;
  if (object == nullptr || !is_readable(*object)) return abort(canopen::SdoAbort::no_object);
  if (request.data[0] != canopen::kSdoUploadRequest) return abort(canopen::SdoAbort::read_only);
  const std::size_t bytes = contract::object_bytes(object->type);
  auto value = static_cast<std::uint32_t>(std::llround(contract::object_default(*object, kNode)));
  if (index == 0x1000) value = 0x00050191;  // CiA 401 without outputs: digital and analogue inputs
  replies_[reply_count_++] = canopen::sdo(reply_id, canopen::sdo_upload_reply_command(bytes), index, sub, value);
}

std::size_t IoStandIn::step(const Readings& readings, std::uint8_t pressed, std::uint64_t now_ns, std::span<CanFrame> out) {
  std::size_t count = 0;
  const bool gone = readings.inputs_ns == 0 || now_ns - std::min(readings.inputs_ns, now_ns) >= kGoneNs;
  if (gone) {
    silent_ = true;
    return 0;
  }
  if (silent_) {
    silent_ = false;
    boot(now_ns);
  }
  if (state_ == NmtState::boot_up) {
    put(out, count, canopen::heartbeat(kId, NmtState::boot_up));
    state_ = NmtState::pre_operational;
    heartbeat_at_ns_ = now_ns + kHeartbeatNs;
    shown_bumpers_ = 0;
    return count;
  }
  if (now_ns >= heartbeat_at_ns_) {
    put(out, count, canopen::heartbeat(kId, state_));
    heartbeat_at_ns_ = std::max(heartbeat_at_ns_ + kHeartbeatNs, now_ns);
  }
  for (std::size_t i = 0; i < reply_count_; ++i) put(out, count, replies_[i]);
  reply_count_ = 0;
  if (state_ != NmtState::operational) return count;

  const bool stale = now_ns - std::min(readings.inputs_ns, now_ns) >= kStaleNs;
  const auto bumpers = static_cast<std::uint8_t>(stale ? kAllPressed : (readings.bumpers | pressed) & kAllPressed);
  if (now_ns >= inputs_at_ns_ || bumpers != shown_bumpers_ || readings.switches != shown_switches_) {
    constexpr auto kInputs = contract::pdo_slot(Pdo::io_tx1, 0x6000, 1), kSwitches = contract::pdo_slot(Pdo::io_tx1, 0x6000, 2);
    CanFrame frame{contract::pdo_cob_id(Pdo::io_tx1, kNode), static_cast<std::uint8_t>(contract::pdo_bytes(Pdo::io_tx1)), 0, {}};
    contract::write_slot(frame, kInputs, bumpers);
    contract::write_slot(frame, kSwitches, readings.switches);
    put(out, count, frame);
    shown_bumpers_ = bumpers;
    shown_switches_ = readings.switches;
    inputs_at_ns_ = now_ns + contract::pdo_info(Pdo::io_tx1).period_ms * kNsPerMs;
  }
  if (now_ns >= batteries_at_ns_) {
    constexpr auto kA = contract::pdo_slot(Pdo::io_tx2, 0x6401, 1), kB = contract::pdo_slot(Pdo::io_tx2, 0x6401, 2);
    const bool old = readings.batteries_ns == 0 || now_ns - std::min(readings.batteries_ns, now_ns) >= kBatteryStaleNs;
    CanFrame frame{contract::pdo_cob_id(Pdo::io_tx2, kNode), static_cast<std::uint8_t>(contract::pdo_bytes(Pdo::io_tx2)), 0, {}};
    contract::write_slot(frame, kA, old ? 0 : readings.battery_10mv[0]);
    contract::write_slot(frame, kB, old ? 0 : readings.battery_10mv[1]);
    put(out, count, frame);
    batteries_at_ns_ = now_ns + contract::pdo_info(Pdo::io_tx2).period_ms * kNsPerMs;
  }
  return count;
}

}  // namespace hoist::bus::pokeys
