#include "control/run/control_loop.hpp"

#include "control/contract/check.hpp"
#include "control/core/serve/param_keeper.hpp"
#include "control/core/supervise/supervisor.hpp"
#include "control/publish/seq_cell.hpp"

namespace hoist::run {

namespace {
// Where a run begins to count the versions of its parameters, so that what was made for those of another run is refused (H27). 31 bits: the count
// does not come round to 0, which is no version.
std::uint64_t first_version(const publish::CoreLink& link) {
  const std::uint64_t run = contract::hash_number(contract::hash_number(contract::kHashStart, link.start_time_ns()), link.start_utc_ns());
  return 1 + ((run ^ run >> 32U) & 0x7FFFFFFFU);
}
}  // namespace

ControlLoop::ControlLoop(bus::CanPort& port, publish::CoreLink& link, const contract::Params& initial, const core::StopHistory& earlier)
    : port_(port), link_(link), publisher_(link) {
  [[maybe_unused]] const bool accepted = core::load_params(state_, initial);
  core::restore_stops(state_, earlier);
  state_.parameter_version = first_version(link);
  publish_params();
}

void ControlLoop::step(const Step& step) noexcept {
  core::TickInputs inputs;
  inputs.tick = step.tick;
  inputs.time_ns = step.time_ns;
  inputs.wake_lateness_s = static_cast<float>(step.wake_lateness_ns) * 1e-9F;
  inputs.previous_duration_s = static_cast<float>(step.previous_duration_ns) * 1e-9F;
  if (lateness_.add(step.wake_lateness_ns, step.previous_duration_ns)) {
    loop_.lateness_p50_s = lateness_.p50_s();
    loop_.lateness_p99_s = lateness_.p99_s();
    loop_.lateness_max_s = lateness_.max_s();
    link_.publish_loop(lateness_.report());
  }
  loop_.page_faults = page_faults_.load(std::memory_order_relaxed);
  inputs.loop = loop_;

  const std::size_t received = port_.receive(frames_, step.time_ns);
  inputs.frames = {frames_.data(), received};
  const bus::PortCounters& counters = port_.counters();
  inputs.bus.refused = counters.refused;
  inputs.bus.send_refused = counters.send_refused;
  inputs.bus.reopened = counters.reopened;
  inputs.bus.overflows = counters.overflows;
  inputs.bus.errors = counters.bus_errors;
  inputs.bus.tx_errors = counters.tx_errors;
  inputs.bus.rx_errors = counters.rx_errors;
  inputs.bus.state = static_cast<std::uint8_t>(counters.state);
  inputs.bus_up = port_.up();

  std::size_t commands = 0;
  std::uint64_t lost = 0;
  if (link_.begin()) {
    commands = link_.read_commands({commands_.data(), contract::kCommandSlots}, lost);
    inputs.drive_fresh = link_.read_drive(inputs.drive);
    inputs.server_heartbeat = link_.heartbeat();
    inputs.server_life = link_.server_life();
    link_.end();
  }
  // The program is ending; or a server wrote over commands that were not read, which no sound one does: a STOP may have been among them.
  // Last, so that nothing in this step comes after it.
  if (step.stop || lost > 0) {
    commands_[commands] = contract::Command{};
    commands_[commands++].kind = contract::CommandKind::stop;
  }
  inputs.commands = {commands_.data(), commands};

  publisher_.before(state_, inputs);
  core::tick(state_, inputs, core::kTick_s, outputs_);

  const std::size_t sent = port_.send({outputs_.frames.data(), outputs_.frames.size()}, step.time_ns);
  if (outputs_.params_changed) publish_params();
  if (outputs_.stops_changed) publish::seq_write(stops_, stops_written_++, core::stop_history(state_));
  publisher_.after(inputs, outputs_, sent);
}

bool ControlLoop::read_stops(core::StopHistory& history, std::uint64_t& seen) const noexcept {
  core::StopHistory newest;
  const std::uint64_t sequence = publish::seq_read_retry(stops_, newest);
  if (sequence == 0 || sequence == seen) return false;
  history = newest;
  seen = sequence;
  return true;
}

void ControlLoop::set_granted(std::uint8_t priority, std::uint8_t cpu, bool memory_locked) noexcept {
  loop_.priority = priority;
  loop_.cpu = cpu;
  loop_.memory_locked = memory_locked;
}

void ControlLoop::publish_params() noexcept {
  contract::ParamsInForce params;
  params.version = state_.parameter_version;
  params.defaults_after_damage = state_.defaults_after_damage ? 1U : 0U;
  for (std::size_t i = 0; i < contract::kParamCount; ++i) {
    params.values[i] = contract::get_param(state_.params, i);
    params.kept[i] = core::kept_param(state_, i);
  }
  link_.publish_params(params);
}

}  // namespace hoist::run
