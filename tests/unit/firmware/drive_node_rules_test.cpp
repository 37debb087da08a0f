// A drive on a motor, judged by its rules (drive_rule.hpp) in every millisecond and after every frame: commands of any kind, a computer that
// comes and goes, an encoder, a current sensor, a supply and a bridge that fail for as long as each limit allows, or longer.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "firmware/nodes/drive/drive_node.hpp"
#include "firmware/sim/motor.hpp"
#include "tests/unit/core/dice.hpp"
#include "tests/unit/firmware/drive_rule.hpp"
#include "tests/unit/firmware/test_board.hpp"

namespace hoist::firmware {
namespace {

using State = DriveRule::State;
using canopen::NmtCommand;
constexpr unsigned kOff = 0x00, kQuickStop = 0x02, kShutdown = 0x06, kSwitchOn = 0x07, kEnable = 0x0F, kReset = 0x80, kHalt = 0x10F;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kEndless = std::numeric_limits<float>::infinity();

class DriveNodeRules : public ::testing::Test {
 protected:
  // Another drive on another machine.
  void begin(std::uint32_t seed) {
    dice_ = core::test::Dice(seed);
    board_ = TestBoard{};
    board_.counts = dice_.of({0, 2147483600, -2147483600, 123456});
    board_.illegal_steps = dice_.of({0U, 7U, 0xFFFFFFFEU});
    sim::MotorConfig config;
    config.inertia_kg_m2 = dice_.of({4.3e-4, 1.0e-3});
    config.resistance_ohm = dice_.of({1.0, 1.2, 1.4});
    config.constant_v_s_rad = dice_.of({0.105, 0.115, 0.12});
    motor_ = sim::Motor(config);
    turned_counts_ = motor_.encoder_counts();
    end_trouble();
    heartbeats_ = commands_ = true;
    now_ms_ = 0;
    sync_at_ = static_cast<int>(dice_.below(10));
    rule_.emplace(board_);
    node_.emplace(board_, contract::Node::drive_left);
    nmt(NmtCommand::start);  // before the boot-up message nothing is heard
    one_ms();
    nmt(NmtCommand::start);
    write(0x2200, 5, dice_.of({3.0F, 6.0F, 6.0F, 12.0F}));
  }

  // ---- frames to both

  void nmt(NmtCommand command) {
    node_->on_frame(canopen::nmt(command, 1));
    rule_->parameters_good = node_->stack().parameters_ok();
    if (rule_->nmt_state != NmtState::boot_up) rule_->nmt(command);
    compare("NMT");
  }
  void command(unsigned word, std::int32_t target_mrad_s) {
    CanFrame frame{0x201, 6, 0, {}};
    contract::write_le(&frame.data[0], 2, word);
    contract::write_le(&frame.data[2], 4, static_cast<std::uint32_t>(target_mrad_s));
    node_->on_frame(frame);
    rule_->command(word, target_mrad_s);
    compare("command");
  }
  void heartbeat(bool boot_up = false) {
    node_->on_frame(canopen::heartbeat(0x7F, boot_up ? NmtState::boot_up : NmtState::operational));
    if (rule_->nmt_state != NmtState::boot_up) rule_->heartbeat(boot_up);
    compare("heartbeat");
  }
  void sync() {
    move_encoder();
    node_->on_frame(canopen::sync());
    rule_->sync();
    compare("SYNC");
  }
  void power_on() {
    node_->power_on();
    rule_->parameters_good = node_->stack().parameters_ok();
    rule_->power_on();
    compare("power");
  }
  bool written(std::uint16_t index, std::uint8_t sub, std::size_t bytes, std::uint32_t raw) {
    return ask(*node_, board_, canopen::sdo(0x601, canopen::sdo_download_command(bytes), index, sub, raw)).data[0] == 0x60;
  }
  void write(std::uint16_t index, std::uint8_t sub, float value) {
    if (!written(index, sub, 4, std::bit_cast<std::uint32_t>(value))) return;
    DriveSettings& set = rule_->set;
    const std::map<unsigned, float*> places{{0x220001, &set.gain},
                                            {0x220002, &set.integral},
                                            {0x220004, &set.filter_s},
                                            {0x220005, &set.limit_a},
                                            {0x223002, &set.winding.limit_c},
                                            {0x223003, &set.winding.ambient_c},
                                            {0x223004, &set.winding.thermal_resistance_k_w},
                                            {0x223005, &set.winding.time_constant_s},
                                            {0x223006, &set.winding.resistance_ohm},
                                            {0x223007, &set.motor_v_s},
                                            {0x223101, &set.highest_v}};
    *places.at(index * 256U + sub) = value;
  }
  void write_ramps(int ramp_rad_s2, int stop_ramp_rad_s2) {
    if (written(0x6083, 0, 4, static_cast<std::uint32_t>(ramp_rad_s2))) rule_->set.ramp_rad_s2 = ramp_rad_s2;
    if (written(0x6085, 0, 4, static_cast<std::uint32_t>(stop_ramp_rad_s2))) rule_->set.stop_ramp_rad_s2 = stop_ramp_rad_s2;
  }
  void write_choices(int stop_option, int on_error) {
    if (written(0x605A, 0, 2, static_cast<std::uint32_t>(stop_option))) rule_->set.stop_option = stop_option;
    if (written(0x1029, 1, 1, static_cast<std::uint32_t>(on_error))) rule_->set.on_error = on_error;
  }

