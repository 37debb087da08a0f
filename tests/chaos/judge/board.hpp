// Active and past faults of a session's plan.
#pragma once
#include <vector>

#include "control/contract/can_dictionary.hpp"
#include "tests/chaos/faults.hpp"

namespace hoist::chaos {

struct Planned {
  Fault fault;
  bool on = false, done = false;
};

class Board {
 public:
  explicit Board(const std::vector<Fault>& faults) {
    for (const Fault& fault : faults) rows.push_back({fault});
  }
  [[nodiscard]] bool now(Kind kind) const;
  [[nodiscard]] bool now(Kind kind, contract::Node node) const;
  [[nodiscard]] bool ever(Kind kind) const;
  /// The bridge of this drive is shorted, alone or with the other one.
  [[nodiscard]] bool shorted(contract::Node drive) const { return now(Kind::bridge_shorted, drive) || now(Kind::bridges_shorted); }
  [[nodiscard]] bool any_yet() const;
  /// A fault that may affect a walking patient (not server, network, disk, clock) is active, or ended less than `quiet_s` ago; of the latter
  /// only with `lasting` those whose effect outlives them.
  [[nodiscard]] bool inside(double now_s, double quiet_s) const;
  [[nodiscard]] bool any(double now_s, double quiet_s) const;
  std::vector<Planned> rows;
};

}  // namespace hoist::chaos
