#include "db/store/exercise_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "db/store/session_types.hpp"
#include "db/store/task_record.hpp"

namespace hoist::db {

using contract::Exercise;
using contract::ExerciseShape;
using contract::ExerciseSize;
using nlohmann::json;

namespace {
std::string name_of(const ExerciseSize& row, ExerciseNames names) {
  return std::string(names == ExerciseNames::told ? row.name : row.stored);
}

// "eight, square or straight".
std::string shapes_in_words(ExerciseNames names) {
  std::vector<std::string_view> words;
  for (const contract::ExerciseInfo& row : contract::kExercises)
    if (names == ExerciseNames::told || row.shape != ExerciseShape::free) words.push_back(row.name);
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) text.append(i == 0 ? "" : i + 1 == words.size() ? " or " : ", ").append(words[i]);
  return text;
}

std::string numbered(const char* name, std::size_t i) { return std::string(name) + '.' + std::to_string(i); }
/// Points on their grid are never nearer by rounding alone.
constexpr double kWithin_m = 1e-9;

// Reads the members that belong to the shape, and counts them.
class Reader {
 public:
  Reader(const json& value, ExerciseNames names, std::vector<ExerciseProblem>& problems)
      : value_(value), names_(names), problems_(problems) {}

  std::optional<Exercise> read() {
    const auto shape = value_.is_object() ? value_.find("shape") : value_.end();
    const contract::ExerciseInfo* info = value_.is_object() && shape != value_.end() && shape->is_string()
                                             ? contract::find_exercise(shape->get_ref<const std::string&>())
                                             : nullptr;
    // Free walking is stored only as what a task asks for.
    const bool stored = names_ == ExerciseNames::stored;
    if (info == nullptr || (info->shape == ExerciseShape::free && stored && !value_.contains("task"))) {
      problems_.push_back({"shape", "must be " + shapes_in_words(names_)});
      return std::nullopt;
    }
    const std::size_t before = problems_.size();
    Exercise exercise{{info->shape, false, 0, 0}, {}};
    for (const ExerciseSize& row : contract::kExerciseSizes)
      if (row.shape == info->shape) contract::size_of(exercise, row.role) = size(row);
    if (info->turned) exercise.clockwise = clockwise();
    if (info->shape == ExerciseShape::own) read_line(exercise.line);
    for (const auto& [name, member] : value_.items())
      if (name == "task" && stored) {
        if (!read_task_record(member)) problems_.push_back({"task", "is not one"});
      } else if (!known(name, *info)) {
        problems_.push_back({name, "is not known here"});
      }
    if (problems_.size() == before) check_share(exercise);
    return problems_.size() == before ? std::optional{exercise} : std::nullopt;
  }

 private:
  bool known(const std::string& name, const contract::ExerciseInfo& info) const {
    if (name == "shape" || (name == "clockwise" && info.turned)) return true;
    if (info.shape == ExerciseShape::own && (name == "closed" || name == "x_m" || name == "y_m")) return true;
    for (const ExerciseSize& row : contract::kExerciseSizes)
      if (row.shape == info.shape && name == name_of(row, names_)) return true;
    return false;
  }
  double size(const ExerciseSize& row) {
    const std::string name = name_of(row, names_);
    const auto at = value_.find(name);
    const bool told = names_ == ExerciseNames::told;
    if (!row.required && (at == value_.end() || (told && (at->is_null() || *at == 0)))) return 0;
    if (at == value_.end() || !at->is_number()) {
      problems_.push_back({name, "must be a number", std::nullopt, contract::kExerciseLeast_m, contract::kExerciseMost_m});
      return 0;
    }
    const auto given = at->get<double>();
    // Written so that a NaN fails.
    if (!(given >= contract::kExerciseLeast_m && given <= contract::kExerciseMost_m))
      problems_.push_back({name, "is outside its range", given, contract::kExerciseLeast_m, contract::kExerciseMost_m});
    return given;
  }
  bool clockwise() {
    const auto at = value_.find("clockwise");
    if (at == value_.end() || (names_ == ExerciseNames::told && at->is_null())) return false;
    if (!at->is_boolean()) problems_.push_back({"clockwise", "must be true or false"});
    return at->is_boolean() && at->get<bool>();
  }
  void read_line(contract::OwnLine& line) {
    const auto closed = value_.find("closed");
    if (closed == value_.end() || !closed->is_boolean()) problems_.push_back({"closed", "must be true or false"});
    line.closed = closed != value_.end() && *closed == true;
    const std::size_t least = contract::own_points_least(line.closed);
    for (const char* name : {"x_m", "y_m"}) {
      const auto at = value_.find(name);
      const std::size_t given = at != value_.end() && at->is_array() ? at->size() : 0;
      if (given < least || given > contract::kOwnPointsMost || (line.count != 0 && given != line.count)) {
        problems_.push_back({name, line.count != 0 ? "must have as many numbers as x_m" : "must be a list of so many numbers",
                             static_cast<double>(given), static_cast<double>(line.count != 0 ? line.count : least),
                             static_cast<double>(line.count != 0 ? line.count : contract::kOwnPointsMost)});
        return;
      }
      line.count = given;
      for (std::size_t i = 0; i < given; ++i) (*name == 'x' ? line.points[i].x_m : line.points[i].y_m) = coordinate(*at, name, i);
    }
    for (std::size_t i = 0; i < (line.closed ? line.count : line.count - 1); ++i)
      if (const double edge_m = own_edge_m(line, i); edge_m < contract::kOwnEdgeLeast_m - kWithin_m)
        problems_.push_back({numbered("x_m", (i + 1) % line.count), "is a point too near to the one before it; value and min are metres",
                             edge_m, contract::kOwnEdgeLeast_m, std::nullopt});
  }
  double coordinate(const json& values, const char* name, std::size_t i) {
    const double given_m = values[i].is_number() ? values[i].get<double>() : std::nan("");
    // Written so that a NaN fails.
    if (!(std::fabs(given_m) <= contract::kOwnReach_m)) {
      problems_.push_back({numbered(name, i), values[i].is_number() ? "is outside its range" : "must be a number",
                           std::isfinite(given_m) ? std::optional{given_m} : std::nullopt, -contract::kOwnReach_m, contract::kOwnReach_m});
      return 0;
    }
    return contract::on_own_grid(given_m);
  }
  void check_share(const Exercise& exercise) {
    const ExerciseSize* radius = contract::find_size(exercise.shape, contract::ExerciseRole::radius);
    const ExerciseSize* size = contract::find_size(exercise.shape, contract::ExerciseRole::size);
    if (radius == nullptr || size == nullptr || radius->share == 0 || exercise.radius_m <= radius->share * exercise.size_m) return;
    const std::string whole = name_of(*size, names_);
    problems_.push_back({name_of(*radius, names_), "must not exceed " + (radius->share == 1 ? whole : "half of " + whole),
                         exercise.radius_m, radius->required ? contract::kExerciseLeast_m : 0.0, radius->share * exercise.size_m});
  }

