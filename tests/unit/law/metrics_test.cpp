// The figures of a run.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>

#include "db/metrics/analysis.hpp"
#include "db/metrics/change.hpp"
#include "db/metrics/cross_correlation.hpp"
#include "db/metrics/evaluate.hpp"
#include "db/metrics/learning.hpp"
#include "db/metrics/median.hpp"
#include "db/metrics/metric_list.hpp"
#include "db/metrics/normalised_ise.hpp"
#include "db/metrics/paired_test.hpp"
#include "db/metrics/table_mean.hpp"
#include "tests/unit/law/golden.hpp"

namespace hoist::db {
namespace {

struct Track {
  double dt_s{};
  std::vector<double> x_m, y_m, psi_rad, dpsi_rad;
  [[nodiscard]] RunColumns columns() const { return {dt_s, x_m, y_m, psi_rad, dpsi_rad}; }
};

/// A walk along the eight at 0.3 m/s, a constant distance to the left of it.
Track beside_the_eight(double dt_s, double offset_m, double speed_m_s = 0.3) {
  const auto path = contract::ReferencePath::eight();
  Track track;
  track.dt_s = dt_s;
  for (double s_m = 0.0; s_m < path.length_m(); s_m += speed_m_s * dt_s) {
    const auto at = path.pose(s_m);
    track.x_m.push_back(at.x_m - offset_m * std::sin(at.psi_rad));
    track.y_m.push_back(at.y_m + offset_m * std::cos(at.psi_rad));
    track.psi_rad.push_back(at.psi_rad);
    track.dpsi_rad.push_back(0.2 * at.kappa_per_m);
  }
  return track;
}

Analysis analysis_of(const contract::ReferencePath& path, const Track& track) {
  Analyser analyser(path);
  do {
    for (std::size_t i = 0; i < track.x_m.size(); ++i)
      analyser.add({i, contract::Mode::user, false, track.x_m[i], track.y_m[i], track.psi_rad[i], track.dpsi_rad[i], 0.0, 0.3});
  } while (analyser.again());
  return analyser.result();
}

TEST(CrossCorrelation, IsBoundedSymmetricAndBlindToScale) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  for (int run = 0; run < 200; ++run) {
    std::vector<double> x(50);
    std::vector<double> y(50);
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = noise(random);
      y[i] = 0.5 * x[i] + noise(random);
    }
    const double c = cross_correlation(x, y).value();
    ASSERT_LE(std::fabs(c), 1.0);
    ASSERT_NEAR(cross_correlation(y, x).value(), c, 1e-14);
    ASSERT_NEAR(cross_correlation(x, x).value(), 1.0, 1e-14);
    auto scaled = x;
    for (auto& value : scaled) value *= -1e200;
    ASSERT_NEAR(cross_correlation(scaled, y).value(), -c, 1e-12);
    for (auto& value : scaled) value *= 1e-320;
    ASSERT_TRUE(std::isfinite(cross_correlation(scaled, y).value()));
  }
  EXPECT_FALSE(cross_correlation(std::vector{1.0}, std::vector{1.0, 2.0}).has_value());
}

