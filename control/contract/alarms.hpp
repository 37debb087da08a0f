// Typed view of alarms.def: the sounds and lights of alarms by priority. The core decides which (core/output/alarm_signal.hpp), the input node
// and the console play them.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "control/contract/check.hpp"
#include "control/contract/faults.hpp"

namespace hoist::contract {

enum class AlarmColour : std::uint8_t { cyan, yellow, red };
inline constexpr std::array<std::string_view, 3> kAlarmColourNames{"cyan", "yellow", "red"};

struct AlarmInfo {
  Priority priority;
  AlarmColour colour;
  std::uint8_t pulses;
  std::uint16_t pulse_ms, spacing_ms, interburst_ms, flash_ms, lit_ms;
};
/// In the order of Priority.
inline constexpr std::array kAlarms{
#define HOIST_ALARM(priority, colour, pulses, pulse_ms, spacing_ms, interburst_ms, flash_ms, lit_ms) \
  AlarmInfo{Priority::priority, AlarmColour::colour, pulses, pulse_ms, spacing_ms, interburst_ms, flash_ms, lit_ms},
#include "control/contract/alarms.def"
#undef HOIST_ALARM
};

/// What sounds or is lit: nothing, or the signal of a priority.
enum class AlarmLevel : std::uint8_t { none, low, medium, high };
constexpr AlarmLevel alarm_level(Priority priority) { return static_cast<AlarmLevel>(static_cast<unsigned>(priority) + 1U); }
/// The signal of a level other than none.
constexpr const AlarmInfo& alarm_info(AlarmLevel level) { return kAlarms[static_cast<std::size_t>(level) - 1U]; }

/// The most urgent of these faults.
constexpr AlarmLevel alarm_level(FaultBits faults) {
  AlarmLevel most = AlarmLevel::none;
  for (const FaultInfo& info : kFaults)
    if ((faults & fault_bit(info)) != 0 && alarm_level(info.priority) > most) most = alarm_level(info.priority);
  return most;
}

/// How long sound is paused at the most: by then it has to be asked for again.
inline constexpr double kAudioPause_s = 120.0;
/// Silence between the two groups of five of a burst.
inline constexpr std::uint16_t kGroupGap_ms = 600;
/// Pitch of a pulse, and how many harmonics lie above it, for those who make the sound themselves.
inline constexpr double kAlarmPitch_hz = 523.25;
inline constexpr unsigned kAlarmHarmonics = 4;

/// Silence after pulse `pulse` of a burst, counted from 0.
constexpr std::uint16_t alarm_gap_ms(const AlarmInfo& alarm, unsigned pulse) {
  constexpr unsigned kGroup = 5, kRun = 3;
  if (pulse + 1U >= alarm.pulses) return alarm.interburst_ms;
  if (alarm.pulses <= kRun) return alarm.spacing_ms;
  if (pulse % kGroup == kRun - 1U) return static_cast<std::uint16_t>(2U * alarm.spacing_ms + alarm.pulse_ms);
  return pulse % kGroup == kGroup - 1U ? kGroupGap_ms : alarm.spacing_ms;
}

/// What the core tells the input node in one byte (2400h:1): bits 0 and 1 the level that sounds, 2 and 3 the one that is lit.
struct AlarmCommand {
  AlarmLevel sound = AlarmLevel::none, light = AlarmLevel::none;
};
constexpr std::uint8_t alarm_byte(AlarmCommand command) {
  return static_cast<std::uint8_t>(static_cast<unsigned>(command.sound) | static_cast<unsigned>(command.light) << 2U);
}
constexpr AlarmCommand alarm_command(std::uint8_t byte) {
  return {static_cast<AlarmLevel>(byte & 3U), static_cast<AlarmLevel>(byte >> 2U & 3U)};
}

// The ranges of IEC 60601-1-8 (control/SOURCES.md, section 2.5).
static_assert(kAlarms.size() == 3 &&
                  all_rows(kAlarms, [](const AlarmInfo& a) { return &a == &kAlarms[static_cast<std::size_t>(a.priority)]; }),
              "alarms.def: one row for each priority, in their order");
static_assert(all_rows(kAlarms,
                       [](const AlarmInfo& a) {
                         switch (a.priority) {
                           case Priority::high:
                             return a.pulses == 10 && a.pulse_ms >= 75 && a.pulse_ms <= 200 && a.spacing_ms >= 50 && a.spacing_ms <= 125 &&
                                    a.interburst_ms >= 2500 && a.interburst_ms <= 15000;
                           case Priority::medium:
                             return a.pulses == 3 && a.pulse_ms >= 125 && a.pulse_ms <= 250 && a.spacing_ms >= 125 && a.spacing_ms <= 250 &&
                                    a.interburst_ms >= 2500 && a.interburst_ms <= 30000;
                           default:
                             return a.pulses <= 2 && a.pulse_ms >= 125 && a.pulse_ms <= 250 && a.interburst_ms > 15000;
                         }
                       }),
              "alarms.def: a burst is outside the ranges of its priority");
static_assert(all_rows(kAlarms,
                       [](const AlarmInfo& a) {
                         const bool lit = a.lit_ms * 5 >= a.flash_ms && a.lit_ms * 5 <= a.flash_ms * 3;  // 20 to 60 %
                         switch (a.priority) {
                           case Priority::high:  // 1.4 to 2.8 Hz
                             return a.colour == AlarmColour::red && a.flash_ms * 14 <= 10000 && a.flash_ms * 28 >= 10000 && lit;
                           case Priority::medium:  // 0.4 to 0.8 Hz
                             return a.colour == AlarmColour::yellow && a.flash_ms * 4 <= 10000 && a.flash_ms * 8 >= 10000 && lit;
                           default:
                             return a.colour == AlarmColour::cyan && a.flash_ms == 0;
                         }
                       }),
              "alarms.def: a light is outside the ranges of its priority");
static_assert(kGroupGap_ms >= 350 && kGroupGap_ms <= 1300, "alarms.hpp: the gap between the groups");
static_assert(kAlarmPitch_hz >= 150 && kAlarmPitch_hz <= 1000 && kAlarmHarmonics >= 4 && 2 * kAlarmPitch_hz >= 300 &&
                  (kAlarmHarmonics + 1) * kAlarmPitch_hz <= 4000,
              "alarms.hpp: pitch or harmonics");

}  // namespace hoist::contract
