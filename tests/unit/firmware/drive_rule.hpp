// The rules of a drive, written a second time from their descriptions (firmware/nodes/README.md "Safety reactions of a drive", CiA 402,
// DECISIONS.md 1 to 5, 14 to 17, 22, 25, 29, 33 and 41; hazards H1, H2, H5, H11 and H12). Its speed estimate, its winding and the step of the
// servo have rules of their own (drive_rules_test.cpp, the tests of control/core/law) and are used as they are: all else is equal to the bit.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "control/core/law/servo_loop.hpp"
#include "firmware/nodes/drive/speed_estimate.hpp"
#include "firmware/nodes/drive/winding.hpp"
#include "tests/unit/firmware/test_board.hpp"

namespace hoist::firmware {

// Rounded as a person would, held at the ends of the type.
template <class Integer>
Integer rounded(float value) {
  const double at = std::round(static_cast<double>(value));
  return static_cast<Integer>(std::clamp<double>(at, std::numeric_limits<Integer>::min(), std::numeric_limits<Integer>::max()));
}

// In how many milliseconds in a row something has been seen.
struct InARow {
  int seen = 0;
  bool at_least(int count, bool now) {
    seen = now ? seen + 1 : 0;
    return seen >= count;
  }
};

// What may be written over the bus, with the values at power-on.
struct DriveSettings {
  float gain = 0.12F, integral = 2.4F, filter_s = 0.004F, limit_a = 6, motor_v_s = 0.115F, highest_v = 32;
  WindingConfig winding{1.2F, 40, 120, 1.3F, 60};
  int ramp_rad_s2 = 450, stop_ramp_rad_s2 = 300, stop_option = 2;
  int heartbeat_ms = 250, on_error = 0;
};

// What a service technician reads after a fault (2240h).
struct FaultRecord {
  unsigned code = 0, time_ms = 0;
  std::int32_t counts = 0, speed_mrad_s = 0, current_ma = 0;
  unsigned supply_mv = 0;
  int duty_permille = 0, winding_dc = 0;
};

// The errors in force (1001h), the last four that began (1003h), and the EMCY that have not left yet.
class ErrorList {
 public:
  void set(unsigned code, unsigned bit, bool on) {
    const auto at = std::find_if(active_.begin(), active_.end(), [code](const Error& error) { return error.code == code; });
    if ((at != active_.end()) == on) return;
    if (on)
      active_.push_back({code, bit});
    else
      active_.erase(at);
    shown = active_.empty() ? 0 : 1;
    for (const Error& error : active_) shown |= error.bit;
    if (on) {
      std::rotate(history.begin(), history.end() - 1, history.end());
      history[0] = code | shown << 16;
    }
    if (waiting.size() < 8) waiting.push_back({on ? code : 0, shown});
  }
  void forget() { *this = {}; }

  struct Error {
    unsigned code = 0, bit = 0;
  };
  unsigned shown = 0;
  std::array<unsigned, 4> history{};
  std::deque<Error> waiting;

 private:
  std::vector<Error> active_;
};

// What it shows of itself by SDO and PDO, besides state and errors.
struct DriveShown {
  unsigned word = 0, error_code = 0, supply_10mv = 0, supply_mv = 0, status = 0, self_test = 1, illegal = 0, edge_us = 0xFFFFFFFF;
  std::int32_t target_mrad_s = 0, counts = 0, demand_mrad_s = 0, speed_mrad_s = 0;
  int current_permille = 0, winding_dc = 0, offset_ma = 0;
  float limit_a = 0;
};

class DriveRule {
 public:
  using State = canopen::drive::State;

  explicit DriveRule(const TestBoard& board) : board_(board) { power_on(); }

  State state = State::not_ready;
  DriveSettings set;
  DriveShown shown;
  FaultRecord record;
  ErrorList errors;
  bool bridge = false;
  float duty = 0, speed_rad_s = 0, limit_a = 0;
  NmtState nmt_state = NmtState::boot_up;
  unsigned second_code = 0;     // of a fault that has ended the ramp of another
  bool parameters_good = true;  // those stored could be read

  [[nodiscard]] bool powered() const {
    return state == State::operation_enabled || state == State::quick_stop_active || state == State::fault_reaction;
  }
  [[nodiscard]] bool operational() const { return nmt_state == NmtState::operational; }
  [[nodiscard]] float reference_rad_s() const { return servo_.reference_rad_s.value; }
  [[nodiscard]] bool ramping() const { return then_.has_value(); }

