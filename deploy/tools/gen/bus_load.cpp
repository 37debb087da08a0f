#include "deploy/tools/gen/bus_load.hpp"

#include <array>
#include <cstdio>

#include "control/contract/bus_load.hpp"

namespace hoist::gen {
namespace {

using namespace hoist::contract;

std::string fixed(double value, const char* format) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}
std::string percent(double share) { return fixed(100.0 * share, "%.1f %%"); }
std::string response(const BusPlan& plan, std::size_t which, const BusConditions& conditions) {
  const auto bits = response_bits(plan, which, conditions);
  return bits ? fixed(bits_ms(*bits), "%.2f") : "no bound";
}

std::string mailbox_response(const BusPlan& plan, std::size_t which, const BusConditions& conditions) {
  const auto bits = response_bits(plan, which, conditions), wait = mailbox_wait_bits(plan, which, conditions);
  return bits && wait ? fixed(bits_ms(*bits + *wait), "%.2f") : "no bound";
}

struct Variant {
  const char* title;
  SwitchedPdos switched;
};
constexpr std::array kVariants = {Variant{"no node sends its rates", SwitchedPdos::none},
                                  Variant{"as planned: the base sends its rates", SwitchedPdos::as_planned},
                                  Variant{"all three sensors send their rates", SwitchedPdos::all}};

}  // namespace

std::string bus_load_page() {
  std::string out =
      "# Bus load and response times\n\n"
      "Computed from the tables by `hoist bus load`; a test holds the limits. 250 kbit/s, 11-bit ids, every frame stuffed as badly as can "
      "be;\n"
      "emergencies of all nodes counted as often as they may come. Response times: Davis, Burns, Bril, Lukkien 2007, exact, from when a "
      "frame\n"
      "ought to be sent (release jitter included: SYNC 0.5 ms, nodes 1 ms, commands 2 ms) until it has arrived; valid because every "
      "sender\n"
      "sends by priority: on the LPC11C24 each identifier has a message object of its own. The STM32F072 has three mailboxes; its "
      "column\n"
      "adds the wait for lower frames of the same board that fill them, in the worst condition.\n"
      "*Storm*: all nodes send their EMCY at once. *Errors*: besides, one bus error every 10 ms. SDO always uses its\n"
      "whole reserve. *Reaction*: when the absence of a frame has a reaction; for heartbeats with one more beat lost.\n\n"
      "## Load\n\n| what is on | worst | without stuff bits | frames a second | with the 25 % reserve for SDO |\n|---|---|---|---|---|\n";
  for (const Variant& variant : kVariants) {
    const BusPlan plan = bus_plan(variant.switched);
    const BusLoad load = bus_load(plan, false), all = bus_load(plan, true);
    out += std::string("| ") + variant.title + " | " + percent(load.worst) + " | " + percent(load.plain) + " | " +
           fixed(load.frames_per_s, "%.0f") + " | " + percent(all.worst) + " |\n";
  }
  out +=
      "\nThe limit of the plan is 80 % with the reserve. With all three rates on the reserve no longer fits under it: a research session "
      "and\n"
      "a long SDO transfer (a dump, a firmware update) are not for the same time. While nothing fails, every frame still meets its period "
      "then, as below.\n"
      "Bumpers are counted every 10 ms, their inhibit time, although their timer is 20 ms: that is as often as they can come.\n";
  for (const Variant& variant : {kVariants[1], kVariants[2]}) {
    const BusPlan plan = bus_plan(variant.switched);
    out += std::string("\n## Response times in ms, ") + variant.title +
           "\n\n| id | frame | bytes | every | quiet | storm | storm and errors | STM32F072 | reaction "
           "|\n|---|---|---|---|---|---|---|---|---|\n";
    for (std::size_t i = 0; i < plan.size; ++i) {
      const BusFrame& f = plan.frames[i];
      char id[8];
      std::snprintf(id, sizeof id, "%03X", f.id);
      const NodeInfo& sender = kNodes[static_cast<std::size_t>(f.sender)];
      const bool both = f.kind == FrameKind::process && f.sender == Node::core;
      std::string what(f.what);
      if (f.kind != FrameKind::sync && f.kind != FrameKind::service)
        what = (both ? std::string(kNodes[static_cast<std::size_t>(*find_node(static_cast<std::uint8_t>(f.id & 0x7FU)))].title)
                     : std::string(sender.title)) +
               ": " + what;
      out += std::string("| ") + (f.kind == FrameKind::service ? "58x, 60x" : id) + " | " + what + " | " + std::to_string(f.bytes) + " | " +
             fixed(bits_ms(f.period), "%.4g") + " | " +
             (f.kind == FrameKind::emergency ? std::string("-") : response(plan, i, {false, false, true})) + " | " +
             response(plan, i, {true, false, true}) + " | " + response(plan, i, {true, true, true}) + " | " +
             mailbox_response(plan, i, {true, true, true}) + " | " + fixed(bits_ms(f.deadline), "%.4g") + " |\n";
    }
  }
  return out;
}

}  // namespace hoist::gen
