// The drive: servo loop at 1 kHz behind the CiA 402 state machine (profile velocity), and the drive's own safety stops.
//
// Three ways to standstill:
//   ramp       quick-stop ramp 6085h under the servo, then the bridge goes off. For every loss of the computer (RPDO deadline 45 ms,
//              heartbeat 250 ms, NMT no longer operational), for its own quick stop, and for faults with a valid encoder.
//   off        the bridge goes off at once. For faults that make the servo unreliable: encoder, current, supply, readings.
//   hold       operation enabled with target zero: normal standing.
// Operation is enabled only by a rising bit 3, and only while RPDOs arrive in time.
//
// A start begins in "not ready" with the self-test: current sensor at rest, readings, bridge driver, encoder lines, stored parameters, and
// the reset cause. The bridge stays off until it has passed.
//
// The current limit in force is 2200h:5, reduced for a hot winding, a sagging supply while motoring, or a rising one while braking. Faults
// come only where the reduction does not help.
#pragma once
#include <cmath>
#include <cstdint>
#include <utility>

#include "control/core/law/servo_loop.hpp"
#include "firmware/lib/canopen_node.hpp"
#include "firmware/lib/convert.hpp"
#include "firmware/nodes/drive/speed_estimate.hpp"
#include "firmware/nodes/drive/winding.hpp"

namespace hoist::firmware {

inline constexpr float kEncoderCountsPerTurn = 2000;   // of the motor shaft: 500 lines, four edges each
inline constexpr float kServoTick_s = 0.001F;          // paper S2: 1 kHz
inline constexpr float kUnderVoltage_v = 19.0F;        // hazard H12
inline constexpr float kSupplyBack_v = 20.0F;          // a reset of that fault needs this much
inline constexpr std::uint32_t kUnderVoltage_ms = 10;  // longer than the sag of one current peak
inline constexpr float kOverCurrent_a = 18.0F;         // one and a half times the largest limit that can be set: the limiter has failed
inline constexpr std::uint32_t kOverCurrent_ms = 2;
inline constexpr float kOverSpeed_rad_s = 225.0F;     // 0.75 m/s through gear 30 and wheel 0.10 m: top speed + 0.1 m/s, hazard H1
inline constexpr std::uint32_t kOverSpeed_ms = 20;    // hazard H1
inline constexpr float kStallCurrentShare = 0.7F;     // hazard H2
inline constexpr std::int32_t kStallCounts = 2;       // the encoder moves less than this ...
inline constexpr std::uint32_t kStall_ms = 100;       // ... for so long
inline constexpr float kStallReference_rad_s = 1.0F;  // holding still against a load is no stall
// At standstill voltage and current keep their ratio at any winding temperature. A motor that turns behind a dead encoder generates a
// rising voltage: 0.4 V in the rest of kStall_ms is 0.15 m/s2, far below what the current limit gives. The transient of a suddenly blocked
// wheel has ended by then: the winding's time constant is near 1 ms, the limiter's 5.
inline constexpr float kStallRise_v = 0.4F;
inline constexpr std::uint32_t kStallSettle_ms = 20;
inline constexpr float kReversedSpeed_rad_s = 20.0F;  // hazard H2: speed against the voltage that the motor generates
inline constexpr float kReversedVoltage_v = 2.5F;     // more than 30 % error of the resistance makes at 6 A
inline constexpr std::uint32_t kReversed_ms = 50;
// Hazard H2, an encoder that stops counting in motion: the generated voltage does not match the measured speed. Permitted differences:
// brushes and filter lag (together under 1.5 V), a winding 30 % off 2230h:6 (copper: 23 % at 80 degrees), and magnets, supply reading and
// encoder together 15 %.
inline constexpr float kUnexplained_v = 1.5F;
inline constexpr float kUnexplainedShareOfWinding = 0.3F;
inline constexpr float kUnexplainedShareOfGenerated = 0.15F;
inline constexpr std::uint32_t kUnexplained_ms = 50;
inline constexpr float kStandstill_rad_s = 2.0F;      // 0.7 cm/s at the wheel; one count in a filtered millisecond is 0.6 rad/s
inline constexpr std::uint32_t kStandstill_ms = 20;   // at rest for so long: stopped
inline constexpr std::uint32_t kStopLonger_ms = 500;  // after the ramp's end the bridge goes off even if the wheel is still pushed
inline constexpr float kTargetReached_rad_s = 3.0F;

inline constexpr std::uint32_t kSelfTest_ms = 20;  // the first 4 let the readings settle, the rest are averaged
inline constexpr std::uint32_t kSelfTestSettle_ms = 4;
inline constexpr float kCurrentOffsetMax_a = 0.6F;  // a tenth of the rated current; a healthy amplifier shows a tenth of that
inline constexpr float kCurrentNoiseMax_a = 1.0F;   // from lowest to highest, with the bridge off
// A current that flows although the bridge is off: shorted transistors (hazard H1). The offset is taken off by then, and the noise that the
// self-test lets pass stays below; the winding's own current has died away after 5 ms.
inline constexpr float kStrayCurrent_a = 1.0F;
inline constexpr std::uint32_t kStrayCurrent_ms = 20;
inline constexpr std::uint32_t kDriverFault_ms = 2;  // nFAULT low for so long; a shorter one is noise on the line
inline constexpr std::uint32_t kOverVoltage_ms = 5;
using contract::canopen::drive::kOverVoltageFold_v;
inline constexpr float kSagBegin_v = 21.0F, kSagEnd_v = 19.5F;  // while motoring; ends above the 19 V that switch off, hazard H12
inline constexpr float kSagShare = 0.25F;                       // of the current limit, left at kSagEnd_v
inline constexpr std::uint32_t kIllegalSteps = 3;               // in one window: a broken line; single ones are noise and only counted
inline constexpr std::uint32_t kIllegalWindow_ms = 100;         // hazard H2

// Faults of a drive in addition to those of every node (CiA 402).
namespace drive_emcy {
inline constexpr std::uint16_t kOverVoltage = 0x3210, kWindingHot = 0x4310, kBridge = 0x5400, kWatchdog = 0x6010, kBlocked = 0x7121;
}
inline constexpr std::uint8_t kTemperatureErrorBit = 0x08;  // of 1001h

// Bits of 2251h: what the self-test found. 0 = passed.
namespace self_test_bit {
inline constexpr std::uint8_t kRunning = 0x01, kCurrentSensor = 0x02, kReadings = 0x04, kDriver = 0x08, kEncoder = 0x10, kParameters = 0x20,
                              kWatchdog = 0x40;
}

template <DriveBoard Board>
class DriveNode {
 public:
  using Stack = CanopenNode<Board, contract::NodeKind::drive>;
  using State = contract::canopen::drive::State;

