// PoKeys: packets, polling a device that may lose, delay and corrupt packets, and the resulting input node. Virtual time over a socketpair;
// one test runs the whole with its thread over UDP.
#include "control/bus/pokeys/input_port.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <deque>
#include <functional>
#include <optional>
#include <random>
#include <tuple>
#include <vector>

#include "firmware/sim/pokeys_device.hpp"

namespace hoist::bus::pokeys {
namespace {
using contract::CanFrame;
using contract::canopen::NmtState;
using sim::PokeysDevice;

constexpr std::uint64_t kMs = 1'000'000;

TEST(PokeysPackets, RequestIsWhatTheProtocolSays) {
  const Packet request = make_request(CommandCode::inputs, 0, 0x42);
  EXPECT_EQ(request[0], 0xBB);
  EXPECT_EQ(request[1], 0xCC);
  EXPECT_EQ(request[6], 0x42);
  EXPECT_EQ(request[7], static_cast<std::uint8_t>(0xBB + 0xCC + 0x42));
}

TEST(PokeysPackets, OnlyTheAnswerToTheQuestionIsGood) {
  Packet reply = make_request(CommandCode::inputs, 0, 7);
  EXPECT_EQ(check_reply(reply, CommandCode::inputs, 7), ReplyCheck::no_reply) << "a request is no reply";
  reply[0] = kReplyMark;
  EXPECT_EQ(check_reply(reply, CommandCode::inputs, 7), ReplyCheck::bad_checksum);
  reply[7] = checksum(reply);
  EXPECT_EQ(check_reply(reply, CommandCode::inputs, 7), ReplyCheck::good);
  EXPECT_EQ(check_reply(reply, CommandCode::inputs, 8), ReplyCheck::other_id);
  EXPECT_EQ(check_reply(reply, CommandCode::analogue, 7), ReplyCheck::other_command);
}

TEST(PokeysPackets, ThePlayedDeviceAnswersGoodRequestsOnly) {
  PokeysDevice played;
  Packet reply{};
  const Packet good = make_request(CommandCode::inputs, 0, 9);
  ASSERT_TRUE(played.answer(good, {0b0110, 0b0001, {}}, reply));
  EXPECT_EQ(check_reply(reply, CommandCode::inputs, 9), ReplyCheck::good);
  EXPECT_FALSE(pin_level(reply, 1));
  EXPECT_TRUE(pin_level(reply, 2));
  EXPECT_TRUE(pin_level(reply, 3));
  EXPECT_TRUE(pin_level(reply, 5));
  EXPECT_FALSE(pin_level(reply, 6));
  Packet bad = good;
  bad[7] ^= 1;
  EXPECT_FALSE(played.answer(bad, {}, reply)) << "a wrong checksum";
  bad = good;
  bad[0] = kReplyMark;
  bad[7] = checksum(bad);
  EXPECT_FALSE(played.answer(bad, {}, reply)) << "a reply is no request";
  bad = good;
  bad[1] = 0x41;
  bad[7] = checksum(bad);
  EXPECT_FALSE(played.answer(bad, {}, reply)) << "a command it does not know";
}

// PoLabs' library: PK_DigitalIOSetGet sets bits from byte 8 and leaves the pins alone whose bits are set from byte 20.
TEST(PokeysPackets, AnOutputIsSetWithoutTouchingAnotherPin) {
  const Packet on = make_output_request(9, true, 3);
  EXPECT_EQ(on[1], 0xCC);
  EXPECT_EQ(on[2], 1);
  EXPECT_EQ(on[7], static_cast<std::uint8_t>(0xBB + 0xCC + 1 + 3));
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(on[8 + i], i == 1 ? 0x01 : 0x00);
    EXPECT_EQ(on[20 + i], i == 1 ? 0xFE : 0xFF);
  }
  EXPECT_EQ(make_output_request(9, false, 3)[9], 0x00);
  EXPECT_EQ(make_output_request(55, true, 3)[8 + 6], 0x40);
}

// The device's end of a socketpair. What it does with a request is up to the test.
class Bench : public ::testing::Test {
 protected:
  Bench() {
    std::array<int, 2> ends{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()), 0);
    ours_ = ends[0];
    theirs_ = ends[1];
    transport_ = std::make_unique<DescriptorTransport>(ours_);
    device = std::make_unique<Device>(*transport_, Wiring{});
  }
  ~Bench() override {
    ::close(ours_);
    if (theirs_ >= 0) ::close(theirs_);
  }
  void unplug() {
    ::close(theirs_);
    theirs_ = -1;
  }
  std::optional<Packet> request() {
    Packet packet{};
    if (::recv(theirs_, packet.data(), packet.size(), MSG_DONTWAIT) != static_cast<ssize_t>(kPacketBytes)) return std::nullopt;
    return packet;
  }
  void say(const Packet& packet, std::size_t bytes = kPacketBytes) {
    std::array<std::uint8_t, 2 * kPacketBytes> buffer{};
    std::copy(packet.begin(), packet.end(), buffer.begin());
    ASSERT_EQ(::send(theirs_, buffer.data(), bytes, MSG_DONTWAIT), static_cast<ssize_t>(bytes));
  }
  Packet right_answer(const Packet& asked) {
    Packet reply{};
    EXPECT_TRUE(played_.answer(asked, pins, reply));
    return reply;
  }
  // Lets time pass in steps of a millisecond; the device answers within each.
  void run(std::uint64_t ms) {
    for (std::uint64_t i = 0; i < ms; ++i) {
      now_ns += kMs;
      device->step(now_ns);
      while (const auto asked = request()) {
        ++asked_count;
        if (behave)
          behave(*asked);
        else
          say(right_answer(*asked));
      }
      device->step(now_ns);
    }
  }
  [[nodiscard]] std::uint64_t age_ms() const {
    return device->readings().inputs_ns == 0 ? 1'000'000 : (now_ns - device->readings().inputs_ns) / kMs;
  }

