// An STM32F072CB around its core: clocks, ports, flash interface, memory remap, converter, watchdog, and the blocks of bx_can.hpp,
// stm32_serial.hpp and stm32_timer.hpp. Written from the reference manual RM0091, the data sheet and the vendor's public register
// description, not from the firmware's drivers.
//
// Strict as the LPC11C24's model is: a block without its clock, reserved bits, a register that does not exist or is not modelled, an order the
// manual forbids: each is a violation.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "tests/machine/bx_can.hpp"
#include "tests/machine/chip.hpp"
#include "tests/machine/stm32_serial.hpp"
#include "tests/machine/stm32_timer.hpp"

namespace hoist::machine {

class Stm32f072 : public Chip {
 public:
  static constexpr std::uint32_t kFlashBase = 0x08000000, kSramBase = 0x20000000;
  static constexpr std::size_t kFlashSize = 0x20000, kSramSize = 0x4000, kFlashPage = 0x800;

  Stm32f072(std::string name, std::span<const std::uint8_t> flash);

  [[nodiscard]] bool pin(PinPlace at) const override;
  [[nodiscard]] bool pin_driven_by_chip(PinPlace at) const override;
  [[nodiscard]] double pin_high_share(PinPlace at) const override;
  void connect_i2c(I2cDevice* device) override { i2c_.connect(device); }
  /// On SPI1.
  void connect_spi(SpiDevice* device, PinPlace select) override;
  void set_supply(double volts) override;
  /// The watchdog's oscillator: 30 to 50 kHz by the data sheet.
  void set_slow_oscillator(double hz) { slow_hz_ = hz; }
  /// The crystal does not oscillate: it never becomes ready.
  void break_crystal() { crystal_broken_ = true; }

  [[nodiscard]] BxCan& can() override { return can_; }
  [[nodiscard]] SerialLine& serial_line() override {
    touched_ = true;
    return usart_;
  }
  [[nodiscard]] const SerialLine& serial_state() const override { return usart_; }

 private:
  static constexpr unsigned kPorts = 6, kPortBits = 16;
  struct Port {
    std::uint32_t mode{}, open_drain{}, speed{}, pull{}, out{}, alternate_low{}, alternate_high{};
  };
  enum class Converter : std::uint8_t { off, calibrating, starting, ready };

  // PeripheralBus
  bool read(std::uint32_t address, unsigned size, std::uint32_t& value) override;
  bool write(std::uint32_t address, unsigned size, std::uint32_t value) override;
  bool call_rom(std::uint32_t) override { return false; }
  // Chip
  void reset_blocks(ResetCause cause) override;
  [[nodiscard]] Time next_block_event() const override;
  void advance_blocks(Time until) override;
  [[nodiscard]] std::uint32_t lines() override;
  void pins_changed(unsigned port) override;
  [[nodiscard]] bool output(PinPlace at) override;

  [[nodiscard]] bool clocked(std::uint32_t address);
  [[nodiscard]] bool read_block(std::uint32_t address, unsigned size, std::uint32_t& value);
  [[nodiscard]] bool write_block(std::uint32_t address, unsigned size, std::uint32_t value);
  [[nodiscard]] std::uint32_t read_system_memory(std::uint32_t address, unsigned size);

  std::uint32_t read_rcc(std::uint32_t offset);
  void write_rcc(std::uint32_t offset, std::uint32_t value);
  void write_clock_control(std::uint32_t value);
  void write_clock_configuration(std::uint32_t value);
  void update_clock();
  std::uint32_t read_syscfg(std::uint32_t offset);
  void write_syscfg(std::uint32_t offset, std::uint32_t value);

  [[nodiscard]] static bool bonded(unsigned port, unsigned bit);
  [[nodiscard]] unsigned mode_of(PinPlace at) const { return (ports_[at.port].mode >> (2 * at.bit)) & 3U; }
  [[nodiscard]] bool has_function(PinPlace at, unsigned function) const;
  [[nodiscard]] std::optional<double> timer_output(PinPlace at) const;
  std::uint32_t read_gpio(unsigned port, std::uint32_t offset);
  void write_gpio(unsigned port, std::uint32_t offset, std::uint32_t value);
  void write_pin_modes(unsigned port, std::uint32_t value);
  void update_pins();
  void update_timer_inputs();

  std::uint32_t read_flash_registers(std::uint32_t offset);
  void write_flash_registers(std::uint32_t offset, std::uint32_t value);
  void program_flash(std::uint32_t address, unsigned size, std::uint32_t value);
  void erase_page();
  void wait_for_flash(double seconds);

  std::uint32_t read_adc(std::uint32_t offset);
  void write_adc(std::uint32_t offset, std::uint32_t value);
  void write_adc_control(std::uint32_t value);
  void configure_adc(std::uint32_t offset, std::uint32_t value);
  void start_conversion();
  void await_trigger();
  void end_conversion(Time at);
  [[nodiscard]] double channel_volts(unsigned channel, Time at);
  [[nodiscard]] Time adc_clock() const;
  [[nodiscard]] Time conversion_time() const;

  std::uint32_t read_iwdg(std::uint32_t offset);
  void write_iwdg(std::uint32_t offset, std::uint32_t value);
  void reload_watchdog();
  [[nodiscard]] Time slow_clocks(double count) const;

  BxCan can_;
  Stm32I2c i2c_;
  Stm32Spi spi_;
  Stm32Usart usart_;
  std::array<Stm32Timer, 3> timers_;  // TIM1, TIM2, TIM3

  // RCC
  std::uint32_t clock_control_{}, clock_configuration_{}, reset_status_{}, ahb_clocks_{}, apb1_clocks_{}, apb2_clocks_{}, predivider_{},
      clock_sources_{}, bypass_{};
  Time crystal_ready_at_{kNever}, pll_ready_at_{kNever};
  bool crystal_broken_{};
  double slow_hz_{40'000.0};
  std::uint32_t memory_mode_{};

  std::array<Port, kPorts> ports_{};
  SpiDevice* spi_device_{};
  PinPlace select_{};
  bool selected_{};
  bool held_in_reset_{};  // by a low supply

  // Flash interface
  std::uint32_t flash_access_{}, flash_status_{}, flash_control_{}, flash_address_{};
  int flash_key_{};
  bool flash_blocked_{};  // wrong key: locked until the next reset

  // Converter
  Converter converter_{Converter::off};
  Time converter_at_{kNever}, calibrated_at_{};
  std::uint32_t adc_status_{}, adc_interrupts_{}, adc_configuration1_{}, adc_configuration2_{}, adc_sampling_{}, adc_threshold_{},
      adc_channels_{}, adc_data_{}, adc_common_{};
  bool adc_started_{};
  Time adc_due_{kNever}, adc_begins_{kNever};
  unsigned adc_at_{};  // present channel
  std::uint64_t trigger_changes_{};

  // Watchdog
  std::uint32_t iwdg_prescale_{}, iwdg_reload_{}, iwdg_window_{};
  bool iwdg_unlocked_{};
  Time iwdg_prescale_at_{}, iwdg_reload_at_{}, iwdg_deadline_{kNever};
};

}  // namespace hoist::machine
