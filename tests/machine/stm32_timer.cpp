#include "tests/machine/stm32_timer.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

namespace hoist::machine {
namespace {

// CR1
constexpr std::uint32_t kEnable = 1, kUpdateOff = 2, kOnePulse = 8, kDown = 0x10, kCentre = 0x60, kTopBuffered = 0x80;
// CR2
constexpr std::uint32_t kXorInputs = 0x80;
// SR
constexpr std::uint32_t kUpdated = 1, kCaptured = 2, kOverCaptured = 0x200;
// BDTR
constexpr std::uint32_t kMainOutput = 0x8000;
constexpr std::uint32_t kPwm1 = 6, kPwm2 = 7;

std::string hex(std::uint32_t value) {
  std::array<char, 12> text{};
  std::snprintf(text.data(), text.size(), "%X", value);
  return text.data();
}

}  // namespace

void Stm32Timer::reset() {
  control1_ = control2_ = slave_ = interrupts_ = status_ = enable_ = outputs_ = 0;
  modes_ = {};
  prescale_wanted_ = prescale_ = 0;
  top_wanted_ = top_ = static_cast<std::uint32_t>(range() - 1);
  compare_wanted_ = compare_ = {};
  counter_ = 0;
  ++changes_;
}

// ---------------------------------------------------------------- counting

void Stm32Timer::update() {
  prescale_ = prescale_wanted_;
  top_ = top_wanted_;
  compare_ = compare_wanted_;
  status_ |= kUpdated;
  ++changes_;
}

void Stm32Timer::settle(Time now) {
  if (now <= settled_) return;
  if (!ticking()) {
    settled_ = now;
    return;
  }
  for (;;) {
    const Time step = clock_ * (static_cast<Time>(prescale_) + 1);
    const std::uint64_t counts = (now - settled_) / step;
    const std::uint64_t to_update = counter_ > top_ ? range() - counter_ : static_cast<std::uint64_t>(top_) + 1 - counter_;
    if (counts < to_update) {
      counter_ += counts;
      settled_ += counts * step;
      return;
    }
    settled_ += to_update * step;
    counter_ = 0;
    if ((control1_ & kUpdateOff) == 0) update();
    // What follows until `now` is the same period again and again.
    const std::uint64_t period = clock_ * (static_cast<Time>(prescale_) + 1) * (static_cast<Time>(top_) + 1);
    settled_ += (now - settled_) / period * period;
  }
}

Time Stm32Timer::next() const {
  if (!ticking()) return kNever;
  const bool waiting = prescale_ != prescale_wanted_ || top_ != top_wanted_ || compare_ != compare_wanted_;
  if (!waiting && (interrupts_ & 1U) == 0) return kNever;
  if ((status_ & kUpdated) != 0 && !waiting) return kNever;
  const std::uint64_t to_update = counter_ > top_ ? range() - counter_ : static_cast<std::uint64_t>(top_) + 1 - counter_;
  return settled_ + to_update * clock_ * (static_cast<Time>(prescale_) + 1);
}

void Stm32Timer::count_edge(bool up) {
  if (up)
    counter_ = counter_ >= top_ ? 0 : counter_ + 1;
  else
    counter_ = counter_ == 0 ? top_ : counter_ - 1;
  control1_ = up ? control1_ & ~kDown : control1_ | kDown;
}

// RM0091, table "Counting direction versus encoder signals": both edges of both inputs.
void Stm32Timer::count_encoder(std::uint32_t before, std::uint32_t after) {
  const std::uint32_t mode = slave_ & 7U;
  const bool first = ((before ^ after) & 1U) != 0, second = ((before ^ after) & 2U) != 0;
  bool a = (before & 1U) != 0;
  bool b = (before & 2U) != 0;
  if (first && second) complain_(std::string(name_) + ": both encoder lines changed at once: the hardware's count is not defined");
  if (first) {
    a = !a;
    if (mode != 1) count_edge(a != b);  // counts on TI1 edges in modes 2 and 3
  }
  if (second) {
    b = !b;
    if (mode != 2) count_edge(b == a);
  }
}

void Stm32Timer::capture(bool before, bool after) {
  if (before == after || (enable_ & 1U) == 0 || (modes_[0] & 3U) != 1) return;
  const std::uint32_t polarity = ((enable_ >> 1) & 1U) | ((enable_ >> 2) & 2U);  // CC1P, CC1NP
  if ((polarity == 0 && !after) || (polarity == 1 && after)) return;
  if ((status_ & kCaptured) != 0) status_ |= kOverCaptured;
  status_ |= kCaptured;
  compare_[0] = compare_wanted_[0] = static_cast<std::uint32_t>(counter_);
}

void Stm32Timer::set_inputs(std::uint32_t levels, Time now) {
  if (levels == inputs_) return;
  settle(now);
  const std::uint32_t before = inputs_;
  inputs_ = levels;
  if ((control1_ & kEnable) == 0) return;
  if (encoder()) count_encoder(before, levels);
  const auto parity = [](std::uint32_t bits) { return ((bits ^ (bits >> 1) ^ (bits >> 2)) & 1U) != 0; };
  if ((control2_ & kXorInputs) != 0)
    capture(parity(before), parity(levels));
  else
    capture((before & 1U) != 0, (levels & 1U) != 0);
}

// ---------------------------------------------------------------- outputs

bool Stm32Timer::drives(unsigned channel) const {
  if ((enable_ & (1U << (4 * channel))) == 0 || ((modes_[channel / 2] >> (8 * (channel & 1U))) & 3U) != 0) return false;
  return !advanced_ || (outputs_ & kMainOutput) != 0;
}

double Stm32Timer::high_share(unsigned channel) const {
  if (!drives(channel)) return 0.0;
  const double period = static_cast<double>(top_) + 1.0;
  const double first = std::min<double>(compare_[channel], period) / period;  // the part with the counter below the compare value
  switch (output_mode(channel)) {
    case kPwm1:
      return first;
    case kPwm2:
      return 1.0 - first;
    case 5:
      return 1.0;
    default:
      return 0.0;
  }
}

bool Stm32Timer::output(unsigned channel, Time now) {
  settle(now);
  if (!drives(channel)) return false;
  const bool below = counter_ < compare_[channel];
  const std::uint32_t mode = output_mode(channel);
  return mode == 5 || (mode == kPwm1 && below) || (mode == kPwm2 && !below);
}

Time Stm32Timer::next_rise(unsigned channel, Time now) {
  settle(now);
  if ((enable_ & (1U << (4 * channel))) == 0 || !ticking()) return kNever;
  const std::uint32_t mode = output_mode(channel), compare = compare_[channel];
  if (mode != kPwm1 && mode != kPwm2) return kNever;
  if (compare == 0 || compare > top_) return kNever;  // always high or always low
  const Time step = clock_ * (static_cast<Time>(prescale_) + 1);
  const std::uint64_t at = mode == kPwm2 ? compare : 0;
  const std::uint64_t period = static_cast<std::uint64_t>(top_) + 1;
  const std::uint64_t counts = at > counter_ ? at - counter_ : period - counter_ + at;
  return settled_ + counts * step;
}

// ---------------------------------------------------------------- registers

std::uint32_t Stm32Timer::read(std::uint32_t offset, Time now) {
  settle(now);
  switch (offset) {
    case 0x00:
      return control1_;
    case 0x04:
      return control2_;
    case 0x08:
      return slave_;
    case 0x0C:
      return interrupts_;
    case 0x10:
      return status_;
    case 0x18:
    case 0x1C:
      return modes_[(offset - 0x18) / 4];
    case 0x20:
      return enable_;
    case 0x24:
      return static_cast<std::uint32_t>(counter_);
    case 0x28:
      return prescale_wanted_;
    case 0x2C:
      return top_wanted_;
    case 0x34:
      if ((modes_[0] & 3U) != 0) status_ &= ~kCaptured;  // of a capture channel
      return compare_wanted_[0];
    case 0x38:
    case 0x3C:
    case 0x40:
      return compare_wanted_[(offset - 0x34) / 4];
    case 0x44:
      if (advanced_) return outputs_;
      [[fallthrough]];
    default:
      complain_(std::string(name_) + ": read of register " + hex(offset) + ", which is write-only, does not exist or is not modelled");
      return 0;
  }
}

void Stm32Timer::check_modes(std::uint32_t value, unsigned pair) {
  if ((value & ~0xFFFFU) != 0) complain_(std::string(name_) + ": reserved bits of CCMR" + std::to_string(pair + 1));
  for (unsigned i = 0; i < 2; ++i) {
    const std::uint32_t half = (value >> (8 * i)) & 0xFFU, select = half & 3U;
    const unsigned channel = 2 * pair + i;
    if (((modes_[pair] ^ value) >> (8 * i) & 3U) != 0 && (enable_ & (1U << (4 * channel))) != 0)
      complain_(std::string(name_) + ": direction of a channel changed while it is enabled");
    if (select > 1 || (select == 1 && (half & 0x0CU) != 0))
      complain_(std::string(name_) + ": crossed inputs, TRC or input prescaler: not modelled");
    if (select == 0 && (half & 0x84U) != 0) complain_(std::string(name_) + ": fast or cleared outputs: not modelled");
    const std::uint32_t mode = (half >> 4) & 7U;
    if (select == 0 && mode != 0 && mode != 4 && mode != 5 && mode != kPwm1 && mode != kPwm2)
      complain_(std::string(name_) + ": outputs that change at a match: not modelled");
  }
}

// Registers that choose how the timer works.
void Stm32Timer::write_mode(std::uint32_t offset, std::uint32_t value) {
  const std::string name(name_);
  switch (offset) {
    case 0x00:
      if ((value & ~0x3FFU) != 0) complain_(name + ": reserved bits of CR1");
      if ((value & (kOnePulse | kCentre)) != 0 || ((value & kDown) != 0 && !encoder()))
        complain_(name + ": one pulse, counting down or centre-aligned: not modelled");
      if ((value & kEnable) != 0 && encoder() && (modes_[0] & 0x303U) != 0x101U)
        complain_(name + ": encoder mode without both channels switched to their inputs");
      control1_ = value;
      return;
    case 0x04:
      if ((value & (advanced_ ? ~0x7FFDU : ~0xF8U)) != 0) complain_(name + ": reserved bits of CR2");
      if ((value & ~kXorInputs) != 0) complain_(name + ": CR2 asks for what is not modelled");
      control2_ = value;
      return;
    case 0x08:
      if ((value & ~0xFFFFU) != 0) complain_(name + ": reserved bits of SMCR");
      if ((value & ~7U) != 0 || (value & 7U) > 3) complain_(name + ": slave modes other than the encoder's: not modelled");
      if ((control1_ & kEnable) != 0) complain_(name + ": SMCR changed while the timer is enabled");
      slave_ = value;
      return;
    case 0x0C:
      if ((value & ~0x1U) != 0) complain_(name + ": interrupts of channels, DMA: not modelled");
      interrupts_ = value;
      return;
    case 0x20:
      if ((value & (advanced_ ? ~0x3FFFU : ~0xBBBBU)) != 0) complain_(name + ": reserved bits of CCER");
      if (encoder() && (value & 0x88U) != 0) complain_(name + ": both edges asked for in encoder mode");
      if ((value & 0x2660U) != 0 || (value & 4U) != 0 || ((modes_[0] & 3U) == 0 && (value & 0xAU) != 0))
        complain_(name + ": inverted or complementary outputs, edges of channels 2 to 4: not modelled");
      enable_ = value;
      return;
    default:
      break;
  }
}

void Stm32Timer::write(std::uint32_t offset, std::uint32_t value, Time now, std::uint32_t clock_hz) {
  settle(now);
  clock_ = std::max<Time>(1, kSecond / clock_hz);
  ++changes_;
  const auto bounded = [&](const char* what) {
    if (value >= range()) complain_(std::string(name_) + ": " + what + " beyond 16 bit");
    return static_cast<std::uint32_t>(value % range());
  };
  switch (offset) {
    case 0x10:
      status_ &= value;  // flags are cleared by zeros
      return;
    case 0x14:
      if ((value & ~1U) != 0) complain_(std::string(name_) + ": events other than an update: not modelled");
      if ((value & 1U) != 0) {
        counter_ = 0;
        settled_ = now;
        if ((control1_ & kUpdateOff) == 0) update();
      }
      return;
    case 0x18:
    case 0x1C:
      check_modes(value, (offset - 0x18) / 4);
      modes_[(offset - 0x18) / 4] = value & 0xFFFFU;
      return;
    case 0x24:
      counter_ = bounded("CNT");
      return;
    case 0x28:
      if (value > 0xFFFF) complain_(std::string(name_) + ": PSC beyond 16 bit");
      prescale_wanted_ = value & 0xFFFFU;
      return;
    case 0x2C:
      top_wanted_ = bounded("ARR");
      if ((control1_ & kTopBuffered) == 0) top_ = top_wanted_;
      return;
    case 0x34:
    case 0x38:
    case 0x3C:
    case 0x40: {
      const unsigned channel = (offset - 0x34) / 4;
      if (((modes_[channel / 2] >> (8 * (channel & 1U))) & 3U) != 0) complain_(std::string(name_) + ": CCR of a capture channel written");
      compare_wanted_[channel] = bounded("CCR");
      if (!buffered(channel)) compare_[channel] = compare_wanted_[channel];
      return;
    }
    case 0x44:
      if (advanced_) {
        if ((value & ~kMainOutput) != 0) complain_(std::string(name_) + ": break, dead time or lock: not modelled");
        outputs_ = value;
        return;
      }
      break;
    case 0x00:
    case 0x04:
    case 0x08:
    case 0x0C:
    case 0x20:
      write_mode(offset, value);
      return;
    default:
      break;
  }
  complain_(std::string(name_) + ": write to register " + hex(offset) + ", which is read-only, does not exist or is not modelled");
}

}  // namespace hoist::machine
