// The tilt sensor: two static Kalman filters (alpha, beta) at 100 Hz, the gyro's bias measured after power-on while the hoist stands: in
// two still seconds, or in eight under a standing person. CiA 410 on the bus.
//
// It samples when a SYNC arrives, so that the three sensors sample together: the chassis' acceleration affects every sensor and cancels
// only in differences of equal, simultaneous filters (D4). Without SYNC it samples on its own clock.
//
// A sensor that is missing, unknown, failed its self-test or stopped giving readings makes the node invalid until a power cycle (the last
// also until a reset of the node). The sensor's mounting is an object (2104h); all later values are in the frame of the hoist.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "control/core/law/tilt_kalman.hpp"
#include "firmware/lib/canopen_node.hpp"
#include "firmware/lib/convert.hpp"
#include "firmware/lib/trig.hpp"

namespace hoist::firmware {

inline constexpr std::uint32_t kTiltSample_ms = 10;      // paper T5: 100 Hz; the printed gain belongs to this rate
inline constexpr std::uint32_t kTiltSampleMin_ms = 5;    // a SYNC sooner than this after a sample sends but does not sample
inline constexpr std::uint32_t kTiltSyncLost_ms = 12;    // then the node's own clock takes over
inline constexpr std::uint32_t kTiltGap_ms = 100;        // after a longer gap the angle restarts from gravity
inline constexpr std::uint32_t kTiltStillSamples = 200;  // D23: a still 2 s at power-on
inline constexpr std::uint32_t kTiltQuarterSamples = kTiltStillSamples / 4;  // its first and last quarter are compared
inline constexpr std::uint32_t kTiltReadFailuresMax = 10;                    // unusable readings in a row: the sensor has failed
inline constexpr std::uint32_t kTiltStart_ms = 6000;                         // power-up and every try of the sensor's self-test fit in
inline constexpr float kGravity_m_s2 = 9.80665F;
inline constexpr float kAccelerationMax_m_s2 = 19.0F;  // just inside the +-2 g that resolve a walking tilt best
inline constexpr float kRateMax_rad_s = 4.3F;          // just inside +-250 deg/s
// Standstill. Noise of gyros of this class stays below 0.005 rad/s rms; a person moves the struts by more than 0.03 rad/s.
inline constexpr float kStillRate_rad_s = 0.03F;        // from the first sample of the window
inline constexpr float kStillAcceleration_m_s2 = 0.5F;  // likewise, each axis
inline constexpr float kStillTurn_rad = 0.01F;          // gravity in the last quarter against the first: a slow steady turn
// Standing. A standing person sways by 10 mm at the harness at up to 1 Hz: 0.08 rad/s of a strut of 0.8 m and 0.4 m/s2. These rates average
// out; the gravity angle at the window's ends separates them from a bias. The middle one of three blocks shows whether the bias was
// constant; 1 Hz of sway separates the results by 0.0085 rad/s at most.
inline constexpr std::uint32_t kTiltSwaySamples = 800;  // 8 s
inline constexpr std::uint32_t kTiltSwayBlock = 200;    // three of them: at the beginning, in the middle, at the end
inline constexpr float kSwayBlocksApart_s = 3.0F;       // from the middle of one block to that of the next
inline constexpr float kSwayRate_rad_s = 0.2F;          // from the first sample of the window
inline constexpr float kSwayAgree_rad_s = 0.01F;        // a fifth of kBiasChange_rad_s
inline constexpr std::uint32_t kTiltRepeatsMax = 10;    // of a sample, in a row: a stuck sensor; noise makes that impossible (H6)
inline constexpr float kBiasMax_rad_s = 0.4F;           // a gyro that shows more at rest (23 deg/s) is defective or being turned
// A gyroscope whose bias has jumped (H8): no sample is valid while one of these is exceeded.
inline constexpr float kBiasChange_rad_s = 0.0524F;         // H8: 3 deg/s from the bias at rest
inline constexpr float kDisagreement_rad = 0.105F;          // H8: 6 deg between gyroscope and gravity ...
inline constexpr float kDisagreementRate_per_s = 1 / 0.5F;  // ... low-passed with 0.5 s
inline constexpr float kTurnMax_rad_s = 1.1F;               // no hoist turns faster (50 deg/s and a margin); the correction ends there

template <TiltBoard Board>
class TiltNode {
 public:
  using Stack = CanopenNode<Board, contract::NodeKind::tilt>;
  static constexpr std::uint8_t kValid = 0x01, kConverged = 0x02, kAccelerationRange = 0x04, kGyroSaturated = 0x08, kSelfTestFailed = 0x10,
                                kSensorMissing = 0x20;