  // ---- what comes from outside

  void power_on() {
    winding_.start(set.winding = DriveSettings{}.winding);
    record = {};
    age_ms_ = 0;
    by_watchdog_ = board_.cause == ResetCause::watchdog;
    reset_node();
  }
  void reset_node() {
    nmt_state = NmtState::boot_up;
    set = {}, shown = {};
    errors.forget();
    if (!parameters_good) errors.set(0x6310, 0x20, true);
    heartbeat_ms_.reset(), command_ms_.reset();
    first_ = {}, second_code = 0;
    word_ = kAllBits;
    counts_ = board_.counts;
    estimate_.restart(counts_);
    speed_rad_s = 0;
    let_go(State::not_ready);
    servo_ = {};
    forget_what_lasted();
    begin_test();
  }
  void nmt(canopen::NmtCommand command) {
    switch (command) {
      case canopen::NmtCommand::start:
        return enter(NmtState::operational);
      case canopen::NmtCommand::stop:
        return enter(NmtState::stopped);
      case canopen::NmtCommand::pre_operational:
        return enter(NmtState::pre_operational);
      case canopen::NmtCommand::reset_node:
        return reset_node();
      case canopen::NmtCommand::reset_communication:
        errors.forget();
        if (!parameters_good) errors.set(0x6310, 0x20, true);
        heartbeat_ms_.reset(), command_ms_.reset();
        set.heartbeat_ms = 250, set.on_error = 0;
        enter(NmtState::boot_up);
        // Faults are latched: this reset ends none.
        if (first_.code != 0) errors.set(first_.code, first_.bit, true);
        if (second_code != 0) errors.set(second_code, second_bit_, true);
        return;
    }
  }
  void heartbeat(bool boot_up) {
    if (boot_up && heartbeat_ms_) lose_heartbeat();
    if (boot_up) return;
    heartbeat_ms_ = 0;
    errors.set(0x8130, 0x10, false);
  }
  void sync() {
    if (!operational()) return;
    counts_ = shown.counts = board_.counts;
    look();
    since_sync_ms_ = 0;
  }
  void command(unsigned word, std::int32_t target_mrad_s) {
    if (!operational()) return;
    shown.word = word, shown.target_mrad_s = target_mrad_s;
    command_ms_ = 0;
    errors.set(0x8250, 0x10, false);
    obey(word);
  }

  // Gives the EMCY that leaves in this millisecond, if one does: what is found in it comes after.
  ErrorList::Error tick(bool emcy_leaves) {
    watch_bus();
    ErrorList::Error left;
    if (emcy_leaves && !errors.waiting.empty()) {
      left = errors.waiting.front();
      errors.waiting.pop_front();
    }
    ++ticks_, ++age_ms_;
    read();
    if (ticks_ % 10 == 5) {
      share_by_heat_ = winding_.current_share(set.winding);
      if (powered() && winding_.too_hot(set.winding)) fault(0x4310, 0x08, kRamp);
    }
    if (state == State::not_ready) test();
    move();
    show();
    return left;
  }

 private:
  static constexpr unsigned kAllBits = 0xFFFF;
  static constexpr bool kRamp = false, kOff = true;

  // ---- loss of the computer

  void enter(NmtState to) {
    if (to == std::exchange(nmt_state, to)) return;
    command_ms_.reset();
    lose_command();
  }
  void watch_bus() {
    if (nmt_state == NmtState::boot_up) return enter(NmtState::pre_operational);
    if (heartbeat_ms_ && ++*heartbeat_ms_ >= set.heartbeat_ms) lose_heartbeat();
    if (command_ms_ && ++*command_ms_ >= 45) {
      command_ms_.reset();
      errors.set(0x8250, 0x10, true);
      lose_command();
    }
  }
  void lose_heartbeat() {
    heartbeat_ms_.reset();
    errors.set(0x8130, 0x10, true);
    lose_command();
    if (set.on_error == 0 && operational()) enter(NmtState::pre_operational);
    if (set.on_error == 2) enter(NmtState::stopped);
  }
  // A drive in motion brakes on the ramp of a quick stop; the next word has no history.
  void lose_command() {
    word_ = kAllBits;
    shown.word = 0, shown.target_mrad_s = 0;
    if (state == State::ready || state == State::switched_on) state = State::switch_on_disabled;
    if (state == State::operation_enabled || state == State::quick_stop_active) leave(State::quick_stop_active, State::switch_on_disabled);
  }

