// Limiter and safety gate are independent implementations of the same limits. For all allowed parameters, every legal motion and every stop
// must pass the gate: a refused stop would turn a ramp into a jolt.
#include <gtest/gtest.h>

#include <random>

#include "control/core/output/limiter.hpp"
#include "control/core/output/safety_gate.hpp"
#include "control/core/types.hpp"

namespace hoist::core {
namespace {

namespace canopen = contract::canopen;
using contract::Mode;
using contract::ParamName;

class Motion {
 public:
  explicit Motion(const contract::Params& params) : params_(params), derived_(derive(params)) {}

  // One step; false when the gate does not let the pair of frames pass.
  bool step(Mode mode, Braking braking, double speed_m_s, double yaw_rate_rad_s) {
    limiter_.step(params_, braking, speed_m_s, yaw_rate_rad_s, false, kTick_s);
    const WheelCommand wheels = mix_wheels(limiter_.speed_m_s(), limiter_.yaw_rate_rad_s(), derived_);
    const GateView view{mode, false, false, true, false, 0};
    return gate_.judge_drives(command(contract::Node::drive_left, wheels.left_raw), command(contract::Node::drive_right, wheels.right_raw),
                              view, params_, derived_, kTick_s);
  }
  [[nodiscard]] bool at_rest() const { return limiter_.at_rest(); }
  [[nodiscard]] const Limiter& limiter() const { return limiter_; }

 private:
  static contract::CanFrame command(contract::Node node, std::int32_t raw) {
    contract::CanFrame frame{contract::pdo_cob_id(contract::Pdo::drive_rx1, node), 6, 0, {}};
    contract::write_slot(frame, contract::pdo_slot(contract::Pdo::drive_rx1, 0x6040), canopen::drive::kEnable);
    contract::write_slot(frame, contract::pdo_slot(contract::Pdo::drive_rx1, 0x60FF), raw);
    return frame;
  }

  contract::Params params_;
  Derived derived_;
  Limiter limiter_;
  SafetyGate gate_;
};

TEST(Stops, H1_H13_TheGateLetsEveryLegalMotionAndEveryStopPass) {
  std::mt19937 random(4711);
  const auto between = [&random](double low, double high) { return low + (high - low) * static_cast<double>(random()) / 4294967295.0; };
  for (int round = 0; round < 2000; ++round) {
    contract::Params params;
    for (const ParamName name : {ParamName::speed_m_s_max, ParamName::yaw_rate_rad_s_max, ParamName::acceleration_m_s2_max,
                                 ParamName::jerk_m_s3_max, ParamName::yaw_acceleration_rad_s2_max, ParamName::speed_cap_norm,
                                 ParamName::protective_deceleration_m_s2, ParamName::bumper_deceleration_m_s2, ParamName::track_width_m}) {
      const contract::ParamInfo& info = contract::kParams[contract::param_index(name)];
      if (round % 2 == 1) contract::set_param_unchecked(params, contract::param_index(name), between(info.min, info.max));
    }
    Motion motion(params);
    for (int leg = 0; leg < 3; ++leg) {
      const double speed_m_s = between(-1.0, 1.0), yaw_rate_rad_s = between(-1.5, 1.5);
      for (int i = static_cast<int>(between(1, 150)); i > 0; --i)
        ASSERT_TRUE(motion.step(Mode::remote, Braking::none, speed_m_s, yaw_rate_rad_s)) << "round " << round;
    }
    const auto braking = static_cast<Braking>(1 + round % 4);
    const Mode mode = braking >= Braking::protective ? Mode::protective_stop : Mode::remote;
    const double from_m_s = motion.limiter().speed_m_s(), turn_rad_s = motion.limiter().yaw_rate_rad_s();
    // The slowest allowed turn ramp takes 8.7 s from the fastest turn.
    int steps = 0;
    for (; steps < 1000 && !motion.at_rest(); ++steps)
      ASSERT_TRUE(motion.step(mode, braking, 0.6, 0.5)) << "round " << round << ", braking " << static_cast<int>(braking) << " from "
                                                        << from_m_s << " m/s and " << turn_rad_s << " rad/s";
    ASSERT_TRUE(motion.at_rest());
  }
}

}  // namespace
}  // namespace hoist::core
