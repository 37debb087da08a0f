#include "tests/chaos/judge/board.hpp"

#include <algorithm>

namespace hoist::chaos {

bool Board::now(Kind kind) const {
  return std::any_of(rows.begin(), rows.end(), [kind](const Planned& r) { return r.fault.kind == kind && r.on; });
}
bool Board::now(Kind kind, contract::Node node) const {
  return std::any_of(rows.begin(), rows.end(),
                     [kind, node](const Planned& r) { return r.fault.kind == kind && r.on && r.fault.node == node; });
}
bool Board::ever(Kind kind) const {
  return std::any_of(rows.begin(), rows.end(), [kind](const Planned& r) { return r.fault.kind == kind && (r.on || r.done); });
}
bool Board::any_yet() const {
  return std::any_of(rows.begin(), rows.end(), [](const Planned& r) { return r.on || r.done; });
}
bool Board::inside(double now_s, double quiet_s) const {
  return std::any_of(rows.begin(), rows.end(), [&](const Planned& r) {
    return !info(r.fault.kind).outside && (r.on || (r.done && now_s - r.fault.end_s < quiet_s));
  });
}
bool Board::any(double now_s, double quiet_s) const {
  return std::any_of(rows.begin(), rows.end(), [&](const Planned& r) { return r.on || (r.done && now_s - r.fault.end_s < quiet_s); });
}

}  // namespace hoist::chaos
