#include "db/advice/tuning_json.hpp"

#include <nlohmann/json.hpp>

namespace hoist::db {

using nlohmann::json;

json tuning_json(const TuningAdvice& advice) {
  json items = json::array();
  for (std::size_t i = 0; i < kTuningRules.size(); ++i) {
    const TuningRule& rule = kTuningRules[i];
    const Suggestion& suggestion = advice.suggestions[i];
    const bool given = suggestion.why == NoAdvice::none;
    const NoAdviceInfo& why = no_advice_info(suggestion.why);
    const auto number = [given](double value) { return given ? json(value) : json(nullptr); };
    items.push_back({{"name", contract::kParams[contract::param_index(rule.param)].name},
                     {"reason_code", given ? json(nullptr) : json(why.name)},
                     {"reason", given ? json(nullptr) : json{{"en", why.text_en}, {"de", why.text_de}}},
                     {"now", number(suggestion.now)},
                     {"suggested", number(suggestion.suggested)},
                     {"measured", number(suggestion.measured)},
                     {"measured_unit", rule.measured_unit},
                     {"measures", {{"en", rule.reason_en}, {"de", rule.reason_de}}},
                     {"formula", rule.formula},
                     {"effect", {{"en", rule.effect_en}, {"de", rule.effect_de}}},
                     {"effect_now", number(suggestion.effect_now)},
                     {"effect_then", number(suggestion.effect_then)}});
  }
  return {{"session", advice.session}, {"standing_s", advice.standing_s}, {"walking_s", advice.walking_s}, {"items", std::move(items)}};
}

}  // namespace hoist::db
