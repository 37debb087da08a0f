// A folder that vanishes, and a made-up walk: what the tests of the recording share.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"
#include "control/contract/signals.hpp"
#include "db/store/database.hpp"
#include "db/store/integrity.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/session_writer.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hoist::db::test {

using hoist::test::TemporaryFolder;

inline constexpr std::uint64_t kStart_ns = 5'000'000'000;
inline constexpr std::int64_t kStartUtc_ns = 1'790'000'000'123'456'789;  // September 2026
inline constexpr std::uint64_t kTick_ns = 10'000'000;

/// A day ends at midnight where the computer stands.
class InTimeZone {
 public:
  explicit InTimeZone(const char* zone) { set(zone); }
  InTimeZone(const InTimeZone&) = delete;
  InTimeZone& operator=(const InTimeZone&) = delete;
  ~InTimeZone() { set(nullptr); }

 private:
  static void set(const char* zone) {
    zone != nullptr ? ::setenv("TZ", zone, 1) : ::unsetenv("TZ");
    ::tzset();
  }
};

/// What opening or a check of the whole file found wrong with it; empty = sound.
inline std::string damage_of(Database& database) {
  if (!database.report().set_aside.empty()) return database.report().set_aside_reason;
  const auto checked = check_integrity(database, [](double) { return true; });
  if (!checked) return checked.error().message;
  if (!(*checked)->structure.empty()) return (*checked)->structure.front();
  return (*checked)->damaged_blobs == 0 ? "" : std::to_string((*checked)->damaged_blobs) + " blobs";
}

/// What a walk looks like to the recorder: sensors with their noise, smooth derived values, many columns that rarely change.
class Walk {
 public:
  explicit Walk(std::uint32_t seed) : random_(seed) {}

