// The CAN drivers of the images on a busy bus: in which order frames leave, and what a sent remote frame leaves behind.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/machine/c_can.hpp"
#include "tests/machine/hoist_bench.hpp"

namespace hoist::machine {
namespace {

using contract::CanFrame;

// Sends without a pause under one identifier: frames of lower priority never win.
class Jammer : public CanStation {
 public:
  void set(std::optional<std::uint32_t> id) { id_ = id; }
  [[nodiscard]] bool on_bus() const override { return true; }
  [[nodiscard]] bool offer(CanFrame& frame) override {
    frame = {id_.value_or(0), 8, 0, {}};
    return id_.has_value();
  }
  void began() override {}
  void sent(CanError) override {}
  void heard(const CanFrame&, CanError) override {}
  void idle(std::uint64_t) override {}

 private:
  std::optional<std::uint32_t> id_;
};

class CanDriver : public testing::TestWithParam<ImageChip> {
 protected:
  void SetUp() override {
    found = load_images();
    if (!found.images) GTEST_SKIP() << found.reason;
  }
  void begin(bool through_gateway) {
    BenchOptions options;
    options.scenario = sim::find_scenario("stand");
    options.through_gateway = through_gateway;
    options.chips.fill(GetParam());
    bench = std::make_unique<HoistBench>(*found.images, options);
    (void)bench->wire().connect(jammer);
    bench->wire().on_frame([this](const CanFrame& frame, Time) {
      wire.push_back(frame);
      if (see) see(frame);
    });
    run(600);
  }
  void run(int milliseconds) {
    for (int ms = 0; ms < milliseconds; ++ms) bench->advance_1ms();
  }
  // Frames received by the computer since the last call.
  std::vector<CanFrame> received() {
    std::vector<CanFrame> all;
    std::array<CanFrame, 64> frames{};
    while (const std::size_t got = bench->host_receive(frames))
      all.insert(all.end(), frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(got));
    return all;
  }
  static std::ptrdiff_t count(const std::vector<CanFrame>& frames, std::uint32_t id) {
    return std::count_if(frames.begin(), frames.end(), [id](const CanFrame& frame) { return frame.id == id; });
  }

  ImagesOrReason found;
  Jammer jammer;
  std::vector<CanFrame> wire;
  std::function<void(const CanFrame&)> see;
  std::unique_ptr<HoistBench> bench;
};

INSTANTIATE_TEST_SUITE_P(Chips, CanDriver, testing::Values(ImageChip::lpc11c24, ImageChip::stm32f072),
                         [](const testing::TestParamInfo<ImageChip>& tested) {
                           return std::string(contract::find_image_chip(static_cast<std::uint8_t>(tested.param))->name);
                         });

// The C_CAN itself, without a program: a remote frame's object before and behind a receiving one.
class RemoteObject : public testing::Test {
 protected:
  RemoteObject() {
    (void)wire.connect(host);
    (void)wire.connect(can);
    write(0x00, 0x41);  // INIT, CCE
    write(0x180, 0);
    write(0x0C, 0x1C0B);
  }
  void write(std::uint32_t offset, std::uint32_t value) { can.write(offset, value, cycles += 100, 48'000'000); }
  void run(Time span) {
    for (const Time end = now + span; now < end; now += 100 * kMicrosecond) wire.advance(now);
  }
  void set_up(std::uint32_t object, std::uint32_t id2, std::uint32_t mask2, std::uint32_t control) {
    write(0x24, 0xF0);  // write mask, arbitration, control
    write(0x28, 0);
    write(0x2C, mask2);
    write(0x30, 0);
    write(0x34, id2);
    write(0x38, control);
    write(0x20, object);
  }
  // Which objects hold new data after a remote frame 711h has left object `remote` and its answer has come.
  std::uint32_t takers(std::uint32_t remote, std::uint32_t receiving) {
    constexpr std::uint32_t kValid = 0x8000, kRequest = 0x100, kEndOfBuffer = 0x80, kUseMask = 0x1000;
    set_up(receiving, kValid, 0x2000, kUseMask | kEndOfBuffer);  // takes everything
    set_up(remote, kValid | (0x711U << 2), 0xFFFF, kRequest | kEndOfBuffer | 1);
    write(0x00, 0);
    run(5 * kMillisecond);
    EXPECT_EQ(host.received.size(), 1U);
    EXPECT_EQ(host.received.front().flags, CanFrame::kRemote);
    host.send({0x711, 1, 0, {5}});
    run(5 * kMillisecond);
    return can.read(0x120, cycles += 100);
  }

