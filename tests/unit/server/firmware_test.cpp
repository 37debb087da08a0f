// A node's new program over REST: whole updates of a simulated node behind the fake core, refusals, and what ends one.
#include <array>
#include <atomic>
#include <chrono>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/firmware_image.hpp"
#include "firmware/boot/host/updatable_node.hpp"
#include "firmware/sim/world.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using contract::CommandKind;
using contract::Mode;
using contract::Node;

constexpr const char* kPath = "/api/v1/firmware/tilt_left";

std::string program(std::size_t bytes = 700, contract::ImageKind kind = contract::ImageKind::tilt) {
  std::vector<std::uint8_t> image(bytes);
  for (std::size_t i = 0; i < bytes; ++i) image[i] = static_cast<std::uint8_t>(i * 7 + (i >> 8));
  firmware::seal_image(image, kind, contract::ImageChip::simulated, contract::image_version(1, 1, 0));
  return {image.begin(), image.end()};
}

class Firmware : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    core_->set_bus([this](const std::vector<contract::CanFrame>& frames) {
      for (const contract::CanFrame& frame : frames) EXPECT_TRUE(world.host_send(frame));
      for (int i = 0; i < 10; ++i) world.advance_1ms();
      std::array<contract::CanFrame, 64> got{};
      const std::size_t count = deaf ? 0 : world.host_receive(got);
      return std::vector<contract::CanFrame>(got.begin(), got.begin() + static_cast<std::ptrdiff_t>(count));
    });
  }
  void TearDown() override {
    core_->set_bus(nullptr);
    ServerTest::TearDown();
  }
  Answer post(const std::string& target, const std::string& body, const std::string& type = "application/octet-stream") {
    Headers headers = bearer_;
    headers.emplace_back("Content-Type", type);
    Answer answer = http(port_, "POST", target, headers, body);
    check_described("POST", target, answer);
    return answer;
  }
  void take_lease() { ASSERT_EQ(call("POST", "/api/v1/lease").status, 200); }
  std::size_t sent(CommandKind kind) {
    std::size_t n = 0;
    for (const auto& command : core_->commands()) n += command.kind == kind;
    return n;
  }
  json node(const std::string& name) {
    const json all = get("/api/v1/firmware").json();
    for (const json& row : all["nodes"])
      if (row["name"] == name) return row;
    return nullptr;
  }
  json update() { return get("/api/v1/firmware").json()["update"]; }

  sim::World world{{.host_in_process = true}};
  std::atomic<bool> deaf{false};
};

TEST_F(Firmware, ANodeGetsANewProgramAndEverybodySeesHowFarItIs) {
  EXPECT_TRUE(update().is_null());
  EXPECT_TRUE(node("tilt_left")["version"].is_null()) << "nobody has asked it yet";
  Live live(port_, bearer_);
  ASSERT_EQ(live.status(), 101U);
  take_lease();
  const auto begin = std::chrono::steady_clock::now();
  deaf = true;  // so that it cannot be over before the second one is asked for
  const Answer answer = post(kPath, program());
  ASSERT_EQ(answer.status, 202U) << answer.body;
  EXPECT_EQ(answer.json()["update"]["result"], "running");
  EXPECT_EQ(answer.json()["update"]["bytes_total"], 700);
  EXPECT_EQ(core_->mode(), Mode::init);
  const Answer second = post("/api/v1/firmware/tilt_right", program());
  EXPECT_EQ(second.status, 409U) << "one at a time";
  deaf = false;
  std::size_t messages = 0, last = 0;
  json progress;
  do {
    progress = live.wait("firmware_progress");
    ASSERT_FALSE(progress.empty());
    ++messages;
    EXPECT_EQ(progress["node"], "tilt_left");
    EXPECT_GE(progress["bytes_sent"].get<std::size_t>(), last);
    last = progress["bytes_sent"].get<std::size_t>();
  } while (progress["result"] == "running");
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_EQ(progress["result"], "done") << progress["text"];
  EXPECT_EQ(progress["phase"], "done");
  EXPECT_EQ(last, 700U);
  EXPECT_GE(messages, 2U);
  EXPECT_LE(static_cast<double>(messages), 4.0 * took_s + 2.0);
  EXPECT_EQ(node("tilt_left")["version"], "1.1.0");
  EXPECT_EQ(node("tilt_left")["in_loader"], false);
  EXPECT_EQ(node("tilt_left")["crc"].get<std::string>().size(), 8U);
  EXPECT_EQ(update()["result"], "done");
  ASSERT_TRUE(until([&] { return sent(CommandKind::end_service) == 1; }));
  EXPECT_EQ(core_->commands().back().kind, CommandKind::end_service);
  EXPECT_EQ(contract::read_image_header(world.program_flash(Node::tilt_left)->read()).version, contract::image_version(1, 1, 0));
  // The same once more is left alone.
  ASSERT_EQ(post(kPath, program()).status, 202U);
  ASSERT_TRUE(until([&] { return update()["result"] != "running"; }));
  EXPECT_EQ(update()["result"], "unchanged");
}

