// The journal of the control steps: inputs and memory of the core as plain bytes, and back. Pure functions, for the loop, the tool and the tests.
#pragma once
#include <bit>
#include <cstring>
#include <span>
#include <type_traits>

#include "control/contract/journal.hpp"
#include "control/core/state.hpp"
#include "control/core/types.hpp"

namespace hoist::publish {

// Not is_trivially_copyable, which std::tuple (the monitors) misses by its assignment alone: copying the bytes is what its copy constructor does.
static_assert(std::is_trivially_copy_constructible_v<core::CoreState> && std::is_trivially_destructible_v<core::CoreState>);
static_assert(sizeof(core::CoreState) <= contract::kCoreImage_bytes, "make kCoreImage_bytes larger");
static_assert(sizeof(core::TickInputs) == 184 && sizeof(core::BusCounters) == 28 && sizeof(core::LoopHealth) == 24,
              "TickInputs has changed: give what is new a row in journal.def, then correct this line");

/// Tells two records apart: any differing bit, but for one pair in 2^32.
[[nodiscard]] inline std::uint32_t digest_of(const contract::TickRecord& record) noexcept {
  static_assert(sizeof(contract::TickRecord) % 8 == 0);
  const auto* bytes = reinterpret_cast<const unsigned char*>(&record);
  std::uint64_t digest = 0;
  for (std::size_t at = 0; at < sizeof record; at += 8) {
    std::uint64_t word;
    std::memcpy(&word, bytes + at, 8);
    digest = (digest ^ word) * 0x9E3779B97F4A7C15ULL;
    digest ^= digest >> 29;
  }
  return static_cast<std::uint32_t>(digest >> 32);
}

/// A step's inputs as they are kept. `step` counts from the core's start.
[[nodiscard]] inline contract::JournalStep journal_of(const core::TickInputs& inputs, std::uint64_t step,
                                                      std::uint32_t record_digest) noexcept {
  contract::JournalStep row;
  row.step = step;
  row.frames = static_cast<std::uint32_t>(inputs.frames.size());
  row.commands = static_cast<std::uint32_t>(inputs.commands.size());
  row.record_digest = record_digest;
#define HOIST_JOURNAL(type, name, where) row.name = static_cast<contract::journal_cpp::type>(inputs.where);
#include "control/contract/journal.def"
#undef HOIST_JOURNAL
  return row;
}

/// The same inputs again. A driving command is only there with drive_fresh: the core looks at no other.
[[nodiscard]] inline core::TickInputs inputs_of(const contract::JournalStep& row, std::span<const contract::CanFrame> frames,
                                                std::span<const contract::Command> commands) noexcept {
  core::TickInputs inputs;
#define HOIST_JOURNAL(type, name, where) inputs.where = static_cast<decltype(inputs.where)>(row.name);
#include "control/contract/journal.def"
#undef HOIST_JOURNAL
  inputs.frames = frames;
  inputs.commands = commands;
  return inputs;
}

/// The core's memory before step `step`, whose tick is `tick`.
inline void take_image(const core::CoreState& state, std::uint64_t step, std::uint64_t tick, contract::CoreImage& image) noexcept {
  image.step = step;
  image.tick = tick;
  image.bytes = sizeof state;
  std::memcpy(image.memory.data(), static_cast<const void*>(&state), sizeof state);
}

/// False, and nothing changed, when the image has another size. Whether it is of this build, and whole, is for the caller to know: any other
/// bytes may hold values that no core ever has.
[[nodiscard]] inline bool put_image(const contract::CoreImage& image, core::CoreState& state) noexcept {
  if (image.bytes != sizeof state) return false;
  std::memcpy(static_cast<void*>(&state), image.memory.data(), sizeof state);
  return true;
}

}  // namespace hoist::publish