  TiltNode(Board& board, contract::Node node) : board_(board), stack_(board, node) { on_power_on(); }

  void on_frame(const CanFrame& frame) {
    // Also before the node is operational: the filters run from power-on. What is no SYNC to the stack is none here.
    if (frame.id == contract::canopen::kSync && frame.dlc == 0 && frame.flags == 0) {
      sync_age_ms_ = 0;
      if (sample_age_ms_ >= kTiltSampleMin_ms) sample();
    }
    stack_.on_frame(frame, *this);
  }

  void tick_1ms() {
    if (sync_age_ms_ < kAgeMax) ++sync_age_ms_;
    if (sample_age_ms_ < kAgeMax) ++sample_age_ms_;
    if (gap_ms_ < kAgeMax) ++gap_ms_;
    watch_sensor();
    if (sync_age_ms_ > kTiltSyncLost_ms && sample_age_ms_ >= kTiltSample_ms) sample();
    if (after_.in_ms > 0 && --after_.in_ms == 0) after_sample();
    stack_.tick_1ms(*this);
  }

  void power_on() {
    stack_.power_on();
    on_power_on();
  }

  [[nodiscard]] const Stack& stack() const { return stack_; }
  [[nodiscard]] float alpha_rad() const { return axes_[0].angle_rad(); }
  [[nodiscard]] float beta_rad() const { return axes_[1].angle_rad(); }

 private:
  friend Stack;
  static constexpr std::uint32_t kAgeMax = 0xFFFF;

  struct Axis {
    law::TiltState<float> state{};
    law::TiltState<float> turn{};                   // what the hoist's turn alone has put into it
    float first_angle_rad = 0, last_angle_rad = 0;  // sums over the first and last quarter of the window
    float angle_sum_rad = 0;
    std::array<float, 3> block_angle_rad{}, block_turned{};  // sums over the blocks of the long window; turned: as Sway::turned
    float rest_bias_rad_s = 0;                               // as measured in the still start
    float disagreement_rad = 0;                              // of gravity from the angle, low-passed
    /// As sent: the paper's filter, less what the hoist's turn put into it.
    [[nodiscard]] float angle_rad() const { return state.angle_rad - turn.angle_rad; }
  };
  struct Window {
    std::uint32_t samples = 0;
    ImuSample first{}, last{};
    std::uint32_t repeats = 0;
    std::array<float, 3> turned{};  // Sway::turned before its first sample
  };
  // The long window. It restarts only together with the short one.
  struct Sway {
    std::uint32_t samples = 0;
    std::array<float, 3> first_rad_s{};
    std::array<float, 3> turned{};  // alpha, beta, yaw: sum of the rates since its beginning; below 320, so exact to 1e-7 rad/s
    float half_yaw = 0;             // turned[2] in the middle
  };

  // Deferred work of a sample: reading the chip and filtering fill most of a millisecond. Not in the next tick, which may come right after the
  // SYNC.
  static constexpr std::uint8_t kAfterSample_ms = 2;
  static_assert(kAfterSample_ms < kTiltSampleMin_ms);
  struct After {
    ImuSample sample{};
    law::AccAngles<float> gravity{};
    float dt_s = 0;
    bool begun = false;    // the filters have restarted with this sample
    bool in_time = false;  // this sample came when it was due
    std::uint8_t in_ms = 0;
  };