  // ---- CiA 402

  enum class Command : std::uint8_t { disable_voltage, quick_stop, shutdown, switch_on, enable };
  static Command command_of(unsigned word) {
    if ((word & 2) == 0) return Command::disable_voltage;
    if ((word & 4) == 0) return Command::quick_stop;
    if ((word & 1) == 0) return Command::shutdown;
    return (word & 8) == 0 ? Command::switch_on : Command::enable;
  }
  void obey(unsigned word) {
    const unsigned before = std::exchange(word_, word);
    const Command command = command_of(word);
    const bool reset = (word & ~before & 0x80) != 0, enable_rises = command == Command::enable && command_of(before) != Command::enable;
    if (reset && first_.code == 0) record = {};
    switch (state) {
      case State::fault:
        if (reset && gone(first_.code) && gone(second_code) && !flows_by_itself()) end_fault();
        return;
      case State::not_ready:
      case State::fault_reaction:
        return;
      case State::switch_on_disabled:
        if (command == Command::shutdown) state = State::ready;
        return;
      case State::ready:
      case State::switched_on:
        return obey_at_rest(command, enable_rises);
      case State::quick_stop_active:
        if (command == Command::disable_voltage) let_go(State::switch_on_disabled);
        return;
      case State::operation_enabled:
        return obey_in_operation(command, enable_rises);
    }
  }
  void obey_at_rest(Command command, bool enable_rises) {
    if (command == Command::disable_voltage || command == Command::quick_stop) {
      state = State::switch_on_disabled;
    } else if (command == Command::shutdown) {
      state = State::ready;
    } else {
      if (supply_v_ >= 19 && board_.driver_good) state = State::switched_on;
      if (enable_rises && state == State::switched_on) take_over();
    }
  }
  void obey_in_operation(Command command, bool enable_rises) {
    switch (command) {
      case Command::disable_voltage:
        return let_go(State::switch_on_disabled);
      case Command::quick_stop:
        return leave(State::quick_stop_active, set.stop_option == 6 ? State::quick_stop_active : State::switch_on_disabled);
      case Command::shutdown:
        return leave(State::operation_enabled, State::ready);
      case Command::switch_on:
        return leave(State::operation_enabled, State::switched_on);
      case Command::enable:
        if (enable_rises) then_.reset();
        return;
    }
  }
  // At the speed and the voltage that the motor has.
  void follow_motor() {
    servo_.reference_rad_s.value = speed_rad_s;
    servo_.integral_v = servo_.applied_v = set.motor_v_s * speed_rad_s;
  }
  void take_over() {
    follow_motor();
    forget_what_lasted();
    then_.reset();
    state = State::operation_enabled;
  }
  void leave(State meanwhile, State then) {
    if (!then_) waited_ms_ = 0, still_ = {};
    state = meanwhile;
    then_ = then;
  }
  void let_go(State then) {
    bridge = false;
    duty = 0;
    limited_ = false;
    then_.reset();
    servo_.integral_v = servo_.applied_v = servo_.reference_rad_s.value = 0;
    state = then;
  }
  [[nodiscard]] bool to_standstill() const { return then_ || state == State::quick_stop_active || (word_ & 0x100) != 0; }

  // ---- faults

  void fault(unsigned code, unsigned bit, bool off) {
    if (first_.code != 0) {
      if (!off || !powered()) return;
      second_code = code, second_bit_ = bit;
      errors.set(code, bit, true);
      return let_go(State::fault);
    }
    first_ = {code, bit};
    shown.error_code = code;
    errors.set(code, bit, true);
    if (record.code == 0)
      record = {code,
                age_ms_,
                counts_,
                rounded<std::int32_t>(1000 * speed_rad_s),
                rounded<std::int32_t>(1000 * current_a_),
                rounded<unsigned>(1000 * supply_v_),
                rounded<std::int16_t>(1000 * duty),
                rounded<std::int16_t>(10 * winding_.temperature_c())};
    if (off || !powered())
      let_go(State::fault);
    else
      leave(State::fault_reaction, State::fault);
  }
  [[nodiscard]] bool gone(unsigned code) const {
    switch (code) {
      case 0x3220:
        return supply_v_ >= 20;
      case 0x3210:
        return supply_v_ < set.highest_v - 2;
      case 0x8400:
        return std::fabs(speed_rad_s) <= 225;
      case 0x5000:
        return usable_;
      case 0x2310:
        return usable_ && std::fabs(current_a_) <= 18;
      case 0x4310:
        return winding_.current_share(set.winding) > 0.3F;
      case 0x5400:
        return board_.driver_good && !flows_by_itself();
      case 0x6310:
        return parameters_good;
      default:
        return true;
    }
  }
  void end_fault() {
    errors.set(first_.code, 0, false);
    errors.set(second_code, 0, false);
    first_ = {}, second_code = 0, shown.error_code = 0;
    record = {};
    by_watchdog_ = false;
    state = State::switch_on_disabled;
    if (test_result_ != 0) begin_test();
  }

