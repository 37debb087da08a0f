// Four words that survive a reset, at the same address for loader and application: whether the next start stays in the loader, and how
// often in a row the application ended by watchdog or fault.
//
// The chip keeps this address over every reset, and no factory program writes it (memory.hpp of the chip). After power-on the words are
// random, so each has its complement beside it; a mismatch counts as "no request, no failure".
#pragma once
#include <cstdint>

namespace hoist::firmware {

// Volatile: on the LPC11C24 they are registers, and a reset may follow each write.
struct Mailbox {
  volatile std::uint32_t request = 0, request_check = 0;
  volatile std::uint32_t failures = 0, failures_check = 0;
};
static_assert(sizeof(Mailbox) == 16);

inline constexpr std::uint32_t kEnterLoader = 0x4C4F4144U;      // "LOAD"
inline constexpr std::uint32_t kApplicationRuns = 0x52554E53U;  // "RUNS": left by the loader, taken away by every orderly restart
// After so many failures in a row the node stays in its loader, so that a crashing program can be replaced.
inline constexpr std::uint32_t kFailedStartsMax = 3;
// An application that has run for so long has started well; it then calls forget_failures().
inline constexpr std::uint32_t kStartedWell_ms = 10000;

inline void leave_request(Mailbox& mailbox, std::uint32_t request) {
  mailbox.request = request;
  mailbox.request_check = ~request;
}
inline bool request_is(const Mailbox& mailbox, std::uint32_t request) {
  return mailbox.request == request && mailbox.request_check == ~request;
}
inline void request_loader(Mailbox& mailbox) { leave_request(mailbox, kEnterLoader); }
inline void forget_request(Mailbox& mailbox) { leave_request(mailbox, 0); }
inline bool loader_requested(const Mailbox& mailbox) { return request_is(mailbox, kEnterLoader); }
// The application ended without saying so: a fault that reset the chip.
inline bool application_fell(const Mailbox& mailbox) { return request_is(mailbox, kApplicationRuns); }

inline std::uint32_t failures(const Mailbox& mailbox) {
  const std::uint32_t count = mailbox.failures;
  return mailbox.failures_check == ~count ? count : 0;
}
inline void set_failures(Mailbox& mailbox, std::uint32_t count) {
  mailbox.failures = count;
  mailbox.failures_check = ~count;
}
inline void forget_failures(Mailbox& mailbox) { set_failures(mailbox, 0); }

}  // namespace hoist::firmware
