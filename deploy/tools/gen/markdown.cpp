// The reference pages that people read.
#include <array>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <string>

#include "control/contract/alarms.hpp"
#include "control/contract/bus_load.hpp"
#include "control/contract/can_dictionary.hpp"
#include "control/contract/emergencies.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/hazards.hpp"
#include "control/contract/params.hpp"
#include "control/contract/signals.hpp"
#include "control/safety/safety_file.hpp"
#include "db/metrics/change.hpp"
#include "db/metrics/metric_list.hpp"
#include "deploy/tools/gen/bus_load.hpp"
#include "deploy/tools/gen/generate.hpp"

namespace hoist::gen {
namespace {

using namespace hoist::contract;

std::string head(std::string_view table, std::string_view title) {
  return "<!-- " + made_from(table) + " -->\n\n# " + std::string(title) + "\n\n";
}

// A cell may not hold the bar that ends it.
std::string cell(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '|') out += '\\';
    out += c;
  }
  return out;
}
std::string row(std::initializer_list<std::string> cells) {
  std::string out = "|";
  for (const auto& text : cells) out += " " + cell(text) + " |";
  return out + "\n";
}
std::string table_head(std::initializer_list<std::string> titles) {
  std::string out = row(titles) + "|";
  for (std::size_t i = 0; i < titles.size(); ++i) out += "---|";
  return out + "\n";
}
std::string code(std::string_view text) { return "`" + std::string(text) + "`"; }

GeneratedFile params_page() {
  std::string out = head("control/contract/params.def", "Parameters");
  out += "All values in SI units. *live* parameters may change while the hoist moves, *stopped* ones only on standby.\n\n";
  out += table_head({"id", "name", "unit", "least", "default", "most", "edit", "who", "what it does", "source"});
  for (const auto& p : kParams) {
    const std::string where = p.scope == ParamScope::core    ? ""
                              : p.scope == ParamScope::drive ? " (in the drives)"
                                                             : " (in the tilt sensors)";
    out += row({std::to_string(p.id), code(p.name), std::string(p.unit), number_text(p.min), number_text(p.default_value),
                number_text(p.max), p.edit == EditRule::live ? "live" : "stopped", p.role == Role::engineer ? "engineer" : "therapist",
                std::string(p.title_en) + where + ": " + std::string(p.effect_en), std::string(p.source)});
  }
  out += "\n## Presets\n\n";
  for (const auto& preset : kPresets) {
    out += "**" + std::string(preset.title_en) + "** (" + code(preset.name) + "): " + std::string(preset.doc_en) + "\n\n" +
           table_head({"parameter", "value"});
    for (const auto& value : kPresetValues) {
      if (value.preset == preset.name) out += row({code(kParams[param_index(value.param)].name), number_text(value.value)});
    }
    out += "\n";
  }
  out.pop_back();
  return {"control/contract/params.gen.md", out};
}

