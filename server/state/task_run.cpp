#include "server/state/task_run.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "control/contract/faults.hpp"

namespace hoist::server {

using contract::Exercise;
using contract::Mode;
using contract::TickRecord;
using db::TaskEnd;
using nlohmann::json;

namespace {
constexpr double kStep_s = 0.01;

// A client that keeps a proportion itself may round it.
constexpr double kSame_m = 1e-6;
bool same(const Exercise& a, const Exercise& b) {
  return a.shape == b.shape && a.clockwise == b.clockwise && std::fabs(a.size_m - b.size_m) < kSame_m &&
         std::fabs(a.radius_m - b.radius_m) < kSame_m && a.line == b.line;
}
json or_null(const std::optional<std::uint64_t>& value) { return value ? json(*value) : json(nullptr); }
}  // namespace

void TaskRun::choose(std::optional<db::TaskChoice> choice) {
  const auto mark = mark_;
  *this = TaskRun{};
  mark_ = mark;
  choice_ = choice;
}

void TaskRun::forget() {
  const auto choice = choice_;
  *this = TaskRun{};
  choice_ = choice;
}

std::optional<db::TaskRecord> TaskRun::next(const Exercise& exercise, Mode mode, bool again) const {
  if (!choice_ || !same(exercise, choice_->exercise) || std::ranges::count(choice_->task->leads, mode) == 0) return std::nullopt;
  const bool not_begun = !begun_tick_;
  const bool goes_on = repetition_ > 0 && (not_begun || (!again && mark_ && mark_ == counted_mark_));
  return db::task_record(*choice_, goes_on ? repetition_ : repetition_ + 1);
}

void TaskRun::begin(const std::optional<db::TaskRecord>& record) {
  of_task_ = record.has_value();
  ended_tick_.reset();
  if (!record || record->repetition == repetition_) return;
  repetition_ = record->repetition;
  reached_ = false;
  begun_tick_.reset();
  psi_rad_.reset();
  turned_rad_ = s_m_ = 0;
  far_ = false;
  path_ = contract::figure_of(choice_->exercise);
}

bool TaskRun::at_end(const TickRecord& record) {
  switch (choice_->task->ends) {
    case TaskEnd::distance:
      s_m_ = path_.project(static_cast<double>(record.fused_x_m), static_cast<double>(record.fused_y_m), s_m_);
      return s_m_ >= choice_->goal * path_.length_m() - db::kTaskArrived_m;
    case TaskEnd::time:
      return static_cast<double>(record.tick - *begun_tick_) * kStep_s >= choice_->goal;
    case TaskEnd::turn: {
      const auto psi_rad = static_cast<double>(record.fused_psi_rad);
      if (psi_rad_) turned_rad_ += std::remainder(psi_rad - *psi_rad_, 2.0 * std::numbers::pi);
      psi_rad_ = psi_rad;
      return std::fabs(turned_rad_) >= choice_->goal;
    }
    case TaskEnd::back: {
      const double away_m =
          std::hypot(static_cast<double>(record.fused_x_m) - from_x_m_, static_cast<double>(record.fused_y_m) - from_y_m_);
      far_ = far_ || away_m >= choice_->goal;
      return far_ && away_m <= db::kTaskBack_m;
    }
    case TaskEnd::hand:
      break;
  }
  return false;
}

TaskRun::Change TaskRun::take(const TickRecord& record) {
  mark_ = record.start_mark;
  const bool moving = record.mode < contract::kModes.size() && contract::kModes[record.mode].moving;
  Change change;
  if (choice_ && of_task_ && repetition_ > 0) {
    if (moving) counted_mark_ = mark_;
    if (moving && !begun_tick_ && record.standing_still == 0) {
      begun_tick_ = record.tick;
      from_x_m_ = static_cast<double>(record.fused_x_m);
      from_y_m_ = static_cast<double>(record.fused_y_m);
      change.told = true;
    }
    if (moving && begun_tick_ && !reached_ && at_end(record)) {
      reached_ = change.told = true;
      // At the end of its line GUIDED ends by itself.
      change.reached = record.mode != static_cast<std::uint8_t>(Mode::guided) || choice_->task->ends != TaskEnd::distance;
    }
    if (moving_ && !moving) {
      ended_tick_ = record.tick;
      if (choice_->task->ends == TaskEnd::hand && begun_tick_) reached_ = true;
      change.told = true;
    }
  }
  moving_ = moving;
  return change;
}

json TaskRun::told() const {
  if (!choice_) return nullptr;
  const db::TaskInfo& task = *choice_->task;
  return {{"task", task.name},
          {"version", task.version},
          {"ends", db::task_end_name(task.ends)},
          {"goal", choice_->goal},
          {"repetitions", choice_->repetitions},
          {"rest_s", choice_->rest_s},
          {"repetition", repetition_},
          {"begun_tick", or_null(begun_tick_)},
          {"reached", reached_},
          {"ended_tick", or_null(ended_tick_)},
          {"line", choice_->line.empty() ? json(nullptr) : json(choice_->line)}};
}

}  // namespace hoist::server
