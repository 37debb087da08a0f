// The whole hoist with its programs as machine code: seven microcontrollers on one wire, each with the circuit of its board around it, the
// plant and the patient of the simulator, and the real control step. One process, one clock, no threads: the same options give the same run.
//
// Real: the images, bit for bit, and the control core. Modelled: chips, wire, motors, patient.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/commands.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/firmware_image.hpp"
#include "control/contract/params.hpp"
#include "control/contract/signals.hpp"
#include "control/contract/slcan_codec.hpp"
#include "control/core/tick.hpp"
#include "firmware/sim/patient.hpp"
#include "firmware/sim/plant.hpp"
#include "tests/machine/board_pins.hpp"
#include "tests/machine/chip.hpp"
#include "tests/machine/image.hpp"
#include "tests/machine/imu_chips.hpp"

namespace hoist::machine {

/// Boxes in the order of contract::Node's nodes, then the gateway.
enum class Box : std::uint8_t { drive_left, drive_right, io, tilt_left, tilt_right, tilt_base, gateway };
inline constexpr std::size_t kBoxCount = 7;

using contract::ImageChip;

/// The images of one build of the firmware.
struct Images {
  struct OfChip {
    Image tilt, drive, io, gateway;
    [[nodiscard]] const Image& of(Box box) const;
  };
  OfChip lpc11c24, stm32f072;
  [[nodiscard]] const Image& of(ImageChip chip, Box box) const { return (chip == ImageChip::stm32f072 ? stm32f072 : lpc11c24).of(box); }
};
/// The images, or the reason for their absence.
struct ImagesOrReason {
  std::optional<Images> images;
  std::string reason;
};
[[nodiscard]] ImagesOrReason load_images();
/// An image of the firmware by its name without chip and ending.
[[nodiscard]] std::optional<Image> load_image(const std::string& name, ImageChip chip);

enum class ImuKind : std::uint8_t { mpu6050, lsm6dso, icm42688p };

struct BenchOptions {
  std::uint64_t seed{1};
  sim::PlantParams plant{};
  sim::PatientParams patient{};
  const sim::Scenario* scenario{&sim::kScenarios.front()};
  /// Which microcontroller each box has.
  std::array<ImageChip, kBoxCount> chips{ImageChip::lpc11c24, ImageChip::lpc11c24, ImageChip::lpc11c24, ImageChip::lpc11c24,
                                         ImageChip::lpc11c24, ImageChip::lpc11c24, ImageChip::lpc11c24};
  /// The only powered board, for tests of one board; empty: all.
  std::optional<Box> only{};
  bool through_gateway{true};  ///< false: the computer is on the wire itself, without the gateway
  /// The whole flash of a box instead of the bare application: its loader and the rest. It starts at address 0.
  std::array<std::vector<std::uint8_t>, 7> flash{};
  std::array<ImuKind, 3> imus{ImuKind::mpu6050, ImuKind::mpu6050, ImuKind::mpu6050};  ///< left, right, base
};

class HoistBench {
 public:
  HoistBench(const Images& images, const BenchOptions& options);
  HoistBench(const HoistBench&) = delete;
  HoistBench& operator=(const HoistBench&) = delete;

  void advance_1ms();
  [[nodiscard]] Time now() const { return now_; }
  [[nodiscard]] double time_s() const { return static_cast<double>(now_) / static_cast<double>(kSecond); }

  /// The computer: frames straight onto the wire, or characters on the serial line.
  void host_send(const contract::CanFrame& frame);
  [[nodiscard]] std::size_t host_receive(std::span<contract::CanFrame> out);

  [[nodiscard]] Chip& chip(Box box) { return *chips_[static_cast<std::size_t>(box)]; }
  /// How the board of this box is wired.
  [[nodiscard]] const BoardPins& pins(Box box) const { return board_pins(options_.chips[static_cast<std::size_t>(box)]); }
  [[nodiscard]] ImuChip& imu(Box box) { return *imus_[static_cast<std::size_t>(box) - static_cast<std::size_t>(Box::tilt_left)]; }
  [[nodiscard]] std::size_t station(Box box) const { return stations_[static_cast<std::size_t>(box)]; }
  [[nodiscard]] CanWire& wire() { return wire_; }
  [[nodiscard]] sim::Plant& plant() { return plant_; }
  [[nodiscard]] sim::Patient& patient() { return patient_; }
  /// A line of an encoder no longer moves.
  void break_encoder_line(Box box, unsigned line) { broken_line_[static_cast<std::size_t>(box)] = 1U << line; }

  /// All violations of all chips as text; empty if there are none.
  [[nodiscard]] std::string violations() const;
  [[nodiscard]] std::uint64_t digest() const;
  /// Lines of the serial line that were no good, as the computer counts them.
  [[nodiscard]] std::uint64_t bad_lines() const { return decoder_.counters().refused_lines + decoder_.counters().overlong_lines; }

 private:
  void advance_quarter();
  void wire_up(Box box, const Image& image);
  void wire_drive(Box box);
  void wire_tilt(Box box);
  void turn_encoder(Box box, sim::Side side, std::int32_t before, Time from, Time span);
  void read_bridge(Box box, sim::Side side);
  void press_bumpers();
  void move_serial_line();

  BenchOptions options_;
  sim::Plant plant_;
  sim::Patient patient_;
  CanWire wire_;
  HostStation host_;
  std::array<std::unique_ptr<Chip>, kBoxCount> chips_;
  std::array<std::unique_ptr<ImuChip>, 3> imus_;
  std::array<std::size_t, kBoxCount> stations_{};
  std::array<unsigned, kBoxCount> broken_line_{};
  std::array<unsigned, 2> encoder_pins_{};
  std::array<double, 2> motor_a_{};
  double supply_v_{};
  std::array<double, 2> battery_v_{};
  std::uint8_t bumpers_{0xFF};
  Time now_{};
  std::string to_gateway_;
  contract::SlcanDecoder decoder_;
  std::vector<contract::CanFrame> received_;
};

/// Bench and control core in step, with one driver at the console.
class MachineLoop {
 public:
  MachineLoop(const Images& images, const BenchOptions& options, const contract::Params& params = {});

  /// One control step and the ten milliseconds that follow it.
  void step();
  void run(double seconds);
  bool run_until(const std::function<bool()>& done, double at_most_s);
  void ask(contract::CommandKind kind, std::uint32_t a = 0, double v0 = 0.0, double v1 = 0.0, double v2 = 0.0);
  bool start(contract::Mode mode);

  [[nodiscard]] HoistBench& bench() { return bench_; }
  [[nodiscard]] const contract::TickRecord& record() const { return outputs_->record; }
  [[nodiscard]] contract::Mode mode() const { return static_cast<contract::Mode>(record().mode); }
  [[nodiscard]] bool fault(contract::Fault which) const;
  [[nodiscard]] const std::vector<contract::Event>& events() const { return events_; }
  [[nodiscard]] std::string faults() const;

 private:
  void sign_parts();
  static constexpr std::uint32_t kClient = 1;
  HoistBench bench_;
  std::unique_ptr<core::CoreState> core_;
  std::unique_ptr<core::TickOutputs> outputs_;
  std::array<contract::CanFrame, 256> frames_{};
  std::vector<contract::Command> commands_;
  std::vector<contract::Event> events_;
  std::uint64_t ticks_{}, sequence_{}, heartbeat_{};
  std::uint32_t requests_{};
};

}  // namespace hoist::machine
