// The law, the whole tick, and shared memory, in nanoseconds.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <vector>

#include "control/bus/slcan.hpp"
#include "control/core/law/differential_drive.hpp"
#include "control/core/law/odometry.hpp"
#include "control/core/law/pelvis.hpp"
#include "control/core/law/pfp.hpp"
#include "control/core/law/pfp_turn.hpp"
#include "control/publish/core_link.hpp"
#include "control/publish/ring.hpp"
#include "control/publish/server_link.hpp"
#include "control/run/control_loop.hpp"
#include "tests/bench/bench.hpp"
#include "tests/support/closed_loop.hpp"

namespace hoist::bench {

double nanoseconds_per_call(const std::function<void(int)>& calls) {
  using Clock = std::chrono::steady_clock;
  int count = 64;
  const auto run = [&] {
    const auto start = Clock::now();
    calls(count);
    return std::chrono::duration<double, std::nano>(Clock::now() - start).count();
  };
  while (run() < 5e6) count *= 2;
  std::array<double, 15> rounds{};
  for (double& round : rounds) round = run() / count;
  std::nth_element(rounds.begin(), rounds.begin() + 7, rounds.end());
  return rounds[7];
}

namespace {
// Equations (1)-(3), Algorithms 1 and 2, mixing and odometry on inputs that change every step: the floor of the tick.
double bare_law_ns() {
  const law::PelvisGeometry<double> geometry{};
  const law::PelvisRange<double> range = law::full_range(geometry, 0.174532925);
  const law::PfpConfig<double> translation{};
  const law::PfpTurnConfig<double> rotation{};
  const law::OdometryConfig<double> odometry{1e-5, 1e-5, 0.7};
  law::PfpState<double> v{};
  law::PfpTurnState<double> w{};
  law::Pose<double> pose{};
  std::array<law::StrutAngles<double>, 256> struts;
  for (std::size_t i = 0; i < struts.size(); ++i) {
    const double phase = static_cast<double>(i) * 0.0245;
    struts[i] = {0.08 + 0.03 * std::sin(phase), 0.08 + 0.03 * std::cos(phase), 0.01 * std::sin(2 * phase), 0.01 * std::cos(2 * phase)};
  }
  std::size_t at = 0;
  return nanoseconds_per_call([&](int count) {
    for (int i = 0; i < count; ++i) {
      const law::Pelvis<double> pelvis = law::pelvis_exact(struts[at++ & 255U], geometry);
      const law::Intent<double> intent = law::normalise(pelvis, range, law::PelvisNeutral<double>{});
      law::pfp_step(translation, v, intent.u_norm, 0.01);
      law::pfp_turn_step(rotation, w, intent.u_psi_norm, 0.01);
      auto wheels = law::wheel_speeds(law::platform_speed(v.v_units, w.omega_units, law::SpeedScale<double>{}), 0.7);
      benchmark::DoNotOptimize(wheels);
      benchmark::DoNotOptimize(
          law::odometry_step(odometry, pose, static_cast<std::int32_t>(at & 1023U), static_cast<std::int32_t>(at & 511U)));
    }
    benchmark::DoNotOptimize(pose);
  });
}

// What the tick was given during a simulated walk.
struct Given {
  core::TickInputs inputs;
  std::vector<contract::CanFrame> frames;
  std::vector<contract::Command> commands;
};
std::vector<Given> recorded_walk() {
  tests::ClosedLoopOptions options;
  options.world.scenario = sim::find_scenario("figure-eight");
  tests::ClosedLoop loop(options);
  std::vector<Given> given;
  loop.on_inputs([&](const core::TickInputs& inputs) {
    given.push_back({inputs, {inputs.frames.begin(), inputs.frames.end()}, {inputs.commands.begin(), inputs.commands.end()}});
  });
  if (!loop.start(contract::Mode::user)) throw std::runtime_error("the walk did not start");
  loop.run(20.0);
  for (Given& step : given) {
    step.inputs.frames = step.frames;
    step.inputs.commands = step.commands;
  }
  return given;
}

// The tick on a recorded walk, without the world around it. The tick is pure, so the replay takes the very same branches.
class WalkReplay {
 public:
  void run(int count) {
    for (int i = 0; i < count; ++i) {
      if (at_ == given_.size()) {
        at_ = 0;
        *state_ = core::CoreState(contract::Params{});
      }
      core::tick(*state_, given_[at_++].inputs, core::kTick_s, *outputs_);
    }
  }

 private:
  std::vector<Given> given_ = recorded_walk();
  std::unique_ptr<core::CoreState> state_ = std::make_unique<core::CoreState>(contract::Params{});
  std::unique_ptr<core::TickOutputs> outputs_ = std::make_unique<core::TickOutputs>();
  std::size_t at_ = 0;
};

// A serial line in memory whose adapter accepts every line.
class LineInMemory final : public bus::SerialDevice {
 public:
  const char* open() noexcept override { return nullptr; }
  void close() noexcept override {}
  ssize_t read(std::span<char> text) noexcept override {
    const std::size_t answers = std::min(owed_, text.size());
    std::fill_n(text.begin(), answers, contract::kSlcanOk);
    owed_ -= answers;
    const std::size_t count = std::min(text.size() - answers, waiting_.size());
    std::copy_n(waiting_.begin(), count, text.begin() + static_cast<std::ptrdiff_t>(answers));
    waiting_.remove_prefix(count);
    if (answers + count > 0) return static_cast<ssize_t>(answers + count);
    errno = EAGAIN;
    return -1;
  }
  ssize_t write(std::span<const char> text) noexcept override {
    owed_ += static_cast<std::size_t>(std::count(text.begin(), text.end(), contract::kSlcanOk));
    return static_cast<ssize_t>(text.size());
  }
  void put(std::string_view text) { waiting_ = text; }