GeneratedFile metrics_page() {
  std::string out = head("db/metrics/metric_list.hpp", "Figures of a session");
  out +=
      "Only steps in a mode in which the wheels may turn count, 10 ms each. A figure is a number, or null with the reason "
      "(`computed.KEY.reason_code`, the rows of `no_figure.def`) where a session has not what *valid with* asks for. `computed` says of "
      "each "
      "figure the version of its definition, its inputs and a hash of their values. x_m, y_m and psi_rad are the track with slip repaired "
      "(fused_) where it was recorded; reference: the nearest place of the exercise, never going back (D27). Bouts: more than 0.05 m/s for "
      "1 s or longer. Decisions: `db/DECISIONS.md`; D numbers: `control/core/law/DECISIONS.md`.\n\n";
  out += table_head({"figure", "version", "unit", "what it says", "formula", "valid with", "computed from", "source"});
  for (const auto& m : db::kMetrics)
    out += row({code(m.key), std::to_string(m.version), std::string(m.unit), std::string(m.doc), std::string(m.formula),
                m.gate.empty() ? "every session" : std::string(m.gate), std::string(m.inputs), std::string(m.source)});
  out +=
      "\n## Change you may believe\n\n"
      "The newest value against the first one, within one exercise and task. A change is told only beyond the minimal detectable change "
      "(95 %): the larger one of the published one and of 1.96 sqrt(2) s, where s is the standard deviation of the patient's own walks "
      "within visits, pooled over visits, with at least " +
      std::to_string(db::kLeastRepeats) +
      " degrees of freedom. Without either, none is told. Of many figures compared at once, one in twenty passes it by chance. "
      "Published (`db/metrics/published_changes.def`):\n\n";
  out += table_head({"figure", "first value from", "below", "minimal detectable change", "measured with", "source"});
  for (const db::PublishedChange& one : db::published_changes())
    out += row({code(one.figure), number_text(one.from), std::isinf(one.below) ? "" : number_text(one.below), number_text(one.minimal),
                std::string(one.whom_en), std::string(one.source)});
  return {"db/metrics/metrics.gen.md", out};
}

GeneratedFile signals_page() {
  constexpr std::array<std::string_view, 6> kTypes = {"u64", "u32", "i32", "f32", "u16", "u8"};
  std::string out = head("control/contract/signals.def", "Live values");
  out += "One record of " + std::to_string(sizeof(TickRecord)) +
         " bytes per control step (100 Hz), little endian. *step* is the value of one step of the recorded integer.\n\n";
  out += table_head({"id", "name", "unit", "type", "byte", "step", "what it is"});
  for (const auto& s : kSignals) {
    out += row({std::to_string(s.id), code(s.name), std::string(s.unit), std::string(kTypes[static_cast<std::size_t>(s.type)]),
                std::to_string(s.offset), number_text(s.lsb), std::string(s.doc)});
  }
  return {"control/contract/signals.gen.md", out};
}

std::string alarms_section() {
  constexpr std::array<std::string_view, 3> kPriorities = {"low", "medium", "high"};
  std::string out =
      "\n## Alarm signals\n\nAt the hoist (input node) and on the console, by the most urgent fault in force; figures after IEC 60601-1-8 "
      "(`control/SOURCES.md`, 2.5). Sound may be paused for " +
      number_text(kAudioPause_s) +
      " s by a therapist or engineer; a new fault, or one that comes back, sounds at once. The light is never paused. The input node "
      "signals "
      "high by itself when the control computer is gone.\n\n" +
      table_head({"priority", "pulses", "pulse", "between pulses", "between bursts", "light", "flashes", "lit"});
  for (auto at = kAlarms.rbegin(); at != kAlarms.rend(); ++at) {
    const bool steady = at->flash_ms == 0;
    out += row({std::string(kPriorities[static_cast<std::size_t>(at->priority)]), std::to_string(at->pulses),
                std::to_string(at->pulse_ms) + " ms",
                at->pulses == 1 ? ""
                                : std::to_string(at->spacing_ms) + " ms" +
                                      (at->pulses > 3 ? ", after the third of five " + std::to_string(alarm_gap_ms(*at, 2)) +
                                                            " ms, after the fifth " + std::to_string(kGroupGap_ms) + " ms"
                                                      : ""),
                number_text(at->interburst_ms / 1000.0) + " s", std::string(kAlarmColourNames[static_cast<std::size_t>(at->colour)]),
                steady ? "steady" : number_text(1000.0 / at->flash_ms) + " Hz",
                steady ? "always" : number_text(100.0 * at->lit_ms / at->flash_ms) + " %"});
  }
  return out;
}

