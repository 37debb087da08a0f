#include "tests/chaos/faults.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace hoist::chaos {
namespace {

using contract::Node;

constexpr std::array kTilts{Node::tilt_left, Node::tilt_right, Node::tilt_base};
constexpr std::array kDrives{Node::drive_left, Node::drive_right};
constexpr std::array kNodes{Node::drive_left, Node::drive_right, Node::io, Node::tilt_left, Node::tilt_right, Node::tilt_base};
constexpr std::array<std::string_view, 6> kNodeNames{"drive_left", "drive_right", "io", "tilt_left", "tilt_right", "tilt_base"};
constexpr std::uint64_t kPlanStream = 1, kLaterStream = 12, kPartStream = 13, kMomentStream = 21, kSlowStream = 23;
constexpr double kLaterShare = 0.4, kPartShare = 0.35, kMomentShare = 0.35, kSlowShare = 0.1;  // of the sessions
// Falls to the side are rare among all kinds, and each has its own angle to what the hoist does: some more, by a stream of their own.
constexpr std::uint64_t kFallStream = 16;
constexpr double kFallShare = 0.08;
// No motion before this.
constexpr double kFirst_s = 6.0;

// So that a plan means the same when it was written down and read again.
double rounded(double value) { return std::round(value * 1000.0) / 1000.0; }

Node target(const KindInfo& kind, int throw6) {
  switch (kind.target) {
    case Target::tilt:
      return kTilts[static_cast<std::size_t>(throw6 % 3)];
    case Target::strut:
      return kTilts[static_cast<std::size_t>(throw6 % 2)];
    case Target::drive:
      return kDrives[static_cast<std::size_t>(throw6 % 2)];
    case Target::any_node:
    case Target::nothing:
      break;
  }
  return kNodes[static_cast<std::size_t>(throw6)];
}

std::string_view cut(std::string_view& text, char end) {
  const std::size_t at = std::min(text.find(end), text.size());
  const std::string_view piece = text.substr(0, at);
  text.remove_prefix(std::min(at + 1, text.size()));
  return piece;
}

bool read_number(std::string_view text, double& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
}

Fault draw(Dice& dice, const std::vector<Kind>& kinds, double length_s) {
  Fault fault;
  const KindInfo& kind = info(kinds[static_cast<std::size_t>(dice.below(static_cast<int>(kinds.size())))]);
  fault.kind = kind.kind;
  fault.start_s = rounded(dice.between(kFirst_s, length_s - 5.0));
  const double length = dice.chance(0.5) ? dice.between(0.02, 1.0) : dice.between(1.0, 15.0);
  fault.end_s = rounded(fault.start_s + length);
  fault.size = rounded(dice.norm());
  fault.node = target(kind, dice.below(6));
  return fault;
}

// Within 30 degrees of either side.
Fault draw_fall(Dice& dice, double length_s) {
  Fault fault = draw(dice, {Kind::fall_aside}, length_s);
  fault.size = rounded((dice.chance(0.5) ? 0.75 : 0.25) + dice.between(-1.0, 1.0) / 12.0);
  return fault;
}

}  // namespace

std::vector<Fault> plan_faults(std::uint64_t seed, int most, double length_s, bool outside_only) {
  Dice dice(seed, kPlanStream), later_dice(seed, kLaterStream), part_dice(seed, kPartStream), moment_dice(seed, kMomentStream),
      slow_dice(seed, kSlowStream);
  std::vector<Kind> kinds, later, parts, moments, slow;
  for (const KindInfo& kind : kKinds) {
    if (outside_only && !kind.outside) continue;
    (kind.kind < kFirstLater    ? kinds
     : kind.kind < kFirstPart   ? later
     : kind.kind < kFirstMoment ? parts
     : kind.kind < kFirstSlow   ? moments
                                : slow)
        .push_back(kind.kind);
  }
  std::vector<Fault> faults;
  const int count = most <= 0 ? 0 : dice.below(most + 1);
  for (int i = 0; i < count; ++i) {
    const Fault fault = draw(dice, kinds, length_s);
    // Its torque can throw a wheel that was held for long (seed 905); until the plant's sliding is better, it only serves to find a masked monitor.
    if (fault.kind != Kind::skid) faults.push_back(fault);
  }
  if (most > 0 && !later.empty() && later_dice.chance(kLaterShare)) faults.push_back(draw(later_dice, later, length_s));
  if (most > 0 && !parts.empty() && part_dice.chance(kPartShare)) faults.push_back(draw(part_dice, parts, length_s));
  if (most > 0 && !moments.empty() && moment_dice.chance(kMomentShare)) {
    Fault fault = draw(moment_dice, moments, length_s);
    const double waits_s = moment_dice.between(0.0, 75.0);
    if (fault.kind != Kind::mute_core) fault.end_s = rounded(fault.end_s + waits_s);
    faults.push_back(fault);
  }
  if (most > 0 && !slow.empty() && slow_dice.chance(kSlowShare)) {
    Fault fault = draw(slow_dice, slow, length_s);
    fault.end_s = rounded(fault.end_s + slow_dice.between(5.0, 60.0));
    faults.push_back(fault);
  }
  if (Dice fall_dice(seed, kFallStream); most > 0 && !outside_only && fall_dice.chance(kFallShare))
    faults.push_back(draw_fall(fall_dice, length_s));
  return faults;
}

std::string faults_text(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults) {
    const KindInfo& kind = info(fault.kind);
    const std::string_view node = kind.target == Target::nothing ? std::string_view{} : kNodeNames[static_cast<std::size_t>(fault.node)];
    char line[120];
    std::snprintf(line, sizeof line, "%s%.*s:%.*s:%g:%g:%g", text.empty() ? "" : ",", static_cast<int>(kind.name.size()), kind.name.data(),
                  static_cast<int>(node.size()), node.data(), fault.start_s, fault.end_s, fault.size);
    text += line;
  }
  return text.empty() ? "-" : text;
}

std::optional<std::vector<Fault>> read_faults(std::string_view text) {
  std::vector<Fault> faults;
  if (text == "-") return faults;
  while (!text.empty()) {
    std::string_view row = cut(text, ',');
    const std::string_view name = cut(row, ':'), node = cut(row, ':'), start = cut(row, ':'), end = cut(row, ':');
    Fault fault;
    const auto kind = std::find_if(kKinds.begin(), kKinds.end(), [name](const KindInfo& k) { return k.name == name; });
    if (kind == kKinds.end() || !read_number(start, fault.start_s) || !read_number(end, fault.end_s) || !read_number(row, fault.size) ||
        fault.size < 0 || fault.size > 1)
      return std::nullopt;
    fault.kind = kind->kind;
    const auto named = std::find(kNodeNames.begin(), kNodeNames.end(), node);
    if (kind->target != Target::nothing && named == kNodeNames.end()) return std::nullopt;
    fault.node = named == kNodeNames.end() ? Node::io : static_cast<Node>(named - kNodeNames.begin());
    faults.push_back(fault);
  }
  return faults;
}

}  // namespace hoist::chaos
