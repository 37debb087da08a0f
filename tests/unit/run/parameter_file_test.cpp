#include "control/run/parameter_file.hpp"
#include "control/run/options.hpp"
#include "tests/support/temporary_folder.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace {
// Disk operations of this program, and their results.
struct Disk {
  std::vector<std::string> done;
  int error = 0;                    // of each sync of a file
  int folder_error = 0;             // of each sync of a folder
  std::optional<std::size_t> room;  // bytes that a write takes at most
};
Disk disk;
}  // namespace

// These replace the C library's functions in the test program.
extern "C" int fsync(int fd) {
  struct stat status {};
  const bool folder = ::fstat(fd, &status) == 0 && S_ISDIR(status.st_mode);
  if (const int error = folder ? disk.folder_error : disk.error; error != 0) {
    errno = error;
    return -1;
  }
  disk.done.emplace_back(folder ? "sync folder" : "sync file");
  return static_cast<int>(::syscall(SYS_fsync, fd));
}
extern "C" ssize_t write(int fd, const void* bytes, std::size_t count) {
  return ::syscall(SYS_write, fd, bytes, std::min(count, disk.room.value_or(count)));
}
extern "C" int rename(const char* from, const char* to) noexcept {
  disk.done.emplace_back("rename");
  return static_cast<int>(::syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}

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
  ASSERT_EQ(save_parameter_file(path, params).problem, "");
  const LoadedParams loaded = load_parameter_file(path);
  ASSERT_TRUE(loaded.usable) << loaded.problem;
  EXPECT_TRUE(loaded.remarks.empty());
  for (std::size_t i = 0; i < contract::kParamCount; ++i)
    EXPECT_EQ(contract::get_param(loaded.params, i), contract::get_param(params, i)) << contract::kParams[i].name;
}

TEST_F(ParameterFile, AnEditedOrCutFileIsNotUsed) {
  ASSERT_EQ(save_parameter_file(path, contract::Params{}).problem, "");
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

// The default was never measured at this machine: what was checked with the old value counts no more.
TEST_F(ParameterFile, AValueOutsideItsRangeIsNamedAndTakesTheCalibrationWithIt) {
  contract::Params params;
  params.track_width_m = 99;  // as an older version with a wider range may have stored it
  params.left_alpha_zero_rad = 0.01;
  params.calibrated_zero_s = params.calibrated_bumpers_s = 1.7e9;
  params.calibrated_nodes_id = 5;
  ASSERT_EQ(save_parameter_file(path, params).problem, "");
  const LoadedParams loaded = load_parameter_file(path);
  ASSERT_TRUE(loaded.usable);
  EXPECT_EQ(loaded.params.track_width_m, contract::Params{}.track_width_m);
  EXPECT_EQ(loaded.params.left_alpha_zero_rad, 0.01);
  EXPECT_EQ(loaded.params.calibrated_zero_s, 0);
  EXPECT_EQ(loaded.params.calibrated_bumpers_s, 0);
  EXPECT_EQ(loaded.params.calibrated_nodes_id, 0);
  ASSERT_EQ(loaded.remarks.size(), 2U);
  EXPECT_EQ(loaded.remarks[0], "stored parameter track_width_m is 99.0, not a number from 0.3 to 1.2 m; its default 0.7 holds");
  EXPECT_NE(loaded.remarks[1].find("calibration"), std::string::npos);
}

TEST_F(ParameterFile, StartValuesKeepFullLeanBelowHangingAndFalls) {
  Options options;
  options.params = path;
  StartParams start;
  options.set = {"lean_range_rad=0.26"};
  const Failure refused = load_start_params(options, start);
  EXPECT_EQ(refused.exit_code, kBadArguments);
  EXPECT_NE(refused.text.find("lean_range_rad"), std::string::npos) << refused.text;
  EXPECT_NE(refused.text.find("hang_tilt_rad"), std::string::npos) << refused.text;
  // A machine that keeps older values goes on with them, and with what they do not concern.
  contract::Params old;
  old.lean_range_rad = 0.26;
  ASSERT_EQ(save_parameter_file(path, old).problem, "");
  options.set = {"speed_cap_norm=0.5", "lean_range_rad=0.26"};
  EXPECT_FALSE(load_start_params(options, start)) << load_start_params(options, start).text;
  EXPECT_EQ(start.in_force.speed_cap_norm, 0.5);
}

TEST_F(ParameterFile, AContradictorySetIsNotUsed) {
  contract::Params params;
  params.fall_tilt_rad = 0.21;
  params.fall_static_tilt_rad = 0.16;
  ASSERT_EQ(save_parameter_file(path, params).problem, "");
  const LoadedParams loaded = load_parameter_file(path);
  EXPECT_FALSE(loaded.usable);
  EXPECT_NE(loaded.problem.find("fall_tilt_rad"), std::string::npos);
}

// Taken for a first start, the defaults would take the place of a patient's settings.
TEST_F(ParameterFile, H27AFileThatCannotBeReadIsNotAFirstStart) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.file("file")) << "";
  std::filesystem::create_symlink("itself", folder.file("itself"));
  for (const std::string& unreadable : {folder.file("file/parameters.json"), folder.file("itself")}) {
    const LoadedParams loaded = load_parameter_file(unreadable);
    EXPECT_FALSE(loaded.usable) << unreadable;
    EXPECT_NE(loaded.problem.find("cannot read " + unreadable), std::string::npos) << loaded.problem;
  }
}

