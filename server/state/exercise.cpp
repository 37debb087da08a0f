#include "server/state/exercise.hpp"

#include <nlohmann/json.hpp>

#include "db/store/exercise_json.hpp"

namespace hoist::server {

using nlohmann::json;

std::optional<Exercise> read_exercise(const json& value, std::vector<FieldError>& errors, const std::string& field) {
  if (value.is_null()) return Exercise{};
  std::vector<db::ExerciseProblem> problems;
  const auto exercise = db::read_exercise(value, db::ExerciseNames::told, problems);
  for (db::ExerciseProblem& problem : problems)
    errors.push_back({field + "." + problem.field, std::move(problem.message), problem.value, problem.min, problem.max});
  return exercise;
}

namespace {
// The fields of the core's check by the names that this shape has for them.
std::string guided_field(contract::GuidedField field, contract::ExerciseShape shape) {
  using contract::GuidedField;
  const auto named = [](const contract::ExerciseSize* row) { return "path." + std::string{row == nullptr ? "shape" : row->name}; };
  switch (field) {
    case GuidedField::size:
      return named(contract::find_size(shape, contract::ExerciseRole::size));
    case GuidedField::radius:
      return named(contract::find_size(shape, contract::ExerciseRole::radius));
    case GuidedField::curve:
      return named(contract::find_curve(shape));
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
  json figure = value;
  if (figure.is_object())
    for (const char* name : {"speed_m_s", "laps"}) figure.erase(name);
  const auto exercise = value.is_null() ? std::nullopt : read_exercise(figure, errors, "path");
  if (value.is_null() || (exercise && !contract::drivable(exercise->shape))) {
    errors.push_back({"path.shape", "must be a figure that can be driven"});
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
  static_cast<contract::SizedExercise&>(path) = *exercise;
  const contract::GuidedProblems problems = contract::check_guided(path, limits);
  for (std::size_t i = 0; i < problems.count; ++i) {
    const contract::GuidedProblem& problem = problems.rows[i];
    errors.push_back({guided_field(problem.field, exercise->shape), guided_message(problem.field),
                      problem.finite ? std::optional{problem.value} : std::nullopt, problem.min, problem.max});
  }
  return errors.empty() ? std::optional{path} : std::nullopt;
}

json exercise_json(const Exercise& exercise) { return db::exercise_json(exercise, db::ExerciseNames::told); }

std::optional<std::string> stored_exercise(const Exercise& e, const std::optional<db::TaskRecord>& task) {
  if (task) return db::stored_with_task(e, *task);
  if (e.shape == Exercise::Shape::free) return std::nullopt;
  return db::exercise_json(e, db::ExerciseNames::stored).dump();
}

StartPose start_pose(const Exercise& e) {
  const contract::PathPose pose = figure_of(e).pose(0.0);
  return {pose.x_m, pose.y_m, pose.psi_rad};
}

Exercise exercise_of_scenario(std::string_view scenario) {
  for (const contract::ExerciseInfo& row : contract::kExercises)
    if (row.shape != Exercise::Shape::own && scenario.find(row.name) != std::string_view::npos) return contract::usual_exercise(row.shape);
  return {};
}

}  // namespace hoist::server
