// The simulated patient in a hoist that moves as recorded: the platform's motion is the input, the harness's motion the output. The loop is
// open, so an error of the patient does not send the hoist elsewhere, and the error shows at the moment at which it arises.
#pragma once

#include <vector>

#include "deploy/tools/hoist/twin/led_session.hpp"
#include "firmware/sim/patient.hpp"

namespace hoist::tool::twin {

/// What the struts would show, per step of the session: equations (1) to (3), upright = 0.
struct Response {
  std::vector<double> dx_m, dy_m, dpsi_rad;
};

[[nodiscard]] Response replay(const LedSession& session, const sim::PatientParams& patient);

}  // namespace hoist::tool::twin