TEST_F(ParameterFile, AFailedSaveSaysWhyAndLeavesTheOldFile) {
  EXPECT_NE(save_parameter_file("/nowhere/parameters.json", contract::Params{}).problem.find("/nowhere"), std::string::npos);
}

// The storing thread: the disk is a folder that exists or not.
class Store : public ParameterFile {
 protected:
  void SetUp() override {
    path = folder / "parameters.json";
    disk = {};
  }
  void TearDown() override { disk = {}; }
  static contract::ParamsInForce in_force(const contract::Params& params) {
    contract::ParamsInForce now;
    for (std::size_t i = 0; i < contract::kParamCount; ++i) now.values[i] = now.kept[i] = contract::get_param(params, i);
    return now;
  }
  static contract::ParamsInForce cap(double speed_cap_norm) {
    contract::Params params;
    params.speed_cap_norm = speed_cap_norm;
    return in_force(params);
  }
  double stored_cap() const {
    const LoadedParams loaded = load_parameter_file(path);
    EXPECT_TRUE(loaded.usable) << loaded.problem;
    return loaded.params.speed_cap_norm;
  }
  test::TemporaryFolder folder;
};

TEST_F(Store, NothingIsToldStoredBeforeFileAndFolderAreSynced) {
  ParameterStore store(path, {}, {});
  EXPECT_EQ(store.look(in_force({}), 2, 0).stored, 2U) << "nothing has changed";
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_EQ(store.look(cap(0.5), 4, 0).stored, 4U);
  EXPECT_EQ(stored_cap(), 0.5);
  EXPECT_EQ(disk.done, (std::vector<std::string>{"sync file", "rename", "sync folder"}));
}

TEST_F(Store, AFullDiskIsToldAndTriedAgain) {
  ParameterStore store(path, {}, {});
  ASSERT_EQ(store.look(cap(0.5), 4, 0).stored, 4U);
  disk.error = ENOSPC;
  const contract::StoreReport full = store.look(cap(0.6), 6, 0);
  EXPECT_EQ(full.stored, 4U);
  EXPECT_EQ(full.tried, 6U);
  EXPECT_EQ(full.problem, contract::StoreProblem::disk_full);
  EXPECT_NE(store.problem(), "");
  EXPECT_EQ(stored_cap(), 0.5) << "the old file is whole";
  disk.error = 0;
  EXPECT_EQ(store.look(cap(0.6), 6, ParameterStore::kRetry_ns - 1).stored, 4U) << "not at each look";
  const contract::StoreReport well = store.look(cap(0.6), 6, ParameterStore::kRetry_ns);
  EXPECT_EQ(well.stored, 6U);
  EXPECT_EQ(well.problem, contract::StoreProblem::none);
  EXPECT_EQ(store.problem(), "");
  EXPECT_EQ(stored_cap(), 0.6);
}

