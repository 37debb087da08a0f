// An LPC11C24 around its core: system control, pins, timers, converter, watchdog, flash routines of the ROM, and the blocks of
// serial_blocks.hpp and c_can.hpp. Written from the user's manual UM10398 and the vendor's public register description, not from the
// firmware's drivers; so each checks the other.
//
// Strict: a block without its clock or held in reset, reserved bits, a register that does not exist, a sequence the manual forbids: each is
// recorded as a violation. Firmware has to run without any.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tests/machine/c_can.hpp"
#include "tests/machine/chip.hpp"
#include "tests/machine/serial_blocks.hpp"
#include "tests/machine/time.hpp"

namespace hoist::machine {

inline constexpr std::size_t kFlashBytes = 0x8000, kRamBytes = 0x2000, kFlashSectorBytes = 0x1000;

/// A 16 or 32 bit counter with four matches.
class MatchTimer {
 public:
  MatchTimer(const char* name, bool wide, Complain complain) : name_(name), wide_(wide), complain_(std::move(complain)) {}
  void reset();
  [[nodiscard]] std::uint32_t read(std::uint32_t offset, Time now);
  void write(std::uint32_t offset, std::uint32_t value, Time now, std::uint32_t clock_hz);
  void advance(Time now);
  [[nodiscard]] Time next() const;
  [[nodiscard]] bool line() const { return flags_ != 0; }
  /// Share of the time a match output is high when it is used as PWM; level of the output otherwise.
  [[nodiscard]] double high_share(unsigned match) const;
  [[nodiscard]] double pwm_hz(std::uint32_t clock_hz) const;
  /// Level of a match output at this very instant. UM10398, rules for single edge controlled PWM outputs: a match value written while the
  /// output is high lets it go low only when the next cycle begins.
  [[nodiscard]] bool output(unsigned match, Time now);
  /// Next edge of the match output after `now`; never without one.
  [[nodiscard]] Time next_edge(unsigned match, bool falling, Time now);

 private:
  [[nodiscard]] std::uint64_t range() const { return wide_ ? 0x1'0000'0000ULL : 0x1'0000ULL; }
  [[nodiscard]] std::uint64_t top() const;  // counts from 0 back to 0
  [[nodiscard]] std::uint64_t counts_since(Time now) const;
  void settle(Time now);
  [[nodiscard]] bool running() const { return (tcr_ & 3U) == 1; }

  const char* name_;
  bool wide_;
  Complain complain_;
  std::uint32_t tcr_{}, pr_{}, mcr_{}, ccr_{}, emr_{}, ctcr_{}, pwmc_{};
  std::array<std::uint32_t, 4> match_{};
  std::uint64_t counter_{};  // at settled_
  Time settled_{};
  Time step_{1};  // one count
  std::uint32_t flags_{};
  std::uint32_t held_high_{};  // PWM outputs that stay high until the cycle ends, independent of their present match value
};

class Lpc11c24 : public Chip {
 public:
  static constexpr unsigned kPorts = 4, kPortBits = 12;

  Lpc11c24(std::string name, std::span<const std::uint8_t> flash);

  [[nodiscard]] bool pin(PinPlace at) const override;
  [[nodiscard]] bool pin_driven_by_chip(PinPlace at) const override;
  [[nodiscard]] double pin_high_share(PinPlace at) const override;
  void connect_i2c(I2cDevice* device) override { i2c_.connect(device); }
  /// On SSP0.
  void connect_spi(SpiDevice* device, PinPlace select) override;
  void set_supply(double volts) override;

  [[nodiscard]] CCan& can() override { return can_; }
  [[nodiscard]] SerialLine& serial_line() override {
    touched_ = true;
    return uart_;
  }
  [[nodiscard]] const SerialLine& serial_state() const override { return uart_; }

 private:
  struct Port {
    std::uint32_t out{}, dir{}, is{}, ibe{}, iev{}, ie{}, ris{};
    std::uint32_t seen{};  // input levels at the last look
  };

  // PeripheralBus
  bool read(std::uint32_t address, unsigned size, std::uint32_t& value) override;
  bool write(std::uint32_t address, unsigned size, std::uint32_t value) override;
  bool call_rom(std::uint32_t address) override;

