#include "server/text/field_error.hpp"

#include <nlohmann/json.hpp>
#include <utility>

namespace hoist::server {

nlohmann::json to_json(const std::vector<FieldError>& errors) {
  nlohmann::json list = nlohmann::json::array();
  for (const FieldError& e : errors) {
    nlohmann::json row{{"field", e.field}, {"message", e.message}};
    if (e.value) row["value"] = *e.value;
    if (e.min) row["min"] = *e.min;
    if (e.max) row["max"] = *e.max;
    list.push_back(std::move(row));
  }
  return list;
}

}  // namespace hoist::server
