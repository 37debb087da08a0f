#include "server/api/exercise.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "control/contract/reference_path.hpp"
#include "server/http/json_text.hpp"

namespace hoist::server {

using nlohmann::json;

namespace {
bool read_size(const json& value, const char* name, double& size, std::vector<FieldError>& errors) {
  const auto at = value.find(name);
  if (at == value.end() || !at->is_number()) {
    errors.push_back({std::string{"exercise."} + name, "must be a number", std::nullopt, kExerciseMin_m, kExerciseMax_m});
    return false;
  }
  size = at->get<double>();
  if (!std::isfinite(size) || size < kExerciseMin_m || size > kExerciseMax_m) {
    errors.push_back({std::string{"exercise."} + name, "is outside its range", size, kExerciseMin_m, kExerciseMax_m});
    return false;
  }
  return true;
}
}  // namespace

std::optional<Exercise> read_exercise(const json& value, std::vector<FieldError>& errors) {
  Exercise exercise;
  if (value.is_null()) return exercise;
  const auto shape = value.is_object() ? value.find("shape") : value.end();
  if (!value.is_object() || shape == value.end() || !shape->is_string()) {
    errors.push_back({"exercise.shape", "must be eight, square, straight or free"});
    return std::nullopt;
  }
  const std::string name = shape->get<std::string>();
  if (name == "free") return exercise;
  if (name == "eight") {
    exercise.shape = Exercise::Shape::eight;
    if (!read_size(value, "c_m", exercise.c_m, errors) || !read_size(value, "radius_m", exercise.radius_m, errors)) return std::nullopt;
    if (exercise.radius_m > exercise.c_m) {
      errors.push_back({"exercise.radius_m", "must not exceed c_m", exercise.radius_m, kExerciseMin_m, exercise.c_m});
      return std::nullopt;
    }
    return exercise;
  }
  if (name == "square") {
    exercise.shape = Exercise::Shape::square;
    return read_size(value, "side_m", exercise.side_m, errors) ? std::optional{exercise} : std::nullopt;
  }
  if (name == "straight") {
    exercise.shape = Exercise::Shape::straight;
    return read_size(value, "length_m", exercise.length_m, errors) ? std::optional{exercise} : std::nullopt;
  }
  errors.push_back({"exercise.shape", "must be eight, square, straight or free"});
  return std::nullopt;
}

json exercise_json(const Exercise& e) {
  switch (e.shape) {
    case Exercise::Shape::eight:
      return {{"shape", "eight"}, {"c_m", e.c_m}, {"radius_m", e.radius_m}};
    case Exercise::Shape::square:
      return {{"shape", "square"}, {"side_m", e.side_m}};
    case Exercise::Shape::straight:
      return {{"shape", "straight"}, {"length_m", e.length_m}};
    case Exercise::Shape::free:
      break;
  }
  return {{"shape", "free"}};
}

std::optional<std::string> stored_exercise(const Exercise& e) {
  if (e.shape == Exercise::Shape::free) return std::nullopt;
  if (e.shape == Exercise::Shape::eight) return json{{"shape", "eight"}, {"centre_m", e.c_m}, {"radius_m", e.radius_m}}.dump();
  return exercise_json(e).dump();
}

json exercise_of_store(const std::optional<std::string>& text) {
  if (!text) return nullptr;
  JsonError ignored;
  auto value = parse_json(*text, ignored);
  if (!value || !value->is_object()) return nullptr;
  if (const auto centre = value->find("centre_m"); centre != value->end()) {
    (*value)["c_m"] = *centre;
    value->erase("centre_m");
  }
  return *value;
}

StartPose start_pose(const Exercise& e) {
  using contract::ReferencePath;
  if (e.shape == Exercise::Shape::free) return {};
  const ReferencePath path = e.shape == Exercise::Shape::eight    ? ReferencePath::eight(e.c_m, e.radius_m)
                             : e.shape == Exercise::Shape::square ? ReferencePath::square(e.side_m)
                                                                  : ReferencePath::straight(e.length_m);
  const contract::PathPose pose = path.pose(0.0);
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