  // Chip
  void reset_blocks(ResetCause cause) override;
  [[nodiscard]] Time next_block_event() const override;
  void advance_blocks(Time until) override;
  [[nodiscard]] std::uint32_t lines() override;
  void pins_changed(unsigned port) override { look_at_port(port); }
  [[nodiscard]] bool output(PinPlace at) override;

  [[nodiscard]] bool reachable(unsigned block);
  void spoil_rom_memory();
  std::uint32_t read_pmu(std::uint32_t offset);
  void write_pmu(std::uint32_t offset, std::uint32_t value);
  std::uint32_t read_syscon(std::uint32_t offset);
  void write_syscon(std::uint32_t offset, std::uint32_t value);
  std::uint32_t read_gpio(unsigned port, std::uint32_t offset);
  void write_gpio(unsigned port, std::uint32_t offset, std::uint32_t value);
  std::uint32_t read_iocon(std::uint32_t offset);
  void write_iocon(std::uint32_t offset, std::uint32_t value);
  std::uint32_t read_adc(std::uint32_t offset);
  void write_adc(std::uint32_t offset, std::uint32_t value);
  std::uint32_t read_wwdt(std::uint32_t offset);
  void write_wwdt(std::uint32_t offset, std::uint32_t value);

  void update_clock();
  void update_pins();
  void look_at_port(unsigned port);
  [[nodiscard]] std::uint32_t function_of(unsigned port, unsigned bit) const;
  [[nodiscard]] bool is_gpio(unsigned port, unsigned bit) const;
  [[nodiscard]] std::uint32_t inputs(unsigned port) const;

  void convert(unsigned channel, Time at);
  void update_burst();
  void await_edge();
  [[nodiscard]] Time conversion_time() const;
  void feed_watchdog();
  [[nodiscard]] std::uint64_t watchdog_value() const;
  void expire_watchdog();

  std::uint32_t iap(std::uint32_t table, std::uint32_t result);
  std::uint32_t iap_erase(std::uint32_t first, std::uint32_t last);
  std::uint32_t iap_write(std::uint32_t to, std::uint32_t from, std::uint32_t count);
  void stall_in_rom(double seconds);

  CCan can_;
  I2c i2c_;
  Ssp ssp0_, ssp1_;
  Uart uart_;
  std::array<MatchTimer, 4> timers_;
  std::array<std::uint32_t, 4> general_{};  // GPREG0 to 3 of the PMU: outlive every reset but a cold boot

  // SYSCON
  std::uint32_t remap_{2}, presetctrl_{}, pll_{}, osc_{}, wdtosc_{}, ircctrl_{0x80}, reset_status_{}, pll_source_{}, pll_source_wanted_{},
      pll_update_{}, main_source_{}, main_source_wanted_{}, main_update_{}, ahb_divider_{1}, ahb_clocks_{0x85F}, ssp0_divider_{1},
      uart_divider_{}, ssp1_divider_{}, wdt_source_{}, wdt_source_wanted_{}, wdt_update_{}, wdt_divider_{}, bod_{}, pdrun_{0xEDF0},
      pdsleep_{}, pdwake_{0xEDF0}, starterp_{}, startaprp_{};
  Time pll_locked_at_{kNever}, osc_ready_at_{kNever};
  std::uint32_t flashcfg_{};
  std::array<std::uint32_t, 64> iocon_{};
  std::array<Port, kPorts> ports_{};
  SpiDevice* spi0_{};
  PinPlace select_{};
  bool selected_{};

  // Converter
  std::uint32_t adc_control_{}, adc_enable_{0x100};
  std::array<std::uint32_t, 8> adc_data_{};
  std::uint32_t adc_global_{};
  Time adc_due_{kNever};
  bool adc_by_edge_{};
  unsigned adc_channel_{};
  Time burst_from_{};
  std::uint64_t burst_done_{};

  // Watchdog
  std::uint32_t wdt_mode_{}, wdt_count_{0xFF}, wdt_warn_{}, wdt_window_{0xFFFFFF};
  int wdt_feed_{};
  Time wdt_deadline_{kNever}, wdt_started_{};
  bool wdt_flag_{};

  // Flash routines
  std::uint32_t prepared_{};
  std::vector<bool> page_written_;
  double supply_v_{3.3};
};

}  // namespace hoist::machine