  DriveNode(Board& board, contract::Node node) : board_(board), stack_(board, node) { start(); }

  void on_frame(const CanFrame& frame) { stack_.on_frame(frame, *this); }

  void tick_1ms() {
    stack_.tick_1ms(*this);
    ++uptime_ms_;
    slow_ms_ = slow_ms_ + 1 < kSlow_ms ? slow_ms_ + 1 : 0;
    motor_watch_ms_ = motor_watch_ms_ + 1 < kMotorWatch_ms ? motor_watch_ms_ + 1 : 0;
    read_board();
    if (slow_ms_ == kHeatAt_ms) look_after_heat();
    if (state_ == State::not_ready) test_itself();
    run_servo();
    publish();
  }

  void power_on() {
    stack_.power_on();
    start();
  }

  // Called by the board when a 1 kHz tick began before the previous one had ended.
  void note_late_tick() { stack_.values().template set<0x2220, 1>(stack_.values().template get<0x2220, 1>() + 1U); }

  [[nodiscard]] const Stack& stack() const { return stack_; }
  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] float speed_rad_s() const { return speed_rad_s_; }
  [[nodiscard]] float reference_rad_s() const { return servo_.reference_rad_s.value; }
  [[nodiscard]] float current_limit_a() const { return current_limit_a_; }
  // Checked before the program is ended for a new one (1F51h:1): nothing is held and nothing rolls.
  [[nodiscard]] bool standing_safely() const { return !powered() && std::fabs(speed_rad_s_) < kStandstill_rad_s; }

 private:
  friend Stack;
  static constexpr std::uint16_t kSwitchOnBit = 0x01, kVoltageBit = 0x02, kNoQuickStopBit = 0x04, kEnableBit = 0x08, kRunBits = 0x0F,
                                 kResetBit = 0x80, kHaltBit = 0x100;

  // ---- callbacks of the stack

  void on_sync() {
    // The position of this very instant: both drives see the same SYNC.
    counts_ = board_.encoder_counts();
    stack_.values().template set<0x6064>(counts_);
    publish_numbers();
    numbers_age_ms_ = 0;
  }
  void on_rpdo() { apply(stack_.values().template get<0x6040>()); }
  void on_rpdo_deadline() { lose_command(); }
  void on_heartbeat_lost() { lose_command(); }
  void on_nmt(NmtState, NmtState to) {
    lose_command();
    // A reset of the communication forgets the list of errors; a latched fault is still one.
    if (to != NmtState::boot_up) return;
    if (fault_code_ != 0) stack_.set_error(fault_code_, fault_bit_, true);
    if (second_code_ != 0) stack_.set_error(second_code_, second_bit_, true);
  }
  // Power-on: all state is lost except the reset cause.
  void start() {
    winding_.start(winding_config());
    first_fault_ = {};
    uptime_ms_ = 0;
    after_watchdog_ = board_.reset_cause() == ResetCause::watchdog;
    on_power_on();
  }
  // A reset over the bus: the winding is as hot as before, and the snapshot stays.
  void on_power_on() {
    board_.set_bridge(false, 0.0F);
    begin_self_test();
    leaving_to_ = State::switch_on_disabled;
    leaving_ = false;
    servo_ = {};
    speed_rad_s_ = 0;
    duty_norm_ = 0;
    limited_ = false;
    word_ = kNoEdges;
    fault_code_ = second_code_ = 0;
    counts_ = board_.encoder_counts();
    estimate_.restart(counts_);
    restart_watches();
    stack_.values().template set<0x2221>(static_cast<std::uint8_t>(board_.reset_cause()));
    publish_first_fault();
  }
  SdoAbort check_write(std::uint16_t index, std::uint8_t, std::uint32_t raw) {
    switch (index) {
      case 0x6040:
      case 0x60FF:  // the RPDO alone commands a drive that may move
        return stack_.operational() ? SdoAbort::device_state : SdoAbort::none;
      case 0x605A:
        return raw == 2 || raw == 6 ? SdoAbort::none : SdoAbort::range;
      default:
        return SdoAbort::none;
    }
  }

