// An LPC11C24 around its core: system control, pins, timers, converter, watchdog, flash routines of the ROM, and the blocks of
// serial_blocks.hpp and c_can.hpp. Written from the user's manual UM10398 and the vendor's public register description, not from the
// firmware's drivers; the two are meant to judge each other.
//
// Strict: a block without its clock or held in reset, reserved bits, a register that does not exist, an order the manual forbids: each is
// written down as a violation. Firmware has to run without any.
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
#include "tests/machine/cortex_m0.hpp"
#include "tests/machine/serial_blocks.hpp"
#include "tests/machine/time.hpp"

namespace hoist::machine {

inline constexpr std::size_t kFlashBytes = 0x8000, kRamBytes = 0x2000, kFlashSectorBytes = 0x1000;

enum class ResetCause : std::uint8_t { power_on, pin, watchdog, brown_out, software };

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
  /// When the match output rises or falls next after `now`; never if it does not.
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
  std::uint32_t held_high_{};  // PWM outputs that stay high until the cycle ends, whatever their match value is now
};

class Lpc11c24 : private PeripheralBus {
 public:
  static constexpr unsigned kPorts = 4, kPortBits = 12;

  Lpc11c24(std::string name, std::span<const std::uint8_t> flash);
  Lpc11c24(const Lpc11c24&) = delete;
  Lpc11c24& operator=(const Lpc11c24&) = delete;

  /// Power on, or another reset. Nothing runs while unpowered.
  void reset(ResetCause cause);
  void power_off() { powered_ = false; }
  [[nodiscard]] bool powered() const { return powered_; }
  /// Begins at these vectors, as the loader hands over, instead of at address 0: for applications without their loader in the flash.
  void start_at(std::uint32_t vectors);

  /// Runs core and blocks up to `end`.
  void run_until(Time end);
  [[nodiscard]] Time now() const { return now_; }

  // Pins from outside. A pin nobody drives follows its pull-up or pull-down.
  void drive_pin(unsigned port, unsigned bit, bool level);
  void float_pin(unsigned port, unsigned bit);
  /// The level at a pin as a meter would see it: driven by the chip, driven from outside, or pulled.
  [[nodiscard]] bool pin(unsigned port, unsigned bit) const;
  [[nodiscard]] bool pin_driven_by_chip(unsigned port, unsigned bit) const;
  /// Share of the time a pin is high: its level, or the duty of the PWM that is switched to it.
  [[nodiscard]] double pin_high_share(unsigned port, unsigned bit) const;
  /// Schedules an edge from outside; in order of time.
  void schedule_pin(Time at, unsigned port, unsigned bit, bool level);
  /// The voltage at a converter channel.
  void set_analog(std::function<double(unsigned channel, Time now)> volts) { analog_ = std::move(volts); }
  /// Select line of the chip on SSP0.
  void connect_spi0(SpiDevice* device, unsigned select_port, unsigned select_bit);

  /// The supply, for the brown-out detector.
  void set_supply(double volts);
  /// The current flash operation is cut by a power failure: after this many more (1 = the next one) the chip is off, the flash half done.
  void cut_power_in_flash_operation(int which) { flash_cut_ = which; }
  [[nodiscard]] std::uint64_t flash_operations() const { return flash_operations_; }

  [[nodiscard]] CortexM0& core() { return *core_; }
  [[nodiscard]] const CortexM0& core() const { return *core_; }
  [[nodiscard]] CCan& can() { return can_; }
  [[nodiscard]] I2c& i2c() { return i2c_; }
  /// To be asked for anew each time it is used: the chip then looks what has come.
  [[nodiscard]] Uart& uart() {
    touched_ = true;
    return uart_;
  }
  [[nodiscard]] const Uart& uart_state() const { return uart_; }
  [[nodiscard]] std::span<std::uint8_t> flash() { return flash_; }
  [[nodiscard]] std::span<std::uint8_t> ram() { return ram_; }

