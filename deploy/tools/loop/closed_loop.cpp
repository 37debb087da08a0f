#include "deploy/tools/loop/closed_loop.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "control/bus/slcan.hpp"

namespace hoist::loop {
namespace {

constexpr int kWorldStepsPerTick = 10;
/// Driving commands come at 25 Hz (design: every 40 ms while held).
constexpr std::uint64_t kTicksPerCommand = 4;
constexpr std::uint32_t kNotKnown = 0;
/// Most driving commands in transit: four seconds' worth.
constexpr std::size_t kLinkMax = 100;

/// Time this thread has had a processor: what the loop costs, however busy the machine is.
double core_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// 1 Mbaud, ten bits a character.
constexpr std::size_t kSerialPerMillisecond = 100;
constexpr std::string_view kGatewaySetup = "\rC\rS5\rO\r";

sim::WorldOptions attached(const ClosedLoopOptions& options) {
  sim::WorldOptions world = options.world;
  world.host_in_process = !options.through_gateway;
  return world;
}

}  // namespace

ClosedLoop::ClosedLoop(const ClosedLoopOptions& options)
    : world_(attached(options)),
      params_(options.params),
      through_gateway_(options.through_gateway),
      core_(std::make_unique<core::CoreState>(options.params)),
      outputs_(std::make_unique<core::TickOutputs>()) {
  commands_.reserve(64);
  events_.reserve(4096);
  if (through_gateway_) to_gateway_ = kGatewaySetup;
}

void ClosedLoop::restart_core() {
  *core_ = core::CoreState(params_);
  *outputs_ = {};
  ticks_ = 0;
  // A restarted core: the server attaches again, and its command numbers restart.
  sequence_ = 0;
  drive_sequence_ = 0;
  commands_.clear();
  link_.clear();
  // It reopens the bus: earlier frames are dropped.
  while (receive() > 0) {
  }
  core_runs_ = true;
}

void ClosedLoop::restart_server() {
  ++server_life_;
  heartbeat_ = 0;
  sequence_ = 0;
  drive_sequence_ = 0;
  commands_.clear();
  link_.clear();
  server_runs_ = true;
}

void ClosedLoop::cut_link(bool cut) {
  link_cut_ = cut;
  if (cut) link_.clear();
}

void ClosedLoop::send(const contract::CanFrame& frame) {
  if (!bus_up_) return;
  if (!through_gateway_) {
    (void)world_.host_send(frame);
    return;
  }
  std::array<char, contract::kSlcanLineMax> line{};
  const std::size_t length = contract::slcan_encode(frame, line);
  if (noise_)
    for (char& c : std::span(line).first(length)) noise_(c);
  to_gateway_.append(line.data(), length);
}

std::size_t ClosedLoop::receive() {
  if (!through_gateway_) return world_.host_receive(frames_);
  return std::exchange(frames_count_, 0);
}

void ClosedLoop::move_serial_line() {
  if (!to_gateway_.empty()) {
    const std::size_t sent =
        world_.uart_write(std::span<const char>(to_gateway_).first(std::min(kSerialPerMillisecond, to_gateway_.size())));
    to_gateway_.erase(0, sent);
  }
  std::array<char, kSerialPerMillisecond> piece{};
  const std::size_t got = world_.uart_read(piece);
  if (noise_)
    for (char& c : std::span(piece).first(got)) noise_(c);
  decoder_.feed(std::span<const char>(piece).first(got), [this](const contract::SlcanLine& line) {
    if (line.kind == contract::SlcanKind::frame && frames_count_ < kFramesMax) frames_[frames_count_++] = line.frame;
    if (line.kind == contract::SlcanKind::bel) {
      ++gateway_refusals_;
    } else if (line.kind == contract::SlcanKind::frame || line.kind == contract::SlcanKind::ack) {
      gateway_refusals_ = 0;
    }
  });
  // As the port of the product does: noise may have closed the bus.
  if (gateway_refusals_ < bus::SlcanPort::kRefusalsBeforeSetup) return;
  gateway_refusals_ = 0;
  to_gateway_ += kGatewaySetup;
}

void ClosedLoop::drive_with_stick(core::TickInputs& inputs) {
  if ((stick_held_ && inputs.tick % kTicksPerCommand == 0) || last_command_) {
    contract::DriveCommand command;
    command.lease_epoch = record().lease_epoch;
    command.client = kClient;
    command.sequence = ++drive_sequence_;
    command.echo_time_ns = record().time_ns;
    command.speed_norm = stick_held_ ? speed_norm_ : 0.0;
    command.yaw_norm = stick_held_ ? yaw_norm_ : 0.0;
    command.held = stick_held_ ? 1 : 0;
    last_command_ = false;
    if (!link_cut_ && link_.size() < kLinkMax) link_.push_back({inputs.tick + (link_delay_ ? link_delay_() : 0U), command});
  }
  // A hanging server forwards nothing.
  if (server_runs_ && !link_stalled_ && !link_.empty() && link_.front().due_tick <= inputs.tick) {
    inputs.drive_fresh = true;
    inputs.drive = link_.front().command;
    link_.pop_front();
  }
  if (std::exchange(stranger_drives_, false)) {
    inputs.drive_fresh = true;
    inputs.drive = stranger_drive_;
  }
}

void ClosedLoop::step() {
  if (core_runs_) {
    core::TickInputs inputs;
    inputs.tick = ticks_++;
    inputs.time_ns = kClockStart_ns + world_.time_ns();
    const std::size_t got = receive();
    inputs.frames = std::span<const contract::CanFrame>(frames_).first(bus_up_ ? got : 0);
    inputs.bus_up = bus_up_;
    inputs.commands = commands_;
    if (server_runs_) ++heartbeat_;
    inputs.server_heartbeat = heartbeat_;
    inputs.server_life = server_life_;
    inputs.wake_lateness_s = static_cast<float>(lateness_s_);
    lateness_s_ = 0.0;
    drive_with_stick(inputs);
    if (see_inputs_) see_inputs_(inputs);
    core::tick(*core_, inputs, core::kTick_s, *outputs_);
    if (break_) break_(*core_, *outputs_);
    if (see_step_) see_step_(inputs, *outputs_);
    commands_.clear();
    for (const contract::CanFrame& frame : outputs_->frames) {
      send(frame);
      if (see_) see_(frame);
    }
    for (const contract::Event& event : outputs_->events) events_.push_back(event);
    // A cheap digest of the record: its 64-bit words, each mixed in.
    const auto* bytes = reinterpret_cast<const char*>(&outputs_->record);
    for (std::size_t at = 0; at + 8 <= sizeof(contract::TickRecord); at += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, bytes + at, 8);
      record_hash_ = (record_hash_ ^ word) * 0x9E3779B97F4A7C15ULL;
      record_hash_ ^= record_hash_ >> 29;
    }
  }
  if (!core_runs_) ++ticks_;  // steps follow the clock: those of a held core are left out
  for (int i = 0; i < kWorldStepsPerTick; ++i) {
    world_.advance_1ms();
    if (through_gateway_) move_serial_line();
    if (see_millisecond_) see_millisecond_();
  }
}

