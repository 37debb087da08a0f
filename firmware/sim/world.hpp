// The simulated world: machine, patient, the six nodes with the shipped firmware sources, the UART gateway and the bus between them, in
// virtual time. It does not include the control laws. For a computer on the bus the only difference to a real hoist is that every node
// reports being simulated.
//
// A computer attaches in one of two ways: as a bus port in this process (tests: host_send, host_receive), or through the gateway's serial
// line (the program: uart_write, uart_read). No heap after construction, no clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "control/bus/virtual_bus.hpp"
#include "control/contract/can_dictionary.hpp"
#include "control/contract/can_frame.hpp"
#include "firmware/boot/host/program_flash.hpp"
#include "firmware/sim/patient.hpp"
#include "firmware/sim/plant.hpp"
#include "firmware/sim/slip_bursts.hpp"
#include "firmware/sim/stop_witness.hpp"

namespace hoist::sim {

struct WorldOptions {
  std::uint64_t seed{1};  ///< of the sensors' noise and biases
  PlantParams plant{};
  PatientParams patient{};
  const Scenario* scenario{&kScenarios.front()};
  bool host_in_process{false};  ///< true: the computer is the port of host_send / host_receive; false: it is behind the gateway
  bool numbered{false};         ///< nodes have serial numbers and do not say that they are simulated, so their parts must have been checked
  bool worst_stuffing{false};   ///< true: every frame as long as bit stuffing can make it
};

class World {
 public:
  explicit World(const WorldOptions& options);
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// One millisecond: patient, machine, firmware, bus.
  void advance_1ms();
  [[nodiscard]] std::uint64_t time_ns() const;
  [[nodiscard]] double time_s() const { return static_cast<double>(time_ns()) * 1e-9; }

  /// The computer's own port. False when the queue is full or the port is pulled.
  bool host_send(const contract::CanFrame& frame);
  /// Frames that have arrived, oldest first; how many were written to `out`.
  std::size_t host_receive(std::span<contract::CanFrame> out);
  /// The gateway's serial line: how many bytes were taken or given.
  std::size_t uart_write(std::span<const char> bytes);
  std::size_t uart_read(std::span<char> bytes);
  /// The computer has closed the line: waiting characters are dropped.
  void uart_hang_up();

  // Faults. Nodes are named as on the bus; the computer itself (Node::core) may be unplugged too.
  /// Unplugs a node or plugs it in. Sensors and inputs are powered through that plug and restart; the drives have their own supply.
  void unplug(contract::Node node, bool pulled);
  [[nodiscard]] bool unplugged(contract::Node node) const;
  /// The node's processor stops: it neither answers nor changes its outputs. Letting it go resets it, as its watchdog would.
  void freeze(contract::Node node, bool frozen);
  /// The sensor behind a tilt node repeats its last sample, while the node continues.
  void freeze_sensor(contract::Node node, bool frozen);
  /// Other failures of that sensor while its node continues: readings offset by `size` (0 to 1: of half a g and one rad/s), random readings
  /// of full range, a lag of up to a second, or no answer.
  enum class SensorFault : std::uint8_t { none, offset, garbage, slow, silent };
  void break_sensor(contract::Node node, SensorFault fault, double size);
  /// The encoder of a drive gives no more counts, or counts backward.
  enum class EncoderFault : std::uint8_t { none, lost, reversed };
  void break_encoder(contract::Node node, EncoderFault fault);
  /// A node with this serial number is fitted instead (0: it says that it is simulated), and starts. reversed: a tilt sensor sits half a turn
  /// about its strut, a drive's motor and encoder are both wired the other way round; swapped: with its twin of the other side. Of the input node
  /// both: the bumpers in front and behind. right: all parts of its kind are where they belong.
  enum class Assembly : std::uint8_t { right, reversed, swapped };
  void exchange(contract::Node node, std::uint32_t serial, Assembly how);
  /// Number of a node of a numbered hoist, as it is built.
  static constexpr std::uint32_t first_serial(contract::Node node) { return 0x10000001U + static_cast<std::uint32_t>(node); }
  /// Wheels lose the floor from now on, for a moment.
  void slip(const SlipBurst& burst);
  /// Hook for each frame on the bus (drop, corrupt, delay, deaf ports); an empty one removes it.
  void set_frame_fault(bus::VirtualBus::FaultHook hook);
  /// A foreign or defective device on the bus, added with its first frame. False when its queue is full.
  bool foreign_send(const contract::CanFrame& frame);
  /// The port of a node, for such a hook.
  [[nodiscard]] std::size_t port_of(contract::Node node) const;

  /// A node is in its loader: it has no program, or was sent there for a new one.
  [[nodiscard]] bool in_loader(contract::Node node) const;
  /// The flash with a node's program; null for the computer.
  [[nodiscard]] firmware::ProgramFlash* program_flash(contract::Node node);

  /// The patient leaves the harness, and the bar is held by hand: forward and left of the middle, turned to the left. It moves there at the
  /// speed of a hand. Zeros: upright by its springs.
  void hold_bar(double dx_m, double dy_m, double yaw_rad);
  /// The patient is strapped in again, standing.
  void strap_in();
  [[nodiscard]] bool patient_in() const;

  /// The bridge of a drive is on, its brake open.
  [[nodiscard]] bool drives_enabled() const;
  /// The relay in the motors' supply is closed (motor_relay.hpp).
  [[nodiscard]] bool relay_closed() const;
  /// Level of the input node's synchronisation output.
  [[nodiscard]] bool sync_output() const;
  /// Outputs of the input node as they are now: buzzer and lights among them (contract::canopen::kBuzzer and others).
  [[nodiscard]] std::uint8_t outputs() const;
  /// What a drive did after its last command.
  [[nodiscard]] const StopWitness& witness(Side side) const;
  /// Machine and patient back at the start mark of a scenario. False, and nothing done, while a drive is enabled or the machine moves.
  [[nodiscard]] bool restart(const Scenario& scenario);

  // True values, for tests and for the program's state report.
  [[nodiscard]] Plant& plant();
  [[nodiscard]] const Plant& plant() const;
  [[nodiscard]] Patient& patient();
  [[nodiscard]] const Patient& patient() const;
  [[nodiscard]] const bus::VirtualBusCounters& bus_counters() const;
  /// A digest of everything that moves: two worlds with equal digests all along are the same run.
  [[nodiscard]] std::uint64_t digest() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace hoist::sim