  PokeysDevice::Pins pins{};
  PokeysDevice played_;
  std::function<void(const Packet&)> behave;
  std::uint64_t now_ns = 10'000 * kMs;
  std::uint32_t asked_count = 0;
  std::unique_ptr<Transport> transport_;
  std::unique_ptr<Device> device;

 private:
  int ours_ = -1, theirs_ = -1;
};

TEST_F(Bench, ReadsBumpersSwitchesAndBatteries) {
  pins = {0b0101, 0b0011, {12.7, 12.66}};
  run(200);
  EXPECT_STREQ(device->problem(), "");
  EXPECT_EQ(device->readings().bumpers, 0b0101);
  EXPECT_EQ(device->readings().switches, 0b0011);
  EXPECT_NEAR(device->readings().battery_10mv[0], 1270, 1);
  EXPECT_NEAR(device->readings().battery_10mv[1], 1266, 1);
  EXPECT_LE(age_ms(), 11U);
  const std::uint32_t before = asked_count;
  run(1000);
  EXPECT_NEAR(asked_count - before, 110, 6) << "inputs every 10 ms, analogue every 100 ms";
  EXPECT_EQ(device->counters().unanswered, 0U);
  EXPECT_EQ(device->counters().refused, 0U);
  pins.bumpers = 0;
  run(20);
  EXPECT_EQ(device->readings().bumpers, 0);
}

TEST_F(Bench, EveryThirdPacketLostLeavesTheReadingsFresh) {
  run(100);
  std::uint32_t number = 0;
  behave = [&](const Packet& asked) {
    if (++number % 3 != 0) say(right_answer(asked));
  };
  std::uint64_t oldest_ms = 0;
  for (int i = 0; i < 500; ++i) {
    run(10);
    oldest_ms = std::max(oldest_ms, age_ms());
  }
  EXPECT_LT(oldest_ms, 100U);
  EXPECT_GT(device->counters().unanswered, 30U);
  EXPECT_EQ(device->counters().opened, 1U);
}

TEST_F(Bench, AnswersThatAreNotRightAreNotTaken) {
  run(100);
  const auto none_counts = [this](const char* what, const std::function<void(Packet&)>& spoil) {
    behave = [this, &spoil](const Packet& asked) {
      PokeysDevice::Pins pressed = pins;
      pressed.bumpers = 0x0F;
      Packet reply{};
      ASSERT_TRUE(played_.answer(asked, pressed, reply));
      spoil(reply);
      say(reply);
    };
    run(60);
    EXPECT_EQ(device->readings().bumpers, 0) << what << ": the wrong answer was taken";
    EXPECT_GE(age_ms(), 50U) << what << ": the reading was renewed";
    behave = nullptr;
    run(100);
    EXPECT_LE(age_ms(), 11U) << what << ": does not come back";
  };
  const auto seal = [](Packet& packet) { packet[7] = checksum(packet); };
  none_counts("wrong checksum", [](Packet& p) { p[7] = static_cast<std::uint8_t>(p[7] + 1); });
  EXPECT_GT(device->counters().refused, 0U);
  none_counts("wrong mark", [&](Packet& p) { p[0] = 0xAB, seal(p); });
  none_counts("wrong id", [&](Packet& p) { p[6] = static_cast<std::uint8_t>(p[6] + 100), seal(p); });
  EXPECT_GT(device->counters().late, 0U);
  none_counts("wrong command", [&](Packet& p) { p[1] = 0x30, seal(p); });
}

