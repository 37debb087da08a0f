// One rehearsal on a simulated hoist: when it happens, and what the staff do about it, from the steps of the core and the rows of the audit log.
// Pure: time is that of the steps.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/signals.hpp"
#include "server/contract/rehearsals.hpp"

namespace hoist::server {

// Of one thing that was looked at.
enum class Seen : std::uint8_t { good, wrong, missing };
struct RehearsalItem {
  RehearsalCheck check{};
  double limit_s = 0;  // 0: none
  Seen seen = Seen::missing;
  std::optional<double> after_s;  // what was done, since what happened; of `look`: how long it was looked
  bool operator==(const RehearsalItem&) const = default;
};
struct RehearsalResult {
  RehearsalKind kind{};
  std::uint64_t seed = 0;
  double after_s = 0;  // of walking, when it happened
  std::vector<RehearsalItem> items;
  bool operator==(const RehearsalResult&) const = default;
};

// Begins the text of every marker with a result.
inline constexpr std::string_view kRehearsalMark = "Rehearsal, simulated hoist: ";
// A line of at most 500 bytes for a marker, and back; nothing for any other text.
[[nodiscard]] std::string rehearsal_text(const RehearsalResult& result);
[[nodiscard]] std::optional<RehearsalResult> read_rehearsal(std::string_view text);
[[nodiscard]] nlohmann::json rehearsal_json(const RehearsalResult& result);

class Rehearsal {
 public:
  // lost: no result, since the core ended.
  enum class Phase : std::uint8_t { waiting, happening, over, lost };
  // It happens so long after the patient began to walk, drawn by the seed.
  static constexpr double kEarliest_s = 8, kLatest_s = 25;
  // Then staff have this long at most.
  static constexpr double kLongest_s = 120;

  Rehearsal(RehearsalKind kind, std::uint64_t seed);

  // What is to be done now, once each.
  struct Due {
    bool happens = false, ends = false, over = false;
  };
  // Every step of the core, in order.
  Due take(const contract::TickRecord& record);
  // Staff did or tried this: name and result of the audit log (server/actions).
  void did(std::string_view action, std::string_view result);
  // Whether a person is in control.
  void lease(bool held);
  // The core has ended: another one counts other steps.
  void lose() { phase_ = Phase::lost; }

  [[nodiscard]] RehearsalKind kind() const { return kind_; }
  [[nodiscard]] Phase phase() const { return phase_; }
  [[nodiscard]] std::uint64_t seed() const { return seed_; }
  [[nodiscard]] RehearsalResult result() const;

 private:
  using Moment = std::optional<double>;  // since it happened
  [[nodiscard]] double since_s() const;
  [[nodiscard]] RehearsalItem item(const RehearsalLook& look) const;
  [[nodiscard]] bool settled() const;

  RehearsalKind kind_;
  std::uint64_t seed_;
  double delay_s_;
  Phase phase_ = Phase::waiting;
  double walked_s_ = 0;
  std::uint64_t now_ns_ = 0, happened_ns_ = 0;
  bool led_ = false, stopped_ = false, touches_ = false, ended_ = false, held_ = false, lost_ = false;
  bool too_early_ = false, moved_hand_over_ = false;
  Moment halted_s_, stop_s_, tried_s_, released_s_, zeroed_s_, started_s_, regained_s_, answered_s_;
};

}  // namespace hoist::server