TEST(NormalisedIse, IsASumOverSamplesOfTheWrappedError) {
  const std::vector<double> zero(4, 0.0);
  const std::vector<double> x_ref = {0.0, 1.0, 2.0, 3.0};
  const std::vector<double> x = {0.1, 1.1, 2.1, 3.1};
  const std::vector<double> turned(4, 2.0 * std::numbers::pi + 0.2);
  const auto ise = normalised_ise({x, zero, turned, x_ref, zero, zero});
  ASSERT_TRUE(ise.has_value());
  EXPECT_NEAR(ise->length_m, 3.0, 1e-15);
  EXPECT_NEAR(ise->j, 4.0 * (0.01 + 0.04) / 3.0, 1e-12);
  EXPECT_NEAR(normalised_ise({x, zero, turned, x_ref, zero, zero}, 6.0)->j, ise->j / 2.0, 1e-12);
  EXPECT_FALSE(normalised_ise({x, zero, zero, zero, zero, zero}).has_value()) << "a reference without length";
  EXPECT_FALSE(normalised_ise({x, zero, zero, x_ref, zero, std::vector<double>{}}).has_value());
  EXPECT_FALSE(normalised_ise({x, zero, zero, x_ref, zero, zero}, 0.0).has_value());
  const std::vector<double> bad = {0.0, std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
  EXPECT_FALSE(normalised_ise({bad, zero, zero, x_ref, zero, zero}).has_value());
}

TEST(WrapAngle, IsHalfOpen) {
  EXPECT_EQ(wrap_angle_rad(std::numbers::pi), std::numbers::pi);
  EXPECT_EQ(wrap_angle_rad(-std::numbers::pi), std::numbers::pi);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-100.0, 100.0);
  for (int i = 0; i < 10'000; ++i) {
    const double angle = any(random);
    const double wrapped = wrap_angle_rad(angle);
    ASSERT_GT(wrapped, -std::numbers::pi);
    ASSERT_LE(wrapped, std::numbers::pi);
    ASSERT_NEAR(std::sin(wrapped), std::sin(angle), 1e-12);
  }
}

TEST(Evaluate, KnowsAPerfectAndABentWalk) {
  const auto path = contract::ReferencePath::eight();
  const auto perfect = beside_the_eight(0.01, 0.0);
  const auto best = evaluate(path, perfect.columns());
  ASSERT_TRUE(best && best->c && best->ise);
  EXPECT_NEAR(*best->c, 1.0, 0.001) << "the pelvis turns as the path does";
  EXPECT_NEAR(best->ise->j, 0.0, 1e-9);
  EXPECT_NEAR(best->ise->length_m, path.length_m(), 0.01);
  const auto beside = beside_the_eight(0.01, 0.1);
  const auto worse = evaluate(path, beside.columns());
  const double samples = static_cast<double>(beside.x_m.size());
  EXPECT_NEAR(worse->ise->j, samples * 0.01 / path.length_m(), 0.01 * worse->ise->j);
  const Comparison compared = analysis_of(path, beside).comparison;
  ASSERT_EQ(compared.why, NoFigure::none);
  EXPECT_NEAR(compared.position_rms_m, 0.1, 1e-3);
  EXPECT_NEAR(compared.lateral_rms_m, 0.1, 1e-3);
  EXPECT_NEAR(compared.heading_rms_rad, 0.0, 1e-2);
  auto against = beside;
  for (auto& value : against.dpsi_rad) value = -value;
  EXPECT_LT(*evaluate(path, against.columns())->c, -0.9);
}

// D29: J_N is proportional to rate and slowness, so it is compared at 100 Hz only.
TEST(Evaluate, BringsEveryRecordingToTheTablesRate) {
  const auto path = contract::ReferencePath::eight();
  const double at_100 = evaluate_at_metric_rate(path, beside_the_eight(0.01, 0.1).columns())->ise->j;
  const double at_10 = evaluate_at_metric_rate(path, beside_the_eight(0.1, 0.1).columns())->ise->j;
  EXPECT_NEAR(at_10, at_100, 0.02 * at_100);
  EXPECT_NEAR(evaluate(path, beside_the_eight(0.1, 0.1).columns())->ise->j, at_100 / 10.0, 0.02 * at_100);
  EXPECT_NEAR(evaluate_at_metric_rate(path, beside_the_eight(0.01, 0.1, 0.15).columns())->ise->j, 2.0 * at_100, 0.04 * at_100);
}