  const json& value_;
  ExerciseNames names_;
  std::vector<ExerciseProblem>& problems_;
};

static_assert(contract::all_rows(contract::kExerciseSizes,
                                 [](const ExerciseSize& s) { return s.share == 0 || s.share == 0.5 || s.share == 1; }),
              "the sentence of a refusal knows the whole and the half");
}  // namespace

std::optional<Exercise> read_exercise(const json& value, ExerciseNames names, std::vector<ExerciseProblem>& problems) {
  return Reader(value, names, problems).read();
}

json exercise_json(const Exercise& exercise, ExerciseNames names) {
  const contract::ExerciseInfo* info = contract::find_exercise(exercise.shape);
  json out{{"shape", info == nullptr ? "free" : info->name}};
  for (const ExerciseSize& row : contract::kExerciseSizes)
    if (const double size_m = contract::size_of(exercise, row.role); row.shape == exercise.shape && (row.required || size_m > 0))
      out[name_of(row, names)] = size_m;
  if (info != nullptr && info->turned && exercise.clockwise) out["clockwise"] = true;
  if (exercise.shape == ExerciseShape::own) {
    out["closed"] = exercise.line.closed;
    out["x_m"] = out["y_m"] = json::array();
    for (std::size_t i = 0; i < exercise.line.count; ++i) {
      out["x_m"].push_back(exercise.line.points[i].x_m);
      out["y_m"].push_back(exercise.line.points[i].y_m);
    }
  }
  return out;
}

Status check_exercise(std::string_view stored) {
  const auto bad = [](std::string message) { return Error{ErrorKind::bad_value, std::move(message), "exercise"}; };
  if (stored.size() > kMaxExercise_bytes) return bad("exercise must be at most 1000 bytes");
  const json value = json::parse(stored, nullptr, false);
  if (!value.is_object()) return bad("exercise must be a JSON object");
  std::vector<ExerciseProblem> problems;
  if (read_exercise(value, ExerciseNames::stored, problems)) return {};
  const ExerciseProblem& first = problems.front();
  return bad("exercise." + first.field + ' ' + first.message);
}

contract::ReferencePath figure_of_stored(std::string_view stored) {
  std::vector<ExerciseProblem> problems;
  return contract::figure_of(read_exercise(json::parse(stored, nullptr, false), ExerciseNames::stored, problems).value_or(Exercise{}));
}

json exercise_as_told(const std::optional<std::string>& stored) {
  if (!stored) return nullptr;
  json exercise = json::parse(*stored, nullptr, false);
  if (!exercise.is_object()) return nullptr;
  exercise.erase("task");
  for (const ExerciseSize& row : contract::kExerciseSizes) {
    if (row.stored == row.name) continue;
    if (const auto at = exercise.find(row.stored); at != exercise.end()) {
      exercise[std::string(row.name)] = *at;
      exercise.erase(std::string(row.stored));
    }
  }
  return exercise;
}

}  // namespace hoist::db
