// The bus of one run of hoist-control, with the input device and the capture around it.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "control/bus/can_port.hpp"
#include "control/bus/capture.hpp"
#include "control/bus/pokeys/input_port.hpp"
#include "control/bus/step_line.hpp"
#include "control/run/options.hpp"

namespace hoist::run {

struct Ports {
  std::shared_ptr<bus::StepLine> lock_step;  // null: steps go by the steady clock
  std::unique_ptr<bus::CanPort> port;
  const bus::pokeys::InputPort* inputs = nullptr;  // both inside `port`, null without one
  const bus::Capture* capture = nullptr;
};

/// `utc_offset_ns`: what must be added to the steady clock to date the frames of a capture.
[[nodiscard]] Failure open_ports(const Options& options, std::int64_t utc_offset_ns, Ports& ports);

/// Tells once when bus, inputs or capture fail, and when bus or inputs work again.
class PortReporter {
 public:
  PortReporter(const Ports& ports, const Options& options);
  void serve();
  /// At the end: what the capture has lost.
  void report_dropped() const;

 private:
  const Ports& ports_;
  const Options& options_;
  std::string_view bus_problem_, bus_remark_;
  std::optional<std::string_view> input_problem_;  // none reported yet: a device that answers at once is reported, too
  bool capture_failed_ = false;
};

}  // namespace hoist::run