  // ---- CiA 402

  // As if all bits had been set: no bit of the next word counts as an edge.
  static constexpr std::uint16_t kNoEdges = 0xFFFF;

  [[nodiscard]] bool powered() const {
    return state_ == State::operation_enabled || state_ == State::quick_stop_active || state_ == State::fault_reaction;
  }

  // Ramping to standstill or held there, independent of the target.
  [[nodiscard]] bool halted() const { return leaving_ || state_ == State::quick_stop_active || (word_ & kHaltBit) != 0; }

  // The computer is lost or not in control: the command ends, and the next word starts without history.
  void lose_command() {
    word_ = kNoEdges;
    stack_.values().template set<0x6040>(0);
    stack_.values().template set<0x60FF>(0);
    switch (state_) {
      case State::ready:
      case State::switched_on:
        state_ = State::switch_on_disabled;
        break;
      case State::operation_enabled:
        begin_stop(State::quick_stop_active, State::switch_on_disabled);
        break;
      case State::quick_stop_active:
        begin_stop(State::quick_stop_active, State::switch_on_disabled);
        break;
      default:
        break;
    }
  }

  void apply(std::uint16_t word) {
    const std::uint16_t before = std::exchange(word_, word);
    const bool reset = (word & ~before & kResetBit) != 0;
    if (state_ == State::fault) {
      // Shorted transistors often show as another fault first.
      if (reset && cause_gone(fault_code_) && cause_gone(second_code_) && !stray_current()) clear_fault();
      return;
    }
    if (reset && fault_code_ == 0) forget_first_fault();  // of a fault that a reset of the node had ended
    // A fault reaction must finish: disable voltage, which the computer sends meanwhile, would cut its ramp.
    if (state_ == State::fault_reaction || state_ == State::not_ready) return;
    if (!apply_stop(word)) apply_start(word, before);
  }

  // Disable voltage, quick stop and shutdown. True when the word is dealt with.
  bool apply_stop(std::uint16_t word) {
    if ((word & kVoltageBit) == 0) {  // disable voltage, transitions 7, 9, 10, 12: all transistors off
      switch_off(State::switch_on_disabled);
      return true;
    }
    if ((word & kNoQuickStopBit) == 0) {  // transitions 7, 10, 11
      if (state_ == State::operation_enabled)
        begin_stop(State::quick_stop_active,
                   stack_.values().template get<0x605A>() == 6 ? State::quick_stop_active : State::switch_on_disabled);
      else if (state_ != State::quick_stop_active)
        state_ = State::switch_on_disabled;
      return true;
    }
    // Transition 16 is not supported: a quick stop ends by disable voltage or at standstill.
    if (state_ == State::quick_stop_active) return true;
    if ((word & kSwitchOnBit) != 0) return false;
    if (state_ == State::operation_enabled)  // shutdown, transitions 2, 6 and 8: the ramp comes first
      begin_stop(State::operation_enabled, State::ready);
    else
      state_ = State::ready;
    return true;
  }

  void apply_start(std::uint16_t word, std::uint16_t before) {
    if (state_ == State::ready && supply_v_ >= kUnderVoltage_v && board_.driver_ok()) state_ = State::switched_on;  // transition 3
    if ((word & kEnableBit) == 0) {                                                                                 // transition 5
      if (state_ == State::operation_enabled) begin_stop(State::operation_enabled, State::switched_on);
      return;
    }
    // The order is new when the word before was any other. By the rise of its last bit alone, a word from which the line took another bit would
    // let this wheel stop by itself, although each word after it says to run.
    if ((before & kRunBits) == kRunBits) return;
    if (state_ == State::switched_on)
      enable();  // transition 4
    else if (state_ == State::operation_enabled)
      leaving_ = false;  // enabled again during the ramp: continues from the present ramp speed
  }

  void enable() {
    take_over();
    restart_watches();
    leaving_ = false;
    state_ = State::operation_enabled;
  }
  // A wheel that turns by itself is taken over at its speed and the voltage that it generates, and then braked on the ramp: otherwise the
  // first tick would short it.
  void take_over() {
    servo_.reference_rad_s.value = speed_rad_s_;
    servo_.integral_v = stack_.values().template get<0x2230, 7>() * speed_rad_s_;
    servo_.applied_v = servo_.integral_v;
  }

  // Ramps down in the state `meanwhile` and ends in `then`, with the bridge off unless the state is kept.
  void begin_stop(State meanwhile, State then) {
    if (!leaving_) stop_age_ms_ = still_ms_ = 0;
    state_ = meanwhile;
    leaving_ = true;
    leaving_to_ = then;
  }

  void switch_off(State then) {
    board_.set_bridge(false, 0.0F);
    duty_norm_ = 0;
    limited_ = false;
    leaving_ = false;
    servo_.integral_v = 0;
    servo_.applied_v = 0;
    servo_.reference_rad_s.value = 0;
    state_ = then;
  }

  // ---- faults: the first one stays until it is reset; one during its ramp that must switch off does so

