// The search for preferred settings, one answer at a time.
#include <gtest/gtest.h>

#include <vector>

#include "db/advice/preference.hpp"

namespace hoist::db {
namespace {

constexpr PreferenceSet kStart{50, 10, 50, 2};

// Answers as a patient who likes the set nearest to this one.
std::vector<Preference> answers_for(const PreferenceSet& liked, PreferenceState& end) {
  const auto distance = [&liked](const PreferenceSet& set) {
    double sum = 0;
    for (std::size_t k = 0; k < set.size(); ++k) sum += std::pow((set[k] - liked[k]) / kStart[k], 2);
    return sum;
  };
  std::vector<Preference> answers;
  for (end = preference_after(kStart, answers); !end.finished; end = preference_after(kStart, answers)) {
    answers.push_back(distance(end.next) < distance(end.best) - 1e-12 ? Preference::better : Preference::worse);
    if (answers.size() > 100) break;
  }
  return answers;
}

TEST(Preference, EachProposalChangesOneSettingInsideTheBounds) {
  // Every sequence of five answers.
  for (int code = 0; code < 3 * 3 * 3 * 3 * 3; ++code) {
    std::vector<Preference> answers;
    for (int rest = code, n = 0; n < 5; ++n, rest /= 3) answers.push_back(static_cast<Preference>(rest % 3));
    const PreferenceState state = preference_after(kStart, answers);
    int different = 0;
    for (std::size_t k = 0; k < kStart.size(); ++k) {
      const contract::ParamInfo& info = contract::kParams[contract::param_index(kPreferred[k])];
      EXPECT_GE(state.next[k], std::max(info.min, (1 - kPreferenceReach_norm) * kStart[k]) - 1e-9);
      EXPECT_LE(state.next[k], std::min(info.max, (1 + kPreferenceReach_norm) * kStart[k]) + 1e-9);
      different += state.next[k] != state.best[k] ? 1 : 0;
    }
    EXPECT_EQ(different, 1);
    EXPECT_EQ(state.answered, 5U);
  }
}

TEST(Preference, ItComesNearToWhatIsLiked) {
  for (const PreferenceSet& liked : {PreferenceSet{60, 10, 50, 2}, PreferenceSet{50, 7, 62, 2}, PreferenceSet{35, 13.5, 40, 1.4}}) {
    PreferenceState end;
    const auto answers = answers_for(liked, end);
    EXPECT_TRUE(end.finished);
    EXPECT_LE(answers.size(), 30U);
    for (std::size_t k = 0; k < kStart.size(); ++k) EXPECT_NEAR(end.best[k], liked[k], 0.051 * kStart[k]) << k;
    EXPECT_EQ(end.next, end.best);
  }
}

TEST(Preference, SameKeepsTheSetAndAllTheSameEndsWhereItBegan) {
  const std::vector<Preference> answers(100, Preference::same);
  const PreferenceState end = preference_after(kStart, answers);
  EXPECT_TRUE(end.finished);
  EXPECT_EQ(end.best, kStart);
  EXPECT_EQ(end.answered, 16U) << "four settings, up and down, two steps";
}

TEST(Preference, AtTheEndOfARangeItGoesTheOtherWay) {
  const PreferenceSet most{100, 10, 50, 2};
  const PreferenceState first = preference_after(most, {});
  EXPECT_DOUBLE_EQ(first.next[0], 80);
}

// They are set while the patient walks, by a therapist.
TEST(Preference, ItsSettingsAreLiveAndOfTherapists) {
  for (const contract::ParamName param : kPreferred) {
    const contract::ParamInfo& info = contract::kParams[contract::param_index(param)];
    EXPECT_EQ(info.edit, contract::EditRule::live) << info.name;
    EXPECT_EQ(info.role, contract::Role::therapist) << info.name;
  }
}

}  // namespace
}  // namespace hoist::db
