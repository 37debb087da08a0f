#include "control/core/serve/param_keeper.hpp"

#include <cmath>
#include <cstring>

#include "control/core/events.hpp"
#include "control/core/modes/mode_list.hpp"
#include "control/core/state.hpp"
#include "control/core/supervise/supervisor.hpp"

namespace hoist::core {

using contract::Event;
using contract::EventKind;
using contract::InEffect;
using contract::Params;

namespace {

constexpr auto kGains = [] {
  constexpr std::size_t kCount = [] {
    std::size_t count = 0;
    for (std::size_t i = 0; i < contract::kParamCount; ++i) count += is_gain(i) ? 1U : 0U;
    return count;
  }();
  std::array<std::size_t, kCount> gains{};
  for (std::size_t i = 0, at = 0; i < contract::kParamCount; ++i)
    if (is_gain(i)) gains[at++] = i;
  return gains;
}();
// Drives learn of a gain on its way this often: 2 % a step, and a bus that has room for the rest.
constexpr std::uint64_t kToNodesTicks = 10;

void tell(CoreState& state, EventKind kind, const Asked& asked, std::uint32_t code, double value) noexcept {
  Event event;
  event.kind = kind;
  event.request_id = asked.request_id;
  event.client = asked.client;
  event.code = code;
  event.value = value;
  emit(state, event);
}

[[nodiscard]] Event event_of_row(EventKind kind, std::size_t index, double value, double before) noexcept {
  Event event;
  event.kind = kind;
  event.item = contract::kParams[index].id;
  event.value = value;
  event.before = before;
  return event;
}

void seal(CoreState& state) noexcept {
  state.seal.copy = state.params;
  state.seal.derived = state.derived;
  state.seal.crc = params_crc(state.params);
}

void derive_again(CoreState& state) noexcept {
  const Derived next = derive(state.params);
  if (!next.reads_posture_as(state.derived)) state.intent.restart();
  state.derived = next;
}

[[nodiscard]] double slewed(double from, double to, std::size_t index, double dt_s) noexcept {
  const contract::ParamInfo& info = contract::kParams[index];
  const double size = std::fmax(std::fabs(from), kSlewFloor * (info.max - info.min));
  const double step = kSlew_per_s * dt_s * size;
  return to > from + step ? from + step : (to < from - step ? from - step : to);
}

void move_gains(CoreState& state, double dt_s) noexcept {
  if (!state.slewing) return;
  const bool driven = mode_row_of(state.mode).drives;
  bool moving = false;
  for (const std::size_t gain : kGains) {
    const double target = contract::get_param(state.params, gain);
    const double from = contract::get_param(state.live, gain);
    const double to = driven ? slewed(from, target, gain, dt_s) : target;
    contract::set_param_unchecked(state.live, gain, to);
    moving = moving || to != target;
    if (from != target && to == target) emit(state, event_of_row(EventKind::parameter_settled, gain, to, from));
  }
  state.slewing = moving;
  if (!moving || state.ticks_run % kToNodesTicks == 0) {
    state.master.params_changed(state.sent_to_nodes, state.live);
    state.sent_to_nodes = state.live;
  }
}

// Writes rows into what is in force; the caller says what that means for a trial.
void write_rows(CoreState& state, const Staging& set, const Asked& asked) noexcept {
  const Params before = state.params;
  // Where nothing is driven there is nothing to jolt: a gain is there at once, too.
  const bool driven = mode_row_of(state.mode).drives;
  const auto waits = [&](const Staging::Row& row) {
    return driven && is_gain(row.index) && contract::get_param(state.live, row.index) != row.value;
  };
  for (const Staging::Row& row : set.rows) {
    contract::set_param_unchecked(state.params, row.index, row.value);
    if (!waits(row)) contract::set_param_unchecked(state.live, row.index, row.value);
  }
  derive_again(state);
  seal(state);
  state.slewing = true;
  ++state.parameter_version;
  state.params_changed = true;
  for (const Staging::Row& row : set.rows) {
    Event event = event_of_row(EventKind::parameter_changed, row.index, row.value, contract::get_param(before, row.index));
    event.request_id = asked.request_id;
    event.client = asked.client;
    event.code = static_cast<std::uint32_t>(waits(row) ? InEffect::gradually : InEffect::at_once);
    emit(state, event);
  }
  // The nodes are told in this step.
  move_gains(state, 0);
}

// Which of the two copies is the one that was sealed; null when neither is.
[[nodiscard]] const Params* whole_copy(const CoreState& state) noexcept {
  if (params_crc(state.seal.copy) == state.seal.crc) return &state.seal.copy;
  if (params_crc(state.params) == state.seal.crc) return &state.params;
  return nullptr;
}

[[nodiscard]] bool same_bits(const Params& a, const Params& b) noexcept {
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): bits, not values, are what damaged memory changes
  return std::memcmp(&a, &b, sizeof(Params)) == 0;
}

// Everything a step uses for its decisions: the table, the gains as the laws see them (on their way they have no copy),
// and what follows from the table.
[[nodiscard]] bool damaged(const CoreState& state) noexcept {
  return !same_bits(state.params, state.seal.copy) || (!state.slewing && !same_bits(state.live, state.params)) ||
         state.derived != state.seal.derived;
}

// Puts the rows on trial back to what was there before. That memory has no copy, so it is looked at when it is used: false when a value is
// none of its row or the rows do not fit together, which a commit had made sure of; such rows stay as they are.
[[nodiscard]] bool take_back(const Trial& trial, Params& params) noexcept {
  bool whole = true;
  Params back = params;
  for (std::size_t i = 0; i < contract::kParamCount; ++i) {
    if (!trial.on_trial[i]) continue;
    const double value = contract::get_param(trial.before, i);
    if (contract::check_param(i, value) == contract::ParamCheck::ok) {
      contract::set_param_unchecked(back, i, value);
    } else {
      whole = false;
    }
  }
  if (contract::check_param_set(back) != nullptr) return false;
  params = back;
  return whole;
}

void look_for_damage(CoreState& state) noexcept {
  if (!damaged(state)) return;
  if (!watches(contract::Fault::parameters_corrupt)) return;
  const Params* whole = whole_copy(state);
  Params good = whole != nullptr ? *whole : Params{};
  // Both copies hold values on trial; damage must not make them permanent.
  const bool tried = state.trial.left_s > 0;
  if (tried && whole != nullptr) static_cast<void>(take_back(state.trial, good));
  const Params told = state.sent_to_nodes;
  install_params(state, good);
  if (whole == nullptr) state.defaults_after_damage = true;
  state.master.params_changed(told, state.live);
  ++state.parameter_version;
  state.params_changed = true;
  state.trial = {};
  if (tried) tell(state, EventKind::parameters_reverted, {}, static_cast<std::uint32_t>(state.parameter_version), 0);
  raise_fault(state, contract::Fault::parameters_corrupt);
}

}  // namespace

