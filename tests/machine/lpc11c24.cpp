#include "tests/machine/lpc11c24.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

namespace hoist::machine {
namespace {

constexpr std::uint32_t kIrc_hz = 12'000'000, kCrystal_hz = 12'000'000;
constexpr Time kCrystalStart = 500 * kMicrosecond;  // data sheet: 500 us typical
constexpr Time kPllLock = 100 * kMicrosecond;       // data sheet: 100 us
constexpr double kAdcReference_v = 3.3;
constexpr double kAdcClockMax_hz = 4.5e6;
constexpr unsigned kAdcClocks = 11;                           // for all ten bits
constexpr std::uint32_t kFlashcfgReserved = 0x00010100;       // a program has to write them back unchanged
constexpr std::uint32_t kDeviceId = 0x1430102B;               // LPC11C24
constexpr double kEraseTime_s = 0.100, kWriteTime_s = 0.001;  // data sheet: 100 ms an erase, 1 ms for 256 bytes
constexpr std::size_t kPageBytes = 256;
// RAM of the boot ROM (UM10398, "RAM used by ISP command handler"): contents may be lost upon reset. Its stack is 256 bytes, down from 32
// below the top; flash routines use those 32. Measured on relatives: an LPC1754 rewrites top - 38h to top - 20h, an LPC804 its top 44 bytes.
constexpr std::size_t kRomVariables = 0x17C, kRomVariablesEnd = 0x25C, kRomStackAndTop = 256 + 32;
constexpr std::size_t kRemapBytes = 512;  // UM10398, SYSMEMREMAP

// Blocks at 0x40000000 + n * 0x4000.
enum Block : unsigned {
  kI2c = 0,
  kWwdt = 1,
  kUart = 2,
  kCt16b0 = 3,
  kCt16b1 = 4,
  kCt32b0 = 5,
  kCt32b1 = 6,
  kAdc = 7,
  kPmu = 14,
  kFlashctrl = 15,
  kSsp0 = 16,
  kIocon = 17,
  kSyscon = 18,
  kCan = 20,
  kSsp1 = 22
};
struct Gate {
  unsigned block;
  int clock;  // bit of SYSAHBCLKCTRL
  int reset;  // bit of PRESETCTRL
  const char* name;
};
constexpr std::array<Gate, 13> kGates{{{kI2c, 5, 1, "I2C"},
                                       {kWwdt, 15, -1, "WWDT"},
                                       {kUart, 12, -1, "UART"},
                                       {kCt16b0, 7, -1, "CT16B0"},
                                       {kCt16b1, 8, -1, "CT16B1"},
                                       {kCt32b0, 9, -1, "CT32B0"},
                                       {kCt32b1, 10, -1, "CT32B1"},
                                       {kAdc, 13, -1, "ADC"},
                                       {kFlashctrl, 3, -1, "FLASHCTRL"},
                                       {kSsp0, 11, 0, "SSP0"},
                                       {kIocon, 16, -1, "IOCON"},
                                       {kCan, 17, 3, "C_CAN"},
                                       {kSsp1, 18, 2, "SSP1"}}};
constexpr unsigned kGpioClock = 6;

// Offset of each pin's IOCON register; 0xFF: no such pin.
constexpr std::array<std::array<std::uint8_t, 12>, 4> kIoconOffset{{
    {0x0C, 0x10, 0x1C, 0x2C, 0x30, 0x34, 0x4C, 0x50, 0x60, 0x64, 0x68, 0x74},
    {0x78, 0x7C, 0x80, 0x90, 0x94, 0xA0, 0xA4, 0xA8, 0x14, 0x38, 0x6C, 0x98},
    {0x08, 0x28, 0x5C, 0x8C, 0x40, 0x44, 0x00, 0x20, 0x24, 0x54, 0x58, 0x70},
    {0x84, 0x88, 0x9C, 0xAC, 0x3C, 0x48, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF},
}};
struct PinFunction {
  unsigned port, bit, function;
};
// Which match output of which timer a pin carries with which function.
struct MatchPin {
  PinFunction pin;
  unsigned timer, match;
};
constexpr std::array<MatchPin, 16> kMatchPins{{{{0, 8, 2}, 0, 0},
                                               {{0, 9, 2}, 0, 1},
                                               {{0, 10, 3}, 0, 2},
                                               {{1, 9, 1}, 1, 0},
                                               {{1, 10, 2}, 1, 1},
                                               {{1, 6, 2}, 2, 0},
                                               {{1, 7, 2}, 2, 1},
                                               {{0, 1, 2}, 2, 2},
                                               {{0, 11, 3}, 2, 3},
                                               {{1, 1, 3}, 3, 0},
                                               {{1, 2, 3}, 3, 1},
                                               {{1, 3, 3}, 3, 2},
                                               {{1, 4, 2}, 3, 3},
                                               {{2, 6, 1}, 2, 1},
                                               {{2, 7, 1}, 2, 2},
                                               {{2, 8, 1}, 2, 3}}};
constexpr std::array<PinFunction, 8> kAdcPins{{{0, 11, 2}, {1, 0, 2}, {1, 1, 2}, {1, 2, 2}, {1, 3, 2}, {1, 4, 1}, {1, 10, 1}, {1, 11, 1}}};

std::string hex(std::uint32_t value) {
  std::array<char, 12> text{};
  std::snprintf(text.data(), text.size(), "%X", value);
  return text.data();
}

}  // namespace

// ---------------------------------------------------------------- timers

void MatchTimer::reset() {
  tcr_ = pr_ = mcr_ = ccr_ = emr_ = ctcr_ = pwmc_ = 0;
  match_.fill(0);
  counter_ = 0;
  settled_ = 0;
  flags_ = held_high_ = 0;
}

std::uint64_t MatchTimer::top() const {
  std::uint64_t top = range();
  for (unsigned i = 0; i < 4; ++i)
    if ((mcr_ & (2U << (3 * i))) != 0) top = std::min<std::uint64_t>(top, static_cast<std::uint64_t>(match_[i]) + 1);
  return top;
}
std::uint64_t MatchTimer::counts_since(Time now) const { return running() && now > settled_ ? (now - settled_) / step_ : 0; }

// The counter as it is now, with the flags of the matches it came through.
void MatchTimer::settle(Time now) {
  const std::uint64_t counts = counts_since(now);
  if (counts == 0) {
    if (!running()) settled_ = now;
    return;
  }
  const std::uint64_t turn = top();
  for (unsigned i = 0; i < 4; ++i) {
    if ((mcr_ & (1U << (3 * i))) == 0 || match_[i] >= turn) continue;
    // Counts until the counter shows the match value.
    const std::uint64_t here = counter_ % turn;
    const std::uint64_t away = match_[i] > here ? match_[i] - here : match_[i] + turn - here;
    if (counts >= away) flags_ |= 1U << i;
  }
  if (counter_ + counts >= turn) held_high_ = 0;
  if (counter_ >= turn) {
    // Set beyond its top: it runs to the end of its range first.
    const std::uint64_t to_end = range() - counter_;
    counter_ = counts >= to_end ? (counts - to_end) % turn : counter_ + counts;
  } else {
    counter_ = (counter_ + counts) % turn;
  }
  settled_ += counts * step_;
}

std::uint32_t MatchTimer::read(std::uint32_t offset, Time now) {
  settle(now);
  switch (offset) {
    case 0x00:
      return flags_;
    case 0x04:
      return tcr_;
    case 0x08:
      return static_cast<std::uint32_t>(counter_);
    case 0x0C:
      return pr_;
    case 0x10:
      return 0;
    case 0x14:
      return mcr_;
    case 0x18:
    case 0x1C:
    case 0x20:
    case 0x24:
      return match_[(offset - 0x18) / 4];
    case 0x28:
      return ccr_;
    case 0x2C:
    case 0x30:
      return 0;
    case 0x3C:
      return emr_;
    case 0x70:
      return ctcr_;
    case 0x74:
      return pwmc_;
    default:
      complain_(std::string(name_) + ": read of register " + hex(offset) + ", which does not exist");
      return 0;
  }
}

void MatchTimer::write(std::uint32_t offset, std::uint32_t value, Time now, std::uint32_t clock_hz) {
  settle(now);
  const auto reserved = [&](std::uint32_t bits) {
    if ((value & bits) != 0) complain_(std::string(name_) + ": reserved bits of register " + hex(offset));
  };
  step_ = (kSecond / clock_hz) * (static_cast<Time>(pr_) + 1);
  switch (offset) {
    case 0x00:
      reserved(~0x3FU);
      flags_ &= ~value;
      return;
    case 0x04:
      reserved(~3U);
      tcr_ = value & 3U;
      settled_ = now;
      if ((tcr_ & 2U) != 0) counter_ = 0;
      return;
    case 0x08:
      counter_ = wide_ ? value : value & 0xFFFFU;
      settled_ = now;
      return;
    case 0x0C:
      pr_ = wide_ ? value : value & 0xFFFFU;
      settled_ = now;
      step_ = (kSecond / clock_hz) * (static_cast<Time>(pr_) + 1);
      return;
    case 0x10:
      return;
    case 0x14:
      reserved(~0xFFFU);
      if ((value & 0x924U) != 0) complain_(std::string(name_) + ": stop on match: not modelled");
      mcr_ = value & 0xFFFU;
      return;
    case 0x18:
    case 0x1C:
    case 0x20:
    case 0x24:
      if (!wide_ && value > 0xFFFF) complain_(std::string(name_) + ": match beyond 16 bit");
      if (const unsigned match = (offset - 0x18) / 4; (pwmc_ & (1U << match)) != 0 && output(match, now)) held_high_ |= 1U << match;
      match_[(offset - 0x18) / 4] = wide_ ? value : value & 0xFFFFU;
      return;
    case 0x28:
      if (value != 0) complain_(std::string(name_) + ": capture: not modelled");
      ccr_ = value;
      return;
    case 0x3C:
      reserved(~0xFFFU);
      emr_ = value & 0xFFFU;
      return;
    case 0x70:
      if (value != 0) complain_(std::string(name_) + ": counter mode: not modelled");
      ctcr_ = value;
      return;
    case 0x74:
      reserved(~0xFU);
      pwmc_ = value & 0xFU;
      return;
    default:
      complain_(std::string(name_) + ": write to register " + hex(offset) + ", which is read-only or does not exist");
  }
}

void MatchTimer::advance(Time now) { settle(now); }

Time MatchTimer::next() const {
  if (!running() || (mcr_ & 0x249U) == 0) return kNever;
  const std::uint64_t turn = top();
  Time best = kNever;
  for (unsigned i = 0; i < 4; ++i) {
    if ((mcr_ & (1U << (3 * i))) == 0 || match_[i] >= turn || (flags_ & (1U << i)) != 0) continue;
    const std::uint64_t here = counter_ % turn;
    const std::uint64_t away = match_[i] > here ? match_[i] - here : match_[i] + turn - here;
    best = std::min(best, settled_ + away * step_);
  }
  return best;
}

double MatchTimer::high_share(unsigned match) const {
  if ((pwmc_ & (1U << match)) == 0) return (emr_ >> match) & 1U;
  if (!running()) return 0.0;
  // Low from the start of the cycle until the match, high from there to its end; a match beyond the end never comes.
  const auto turn = static_cast<double>(top());
  return match_[match] >= top() ? 0.0 : (turn - match_[match]) / turn;
}
bool MatchTimer::output(unsigned match, Time now) {
  settle(now);
  if ((pwmc_ & (1U << match)) == 0) return ((emr_ >> match) & 1U) != 0;
  return running() && ((held_high_ & (1U << match)) != 0 || counter_ >= match_[match]);
}
Time MatchTimer::next_edge(unsigned match, bool falling, Time now) {
  settle(now);
  if (!running()) return kNever;
  const std::uint64_t turn = top();
  const bool is_pwm = (pwmc_ & (1U << match)) != 0;
  const std::uint32_t action = (emr_ >> (4 + 2 * match)) & 3U;
  // A PWM output rises at its match and falls when the counter restarts; another one changes at its match as set in EMR.
  const std::uint64_t at = is_pwm && falling ? 0 : match_[match];
  if (at >= turn || (is_pwm && (match_[match] == 0 || match_[match] >= turn))) return kNever;
  if (!is_pwm && action != 3) return kNever;
  const std::uint64_t here = counter_ % turn;
  std::uint64_t away = at > here ? at - here : at + turn - here;
  if (!is_pwm && (((emr_ >> match) & 1U) != 0) != falling) away += turn;
  return settled_ + away * step_;
}
double MatchTimer::pwm_hz(std::uint32_t clock_hz) const {
  return static_cast<double>(clock_hz) / (static_cast<double>(pr_) + 1.0) / static_cast<double>(top());
}

// ---------------------------------------------------------------- chip

Lpc11c24::Lpc11c24(std::string name, std::span<const std::uint8_t> flash)
    : Chip(std::move(name), flash, kFlashBytes, kRamBytes, {}),
      can_(complain_),
      i2c_(complain_),
      ssp0_("SSP0", complain_),
      ssp1_("SSP1", complain_),
      uart_(complain_),
      timers_{MatchTimer("CT16B0", false, complain_), MatchTimer("CT16B1", false, complain_), MatchTimer("CT32B0", true, complain_),
              MatchTimer("CT32B1", true, complain_)},
      page_written_(kFlashBytes / kPageBytes, false) {
  // A page that holds something may not be written again before it is erased.
  for (std::size_t i = 0; i < flash_.size(); ++i)
    if (flash_[i] != 0xFF) page_written_[i / kPageBytes] = true;
}

void Lpc11c24::spoil_rom_memory() {
  const auto spoil = [this](std::size_t from, std::size_t end) {
    for (std::size_t i = from; i < end; ++i) ram_[i] = static_cast<std::uint8_t>((ram_[i] ^ 0x5AU) + i);
  };
  spoil(kRomVariables, kRomVariablesEnd);
  spoil(kRamBytes - kRomStackAndTop, kRamBytes);
}

void Lpc11c24::reset_blocks(ResetCause cause) {
  if (cause == ResetCause::power_on) {
    reset_status_ = 0;
    general_.fill(0);  // only a cold boot clears them
  }
  constexpr std::array<std::uint32_t, 5> kStatus{1, 2, 4, 8, 16};
  reset_status_ |= kStatus[static_cast<std::size_t>(cause)];
  spoil_rom_memory();
  remap_ = 2;  // the ROM leaves it like this when it starts a program in flash
  presetctrl_ = pll_ = osc_ = wdtosc_ = pll_source_ = pll_source_wanted_ = pll_update_ = main_source_ = main_source_wanted_ = main_update_ =
      0;
  ircctrl_ = 0x80;
  ahb_divider_ = 1;
  ahb_clocks_ = 0x85F;
  ssp0_divider_ = uart_divider_ = ssp1_divider_ = wdt_source_ = wdt_source_wanted_ = wdt_update_ = wdt_divider_ = bod_ = 0;
  pdrun_ = 0xEDF0;
  pdwake_ = 0xEDF0;
  pdsleep_ = starterp_ = startaprp_ = 0;
  pll_locked_at_ = osc_ready_at_ = kNever;
  flashcfg_ = kFlashcfgReserved | 2U;
  iocon_.fill(0xD0);
  ports_ = {};
  adc_control_ = 0;
  adc_enable_ = 0x100;
  adc_data_.fill(0);
  adc_global_ = 0;
  adc_due_ = kNever;
  adc_by_edge_ = false;
  wdt_mode_ = 0;
  wdt_count_ = 0xFF;
  wdt_warn_ = 0;
  wdt_window_ = 0xFFFFFF;
  wdt_feed_ = 0;
  wdt_deadline_ = kNever;
  wdt_flag_ = false;
  prepared_ = 0;
  can_.reset();
  i2c_.reset();
  ssp0_.reset();
  ssp1_.reset();
  uart_.reset();
  for (MatchTimer& timer : timers_) timer.reset();
  core_->show_at_zero({});
  core_->set_flash_waits(2);
  update_clock();
  update_pins();
  for (unsigned p = 0; p < kPorts; ++p) ports_[p].seen = inputs(p);

  std::uint32_t sum = 0, word = 0;
  for (unsigned i = 0; i < 8; ++i) {
    std::memcpy(&word, &flash_[start_vectors_ + 4 * i], 4);
    sum += word;
  }
  if (sum != 0) violation("the ROM would not start this image: its first eight vectors do not add up to 0");
  std::memcpy(&word, &flash_[0x2FC], 4);
  if (word == 0x12345678 || word == 0x87654321 || word == 0x43218765 || word == 0x4E697370) violation("the word at 2FCh locks the chip");
}

// ---------------------------------------------------------------- time

Time Lpc11c24::next_block_event() const {
  Time next = std::min({i2c_.next(), ssp0_.next(), ssp1_.next(), uart_.next(), adc_due_, wdt_deadline_});
  for (const MatchTimer& timer : timers_) next = std::min(next, timer.next());
  return next;
}

void Lpc11c24::advance_blocks(Time until) {
  i2c_.advance(until);
  ssp0_.advance(until);
  ssp1_.advance(until);
  uart_.advance(until);
  for (MatchTimer& timer : timers_) timer.advance(until);
  if (adc_due_ <= until) {
    const Time at = adc_due_;
    adc_due_ = kNever;
    convert(adc_channel_, at);
    if (adc_by_edge_ && ((adc_control_ >> 24) & 7U) >= 4) await_edge();  // as long as START stands, each edge starts one
  }
  if (wdt_deadline_ <= until) expire_watchdog();
}

void Lpc11c24::expire_watchdog() {
  wdt_deadline_ = kNever;
  wdt_mode_ |= 4U;
  if ((wdt_mode_ & 2U) != 0)
    reset_wanted_ = ResetCause::watchdog;
  else
    wdt_flag_ = true;
}

std::uint32_t Lpc11c24::lines() {
  if ((adc_control_ & 0x10000U) != 0) update_burst();
  std::uint32_t lines = 0;
  if (can_.line()) lines |= 1U << 13;
  if (i2c_.line()) lines |= 1U << 15;
  if (ssp1_.line()) lines |= 1U << 14;
  for (unsigned i = 0; i < 4; ++i)
    if (timers_[i].line()) lines |= 1U << (16 + i);
  if (ssp0_.line()) lines |= 1U << 20;
  if (uart_.line()) lines |= 1U << 21;
  std::uint32_t done = 0;
  for (unsigned i = 0; i < 8; ++i)
    if ((adc_data_[i] >> 31) != 0) done |= 1U << i;
  if ((done & adc_enable_ & 0xFFU) != 0 || ((adc_enable_ & 0x100U) != 0 && (adc_global_ >> 31) != 0)) lines |= 1U << 24;
  if (wdt_flag_) lines |= 1U << 25;
  for (unsigned p = 0; p < kPorts; ++p)
    if ((ports_[p].ris & ports_[p].ie) != 0) lines |= 1U << (31 - p);
  return lines;
}

void Lpc11c24::stall_in_rom(double seconds) {
  stall(seconds);
  if (wdt_deadline_ <= now_) expire_watchdog();
}

// ---------------------------------------------------------------- access

bool Lpc11c24::reachable(unsigned block) {
  for (const Gate& gate : kGates) {
    if (gate.block != block) continue;
    if ((ahb_clocks_ & (1U << gate.clock)) == 0) {
      violation(std::string(gate.name) + " touched without its clock");
      return false;
    }
    if (gate.reset >= 0 && (presetctrl_ & (1U << gate.reset)) == 0) {
      violation(std::string(gate.name) + " touched while held in reset");
      return false;
    }
    return true;
  }
  return true;
}

bool Lpc11c24::read(std::uint32_t address, unsigned size, std::uint32_t& value) {
  value = 0;
  catch_up();
  if (address >= 0x50000000 && address < 0x50040000) {
    if ((ahb_clocks_ & (1U << kGpioClock)) == 0) {
      violation("GPIO touched without its clock");
      return true;
    }
    value = read_gpio((address >> 16) & 3U, address & 0xFFFCU) >> (8 * (address & 3U));
    return true;
  }
  if (address < 0x40000000 || address >= 0x40080000) return false;
  if (size != 4) violation("peripheral register read that is not a word: " + hex(address));
  const unsigned block = (address >> 14) & 31U;
  const std::uint32_t offset = address & 0x3FFCU;
  if (!reachable(block)) return true;
  switch (block) {
    case kI2c:
      value = i2c_.read(offset);
      break;
    case kWwdt:
      value = read_wwdt(offset);
      break;
    case kUart:
      value = uart_.read(offset, now_);
      break;
    case kCt16b0:
    case kCt16b1:
    case kCt32b0:
    case kCt32b1:
      value = timers_[block - kCt16b0].read(offset, now_);
      break;
    case kAdc:
      value = read_adc(offset);
      break;
    case kPmu:
      value = read_pmu(offset);
      return true;
    case kFlashctrl:
      if (offset != 0x10) violation("FLASHCTRL: read of register " + hex(offset) + ": not modelled");
      value = flashcfg_;
      return true;
    case kSsp0:
      value = ssp0_.read(offset, now_);
      break;
    case kSsp1:
      value = ssp1_.read(offset, now_);
      break;
    case kIocon:
      value = read_iocon(offset);
      return true;
    case kSyscon:
      value = read_syscon(offset);
      return true;
    case kCan:
      value = can_.read(offset, core_->cycles());
      break;
    default:
      return false;
  }
  update_lines();
  return true;
}

bool Lpc11c24::write(std::uint32_t address, unsigned size, std::uint32_t value) {
  catch_up();
  if (address >= 0x50000000 && address < 0x50040000) {
    if ((ahb_clocks_ & (1U << kGpioClock)) == 0) {
      violation("GPIO touched without its clock");
      return true;
    }
    if (size != 4) violation("GPIO register write that is not a word");
    write_gpio((address >> 16) & 3U, address & 0xFFFCU, value);
    update_lines();
    return true;
  }
  if (address < 0x40000000 || address >= 0x40080000) return false;
  if (size != 4) violation("peripheral register write that is not a word: " + hex(address));
  const unsigned block = (address >> 14) & 31U;
  const std::uint32_t offset = address & 0x3FFCU;
  if (!reachable(block)) return true;
  switch (block) {
    case kI2c:
      i2c_.write(offset, value, now_, clock_hz_);
      break;
    case kWwdt:
      write_wwdt(offset, value);
      break;
    case kUart:
      if (uart_divider_ == 0) violation("UART: used with its clock divider at 0");
      uart_.write(offset, value, now_, clock_hz_);
      break;
    case kCt16b0:
    case kCt16b1:
    case kCt32b0:
    case kCt32b1:
      timers_[block - kCt16b0].write(offset, value, now_, clock_hz_);
      break;
    case kAdc:
      write_adc(offset, value);
      break;
    case kPmu:
      write_pmu(offset, value);
      break;
    case kFlashctrl:
      if (offset != 0x10) {
        violation("FLASHCTRL: write to register " + hex(offset) + ": not modelled");
        break;
      }
      if ((value & ~3U) != kFlashcfgReserved) violation("FLASHCFG: reserved bits not written back as read");
      flashcfg_ = kFlashcfgReserved | (value & 3U);
      update_clock();
      break;
    case kSsp0:
      ssp0_.write(offset, value, now_, clock_hz_);
      break;
    case kSsp1:
      ssp1_.write(offset, value, now_, clock_hz_);
      break;
    case kIocon:
      write_iocon(offset, value);
      break;
    case kSyscon:
      write_syscon(offset, value);
      break;
    case kCan:
      can_.write(offset, value, core_->cycles(), clock_hz_);
      break;
    default:
      return false;
  }
  update_lines();
  return true;
}

// ---------------------------------------------------------------- power management

std::uint32_t Lpc11c24::read_pmu(std::uint32_t offset) {
  if (offset >= 0x04 && offset <= 0x10) return general_[(offset - 0x04) / 4];
  if (offset != 0) violation("PMU: read of register " + hex(offset) + ", which does not exist or is not modelled");
  return 0;
}
void Lpc11c24::write_pmu(std::uint32_t offset, std::uint32_t value) {
  if (offset >= 0x04 && offset <= 0x10)
    general_[(offset - 0x04) / 4] = value;
  else if (offset != 0)
    violation("PMU: write to register " + hex(offset) + ", which does not exist or is not modelled");
  else if ((value & 2U) != 0)
    violation("deep power-down asked for");
}

// ---------------------------------------------------------------- system control

void Lpc11c24::update_clock() {
  const std::uint32_t pll_in = pll_source_ == 1 ? kCrystal_hz : kIrc_hz;
  std::uint32_t main_hz = kIrc_hz;
  if (main_source_ == 1) main_hz = pll_in;
  if (main_source_ == 3) {
    main_hz = pll_in * ((pll_ & 0x1FU) + 1);
    if (pll_locked_at_ > now_) violation("main clock taken from the PLL before it has locked");
  }
  if (main_source_ == 2) violation("main clock taken from the watchdog oscillator: not modelled");
  if (ahb_divider_ == 0) {
    violation("SYSAHBCLKDIV 0: the system clock stops");
    return;
  }
  set_clock(main_hz / ahb_divider_);
  if (clock_hz_ > 50'000'000) violation("system clock of " + std::to_string(clock_hz_) + " Hz, 50 MHz is the most");
  const std::uint32_t waits = flashcfg_ & 3U;
  const std::uint32_t needed = clock_hz_ > 40'000'000 ? 2 : (clock_hz_ > 20'000'000 ? 1 : 0);
  if (waits < needed || waits == 3)
    violation("FLASHCFG: " + std::to_string(waits) + " wait states at " + std::to_string(clock_hz_) + " Hz");
  core_->set_flash_waits(waits);
}

std::uint32_t Lpc11c24::read_syscon(std::uint32_t offset) {
  switch (offset) {
    case 0x000:
      return remap_;
    case 0x004:
      return presetctrl_;
    case 0x008:
      return pll_;
    case 0x00C:
      return pll_locked_at_ <= now_ ? 1 : 0;
    case 0x020:
      return osc_;
    case 0x024:
      return wdtosc_;
    case 0x028:
      return ircctrl_;
    case 0x030:
      return reset_status_;
    case 0x040:
      return pll_source_wanted_;
    case 0x044:
      return pll_update_;
    case 0x070:
      return main_source_wanted_;
    case 0x074:
      return main_update_;
    case 0x078:
      return ahb_divider_;
    case 0x080:
      return ahb_clocks_;
    case 0x094:
      return ssp0_divider_;
    case 0x098:
      return uart_divider_;
    case 0x09C:
      return ssp1_divider_;
    case 0x0D0:
      return wdt_source_wanted_;
    case 0x0D4:
      return wdt_update_;
    case 0x0D8:
      return wdt_divider_;
    case 0x150:
      return bod_;
    case 0x154:
      return 4;
    case 0x200:
      return startaprp_;
    case 0x204:
      return starterp_;
    case 0x20C:
      return 0;
    case 0x230:
      return pdsleep_;
    case 0x234:
      return pdwake_;
    case 0x238:
      return pdrun_;
    case 0x3F4:
      return kDeviceId;
    default:
      violation("SYSCON: read of register " + hex(offset) + ", which does not exist or is not modelled");
      return 0;
  }
}

void Lpc11c24::write_syscon(std::uint32_t offset, std::uint32_t value) {
  const auto reserved = [&](std::uint32_t bits) {
    if ((value & bits) != 0) violation("SYSCON: reserved bits of register " + hex(offset));
  };
  switch (offset) {
    case 0x000:
      reserved(~3U);
      remap_ = value & 3U;
      if (remap_ == 0) violation("SYSMEMREMAP 0: the ROM's vectors: not modelled");
      core_->show_at_zero(remap_ == 1 ? std::span(ram_).first(kRemapBytes) : std::span<std::uint8_t>{});
      return;
    case 0x004:
      reserved(~0xFU);
      if ((presetctrl_ & 1U) != 0 && (value & 1U) == 0) ssp0_.reset();
      if ((presetctrl_ & 2U) != 0 && (value & 2U) == 0) i2c_.reset();
      if ((presetctrl_ & 4U) != 0 && (value & 4U) == 0) ssp1_.reset();
      if ((presetctrl_ & 8U) != 0 && (value & 8U) == 0) can_.reset();
      presetctrl_ = value & 0xFU;
      return;
    case 0x008: {
      reserved(~0x7FU);
      if (main_source_ == 3) violation("PLL changed while the main clock comes from it");
      pll_ = value & 0x7FU;
      const std::uint32_t out_hz = (pll_source_wanted_ == 1 ? kCrystal_hz : kIrc_hz) * ((pll_ & 0x1FU) + 1);
      const std::uint32_t current_hz = out_hz * 2 * (1U << ((pll_ >> 5) & 3U));
      if (current_hz < 156'000'000 || current_hz > 320'000'000 || out_hz > 100'000'000)
        violation("PLL: its oscillator at " + std::to_string(current_hz) + " Hz, allowed are 156 to 320 MHz");
      if ((pdrun_ & 0x80U) == 0) pll_locked_at_ = now_ + kPllLock;
      return;
    }
    case 0x020:
      reserved(~3U);
      if ((value & 1U) != 0) violation("crystal oscillator bypassed");
      osc_ = value & 3U;
      return;
    case 0x024:
      reserved(~0x1FFU);
      wdtosc_ = value & 0x1FFU;
      return;
    case 0x028:
      violation("IRC trimmed by the program");
      return;
    case 0x030:
      reset_status_ &= ~value;
      return;
    case 0x040:
      reserved(~3U);
      pll_source_wanted_ = value & 3U;
      return;
    case 0x044:
      reserved(~1U);
      if (pll_update_ == 0 && (value & 1U) != 0) {
        if (pll_source_wanted_ == 1 && (osc_ready_at_ == kNever || osc_ready_at_ > now_))
          violation("PLL fed from the crystal before it is powered and has started");
        if (pll_source_wanted_ > 1) violation("PLL fed from a source that does not exist");
        pll_source_ = pll_source_wanted_;
      }
      pll_update_ = value & 1U;
      return;
    case 0x070:
      reserved(~3U);
      main_source_wanted_ = value & 3U;
      return;
    case 0x074:
      reserved(~1U);
      if (main_update_ == 0 && (value & 1U) != 0) {
        main_source_ = main_source_wanted_;
        update_clock();
      }
      main_update_ = value & 1U;
      return;
    case 0x078:
      reserved(~0xFFU);
      ahb_divider_ = value & 0xFFU;
      update_clock();
      return;
    case 0x080:
      reserved(~0x7BFFFU & 0xFFFFFFFFU);
      if ((value & 0x1FU) != 0x1FU) violation("SYSAHBCLKCTRL: clock of core, ROM, RAM or flash switched off");
      ahb_clocks_ = value;
      return;
    case 0x094:
      reserved(~0xFFU);
      ssp0_divider_ = value & 0xFFU;
      ssp0_.set_divider(ssp0_divider_);
      return;
    case 0x098:
      reserved(~0xFFU);
      uart_divider_ = value & 0xFFU;
      uart_.set_divider(uart_divider_);
      return;
    case 0x09C:
      reserved(~0xFFU);
      ssp1_divider_ = value & 0xFFU;
      ssp1_.set_divider(ssp1_divider_);
      return;
    case 0x0D0:
      reserved(~3U);
      wdt_source_wanted_ = value & 3U;
      return;
    case 0x0D4:
      reserved(~1U);
      if (wdt_update_ == 0 && (value & 1U) != 0) {
        wdt_source_ = wdt_source_wanted_;
        if (wdt_source_ == 2 && (pdrun_ & 0x40U) != 0) violation("watchdog clocked from its oscillator, which is powered down");
      }
      wdt_update_ = value & 1U;
      return;
    case 0x0D8:
      reserved(~0xFFU);
      wdt_divider_ = value & 0xFFU;
      return;
    case 0x150:
      reserved(~0x1FU);
      bod_ = value & 0x1FU;
      set_supply(supply_v_);
      return;
    case 0x154:
      return;
    case 0x200:
      startaprp_ = value;
      return;
    case 0x204:
      starterp_ = value;
      return;
    case 0x208:
      return;
    case 0x230:
      pdsleep_ = value;
      return;
    case 0x234:
      pdwake_ = value;
      return;
    case 0x238:
      if ((value & ~0xFFU) != 0xED00U) violation("PDRUNCFG: reserved bits not written as the manual says");
      if ((value & 7U) != 0) violation("PDRUNCFG: IRC or flash powered down");
      if ((pdrun_ & 0x20U) != 0 && (value & 0x20U) == 0) osc_ready_at_ = now_ + kCrystalStart;
      if ((value & 0x20U) != 0) osc_ready_at_ = kNever;
      if ((pdrun_ & 0x80U) != 0 && (value & 0x80U) == 0) pll_locked_at_ = now_ + kPllLock;
      if ((value & 0x80U) != 0) pll_locked_at_ = kNever;
      pdrun_ = value;
      return;
    default:
      violation("SYSCON: write to register " + hex(offset) + ", which is read-only or does not exist");
  }
}

void Lpc11c24::set_supply(double volts) {
  supply_v_ = volts;
  constexpr std::array<double, 4> kLevel{1.46, 2.06, 2.35, 2.63};
  if (volts < 1.8 * 0.8) {
    powered_ = false;
    return;
  }
  if ((bod_ & 0x10U) != 0 && (pdrun_ & 8U) == 0 && volts < kLevel[bod_ & 3U]) reset_wanted_ = ResetCause::brown_out;
}

// ---------------------------------------------------------------- pins

std::uint32_t Lpc11c24::function_of(unsigned port, unsigned bit) const {
  const std::uint8_t offset = kIoconOffset[port][bit];
  return offset == 0xFF ? 0 : iocon_[offset / 4] & 7U;
}
bool Lpc11c24::is_gpio(unsigned port, unsigned bit) const {
  // Reset, SWD and the converter's first pins have GPIO as function 1; all others as function 0.
  const bool one = (port == 0 && (bit == 0 || bit == 10 || bit == 11)) || (port == 1 && bit <= 3);
  return function_of(port, bit) == (one ? 1U : 0U);
}
bool Lpc11c24::pin_driven_by_chip(PinPlace at) const {
  const auto [port, bit] = at;
  if (!powered_) return false;
  if (is_gpio(port, bit)) return (ports_[port].dir & (1U << bit)) != 0;
  for (const MatchPin& match : kMatchPins)
    if (match.pin.port == port && match.pin.bit == bit && match.pin.function == function_of(port, bit)) return true;
  return false;
}
double Lpc11c24::pin_high_share(PinPlace at) const {
  const auto [port, bit] = at;
  if (powered_ && !is_gpio(port, bit))
    for (const MatchPin& match : kMatchPins)
      if (match.pin.port == port && match.pin.bit == bit && match.pin.function == function_of(port, bit))
        return timers_[match.timer].high_share(match.match);
  return pin(at) ? 1.0 : 0.0;
}
bool Lpc11c24::pin(PinPlace at) const {
  const auto [port, bit] = at;
  const std::uint32_t mask = 1U << bit;
  if (powered_ && is_gpio(port, bit) && (ports_[port].dir & mask) != 0) return (ports_[port].out & mask) != 0;
  if ((outside_[port].driven & mask) != 0) return (outside_[port].level & mask) != 0;
  if (!powered_) return false;
  const std::uint8_t offset = kIoconOffset[port][bit];
  return offset != 0xFF && ((iocon_[offset / 4] >> 3) & 3U) == 2;
}
std::uint32_t Lpc11c24::inputs(unsigned port) const {
  std::uint32_t value = 0;
  for (unsigned bit = 0; bit < kPortBits; ++bit) {
    const std::uint8_t offset = kIoconOffset[port][bit];
    if (offset == 0xFF || !is_gpio(port, bit)) continue;
    const bool analog_pin = (port == 0 && bit == 11) || (port == 1 && (bit <= 4 || bit >= 10));
    if (analog_pin && (iocon_[offset / 4] & 0x80U) == 0) continue;  // in analog mode the digital input is off
    if (pin({port, bit})) value |= 1U << bit;
  }
  return value;
}

void Lpc11c24::look_at_port(unsigned number) {
  Port& port = ports_[number];
  touched_ = true;
  const std::uint32_t level = inputs(number);
  const std::uint32_t rose = level & ~port.seen, fell = port.seen & ~level;
  port.seen = level;
  port.ris |= (rose | fell) & port.ibe & ~port.is;
  port.ris |= rose & port.iev & ~port.ibe & ~port.is;
  port.ris |= fell & ~port.iev & ~port.ibe & ~port.is;
  port.ris |= ((level & port.iev) | (~level & ~port.iev)) & port.is & 0xFFFU;
}

void Lpc11c24::connect_spi(SpiDevice* device, PinPlace select) {
  spi0_ = device;
  select_ = select;
  ssp0_.connect(device);
}

void Lpc11c24::update_pins() {
  i2c_.set_pins(function_of(0, 4) == 1 && function_of(0, 5) == 1);
  const std::uint32_t clock_place = iocon_[0xB0 / 4] & 3U;
  const bool clock_out = (clock_place == 0 && function_of(0, 10) == 2) || (clock_place == 1 && function_of(2, 11) == 1) ||
                         (clock_place == 2 && function_of(0, 6) == 2);
  ssp0_.set_pins(clock_out && function_of(0, 8) == 1 && function_of(0, 9) == 1);
  uart_.set_pins(function_of(1, 6) == 1, function_of(1, 7) == 1, function_of(1, 5) == 1, function_of(0, 7) == 1);
  if (spi0_ != nullptr) {
    const bool low = pin_driven_by_chip(select_) && !pin(select_);
    if (low != selected_) {
      selected_ = low;
      spi0_->spi_select(low, now_);
    }
  }
  for (unsigned p = 0; p < kPorts; ++p) look_at_port(p);
}

std::uint32_t Lpc11c24::read_iocon(std::uint32_t offset) {
  if (offset > 0xD4) {
    violation("IOCON: register " + hex(offset) + " does not exist");
    return 0;
  }
  return iocon_[offset / 4];
}
void Lpc11c24::write_iocon(std::uint32_t offset, std::uint32_t value) {
  if (offset > 0xD4) {
    violation("IOCON: register " + hex(offset) + " does not exist");
    return;
  }
  if (offset < 0xB0) {
    bool found = false;
    for (const auto& port : kIoconOffset) found |= std::find(port.begin(), port.end(), static_cast<std::uint8_t>(offset)) != port.end();
    if (!found && offset != 0x18) violation("IOCON: register " + hex(offset) + " does not exist");
    const bool i2c_pin = offset == 0x30 || offset == 0x34;
    if ((value & (i2c_pin ? ~0x3C7U & ~0xC0U : ~0x7FFU)) != 0) violation("IOCON: reserved bits of register " + hex(offset));
    // SWD pins switched away lock the debugger out.
    if (offset == 0x68 && (value & 7U) != 0) violation("SWCLK switched away from the debugger");
    if (offset == 0x90 && (value & 7U) != 0) violation("SWDIO switched away from the debugger");
  }
  iocon_[offset / 4] = value;
  update_pins();
}

std::uint32_t Lpc11c24::read_gpio(unsigned number, std::uint32_t offset) {
  Port& port = ports_[number];
  if (offset < 0x4000) {
    const std::uint32_t mask = offset >> 2;
    return inputs(number) & mask;
  }
  switch (offset) {
    case 0x8000:
      return port.dir;
    case 0x8004:
      return port.is;
    case 0x8008:
      return port.ibe;
    case 0x800C:
      return port.iev;
    case 0x8010:
      return port.ie;
    case 0x8014:
      return port.ris;
    case 0x8018:
      return port.ris & port.ie;
    default:
      violation("GPIO: read of register " + hex(offset) + ", which is write-only or does not exist");
      return 0;
  }
}

bool Lpc11c24::output(PinPlace at) {
  for (const MatchPin& match : kMatchPins)
    if (match.pin.port == at.port && match.pin.bit == at.bit && match.pin.function == function_of(at.port, at.bit))
      return timers_[match.timer].output(match.match, now_);
  return pin_driven_by_chip(at) && pin(at);
}

void Lpc11c24::write_gpio(unsigned number, std::uint32_t offset, std::uint32_t value) {
  Port& port = ports_[number];
  if (offset < 0x4000) {
    const std::uint32_t mask = (offset >> 2) & 0xFFFU;
    const std::uint32_t before = port.out;
    port.out = (port.out & ~mask) | (value & mask);
    outputs_written(number, before, port.out);
    update_pins();
    return;
  }
  if ((value & ~0xFFFU) != 0) violation("GPIO: reserved bits of register " + hex(offset));
  switch (offset) {
    case 0x8000:
      for (unsigned bit = 0; bit < kPortBits; ++bit)
        if ((value & (1U << bit)) != 0 && (outside_[number].driven & (1U << bit)) != 0 && is_gpio(number, bit))
          violation("pin PIO" + std::to_string(number) + "_" + std::to_string(bit) + " made an output against something that drives it");
      port.dir = value & 0xFFFU;
      update_pins();
      return;
    case 0x8004:
      port.is = value & 0xFFFU;
      break;
    case 0x8008:
      port.ibe = value & 0xFFFU;
      break;
    case 0x800C:
      port.iev = value & 0xFFFU;
      break;
    case 0x8010:
      port.ie = value & 0xFFFU;
      break;
    case 0x801C:
      port.ris &= ~value;
      break;
    default:
      violation("GPIO: write to register " + hex(offset) + ", which is read-only or does not exist");
      return;
  }
  if (offset != 0x801C) look_at_port(number);
}

// ---------------------------------------------------------------- converter

Time Lpc11c24::conversion_time() const {
  const unsigned clocks = kAdcClocks - ((adc_control_ >> 17) & 7U);
  return clocks * (((adc_control_ >> 8) & 0xFFU) + 1) * unit_;
}

void Lpc11c24::convert(unsigned channel, Time at) {
  const PinFunction& pin = kAdcPins[channel];
  const std::uint32_t config = iocon_[kIoconOffset[pin.port][pin.bit] / 4];
  if ((config & 7U) != pin.function) violation("ADC: channel " + std::to_string(channel) + " converted without its pin switched to it");
  if ((config & 0x80U) != 0) violation("ADC: pin of channel " + std::to_string(channel) + " is in digital mode");
  if ((config & 0x18U) != 0) violation("ADC: pin of channel " + std::to_string(channel) + " has a pull resistor");
  const double volts = analog_ ? analog_(channel, at) : 0.0;
  const auto counts = static_cast<std::uint32_t>(std::clamp(std::floor(volts / kAdcReference_v * 1024.0), 0.0, 1023.0));
  std::uint32_t& data = adc_data_[channel];
  data = 0x80000000U | (counts << 6) | ((data >> 31) != 0 ? 0x40000000U : 0U);
  adc_global_ = 0x80000000U | (counts << 6) | (channel << 24) | ((adc_global_ >> 31) != 0 ? 0x40000000U : 0U);
}

// Conversions of a burst without interrupts are computed on reading: only the last one of each channel matters.
void Lpc11c24::update_burst() {
  if ((adc_control_ & 0x10000U) == 0 || (pdrun_ & 0x10U) != 0) return;
  std::array<unsigned, 8> order{};
  unsigned count = 0;
  for (unsigned i = 0; i < 8; ++i)
    if ((adc_control_ & (1U << i)) != 0) order[count++] = i;
  if (count == 0) return;
  const std::uint64_t done = now_ > burst_from_ ? (now_ - burst_from_) / conversion_time() : 0;
  if (done == burst_done_) return;
  const std::uint64_t first = done - burst_done_ > count ? done - count : burst_done_;
  for (std::uint64_t i = first; i < done; ++i) convert(order[i % count], burst_from_ + (i + 1) * conversion_time());
  burst_done_ = done;
}

// The conversion that begins with the next edge of the match output which START names.
void Lpc11c24::await_edge() {
  struct Source {
    unsigned timer, match;
  };
  constexpr std::array<Source, 4> kSources{{{2, 0}, {2, 1}, {0, 0}, {0, 1}}};  // START 4 to 7
  const unsigned start = (adc_control_ >> 24) & 7U;
  if (start < 4) {
    violation("ADC: start by a pin: not modelled");
    return;
  }
  const Source& source = kSources[start - 4];
  const Time edge = timers_[source.timer].next_edge(source.match, (adc_control_ & 0x08000000U) != 0, now_);
  adc_due_ = edge == kNever ? kNever : edge + conversion_time();
}

std::uint32_t Lpc11c24::read_adc(std::uint32_t offset) {
  update_burst();
  switch (offset) {
    case 0x00:
      return adc_control_;
    case 0x04: {
      const std::uint32_t value = adc_global_;
      adc_global_ &= 0x3FFFFFFFU;
      return value;
    }
    case 0x0C:
      return adc_enable_;
    case 0x30: {
      std::uint32_t value = 0;
      for (unsigned i = 0; i < 8; ++i) value |= ((adc_data_[i] >> 31) << i) | (((adc_data_[i] >> 30) & 1U) << (8 + i));
      return value;
    }
    default:
      if (offset >= 0x10 && offset <= 0x2C) {
        std::uint32_t& data = adc_data_[(offset - 0x10) / 4];
        const std::uint32_t value = data;
        data &= 0x3FFFFFFFU;
        return value;
      }
      violation("ADC: read of register " + hex(offset) + ", which does not exist");
      return 0;
  }
}

void Lpc11c24::write_adc(std::uint32_t offset, std::uint32_t value) {
  switch (offset) {
    case 0x00: {
      if ((value & 0xF0F00000U) != 0) violation("ADC: reserved bits of CR");
      update_burst();
      adc_control_ = value;
      const unsigned start = (value >> 24) & 7U;
      const double clock = static_cast<double>(clock_hz_) / (((value >> 8) & 0xFFU) + 1);
      const bool burst = (value & 0x10000U) != 0;
      if (burst || start != 0) {
        if (clock > kAdcClockMax_hz) violation("ADC: clock of " + std::to_string(clock) + " Hz, 4.5 MHz is the most");
        if ((pdrun_ & 0x10U) != 0) {
          violation("ADC: started while powered down");
          return;
        }
      }
      if (burst) {
        if (start != 0) violation("ADC: START must be 0 in burst mode");
        if ((adc_enable_ & 0x100U) != 0) violation("ADC: ADGINTEN must be 0 in burst mode");
        if ((adc_enable_ & 0xFFU) != 0) violation("ADC: interrupts of a burst: not modelled");
        burst_from_ = now_;
        burst_done_ = 0;
        return;
      }
      if (start == 0) {
        adc_due_ = kNever;
        return;
      }
      const std::uint32_t select = value & 0xFFU;
      if (select == 0 || (select & (select - 1)) != 0) {
        violation("ADC: exactly one channel may be selected outside burst mode");
        return;
      }
      if (adc_due_ != kNever && !adc_by_edge_) violation("ADC: started while converting");
      adc_channel_ = 0;
      while ((select & (1U << adc_channel_)) == 0) ++adc_channel_;
      adc_by_edge_ = start != 1;
      if (start == 1)
        adc_due_ = now_ + conversion_time();
      else
        await_edge();
      return;
    }
    case 0x0C:
      if ((value & ~0x1FFU) != 0) violation("ADC: reserved bits of INTEN");
      adc_enable_ = value & 0x1FFU;
      return;
    default:
      violation("ADC: write to register " + hex(offset) + ", which is read-only or does not exist");
  }
}

// ---------------------------------------------------------------- watchdog

std::uint64_t Lpc11c24::watchdog_value() const {
  if (wdt_deadline_ == kNever) return wdt_count_;
  const Time left = wdt_deadline_ > now_ ? wdt_deadline_ - now_ : 0;
  const Time total = wdt_deadline_ - wdt_started_;
  return total == 0 ? 0 : wdt_count_ * left / total;
}

void Lpc11c24::feed_watchdog() {
  double rate = kIrc_hz;
  if (wdt_source_ == 1) rate = clock_hz_;
  if (wdt_source_ == 2) {
    constexpr std::array<double, 16> kOscillator{0,     0.6e6,  1.05e6, 1.4e6,  1.75e6, 2.1e6, 2.4e6, 2.7e6,
                                                 3.0e6, 3.25e6, 3.5e6,  3.75e6, 4.0e6,  4.2e6, 4.4e6, 4.6e6};
    rate = kOscillator[(wdtosc_ >> 5) & 15U] / (2.0 * (1.0 + (wdtosc_ & 31U)));
  }
  if (wdt_divider_ == 0 || rate <= 0.0) {
    violation("WWDT: fed without a clock");
    return;
  }
  rate /= wdt_divider_;
  if ((wdt_mode_ & 1U) != 0 && wdt_deadline_ != kNever && watchdog_value() > wdt_window_) {
    violation("WWDT: fed before its window opened");
    reset_wanted_ = ResetCause::watchdog;
  }
  if ((wdt_mode_ & 1U) == 0) return;
  wdt_started_ = now_;
  // Counts every fourth clock.
  wdt_deadline_ = now_ + static_cast<Time>(4.0 * wdt_count_ / rate * static_cast<double>(kSecond));
}

std::uint32_t Lpc11c24::read_wwdt(std::uint32_t offset) {
  if (wdt_feed_ == 1) violation("WWDT: its registers touched between the two words of a feed");
  switch (offset) {
    case 0x00:
      return wdt_mode_;
    case 0x04:
      return wdt_count_;
    case 0x0C:
      return static_cast<std::uint32_t>(watchdog_value());
    case 0x14:
      return wdt_warn_;
    case 0x18:
      return wdt_window_;
    default:
      violation("WWDT: read of register " + hex(offset) + ", which is write-only or does not exist");
      return 0;
  }
}
void Lpc11c24::write_wwdt(std::uint32_t offset, std::uint32_t value) {
  if (offset != 0x08 && wdt_feed_ == 1) violation("WWDT: its registers touched between the two words of a feed");
  switch (offset) {
    case 0x00:
      if ((value & ~0x1FU) != 0) violation("WWDT: reserved bits of MOD");
      // Once on, it cannot be switched off.
      wdt_mode_ = (value & 0x1FU) | (wdt_mode_ & 3U);
      if ((value & 4U) == 0) wdt_mode_ &= ~4U;
      wdt_flag_ = false;
      return;
    case 0x04:
      if (value > 0xFFFFFF) violation("WWDT: time beyond 24 bit");
      wdt_count_ = std::max<std::uint32_t>(value & 0xFFFFFFU, 0xFF);
      return;
    case 0x08:
      if (wdt_feed_ == 0 && (value & 0xFFU) == 0xAAU) {
        wdt_feed_ = 1;
        return;
      }
      if (wdt_feed_ == 1 && (value & 0xFFU) == 0x55U) {
        wdt_feed_ = 0;
        feed_watchdog();
        return;
      }
      wdt_feed_ = 0;
      violation("WWDT: wrong feed sequence");
      if ((wdt_mode_ & 3U) == 3U) reset_wanted_ = ResetCause::watchdog;
      return;
    case 0x14:
      wdt_warn_ = value & 0x3FFU;
      return;
    case 0x18:
      wdt_window_ = value & 0xFFFFFFU;
      return;
    default:
      violation("WWDT: write to register " + hex(offset) + ", which is read-only or does not exist");
  }
}

// ---------------------------------------------------------------- flash routines of the ROM

bool Lpc11c24::call_rom(std::uint32_t address) {
  catch_up();
  core_->stop();
  if (address != 0x1FFF1FF1) return false;
  const std::uint32_t status = iap(core_->reg(0), core_->reg(1));
  (void)core_->poke(core_->reg(1), 4, status);
  // The routines use the top of RAM and save nothing there.
  std::fill(ram_.end() - 32, ram_.end(), std::uint8_t{0xEE});
  update_lines();
  return true;
}

std::uint32_t Lpc11c24::iap(std::uint32_t table, std::uint32_t result) {
  constexpr std::uint32_t kDone = 0, kInvalidCommand = 1, kSourceAlign = 2, kDestinationAlign = 3, kCountWrong = 6, kInvalidSector = 7,
                          kNotBlank = 8, kNotPrepared = 9, kCompareError = 10;
  std::array<std::uint32_t, 5> word{};
  for (unsigned i = 0; i < word.size(); ++i) (void)core_->peek(table + 4 * i, 4, word[i]);
  if (core_->lowest_sp() < CortexM0::kRamBase + 0xC0) violation("IAP: called with the stack at the end of RAM");
  if (core_->reg(13) > CortexM0::kRamBase + kRamBytes - 32) violation("IAP: stack within the 32 bytes of RAM that the ROM uses");
  const auto interruptible = [&] {
    if (core_->interruptible()) violation("IAP: flash written or erased with interrupts on, whose program is in that flash");
  };
  const auto sectors_good = [&](std::uint32_t first, std::uint32_t last) {
    return first <= last && last < kFlashBytes / kFlashSectorBytes;
  };
  const auto clock_good = [&](std::uint32_t khz) {
    if (khz != clock_hz_ / 1000)
      violation("IAP: told a clock of " + std::to_string(khz) + " kHz, it is " + std::to_string(clock_hz_ / 1000));
  };
  switch (word[0]) {
    case 50:
      if (!sectors_good(word[1], word[2])) return kInvalidSector;
      prepared_ = 0;
      for (std::uint32_t s = word[1]; s <= word[2]; ++s) prepared_ |= 1U << s;
      return kDone;
    case 51: {
      interruptible();
      clock_good(word[4]);
      if ((word[1] & 0xFFU) != 0 || word[1] >= kFlashBytes) return kDestinationAlign;
      if ((word[2] & 3U) != 0) return kSourceAlign;
      if (word[3] != 256 && word[3] != 512 && word[3] != 1024 && word[3] != 4096) return kCountWrong;
      const std::uint32_t sector = word[1] / kFlashSectorBytes;
      if ((prepared_ & (1U << sector)) == 0) return kNotPrepared;
      return iap_write(word[1], word[2], word[3]);
    }
    case 52: {
      interruptible();
      clock_good(word[3]);
      if (!sectors_good(word[1], word[2])) return kInvalidSector;
      for (std::uint32_t s = word[1]; s <= word[2]; ++s)
        if ((prepared_ & (1U << s)) == 0) return kNotPrepared;
      return iap_erase(word[1], word[2]);
    }
    case 53:
      if (!sectors_good(word[1], word[2])) return kInvalidSector;
      for (std::size_t i = word[1] * kFlashSectorBytes; i < (word[2] + 1) * kFlashSectorBytes; ++i)
        if (flash_[i] != 0xFF) {
          (void)core_->poke(result + 4, 4, static_cast<std::uint32_t>(i & ~3U));
          return kNotBlank;
        }
      return kDone;
    case 54:
      (void)core_->poke(result + 4, 4, kDeviceId);
      return kDone;
    case 56: {
      if (((word[1] | word[2] | word[3]) & 3U) != 0) return kCountWrong;
      for (std::uint32_t i = 0; i < word[3]; ++i) {
        std::uint32_t a = 0, b = 0;
        if (!core_->peek(word[1] + i, 1, a) || !core_->peek(word[2] + i, 1, b) || a != b) {
          (void)core_->poke(result + 4, 4, i);
          return kCompareError;
        }
      }
      return kDone;
    }
    case 57:
      violation("IAP: ROM loader asked for: not modelled");
      return kDone;
    case 58:
      // No two chips have the same one: here it follows from the name.
      for (unsigned i = 0; i < 4; ++i)
        (void)core_->poke(result + 4 + 4 * i, 4, 0x48000000U + i + static_cast<std::uint32_t>(std::hash<std::string>{}(name())));
      return kDone;
    default:
      return kInvalidCommand;
  }
}

std::uint32_t Lpc11c24::iap_erase(std::uint32_t first, std::uint32_t last) {
  prepared_ = 0;
  const bool cut = cut_now();
  for (std::size_t i = first * kFlashSectorBytes; i < (last + 1) * kFlashSectorBytes; ++i) {
    // Cut half way: some cells are erased, some are not, some read either way.
    if (cut && (i * 2654435761U & 0x80U) != 0) {
      flash_[i] = static_cast<std::uint8_t>(flash_[i] | (i * 40503U & 0xFFU));
      continue;
    }
    flash_[i] = 0xFF;
    page_written_[i / kPageBytes] = cut;
  }
  stall_in_rom(kEraseTime_s);
  return 0;
}

std::uint32_t Lpc11c24::iap_write(std::uint32_t to, std::uint32_t from, std::uint32_t count) {
  prepared_ = 0;
  if (from >= CortexM0::kRamBase + kRamBytes - 32 - count && from < CortexM0::kRamBase + kRamBytes)
    violation("IAP: source reaches into the 32 bytes that the ROM uses");
  const bool cut = cut_now();
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint32_t byte = 0;
    if (!core_->peek(from + i, 1, byte) || from < CortexM0::kRamBase) {
      violation("IAP: source is not in RAM");
      return 4;
    }
    if (i % kPageBytes == 0) {
      if (page_written_[(to + i) / kPageBytes]) violation("IAP: page written twice without an erase between");
      page_written_[(to + i) / kPageBytes] = true;
    }
    if (cut && i >= count / 2) break;
    flash_[to + i] = static_cast<std::uint8_t>(flash_[to + i] & byte);
  }
  stall_in_rom(kWriteTime_s * count / kPageBytes);
  return 0;
}

}  // namespace hoist::machine
