// What each control step was given, for running it again: typed view of journal.def, and copies of the core's memory to begin from.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "control/contract/commands.hpp"

namespace hoist::contract {

namespace journal_cpp {
using u64 = std::uint64_t;
using u32 = std::uint32_t;
using u16 = std::uint16_t;
using u8 = std::uint8_t;
using f32 = float;
using f32_s = float;
using f64 = double;
}  // namespace journal_cpp

/// One step. Steps are numbered from 0 at the core's start without a hole, also where ticks were left out: a jump of `step` is a loss.
struct alignas(8) JournalStep {
  std::uint64_t step = 0;
  std::uint32_t frames = 0, commands = 0;  ///< how many it was given
  std::uint32_t record_digest = 0;         ///< digest_of the TickRecord that it gave
#define HOIST_JOURNAL(type, name, where) journal_cpp::type name = 0;
#include "control/contract/journal.def"
#undef HOIST_JOURNAL
};
static_assert(std::is_trivially_copyable_v<JournalStep> && sizeof(JournalStep) % 8 == 0);

/// A command with the step that was given it.
struct JournalCommand {
  std::uint64_t step = 0;
  Command command;
};
static_assert(std::is_trivially_copyable_v<JournalCommand> && sizeof(JournalCommand) == 72);

/// The core's memory before a step, as plain bytes: of use only to a program of the same build.
inline constexpr std::size_t kCoreImage_bytes = 36'864;
struct CoreImage {
  std::uint64_t step = 0, tick = 0;  ///< of the step that comes next
  std::uint64_t bytes = 0;           ///< of `memory` that are used
  std::array<std::uint8_t, kCoreImage_bytes> memory{};
};
static_assert(std::is_trivially_copyable_v<CoreImage> && sizeof(CoreImage) % 8 == 0);

}  // namespace hoist::contract