  // ---- time

  enum class Encoder : std::uint8_t { good, dead, reversed };
  void move_encoder() {
    if (hand_rad_s_) return;
    const std::int32_t turned = motor_.encoder_counts();
    const auto moved = static_cast<std::uint32_t>(turned) - static_cast<std::uint32_t>(turned_counts_);
    turned_counts_ = turned;
    const std::uint32_t shown = encoder_ == Encoder::good ? moved : (encoder_ == Encoder::dead ? 0U : 0U - moved);
    board_.counts = static_cast<std::int32_t>(static_cast<std::uint32_t>(board_.counts) + shown);
    const double counts_s = std::fabs(motor_.speed_rad_s()) * 2000 / 6.283185307179586;
    board_.edge_us = counts_s > 1 && !untimed_ ? static_cast<std::uint32_t>(1e6 / counts_s) : kEdgeTimeUnknown_us;
  }
  // A shaft turned by hand, without an edge timer.
  void turn_by_hand() {
    board_.edge_us = kEdgeTimeUnknown_us;
    hand_counts_ += *hand_rad_s_ * 2 / 6.283185307179586;
    const double whole = std::floor(hand_counts_);
    hand_counts_ -= whole;
    board_.counts =
        static_cast<std::int32_t>(static_cast<std::uint32_t>(board_.counts) + static_cast<std::uint32_t>(static_cast<int>(whole)));
  }
  void one_ms() {
    if (hand_rad_s_) turn_by_hand();
    move_encoder();
    board_.current_a = current_a_ ? *current_a_ : static_cast<float>(motor_.current_a()) + bias_a_;
    if (noise_a_ > 0) board_.current_a += noise_a_ * static_cast<float>(dice_.any(-1, 1));
    board_.sent.clear();
    node_->tick_1ms();
    rule_->parameters_good = node_->stack().parameters_ok();
    const auto emergencies = board_.with_id(0x081);
    const ErrorList::Error left = rule_->tick(!emergencies.empty());
    if (!emergencies.empty()) {
      same("EMCY", contract::read_le(&emergencies[0].data[0], 2), left.code);
      same("EMCY's register", emergencies[0].data[2], left.bit);
    }
    compare("millisecond");
    ++now_ms_;
    ++seen_[static_cast<std::size_t>(rule_->state)];
    const double open_v = motor_.config().constant_v_s_rad * motor_.speed_rad_s();
    const double driven_v = static_cast<double>(board_.duty_norm * board_.supply_voltage_v);
    motor_.step(board_.bridge_on && std::isfinite(driven_v) ? driven_v : open_v, load_n_m_, 0.001);
  }
  void run(int milliseconds, unsigned word, double target_rad_s) {
    for (int i = 0; i < milliseconds && good_; ++i) {
      if (commands_ && (i == 0 || now_ms_ % 10 == 0)) command(word, static_cast<std::int32_t>(std::lround(1000 * target_rad_s)));
      if (heartbeats_ && now_ms_ % 100 == 0) heartbeat();
      if (syncs_ && now_ms_ % 10 == sync_at_) sync();
      one_ms();
    }
  }
  // From any state into operation, if no cause of a fault remains.
  void wake(double target_rad_s = 0) {
    if (!rule_->operational()) nmt(NmtCommand::start);
    run(1, kOff, target_rad_s);
    run(1, kReset, target_rad_s);
    if (rule_->state == State::not_ready) run(20, kReset, target_rad_s);
    run(dice_.of({1, 12}), kShutdown, target_rad_s);
    run(1, kEnable, target_rad_s);
  }
  // Off and on again within one millisecond.
  void wake_at_once() {
    for (const unsigned word : {kOff, kShutdown, kEnable}) command(word, 0);
  }

  // ---- what goes wrong, until end_trouble()

  void end_trouble() {
    encoder_ = Encoder::good;
    untimed_ = false;
    current_a_.reset(), hand_rad_s_.reset();
    bias_a_ = noise_a_ = 0;
    load_n_m_ = 0;
    syncs_ = true;
    motor_.lock(false);
    board_.supply_voltage_v = 24;
    board_.driver_good = true;
  }

