// The vector table: at the start of the image, and copied to the start of RAM, because this processor takes its vectors from address 0,
// where the loader's are.
#pragma once
#include <cstddef>
#include <cstdint>

#include "firmware/boards/cortex_m0/run.hpp"
#include "firmware/boards/cortex_m0/startup.hpp"

extern "C" {
// Made by the linker script so that the first eight words add up to zero: otherwise the ROM of the LPC11C24 does not start the program at
// address 0.
extern std::uint32_t hoist_vector_checksum[];

inline void systick_interrupt() { hoist::firmware::cortex_m0::on_systick(); }
}

namespace hoist::firmware::cortex_m0 {

union Vector {
  std::uint32_t* address;
  void (*handler)();
};
template <std::size_t kBytes>
struct Vectors {
  Vector at[kBytes / 4];
};
struct Interrupt {
  std::uint32_t number;
  void (*handler)();
};

// Any other interrupt is a fault.
template <std::size_t kBytes, std::size_t kHandled>
consteval Vectors<kBytes> make_vectors(const Interrupt (&handled)[kHandled]) {
  Vectors<kBytes> v{};
  for (Vector& entry : v.at) entry = {.handler = fault_handler};
  v.at[0] = {.address = hoist_stack_top};
  v.at[1] = {.handler = reset_handler};
  for (std::size_t i = 4; i < 16; ++i) v.at[i] = {.address = nullptr};  // reserved
  v.at[7] = {.address = hoist_vector_checksum};
  v.at[11] = {.handler = fault_handler};  // SVC
  v.at[14] = {.handler = fault_handler};  // PendSV
  v.at[15] = {.handler = systick_interrupt};
  for (const Interrupt& one : handled) v.at[16 + one.number] = {.handler = one.handler};
  return v;
}

template <std::size_t kBytes>
void copy_vectors(const Vectors<kBytes>& table, std::uint32_t to) {
  const std::uint32_t from = reinterpret_cast<std::uintptr_t>(&table);
  for (std::uint32_t i = 0; i < kBytes; i += 4) write_word(to + i, read_word(from + i));
}

}  // namespace hoist::firmware::cortex_m0
