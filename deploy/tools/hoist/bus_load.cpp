// hoist bus load: how full the bus is and how late a frame can be, from the tables.
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "control/contract/bus_load.hpp"
#include "deploy/tools/gen/bus_load.hpp"
#include "deploy/tools/hoist/command.hpp"

namespace hoist::tool {

namespace {

using namespace hoist::contract;

constexpr char kBusLoadHelp[] =
    "usage: hoist bus load [--markdown | --json] [--rates none|planned|all]\n\n"
    "Load and worst response times of the bus, computed from the tables. --rates: which tilt sensors send their rates\n"
    "(default planned: the base's). --markdown prints firmware/BUS_LOAD.gen.md, which shows all of them.\n";

nlohmann::ordered_json response_json(const BusPlan& plan, std::size_t which, const BusConditions& conditions) {
  const auto bits = response_bits(plan, which, conditions);
  return bits ? nlohmann::ordered_json(bits_ms(*bits)) : nlohmann::ordered_json(nullptr);
}

void print_json(const BusPlan& plan) {
  const BusLoad load = bus_load(plan, false), all = bus_load(plan, true);
  nlohmann::ordered_json page{{"bit_rate", kBusBitRate},
                              {"load_worst", load.worst},
                              {"load_plain", load.plain},
                              {"load_worst_with_service", all.worst},
                              {"frames_per_s", load.frames_per_s}};
  for (std::size_t i = 0; i < plan.size; ++i) {
    const BusFrame& f = plan.frames[i];
    page["frames"].push_back({{"id", f.id},
                              {"sender", kNodes[static_cast<std::size_t>(f.sender)].name},
                              {"what", f.what},
                              {"bytes", f.bytes},
                              {"period_ms", bits_ms(f.period)},
                              {"quiet_ms", response_json(plan, i, {false, false, true})},
                              {"storm_ms", response_json(plan, i, {true, false, true})},
                              {"storm_errors_ms", response_json(plan, i, {true, true, true})},
                              {"reaction_ms", bits_ms(f.deadline)}});
  }
  std::printf("%s\n", page.dump(2).c_str());
}

void print_text(const BusPlan& plan) {
  const BusLoad load = bus_load(plan, false), all = bus_load(plan, true);
  std::printf("load at worst %.1f %%, without stuff bits %.1f %%, %.0f frames a second; with the reserve for SDO %.1f %% (limit 80 %%)\n\n",
              100 * load.worst, 100 * load.plain, load.frames_per_s, 100 * all.worst);
  std::printf("  id  %-12s %-24s bytes  every ms   quiet   storm  storm+errors  reaction ms\n", "sender", "frame");
  for (std::size_t i = 0; i < plan.size; ++i) {
    const BusFrame& f = plan.frames[i];
    const auto ms = [&](const BusConditions& conditions) {
      const auto bits = response_bits(plan, i, conditions);
      return bits ? bits_ms(*bits) : -1.0;
    };
    std::printf(" %03X  %-12s %-24s %5u  %8.4g  %6.2f  %6.2f  %12.2f  %11.4g\n", f.id,
                std::string(kNodes[static_cast<std::size_t>(f.sender)].name).c_str(), std::string(f.what).c_str(), f.bytes,
                bits_ms(f.period), ms({false, false, true}), ms({true, false, true}), ms({true, true, true}), bits_ms(f.deadline));
  }
}

}  // namespace

int run_bus_load(std::span<const std::string_view> arguments) {
  bool json = false, markdown = false;
  SwitchedPdos rates = SwitchedPdos::as_planned;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view argument = arguments[i];
    if (argument == "--help") {
      std::fputs(kBusLoadHelp, stdout);
      return kDone;
    }
    if (argument == "--json") {
      json = true;
    } else if (argument == "--bus" && i + 1 < arguments.size()) {
      ++i;  // like its neighbours; no bus is needed
    } else if (argument == "--markdown") {
      markdown = true;
    } else if (argument == "--rates" && i + 1 < arguments.size() &&
               (arguments[i + 1] == "none" || arguments[i + 1] == "planned" || arguments[i + 1] == "all")) {
      ++i;
      rates = arguments[i] == "none" ? SwitchedPdos::none : arguments[i] == "all" ? SwitchedPdos::all : SwitchedPdos::as_planned;
    } else {
      std::fputs(kBusLoadHelp, stderr);
      return kBadUsage;
    }
  }
  const BusPlan plan = bus_plan(rates);
  if (markdown)
    std::fputs(gen::bus_load_page().c_str(), stdout);
  else if (json)
    print_json(plan);
  else
    print_text(plan);
  return kDone;
}

}  // namespace hoist::tool
