#include "tests/reactions/reactions.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <sstream>

#include "control/contract/faults.hpp"
#include "tests/support/closed_loop.hpp"

namespace hoist::reactions {
namespace {

using contract::Fault;
using contract::Mode;
using contract::Node;
using tests::ClosedLoop;

// What "braking begins" means for a row.
enum class Begin {
  command,  // the core's braking command has reached the drives: the step that brakes, and a millisecond on the bus
  motor,    // the motors' current falls: the drives act by themselves
};

struct Row {
  const char* hazard;
  const char* fault;   // in words
  const char* answer;  // in words
  // Expected cause in the braking step or the next: a stop for another cause does not count. Fault bits, one of which is enough; none: the
  // core itself is dead.
  contract::FaultBits why;
  int budget_ms;
  Mode mode;
  const char* scenario;
  Begin begin;
  std::function<void(ClosedLoop&)> cause;
  // Start of the hazard; null: at once. For a fall: when the body exceeds the monitor's angle and rate.
  std::function<bool(ClosedLoop&, double& memory)> present;
  // Called in each millisecond after the cause, for lasting causes; may be null.
  std::function<void(ClosedLoop&)> goes_on = nullptr;
  // Called once in STANDBY, before walking; may be null.
  std::function<void(ClosedLoop&)> before = nullptr;
};

contract::FaultBits bit(Fault fault) { return contract::fault_bit(fault); }
int budget(Fault fault) { return static_cast<int>(contract::fault_info(fault).budget_ms); }

// Counted from the guard's own angle and rate, of the body itself.
bool falls(ClosedLoop& loop, double& last_rad) {
  const auto& p = loop.core().params;
  const double lean_rad = std::atan(loop.world().patient().harness().dx_m / p.strut_length_m);
  const double rate_rad_s = (lean_rad - last_rad) / 0.001;
  last_rad = lean_rad;
  return lean_rad > p.fall_tilt_rad && rate_rad_s > p.fall_rate_rad_s;
}

// The stick is held: a partly hanging server still forwards its commands.
void drives_on(ClosedLoop& loop) {
  contract::DriveCommand command;
  command.lease_epoch = loop.record().lease_epoch;
  command.client = loop.record().lease_holder;
  command.sequence = 1'000'000'000 + loop.ticks();
  command.echo_time_ns = loop.record().time_ns;
  command.speed_norm = 1.0;
  command.held = 1;
  loop.put_drive(command);
}

// An engineer's tool writes an object of 2230h: what the left drive knows of its motor's winding.
void write_winding(ClosedLoop& loop, std::uint8_t sub, float value) {
  namespace canopen = contract::canopen;
  const std::uint32_t request = canopen::kSdoRequestBase + contract::node_id(Node::drive_left);
  (void)loop.world().foreign_send(
      canopen::sdo(request, canopen::sdo_download_command(4), 0x2230, sub, std::bit_cast<std::uint32_t>(value)));
}

// A thousand frames a second of an unknown device, at lowest priority.
void babbles(ClosedLoop& loop) { (void)loop.world().foreign_send({0x7F1, 8, 0, {}}); }

const std::vector<Row>& table() {
  const auto unplugs = [](Node node) { return [node](ClosedLoop& l) { l.world().unplug(node, true); }; };
  const auto sticks = [](Node node) { return [node](ClosedLoop& l) { l.world().freeze_sensor(node, true); }; };
  using Encoder = sim::World::EncoderFault;
  static const std::vector<Row> rows = {
      {"H1", "the controller asks for a jump", "protective stop by the gate", bit(Fault::gate_refused), budget(Fault::gate_refused) + 10,
       Mode::user, "straight", Begin::command,
       [](ClosedLoop& l) {
         l.break_core([done = false](core::CoreState& state, core::TickOutputs&) mutable {
           if (!done) state.limiter.start_from(state.params, 0.65, 0.5);
           done = true;
         });
       },
       nullptr},
      // A blocked wheel shows as following error, or by the drive's own fault if that is sooner.
      {"H1", "a wheel is blocked", "protective stop", bit(Fault::overspeed) | bit(Fault::drive_left_fault), budget(Fault::overspeed),
       Mode::user, "straight", Begin::command, [](ClosedLoop& l) { l.world().plant().block_wheel(sim::Side::left, true); }, nullptr},
      // The first reaction, without effect on a shorted bridge, and the last, the relay: the distance counts until standstill.
      {"H1", "a bridge is shorted at full duty", "the drive, then protective stop, then no power",
       bit(Fault::overspeed) | bit(Fault::drive_left_fault), budget(Fault::overspeed), Mode::user, "straight", Begin::command,
       [](ClosedLoop& l) { l.world().plant().short_bridge(sim::Side::left, 1.0); }, nullptr},
      {"H1", "both bridges are shorted at full duty", "the drives, then protective stop, then no power",
       bit(Fault::overspeed) | bit(Fault::drive_left_fault) | bit(Fault::drive_right_fault), budget(Fault::overspeed), Mode::remote,
       "straight", Begin::command,
       [](ClosedLoop& l) {
         l.world().plant().short_bridge(sim::Side::left, 1.0);
         l.world().plant().short_bridge(sim::Side::right, 1.0);
       },
       nullptr},
      {"H1", "both bridges are shorted while the hoist stands by", "the drives, then protective stop, then no power",
       bit(Fault::overspeed) | bit(Fault::drive_left_fault) | bit(Fault::drive_right_fault), budget(Fault::overspeed), Mode::standby,
       "straight", Begin::command,
       [](ClosedLoop& l) {
         l.world().plant().short_bridge(sim::Side::left, 1.0);
         l.world().plant().short_bridge(sim::Side::right, 1.0);
       },
       nullptr},
      {"H2", "an encoder is lost", "the drive, then protective stop", bit(Fault::drive_left_fault), budget(Fault::drive_left_fault),
       Mode::user, "straight", Begin::command, [](ClosedLoop& l) { l.world().break_encoder(Node::drive_left, Encoder::lost); }, nullptr},
      {"H2", "an encoder is reversed", "the drive, then protective stop", bit(Fault::drive_right_fault), budget(Fault::drive_right_fault),
       Mode::user, "straight", Begin::command, [](ClosedLoop& l) { l.world().break_encoder(Node::drive_right, Encoder::reversed); },
       nullptr},
      {"H3", "the left drive is unplugged", "protective stop", bit(Fault::drive_left_lost), budget(Fault::drive_left_lost), Mode::user,
       "straight", Begin::command, unplugs(Node::drive_left), nullptr},
      {"H3", "the right drive is unplugged", "protective stop", bit(Fault::drive_right_lost), budget(Fault::drive_right_lost), Mode::user,
       "straight", Begin::command, unplugs(Node::drive_right), nullptr},
      {"H4", "a strut's sensor is unplugged", "protective stop", bit(Fault::tilt_left_lost), budget(Fault::tilt_left_lost), Mode::user,
       "straight", Begin::command, unplugs(Node::tilt_left), nullptr},
      {"H4", "the chassis' sensor is unplugged", "protective stop", bit(Fault::tilt_base_lost), budget(Fault::tilt_base_lost), Mode::user,
       "straight", Begin::command, unplugs(Node::tilt_base), nullptr},
      {"H4", "a strut's processor stands", "protective stop", bit(Fault::tilt_right_lost), budget(Fault::tilt_right_lost), Mode::user,
       "straight", Begin::command, [](ClosedLoop& l) { l.world().freeze(Node::tilt_right, true); }, nullptr},
      {"H5", "the bus is down, and the core sees it", "the drives by themselves", bit(Fault::bus_down), budget(Fault::bus_down), Mode::user,
       "straight", Begin::motor, [](ClosedLoop& l) { l.set_bus_up(false); }, nullptr},
      {"H5 H23", "the control program is dead", "the drives by themselves", 0, 60, Mode::user, "straight", Begin::motor,
       [](ClosedLoop& l) { l.kill_core(); }, nullptr},
      {"H6", "a strut's chip repeats its sample", "protective stop", bit(Fault::tilt_frozen), budget(Fault::tilt_frozen), Mode::user,
       "straight", Begin::command, sticks(Node::tilt_left), nullptr},
      {"H6", "the chassis' chip repeats its sample", "protective stop", bit(Fault::tilt_frozen), budget(Fault::tilt_frozen), Mode::user,
       "straight", Begin::command, sticks(Node::tilt_base), nullptr},
      {"H9", "the floor tilts, from 8° of the chassis", "protective stop", bit(Fault::base_tilted), budget(Fault::base_tilted), Mode::user,
       "straight", Begin::command, [](ClosedLoop& l) { l.world().plant().tilt_floor(10.0 * sim::kDegree_rad, 0.0); },
       [](ClosedLoop& l, double&) {
         return std::hypot(l.world().plant().chassis_alpha_rad(), l.world().plant().chassis_beta_rad()) > 8.0 * sim::kDegree_rad;
       }},
      {"H12", "the batteries break down", "soft stop", bit(Fault::battery_empty), budget(Fault::battery_empty), Mode::user, "straight",
       Begin::command, [](ClosedLoop& l) { l.world().plant().force_battery(21.0); }, nullptr},
      {"H12", "the supply jumps to 31 V, where the drives brake half", "soft stop", bit(Fault::supply_high), budget(Fault::supply_high),
       Mode::user, "straight", Begin::command, [](ClosedLoop& l) { l.world().plant().force_battery(31.0); }, nullptr},
      {"H13", "the front bumper is pressed", "stop at 1.5 m/s²", bit(Fault::bumper_pressed), budget(Fault::bumper_pressed), Mode::user,
       "straight", Begin::command, [](ClosedLoop& l) { l.world().plant().force_bumper(0, true); }, nullptr},
      {"H14", "the input node is unplugged", "protective stop", bit(Fault::io_lost), budget(Fault::io_lost), Mode::user, "straight",
       Begin::command, unplugs(Node::io), nullptr},
      {"H15", "the patient stumbles; the body is at 10° and 25°/s", "protective stop", bit(Fault::fall_detected),
       budget(Fault::fall_detected), Mode::user, "straight", Begin::command, [](ClosedLoop& l) { l.world().patient().trip(); }, falls},
      {"H7", "a strut's chip gives nonsense", "protective stop", bit(Fault::tilt_implausible), budget(Fault::tilt_implausible), Mode::user,
       "straight", Begin::command, [](ClosedLoop& l) { l.world().break_sensor(Node::tilt_left, sim::World::SensorFault::garbage, 1.0); },
       nullptr},
      {"H10", "both wheels lose the floor and the machine is twisted", "soft stop", bit(Fault::wheel_slip), budget(Fault::wheel_slip),
       Mode::user, "straight", Begin::command,
       [](ClosedLoop& l) {
         l.world().slip({3.0, {0.05, 0.05}, 0.0, 25.0});
       },
       nullptr},
      {"H16", "the patient hangs; the body is at 10.5°", "soft stop", bit(Fault::patient_hanging), budget(Fault::patient_hanging),
       Mode::user, "straight", Begin::command, [](ClosedLoop& l) { l.world().patient().hang(); },
       [](ClosedLoop& l, double&) { return std::atan(l.world().patient().harness().dx_m / 0.8) > 10.5 * sim::kDegree_rad; }},
      {"H17", "the radio link is cut", "stop at 0.8 m/s²", bit(Fault::remote_command_lost), budget(Fault::remote_command_lost),
       Mode::remote, "straight", Begin::command, [](ClosedLoop& l) { l.cut_link(true); }, nullptr},
      // Stick commands still arrive: only the server's heartbeat has stopped.
      {"H21", "the server dies while a therapist drives", "stop at 0.8 m/s²", bit(Fault::server_lost), budget(Fault::server_lost),
       Mode::remote, "straight", Begin::command, [](ClosedLoop& l) { l.stop_server(); }, nullptr, drives_on},
      {"H22", "a step is 35 ms late", "protective stop", bit(Fault::loop_overrun), budget(Fault::loop_overrun), Mode::user, "straight",
       Begin::command, [](ClosedLoop& l) { l.be_late(0.035); }, nullptr},
      // By the sensor's own check, or before it because the struts lean apart.
      {"H8", "a strut's gyroscope loses its zero by 20°/s", "protective stop", bit(Fault::tilt_sensor_fault) | bit(Fault::tilt_implausible),
       1000, Mode::user, "straight", Begin::command, [](ClosedLoop& l) { l.world().plant().jump_gyro_bias(sim::Place::left_strut, 0.35); },
       nullptr},
      // The winding is warm after power-on and stays so here; then its limit is lowered below that.
      {"H11", "a motor's winding is over its limit", "the drive, then protective stop", bit(Fault::drive_left_fault),
       budget(Fault::drive_left_fault), Mode::user, "straight", Begin::command, [](ClosedLoop& l) { write_winding(l, 2, 80); }, nullptr,
       nullptr,
       [](ClosedLoop& l) {
         write_winding(l, 3, 60);
         write_winding(l, 5, 3600);
       }},
      {"H30", "a stranger floods the bus", "protective stop", bit(Fault::node_babbling), budget(Fault::node_babbling), Mode::user,
       "straight", Begin::command, [](ClosedLoop&) {}, nullptr, babbles},
      {"2.3", "the emergency stop is pressed", "no power, brakes", bit(Fault::emergency_stop), budget(Fault::emergency_stop) + 10,
       Mode::user, "straight", Begin::command, [](ClosedLoop& l) { l.world().plant().press_emergency_stop(true); }, nullptr},
      {"2.3", "STOP on the console", "protective stop", bit(Fault::stop_pressed), budget(Fault::stop_pressed) + 10, Mode::user, "straight",
       Begin::command, [](ClosedLoop& l) { l.ask(contract::CommandKind::stop); }, nullptr},
  };
  return rows;
}

// Without power nothing is commanded.
bool brakes(ClosedLoop& loop) { return loop.core().in_mode.braking != core::Braking::none || loop.mode() == Mode::emergency_stop; }

// The hoist and each of its wheels: a spinning hoist is not at rest.
bool stands(ClosedLoop& loop) {
  const sim::Plant& plant = loop.world().plant();
  return std::fabs(plant.platform().speed_m_s) < 0.01 && std::fabs(plant.wheel_speed_m_s(sim::Side::left)) < 0.02 &&
         std::fabs(plant.wheel_speed_m_s(sim::Side::right)) < 0.02;
}

double speed_m_s(ClosedLoop& loop) { return loop.world().plant().platform().speed_m_s; }

bool set_off(ClosedLoop& loop, const Row& row, double wish_m_s) {
  if (row.mode == Mode::standby) return loop.run_until([&] { return loop.mode() == Mode::standby; }, 10.0);
  if (!loop.start(row.mode)) return false;
  if (row.mode == Mode::remote) {
    loop.hold_stick(1.0, 0.0);
    const double top_m_s = 0.85 * loop.core().params.remote_speed_m_s_max;
    return loop.run_until([&] { return speed_m_s(loop) > top_m_s; }, 8.0);
  }
  return loop.run_until([&] { return speed_m_s(loop) > 0.85 * wish_m_s; }, 15.0);
}

// One try; adds to the row's figures.
void once(const Row& row, int number, Reaction& result, const sim::PlantParams& plant = {}) {
  tests::ClosedLoopOptions options;
  options.world.plant = plant;
  options.world.seed = static_cast<std::uint64_t>(number) + 1;
  options.world.scenario = sim::find_scenario(row.scenario);
  options.world.patient.wish_m_s = 0.30 + 0.05 * (number % 4);
  options.world.patient.yields_after_s =
      sim::PatientParams::kStubborn_s;  // the patient, who keeps leaning while the machine does something else
  ClosedLoop loop(options);
  ++result.tries;
  if (row.before && loop.run_until([&] { return loop.mode() == Mode::standby; }, 10.0)) row.before(loop);
  if (!set_off(loop, row, options.world.patient.wish_m_s)) {
    ++result.missed;
    return;
  }
  loop.run(0.13 * (number % 7));  // somewhere else in the stride

  // The fault comes in one millisecond of the step; all times are counted in these.
  long now_ms = 0, fault_ms = -1, begin_ms = -1, stopped_ms = -1;
  const long cause_ms = 100 + (number * 7) % 10;
  double memory = 0, current_a = 0, begin_m = 0, stopped_m = 0;
  bool caused = false, for_this = row.why == 0;
  std::size_t events_before = 0;
  const auto raised = [&] {
    return std::any_of(
        loop.events().begin() + static_cast<std::ptrdiff_t>(events_before), loop.events().end(),
        [&](const contract::Event& e) { return e.kind == contract::EventKind::fault_raised && (row.why >> e.code & 1U) != 0; });
  };
  loop.on_millisecond([&] {
    ++now_ms;
    sim::World& world = loop.world();
    const double current_now_a = world.plant().motor_current_a(sim::Side::left) + world.plant().motor_current_a(sim::Side::right);
    if (!caused && now_ms >= cause_ms) {
      caused = true;
      events_before = loop.events().size();
      row.cause(loop);
    }
    if (caused && row.goes_on) row.goes_on(loop);
    const bool present = row.present == nullptr ? caused : row.present(loop, memory);
    if (fault_ms < 0 && caused && present) {
      fault_ms = now_ms;
      begin_m = world.plant().platform().x_m;
      current_a = current_now_a;
    }
    if (fault_ms < 0) return;
    if (row.begin == Begin::motor && begin_ms < 0 && current_now_a < current_a - 0.6) begin_ms = now_ms;
    if (stopped_ms < 0 && begin_ms >= 0 && stands(loop)) {
      stopped_ms = now_ms;
      stopped_m = world.plant().platform().x_m;
    }
  });
  while (now_ms < 12000 && (begin_ms < 0 || stopped_ms < 0)) {
    const long step_ms = now_ms;
    loop.step();
    // The step decides at its beginning; its two commands are on the bus within a millisecond.
    if (row.begin == Begin::command && fault_ms >= 0 && begin_ms < 0 && brakes(loop)) {
      begin_ms = step_ms + 1;
    }
    // A mode reports the cause of braking to the monitors in the next step.
    if (row.begin == Begin::command && begin_ms >= 0 && now_ms < begin_ms + 20) for_this = for_this || raised();
    // The drives may have braked before the core detects it.
    if (row.begin == Begin::motor && caused) for_this = for_this || raised();
  }
  if (!for_this || fault_ms < 0 || begin_ms < 0 || stopped_ms < 0) {
    ++result.missed;
    return;
  }
  // A fall may be seen before the body has reached the angle that is counted from: the filter may also show too much.
  const long reaction_ms = std::max(0L, begin_ms - fault_ms);
  result.worst_ms = std::max(result.worst_ms, static_cast<int>(reaction_ms));
  result.stopped_ms = std::max(result.stopped_ms, static_cast<int>(stopped_ms - fault_ms));
  result.distance_cm = std::max(result.distance_cm, static_cast<int>(std::ceil((stopped_m - begin_m) * 100.0)));
}

}  // namespace

std::vector<Reaction> measure(int tries) {
  std::vector<Reaction> results;
  for (const Row& row : table()) {
    Reaction result{row.hazard, row.fault, row.answer, row.budget_ms};
    for (int i = 0; i < tries; ++i) once(row, i, result);
    results.push_back(result);
  }
  return results;
}

std::vector<Machine> measure_machines(int tries) {
  const auto frame = [](double casters_ahead_m, double driven_load_norm) {
    sim::PlantParams plant;
    plant.caster_ahead_m = casters_ahead_m;
    plant.driven_load_norm = driven_load_norm;
    return plant;
  };
  sim::PlantParams heavy_rotors, quick_brakes, slow_brakes, slow_gyros;
  heavy_rotors.rotor_inertia_kg_m2 = 4.3e-4;
  quick_brakes.brake_close_s = 0.0;
  slow_brakes.brake_close_s = 0.10;
  slow_gyros.imu.gyro_late_s = 0.0098;
  const std::vector<std::pair<const char*, sim::PlantParams>> machines{
      {"as above: casters 0.8 m ahead, 85 % of the weight on the driven axle", {}},
      {"casters 1.0 m ahead", frame(1.0, 0.85)},
      {"casters 0.6 m ahead", frame(0.6, 0.85)},
      {"70 % on the driven axle", frame(0.8, 0.7)},
      {"casters 0.5 m ahead, 70 % on the driven axle", frame(0.5, 0.7)},
      {"rotors of 4.3e-4 kg m² in place of 1.0e-4", heavy_rotors},
      {"brakes that close at once in place of 50 ms", quick_brakes},
      {"brakes that close after 100 ms", slow_brakes},
      {"gyroscopes 9.8 ms late in place of 4.9", slow_gyros}};
  std::vector<Machine> results;
  for (const auto& [what, plant] : machines) {
    Machine machine{what, {}, {}};
    for (const Row& row : table()) {
      const bool falls = std::string_view(row.hazard) == "H15";
      if (!falls && row.why != bit(Fault::emergency_stop)) continue;
      for (int i = 0; i < tries; ++i) once(row, i, falls ? machine.fall : machine.emergency_stop, plant);
    }
    results.push_back(machine);
  }
  return results;
}

std::string page(const std::vector<Reaction>& rows, const std::vector<Machine>& machines) {
  std::ostringstream text;
  text << "<!-- Made by `deploy/dev trace --write`: measured, not written. Do not edit. -->\n"
          "# How fast each hazard is answered\n\n"
          "From the fault to the beginning of braking at the drives and to rest, in the whole loop in virtual time: the real control step, "
          "the\n"
          "shipped nodes' sources, the bus, the machine and a walking patient at 0.30 to 0.45 m/s (a therapist driving at the driving "
          "speed limit\n"
          "for H17, H21 and where both bridges are shorted; in H21 the commands go on arriving). Each fault is tried "
       << kPageTries
       << " times, at every millisecond of the control step and in\n"
          "different moments of the stride; the worst counts, and a stop only when the hoist says that it stopped for this. "
          "`test_reactions` repeats\n"
          "some of them and fails when one is slower than its budget or than this page says. Rows whose budget\n"
          "is that of a single step have one step more here: the fault comes at any moment between two. H15 is counted from the\n"
          "guard's 10° and 25°/s of the body itself. The guard acts within 30 ms of what the published tilt filter shows, and that is up "
          "to 2°\n"
          "and 4°/s less than a walking patient's body has: this is what the longer budget allows for.\n\n"
          "| hazard | fault | answer | budget | worst reaction | worst time to rest | longest way |\n|---|---|---|---|---|---|---|\n";
  for (const Reaction& row : rows)
    text << "| " << row.hazard << " | " << row.fault << " | " << row.answer << " | " << row.budget_ms << " ms | " << row.worst_ms
         << " ms | " << row.stopped_ms << " ms | " << row.distance_cm << " cm |\n";
  text << "\n## Other machines\n\n"
          "What the simulator assumes of the machine, one thing at a time, for a patient who stumbles and for the emergency stop, each of "
       << kPageTries
       << "\ntries. *Dragged*: not at rest after 12 s, or stopped for another cause. A body in the harness pulls forward at 0.8 m: it "
          "takes load\n"
          "off the driven wheels and puts it on the casters, so that held wheels may slide.\n\n"
          "| machine | fall: worst reaction | to rest | longest way | dragged | emergency stop: to rest | longest way |\n"
          "|---|---|---|---|---|---|---|\n";
  for (const Machine& machine : machines)
    text << "| " << machine.what << " | " << machine.fall.worst_ms << " ms | " << machine.fall.stopped_ms << " ms | "
         << machine.fall.distance_cm << " cm | " << machine.fall.missed << " | " << machine.emergency_stop.stopped_ms << " ms | "
         << machine.emergency_stop.distance_cm << " cm |\n";
  return text.str();
}

Reaction read_row(std::string_view page, std::string_view fault) {
  Reaction row;
  std::istringstream lines{std::string(page)};
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> cells;
    std::istringstream parts(line);
    for (std::string cell; std::getline(parts, cell, '|');) cells.push_back(cell);
    if (cells.size() < 8 || cells[2] != " " + std::string(fault) + " ") continue;
    row = {cells[1],
           std::string(fault),
           cells[3],
           std::atoi(cells[4].c_str()),
           std::atoi(cells[5].c_str()),
           std::atoi(cells[6].c_str()),
           std::atoi(cells[7].c_str()),
           1,
           0};
  }
  return row;
}

}  // namespace hoist::reactions