TEST_F(Bench, AnswersOfTheWrongSizeAreNotTaken) {
  run(100);
  for (const std::size_t bytes : {1UL, 63UL, 65UL, 128UL}) {
    const std::uint32_t before = device->counters().refused;
    behave = [this, bytes](const Packet& asked) { say(right_answer(asked), bytes); };
    run(60);
    EXPECT_GT(device->counters().refused, before) << bytes;
    EXPECT_GE(age_ms(), 50U) << bytes;
    behave = nullptr;
    run(60);
  }
}

TEST_F(Bench, AnAnswerThatComesTooLateIsNotTakenForTheNextOne) {
  run(100);
  pins.bumpers = 0x0F;  // what the late answers say
  std::deque<std::pair<std::uint64_t, Packet>> under_way;
  behave = [&](const Packet& asked) { under_way.emplace_back(now_ns + 40 * kMs, right_answer(asked)); };
  for (int i = 0; i < 300; ++i) {
    run(1);
    while (!under_way.empty() && under_way.front().first <= now_ns) {
      say(under_way.front().second);
      under_way.pop_front();
    }
  }
  EXPECT_EQ(device->readings().bumpers, 0);
  EXPECT_GT(device->counters().late, 3U);
  EXPECT_GE(age_ms(), 200U);
}

TEST_F(Bench, GarbageIsBoundedAndChangesNothing) {
  run(100);
  std::mt19937 random(3);
  const Readings before = device->readings();
  for (int round = 0; round < 200; ++round) {
    for (int i = 0; i < 5; ++i) {
      Packet noise{};
      for (auto& byte : noise) byte = static_cast<std::uint8_t>(random());
      if (i % 2 == 0) noise[0] = kReplyMark;
      say(noise);
    }
    device->step(now_ns);
    while (request()) {
    }
  }
  EXPECT_EQ(device->readings().bumpers, before.bumpers);
  EXPECT_EQ(device->readings().inputs_ns, before.inputs_ns);
  EXPECT_GE(device->counters().refused + device->counters().late, 990U);
  run(200);
  EXPECT_LE(age_ms(), 11U);
}

TEST_F(Bench, ASilentDeviceIsOpenedAnewAndAskedWhoItIsAgain) {
  run(100);
  behave = [](const Packet&) {};
  run(3000);
  EXPECT_STRNE(device->problem(), "");
  EXPECT_GE(device->counters().opened, 3U);
  EXPECT_LE(device->counters().opened, 7U) << "a pause lies between the tries";
  const std::uint32_t opened = device->counters().opened;
  std::vector<std::uint8_t> commands;
  behave = [&](const Packet& asked) {
    commands.push_back(asked[1]);
    say(right_answer(asked));
  };
  run(900);
  EXPECT_STREQ(device->problem(), "");
  EXPECT_LE(age_ms(), 11U);
  EXPECT_LE(device->counters().opened, opened + 1);
  ASSERT_GE(commands.size(), 3U);
  EXPECT_EQ(commands[0], 0x00) << "another device may have taken its place";
}

