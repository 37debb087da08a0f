// A tilt node against its rules, written a second time in double from their descriptions (firmware/nodes/tilt/tilt_node.hpp, the filter in
// control/core/law/tilt_kalman.hpp, DECISIONS.md 7, 8, 23, 28, 34, 43 and 46; hazards H6 to H8): a sensor that stands, sways, turns, is
// pushed, loses its zero, repeats itself or fails, under a SYNC that is punctual, late or gone. Each millisecond must be judged alike.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "firmware/nodes/tilt/tilt_node.hpp"
#include "tests/unit/firmware/test_board.hpp"

namespace hoist::firmware {
namespace {

// Equations (15) and (16) of the paper.
struct PaperFilter {
  double angle_rad = 0, bias_rad_s = 0, rate_rad_s = 0;
  void begin(double at_rad, double rate) { angle_rad = at_rad, rate_rad_s = rate; }
  void step(double gain_angle, double gain_bias, double rate, double gravity_rad, double dt_s) {
    const double predicted_rad = angle_rad + dt_s * (rate_rad_s - bias_rad_s);
    angle_rad = predicted_rad + gain_angle * (gravity_rad - predicted_rad);
    bias_rad_s += gain_bias * (gravity_rad - predicted_rad);
    rate_rad_s = rate;
  }
};

// What a sensor says in the hoist's frame: rates of alpha, beta and yaw; forces forward, left and up; the two angles of gravity.
struct Reading {
  std::array<double, 3> rate{}, force{};
  std::array<double, 2> gravity{};
  static Reading of(const ImuSample& s) {
    const double ax = s.ax_m_s2, ay = s.ay_m_s2, az = s.az_m_s2;
    return {{s.alpha_rate_rad_s, s.beta_rate_rad_s, s.yaw_rate_rad_s}, {ax, ay, az}, {std::atan2(-ax, az), std::atan2(ay, az)}};
  }
  [[nodiscard]] double norm() const { return std::hypot(force[0], force[1], force[2]); }
  [[nodiscard]] bool finite() const {
    const auto all = [](const auto& values) {
      return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
    };
    return all(rate) && all(force);
  }
  [[nodiscard]] bool same(const Reading& other) const { return rate == other.rate && force == other.force; }
  // Whether a rate or a force is so far from another reading's.
  [[nodiscard]] bool rate_apart(const Reading& other, double most) const { return apart(rate, other.rate, most); }
  [[nodiscard]] bool force_apart(const Reading& other, double most) const { return apart(force, other.force, most); }

 private:
  static bool apart(const std::array<double, 3>& one, const std::array<double, 3>& other, double most) {
    for (std::size_t i = 0; i < 3; ++i)
      if (std::fabs(one[i] - other[i]) > most) return true;
    return false;
  }
};

using Readings = std::vector<Reading>;

template <class Of>
double mean(const Readings& all, std::size_t first, std::size_t count, const Of& of) {
  double sum = 0;
  for (std::size_t i = first; i < first + count; ++i) sum += of(all[i]);
  return sum / static_cast<double>(count);
}

// What is known at the end of the still start or of eight seconds of standing.
struct Zero {
  std::array<double, 3> bias_rad_s{};
  std::array<double, 2> angle_rad{};
};

// Two seconds in which nothing moves, or eight in which a person stands.
class Start {
 public:
  void again() { still_.clear(), standing_.clear(), repeats_ = 0, last_ = {}; }

  // True when the zero is known.
  bool add(const Reading& now, Zero& zero) {
    bool stands = now.norm() > 0.9 * 9.80665 && now.norm() < 1.1 * 9.80665 && !now.rate_apart({}, 0.4);
    if (!standing_.empty() && now.rate_apart(standing_.front(), 0.2)) stands = false;
    repeats_ = stands && now.same(last_) ? repeats_ + 1 : 0;
    last_ = now;
    if (!stands || repeats_ == 10) {
      again();
      return false;
    }
    if (!still_.empty() && (now.rate_apart(still_.front(), 0.03) || now.force_apart(still_.front(), 0.5)))
      still_.clear();
    else
      still_.push_back(now);
    if (still_.size() == 200 && still_is_over(zero)) return true;
    standing_.push_back(now);
    return standing_.size() == 800 && standing_is_over(zero);
  }

 private:
  bool still_is_over(Zero& zero) {
    const Readings all = std::exchange(still_, {});
    for (std::size_t i = 0; i < 2; ++i) {
      const auto gravity = [i](const Reading& r) { return r.gravity[i]; };
      if (std::fabs(mean(all, 150, 50, gravity) - mean(all, 0, 50, gravity)) > 0.01) return false;
      zero.angle_rad[i] = mean(all, 0, 200, gravity);
    }
    for (std::size_t i = 0; i < 3; ++i) zero.bias_rad_s[i] = mean(all, 0, 200, [i](const Reading& r) { return r.rate[i]; });
    return true;
  }

