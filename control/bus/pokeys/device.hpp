// One polled PoKeys device: digital inputs every 10 ms, analogue ones every 100 ms, one request at a time. A state machine without clock
// and threads; step() gets the time.
//
// Values count only after the device has identified itself as a PoKeys with correctly configured pins.
#pragma once
#include <array>
#include <cstdint>

#include "control/bus/pokeys/transport.hpp"

namespace hoist::bus::pokeys {

// Use of the pins. Bumpers are contacts that are closed to ground while nothing is touched, on inputs with pull-up: a pressed strip and a
// cut wire both read 1.
struct Wiring {
  std::array<std::uint8_t, 4> bumper_pins{1, 2, 3, 4};  // front, rear, left, right
  std::array<std::uint8_t, 4> switch_pins{5, 6, 7, 8};  // the bit is the pin's level
  std::array<std::uint8_t, 2> battery_pins{41, 42};
  std::uint8_t sync_pin = 0;   // output with the synchronisation pulses; 0 = none
  double full_scale_v = 20.0;  // battery voltage that the divider turns into the converter's largest count
};

struct Readings {
  std::uint64_t inputs_ns = 0;  // when their request was sent; 0 = never
  std::uint8_t bumpers = 0;     // bit set = pressed
  std::uint8_t switches = 0;
  std::uint64_t batteries_ns = 0;
  std::array<std::uint16_t, 2> battery_10mv{};
};

struct DeviceCounters {
  std::uint32_t replies = 0;     // good ones
  std::uint32_t unanswered = 0;  // requests given up
  std::uint32_t refused = 0;     // packets of wrong size, mark, checksum, command or content
  std::uint32_t late = 0;        // answers after their request's timeout
  std::uint32_t opened = 0;
};

class Device {
 public:
  Device(Transport& transport, const Wiring& wiring) : transport_(transport), wiring_(wiring) {}

  // Does what is due. Call it when a packet may be there and at next_ns().
  void step(std::uint64_t now_ns);
  [[nodiscard]] std::uint64_t next_ns() const { return next_ns_; }
  // The level of the synchronisation output; it leaves with the next poll of the inputs.
  void set_sync(bool on) { sync_ = on; }
  [[nodiscard]] const Readings& readings() const { return readings_; }
  [[nodiscard]] const DeviceCounters& counters() const { return counters_; }
  // Why there are no readings; empty while there are.
  [[nodiscard]] const char* problem() const { return problem_; }

  static constexpr std::uint64_t kInputsEveryNs = 10'000'000;
  static constexpr std::uint64_t kAnalogueEveryNs = 100'000'000;
  static constexpr std::uint64_t kAnswerNs =
      30'000'000;  // on USB an answer takes 1 ms; three of these fit into the 100 ms of a stale value
  static constexpr std::uint64_t kSilenceNs = 500'000'000;        // then the device is reopened
  static constexpr std::uint64_t kRetryNs = 200'000'000;          // between tries to open
  static constexpr std::uint64_t kWrongDeviceNs = 2'000'000'000;  // until an unsuitable device is tried again
  static constexpr int kPacketsPerStep = 32;                      // bounds the work of one step even on a flood

 private:
  enum class Stage : std::uint8_t { closed, identify, pins, running };
  void close(std::uint64_t now_ns, const char* why, std::uint64_t rest_ns);
  void take(const Packet& packet, std::uint64_t now_ns);
  void take_inputs(const Packet& packet);
  void take_analogue(const Packet& packet);
  [[nodiscard]] const char* check_pins(const Packet& packet) const;
  void ask(CommandCode command, std::uint8_t parameter, std::uint64_t now_ns);

  Transport& transport_;
  Wiring wiring_;
  Stage stage_ = Stage::closed;
  bool asked_ = false, sync_ = false;
  CommandCode command_ = CommandCode::identity;
  std::uint8_t id_ = 0;
  std::uint64_t asked_ns_ = 0, answered_ns_ = 0, open_at_ns_ = 0, inputs_at_ns_ = 0, analogue_at_ns_ = 0, next_ns_ = 0;
  Readings readings_;
  DeviceCounters counters_;
  const char* problem_ = "the device was not found yet";
};

}  // namespace hoist::bus::pokeys