TEST_F(Bench, AWrongDeviceOrWrongPinsAreNotUsed) {
  Wiring wiring;
  const auto never_used = [this, &wiring](const std::function<void(Packet&)>& change, const char* says) {
    device = std::make_unique<Device>(*transport_, wiring);
    behave = [this, &change](const Packet& asked) {
      Packet reply = right_answer(asked);
      change(reply);
      say(reply);
    };
    run(1000);
    EXPECT_EQ(device->readings().inputs_ns, 0U) << says;
    EXPECT_NE(std::string(device->problem()).find(says), std::string::npos) << device->problem();
  };
  never_used(
      [](Packet& p) {
        if (p[1] == 0x00) p[8] = 'X';
      },
      "no PoKeys57");
  never_used(
      [](Packet& p) {
        if (p[1] == 0xC0) p[8 + 2] = kDigitalOutput;
      },
      "bumper");
  never_used(
      [](Packet& p) {
        if (p[1] == 0xC0) p[8] = kDigitalInput | kInverted;
      },
      "bumper");
  never_used(
      [](Packet& p) {
        if (p[1] == 0xC0) p[8 + 6] = 0;
      },
      "switch");
  never_used(
      [](Packet& p) {
        if (p[1] == 0xC0) p[8 + 41] = kDigitalInput;
      },
      "battery");
  wiring.sync_pin = 9;
  never_used(
      [](Packet& p) {
        if (p[1] == 0xC0) p[8 + 8] = kDigitalInput;
      },
      "synchronisation");
}

TEST_F(Bench, TheSynchronisationOutputLeavesWithThePollsAndOnlyWhenItIsWired) {
  device->set_sync(true);
  run(50);
  EXPECT_FALSE(played_.output()) << "no pin is named for it";
  Wiring wiring;
  wiring.sync_pin = 9;
  device = std::make_unique<Device>(*transport_, wiring);
  pins.bumpers = 0b0100;
  for (const bool level : {true, false, true}) {
    device->set_sync(level);
    run(50);
    EXPECT_EQ(played_.output(), level);
    EXPECT_EQ(device->readings().bumpers, 0b0100) << "the same packet reads the inputs";
  }
}

TEST_F(Bench, AnAnalogueValueThatCannotBeIsNotTaken) {
  pins.battery_v = {12.0, 12.0};
  run(200);
  const auto batteries_ns = device->readings().batteries_ns;
  behave = [this](const Packet& asked) {
    Packet reply = right_answer(asked);
    if (reply[1] == 0x3A) reply[8] = 0x10;
    say(reply);
  };
  run(500);
  EXPECT_EQ(device->readings().batteries_ns, batteries_ns);
  EXPECT_NEAR(device->readings().battery_10mv[0], 1200, 1);
  EXPECT_LE(age_ms(), 11U) << "the digital inputs go on";
}

TEST_F(Bench, ADeviceThatIsPulledOutIsSeen) {
  run(100);
  unplug();
  now_ns += 20 * kMs;
  device->step(now_ns);
  EXPECT_STREQ(device->problem(), "the device has gone away");
}

TEST(PokeysUsb, WhatIsNoPokeysIsNotTalkedTo) {
  HidrawTransport nowhere("/nowhere/hidraw0"), file("/dev/null");
  EXPECT_STREQ(nowhere.open(), "the device is not there");
  EXPECT_STREQ(file.open(), "the device is no HID device");
  EXPECT_EQ(file.descriptor(), -1);
}

// ---- the input node

class StandIn : public ::testing::Test {
 protected:
  // One control step.
  std::vector<CanFrame> step(std::uint8_t pressed = 0) {
    now_ns += 10 * kMs;
    if (answers) readings.inputs_ns = readings.batteries_ns = now_ns - 3 * kMs;
    std::array<CanFrame, IoStandIn::kFramesMax> out{};
    const std::size_t count = node.step(readings, pressed, now_ns, out);
    return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(count)};
  }
  void start() {
    ASSERT_EQ(step().size(), 1U);
    node.on_frame(contract::canopen::nmt(contract::canopen::NmtCommand::start, 8));
  }
  // The bumpers byte of the newest first process data within `steps`; empty without one.
  std::optional<int> bumpers_within(int steps, std::uint8_t pressed = 0) {
    std::optional<int> shown;
    for (int i = 0; i < steps; ++i)
      for (const CanFrame& frame : step(i == 0 ? pressed : std::uint8_t{0}))
        if (frame.id == 0x188) shown = frame.data[0];
    return shown;
  }
  IoStandIn node;
  Readings readings;
  bool answers = true;
  std::uint64_t now_ns = 1000 * kMs;
};

TEST_F(StandIn, SaysNothingBeforeTheDeviceHasAnswered) {
  answers = false;
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(step().empty());
}