  // ---- self-test: twenty milliseconds, the last sixteen of which show the current sensor at rest

  void begin_test() {
    state = State::not_ready;
    test_result_ = 1;
    test_ms_ = 0;
    test_readable_ = true;
    at_rest_a_.clear();
    offset_a_ = 0;
    illegal_before_ = window_began_ = board_.illegal_steps;
  }
  void test() {
    test_readable_ = test_readable_ && usable_;
    if (!test_readable_) test_result_ |= 4;
    if (++test_ms_ > 4) at_rest_a_.push_back(current_a_);
    if (test_ms_ < 20) return;
    const float mean_a = std::accumulate(at_rest_a_.begin(), at_rest_a_.end(), 0.0F) / 16;
    const auto [low, high] = std::minmax_element(at_rest_a_.begin(), at_rest_a_.end());
    const bool sensor = std::fabs(mean_a) <= 0.6F && *high - *low <= 1;
    const bool driver = supply_v_ < 19 || board_.driver_good;
    const bool encoder = board_.illegal_steps == illegal_before_;
    test_result_ = (sensor ? 0U : 2U) | (test_readable_ ? 0U : 4U) | (driver ? 0U : 8U) | (encoder ? 0U : 0x10U) |
                   (parameters_good ? 0U : 0x20U) | (by_watchdog_ ? 0x40U : 0U);
    state = State::switch_on_disabled;
    if (!sensor || !test_readable_) fault(0x5000, 0x02, kOff);
    if (!driver) fault(0x5400, 0x20, kOff);
    if (!encoder) fault(0x7305, 0x20, kOff);
    if (by_watchdog_) fault(0x6010, 0x20, kOff);
    if (!parameters_good) fault(0x6310, 0x20, kOff);
    if (test_result_ == 0) offset_a_ = mean_a;
  }

  // ---- every millisecond

