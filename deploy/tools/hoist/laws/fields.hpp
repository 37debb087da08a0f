// Reads named fields out of a JSON object and refuses by name fields that are missing, of the wrong type, out of range or unknown.
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace hoist::tool {

/// The sentence says which field and what is allowed.
struct Refusal : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What a number may be; always finite unless `infinite_ok`.
struct Range {
  double low{-std::numeric_limits<double>::infinity()};
  double high{std::numeric_limits<double>::infinity()};
  bool low_open{false};
  bool high_open{false};
  bool infinite_ok{false};
};

inline constexpr Range kAny{};
inline constexpr Range kPositive{.low = 0.0, .low_open = true};
inline constexpr Range kNotNegative{.low = 0.0};
inline constexpr Range kUnit{.low = -1.0, .high = 1.0};

class Fields {
 public:
  /// `object` must outlive this. Refuses when it is no object.
  explicit Fields(const nlohmann::json& object, std::string what = "the line");

  /// Present and not null.
  [[nodiscard]] bool has(const std::string& name);
  [[nodiscard]] double number(const std::string& name, const Range& range = kAny);
  [[nodiscard]] double number_or(const std::string& name, double fallback, const Range& range = kAny);
  [[nodiscard]] std::optional<double> optional_number(const std::string& name, const Range& range = kAny);
  [[nodiscard]] std::vector<double> numbers(const std::string& name, const Range& range = kAny);
  [[nodiscard]] std::int32_t integer(const std::string& name);
  [[nodiscard]] std::vector<std::int32_t> integers(const std::string& name);
  [[nodiscard]] std::string text(const std::string& name);
  [[nodiscard]] std::string text_or(const std::string& name, const std::string& fallback);
  [[nodiscard]] bool flag_or(const std::string& name, bool fallback);
  /// A table of numbers in which null is "missing".
  [[nodiscard]] std::vector<std::vector<std::optional<double>>> optional_table(const std::string& name);
  /// The field itself, or nullptr.
  [[nodiscard]] const nlohmann::json* raw(const std::string& name);

  /// Refuses unknown fields: a misspelt option must not be ignored.
  void refuse_unknown() const;

 private:
  const nlohmann::json& required(const std::string& name);

  const nlohmann::json& object_;
  std::set<std::string> asked_;
};

/// Refuses when the second column is not as long as the first.
void same_length(const std::string& name, std::size_t length, const std::string& other, std::size_t other_length);

/// A number for an answer: null for NaN, "inf" and "-inf" for infinities, so that every answer is JSON.
[[nodiscard]] nlohmann::json number_out(double value);

}  // namespace hoist::tool
