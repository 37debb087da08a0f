// The state of a calibration step (advanced by modes/calibration_run.hpp).
#pragma once
#include <cstdint>

#include "control/contract/calibration.hpp"
#include "control/core/calibrate/bumper_check.hpp"
#include "control/core/calibrate/pairs.hpp"
#include "control/core/calibrate/still_window.hpp"
#include "control/core/calibrate/strut_check.hpp"
#include "control/core/calibrate/umbmark.hpp"
#include "control/core/command/staging.hpp"
#include "control/core/types.hpp"

namespace hoist::core {

/// Timeout without activity: 60 s (SOURCES 2.3).
inline constexpr std::uint32_t kCalibrationIdleTicks = 6000;
/// Ten seconds for the operator to bring everything to rest.
inline constexpr std::uint32_t kCalibrationRestTicks = 1000;

/// The measured quantities: six angles as sent, positions of both wheels in counts, turn rate.
inline constexpr std::size_t kCalibrationChannels = 9;

struct Calibration {
  contract::CalibrationStep step = contract::CalibrationStep::none;
  contract::CalibrationPhase phase = contract::CalibrationPhase::none;
  contract::CalibrationReason reason = contract::CalibrationReason::none;
  std::uint8_t done_percent = 0;
  float value = 0;  // what the screen shows while it is measured

  std::uint32_t idle_ticks = 0, restless_ticks = 0;
  StillWindow<kCalibrationChannels> still, first_half;
  std::int64_t left_counts = 0, right_counts = 0;  // since the step began
  std::int64_t left_from = 0, right_from = 0;      // where the measured distance or turn began
  bool started = false;                            // that place is known
  double turned_rad = 0;                           // by the gyroscope, since that place
  bool turning = false;                            // second part of the wheel sensors' step
  double entered = 0;                              // what the operator measured, waiting for rest
  bool waiting = false;
  MeasuredPairs pairs;
  SquareMean left_squares, right_squares;
  double side_m = 0;
  BumperCheck bumpers;
  StrutCheck struts;
  StrutCheck::Angles upright{};  // at rest, where the check of the struts began
  bool used = false;
  Staging result;  // parameters as they would become, dates not included
};

}  // namespace hoist::core