  void on_sync() {}
  void on_rpdo() {}
  void on_rpdo_deadline() {}
  void on_heartbeat_lost() {}
  void on_nmt(NmtState, NmtState) {}
  void on_power_on() {
    begin_anew();
    failed_ = missing_ = false;
    failures_ = 0;
    stack_.values().template set<0x2221>(static_cast<std::uint8_t>(board_.reset_cause()));
    if (!set_mounting(stack_.values().template get<0x2104>())) give_up(false);  // kept by a program that knew others
    sync_age_ms_ = kAgeMax;
    sample_age_ms_ = 0;
    gap_ms_ = 0;
  }
  SdoAbort check_write(std::uint16_t index, std::uint8_t, std::uint32_t raw) {
    if (index != 0x2104) return SdoAbort::none;
    if (stack_.operational()) return SdoAbort::device_state;
    if (!set_mounting(static_cast<std::uint8_t>(raw))) return SdoAbort::range;
    begin_anew();  // all angles and rates were of other directions
    return SdoAbort::none;
  }

  // ---- the sensor

  // Which axis of the chip points forward, left and up, and in which sense.
  struct Mounting {
    std::array<std::uint8_t, 3> axis{0, 1, 2};
    std::array<bool, 3> reversed{};
  };
  // 2104h: tens and ones are 1 to 6. False, and nothing changed, when these are not two different axes.
  bool set_mounting(std::uint8_t code) {
    const std::uint8_t forward = static_cast<std::uint8_t>(code / 10U), left = static_cast<std::uint8_t>(code % 10U);
    if (forward < 1 || forward > 6 || left < 1 || left > 6 || (forward - 1) % 3 == (left - 1) % 3) return false;
    Mounting m;
    m.axis[0] = static_cast<std::uint8_t>((forward - 1) % 3);
    m.axis[1] = static_cast<std::uint8_t>((left - 1) % 3);
    m.axis[2] = static_cast<std::uint8_t>(3 - m.axis[0] - m.axis[1]);
    m.reversed[0] = forward > 3;
    m.reversed[1] = left > 3;
    // Up completes a right-handed frame: the axes in cyclic order need no sign.
    const bool cyclic = m.axis[1] == (m.axis[0] + 1) % 3;
    m.reversed[2] = (m.reversed[0] != m.reversed[1]) == cyclic;
    mounting_ = m;
    return true;
  }
  [[nodiscard]] ImuSample mounted(const ImuSample& chip) const {
    const std::array<float, 3> acceleration{chip.ax_m_s2, chip.ay_m_s2, chip.az_m_s2};
    const std::array<float, 3> rate{chip.beta_rate_rad_s, chip.alpha_rate_rad_s, chip.yaw_rate_rad_s};  // about x, y, z
    std::array<float, 6> out{};
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t from = mounting_.axis[i];
      out[i] = mounting_.reversed[i] ? -acceleration[from] : acceleration[from];
      out[3 + i] = mounting_.reversed[i] ? -rate[from] : rate[from];
    }
    return {out[0], out[1], out[2], out[4], out[3], out[5]};
  }
  // What the chip's driver found out. The first readings may take as long as the self-test with all its tries.
  void watch_sensor() {
    const ImuReport report = board_.imu_report();
    stack_.values().template set<0x2122>(report.who_am_i);
    if (start_age_ms_ < kTiltStart_ms) ++start_age_ms_;
    if (report.self_test_failed) give_up(false);
    if (report.wrong_part) give_up(true);
    if (!started_ && start_age_ms_ == kTiltStart_ms) give_up(!report.found);
  }
  void give_up(bool missing) {
    missing_ = missing_ || missing;
    if (failed_) return;
    failed_ = true;
    report_error();
    publish_status(0);
  }
  void report_error() { stack_.set_error(emcy::kHardware, error_bit::kProfile, failed_ || doubtful_); }
  void publish_status(std::uint8_t bits) {
    stack_.values().template set<0x2120>(static_cast<std::uint8_t>(bits | (converged_ ? kConverged : 0U) |
                                                                   (failed_ ? kSelfTestFailed : 0U) | (missing_ ? kSensorMissing : 0U)));
  }

  static bool usable(const ImuSample& s) {
    return law::finite(s.ax_m_s2) && law::finite(s.ay_m_s2) && law::finite(s.az_m_s2) && law::finite(s.alpha_rate_rad_s) &&
           law::finite(s.beta_rate_rad_s) && law::finite(s.yaw_rate_rad_s);
  }
  static bool above(float value, float limit) { return value > limit || value < -limit; }
  // Equations (17) and (18) as law::acc_angles reads them, with an arctangent that gives the same bits on every machine.
  static law::AccAngles<float> gravity_of(const ImuSample& s) {
    if (s.ax_m_s2 == 0.0F && s.ay_m_s2 == 0.0F && s.az_m_s2 == 0.0F) return {};
    return {arctan2(-s.ax_m_s2, s.az_m_s2), arctan2(s.ay_m_s2, s.az_m_s2), true};
  }

