// /loop: how punctual the core's steps are, in full. The record of a step has the summary.
#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "control/contract/loop_report.hpp"
#include "server/api/handlers.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {

constexpr std::uint8_t kNoCpu = 255;

double seconds(std::uint64_t ns) { return static_cast<double>(ns) * 1e-9; }

// Only buckets that hold something: most of them never do.
json buckets(const std::array<std::uint64_t, contract::kLatenessBuckets>& counts) {
  json list = json::array();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    list.push_back({{"from_s", i == 0 ? 0.0 : seconds(contract::lateness_bucket_end_ns(i - 1))},
                    {"to_s", i + 1 == counts.size() ? json(nullptr) : json(seconds(contract::lateness_bucket_end_ns(i)))},
                    {"count", counts[i]}});
  }
  return list;
}

}  // namespace

void get_loop(const CallPtr& call) {
  const Services& s = call->services;
  const auto& newest = s.core.newest();
  contract::LoopReport report;
  if (!newest || !s.core.connected() || !s.core.link().loop(report)) {
    call->fail({.status = 503,
                .name = "no-core",
                .title = "The control core does not answer",
                .detail = "The control core is not connected, or has not run for a second yet."});
    return;
  }
  call->respond(json{{"steps", report.steps},
                     {"missed", newest->missed_ticks},
                     {"late", newest->overruns},
                     {"lateness_p50_s", newest->lateness_p50_s},
                     {"lateness_p99_s", newest->lateness_p99_s},
                     {"lateness_max_s", newest->lateness_max_s},
                     {"latest_ever_s", seconds(report.latest_ever_ns)},
                     {"longest_step_s", seconds(report.longest_step_ns)},
                     {"page_faults", newest->page_faults},
                     {"allocations", newest->allocations},
                     {"priority", newest->loop_priority == 0 ? json(nullptr) : json(newest->loop_priority)},
                     {"cpu", newest->loop_cpu == kNoCpu ? json(nullptr) : json(newest->loop_cpu)},
                     {"memory_locked", newest->memory_locked != 0},
                     {"lately", buckets(report.lately)},
                     {"ever", buckets(report.ever)}});
}

}  // namespace hoist::server::api
