// What a calibration step needs before it begins, and what its checks say of the parts: written a second time from control/README.md,
// DECISIONS.md (28, 29, 155) and control/contract/calibration.hpp.
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <random>
#include <string_view>

#include "control/core/modes/calibration_run.hpp"
#include "control/core/standstill.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {
namespace calibration_entry {

using contract::CalibrationStep;
using contract::ParamName;
using contract::Params;

/// Some steps look at angles, so the filters of the tilt sensors must have converged.
bool looks_at_angles(std::string_view step) {
  for (const std::string_view one : {"zero", "neutral", "gyro", "strut_length", "strut_spacing", "struts"})
    if (step == one) return true;
  return false;
}

TEST(CalibrationEntryRules, AStepBeginsOnStandbyAtRestWithEveryNode) {
  using contract::Pdo;
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  std::mt19937 random(1);
  const auto below = [&](unsigned n) { return random() % n; };
  std::uint32_t seen = 0;
  for (int i = 0; i < 1500 && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState state = hoist.state;
    Estimate& sensed = state.sensed;
    std::uint32_t wanted = 0;
    if (below(4) == 0) state.mode = static_cast<Mode>(below(static_cast<unsigned>(contract::kModes.size())));
    if (state.mode != Mode::standby && state.mode != Mode::calibrate) wanted |= refusal_bit(Refusal::not_standby);

    // Ages in control steps: three tilts, the rates, two drives, the input node. H4: a tilt is stale from 30 ms; H3, H14: lost from 50 ms.
    constexpr std::array kOldest{3, 3, 3, 3, 5, 5, 5};
    std::array<int, 7> ages{};
    for (int& age : ages) age = below(8) == 0 ? static_cast<int>(below(7)) : static_cast<int>(below(3));
    bool missing = false, settled = true;
    for (std::size_t k = 0; k < ages.size(); ++k) missing = missing || ages[k] >= kOldest[k];
    if (missing) wanted |= refusal_bit(Refusal::nodes_missing);
    TiltSensor* const tilts[] = {&sensed.left_strut, &sensed.right_strut, &sensed.base};
    DriveSensor* const drives[] = {&sensed.left_drive, &sensed.right_drive};
    std::array<int, 3> statuses{};
    for (int& status : statuses) {
      // Valid at least; converged is bit 1.
      status = below(5) == 0 ? 1 + 2 * static_cast<int>(below(16)) : 3;
      settled = settled && (status & 2) != 0;
    }
    for (int age = 7; age >= 0; --age) {
      sensed.next_tick();
      for (std::size_t k = 0; k < 3; ++k) {
        if (ages[k] != age) continue;
        contract::CanFrame frame{0, 8, 0, {}};
        contract::write_slot(frame, contract::pdo_slot(Pdo::tilt_tx1, 0x2120), statuses[k]);
        contract::write_slot(frame, contract::pdo_slot(Pdo::tilt_tx1, 0x2121), i % 250);
        tilts[k]->restart();
        tilts[k]->take_angles(frame);
      }
      if (ages[3] == age) sensed.base.take_rates({0, 8, 0, {}});
      for (std::size_t k = 0; k < 2; ++k)
        if (ages[4 + k] == age) static_cast<void>(drives[k]->take_state({0, 8, 0, {}}, 1e12));
      if (ages[6] == age) sensed.io.take_inputs({0, 2, 0, {}});
    }
    // A chassis that began again has no rates yet.
    if (ages[3] > ages[2]) wanted |= refusal_bit(Refusal::nodes_missing);

    if (below(6) == 0) state.limiter.start_from(state.params, 0.1, 0);
    sensed.odometry.standing_still = below(5) != 0;
    if (!state.limiter.at_rest() || !stands(sensed)) wanted |= refusal_bit(Refusal::moving);

    for (const contract::CalibrationStepInfo& info : contract::kCalibrationSteps) {
      const std::uint32_t settling = looks_at_angles(info.name) && !settled ? refusal_bit(Refusal::sensors_settling) : 0;
      EXPECT_EQ(calibration_refusals(state, info), wanted | settling) << info.name;
      seen |= wanted | settling;
    }
  }
  EXPECT_EQ(seen, refusal_bit(Refusal::not_standby) | refusal_bit(Refusal::nodes_missing) | refusal_bit(Refusal::moving) |
                      refusal_bit(Refusal::sensors_settling));
}

constexpr std::array kDates{0.0, 0.5, 1'790'000'000.0};
constexpr std::array kChecks{ParamName::calibrated_encoders_s, ParamName::calibrated_bumpers_s, ParamName::calibrated_struts_s};
void set(Params& params, ParamName name, double value) { contract::set_param_unchecked(params, contract::param_index(name), value); }

// H2, H7, H13.
TEST(CalibrationEntryRules, ARealHoistNeedsItsZerosAndEachCheckWithTheseParts) {
  for (const bool real : {false, true}) {
    ScriptedHoist hoist;
    hoist.real = real;
    std::uint32_t serial = 0x51;
    hoist.each([&serial](contract::Node, FakeNode& node) { node.serial = serial++; });
    ASSERT_TRUE(hoist.ready());
    CoreState state = hoist.state;
    const auto own = static_cast<double>(state.master.nodes_id());
    for (const double zeroed : kDates)
      for (const double encoders : kDates)
        for (const double bumpers : kDates)
          for (const double struts : kDates)
            for (const double id : {0.0, own, own + 1}) {
              SCOPED_TRACE(testing::Message() << real << ' ' << zeroed << ' ' << encoders << ' ' << bumpers << ' ' << struts << ' '
                                              << id - own);
              Params& p = state.params;
              p.calibrated_zero_s = zeroed;
              p.calibrated_encoders_s = encoders;
              p.calibrated_bumpers_s = bumpers;
              p.calibrated_struts_s = struts;
              p.calibrated_nodes_id = id;
              EXPECT_EQ(calibration_valid(state), !real || zeroed > 0);
              EXPECT_EQ(parts_checked(state), !real || (id == own && encoders > 0 && bumpers > 0 && struts > 0));
            }
  }
}

// A check names the parts that it was made with; other parts than before make the other two due.
TEST(CalibrationEntryRules, ACheckSignsItsParts) {
  ScriptedHoist hoist;
  hoist.real = true;
  hoist.each([](contract::Node, FakeNode& node) { node.serial = 0x77; });
  ASSERT_TRUE(hoist.ready());
  CoreState state = hoist.state;
  const auto own = static_cast<double>(state.master.nodes_id());
  for (const contract::CalibrationStepInfo& info : contract::kCalibrationSteps)
    for (const double id : {0.0, own, own - 1}) {
      SCOPED_TRACE(testing::Message() << info.name << ' ' << id - own);
      state.in_mode.calibration.step = info.step;
      set(state.params, ParamName::calibrated_nodes_id, id);
      std::map<std::size_t, double> wanted, signed_rows;
      const bool check =
          info.step == CalibrationStep::encoders || info.step == CalibrationStep::bumpers || info.step == CalibrationStep::struts;
      if (check && id != own) {
        wanted[contract::param_index(ParamName::calibrated_nodes_id)] = own;
        for (const ParamName other : kChecks)
          if (other != info.date) wanted[contract::param_index(other)] = 0;
      }
      Staging rows;
      sign_parts(state, rows);
      for (const Staging::Row& row : rows.rows) signed_rows[row.index] = row.value;
      EXPECT_EQ(signed_rows, wanted);
      EXPECT_EQ(rows.rows.size(), wanted.size());
    }
}

}  // namespace calibration_entry
}  // namespace
}  // namespace hoist::core::test
