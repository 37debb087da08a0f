#include "tests/chaos/judge/alarms.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hoist::chaos {
namespace {

using HoistFault = contract::Fault;
using contract::Mode;
using contract::Node;
using contract::TickRecord;

// An acknowledgement may wait half a second for a drive to leave its fault.
constexpr double kReleased_s = 0.6;
// H16: long enough to be read, and only when the patient stands: half of the 10 degrees, and 2 that the sensors' filter hides.
constexpr double kRead_s = 4.9, kUpright_rad = (0.5 * 10.0 + 2.0) * kDegree_rad;
constexpr double kTurns_m_s = 0.05, kTurns_s = 0.2;

// The judge's own: alarms that last as long as their cause. Every other one has stopped the hoist, and stays until it is acknowledged.
constexpr contract::FaultBits kPassing = [] {
  contract::FaultBits bits = 0;
  for (const HoistFault fault : {HoistFault::battery_empty, HoistFault::battery_low, HoistFault::battery_uneven, HoistFault::supply_high,
                                 HoistFault::remote_command_lost, HoistFault::server_lost, HoistFault::console_lost,
                                 HoistFault::base_tilt_high, HoistFault::patient_hanging, HoistFault::wheel_slip})
    bits |= contract::fault_bit(fault);
  return bits;
}();

}  // namespace

void Alarms::restart() {
  known_ = held_ = false;
  stands_s_ = {};
}

// A sensor is switched off and on, and in the end replaced, for what it said itself; a frame that is none of the dictionary's says nothing.
bool Alarms::sensor_failed() const {
  constexpr int kSaid_steps = 20;
  // Rates that add up to a lost zero are remembered for ten seconds; a filter unlearns what it was taught within a minute.
  constexpr double kUnlearnt_s = 60.0;
  if (ears_.doubt_age() < kSaid_steps) return true;
  return std::any_of(board_.rows.begin(), board_.rows.end(), [&](const Planned& row) {
    const bool kind = row.fault.kind == Kind::gyro_jump || (row.fault.kind >= Kind::sensor_stuck && row.fault.kind <= Kind::sensor_silent);
    return kind && (row.on || (row.done && world_.time_s() - row.fault.end_s < kUnlearnt_s));
  });
}

void Alarms::raised(HoistFault fault) {
  raised_s_[contract::fault_info(fault).bit] = world_.time_s();
  if (fault == HoistFault::tilt_sensor_fault && !sensor_failed()) broken_("I11: a sensor has failed that never said so", 0.0, {});
}

void Alarms::cleared(HoistFault fault, Mode before, const Truth& truth, bool lean_known) {
  const double now_s = world_.time_s();
  const std::string_view name = contract::fault_info(fault).name;
  // INIT checks everything again when it ends.
  if (before != Mode::init && (kPassing & contract::fault_bit(fault)) == 0 && now_s - acknowledged_s_ > kReleased_s)
    broken_("I11: an alarm goes out without an acknowledgement: ", now_s - acknowledged_s_, name);
  if (fault != HoistFault::patient_hanging) return;
  const double shown_s = now_s - raised_s_[contract::fault_info(fault).bit];
  if (shown_s < kRead_s) broken_("I11: the alarm for a patient who hangs goes out before it can be read", shown_s, {});
  if (lean_known && truth.lean_rad > kUpright_rad)
    broken_("I11: the alarm for a patient who hangs goes out while the patient hangs", truth.lean_rad, {});
}

void Alarms::see_millisecond() {
  // H11: what flows through a motor is limited, also into a wheel that is blocked. The limiter takes 5 ms; a wheel that was stopped at once drew
  // more for 8. One that a body pushes faster than this generates more than the supply, and feeds it through the bridge's diodes.
  constexpr double kOver_norm = 1.25, kGenerates_m_s = 0.65;
  constexpr int kOver_ms = 12;
  const sim::Plant& plant = world_.plant();
  for (const sim::Side side : {sim::Side::left, sim::Side::right}) {
    int& above_ms = above_ms_[static_cast<std::size_t>(side)];
    const bool served = plant.bridge_enabled(side) && !board_.shorted(side == sim::Side::left ? Node::drive_left : Node::drive_right) &&
                        std::fabs(plant.wheel_speed_m_s(side)) < kGenerates_m_s;
    above_ms = served && limit_a_ > 0 && std::fabs(plant.motor_current_a(side)) > kOver_norm * limit_a_ ? above_ms + 1 : 0;
    if (above_ms == kOver_ms) broken_("I2: a motor gets more current than its limit", plant.motor_current_a(side), {});
  }
}