TEST_F(StandIn, BehavesAsTheInputNode) {
  const auto boot = step();
  ASSERT_EQ(boot.size(), 1U);
  EXPECT_EQ(boot[0], contract::canopen::heartbeat(8, NmtState::boot_up));
  node.on_frame(contract::canopen::sdo(0x608, contract::canopen::kSdoUploadRequest, 0x1018, 2, 0));
  auto frames = step();
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0], contract::canopen::sdo(0x588, 0x43, 0x1018, 2, 3)) << "an input board, and no simulated one";
  // What the core asks for before it starts the node.
  for (const auto& [index, sub, command, word] : {std::tuple{0x1016, 1, 0x43, 0x007F00FA}, {0x6206, 1, 0x4F, 255}, {0x6207, 1, 0x4F, 0}}) {
    const auto object = static_cast<std::uint16_t>(index);
    const auto part = static_cast<std::uint8_t>(sub);
    node.on_frame(contract::canopen::sdo(0x608, contract::canopen::kSdoUploadRequest, object, part, 0));
    frames = step();
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0], contract::canopen::sdo(0x588, static_cast<std::uint8_t>(command), object, part, static_cast<std::uint32_t>(word)));
  }
  for (int i = 0; i < 100; ++i)
    for (const CanFrame& frame : step())
      EXPECT_EQ(frame, contract::canopen::heartbeat(8, NmtState::pre_operational)) << "no data before start";
  node.on_frame(contract::canopen::nmt(contract::canopen::NmtCommand::start, 8));
  readings.battery_10mv = {1270, 1265};
  int heartbeats = 0, inputs = 0, batteries = 0;
  for (int i = 0; i < 100; ++i)
    for (const CanFrame& frame : step()) {
      heartbeats += frame.id == 0x708 ? 1 : 0;
      inputs += frame.id == 0x188 ? 1 : 0;
      if (frame.id != 0x288) continue;
      ++batteries;
      EXPECT_EQ(frame.dlc, 8);
      EXPECT_EQ(contract::read_le(&frame.data[0], 2), 1270U);
      EXPECT_EQ(contract::read_le(&frame.data[2], 2), 1265U);
    }
  EXPECT_EQ(heartbeats, 10);
  EXPECT_NEAR(inputs, 1000 / contract::pdo_info(contract::Pdo::io_tx1).period_ms, 1) << "as often as the dictionary says";
  EXPECT_NEAR(batteries, 1000 / contract::pdo_info(contract::Pdo::io_tx2).period_ms, 1);
  node.on_frame(contract::canopen::nmt(contract::canopen::NmtCommand::stop, 0));
  EXPECT_FALSE(bumpers_within(20));
  node.on_frame(contract::canopen::nmt(contract::canopen::NmtCommand::reset_node, 8));
  frames = step();
  ASSERT_FALSE(frames.empty());
  EXPECT_EQ(frames[0], contract::canopen::heartbeat(8, NmtState::boot_up));
}

TEST_F(StandIn, RefusesWhatItDoesNotHave) {
  step();
  node.on_frame(contract::canopen::sdo(0x608, contract::canopen::kSdoUploadRequest, 0x6041, 0, 0));
  node.on_frame(contract::canopen::sdo(0x608, contract::canopen::sdo_download_command(2), 0x1017, 0, 50));
  const auto frames = step();
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].data[0], contract::canopen::kSdoAbort);
  EXPECT_EQ(contract::read_le(&frames[0].data[4], 4), 0x06020000U);
  EXPECT_EQ(contract::read_le(&frames[1].data[4], 4), 0x06010002U);
  for (int i = 0; i < 100; ++i) node.on_frame(contract::canopen::sdo(0x608, contract::canopen::kSdoUploadRequest, 0x1000, 0, 0));
  EXPECT_LE(step().size(), IoStandIn::kFramesMax) << "a flood of questions is bounded";
}

TEST_F(StandIn, APressIsShownAtOnceAndAShortOneIsNotForgotten) {
  start();
  EXPECT_EQ(bumpers_within(4), 0);
  readings.bumpers = 0b0010;
  EXPECT_EQ(bumpers_within(1), 0b0010);
  readings.bumpers = 0;
  EXPECT_EQ(bumpers_within(1), 0);
  EXPECT_EQ(bumpers_within(1, 0b0100), 0b0100) << "touched and free again between two steps";
  EXPECT_EQ(bumpers_within(3), 0);
}

