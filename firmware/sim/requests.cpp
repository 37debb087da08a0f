#include "firmware/sim/requests.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <variant>

#include "firmware/sim/pokeys_device.hpp"

namespace hoist::sim {
namespace {

using contract::Node;
using nlohmann::json;

struct Refused {
  std::string why;
};
using Answer = std::variant<json, Refused>;

const json kDone = {{"ok", true}};
constexpr double kBatteryMax_v = 32.0;
constexpr double kWishMin_m_s = 0.05, kWishMax_m_s = 0.8;
constexpr double kPlaceMax_m = 100.0;
constexpr double kBarMax_m = 0.25, kBarMax_rad = 0.5;
constexpr double kFloorMax_rad = 0.5;

// Fields. Each refusal names the field and what it may be.
std::optional<std::string> text(const json& request, const char* field) {
  const auto it = request.find(field);
  if (it == request.end() || !it->is_string()) return std::nullopt;
  return it->get<std::string>();
}
std::optional<double> number(const json& request, const char* field, double low, double high) {
  const auto it = request.find(field);
  if (it == request.end() || !it->is_number()) return std::nullopt;
  const double value = it->get<double>();
  if (!std::isfinite(value) || value < low || value > high) return std::nullopt;
  return value;
}
std::optional<bool> flag(const json& request, const char* field) {
  const auto it = request.find(field);
  if (it == request.end() || !it->is_boolean()) return std::nullopt;
  return it->get<bool>();
}
std::optional<Node> node(const json& request) {
  const auto name = text(request, "node");
  if (!name) return std::nullopt;
  for (std::size_t i = 0; i < contract::kNodes.size(); ++i)
    if (contract::kNodes[i].name == *name) return static_cast<Node>(i);
  return std::nullopt;
}
std::string node_names() {
  std::string names;
  for (const contract::NodeInfo& info : contract::kNodes) names += (names.empty() ? "" : ", ") + std::string(info.name);
  return names;
}
Refused bad_node() { return {"node: one of " + node_names()}; }

struct Sides {
  bool left, right;
};
// Of the member "which": left, right or both.
std::optional<Sides> sides(const json& request) {
  const auto which = text(request, "which");
  const Sides found{which == "left" || which == "both", which == "right" || which == "both"};
  return found.left || found.right ? std::optional(found) : std::nullopt;
}
Refused patient_out() { return {"op: the patient is not in the hoist; {\"op\":\"strap\"}"}; }
Refused bad_sides() { return {"which: left, right or both"}; }

Answer op_state(World& world, const ProgramState& program, const json&) {
  const Plant& plant = world.plant();
  const Patient& patient = world.patient();
  const PlatformMotion& at = plant.platform();
  json pulled = json::array(), in_loader = json::array();
  for (std::size_t i = 0; i < contract::kNodes.size(); ++i) {
    if (world.unplugged(static_cast<Node>(i))) pulled.push_back(contract::kNodes[i].name);
    if (world.in_loader(static_cast<Node>(i))) in_loader.push_back(contract::kNodes[i].name);
  }
  return json{{"time_s", world.time_s()},
              {"x_m", at.x_m},
              {"y_m", at.y_m},
              {"psi_rad", at.psi_rad},
              {"speed_m_s", at.speed_m_s},
              {"yaw_rate_rad_s", at.yaw_rate_rad_s},
              {"patient_in", world.patient_in()},
              {"pushed", plant.pushed()},
              {"wheel_left_m_s", plant.wheel_speed_m_s(Side::left)},
              {"wheel_right_m_s", plant.wheel_speed_m_s(Side::right)},
              {"slipping", plant.slipping()},
              {"enabled", world.drives_enabled()},
              {"patient", patient_state_name(patient.state())},
              {"scenario", patient.scenario().name},
              {"progress_m", patient.progress_m()},
              {"dx_m", patient.harness().dx_m},
              {"dy_m", patient.harness().dy_m},
              {"pelvis_yaw_rad", patient.harness().yaw_rad},
              {"strut_left_alpha_rad", plant.strut_alpha_rad(Side::left)},
              {"strut_right_alpha_rad", plant.strut_alpha_rad(Side::right)},
              {"supply_v", plant.supply_v()},
              {"bumpers", plant.bumpers()},
              {"sync_output", program.pokeys != nullptr ? program.pokeys->output() : world.sync_output()},
              {"buzzer", (world.outputs() & contract::canopen::kBuzzer) != 0},
              {"red_light", (world.outputs() & contract::canopen::kRedLight) != 0},
              {"unplugged", pulled},
              {"in_loader", in_loader},
              {"bus_frames", world.bus_counters().frames},
              {"computer_attached", program.computer_attached},
              {"late", program.late},
              {"simulated", true}};
}

json witness_of(const World& world, Side side) {
  const StopWitness& seen = world.witness(side);
  const auto time_s = [](std::optional<std::uint64_t> ns) { return ns ? json(static_cast<double>(*ns) * 1e-9) : json(nullptr); };
  return json{{"command_s", time_s(seen.command_ns())},
              {"gave_up_s", time_s(seen.gave_up_ns())},
              {"at_rest_s", time_s(seen.at_rest_ns())},
              {"speed_m_s", seen.speed_at_command_m_s()},
              {"rolled_m", seen.rolled_m()}};
}
Answer op_witness(World& world, const ProgramState& program, const json&) {
  return json{{"time_s", world.time_s()},
              {"late", program.late},
              {"relay_closed", world.relay_closed()},
              {"supply_v", world.plant().supply_v()},
              {"left", witness_of(world, Side::left)},
              {"right", witness_of(world, Side::right)}};
}

Answer op_line(World&, const ProgramState& program, const json& request) {
  const auto cut = flag(request, "cut");
  if (!cut) return Refused{"cut: true or false"};
  if (program.line_cut == nullptr) return Refused{"op: there is no serial line; start without --bus"};
  *program.line_cut = *cut;
  return kDone;
}

Answer op_bumper(World& world, const ProgramState&, const json& request) {
  constexpr std::array<std::string_view, 4> kStrips{"front", "rear", "left", "right"};  // order of the bits
  const auto which = text(request, "which");
  int bit = -1;
  for (std::size_t i = 0; which && i < kStrips.size(); ++i)
    if (*which == kStrips[i]) bit = static_cast<int>(i);
  if (bit < 0) return Refused{"which: front, rear, left or right"};
  const auto pressed = flag(request, "pressed");
  if (!pressed) return Refused{"pressed: true or false"};
  world.plant().force_bumper(bit, *pressed);
  return kDone;
}

// Toward which side; forward unless it is said.
Answer op_fall(World& world, const json& request, void (Patient::*how)(double)) {
  struct Side {
    std::string_view name;
    double toward_rad;
  };
  constexpr std::array<Side, 4> kSides{Side{"forward", 0.0}, Side{"backward", kPi}, Side{"left", kPi / 2.0}, Side{"right", -kPi / 2.0}};
  double toward_rad = 0.0;
  if (request.contains("toward")) {
    const auto toward = text(request, "toward");
    const auto* side = std::find_if(kSides.begin(), kSides.end(), [&toward](const Side& row) { return toward && row.name == *toward; });
    if (side == kSides.end()) return Refused{"toward: forward, backward, left or right"};
    toward_rad = side->toward_rad;
  }
  if (!world.patient_in()) return patient_out();
  (world.patient().*how)(toward_rad);
  return kDone;
}
Answer op_trip(World& world, const ProgramState&, const json& request) { return op_fall(world, request, &Patient::trip); }
Answer op_collapse(World& world, const ProgramState&, const json& request) { return op_fall(world, request, &Patient::collapse); }
Answer op_hang(World& world, const ProgramState&, const json&) {
  if (!world.patient_in()) return patient_out();
  world.patient().hang();
  return kDone;
}

Answer op_freeze_feet(World& world, const ProgramState&, const json& request) {
  const auto seconds = number(request, "seconds", 0.5, 60.0);
  if (!seconds) return Refused{"seconds: 0.5 to 60"};
  if (!world.patient_in()) return patient_out();
  world.patient().freeze_feet(*seconds);
  return kDone;
}

Answer op_plug(World& world, const json& request, bool pulled) {
  const auto which = node(request);
  if (!which) return bad_node();
  world.unplug(*which, pulled);
  return kDone;
}
Answer op_unplug(World& world, const ProgramState&, const json& request) { return op_plug(world, request, true); }
Answer op_replug(World& world, const ProgramState&, const json& request) { return op_plug(world, request, false); }

Answer op_exchange(World& world, const ProgramState&, const json& request) {
  const auto which = node(request);
  if (!which || *which == Node::core) return bad_node();
  constexpr std::array<std::string_view, 3> kHow{"right", "reversed", "swapped"};  // order of Assembly
  const auto how = text(request, "how");
  const auto row = std::find_if(kHow.begin(), kHow.end(), [&how](std::string_view name) { return how && name == *how; });
  if (row == kHow.end()) return Refused{"how: right, reversed or swapped"};
  world.exchange(*which, 0, static_cast<World::Assembly>(row - kHow.begin()));
  return kDone;
}

Answer op_freeze(World& world, const ProgramState&, const json& request) {
  const auto which = node(request);
  if (!which || *which == Node::core) return bad_node();
  const auto frozen = flag(request, "frozen");
  if (!frozen) return Refused{"frozen: true or false"};
  world.freeze(*which, *frozen);
  return kDone;
}

Answer op_freeze_sensor(World& world, const ProgramState&, const json& request) {
  const auto which = node(request);
  if (!which || contract::kNodes[static_cast<std::size_t>(*which)].kind != contract::NodeKind::tilt)
    return Refused{"node: tilt_left, tilt_right or tilt_base"};
  const auto frozen = flag(request, "frozen");
  if (!frozen) return Refused{"frozen: true or false"};
  world.freeze_sensor(*which, *frozen);
  return kDone;
}

Answer op_slip(World& world, const ProgramState&, const json& request) {
  const auto which = sides(request);
  if (!which) return bad_sides();
  const auto seconds = number(request, "seconds", 0.05, 10.0);
  if (!seconds) return Refused{"seconds: 0.05 to 10"};
  const auto grip_norm = number(request, "grip_norm", 0.0, 1.0);
  if (!grip_norm) return Refused{"grip_norm: 0 to 1"};
  const auto twist_n_m = number(request, "twist_n_m", -60.0, 60.0);
  if (!twist_n_m) return Refused{"twist_n_m: -60 to 60, left positive"};
  SlipBurst burst;
  burst.seconds = *seconds;
  const double dry_norm = world.plant().params().grip_norm;
  burst.grip_norm = {which->left ? *grip_norm : dry_norm, which->right ? *grip_norm : dry_norm};
  burst.twist_n_m = *twist_n_m;
  world.slip(burst);
  return kDone;
}

Answer op_battery(World& world, const ProgramState&, const json& request) {
  const auto it = request.find("volts");
  if (it != request.end() && it->is_null()) {
    world.plant().force_battery(std::nullopt);
    return kDone;
  }
  const auto volts = number(request, "volts", 0.0, kBatteryMax_v);
  if (!volts) return Refused{"volts: 0 to 32 for both batteries together, or null for what physics gives"};
  world.plant().force_battery(*volts);
  return kDone;
}

Answer op_power(World& world, const ProgramState&, const json& request) {
  const auto on = flag(request, "on");
  if (!on) return Refused{"on: true or false (false: the relay has opened without a word from the emergency stop)"};
  world.plant().cut_power(!*on);
  return kDone;
}

Answer op_short(World& world, const ProgramState&, const json& request) {
  const auto which = sides(request);
  if (!which) return bad_sides();
  const auto it = request.find("duty_norm");
  std::optional<double> duty_norm;
  if (it == request.end() || !it->is_null()) {
    duty_norm = number(request, "duty_norm", -1.0, 1.0);
    if (!duty_norm) return Refused{"duty_norm: -1 to 1, or null for a bridge that is whole again"};
  }
  if (which->left) world.plant().short_bridge(Side::left, duty_norm);
  if (which->right) world.plant().short_bridge(Side::right, duty_norm);
  return kDone;
}

Answer op_emergency_stop(World& world, const ProgramState&, const json& request) {
  const auto pressed = flag(request, "pressed");
  if (!pressed) return Refused{"pressed: true or false"};
  world.plant().press_emergency_stop(*pressed);
  return kDone;
}

Answer op_configuration_switch(World& world, const ProgramState&, const json& request) {
  const auto on = flag(request, "on");
  if (!on) return Refused{"on: true or false"};
  world.plant().turn_configuration_switch(*on);
  return kDone;
}

Answer op_sync_input(World& world, const ProgramState&, const json& request) {
  const auto on = flag(request, "on");
  if (!on) return Refused{"on: true or false"};
  world.plant().set_sync_input(*on);
  return kDone;
}

Answer op_floor(World& world, const ProgramState&, const json& request) {
  const auto slope_rad = number(request, "slope_rad", -kFloorMax_rad, kFloorMax_rad);
  if (!slope_rad) return Refused{"slope_rad: -0.5 to 0.5"};
  const auto downhill_rad = number(request, "downhill_rad", -kPi, kPi);
  if (!downhill_rad) return Refused{"downhill_rad: -pi to pi, the heading in which the floor falls"};
  world.plant().tilt_floor(*slope_rad, *downhill_rad);
  return kDone;
}

// Laid just ahead of the casters, across the way.
Answer op_edge(World& world, const json& request, double sign, double length_m) {
  const auto height_m = number(request, "height_m", 0.001, 0.04);
  if (!height_m) return Refused{"height_m: 0.001 to 0.04"};
  const auto which = sides(request);
  if (!which) return bad_sides();
  const PlatformMotion& at = world.plant().platform();
  const double ahead_m = world.plant().params().caster_ahead_m + 0.15;
  const FloorEdge edge{at.x_m + ahead_m * std::cos(at.psi_rad),
                       at.y_m + ahead_m * std::sin(at.psi_rad),
                       at.psi_rad,
                       sign * *height_m,
                       length_m,
                       which->left,
                       which->right};
  if (!world.plant().lay_edge(edge)) return Refused{"op: a wheel still stands on the one before"};
  return kDone;
}
Answer op_sill(World& world, const ProgramState&, const json& request) { return op_edge(world, request, 1.0, 0.08); }
Answer op_step_down(World& world, const ProgramState&, const json& request) { return op_edge(world, request, -1.0, 0.0); }

Answer op_pokeys(World&, const ProgramState& program, const json& request) {
  if (program.pokeys == nullptr) return Refused{"op: there is no PoKeys; start with --pokeys-udp"};
  const auto silent = flag(request, "silent");
  if (!silent) return Refused{"silent: true or false"};
  program.pokeys->set_silent(*silent);
  return kDone;
}

Answer op_strap_cut(World& world, const ProgramState&, const json& request) {
  const auto which = sides(request);
  if (!which) return bad_sides();
  const auto cut = flag(request, "cut");
  if (!cut) return Refused{"cut: true or false"};
  if (!*cut && world.drives_enabled()) return Refused{"op: only while the drives are disabled"};
  if (which->left) world.plant().cut_strap(Side::left, *cut);
  if (which->right) world.plant().cut_strap(Side::right, *cut);
  if (!*cut) world.patient().stand_in_the_middle();
  return kDone;
}

Answer op_loose_box(World& world, const ProgramState&, const json& request) {
  const auto which = node(request);
  if (which != Node::tilt_left && which != Node::tilt_right) return Refused{"node: tilt_left or tilt_right"};
  const auto play_rad = number(request, "play_rad", 0.0, 0.5);
  if (!play_rad) return Refused{"play_rad: 0 to 0.5; 0 is tight"};
  world.plant().loosen_box(*which == Node::tilt_left ? Place::left_strut : Place::right_strut, *play_rad);
  return kDone;
}

Answer op_wish(World& world, const ProgramState&, const json& request) {
  const auto wish_m_s = number(request, "speed_m_s", kWishMin_m_s, kWishMax_m_s);
  if (!wish_m_s) return Refused{"speed_m_s: 0.05 to 0.8"};
  world.patient().set_wish(*wish_m_s);
  return kDone;
}

Answer op_bar(World& world, const ProgramState&, const json& request) {
  const auto dx_m = number(request, "dx_m", -kBarMax_m, kBarMax_m);
  const auto yaw_rad = number(request, "yaw_rad", -kBarMax_rad, kBarMax_rad);
  if (!dx_m) return Refused{"dx_m: -0.25 to 0.25, forward of the middle"};
  if (!yaw_rad) return Refused{"yaw_rad: -0.5 to 0.5, to the left"};
  if (world.drives_enabled()) return Refused{"op: only while the drives are disabled"};
  world.hold_bar(*dx_m, 0.0, *yaw_rad);
  return kDone;
}
Answer op_strap(World& world, const ProgramState&, const json&) {
  if (world.drives_enabled()) return Refused{"op: only while the drives are disabled"};
  world.strap_in();
  return kDone;
}

Answer op_push(World& world, const ProgramState&, const json& request) {
  const auto way_m = number(request, "way_m", -kPlaceMax_m, kPlaceMax_m);
  const auto turn_rad = number(request, "turn_rad", -kPlaceMax_m, kPlaceMax_m);
  if (!way_m) return Refused{"way_m: -100 to 100, forward"};
  if (!turn_rad) return Refused{"turn_rad: -100 to 100, to the left"};
  if (world.drives_enabled()) return Refused{"op: only while the drives are disabled"};
  world.plant().push_by_hand(*way_m, *turn_rad);
  return kDone;
}

Answer op_wire_bumper(World& world, const ProgramState&, const json& request) {
  const auto strip = number(request, "strip", 0, 3);
  const auto bit = number(request, "bit", 0, 255);
  if (!strip || *strip != std::floor(*strip)) return Refused{"strip: 0 front, 1 rear, 2 left, 3 right"};
  if (!bit || *bit != std::floor(*bit) || (*bit > 7 && *bit < 255)) return Refused{"bit: input that it is wired to, 0 to 7; 255 for none"};
  world.plant().wire_bumper(static_cast<std::size_t>(*strip), static_cast<std::uint8_t>(*bit));
  return kDone;
}

Answer op_obstacle(World& world, const ProgramState&, const json& request) {
  const auto x_m = number(request, "x_m", -kPlaceMax_m, kPlaceMax_m);
  const auto y_m = number(request, "y_m", -kPlaceMax_m, kPlaceMax_m);
  const auto radius_m = number(request, "radius_m", 0.01, 10.0);
  if (!x_m || !y_m) return Refused{"x_m, y_m: -100 to 100"};
  if (!radius_m) return Refused{"radius_m: 0.01 to 10"};
  if (!world.plant().add_obstacle({*x_m, *y_m, *radius_m})) return Refused{"op: there is no room for another obstacle"};
  return kDone;
}

Answer op_clear_floor(World& world, const ProgramState&, const json&) {
  world.plant().take_obstacles();
  world.plant().take_edge();
  return kDone;
}

Answer restart(World& world, const Scenario& scenario) {
  if (!world.restart(scenario)) return Refused{"op: only while the drives are disabled and the hoist stands still"};
  return kDone;
}
Answer op_scenario(World& world, const ProgramState&, const json& request) {
  const auto name = text(request, "name");
  const Scenario* scenario = name ? find_scenario(*name) : nullptr;
  if (scenario == nullptr) {
    std::string names;
    for (const Scenario& row : kScenarios) names += (names.empty() ? "" : ", ") + std::string(row.name);
    return Refused{"name: one of " + names};
  }
  return restart(world, *scenario);
}
Answer op_reset(World& world, const ProgramState&, const json&) { return restart(world, world.patient().scenario()); }

Answer op_help(World&, const ProgramState&, const json&);

struct Operation {
  std::string_view name;
  std::string_view meaning;
  Answer (*run)(World&, const ProgramState&, const json&);
};
constexpr std::array kOperations{
    Operation{"state", "the true state of the world", op_state},
    Operation{"witness", "what the drives did after their last command, in the world's own time", op_witness},
    Operation{"line", "cut: the serial line is cut in both directions", op_line},
    Operation{"bumper", "which (front, rear, left, right), pressed", op_bumper},
    Operation{"trip", "the patient falls over its feet; toward forward (as without), backward, left or right", op_trip},
    Operation{"collapse", "the patient's legs give way; toward as in trip", op_collapse},
    Operation{"hang", "the patient hangs forward in the harness", op_hang},
    Operation{"freeze_feet", "seconds: the patient's feet stick to the floor for this long", op_freeze_feet},
    Operation{"unplug", "node: its plug is pulled", op_unplug},
    Operation{"replug", "node: its plug is back", op_replug},
    Operation{"exchange", "node, how (right, reversed, swapped): another part is fitted, with signs or sides that may be wrong",
              op_exchange},
    Operation{"freeze", "node, frozen: its processor stops", op_freeze},
    Operation{"freeze_sensor", "node, frozen: its sensor repeats the last sample", op_freeze_sensor},
    Operation{"slip", "which (left, right, both), seconds, grip_norm, twist_n_m: wheels lose grip while the frame is twisted", op_slip},
    Operation{"battery", "volts of both together, null for what physics gives", op_battery},
    Operation{"power", "on: false opens the motors' relay without a word from the emergency stop", op_power},
    Operation{"short", "which (left, right, both), duty_norm: transistors are shorted, the motor runs whatever its board does; null: whole",
              op_short},
    Operation{"emergency_stop", "pressed: the button on the hoist; opens chain and relay", op_emergency_stop},
    Operation{"configuration_switch", "on: the switch that allows the first set-up of accounts", op_configuration_switch},
    Operation{"sync_input", "on: the line of another recording system, such as a motion capture", op_sync_input},
    Operation{"floor", "slope_rad, downhill_rad: the floor is a ramp that falls in that heading", op_floor},
    Operation{"sill", "height_m, which (left, right, both wheels): a door sill just ahead, instead of the one before", op_sill},
    Operation{"step_down", "height_m, which as in sill: a step down just ahead", op_step_down},
    Operation{"pokeys", "silent: the PoKeys on the network does not answer", op_pokeys},
    Operation{"strap_cut", "which (left, right, both), cut: that strut springs upright and holds nothing", op_strap_cut},
    Operation{"loose_box", "node, play_rad: the tilt box of a strut tips to the side to which it leans", op_loose_box},
    Operation{"wish", "speed_m_s the patient likes to walk", op_wish},
    Operation{"bar", "dx_m, yaw_rad: the patient leaves, the bar is held there by hand; zeros release it", op_bar},
    Operation{"strap", "the patient is strapped in again", op_strap},
    Operation{"push", "way_m, turn_rad: the hoist is pushed by hand, with the drives off", op_push},
    Operation{"wire_bumper", "strip (0 front, 1 rear, 2 left, 3 right), bit: wires it to another input, 255 to none", op_wire_bumper},
    Operation{"obstacle", "x_m, y_m, radius_m: a post on the floor", op_obstacle},
    Operation{"clear_floor", "posts, and the sill or step once no wheel is on it, are taken away", op_clear_floor},
    Operation{"scenario", "name: back at the start mark of that scenario", op_scenario},
    Operation{"reset", "machine and patient back at the start mark", op_reset},
    Operation{"help", "this list", op_help},
};

Answer op_help(World&, const ProgramState&, const json&) {
  json list = json::object();
  for (const Operation& operation : kOperations) list[std::string(operation.name)] = operation.meaning;
  return list;
}

}  // namespace

std::string answer_request(World& world, const ProgramState& program, std::string_view line) {
  const auto refuse = [](const std::string& why) { return json{{"error", why}}.dump(-1, ' ', false, json::error_handler_t::replace); };
  if (line.size() > kRequestMax) return refuse("line: at most 4096 characters");
  const json request = json::parse(line.begin(), line.end(), nullptr, false);
  if (request.is_discarded() || !request.is_object()) return refuse("line: one JSON object");
  const auto op = text(request, "op");
  if (!op) return refuse("op: a word; {\"op\":\"help\"} lists them");
  for (const Operation& operation : kOperations) {
    if (operation.name != *op) continue;
    const Answer answer = operation.run(world, program, request);
    if (const auto* refused = std::get_if<Refused>(&answer)) return refuse(refused->why);
    return std::get<json>(answer).dump(-1, ' ', false, json::error_handler_t::replace);
  }
  return refuse("op: unknown; {\"op\":\"help\"} lists them");
}

}  // namespace hoist::sim
