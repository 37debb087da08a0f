#include "control/run/parameter_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

namespace hoist::run {
namespace {

class ParameterFile : public ::testing::Test {
 protected:
  ~ParameterFile() override { ::unlink(path.c_str()); }
  std::string text() const {
    std::ifstream file(path);
    std::stringstream all;
    all << file.rdbuf();
    return all.str();
  }
  void write(const std::string& content) const { std::ofstream(path) << content; }
  std::string path = ::testing::TempDir() + "hoist-parameters-" + std::to_string(::getpid()) + ".json";
};

TEST_F(ParameterFile, AMissingFileIsAFirstStart) {
  const LoadedParams loaded = load_parameter_file(path);
  EXPECT_TRUE(loaded.usable);
  EXPECT_EQ(loaded.params.track_width_m, contract::Params{}.track_width_m);
}

TEST_F(ParameterFile, ComesBackToTheLastBit) {
  contract::Params params;
  params.lean_gain_filtered_units = 1.0 / 3.0;
  params.neutral_lean_m = -0.012345678901234567;
  ASSERT_EQ(save_parameter_file(path, params), "");
  const LoadedParams loaded = load_parameter_file(path);
  ASSERT_TRUE(loaded.usable) << loaded.problem;
  EXPECT_TRUE(loaded.remarks.empty());
  for (std::size_t i = 0; i < contract::kParamCount; ++i)
    EXPECT_EQ(contract::get_param(loaded.params, i), contract::get_param(params, i)) << contract::kParams[i].name;
}

TEST_F(ParameterFile, AnEditedOrCutFileIsNotUsed) {
  ASSERT_EQ(save_parameter_file(path, contract::Params{}), "");
  const std::string good = text();
  std::string edited = good;
  edited.replace(edited.find("0.8"), 3, "0.9");
  write(edited);
  EXPECT_FALSE(load_parameter_file(path).usable);
  EXPECT_NE(load_parameter_file(path).problem.find("checksum"), std::string::npos);
  for (std::size_t length = 0; length < good.size() - 2; length += 37) {
    write(good.substr(0, length));
    EXPECT_FALSE(load_parameter_file(path).usable) << "cut at " << length;
  }
}

TEST_F(ParameterFile, AValueOutsideItsRangeStaysAtItsDefaultAndIsNamed) {
  contract::Params params;
  params.track_width_m = 99;  // as an older version with a wider range may have stored it
  ASSERT_EQ(save_parameter_file(path, params), "");
  const LoadedParams loaded = load_parameter_file(path);
  ASSERT_TRUE(loaded.usable);
  EXPECT_EQ(loaded.params.track_width_m, contract::Params{}.track_width_m);
  ASSERT_EQ(loaded.remarks.size(), 1U);
  EXPECT_NE(loaded.remarks[0].find("track_width_m"), std::string::npos);
}

TEST_F(ParameterFile, AContradictorySetIsNotUsed) {
  contract::Params params;
  params.fall_tilt_rad = 0.21;
  params.fall_static_tilt_rad = 0.16;
  ASSERT_EQ(save_parameter_file(path, params), "");
  const LoadedParams loaded = load_parameter_file(path);
  EXPECT_FALSE(loaded.usable);
  EXPECT_NE(loaded.problem.find("fall_tilt_rad"), std::string::npos);
}

TEST_F(ParameterFile, AFailedSaveSaysWhyAndLeavesTheOldFile) {
  EXPECT_NE(save_parameter_file("/nowhere/parameters.json", contract::Params{}).find("/nowhere"), std::string::npos);
}

// What the loop writes: never the defaults that stand in for damaged settings, and of --set only what somebody changed since.
TEST_F(ParameterFile, KeepsWhatItHasWhenDefaultsStandInForDamagedSettings) {
  contract::Params stored;
  stored.lean_gain_direct_units = 3;
  contract::Params started = stored;
  started.turn_gain_direct_units = 5;  // --set
  const auto in_force = [](const contract::Params& params) {
    contract::ParamsInForce now;
    for (std::size_t i = 0; i < contract::kParamCount; ++i) now.values[i] = now.kept[i] = contract::get_param(params, i);
    return now;
  };
  const contract::ParamsInForce before = in_force(started);
  EXPECT_FALSE(params_to_store(before, before, started, stored)) << "nothing has changed";
  contract::ParamsInForce damaged = in_force(contract::Params{});
  damaged.defaults_after_damage = 1;
  EXPECT_FALSE(params_to_store(damaged, before, started, stored)) << "the file is the last place that knows better";
  contract::Params changed = started;
  changed.speed_cap_norm = 0.5;
  const auto to_store = params_to_store(in_force(changed), before, started, stored);
  ASSERT_TRUE(to_store);
  EXPECT_EQ(to_store->speed_cap_norm, 0.5);
  EXPECT_EQ(to_store->lean_gain_direct_units, 3);
  EXPECT_EQ(to_store->turn_gain_direct_units, stored.turn_gain_direct_units) << "for this run only";
}

}  // namespace
}  // namespace hoist::run