void Alarms::hand(double seen_s, bool held) {
  seen_s_ = known_ ? std::max(seen_s_, seen_s) : seen_s;
  told_s_ = world_.time_s();
  known_ = true;
  held_ = held;
}

void Alarms::after_step(const Told& told, const Truth& truth, std::uint32_t from, bool free) {
  limit_a_ = told.params.drive_current_limit_a;
  watch_driver(told.record, truth, from, free);
  watch_hand(told.record);
  watch_words(told.record, truth);
  watch_wheels(told.record);
}

// H20: control changes hands at rest. What turns a wheel so slowly, or for a moment, is no motion; a silent drive's wheel cannot be asked.
void Alarms::watch_driver(const TickRecord& record, const Truth& truth, std::uint32_t from, bool free) {
  const bool heard = ears_.age(Node::drive_left) <= 1 && ears_.age(Node::drive_right) <= 1;
  const bool known = heard && std::fabs(static_cast<double>(record.wheel_left_m_s) - truth.wheel_m_s[0]) < kTurns_m_s &&
                     std::fabs(static_cast<double>(record.wheel_right_m_s) - truth.wheel_m_s[1]) < kTurns_m_s;
  turns_s_ = known && truth.fastest_m_s > kTurns_m_s ? turns_s_ + kStep_s : 0;
  if (turns_s_ > kTurns_s && !free && from != 0 && record.lease_holder != 0 && record.lease_holder != from)
    broken_("I3: control changes hands while the hoist moves", truth.fastest_m_s, {});
}

// I6, H18: the age that is shown, and acted upon, counts from what the hand had seen, not from when its command arrived.
void Alarms::watch_hand(const TickRecord& record) {
  if (!known_ || !contract::led_by_hand(static_cast<Mode>(record.mode))) return;
  constexpr double kNone_s = 9.9;  // shown for every older one, and for none
  const double age_s = std::min(world_.time_s() - seen_s_, kNone_s);
  if (static_cast<double>(record.remote_age_s) < age_s - 2.0 * kStep_s)
    broken_("I6: a driving command is told to be younger than it is", age_s, {});
  const bool wished = record.speed_wish_m_s != 0 || record.yaw_rate_wish_rad_s != 0;
  if (!held_ && wished) broken_("I6: drives on after its driver let go", static_cast<double>(record.speed_wish_m_s), {});
}

// The words for a blocked wheel send a person to the sill under it; those for the machine send for service, and the third stop puts the hoist
// out of service. Only where nothing else of this drive or of its supply is broken.
void Alarms::watch_words(const TickRecord& record, const Truth& truth) {
  constexpr std::uint16_t kBlocked = 0x7121;
  constexpr double kSettled_s = 0.05, kTold_s = 0.3;
  for (const Node node : {Node::drive_left, Node::drive_right}) {
    const std::size_t side = node == Node::drive_left ? 0 : 1;
    const bool only = std::all_of(board_.rows.begin(), board_.rows.end(), [&](const Planned& row) {
      const bool own = info(row.fault.kind).target == Target::nothing ? row.fault.kind != Kind::babble : row.fault.node == node;
      return !row.on || row.fault.kind == Kind::wheel_blocked || !own || info(row.fault.kind).outside;
    });
    const bool stands = board_.now(Kind::wheel_blocked, node) && only && std::fabs(truth.wheel_m_s[side]) < 0.01;
    stands_s_[side] = stands ? stands_s_[side] + kStep_s : 0;
    const HoistFault fault = side == 0 ? HoistFault::drive_left_fault : HoistFault::drive_right_fault;
    const double since_s = world_.time_s() - raised_s_[contract::fault_info(fault).bit];
    const std::uint16_t code = side == 0 ? record.drive_left_fault_code : record.drive_right_fault_code;
    if ((record.fault_bits & contract::fault_bit(fault)) != 0 && since_s < kTold_s && stands_s_[side] > since_s + kSettled_s && code != 0 &&
        code != kBlocked)
      broken_("I11: a blocked wheel is told as a fault of the machine", static_cast<double>(code), {});
  }
}

// H2: a position that no wheel can have reached is no motion. 3 m/s is believed, five times the top speed.
void Alarms::watch_wheels(const TickRecord& record) {
  constexpr double kBelieved_m_s = 3.1;
  const double fastest_m_s =
      std::max(std::fabs(static_cast<double>(record.wheel_left_m_s)), std::fabs(static_cast<double>(record.wheel_right_m_s)));
  if (fastest_m_s > kBelieved_m_s) broken_("I2: a wheel is told to turn faster than any can", fastest_m_s, {});
}

}  // namespace hoist::chaos