TEST(Evaluate, RefusesWhatCannotBeJudged) {
  const auto path = contract::ReferencePath::eight();
  const auto good = beside_the_eight(0.01, 0.0);
  auto run = good;
  run.dt_s = 0.0;
  EXPECT_FALSE(evaluate(path, run.columns()).has_value());
  run = good;
  run.psi_rad.pop_back();
  EXPECT_FALSE(evaluate(path, run.columns()).has_value());
  run = good;
  run.dpsi_rad[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(evaluate(path, run.columns()).has_value());
  EXPECT_FALSE(evaluate(path, Track{0.01, {}, {}, {}, {}}.columns()).has_value());
  EXPECT_FALSE(evaluate(contract::ReferencePath::square(-1.0), good.columns()).has_value());
  run = good;
  run.dt_s = 1e9;
  EXPECT_FALSE(evaluate_at_metric_rate(path, run.columns()).has_value()) << "a wrong dt must not ask for all memory";
}

// Element n / 2 in rising order, whatever the numbers.
TEST(MedianSearch, IsTheOneOfTheSortedNumbers) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (const std::size_t count : {1U, 2U, 3U, 10U, 1001U, 5000U}) {
    std::vector<double> values(count);
    for (double& value : values) value = normal(random) * std::pow(10.0, normal(random) * 3);
    if (count > 9) values[0] = values[1] = 0.0, values[2] = -0.0, values[3] = 1e308, values[4] = -1e308;
    MedianSearch search;
    do
      for (const double value : values) search.add(value);
    while (search.again());
    std::ranges::sort(values);
    EXPECT_EQ(search.value(), values[count / 2]) << count;
    EXPECT_EQ(search.count(), count);
  }
  EXPECT_FALSE(MedianSearch().again());
}

TEST(TableMean, LeavesOutWhoDidNotRun) {
  const std::vector<std::vector<std::optional<double>>> rows = {{1.0, std::nullopt, std::nullopt}, {3.0, 5.0, std::nullopt}};
  const auto mean = table_mean(rows);
  ASSERT_EQ(mean.size(), 3U);
  EXPECT_EQ(mean[0], 2.0);
  EXPECT_EQ(mean[1], 5.0);
  EXPECT_FALSE(mean[2].has_value()) << "a run nobody did has no mean, not zero";
  EXPECT_TRUE(table_mean(std::vector<std::vector<std::optional<double>>>{{1.0}, {1.0, 2.0}}).empty());
}

// The paper's own tables; p by listing all signs with another program. Of runs 3 and 6 one pair is a tie.
TEST(PairedTest, GivesTheKnownValuesOfThePapersTables) {
  using Column = std::vector<std::optional<double>>;
  const std::optional<double> none;
  const Column c2{0.60, 0.23, 0.42, 0.76, 0.49, 0.18, 0.39, 0.24, 0.70, 0.35, 0.56},
      c3{0.95, 0.91, 0.86, 0.91, 0.77, 0.70, 0.89, 0.91, 0.86, 0.86, 0.95},
      c5{none, none, 0.47, 0.88, 0.65, 0.69, 0.45, none, none, 0.51, 0.77},
      c6{none, none, 0.92, 0.91, 0.81, 0.92, 0.87, none, none, 0.93, 0.91};
  const Column j2{9.42, 8.41, 29.73, 4.06, 6.80, 3.58, 5.01, 6.84, 24.76, 14.36, 12.20},
      j3{3.78, 5.88, 3.56, 3.41, 17.80, 7.05, 7.29, 5.05, 4.78, 6.62, 8.68},
      j5{none, none, 5.58, 11.12, 13.30, 3.63, 12.39, none, none, 31.22, 8.58},
      j6{none, none, 2.12, 3.61, 9.87, 7.79, 4.43, none, none, 7.40, 7.72};
  const auto expect = [](const Column& a, const Column& b, std::size_t pairs, std::size_t up, double p) {
    const PairedTest test = paired_test(a, b);
    EXPECT_EQ(test.pairs, pairs);
    EXPECT_EQ(test.up, up);
    ASSERT_TRUE(test.p);
    EXPECT_NEAR(*test.p, p, 0.006);
  };
  expect(c2, c3, 11, 11, 0.001);
  expect(c5, c6, 7, 7, 0.016);
  expect(c2, c5, 7, 7, 0.016);
  expect(j2, j3, 11, 3, 0.17);
  expect(j5, j6, 7, 1, 0.11);
  expect(j3, j6, 7, 3, 0.22);
  expect(c3, c6, 7, 4, 0.1875);
  EXPECT_FALSE(paired_test(c2, c2).p) << "nothing differs";
}

