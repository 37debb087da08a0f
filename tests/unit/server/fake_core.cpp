#include "tests/unit/server/fake_core.hpp"

#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "control/contract/calibration.hpp"

namespace hoist::test {

using namespace contract;

namespace {
std::uint64_t steady_ns() {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count());
}
constexpr int kStep_ms = 5;
}  // namespace

FakeCore::FakeCore(const std::string& socket_path) {
  std::string error;
  const auto utc = static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count());
  link_ = publish::CoreLink::create(socket_path, steady_ns(), utc, error);
  if (!link_) throw std::runtime_error(error);
  params_.version = 1;
  for (std::size_t i = 0; i < kParamCount; ++i) params_.values[i] = kParams[i].default_value;
  link_->publish_params(params_);
  link_->publish_loop({});
  record_.mode = static_cast<std::uint8_t>(Mode::standby);
  record_.standing_still = 1;
  record_.simulated = 1;
  record_.parameter_version = 1;
  record_.time_ns = steady_ns();
  thread_ = std::thread([this] { main(); });
}

FakeCore::~FakeCore() {
  ending_ = true;
  thread_.join();
}

void FakeCore::main() {
  while (!ending_) {
    // Waits for a server to attach, and so sets the pace.
    const std::string said = link_->serve(kStep_ms);
    step();
  }
}

void FakeCore::step() {
  const std::lock_guard lock(mutex_);
  if (link_->begin()) {
    std::array<Command, 64> taken;
    std::uint64_t lost = 0;
    const std::size_t count = link_->read_commands(taken, lost);
    for (std::size_t i = 0; i < count; ++i) {
      commands_.push_back(taken[i]);
      if (!muted_) take(taken[i]);
    }
    DriveCommand drive;
    if (link_->read_drive(drive)) drive_ = drive;
  }
  link_->end();
  if (bus_) {
    for (const CanFrame& frame : bus_(service_frames_)) {
      BusRecord record;
      record.id = frame.id;
      record.dlc = frame.dlc;
      record.data = std::bit_cast<std::uint64_t>(frame.data);
      frames_.push_back(record);
    }
    service_frames_.clear();
  }
  for (const BusRecord& frame : frames_) link_->publish_bus(frame);
  frames_.clear();
  for (std::size_t i = 0; i <= skip_; ++i) publish_tick();
  store();
  skip_ = 0;
  skipped_.notify_all();
  for (Event& event : events_) {
    event.tick = record_.tick;
    event.time_ns = record_.time_ns;
    link_->publish_event(event);
  }
  events_.clear();
}

void FakeCore::store() {
  contract::ParamsInForce in_force;
  const std::uint64_t sequence = link_->params(in_force);
  if (!store_held_) store_ = {.stored = sequence, .tried = sequence};
  if (store_.problem != StoreProblem::none) store_.tried = sequence;
  link_->publish_store(store_);
}

void FakeCore::publish_tick() {
  ++record_.tick;
  record_.time_ns += 10'000'000;
  record_.x_m += 0.001F;
  record_.distance_m += 0.001F;
  record_.fused_x_m = record_.x_m;
  record_.fused_y_m = record_.y_m;
  record_.fused_psi_rad = record_.psi_rad;
  if (each_) each_(record_);
  link_->publish_tick(record_);
  published_.push_back(record_);
}

void FakeCore::answer(const Command& command, std::uint32_t bits, std::uint32_t item) {
  Event event;
  event.request_id = command.request_id;
  event.client = command.client;
  event.item = item;
  event.kind = bits == 0 ? EventKind::command_done : EventKind::command_refused;
  event.bits = bits;
  if (bits != 0) event.code = static_cast<std::uint32_t>(std::countr_zero(bits));
  events_.push_back(event);
}