  bool standing_is_over(Zero& zero) {
    const Readings all = std::exchange(standing_, {});
    const auto yaw = [](const Reading& r) { return r.rate[2]; };
    bool agree = std::fabs(mean(all, 400, 400, yaw) - mean(all, 0, 400, yaw)) <= 0.01;
    zero.bias_rad_s[2] = mean(all, 0, 800, yaw);
    for (std::size_t i = 0; i < 2; ++i) {
      // Gravity's angle less the turn by the rates falls by the bias.
      Readings drift = all;
      double turn_rad = 0;
      for (Reading& r : drift) r.gravity[i] -= turn_rad += 0.01 * r.rate[i];
      const auto left = [i](const Reading& r) { return r.gravity[i]; };
      const double begin = mean(drift, 0, 200, left), middle = mean(drift, 300, 200, left), end = mean(drift, 600, 200, left);
      const double early = (begin - middle) / 3, late = (middle - end) / 3;
      agree = agree && std::fabs(early - late) <= 0.01;
      zero.bias_rad_s[i] = (early + late) / 2;
      zero.angle_rad[i] = end - zero.bias_rad_s[i] * 1.0 + turn_rad;  // one second after the middle of the last block
    }
    if (!agree) again();
    return agree;
  }

  Readings still_, standing_;
  Reading last_;
  int repeats_ = 0;
};

class TiltRule {
 public:
  // What the bus shows.
  std::array<double, 2> angle_deg{}, bias_rad_s{};
  std::array<double, 3> rate_deg_s{}, force_g{};  // rates of yaw, alpha, beta
  unsigned status = 0, counter = 0;
  int reads = 0;
  bool error = false;
  // What the test looks at.
  bool converged = false, doubtful = false;

  double gain_angle = 0.0102, gain_bias = -0.0013;
  ImuSample imu;  // in the hoist's frame
  bool fresh = true;

  void power_on() {
    const auto kept = std::pair{reads, axis_};
    *this = {};
    reads = kept.first, axis_ = kept.second;
  }
  // Its mounting has changed: all that it knew was of other axes.
  void mounted_anew() {
    filters_ = {}, turns_ = {}, disagreement_rad_ = {}, zero_ = {};
    started_ = converged = false;
    start_.again();
    pending_ms_ = 0, age_ms_ = 0;
  }

  void tick(const ImuReport& report) {
    ++since_sync_ms_, ++since_sample_ms_, ++since_good_ms_, ++age_ms_;
    if (report.self_test_failed) fail_for_good(false);
    if (report.wrong_part) fail_for_good(true);
    if (!started_ && age_ms_ >= 6000) fail_for_good(!report.found);
    if (since_sync_ms_ > 12 && since_sample_ms_ >= 10) sample();
    if (pending_ms_ > 0 && --pending_ms_ == 0) think();
  }
  void sync() {
    since_sync_ms_ = 0;
    if (since_sample_ms_ >= 5) sample();
  }

 private:
  void fail_for_good(bool missing) {
    missing_ = missing_ || missing;
    if (failed_) return;
    failed_ = error = true;
    show(0);
  }
  void show(unsigned bits) { status = bits | (converged ? 2U : 0U) | (failed_ ? 16U : 0U) | (missing_ ? 32U : 0U); }

  void sample() {
    ++reads;
    const Reading now = Reading::of(imu);
    const int age_ms = std::exchange(since_sample_ms_, 0);
    if (!fresh || !now.finite() || now.norm() == 0) {
      if (started_ && ++failures_ == 10) fail_for_good(false);
      if (!converged) start_.again();
      show(0);
      return;
    }
    in_time_ = age_ms >= 8 && age_ms <= 12;
    dt_s_ = in_time_ && age_ms == since_good_ms_ ? 0.01 : 0.001 * since_good_ms_;  // a punctual one counts as 10 ms
    begins_ = !started_ || since_good_ms_ > 100;
    for (std::size_t i = 0; i < 2; ++i) {
      if (begins_) {
        filters_[i].begin(now.gravity[i], now.rate[i]);
        disagreement_rad_[i] = 0;
      } else {
        filters_[i].step(gain_angle, gain_bias, now.rate[i], now.gravity[i], dt_s_);
      }
    }
    started_ = true;
    since_good_ms_ = failures_ = 0;
    now_ = now;
    pending_ms_ = 2;
    publish();
  }

  [[nodiscard]] double angle_rad(std::size_t i) const { return filters_[i].angle_rad - turns_[i].angle_rad; }

