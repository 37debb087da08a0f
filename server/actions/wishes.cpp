#include "server/actions/wishes.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace hoist::server {

using nlohmann::json;

namespace {
template <typename Value>
std::optional<Value> read(const json& fields, const char* name) {
  const auto at = fields.find(name);
  return at == fields.end() || at->is_null() ? std::nullopt : std::optional{at->get<Value>()};
}
}  // namespace

std::optional<double> number_wish(const json& fields, const char* name) { return read<double>(fields, name); }
std::uint32_t version_wish(const json& fields) { return read<std::uint32_t>(fields, "version").value_or(0); }

std::optional<std::uint64_t> whole_wish(const json& value) {
  if (value.is_number_unsigned()) return value.get<std::uint64_t>();
  if (!value.is_number() || !(value.get<double>() >= 0 && value.get<double>() < 1.8e19)) return std::nullopt;
  return static_cast<std::uint64_t>(value.get<double>());
}
std::uint64_t echo_wish(const json& fields) {
  const auto at = fields.find("echo");
  return at == fields.end() || at->is_null() ? 0 : std::max<std::uint64_t>(whole_wish(*at).value_or(0), 1);
}

HandOverWish hand_over_wish(const json& fields) { return {read<std::uint32_t>(fields, "client"), read<std::string>(fields, "user")}; }

CalibrateWish calibrate_wish(const json& fields) {
  return {read<std::string>(fields, "step").value_or(""), read<bool>(fields, "harness_empty").value_or(false)};
}

MeasureWish measure_wish(const json& fields) {
  return {number_wish(fields, "figure").value_or(0), number_wish(fields, "x_m"), number_wish(fields, "y_m"),
          read<std::string>(fields, "turning")};
}

MarkerWish marker_wish(const json& fields) {
  return {read<std::string>(fields, "text").value_or(""),
          read<std::string>(fields, "kind").value_or(std::string(db::kMarkerKinds.front()))};
}

StartPose pose_wish(const json& fields) {
  return {number_wish(fields, "x_m").value_or(0), number_wish(fields, "y_m").value_or(0), number_wish(fields, "psi_rad").value_or(0)};
}

NumbersByName numbers_wish(const json& fields) {
  NumbersByName numbers;
  for (const auto& [name, value] : fields.items()) numbers.emplace_back(name, value.get<double>());
  return numbers;
}

}  // namespace hoist::server