TEST_F(Firmware, WhatIsNoProgramForThisNodeIsRefusedBeforeAnythingIsSent) {
  take_lease();
  const auto refused = [&](const std::string& body, const std::string& field) {
    const Answer answer = post(kPath, body);
    ASSERT_EQ(answer.status, 422U) << answer.body;
    EXPECT_EQ(answer.json()["errors"][0]["field"], field);
  };
  refused("", "length");
  refused("short", "length");
  refused(program(700, contract::ImageKind::drive), "kind");
  std::string image = program();
  image[0xC0] = 'X';
  refused(image, "magic");
  image = program();
  image[500] = static_cast<char>(image[500] ^ 1);
  refused(image, "crc");
  refused(program() + "x", "length");
  refused(program(0x8000), "length");
  EXPECT_EQ(post(kPath, std::string(128 * 1024 + 1, 'x')).status, 413U);
  EXPECT_EQ(post(kPath, program(), "application/json").status, 415U);
  EXPECT_EQ(post("/api/v1/firmware/core", program()).status, 404U);
  EXPECT_EQ(post("/api/v1/firmware/nobody", program()).status, 404U);
  EXPECT_EQ(post(std::string{kPath} + "?force=yes", program()).status, 422U);
  EXPECT_EQ(http(port_, "POST", "/api/v1/neutral", {bearer_[0], {"Content-Type", "application/json"}}, "{" + std::string(70'000, ' ') + "}")
                .status,
            413U)
      << "room for a program is for programs only";
  EXPECT_EQ(sent(CommandKind::begin_service), 0U);
  EXPECT_TRUE(update().is_null());
}

TEST_F(Firmware, TheCoreHasTheLastWord) {
  Answer answer = post(kPath, program());
  EXPECT_EQ(answer.status, 409U);
  EXPECT_EQ(answer.json()["refusals"][0], "no_lease");
  take_lease();
  core_->set([](contract::TickRecord& record) { record.mode = static_cast<std::uint8_t>(Mode::user); });
  answer = post(kPath, program());
  EXPECT_EQ(answer.status, 409U);
  EXPECT_EQ(answer.json()["refusals"][0], "not_standby");
  EXPECT_EQ(sent(CommandKind::service_frame), 0U);
  EXPECT_TRUE(update().is_null());
  for (const auto& command : core_->commands())
    if (command.kind == CommandKind::begin_service) {
      EXPECT_EQ(command.b, static_cast<std::uint32_t>(contract::Role::engineer));
    }
}

TEST_F(Firmware, STOPBreaksItOffAndSaysSo) {
  take_lease();
  ASSERT_EQ(post(kPath, program(6000)).status, 202U);
  ASSERT_TRUE(until([&] { return update()["bytes_sent"].get<int>() > 100; }));
  EXPECT_EQ(call("POST", "/api/v1/stop").status, 200U);
  ASSERT_TRUE(until([&] { return update()["result"] != "running"; }));
  EXPECT_EQ(update()["result"], "interrupted");
  EXPECT_NE(update()["text"].get<std::string>().find("send the program again"), std::string::npos);
  const std::size_t frames = sent(CommandKind::service_frame);
  for (int i = 0; i < 20; ++i) get("/api/v1/status");
  EXPECT_EQ(sent(CommandKind::service_frame), frames);
  // And then again, from its loader.
  ASSERT_EQ(call("POST", "/api/v1/acknowledge").status, 200U);
  ASSERT_EQ(post(kPath, program()).status, 202U);
  ASSERT_TRUE(until([&] { return update()["result"] != "running"; }));
  EXPECT_EQ(update()["result"], "done");
}

TEST_F(Firmware, ANodeThatDoesNotAnswerIsSaidToBeAbsent) {
  deaf = true;
  take_lease();
  ASSERT_EQ(post(kPath, program()).status, 202U);
  ASSERT_TRUE(until([&] { return update()["result"] != "running"; }));
  EXPECT_EQ(update()["result"], "failed");
  EXPECT_NE(update()["text"].get<std::string>().find("does not answer"), std::string::npos);
  ASSERT_TRUE(until([&] { return core_->mode() == Mode::standby; })) << "and service is over";
}

}  // namespace
}  // namespace hoist::test