  CanWire wire;
  HostStation host;
  CCan can{[](const std::string& what) { ADD_FAILURE() << what; }};
  std::uint64_t cycles = 0;
  Time now = 0;
};
TEST_F(RemoteObject, BeforeTheReceivingOneTakesItsAnswer) { EXPECT_EQ(takers(1, 2), 1U << 0); }
TEST_F(RemoteObject, BehindTheReceivingOneTakesNothing) { EXPECT_EQ(takers(3, 2), 1U << 1); }

// A remote frame is sent from a receive object. That object must not take the data frames that answer it, nor later ones.
TEST_P(CanDriver, ASentRemoteFrameTakesNoFrameFromTheComputer) {
  begin(true);
  constexpr std::uint32_t kHeartbeat = 0x711;
  for (const std::uint32_t id : {kHeartbeat, 0x181U, 0x591U, 0x081U}) bench->host_send({id, 1, CanFrame::kRemote, {}});
  run(50);
  EXPECT_EQ(std::count_if(wire.begin(), wire.end(), [](const CanFrame& frame) { return (frame.flags & CanFrame::kRemote) != 0; }), 4);
  (void)received();
  wire.clear();
  run(1000);
  EXPECT_GE(count(wire, kHeartbeat), 9);
  run(5);
  EXPECT_GE(count(received(), kHeartbeat), 9);
  // And the object can be used again.
  wire.clear();
  bench->host_send({kHeartbeat, 1, CanFrame::kRemote, {}});
  run(20);
  EXPECT_EQ(std::count_if(wire.begin(), wire.end(), [](const CanFrame& frame) { return (frame.flags & CanFrame::kRemote) != 0; }), 1);
  EXPECT_EQ(bench->violations(), "");
}

// A wrong bit that the UART notices makes no other frame of a line, wherever in it it is.
TEST_P(CanDriver, H4ALineWithADamagedCharacterIsNoFrame) {
  begin(true);
  constexpr std::size_t kLine = sizeof("t7E580123456789ABCDEF");  // with its end
  const CanFrame sent{0x7E5, 8, 0, {0x01, 0x23, 0x45, 0x67, 0x89, 0xAB, 0xCD, 0xEF}}, after{0x7E4, 1, 0, {0x5A}};
  for (std::size_t nth = 1; nth <= kLine; ++nth) {
    bench->chip(Box::gateway).serial_line().disturb(nth);
    bench->host_send(sent);
    run(3);
    bench->host_send(after);
    run(3);
  }
  std::vector<CanFrame> came;
  std::copy_if(wire.begin(), wire.end(), std::back_inserter(came), [](const CanFrame& frame) { return frame.id >= 0x7E0; });
  EXPECT_EQ(came, std::vector(kLine - 1, after));  // a damaged end takes the next line with it
}

// What the computer sends in any order while the bus is busy leaves the gateway in the order of the identifiers. On the STM32F072 one frame of
// process data and one of SDO and heartbeats hold a mailbox that they got before the others came (stm32f072/transmit_order.hpp).
TEST_P(CanDriver, TheGatewaySendsByIdentifier) {
  begin(true);
  jammer.set(1);
  run(5);
  const std::vector<std::uint32_t> falling{0x77F, 0x601, 0x208, 0x202, 0x201, 0x080};
  for (const std::uint32_t id : falling) {
    bench->host_send({id, 0, 0, {}});
    run(3);
  }
  wire.clear();
  jammer.set(std::nullopt);
  run(20);
  std::vector<std::uint32_t> sent;
  for (const CanFrame& frame : wire)
    if (std::find(falling.begin(), falling.end(), frame.id) != falling.end()) sent.push_back(frame.id);
  const std::vector<std::uint32_t> by_mailbox{0x080, 0x208, 0x201, 0x202, 0x77F, 0x601};
  EXPECT_EQ(sent, GetParam() == ImageChip::stm32f072 ? by_mailbox : std::vector<std::uint32_t>(falling.rbegin(), falling.rend()));
  EXPECT_EQ(bench->violations(), "");
}

// The second process data of a node that waits in the controller does not hold up the first: 181h before 281h, 193h before 293h. On the STM32F072
// it may, once, when the node's heartbeat waits too: the two have every mailbox but that of SYNC and EMCY.
TEST_P(CanDriver, ANodesSecondProcessDataLetsItsFirstPass) {
  begin(false);
  bench->host_send(contract::canopen::nmt(contract::canopen::NmtCommand::start, 0));
  run(20);
  constexpr std::uint32_t kBelowSync = 0x100;  // passes SYNC, stops every process datum
  struct Pair {
    std::uint32_t first, second;
  };
  for (const Pair pair : {Pair{0x181, 0x281}, Pair{0x193, 0x293}}) {
    int both_waited = 0;
    for (int cycle = 0; cycle < 10; ++cycle) {
      see = [&](const CanFrame& frame) {
        if (frame.id == pair.first) jammer.set(kBelowSync);  // the second one is the controller's next
      };
      bench->host_send(contract::canopen::sync());
      run(10);
      see = nullptr;
      wire.clear();
      bench->host_send(contract::canopen::sync());
      run(4);
      jammer.set(std::nullopt);
      run(6);
      std::vector<std::uint32_t> sent;
      for (const CanFrame& frame : wire)
        if (frame.id == pair.first || frame.id == pair.second) sent.push_back(frame.id);
      const bool mailboxes_held = GetParam() == ImageChip::stm32f072 && count(wire, 0x700 + (pair.first & 0x7FU)) > 0;
      const auto first = std::find(sent.begin(), sent.end(), pair.first);
      ASSERT_NE(first, sent.end()) << cycle;
      EXPECT_LE(first - sent.begin(), mailboxes_held ? 1 : 0) << cycle;
      both_waited += sent.size() > 1 ? 1 : 0;
    }
    EXPECT_GE(both_waited, 2) << pair.first;
  }
  EXPECT_EQ(bench->violations(), "");
}

}  // namespace
}  // namespace hoist::machine
