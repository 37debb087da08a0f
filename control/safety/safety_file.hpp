// Typed view of the tables of this folder, for the generated page and its checks. No program of the hoist includes it.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

#include "control/contract/check.hpp"
#include "control/contract/hazards.hpp"

namespace hoist::safety {

enum class Severity : std::uint8_t { minor = 1, serious, critical, catastrophic };
enum class Probability : std::uint8_t { improbable = 1, remote, occasional, probable, frequent };
inline constexpr std::array<std::string_view, 4> kSeverityNames{"minor", "serious", "critical", "catastrophic"};
inline constexpr std::array<std::string_view, 5> kProbabilityNames{"improbable", "remote", "occasional", "probable", "frequent"};

/// Whether a risk may be left: acceptable, to be reduced as far as possible, or not at all (ISO 14971, 4.2: criteria of this file).
enum class Verdict : std::uint8_t { acceptable, reduce, unacceptable };
inline constexpr std::array<std::string_view, 3> kVerdictNames{"acceptable", "reduced as far as known", "unacceptable"};
constexpr Verdict verdict(Severity severity, Probability probability) {
  const int sum = static_cast<int>(severity) + static_cast<int>(probability);
  return sum <= 4 ? Verdict::acceptable : sum == 5 ? Verdict::reduce : Verdict::unacceptable;
}

struct Risk {
  int hazard;
  std::string_view harm;
  Severity severity;
  Probability before, after;
  std::string_view residual;
};
inline constexpr std::array kRisks{
#define HOIST_RISK(hazard, harm, severity, before, after, residual) \
  Risk{hazard, harm, Severity::severity, Probability::before, Probability::after, residual},
#include "control/safety/risks.def"
#undef HOIST_RISK
};

struct SafetyTest {
  int hazard;
  std::string_view program, test;
};
inline constexpr std::array kSafetyTests{
#define HOIST_SAFETY_TEST(hazard, program, test) SafetyTest{hazard, program, test},
#include "control/safety/tests.def"
#undef HOIST_SAFETY_TEST
};

struct Part {
  std::string_view folder;
  char software_class;
  std::string_view why;
};
inline constexpr std::array kParts{
#define HOIST_PART(folder, software_class, why) Part{folder, (#software_class)[0], why},
#include "control/safety/parts.def"
#undef HOIST_PART
};

enum class Origin : std::uint8_t { debian, npm, system };
enum class RunsIn : std::uint8_t { product, build, test };
inline constexpr std::array<std::string_view, 3> kOriginNames{"Debian", "npm", "system"};
inline constexpr std::array<std::string_view, 3> kRunsInNames{"product", "build", "test"};
struct Soup {
  std::string_view name;
  Origin origin;
  RunsIn in;
  std::string_view use, failure;
};
inline constexpr std::array kSoup{
#define HOIST_SOUP(name, origin, in, use, failure) Soup{name, Origin::origin, RunsIn::in, use, failure},
#include "control/safety/soup.def"
#undef HOIST_SOUP
};

enum class Coverage : std::uint8_t { none, low, medium, high };
inline constexpr std::array<std::string_view, 4> kCoverageNames{"none", "low", "medium", "high"};
struct StopPath {
  std::string_view name, asked_by, first, second, category;
  Coverage coverage;
  std::string_view hazards;  // numbers, separated by a space
};
inline constexpr std::array kStopPaths{
#define HOIST_STOP(name, asked_by, first, second, category, coverage, hazards) \
  StopPath{name, asked_by, first, second, category, Coverage::coverage, hazards},
#include "control/safety/stops.def"
#undef HOIST_STOP
};

/// The row of a hazard, nullptr when there is none.
constexpr const Risk* risk_of(int hazard) {
  for (const Risk& risk : kRisks)
    if (risk.hazard == hazard) return &risk;
  return nullptr;
}

static_assert(kRisks.size() == contract::kHazards.size() && contract::unique_by(kRisks, [](const Risk& r) { return r.hazard; }) &&
                  // Not by risk_of(): with UndefinedBehaviorSanitizer g++ 12 calls no address a constant.
                  contract::all_rows(contract::kHazards,
                                     [](const contract::HazardInfo& h) {
                                       return std::ranges::any_of(kRisks, [&h](const Risk& r) { return r.hazard == h.number; });
                                     }),
              "risks.def: one row for each hazard of hazards.def");
static_assert(contract::all_rows(kRisks,
                                 [](const Risk& r) {
                                   return !r.harm.empty() && !r.residual.empty() && r.after <= r.before &&
                                          verdict(r.severity, r.after) != Verdict::unacceptable;
                                 }),
              "risks.def: a risk lacks its words, grows by its measures, or is unacceptable with them");
static_assert(contract::all_rows(kParts,
                                 [](const Part& p) { return p.software_class >= 'A' && p.software_class <= 'C' && !p.why.empty(); }) &&
                  contract::unique_by(kParts, [](const Part& p) { return p.folder; }),
              "parts.def: a class is none of A, B, C, or a folder is there twice");
static_assert(contract::unique_by(kSoup, [](const Soup& s) { return s.name; }) &&
                  contract::all_rows(kSoup, [](const Soup& s) { return !s.use.empty() && !s.failure.empty(); }),
              "soup.def: a row is there twice, or lacks its words");

}  // namespace hoist::safety
