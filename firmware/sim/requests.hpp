// Requests to a running simulator: one JSON object per line, one line of answer. The operations are one list in requests.cpp; {"op":"help"}
// answers with it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "firmware/sim/world.hpp"

namespace hoist::sim {

class PokeysDevice;

/// Longest line that is read; a longer one is refused.
inline constexpr std::size_t kRequestMax = 4096;

/// Values that only the program around the world knows.
struct ProgramState {
  std::uint64_t late{};           ///< times it was more than 5 ms behind and let time go
  bool computer_attached{false};  ///< a program has the serial line open, or the CAN interface is up
  bool* line_cut{nullptr};        ///< set: the serial line carries nothing; null where there is none
  PokeysDevice* pokeys{nullptr};  ///< the PoKeys on the network, if there is one
};

/// Carries out one request. Always one line of JSON without its end: the result, or {"error": "..."} that names the field and its range; a
/// refused request changes nothing.
[[nodiscard]] std::string answer_request(World& world, const ProgramState& program, std::string_view line);

}  // namespace hoist::sim
