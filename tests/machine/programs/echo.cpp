// A bare program that shows the model: crystal and PLL, SysTick, two levels of interrupts, and a CAN controller that answers each frame with
// the next id and its data inverted. What it has seen it leaves in `seen`, where the test finds it by name.
#include <cstdint>

namespace {

std::uint32_t read(std::uint32_t address) { return *reinterpret_cast<volatile std::uint32_t*>(address); }
void write(std::uint32_t address, std::uint32_t value) { *reinterpret_cast<volatile std::uint32_t*>(address) = value; }

constexpr std::uint32_t kSyscon = 0x40048000, kFlashcfg = 0x4003C010, kCan = 0x40050000, kTimer = 0x40014000;

}  // namespace

extern "C" {

struct Seen {
  std::uint32_t ticks, frames, nested, timer, interrupted_at_level, asleep;
};
volatile Seen seen;

void systick_handler() {
  seen.ticks = seen.ticks + 1;
  // Wait until the timer, which is more urgent, has come in between.
  const std::uint32_t before = seen.timer;
  for (int i = 0; i < 2000 && seen.timer == before; ++i) asm volatile("nop");
  if (seen.timer != before) seen.nested = seen.nested + 1;
}
void timer_handler() {
  std::uint32_t level = 0;
  asm volatile("mrs %0, ipsr" : "=r"(level));
  seen.interrupted_at_level = level;
  write(kTimer + 0x00, 1);
  seen.timer = seen.timer + 1;
}
void can_handler() {
  const std::uint32_t which = read(kCan + 0x10);
  if (which != 1) {
    (void)read(kCan + 0x04);
    return;
  }
  // Interface 2 belongs to the interrupt.
  write(kCan + 0x84, 0x3F);
  write(kCan + 0x80, 1);
  while ((read(kCan + 0x80) & 0x8000U) != 0) {
  }
  const std::uint32_t id = (read(kCan + 0x94) >> 2) & 0x7FFU;
  const std::uint32_t length = read(kCan + 0x98) & 0xFU;
  write(kCan + 0x94, 0xA000U | ((id + 1) << 2));
  write(kCan + 0x98, 0x0180U | 0x8000U | length);
  for (std::uint32_t i = 0; i < 4; ++i) write(kCan + 0x9C + 4 * i, ~read(kCan + 0x9C + 4 * i) & 0xFFFFU);
  write(kCan + 0x84, 0xB7);
  write(kCan + 0x80, 2);
  while ((read(kCan + 0x80) & 0x8000U) != 0) {
  }
  seen.frames = seen.frames + 1;
}
void fault_handler() {
  for (;;) {
  }
}

void start() {
  seen.ticks = 0;
  seen.frames = 0;
  seen.nested = 0;
  seen.timer = 0;
  seen.interrupted_at_level = 0;
  seen.asleep = 0;
  // Crystal, PLL at four times, three clocks for the flash.
  write(kSyscon + 0x238, 0xED50);
  for (int i = 0; i < 3000; ++i) asm volatile("nop");
  write(kSyscon + 0x040, 1);
  write(kSyscon + 0x044, 0);
  write(kSyscon + 0x044, 1);
  write(kSyscon + 0x008, 0x23);
  while ((read(kSyscon + 0x00C) & 1U) == 0) {
  }
  write(kFlashcfg, (read(kFlashcfg) & ~3U) | 2U);
  write(kSyscon + 0x070, 3);
  write(kSyscon + 0x074, 0);
  write(kSyscon + 0x074, 1);
  // Clocks of CAN and CT32B0, CAN out of reset.
  write(kSyscon + 0x080, read(kSyscon + 0x080) | (1U << 17) | (1U << 9));
  write(kSyscon + 0x004, 8);

  write(kCan + 0x00, 0x41);
  write(kCan + 0x180, 0);
  write(kCan + 0x0C, 0x1C0B);
  for (std::uint32_t object = 1; object <= 32; ++object) {
    write(kCan + 0x24, 0xF0);
    write(kCan + 0x28, 0);
    write(kCan + 0x2C, 0xC000);
    write(kCan + 0x30, 0);
    write(kCan + 0x34, object == 1 ? 0x8000 : 0);
    write(kCan + 0x38, object == 1 ? 0x1480 : 0);
    write(kCan + 0x20, object);
    while ((read(kCan + 0x20) & 0x8000U) != 0) {
    }
  }
  write(kCan + 0x00, 0x02);

  // The timer interrupts every 100 us, SysTick every millisecond, one level below.
  write(kTimer + 0x0C, 47);
  write(kTimer + 0x18, 99);
  write(kTimer + 0x14, 3);
  write(kTimer + 0x04, 1);
  write(0xE000E410, 0x00804000);  // IRQ 16 to 19: CT32B0 (18) at 2
  write(0xE000E40C, 0x00004000);  // CAN (13) at 1
  write(0xE000ED20, 0xC0000000);  // SysTick at 3
  write(0xE000E100, (1U << 13) | (1U << 18));
  write(0xE000E014, 47999);
  write(0xE000E018, 0);
  write(0xE000E010, 7);
  for (;;) {
    asm volatile("wfi");
    seen.asleep = seen.asleep + 1;
  }
}

using Entry = void (*)();
constexpr std::uint32_t kStackTop = 0x10001FE0;
struct Vectors {
  std::uint32_t stack;
  Entry entries[47];
};
}

// The ROM's checksum depends on addresses known only to the linker; the test writes it.
__attribute__((section(".vectors"), used)) const Vectors vectors = {
    kStackTop, {start,         fault_handler, fault_handler, nullptr,       nullptr,       nullptr,       nullptr,         nullptr,
                nullptr,       nullptr,       fault_handler, nullptr,       nullptr,       fault_handler, systick_handler, fault_handler,
                fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler,   fault_handler,
                fault_handler, fault_handler, fault_handler, fault_handler, can_handler,   fault_handler, fault_handler,   fault_handler,
                fault_handler, timer_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler,   fault_handler,
                fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler}};