 private:
  std::string_view waiting_;
  std::size_t owed_ = 0;
};

// Whole steps of hoist-control on a recorded walk.
class StepReplay {
 public:
  StepReplay() {
    for (const Given& step : given_) {
      std::string text;
      std::array<char, contract::kSlcanLineMax> line{};
      for (const contract::CanFrame& frame : step.frames) text.append(line.data(), contract::slcan_encode(frame, line));
      text_.push_back(std::move(text));
    }
  }
  void run(int count) {
    std::unique_ptr<Life> life;
    for (int i = 0; i < count; ++i) {
      const std::size_t at = static_cast<std::size_t>(i) % given_.size();
      if (at == 0) life = std::make_unique<Life>(given_.front().inputs.time_ns);
      life->line->put(text_[at]);
      life->server.beat();
      for (contract::Command command : given_[at].commands) life->server.send(command);
      life->loop.step({.tick = given_[at].inputs.tick, .time_ns = given_[at].inputs.time_ns});
    }
    contract::TickRecord last;
    if (!life->server.newest(last) || last.mode != static_cast<std::uint8_t>(contract::Mode::user))
      throw std::runtime_error("the replayed steps do not walk");
  }

 private:
  struct Life {
    explicit Life(std::uint64_t time_ns) : link(linked(time_ns)), server("") {
      std::string error;
      if (!server.attach_directly(*link, error)) throw std::runtime_error(error);
      // Opens the adapter and takes its answers, so that the bus is up in the first step.
      std::array<contract::CanFrame, 1> none;
      for (int i = 0; i < 2; ++i) port.receive(none, time_ns);
    }
    static std::unique_ptr<publish::CoreLink> linked(std::uint64_t time_ns) {
      std::string error;
      auto link = publish::CoreLink::create("", time_ns, 0, error);
      return link != nullptr ? std::move(link) : throw std::runtime_error(error);
    }
    std::unique_ptr<publish::CoreLink> link;
    publish::ServerLink server;
    std::shared_ptr<LineInMemory> line = std::make_shared<LineInMemory>();
    bus::SlcanPort port{line};
    run::ControlLoop loop{port, *link, contract::Params{}};
  };
  std::vector<Given> given_ = recorded_walk();
  std::vector<std::string> text_;
};
}  // namespace

void replay_ticks(int count) { WalkReplay().run(count); }
void replay_steps(int count) { StepReplay().run(count); }

void measure_law_and_tick(Report& report) {
  WalkReplay replay;
  const double tick_ns = nanoseconds_per_call([&](int count) { replay.run(count); });
  const double law_ns = bare_law_ns();
  report.add({"law.law", "control law (eqs 1-3, algorithms 1 and 2, odometry)", law_ns, "ns", 0, ""});
  report.add({"law.tick", "whole tick, walking (estimate to safety gate)", tick_ns, "ns", law_ns, "bare law", {5.0}});
}

void measure_shared_memory(Report& report) {
  auto ring = std::make_unique<contract::SeqRing<contract::TickRecord, contract::kTickSlots>>();
  auto plain = std::make_unique<std::array<std::array<unsigned char, sizeof(contract::TickRecord)>, contract::kTickSlots>>();
  // The C library's routine: a direct call of known size becomes `rep movsq`, which is several times slower.
  void* (*volatile const copy)(void*, const void*, std::size_t) = std::memcpy;
  contract::TickRecord record{};
  std::uint64_t number = 0;
  const double copy_ns = nanoseconds_per_call([&](int count) {
    for (int i = 0; i < count; ++i) {
      record.tick = number++;
      copy((*plain)[number % contract::kTickSlots].data(), &record, sizeof record);
      benchmark::ClobberMemory();
    }
  });
  const double publish_ns = nanoseconds_per_call([&](int count) {
    for (int i = 0; i < count; ++i) {
      record.tick = number++;
      publish::ring_write(*ring, record);
      benchmark::ClobberMemory();
    }
  });
  contract::TickRecord out{};
  const double copy_out_ns = nanoseconds_per_call([&](int count) {
    for (int i = 0; i < count; ++i) {
      copy(&out, (*plain)[7].data(), sizeof out);
      benchmark::DoNotOptimize(out);
      benchmark::ClobberMemory();
    }
  });
  const double read_ns = nanoseconds_per_call([&](int count) {
    for (int i = 0; i < count; ++i) {
      benchmark::DoNotOptimize(publish::ring_newest(*ring, out));
      benchmark::DoNotOptimize(out);
      benchmark::ClobberMemory();
    }
  });
  const std::string size = std::to_string(sizeof(contract::TickRecord)) + " B";
  report.add({"memory.publish", "publish one record (" + size + ") into the ring", publish_ns, "ns", copy_ns, "memcpy", {1.6}});
  report.add({"memory.read", "read the newest record (" + size + ")", read_ns, "ns", copy_out_ns, "memcpy", {1.6}});
}

void measure_simulator(Report& report) {
  Row row{"simulator.speed", "whole closed loop, as a multiple of real time", 0, "x", 0, "", {2000, Better::higher}};
  row.value = tests::simulated_seconds_per_second(60.0);
  row.note = "core, nodes, bus, plant and patient on one core";
  report.add(row);
}

}  // namespace hoist::bench
