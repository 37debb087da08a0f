// The rows of rehearsals.def.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace hoist::server {

enum class RehearsalKind : std::uint8_t {
#define HOIST_REHEARSAL(name, happens, ends, ends_after_s) name,
#define HOIST_REHEARSAL_CHECK(name, doc)
#define HOIST_REHEARSAL_LOOKS(rehearsal, check, limit_s)
#include "server/contract/rehearsals.def"
#undef HOIST_REHEARSAL
#undef HOIST_REHEARSAL_CHECK
};
enum class RehearsalCheck : std::uint8_t {
#define HOIST_REHEARSAL(name, happens, ends, ends_after_s)
#define HOIST_REHEARSAL_CHECK(name, doc) name,
#include "server/contract/rehearsals.def"
#undef HOIST_REHEARSAL
#undef HOIST_REHEARSAL_CHECK
#undef HOIST_REHEARSAL_LOOKS
};

struct RehearsalInfo {
  std::string_view name, happens, ends;
  double ends_after_s;
};
struct RehearsalCheckInfo {
  std::string_view name, doc;
};
struct RehearsalLook {
  RehearsalKind rehearsal;
  RehearsalCheck check;
  double limit_s;
};

#define HOIST_REHEARSAL_CHECK(name, doc)
#define HOIST_REHEARSAL_LOOKS(rehearsal, check, limit_s)
inline constexpr std::array kRehearsals{
#define HOIST_REHEARSAL(name, happens, ends, ends_after_s) RehearsalInfo{#name, happens, ends, ends_after_s},
#include "server/contract/rehearsals.def"
#undef HOIST_REHEARSAL
};
#undef HOIST_REHEARSAL_CHECK
#undef HOIST_REHEARSAL_LOOKS
#define HOIST_REHEARSAL(name, happens, ends, ends_after_s)
#define HOIST_REHEARSAL_LOOKS(rehearsal, check, limit_s)
inline constexpr std::array kRehearsalChecks{
#define HOIST_REHEARSAL_CHECK(name, doc) RehearsalCheckInfo{#name, doc},
#include "server/contract/rehearsals.def"
#undef HOIST_REHEARSAL_CHECK
};
#undef HOIST_REHEARSAL_LOOKS
#define HOIST_REHEARSAL_CHECK(name, doc)
inline constexpr std::array kRehearsalLooks{
#define HOIST_REHEARSAL_LOOKS(rehearsal, check, limit_s) RehearsalLook{RehearsalKind::rehearsal, RehearsalCheck::check, limit_s},
#include "server/contract/rehearsals.def"
#undef HOIST_REHEARSAL_LOOKS
};
#undef HOIST_REHEARSAL
#undef HOIST_REHEARSAL_CHECK

constexpr const RehearsalInfo& rehearsal_info(RehearsalKind kind) { return kRehearsals[static_cast<std::size_t>(kind)]; }
constexpr std::string_view rehearsal_check_name(RehearsalCheck check) { return kRehearsalChecks[static_cast<std::size_t>(check)].name; }
constexpr std::optional<RehearsalKind> find_rehearsal(std::string_view name) {
  for (std::size_t i = 0; i < kRehearsals.size(); ++i)
    if (kRehearsals[i].name == name) return static_cast<RehearsalKind>(i);
  return std::nullopt;
}

}  // namespace hoist::server