  void sample() {
    ImuSample chip;
    const bool fresh = board_.read_imu(chip) && usable(chip);
    const ImuSample s = fresh ? mounted(chip) : ImuSample{};
    const law::AccAngles<float> gravity = fresh ? gravity_of(s) : law::AccAngles<float>{};
    const bool late = sample_age_ms_ < kTiltSample_ms - 2 || sample_age_ms_ > kTiltSample_ms + 2;
    const float dt_s = 0.001F * static_cast<float>(!late && gap_ms_ == sample_age_ms_ ? kTiltSample_ms : gap_ms_);
    sample_age_ms_ = 0;
    const bool begins = !started_ || gap_ms_ > kTiltGap_ms;
    if (!fresh || !gravity.valid || !filter(s, gravity, begins, dt_s)) return fail();
    gap_ms_ = 0;
    failures_ = 0;
    after_ = {s, gravity, dt_s, begins, !late, kAfterSample_ms};
    publish(s);
  }

  // Its result applies to the next sample, 10 ms later, which is fast enough.
  void after_sample() {
    follow_turn(after_.sample.yaw_rate_rad_s, after_.begun, after_.dt_s);
    doubt(after_.gravity, after_.dt_s);
    if (!converged_) settle(after_.sample, after_.gravity, after_.in_time);
  }

  // H8: a gyroscope whose bias has jumped disagrees with gravity. The hoist's own motion stays below the limits: braking with 1.5 m/s2
  // looks like 8.7 degrees of lean, but for less than half a second (DECISIONS.md, 23). The bias learnt from a turn is known and subtracted
  // (46).
  void doubt(const law::AccAngles<float>& gravity, float dt_s) {
    bool zero_lost = false;
    const float angles_rad[2] = {gravity.alpha_rad, gravity.beta_rad};
    for (std::size_t i = 0; i < 2; ++i) {
      Axis& axis = axes_[i];
      axis.disagreement_rad += (angles_rad[i] - axis.angle_rad() - axis.disagreement_rad) * kDisagreementRate_per_s * dt_s;
      zero_lost = zero_lost || above(axis.disagreement_rad, kDisagreement_rad) ||
                  above(axis.state.bias_rad_s - axis.turn.bias_rad_s - axis.rest_bias_rad_s, kBiasChange_rad_s);
    }
    doubtful_ = converged_ && zero_lost;
    report_error();
  }

  [[nodiscard]] law::TiltGain<float> gain() const {
    return {stack_.values().template get<0x2102, 1>(), stack_.values().template get<0x2102, 2>()};
  }

  bool filter(const ImuSample& s, const law::AccAngles<float>& gravity, bool begins, float dt_s) {
    const float angles_rad[2] = {gravity.alpha_rad, gravity.beta_rad};
    const float rates_rad_s[2] = {s.alpha_rate_rad_s, s.beta_rate_rad_s};
    for (std::size_t i = 0; i < 2; ++i) {
      Axis& axis = axes_[i];
      if (begins) {
        axis.state = law::tilt_start(angles_rad[i], axis.state.bias_rad_s, rates_rad_s[i]);
        axis.disagreement_rad = 0;
      } else if (!law::tilt_step(gain(), axis.state, rates_rad_s[i], angles_rad[i], dt_s)) {
        return false;
      }
    }
    started_ = true;
    return true;
  }

  // A leaning sensor measures part of the hoist's turn as pitch and roll, which the paper's filter, slow to trust gravity, holds as an angle: 3
  // degrees aside at 10 degrees forward and 20 degrees a second. The filter is linear: a second one, fed with that part alone and zero gravity
  // angle, holds its share in the first.
  void follow_turn(float yaw_rate_rad_s, bool begins, float dt_s) {
    const float yaw_rad_s = std::clamp(yaw_rate_rad_s - yaw_bias_rad_s_, -kTurnMax_rad_s, kTurnMax_rad_s);
    const float felt_rad_s[2] = {yaw_rad_s * axes_[1].angle_rad(), -yaw_rad_s * axes_[0].angle_rad()};
    for (std::size_t i = 0; i < 2; ++i) {
      law::TiltState<float>& turn = axes_[i].turn;
      // An unusable state restarts at zero: the bias is then checked without correction.
      if (begins || !law::tilt_step(gain(), turn, felt_rad_s[i], 0.0F, dt_s)) turn = law::tilt_start(0.0F, turn.bias_rad_s, felt_rad_s[i]);
    }
  }

