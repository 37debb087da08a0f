// The step that the real-time thread runs: it must never allocate, for any input.
#include "control/run/control_loop.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "control/contract/can_dictionary.hpp"
#include "control/publish/ring.hpp"
#include "control/publish/server_link.hpp"
#include "control/run/heap_watch.hpp"

namespace hoist::run {
namespace {

// A bus on which anything may arrive.
class NoisyPort final : public bus::CanPort {
 public:
  std::size_t receive(std::span<contract::CanFrame> out, std::uint64_t) noexcept override {
    const std::size_t count = next() % 24;
    for (std::size_t i = 0; i < count; ++i) {
      constexpr std::array<std::uint32_t, 12> ids{0x181, 0x182, 0x188, 0x191, 0x192, 0x193, 0x293, 0x281, 0x701, 0x711, 0x581, 0x123};
      out[i].id = ids[next() % ids.size()];
      out[i].dlc = static_cast<std::uint8_t>(next() % 9);
      for (std::uint8_t& byte : out[i].data) byte = static_cast<std::uint8_t>(next());
    }
    counters_.received += static_cast<std::uint32_t>(count);
    return count;
  }
  std::size_t send(std::span<const contract::CanFrame> frames, std::uint64_t) noexcept override {
    const std::size_t taken = std::min(frames.size(), room);
    sent += taken;
    for (const contract::CanFrame& frame : frames.first(taken))
      if (frame.id == contract::canopen::kSync) ++syncs;
    return taken;
  }
  [[nodiscard]] bool up() const noexcept override { return true; }
  [[nodiscard]] const bus::PortCounters& counters() const noexcept override { return counters_; }
  std::uint64_t sent = 0, syncs = 0;
  std::size_t room = 1000;  // frames that it takes in a step

