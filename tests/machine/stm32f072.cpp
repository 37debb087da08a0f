#include "tests/machine/stm32f072.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>

namespace hoist::machine {
namespace {

constexpr std::uint32_t kInternal_hz = 8'000'000, kCrystal_hz = 8'000'000;
constexpr Time kCrystalStart = 2 * kMillisecond;    // data sheet, HSE oscillator: 2 ms
constexpr Time kPllLock = 200 * kMicrosecond;       // data sheet, PLL: 200 us at most
constexpr double kEraseTime_s = 0.040;              // data sheet: 20 to 40 ms a page
constexpr double kProgramTime_s = 60e-6;            // data sheet: 40 to 60 us a half-word
constexpr Time kConverterStart = 1 * kMicrosecond;  // data sheet: stabilisation time, 1 us
constexpr double kAdcReference_v = 3.3;
constexpr double kAdcClockMax_hz = 14e6;
constexpr unsigned kCalibrationClocks = 83, kEnableForgottenClocks = 4;
constexpr double kConvertClocks = 12.5;
constexpr std::array<double, 8> kSampleClocks{1.5, 7.5, 13.5, 28.5, 41.5, 55.5, 71.5, 239.5};
constexpr double kSlowUpdateClocks = 5.0;  // RM0091: PVU and RVU last up to five clocks of the slow oscillator

constexpr std::uint32_t kTimer2 = 0x40000000, kTimer3 = 0x40000400, kWatchdog = 0x40003000, kI2c1 = 0x40005400, kCan = 0x40006400,
                        kSyscfg = 0x40010000, kAdc = 0x40012400, kTimer1 = 0x40012C00, kSpi1 = 0x40013000, kUsart1 = 0x40013800,
                        kDebug = 0x40015800, kRcc = 0x40021000, kFlashRegisters = 0x40022000, kGpio = 0x48000000,
                        kSystemMemory = 0x1FFFC800, kSystemMemoryEnd = 0x1FFFF800;

// Interrupt numbers, RM0091 table 37.
constexpr unsigned kIrqAdc = 12, kIrqTimer1Update = 13, kIrqTimer2 = 15, kIrqTimer3 = 16, kIrqI2c1 = 23, kIrqSpi1 = 25, kIrqUsart1 = 27,
                   kIrqCan = 30;

enum class Bus : std::uint8_t { ahb, apb1, apb2 };
struct Gate {
  std::uint32_t base;
  Bus bus;
  unsigned bit;
  const char* name;
};
constexpr std::array<Gate, 10> kGates{{{kTimer2, Bus::apb1, 0, "TIM2"},
                                       {kTimer3, Bus::apb1, 1, "TIM3"},
                                       {kI2c1, Bus::apb1, 21, "I2C1"},
                                       {kCan, Bus::apb1, 25, "bxCAN"},
                                       {kSyscfg, Bus::apb2, 0, "SYSCFG"},
                                       {kAdc, Bus::apb2, 9, "ADC"},
                                       {kTimer1, Bus::apb2, 11, "TIM1"},
                                       {kSpi1, Bus::apb2, 12, "SPI1"},
                                       {kUsart1, Bus::apb2, 14, "USART1"},
                                       {kDebug, Bus::apb2, 22, "DBGMCU"}}};
constexpr std::uint32_t kAhbKnown = 0x017E0057, kApb1Known = 0x7AFE4933, kApb2Known = 0x00475A01;

// Alternate functions that carry something here (data sheet, tables 15 and 16).
constexpr unsigned kPortA = 0, kPortB = 1;
struct TimerPin {
  PinPlace place;
  unsigned function, timer, channel;
};
constexpr std::array<TimerPin, 8> kTimerPins{{{{kPortA, 8}, 2, 0, 0},
                                              {{kPortA, 9}, 2, 0, 1},
                                              {{kPortA, 10}, 2, 0, 2},
                                              {{kPortA, 0}, 2, 1, 0},
                                              {{kPortA, 1}, 2, 1, 1},
                                              {{kPortA, 2}, 2, 1, 2},
                                              {{kPortA, 6}, 1, 2, 0},
                                              {{kPortA, 7}, 1, 2, 1}}};
// Outputs of other blocks: CAN, SPI, USART, I2C.
struct BlockPin {
  PinPlace place;
  unsigned function;
};
constexpr std::array<BlockPin, 5> kBlockOutputs{
    {{{kPortB, 9}, 4}, {{kPortA, 5}, 0}, {{kPortA, 7}, 0}, {{kPortA, 9}, 1}, {{kPortA, 12}, 1}}};

constexpr unsigned kModeInput = 0, kModeOutput = 1, kModeAlternate = 2, kModeAnalog = 3;

std::string hex(std::uint32_t value) {
  std::array<char, 12> text{};
  std::snprintf(text.data(), text.size(), "%X", value);
  return text.data();
}
std::string pin_name(PinPlace at) { return std::string("P") + static_cast<char>('A' + at.port) + std::to_string(at.bit); }

}  // namespace

Stm32f072::Stm32f072(std::string name, std::span<const std::uint8_t> flash)
    : Chip(std::move(name), flash, kFlashSize, kSramSize, {kFlashBase, kSramBase, 0, 0}),
      can_(complain_),
      i2c_(complain_),
      spi_(complain_),
      usart_(complain_),
      timers_{Stm32Timer("TIM1", true, false, complain_), Stm32Timer("TIM2", false, true, complain_),
              Stm32Timer("TIM3", false, false, complain_)} {}

void Stm32f072::reset_blocks(ResetCause cause) {
  // CSR: every cause but the power itself comes with the pin's flag, because the chip pulls its own reset line.
  constexpr std::array<std::uint32_t, 5> kStatus{1U << 27, 0, 1U << 29, 1U << 27, 1U << 28};
  if (cause == ResetCause::power_on) reset_status_ = 0;
  reset_status_ |= kStatus[static_cast<std::size_t>(cause)] | (1U << 26);
  clock_control_ = 0x8083;  // HSI on and ready, trimmed to the middle; some calibration value
  clock_configuration_ = 0;
  ahb_clocks_ = 0x14;
  apb1_clocks_ = apb2_clocks_ = predivider_ = clock_sources_ = 0;
  crystal_ready_at_ = pll_ready_at_ = kNever;
  memory_mode_ = 0;  // BOOT0 low: main flash
  core_->show_at_zero(flash_);
  ports_ = {};
  ports_[kPortA] = {0x28000000, 0, 0x0C000000, 0x24000000, 0, 0, 0};  // SWD
  flash_access_ = 0x30;                                               // prefetch on after reset, as its status says
  flash_status_ = flash_address_ = 0;
  flash_control_ = 0x80;
  flash_key_ = 0;
  flash_blocked_ = false;
  converter_ = Converter::off;
  converter_at_ = adc_due_ = adc_begins_ = kNever;
  adc_status_ = adc_interrupts_ = adc_configuration1_ = adc_configuration2_ = adc_sampling_ = adc_channels_ = adc_data_ = adc_common_ = 0;
  adc_threshold_ = 0x0FFF0000;
  adc_started_ = false;
  iwdg_prescale_ = 0;
  iwdg_reload_ = iwdg_window_ = 0xFFF;
  iwdg_unlocked_ = false;
  iwdg_prescale_at_ = iwdg_reload_at_ = 0;
  iwdg_deadline_ = kNever;
  can_.reset();
  i2c_.reset();
  spi_.reset();
  usart_.reset();
  for (Stm32Timer& timer : timers_) timer.reset();
  update_clock();
  update_pins();
}

// ---------------------------------------------------------------- time

Time Stm32f072::next_block_event() const {
  Time next = std::min({i2c_.next(), spi_.next(), usart_.next(), adc_due_, converter_at_, iwdg_deadline_});
  for (const Stm32Timer& timer : timers_) next = std::min(next, timer.next());
  return next;
}

void Stm32f072::advance_blocks(Time until) {
  i2c_.advance(until);
  spi_.advance(until);
  usart_.advance(until);
  for (Stm32Timer& timer : timers_) timer.advance(until);
  if (converter_at_ <= until) {
    if (converter_ == Converter::calibrating) {
      converter_ = Converter::off;
      calibrated_at_ = converter_at_;
    } else if (converter_ == Converter::starting) {
      converter_ = Converter::ready;
      adc_status_ |= 1U;
    }
    converter_at_ = kNever;
  }
  if (trigger_changes_ != timers_[0].changes()) await_trigger();
  if (adc_due_ <= until) end_conversion(adc_due_);
  if (iwdg_deadline_ <= until) {
    iwdg_deadline_ = kNever;
    reset_wanted_ = ResetCause::watchdog;
  }
}

std::uint32_t Stm32f072::lines() {
  std::uint32_t lines = 0;
  if ((adc_status_ & adc_interrupts_) != 0) lines |= 1U << kIrqAdc;
  if (timers_[0].line()) lines |= 1U << kIrqTimer1Update;
  if (timers_[1].line()) lines |= 1U << kIrqTimer2;
  if (timers_[2].line()) lines |= 1U << kIrqTimer3;
  if (i2c_.line()) lines |= 1U << kIrqI2c1;
  if (spi_.line()) lines |= 1U << kIrqSpi1;
  if (usart_.line()) lines |= 1U << kIrqUsart1;
  if (can_.line()) lines |= 1U << kIrqCan;
  return lines;
}

// ---------------------------------------------------------------- access

bool Stm32f072::clocked(std::uint32_t address) {
  const std::uint32_t base = address & ~0x3FFU;
  for (const Gate& gate : kGates) {
    if (gate.base != base) continue;
    const std::uint32_t clocks = gate.bus == Bus::apb1 ? apb1_clocks_ : apb2_clocks_;
    if ((clocks & (1U << gate.bit)) != 0) return true;
    violation(std::string(gate.name) + " touched without its clock");
    return false;
  }
  if (address >= kGpio && address < kGpio + 0x400 * kPorts && (ahb_clocks_ & (1U << (17 + (address - kGpio) / 0x400))) == 0) {
    violation(std::string("port ") + static_cast<char>('A' + (address - kGpio) / 0x400) + " touched without its clock");
    return false;
  }
  return true;
}

std::uint32_t Stm32f072::read_system_memory(std::uint32_t address, unsigned size) {
  // Unique number, which follows from the name here: no two chips have the same one; calibration at 30 and 110 degrees C and of the reference, at 3.3 V; size of the flash in KB.
  struct Place {
    std::uint32_t at;
    std::uint32_t value;
  };
  const std::array<Place, 6> kWords{{{0x1FFFF7AC, 0x00320045U ^ static_cast<std::uint32_t>(std::hash<std::string>{}(name()))},
                                     {0x1FFFF7B0, 0x30385114},
                                     {0x1FFFF7B4, 0x20343253},
                                     {0x1FFFF7B8, 1775U | (1526U << 16)},
                                     {0x1FFFF7C0, 1348U << 16},
                                     {0x1FFFF7CC, 128}}};
  for (const Place& place : kWords)
    if ((address & ~3U) == place.at && (address & 3U) + size <= 4) return place.value >> (8 * (address & 3U));
  violation("system memory read at " + hex(address) + ": not modelled");
  return 0xFFFFFFFF;
}

bool Stm32f072::read(std::uint32_t address, unsigned size, std::uint32_t& value) {
  value = 0;
  catch_up();
  if (address >= kSystemMemory && address < kSystemMemoryEnd) {
    value = read_system_memory(address, size);
    return true;
  }
  if (address < 0x40000000 || address >= kGpio + 0x400 * kPorts) return false;
  if (!clocked(address)) return true;
  if (!read_block(address, size, value)) {
    violation("read at " + hex(address) + ": block that does not exist or is not modelled");
    return false;
  }
  update_lines();
  return true;
}

bool Stm32f072::read_block(std::uint32_t address, unsigned size, std::uint32_t& value) {
  const std::uint32_t base = address & ~0x3FFU, offset = address & 0x3FCU;
  if (base == kSpi1 && offset == 0x0C) {
    value = spi_.read(offset, size);
    return true;
  }
  if (base >= kGpio) {
    value = read_gpio((base - kGpio) / 0x400, offset) >> (8 * (address & 3U));
    return true;
  }
  if (size != 4) violation("peripheral register read that is not a word: " + hex(address));
  switch (base) {
    case kTimer1:
      value = timers_[0].read(offset, now_);
      return true;
    case kTimer2:
      value = timers_[1].read(offset, now_);
      return true;
    case kTimer3:
      value = timers_[2].read(offset, now_);
      return true;
    case kWatchdog:
      value = read_iwdg(offset);
      return true;
    case kI2c1:
      value = i2c_.read(offset, now_);
      return true;
    case kCan:
      value = can_.read(offset, core_->cycles());
      return true;
    case kSyscfg:
      value = read_syscfg(offset);
      return true;
    case kAdc:
      value = read_adc(offset);
      return true;
    case kSpi1:
      value = spi_.read(offset, size);
      return true;
    case kUsart1:
      value = usart_.read(offset);
      return true;
    case kDebug:
      if (offset != 0) return false;
      value = 0x20016448;  // IDCODE: STM32F07x, revision
      return true;
    case kRcc:
      value = read_rcc(offset);
      return true;
    case kFlashRegisters:
      value = read_flash_registers(offset);
      return true;
    default:
      return false;
  }
}

bool Stm32f072::write(std::uint32_t address, unsigned size, std::uint32_t value) {
  catch_up();
  if (address >= kFlashBase && address < kFlashBase + kFlashSize) {
    program_flash(address, size, value);
    update_lines();
    return true;
  }
  if (address < 0x40000000 || address >= kGpio + 0x400 * kPorts) return false;
  if (!clocked(address)) return true;
  if (!write_block(address, size, value)) {
    violation("write at " + hex(address) + ": block that does not exist or is not modelled");
    return false;
  }
  update_lines();
  return true;
}

bool Stm32f072::write_block(std::uint32_t address, unsigned size, std::uint32_t value) {
  const std::uint32_t base = address & ~0x3FFU, offset = address & 0x3FCU;
  if (base == kSpi1 && offset == 0x0C) {
    spi_.write(offset, size, value, now_, clock_hz_);
    return true;
  }
  if (size != 4) violation("peripheral register write that is not a word: " + hex(address));
  if (base >= kGpio) {
    write_gpio((base - kGpio) / 0x400, offset, value);
    return true;
  }
  switch (base) {
    case kTimer1:
      timers_[0].write(offset, value, now_, clock_hz_);
      await_trigger();
      update_pins();
      return true;
    case kTimer2:
      timers_[1].write(offset, value, now_, clock_hz_);
      return true;
    case kTimer3:
      timers_[2].write(offset, value, now_, clock_hz_);
      return true;
    case kWatchdog:
      write_iwdg(offset, value);
      return true;
    case kI2c1:
      i2c_.write(offset, value, now_, (clock_sources_ & 0x10U) != 0 ? clock_hz_ : kInternal_hz);
      return true;
    case kCan:
      can_.write(offset, value, core_->cycles(), clock_hz_);
      return true;
    case kSyscfg:
      write_syscfg(offset, value);
      return true;
    case kAdc:
      write_adc(offset, value);
      return true;
    case kSpi1:
      spi_.write(offset, size, value, now_, clock_hz_);
      return true;
    case kUsart1:
      usart_.write(offset, value, now_, clock_hz_);
      return true;
    case kRcc:
      write_rcc(offset, value);
      return true;
    case kFlashRegisters:
      write_flash_registers(offset, value);
      return true;
    default:
      return false;
  }
}

// ---------------------------------------------------------------- clocks

void Stm32f072::update_clock() {
  const std::uint32_t source = clock_configuration_ & 3U;
  std::uint32_t hz = kInternal_hz;
  if (source == 1) hz = kCrystal_hz;
  if (source == 2) {
    const std::uint32_t from = (clock_configuration_ >> 15) & 3U;
    std::uint32_t in = kInternal_hz / 2;
    if (from == 2) in = kCrystal_hz / ((predivider_ & 0xFU) + 1);
    if (from == 1) in = kInternal_hz / ((predivider_ & 0xFU) + 1);
    if (from == 3) violation("RCC: PLL from HSI48: not modelled");
    hz = in * std::min<std::uint32_t>(((clock_configuration_ >> 18) & 0xFU) + 2, 16);
    if (in < 1'000'000 || in > 24'000'000) violation("RCC: PLL input of " + std::to_string(in) + " Hz, 1 to 24 MHz");
    if (hz < 16'000'000) violation("RCC: PLL at " + std::to_string(hz) + " Hz, 16 MHz is the least");
  }
  if (hz > 48'000'000) violation("RCC: system clock of " + std::to_string(hz) + " Hz, 48 MHz is the most");
  set_clock(std::min<std::uint32_t>(hz, 48'000'000));
  const std::uint32_t waits = flash_access_ & 7U;
  if (waits > 1) violation("FLASH_ACR: reserved number of wait states");
  if (hz > 24'000'000 && waits == 0) violation("FLASH_ACR: 0 wait states at " + std::to_string(hz) + " Hz");
  core_->set_flash_waits(waits);
}

std::uint32_t Stm32f072::read_rcc(std::uint32_t offset) {
  switch (offset) {
    case 0x00:
      return clock_control_ | (crystal_ready_at_ <= now_ ? 1U << 17 : 0U) | (pll_ready_at_ <= now_ ? 1U << 25 : 0U);
    case 0x04:
      return clock_configuration_ | ((clock_configuration_ & 3U) << 2);
    case 0x14:
      return ahb_clocks_;
    case 0x18:
      return apb2_clocks_;
    case 0x1C:
      return apb1_clocks_;
    case 0x24:
      return reset_status_ | (iwdg_deadline_ != kNever ? 2U : 0U);
    case 0x2C:
      return predivider_;
    case 0x30:
      return clock_sources_;
    default:
      violation("RCC: read of register " + hex(offset) + ", which does not exist or is not modelled");
      return 0;
  }
}

void Stm32f072::write_clock_control(std::uint32_t value) {
  if ((value & ~0x030FFFFBU) != 0) violation("RCC: reserved bits of CR");
  if ((value & 0x000C0000U) != 0) violation("RCC: bypassed or supervised crystal: not modelled");
  const std::uint32_t source = clock_configuration_ & 3U;
  const bool internal = (value & 1U) != 0, crystal = (value & (1U << 16)) != 0, pll = (value & (1U << 24)) != 0;
  if (!internal && source == 0) violation("RCC: internal oscillator switched off while it is the system clock");
  if (!pll && source == 2) violation("RCC: PLL switched off while it is the system clock");
  if (!crystal && (source == 1 || (source == 2 && ((clock_configuration_ >> 15) & 3U) == 2)))
    violation("RCC: crystal switched off while the system clock comes from it");
  if (pll && pll_ready_at_ == kNever) {
    if (((clock_configuration_ >> 15) & 3U) == 2 && crystal_ready_at_ > now_) violation("RCC: PLL switched on before its crystal is ready");
    pll_ready_at_ = now_ + kPllLock;
  }
  if (!pll) pll_ready_at_ = kNever;
  if (crystal && crystal_ready_at_ == kNever && !crystal_broken_) crystal_ready_at_ = now_ + kCrystalStart;
  if (!crystal) crystal_ready_at_ = kNever;
  clock_control_ = (value & 0x010100F9U) | 0x8000U | (internal ? 2U : 0U);
}

void Stm32f072::write_clock_configuration(std::uint32_t value) {
  constexpr std::uint32_t kPllBits = 0x003F8000U | (1U << 17);
  if ((value & 0x00C03800U) != 0) violation("RCC: reserved bits of CFGR");
  if ((value & 0xFF0047F0U) != 0) violation("RCC: bus dividers or clock output: not modelled");
  if (((value ^ clock_configuration_) & kPllBits) != 0 && pll_ready_at_ != kNever) violation("RCC: PLL changed while it is switched on");
  const std::uint32_t source = value & 3U;
  if (source == 3) violation("RCC: HSI48 as system clock: not modelled");
  if (source == 1 && crystal_ready_at_ > now_) violation("RCC: system clock taken from the crystal before it is ready");
  if (source == 2 && pll_ready_at_ > now_) violation("RCC: system clock taken from the PLL before it has locked");
  clock_configuration_ = value & ~0xCU;
  update_clock();
}

void Stm32f072::write_rcc(std::uint32_t offset, std::uint32_t value) {
  const auto known = [&](std::uint32_t bits, const char* what) {
    if ((value & ~bits) != 0) violation(std::string("RCC: reserved bits of ") + what);
    return value & bits;
  };
  switch (offset) {
    case 0x00:
      write_clock_control(value);
      return;
    case 0x04:
      write_clock_configuration(value);
      return;
    case 0x14:
      ahb_clocks_ = known(kAhbKnown, "AHBENR");
      return;
    case 0x18:
      apb2_clocks_ = known(kApb2Known, "APB2ENR");
      return;
    case 0x1C:
      apb1_clocks_ = known(kApb1Known, "APB1ENR");
      return;
    case 0x24:
      if ((value & 0x007FFFFCU) != 0) violation("RCC: reserved bits of CSR");
      if ((value & (1U << 24)) != 0) reset_status_ = 0;
      return;
    case 0x2C:
      if (pll_ready_at_ != kNever) violation("RCC: PLL changed while it is switched on");
      predivider_ = known(0xF, "CFGR2");
      return;
    case 0x30:
      clock_sources_ = known(0x000300D3, "CFGR3");
      if ((clock_sources_ & ~0x10U) != 0) violation("RCC: CFGR3 asks for what is not modelled");
      return;
    default:
      violation("RCC: write to register " + hex(offset) + ", which does not exist or is not modelled");
  }
}

std::uint32_t Stm32f072::read_syscfg(std::uint32_t offset) {
  if (offset != 0) violation("SYSCFG: read of register " + hex(offset) + ", which does not exist or is not modelled");
  return memory_mode_;
}
void Stm32f072::write_syscfg(std::uint32_t offset, std::uint32_t value) {
  if (offset != 0 || (value & ~3U) != 0) {
    violation("SYSCFG: register " + hex(offset) + " asks for what is not modelled");
    return;
  }
  memory_mode_ = value;
  switch (value) {
    case 0:
    case 2:
      core_->show_at_zero(flash_);
      return;
    case 3:
      core_->show_at_zero(ram_);
      return;
    default:
      violation("SYSCFG: system memory at address 0: not modelled");
  }
}

// ---------------------------------------------------------------- pins

// LQFP48: all of ports A and B, PC13 to PC15, PF0 and PF1.
bool Stm32f072::bonded(unsigned port, unsigned bit) {
  if (port <= kPortB) return true;
  return (port == 2 && bit >= 13) || (port == 5 && bit <= 1);
}
bool Stm32f072::has_function(PinPlace at, unsigned function) const {
  const Port& port = ports_[at.port];
  const std::uint32_t chosen = ((at.bit < 8 ? port.alternate_low : port.alternate_high) >> (4 * (at.bit & 7U))) & 0xFU;
  return mode_of(at) == kModeAlternate && chosen == function;
}
std::optional<double> Stm32f072::timer_output(PinPlace at) const {
  for (const TimerPin& pin : kTimerPins)
    if (pin.place.port == at.port && pin.place.bit == at.bit && has_function(at, pin.function) && timers_[pin.timer].drives(pin.channel))
      return timers_[pin.timer].high_share(pin.channel);
  return std::nullopt;
}
bool Stm32f072::output(PinPlace at) {
  for (const TimerPin& pin : kTimerPins)
    if (pin.place.port == at.port && pin.place.bit == at.bit && has_function(at, pin.function) && timers_[pin.timer].drives(pin.channel))
      return timers_[pin.timer].output(pin.channel, now_);
  return pin_driven_by_chip(at) && pin(at);
}
bool Stm32f072::pin_driven_by_chip(PinPlace at) const {
  if (!powered_) return false;
  const std::uint32_t bit = 1U << at.bit;
  const Port& port = ports_[at.port];
  if (mode_of(at) == kModeOutput) return (port.open_drain & bit) == 0 || (port.out & bit) == 0;
  if (timer_output(at)) return true;
  return std::any_of(kBlockOutputs.begin(), kBlockOutputs.end(), [&](const BlockPin& pin) {
    return pin.place.port == at.port && pin.place.bit == at.bit && has_function(at, pin.function);
  });
}
double Stm32f072::pin_high_share(PinPlace at) const {
  if (powered_)
    if (const auto share = timer_output(at)) return *share;
  return pin(at) ? 1.0 : 0.0;
}
bool Stm32f072::pin(PinPlace at) const {
  const std::uint32_t bit = 1U << at.bit;
  const Port& port = ports_[at.port];
  if (powered_ && mode_of(at) == kModeOutput && ((port.open_drain & bit) == 0 || (port.out & bit) == 0)) return (port.out & bit) != 0;
  if (powered_)
    if (const auto share = timer_output(at)) return *share >= 0.5;
  if ((outside_[at.port].driven & bit) != 0) return (outside_[at.port].level & bit) != 0;
  return powered_ && ((port.pull >> (2 * at.bit)) & 3U) == 1;
}

void Stm32f072::update_timer_inputs() {
  std::array<std::uint32_t, 3> levels{};
  for (const TimerPin& each : kTimerPins)
    if (has_function(each.place, each.function) && !timers_[each.timer].drives(each.channel) && pin(each.place))
      levels[each.timer] |= 1U << each.channel;
  for (std::size_t i = 0; i < timers_.size(); ++i) timers_[i].set_inputs(levels[i], now_);
}

void Stm32f072::pins_changed(unsigned port) {
  touched_ = true;
  if (port == kPortA) update_timer_inputs();
}

void Stm32f072::connect_spi(SpiDevice* device, PinPlace select) {
  spi_device_ = device;
  select_ = select;
  spi_.connect(device);
}

void Stm32f072::update_pins() {
  i2c_.set_pins(has_function({kPortB, 6}, 1) && has_function({kPortB, 7}, 1) && (ports_[kPortB].open_drain & 0xC0U) == 0xC0U);
  // Data sheet, I/O AC characteristics: low, medium and high speed; bit 0 clear is low for any bit 1.
  constexpr std::array<std::uint32_t, 4> kEdge_hz{2'000'000, 10'000'000, 2'000'000, 50'000'000};
  const auto edge_hz = [&](unsigned bit) { return kEdge_hz[(ports_[kPortA].speed >> (2 * bit)) & 3U]; };
  spi_.set_pins(has_function({kPortA, 5}, 0) && has_function({kPortA, 6}, 0) && has_function({kPortA, 7}, 0),
                std::min(edge_hz(5), edge_hz(7)));
  can_.set_pins(has_function({kPortB, 8}, 4) && has_function({kPortB, 9}, 4));
  usart_.set_pins(has_function({kPortA, 10}, 1), has_function({kPortA, 9}, 1), has_function({kPortA, 12}, 1),
                  has_function({kPortA, 11}, 1));
  constexpr PinPlace kRts{kPortA, 12};
  usart_.set_rts_output(mode_of(kRts) == kModeOutput, pin(kRts));
  if (spi_device_ != nullptr) {
    const bool low = pin_driven_by_chip(select_) && !pin(select_);
    if (low != selected_) {
      selected_ = low;
      spi_device_->spi_select(low, now_);
    }
  }
  update_timer_inputs();
}

std::uint32_t Stm32f072::read_gpio(unsigned number, std::uint32_t offset) {
  const Port& port = ports_[number];
  switch (offset) {
    case 0x00:
      return port.mode;
    case 0x04:
      return port.open_drain;
    case 0x08:
      return port.speed;
    case 0x0C:
      return port.pull;
    case 0x10: {
      std::uint32_t value = 0;
      for (unsigned bit = 0; bit < kPortBits; ++bit)
        if (mode_of({number, bit}) != kModeAnalog && pin({number, bit})) value |= 1U << bit;  // analog: the digital input is off
      return value;
    }
    case 0x14:
      return port.out;
    case 0x20:
      return port.alternate_low;
    case 0x24:
      return port.alternate_high;
    default:
      violation("GPIO: read of register " + hex(offset) + ", which is write-only, does not exist or is not modelled");
      return 0;
  }
}

void Stm32f072::write_pin_modes(unsigned number, std::uint32_t value) {
  Port& port = ports_[number];
  for (unsigned bit = 0; bit < kPortBits; ++bit) {
    const unsigned before = (port.mode >> (2 * bit)) & 3U, after = (value >> (2 * bit)) & 3U;
    if (before == after) continue;
    const PinPlace at{number, bit};
    if (!bonded(number, bit)) violation("pin " + pin_name(at) + " does not exist in this package");
    if (number == kPortA && (bit == 13 || bit == 14)) violation("SWD pin " + pin_name(at) + " switched away from the debugger");
    if (number == 5) violation("pin " + pin_name(at) + " carries the crystal");
    const bool open_drain = (port.open_drain & (1U << bit)) != 0;
    if (after == kModeOutput && !open_drain && (outside_[number].driven & (1U << bit)) != 0)
      violation("pin " + pin_name(at) + " made an output against something that drives it");
  }
  port.mode = value;
}

void Stm32f072::write_gpio(unsigned number, std::uint32_t offset, std::uint32_t value) {
  Port& port = ports_[number];
  const std::uint32_t before = port.out;
  const auto low_half = [&](std::uint32_t from) {
    if ((from & ~0xFFFFU) != 0) violation("GPIO: reserved bits of register " + hex(offset));
    return from & 0xFFFFU;
  };
  switch (offset) {
    case 0x00:
      write_pin_modes(number, value);
      break;
    case 0x04:
      port.open_drain = low_half(value);
      break;
    case 0x08:
      port.speed = value;
      break;
    case 0x0C:
      if ((value & (value >> 1) & 0x55555555U) != 0) violation("GPIO: reserved pull of a pin");
      port.pull = value;
      break;
    case 0x14:
      port.out = low_half(value);
      break;
    case 0x18:
      port.out = (port.out & ~(value >> 16)) | (value & 0xFFFFU);  // a bit that is set and reset is set
      break;
    case 0x20:
    case 0x24:
      if (number == 5 || (value & 0x88888888U) != 0) violation("GPIO: alternate function that does not exist");
      (offset == 0x20 ? port.alternate_low : port.alternate_high) = value;
      break;
    case 0x28:
      port.out &= ~low_half(value);
      break;
    default:
      violation("GPIO: write to register " + hex(offset) + ", which is read-only, does not exist or is not modelled");
      return;
  }
  outputs_written(number, before, port.out);
  update_pins();
}

// The power-down reset at 1.88 V holds the chip until the supply is above 1.92 V (data sheet); it is always on.
void Stm32f072::set_supply(double volts) {
  if (volts < 1.88 && powered_) {
    held_in_reset_ = true;
    power_off();
  } else if (volts > 1.92 && held_in_reset_) {
    held_in_reset_ = false;
    reset(ResetCause::brown_out);
  }
}

// ---------------------------------------------------------------- flash

std::uint32_t Stm32f072::read_flash_registers(std::uint32_t offset) {
  switch (offset) {
    case 0x00:
      return (flash_access_ & ~0x20U) | ((flash_access_ & 0x10U) << 1);
    case 0x0C:
      return flash_status_;
    case 0x10:
      return flash_control_;
    case 0x1C:
      return 0x03FFFC00;  // OBR: nothing protected
    case 0x20:
      return 0xFFFFFFFF;
    default:
      violation("FLASH: read of register " + hex(offset) + ", which is write-only, does not exist or is not modelled");
      return 0;
  }
}

void Stm32f072::write_flash_registers(std::uint32_t offset, std::uint32_t value) {
  constexpr std::uint32_t kProgram = 1, kErasePage = 2, kEraseAll = 4, kStart = 0x40, kLock = 0x80;
  switch (offset) {
    case 0x00:
      if ((value & ~0x3FU) != 0) violation("FLASH: reserved bits of ACR");
      if (((value ^ flash_access_) & 0x10U) != 0 && clock_hz_ > 24'000'000) violation("FLASH: prefetch switched above 24 MHz");
      flash_access_ = value & 0x1FU;
      update_clock();
      return;
    case 0x04: {
      constexpr std::array<std::uint32_t, 2> kKeys{0x45670123, 0xCDEF89AB};
      if (flash_blocked_ || flash_key_ >= 2 || (flash_control_ & kLock) == 0 || value != kKeys[static_cast<std::size_t>(flash_key_)]) {
        violation("FLASH: wrong key");
        flash_blocked_ = true;
        flash_key_ = 0;
        return;
      }
      if (++flash_key_ == 2) {
        flash_key_ = 0;
        flash_control_ &= ~kLock;
      }
      return;
    }
    case 0x0C:
      if ((value & ~0x34U) != 0) violation("FLASH: reserved or read-only bits of SR");
      flash_status_ &= ~(value & 0x34U);
      return;
    case 0x10:
      if ((value & ~0x36F7U) != 0) violation("FLASH: reserved bits of CR");
      if ((flash_control_ & kLock) != 0 && value != kLock) {
        violation("FLASH: CR written while it is locked");
        return;
      }
      if ((value & (kEraseAll | 0x3630U)) != 0) violation("FLASH: option bytes, mass erase or interrupts: not modelled");
      if (std::popcount(value & (kProgram | kErasePage | kEraseAll)) > 1) violation("FLASH: several operations chosen at once");
      flash_control_ = value & ~kStart;
      if ((value & kStart) == 0) return;
      if ((value & kErasePage) == 0)
        violation("FLASH: STRT without PER");
      else
        erase_page();
      return;
    case 0x14:
      if ((flash_control_ & kLock) != 0) violation("FLASH: AR written while it is locked");
      flash_address_ = value;
      return;
    default:
      violation("FLASH: write to register " + hex(offset) + ", which is read-only, does not exist or is not modelled");
  }
}

// A fetch from busy flash stalls the core until the operation is over.
void Stm32f072::wait_for_flash(double seconds) {
  if (!((clock_control_ & 1U) != 0)) violation("FLASH: changed while the internal oscillator is off");
  stall(seconds);
  if (iwdg_deadline_ <= now_) {
    iwdg_deadline_ = kNever;
    reset_wanted_ = ResetCause::watchdog;
  }
}

void Stm32f072::erase_page() {
  if (flash_address_ < kFlashBase || flash_address_ >= kFlashBase + kFlashSize) {
    violation("FLASH: page outside the flash");
    return;
  }
  const std::size_t from = (flash_address_ - kFlashBase) / kFlashPage * kFlashPage;
  const bool cut = cut_now();
  for (std::size_t i = from; i < from + kFlashPage; ++i) {
    // Cut half way: some cells are erased, some are not, some read either way.
    if (cut && (i * 2654435761U & 0x80U) != 0)
      flash_[i] = static_cast<std::uint8_t>(flash_[i] | (i * 40503U & 0xFFU));
    else
      flash_[i] = 0xFF;
  }
  wait_for_flash(kEraseTime_s);
  flash_status_ |= 0x20U;
}

void Stm32f072::program_flash(std::uint32_t address, unsigned size, std::uint32_t value) {
  if ((flash_control_ & 0x80U) != 0 || (flash_control_ & 1U) == 0) {
    violation("FLASH: written at " + hex(address) + " without PG");
    return;
  }
  if (size != 2) {
    violation("FLASH: written by something else than half-words");
    return;
  }
  std::uint16_t held = 0;
  std::uint8_t* at = &flash_[address - kFlashBase];
  std::memcpy(&held, at, 2);
  if (held != 0xFFFF && value != 0) {  // only erased half-words, or zeros over anything
    flash_status_ |= 4U;
    violation("FLASH: half-word at " + hex(address) + " programmed without being erased (PGERR)");
    return;
  }
  const bool cut = cut_now();
  // Cut half way: some bits have not become zero.
  const auto stored = static_cast<std::uint16_t>(cut ? value | (address * 40503U & 0x5A5AU) : value);
  std::memcpy(at, &stored, 2);
  wait_for_flash(kProgramTime_s);
  flash_status_ |= 0x20U;
}

// ---------------------------------------------------------------- converter

Time Stm32f072::adc_clock() const {
  const std::uint32_t mode = adc_configuration2_ >> 30;
  if (mode == 0) return kSecond / 14'000'000;
  return unit_ * (mode == 1 ? 2 : 4);
}
Time Stm32f072::conversion_time() const {
  return static_cast<Time>((kSampleClocks[adc_sampling_ & 7U] + kConvertClocks) * static_cast<double>(adc_clock()));
}

double Stm32f072::channel_volts(unsigned channel, Time at) {
  constexpr double kTemperature_v = 1.43 + 5.0 * 0.0043, kReference_v = 1.23;  // at 25 degrees C
  constexpr double kLongSample_s = 4e-6;                                       // data sheet, for both
  if (channel >= 16) {
    if ((adc_common_ & (channel == 16 ? 1U << 23 : 1U << 22)) == 0 || channel == 18)
      violation("ADC: channel " + std::to_string(channel) + " converted without its source switched on");
    const double sample_s = kSampleClocks[adc_sampling_ & 7U] * static_cast<double>(adc_clock()) / static_cast<double>(kSecond);
    if (sample_s < kLongSample_s) violation("ADC: channel " + std::to_string(channel) + " needs 4 us of sampling");
    return channel == 16 ? kTemperature_v : kReference_v;
  }
  PinPlace place{kPortA, channel};
  if (channel >= 8) place = channel < 10 ? PinPlace{kPortB, channel - 8} : PinPlace{2, channel - 10};
  if (mode_of(place) != kModeAnalog) violation("ADC: pin " + pin_name(place) + " converted outside analog mode");
  if (((ports_[place.port].pull >> (2 * place.bit)) & 3U) != 0) violation("ADC: pin " + pin_name(place) + " has a pull resistor");
  return analog_ ? analog_(channel, at) : 0.0;
}

// The trigger that CFGR1 names: the rising edge of TIM1's channel 4.
void Stm32f072::await_trigger() {
  trigger_changes_ = timers_[0].changes();
  if (!adc_started_ || (adc_configuration1_ & 0xC00U) == 0) return;
  if (adc_begins_ <= now_ && adc_due_ != kNever) return;  // converting
  adc_begins_ = timers_[0].next_rise(3, now_);
  adc_due_ = adc_begins_ == kNever ? kNever : adc_begins_ + conversion_time();
}

void Stm32f072::start_conversion() {
  if (converter_ != Converter::ready) {
    violation("ADC: started before it is ready");
    return;
  }
  if (adc_channels_ == 0) violation("ADC: started without a channel");
  adc_started_ = true;
  adc_at_ = static_cast<unsigned>(std::countr_zero(adc_channels_));
  adc_due_ = kNever;
  if ((adc_configuration1_ & 0xC00U) != 0) {
    if ((adc_configuration1_ & 0xC00U) != 0x400U || ((adc_configuration1_ >> 6) & 7U) != 1)
      violation("ADC: trigger other than the rising edge of TIM1_CC4: not modelled");
    await_trigger();
    return;
  }
  adc_begins_ = now_;
  adc_due_ = now_ + conversion_time();
}

void Stm32f072::end_conversion(Time at) {
  const double volts = channel_volts(adc_at_, at);
  adc_data_ = static_cast<std::uint32_t>(std::clamp(std::floor(volts / kAdcReference_v * 4096.0), 0.0, 4095.0));
  if ((adc_status_ & 4U) != 0) {
    adc_status_ |= 0x10U;
    if ((adc_configuration1_ & 0x1000U) == 0) violation("ADC: overrun that keeps the old value: not modelled");
  }
  adc_status_ |= 4U | 2U;
  adc_due_ = adc_begins_ = kNever;
  const std::uint32_t behind = adc_channels_ & ~((2U << adc_at_) - 1U);
  if (behind != 0) {
    adc_at_ = static_cast<unsigned>(std::countr_zero(behind));
    adc_begins_ = at;
    adc_due_ = at + conversion_time();
    return;
  }
  adc_status_ |= 8U;
  adc_at_ = static_cast<unsigned>(std::countr_zero(adc_channels_));
  if ((adc_configuration1_ & 0xC00U) != 0)
    await_trigger();
  else
    adc_started_ = false;
}

std::uint32_t Stm32f072::read_adc(std::uint32_t offset) {
  switch (offset) {
    case 0x00:
      return adc_status_;
    case 0x04:
      return adc_interrupts_;
    case 0x08:
      return (converter_ == Converter::calibrating ? 1U << 31 : 0U) | (adc_started_ ? 4U : 0U) |
             (converter_ == Converter::ready || converter_ == Converter::starting ? 1U : 0U);
    case 0x0C:
      return adc_configuration1_;
    case 0x10:
      return adc_configuration2_;
    case 0x14:
      return adc_sampling_;
    case 0x20:
      return adc_threshold_;
    case 0x28:
      return adc_channels_;
    case 0x40:
      adc_status_ &= ~4U;
      return adc_data_;
    case 0x308:
      return adc_common_;
    default:
      violation("ADC: read of register " + hex(offset) + ", which does not exist");
      return 0;
  }
}

// All bits are set by software and taken back by hardware; zeros have no effect.
void Stm32f072::write_adc_control(std::uint32_t value) {
  constexpr std::uint32_t kOn = 1, kOff = 2, kStart = 4, kStop = 0x10, kCalibrate = 1U << 31;
  if ((value & ~(kOn | kOff | kStart | kStop | kCalibrate)) != 0) violation("ADC: reserved bits of CR");
  if ((value & kCalibrate) != 0) {
    if (converter_ != Converter::off) violation("ADC: calibrated while it is on");
    converter_ = Converter::calibrating;
    converter_at_ = now_ + kCalibrationClocks * adc_clock();
    return;
  }
  if ((value & kOff) != 0) {
    if (converter_ != Converter::ready || adc_started_) violation("ADC: switched off while it is off or converting");
    converter_ = Converter::off;
  }
  if ((value & kOn) != 0 && converter_ == Converter::calibrating) violation("ADC: switched on while calibrating");
  if ((value & kOn) != 0 && converter_ == Converter::off &&
      (calibrated_at_ == 0 || now_ >= calibrated_at_ + kEnableForgottenClocks * adc_clock())) {
    converter_ = Converter::starting;
    converter_at_ = now_ + kConverterStart;
  }
  if ((value & kStop) != 0) {
    if (!adc_started_) violation("ADC: stopped while it is not converting");
    adc_started_ = false;
    adc_due_ = adc_begins_ = kNever;
  }
  if ((value & kStart) != 0 && (value & kStop) == 0) {
    if (adc_started_) violation("ADC: started while converting");
    start_conversion();
  }
}

void Stm32f072::configure_adc(std::uint32_t offset, std::uint32_t value) {
  if (adc_started_) violation("ADC: register " + hex(offset) + " written while ADSTART is set");
  switch (offset) {
    case 0x0C:
      if ((value & 0x833E0200U) != 0) violation("ADC: reserved bits of CFGR1");
      if ((value & ~0x1DC0U) != 0) violation("ADC: CFGR1 asks for what is not modelled");
      adc_configuration1_ = value;
      return;
    case 0x10:
      if ((value & 0x3FFFFFFFU) != 0) violation("ADC: reserved bits of CFGR2");
      if (converter_ != Converter::off) violation("ADC: CKMODE changed while the converter is on");
      if ((value >> 30) == 3) violation("ADC: reserved CKMODE");
      if ((value >> 30) == 0) violation("ADC: its own oscillator HSI14: not modelled");
      adc_configuration2_ = value;
      if (static_cast<double>(kSecond) / static_cast<double>(adc_clock()) > kAdcClockMax_hz) violation("ADC: clock above 14 MHz");
      return;
    case 0x14:
      if ((value & ~7U) != 0) violation("ADC: reserved bits of SMPR");
      adc_sampling_ = value & 7U;
      return;
    default:
      if ((value & ~0x7FFFFU) != 0) violation("ADC: reserved bits of CHSELR");
      adc_channels_ = value & 0x7FFFFU;
  }
}

void Stm32f072::write_adc(std::uint32_t offset, std::uint32_t value) {
  switch (offset) {
    case 0x00:
      if ((value & ~0x9FU) != 0) violation("ADC: reserved bits of ISR");
      adc_status_ &= ~value;
      return;
    case 0x04:
      if ((value & ~0x9FU) != 0) violation("ADC: reserved bits of IER");
      adc_interrupts_ = value;
      return;
    case 0x08:
      write_adc_control(value);
      return;
    case 0x0C:
    case 0x10:
    case 0x14:
    case 0x28:
      configure_adc(offset, value);
      return;
    case 0x308:
      if ((value & ~0x01C00000U) != 0) violation("ADC: reserved bits of CCR");
      if (adc_started_) violation("ADC: CCR written while ADSTART is set");
      adc_common_ = value;
      return;
    default:
      violation("ADC: write to register " + hex(offset) + ", which is read-only, does not exist or is not modelled");
  }
}

// ---------------------------------------------------------------- watchdog

Time Stm32f072::slow_clocks(double count) const { return static_cast<Time>(count / slow_hz_ * static_cast<double>(kSecond)); }

void Stm32f072::reload_watchdog() {
  const double divider = 4U << std::min(iwdg_prescale_, 6U);
  iwdg_deadline_ = now_ + slow_clocks(divider * (iwdg_reload_ + 1.0));
}

std::uint32_t Stm32f072::read_iwdg(std::uint32_t offset) {
  switch (offset) {
    case 0x00:
      return 0;
    case 0x04:
      if (now_ < iwdg_prescale_at_) violation("IWDG: PR read while it is being updated");
      return iwdg_prescale_;
    case 0x08:
      if (now_ < iwdg_reload_at_) violation("IWDG: RLR read while it is being updated");
      return iwdg_reload_;
    case 0x0C:
      return (now_ < iwdg_prescale_at_ ? 1U : 0U) | (now_ < iwdg_reload_at_ ? 2U : 0U);
    case 0x10:
      return iwdg_window_;
    default:
      violation("IWDG: read of register " + hex(offset) + ", which does not exist");
      return 0;
  }
}

void Stm32f072::write_iwdg(std::uint32_t offset, std::uint32_t value) {
  const auto open = [&](Time busy_until) {
    if (!iwdg_unlocked_) violation("IWDG: register " + hex(offset) + " written without its key");
    if (now_ < busy_until) violation("IWDG: register " + hex(offset) + " written while it is being updated");
    return iwdg_unlocked_ && now_ >= busy_until;
  };
  switch (offset) {
    case 0x00:
      iwdg_unlocked_ = value == 0x5555;
      if (value == 0xAAAA) {
        if (iwdg_deadline_ != kNever) reload_watchdog();
      } else if (value == 0xCCCC) {
        reload_watchdog();
      } else if (value != 0x5555) {
        violation("IWDG: unknown key");
      }
      return;
    case 0x04:
      if ((value & ~7U) != 0) violation("IWDG: reserved bits of PR");
      if (!open(iwdg_prescale_at_)) return;
      iwdg_prescale_ = value & 7U;
      iwdg_prescale_at_ = now_ + slow_clocks(kSlowUpdateClocks);
      return;
    case 0x08:
      if ((value & ~0xFFFU) != 0) violation("IWDG: reserved bits of RLR");
      if (!open(iwdg_reload_at_)) return;
      iwdg_reload_ = value & 0xFFFU;
      iwdg_reload_at_ = now_ + slow_clocks(kSlowUpdateClocks);
      return;
    case 0x10:
      violation("IWDG: window: not modelled");
      return;
    default:
      violation("IWDG: write to register " + hex(offset) + ", which is read-only or does not exist");
  }
}

}  // namespace hoist::machine