  enum class Reaction : std::uint8_t { ramp, off };
  void fault(std::uint16_t code, std::uint8_t register_bit, Reaction reaction) {
    if (fault_code_ != 0) {
      if (reaction == Reaction::off && powered()) end_fault_ramp(code, register_bit);
      return;
    }
    fault_code_ = code;
    fault_bit_ = register_bit;
    if (first_fault_.code == 0) {
      first_fault_ = {code,
                      uptime_ms_,
                      counts_,
                      to_integer<std::int32_t>(1000.0F * speed_rad_s_),
                      to_integer<std::int32_t>(1000.0F * current_a_),
                      static_cast<std::uint32_t>(to_integer<std::int32_t>(1000.0F * supply_v_)),
                      to_integer<std::int16_t>(1000.0F * duty_norm_),
                      to_integer<std::int16_t>(10.0F * winding_.temperature_c())};
      publish_first_fault();
    }
    stack_.values().template set<0x603F>(code);
    stack_.set_error(code, register_bit, true);
    if (reaction == Reaction::off || !powered())
      switch_off(State::fault);
    else
      begin_stop(State::fault_reaction, State::fault);
  }
  // 603Fh keeps the first fault; the second has its own EMCY, because the reset waits for the end of both.
  void end_fault_ramp(std::uint16_t code, std::uint8_t register_bit) {
    second_code_ = code;
    second_bit_ = register_bit;
    stack_.set_error(code, register_bit, true);
    switch_off(State::fault);
  }
  [[nodiscard]] bool cause_gone(std::uint16_t code) const {
    switch (code) {
      case emcy::kUnderVoltage:
        return supply_v_ >= kSupplyBack_v;
      case emcy::kOverSpeed:
        return std::fabs(speed_rad_s_) <= kOverSpeed_rad_s;
      case emcy::kHardware:
        return readings_usable_;
      case emcy::kOverCurrent:
        return readings_usable_ && std::fabs(current_a_) <= kOverCurrent_a;
      case drive_emcy::kOverVoltage:
        return supply_v_ < stack_.values().template get<0x2231, 1>() - kOverVoltageFold_v;
      case drive_emcy::kWindingHot:
        return winding_.current_share(winding_config()) > Winding::kFoldShare;
      case drive_emcy::kBridge:
        return board_.driver_ok() && !stray_current();
      case emcy::kParametersLost:
        return stack_.parameters_ok();
      default:
        return true;  // none; or an encoder, which shows whether it works only when the motor runs
    }
  }
  void clear_fault() {
    stack_.set_error(fault_code_, fault_bit_, false);
    stack_.set_error(second_code_, second_bit_, false);
    fault_code_ = second_code_ = 0;
    stack_.values().template set<0x603F>(0);
    forget_first_fault();
    after_watchdog_ = false;
    if (self_test_ != 0)
      begin_self_test();  // the self-test had failed: repeat it
    else
      state_ = State::switch_on_disabled;
  }

  // Snapshot at the first fault, for service. Only a fault reset clears it.
  struct FirstFault {
    std::uint16_t code = 0;
    std::uint32_t time_ms = 0;
    std::int32_t position_counts = 0, speed_mrad_s = 0, current_ma = 0;
    std::uint32_t supply_mv = 0;
    std::int16_t duty_permille = 0, winding_dc = 0;
  };
  void publish_first_fault() {
    auto& values = stack_.values();
    values.template set<0x2240, 1>(first_fault_.code);
    values.template set<0x2240, 2>(first_fault_.time_ms);
    values.template set<0x2240, 3>(first_fault_.position_counts);
    values.template set<0x2240, 4>(first_fault_.speed_mrad_s);
    values.template set<0x2240, 5>(first_fault_.current_ma);
    values.template set<0x2240, 6>(first_fault_.supply_mv);
    values.template set<0x2240, 7>(first_fault_.duty_permille);
    values.template set<0x2240, 8>(first_fault_.winding_dc);
  }
  void forget_first_fault() {
    first_fault_ = {};
    publish_first_fault();
  }

  // ---- self-test