  contract::TickRecord record(std::uint64_t tick) {
    contract::TickRecord r;
    const double t = static_cast<double>(tick) * 0.01;
    std::normal_distribution<double> normal;
    const auto noise = [&](double sigma) { return sigma * normal(random_); };
    const auto f = [](double value) { return static_cast<float>(value); };
    // 1e-4 rad steps of the sensor with about 3 steps of noise, as measured on such sensors.
    const auto angle = [&](double value) { return f(std::round((value + noise(3e-4)) * 1e4) * 1e-4); };
    r.tick = tick;
    r.time_ns = kStart_ns + tick * kTick_ns + static_cast<std::uint64_t>(std::fabs(noise(15'000)));
    const double lean = 0.08 + 0.02 * std::sin(6.3 * 0.9 * t), turn = 0.05 * std::sin(0.4 * t), sway = 0.03 * std::sin(5.6 * t);
    r.left_alpha_rad = angle(lean + turn);
    r.left_beta_rad = angle(sway);
    r.right_alpha_rad = angle(lean - turn);
    r.right_beta_rad = angle(sway);
    r.base_alpha_rad = angle(0.002);
    r.base_beta_rad = angle(-0.001);
    r.base_yaw_rate_rad_s = f(0.2 * std::sin(0.4 * t) + noise(1e-3));
    r.base_pitch_rate_rad_s = f(noise(1e-3));
    r.base_roll_rate_rad_s = f(noise(1e-3));
    r.dx_m = f(0.8 * std::sin(static_cast<double>(r.left_alpha_rad)));
    r.dy_m = f(-0.8 * std::sin(static_cast<double>(r.left_beta_rad)));
    r.dpsi_rad = f(std::atan(static_cast<double>(r.right_alpha_rad) - static_cast<double>(r.left_alpha_rad)));
    r.lean_norm = f(static_cast<double>(r.dx_m) / 0.139);
    r.turn_norm = f(static_cast<double>(r.dpsi_rad) / 0.2);
    v_ += 0.001 * (0.45 - v_);
    w_ += 0.002 * (0.2 * std::sin(0.4 * t) - w_);
    r.lean_filtered_units = f(v_ / 0.03);
    r.turn_filtered_units = f(w_ / 0.0116);
    r.speed_wish_m_s = r.speed_command_m_s = f(v_);
    r.yaw_rate_wish_rad_s = r.yaw_rate_command_rad_s = f(w_);
    r.wheel_left_command_m_s = f(v_ - 0.35 * w_);
    r.wheel_right_command_m_s = f(v_ + 0.35 * w_);
    r.remote_age_s = 9.999F;
    r.stop_distance_m = f(v_ * v_ / 1.6);
    const double left = v_ - 0.35 * w_, right = v_ + 0.35 * w_;
    left_ += left * 0.01 / 0.6283 * 60000;
    right_ += right * 0.01 / 0.6283 * 60000;
    const auto left_counts = static_cast<std::int32_t>(left_), right_counts = static_cast<std::int32_t>(right_);
    r.wheel_left_m_s = f((left_counts - last_left_) * 0.6283 / 60000 * 100);
    r.wheel_right_m_s = f((right_counts - last_right_) * 0.6283 / 60000 * 100);
    last_left_ = left_counts;
    last_right_ = right_counts;
    r.left_counts = left_counts;
    r.right_counts = right_counts;
    r.speed_m_s = f((static_cast<double>(r.wheel_left_m_s) + static_cast<double>(r.wheel_right_m_s)) / 2);
    r.yaw_rate_rad_s = f((static_cast<double>(r.wheel_right_m_s) - static_cast<double>(r.wheel_left_m_s)) / 0.7);
    psi_ += static_cast<double>(r.yaw_rate_rad_s) * 0.01;
    x_ += static_cast<double>(r.speed_m_s) * 0.01 * std::cos(psi_);
    y_ += static_cast<double>(r.speed_m_s) * 0.01 * std::sin(psi_);
    r.x_m = f(x_);
    r.y_m = f(y_);
    r.psi_rad = f(psi_);
    r.fused_x_m = r.x_m;
    r.fused_y_m = r.y_m;
    r.fused_psi_rad = r.psi_rad;
    distance_ += static_cast<double>(r.speed_m_s) * 0.01;
    r.distance_m = f(distance_);
    // The drives report 10 mA and 100 mV steps, ten times a second the supply.
    r.left_current_a = f(std::round((1.2 + noise(0.03)) * 100) / 100);
    r.right_current_a = f(std::round((1.2 + noise(0.03)) * 100) / 100);
    if (tick % 10 == 0 || supply_ == 0) supply_ = std::round((25.2 - t * 1e-4 + noise(0.02)) * 10) / 10;
    r.left_supply_v = r.right_supply_v = f(supply_);
    r.battery_a_v = r.battery_b_v = f(supply_ / 2);
    r.wake_lateness_s = f(std::fabs(noise(15e-6)));
    r.tick_duration_s = f(20e-6 + std::fabs(noise(3e-6)));
    // The bus: about eight frames a step, a new load value each second, one node that loses a frame a second.
    frames_ += 7 + tick % 2 + (tick % 5 == 0 ? 2 : 0);
    r.bus_frames = static_cast<std::uint32_t>(frames_);
    if (tick % 100 == 0 || load_ == 0) load_ = 0.41 + noise(0.002);
    r.bus_load_norm = f(load_);
    r.bus_frames_per_s = static_cast<std::uint16_t>(load_ * 2200);
    r.bus_up = 1;
    r.babbling_id = 0xFFFF;
    r.io_age_ticks = static_cast<std::uint8_t>(tick % 2);
    r.drive_left_nmt_state = r.drive_right_nmt_state = r.io_nmt_state = 5;
    r.tilt_left_nmt_state = r.tilt_right_nmt_state = r.tilt_base_nmt_state = 5;
    r.tilt_right_lost_frames = static_cast<std::uint32_t>(tick / 100);
    r.tilt_right_lost_10s = static_cast<std::uint8_t>(9 + tick / 50 % 2);
    r.mode = static_cast<std::uint8_t>(contract::Mode::user);
    r.simulated = 1;
    r.server_alive = 1;
    r.left_status_word = r.right_status_word = 0x1637;
    r.lease_epoch = 3;
    r.lease_holder = 7;
    return r;
  }
  std::vector<contract::TickRecord> records(std::uint64_t first, std::size_t count) {
    std::vector<contract::TickRecord> out;
    for (std::size_t i = 0; i < count; ++i) out.push_back(record(first + i));
    return out;
  }

 private:
  std::mt19937 random_;
  double v_ = 0, w_ = 0, x_ = 0, y_ = 0, psi_ = 0, distance_ = 0, left_ = 0, right_ = 0, supply_ = 0, load_ = 0;
  std::uint64_t frames_ = 0;
  std::int32_t last_left_ = 0, last_right_ = 0;
};

inline SessionStart start_of_walk() {
  SessionStart start;
  start.subject = "P-017";
  start.started_utc_ns = kStartUtc_ns;
  start.start_time_ns = kStart_ns;
  start.core_start_time_ns = 1'000;
  start.simulated = true;
  start.layout_hash = 0xFEDCBA9876543210ULL;  // above the signed range on purpose
  start.software_version = "0.1.0";
  return start;
}

/// The stored value of a column: the nearest step, as the printed decimal.
inline double kept(const contract::TickRecord& record, std::string_view name) {
  const std::size_t index = *contract::find_signal(name);
  double scale = 1;
  while (contract::kSignals[index].lsb * scale < 0.5) scale *= 10;
  return static_cast<double>(std::llrint(contract::signal_value(record, index) * scale)) / scale;
}

inline std::vector<std::string> all_columns() {
  std::vector<std::string> names;
  for (const contract::SignalInfo& signal : contract::kSignals) names.emplace_back(signal.name);
  return names;
}

/// Everything read from the store equals what was appended, in order.
inline void expect_recorded(Database& database, SessionId session, const std::vector<contract::TickRecord>& records) {
  const std::vector<std::string> names = all_columns();
  const Result<Columns> columns = SessionReader(database).read_columns(session, names);
  ASSERT_TRUE(columns.ok()) << columns.error().message;
  ASSERT_EQ(columns->tick.size(), records.size());
  for (std::size_t c = 0; c < names.size(); ++c) {
    ASSERT_EQ(columns->values[c].size(), records.size());
    for (std::size_t i = 0; i < records.size(); ++i)
      ASSERT_EQ(columns->values[c][i], kept(records[i], names[c])) << names[c] << " sample " << i;
  }
}

}  // namespace hoist::db::test
