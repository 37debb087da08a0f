// What a client wishes, from the fields of a REST body or a hoist.v1 message that its schema allows (contract/fields.hpp).
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/record/recorder.hpp"
#include "server/state/exercise.hpp"

namespace hoist::server {

// Whom the lease is given to: a client, or the one of this account that asks for it or else came last.
struct HandOverWish {
  std::optional<std::uint32_t> client;
  std::optional<std::string> user;
};
struct CalibrateWish {
  std::string step;
  bool harness_empty = false;
};
struct MeasureWish {
  double figure = 0;
  std::optional<double> x_m, y_m;      // of a driven square, as `turning`
  std::optional<std::string> turning;  // left, right
};
using NumbersByName = std::vector<std::pair<std::string, double>>;

[[nodiscard]] HandOverWish hand_over_wish(const nlohmann::json& fields);
[[nodiscard]] CalibrateWish calibrate_wish(const nlohmann::json& fields);
[[nodiscard]] MeasureWish measure_wish(const nlohmann::json& fields);
[[nodiscard]] MarkerWish marker_wish(const nlohmann::json& fields);
[[nodiscard]] StartPose pose_wish(const nlohmann::json& fields);
[[nodiscard]] NumbersByName numbers_wish(const nlohmann::json& fields);
[[nodiscard]] std::optional<double> number_wish(const nlohmann::json& fields, const char* name);
// Of the parameters that were looked at, 0 = whichever are in force.
[[nodiscard]] std::uint32_t version_wish(const nlohmann::json& fields);
// A whole number that a JavaScript number may hold; large ones come as doubles.
[[nodiscard]] std::optional<std::uint64_t> whole_wish(const nlohmann::json& value);
// The newest step that the sender had seen (Asker::echo_time_ns), from any message; 0 = it does not say. What is no time counts as the oldest.
[[nodiscard]] std::uint64_t echo_wish(const nlohmann::json& fields);

}  // namespace hoist::server