GeneratedFile faults_page() {
  constexpr std::array<std::string_view, 3> kPriorities = {"low", "medium", "high"};
  constexpr std::array<std::string_view, 5> kReactions = {"warning only", "soft stop to standby", "protective stop until acknowledged",
                                                          "protective stop, then out of service", "emergency stop"};
  std::string out = head("control/contract/faults.def", "Faults, refusals, modes");
  out += "## Faults\n\n" + table_head({"bit", "name", "priority", "reaction", "hazard", "what the therapist reads", "what to do"});
  for (const auto& f : kFaults) {
    out += row({std::to_string(f.bit), code(f.name), std::string(kPriorities[static_cast<std::size_t>(f.priority)]),
                std::string(kReactions[static_cast<std::size_t>(f.reaction)]), std::string(f.hazard()), std::string(f.text_en),
                std::string(f.action_en)});
  }
  out +=
      "\n## Details\n\nWhat a fault is about, by its live value `<fault>_code`. *Outside*: floor, load or patient; such a stop does not "
      "count "
      "towards FAULT.\n\n" +
      table_head({"fault", "code", "name", "origin", "what the therapist reads", "what to do"});
  for (const auto& d : kDetails) {
    out += row({code(fault_info(d.fault).name), hex_text(d.code, 4), code(d.name), d.origin == Origin::outside ? "outside" : "machine",
                std::string(d.text_en), std::string(d.action_en)});
  }
  out += "\n## Causes and consequences\n\nWhile the cause is in force, its consequences are shown under it and do not count.\n\n" +
         table_head({"cause", "consequence"});
  for (const auto& e : kExplanations) out += row({code(fault_info(e.cause).name), code(fault_info(e.effect).name)});
  out += "\n## The patient first\n\nShown above every other alarm, in this order:";
  for (const Fault fault : kEndangers) out += " " + code(fault_info(fault).name);
  out += ".\n";
  out += alarms_section();
  constexpr std::array<std::string_view, 5> kMonitorReactions = {"warning", "R1", "R2", "R2", "R4"};
  out +=
      "\n## Monitors\n\nHow each fault is found. R1 soft stop to standby, R2 protective stop until acknowledged, R4 "
      "power off. *Budget*: from the cause to the beginning of braking, by the rule that is there for a sudden "
      "cause; a rule that waits longer says so under *threshold*.\n\n" +
      table_head({"fault", "hazards", "reaction", "budget", "threshold"});
  for (const auto& f : kFaults) {
    out += row({code(f.name), std::string(f.hazards), std::string(kMonitorReactions[static_cast<std::size_t>(f.reaction)]),
                std::to_string(f.budget_ms) + " ms", std::string(f.threshold)});
  }
  out += "\n## Refusals\n\nWhy a start is blocked or a command is refused.\n\n" + table_head({"bit", "name", "what the therapist reads"});
  for (const auto& r : kRefusals) out += row({std::to_string(r.bit), code(r.name), std::string(r.text_en)});
  out += "\n## Speed causes\n\nWhy the hoist goes more slowly than it is asked to.\n\n" +
         table_head({"value", "name", "what the therapist reads"});
  for (const auto& c : kSpeedCauses) out += row({std::to_string(c.value), code(c.name), std::string(c.text_en)});
  out += "\n## Modes\n\n" + table_head({"value", "name", "title", "wheels may turn"});
  for (const auto& m : kModes) out += row({std::to_string(m.value), code(m.name), std::string(m.title_en), m.moving ? "yes" : "no"});
  return {"control/contract/faults.gen.md", out};
}