  // Two milliseconds after the sample.
  void think() {
    const double yaw = std::clamp(now_.rate[2] - zero_.bias_rad_s[2], -1.1, 1.1);
    const std::array<double, 2> felt{yaw * angle_rad(1), -yaw * angle_rad(0)};
    for (std::size_t i = 0; i < 2; ++i) {
      if (begins_) {
        turns_[i].begin(0, felt[i]);
      } else {
        turns_[i].step(gain_angle, gain_bias, felt[i], 0, dt_s_);
      }
    }
    bool lost = false;
    for (std::size_t i = 0; i < 2; ++i) {
      disagreement_rad_[i] += (now_.gravity[i] - angle_rad(i) - disagreement_rad_[i]) * dt_s_ / 0.5;
      const double learnt_rad_s = filters_[i].bias_rad_s - turns_[i].bias_rad_s - zero_.bias_rad_s[i];
      lost = lost || std::fabs(disagreement_rad_[i]) > 0.105 || std::fabs(learnt_rad_s) > 0.0524;
    }
    doubtful = converged && lost;
    error = failed_ || doubtful;
    if (converged) return;
    if (!in_time_) return start_.again();
    converged = start_.add(now_, zero_);
    for (std::size_t i = 0; i < 2 && converged; ++i) {
      filters_[i] = {zero_.angle_rad[i], zero_.bias_rad_s[i], now_.rate[i]};
      turns_[i] = {};
      disagreement_rad_[i] = 0;
    }
    if (!converged) zero_ = {};
  }

  void publish() {
    const double deg = 180 / std::acos(-1.0);
    for (std::size_t i = 0; i < 2; ++i) {
      angle_deg[i] = angle_rad(i) * deg;
      bias_rad_s[i] = filters_[i].bias_rad_s;
      rate_deg_s[1 + i] = (now_.rate[i] - bias_rad_s[i]) * deg;
    }
    rate_deg_s[0] = (now_.rate[2] - zero_.bias_rad_s[2]) * deg;
    axis_ = (axis_ + 1) % 3;  // one force with each sample
    force_g[axis_] = now_.force[axis_] / 9.80665;
    const bool no_down = now_.norm() < 0.5 * 9.80665 || now_.norm() > 1.5 * 9.80665;
    show((failed_ || doubtful ? 0U : 1U) | (no_down ? 4U : 0U) | (now_.rate_apart({}, 4.3) ? 8U : 0U));
    counter = (counter + 1) % 256;
  }

  std::array<PaperFilter, 2> filters_{}, turns_{};
  std::array<double, 2> disagreement_rad_{};
  Zero zero_;
  Start start_;
  Reading now_;
  double dt_s_ = 0;
  bool in_time_ = false, begins_ = false, started_ = false, failed_ = false, missing_ = false;
  std::size_t axis_ = 2;
  int pending_ms_ = 0, failures_ = 0, age_ms_ = 0;
  int since_sync_ms_ = 1000, since_sample_ms_ = 0, since_good_ms_ = 0;
};

// A sensor on a strut: leans, sways, turns, and has a zero that drifts.
struct TiltWorld {
  std::array<float, 2> lean_rad{}, sway_rad{}, turn_rad_s{};
  std::array<float, 3> bias_rad_s{}, drift_rad_s2{}, push_m_s2{};
  float yaw_rad_s = 0, yaw_sway_rad_s = 0, omega_rad_s = 0, weight = 1, restless = 1;

  ImuSample at(float time_s, std::mt19937& random) const {
    const auto noise = [&](float most) { return restless * most * (static_cast<float>(random() % 2001U) - 1000) * 0.001F; };
    const float sine = std::sin(omega_rad_s * time_s), cosine = std::cos(omega_rad_s * time_s), g = 9.80665F * weight;
    const float alpha = lean_rad[0] + turn_rad_s[0] * time_s + sway_rad[0] * sine;
    const float beta = lean_rad[1] + turn_rad_s[1] * time_s + sway_rad[1] * sine;
    const auto zero = [&](std::size_t i) { return bias_rad_s[i] + drift_rad_s2[i] * time_s + noise(0.004F); };
    const float yaw = yaw_rad_s + yaw_sway_rad_s * cosine;
    return {push_m_s2[0] - g * std::sin(alpha) + noise(0.05F),
            push_m_s2[1] + g * std::cos(alpha) * std::sin(beta) + noise(0.05F),
            push_m_s2[2] + g * std::cos(alpha) * std::cos(beta) + noise(0.05F),
            zero(0) + turn_rad_s[0] + sway_rad[0] * omega_rad_s * cosine + yaw * std::sin(beta),
            zero(1) + turn_rad_s[1] + sway_rad[1] * omega_rad_s * cosine - yaw * std::sin(alpha),
            zero(2) + yaw};
  }
};

// The chip's axes as they must be for this mounting code: forward and left as it says, up by the right hand.
ImuSample seen_by_chip(const ImuSample& hoist, int code) {
  std::array<std::array<float, 3>, 3> axes{};
  for (std::size_t row = 0; row < 2; ++row) {
    const int digit = row == 0 ? code / 10 : code % 10;
    axes[row][static_cast<std::size_t>((digit - 1) % 3)] = digit > 3 ? -1.0F : 1.0F;
  }
  for (std::size_t i = 0; i < 3; ++i)
    axes[2][i] = axes[0][(i + 1) % 3] * axes[1][(i + 2) % 3] - axes[0][(i + 2) % 3] * axes[1][(i + 1) % 3];
  const std::array<float, 3> force{hoist.ax_m_s2, hoist.ay_m_s2, hoist.az_m_s2};
  const std::array<float, 3> about{hoist.beta_rate_rad_s, hoist.alpha_rate_rad_s, hoist.yaw_rate_rad_s};
  std::array<float, 3> f{}, r{};
  for (std::size_t chip = 0; chip < 3; ++chip) {
    for (std::size_t row = 0; row < 3; ++row) {
      if (axes[row][chip] == 0) continue;  // a reading that is no number stays in its own axis
      f[chip] = axes[row][chip] * force[row];
      r[chip] = axes[row][chip] * about[row];
    }
  }
  return {f[0], f[1], f[2], r[1], r[0], r[2]};
}

// How a sensor lives from one power-on to the next.
enum class Life : unsigned { quiet, still, swaying, rough, driving, dead };

class TiltRules : public ::testing::Test {
 protected:
  void SetUp() override { node_.tick_1ms(); }
  template <class T>
  T one_of(std::initializer_list<T> all) {
    return all.begin()[random_() % all.size()];
  }
  bool once_in(unsigned times) { return random_() % times == 0; }
  float either(float size) { return once_in(2) ? size : -size; }

