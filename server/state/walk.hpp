// What is walked, as every screen is to draw it: the exercise, and from the core's records the start mark, the time in motion and the path.
#pragma once
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "control/contract/signals.hpp"
#include "server/state/exercise.hpp"
#include "server/state/task_run.hpp"

namespace hoist::server {

// A path of bounded size: a point each `step_m`; when it is full, every second point goes and the step doubles. The console goes on with the
// same rule (web/src/link/trace.ts).
class PathTrace {
 public:
  static constexpr std::size_t kPointsMost = 2048;
  static constexpr double kFirstStep_m = 0.02;

  void clear();
  void add(double x_m, double y_m);
  [[nodiscard]] double step_m() const { return step_m_; }
  [[nodiscard]] const std::vector<double>& x_m() const { return x_m_; }
  [[nodiscard]] const std::vector<double>& y_m() const { return y_m_; }

 private:
  double step_m_ = kFirstStep_m;
  std::vector<double> x_m_, y_m_;
};

class Walk {
 public:
  explicit Walk(Exercise chosen) : chosen_(chosen) {}

  // What a step has changed: a new start mark, where path and time start; the task.
  struct Change {
    bool marked = false;
    TaskRun::Change task = {};
  };
  // Every step of the core, in order.
  Change take(const contract::TickRecord& record);
  // Another core: only the chosen exercise is left.
  void forget();
  // The next start begins at its start mark, also where it would go on.
  void start_anew() { anew_ = true; }
  // At standstill: nothing walked so far, and no repetition of the task, is of the patient who walks next.
  void change_patient();
  // Another exercise ends the task, where one is chosen.
  void choose(const Exercise& exercise) {
    chosen_ = exercise;
    task_.choose(std::nullopt);
  }
  // The task and its line.
  void choose(const db::TaskChoice& choice) {
    chosen_ = choice.exercise;
    task_.choose(choice);
  }
  [[nodiscard]] const Exercise& chosen() const { return chosen_; }
  [[nodiscard]] bool starts_anew() const { return anew_; }
  [[nodiscard]] const TaskRun& task() const { return task_; }
  // A motion has begun with this exercise; `told` as in the request, for GUIDED with speed and laps. `task`: as it is recorded, too.
  void begin(nlohmann::json told, const std::optional<db::TaskRecord>& task) {
    begun_ = std::move(told);
    anew_ = false;
    task_.begin(task);
  }

  // The message `walk` without its type, the same for GET /api/v1/walk.
  [[nodiscard]] nlohmann::json told() const;

 private:
  void mark_start();

  struct Mark {
    double x_m = 0, y_m = 0, psi_rad = 0;
  };
  Exercise chosen_;
  nlohmann::json begun_;  // null: not known to this server
  std::optional<contract::TickRecord> last_;
  std::optional<Mark> mark_;  // nothing: set before this server came
  std::uint64_t motion_ns_ = 0;
  bool anew_ = false;
  PathTrace path_;
  TaskRun task_;
};

}  // namespace hoist::server