  // ---- comparison

  template <class Shown, class Meant>
  void same(const char* what, Shown shown, Meant meant) {
    const auto is_same = [&] {
      if constexpr (std::is_floating_point_v<Shown>)
        return std::bit_cast<std::uint32_t>(shown) == std::bit_cast<std::uint32_t>(meant) || (shown == 0 && meant == 0);
      else
        return static_cast<std::int64_t>(shown) == static_cast<std::int64_t>(meant);
    };
    if (!good_ || is_same()) return;
    good_ = false;
    ADD_FAILURE() << what << " is " << +shown << ", by the rule " << +meant << ", at " << at_ << " " << now_ms_;
  }
  void compare(const char* at) {
    at_ = at;
    const auto& values = node_->stack().values();
    const DriveShown& shown = rule_->shown;
    same("state", static_cast<int>(node_->state()), static_cast<int>(rule_->state));
    same("bridge", board_.bridge_on, rule_->bridge);
    same("duty", board_.duty_norm, rule_->duty);
    same("speed", node_->speed_rad_s(), rule_->speed_rad_s);
    same("reference", node_->reference_rad_s(), rule_->reference_rad_s());
    same("limit", node_->current_limit_a(), rule_->limit_a);
    same("1001h", values.get<0x1001>(), rule_->errors.shown);
    same("1003h:1", values.get<0x1003, 1>(), rule_->errors.history[0]);
    same("1003h:2", values.get<0x1003, 2>(), rule_->errors.history[1]);
    same("6040h", values.get<0x6040>(), shown.word);
    same("60FFh", values.get<0x60FF>(), shown.target_mrad_s);
    same("603Fh", values.get<0x603F>(), shown.error_code);
    same("6041h", values.get<0x6041>(), shown.status);
    same("6064h", values.get<0x6064>(), shown.counts);
    same("606Bh", values.get<0x606B>(), shown.demand_mrad_s);
    same("606Ch", values.get<0x606C>(), shown.speed_mrad_s);
    // The rated current is six amperes but for a rounding.
    if (std::abs(values.get<0x6078>() - shown.current_permille) > 1) same("6078h", values.get<0x6078>(), shown.current_permille);
    same("6079h", values.get<0x6079>(), shown.supply_mv);
    same("2211h", values.get<0x2211>(), shown.supply_10mv);
    same("2251h", values.get<0x2251>(), shown.self_test);
    same("2252h", values.get<0x2252>(), shown.offset_ma);
    same("2230h:1", values.get<0x2230, 1>(), shown.winding_dc);
    same("2230h:8", values.get<0x2230, 8>(), shown.limit_a);
    same("2250h:1", values.get<0x2250, 1>(), shown.illegal);
    same("2250h:2", values.get<0x2250, 2>(), shown.edge_us);
    compare_record();
    const bool stands = !rule_->powered() && std::fabs(rule_->speed_rad_s) < 2;
    same("standing safely", node_->standing_safely(), stands);
  }
  void compare_record() {
    const auto& values = node_->stack().values();
    const FaultRecord& record = rule_->record;
    same("2240h:1", values.get<0x2240, 1>(), record.code);
    same("2240h:2", values.get<0x2240, 2>(), record.time_ms);
    same("2240h:3", values.get<0x2240, 3>(), record.counts);
    same("2240h:4", values.get<0x2240, 4>(), record.speed_mrad_s);
    same("2240h:5", values.get<0x2240, 5>(), record.current_ma);
    same("2240h:6", values.get<0x2240, 6>(), record.supply_mv);
    same("2240h:7", values.get<0x2240, 7>(), record.duty_permille);
    same("2240h:8", values.get<0x2240, 8>(), record.winding_dc);
    if (rule_->shown.error_code != std::exchange(fault_before_, rule_->shown.error_code)) ++faults_[rule_->shown.error_code];
    if (rule_->second_code != std::exchange(second_before_, rule_->second_code)) ++seconds_[rule_->second_code];
  }