  bool write(std::uint16_t index, std::uint8_t sub, std::size_t bytes, std::uint32_t value) {
    return ask(node_, board_, canopen::sdo(0x613, canopen::sdo_download_command(bytes), index, sub, value)).data[0] == 0x60;
  }
  void set_gain(double angle, double bias) {
    ASSERT_TRUE(write(0x2102, 1, 4, std::bit_cast<std::uint32_t>(static_cast<float>(angle))));
    ASSERT_TRUE(write(0x2102, 2, 4, std::bit_cast<std::uint32_t>(static_cast<float>(bias))));
    rule_.gain_angle = static_cast<float>(angle), rule_.gain_bias = static_cast<float>(bias);
  }

  void begin(Life life) {
    board_.cause = one_of({ResetCause::power, ResetCause::pin, ResetCause::watchdog, ResetCause::software});
    if (once_in(2)) {
      node_.power_on();
    } else {
      node_.on_frame(canopen::nmt(canopen::NmtCommand::reset_node, 0));
    }
    rule_.power_on();
    ASSERT_EQ(node_.stack().values().get<0x2221>(), static_cast<std::uint8_t>(board_.cause));
    ASSERT_EQ(node_.stack().values().get<0x2120>(), 0);
    life_ = life;
    reads_before_ = rule_.reads;
    error_ = false;
    looked_at_ = -1;
    code_ = 12;
    board_.report = {life != Life::dead || once_in(2), false, false, 0x68};
    board_.imu_fresh = rule_.fresh = life != Life::dead;
    punctual_ = life != Life::rough && life != Life::dead;
    to_sync_ms_ = life != Life::quiet && once_in(3) ? 14 : 10;
    jerk_at_ = -1;
    outage_ = 0;
    repeats_ = 0;
    world_ = {};
    time_s_ = 0;
    if (life == Life::quiet) world_.restless = 0.2F;
    for (float& lean : world_.lean_rad) lean = either(one_of({0.0F, 0.05F, 0.2F, 0.4F}));
    for (float& bias : world_.bias_rad_s) bias = either(one_of({0.0F, 0.02F, 0.1F, 0.18F}));
    if (life == Life::still) {
      if (once_in(4)) world_.bias_rad_s[random_() % 3] = either(one_of({0.35F, 0.42F}));
      if (once_in(2)) world_.weight = one_of({0.88F, 0.92F, 1.08F, 1.12F});
      if (once_in(2)) world_.turn_rad_s[random_() % 2] = either(one_of({0.0055F, 0.008F}));
    }
    if (life == Life::swaying) {
      world_.omega_rad_s = one_of({2.0F, 4.0F, 6.0F});
      for (float& sway : world_.sway_rad) sway = either(one_of({0.02F, 0.06F})) / world_.omega_rad_s;
      world_.yaw_sway_rad_s = either(0.04F);
      switch (random_() % 4) {  // at most one thing that speaks against it
        case 0:
          world_.drift_rad_s2[random_() % 2] = either(one_of({0.0027F, 0.004F}));
          break;
        case 1:
          world_.drift_rad_s2[2] = either(one_of({0.002F, 0.003F}));
          break;
        case 2:
          jerk_at_ = 100 + static_cast<int>(random_() % 690);
          jerked_ = random_() % 3;
          jerk_ = either(one_of({0.1F, 0.28F, 0.32F}));
          break;
        default:
          world_.turn_rad_s[random_() % 2] = either(0.01F);
          break;
      }
    }
    ASSERT_NO_FATAL_FAILURE(one_ms());  // boot-up
    if (once_in(2)) {
      ASSERT_NO_FATAL_FAILURE(set_gain(one_of({0.005, 0.03, 0.05}), one_of({-0.004, -0.02, -0.03})));
    }
    if (life != Life::dead && once_in(2)) mount();
  }
  void mount() {
    code_ = one_of({13, 15, 21, 24, 26, 31, 35, 42, 43, 45, 51, 56, 62, 64, 65, 12});
    ASSERT_TRUE(write(0x2104, 0, 1, static_cast<std::uint32_t>(code_)));
    rule_.mounted_anew();
    look();
  }

