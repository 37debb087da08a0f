#include "server/state/rehearsal.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <random>

#include "control/contract/faults.hpp"

namespace hoist::server {

using contract::Mode;
using nlohmann::json;

namespace {
// A gap between two steps counts as no more walking than this.
constexpr double kGap_s = 0.1;
// What follows the last thing done still belongs to it.
constexpr double kSettle_s = 2;
constexpr std::array<std::string_view, 3> kSeenNames{"good", "wrong", "missing"};

double drawn_s(std::uint64_t seed) {
  // Not a distribution of the library: those differ between libraries.
  const double share = static_cast<double>(std::mt19937_64(seed)() >> 11U) * 0x1.0p-53;
  return Rehearsal::kEarliest_s + share * (Rehearsal::kLatest_s - Rehearsal::kEarliest_s);
}

std::string tenths(double seconds) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f s", seconds);
  return text.data();
}

// Takes a prefix off; false, and nothing taken, when it is not there.
bool take(std::string_view& text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}
template <typename Number>
std::optional<Number> take_number(std::string_view& text) {
  Number value{};
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{}) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}
std::string_view take_word(std::string_view& text) {
  const std::size_t end = text.find_first_not_of("abcdefghijklmnopqrstuvwxyz_");
  const std::string_view word = text.substr(0, end);
  text.remove_prefix(word.size());
  return word;
}
}  // namespace

std::string rehearsal_text(const RehearsalResult& result) {
  std::string text = std::string(kRehearsalMark) + std::string(rehearsal_info(result.kind).name) + ", seed " + std::to_string(result.seed) +
                     ", after " + tenths(result.after_s);
  for (const RehearsalItem& item : result.items) {
    text += "; " + std::string(rehearsal_check_name(item.check)) + " " + std::string(kSeenNames[static_cast<std::size_t>(item.seen)]);
    if (item.after_s) text += " " + tenths(*item.after_s);
  }
  return text;
}

std::optional<RehearsalResult> read_rehearsal(std::string_view text) {
  RehearsalResult result;
  if (!take(text, kRehearsalMark)) return std::nullopt;
  const auto kind = find_rehearsal(take_word(text));
  if (!kind || !take(text, ", seed ")) return std::nullopt;
  const auto seed = take_number<std::uint64_t>(text);
  if (!seed || !take(text, ", after ")) return std::nullopt;
  const auto after_s = take_number<double>(text);
  if (!after_s || !take(text, " s")) return std::nullopt;
  result = {.kind = *kind, .seed = *seed, .after_s = *after_s, .items = {}};
  for (const RehearsalLook& look : kRehearsalLooks) {
    if (look.rehearsal != *kind) continue;
    if (!take(text, "; ") || take_word(text) != rehearsal_check_name(look.check) || !take(text, " ")) return std::nullopt;
    const auto* seen = std::ranges::find(kSeenNames, take_word(text));
    if (seen == kSeenNames.end()) return std::nullopt;
    RehearsalItem item{look.check, look.limit_s, static_cast<Seen>(seen - kSeenNames.begin()), std::nullopt};
    if (take(text, " ")) {
      item.after_s = take_number<double>(text);
      if (!item.after_s || !take(text, " s")) return std::nullopt;
    }
    result.items.push_back(item);
  }
  return text.empty() ? std::optional(result) : std::nullopt;
}

json rehearsal_json(const RehearsalResult& result) {
  json items = json::array();
  for (const RehearsalItem& item : result.items)
    items.push_back({{"check", rehearsal_check_name(item.check)},
                     {"limit_s", item.limit_s > 0 ? json(item.limit_s) : json(nullptr)},
                     {"seen", kSeenNames[static_cast<std::size_t>(item.seen)]},
                     {"after_s", item.after_s ? json(*item.after_s) : json(nullptr)}});
  return {{"rehearsal", rehearsal_info(result.kind).name}, {"seed", result.seed}, {"after_s", result.after_s}, {"items", std::move(items)}};
}

Rehearsal::Rehearsal(RehearsalKind kind, std::uint64_t seed) : kind_(kind), seed_(seed), delay_s_(drawn_s(seed)) {}

double Rehearsal::since_s() const { return static_cast<double>(now_ns_ - happened_ns_) * 1e-9; }

Rehearsal::Due Rehearsal::take(const contract::TickRecord& record) {
  Due due;
  const double step_s = now_ns_ == 0 || record.time_ns <= now_ns_ ? 0 : static_cast<double>(record.time_ns - now_ns_) * 1e-9;
  now_ns_ = std::max(now_ns_, record.time_ns);
  const auto mode = static_cast<Mode>(record.mode);
  led_ = record.mode < contract::kModes.size() && contract::kModes[record.mode].moving;
  stopped_ = mode == Mode::protective_stop;
  touches_ = record.bumpers != 0;
  if (phase_ == Phase::waiting) {
    if (mode == Mode::user && record.standing_still == 0) walked_s_ += std::min(step_s, kGap_s);
    if (walked_s_ < delay_s_) return due;
    phase_ = Phase::happening;
    happened_ns_ = now_ns_;
    due.happens = true;
    return due;
  }
  if (phase_ != Phase::happening) return due;
  if (!led_ && !halted_s_) halted_s_ = since_s();
  const RehearsalInfo& info = rehearsal_info(kind_);
  if (!ended_ && info.ends_after_s > 0 && since_s() >= info.ends_after_s) ended_ = due.ends = true;
  if (since_s() < kLongest_s && !settled()) return due;
  phase_ = Phase::over;
  due.over = true;
  if (!ended_) ended_ = due.ends = true;
  return due;
}

