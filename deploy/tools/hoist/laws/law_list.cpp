#include "deploy/tools/hoist/laws/law_list.hpp"

#include <nlohmann/json.hpp>

namespace hoist::tool {

using nlohmann::json;

const Law* find_law(std::string_view name) {
  for (const auto group : {motion_laws(), tilt_laws(), metric_laws()}) {
    for (const auto& law : group) {
      if (law.name == name) return &law;
    }
  }
  return nullptr;
}

json compute_law(const Law& law, const json& line, const json& shared_params) {
  Fields in(line);
  json merged = shared_params;
  if (const json* own = in.raw("params"); own != nullptr && !own->is_null()) {
    if (!own->is_object()) throw Refusal("params: must be an object");
    merged.update(*own);
  }
  Fields params(merged, "params");
  // A whole golden case may be piped in: these fields of it are ignored.
  for (const char* description : {"id", "note", "tags"}) static_cast<void>(in.raw(description));
  json out = law.compute(in, params);
  in.refuse_unknown();
  params.refuse_unknown();
  return out;
}

}  // namespace hoist::tool