  // The next reading, once the last has been taken.
  void look() {
    rule_.imu = world_.at(time_s_, random_);
    float* const fields[] = {&rule_.imu.alpha_rate_rad_s, &rule_.imu.beta_rate_rad_s, &rule_.imu.yaw_rate_rad_s,
                             &rule_.imu.ax_m_s2,          &rule_.imu.ay_m_s2,         &rule_.imu.az_m_s2};
    if (life_ == Life::quiet || jerk_at_ > 0) {
      if (rule_.reads - reads_before_ == jerk_at_) *fields[jerked_] += jerk_;
    } else if (repeats_ > 0) {
      --repeats_;
      rule_.imu = repeated_;
    } else if (once_in(life_ == Life::still ? 180 : life_ == Life::swaying ? 1500 : rule_.converged ? 60 : 400)) {
      float& field = *fields[random_() % 6];
      const bool force = &field == fields[3] || &field == fields[4] || &field == fields[5];
      const bool small = life_ == Life::still || life_ == Life::swaying;
      field += either(small   ? force ? one_of({0.35F, 0.4F, 0.65F, 0.9F}) : one_of({0.02F, 0.022F, 0.04F, 0.05F, 0.12F, 0.26F, 0.35F})
                        : force ? one_of({2.0F, 6.0F})
                              : one_of({0.5F, 4.1F, 4.8F}));
    } else if (life_ == Life::rough && once_in(60)) {
      *fields[random_() % 6] = either(one_of({std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}));
    } else if (life_ == Life::rough && once_in(80)) {
      const unsigned left = random_() % 4;  // which force is still there, if any
      for (unsigned i = 0; i < 3; ++i)
        if (i != left) *fields[3 + i] = 0;
    } else if (once_in(150)) {
      const float weight = one_of({0.47F, 0.53F, 1.45F, 1.55F, 0.6F, 1.2F});
      if (life_ == Life::driving || life_ == Life::rough)
        for (unsigned i = 0; i < 3; ++i) *fields[3 + i] *= weight;
    }
    if (once_in(life_ == Life::swaying ? 3000 : 400)) {
      repeats_ = one_of({5, 9, 10, 11, 12, 30});
      repeated_ = rule_.imu;
    }
    board_.imu = seen_by_chip(rule_.imu, code_);
  }

  void happen() {
    if (outage_ > 0 && rule_.reads - outage_begin_ == outage_) {
      outage_ = 0;
      rule_.fresh = board_.imu_fresh = true;
    }
    if ((life_ == Life::still && once_in(6000)) || (life_ == Life::driving && rule_.converged && outage_ == 0 && once_in(2500))) {
      outage_ = life_ == Life::still ? 1 : one_of({8, 9});
      outage_begin_ = rule_.reads;
      rule_.fresh = board_.imu_fresh = false;
    }
    if (life_ == Life::still && once_in(3000)) end_turn();
    if (life_ == Life::still && !rule_.converged && once_in(6000)) mount_out_of_operation();
    if (life_ == Life::rough) {
      if (once_in(300)) rule_.fresh = board_.imu_fresh = false;
      if (!rule_.fresh && once_in(one_of({30U, 90U}))) rule_.fresh = board_.imu_fresh = true;
      if (once_in(4000) && !rule_.converged) mount_out_of_operation();
      if (once_in(6000)) board_.report.who_am_i = static_cast<std::uint8_t>(random_());
      if (once_in(9000)) board_.report.wrong_part = true;
      if (once_in(9000)) board_.report.self_test_failed = true;
    }
    if (life_ == Life::dead) {
      if (once_in(8000)) rule_.fresh = board_.imu_fresh = true;
      if (!rule_.converged && once_in(6000)) mount_out_of_operation();
      if (once_in(4000)) board_.report.found = !board_.report.found;
    }
    if (life_ == Life::driving && rule_.converged && once_in(1500)) {
      const std::size_t i = random_() % 2;
      switch (random_() % 5) {
        case 0:
          world_.yaw_rad_s = either(one_of({0.0F, 0.3F, 0.9F, 1.4F}));
          break;
        case 1:
          world_.bias_rad_s[i] += either(one_of({0.03F, 0.04F, 0.07F, 0.09F}));
          break;
        case 2:
          world_.push_m_s2[i] = either(one_of({0.0F, 1.2F, 2.0F, 3.5F}));
          break;
        case 3:
          world_.lean_rad[i] = either(one_of({0.1F, 0.3F}));
          break;
        default:
          world_.push_m_s2 = {};
          break;
      }
    }
  }
  void end_turn() {
    for (std::size_t i = 0; i < 2; ++i) world_.lean_rad[i] += world_.turn_rad_s[i] * time_s_;
    world_.turn_rad_s = {};
  }
  void mount_out_of_operation() {
    node_.on_frame(canopen::nmt(canopen::NmtCommand::pre_operational, 0));
    mount();
    node_.on_frame(canopen::nmt(canopen::NmtCommand::start, 0));
  }