  core::test::Dice dice_{1};
  TestBoard board_;
  std::optional<DriveNode<TestBoard>> node_;
  std::optional<DriveRule> rule_;
  sim::Motor motor_;
  std::int32_t turned_counts_ = 0;
  Encoder encoder_ = Encoder::good;
  bool untimed_ = false, heartbeats_ = true, commands_ = true, syncs_ = true, good_ = true;
  std::optional<float> current_a_;
  std::optional<double> hand_rad_s_;
  double hand_counts_ = 0;
  float bias_a_ = 0, noise_a_ = 0;
  double load_n_m_ = 0;
  int now_ms_ = 0, sync_at_ = 5;
  const char* at_ = "";
  std::array<int, 8> seen_{};                 // milliseconds in each state
  std::map<unsigned, int> faults_, seconds_;  // how often each was found
  unsigned fault_before_ = 0, second_before_ = 0;
};

// Any word after any other, and a computer that comes and goes.
TEST_F(DriveNodeRules, H5_H15_EveryCommandMeansWhatTheRuleSays) {
  for (std::uint32_t seed = 1; seed <= 40 && good_; ++seed) {
    SCOPED_TRACE(seed);
    begin(seed);
    run(19, kOff, 0);
    write_choices(dice_.of({2, 6}), dice_.of({0, 1, 2}));
    write_ramps(dice_.of({450, 2000}), dice_.of({300, 600}));
    for (int i = 0; i < 120 && good_; ++i) {
      unsigned word = dice_.of({kEnable, kEnable, kEnable, kSwitchOn, kShutdown, kQuickStop, kOff, kReset, kHalt, 0x8FU, 0x86U});
      if (dice_.chance(0.1)) word = static_cast<unsigned>(dice_.below(0x200));
      const double target_rad_s = dice_.of({0.0, 0.9, 2.9, 8.0, 30.0, 60.0, -20.0, -60.0});
      run(dice_.of({1, 2, 5, 10, 19, 20, 21, 22, 60}), word, target_rad_s);
      if (dice_.chance(0.25)) wake(target_rad_s);
      if (dice_.chance(0.1)) commands_ = !commands_;
      if (dice_.chance(0.1)) heartbeats_ = !heartbeats_;
      if (dice_.chance(0.1)) syncs_ = !syncs_;
      if (dice_.chance(0.05)) heartbeat(dice_.chance(0.5));
      if (dice_.chance(0.1)) load_n_m_ = dice_.of({0.0, -0.2, 0.3, -0.6});
      if (dice_.chance(0.1)) board_.supply_voltage_v = dice_.of({24.0F, 19.0F, 18.99F});
      if (dice_.chance(0.1)) board_.driver_good = !board_.driver_good;
      if (dice_.chance(0.04))
        nmt(dice_.of({NmtCommand::stop, NmtCommand::pre_operational, NmtCommand::reset_node, NmtCommand::reset_communication}));
      if (!heartbeats_ && dice_.chance(0.2)) run(260, kEnable, target_rad_s);
      if (!commands_ && dice_.chance(0.3)) run(50, kEnable, target_rad_s);
      if (i % 10 == 9) {
        end_trouble();
        heartbeats_ = commands_ = true;
      }
    }
  }
  for (const int milliseconds : seen_) EXPECT_GT(milliseconds, 100);
}

// One trouble, or two.
class DriveTroubles : public DriveNodeRules {
 protected:
  void make_trouble() {
    if (dice_.chance(0.5))
      make_electric_trouble();
    else
      make_motor_trouble();
  }
  void make_electric_trouble() {
    switch (dice_.below(6)) {
      case 0:
        board_.driver_good = false;
        break;
      case 1:
        board_.supply_voltage_v = dice_.of({18.9F, 19.0F, 12.0F, 6.0F, 5.9F, 0.4F, 0.0F, kNan, kEndless});
        break;
      case 2:
        board_.supply_voltage_v = dice_.of({31.9F, 32.1F, 33.9F, 30.5F, 29.9F});
        break;
      case 3:
        current_a_ = dice_.of({17.9F, 18.1F, -18.1F, 40.0F, -40.0F, kNan, kEndless, -kEndless});
        break;
      case 4:
        bias_a_ = dice_.of({1.2F, -1.2F, 0.9F, 3.0F, -3.0F});
        break;
      default:
        noise_a_ = dice_.of({0.3F, 1.0F, 4.0F});
        break;
    }
  }
  void make_motor_trouble() {
    switch (dice_.below(8)) {
      case 0:
        board_.illegal_steps += static_cast<std::uint32_t>(dice_.below(4));
        break;
      case 1:
        encoder_ = dice_.of({Encoder::dead, Encoder::reversed});
        break;
      case 2:
        motor_.lock(true);
        break;
      case 3:
        load_n_m_ = dice_.of({-1.5, 1.5, -0.6, 0.6, -3.0, 3.0});
        break;
      case 4:
        write(0x2230, 2, dice_.of({80.0F, 84.0F, 86.0F, 95.0F, 120.0F}));
        break;
      case 5:
        write(0x2230, 6, dice_.of({0.6F, 1.2F, 2.4F}));
        break;
      case 6:
        write(0x2230, 7, dice_.of({0.08F, 0.115F, 0.15F}));
        break;
      default:
        untimed_ = true;
        break;
    }
  }
  void make_test_trouble() {
    switch (dice_.below(6)) {
      case 0:
        ++board_.illegal_steps;
        break;
      case 1:
        current_a_ = dice_.of({kNan, kEndless, 1.5F, -1.5F, 0.7F});
        break;
      case 2:
        board_.supply_voltage_v = dice_.of({kNan, 19.0F, 18.9F, 24.0F});
        break;
      case 3:
        board_.driver_good = !board_.driver_good;
        break;
      default:
        break;
    }
  }
  // Near what a reset asks for.
  static constexpr float kSupplies_v[] = {18.9F, 19.9F, 20.0F, 29.9F, 30.1F, 32.5F, kNan};
  static constexpr float kCurrents_a[] = {0.9F, 1.1F, -1.1F, 17.9F, -17.9F, 18.2F, -18.2F, kNan};
  static constexpr float kWindingLimits[] = {80, 84, 89, 91, 94, 97};  // of a winding at 90 degrees
  static constexpr std::size_t kLasting = std::size(kSupplies_v) + std::size(kCurrents_a) + std::size(kWindingLimits) + 2;
  void make_lasting(std::size_t which) {
    if (which < std::size(kSupplies_v)) {
      board_.supply_voltage_v = kSupplies_v[which];
      return;
    }
    which -= std::size(kSupplies_v);
    if (which < std::size(kCurrents_a)) {
      current_a_ = kCurrents_a[which];
      return;
    }
    which -= std::size(kCurrents_a);
    if (which < std::size(kWindingLimits))
      write(0x2230, 2, kWindingLimits[which]);
    else if (which == std::size(kWindingLimits))
      board_.driver_good = false;
    else
      board_.illegal_steps += 3;
  }
  // Lost parameters are a fault until defaults are stored.
  void forget_parameters() {
    nmt(NmtCommand::pre_operational);
    if (written(0x1011, 1, 4, canopen::kLoad)) rule_->errors.set(0x6310, 0x20, false);
    nmt(NmtCommand::start);
  }
  int some_time() { return dice_.of({1, 2, 3, 4, 5, 6, 9, 10, 11, 20, 50, 56, 60, 101, 121}); }
};

TEST_F(DriveTroubles, H1_H2_H11_H12_EachIsFoundWhenTheRuleSays) {
  for (std::uint32_t seed = 1; seed <= 100 && good_; ++seed) {
    SCOPED_TRACE(seed);
    begin(seed);
    run(19, kOff, 0);
    for (int i = 0; i < 25 && good_; ++i) {
      const double target_rad_s = dice_.of({0.0, 0.9, 1.1, 30.0, 60.0, 120.0, 190.0, 240.0, -30.0, -120.0, -240.0});
      wake(dice_.of({0.0, target_rad_s}));
      run(dice_.of({0, 5, 100, 300}), kEnable, target_rad_s);
      if (dice_.chance(0.2)) wake_at_once();
      make_trouble();
      run(some_time(), kEnable, target_rad_s);
      if (dice_.chance(0.5)) make_trouble();
      run(some_time(), dice_.of({kEnable, kEnable, kOff, kQuickStop, kShutdown}), target_rad_s);
      if (dice_.chance(0.1)) nmt(dice_.of({NmtCommand::reset_communication, NmtCommand::reset_node}));
      if (dice_.chance(0.5)) wake();  // while the cause stays
      end_trouble();
      write(0x2230, 2, 120);
      write(0x2230, 6, 1.2F);
      write(0x2230, 7, 0.115F);
      run(dice_.of({0, 1, 30}), kOff, 0);
    }
  }
  for (const unsigned code : {0x5400U, 0x3220U, 0x3210U, 0x7305U, 0x7121U, 0x2310U, 0x5000U, 0x8400U, 0x4310U}) {
    EXPECT_GT(faults_[code], 10) << std::hex << code;
  }
  for (const unsigned code : {0x2310U, 0x3220U, 0x5000U, 0x5400U, 0x7305U}) EXPECT_GT(seconds_[code], 0) << std::hex << code;
}

// A push that prevents rest at the end of a stop, with more or less force than the current can hold.
TEST_F(DriveNodeRules, H2EveryStopEndsWhenTheRuleSays) {
  for (std::uint32_t seed = 1; seed <= 30 && good_; ++seed) {
    SCOPED_TRACE(seed);
    begin(seed);
    run(19, kOff, 0);
    write_choices(dice_.of({2, 6}), 0);
    for (int i = 0; i < 3 && good_; ++i) {
      wake();
      const double target_rad_s = dice_.of({0.0, 20.0, -60.0});
      run(dice_.of({30, 200}), kEnable, target_rad_s);
      load_n_m_ = dice_.of({0.0, 0.3, 0.4, 0.5, -0.3, -0.4, -0.5});
      run(dice_.of({20, 100, 600, 800}), dice_.of({kQuickStop, kShutdown, kSwitchOn, kHalt}), target_rad_s);
      if (dice_.chance(0.3)) {
        commands_ = false;
        run(dice_.of({60, 700}), kEnable, target_rad_s);
        commands_ = true;
      }
      end_trouble();
    }
  }
}

// A reset of the node ends a stop under way, and nothing of it is left at the next start.
TEST_F(DriveNodeRules, AResetEndsAStopAsTheRuleSays) {
  for (std::uint32_t seed = 1; seed <= 20 && good_; ++seed) {
    SCOPED_TRACE(seed);
    begin(seed);
    run(19, kOff, 0);
    wake();
    run(30, kEnable, 0);
    run(5, dice_.of({kShutdown, kSwitchOn, kQuickStop}), 0);
    nmt(NmtCommand::reset_node);
    one_ms();
    wake(60);
    run(30, kEnable, 60);
  }
}

// Supplies that sag and rise, and a winding between warm and hot.
TEST_F(DriveNodeRules, H11_H12_TheCurrentIsReducedAsTheRuleSays) {
  int reduced_ms = 0;
  for (std::uint32_t seed = 1; seed <= 40 && good_; ++seed) {
    SCOPED_TRACE(seed);
    begin(seed);
    run(19, kOff, 0);
    write(0x2231, 1, dice_.of({29.5F, 32.0F, 34.0F}));
    write(0x2230, 5, 5);
    write(0x2200, 1, dice_.of({0.12F, 0.3F}));
    write(0x2200, 2, dice_.of({2.4F, 5.0F}));
    write(0x2200, 4, dice_.of({0.004F, 0.001F, 0.02F}));
    wake();
    for (int i = 0; i < 25 && good_; ++i) {
      if (rule_->state != State::operation_enabled) wake();
      if (dice_.chance(0.3)) write(0x2230, 2, dice_.of({88.0F, 93.0F, 98.0F, 104.0F, 120.0F}));
      if (dice_.chance(0.1)) write(0x2230, 3, dice_.of({20.0F, 60.0F}));
      if (dice_.chance(0.1)) write(0x2230, 4, dice_.of({0.5F, 2.0F}));
      board_.supply_voltage_v = dice_.chance(0.5) ? 24 : static_cast<float>(dice_.any(19, 34));
      load_n_m_ = dice_.of({0.0, 0.0, 0.4, -0.4});
      for (int k = dice_.of({10, 40, 80}); k > 0 && good_; --k) {
        run(1, kEnable, dice_.of({100.0, 100.0, -100.0}));
        reduced_ms += (rule_->shown.status & 0x80) != 0 ? 1 : 0;
        if (dice_.chance(0.1)) board_.supply_voltage_v += static_cast<float>(dice_.any(-0.3, 0.3));
      }
      if (dice_.chance(0.1)) run(30, kOff, 0);
    }
  }
  EXPECT_GT(reduced_ms, 1000);
}

TEST_F(DriveTroubles, H11EachSelfTestFindsWhatTheRuleSays) {
  std::map<unsigned, int> results;
  for (std::uint32_t seed = 1; seed <= 40 && good_; ++seed) {
    SCOPED_TRACE(seed);
    begin(seed);
    for (int i = 0; i < 25 && good_; ++i) {
      board_.cause = dice_.of({ResetCause::power, ResetCause::power, ResetCause::pin, ResetCause::watchdog, ResetCause::software});
      if (dice_.chance(0.1))
        for (auto& page : board_.pages.pages) std::fill(page.begin(), page.end(), std::byte{0x5A});
      if (dice_.chance(0.5))
        power_on();
      else
        nmt(NmtCommand::reset_node);
      one_ms();
      if (dice_.chance(0.9)) nmt(NmtCommand::start);
      bias_a_ = dice_.of({0.0F, 0.0F, 0.3F, 0.59F, 0.61F, -0.61F, 1.3F});
      noise_a_ = dice_.of({0.0F, 0.0F, 0.05F, 0.5F, 0.55F});
      board_.supply_voltage_v = dice_.of({24.0F, 24.0F, 19.0F, 18.9F, 0.0F});
      board_.driver_good = dice_.chance(0.7);
      const int at = dice_.of({2, 4, 5, 6, 19, 20, 30});
      for (int ms = 1; ms <= 22 && good_; ++ms) {
        if (ms == at) make_test_trouble();
        if (ms == at + 1) current_a_.reset();
        run(1, dice_.of({kOff, kShutdown, kEnable}), 0);
      }
      ++results[rule_->shown.self_test];
      if (dice_.chance(0.5)) end_trouble();
      wake();
      if (dice_.chance(0.5)) forget_parameters();
      wake();
      end_trouble();
      wake();
      run(2, kEnable, 30);
    }
  }
  for (const unsigned bit : {0x02U, 0x04U, 0x08U, 0x10U, 0x20U, 0x40U}) EXPECT_GT(results[bit], 1) << bit;
  EXPECT_GT(results[0], 100);
}

// A fault, then anything else that is wrong: the reset waits for the fault's own cause.
TEST_F(DriveTroubles, AResetIsJudgedAsTheRuleSaysBesideOtherTroubles) {
  for (std::uint32_t seed = 1; seed <= 3 && good_; ++seed) {
    SCOPED_TRACE(seed);
    begin(seed);
    run(19, kOff, 0);
    write(0x2230, 5, 3600);
    for (std::size_t first = 0; first < kLasting; ++first) {
      for (std::size_t second = 0; second < kLasting; ++second) {
        write(0x2230, 2, 120);
        run(2, kOff, 0);
        wake();
        make_lasting(first);
        run(30, kEnable, 0);
        const bool kept = dice_.chance(0.5);
        if (!kept) end_trouble();
        make_lasting(second);
        if (dice_.chance(0.2)) hand_rad_s_ = dice_.of({224.0, 227.0, -227.0, 1.9, 2.1, -2.1});
        run(dice_.of({1, 2, 30}), kOff, 0);
        run(1, kReset, 0);
        run(1, kShutdown, 0);
        end_trouble();
        run(30, kOff, 0);
      }
    }
  }
  for (const unsigned code : {0x5400U, 0x3220U, 0x3210U, 0x7305U, 0x2310U, 0x5000U, 0x4310U}) {
    EXPECT_GT(faults_[code], 20) << std::hex << code;
  }
}

// One that ends before its limit leaves nothing behind for the next time in operation.
TEST_F(DriveTroubles, EachStartInOperationBeginsToCountAnew) {
  for (std::uint32_t seed = 1; seed <= 60 && good_; ++seed) {
    SCOPED_TRACE(seed);
    begin(seed);
    run(19, kOff, 0);
    for (int i = 0; i < 6 && good_; ++i) {
      const std::size_t which = dice_.below(5);
      for (const int for_ms : {dice_.of({1, 4, 9, 19}), dice_.of({1, 4, 9, 19}), 30}) {
        run(1, kOff, 0);
        run(1, kReset, 0);
        run(1, kShutdown, 0);
        command(kEnable, 0);
        if (which == 0) board_.driver_good = false;
        if (which == 1) board_.supply_voltage_v = 18.5F;
        if (which == 2) board_.supply_voltage_v = 33;
        if (which == 3) current_a_ = 19;
        if (which == 4) ++board_.illegal_steps;
        run(for_ms, kEnable, 0);
        if (which == 4) ++board_.illegal_steps;
        run(1, kEnable, 0);
        end_trouble();
        if (dice_.chance(0.5)) run(20, kOff, 0);
      }
      // And of a current that flows by itself.
      run(2, kOff, 0);
      current_a_ = 1.5F;
      run(dice_.of({3, 18}), kShutdown, 0);
      command(kEnable, 0);
      run(1, kEnable, 0);
      run(dice_.of({5, 19, 21}), kOff, 0);
      end_trouble();
      run(2, kOff, 0);
      run(1, kReset, 0);
      run(30, kOff, 0);
    }
  }
  for (const unsigned code : {0x5400U, 0x3220U, 0x3210U, 0x2310U}) EXPECT_GT(faults_[code], 20) << std::hex << code;
}

TEST_F(DriveNodeRules, H2IllegalStepsAreCountedAsTheRuleSays) {
  for (std::uint32_t seed = 1; seed <= 60 && good_; ++seed) {
    SCOPED_TRACE(seed);
    begin(seed);
    run(19, kOff, 0);
    wake();
    for (int ms = 0; ms < 700 && good_; ++ms) {
      if (dice_.chance(0.02)) ++board_.illegal_steps;
      run(1, kEnable, 0);
      if (rule_->state == State::fault) wake();
    }
  }
  EXPECT_GT(faults_[0x7305], 100);
}

// A shaft that hardly moves under a current near 70 % of the limit.
TEST_F(DriveNodeRules, H2AStallIsFoundWhenTheRuleSays) {
  for (std::uint32_t seed = 1; seed <= 100 && good_; ++seed) {
    SCOPED_TRACE(seed);
    begin(seed);
    run(19, kOff, 0);
    write(0x2230, 6, 0.2F);  // with which no other rule is near its limit
    for (int i = 0; i < 4 && good_; ++i) {
      end_trouble();
      hand_rad_s_ = dice_.of({0.0, 0.0, 0.0, 4.0});
      run(30, kOff, 0);
      current_a_ = dice_.of({0.0F, 0.9F}) * rule_->set.limit_a;
      run(2, kOff, 0);
      wake();
      const double target_rad_s = dice_.of({0.9, 1.1, 1.6, 1.9, 2.3, 3.0, 4.5, -1.1, -1.6, -2.0, -3.0});
      const double share = dice_.of({0.65, 0.75, 0.85, 0.95}) * (target_rad_s > 0 ? 1 : -1), noise = dice_.of({0.0, 0.02, 0.1});
      const double creep_rad_s = dice_.of({0.0, 0.0, 0.0, 0.02, -0.02, 0.1});
      for (int ms = 0; ms < 150 && good_; ++ms) {
        current_a_ = static_cast<float>(share * (1 + dice_.any(-noise, noise))) * rule_->set.limit_a;
        hand_rad_s_ = creep_rad_s;
        if (dice_.chance(0.02)) hand_rad_s_ = dice_.of({3.142, 6.284, 9.425, -3.141, -6.283, -9.424});  // one to three counts
        run(1, kEnable, target_rad_s);
      }
    }
  }
  EXPECT_GT(faults_[0x7121], 50);
  EXPECT_GT(faults_[0x7305], 50);
}

// A shaft turned by hand at each limit's speed, and a resistance and a motor constant with which the voltages come near each limit.
TEST_F(DriveNodeRules, H2SpeedVoltageAndCurrentBelongToOneMotorAsTheRuleSays) {
  for (std::uint32_t seed = 1; seed <= 100 && good_; ++seed) {
    SCOPED_TRACE(seed);
    begin(seed);
    run(19, kOff, 0);
    write(0x2230, 5, 3600);
    write(0x2230, 2, 155);
    write(0x2200, 4, 0.05F);
    for (int i = 0; i < 4 && good_; ++i) {
      end_trouble();
      const double speed_rad_s = dice_.of({0.0, 9.0, 12.0, 18.0, 23.0, 38.0, 45.0, -12.0, -18.0, -23.0, -45.0});
      hand_rad_s_ = speed_rad_s;
      run(200, kOff, 0);
      wake();
      const double target_rad_s = speed_rad_s + dice_.of({-1.0, 1.0, 10.0, -10.0, 30.0, -30.0});
      const float generated_v = dice_.of({0.0F, 0.5F, 1.2F, 2.4F, 2.6F, 4.9F, 5.2F, -0.5F, -1.2F, -2.4F, -2.6F, -4.9F, -5.2F});
      const float amperes = dice_.of({0.8F, 0.95F, 1.05F, -0.95F}) * rule_->set.limit_a;
      const int off_from = dice_.of({45, 50, 55, 200}), off_to = off_from + dice_.of({1, 5, 6});
      write(0x2230, 7, dice_.of({0.005F, 0.05F, 0.115F, 0.2F}));
      for (int ms = 0; ms < 120 && good_; ++ms) {
        current_a_ = amperes;
        const float applied_v = board_.duty_norm * board_.supply_voltage_v;
        const bool off = ms >= off_from && ms < off_to;
        write(0x2230, 6, std::clamp((applied_v - (off ? 0 : generated_v)) / amperes, 0.05F, 20.0F));
        run(1, kEnable, target_rad_s);
      }
    }
  }
  EXPECT_GT(faults_[0x7305], 100);
}

// What a write must be, beyond type and range: commands only by RPDO, and the quick stops that there are.
TEST_F(DriveNodeRules, WritesAreRefusedAsTheRuleSays) {
  begin(1);
  const auto answer = [&](std::uint16_t index, std::size_t bytes, std::uint32_t raw) {
    const CanFrame frame = ask(*node_, board_, canopen::sdo(0x601, canopen::sdo_download_command(bytes), index, 0, raw));
    return frame.data[0] == 0x60 ? 0U : static_cast<std::uint32_t>(contract::read_le(&frame.data[4], 4));
  };
  EXPECT_EQ(answer(0x6040, 2, 0x06), 0x08000022U);
  EXPECT_EQ(answer(0x60FF, 4, 1000), 0x08000022U);
  nmt(NmtCommand::pre_operational);
  EXPECT_EQ(answer(0x6040, 2, 0x06), 0U);
  EXPECT_EQ(answer(0x60FF, 4, 1000), 0U);
  for (const std::uint32_t option : {2U, 6U}) EXPECT_EQ(answer(0x605A, 2, option), 0U) << option;
  for (const std::uint32_t option : {1U, 3U, 4U, 5U, 7U}) EXPECT_EQ(answer(0x605A, 2, option), 0x06090030U) << option;
}

}  // namespace
}  // namespace hoist::firmware