// Two walks in each visit, by turns 0.02, 0.04 and 0.06 apart: s^2 = (0.0002 + 0.0008 + 0.0018) / 3. The visits themselves are 1 apart.
std::vector<Measured> walks(std::size_t visits) {
  std::vector<Measured> out;
  for (std::size_t visit = 1; visit <= visits; ++visit)
    for (int walk = 0; walk < 2; ++walk)
      out.push_back({.session = static_cast<std::int64_t>(2 * visit) + walk,
                     .visit = static_cast<std::int64_t>(visit),
                     .value = static_cast<double>(visit) + 0.02 * static_cast<double>((visit - 1) % 3 + 1) * walk});
  return out;
}

TEST(Change, ComesFromRepeatsWithinVisitsOnly) {
  EXPECT_FALSE(own_minimal_change(walks(9))) << "9 degrees of freedom say nothing";
  const auto minimal = own_minimal_change(walks(12));
  ASSERT_TRUE(minimal);
  EXPECT_NEAR(*minimal, 1.96 * std::sqrt(2.0 * 0.0028 / 3), 1e-12);
  std::vector<Measured> far = walks(12);
  for (Measured& one : far) one.value += 1e6;
  EXPECT_NEAR(*own_minimal_change(far), *minimal, 1e-9);
  // Visits are told apart by their number, not by their order: 0 to 11 without 5, and between them one of another visit.
  std::vector<Measured> mixed(12);
  for (std::size_t i = 0; i < mixed.size(); ++i) mixed[i] = {.session = 1, .visit = i == 5 ? 2 : 1, .value = static_cast<double>(i)};
  EXPECT_NEAR(own_minimal_change(mixed).value_or(0), 1.96 * std::sqrt(2.0 * (481 - 61.0 * 61 / 11) / 10), 1e-9);
  EXPECT_FALSE(own_minimal_change(std::vector<Measured>(20, Measured{.session = 1, .visit = 1, .value = 2}))) << "nothing varied";
}

TEST(Change, IsToldBeyondTheMinimalOneOnly) {
  EXPECT_FALSE(change_of("J_N", {}));
  EXPECT_EQ(change_of("J_N", std::vector<Measured>{{1, 1, 5.0}, {2, 1, 9.0}})->why, NoChange::one_visit);
  EXPECT_EQ(change_of("J_N", walks(9))->why, NoChange::few_repeats);
  const auto real = change_of("J_N", walks(12));
  EXPECT_EQ(real->why, NoChange::none);
  EXPECT_EQ(real->repeats, 12U);
  EXPECT_EQ(real->published, nullptr);
  EXPECT_NEAR(real->difference(), 11.06, 1e-12);
  std::vector<Measured> back = walks(12);
  back.back().value = back.front().value - 0.05;
  EXPECT_EQ(change_of("J_N", back)->why, NoChange::within_noise);
}

// The first walk after a pause against the last one before it.
TEST(Change, FromOneVisitToTheNextIsWhatWasKept) {
  EXPECT_FALSE(retention_of("J_N", {}));
  EXPECT_FALSE(retention_of("J_N", std::vector<Measured>{{1, 1, 5.0}, {2, 1, 9.0}})) << "one visit";
  std::vector<Measured> values = walks(12);
  auto kept = retention_of("J_N", values);
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->first.session, 23);
  EXPECT_EQ(kept->last.session, 24);
  EXPECT_NEAR(kept->difference(), 0.96, 1e-12);
  EXPECT_EQ(kept->why, NoChange::none);
  values[22].value = values[21].value + 0.05;
  EXPECT_EQ(retention_of("J_N", values)->why, NoChange::within_noise);
}

