#include "server/state/parameter_history.hpp"

#include <algorithm>
#include <iterator>

#include "control/contract/params.hpp"

namespace hoist::server {

void ParameterHistory::expect(std::uint32_t request_id, ChangeOrigin origin) {
  if (request_id == 0) return;
  expected_.emplace_back(request_id, std::move(origin));
  if (expected_.size() > kExpectedMost) expected_.pop_front();
}

void ParameterHistory::on_parameters(const contract::ParamsInForce& parameters) {
  // Later changes are events. What changed while no server listened is found once per core.
  if (core_.link().life() == life_) return;
  life_ = core_.link().life();
  compare(parameters);
}

void ParameterHistory::compare_file() {
  // Before the first parameters of a core there is nothing to compare.
  if (life_ != 0) compare(core_.parameters());
}

void ParameterHistory::compare(const contract::ParamsInForce& parameters) {
  ++comparison_;
  in_force_.clear();
  for (std::size_t i = 0; i < contract::kParamCount; ++i)
    in_force_.push_back({.utc_ns = utc_ns_(),
                         .core_start_time_ns = life_,
                         .time_ns = core_.newest() ? core_.newest()->time_ns : life_,
                         .parameter = contract::kParams[i].id,
                         .name = std::string{contract::kParams[i].name},
                         .value = parameters.values[i],
                         .reason = {}});
}

void ParameterHistory::on_event(const contract::Event& event) {
  if (event.kind != contract::EventKind::parameter_changed || event.value == event.before) return;
  const auto index = contract::find_param_id(event.item);
  if (!index) return;
  const auto expected = std::ranges::find(expected_, event.request_id, &std::pair<std::uint32_t, ChangeOrigin>::first);
  // Without a request the core has ended a trial.
  const ChangeOrigin origin = expected != expected_.end() ? expected->second : ChangeOrigin{event.request_id == 0 ? "trial_over" : "set"};
  waiting_.push_back({.utc_ns = utc_ns_(),
                      .core_start_time_ns = core_.link().life(),
                      .time_ns = event.time_ns,
                      .parameter = event.item,
                      .name = std::string{contract::kParams[*index].name},
                      .value = event.value,
                      .before = event.before,
                      .reason = std::string{origin.reason},
                      .source = origin.source,
                      .actor = event.client != 0 ? actors_.find(event.client) : std::nullopt});
  if (waiting_.size() > kWaitingMost) waiting_.pop_front();
  // What is still to be compared is what is in force after the changes that are written before it.
  for (db::ParameterChange& row : in_force_)
    if (row.parameter == event.item) row.value = event.value;
}

void ParameterHistory::poll(std::uint64_t now_ns) {
  if (writing_ || now_ns < retry_ns_ || (waiting_.empty() && in_force_.empty())) return;
  std::vector<db::ParameterChange> changes(waiting_.begin(), waiting_.end());
  const auto work = [changes, in_force = in_force_](Records& records) {
    db::Database* database = records.late() ? nullptr : records.database();
    if (database == nullptr) return Written::nothing;
    db::ParameterLog log(*database);
    if (!changes.empty() && !log.append(changes)) return Written::nothing;
    return in_force.empty() || log.catch_up(in_force) ? Written::all : Written::changes;
  };
  const auto then = [this, count = changes.size(), comparison = comparison_, now_ns](Written written) {
    writing_ = false;
    // Meanwhile the oldest may have gone for newer ones: what is left of these goes now.
    if (written != Written::nothing)
      waiting_.erase(waiting_.begin(), std::next(waiting_.begin(), static_cast<std::ptrdiff_t>(std::min(count, waiting_.size()))));
    if (written == Written::all && comparison == comparison_) in_force_.clear();
    if (written != Written::all) retry_ns_ = now_ns + kRetry_ns;
  };
  writing_ = records_.ask<Written>(work, then);
  if (!writing_) retry_ns_ = now_ns + kRetry_ns;
}

}  // namespace hoist::server
