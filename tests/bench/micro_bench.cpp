// The law, the whole tick, and shared memory, in nanoseconds.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <vector>

#include "control/core/intent/pelvis.hpp"
#include "control/core/law/differential_drive.hpp"
#include "control/core/law/odometry.hpp"
#include "control/core/law/pfp.hpp"
#include "control/core/law/pfp_turn.hpp"
#include "control/publish/ring.hpp"
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
  const core::PelvisGeometry<double> geometry{};
  const core::PelvisRange<double> range = core::full_range(geometry, 0.174532925);
  const law::PfpConfig<double> translation{};
  const law::PfpTurnConfig<double> rotation{};
  const law::OdometryConfig<double> odometry{1e-5, 1e-5, 0.7};
  law::PfpState<double> v{};
  law::PfpTurnState<double> w{};
  law::Pose<double> pose{};
  std::array<core::StrutAngles<double>, 256> struts;
  for (std::size_t i = 0; i < struts.size(); ++i) {
    const double phase = static_cast<double>(i) * 0.0245;
    struts[i] = {0.08 + 0.03 * std::sin(phase), 0.08 + 0.03 * std::cos(phase), 0.01 * std::sin(2 * phase), 0.01 * std::cos(2 * phase)};
  }
  std::size_t at = 0;
  return nanoseconds_per_call([&](int count) {
    for (int i = 0; i < count; ++i) {
      const core::Pelvis<double> pelvis = core::pelvis_exact(struts[at++ & 255U], geometry);
      const core::Intent<double> intent = core::normalise(pelvis, range, core::PelvisNeutral<double>{});
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

// The tick on what it was given during a simulated walk, replayed without the world around it. The tick is pure, so the replay takes the
// very same branches.
class WalkReplay {
 public:
  WalkReplay() {
    options_.world.scenario = sim::find_scenario("figure-eight");
    tests::ClosedLoop loop(options_);
    loop.on_inputs([&](const core::TickInputs& inputs) {
      given_.push_back({inputs, {inputs.frames.begin(), inputs.frames.end()}, {inputs.commands.begin(), inputs.commands.end()}});
    });
    if (!loop.start(contract::Mode::user)) throw std::runtime_error("the walk did not start");
    loop.run(20.0);
    for (Given& step : given_) {
      step.inputs.frames = step.frames;
      step.inputs.commands = step.commands;
    }
    state_ = std::make_unique<core::CoreState>(options_.params);
  }
  void run(int count) {
    for (int i = 0; i < count; ++i) {
      if (at_ == given_.size()) {
        at_ = 0;
        *state_ = core::CoreState(options_.params);
      }
      core::tick(*state_, given_[at_++].inputs, core::kTick_s, *outputs_);
    }
  }

 private:
  struct Given {
    core::TickInputs inputs;
    std::vector<contract::CanFrame> frames;
    std::vector<contract::Command> commands;
  };
  tests::ClosedLoopOptions options_;
  std::vector<Given> given_;
  std::unique_ptr<core::CoreState> state_;
  std::unique_ptr<core::TickOutputs> outputs_ = std::make_unique<core::TickOutputs>();
  std::size_t at_ = 0;
};
}  // namespace

void replay_ticks(int count) { WalkReplay().run(count); }

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