void ClosedLoop::run(double seconds) {
  const auto steps = std::lround(seconds / core::kTick_s);
  for (long i = 0; i < steps; ++i) step();
}

bool ClosedLoop::run_until(const std::function<bool()>& done, double at_most_s) {
  const auto steps = std::lround(at_most_s / core::kTick_s);
  for (long i = 0; i < steps && !done(); ++i) step();
  return done();
}

std::uint32_t ClosedLoop::ask(contract::CommandKind kind, std::uint32_t a, double v0, double v1, double v2, std::uint32_t b) {
  return ask_as(kClient, kind, a, v0, v1, v2, b);
}

std::uint32_t ClosedLoop::ask_as(std::uint32_t client, contract::CommandKind kind, std::uint32_t a, double v0, double v1, double v2,
                                 std::uint32_t b) {
  contract::Command command;
  command.sequence = ++sequence_;
  command.kind = kind;
  command.request_id = ++requests_;
  command.client = client;
  command.lease_epoch = ticks_ > 0 ? record().lease_epoch : kNotKnown;
  command.a = a;
  command.b = b;
  command.v0 = v0;
  command.v1 = v1;
  command.v2 = v2;
  if (kind == contract::CommandKind::stage_parameter) {
    if (b == 0) seal_ = {};
    seal_.add(a, v0);
  }
  if (kind == contract::CommandKind::commit_parameters) command.bits = seal_.value();
  commands_.push_back(command);
  return requests_;
}

bool ClosedLoop::may_start() {
  if (!run_until([this] { return mode() == contract::Mode::standby; }, 10.0)) return false;
  if (record().lease_holder != kClient) ask(contract::CommandKind::take_lease);
  return run_until([this] { return record().blocked_bits == 0; }, 10.0);
}

bool ClosedLoop::start_guided(const contract::GuidedPath& path) {
  if (!may_start()) return false;
  contract::Command command;
  contract::put_guided(command, path);
  ask(command.kind, command.a, command.v0, command.v1, command.v2, command.b);
  return run_until([this] { return mode() == contract::Mode::guided; }, 1.0);
}

bool ClosedLoop::start(contract::Mode mode) {
  if (mode == contract::Mode::guided) return start_guided({contract::GuidedShape::straight, false, 2.0, 0, 0.2, 1});
  if (!may_start()) return false;
  ask(contract::CommandKind::request_mode, static_cast<std::uint32_t>(mode));
  return run_until([this, mode] { return this->mode() == mode; }, 1.0);
}

void ClosedLoop::hold_stick(double speed_norm, double yaw_norm) {
  speed_norm_ = speed_norm;
  yaw_norm_ = yaw_norm;
  stick_held_ = true;
}

void ClosedLoop::let_go() {
  stick_held_ = false;
  last_command_ = true;
}

bool ClosedLoop::fault(contract::Fault which) const { return ((record().fault_bits >> contract::fault_info(which).bit) & 1U) != 0; }

bool ClosedLoop::ever_raised(contract::Fault which) const {
  return std::any_of(events_.begin(), events_.end(), [which](const contract::Event& event) {
    return event.kind == contract::EventKind::fault_raised && event.code == static_cast<std::uint32_t>(which);
  });
}

std::uint64_t ClosedLoop::digest() const { return record_hash_ ^ world_.digest(); }

double simulated_seconds_per_second(double virtual_s) {
  ClosedLoopOptions options;
  options.world.scenario = sim::find_scenario("figure-eight");
  ClosedLoop loop(options);
  // The start is simulated but not measured.
  if (!loop.start(contract::Mode::user)) return 0.0;
  const double begin_s = core_seconds();
  loop.run(virtual_s);
  const double took_s = core_seconds() - begin_s;
  return took_s > 0.0 ? virtual_s / took_s : 0.0;
}

}  // namespace hoist::loop