double kept_param(const CoreState& state, std::size_t index) noexcept {
  const bool tried = state.trial.left_s > 0 && state.trial.on_trial[index];
  return contract::get_param(tried ? state.trial.before : state.params, index);
}

void install_params(CoreState& state, const Params& params) noexcept {
  state.params = params;
  state.live = params;
  state.sent_to_nodes = params;
  derive_again(state);
  state.slewing = false;
  seal(state);
}

void put_into_force(CoreState& state, const Staging& set, const Asked& asked, double trial_s) noexcept {
  Trial& trial = state.trial;
  if (trial_s > 0) {
    // A second trial on top of a first: the values before both come back.
    if (trial.left_s <= 0) trial.before = state.params;
    for (const Staging::Row& row : set.rows) trial.on_trial[row.index] = true;
    trial.left_s = trial_s;
  } else {
    // Not a trial: an earlier trial of these rows is over, because the client had seen the values in force.
    state.defaults_after_damage = false;
    for (const Staging::Row& row : set.rows) {
      contract::set_param_unchecked(trial.before, row.index, row.value);
      trial.on_trial[row.index] = false;
    }
  }
  write_rows(state, set, asked);
  if (trial_s > 0) {
    tell(state, EventKind::parameters_on_trial, asked, static_cast<std::uint32_t>(state.parameter_version), trial_s);
  } else if (trial.left_s > 0) {
    bool any = false;
    for (const bool row : trial.on_trial) any = any || row;
    if (!any) static_cast<void>(confirm_trial(state, asked));
  }
}

bool confirm_trial(CoreState& state, const Asked& asked) noexcept {
  if (state.trial.left_s <= 0) return false;
  state.trial = {};
  state.defaults_after_damage = false;
  state.params_changed = true;  // the same values, but from now on they are to be kept
  tell(state, EventKind::parameters_confirmed, asked, static_cast<std::uint32_t>(state.parameter_version), 0);
  return true;
}

bool revert_trial(CoreState& state, const Asked& asked) noexcept {
  if (state.trial.left_s <= 0) return false;
  Params before = state.params;
  const bool whole = take_back(state.trial, before);
  Staging back;
  for (std::size_t i = 0; i < contract::kParamCount; ++i)
    if (state.trial.on_trial[i]) static_cast<void>(back.rows.push_back({i, contract::get_param(before, i)}));
  state.trial = {};
  write_rows(state, back, asked);
  tell(state, EventKind::parameters_reverted, asked, static_cast<std::uint32_t>(state.parameter_version), 0);
  if (!whole) raise_fault(state, contract::Fault::parameters_corrupt);
  return true;
}

void serve_params(CoreState& state, double dt_s) noexcept {
  look_for_damage(state);
  if (state.trial.left_s > 0) {
    state.trial.left_s -= dt_s;
    if (state.trial.left_s <= dt_s / 2) {
      state.trial.left_s = dt_s;
      static_cast<void>(revert_trial(state, {}));
    }
  }
  move_gains(state, dt_s);
}

}  // namespace hoist::core
