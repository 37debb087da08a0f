#include "tests/machine/chip.hpp"

#include <algorithm>
#include <cstring>

namespace hoist::machine {

Chip::Chip(std::string name, std::span<const std::uint8_t> flash, std::size_t flash_bytes, std::size_t ram_bytes, const MemoryMap& map)
    : flash_(flash_bytes, 0xFF),
      ram_(ram_bytes, 0xA5),
      core_(std::make_unique<CortexM0>(flash_, ram_, static_cast<PeripheralBus&>(*this), map)),
      complain_([this](const std::string& what) { violation(what); }),
      name_(std::move(name)) {
  std::copy_n(flash.begin(), std::min(flash.size(), flash_.size()), flash_.begin());
}

void Chip::reset(ResetCause cause) {
  powered_ = true;
  if (cause == ResetCause::power_on) std::fill(ram_.begin(), ram_.end(), std::uint8_t{0xA5});
  do_reset(cause);
}

void Chip::do_reset(ResetCause cause) {
  ++resets_[static_cast<std::size_t>(cause)];
  hung_ = false;
  reset_blocks(cause);
  core_->reset();
  if (start_vectors_ != 0) {
    std::uint32_t word = 0;
    (void)core_->peek(start_vectors_, 4, word);
    core_->set_reg(13, word & ~3U);
    (void)core_->peek(start_vectors_ + 4, 4, word);
    core_->set_reg(15, word & ~1U);
  }
  next_ = 0;
  touched_ = true;
}

void Chip::set_clock(std::uint32_t clock_hz) {
  clock_hz_ = clock_hz;
  if (clock_hz == 0 || kSecond % clock_hz != 0)
    violation("system clock of " + std::to_string(clock_hz) + " Hz does not divide 48 MHz: not modelled");
  unit_ = std::max<Time>(1, clock_hz == 0 ? 1 : kSecond / clock_hz);
  slice_from_ = now_;
  slice_cycles_ = core_->cycles();
  core_->stop();
}

void Chip::service(Time until) {
  while (edge_at_ < edges_.size() && edges_[edge_at_].at <= until) {
    const Edge& edge = edges_[edge_at_++];
    Outside& port = outside_[edge.place.port];
    const std::uint32_t bit = 1U << edge.place.bit;
    port.driven |= bit;
    port.level = edge.level ? port.level | bit : port.level & ~bit;
    pins_changed(edge.place.port);
  }
  if (edge_at_ == edges_.size()) {
    edges_.clear();
    edge_at_ = 0;
  }
  advance_blocks(until);
  update_lines();
}

void Chip::update_lines() {
  touched_ = false;
  can_changes_ = can().changes();
  core_->set_lines(lines());
  Time next = next_block_event();
  if (edge_at_ < edges_.size()) next = std::min(next, edges_[edge_at_].at);
  if (next < next_ || reset_wanted_ || !powered_) core_->stop();
  next_ = next;
}

void Chip::run_until(Time end) {
  if (!powered_) {
    now_ = end;
    return;
  }
  if (touched_ || can().changes() != can_changes_) update_lines();  // something has come from outside
  while (now_ < end) {
    if (reset_wanted_) {
      const ResetCause cause = *reset_wanted_;
      reset_wanted_.reset();
      do_reset(cause);
    }
    if (!powered_) break;
    if (next_ <= now_) service(now_);
    if (reset_wanted_) continue;
    const Time until = std::min(end, std::max(next_, now_ + 1));
    if (hung_) {
      now_ = until;
      continue;
    }
    slice_from_ = now_;
    slice_cycles_ = core_->cycles();
    in_slice_ = true;
    (void)core_->run((until - now_ + unit_ - 1) / unit_);
    catch_up();
    in_slice_ = false;
    if (now_ >= until || !(core_->asleep() || core_->locked_up())) continue;
    // Asleep: advance to the next event.
    Time wake = until;
    const std::uint64_t tick = core_->cycles_to_systick();
    if (tick != UINT64_MAX) wake = std::min(wake, now_ + tick * unit_);
    const std::uint64_t cycles = wake > now_ ? (wake - now_ + unit_ - 1) / unit_ : 1;
    core_->sleep(cycles);
    now_ += cycles * unit_;
  }
  if (now_ < end) now_ = end;
}

void Chip::stall(double seconds) {
  core_->sleep(static_cast<std::uint64_t>(seconds * clock_hz_));
  catch_up();
}

bool Chip::cut_now() {
  ++flash_operations_;
  if (flash_cut_ == 0 || --flash_cut_ != 0) return false;
  powered_ = false;
  return true;
}

void Chip::outputs_written(unsigned port, std::uint32_t before, std::uint32_t after) {
  if (!interlock_ || port != interlock_->held.port || ((before ^ after) & (1U << interlock_->held.bit)) == 0) return;
  const bool enabled = pin(interlock_->enable);
  interlock_changes_ += enabled ? 1 : 0;
  if (enabled && output(interlock_->while_high)) violation("direction of the bridge changed while its PWM output is high");
}

void Chip::drive_pin(PinPlace at, bool level) {
  Outside& port = outside_[at.port];
  const std::uint32_t mask = 1U << at.bit;
  port.driven |= mask;
  port.level = level ? port.level | mask : port.level & ~mask;
  pins_changed(at.port);
}
void Chip::float_pin(PinPlace at) {
  outside_[at.port].driven &= ~(1U << at.bit);
  pins_changed(at.port);
}
void Chip::schedule_pin(Time at, PinPlace place, bool level) {
  edges_.push_back({at, place, level});
  next_ = std::min(next_, at);
}

}  // namespace hoist::machine