  // An unusable sample: the counter stops, which the computer takes for a missing sensor, and the valid bit is cleared.
  void fail() {
    // Before the first reading the sensor is still starting; watch_sensor() ends that.
    if (started_ && failures_ < kTiltReadFailuresMax && ++failures_ == kTiltReadFailuresMax) give_up(false);
    if (!converged_) restart_settling();
    publish_status(0);
  }

  // Nothing is known of the sensor any more, and the time that its first reading may take begins.
  void begin_anew() {
    axes_ = {};
    restart_settling();
    after_ = {};
    yaw_bias_rad_s_ = 0;
    started_ = converged_ = doubtful_ = false;
    start_age_ms_ = 0;
  }

  void restart_settling() {
    window_ = {};
    sway_ = {};
  }

  // Bias and angles are known once one of the two windows is full.
  void settle(const ImuSample& s, const law::AccAngles<float>& gravity, bool in_time) {
    if (!in_time || !stands(s)) return restart_settling();
    window_.repeats = s == window_.last ? window_.repeats + 1 : 0;
    window_.last = s;
    // A sensor that repeats one sample looks perfectly still, and its rate would be taken for the bias.
    if (window_.repeats == kTiltRepeatsMax) return restart_settling();
    const float angles_rad[2] = {gravity.alpha_rad, gravity.beta_rad};
    if (settle_still(s, angles_rad)) return;
    settle_swaying(s, angles_rad);
  }

  // Only a person's sway moves the sensor.
  [[nodiscard]] bool stands(const ImuSample& s) {
    const float rates_rad_s[3] = {s.alpha_rate_rad_s, s.beta_rate_rad_s, s.yaw_rate_rad_s};
    const float norm2 = s.ax_m_s2 * s.ax_m_s2 + s.ay_m_s2 * s.ay_m_s2 + s.az_m_s2 * s.az_m_s2;
    const float g2 = kGravity_m_s2 * kGravity_m_s2;
    if (norm2 < 0.81F * g2 || norm2 > 1.21F * g2) return false;  // more than 10 % from g is no standing
    for (std::size_t i = 0; i < 3; ++i) {
      if (sway_.samples == 0) sway_.first_rad_s[i] = rates_rad_s[i];
      if (above(rates_rad_s[i], kBiasMax_rad_s) || above(rates_rad_s[i] - sway_.first_rad_s[i], kSwayRate_rad_s)) return false;
    }
    return true;
  }

  // The still two seconds; any motion restarts them. True when they are complete.
  bool settle_still(const ImuSample& s, const float (&angles_rad)[2]) {
    const ImuSample& f = window_.samples == 0 ? s : window_.first;
    const bool moved = above(s.alpha_rate_rad_s - f.alpha_rate_rad_s, kStillRate_rad_s) ||
                       above(s.beta_rate_rad_s - f.beta_rate_rad_s, kStillRate_rad_s) ||
                       above(s.yaw_rate_rad_s - f.yaw_rate_rad_s, kStillRate_rad_s) ||
                       above(s.ax_m_s2 - f.ax_m_s2, kStillAcceleration_m_s2) || above(s.ay_m_s2 - f.ay_m_s2, kStillAcceleration_m_s2) ||
                       above(s.az_m_s2 - f.az_m_s2, kStillAcceleration_m_s2);
    if (moved) {
      window_.samples = 0;
      return false;
    }
    if (window_.samples == 0) {
      window_.first = s;
      window_.turned = sway_.turned;
      for (Axis& axis : axes_) axis.first_angle_rad = axis.last_angle_rad = axis.angle_sum_rad = 0;
    }
    for (std::size_t i = 0; i < 2; ++i) {
      axes_[i].angle_sum_rad += angles_rad[i];
      if (window_.samples < kTiltQuarterSamples) axes_[i].first_angle_rad += angles_rad[i];
      if (window_.samples >= kTiltStillSamples - kTiltQuarterSamples) axes_[i].last_angle_rad += angles_rad[i];
    }
    if (++window_.samples < kTiltStillSamples) return false;
    window_.samples = 0;
    constexpr float kQuarter = static_cast<float>(kTiltQuarterSamples), kCount = static_cast<float>(kTiltStillSamples);
    for (const Axis& axis : axes_)
      if (above((axis.last_angle_rad - axis.first_angle_rad) / kQuarter, kStillTurn_rad)) return false;
    // This sample is not yet in the sums.
    const float rates_rad_s[3] = {s.alpha_rate_rad_s, s.beta_rate_rad_s, s.yaw_rate_rad_s};
    float bias_rad_s[3];
    for (std::size_t i = 0; i < 3; ++i) bias_rad_s[i] = (sway_.turned[i] + rates_rad_s[i] - window_.turned[i]) / kCount;
    const float means_rad[2] = {axes_[0].angle_sum_rad / kCount, axes_[1].angle_sum_rad / kCount};
    converge(s, bias_rad_s, means_rad);
    return true;
  }