  void begin_self_test() {
    state_ = State::not_ready;
    self_test_ = self_test_bit::kRunning;
    self_test_ms_ = 0;
    offset_sum_a_ = 0;
    offset_low_a_ = offset_high_a_ = 0;
    current_offset_a_ = 0;
    illegal_at_start_ = illegal_seen_ = board_.illegal_encoder_steps();
  }
  // One millisecond of the self-test, with the bridge off: no current flows, so the sensor shows its offset.
  void test_itself() {
    if (!readings_usable_) self_test_ |= self_test_bit::kReadings;
    if (++self_test_ms_ > kSelfTestSettle_ms) {
      if (self_test_ms_ == kSelfTestSettle_ms + 1) offset_low_a_ = offset_high_a_ = current_a_;
      if (current_a_ < offset_low_a_) offset_low_a_ = current_a_;
      if (current_a_ > offset_high_a_) offset_high_a_ = current_a_;
      offset_sum_a_ += current_a_;
    }
    if (self_test_ms_ < kSelfTest_ms) return;
    const float offset_a = offset_sum_a_ / static_cast<float>(kSelfTest_ms - kSelfTestSettle_ms);
    const bool quiet = offset_high_a_ - offset_low_a_ <= kCurrentNoiseMax_a;
    if (!(std::fabs(offset_a) <= kCurrentOffsetMax_a) || !quiet) self_test_ |= self_test_bit::kCurrentSensor;
    // Without supply (emergency stop pressed) the driver rightly reports a fault; it is checked once the supply is present.
    if (supply_v_ >= kUnderVoltage_v && !board_.driver_ok()) self_test_ |= self_test_bit::kDriver;
    if (board_.illegal_encoder_steps() != illegal_at_start_) self_test_ |= self_test_bit::kEncoder;
    if (!stack_.parameters_ok()) self_test_ |= self_test_bit::kParameters;
    if (after_watchdog_) self_test_ |= self_test_bit::kWatchdog;
    self_test_ = static_cast<std::uint8_t>(self_test_ & ~self_test_bit::kRunning);
    state_ = State::switch_on_disabled;
    // The worst first: its code is the one that stays.
    if ((self_test_ & (self_test_bit::kReadings | self_test_bit::kCurrentSensor)) != 0)
      fault(emcy::kHardware, error_bit::kCurrent, Reaction::off);
    if ((self_test_ & self_test_bit::kDriver) != 0) fault(drive_emcy::kBridge, error_bit::kProfile, Reaction::off);
    if ((self_test_ & self_test_bit::kEncoder) != 0) fault(emcy::kEncoder, error_bit::kProfile, Reaction::off);
    if ((self_test_ & self_test_bit::kWatchdog) != 0) fault(drive_emcy::kWatchdog, error_bit::kProfile, Reaction::off);
    if ((self_test_ & self_test_bit::kParameters) != 0) fault(emcy::kParametersLost, error_bit::kProfile, Reaction::off);
    if (self_test_ == 0) current_offset_a_ = offset_a;
  }

  void restart_watches() {
    under_voltage_ms_ = over_current_ms_ = over_speed_ms_ = stall_ms_ = reversed_looks_ = unexplained_looks_ = 0;
    over_voltage_ms_ = driver_ms_ = illegal_age_ms_ = stray_current_ms_ = 0;
    illegal_seen_ = board_.illegal_encoder_steps();
    stall_counts_ = counts_;
  }

  // True once `condition` has held in `limit_ms` consecutive ticks.
  static bool lasts(bool condition, std::uint32_t& age_ms, std::uint32_t limit_ms) {
    if (!condition) {
      age_ms = 0;
      return false;
    }
    if (age_ms < limit_ms) ++age_ms;
    return age_ms >= limit_ms;
  }

  // Current while the bridge sleeps means shorted transistors. The fault keeps EN and nSLEEP low, is reported, and cannot be reset while
  // the current flows; only the relay in the supply ends it.
  void watch_sleeping_bridge() {
    const bool stray = state_ != State::not_ready && stray_current();
    if (lasts(stray, stray_current_ms_, kStrayCurrent_ms)) fault(drive_emcy::kBridge, error_bit::kProfile, Reaction::off);
  }
  // A current against the motion is none of those: a wheel pushed faster than about 0.7 m/s generates more than the supply and feeds it through
  // the bridge's diodes.
  [[nodiscard]] bool stray_current() const {
    const bool feeds_back = std::fabs(speed_rad_s_) > kStandstill_rad_s && (current_a_ > 0) != (speed_rad_s_ > 0);
    return !powered() && std::fabs(current_a_) > kStrayCurrent_a && !feeds_back;
  }

  // `applied_v` is the voltage of the tick before: the one that made the current just read.
  void watch(float reference_rad_s, float current_limit_a, float applied_v) {
    const auto& values = stack_.values();
    if (lasts(!board_.driver_ok(), driver_ms_, kDriverFault_ms)) fault(drive_emcy::kBridge, error_bit::kProfile, Reaction::off);
    if (lasts(supply_v_ < kUnderVoltage_v, under_voltage_ms_, kUnderVoltage_ms))
      fault(emcy::kUnderVoltage, error_bit::kVoltage, Reaction::off);
    if (lasts(supply_v_ > values.template get<0x2231, 1>(), over_voltage_ms_, kOverVoltage_ms))
      fault(drive_emcy::kOverVoltage, error_bit::kVoltage, Reaction::off);
    watch_encoder_lines();
    if (lasts(std::fabs(current_a_) > kOverCurrent_a, over_current_ms_, kOverCurrent_ms))
      fault(emcy::kOverCurrent, error_bit::kCurrent, Reaction::off);
    if (lasts(std::fabs(speed_rad_s_) > kOverSpeed_rad_s, over_speed_ms_, kOverSpeed_ms))
      fault(emcy::kOverSpeed, error_bit::kProfile, Reaction::ramp);

    // Blocked wheel, or an encoder that never counted: current without movement although movement is commanded.
    const std::int32_t moved = law::delta32(counts_, stall_counts_);
    const bool moving = moved > kStallCounts || moved < -kStallCounts;
    const bool stalled =
        !moving && std::fabs(current_a_) > kStallCurrentShare * current_limit_a && std::fabs(reference_rad_s) > kStallReference_rad_s;
    if (!stalled) stall_counts_ = counts_;
    if (stalled && stall_ms_ == kStallSettle_ms) {
      stall_begin_v_ = applied_v;
      stall_begin_a_ = current_a_;
    }
    if (lasts(stalled, stall_ms_, kStall_ms))
      fault(wheel_stands(applied_v) ? drive_emcy::kBlocked : emcy::kEncoder, error_bit::kProfile, Reaction::off);
    if (motor_watch_ms_ == kMotorWatchAt_ms) watch_motor(applied_v);
  }

