// What may be chosen of a report.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace hoist::db {

enum class Language : std::uint8_t { en, de };
[[nodiscard]] inline std::optional<Language> find_language(std::string_view name) {
  if (name == "en") return Language::en;
  return name == "de" ? std::optional(Language::de) : std::nullopt;
}

/// patient: one page in plain words. full: every figure with definition and gate, alarms, settings, origin.
enum class ReportKind : std::uint8_t { patient, full };
[[nodiscard]] inline std::optional<ReportKind> find_report_kind(std::string_view name) {
  if (name == "patient") return ReportKind::patient;
  return name == "full" ? std::optional(ReportKind::full) : std::nullopt;
}

struct ReportOptions {
  ReportKind kind = ReportKind::full;
  Language language = Language::en;
  std::string program;  ///< that makes it: version and commit
};

}  // namespace hoist::db
