// lockstep.hpp on a bare Cortex-M0: runs the drive (LOCKSTEP_DRIVE) or the tilt sensor for ever. It sleeps before and after each tick of
// the node, so that the test can count the clocks between; `state` is its phase. Under QEMU (LOCKSTEP_QEMU) it does not sleep, prints the
// digest after LOCKSTEP_TICKS by semihosting and ends.
#include <cstddef>
#include <cstdint>
#include <new>

#include "tests/machine/programs/lockstep.hpp"

#ifdef LOCKSTEP_DRIVE
using Run = hoist::lockstep::DriveRun;
#else
using Run = hoist::lockstep::TiltRun;
#endif

extern "C" {

struct State {
  std::uint32_t ticks, digest, sent, working;
};
volatile State state;

void start();
}

namespace {

alignas(Run) std::byte place[sizeof(Run)];

#ifdef LOCKSTEP_QEMU
// Semihosting (ARM 100863): SYS_WRITE0, then SYS_EXIT with "application exit".
void call_host(std::uint32_t operation, std::uint32_t argument) {
  register std::uint32_t r0 asm("r0") = operation;
  register std::uint32_t r1 asm("r1") = argument;
  asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}
void print_and_exit(std::uint32_t digest) {
  static char text[10];
  for (unsigned i = 0; i < 8; ++i) text[i] = "0123456789abcdef"[(digest >> (28 - 4 * i)) & 15U];
  text[8] = '\n';
  text[9] = 0;
  call_host(0x04, reinterpret_cast<std::uint32_t>(text));
  call_host(0x18, 0x20026);
}
#endif

void mark(bool working) {
  state.working = working ? 1 : 0;
#ifndef LOCKSTEP_QEMU
  asm volatile("wfi" ::: "memory");
#endif
}

}  // namespace

extern "C" void start() {
  state.ticks = 0;
  Run& run = *new (place) Run;
  for (;;) {
    run.step(mark);
    state.digest = run.digest();
    state.sent = run.sent();
    state.ticks = state.ticks + 1;
#ifdef LOCKSTEP_QEMU
    if (state.ticks == LOCKSTEP_TICKS) print_and_exit(run.digest());
#endif
  }
}

namespace {
void fault() {
  for (;;) {
  }
}
using Entry = void (*)();
}  // namespace

extern "C" std::uint32_t stack_top;

__attribute__((section(".vectors"), used)) const struct {
  std::uint32_t* stack;
  Entry entries[15];
} vectors = {&stack_top,
             {start, fault, fault, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, fault, nullptr, nullptr, fault, fault}};
