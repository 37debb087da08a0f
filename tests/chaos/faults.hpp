// What may break in a random session: the list of SOURCES 2.4, one row each, and the plan of one session.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/can_dictionary.hpp"
#include "tests/chaos/dice.hpp"

namespace hoist::chaos {

enum class Kind : std::uint8_t {
  unplug,
  loose_plug,
  freeze,
  reboot,
  bus_off,
  drop,
  corrupt,
  delay,
  duplicate,
  babble,
  garbage_frames,
  serial_noise,
  sensor_stuck,
  sensor_offset,
  sensor_garbage,
  sensor_slow,
  sensor_silent,
  gyro_jump,
  encoder_lost,
  encoder_reversed,
  slip,
  wheel_blocked,
  bridge_shorted,
  battery,
  power_cut,
  emergency_stop,
  bumper,
  obstacle,
  slope,
  trip,
  collapse,
  hang,
  pelvis_turned,
  core_bus_off,
  core_late,
  core_stall,
  core_crash,
  server_hang,
  server_crash,
  link_loss,
  link_stall,
  link_jitter,
  tab_freeze,
  second_client,
  take_over,
  replay,
  parameter_push,
  logout,
  disk_full,
  disk_slow,
  disk_error,
  disk_power_cut,
  clock_jump,
  battery_weak,
  skid,
  fall_aside,
  faint,
  shove,
  held,
  battery_full,
  bridges_shorted,
  sill,
  step_down,
  wrong_part,
  strap_cut,
  loose_strut,
  touch_in_stop,
  mute_core,
  lone_therapist,
  other_console,
  held_before,
  tuned_twice,
  supply_rises,
  count
};

enum class Target : std::uint8_t { nothing, any_node, tilt, strut, drive };

struct KindInfo {
  Kind kind;
  std::string_view name;
  Target target;
  bool outside;  // server, network, disk, clock: must not affect patient-led walking (I12)
  bool disk;     // needs the recorder
};

inline constexpr std::array kKinds{
    KindInfo{Kind::unplug, "unplug", Target::any_node, false, false},
    KindInfo{Kind::loose_plug, "loose_plug", Target::any_node, false, false},
    KindInfo{Kind::freeze, "freeze", Target::any_node, false, false},
    KindInfo{Kind::reboot, "reboot", Target::any_node, false, false},
    KindInfo{Kind::bus_off, "bus_off", Target::any_node, false, false},
    KindInfo{Kind::drop, "drop", Target::any_node, false, false},
    KindInfo{Kind::corrupt, "corrupt", Target::any_node, false, false},
    KindInfo{Kind::delay, "delay", Target::any_node, false, false},
    KindInfo{Kind::duplicate, "duplicate", Target::any_node, false, false},
    KindInfo{Kind::babble, "babble", Target::nothing, false, false},
    KindInfo{Kind::garbage_frames, "garbage_frames", Target::nothing, false, false},
    KindInfo{Kind::serial_noise, "serial_noise", Target::nothing, false, false},
    KindInfo{Kind::sensor_stuck, "sensor_stuck", Target::tilt, false, false},
    KindInfo{Kind::sensor_offset, "sensor_offset", Target::tilt, false, false},
    KindInfo{Kind::sensor_garbage, "sensor_garbage", Target::tilt, false, false},
    KindInfo{Kind::sensor_slow, "sensor_slow", Target::tilt, false, false},
    KindInfo{Kind::sensor_silent, "sensor_silent", Target::tilt, false, false},
    KindInfo{Kind::gyro_jump, "gyro_jump", Target::tilt, false, false},
    KindInfo{Kind::encoder_lost, "encoder_lost", Target::drive, false, false},
    KindInfo{Kind::encoder_reversed, "encoder_reversed", Target::drive, false, false},
    KindInfo{Kind::slip, "slip", Target::drive, false, false},
    KindInfo{Kind::wheel_blocked, "wheel_blocked", Target::drive, false, false},
    KindInfo{Kind::bridge_shorted, "bridge_shorted", Target::drive, false, false},
    KindInfo{Kind::battery, "battery", Target::nothing, false, false},
    KindInfo{Kind::power_cut, "power_cut", Target::nothing, false, false},
    KindInfo{Kind::emergency_stop, "emergency_stop", Target::nothing, false, false},
    KindInfo{Kind::bumper, "bumper", Target::nothing, false, false},
    KindInfo{Kind::obstacle, "obstacle", Target::nothing, false, false},
    KindInfo{Kind::slope, "slope", Target::nothing, false, false},
    KindInfo{Kind::trip, "trip", Target::nothing, false, false},
    KindInfo{Kind::collapse, "collapse", Target::nothing, false, false},
    KindInfo{Kind::hang, "hang", Target::nothing, false, false},
    KindInfo{Kind::pelvis_turned, "pelvis_turned", Target::nothing, false, false},
    KindInfo{Kind::core_bus_off, "core_bus_off", Target::nothing, false, false},
    KindInfo{Kind::core_late, "core_late", Target::nothing, false, false},
    KindInfo{Kind::core_stall, "core_stall", Target::nothing, false, false},
    KindInfo{Kind::core_crash, "core_crash", Target::nothing, false, false},
    KindInfo{Kind::server_hang, "server_hang", Target::nothing, true, true},
    KindInfo{Kind::server_crash, "server_crash", Target::nothing, true, true},
    KindInfo{Kind::link_loss, "link_loss", Target::nothing, true, false},
    KindInfo{Kind::link_stall, "link_stall", Target::nothing, true, false},
    KindInfo{Kind::link_jitter, "link_jitter", Target::nothing, true, false},
    KindInfo{Kind::tab_freeze, "tab_freeze", Target::nothing, true, false},
    KindInfo{Kind::second_client, "second_client", Target::nothing, true, false},
    KindInfo{Kind::take_over, "take_over", Target::nothing, true, false},
    KindInfo{Kind::replay, "replay", Target::nothing, true, false},
    KindInfo{Kind::parameter_push, "parameter_push", Target::nothing, false, false},
    KindInfo{Kind::logout, "logout", Target::nothing, true, false},
    KindInfo{Kind::disk_full, "disk_full", Target::nothing, true, true},
    KindInfo{Kind::disk_slow, "disk_slow", Target::nothing, true, true},
    KindInfo{Kind::disk_error, "disk_error", Target::nothing, true, true},
    KindInfo{Kind::disk_power_cut, "disk_power_cut", Target::nothing, true, true},
    KindInfo{Kind::clock_jump, "clock_jump", Target::nothing, true, true},
    KindInfo{Kind::battery_weak, "battery_weak", Target::nothing, false, false},
    KindInfo{Kind::skid, "skid", Target::nothing, false, false},
    KindInfo{Kind::fall_aside, "fall_aside", Target::nothing, false, false},
    KindInfo{Kind::faint, "faint", Target::nothing, false, false},
    KindInfo{Kind::shove, "shove", Target::nothing, false, false},
    KindInfo{Kind::held, "held", Target::nothing, false, false},
    KindInfo{Kind::battery_full, "battery_full", Target::nothing, false, false},
    KindInfo{Kind::bridges_shorted, "bridges_shorted", Target::nothing, false, false},
    KindInfo{Kind::sill, "sill", Target::nothing, false, false},
    KindInfo{Kind::step_down, "step_down", Target::nothing, false, false},
    KindInfo{Kind::wrong_part, "wrong_part", Target::any_node, false, false},
    KindInfo{Kind::strap_cut, "strap_cut", Target::nothing, false, false},
    KindInfo{Kind::loose_strut, "loose_strut", Target::strut, false, false},
    KindInfo{Kind::touch_in_stop, "touch_in_stop", Target::nothing, false, false},
    KindInfo{Kind::mute_core, "mute_core", Target::nothing, false, false},
    KindInfo{Kind::lone_therapist, "lone_therapist", Target::nothing, true, false},
    KindInfo{Kind::other_console, "other_console", Target::nothing, true, false},
    KindInfo{Kind::held_before, "held_before", Target::nothing, true, false},
    KindInfo{Kind::tuned_twice, "tuned_twice", Target::nothing, false, false},
    KindInfo{Kind::supply_rises, "supply_rises", Target::nothing, false, false},
};
constexpr const KindInfo& info(Kind kind) { return kKinds[static_cast<std::size_t>(kind)]; }
static_assert([] {
  for (std::size_t i = 0; i < kKinds.size(); ++i)
    if (kKinds[i].kind != static_cast<Kind>(i)) return false;
  return kKinds.size() == static_cast<std::size_t>(Kind::count);
}());

struct Fault {
  Kind kind{};
  contract::Node node{};
  double start_s{}, end_s{};
  double size{};  // 0 to 1, what it means depends on the kind
};

/// Kinds from here on are drawn from a stream of their own: the rest of a seed's plan is what it was without them.
inline constexpr Kind kFirstLater = Kind::fall_aside;
/// And from here on from a third one.
inline constexpr Kind kFirstPart = Kind::sill;
/// And from here on from a fourth one; they wait for the moment in which they matter (moments.hpp), up to a minute and a half.
inline constexpr Kind kFirstMoment = Kind::touch_in_stop;
/// And from here on from a fifth one; they build up for up to a minute.
inline constexpr Kind kFirstSlow = Kind::supply_rises;

/// Up to `most` faults of one session, by its seed, and one more of each later group of kinds. `outside_only`: only faults that must not affect
/// walking that a patient leads.
[[nodiscard]] std::vector<Fault> plan_faults(std::uint64_t seed, int most, double length_s, bool outside_only);

/// "unplug:io:12.5:14:0.3,bumper::20:21:0.9", as --faults takes it and the file of kept sessions holds it. "-" is no fault at all.
[[nodiscard]] std::string faults_text(const std::vector<Fault>& faults);
/// Empty for an invalid text.
[[nodiscard]] std::optional<std::vector<Fault>> read_faults(std::string_view text);

}  // namespace hoist::chaos