void Rehearsal::did(std::string_view action, std::string_view result) {
  if (phase_ != Phase::happening) return;
  const bool done = result == "done";
  const auto once = [this](Moment& moment) {
    if (!moment) moment = since_s();
  };
  if (done && (action == "stop" || action == "end_motion")) once(stop_s_);
  if (action == "acknowledge" && (done || stopped_) && !released_s_) {
    once(tried_s_);
    // The core lets a hoist go that a bumper touches, since only driving may clear it.
    too_early_ = too_early_ || touches_ || result == "cause_not_cleared" || result == "moving";
    if (done) once(released_s_);
  }
  if (done && action == "set_neutral" && released_s_) once(zeroed_s_);
  if (done && action == "start_motion" && halted_s_) once(started_s_);
  if (done && (action == "keep_lease" || action == "hand_over")) once(answered_s_);
  if (action == "hand_over" && led_) moved_hand_over_ = true;
}

void Rehearsal::lease(bool held) {
  held_ = held;
  if (phase_ != Phase::happening) return;
  lost_ = lost_ || !held;
  if (held && lost_ && !regained_s_) regained_s_ = since_s();
}

RehearsalItem Rehearsal::item(const RehearsalLook& look) const {
  RehearsalItem out{look.check, look.limit_s, Seen::missing, std::nullopt};
  const auto tell = [&out](const Moment& moment, bool good) {
    out.after_s = moment;
    if (moment) out.seen = good ? Seen::good : Seen::wrong;
  };
  const auto in_time = [&](const Moment& moment) { tell(moment, moment && *moment <= look.limit_s); };
  switch (look.check) {
    case RehearsalCheck::stop:
    case RehearsalCheck::end:
      in_time(stop_s_);
      break;
    case RehearsalCheck::look:
      if (tried_s_)
        tell(std::max(0.0, *tried_s_ - halted_s_.value_or(*tried_s_)), *tried_s_ - halted_s_.value_or(*tried_s_) >= look.limit_s);
      break;
    case RehearsalCheck::cause_gone:
      tell(tried_s_, !too_early_);
      break;
    case RehearsalCheck::acknowledge:
      in_time(released_s_);
      break;
    case RehearsalCheck::zero:
      tell(zeroed_s_, !started_s_ || (zeroed_s_ && *zeroed_s_ < *started_s_));
      break;
    case RehearsalCheck::go_on:
      in_time(started_s_);
      break;
    case RehearsalCheck::regain:
      in_time(regained_s_);
      break;
    case RehearsalCheck::stay_ended:
      if (stop_s_) out.seen = started_s_ ? Seen::wrong : Seen::good;
      out.after_s = started_s_;
      break;
    case RehearsalCheck::answer:
      in_time(answered_s_);
      break;
    case RehearsalCheck::standing:
      if (answered_s_ || moved_hand_over_) out.seen = moved_hand_over_ ? Seen::wrong : Seen::good;
      break;
  }
  return out;
}

// Nothing more can change.
bool Rehearsal::settled() const {
  double last_s = 0;
  const auto came = [&last_s](const Moment& moment) {
    if (moment) last_s = std::max(last_s, *moment);
    return moment.has_value();
  };
  for (const RehearsalLook& look : kRehearsalLooks) {
    if (look.rehearsal != kind_) continue;
    switch (look.check) {
      case RehearsalCheck::regain:
        if (!came(regained_s_) || !ended_) return false;
        break;
      case RehearsalCheck::answer:
      case RehearsalCheck::standing:
        if (!came(answered_s_)) return false;
        break;
      case RehearsalCheck::stay_ended:
        if (!came(started_s_) && (!came(stop_s_) || since_s() < *stop_s_ + look.limit_s)) return false;
        break;
      case RehearsalCheck::end:
        if (!came(stop_s_)) return false;
        break;
      default:
        // What was left out before the walk went on stays left out.
        if (!came(started_s_)) return false;
        break;
    }
  }
  return since_s() >= last_s + kSettle_s;
}

RehearsalResult Rehearsal::result() const {
  // As its text tells it: what is read back later is the same.
  const auto rounded = [](double seconds) { return std::round(seconds * 10) / 10; };
  RehearsalResult out{.kind = kind_, .seed = seed_, .after_s = rounded(delay_s_), .items = {}};
  for (const RehearsalLook& look : kRehearsalLooks) {
    if (look.rehearsal != kind_) continue;
    out.items.push_back(item(look));
    if (auto& after_s = out.items.back().after_s) after_s = rounded(*after_s);
  }
  return out;
}

}  // namespace hoist::server