void FakeCore::take(const Command& c) {
  const bool holds = record_.lease_holder != 0 && record_.lease_holder == c.client && record_.lease_epoch == c.lease_epoch;
  const auto mode = static_cast<Mode>(record_.mode);
  const bool ends = c.kind == CommandKind::request_mode && c.a == static_cast<std::uint32_t>(Mode::standby);
  if (const std::uint64_t echo = echo_of(c); echo != 0 && !ends && !is_fresh_echo(echo, record_.time_ns, kEchoAge_s_max))
    return answer(c, refusal_bit(Refusal::stale_command));
  switch (c.kind) {
    case CommandKind::stop:
      record_.mode = static_cast<std::uint8_t>(Mode::protective_stop);
      service_ = false;
      return answer(c, 0);
    case CommandKind::acknowledge:
      if (!holds) return answer(c, refusal_bit(Refusal::no_lease));
      record_.mode = static_cast<std::uint8_t>(Mode::standby);
      return answer(c, 0);
    case CommandKind::take_lease: {
      const bool other = record_.lease_holder != 0 && record_.lease_holder != c.client;
      const bool given = c.a == kHandOver && record_.lease_holder != 0 && c.lease_epoch == record_.lease_epoch;
      if ((c.a == kHandOver && !given) || (other && c.a != kTakeOver && !given)) return answer(c, refusal_bit(Refusal::no_lease));
      if (other && kModes[record_.mode].moving) return answer(c, refusal_bit(Refusal::moving));
      record_.lease_holder = c.client;
      ++record_.lease_epoch;
      Event event;
      event.kind = EventKind::lease_changed;
      event.client = c.client;
      event.code = record_.lease_epoch;
      events_.push_back(event);
      return answer(c, 0);
    }
    case CommandKind::release_lease:
      if (c.client != record_.lease_holder) return answer(c, refusal_bit(Refusal::no_lease));
      record_.lease_holder = 0;
      ++record_.lease_epoch;
      return answer(c, 0);
    case CommandKind::request_mode:
      if (!holds && !(c.a == static_cast<std::uint32_t>(Mode::standby) && kModes[record_.mode].moving))
        return answer(c, refusal_bit(Refusal::no_lease));
      if (c.a != static_cast<std::uint32_t>(Mode::standby) && mode != Mode::standby) return answer(c, refusal_bit(Refusal::not_standby));
      record_.mode = static_cast<std::uint8_t>(c.a);
      return answer(c, 0);
    case CommandKind::begin_guided:
      if (!holds) return answer(c, refusal_bit(Refusal::no_lease));
      if (mode != Mode::standby) return answer(c, refusal_bit(Refusal::not_standby));
      record_.mode = static_cast<std::uint8_t>(Mode::guided);
      return answer(c, 0);
    case CommandKind::stage_parameter: {
      if (c.b == 0) {
        staged_.clear();
        staging_broken_ = false;
      }
      const auto index = find_param_id(c.a);
      if (!index || check_param(*index, c.v0) != ParamCheck::ok || staged_.size() != c.b) {
        staging_broken_ = true;
        return answer(c, refusal_bit(Refusal::out_of_range), c.a);
      }
      staged_.emplace_back(*index, c.v0);
      return answer(c, 0);
    }
    case CommandKind::commit_parameters: {
      trial_s_ = c.v0;
      if (staging_broken_ || staged_.size() != c.a) return answer(c, refusal_bit(Refusal::out_of_order));
      if (const auto made_for = static_cast<std::uint32_t>(c.bits >> 32U); made_for != 0 && made_for != record_.parameter_version)
        return answer(c, refusal_bit(Refusal::set_outdated));
      for (const auto& [index, value] : staged_)
        if (kParams[index].edit == EditRule::stopped && mode != Mode::standby)
          return answer(c, refusal_bit(Refusal::only_when_stopped), kParams[index].id);
      for (const auto& [index, value] : staged_) {
        Event event;
        event.kind = EventKind::parameter_changed;
        event.request_id = c.request_id;
        event.client = c.client;
        event.item = kParams[index].id;
        event.value = value;
        event.before = params_.values[index];
        events_.push_back(event);
        params_.values[index] = value;
      }
      record_.parameter_version = static_cast<std::uint32_t>(++params_.version);
      link_->publish_params(params_);
      return answer(c, 0);
    }
    case CommandKind::set_pose:
      if (mode != Mode::standby) return answer(c, refusal_bit(Refusal::not_standby));
      if (c.a != 0 && c.a == mark_exercise_ && c.b != kStartAgain) return answer(c, 0);
      mark_exercise_ = c.a;
      ++record_.start_mark;
      record_.x_m = static_cast<float>(c.v0);
      record_.y_m = static_cast<float>(c.v1);
      record_.psi_rad = static_cast<float>(c.v2);
      record_.distance_m = 0;
      {
        Event event;
        event.kind = EventKind::pose_set;
        events_.push_back(event);
      }
      return answer(c, 0);
    case CommandKind::set_neutral:
      link_->publish_params(params_);
      return answer(c, 0);
    case CommandKind::confirm_parameters:
    case CommandKind::revert_parameters:
      if (trial_s_ == 0) return answer(c, refusal_bit(Refusal::out_of_order));
      if (c.kind == CommandKind::confirm_parameters && c.a != 0 && c.a != record_.parameter_version)
        return answer(c, refusal_bit(Refusal::set_outdated));
      trial_s_ = 0;
      link_->publish_params(params_);
      return answer(c, 0);
    case CommandKind::begin_service:
      if (c.b != static_cast<std::uint32_t>(Role::engineer)) return answer(c, refusal_bit(Refusal::not_allowed));
      if (!holds) return answer(c, refusal_bit(Refusal::no_lease));
      if (mode != Mode::standby && mode != Mode::init) return answer(c, refusal_bit(Refusal::not_standby));
      record_.mode = static_cast<std::uint8_t>(Mode::init);
      service_ = true;
      return answer(c, 0);
    case CommandKind::service_frame: {
      if (!service_ || !holds) return answer(c, refusal_bit(Refusal::out_of_order));
      CanFrame frame{c.a, static_cast<std::uint8_t>(c.v1), 0, {}};
      frame.data = std::bit_cast<decltype(frame.data)>(c.v0);
      service_frames_.push_back(frame);
      return answer(c, 0);
    }
    case CommandKind::end_service:
      if (!service_ || !holds) return answer(c, refusal_bit(Refusal::out_of_order));
      service_ = false;
      record_.mode = static_cast<std::uint8_t>(Mode::standby);
      return answer(c, 0);
    case CommandKind::begin_calibration:
      if (!holds) return answer(c, refusal_bit(Refusal::no_lease));
      if (contract::find_calibration_step(c.a)->empty_harness && c.v0 != 1.0) return answer(c, refusal_bit(Refusal::harness_unconfirmed));
      record_.mode = static_cast<std::uint8_t>(Mode::calibrate);
      record_.calibration_step = static_cast<std::uint8_t>(c.a);
      record_.calibration_phase = 3;
      return answer(c, 0);
    case CommandKind::measure_calibration:
      return answer(c, std::fabs(c.v0) <= 20.0 ? 0U : refusal_bit(Refusal::out_of_range));
    case CommandKind::use_calibration:
    case CommandKind::cancel_calibration:
      if (mode != Mode::calibrate) return answer(c, refusal_bit(Refusal::out_of_order));
      record_.mode = static_cast<std::uint8_t>(Mode::standby);
      record_.calibration_step = record_.calibration_phase = 0;
      if (c.kind == CommandKind::use_calibration) link_->publish_params(params_);
      return answer(c, 0);
    case CommandKind::pause_alarm:
      if (record_.fault_bits == 0) return answer(c, refusal_bit(Refusal::out_of_order));
      record_.alarm_pause_s = c.a == 1 ? 120.0F : 0.0F;
      return answer(c, 0);
    case CommandKind::none:
      break;
  }
  answer(c, refusal_bit(Refusal::unknown_item));
}