  // Eight seconds of standing: the turn that the rates add up to, less the turn that gravity saw, is the bias.
  void settle_swaying(const ImuSample& s, const float (&angles_rad)[2]) {
    const float rates_rad_s[3] = {s.alpha_rate_rad_s, s.beta_rate_rad_s, s.yaw_rate_rad_s};
    for (std::size_t i = 0; i < 3; ++i) sway_.turned[i] += rates_rad_s[i];
    constexpr std::uint32_t kApart = (kTiltSwaySamples - kTiltSwayBlock) / 2;
    const std::uint32_t block = sway_.samples / kApart;
    for (std::size_t i = 0; i < 2 && sway_.samples - block * kApart < kTiltSwayBlock; ++i) {
      const bool begins = sway_.samples == block * kApart;
      axes_[i].block_angle_rad[block] = (begins ? 0.0F : axes_[i].block_angle_rad[block]) + angles_rad[i];
      axes_[i].block_turned[block] = (begins ? 0.0F : axes_[i].block_turned[block]) + sway_.turned[i];
    }
    if (++sway_.samples == kTiltSwaySamples / 2) sway_.half_yaw = sway_.turned[2];
    if (sway_.samples < kTiltSwaySamples) return;

    constexpr float kBlock = static_cast<float>(kTiltSwayBlock), kCount = static_cast<float>(kTiltSwaySamples), kSample_s = 0.01F;
    float bias_rad_s[3] = {0, 0, sway_.turned[2] / kCount}, now_rad[2];
    bool agree = !above((sway_.turned[2] - 2.0F * sway_.half_yaw) * 2.0F / kCount, kSwayAgree_rad_s);
    for (std::size_t i = 0; i < 2; ++i) {
      float drift_rad[3];  // gravity's angle less the rates' turn: falls by the bias
      for (std::size_t k = 0; k < 3; ++k) drift_rad[k] = (axes_[i].block_angle_rad[k] - kSample_s * axes_[i].block_turned[k]) / kBlock;
      agree = agree && !above(drift_rad[0] - 2.0F * drift_rad[1] + drift_rad[2], kSwayAgree_rad_s * kSwayBlocksApart_s);
      bias_rad_s[i] = (drift_rad[0] - drift_rad[2]) / (2.0F * kSwayBlocksApart_s);
      constexpr float kSinceBlock_s = kSample_s * kBlock / 2.0F;
      now_rad[i] = drift_rad[2] - bias_rad_s[i] * kSinceBlock_s + kSample_s * sway_.turned[i];
    }
    if (!agree) return restart_settling();
    converge(s, bias_rad_s, now_rad);
  }

  void converge(const ImuSample& s, const float (&bias_rad_s)[3], const float (&angles_rad)[2]) {
    const float rates_rad_s[2] = {s.alpha_rate_rad_s, s.beta_rate_rad_s};
    for (std::size_t i = 0; i < 2; ++i) {
      axes_[i].rest_bias_rad_s = bias_rad_s[i];
      axes_[i].disagreement_rad = 0;
      axes_[i].turn = {};
      axes_[i].state = law::tilt_start(angles_rad[i], bias_rad_s[i], rates_rad_s[i]);
    }
    yaw_bias_rad_s_ = bias_rad_s[2];
    converged_ = true;
  }

