// What ends a clinical task (db/tasks).
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace hoist::db {

enum class TaskEnd : std::uint8_t {
  distance,  ///< the task's line, walked so many times
  time,      ///< so many seconds since the first movement
  turn,      ///< so many radians from the heading at the start, to either side
  hand       ///< when the therapist ends it
};
inline constexpr std::array<std::string_view, 4> kTaskEnds{"distance", "time", "turn", "hand"};
[[nodiscard]] constexpr std::string_view task_end_name(TaskEnd end) { return kTaskEnds[static_cast<std::size_t>(end)]; }
[[nodiscard]] constexpr std::optional<TaskEnd> find_task_end(std::string_view name) {
  for (std::size_t i = 0; i < kTaskEnds.size(); ++i)
    if (kTaskEnds[i] == name) return static_cast<TaskEnd>(i);
  return std::nullopt;
}

/// The end of the line counts as reached this far before it: the projection of a walk that ends on it may stay just short.
inline constexpr double kTaskArrived_m = 0.02;

}  // namespace hoist::db
