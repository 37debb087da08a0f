// A Cortex-M0 core: the instructions of ARMv6-M, exceptions with two bits of priority, NVIC, SysTick, WFI.
//
// Stricter than most emulators, as silicon is: a word at an odd address, an instruction of a larger core, a jump or access to an unmapped
// address is a HardFault, and is recorded. Cycles are the ones of the Cortex-M0 technical reference manual (r0p0, table 3-1, fast
// multiplier); every 32-bit word fetched from flash costs the wait states on top, as if the chip had no prefetch: an upper bound.
//
// Not modelled: PSP and unprivileged code (writing CONTROL is a violation), NMI, exact tail-chaining (a return and a new entry are charged
// in full), debug.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace hoist::machine {

/// What the core sees beyond flash, RAM and its own system registers. `size` is 1, 2 or 4; the address is aligned to it.
class PeripheralBus {
 public:
  virtual ~PeripheralBus() = default;
  /// False for an unmapped address: the core takes a HardFault.
  [[nodiscard]] virtual bool read(std::uint32_t address, unsigned size, std::uint32_t& value) = 0;
  [[nodiscard]] virtual bool write(std::uint32_t address, unsigned size, std::uint32_t value) = 0;
  /// The core has reached this address in the chip's ROM: apply the routine's effect on registers and memory and return true; the core then
  /// returns to LR.
  [[nodiscard]] virtual bool call_rom(std::uint32_t address) = 0;
  /// SYSRESETREQ was written.
  virtual void request_reset() = 0;
  /// A violation: something that correct firmware never does.
  virtual void violation(const std::string& what) = 0;
};

/// Where a chip maker puts flash and RAM. The LPC11C24's places are the default.
struct MemoryMap {
  std::uint32_t flash_base{0x00000000};
  std::uint32_t ram_base{0x10000000};
  std::uint32_t rom_base{0x1FFF0000}, rom_end{0x1FFF4000};  ///< routines of the chip maker that a program may call; equal: none
};

class CortexM0 {
 public:
  static constexpr std::uint32_t kRamBase = MemoryMap{}.ram_base;
  static constexpr unsigned kIrqCount = 32;
  static constexpr unsigned kExceptionEntry_cycles = 16;
  static constexpr unsigned kExceptionExit_cycles = 12;
  static constexpr int kHardFault = 3, kSvCall = 11, kPendSv = 14, kSysTick = 15, kFirstIrq = 16;

  CortexM0(std::span<std::uint8_t> flash, std::span<std::uint8_t> ram, PeripheralBus& bus, const MemoryMap& map = {})
      : flash_(flash), ram_(ram), bus_(bus), map_(map) {}

  /// Registers as after a reset; stack pointer and first instruction from the vectors at address 0.
  void reset();

  /// Takes a pending exception if one may be taken, or else one instruction. Returns the core clocks it took; 0 while asleep or locked up.
  unsigned step() { return static_cast<unsigned>(run(1)); }
  /// Repeats this for that many clocks or until stop(); returns the clocks taken. Fewer than requested: asleep, locked up or stopped.
  std::uint64_t run(std::uint64_t clocks);
  /// Ends run() after the present instruction, so that peripherals are updated.
  void stop() { stop_ = true; }

  /// Moves SysTick on without executing: `cycles` core clocks asleep.
  void sleep(std::uint64_t cycles);
  [[nodiscard]] bool asleep() const { return asleep_; }
  /// Ends a WFI as an interrupt would that is over at once.
  void wake() { asleep_ = false; }
  [[nodiscard]] bool locked_up() const { return locked_up_; }
  /// Core clocks until the next SysTick event; UINT64_MAX when it is off.
  [[nodiscard]] std::uint64_t cycles_to_systick() const;

  /// The interrupt lines of the peripherals, one bit each, as levels. A line that rises becomes pending, and one that is still high when its
  /// handler returns becomes pending again.
  void set_lines(std::uint32_t lines);

  /// Memory mapped to address 0 (SYSMEMREMAP, MEM_MODE): a part of flash or RAM, or none.
  void show_at_zero(std::span<std::uint8_t> memory) {
    at_zero_ = memory;
    last_word_ = kNoWord;
  }
  /// Extra clocks for each 32-bit word fetched from flash.
  void set_flash_waits(unsigned waits) { flash_waits_ = waits; }

  [[nodiscard]] std::uint32_t reg(unsigned n) const { return r_[n]; }
  void set_reg(unsigned n, std::uint32_t value) {
    r_[n] = value;
    last_word_ = kNoWord;
  }
  /// N Z C V in bits 31 to 28.
  [[nodiscard]] std::uint32_t flags() const;
  void set_flags(std::uint32_t apsr);
  [[nodiscard]] bool primask() const { return primask_; }
  /// Some interrupt is enabled and would be taken.
  [[nodiscard]] bool interruptible() const { return !primask_ && (enabled_ != 0 || (systick_csr_ & 3U) == 3U); }
  [[nodiscard]] int exception() const { return exception_; }

  /// Memory as the core sees it, without cost or effect; false outside flash and RAM.
  [[nodiscard]] bool peek(std::uint32_t address, unsigned size, std::uint32_t& value) const;
  [[nodiscard]] bool poke(std::uint32_t address, unsigned size, std::uint32_t value);