std::string risks_section() {
  std::string out =
      "## Risks\n\nSeverity and probability are estimates. A risk is acceptable up to severity + probability = 4 (minor 1 to catastrophic "
      "4, "
      "improbable 1 to frequent 5), to be reduced as far as possible at 5, unacceptable above.\n\n" +
      table_head({"", "hazard", "harm", "severity", "without measures", "with them", "residual risk", "what is left"});
  for (const auto& hazard : kHazards) {
    const safety::Risk& risk = *safety::risk_of(hazard.number);
    const auto likely = [](safety::Probability p) { return std::string(safety::kProbabilityNames[static_cast<std::size_t>(p) - 1U]); };
    out += row({"H" + std::to_string(hazard.number), std::string(hazard.what), std::string(risk.harm),
                std::string(safety::kSeverityNames[static_cast<std::size_t>(risk.severity) - 1U]), likely(risk.before), likely(risk.after),
                std::string(safety::kVerdictNames[static_cast<std::size_t>(safety::verdict(risk.severity, risk.after))]),
                std::string(risk.residual)});
  }
  out += "\n### Measures and their tests\n\n" + table_head({"", "monitors", "other measures", "tests"});
  for (const auto& hazard : kHazards) {
    const std::string name = "H" + std::to_string(hazard.number);
    std::string monitors, tests;
    for (const auto& fault : kFaults)
      if ((" " + std::string(fault.hazards) + " ").find(" " + name + " ") != std::string::npos)
        monitors += (monitors.empty() ? "" : ", ") + code(fault.name);
    for (const auto& test : safety::kSafetyTests)
      if (test.hazard == hazard.number)
        tests += (tests.empty() ? "" : ", ") + code(std::string(test.program) + " " + std::string(test.test));
    out += row({name, monitors, std::string(hazard.guard), tests});
  }
  return out;
}

GeneratedFile safety_page() {
  std::string out = head("the tables of control/safety, hazards.def and faults.def", "Safety file: tables");
  out += "What this is, intended use, and what is not there: [README](README.md). It claims no certification.\n\n" + risks_section();
  out += "\n## Parts\n\nSoftware safety class after IEC 62304.\n\n" + table_head({"part", "class", "why"});
  for (const auto& part : safety::kParts) out += row({code(part.folder), std::string(1, part.software_class), std::string(part.why)});
  out +=
      "\n## Stop paths\n\nCategory of the structure as designed (ISO 13849-1); coverage of dangerous faults by software. A performance "
      "level "
      "needs the failure rates of real parts and is not computed.\n\n" +
      table_head({"stop", "asked by", "first channel", "second channel", "category", "coverage", "hazards"});
  for (const auto& stop : safety::kStopPaths) {
    std::string hazards;
    for (const char c : stop.hazards) {
      if (hazards.empty() || hazards.back() == ' ') hazards += 'H';
      hazards += c;
    }
    out += row({std::string(stop.name), std::string(stop.asked_by), std::string(stop.first), std::string(stop.second),
                std::string(stop.category), std::string(safety::kCoverageNames[static_cast<std::size_t>(stop.coverage)]), hazards});
  }
  out += "\n## SOUP\n\n" + table_head({"name", "from", "part of", "used for", "if it fails"});
  for (const auto& soup : safety::kSoup)
    out += row({code(soup.name), std::string(safety::kOriginNames[static_cast<std::size_t>(soup.origin)]),
                std::string(safety::kRunsInNames[static_cast<std::size_t>(soup.in)]), std::string(soup.use), std::string(soup.failure)});
  return {"control/safety/SAFETY.gen.md", out};
}

GeneratedFile emergencies_page() {
  std::string out = head("control/contract/emergencies.def", "Emergency messages");
  out += "Codes of EMCY messages. A code without a row of its own is told by the row of its class.\n\n";
  out += table_head({"code", "bits that count", "what the therapist reads", "for engineers"});
  for (const auto& e : kEmergencies)
    out += row({code(hex_text(e.code, 4)), code(hex_text(e.mask, 4)), std::string(e.text_en), std::string(e.detail_en)});
  return {"control/contract/emergencies.gen.md", out};
}

std::string_view type_name(ObjectType type) {
  constexpr std::array<std::string_view, 7> kNames = {"u8", "i8", "u16", "i16", "u32", "i32", "f32"};
  return kNames[static_cast<std::size_t>(type)];
}

