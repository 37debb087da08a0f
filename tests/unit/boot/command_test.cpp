// `hoist firmware` on the command line: files, and a complete update of a node of hoist-sim over its pseudo terminal.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "control/bus/can_port.hpp"
#include "tests/support/shell.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/boot/boot_support.hpp"

namespace hoist::firmware {
namespace {

class FirmwareCommand : public testing::Test {
 protected:
  ~FirmwareCommand() override {
    if (simulator_ > 0) {
      ::kill(simulator_, SIGTERM);
      ::waitpid(simulator_, nullptr, 0);
    }
  }

  using Result = test::ShellResult;
  Result hoist(const std::string& arguments) { return test::run_shell(std::string(HOIST_PROGRAM) + " firmware " + arguments + " 2>&1"); }
  [[nodiscard]] std::string file(const std::string& name) const { return folder_.file(name); }
  void write(const std::string& name, const std::vector<std::uint8_t>& content) const {
    std::ofstream(file(name), std::ios::binary)
        .write(reinterpret_cast<const char*>(content.data()), static_cast<std::streamsize>(content.size()));
  }
  std::vector<std::uint8_t> read(const std::string& name) const {
    std::ifstream in(file(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }
  // The words filled in by packing.
  static void as_linked(std::vector<std::uint8_t>& image) { std::fill_n(image.begin() + contract::kImageHeaderAt + 4, 8, std::uint8_t{0}); }
  // Starts hoist-sim and waits for its first line, printed when its terminal exists.
  void start_simulator() {
    std::array<int, 2> out{};
    ASSERT_EQ(::pipe2(out.data(), O_CLOEXEC), 0);
    const std::string link = file("bus");
    simulator_ = ::fork();
    if (simulator_ == 0) {
      ::dup2(out[1], STDOUT_FILENO);
      ::execl(HOIST_SIMULATOR, HOIST_SIMULATOR, "--pty-link", link.c_str(), static_cast<char*>(nullptr));
      ::_exit(127);
    }
    ::close(out[1]);
    pollfd readable{out[0], POLLIN, 0};
    std::string text;
    std::array<char, 256> piece{};
    while (text.find("SLCAN at") == std::string::npos && ::poll(&readable, 1, 30000) == 1) {
      const ssize_t got = ::read(out[0], piece.data(), piece.size());
      if (got <= 0) break;
      text.append(piece.data(), static_cast<std::size_t>(got));
    }
    simulator_out_ = out[0];  // stays open: a closed pipe would end the simulator
    ASSERT_NE(text.find("SLCAN at"), std::string::npos) << text;
  }

 private:
  test::TemporaryFolder folder_;
  pid_t simulator_ = -1;
  int simulator_out_ = -1;
};

TEST_F(FirmwareCommand, PacksAndShowsAProgram) {
  auto linked = make_image(5001, contract::image_version(1, 2, 3), 3, ImageKind::drive, ImageChip::lpc11c24);
  contract::write_le(&linked[0], 4, 0x10001FD0);
  contract::write_le(&linked[4], 4, 0x10D5);
  as_linked(linked);
  write("in.bin", linked);
  const Result packed = hoist("pack " + file("in.bin") + " " + file("out"));
  EXPECT_EQ(packed.exit_code, 0) << packed.output;
  EXPECT_NE(packed.output.find("drive for lpc11c24, version 1.2.3"), std::string::npos) << packed.output;
  const auto image = read("out");
  EXPECT_EQ(image.size(), 5004U);  // whole words
  EXPECT_EQ(contract::check_image_file(image), ImageError::none);
  EXPECT_TRUE(std::equal(linked.begin(), linked.begin() + contract::kImageHeaderAt, image.begin()));
  EXPECT_TRUE(std::equal(linked.begin() + contract::kImageMin, linked.end(), image.begin() + contract::kImageMin));
  const Result shown = hoist("show " + file("out") + " --json");
  EXPECT_EQ(shown.exit_code, 0);
  EXPECT_NE(shown.output.find(R"("kind":"drive","chip":"lpc11c24","version":"1.2.3","length":5004)"), std::string::npos) << shown.output;
  // For a simulated node it is the same program; no chip takes it.
  EXPECT_EQ(hoist("pack " + file("in.bin") + " --simulated " + file("again")).exit_code, 0);
  EXPECT_EQ(contract::check_image(read("again"), ImageKind::drive, simulated_chip()), ImageError::none);
  EXPECT_EQ(contract::check_image(read("again"), ImageKind::drive, *contract::find_image_chip("lpc11c24")), ImageError::chip);
}

// The header decides what a program is: an input board's outputs are a drive's EN, PH and nSLEEP.
TEST_F(FirmwareCommand, PacksNoProgramUnderTheNameOfAnotherNodeOrChip) {
  const auto pack = [&](std::uint8_t kind, std::uint8_t chip, const std::string& options) {
    auto linked = make_image(5000, contract::image_version(1, 0, 0), 3, ImageKind::io, ImageChip::simulated);
    linked[contract::kImageHeaderAt + 16] = kind;
    linked[contract::kImageHeaderAt + 17] = chip;
    as_linked(linked);
    write("in.bin", linked);
    const Result result = hoist("pack " + file("in.bin") + options + " " + file("out"));
    EXPECT_EQ(result.exit_code == 0, std::filesystem::exists(file("out"))) << result.output;
    return result;
  };
  constexpr auto kIo = static_cast<std::uint8_t>(ImageKind::io);
  constexpr auto kSimulated = static_cast<std::uint8_t>(ImageChip::simulated);
  EXPECT_EQ(pack(kIo, kSimulated, " --kind drive").exit_code, 2);
  EXPECT_EQ(pack(kIo, kSimulated, " --chip lpc11c24").exit_code, 2);
  EXPECT_EQ(pack(kIo, kSimulated, " --version 9.9.9").exit_code, 2);
  EXPECT_EQ(pack(4, kSimulated, "").exit_code, 1);
  const Result unnamed = pack(0, 0, "");  // a header with zeros, as in old programs
  EXPECT_EQ(unnamed.exit_code, 1);
  EXPECT_NE(unnamed.output.find("does not say for which kind"), std::string::npos) << unnamed.output;
  EXPECT_EQ(pack(0, 0, " --simulated").exit_code, 1);
  EXPECT_EQ(pack(kIo, kSimulated, "").exit_code, 0);
}

TEST_F(FirmwareCommand, RefusesWithTheReasonAndWritesNothing) {
  write("junk", std::vector<std::uint8_t>(5000, 0x33));
  write("short", std::vector<std::uint8_t>(100, 0));
  write("long", std::vector<std::uint8_t>(contract::kImageMax + 1, 0));
  write("empty", std::vector<std::uint8_t>(5000, 0xFF));
  const auto refused = [&](const std::string& arguments, int code, const std::string& because) {
    const Result result = hoist(arguments);
    EXPECT_EQ(result.exit_code, code) << arguments << '\n' << result.output;
    EXPECT_NE(result.output.find(because), std::string::npos) << arguments << '\n' << result.output;
    EXPECT_FALSE(std::filesystem::exists(file("out")));
  };
  const std::string good = " " + file("out");
  refused("pack " + file("junk") + good, 1, "C0h");
  refused("pack " + file("empty") + good, 1, "C0h");
  refused("pack " + file("short") + good, 1, "too short");
  refused("pack " + file("long") + good, 1, "longer than");
  refused("pack " + file("absent") + good, 1, "cannot read");
  refused("pack " + file("junk") + " --force" + good, 2, "--force");
  refused("show " + file("junk"), 1, "magic");
  refused("update --bus slcan:" + file("nothing") + " --node tilt_left " + file("junk"), 1, "magic");
  refused("update --bus slcan:x --node nobody " + file("junk"), 2, "--node");
  refused("burn", 2, "burn");
  EXPECT_EQ(hoist("--help").exit_code, 0);
}

TEST_F(FirmwareCommand, UpdatesANodeOfTheSimulator) {
  start_simulator();
  const std::string bus = "--bus slcan:" + file("bus") + " ";
  Result listed = hoist("list --json " + bus);
  EXPECT_EQ(listed.exit_code, 0) << listed.output;
  EXPECT_NE(listed.output.find(R"({"node":"tilt_left","present":true,"in_loader":false,"simulated":true,"version":"1.0.0")"),
            std::string::npos)
      << listed.output;
  write("new", make_image(1500, contract::image_version(1, 2, 3), 9, ImageKind::tilt));
  write("old", make_image(1500, contract::image_version(0, 2, 3), 9, ImageKind::tilt));
  const Result updated = hoist("update " + bus + "--node tilt_left " + file("new"));
  EXPECT_EQ(updated.exit_code, 0) << updated.output;
  EXPECT_NE(updated.output.find("tilt_left runs 1.2.3 now (before: 1.0.0)"), std::string::npos) << updated.output;
  EXPECT_NE(updated.output.find("sending"), std::string::npos);
  listed = hoist("list " + bus);
  EXPECT_NE(listed.output.find("tilt_left     1.2.3"), std::string::npos) << listed.output;
  EXPECT_NE(listed.output.find("tilt_right    1.0.0"), std::string::npos) << listed.output;
  const Result refused = hoist("update " + bus + "--node tilt_left " + file("old"));
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.output.find("it runs 1.2.3"), std::string::npos) << refused.output;
  EXPECT_EQ(hoist("update " + bus + "--node drive_left " + file("new")).exit_code, 1);
}

// A line without echo: a second program could not detect hoist-control. So a line in use is refused.
TEST_F(FirmwareCommand, RefusesALineThatAnotherProgramHasOpen) {
  start_simulator();
  std::string error;
  const auto port = bus::open_port("slcan:" + file("bus"), error);
  ASSERT_TRUE(port) << error;
  std::array<contract::CanFrame, 16> frames{};
  port->receive(frames, 1);
  write("new", make_image(1500, contract::image_version(1, 2, 3), 9, ImageKind::tilt));
  for (const std::string& verb : {std::string("list"), "update --node tilt_left " + file("new")}) {
    const Result refused = hoist(verb + " --bus slcan:" + file("bus"));
    EXPECT_EQ(refused.exit_code, 1) << refused.output;
    EXPECT_NE(refused.output.find("another program has the device open"), std::string::npos) << refused.output;
  }
}

}  // namespace
}  // namespace hoist::firmware
