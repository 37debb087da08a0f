#include "deploy/tools/hoist/study/virtual_run.hpp"

#include <algorithm>
#include <cmath>

#include "control/contract/params.hpp"
#include "deploy/tools/hoist/study/therapist.hpp"

namespace hoist::tool::study {

namespace {

using contract::CommandKind;
using contract::Mode;

/// A run that takes longer has failed.
constexpr double kLongest_s = 400.0;
/// Walked on behind the last lap, so that the recorded progress has reached it.
constexpr double kBeyond_m = 0.15;
constexpr double kStrut_m = 0.8;  // of the simulated machine

std::uint64_t mixed(std::uint64_t seed, std::uint64_t subject, std::uint64_t what) {
  return sim::Random(sim::Random(seed * 1000 + subject).next() ^ what).next();
}

double drawn(sim::Random& random, const Range& range) { return random.uniform(range[0], range[1]); }

// The person is the same in all runs; what was learnt, and the orthosis, differ.
sim::PatientParams person(const Protocol& protocol, const Run& run, int subject, int runs_done, std::uint64_t seed, double range_rad) {
  const auto number = static_cast<std::uint64_t>(subject);
  sim::PatientParams p = sim::PatientParams::random(mixed(seed, number, 1));
  sim::Random random(mixed(seed, number, 2));
  const Assumptions& assumed = protocol.assumed;
  p.wish_m_s = drawn(random, assumed.wish_m_s);
  p.anticipation_norm = drawn(random, assumed.anticipation_norm) + assumed.learning_norm * runs_done;
  p.trailing_s = assumed.trailing_s;
  p.lean_for(kStrut_m * std::tan(range_rad));
  if (run.injured) {
    p.limp_norm = assumed.limp_norm;
    for (double* sway : {&p.sway_forward_m, &p.sway_lateral_m, &p.sway_yaw_rad}) *sway *= assumed.injured_sway_norm;
  }
  return p;
}

class Runner {
 public:
  Runner(double laps, const Assumptions& assumed, const Run& run, const loop::ClosedLoopOptions& options, std::uint64_t therapist_seed)
      : laps_(laps),
        run_(run),
        remote_(options.params.remote_speed_m_s_max, options.params.remote_yaw_rate_rad_s_max),
        loop_(options),
        therapist_(assumed, loop_.world().patient().path(), therapist_seed) {}

  void go(VirtualRun& out) {
    const contract::ReferencePath path = loop_.world().patient().path();
    const contract::PathPose start = path.pose(0.0);
    if (!loop_.run_until([this] { return loop_.mode() == Mode::standby; }, 10.0)) return stop(out, "the hoist was not ready");
    loop_.ask(CommandKind::take_lease);
    loop_.step();
    loop_.ask(CommandKind::set_pose, 0, start.x_m, start.y_m, start.psi_rad);
    loop_.run(0.05);
    loop_.on_step([&out](const core::TickInputs&, const core::TickOutputs& outputs) { out.records.push_back(outputs.record); });
    const Mode mode = run_.by_patient ? Mode::user : Mode::remote;
    if (!loop_.start(mode)) return stop(out, "motion was refused");
    const double end_m = laps_ * path.length_m() + kBeyond_m;
    while (progress_m() < end_m && loop_.mode() == mode && static_cast<double>(out.records.size()) * core::kTick_s < kLongest_s) {
      if (!run_.by_patient) drive();
      loop_.step();
    }
    if (loop_.mode() != mode)
      stop(out, "the hoist stopped: " + std::string(contract::kModes[static_cast<std::size_t>(loop_.mode())].name));
    else if (progress_m() < end_m)
      stop(out, "not done within " + std::to_string(static_cast<int>(kLongest_s)) + " s");
    loop_.let_go();
    loop_.ask(CommandKind::request_mode, static_cast<std::uint32_t>(Mode::standby));
    loop_.run_until([this] { return loop_.mode() == Mode::standby; }, 5.0);
    loop_.run(0.5);
  }

 private:
  static void stop(VirtualRun& out, const std::string& why) { out.unfinished = why; }
  double progress_m() { return run_.by_patient ? loop_.world().patient().progress_m() : therapist_.progress_m(); }
  void drive() {
    const Therapist::Stick stick = therapist_.look(loop_.world().plant().platform());
    loop_.hold_stick(std::clamp(stick.speed_m_s / remote_.first, -1.0, 1.0), std::clamp(stick.yaw_rate_rad_s / remote_.second, -1.0, 1.0));
  }

  double laps_;
  Run run_;
  std::pair<double, double> remote_;
  loop::ClosedLoop loop_;
  Therapist therapist_;
};

VirtualRun begun(const contract::Params& params) {
  VirtualRun out;
  for (std::size_t i = 0; i < contract::kParams.size(); ++i) out.parameters.push_back(contract::get_param(params, i));
  return out;
}

}  // namespace

VirtualRun walk(const Protocol& protocol, const Run& run, int subject, int runs_done, std::uint64_t seed) {
  const auto number = static_cast<std::uint64_t>(subject), which = static_cast<std::uint64_t>(run.number);
  loop::ClosedLoopOptions options;
  for (const contract::PresetValue& value : contract::kPresetValues)
    if (value.preset == protocol.preset) contract::set_param_unchecked(options.params, contract::param_index(value.param), value.value);
  options.world.seed = mixed(seed, number, 100 + which);
  options.world.patient = person(protocol, run, subject, runs_done, seed, options.params.lean_range_rad);
  options.world.scenario = sim::find_scenario(run.shape == contract::ExerciseShape::square ? "square" : "figure-eight");
  VirtualRun out = begun(options.params);
  out.subject = subject;
  out.run = run.number;
  Runner(protocol.laps, protocol.assumed, run, options, mixed(seed, number, 200 + which)).go(out);
  return out;
}

VirtualRun walk_led(const loop::ClosedLoopOptions& options, double laps) {
  Run led;
  led.by_patient = true;
  VirtualRun out = begun(options.params);
  Runner(laps, {}, led, options, 0).go(out);
  return out;
}

std::vector<Run> order_of(const Protocol& protocol, int subject, std::uint64_t seed) {
  std::vector<Run> runs;
  for (const Run& run : protocol.runs)
    if (protocol.has(subject, run.number)) runs.push_back(run);
  if (!protocol.random_order) return runs;
  sim::Random random(mixed(seed, static_cast<std::uint64_t>(subject), 3));
  for (std::size_t left = runs.size(); left > 1; --left) std::swap(runs[left - 1], runs[random.next() % left]);
  return runs;
}

}  // namespace hoist::tool::study
