// What a monitor looks at, without a hoist around it: the sensors are filled through their own frames, the rest is as a test says. For
// tests that compare a monitor in every step with its rule, written a second time from its description, over random inputs.
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "control/core/monitor/monitor_list.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {

struct MonitorBench {
  Estimate sensed;
  BusHealth health;
  contract::Params params;
  DriveControl left_control, right_control;
  Mode mode = Mode::user;
  bool moving = true, powered = true, bus_up = true, bus_settled = true;
  bool server_alive = true, server_seen = true, held_back = false, relay_cut = false;
  contract::FaultBits latched = 0;
  double left_command_m_s = 0, right_command_m_s = 0;
  std::uint8_t bumpers_acknowledged = 0;
  float wake_lateness_s = 0;
  std::uint64_t ticks = 10'000;

  [[nodiscard]] MonitorView view() const {
    return {.sensed = sensed,
            .health = health,
            .params = params,
            .mode = mode,
            .moving = moving,
            .powered = powered,
            .latched = latched,
            .left_command_m_s = left_command_m_s,
            .right_command_m_s = right_command_m_s,
            .left_control = left_control,
            .right_control = right_control,
            .bus_up = bus_up,
            .bus_settled = bus_settled,
            .server_alive = server_alive,
            .server_seen = server_seen,
            .console_gone = false,
            .remote_lost = false,
            .held_back = held_back,
            .relay_cut = relay_cut,
            .bumpers_acknowledged = bumpers_acknowledged,
            .wake_lateness_s = wake_lateness_s,
            .ticks = ticks,
            .dt_s = kTick_s};
  }
};

struct TiltSample {
  double alpha_deg = 0, beta_deg = 0;
  std::uint8_t status = tilt_status::kValid | tilt_status::kConverged, counter = 0;
};
inline void send_angles(TiltSensor& sensor, const TiltSample& sample, TiltZero zero = {}) {
  using contract::Pdo;
  contract::CanFrame frame{contract::pdo_cob_id(Pdo::tilt_tx1, contract::Node::tilt_left), 6, 0, {}};
  contract::write_slot(frame, contract::pdo_slot(Pdo::tilt_tx1, 0x6010), std::lround(sample.alpha_deg * 1000));
  contract::write_slot(frame, contract::pdo_slot(Pdo::tilt_tx1, 0x6020), std::lround(sample.beta_deg * 1000));
  contract::write_slot(frame, contract::pdo_slot(Pdo::tilt_tx1, 0x2120), sample.status);
  contract::write_slot(frame, contract::pdo_slot(Pdo::tilt_tx1, 0x2121), sample.counter);
  sensor.take_angles(frame, zero);
}

struct TiltRates {
  double yaw_deg_s = 0, pitch_deg_s = 0, roll_deg_s = 0;
};
inline void send_rates(TiltSensor& sensor, const TiltRates& rates) {
  using contract::Pdo;
  contract::CanFrame frame{contract::pdo_cob_id(Pdo::tilt_tx2, contract::Node::tilt_left), 6, 0, {}};
  contract::write_slot(frame, contract::pdo_slot(Pdo::tilt_tx2, 0x2110, 1), std::lround(rates.yaw_deg_s * 100));
  contract::write_slot(frame, contract::pdo_slot(Pdo::tilt_tx2, 0x2110, 2), std::lround(rates.pitch_deg_s * 100));
  contract::write_slot(frame, contract::pdo_slot(Pdo::tilt_tx2, 0x2110, 3), std::lround(rates.roll_deg_s * 100));
  sensor.take_rates(frame);
}

inline void send_state(DriveSensor& drive, std::uint16_t status_word, double current_a, std::int32_t counts = 0) {
  using contract::Pdo;
  contract::CanFrame frame{contract::pdo_cob_id(Pdo::drive_tx1, contract::Node::drive_left), 8, 0, {}};
  contract::write_slot(frame, contract::pdo_slot(Pdo::drive_tx1, 0x6041), status_word);
  contract::write_slot(frame, contract::pdo_slot(Pdo::drive_tx1, 0x6064), counts);
  contract::write_slot(frame, contract::pdo_slot(Pdo::drive_tx1, 0x6078), std::lround(current_a / 6.0 * 1000.0));
  static_cast<void>(drive.take_state(frame, 1e9));
}
inline void send_supply(DriveSensor& drive, double supply_v) {
  using contract::Pdo;
  contract::CanFrame frame{contract::pdo_cob_id(Pdo::drive_tx2, contract::Node::drive_left), 8, 0, {}};
  contract::write_slot(frame, contract::pdo_slot(Pdo::drive_tx2, 0x2211), std::lround(supply_v * 100));
  drive.take_supply(frame);
}

inline void send_inputs(IoSensor& io, std::uint8_t bumpers, std::uint8_t switches) {
  io.take_inputs({contract::pdo_cob_id(contract::Pdo::io_tx1, contract::Node::io), 2, 0, {bumpers, switches}});
}
inline void send_batteries(IoSensor& io, double a_v, double b_v) {
  using contract::Pdo;
  contract::CanFrame frame{contract::pdo_cob_id(Pdo::io_tx2, contract::Node::io), 8, 0, {}};
  contract::write_slot(frame, contract::pdo_slot(Pdo::io_tx2, 0x6401, 1), std::lround(a_v * 100));
  contract::write_slot(frame, contract::pdo_slot(Pdo::io_tx2, 0x6401, 2), std::lround(b_v * 100));
  io.take_batteries(frame);
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  /// 0 to count - 1.
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(engine_()) % count; }
  bool once_in(std::uint32_t count) { return below(count) == 0; }

 private:
  std::mt19937 engine_;
};

/// One of these values, chosen anew after a random while. A value that stands in the list twice comes twice as often.
template <typename T>
class Spells {
 public:
  Spells(Random& random, std::uint32_t ticks_most, std::vector<T> values)
      : random_(random), values_(std::move(values)), ticks_most_(ticks_most), value_(values_[0]) {}
  T step() {
    if (left_ticks_ == 0) {
      value_ = values_[random_.below(static_cast<std::uint32_t>(values_.size()))];
      left_ticks_ = 1 + random_.below(ticks_most_);
    }
    --left_ticks_;
    return value_;
  }

 private:
  Random& random_;
  std::vector<T> values_;
  std::uint32_t ticks_most_;
  std::uint32_t left_ticks_ = 0;
  T value_;
};

/// A duration of so many steps that ends between two of them: the nearer one counts.
inline double about_steps_s(Random& random, int steps) { return (steps + (random.once_in(2) ? 0.4 : -0.4)) * kTick_s; }

/// Steps in a row.
struct Streak {
  int ticks = 0;
  int step(bool now) { return ticks = now ? ticks + 1 : 0; }
};

}  // namespace hoist::core::test
