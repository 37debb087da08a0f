// The off-line gain of the tilt filter: the three steps under (12), page 5, iterated until nothing changes. A tool for engineers: with the
// values (13) it returns (0.028434446, -0.034849059), the solution of (13), not the printed (14) (D20).
#pragma once

#include <cmath>

namespace hoist::law {

/// One axis: the paper's four-state filter is two of these side by side, because A, C, V and N couple nothing across.
template <typename Real>
struct KalmanGainProblem {
  Real v_angle{Real(0.1)};  ///< process variance of the angle, rad^2 (13)
  Real v_bias{Real(1)};     ///< process variance of the bias, rad^2/s^2 (13)
  Real n_angle{Real(800)};  ///< measurement variance (13)
  Real dt_s{Real(0.01)};
  Real p0_angle{Real(1)};  ///< start of the iteration; the answer does not depend on it
  Real p0_bias{Real(1)};
};

template <typename Real>
struct KalmanGainSolution {
  Real k_angle{};
  Real k_bias{};
  int steps{};
  bool converged{false};  ///< false: unusable input or kKalmanGainStepLimit reached; the gain must not be used
};

inline constexpr int kKalmanGainStepLimit = 1'000'000;
/// The gain must be constant within this tolerance for this many steps in a row: a single step may be coincidence.
inline constexpr int kKalmanGainQuietSteps = 8;

template <typename Real>
[[nodiscard]] inline KalmanGainSolution<Real> solve_kalman_gain(const KalmanGainProblem<Real>& problem) {
  const auto positive = [](Real x) { return x > Real(0) && std::isfinite(x); };
  const auto not_negative = [](Real x) { return x >= Real(0) && std::isfinite(x); };
  if (!not_negative(problem.v_angle) || !positive(problem.v_bias) || !positive(problem.n_angle) || !positive(problem.dt_s) ||
      !not_negative(problem.p0_angle) || !not_negative(problem.p0_bias)) {
    return {};
  }
  const Real dt = problem.dt_s;
  const Real quiet = sizeof(Real) >= 8 ? Real(1e-14) : Real(1e-6);
  Real p11 = problem.p0_angle;
  Real p12 = Real(0);
  Real p22 = problem.p0_bias;
  KalmanGainSolution<Real> solution;
  int quiet_steps = 0;
  for (int step = 1; step <= kKalmanGainStepLimit; ++step) {
    // Step 1: P* = A P A^T + V with A = [1 -dt; 0 1].
    const Real s11 = p11 - Real(2) * dt * p12 + dt * dt * p22 + problem.v_angle;
    const Real s12 = p12 - dt * p22;
    const Real s22 = p22 + problem.v_bias;
    // Step 2: K = P* C^T / (C P* C^T + N) with C = [1 0].
    const Real k_angle = s11 / (s11 + problem.n_angle);
    const Real k_bias = s12 / (s11 + problem.n_angle);
    // Step 3: P = P* - K C P*.
    p11 = s11 - k_angle * s11;
    p12 = s12 - k_angle * s12;
    p22 = s22 - k_bias * s12;
    if (!std::isfinite(k_angle) || !std::isfinite(k_bias)) return {};
    const bool still = std::fabs(k_angle - solution.k_angle) <= quiet * std::fabs(k_angle) &&
                       std::fabs(k_bias - solution.k_bias) <= quiet * std::fabs(k_bias);
    solution.k_angle = k_angle;
    solution.k_bias = k_bias;
    solution.steps = step;
    quiet_steps = still ? quiet_steps + 1 : 0;
    if (quiet_steps >= kKalmanGainQuietSteps) {
      solution.converged = true;
      return solution;
    }
  }
  return solution;
}

}  // namespace hoist::law