  // At the end of a stall: blocked from outside, or turning unseen.
  [[nodiscard]] bool wheel_stands(float applied_v) const {
    const float rise_va = std::fabs(applied_v * stall_begin_a_ - current_a_ * stall_begin_v_);
    return rise_va <= kStallRise_v * std::fabs(stall_begin_a_);
  }

  // Whether speed, voltage and current belong to one motor; every few milliseconds, because it is a dozen operations in soft float.
  void watch_motor(float applied_v) {
    const auto& values = stack_.values();
    // Reversed encoder: it shows the motor turning against the voltage that the motor itself generates. Comparing with the plain duty
    // would take every braking for it: then the duty does oppose the speed, rightly.
    const float winding_v = values.template get<0x2230, 6>() * current_a_;
    const float generated_v = applied_v - winding_v;
    const bool reversed = std::fabs(speed_rad_s_) > kReversedSpeed_rad_s && std::fabs(generated_v) > kReversedVoltage_v &&
                          (generated_v > 0) != (speed_rad_s_ > 0);
    if (lasts(reversed, reversed_looks_, kReversed_ms / kMotorWatch_ms + 1)) fault(emcy::kEncoder, error_bit::kProfile, Reaction::off);

    // Encoder that stopped counting in motion. The servo sees a standing wheel and speeds it up; the current soon falls below the stall
    // rule's limit, because the motor runs so fast. The generated voltage shows it.
    const float explained_v = values.template get<0x2230, 7>() * speed_rad_s_;
    const float allowed_v =
        kUnexplained_v + kUnexplainedShareOfWinding * std::fabs(winding_v) + kUnexplainedShareOfGenerated * std::fabs(generated_v);
    const bool unexplained = std::fabs(generated_v - explained_v) > allowed_v;
    if (lasts(unexplained, unexplained_looks_, kUnexplained_ms / kMotorWatch_ms + 1))
      fault(emcy::kEncoder, error_bit::kProfile, Reaction::off);
  }

  // Both lines changing at once is impossible; now and then noise looks like it.
  void watch_encoder_lines() {
    const std::uint32_t steps = board_.illegal_encoder_steps();
    if (steps - illegal_seen_ >= kIllegalSteps) {
      fault(emcy::kEncoder, error_bit::kProfile, Reaction::off);
    } else if (++illegal_age_ms_ >= kIllegalWindow_ms) {
      illegal_age_ms_ = 0;
      illegal_seen_ = steps;
    }
  }

  // ---- how much current may flow

  [[nodiscard]] WindingConfig winding_config() const {
    const auto& values = stack_.values();
    WindingConfig config;
    config.limit_c = values.template get<0x2230, 2>();
    config.ambient_c = values.template get<0x2230, 3>();
    config.thermal_resistance_k_w = values.template get<0x2230, 4>();
    config.time_constant_s = values.template get<0x2230, 5>();
    config.resistance_ohm = values.template get<0x2230, 6>();
    return config;
  }
  // Nothing thermal changes within 10 ms.
  void look_after_heat() {
    const WindingConfig config = winding_config();
    thermal_share_ = winding_.current_share(config);
    if (powered() && winding_.too_hot(config)) fault(drive_emcy::kWindingHot, kTemperatureErrorBit, Reaction::ramp);
  }
  [[nodiscard]] float limit_in_force_a() {
    const auto& values = stack_.values();
    float share = thermal_share_;
    const bool braking = (speed_rad_s_ > 0) != (current_a_ > 0);
    const float room_v = values.template get<0x2231, 1>() - supply_v_;
    if (braking && room_v < kOverVoltageFold_v) {
      // Braking energy raises the supply when the battery does not take it.
      const float room_share = room_v <= 0.0F ? 0.0F : room_v / kOverVoltageFold_v;
      if (room_share < share) share = room_share;
    }
    if (!braking && powered() && supply_v_ < kSagBegin_v) {
      const float above_end_v = supply_v_ - kSagEnd_v;
      const float sag_share = above_end_v <= 0.0F ? kSagShare : kSagShare + (1.0F - kSagShare) / (kSagBegin_v - kSagEnd_v) * above_end_v;
      if (sag_share < share) share = sag_share;
    }
    limit_folded_ = share < 1.0F;
    return share * values.template get<0x2200, 5>();
  }

  // ---- every millisecond

  void read_board() {
    counts_ = board_.encoder_counts();
    measured_rad_s_ = kRadPerMsPerCount * estimate_.step(counts_, board_.edge_time_us());
    const float current_a = board_.motor_current_a();
    const float supply_v = board_.supply_v();
    readings_usable_ = law::finite(current_a) && law::finite(supply_v);
    current_a_ = law::finite(current_a) ? current_a - current_offset_a_ : 0.0F;
    supply_v_ = law::finite(supply_v) ? supply_v : 0.0F;
    if (!readings_usable_ && powered()) fault(emcy::kHardware, error_bit::kGeneric, Reaction::off);
    winding_.step_1ms(winding_config(), current_a_);
  }