  void one_ms() {
    if (rule_.reads != looked_at_) look();
    looked_at_ = rule_.reads;
    time_s_ += 0.001F;
    node_.tick_1ms();
    rule_.tick(board_.report);
    ASSERT_NO_FATAL_FAILURE(compare());
  }
  void run_ms(int count) {
    for (int i = 0; i < count; ++i) {
      happen();
      ASSERT_NO_FATAL_FAILURE(one_ms()) << "millisecond " << i;
      if (i == 1) node_.on_frame(canopen::nmt(canopen::NmtCommand::start, 0));
      if (once_in(500)) node_.on_frame(one_of({frame_of(0x80, {0}), frame_of(0x81, {}), frame_of(0x7F, {}), CanFrame{0x80, 0, 2, {}}}));
      if (--to_sync_ms_ > 0) continue;
      const bool odd = life_ != Life::quiet && once_in(punctual_ ? 2000 : 6);
      to_sync_ms_ = outage_ > 1            ? 12
                    : life_ == Life::quiet ? 10
                    : !odd                 ? (once_in(20) ? one_of({8, 9, 11, 12}) : 10)
                                           : one_of({3, 4, 5, 6, 7, 13, 14, 18, 60});
      if (rule_.reads != looked_at_) look();
      looked_at_ = rule_.reads;
      node_.on_frame(canopen::sync());
      rule_.sync();
      ASSERT_NO_FATAL_FAILURE(compare()) << "SYNC in millisecond " << i;
    }
  }

  void compare() {
    const auto& values = node_.stack().values();
    ASSERT_EQ(board_.imu_reads, rule_.reads);
    ASSERT_EQ(values.get<0x2120>(), rule_.status);
    ASSERT_EQ(values.get<0x1001>(), rule_.error ? 0x21 : 0);
    if (rule_.error && !error_) {
      ASSERT_EQ((values.get<0x1003, 1>()), 0x215000U);
    }
    error_ = rule_.error;
    ASSERT_EQ(values.get<0x2122>(), board_.report.who_am_i);
    if (values.get<0x2121>() == seen_ && rule_.counter == seen_) return;
    seen_ = rule_.counter;
    ASSERT_EQ(values.get<0x2121>(), rule_.counter);
    const auto clamped = [](double value) { return std::clamp(value, -32768.0, 32767.0); };
    ASSERT_NEAR(values.get<0x6010>(), clamped(1000 * rule_.angle_deg[0]), 1.2);
    ASSERT_NEAR(values.get<0x6020>(), clamped(1000 * rule_.angle_deg[1]), 1.2);
    ASSERT_NEAR((values.get<0x2101, 1>()), rule_.bias_rad_s[0], 1e-5);
    ASSERT_NEAR((values.get<0x2101, 2>()), rule_.bias_rad_s[1], 1e-5);
    ASSERT_NEAR((values.get<0x2110, 1>()), clamped(100 * rule_.rate_deg_s[0]), 0.6);
    ASSERT_NEAR((values.get<0x2110, 2>()), clamped(100 * rule_.rate_deg_s[1]), 0.6);
    ASSERT_NEAR((values.get<0x2110, 3>()), clamped(100 * rule_.rate_deg_s[2]), 0.6);
    ASSERT_NEAR((values.get<0x2111, 1>()), clamped(1000 * rule_.force_g[0]), 0.6);
    ASSERT_NEAR((values.get<0x2111, 2>()), clamped(1000 * rule_.force_g[1]), 0.6);
    ASSERT_NEAR((values.get<0x2111, 3>()), clamped(1000 * rule_.force_g[2]), 0.6);
  }

  void live(Life life, unsigned seed, int for_ms) {
    SCOPED_TRACE(testing::Message() << "life " << static_cast<unsigned>(life) << ", seed " << seed);
    random_.seed(seed);
    ASSERT_NO_FATAL_FAILURE(begin(life));
    ASSERT_NO_FATAL_FAILURE(run_ms(for_ms));
    converged_ += rule_.converged ? 1 : 0;
  }

