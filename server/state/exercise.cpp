#include "server/state/exercise.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "control/contract/reference_path.hpp"

namespace hoist::server {

using nlohmann::json;

namespace {
// A number within the sizes that fit; nothing, with the reason, for anything else.
std::optional<double> read_size(const json& value, const std::string& field, const char* name, std::vector<FieldError>& errors) {
  const auto at = value.find(name);
  if (at == value.end() || !at->is_number()) {
    errors.push_back({field + "." + name, "must be a number", std::nullopt, kExerciseMin_m, kExerciseMax_m});
    return std::nullopt;
  }
  const auto size = at->get<double>();
  if (!std::isfinite(size) || size < kExerciseMin_m || size > kExerciseMax_m) {
    errors.push_back({field + "." + name, "is outside its range", size, kExerciseMin_m, kExerciseMax_m});
    return std::nullopt;
  }
  return size;
}

bool read_side(const json& value, const std::string& field, bool& clockwise, std::vector<FieldError>& errors) {
  const auto at = value.find("clockwise");
  if (at == value.end() || at->is_null()) return true;
  if (at->is_boolean()) {
    clockwise = at->get<bool>();
    return true;
  }
  errors.push_back({field + ".clockwise", "must be true or false"});
  return false;
}

constexpr const char* kShapes = "must be eight, square, circle, straight or free";
}  // namespace

std::optional<Exercise> read_exercise(const json& value, std::vector<FieldError>& errors, const std::string& field) {
  Exercise exercise;
  if (value.is_null()) return exercise;
  const auto shape = value.is_object() ? value.find("shape") : value.end();
  if (!value.is_object() || shape == value.end() || !shape->is_string()) {
    errors.push_back({field + ".shape", kShapes});
    return std::nullopt;
  }
  const std::string name = shape->get<std::string>();
  bool good = true;
  const auto take = [&](const char* size_name, double& size) {
    const auto read = read_size(value, field, size_name, errors);
    size = read.value_or(0);
    good = good && read;
  };
  if (name == "free") return exercise;
  if (name == "eight") {
    exercise.shape = Exercise::Shape::eight;
    take("c_m", exercise.c_m);
    take("radius_m", exercise.radius_m);
    if (good && exercise.radius_m > exercise.c_m) {
      errors.push_back({field + ".radius_m", "must not exceed c_m", exercise.radius_m, kExerciseMin_m, exercise.c_m});
      good = false;
    }
  } else if (name == "square") {
    exercise.shape = Exercise::Shape::square;
    take("side_m", exercise.side_m);
    const auto corner = value.find("corner_radius_m");
    // Zero says what leaving it out says: sharp corners.
    if (corner != value.end() && !corner->is_null() && *corner != 0) take("corner_radius_m", exercise.corner_radius_m);
    if (good && 2 * exercise.corner_radius_m > exercise.side_m) {
      errors.push_back({field + ".corner_radius_m", "must not exceed half of side_m", exercise.corner_radius_m, 0, exercise.side_m / 2});
      good = false;
    }
  } else if (name == "circle") {
    exercise.shape = Exercise::Shape::circle;
    take("radius_m", exercise.radius_m);
  } else if (name == "straight") {
    exercise.shape = Exercise::Shape::straight;
    take("length_m", exercise.length_m);
    return good ? std::optional{exercise} : std::nullopt;
  } else {
    errors.push_back({field + ".shape", kShapes});
    return std::nullopt;
  }
  good = read_side(value, field, exercise.clockwise, errors) && good;
  return good ? std::optional{exercise} : std::nullopt;
}

namespace {
// The fields of the core's check by the names that this shape has for them.
std::string guided_field(contract::GuidedField field, Exercise::Shape shape) {
  using contract::GuidedField;
  const bool square = shape == Exercise::Shape::square;
  switch (field) {
    case GuidedField::size:
      return square                             ? "path.side_m"
             : shape == Exercise::Shape::eight  ? "path.c_m"
             : shape == Exercise::Shape::circle ? "path.radius_m"
                                                : "path.length_m";
    case GuidedField::radius:
    case GuidedField::curve:
      return square ? "path.corner_radius_m" : "path.radius_m";
    case GuidedField::length:
      return "path.laps";
    default:
      return "path." + std::string{contract::guided_field_name(field)};
  }
}

const char* guided_message(contract::GuidedField field) {
  switch (field) {
    case contract::GuidedField::length:
      return "all laps together are longer than allowed; value, min and max are metres";
    case contract::GuidedField::curve:
      return "is tighter than the turning limit allows at any speed";
    default:
      return "is outside its range";
  }
}
}  // namespace

std::optional<contract::GuidedPath> read_guided(const json& value, const contract::GuidedLimits& limits, std::vector<FieldError>& errors) {
  const auto exercise = value.is_null() ? std::nullopt : read_exercise(value, errors, "path");
  if (value.is_null() || (exercise && exercise->shape == Exercise::Shape::free)) {
    errors.push_back({"path.shape", "must be eight, square, circle or straight"});
    return std::nullopt;
  }
  contract::GuidedPath path;
  if (const auto speed = value.is_object() ? value.find("speed_m_s") : value.end(); speed != value.end() && speed->is_number())
    path.speed_m_s = speed->get<double>();
  else
    errors.push_back({"path.speed_m_s", "must be a number", std::nullopt, contract::kGuidedSpeedLeast_m_s, limits.speed_m_s});
  if (const auto laps = value.is_object() ? value.find("laps") : value.end(); laps != value.end() && !laps->is_null()) {
    if (laps->is_number_unsigned() && laps->get<std::uint64_t>() <= contract::kGuidedLapsMost)
      path.laps = static_cast<std::uint32_t>(laps->get<std::uint64_t>());
    else
      errors.push_back({"path.laps", "must be a whole number in its range", std::nullopt, 1, contract::kGuidedLapsMost});
  }
  if (!exercise || !errors.empty()) return std::nullopt;
  switch (exercise->shape) {
    case Exercise::Shape::eight:
      path.shape = contract::GuidedShape::eight;
      path.size_m = exercise->c_m;
      path.radius_m = exercise->radius_m;
      break;
    case Exercise::Shape::square:
      path.shape = contract::GuidedShape::square;
      path.size_m = exercise->side_m;
      path.radius_m = exercise->corner_radius_m;
      break;
    case Exercise::Shape::circle:
      path.shape = contract::GuidedShape::circle;
      path.size_m = exercise->radius_m;
      break;
    case Exercise::Shape::straight:
    case Exercise::Shape::free:
      path.shape = contract::GuidedShape::straight;
      path.size_m = exercise->length_m;
      break;
  }
  path.clockwise = exercise->clockwise;
  const contract::GuidedProblems problems = contract::check_guided(path, limits);
  for (std::size_t i = 0; i < problems.count; ++i) {
    const contract::GuidedProblem& problem = problems.rows[i];
    errors.push_back({guided_field(problem.field, exercise->shape), guided_message(problem.field),
                      problem.finite ? std::optional{problem.value} : std::nullopt, problem.min, problem.max});
  }
  return errors.empty() ? std::optional{path} : std::nullopt;
}

Exercise exercise_of_guided(const contract::GuidedPath& path) {
  Exercise e;
  e.clockwise = path.clockwise && path.shape != contract::GuidedShape::straight;
  switch (path.shape) {
    case contract::GuidedShape::eight:
      e.shape = Exercise::Shape::eight;
      e.c_m = path.size_m;
      e.radius_m = path.radius_m;
      break;
    case contract::GuidedShape::square:
      e.shape = Exercise::Shape::square;
      e.side_m = path.size_m;
      e.corner_radius_m = path.radius_m;
      break;
    case contract::GuidedShape::circle:
      e.shape = Exercise::Shape::circle;
      e.radius_m = path.size_m;
      break;
    case contract::GuidedShape::straight:
      e.shape = Exercise::Shape::straight;
      e.length_m = path.size_m;
      break;
  }
  return e;
}

contract::ReferencePath figure_of(const Exercise& e) {
  using contract::ReferencePath;
  const auto figure = [&e] {
    switch (e.shape) {
      case Exercise::Shape::eight:
        return ReferencePath::eight(e.c_m, e.radius_m);
      case Exercise::Shape::square:
        return e.corner_radius_m > 0 ? ReferencePath::round_square(e.side_m, e.corner_radius_m) : ReferencePath::square(e.side_m);
      case Exercise::Shape::circle:
        return ReferencePath::circle(e.radius_m);
      case Exercise::Shape::straight:
        return ReferencePath::straight(e.length_m);
      case Exercise::Shape::free:
        break;
    }
    return ReferencePath::straight(0.0);
  };
  return e.clockwise ? figure().mirrored() : figure();
}

json exercise_json(const Exercise& e) {
  const auto sided = [&e](json out) {
    if (e.clockwise) out["clockwise"] = true;
    return out;
  };
  switch (e.shape) {
    case Exercise::Shape::eight:
      return sided({{"shape", "eight"}, {"c_m", e.c_m}, {"radius_m", e.radius_m}});
    case Exercise::Shape::square: {
      json out{{"shape", "square"}, {"side_m", e.side_m}};
      if (e.corner_radius_m > 0) out["corner_radius_m"] = e.corner_radius_m;
      return sided(std::move(out));
    }
    case Exercise::Shape::circle:
      return sided({{"shape", "circle"}, {"radius_m", e.radius_m}});
    case Exercise::Shape::straight:
      return {{"shape", "straight"}, {"length_m", e.length_m}};
    case Exercise::Shape::free:
      break;
  }
  return {{"shape", "free"}};
}

std::optional<std::string> stored_exercise(const Exercise& e) {
  if (e.shape == Exercise::Shape::free) return std::nullopt;
  json out = exercise_json(e);
  if (const auto centre = out.find("c_m"); centre != out.end()) {
    out["centre_m"] = *centre;
    out.erase("c_m");
  }
  return out.dump();
}

StartPose start_pose(const Exercise& e) {
  const contract::PathPose pose = figure_of(e).pose(0.0);
  return {pose.x_m, pose.y_m, pose.psi_rad};
}

Exercise exercise_of_scenario(std::string_view scenario) {
  Exercise e;
  if (scenario.find("eight") != std::string_view::npos) {
    e.shape = Exercise::Shape::eight;
    e.c_m = contract::kEightCentre_m;
    e.radius_m = contract::kEightRadius_m;
  } else if (scenario.find("square") != std::string_view::npos) {
    e.shape = Exercise::Shape::square;
    e.side_m = contract::kSquareSide_m;
  } else if (scenario.find("straight") != std::string_view::npos) {
    e.shape = Exercise::Shape::straight;
    e.length_m = contract::kStraightLength_m;
  }
  return e;
}

}  // namespace hoist::server
