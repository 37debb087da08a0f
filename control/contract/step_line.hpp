// Lock-step between simulator and core: one packet each way per control period over a Unix SOCK_SEQPACKET socket. The simulator advances its
// world by one period and offers the step; the core ticks and answers; only then does the world go on. So both have the same time, however
// slowly this computer runs them. A packet is a header with text behind it: what the gateway's serial line carried in that period.
#pragma once
#include <cstddef>
#include <cstdint>

namespace hoist::contract {

inline constexpr std::uint64_t kStepPeriod_ns = 10'000'000;
inline constexpr std::uint32_t kStepMagic = 0x31505448;  // "HTP1", little endian
/// Text of one packet. The line carries 1000 characters in a period (1 Mbaud).
inline constexpr std::size_t kStepTextMax = 2048;
/// A partner that is connected and silent for this long has hung: the other one goes on by the steady clock without it. Far beyond what a
/// busy computer delays a program that is ready to run.
inline constexpr int kStepSilence_ms = 5000;

struct StepHeader {
  std::uint32_t magic = kStepMagic;
  std::uint32_t step = 0;  ///< counted by the simulator from 1 at each connection; the answer repeats it
  std::uint32_t room = 0;  ///< simulator: characters that it takes with the answer (RTS/CTS of the real line); core: 0
};
static_assert(sizeof(StepHeader) == 12);
inline constexpr std::size_t kStepPacketMax = sizeof(StepHeader) + kStepTextMax;

}  // namespace hoist::contract
