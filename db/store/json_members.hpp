// The members of a JSON object, each asked for by name; what is wrong first is kept as a sentence.
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace hoist::db {

/// Reads the members of one object and refuses the ones that nobody asked for. `where` goes before each name in `problem`.
class Members {
 public:
  Members(const nlohmann::json& value, std::string where, std::string& problem)
      : value_(value), where_(std::move(where)), problem_(problem) {
    if (!value_.is_object()) wrong("", "must be an object");
  }
  const nlohmann::json& member(const char* name) {
    static const nlohmann::json kNull;
    ++read_;
    const auto at = value_.is_object() ? value_.find(name) : value_.end();
    if (value_.is_object() && at == value_.end()) wrong(name, "is missing");
    return value_.is_object() && at != value_.end() ? *at : kNull;
  }
  std::string text(const char* name) {
    const nlohmann::json& value = member(name);
    if (!value.is_string() || value.get_ref<const std::string&>().empty()) wrong(name, "must be a text");
    return value.is_string() ? value.get<std::string>() : std::string{};
  }
  double number(const char* name, double least, double most) {
    const nlohmann::json& value = member(name);
    const double given = value.is_number() ? value.get<double>() : std::nan("");
    // Written so that a NaN fails.
    if (!(given >= least && given <= most))
      wrong(name, "must be a number from " + nlohmann::json(least).dump() + " to " + nlohmann::json(most).dump());
    return given;
  }
  /// `least` when there is no such number.
  std::uint32_t whole(const char* name, std::uint32_t least, std::uint32_t most) {
    const double given = number(name, least, most);
    const bool is_whole = given >= least && given <= most && given == std::floor(given);
    if (!is_whole) wrong(name, "must be a whole number from " + std::to_string(least) + " to " + std::to_string(most));
    return is_whole ? static_cast<std::uint32_t>(given) : least;
  }
  void words(const char* name) {
    Members both = inside(name);
    (void)both.text("en");
    (void)both.text("de");
    both.end();
  }
  /// The members of a member.
  Members inside(const char* name) { return {member(name), where_ + name + ".", problem_}; }
  void wrong(const std::string& name, const std::string& what) {
    if (problem_.empty()) problem_ = where_ + name + ' ' + what;
  }
  void end() {
    if (value_.is_object() && value_.size() != read_) wrong("", "has a member that is not known");
  }

 private:
  const nlohmann::json& value_;
  std::string where_;
  std::string& problem_;
  std::size_t read_ = 0;
};

}  // namespace hoist::db