TEST_F(StandIn, AStaleAnswerReadsAsPressedThenTheNodeFallsSilentAndComesBackAnew) {
  start();
  EXPECT_EQ(bumpers_within(5), 0);
  answers = false;  // the last answer is 3 ms old now
  EXPECT_EQ(bumpers_within(9).value_or(0), 0) << "93 ms old";
  EXPECT_EQ(bumpers_within(1), 0x0F) << "103 ms old";
  std::optional<std::uint32_t> volts;
  bool silent = false;
  for (int i = 0; i < 120; ++i) {
    const auto frames = step();
    for (const CanFrame& frame : frames) {
      EXPECT_FALSE(silent) << "speaks again without the device";
      if (frame.id == 0x188) {
        EXPECT_EQ(frame.data[0], 0x0F);
      }
      if (frame.id == 0x288) volts = contract::read_le(&frame.data[0], 2);
    }
    silent = silent || now_ns - readings.inputs_ns >= IoStandIn::kGoneNs;
  }
  EXPECT_TRUE(silent);
  EXPECT_EQ(volts, 0U) << "a battery nobody has measured for long reads as empty";
  answers = true;
  const auto frames = step();
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0], contract::canopen::heartbeat(8, NmtState::boot_up)) << "the core configures it from the start";
  EXPECT_FALSE(bumpers_within(20)) << "and starts it again";
}

// ---- the command line

TEST(PokeysInputs, UnderstandsItsWords) {
  InputOptions options;
  EXPECT_EQ(parse_inputs("pokeys:usb", options), "");
  EXPECT_EQ(parse_inputs("pokeys:/dev/hidraw3", options), "");
  EXPECT_EQ(parse_inputs("pokeys:udp:127.0.0.1", options), "");
  EXPECT_EQ(parse_inputs("pokeys:udp:127.0.0.1:1234?bumpers=9,10,11,12&switches=1,2,3,4&batteries=43,44&full_v=33&sync=20", options), "");
  EXPECT_EQ(options.wiring.sync_pin, 20);
  EXPECT_EQ(options.wiring.bumper_pins[3], 12);
  EXPECT_EQ(options.wiring.battery_pins[0], 43);
  EXPECT_DOUBLE_EQ(options.wiring.full_scale_v, 33.0);
  ASSERT_NE(options.transport, nullptr);
}

TEST(PokeysInputs, RefusesEverythingElseAndSaysWhat) {
  for (const char* bad : {"",
                          "pokeys",
                          "pokeys:",
                          "pokeys:udp",
                          "pokeys:udp:",
                          "pokeys:tcp:host",
                          "io",
                          "pokeys:udp:127.0.0.1:0",
                          "pokeys:udp:127.0.0.1:70000",
                          "pokeys:udp:127.0.0.1:12x",
                          "pokeys:usb?bumpers=1,2,3",
                          "pokeys:usb?bumpers=1,2,3,4,5",
                          "pokeys:usb?bumpers=0,1,2,3",
                          "pokeys:usb?bumpers=1,2,3,56",
                          "pokeys:usb?bumpers=1,2,3,",
                          "pokeys:usb?bumpers=1;2;3;4",
                          "pokeys:usb?batteries=40,41",
                          "pokeys:usb?full_v=nan",
                          "pokeys:usb?full_v=1",
                          "pokeys:usb?full_v=1e9",
                          "pokeys:usb?full_v=",
                          "pokeys:usb?colour=red",
                          "pokeys:usb?bumpers=1,1,2,3",
                          "pokeys:usb?bumpers=5,6,7,9",
                          "pokeys:usb?sync=0",
                          "pokeys:usb?sync=1,2",
                          "pokeys:usb?sync=7"}) {
    InputOptions options;
    EXPECT_NE(parse_inputs(bad, options), "") << bad;
  }
  InputOptions options;
  EXPECT_NE(parse_inputs("pokeys:usb?bumpers=1,2,3,99", options).find("from 1 to 55"), std::string::npos);
}

// ---- complete, with its thread, against the simulator's device on the network

class NullPort final : public CanPort {
 public:
  std::size_t receive(std::span<CanFrame> out, std::uint64_t) noexcept override {
    const std::size_t count = std::min(out.size(), waiting.size());
    std::copy_n(waiting.begin(), count, out.begin());
    counters_.received += static_cast<std::uint32_t>(count);
    waiting.clear();
    return count;
  }
  std::size_t send(std::span<const CanFrame> frames, std::uint64_t) noexcept override { return frames.size(); }
  [[nodiscard]] bool up() const noexcept override { return true; }
  [[nodiscard]] const PortCounters& counters() const noexcept override { return counters_; }
  std::vector<CanFrame> waiting;

