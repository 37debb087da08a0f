#include "db/metrics/lead.hpp"

#include <algorithm>
#include <cmath>

#include "db/metrics/comparison.hpp"

namespace hoist::db {

namespace {
bool led(const WalkSample& sample) { return sample.mode == contract::Mode::user; }
}  // namespace

void StartsAndStops::Return::add(bool sample_led, bool inside, double step_m) {
  if (!sample_led || !inside) {
    // It may begin after this sample, which must be led.
    whole = !sample_led;
    samples = 0;
    way_m = 0;
    return;
  }
  ++samples;
  way_m += step_m;
}

// From the lean's leaving the dead band; nothing when the patient did not stand before, or leant already when the lead began.
void StartsAndStops::begin_bout(const WalkSample& sample) {
  constexpr auto kRest = samples_in(kRest_s);
  latency_s_.reset();
  in_bout_ = 0;
  returns_ = {};
  const bool stood = samples_ > kRest && led_ > kRest && slow_ >= kRest;
  if (stood && beyond_ > 0 && led(sample) && beyond_ < samples_ && led_ > beyond_)
    latency_s_ = static_cast<double>(beyond_ - 1) * kSample_s;
}

void StartsAndStops::end_bout() {
  if (in_bout_ >= samples_in(kBout_s)) {
    const bool forward = !(speed_m_s_ < 0);
    stops_.push_back({forward ? 1.0 : -1.0, returns_[forward ? 1 : 0]});
  }
  in_bout_ = 0;
}

void StartsAndStops::add(const WalkSample& sample, Lead& out) {
  if (!tick_ || sample.tick != *tick_ + 1) end(out);
  tick_ = sample.tick;
  const bool now_led = led(sample), beyond = std::fabs(sample.lean_norm) > settings_.lean_dead_band_norm;
  ++samples_;
  led_ = now_led ? led_ + 1 : 0;
  beyond_ = now_led && beyond ? beyond_ + 1 : 0;
  const std::optional<std::size_t> place = run_.add(sample);
  if (!place || *place == 0) end_bout();
  // Until the hoist rests: what comes then is no part of the stop.
  const bool rests = std::fabs(sample.speed_m_s) <= kStopped_m_s, step = !rests && now_led;
  const double step_m = std::fabs(sample.speed_m_s) * kSample_s;
  for (Stop& stop : stops_) {
    if (step)
      stop.back.add(now_led, stop.way * sample.lean_norm <= settings_.lean_dead_band_norm, step_m);
    else if (now_led && !stop.back.whole && stop.back.samples > 0)
      out.stopping_m.add(stop.back.way_m);
  }
  if (!step) stops_.clear();
  if (place) {
    if (*place == 0) begin_bout(sample);
    ++in_bout_;
    if (in_bout_ == samples_in(kBout_s) && latency_s_) out.latency_s.add(*latency_s_);
    for (const std::size_t forward : {0U, 1U})
      returns_[forward].add(now_led, (forward == 1 ? 1.0 : -1.0) * sample.lean_norm <= settings_.lean_dead_band_norm, step_m);
    speed_m_s_ = sample.speed_m_s;
  }
  slow_ = std::fabs(sample.speed_m_s) <= kBout_m_s ? slow_ + 1 : 0;
}

void StartsAndStops::end(Lead&) {
  samples_ = led_ = slow_ = beyond_ = in_bout_ = 0;
  stops_.clear();
}

void BalanceJudge::add(const WalkSample& sample) {
  if (!tick_ || sample.tick != *tick_ + 1) place_ = 0;
  tick_ = sample.tick;
  const double tilt_rad = std::asin(std::min(1.0, std::hypot(sample.dx_m, sample.dy_m) / settings_.strut_length_m));
  tilt_rad_[place_ % tilt_rad_.size()] = tilt_rad;
  const std::size_t place = place_++;
  if (place < kOver) return;
  const double rate_rad_s = (tilt_rad - tilt_rad_[(place - kOver) % tilt_rad_.size()]) / kBalanceOver_s;
  switch (pass_) {
    case Pass::median:
      return median_.add(rate_rad_s);
    case Pass::deviation:
      return deviation_.add(std::fabs(rate_rad_s - median_.value()));
    case Pass::events:
      if (tilt_rad <= kBalanceShare_norm * settings_.lean_range_rad || rate_rad_s <= limit_rad_s_) return;
      if (!latest_ || sample.tick - *latest_ >= samples_in(kBalanceApart_s)) ++events_;
      latest_ = sample.tick;
      return;
    case Pass::over:
      return;
  }
}

bool BalanceJudge::again() {
  tick_.reset();
  switch (pass_) {
    case Pass::median:
      if (median_.again()) return true;
      if (static_cast<double>(median_.count()) * kSample_s < kBalanceLeast_s)
        pass_ = Pass::over;
      else
        pass_ = Pass::deviation;
      break;
    case Pass::deviation:
      if (deviation_.again()) return true;
      limit_rad_s_ = median_.value() + kBalanceDeviations * 1.4826 * deviation_.value();
      pass_ = Pass::events;
      break;
    case Pass::events:
    case Pass::over:
      pass_ = Pass::over;
      break;
  }
  return pass_ != Pass::over;
}

LeadJudge::LeadJudge(const std::optional<WalkSettings>& settings) : settings_(settings) {
  if (!settings) return;
  starts_.emplace(*settings);
  balance_.emplace(*settings);
}

void LeadJudge::add(const WalkSample& sample) {
  if (!settings_) return;
  balance_->add(sample);
  if (!first_) return;
  starts_->add(sample, out_);
  if (!led(sample)) return;
  ++led_;
  inside_ += std::fabs(sample.lean_norm) > settings_->lean_dead_band_norm ? 0 : 1;
  lean_s_ += std::fabs(sample.lean_norm) * kSample_s;
  way_m_ += std::fabs(sample.speed_m_s) * kSample_s;
}

bool LeadJudge::again() {
  first_ = false;
  return balance_ && balance_->again();
}

Lead LeadJudge::result(const Walk& walk) const {
  Lead out = out_;
  if (walk.samples == 0) return {};
  if (!walk.has_lean || !walk.has_sway || !settings_)
    out.why = NoFigure::not_recorded;
  else
    out.why = walk.settings_changed ? NoFigure::settings_changed : NoFigure::none;
  out.why_no_balance = out.why;
  if (out.why != NoFigure::none) return out;
  out.balance_events = balance_->events();
  if (static_cast<double>(balance_->rates()) * kSample_s < kBalanceLeast_s) out.why_no_balance = NoFigure::too_short;
  if (missing_s(walk) > kMissingMost_s) out.why_no_balance = NoFigure::part_missing;
  if (led_ == 0) {
    out.why = NoFigure::not_led;
    return out;
  }
  out.dead_band_norm = static_cast<double>(inside_) / static_cast<double>(led_);
  if (way_m_ >= kLedLeast_m) out.effort_s_m = lean_s_ / way_m_;
  return out;
}

}  // namespace hoist::db
