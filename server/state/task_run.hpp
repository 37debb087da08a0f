// The chosen task, the same on all screens: which repetition is walked, whether its end is reached, and since when the patient rests.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "control/contract/reference_path.hpp"
#include "control/contract/signals.hpp"
#include "db/store/tasks.hpp"

namespace hoist::server {

class TaskRun {
 public:
  // Nothing: no task, only an exercise. The repetitions begin anew.
  void choose(std::optional<db::TaskChoice> choice);
  // Another core: its start marks and steps are others.
  void forget();
  [[nodiscard]] const std::optional<db::TaskChoice>& choice() const { return choice_; }

  // What a motion on this exercise would be recorded as, were it to begin now; nothing when it is not the task's. A new start mark begins the
  // next repetition, the same one goes on with the last, as does a repetition in which nothing has moved. `again`: the start mark will be a new one;
  // its step may come later than this question.
  [[nodiscard]] std::optional<db::TaskRecord> next(const contract::Exercise& exercise, contract::Mode mode, bool again = false) const;
  // Whether the latest repetition has reached its end: a start on its line begins the next one, at its start.
  [[nodiscard]] bool over() const { return reached_; }
  // That motion has begun. Nothing: another motion, which is no repetition.
  void begin(const std::optional<db::TaskRecord>& record);

  struct Change {
    bool told = false;     // told() is another
    bool reached = false;  // the end of the task, in this step, in a mode that goes on until it is asked to end
  };
  // Every step of the core, in order.
  Change take(const contract::TickRecord& record);

  // TaskState of the contract; null without a task.
  [[nodiscard]] nlohmann::json told() const;

 private:
  [[nodiscard]] bool at_end(const contract::TickRecord& record);

  std::optional<db::TaskChoice> choice_;
  std::uint32_t repetition_ = 0;                      // begun so far
  std::optional<std::uint32_t> mark_, counted_mark_;  // of the newest step; of the latest motion of the task
  bool of_task_ = false;                              // the motion under way, or the latest one
  bool moving_ = false, reached_ = false;
  contract::ReferencePath path_ = contract::ReferencePath::straight(0.0);
  double s_m_ = 0, turned_rad_ = 0, from_x_m_ = 0, from_y_m_ = 0;
  bool far_ = false;  // away from the start by the goal of a task that ends by coming back
  std::optional<double> psi_rad_;
  std::optional<std::uint64_t> begun_tick_, ended_tick_;
};

}  // namespace hoist::server
