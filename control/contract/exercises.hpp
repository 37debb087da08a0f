// The rows of exercises.def, and the one place where an exercise becomes a line on the floor.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

#include "control/contract/check.hpp"
#include "control/contract/own_line.hpp"
#include "control/contract/reference_path.hpp"

namespace hoist::contract {

#define HOIST_EXERCISE_SIZE(...)
enum class ExerciseShape : std::uint8_t {
#define HOIST_EXERCISE(shape, number, turned, closed, title_en, title_de) shape = number,
#include "control/contract/exercises.def"
#undef HOIST_EXERCISE
};

struct ExerciseInfo {
  std::string_view name;
  ExerciseShape shape;
  bool turned, closed;
  std::string_view title_en, title_de;
};
inline constexpr std::array kExercises{
#define HOIST_EXERCISE(shape, number, turned, closed, title_en, title_de) \
  ExerciseInfo{#shape, ExerciseShape::shape, turned, closed, title_en, title_de},
#include "control/contract/exercises.def"
#undef HOIST_EXERCISE
};
#undef HOIST_EXERCISE_SIZE

enum class ExerciseRole : std::uint8_t { size, radius };
struct ExerciseSize {
  ExerciseShape shape;
  ExerciseRole role;
  std::string_view name, stored;
  bool required;
  double usual_m, driven_least_m, driven_most_m, share, curve;
  std::string_view title_en, title_de, doc;
};
#define HOIST_EXERCISE(...)
inline constexpr std::array kExerciseSizes{
#define HOIST_EXERCISE_SIZE(shape, role, name, stored, required, usual_m, driven_least_m, driven_most_m, share, curve, title_en, title_de, \
                            doc)                                                                                                           \
  ExerciseSize{ExerciseShape::shape,                                                                                                       \
               ExerciseRole::role,                                                                                                         \
               #name,                                                                                                                      \
               stored,                                                                                                                     \
               required,                                                                                                                   \
               usual_m,                                                                                                                    \
               driven_least_m,                                                                                                             \
               driven_most_m,                                                                                                              \
               share,                                                                                                                      \
               curve,                                                                                                                      \
               title_en,                                                                                                                   \
               title_de,                                                                                                                   \
               doc},
#include "control/contract/exercises.def"
#undef HOIST_EXERCISE_SIZE
};
#undef HOIST_EXERCISE

/// Sizes that can be walked: they fit a hall and a hoist.
inline constexpr double kExerciseLeast_m = 0.2, kExerciseMost_m = 100.0;

static_assert(unique_by(kExercises, [](const ExerciseInfo& e) { return e.name; }), "exercises.def: a shape is named twice");
static_assert(all_rows(kExerciseSizes,
                       [](const ExerciseSize& s) {
                         return s.share >= 0 && s.share <= 1 && s.curve >= 0 && s.curve <= 1 && s.driven_least_m >= kExerciseLeast_m &&
                                s.driven_most_m <= kExerciseMost_m && s.driven_least_m < s.driven_most_m &&
                                (s.role == ExerciseRole::radius || (s.share == 0 && s.required));
                       }),
              "exercises.def: a size has no usable range");

/// Null for a name or number that no row has.
[[nodiscard]] constexpr const ExerciseInfo* find_exercise(std::string_view name) {
  for (const ExerciseInfo& row : kExercises)
    if (row.name == name) return &row;
  return nullptr;
}
[[nodiscard]] constexpr const ExerciseInfo* find_exercise(ExerciseShape shape) {
  for (const ExerciseInfo& row : kExercises)
    if (row.shape == shape) return &row;
  return nullptr;
}
/// Null where the shape has no such size.
[[nodiscard]] constexpr const ExerciseSize* find_size(ExerciseShape shape, ExerciseRole role) {
  for (const ExerciseSize& row : kExerciseSizes)
    if (row.shape == shape && row.role == role) return &row;
  return nullptr;
}

/// Whether the hoist can drive it by itself: it has a line that follows from the sizes in a command.
[[nodiscard]] constexpr bool drivable(ExerciseShape shape) { return shape != ExerciseShape::free && shape != ExerciseShape::own; }

/// One exercise but for points. Sizes by role; one that the shape does not have, or that was left out, is 0.
struct SizedExercise {
  using Shape = ExerciseShape;
  ExerciseShape shape = ExerciseShape::free;
  bool clockwise = false;  ///< the figure with left and right exchanged
  double size_m = 0;
  double radius_m = 0;
};
struct Exercise : SizedExercise {
  OwnLine line = {};  ///< of the shape own
};
[[nodiscard]] constexpr double& size_of(SizedExercise& exercise, ExerciseRole role) {
  return role == ExerciseRole::size ? exercise.size_m : exercise.radius_m;
}
[[nodiscard]] constexpr double size_of(const SizedExercise& exercise, ExerciseRole role) {
  return role == ExerciseRole::size ? exercise.size_m : exercise.radius_m;
}
/// An own line for examples.
inline constexpr OwnLine kUsualOwnLine{{{{0, 0}, {4, 0}, {4, 2}, {2, 3}, {0, 2}}}, 5, true};
/// The shape with the sizes of its rows.
[[nodiscard]] constexpr Exercise usual_exercise(ExerciseShape shape) {
  Exercise exercise{{shape, false, 0, 0}, shape == ExerciseShape::own ? kUsualOwnLine : OwnLine{}};
  for (const ExerciseSize& row : kExerciseSizes)
    if (row.shape == shape) size_of(exercise, row.role) = row.usual_m;
  return exercise;
}
/// The size that gives the radius of its curves; null for a shape without curves.
[[nodiscard]] constexpr const ExerciseSize* find_curve(ExerciseShape shape) {
  for (const ExerciseSize& row : kExerciseSizes)
    if (row.shape == shape && row.curve > 0) return &row;
  return nullptr;
}

/// The line on the floor, in the figure's own frame. Not valid() for free walking and own lines, and for sizes that make no figure.
[[nodiscard]] inline ReferencePath figure_of(const SizedExercise& exercise) {
  const auto figure = [&exercise] {
    switch (exercise.shape) {
      case ExerciseShape::square:
        return exercise.radius_m > 0 ? ReferencePath::round_square(exercise.size_m, exercise.radius_m)
                                     : ReferencePath::square(exercise.size_m);
      case ExerciseShape::circle:
        return ReferencePath::circle(exercise.size_m);
      case ExerciseShape::eight:
        return ReferencePath::eight(exercise.size_m, exercise.radius_m);
      case ExerciseShape::slalom:
        return ReferencePath::slalom(exercise.size_m);
      case ExerciseShape::straight:
        return ReferencePath::straight(exercise.size_m);
      case ExerciseShape::own:
      case ExerciseShape::free:
        break;
    }
    return ReferencePath::straight(0.0);
  };
  return exercise.clockwise ? figure().mirrored() : figure();
}
/// The same, and of an own line as it was drawn.
[[nodiscard]] inline ReferencePath figure_of(const Exercise& exercise) {
  if (exercise.shape == ExerciseShape::own) return ReferencePath::own(exercise.line, exercise.radius_m);
  return figure_of(static_cast<const SizedExercise&>(exercise));
}

}  // namespace hoist::contract