void FakeCore::set(const std::function<void(TickRecord&)>& change) {
  const std::lock_guard lock(mutex_);
  change(record_);
}
void FakeCore::set_each(std::function<void(TickRecord&)> each) {
  const std::lock_guard lock(mutex_);
  each_ = std::move(each);
}
void FakeCore::mute(bool on) {
  const std::lock_guard lock(mutex_);
  muted_ = on;
}
void FakeCore::hold_store(bool on, StoreProblem problem) {
  const std::lock_guard lock(mutex_);
  store_held_ = on;
  store_.problem = problem;
}
void FakeCore::refuse_stops(StoreProblem problem) { link_->publish_stops_problem(problem); }
void FakeCore::publish_event(Event event) {
  const std::lock_guard lock(mutex_);
  events_.push_back(event);
}
void FakeCore::publish_bus(BusRecord record) {
  const std::lock_guard lock(mutex_);
  frames_.push_back(record);
}
void FakeCore::publish_loop(const contract::LoopReport& report) {
  const std::lock_guard lock(mutex_);
  link_->publish_loop(report);
}
void FakeCore::set_bus(Bus bus) {
  const std::lock_guard lock(mutex_);
  bus_ = std::move(bus);
}
void FakeCore::skip(std::size_t count) {
  std::unique_lock lock(mutex_);
  skip_ += count;
  skipped_.wait(lock, [this] { return skip_ == 0; });
}
std::vector<Command> FakeCore::commands() {
  const std::lock_guard lock(mutex_);
  return commands_;
}
DriveCommand FakeCore::drive() {
  const std::lock_guard lock(mutex_);
  return drive_;
}
std::vector<TickRecord> FakeCore::published() {
  const std::lock_guard lock(mutex_);
  return published_;
}
Mode FakeCore::mode() {
  const std::lock_guard lock(mutex_);
  return static_cast<Mode>(record_.mode);
}

}  // namespace hoist::test