  [[nodiscard]] const std::string& name() const { return name_; }
  /// Each thing that correct firmware never does, with how often.
  [[nodiscard]] const std::map<std::string, std::uint64_t>& violations() const { return violations_; }
  /// Adds one: for what hangs on the chip.
  void complain(const std::string& what) { violation(what); }
  /// Wiring in which one output must not change while another one is high and a third enables both: direction and PWM of an H-bridge.
  struct Interlock {
    unsigned port, bit;              // what must hold still ...
    unsigned while_port, while_bit;  // ... while this match output is high ...
    unsigned enable_port, enable_bit;
  };
  void set_interlock(const Interlock& interlock) { interlock_ = interlock; }
  /// How often that output changed while the third one was high.
  [[nodiscard]] std::uint64_t interlock_changes() const { return interlock_changes_; }
  void forget_violations() { violations_.clear(); }
  [[nodiscard]] std::uint64_t resets(ResetCause cause) const { return resets_[static_cast<std::size_t>(cause)]; }
  [[nodiscard]] std::uint32_t clock_hz() const { return clock_hz_; }
  /// The core stays where it is, its blocks go on: as if it hung with interrupts off.
  void hang(bool hung) { hung_ = hung; }

 private:
  struct Port {
    std::uint32_t out{}, dir{}, is{}, ibe{}, iev{}, ie{}, ris{};
    std::uint32_t outside{}, driven{};
    std::uint32_t seen{};  // input levels at the last look
  };
  struct Edge {
    Time at;
    unsigned port, bit;
    bool level;
  };

  // PeripheralBus
  bool read(std::uint32_t address, unsigned size, std::uint32_t& value) override;
  bool write(std::uint32_t address, unsigned size, std::uint32_t value) override;
  bool call_rom(std::uint32_t address) override;
  void request_reset() override {
    reset_wanted_ = ResetCause::software;
    core_->stop();
  }
  void violation(const std::string& what) override;

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
  void update_lines();
  void service(Time until);
  [[nodiscard]] Time next_event() const;
  [[nodiscard]] std::uint32_t function_of(unsigned port, unsigned bit) const;
  [[nodiscard]] bool is_gpio(unsigned port, unsigned bit) const;
  [[nodiscard]] std::uint32_t inputs(unsigned port) const;

  void convert(unsigned channel, Time at);
  void update_burst();
  void await_edge();
  [[nodiscard]] Time conversion_time() const;
  void feed_watchdog();
  [[nodiscard]] std::uint64_t watchdog_value() const;
  void do_reset(ResetCause cause);

  std::uint32_t iap(std::uint32_t table, std::uint32_t result);
  [[nodiscard]] bool cut_now();
  std::uint32_t iap_erase(std::uint32_t first, std::uint32_t last);
  std::uint32_t iap_write(std::uint32_t to, std::uint32_t from, std::uint32_t count);
  void stall(double seconds);
  void catch_up();

  [[nodiscard]] bool match_output(unsigned port, unsigned bit);

  std::string name_;
  std::optional<Interlock> interlock_;
  std::uint64_t interlock_changes_ = 0;
  std::vector<std::uint8_t> flash_, ram_;
  std::unique_ptr<CortexM0> core_;
  Complain complain_;
  CCan can_;
  I2c i2c_;
  Ssp ssp0_, ssp1_;
  Uart uart_;
  std::array<MatchTimer, 4> timers_;
  bool powered_{};
  bool hung_{};
  Time now_{};
  Time slice_from_{};  // where the core's run under way began, and its clocks then
  std::uint64_t slice_cycles_{};
  bool in_slice_{};
  Time unit_{4};
  std::uint32_t clock_hz_{12'000'000};
  Time next_{};         // cached next event
  bool touched_{true};  // from outside, since the lines were last looked at
  std::uint64_t can_changes_{};
  std::map<std::string, std::uint64_t> violations_;
  std::array<std::uint64_t, 5> resets_{};
  std::optional<ResetCause> reset_wanted_;
  std::uint32_t start_vectors_{};
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
  std::vector<Edge> edges_;
  std::size_t edge_at_{};
  SpiDevice* spi0_{};
  unsigned select_port_{}, select_bit_{};
  bool selected_{};

  // Converter
  std::function<double(unsigned, Time)> analog_;
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
  int flash_cut_{};
  std::uint64_t flash_operations_{};
  std::vector<bool> page_written_;
  double supply_v_{3.3};
};

}  // namespace hoist::machine