// All orders of a visit are tried: of those that chance gives, at most 5 % may be taken for learning, and the interval holds 0 in the others.
TEST(Learning, IsToldFalselyInAtMostOneOfTwentyOrders) {
  const std::map<std::size_t, std::size_t> expected{{5, 1}, {6, 6}, {7, 76}};
  for (const std::size_t walked : {5U, 6U, 7U}) {
    std::vector<double> order(walked);
    for (std::size_t i = 0; i < walked; ++i) order[i] = static_cast<double>(i * i);
    std::size_t orders = 0, rising = 0, falling = 0;
    do {
      std::vector<Measured> values;
      for (std::size_t i = 0; i < walked; ++i) values.push_back({1, 1, order[i], static_cast<std::int64_t>(i)});
      const Learning learning = learning_of(values);
      ASSERT_TRUE(learning.slope);
      ++orders;
      rising += learning.why == NoChange::none && learning.slope->low > 0;
      falling += learning.why == NoChange::none && learning.slope->high < 0;
      ASSERT_EQ(learning.why == NoChange::none, learning.slope->low > 0 || learning.slope->high < 0);
    } while (std::ranges::next_permutation(order).found);
    EXPECT_EQ(rising, falling);
    EXPECT_LE(40 * rising, orders) << walked;
    // Kendall's S at 2.5 % a side: 10, 13 and 15, reached by so many orders (Kendall 1975, table 1).
    EXPECT_EQ(rising, expected.at(walked)) << walked;
  }
}

TEST(Learning, TakesTheSlopeWithinVisitsAndEachVisitsOwnLevel) {
  // 0.1 a walk within each visit; from visit to visit it falls.
  std::vector<Measured> values;
  for (int visit = 0; visit < 3; ++visit)
    for (int walk = 0; walk < 4; ++walk) values.push_back({4 * visit + walk, visit, 5.0 - 2 * visit + 0.1 * walk, walk});
  values.push_back({99, 99, 40.0});
  Learning learning = learning_of(values);
  EXPECT_EQ(learning.walks, 12U);
  EXPECT_EQ(learning.visits, 3U);
  ASSERT_TRUE(learning.slope);
  EXPECT_NEAR(learning.slope->middle, 0.1, 1e-9);
  EXPECT_EQ(learning.why, NoChange::none);
  // One wild walk does not move the middle.
  values[2].value = 100;
  EXPECT_NEAR(learning_of(values).slope->middle, 0.1, 1e-9);
  // Equal values are no slope.
  for (Measured& one : values) one.value = 3;
  learning = learning_of(values);
  EXPECT_EQ(learning.why, NoChange::no_slope);
  EXPECT_EQ(learning.slope->high, 0);
}

// A walk without a valid value is practice, too.
TEST(Learning, CountsWalksAndNotValues) {
  std::vector<Measured> all, half;
  for (int walk = 0; walk < 10; ++walk) {
    all.push_back({walk, 1, 0.4 + 0.02 * walk, walk});
    if (walk % 2 == 0) half.push_back(all.back());
  }
  for (const std::vector<Measured>& values : {all, half}) {
    const Learning learning = learning_of(values);
    ASSERT_TRUE(learning.slope) << values.size();
    EXPECT_NEAR(learning.slope->middle, 0.02, 1e-9) << values.size();
    EXPECT_NEAR(learning.slope->low, 0.02, 1e-9) << values.size();
    EXPECT_NEAR(learning.slope->high, 0.02, 1e-9) << values.size();
  }
}

