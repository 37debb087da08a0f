// A PoKeys57E on the network, played: bumpers on pins 1 to 4 (1 = pressed, as with contacts that open), switches on 5 to 8, batteries on the
// analogue pins 41 and 42 (20 V at full scale), an output on pin 9. Written after the device's protocol description and not with the control side's
// own tables, so that a misreading there does not cancel itself here.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace hoist::sim {

class PokeysDevice {
 public:
  static constexpr std::size_t kPacket = 64;
  static constexpr double kFullScale_v = 20.0;

  struct Pins {
    std::uint8_t bumpers{};
    std::uint8_t switches{};
    std::array<double, 2> battery_v{};
  };
  /// The device's answer to one packet; false when a real one would not answer: wrong mark, wrong checksum, unknown command.
  [[nodiscard]] bool answer(std::span<const std::uint8_t, kPacket> request, const Pins& pins, std::span<std::uint8_t, kPacket> reply);
  /// Level of pin 9.
  [[nodiscard]] bool output() const { return output_; }

  PokeysDevice() = default;
  ~PokeysDevice();
  PokeysDevice(const PokeysDevice&) = delete;
  PokeysDevice& operator=(const PokeysDevice&) = delete;
  /// On this machine's own address only. Empty when it worked, otherwise the sentence for people.
  [[nodiscard]] std::string open(std::uint16_t port);
  /// Answers what has arrived; never waits.
  void serve(const Pins& pins);
  /// A silent device does not answer.
  void set_silent(bool silent) { silent_ = silent; }

 private:
  static constexpr int kPacketsPerCall = 16;
  int fd_{-1};
  bool silent_{false}, output_{false};
};

}  // namespace hoist::sim
