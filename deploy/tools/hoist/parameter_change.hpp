// A parameter with another value, as it is written on the command line: NAME=VALUE.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "control/contract/params.hpp"

namespace hoist::tool {

using ParameterChange = std::pair<std::size_t, double>;  ///< index in contract::kParams, value

/// NAME=VALUE; the sentence of the refusal is empty when it was taken.
inline std::string parse_change(std::string_view text, std::vector<ParameterChange>& changes) {
  const std::size_t equals = text.find('=');
  const auto index = equals == std::string_view::npos ? std::nullopt : contract::find_param(text.substr(0, equals));
  if (!index) return "--set needs the name of a parameter and its value, not " + std::string(text);
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data() + equals + 1, end, value);
  const contract::ParamInfo& info = contract::kParams[*index];
  if (error != std::errc() || at != end || contract::check_param(*index, value) != contract::ParamCheck::ok) {
    char sentence[200];
    std::snprintf(sentence, sizeof sentence, "%s must be a number from %g to %g %s", std::string(info.name).c_str(), info.min, info.max,
                  std::string(info.unit).c_str());
    return sentence;
  }
  changes.emplace_back(*index, value);
  return {};
}

}  // namespace hoist::tool
