#include "db/advice/preference.hpp"

#include <algorithm>
#include <cmath>

namespace hoist::db {

namespace {

// Goes through the search answer by answer.
class Search {
 public:
  explicit Search(const PreferenceSet& start) : start_(start) {
    state_.best = start;
    propose();
  }

  void answer(Preference preference) {
    if (state_.finished) return;
    ++state_.answered;
    if (preference == Preference::better) {
      state_.best = state_.next;
      liked_ = true;
      if (step(direction_)) return;
      advance();
    } else if (direction_ > 0 && !liked_) {
      direction_ = -1;
      if (!step(direction_)) advance();
    } else {
      advance();
    }
  }
  [[nodiscard]] const PreferenceState& state() const { return state_; }

 private:
  // The set one step further; false where a bound leaves no step.
  bool step(int direction) {
    const std::size_t k = state_.changed;
    const contract::ParamInfo& info = contract::kParams[contract::param_index(kPreferred[k])];
    const double reach = kPreferenceReach_norm * start_[k];
    const double least = std::max(info.min, start_[k] - reach), most = std::min(info.max, start_[k] + reach);
    const double wanted = state_.best[k] + direction * kPreferenceSteps_norm[round_] * start_[k];
    constexpr double kRounding = 1e-9;
    if (wanted < least - kRounding || wanted > most + kRounding) return false;
    state_.next = state_.best;
    state_.next[k] = std::clamp(wanted, least, most);
    return true;
  }
  // The first step of this setting, up or else down, or of the next setting that has one.
  void propose() {
    for (;;) {
      liked_ = false;
      for (direction_ = 1; direction_ >= -1; direction_ -= 2)
        if (step(direction_)) return;
      if (!turn_page()) return;
    }
  }
  void advance() {
    if (turn_page()) propose();
  }
  // The next setting, or the next round; false at the end.
  bool turn_page() {
    if (++state_.changed < kPreferred.size()) return true;
    state_.changed = 0;
    if (++round_ < kPreferenceSteps_norm.size()) return true;
    state_.finished = true;
    state_.next = state_.best;
    return false;
  }

  PreferenceSet start_;
  PreferenceState state_;
  std::size_t round_ = 0;
  int direction_ = 1;
  bool liked_ = false;
};

}  // namespace

PreferenceState preference_after(const PreferenceSet& start, std::span<const Preference> answers) {
  Search search(start);
  for (const Preference answer : answers) search.answer(answer);
  return search.state();
}

}  // namespace hoist::db