  // Counts since construction.
  [[nodiscard]] std::uint64_t instructions() const { return instructions_; }
  [[nodiscard]] std::uint64_t cycles() const { return cycles_; }            ///< awake and asleep
  [[nodiscard]] std::uint64_t busy_cycles() const { return busy_cycles_; }  ///< awake only
  [[nodiscard]] std::uint64_t flash_words() const { return flash_words_; }
  [[nodiscard]] std::uint64_t exceptions(int number) const { return exception_counts_[static_cast<std::size_t>(number)]; }
  /// The lowest stack pointer since the last reset.
  [[nodiscard]] std::uint32_t lowest_sp() const { return lowest_sp_; }
  [[nodiscard]] std::uint64_t hard_faults() const { return exception_counts_[kHardFault]; }
  /// Work between one SysTick and the next, since reset_work().
  struct Work {
    std::uint64_t ticks{}, worst_cycles{}, total_cycles{}, instructions{};
    std::uint64_t worst_without_waits{};  ///< the same millisecond's, or another's, with a flash that never waits
    std::uint64_t total_without_waits{};
  };
  [[nodiscard]] const Work& work() const { return work_; }
  void reset_work();
  /// Sees each instruction's address before it is executed. Slow; empty ends it.
  void on_instruction(std::function<void(std::uint32_t address, std::uint16_t opcode)> see) { see_ = std::move(see); }

 private:
  struct Fault {
    const char* why;
    std::uint32_t address;
  };
  static constexpr std::uint32_t kNoWord = 0xFFFFFFFF;
  static constexpr std::uint32_t kSystemBase = 0xE000E000;

  std::uint32_t load(std::uint32_t address, unsigned size);
  void store(std::uint32_t address, unsigned size, std::uint32_t value);
  std::uint16_t fetch(std::uint32_t address);
  void note_tick();
  void systick_is_zero();
  [[nodiscard]] std::uint64_t systick_left() const;
  [[nodiscard]] std::uint8_t* memory(std::uint32_t address, unsigned size) const;
  [[nodiscard]] bool in_flash(const std::uint8_t* at) const { return at >= flash_.data() && at < flash_.data() + flash_.size(); }
  std::uint32_t read_system(std::uint32_t address);
  void write_system(std::uint32_t address, std::uint32_t value);

  unsigned execute(std::uint16_t op);
  unsigned execute_misc(std::uint16_t op);
  unsigned execute_wide(std::uint16_t first, std::uint16_t second);
  std::uint32_t add_with_carry(std::uint32_t a, std::uint32_t b, std::uint32_t carry, bool set);
  void set_nz(std::uint32_t value) {
    n_ = (value >> 31) != 0;
    z_ = value == 0;
  }
  [[nodiscard]] bool condition(unsigned cond) const;
  void set_sp(std::uint32_t value) {
    r_[13] = value & ~3U;
    if (r_[13] < lowest_sp_) lowest_sp_ = r_[13];
  }
  void jump(std::uint32_t address) { next_pc_ = address & ~1U; }
  /// BX, BLX, POP: interworking, and return from an exception.
  void branch_exchange(std::uint32_t target);
  void write_msr(unsigned which, std::uint32_t value);
  [[nodiscard]] std::uint32_t read_mrs(unsigned which) const;

  [[nodiscard]] int priority_of(int exception) const;
  [[nodiscard]] int current_priority() const;
  bool take_exception();
  void enter(int exception, std::uint32_t return_address);
  void leave(std::uint32_t exc_return);
  void hard_fault(const Fault& fault);

  std::span<std::uint8_t> flash_;
  std::span<std::uint8_t> ram_;
  PeripheralBus& bus_;
  MemoryMap map_;
  std::array<std::uint32_t, 16> r_{};
  std::uint32_t next_pc_{};
  bool n_{}, z_{}, c_{}, v_{};
  bool primask_{};
  bool asleep_{};
  bool locked_up_{};
  bool attention_{};
  bool stop_{};
  std::span<std::uint8_t> at_zero_;
  unsigned flash_waits_{};
  unsigned waits_{};  // wait states of the present instruction
  std::uint32_t last_word_{kNoWord};

  int exception_{};               // in progress, 0: thread
  std::array<int, 48> active_{};  // nested exceptions, innermost last
  std::size_t active_count_{};
  std::uint64_t pending_{};  // by exception number
  std::uint32_t enabled_{};  // interrupts
  std::uint32_t lines_{};
  std::array<std::uint8_t, kIrqCount> irq_priority_{};
  std::uint8_t svc_priority_{}, pendsv_priority_{}, systick_priority_{};
  std::uint32_t scr_{};

  std::uint32_t systick_csr_{}, systick_reload_{};
  std::uint64_t systick_stopped_{};            // what the counter shows while it is off
  std::uint64_t systick_zero_at_{UINT64_MAX};  // when it reaches 0, counted in cycles_

  std::uint64_t instructions_{}, cycles_{}, busy_cycles_{}, flash_words_{};
  std::array<std::uint64_t, 48> exception_counts_{};
  std::uint32_t lowest_sp_{0xFFFFFFFF};
  Work work_{};
  std::uint64_t work_busy_{}, work_waits_{}, work_instructions_{}, all_waits_{};
  std::function<void(std::uint32_t, std::uint16_t)> see_;
};

}  // namespace hoist::machine
