#include "tests/chaos/moments.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "control/contract/commands.hpp"
#include "control/contract/guided_path.hpp"
#include "control/contract/params.hpp"

namespace hoist::chaos {
namespace {

using contract::CommandKind;
using contract::Mode;

constexpr auto kTherapistRole = static_cast<std::uint32_t>(contract::Role::therapist);
constexpr auto kEngineerRole = static_cast<std::uint32_t>(contract::Role::engineer);

int bumper_of(const Fault& fault) { return std::min(static_cast<int>(fault.size * 4.0), 3); }

}  // namespace

void Moments::go_on(const Fault& fault) {
  switch (fault.kind) {
    case Kind::touch_in_stop:
      return touch(fault);
    case Kind::lone_therapist:
      return pause_and_release();
    case Kind::other_console:
      return lead_from_elsewhere();
    case Kind::held_before:
      return press_too_early();
    case Kind::tuned_twice:
      return correct_a_setting();
    default:
      return;
  }
}

void Moments::end(const Fault& fault) {
  if (fault.kind == Kind::touch_in_stop) loop_.world().plant().force_bumper(bumper_of(fault), false);
  if (fault.kind == Kind::other_console && loop_.record().lease_holder == kStranger) loop_.ask_as(kStranger, CommandKind::release_lease);
  if (fault.kind == Kind::held_before && button_steps_ > 0) loop_.fall_silent();
  if (fault.kind == Kind::tuned_twice && wrong_row_) commit(*wrong_row_, right_value_);
}

bool Moments::may_start() const {
  return loop_.mode() == Mode::standby && loop_.record().lease_holder == kTherapist && loop_.record().blocked_bits == 0;
}

// Once in a stop, up to 0.2 s after it began, for 0.3 s: what the hoist slides against, or the foot of a helper.
void Moments::touch(const Fault& fault) {
  constexpr int kTouches_steps = 30;
  if (touch_steps_ > 0 && --touch_steps_ == kTouches_steps) loop_.world().plant().force_bumper(bumper_of(fault), true);
  if (touch_steps_ == 1) loop_.world().plant().force_bumper(bumper_of(fault), false);
  if (loop_.mode() != Mode::protective_stop) {
    touched_ = false;
  } else if (!touched_) {
    touched_ = true;
    touch_steps_ = kTouches_steps + 1 + dice_.below(20);
  }
}

// A therapist without an engineer: pauses the sound of each alarm, and tries to release a hoist that is out of service.
void Moments::pause_and_release() {
  if (loop_.mode() == Mode::fault && dice_.chance(0.02)) loop_.ask(CommandKind::acknowledge, 0, 0, 0, 0, kTherapistRole);
  if (quiet_steps_ > 0) {
    --quiet_steps_;
  } else if (loop_.record().fault_bits != 0 && dice_.chance(0.02)) {
    loop_.ask(CommandKind::pause_alarm, 1, 0, 0, 0, kTherapistRole);
    quiet_steps_ = 300 + dice_.below(2000);
  }
}

// Asks for starts that are not its own to ask for; takes a led hoist over where it stands, and pushes its own stick.
void Moments::lead_from_elsewhere() {
  const contract::TickRecord& record = loop_.record();
  if (may_start() && dice_.chance(0.02))
    loop_.ask_as(kStranger, CommandKind::request_mode, static_cast<std::uint32_t>(dice_.chance(0.5) ? Mode::user : Mode::remote));
  const bool led = contract::led_by_hand(loop_.mode());
  if (record.lease_holder != kStranger || !led) stranger_steps_ = 0;
  if (!led) return;
  if (record.lease_holder == kTherapist) {
    const auto& plant = loop_.world().plant();
    const double fastest_m_s =
        std::max(std::fabs(plant.wheel_speed_m_s(sim::Side::left)), std::fabs(plant.wheel_speed_m_s(sim::Side::right)));
    if (fastest_m_s < 0.005 && dice_.chance(0.03)) loop_.ask_as(kStranger, CommandKind::take_lease, contract::kTakeOver);
    return;
  }
  if (record.lease_holder != kStranger) return;
  constexpr int kMiddle_steps = 20;
  ++stranger_steps_;
  contract::DriveCommand drive;
  drive.lease_epoch = record.lease_epoch;
  drive.client = kStranger;
  drive.sequence = 2'000'000'000 + static_cast<std::uint64_t>(loop_.ticks());
  drive.echo_time_ns = record.time_ns;
  drive.speed_norm = stranger_steps_ > kMiddle_steps ? 0.5 : 0.0;
  drive.held = 1;
  loop_.put_drive(drive);
}

// The button of an exercise is held, and the exercise is begun only then.
void Moments::press_too_early() {
  constexpr int kBegin_steps = 30, kLetGo_steps = 80;
  if (!may_start()) {
    if (button_steps_ > 0 && loop_.mode() != Mode::guided) loop_.fall_silent();
    button_steps_ = std::min(button_steps_, 0);
    return;
  }
  if (button_steps_ <= 0) {
    if (button_steps_ < 0)
      ++button_steps_;
    else if (dice_.chance(0.02))
      button_steps_ = 1;
    return;
  }
  if (++button_steps_ == kLetGo_steps) {
    button_steps_ = -200;
    return loop_.let_go();
  }
  loop_.hold_stick(0.0, 0.0);
  if (button_steps_ != kBegin_steps) return;
  contract::Command command;
  contract::put_guided(command, {contract::GuidedShape::straight, false, 2.0, 0.0, 0.3, 1});
  loop_.ask(command.kind, command.a, command.v0, command.v1, command.v2, command.b);
}

// A setting of the nodes is changed by mistake, and put right before it has reached them all.
void Moments::correct_a_setting() {
  constexpr std::array kRows{contract::ParamName::drive_current_limit_a, contract::ParamName::drive_acceleration_rad_s2,
                             contract::ParamName::tilt_kalman_angle_norm, contract::ParamName::tilt_kalman_bias_per_s};
  if (wrong_row_) {
    if (--wrong_steps_ > 0 || loop_.mode() != Mode::standby || loop_.record().lease_holder != kTherapist) return;
    const std::size_t row = *wrong_row_;
    // Tried again as long as it was refused.
    if (contract::get_param(loop_.core().params, row) == right_value_) {
      wrong_row_.reset();
      return;
    }
    wrong_steps_ = 10;
    return commit(row, right_value_);
  }
  if (!may_start() || !dice_.chance(0.05)) return;
  const std::size_t row = contract::param_index(kRows[static_cast<std::size_t>(dice_.below(static_cast<int>(kRows.size())))]);
  right_value_ = contract::get_param(loop_.core().params, row);
  wrong_row_ = row;
  wrong_steps_ = 1 + dice_.below(6);
  commit(row, right_value_ * dice_.between(1.05, 1.2));
}

void Moments::commit(std::size_t row, double value) {
  loop_.ask(CommandKind::stage_parameter, contract::kParams[row].id, value);
  loop_.ask(CommandKind::commit_parameters, 1, 0, 0, 0, kEngineerRole);
}

}  // namespace hoist::chaos