  TestBoard board_;
  TiltNode<TestBoard> node_{board_, contract::Node::tilt_base};
  TiltRule rule_;
  TiltWorld world_;
  std::mt19937 random_{1};
  Life life_ = Life::still;
  ImuSample repeated_;
  float time_s_ = 0, jerk_ = 0;
  bool punctual_ = true, error_ = false;
  int code_ = 12, repeats_ = 0, looked_at_ = -1, to_sync_ms_ = 10, converged_ = 0;
  std::size_t jerked_ = 0;  // as `fields` in look()
  int reads_before_ = 0, jerk_at_ = -1, outage_ = 0, outage_begin_ = 0;
  unsigned seen_ = 0;
};

TEST_F(TiltRules, H8ASensorThatStandsIsKnownByTheRule) {
  for (unsigned seed = 1; seed <= 80; ++seed) ASSERT_NO_FATAL_FAILURE(live(Life::still, seed, 5000));
  EXPECT_GT(converged_, 20);
  EXPECT_LT(converged_, 70);
}

TEST_F(TiltRules, H8AStandingPersonsSensorIsKnownByTheRule) {
  for (unsigned seed = 1; seed <= 60; ++seed) ASSERT_NO_FATAL_FAILURE(live(Life::swaying, seed, seed % 4 == 0 ? 16'500 : 8600));
  EXPECT_GT(converged_, 20);
  EXPECT_LT(converged_, 50);
}

TEST_F(TiltRules, H8ATurningLeaningSensorIsJudgedByTheRule) {
  for (unsigned seed = 1; seed <= 25; ++seed) ASSERT_NO_FATAL_FAILURE(live(Life::driving, seed, 12'000));
  EXPECT_GT(converged_, 15);
}

TEST_F(TiltRules, H6AFailingSensorIsJudgedByTheRule) {
  for (unsigned seed = 1; seed <= 60; ++seed) ASSERT_NO_FATAL_FAILURE(live(Life::rough, seed, 3000));
}

TEST_F(TiltRules, H6ADeadSensorIsJudgedByTheRule) {
  for (unsigned seed = 1; seed <= 16; ++seed) ASSERT_NO_FATAL_FAILURE(live(Life::dead, seed, 9000));
}

// A turn too slow for the rates: seen by gravity after two seconds, and taken off after eight.
TEST_F(TiltRules, H8ASlowTurnIsTakenOffAfterEightSeconds) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    ASSERT_NO_FATAL_FAILURE(begin(Life::quiet));
    world_.turn_rad_s[seed % 2] = seed < 3 ? 0.009F : -0.009F;
    ASSERT_NO_FATAL_FAILURE(run_ms(8200));
    EXPECT_TRUE(rule_.converged);
  }
}

// After a slow turn the two seconds begin anew.
TEST_F(TiltRules, H8ASlowTurnThatEndsIsFollowedByTwoStillSeconds) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    ASSERT_NO_FATAL_FAILURE(begin(Life::quiet));
    world_.turn_rad_s[seed % 2] = seed < 3 ? 0.009F : -0.009F;
    ASSERT_NO_FATAL_FAILURE(run_ms(2030));
    end_turn();
    ASSERT_NO_FATAL_FAILURE(run_ms(2100));
    EXPECT_TRUE(rule_.converged);
  }
}

// Each rate and each force has its limits, in both directions; 100 readings that were good are lost beyond them.
TEST_F(TiltRules, H8EachAxisAloneEndsTheStillTime) {
  for (std::size_t axis = 0; axis < 6; ++axis) {
    for (const float share : {0.75F, -0.75F, 1.5F, -1.5F}) {
      SCOPED_TRACE(testing::Message() << "axis " << axis << ", " << share << " of the limit");
      ASSERT_NO_FATAL_FAILURE(begin(Life::quiet));
      jerk_at_ = 100;
      jerked_ = axis;
      jerk_ = share * (axis < 3 ? 0.03F : 0.5F);
      ASSERT_NO_FATAL_FAILURE(run_ms(2100));
      EXPECT_EQ(rule_.converged, std::fabs(share) < 1);
    }
  }
}

TEST_F(TiltRules, H8EachRateAloneEndsTheStandingTime) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const float share : {0.65F, -0.65F, 1.5F, -1.5F}) {
      SCOPED_TRACE(testing::Message() << "axis " << axis << ", " << share << " of the limit");
      ASSERT_NO_FATAL_FAILURE(begin(Life::quiet));
      world_.bias_rad_s = {};
      world_.omega_rad_s = 3.1415927F;
      world_.sway_rad = {0.012F, -0.012F};
      world_.yaw_sway_rad_s = 0.035F;
      look();
      jerk_at_ = 400;  // where the sway is as it was at the beginning
      jerked_ = axis;
      jerk_ = share * 0.2F;
      ASSERT_NO_FATAL_FAILURE(run_ms(8100));
      EXPECT_EQ(rule_.converged, std::fabs(share) < 1);
    }
  }
}