 private:
  std::uint32_t next() { return (seed_ = seed_ * 1664525U + 1013904223U) >> 8; }
  std::uint32_t seed_ = 7;
  bus::PortCounters counters_;
};

TEST(ControlLoop, NeverAllocatesInTenThousandSteps) {
  std::string error;
  auto link = publish::CoreLink::create("", 1, 1, error);
  ASSERT_NE(link, nullptr) << error;
  publish::ServerLink server("");
  ASSERT_TRUE(server.attach_directly(*link, error)) << error;
  NoisyPort port;
  auto loop = std::make_unique<ControlLoop>(port, *link, contract::Params{});
  const std::uint64_t before = heap_requests();
  for (std::uint64_t tick = 0; tick < 10'000; ++tick) {
    server.beat();
    contract::Command command;
    command.kind = static_cast<contract::CommandKind>(tick % 11);
    command.client = 1;
    command.request_id = static_cast<std::uint32_t>(tick);
    command.a = static_cast<std::uint32_t>(tick % 5);
    command.v0 = tick % 3 == 0 ? std::nan("") : 0.1;
    server.send(command);
    ControlLoop::Step step;
    step.tick = tick;
    step.time_ns = 1'000'000'000 + tick * 10'000'000;
    loop->step(step);
  }
  EXPECT_EQ(heap_requests() - before, 0U);
  EXPECT_EQ(port.syncs, 10'000U) << "one SYNC each step, whatever happens";
}

// A full ring is read whole. A server that writes over what was not read may have written over a STOP.
TEST(ControlLoop, CommandsThatWereOverwrittenStopTheHoist) {
  for (const std::size_t written : {contract::kCommandSlots, contract::kCommandSlots + 1}) {
    std::string error;
    auto link = publish::CoreLink::create("", 1, 1, error);
    const publish::OwnedSegment memory = publish::create_segment("commands", sizeof(contract::CommandSegment), error);
    auto& segment = *memory.mapping->as<contract::CommandSegment>();
    publish::write_header(segment.header, contract::kCommandMagic, sizeof segment, 1, 0);
    ASSERT_TRUE(link->attach(memory.descriptor.get(), error)) << error;
    NoisyPort port;
    auto loop = std::make_unique<ControlLoop>(port, *link, contract::Params{});
    for (std::size_t i = 0; i < written; ++i) publish::ring_write(segment.commands, contract::Command{.sequence = i + 1});
    loop->step({.tick = 0, .time_ns = 1'000'000'000});
    const bool stopped = (loop->record().fault_bits & contract::fault_bit(contract::Fault::stop_pressed)) != 0;
    EXPECT_EQ(stopped, written > contract::kCommandSlots);
    EXPECT_GE(loop->record().commands_refused, contract::kCommandSlots);
  }
}

TEST(ControlLoop, PublishesEveryStepAndEveryFrame) {
  std::string error;
  auto link = publish::CoreLink::create("", 1, 1, error);
  publish::ServerLink server("");
  ASSERT_TRUE(server.attach_directly(*link, error)) << error;
  publish::TickReader ticks(server);
  publish::BusReader frames(server);
  NoisyPort port;
  auto loop = std::make_unique<ControlLoop>(port, *link, contract::Params{});
  contract::ParamsInForce params;
  ASSERT_TRUE(server.params(params)) << "the parameters are there before the first step";
  EXPECT_EQ(params.values[contract::param_index(contract::ParamName::track_width_m)], contract::Params{}.track_width_m);
  for (std::uint64_t tick = 0; tick < 50; ++tick) {
    ControlLoop::Step step;
    step.tick = tick;
    step.time_ns = 1'000'000'000 + tick * 10'000'000;
    loop->step(step);
  }
  auto records = std::make_unique<std::array<contract::TickRecord, 64>>();
  ASSERT_EQ(ticks.read(*records).count, 50U);
  for (std::uint64_t tick = 0; tick < 50; ++tick) {
    EXPECT_EQ((*records)[tick].tick, tick);
    EXPECT_EQ((*records)[tick].time_ns, 1'000'000'000 + tick * 10'000'000);
  }
  auto bus = std::make_unique<std::array<contract::BusRecord, 4096>>();
  EXPECT_EQ(frames.read(*bus).count, port.counters().received + port.sent);
  // A recording must not say that a drive was commanded when nothing left.
  port.room = 1;
  const std::uint64_t before = port.sent;
  loop->step({.tick = 50, .time_ns = 1'500'000'000});
  const std::size_t count = frames.read(*bus).count;
  EXPECT_EQ(
      std::count_if(bus->begin(), bus->begin() + static_cast<std::ptrdiff_t>(count), [](const auto& frame) { return frame.sent != 0; }), 1);
  EXPECT_EQ(port.sent, before + 1);
}

// With an image and the published inputs the core gives the same records again, for any input.
TEST(ControlLoop, PublishesAllThatItTakesToRunItsStepsAgain) {
  std::string error;
  auto link = publish::CoreLink::create("", 1, 1, error);
  publish::ServerLink server("");
  ASSERT_TRUE(server.attach_directly(*link, error)) << error;
  NoisyPort port;
  auto loop = std::make_unique<ControlLoop>(port, *link, contract::Params{});
  constexpr std::uint64_t kSteps = 400;
  for (std::uint64_t tick = 0; tick < kSteps; ++tick) {
    server.beat();
    contract::Command command;
    command.kind = static_cast<contract::CommandKind>(tick % 11);
    command.client = 1;
    command.a = static_cast<std::uint32_t>(tick % 5);
    command.v0 = 0.1;
    if (tick % 3 == 0) server.send(command);
    contract::DriveCommand drive;
    drive.sequence = tick;
    drive.echo_time_ns = 1'000'000'000 + tick * 9'999'999;
    if (tick % 4 == 0) server.drive(drive);
    loop->step({.tick = tick + tick / 50,
                .time_ns = 1'000'000'000 + tick * 10'000'000,
                .wake_lateness_ns = tick * 1000,
                .previous_duration_ns = tick * 777,
                .stop = tick == 390});
  }
  std::vector<contract::TickRecord> records(kSteps);
  std::vector<contract::BusRecord> bus(16384);
  std::vector<contract::JournalStep> steps(kSteps);
  std::vector<contract::JournalCommand> commands(1024);
  std::vector<contract::CoreImage> images(contract::kImageSlots);
  const auto all = publish::ReadFrom::oldest;
  ASSERT_EQ(publish::TickReader(server, all).read(records).count, kSteps);
  ASSERT_EQ(publish::JournalReader(server, all).read(steps).count, kSteps);
  bus.resize(publish::BusReader(server, all).read(bus).count);
  commands.resize(publish::JournalCommandReader(server, all).read(commands).count);
  images.resize(publish::ImageReader(server, all).read(images).count);
  ASSERT_FALSE(images.empty());
  const contract::CoreImage& image = images.front();
  auto core = std::make_unique<core::CoreState>();
  auto out = std::make_unique<core::TickOutputs>();
  ASSERT_TRUE(publish::put_image(image, *core));
  ASSERT_LT(image.step, kSteps - 50);
  for (std::uint64_t i = image.step; i < kSteps; ++i) {
    std::vector<contract::CanFrame> frames;
    for (const contract::BusRecord& frame : bus)
      if (frame.sent == 0 && frame.time_ns == steps[i].time_ns)
        frames.push_back({frame.id, frame.dlc, frame.flags, std::bit_cast<decltype(contract::CanFrame::data)>(frame.data)});
    std::vector<contract::Command> given;
    for (const contract::JournalCommand& command : commands)
      if (command.step == i) given.push_back(command.command);
    ASSERT_EQ(frames.size(), steps[i].frames);
    ASSERT_EQ(given.size(), steps[i].commands);
    core::tick(*core, publish::inputs_of(steps[i], frames, given), core::kTick_s, *out);
    ASSERT_EQ(std::memcmp(&out->record, &records[i], sizeof records[i]), 0) << "step " << i << " from the image before step " << image.step;
    ASSERT_EQ(publish::digest_of(out->record), steps[i].record_digest);
  }
}

// A client that holds a version of an earlier run has not seen the values of this one.
TEST(ControlLoop, VersionsOfTwoRunsDoNotMeet_H27) {
  struct Start {
    std::uint64_t time_ns, utc_ns;
  };
  // The next start within the same time of the clock, the same moment after two boots, a wall clock that was set back, simulated time.
  constexpr std::uint64_t kTime_ns = 5'000'000'000, kUtc_ns = 1'790'000'000'000'000'000;
  std::vector<std::uint64_t> versions;
  for (const Start& start : {Start{1, 1}, Start{kTime_ns, kUtc_ns}, Start{kTime_ns + 1, kUtc_ns + 1}, Start{kTime_ns, kUtc_ns + 1},
                             Start{kTime_ns + 60'000'000'000, kUtc_ns}, Start{0, kUtc_ns}}) {
    std::string error;
    auto link = publish::CoreLink::create("", start.time_ns, start.utc_ns, error);
    ASSERT_NE(link, nullptr) << error;
    NoisyPort port;
    const auto loop = std::make_unique<ControlLoop>(port, *link, contract::Params{});
    contract::ParamsInForce params;
    ASSERT_NE(link->params(params), 0U);
    // 0 is no version, and none of a run may come back to it: records and commands have 32 bits.
    EXPECT_GT(params.version, 0U);
    EXPECT_LE(params.version, std::uint64_t{1} << 31U);
    versions.push_back(params.version);
  }
  std::ranges::sort(versions);
  for (std::size_t i = 1; i < versions.size(); ++i) EXPECT_GT(versions[i] - versions[i - 1], 10'000U) << "more than the changes of a run";
}

}  // namespace
}  // namespace hoist::run
