// The stored stops (H22): stored values are restored, and an invalid file puts the hoist out of service.
#include "control/run/stop_file.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "control/contract/faults.hpp"
#include "control/core/supervise/supervisor.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::run {
namespace {

using contract::Fault;
using contract::fault_bit;

constexpr std::uint64_t kNow_ns = 900'000'000'000;

class StopFile : public testing::Test {
 protected:
  [[nodiscard]] std::string text() const {
    std::ifstream file(path_);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void write(const std::string& text) const { std::ofstream(path_) << text; }
  static core::StopHistory two_stops() {
    core::StopHistory history;
    history.count = 2;
    history.stops[0] = {600'000'000'000, static_cast<std::uint64_t>(Fault::tilt_left_lost)};
    history.stops[1] = {800'000'000'000, static_cast<std::uint64_t>(Fault::loop_overrun)};
    return history;
  }

  const test::TemporaryFolder folder_;
  const std::string path_ = folder_.file("stops.json");
};

TEST_F(StopFile, AMissingFileIsAFirstStart) {
  const LoadedStops loaded = load_stop_file(path_, "a", kNow_ns);
  EXPECT_TRUE(loaded.problem.empty());
  EXPECT_EQ(loaded.history.count, 0U);
  EXPECT_EQ(loaded.history.out_of_service, 0U);
}

TEST_F(StopFile, H22WhatWasStoredIsKnownAfterARestartOfTheProgram) {
  core::StopHistory history = two_stops();
  history.out_of_service = fault_bit(Fault::control_fault) | fault_bit(Fault::loop_overrun);
  ASSERT_EQ(save_stop_file(path_, "a", history).problem, "");
  const LoadedStops loaded = load_stop_file(path_, "a", kNow_ns);
  EXPECT_TRUE(loaded.problem.empty()) << loaded.problem;
  ASSERT_EQ(loaded.history.count, 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(loaded.history.stops[i].time_ns, history.stops[i].time_ns);
    EXPECT_EQ(loaded.history.stops[i].fault, history.stops[i].fault);
  }
  EXPECT_EQ(loaded.history.out_of_service, history.out_of_service);
}

// The steady clock restarts with the computer, and the wall clock may not be set: each stop counts as new.
TEST_F(StopFile, H22AfterARestartOfTheComputerEachStopIsOneOfNow) {
  ASSERT_EQ(save_stop_file(path_, "a", two_stops()).problem, "");
  for (const std::string boot : {"b", ""}) {
    const LoadedStops loaded = load_stop_file(path_, boot, 5);
    ASSERT_EQ(loaded.history.count, 2U);
    EXPECT_EQ(loaded.history.stops[0].time_ns, 5);
    EXPECT_EQ(loaded.history.stops[1].time_ns, 5);
  }
}

// The unit's sandbox hides /proc/sys; without an id each restart of the program would count all stops as new.
TEST_F(StopFile, H22TheInstalledProgramKnowsTheBoot) {
  std::ifstream unit(std::string(HOIST_SOURCE_DIR) + "/deploy/systemd/hoist-control.service");
  const std::string service{std::istreambuf_iterator<char>(unit), {}};
  EXPECT_NE(service.find("\nEnvironment=HOIST_BOOT_ID=%b\n"), std::string::npos);
  ::unsetenv("HOIST_BOOT_ID");
  const std::string of_kernel = boot_id();
  EXPECT_EQ(of_kernel.size(), 32U) << of_kernel;
  ASSERT_EQ(::setenv("HOIST_BOOT_ID", "0123456789abcdef0123456789abcdef", 1), 0);
  EXPECT_EQ(boot_id(), "0123456789abcdef0123456789abcdef");
  EXPECT_TRUE(StopStore(path_).keeps_times());
  ASSERT_EQ(::setenv("HOIST_BOOT_ID", "", 1), 0);
  EXPECT_FALSE(StopStore(path_).keeps_times());
  ::unsetenv("HOIST_BOOT_ID");
}

TEST_F(StopFile, H22ADamagedFilePutsTheHoistOutOfService) {
  ASSERT_EQ(save_stop_file(path_, "a", two_stops()).problem, "");
  const std::string whole = text();
  std::size_t noticed = 0;
  for (std::size_t cut = 0; cut + 2 < whole.size(); ++cut) {
    write(whole.substr(0, cut));
    const LoadedStops loaded = load_stop_file(path_, "a", kNow_ns);
    ASSERT_FALSE(loaded.problem.empty()) << cut;
    ASSERT_EQ(loaded.history.out_of_service, fault_bit(Fault::control_fault));
    ++noticed;
  }
  EXPECT_GT(noticed, 100U);
  std::string edited = whole;
  edited.replace(edited.find("loop_overrun"), 12, "tilt_frozen\"");
  for (const std::string& bad : {edited, std::string("[]"), std::string(100'000, ' ')}) {
    write(bad);
    EXPECT_EQ(load_stop_file(path_, "a", kNow_ns).history.out_of_service, fault_bit(Fault::control_fault));
  }
}

TEST_F(StopFile, H22AFileThatCannotBeReadPutsTheHoistOutOfService) {
  std::ofstream(folder_.file("file")) << "";
  std::filesystem::create_symlink("itself", folder_.file("itself"));
  for (const std::string& unreadable : {folder_.file("file/stops.json"), folder_.file("itself")}) {
    const LoadedStops loaded = load_stop_file(unreadable, "a", kNow_ns);
    EXPECT_NE(loaded.problem.find("cannot read " + unreadable), std::string::npos) << loaded.problem;
    EXPECT_EQ(loaded.history.out_of_service, fault_bit(Fault::control_fault)) << unreadable;
  }
}

TEST_F(StopFile, H22WhatCannotBeWrittenIsToldAndTriedAgain) {
  const std::string path = folder_.file("later/stops.json");
  StopStore store(path);
  EXPECT_EQ(store.look(nullptr), contract::StoreProblem::none) << "nothing has changed";
  const core::StopHistory two = two_stops();
  EXPECT_EQ(store.look(&two), contract::StoreProblem::failed);
  EXPECT_NE(store.problem().find(path), std::string::npos);
  EXPECT_EQ(store.look(nullptr), contract::StoreProblem::failed) << "still";
  std::filesystem::create_directory(folder_.file("later"));
  EXPECT_EQ(store.look(nullptr), contract::StoreProblem::none);
  EXPECT_EQ(store.problem(), "");
  EXPECT_EQ(store.load(kNow_ns).history.count, 2U);
}

// End to end: three losses of one sensor, with a restart of the program in between, as hoist-control stores and loads them.
TEST_F(StopFile, H22TheThirdStopIsTheLastAlsoAfterARestart) {
  for (int run = 0; run < 3; ++run) {
    core::test::ScriptedHoist hoist;
    hoist.time_ns = kNow_ns + static_cast<std::uint64_t>(run) * 60'000'000'000;
    core::restore_stops(hoist.state, load_stop_file(path_, "a", hoist.time_ns).history);
    ASSERT_TRUE(hoist.ready());
    hoist.tilt_left.silent = true;
    hoist.step(10);
    hoist.tilt_left.silent = false;
    for (int i = 0; i < 300; ++i) {
      hoist.step();
      if (hoist.out.stops_changed) {
        ASSERT_EQ(save_stop_file(path_, "a", core::stop_history(hoist.state)).problem, "");
      }
    }
    EXPECT_EQ(hoist.state.mode, run < 2 ? contract::Mode::protective_stop : contract::Mode::fault) << run;
  }
  core::test::ScriptedHoist again;
  core::restore_stops(again.state, load_stop_file(path_, "a", kNow_ns + 7'200'000'000'000).history);
  again.step(300);
  EXPECT_EQ(again.state.mode, contract::Mode::fault) << "out of service is left by an acknowledgement, not by the switch";
  EXPECT_TRUE(again.has_fault(Fault::tilt_left_lost)) << "and what it was for is known";
}

}  // namespace
}  // namespace hoist::run