// What was read in another mounting counts no more, not even the last reading; and the sensor has its time to start once more.
TEST_F(TiltRules, H7AnotherMountingBeginsEverythingAnew) {
  for (const bool dead : {false, true}) {
    for (const int after_ms : {1500, 1501, 1502, 1503, 1509}) {
      SCOPED_TRACE(after_ms);
      ASSERT_NO_FATAL_FAILURE(begin(Life::quiet));
      rule_.fresh = board_.imu_fresh = !dead;
      ASSERT_NO_FATAL_FAILURE(run_ms(after_ms));
      mount_out_of_operation();
      ASSERT_NO_FATAL_FAILURE(run_ms(dead ? 6010 : 2100));
      EXPECT_EQ(rule_.converged, !dead);
    }
  }
}

// Both windows end with one sample: the still one counts.
TEST_F(TiltRules, H8TwoStillSecondsCountBeforeEightOfStanding) {
  ASSERT_NO_FATAL_FAILURE(begin(Life::quiet));
  world_.drift_rad_s2 = {0.001F, -0.001F, 0.001F};
  jerk_ = 0.08F;
  for (const int at : {150, 300, 450, 600}) {
    jerk_at_ = at - 1;  // the reading after so many
    while (rule_.reads - reads_before_ < at) ASSERT_NO_FATAL_FAILURE(run_ms(1));
  }
  ASSERT_NO_FATAL_FAILURE(run_ms(1980));
  EXPECT_FALSE(rule_.converged);
  ASSERT_NO_FATAL_FAILURE(run_ms(100));
  EXPECT_TRUE(rule_.converged);
}

// A reading is thought about once, however long the next is missing.
TEST_F(TiltRules, H6ALongOutageEndsLikeAShortOne) {
  for (const int missing_ms : {40, 250, 251, 252, 253, 254, 255, 256, 257, 258, 259, 500}) {
    SCOPED_TRACE(missing_ms);
    ASSERT_NO_FATAL_FAILURE(begin(Life::quiet));
    ASSERT_NO_FATAL_FAILURE(run_ms(100));
    rule_.fresh = board_.imu_fresh = false;
    ASSERT_NO_FATAL_FAILURE(run_ms(missing_ms));
    rule_.fresh = board_.imu_fresh = true;
    ASSERT_NO_FATAL_FAILURE(run_ms(2100));
    EXPECT_TRUE(rule_.converged);
  }
}

TEST(TiltStart, SaysWhyItsProcessorStartedFromTheFirstMomentOn) {
  TestBoard board;
  board.cause = ResetCause::watchdog;
  const TiltNode<TestBoard> node(board, contract::Node::tilt_base);
  EXPECT_EQ(node.stack().values().get<0x2221>(), 2);
}

// H7: a stored mounting that does not exist (33 is between the ends of the object's range).
TEST(TiltStart, H7WithAMountingThatDoesNotExistTheNodeHasFailed) {
  for (const unsigned code : {12U, 21U, 33U, 14U, 41U, 20U, 17U, 27U, 48U}) {
    SCOPED_TRACE(code);
    TestBoard board;
    const std::array records{StoredValue{0x0001, 0, 1, 0x13}, StoredValue{0x2104, 0, 1, code}};
    ParameterStore<TestFlash> store(board.pages, static_cast<std::uint8_t>(contract::NodeKind::tilt));
    ASSERT_TRUE(store.save(records.size(), [&records](std::size_t i) { return records.at(i); }));
    TiltNode<TestBoard> node(board, contract::Node::tilt_base);
    make_operational(node, board);
    tick(node, 10);
    ASSERT_EQ(node.stack().values().get<0x2104>(), code);
    const bool exists = code == 12 || code == 21;
    EXPECT_EQ(node.stack().values().get<0x2120>(), exists ? 1 : 16);
    EXPECT_EQ(node.stack().values().get<0x1001>(), exists ? 0 : 0x21);
  }
}

// Rates that no gyroscope has, yet a broken one may show: what the filter cannot compute is no sample.
TEST(TiltStart, H6AReadingTooLargeForTheFilterIsNoSample) {
  TestBoard board;
  TiltNode<TestBoard> node(board, contract::Node::tilt_base);
  node.tick_1ms();
  const auto bits = std::bit_cast<std::uint32_t>(-0.2F);
  ASSERT_EQ(ask(node, board, canopen::sdo(0x613, canopen::sdo_download_command(4), 0x2102, 2, bits)).data[0], 0x60);
  node.on_frame(canopen::nmt(canopen::NmtCommand::start, 0));
  const auto& values = node.stack().values();
  int missing = 0;
  for (int i = 0; i < 200; ++i) {
    board.imu.alpha_rate_rad_s = i / 100 % 2 == 0 ? 3.4e38F : -3.4e38F;
    const std::uint8_t before = values.get<0x2121>();
    tick(node, 10);
    const bool counted = values.get<0x2121>() != before;
    ASSERT_EQ(values.get<0x2120>() & 1, counted && (values.get<0x2120>() & 16) == 0 ? 1 : 0);
    missing += counted ? 0 : 1;
  }
  EXPECT_GT(missing, 0);
}

}  // namespace
}  // namespace hoist::firmware
