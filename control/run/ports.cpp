#include "control/run/ports.hpp"

#include <cstring>
#include <iostream>
#include <string>
#include <utility>

#include "control/bus/slcan.hpp"
#include "control/run/real_time.hpp"

namespace hoist::run {
namespace {

Failure open_bus(const Options& options, Ports& ports) {
  std::string error;
  if (const std::string socket = lock_step_socket(options.bus); !socket.empty()) {
    ports.lock_step = std::make_shared<bus::StepLine>(socket);
    ports.port = std::make_unique<bus::SlcanPort>(ports.lock_step);
  } else {
    ports.port = bus::open_port(options.bus, error, bus::PortUse::core);
  }
  return ports.port ? Failure{} : Failure{kBadArguments, error};
}

Failure add_inputs(const Options& options, Ports& ports) {
  if (options.inputs == "can") return {};
  bus::pokeys::InputOptions inputs;
  if (const std::string problem = bus::pokeys::parse_inputs(options.inputs, inputs); !problem.empty())
    return {kBadArguments, "--inputs: " + problem};
  inputs.at_thread_start = [real_time = options.real_time] { static_cast<void>(take_row(ThreadId::inputs, real_time, kNoCpu)); };
  auto port = std::make_unique<bus::pokeys::InputPort>(std::move(ports.port), std::move(inputs));
  ports.inputs = port.get();
  ports.port = std::move(port);
  return {};
}

Failure add_capture(const Options& options, std::int64_t utc_offset_ns, Ports& ports) {
  if (options.capture.empty()) return {};
  constexpr std::string_view kSocketCan = "socketcan:";
  const std::string interface = options.bus.starts_with(kSocketCan) ? options.bus.substr(kSocketCan.size()) : "can0";
  std::string error;
  std::unique_ptr<bus::Capture> capture = bus::Capture::open(options.capture, interface, utc_offset_ns, error);
  if (!capture) return {kBadComputer, "--capture: " + error};
  ports.capture = capture.get();
  ports.port = std::make_unique<bus::CapturePort>(std::move(ports.port), std::move(capture));
  return {};
}

}  // namespace

Failure open_ports(const Options& options, std::int64_t utc_offset_ns, Ports& ports) {
  if (Failure failure = open_bus(options, ports)) return failure;
  if (Failure failure = add_inputs(options, ports)) return failure;
  return add_capture(options, utc_offset_ns, ports);
}

PortReporter::PortReporter(const Ports& ports, const Options& options)
    : ports_(ports), options_(options), bus_problem_(ports.port->problem()) {
  if (!bus_problem_.empty()) std::cout << "hoist-control: bus: " << bus_problem_ << std::endl;
}

void PortReporter::serve() {
  if (const std::string_view now = ports_.port->problem(); now != bus_problem_) {
    bus_problem_ = now;
    std::cout << "hoist-control: bus: " << (now.empty() ? "up" : now) << std::endl;
  }
  if (const std::string_view now = ports_.port->remark(); now != bus_remark_) {
    bus_remark_ = now;
    if (!now.empty()) std::cout << "hoist-control: bus: " << now << std::endl;
  }
  if (ports_.inputs != nullptr)
    if (const std::string_view now = ports_.inputs->input_problem(); now != input_problem_) {
      input_problem_ = now;
      std::cout << "hoist-control: inputs: " << (now.empty() ? "come from the PoKeys" : now) << std::endl;
    }
  if (ports_.capture != nullptr && ports_.capture->failure() != 0 && !capture_failed_) {
    capture_failed_ = true;
    std::cerr << "hoist-control: " << options_.capture << ": " << std::strerror(ports_.capture->failure()) << "; nothing more is captured"
              << std::endl;
  }
}

void PortReporter::report_dropped() const {
  if (ports_.capture != nullptr && ports_.capture->dropped() > 0)
    std::cerr << "hoist-control: " << ports_.capture->dropped() << " frames are missing in " << options_.capture << std::endl;
}

}  // namespace hoist::run