// What a disk that fills up does: it takes a part and reports no error.
TEST_F(Store, AFileOfWhichTheDiskTookAPartIsNotPutInPlace) {
  ParameterStore store(path, {}, {});
  ASSERT_EQ(store.look(cap(0.5), 4, 0).stored, 4U);
  disk.room = 10;
  const contract::StoreReport full = store.look(cap(0.6), 6, 0);
  disk.room.reset();
  EXPECT_EQ(full.stored, 4U);
  EXPECT_EQ(full.problem, contract::StoreProblem::disk_full);
  EXPECT_EQ(stored_cap(), 0.5) << "the old file is whole";
  EXPECT_EQ(store.look(cap(0.6), 6, ParameterStore::kRetry_ns).stored, 6U);
}

TEST_F(Store, AFolderThatCouldNotBeSyncedLeavesTheFileInDoubt) {
  ParameterStore store(path, {}, {});
  ASSERT_EQ(store.look(cap(0.5), 4, 0).stored, 4U);
  disk.folder_error = EIO;
  EXPECT_EQ(store.look(cap(0.6), 6, 0).problem, contract::StoreProblem::failed);
  disk.folder_error = 0;
  // Back to what was stored before: the file may hold the value in between.
  EXPECT_EQ(store.look(cap(0.5), 8, 0).stored, 8U);
  EXPECT_EQ(stored_cap(), 0.5);
}

TEST_F(Store, AMissingFolderIsToldAndAnewOneIsUsed) {
  std::filesystem::remove_all(folder.path());
  ParameterStore store(path, {}, {});
  EXPECT_EQ(store.look(cap(0.5), 4, 0).problem, contract::StoreProblem::failed);
  std::filesystem::create_directories(folder.path());
  EXPECT_EQ(store.look(cap(0.5), 4, ParameterStore::kRetry_ns).stored, 4U);
  EXPECT_EQ(stored_cap(), 0.5);
}

TEST_F(Store, WithoutAFileAChangeIsNeverCalledStored) {
  ParameterStore store("", {}, {});
  EXPECT_EQ(store.look(in_force({}), 2, 0).problem, contract::StoreProblem::none);
  const contract::StoreReport report = store.look(cap(0.5), 4, 0);
  EXPECT_EQ(report.stored, 2U);
  EXPECT_EQ(report.problem, contract::StoreProblem::no_file);
}

// Never defaults that replace damaged settings, of --set only values changed since, and no trial.
TEST_F(Store, KeepsWhatItHasWhenDefaultsStandInForDamagedSettings) {
  contract::Params stored;
  stored.lean_gain_direct_units = 3;
  contract::Params started = stored;
  started.turn_gain_direct_units = 5;  // --set
  ParameterStore store(path, started, stored);
  EXPECT_EQ(store.look(in_force(started), 2, 0).stored, 2U);
  contract::ParamsInForce damaged = in_force(contract::Params{});
  damaged.defaults_after_damage = 1;
  EXPECT_EQ(store.look(damaged, 4, 0).stored, 4U) << "the file is the last place that knows better";
  contract::ParamsInForce tried = in_force(started);
  tried.values[contract::param_index(contract::ParamName::speed_cap_norm)] = 0.4;
  EXPECT_EQ(store.look(tried, 6, 0).stored, 6U) << "the next start begins without it, as it shall";
  EXPECT_FALSE(std::filesystem::exists(path));
  contract::Params changed = started;
  changed.speed_cap_norm = 0.5;
  EXPECT_EQ(store.look(in_force(changed), 8, 0).stored, 8U);
  const LoadedParams loaded = load_parameter_file(path);
  EXPECT_EQ(loaded.params.speed_cap_norm, 0.5);
  EXPECT_EQ(loaded.params.lean_gain_direct_units, 3);
  EXPECT_EQ(loaded.params.turn_gain_direct_units, stored.turn_gain_direct_units) << "for this run only";
}

}  // namespace
}  // namespace hoist::run
