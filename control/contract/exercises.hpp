// The rows of exercises.def.
#pragma once
#include <array>
#include <string_view>

#include "control/contract/reference_path.hpp"

namespace hoist::contract {

struct ExerciseShape {
  std::string_view name;
  bool turned;  // may be walked clockwise too
};
struct ExerciseSize {
  std::string_view shape, name, stored;
  bool required;
  double usual_m;
  double share;         // at most this share of the size `of`; 0 = no such limit
  std::string_view of;  // its name
  std::string_view doc;
};

/// Sizes that fit a hall and a hoist.
inline constexpr double kExerciseLeast_m = 0.2, kExerciseMost_m = 100.0;

#define HOIST_SIZE(...)
inline constexpr std::array kExerciseShapes{
#define HOIST_SHAPE(shape, turned) ExerciseShape{#shape, (turned) != 0},
#include "control/contract/exercises.def"
#undef HOIST_SHAPE
};
#undef HOIST_SIZE
#define HOIST_SHAPE(...)
inline constexpr std::array kExerciseSizes{
#define HOIST_SIZE(shape, name, stored, required, usual_m, share, of, doc) \
  ExerciseSize{#shape, #name, stored, (required) != 0, usual_m, share, of, doc},
#include "control/contract/exercises.def"
#undef HOIST_SIZE
};
#undef HOIST_SHAPE

/// Null for an unknown shape, and for a size that the shape does not have.
[[nodiscard]] constexpr const ExerciseShape* find_exercise_shape(std::string_view name) {
  for (const ExerciseShape& shape : kExerciseShapes)
    if (shape.name == name) return &shape;
  return nullptr;
}
[[nodiscard]] constexpr const ExerciseSize* find_exercise_size(std::string_view shape, std::string_view name) {
  for (const ExerciseSize& size : kExerciseSizes)
    if (size.shape == shape && size.name == name) return &size;
  return nullptr;
}

// The paper's sizes have one value here and in the figures.
static_assert(find_exercise_size("eight", "c_m")->usual_m == kEightCentre_m &&
              find_exercise_size("eight", "radius_m")->usual_m == kEightRadius_m &&
              find_exercise_size("square", "side_m")->usual_m == kSquareSide_m &&
              find_exercise_size("straight", "length_m")->usual_m == kStraightLength_m);

}  // namespace hoist::contract