  void read() {
    counts_ = board_.counts;
    // One count in a millisecond is a two-thousandth of a turn.
    measured_rad_s_ = 6.2831853F / 2 * estimate_.step(counts_, board_.edge_us);
    usable_ = std::isfinite(board_.current_a) && std::isfinite(board_.supply_voltage_v);
    current_a_ = std::isfinite(board_.current_a) ? board_.current_a - offset_a_ : 0;
    supply_v_ = std::isfinite(board_.supply_voltage_v) ? board_.supply_voltage_v : 0;
    if (!usable_ && powered()) fault(0x5000, 0x01, kOff);
    winding_.step_1ms(set.winding, current_a_);
  }
  // Less current for a hot winding, for a supply that sags under a motor, and for one that rises under a brake.
  float limit_now() {
    const bool brakes = (speed_rad_s > 0) != (current_a_ > 0);
    float share = share_by_heat_;
    if (brakes) share = std::min(share, std::clamp((set.highest_v - supply_v_) / 2, 0.0F, 1.0F));
    if (!brakes && powered()) share = std::min(share, std::clamp(0.25F + (supply_v_ - 19.5F) / 2, 0.25F, 1.0F));
    reduced_ = share < 1;
    return share * set.limit_a;
  }
  void move() {
    const float filter = law::low_pass_share(set.filter_s, 0.001F);
    limit_a = limit_now();
    if (!powered()) {
      if (lasting_.stray.at_least(20, state != State::not_ready && flows_by_itself())) fault(0x5400, 0x20, kOff);
      speed_rad_s = law::low_pass_by_share(filter, servo_.speed_rad_s, measured_rad_s_);
      return let_go(state);
    }
    law::ServoConfig<float> config;
    config.k_p_v_s_rad = set.gain, config.k_i_v_rad = set.integral, config.current_limit_a = limit_a;
    config.speed_low_pass_s = set.filter_s, config.speed_low_pass_share = filter;
    config.acceleration_max_rad_s2 = static_cast<float>(then_ ? set.stop_ramp_rad_s2 : set.ramp_rad_s2);
    law::ServoInput<float> input;
    input.target_rad_s = to_standstill() ? 0.0F : 0.001F * static_cast<float>(shown.target_mrad_s);
    input.current_a = current_a_, input.supply_v = supply_v_;
    input.speed_measured = true, input.speed_rad_s = measured_rad_s_;
    const float applied_v = servo_.applied_v;
    law::LowPassState<float> measured = servo_.speed_rad_s;
    (void)law::low_pass_by_share(filter, measured, measured_rad_s_);
    const law::ServoOutput<float> output = law::servo_step(config, servo_, input, 0.001F);
    servo_.speed_rad_s = measured;
    speed_rad_s = measured.value, duty = output.duty_norm, limited_ = output.limited;
    if (supply_v_ < 6) follow_motor();  // too low for any duty: the wheel rolls
    watch(reference_rad_s(), applied_v);
    if (then_ && powered() && reference_rad_s() == 0) come_to_rest();
    if (powered()) bridge = supply_v_ >= 6;
  }
  // After 20 ms of rest, or when a push has prevented it for half a second. A quick stop of option 6 holds instead.
  void come_to_rest() {
    ++waited_ms_;
    const bool still = still_.at_least(20, std::fabs(speed_rad_s) < 2);
    if ((still || waited_ms_ >= 500) && *then_ != State::quick_stop_active) let_go(*then_);
  }

  // ---- what is watched

  // Current without a bridge, unless it is what a quickly pushed motor feeds into the supply.
  [[nodiscard]] bool flows_by_itself() const {
    const bool feeds = std::fabs(speed_rad_s) > 2 && (current_a_ > 0) != (speed_rad_s > 0);
    return !powered() && std::fabs(current_a_) > 1 && !feeds;
  }
  void forget_what_lasted() {
    lasting_ = {};
    stall_.clear();
    stall_counts_ = counts_;
    window_began_ = board_.illegal_steps;
    window_ms_ = 0;
  }
  void watch(float reference_rad_s, float applied_v) {
    if (lasting_.driver.at_least(2, !board_.driver_good)) fault(0x5400, 0x20, kOff);
    if (lasting_.low_supply.at_least(10, supply_v_ < 19)) fault(0x3220, 0x04, kOff);
    if (lasting_.high_supply.at_least(5, supply_v_ > set.highest_v)) fault(0x3210, 0x04, kOff);
    // Three in a hundred milliseconds.
    ++window_ms_;
    if (board_.illegal_steps - window_began_ >= 3) {
      fault(0x7305, 0x20, kOff);
    } else if (window_ms_ == 100) {
      window_ms_ = 0;
      window_began_ = board_.illegal_steps;
    }
    if (lasting_.current.at_least(2, std::fabs(current_a_) > 18)) fault(0x2310, 0x02, kOff);
    if (lasting_.speed.at_least(20, std::fabs(speed_rad_s) > 225)) fault(0x8400, 0x20, kRamp);
    watch_stall(reference_rad_s, applied_v);
    if (ticks_ % 5 == 2) watch_motor(applied_v);
  }
  // A hundred milliseconds of 70 % of the current without three counts, while movement is asked for. From the 21st on, a motor that stands
  // keeps the ratio of voltage and current; one that turns unseen needs 0.4 V more for the same current.
  void watch_stall(float reference_rad_s, float applied_v) {
    const auto moved = static_cast<std::int32_t>(static_cast<std::uint32_t>(counts_) - static_cast<std::uint32_t>(stall_counts_));
    const bool stands = moved >= -2 && moved <= 2;
    if (!stands || std::fabs(current_a_) <= 0.7F * limit_a || std::fabs(reference_rad_s) <= 1) {
      stall_.clear();
      stall_counts_ = counts_;
      return;
    }
    stall_.emplace_back(applied_v, current_a_);
    if (stall_.size() < 100) return;
    const auto [begin_v, begin_a] = stall_[20];
    const float rise_va = std::fabs(applied_v * begin_a - current_a_ * begin_v);
    fault(rise_va <= 0.4F * std::fabs(begin_a) ? 0x7121 : 0x7305, 0x20, kOff);
  }
  // Eleven looks in a row, five milliseconds apart: the first and the last are fifty apart.
  void watch_motor(float applied_v) {
    const float winding_v = set.winding.resistance_ohm * current_a_, generated_v = applied_v - winding_v;
    const bool opposed = (generated_v > 2.5F && speed_rad_s < -20) || (generated_v < -2.5F && speed_rad_s > 20);
    if (lasting_.reversed.at_least(11, opposed)) fault(0x7305, 0x20, kOff);
    const float allowed_v = 1.5F + 0.3F * std::fabs(winding_v) + 0.15F * std::fabs(generated_v);
    const bool unexplained = std::fabs(generated_v - set.motor_v_s * speed_rad_s) > allowed_v;
    if (lasting_.unexplained.at_least(11, unexplained)) fault(0x7305, 0x20, kOff);
  }