  [[nodiscard]] law::ServoConfig<float> servo_config() {
    const auto& values = stack_.values();
    law::ServoConfig<float> config;
    config.counts_per_turn = kEncoderCountsPerTurn;
    config.k_p_v_s_rad = values.template get<0x2200, 1>();
    config.k_i_v_rad = values.template get<0x2200, 2>();
    config.speed_low_pass_s = values.template get<0x2200, 4>();
    if (std::bit_cast<std::uint32_t>(config.speed_low_pass_s) != filter_bits_) {
      filter_bits_ = std::bit_cast<std::uint32_t>(config.speed_low_pass_s);
      filter_share_ = law::low_pass_share(config.speed_low_pass_s, kServoTick_s);
    }
    config.speed_low_pass_share = filter_share_;
    config.current_limit_a = current_limit_a_ = limit_in_force_a();
    config.acceleration_max_rad_s2 = static_cast<float>(values.template get<0x6083>());
    return config;
  }

  void run_servo() {
    law::ServoConfig<float> config = servo_config();
    law::ServoInput<float> input;
    input.position_counts = counts_;
    input.command_age_s = 0;  // the RPDO deadline is checked above, with its own reaction
    input.speed_measured = true;
    input.speed_rad_s = measured_rad_s_;
    if (!powered()) return rest_servo(config, input);
    if (leaving_) config.acceleration_max_rad_s2 = static_cast<float>(stack_.values().template get<0x6085>());
    input.target_rad_s = halted() ? 0.0F : target_in_rad_s();
    input.current_a = current_a_;
    input.supply_v = supply_v_;
    const float applied_before_v = servo_.applied_v;
    const law::LowPassState<float> speed_before = servo_.speed_rad_s;
    const law::ServoOutput<float> output = law::servo_step(config, servo_, input, kServoTick_s);
    speed_rad_s_ = output.speed_rad_s;
    duty_norm_ = output.duty_norm;
    limited_ = output.limited;
    // A refusal with valid readings means no supply; the check below decides when that is a fault, and until then the bridge stays off.
    if (output.refused) roll_on(config, speed_before);
    watch(servo_.reference_rad_s.value, config.current_limit_a, applied_before_v);
    if (leaving_ && powered()) finish_stop(servo_.reference_rad_s.value);
    if (!powered()) return;  // just switched off, with the bridge
    board_.set_bridge(!output.refused, duty_norm_);
  }

  // A servo that refuses forgets all. The wheel rolls on, measured as before, and is taken over when the supply is back.
  void roll_on(const law::ServoConfig<float>& config, law::LowPassState<float> speed) {
    speed_rad_s_ = law::low_pass_by_share(config.speed_low_pass_share, speed, measured_rad_s_);
    servo_.speed_rad_s = speed;
    take_over();
  }

  // Without power the speed is still measured; the loop stays at rest, independent of the supply.
  void rest_servo(const law::ServoConfig<float>& config, const law::ServoInput<float>& input) {
    watch_sleeping_bridge();
    speed_rad_s_ = law::servo_step(config, servo_, input, kServoTick_s).speed_rad_s;
    servo_.integral_v = 0;
    servo_.applied_v = 0;
    servo_.reference_rad_s.value = 0;
    duty_norm_ = 0;
    limited_ = false;
    board_.set_bridge(false, 0.0F);
  }

  // 60FFh as a float, converted when it has changed.
  [[nodiscard]] float target_in_rad_s() {
    if (stack_.values().template get<0x60FF>() != target_mrad_s_) {
      target_mrad_s_ = stack_.values().template get<0x60FF>();
      target_rad_s_ = 0.001F * static_cast<float>(target_mrad_s_);
    }
    return target_rad_s_;
  }

  void finish_stop(float reference_rad_s) {
    if (reference_rad_s != 0.0F) return;
    ++stop_age_ms_;
    const bool still = lasts(std::fabs(speed_rad_s_) < kStandstill_rad_s, still_ms_, kStandstill_ms);
    if (!still && stop_age_ms_ < kStopLonger_ms) return;
    if (leaving_to_ == State::quick_stop_active) return;  // option 6: stays there, held at zero
    switch_off(leaving_to_);
  }

  // Status word 6041h of each state (CiA 402).
  [[nodiscard]] static constexpr std::uint16_t status_of(State state) {
    switch (state) {
      case State::not_ready:
        return 0x00;
      case State::switch_on_disabled:
        return 0x40;
      case State::ready:
        return 0x21;
      case State::switched_on:
        return 0x23;
      case State::operation_enabled:
        return 0x27;
      case State::quick_stop_active:
        return 0x07;
      case State::fault_reaction:
        return 0x0F;
      case State::fault:
        return 0x08;
    }
    return 0x00;
  }

