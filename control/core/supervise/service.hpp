// Service: the hoist stays in INIT while an engineer's tool gives nodes new programs through the running core (`Service` in state.hpp).
#pragma once
#include <cstdint>

namespace hoist::core {

struct CoreState;

/// The lease holder, an engineer, wants nodes to get new programs: INIT, and it stays. Also from INIT, where a node without a program keeps
/// the hoist. Refusal bits, 0 = service is on.
[[nodiscard]] std::uint32_t begin_service(CoreState& state) noexcept;

}  // namespace hoist::core