GeneratedFile can_page() {
  std::string out = head("control/contract/can_dictionary.def", "The bus: nodes, process data, objects");
  out += "CANopen at 250 kbit/s. The DBC of all frames is `hoist.gen.dbc`; one EDS per node is in `firmware/nodes/eds/`.\n\n## Nodes\n\n" +
         table_head({"node", "id", "title"});
  for (const auto& node : kNodes) out += row({code(node.name), hex_text(node.id, 2), std::string(node.title)});
  out += "\n## Process data\n\n" + table_head({"frame", "id", "bytes", "from", "when", "content", "worst load"});
  for (const auto& pdo : kPdos) {
    for (const auto& node : kNodes) {
      if (node.kind != pdo.kind) continue;
      // Off by default (HOIST_PDO_OFF): not in the regular load.
      const bool off = !pdo_on_by_default(pdo.pdo, *find_node(node.id));
      std::string content;
      for (const auto& entry : kPdoEntries) {
        if (entry.pdo != pdo.pdo) continue;
        const auto* object = find_object(pdo.kind, entry.index, entry.sub);
        content += (content.empty() ? "" : ", ") + std::string(object->name) + " " + std::string(type_name(object->type));
      }
      const double bits_per_second =
          static_cast<double>(worst_frame_bits(pdo_bytes(pdo.pdo))) * 1000.0 / static_cast<double>(pdo.period_ms);
      const std::string when = pdo.type <= 240 ? "every " + (pdo.type == 1 ? std::string() : std::to_string(pdo.type) + ". ") + "SYNC"
                                               : "every " + std::to_string(pdo.period_ms) + " ms or on change";
      char percent[16];
      std::snprintf(percent, sizeof percent, "%.1f %%", 100.0 * bits_per_second / kBusBitRate);
      out += row({std::string(node.name) + " " + std::string(pdo.title), hex_text(static_cast<unsigned>(pdo.cob_base) + node.id, 3),
                  std::to_string(pdo_bytes(pdo.pdo)), pdo.direction == PdoDirection::tx ? std::string(node.name) : "core",
                  off ? "research switch, off" : when, content, off ? "-" : percent});
    }
  }
  out += "\nWhat all of it together makes of the bus, and how late each frame can be, is in `firmware/BUS_LOAD.gen.md`.\n";
  out += "\n## Objects\n\n" + table_head({"nodes", "object", "name", "type", "access", "default", "range", "unit", "title"});
  constexpr std::array<std::string_view, 5> kOwners = {"tilt", "drive", "io", "core", "all"};
  for (const auto& object : kObjects) {
    char address[24];
    std::snprintf(address, sizeof address, "%04Xh:%u", object.index, object.sub);
    const std::string unit = object.scale == 1.0 ? std::string(object.unit) : number_text(object.scale) + " " + std::string(object.unit);
    out += row({std::string(kOwners[static_cast<std::size_t>(object.owner)]), address, code(object.name),
                std::string(type_name(object.type)), object.access == Access::rw ? "read, write" : "read",
                is_node_relative(object.index, object.sub) ? hex_text(static_cast<unsigned>(object.default_value), 3) + " + node"
                                                           : number_text(object.default_value),
                number_text(object.min) + " to " + number_text(object.max), unit, std::string(object.title)});
  }
  for (const auto& text : kTexts) {
    char address[24];
    std::snprintf(address, sizeof address, "%04Xh:0", text.index);
    out += row({"all", address, code(text.name), "text", "read", "", "", "", std::string(text.title)});
  }
  return {"control/contract/can_dictionary.gen.md", out};
}

GeneratedFile load_page() {
  return {"firmware/BUS_LOAD.gen.md", "<!-- " + made_from("control/contract/can_dictionary.def") + " -->\n\n" + bus_load_page()};
}

}  // namespace

std::vector<GeneratedFile> markdown_files() {
  return {params_page(), signals_page(), faults_page(), emergencies_page(), can_page(), load_page(), metrics_page(), safety_page()};
}

}  // namespace hoist::gen