TEST(Learning, NeedsFiveWalksOfOneVisitOrTwoOfSix) {
  const auto why = [](const std::vector<std::size_t>& visits) {
    std::vector<Measured> values;
    for (std::size_t visit = 0; visit < visits.size(); ++visit)
      for (std::size_t walk = 0; walk < visits[visit]; ++walk)
        values.push_back({1, static_cast<std::int64_t>(visit), static_cast<double>(walk), static_cast<std::int64_t>(walk)});
    return learning_of(values).why;
  };
  EXPECT_EQ(why({}), NoChange::few_walks);
  EXPECT_EQ(why({4}), NoChange::few_walks);
  EXPECT_EQ(why({5}), NoChange::none);
  EXPECT_EQ(why({3, 3}), NoChange::few_walks);
  EXPECT_EQ(why({3, 4}), NoChange::none);
  EXPECT_EQ(why({2, 2, 2, 2, 2, 1}), NoChange::few_walks);
  EXPECT_EQ(why({2, 2, 2, 2, 2, 2}), NoChange::none);
}

// The faster the first walk, the larger the minimal change (Lewek & Sykes 2019, Hosoi et al. 2023). Exactly that much is no change.
TEST(Change, IsPublishedWhereTheLiteratureHasIt) {
  const auto of = [](std::string_view figure, double first, double last) {
    return *change_of(figure, std::vector<Measured>{{1, 1, first}, {2, 2, last}});
  };
  EXPECT_EQ(of("walking_speed_m_s", 0.25, 0.34).why, NoChange::within_noise);
  EXPECT_EQ(of("walking_speed_m_s", 0.25, 0.36).why, NoChange::none);
  EXPECT_EQ(of("walking_speed_m_s", 0.25, 0.14).why, NoChange::none) << "slower, too";
  EXPECT_EQ(of("timed_speed_m_s", 0.4, 0.5).minimal, 0.15);
  EXPECT_EQ(of("walking_speed_m_s", 0.8, 1.0).minimal, 0.21);
  EXPECT_EQ(of("walking_speed_m_s", 0.5, 0.75).published->source, "Lewek & Sykes 2019");
  EXPECT_EQ(of("cadence_steps_min", 80.0, 92.0).why, NoChange::within_noise);
  EXPECT_EQ(of("cadence_steps_min", 80.0, 93.0).why, NoChange::none);
  EXPECT_EQ(of("J_N", 1.0, 9.0).why, NoChange::few_repeats);
}

TEST(Change, OfAPatientWhoVariesMoreThanPublishedIsTheOwnOne) {
  std::vector<Measured> varied = walks(12);
  for (Measured& one : varied) one.value = 0.5 + 3 * std::fmod(one.value, 1.0);
  const auto own = change_of("walking_speed_m_s", varied);
  EXPECT_EQ(own->published, nullptr);
  EXPECT_NEAR(*own->minimal, 3 * 1.96 * std::sqrt(2.0 * 0.0028 / 3), 1e-9);
  for (Measured& one : varied) one.value = 0.5 + (one.value - 0.5) / 10;
  EXPECT_EQ(change_of("walking_speed_m_s", varied)->minimal, 0.15);
}

// Every row names a figure, and the rows of a figure cover all values without a gap.
TEST(Change, EveryPublishedRowFitsAFigure) {
  std::map<std::string_view, double> reached;
  for (const PublishedChange& one : published_changes()) {
    EXPECT_EQ(std::ranges::count(kMetrics, one.figure, &MetricInfo::key), 1) << one.figure;
    EXPECT_EQ(one.from, reached[one.figure]) << one.figure;
    EXPECT_LT(one.from, one.below);
    EXPECT_GT(one.minimal, 0);
    reached[one.figure] = one.below;
  }
  for (const auto& [figure, below] : reached) EXPECT_TRUE(std::isinf(below)) << figure;
}

}  // namespace
}  // namespace hoist::db