  void publish(const ImuSample& s) {
    constexpr float kMilliDegrees = 57295.7795F;  // per radian
    constexpr float kCentiDegrees = 5729.57795F;
    auto& values = stack_.values();
    const law::TiltState<float>&alpha = axes_[0].state, &beta = axes_[1].state;
    values.template set<0x6010>(to_integer<std::int16_t>(alpha_rad() * kMilliDegrees));
    values.template set<0x6020>(to_integer<std::int16_t>(beta_rad() * kMilliDegrees));
    values.template set<0x2101, 1>(alpha.bias_rad_s);
    values.template set<0x2101, 2>(beta.bias_rad_s);
    values.template set<0x2110, 1>(to_integer<std::int16_t>((s.yaw_rate_rad_s - yaw_bias_rad_s_) * kCentiDegrees));
    values.template set<0x2110, 2>(to_integer<std::int16_t>((s.alpha_rate_rad_s - alpha.bias_rad_s) * kCentiDegrees));
    values.template set<0x2110, 3>(to_integer<std::int16_t>((s.beta_rate_rad_s - beta.bias_rad_s) * kCentiDegrees));
    const float norm2 = s.ax_m_s2 * s.ax_m_s2 + s.ay_m_s2 * s.ay_m_s2 + s.az_m_s2 * s.az_m_s2;
    const float g2 = kGravity_m_s2 * kGravity_m_s2;
    // Less than half or more than one and a half g has no direction that could be called down.
    const bool acceleration = norm2 < 0.25F * g2 || norm2 > 2.25F * g2 || above(s.ax_m_s2, kAccelerationMax_m_s2) ||
                              above(s.ay_m_s2, kAccelerationMax_m_s2) || above(s.az_m_s2, kAccelerationMax_m_s2);
    const bool saturated =
        above(s.alpha_rate_rad_s, kRateMax_rad_s) || above(s.beta_rate_rad_s, kRateMax_rad_s) || above(s.yaw_rate_rad_s, kRateMax_rad_s);
    // Values for SDO, one axis per sample: conversions are expensive without hardware floating point.
    constexpr float kMilliG = 1000.0F / kGravity_m_s2;
    raw_axis_ = raw_axis_ == 2 ? std::uint8_t{0} : static_cast<std::uint8_t>(raw_axis_ + 1U);
    if (raw_axis_ == 0) values.template set<0x2111, 1>(to_integer<std::int16_t>(kMilliG * s.ax_m_s2));
    if (raw_axis_ == 1) values.template set<0x2111, 2>(to_integer<std::int16_t>(kMilliG * s.ay_m_s2));
    if (raw_axis_ == 2) values.template set<0x2111, 3>(to_integer<std::int16_t>(kMilliG * s.az_m_s2));
    // A failed sensor stays invalid until a power cycle, also when it seems to work again. Without its parameters the mounting is unknown:
    // angles may have the wrong sign, and the computer ignores emergency messages.
    const bool valid = !failed_ && !doubtful_ && stack_.parameters_ok();
    publish_status(
        static_cast<std::uint8_t>((valid ? kValid : 0U) | (acceleration ? kAccelerationRange : 0U) | (saturated ? kGyroSaturated : 0U)));
    values.template set<0x2121>(static_cast<std::uint8_t>(values.template get<0x2121>() + 1U));
  }

  Board& board_;
  Stack stack_;
  std::array<Axis, 2> axes_{};  // alpha, beta
  Window window_{};
  Sway sway_{};
  After after_{};
  float yaw_bias_rad_s_ = 0;
  Mounting mounting_{};
  std::uint8_t raw_axis_ = 2;
  bool started_ = false, converged_ = false, failed_ = false, missing_ = false, doubtful_ = false;
  std::uint32_t failures_ = 0, start_age_ms_ = 0;
  std::uint32_t sync_age_ms_ = kAgeMax, sample_age_ms_ = 0, gap_ms_ = 0;
};

}  // namespace hoist::firmware
