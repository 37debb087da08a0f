// Access to memory-mapped registers, and the few that every Cortex-M0 has: SysTick, NVIC, system control (ARMv6-M, chapter B3).
//
// A register is read or written by a function call and never by an operator on a volatile reference: in C++20 a discarded volatile
// expression does not read, and |= on one is deprecated.
#pragma once
#include <cstdint>

namespace hoist::firmware::cortex_m0 {

inline std::uint32_t read_word(std::uint32_t address) { return *reinterpret_cast<const volatile std::uint32_t*>(address); }
inline void write_word(std::uint32_t address, std::uint32_t value) { *reinterpret_cast<volatile std::uint32_t*>(address) = value; }
// A few registers do something else when they are accessed as a word.
inline std::uint8_t read_byte(std::uint32_t address) { return *reinterpret_cast<const volatile std::uint8_t*>(address); }
inline void write_byte(std::uint32_t address, std::uint8_t value) { *reinterpret_cast<volatile std::uint8_t*>(address) = value; }
inline void write_half(std::uint32_t address, std::uint16_t value) { *reinterpret_cast<volatile std::uint16_t*>(address) = value; }

template <std::uint32_t kAddress>
struct Register {
  static_assert(kAddress % 4 == 0);
  static std::uint32_t read() { return read_word(kAddress); }
  static void write(std::uint32_t value) { write_word(kAddress, value); }
  // Read, change, write: not atomic against interrupts.
  static void set(std::uint32_t bits) { write(read() | bits); }
  static void clear(std::uint32_t bits) { write(read() & ~bits); }
};

using SysTickControl = Register<0xE000E010>;  // bit 0 enable, 1 interrupt, 2 processor clock, 16 has reached zero since the last read
using SysTickReload = Register<0xE000E014>;
using SysTickValue = Register<0xE000E018>;
using NvicEnable = Register<0xE000E100>;
using NvicDisable = Register<0xE000E180>;
using NvicClearPending = Register<0xE000E280>;
using ResetControl = Register<0xE000ED0C>;  // AIRCR
using SystemPriority3 = Register<0xE000ED20>;

inline constexpr std::uint32_t kResetRequest = 0x05FA0004;  // key and SYSRESETREQ

// Four priorities, 0 is the highest.
inline void enable_interrupt(std::uint32_t number, std::uint32_t priority) {
  const std::uint32_t address = 0xE000E400 + (number & ~3U);
  const std::uint32_t shift = 8 * (number & 3U) + 6;
  write_word(address, (read_word(address) & ~(3U << shift)) | (priority << shift));
  NvicEnable::write(1U << number);
}

inline void start_systick(std::uint32_t cycles, std::uint32_t priority) {
  SystemPriority3::write((SystemPriority3::read() & 0x00FFFFFFU) | (priority << 30));
  SysTickReload::write(cycles - 1);
  SysTickValue::write(0);
  SysTickControl::write(7);
}

inline void disable_interrupts() { asm volatile("cpsid i" ::: "memory"); }
inline void enable_interrupts() { asm volatile("cpsie i" ::: "memory"); }
inline void wait_for_interrupt() { asm volatile("dsb\n\twfi" ::: "memory"); }
inline void barrier() { asm volatile("dsb" ::: "memory"); }

// Everything between construction and destruction happens at once, seen from an interrupt. Restores what was: may be nested.
class InterruptsOff {
 public:
  InterruptsOff() {
    asm volatile("mrs %0, primask" : "=r"(primask_));
    disable_interrupts();
  }
  ~InterruptsOff() { asm volatile("msr primask, %0" ::"r"(primask_) : "memory"); }
  InterruptsOff(const InterruptsOff&) = delete;
  InterruptsOff& operator=(const InterruptsOff&) = delete;

 private:
  std::uint32_t primask_;
};

/// Longer than the slowest watchdog takes (83 ms): a round is four clocks or more, which makes 0.1 s or more at 48 MHz.
inline void outwait_watchdog() {
  for (std::uint32_t round = 0; round < 1'200'000; ++round) asm volatile("");
}

[[noreturn]] inline void reset_now() {
  barrier();
  ResetControl::write(kResetRequest);
  barrier();
  for (;;) asm volatile("nop");
}

}  // namespace hoist::firmware::cortex_m0