 private:
  PortCounters counters_;
};

TEST(PokeysInputs, TheWholeWayOverUdp) {
  // A free port of this machine.
  const int probe = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(::bind(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(::getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size), 0);
  const std::uint16_t udp_port = ntohs(address.sin_port);
  ::close(probe);

  PokeysDevice device;
  ASSERT_EQ(device.open(udp_port), "");
  PokeysDevice::Pins pins{0, 0, {12.5, 12.4}};
  InputOptions options;
  ASSERT_EQ(parse_inputs("pokeys:udp:127.0.0.1:" + std::to_string(udp_port) + "?sync=9", options), "");
  auto inner = std::make_unique<NullPort>();
  NullPort& bus = *inner;
  InputPort port(std::move(inner), std::move(options));
  std::array<CanFrame, 32> frames{};
  const std::array start{contract::canopen::nmt(contract::canopen::NmtCommand::start, 8)};
  const auto boot_up = contract::canopen::heartbeat(8, NmtState::boot_up);
  // Real time because of a thread: waits for events, never for a fixed time.
  const auto wait_for = [&](const std::function<bool(const CanFrame&)>& wanted) {
    for (int i = 0; i < 10000; ++i) {
      device.serve(pins);
      timespec now{};
      ::clock_gettime(CLOCK_MONOTONIC, &now);
      const auto now_ns = static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(now.tv_nsec);
      const std::size_t count = port.receive(frames, now_ns);
      for (std::size_t f = 0; f < count; ++f) {
        // Also again: on a machine that was delayed by a second the node was lost.
        if (frames[f] == boot_up) {
          EXPECT_EQ(port.send(start, 0), 1U);
        }
        if (wanted(frames[f])) return true;
      }
      ::poll(nullptr, 0, 1);
    }
    return false;
  };
  ASSERT_TRUE(wait_for([&](const CanFrame& f) { return f == boot_up; }));
  EXPECT_STREQ(port.input_problem(), "");
  ASSERT_TRUE(wait_for([](const CanFrame& f) { return f.id == 0x188 && f.data[0] == 0; }));
  ASSERT_TRUE(wait_for([](const CanFrame& f) { return f.id == 0x288 && contract::read_le(&f.data[0], 2) == 1250; }));
  pins.bumpers = 0b1000;
  ASSERT_TRUE(wait_for([](const CanFrame& f) { return f.id == 0x188 && f.data[0] == 0b1000; }));
  pins.bumpers = 0;
  ASSERT_TRUE(wait_for([](const CanFrame& f) { return f.id == 0x188 && f.data[0] == 0; }));
  // A second input node on the bus has no say; the others pass.
  bus.waiting = {CanFrame{0x188, 2, 0, {0x05, 0}}, CanFrame{0x708, 1, 0, {5}}, CanFrame{0x181, 1, 0, {1}}};
  bool drive = false, wrong = false;
  ASSERT_TRUE(wait_for([&](const CanFrame& f) {
    drive = drive || f.id == 0x181;
    wrong = wrong || (f.id == 0x188 && f.data[0] == 0x05);
    return f.id == 0x288;
  }));
  EXPECT_TRUE(drive);
  EXPECT_FALSE(wrong);
  EXPECT_EQ(port.doubles(), 2U);
  EXPECT_EQ(port.counters().refused, 2U);
  for (const bool level : {true, false}) {
    const std::array outputs{CanFrame{0x208, 2, 0, {static_cast<std::uint8_t>(level ? contract::canopen::kSyncOutput : 0)}}};
    port.send(outputs, 0);
    ASSERT_TRUE(wait_for([&](const CanFrame&) { return device.output() == level; })) << "the synchronisation output";
  }
  device.set_silent(true);
  ASSERT_TRUE(wait_for([](const CanFrame& f) { return f.id == 0x188 && f.data[0] == 0x0F; })) << "silence is not read as pressed";
  device.set_silent(false);
  ASSERT_TRUE(wait_for([](const CanFrame& f) { return f.id == 0x188 && f.data[0] == 0; }));
}

}  // namespace
}  // namespace hoist::bus::pokeys
