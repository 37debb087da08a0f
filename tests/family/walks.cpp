#include "tests/family/walks.hpp"

#include <algorithm>
#include <cmath>

#include "control/contract/faults.hpp"
#include "control/contract/guided_path.hpp"

namespace hoist::family {

namespace {

using contract::Mode;

constexpr double kRolls_m_s = 0.02;
constexpr double kDrivenMost_m_s = 0.30;                                      // the default of remote_speed_m_s_max
constexpr double kDrivenLeast_m_s = 0.06;                                     // an exercise is not slower than 0.05
constexpr double kHeldLeast_s = 15.0, kHeldMost_s = 40.0, kReleased_s = 3.0;  // how a therapist holds (assumed)

loop::ClosedLoopOptions loop_options(const WalkOptions& options) {
  loop::ClosedLoopOptions loop;
  loop.params = options.params;
  loop.world.seed = options.seed;
  loop.world.scenario = sim::find_scenario("figure-eight");
  loop.world.patient = options.member->params;
  loop.world.patient.variation.seed = options.seed;
  return loop;
}

double driven_m_s(const WalkOptions& options) { return std::clamp(options.member->params.wish_m_s, kDrivenLeast_m_s, kDrivenMost_m_s); }

tool::study::Assumptions hand_of(const WalkOptions& options) {
  tool::study::Assumptions hand;
  hand.therapist_m_s = driven_m_s(options);
  return hand;
}

contract::GuidedPath eight(double speed_m_s) {
  const contract::Exercise usual = contract::usual_exercise(contract::ExerciseShape::eight);
  contract::GuidedPath path;
  static_cast<contract::SizedExercise&>(path) = usual;
  path.speed_m_s = speed_m_s;
  path.laps = 15;
  return path;
}

}  // namespace

void WalkTally::add(const WalkTally& other) {
  moving_s += other.moving_s;
  rolling_s += other.rolling_s;
  for (const auto& [cause, count] : other.unasked) unasked[cause] += count;
  frozen += other.frozen;
  refused += other.refused;
}

int WalkTally::unasked_all() const {
  int all = 0;
  for (const auto& [cause, count] : unasked) all += count;
  return all;
}

Walk::Walk(const WalkOptions& options)
    : options_(options),
      loop_(std::make_unique<loop::ClosedLoop>(loop_options(options))),
      therapist_(std::make_unique<tool::study::Therapist>(hand_of(options), loop_->world().patient().path(), options.seed)),
      hand_(options.seed ^ 0x48616E64ULL) {}

bool Walk::start() {
  const bool started = options_.mode == Mode::guided ? loop_->start_guided(eight(driven_m_s(options_))) : loop_->start(options_.mode);
  lets_go_s_ = loop_->time_s() + hand_.uniform(kHeldLeast_s, kHeldMost_s);
  holds_s_ = 0.0;
  events_at_start_ = loop_->events().size();
  return started;
}

void Walk::drive() {
  const double now_s = loop_->time_s();
  const tool::study::Therapist::Stick stick = therapist_->look(loop_->world().plant().platform());
  if (now_s >= lets_go_s_) {
    loop_->let_go();
    holds_s_ = now_s + kReleased_s;
    lets_go_s_ = holds_s_ + hand_.uniform(kHeldLeast_s, kHeldMost_s);
  }
  if (now_s < holds_s_) return;
  if (options_.mode == Mode::guided) return loop_->hold_stick(0.0, 0.0);
  const contract::Params& p = loop_->core().params;
  loop_->hold_stick(std::clamp(stick.speed_m_s / p.remote_speed_m_s_max, -1.0, 1.0),
                    std::clamp(stick.yaw_rate_rad_s / p.remote_yaw_rate_rad_s_max, -1.0, 1.0));
}

bool Walk::step() {
  if (contract::led_by_hand(options_.mode)) drive();
  loop_->step();
  if (loop_->world().patient().frozen()) froze_s_ = loop_->time_s();
  return loop_->mode() == options_.mode;
}

std::string Walk::cause() const {
  if (options_.mode == Mode::guided && loop_->record().guided_end == static_cast<std::uint8_t>(contract::GuidedEnd::finished)) return {};
  const auto& events = loop_->events();
  for (std::size_t i = events_at_start_; i < events.size(); ++i) {
    if (events[i].kind != contract::EventKind::fault_raised) continue;
    const contract::FaultInfo& fault = contract::fault_info(static_cast<contract::Fault>(events[i].code));
    if (fault.reaction != contract::Reaction::warn) return std::string(fault.name);
  }
  return "no fault";
}

WalkTally walk(const WalkOptions& options, const std::function<void(Walk&)>& see) {
  WalkTally tally;
  double left_s = options.length_s;
  for (std::uint64_t again = 0; left_s > 0.0; ++again) {
    WalkOptions mine = options;
    mine.seed = options.seed + again * 1'000'003;
    Walk one(mine);
    if (!one.start()) {
      ++tally.refused;
      left_s -= 10.0;
      continue;
    }
    bool goes_on = true;
    while (goes_on && left_s > 0.0) {
      goes_on = one.step();
      left_s -= core::kTick_s;
      tally.moving_s += core::kTick_s;
      if (std::fabs(one.loop().world().plant().platform().speed_m_s) > kRolls_m_s) tally.rolling_s += core::kTick_s;
      if (see) see(one);
    }
    if (goes_on) break;
    const std::string cause = one.cause();
    if (cause.empty()) continue;
    if (contract::led_by_hand(options.mode) && one.froze_lately())
      ++tally.frozen;
    else
      ++tally.unasked[cause];
  }
  return tally;
}

}  // namespace hoist::family