  // ---- what is shown

  void show() {
    constexpr std::array<unsigned, 8> kStates{0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08};
    const bool in_motion = state == State::operation_enabled || state == State::quick_stop_active;
    shown.status = kStates.at(static_cast<std::size_t>(state)) | (supply_v_ >= 19 ? 0x10U : 0U) | (reduced_ ? 0x80U : 0U) |
                   (operational() ? 0x200U : 0U) | (in_motion && on_target_ ? 0x400U : 0U) | (limited_ ? 0x800U : 0U) |
                   (at_rest_ ? 0x1000U : 0U);
    shown.counts = counts_;
    shown.self_test = test_result_;
    ++since_sync_ms_;
    switch (ticks_ % 10) {
      case 3:
        shown.winding_dc = rounded<std::int16_t>(10 * winding_.temperature_c());
        return;
      case 4:
        shown.offset_ma = rounded<std::int16_t>(1000 * offset_a_);
        return;
      case 6:
        shown.limit_a = limit_a, shown.illegal = board_.illegal_steps, shown.edge_us = board_.edge_us;
        return;
      case 8:
        if (since_sync_ms_ >= 20) look();
        return;
      default:
        return;
    }
  }
  // At each SYNC, and without it every ten milliseconds.
  void look() {
    at_rest_ = std::fabs(speed_rad_s) < 2;
    on_target_ = to_standstill() ? at_rest_ : std::fabs(speed_rad_s - 0.001F * static_cast<float>(shown.target_mrad_s)) < 3;
    shown.demand_mrad_s = rounded<std::int32_t>(1000 * reference_rad_s());
    shown.speed_mrad_s = rounded<std::int32_t>(1000 * speed_rad_s);
    shown.current_permille = rounded<std::int16_t>(1000 * current_a_ / 6);
    shown.supply_mv = rounded<unsigned>(1000 * supply_v_);
    shown.supply_10mv = rounded<std::uint16_t>(100 * supply_v_);
  }

  const TestBoard& board_;
  unsigned ticks_ = 0, age_ms_ = 0;
  std::optional<int> heartbeat_ms_, command_ms_;  // since the last, while one is awaited
  unsigned word_ = kAllBits;
  std::optional<State> then_;  // where the ramp under way ends
  int waited_ms_ = 0, since_sync_ms_ = 0;
  InARow still_;

  law::ServoState<float> servo_;
  SpeedEstimate estimate_;
  Winding winding_;
  std::int32_t counts_ = 0;
  float measured_rad_s_ = 0, current_a_ = 0, supply_v_ = 0, share_by_heat_ = 1, offset_a_ = 0;
  bool usable_ = false, limited_ = false, reduced_ = false, at_rest_ = true, on_target_ = false;
  bool by_watchdog_ = false;

  ErrorList::Error first_;
  unsigned second_bit_ = 0;
  unsigned test_result_ = 1, illegal_before_ = 0, window_began_ = 0;
  int test_ms_ = 0, window_ms_ = 0;
  bool test_readable_ = true;
  std::vector<float> at_rest_a_;
  struct Lasting {
    InARow driver, low_supply, high_supply, current, speed, reversed, unexplained, stray;
  };
  Lasting lasting_;
  std::vector<std::pair<float, float>> stall_;  // voltage and current of each millisecond of a stall
  std::int32_t stall_counts_ = 0;
};

}  // namespace hoist::firmware
