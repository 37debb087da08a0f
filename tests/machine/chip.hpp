// What every modelled microcontroller has: a core with its memories, pins that can be driven from outside, violations, and the loop that lets
// core and blocks run in step. The blocks are the derived class's.
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

#include "tests/machine/can_wire.hpp"
#include "tests/machine/cortex_m0.hpp"
#include "tests/machine/serial_blocks.hpp"
#include "tests/machine/time.hpp"

namespace hoist::machine {

enum class ResetCause : std::uint8_t { power_on, pin, watchdog, brown_out, software };

/// Port and bit of a pin; ports are counted from 0 (PIO0, port A).
struct PinPlace {
  unsigned port{}, bit{};
};

class Chip : protected PeripheralBus {
 public:
  static constexpr unsigned kPortsMax = 6;

  Chip(std::string name, std::span<const std::uint8_t> flash, std::size_t flash_bytes, std::size_t ram_bytes, const MemoryMap& map);
  Chip(const Chip&) = delete;
  Chip& operator=(const Chip&) = delete;

  /// Power-on, or another reset. Nothing runs while unpowered.
  void reset(ResetCause cause);
  void power_off() { powered_ = false; }
  [[nodiscard]] bool powered() const { return powered_; }
  /// Begins at these vectors, as the loader hands over, instead of at address 0: for applications without their loader in the flash.
  void start_at(std::uint32_t vectors) { start_vectors_ = vectors; }

  /// Runs core and blocks up to `end`.
  void run_until(Time end);
  [[nodiscard]] Time now() const { return now_; }

  // Pins from outside. A pin that nothing drives follows its pull-up or pull-down.
  void drive_pin(PinPlace at, bool level);
  void float_pin(PinPlace at);
  /// The level at a pin as a meter would see it: driven by the chip, driven from outside, or pulled.
  [[nodiscard]] virtual bool pin(PinPlace at) const = 0;
  [[nodiscard]] virtual bool pin_driven_by_chip(PinPlace at) const = 0;
  /// Share of the time a pin is high: its level, or the duty of the PWM that is switched to it.
  [[nodiscard]] virtual double pin_high_share(PinPlace at) const = 0;
  /// Schedules an edge from outside; in order of time.
  void schedule_pin(Time at, PinPlace place, bool level);
  /// The voltage at a converter channel.
  void set_analog(std::function<double(unsigned channel, Time now)> volts) { analog_ = std::move(volts); }
  /// The chips on its I2C bus, and on its SPI with their select line.
  virtual void connect_i2c(I2cDevice* device) = 0;
  virtual void connect_spi(SpiDevice* device, PinPlace select) = 0;

  /// The supply, for the chip's own supervisor.
  virtual void set_supply(double volts) = 0;
  /// The current flash operation is cut by a power failure: after this many more (1 = the next one) the chip is off, the flash half done.
  void cut_power_in_flash_operation(int which) { flash_cut_ = which; }
  [[nodiscard]] std::uint64_t flash_operations() const { return flash_operations_; }

  [[nodiscard]] CortexM0& core() { return *core_; }
  [[nodiscard]] const CortexM0& core() const { return *core_; }
  [[nodiscard]] virtual CanController& can() = 0;
  /// Call again before each use: it updates the chip's inputs.
  [[nodiscard]] virtual SerialLine& serial_line() = 0;
  [[nodiscard]] virtual const SerialLine& serial_state() const = 0;
  [[nodiscard]] std::span<std::uint8_t> flash() { return flash_; }
  [[nodiscard]] std::span<std::uint8_t> ram() { return ram_; }

  [[nodiscard]] const std::string& name() const { return name_; }
  /// Violations, with their counts.
  [[nodiscard]] const std::map<std::string, std::uint64_t>& violations() const { return violations_; }
  /// Adds one: for what hangs on the chip.
  void complain(const std::string& what) { violation(what); }
  /// Wiring in which one output must not change while another one is high and a third enables both: direction and PWM of an H-bridge.
  struct Interlock {
    PinPlace held, while_high, enable;
  };
  void set_interlock(const Interlock& interlock) { interlock_ = interlock; }
  /// How often that output changed while the third one was high.
  [[nodiscard]] std::uint64_t interlock_changes() const { return interlock_changes_; }
  void forget_violations() { violations_.clear(); }
  [[nodiscard]] std::uint64_t resets(ResetCause cause) const { return resets_[static_cast<std::size_t>(cause)]; }
  [[nodiscard]] std::uint32_t clock_hz() const { return clock_hz_; }
  /// The core stops, its blocks continue: as if it hung with interrupts off.
  void hang(bool hung) { hung_ = hung; }

 protected:
  struct Outside {
    std::uint32_t level{}, driven{};
  };

  /// Registers as this reset leaves them, RAM untouched; then the core's vectors.
  virtual void reset_blocks(ResetCause cause) = 0;
  [[nodiscard]] virtual Time next_block_event() const = 0;
  virtual void advance_blocks(Time until) = 0;
  /// The interrupt lines as the blocks drive them.
  [[nodiscard]] virtual std::uint32_t lines() = 0;
  /// Levels at this port's pins may have changed from outside.
  virtual void pins_changed(unsigned port) = 0;
  /// Whether the chip drives this pin high at this very instant, PWM as far as it is in its period.
  [[nodiscard]] virtual bool output(PinPlace at) = 0;
  /// The program has written the output levels of a port.
  void outputs_written(unsigned port, std::uint32_t before, std::uint32_t after);

  void request_reset() override {
    reset_wanted_ = ResetCause::software;
    core_->stop();
  }
  void violation(const std::string& what) override { ++violations_[what]; }

  /// Sets `clock_hz_`; the core's clocks last so long from now on.
  void set_clock(std::uint32_t clock_hz);
  void update_lines();
  /// While the core runs, time follows its clocks.
  void catch_up() {
    if (in_slice_) now_ = slice_from_ + (core_->cycles() - slice_cycles_) * unit_;
  }
  /// The core waits, its clocks continue.
  void stall(double seconds);
  /// Counts a flash operation; true for a power cut in the middle of it.
  [[nodiscard]] bool cut_now();

  std::vector<std::uint8_t> flash_, ram_;
  std::unique_ptr<CortexM0> core_;
  Complain complain_;
  bool powered_{};
  Time now_{};
  Time unit_{4};  // of a core clock
  std::uint32_t clock_hz_{12'000'000};
  bool touched_{true};  // from outside, since the lines were last sampled
  std::optional<ResetCause> reset_wanted_;
  std::uint32_t start_vectors_{};
  std::array<Outside, kPortsMax> outside_{};
  std::function<double(unsigned, Time)> analog_;

 private:
  struct Edge {
    Time at;
    PinPlace place;
    bool level;
  };
  void do_reset(ResetCause cause);
  void service(Time until);

  std::string name_;
  bool hung_{};
  Time slice_from_{};  // start of the core's present run, and its clocks then
  std::uint64_t slice_cycles_{};
  bool in_slice_{};
  Time next_{};  // cached next event
  std::uint64_t can_changes_{};
  std::map<std::string, std::uint64_t> violations_;
  std::array<std::uint64_t, 5> resets_{};
  std::optional<Interlock> interlock_;
  std::uint64_t interlock_changes_{};
  std::vector<Edge> edges_;
  std::size_t edge_at_{};
  int flash_cut_{};
  std::uint64_t flash_operations_{};
};

}  // namespace hoist::machine
