// The kinds of rows of the audit log (audit.def), and which routes are logged.
#pragma once
#include <algorithm>
#include <array>
#include <string_view>

#include "control/contract/check.hpp"
#include "server/contract/routes.hpp"

namespace hoist::server {

struct AuditKind {
  std::string_view name;
  std::string_view done_en, tried_en, done_de, tried_de;
};
inline constexpr std::array kAuditKinds{
#define HOIST_AUDIT(name, done_en, tried_en, done_de, tried_de) AuditKind{#name, done_en, tried_en, done_de, tried_de},
#include "server/contract/audit.def"
#undef HOIST_AUDIT
};
static_assert(contract::unique_by(kAuditKinds, [](const AuditKind& kind) { return kind.name; }), "audit.def: a kind is named twice");

constexpr bool is_audit_kind(std::string_view name) {
  for (const AuditKind& kind : kAuditKinds)
    if (kind.name == name) return true;
  return false;
}

// The name of a kind, checked when it is compiled.
struct AuditName {
  std::string_view text;
  consteval AuditName(const char* name) : text(name) {  // NOLINT(google-explicit-constructor): a name is written as a text
    if (!is_audit_kind(text)) throw "audit.def has no such kind";
  }
};

// What people change beside actions, which write their rows themselves, what was refused before it became one, and what leaves the hoist.
constexpr bool is_download(const Route& route) {
  constexpr std::array<std::string_view, 5> kDownloads{"export_session", "export_mcap", "get_job_file", "get_session_report",
                                                       "get_visit_report"};
  return std::ranges::find(kDownloads, route.operation) != kDownloads.end();
}
constexpr bool is_audited(const Route& route) {
  return (route.method != Method::get && route.operation != "open_ticket") || is_download(route);
}
static_assert(contract::all_rows(kRoutes, [](const Route& route) { return !is_audited(route) || is_audit_kind(route.operation); }),
              "audit.def: a route that is logged has no words");

}  // namespace hoist::server
