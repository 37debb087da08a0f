#include "server/state/walk.hpp"

#include <cmath>

#include "control/contract/faults.hpp"

namespace hoist::server {

using contract::TickRecord;
using nlohmann::json;

namespace {
bool moves(const TickRecord& record) { return record.mode < contract::kModes.size() && contract::kModes[record.mode].moving; }

// Tenths of a millimetre are finer than any screen, and short as text.
json rounded(const std::vector<double>& values) {
  json out = json::array();
  for (const double value : values) out.push_back(std::round(value * 1e4) * 1e-4);
  return out;
}

void halve(std::vector<double>& values) {
  for (std::size_t i = 0; 2 * i < values.size(); ++i) values[i] = values[2 * i];
  values.resize((values.size() + 1) / 2);
}
}  // namespace

void PathTrace::clear() {
  step_m_ = kFirstStep_m;
  x_m_.clear();
  y_m_.clear();
}

void PathTrace::add(double x_m, double y_m) {
  if (!x_m_.empty() && std::hypot(x_m - x_m_.back(), y_m - y_m_.back()) < step_m_) return;
  x_m_.reserve(kPointsMost);
  y_m_.reserve(kPointsMost);
  x_m_.push_back(x_m);
  y_m_.push_back(y_m);
  if (x_m_.size() < kPointsMost) return;
  halve(x_m_);
  halve(y_m_);
  step_m_ *= 2;
}

Walk::Change Walk::take(const TickRecord& record) {
  // The core counts its marks. Of a mark set before this server came, the place is known only while nothing has moved since.
  const bool marks = last_ ? record.start_mark != last_->start_mark : record.distance_m == 0;
  if (last_ && moves(*last_) && moves(record)) motion_ns_ += record.time_ns - last_->time_ns;
  last_ = record;
  if (marks) mark_start();
  path_.add(static_cast<double>(record.fused_x_m), static_cast<double>(record.fused_y_m));
  return {marks, task_.take(record)};
}

void Walk::mark_start() {
  if (!last_) return;
  const auto x_m = static_cast<double>(last_->fused_x_m);
  const auto y_m = static_cast<double>(last_->fused_y_m);
  mark_ = Mark{x_m, y_m, static_cast<double>(last_->fused_psi_rad)};
  motion_ns_ = 0;
  path_.clear();
  path_.add(x_m, y_m);
}

void Walk::change_patient() {
  begun_ = nullptr;
  anew_ = true;
  mark_start();
  task_.choose(task_.choice());
}

void Walk::forget() {
  begun_ = nullptr;
  last_.reset();
  mark_.reset();
  motion_ns_ = 0;
  path_.clear();
  task_.forget();
}

json Walk::told() const {
  json out{{"exercise", exercise_json(chosen_)},
           {"begun", begun_},
           {"task", task_.told()},
           {"tick", last_ ? json(last_->tick) : json(nullptr)},
           {"motion_s", mark_ ? json(static_cast<double>(motion_ns_) * 1e-9) : json(nullptr)},
           {"mark", nullptr},
           {"step_m", path_.step_m()},
           {"x_m", rounded(path_.x_m())},
           {"y_m", rounded(path_.y_m())}};
  if (mark_) out["mark"] = {{"x_m", mark_->x_m}, {"y_m", mark_->y_m}, {"psi_rad", mark_->psi_rad}};
  return out;
}

}  // namespace hoist::server