  void publish() {
    std::uint16_t status = status_of(state_);
    if (supply_v_ >= kUnderVoltage_v) status = static_cast<std::uint16_t>(status | 0x10U);
    if (limit_folded_) status = static_cast<std::uint16_t>(status | 0x80U);  // warning: less current than set
    if (stack_.operational()) status = static_cast<std::uint16_t>(status | 0x200U);
    if ((state_ == State::operation_enabled || state_ == State::quick_stop_active) && on_target_)
      status = static_cast<std::uint16_t>(status | 0x400U);
    if (limited_) status = static_cast<std::uint16_t>(status | 0x800U);
    if (at_rest_) status = static_cast<std::uint16_t>(status | 0x1000U);
    stack_.values().template set<0x6041>(status);
    stack_.values().template set<0x6064>(counts_);
    stack_.values().template set<0x2251>(self_test_);
    if (numbers_age_ms_ < 2 * kSlow_ms) ++numbers_age_ms_;
    if (slow_ms_ == kNumbersAt_ms && numbers_age_ms_ >= 2 * kSlow_ms) publish_numbers();
    publish_slowly();
  }
  // Values of the PDOs, converted at every SYNC and now and then for SDO. Conversions cost more than the servo.
  void publish_numbers() {
    auto& values = stack_.values();
    const float target_rad_s = 0.001F * static_cast<float>(values.template get<0x60FF>());
    at_rest_ = std::fabs(speed_rad_s_) < kStandstill_rad_s;
    // CiA 402: during halt and quick stop the target is standstill.
    on_target_ = halted() ? at_rest_ : std::fabs(speed_rad_s_ - target_rad_s) < kTargetReached_rad_s;
    values.template set<0x606B>(to_integer<std::int32_t>(1000.0F * servo_.reference_rad_s.value));
    values.template set<0x606C>(to_integer<std::int32_t>(1000.0F * speed_rad_s_));
    const float rated_a = 0.001F * static_cast<float>(values.template get<0x6075>());
    values.template set<0x6078>(to_integer<std::int16_t>(1000.0F * current_a_ / rated_a));
    const float supply_v = supply_v_ > 0 ? supply_v_ : 0.0F;
    values.template set<0x6079>(static_cast<std::uint32_t>(to_integer<std::int32_t>(1000.0F * supply_v)));
    values.template set<0x2211>(to_integer<std::uint16_t>(100.0F * supply_v));
  }
  // Values for SDO: each every 10 ms, one at a time.
  void publish_slowly() {
    auto& values = stack_.values();
    switch (slow_ms_) {
      case 3:
        return values.template set<0x2230, 1>(to_integer<std::int16_t>(10.0F * winding_.temperature_c()));
      case 4:
        return values.template set<0x2252>(to_integer<std::int16_t>(1000.0F * current_offset_a_));
      case 6:
        values.template set<0x2230, 8>(current_limit_a_);
        values.template set<0x2250, 1>(board_.illegal_encoder_steps());
        return values.template set<0x2250, 2>(board_.edge_time_us());
      default:
        return;
    }
  }

  Board& board_;
  Stack stack_;
  State state_ = State::switch_on_disabled;
  bool leaving_ = false;  // on the ramp to a standstill, then to leaving_to_
  State leaving_to_ = State::switch_on_disabled;
  std::uint32_t stop_age_ms_ = 0, still_ms_ = 0;
  std::uint16_t word_ = kNoEdges;

  // What need not be done in every tick, and in which of the ten: no two in the same one.
  static constexpr std::uint32_t kSlow_ms = 10, kMotorWatch_ms = 5;
  static constexpr std::uint32_t kHeatAt_ms = 5, kNumbersAt_ms = 8, kMotorWatchAt_ms = 2;
  // One count per millisecond, in rad/s.
  static constexpr float kRadPerMsPerCount = 6.2831853F / (kEncoderCountsPerTurn * kServoTick_s);

  std::uint32_t uptime_ms_ = 0;
  law::ServoState<float> servo_{};
  SpeedEstimate estimate_{};
  Winding winding_{};
  FirstFault first_fault_{};
  bool after_watchdog_ = false, on_target_ = false, at_rest_ = true, limit_folded_ = false;
  std::uint32_t slow_ms_ = 0, motor_watch_ms_ = 0, numbers_age_ms_ = 0;
  std::uint32_t filter_bits_ = 0;  // the time constant that filter_share_ belongs to
  float filter_share_ = 0;
  std::int32_t target_mrad_s_ = 0;  // 60FFh, and the same as a float
  float target_rad_s_ = 0;
  std::uint8_t self_test_ = self_test_bit::kRunning;
  std::uint32_t self_test_ms_ = 0;
  float offset_sum_a_ = 0, offset_low_a_ = 0, offset_high_a_ = 0, current_offset_a_ = 0;
  std::int32_t counts_ = 0;
  float current_a_ = 0, supply_v_ = 0, speed_rad_s_ = 0, duty_norm_ = 0;
  float measured_rad_s_ = 0, current_limit_a_ = 0, thermal_share_ = 1;
  bool readings_usable_ = false, limited_ = false;

  std::uint16_t fault_code_ = 0, second_code_ = 0;  // the second ended the first one's ramp
  std::uint8_t fault_bit_ = 0, second_bit_ = 0;
  std::uint32_t under_voltage_ms_ = 0, over_current_ms_ = 0, over_speed_ms_ = 0, stall_ms_ = 0, reversed_looks_ = 0, unexplained_looks_ = 0;
  std::uint32_t over_voltage_ms_ = 0, driver_ms_ = 0, illegal_age_ms_ = 0, stray_current_ms_ = 0;
  std::uint32_t illegal_at_start_ = 0, illegal_seen_ = 0;
  std::int32_t stall_counts_ = 0;
  float stall_begin_v_ = 0, stall_begin_a_ = 0;  // after kStallSettle_ms of a stall
};

}  // namespace hoist::firmware
