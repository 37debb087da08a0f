#include "firmware/sim/world.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

#include "firmware/boards/host/host_boards.hpp"
#include "firmware/boot/host/updatable_node.hpp"
#include "firmware/nodes/drive/drive_node.hpp"
#include "firmware/nodes/gateway/gateway_node.hpp"
#include "firmware/nodes/io/io_node.hpp"
#include "firmware/nodes/tilt/tilt_node.hpp"
#include "firmware/sim/motor_relay.hpp"
#include "firmware/sim/random.hpp"

namespace hoist::sim {
namespace {

using contract::CanFrame;
using contract::Node;

constexpr std::uint64_t kMillisecond_ns = 1'000'000;
constexpr std::size_t kNodeCount = contract::kNodes.size();
constexpr std::size_t kHostQueueMax = 256;
constexpr double kAtRest_m_s = 0.005;
constexpr double kTurn_rad = 6.283185307179586;

constexpr std::size_t index(Node node) { return static_cast<std::size_t>(node); }
constexpr Side side_of(Node node) { return node == Node::drive_left ? Side::left : Side::right; }
constexpr Place place_of(Node node) {
  return node == Node::tilt_left ? Place::left_strut : (node == Node::tilt_right ? Place::right_strut : Place::chassis);
}

// The machine as its boards see it: the plant behind wires that can break.
class Machine {
 public:
  explicit Machine(Plant& plant) : plant_(plant) {}

  /// The drives' plugs are swapped, or motor and encoder of one are wired the other way round. Both bridges are switched off.
  void wire_drives(bool swapped, std::optional<Side> mirrored) {
    for (const Side side : {Side::left, Side::right}) plant_.set_bridge(side, false, 0.0);
    swapped_ = swapped;
    mirrored_ = {mirrored == Side::left, mirrored == Side::right};
    for (const Node drive : {Node::drive_left, Node::drive_right})
      encoders_[static_cast<std::size_t>(side_of(drive))].raw = plant_.encoder_counts(wheel_of(drive));
  }
  bool read_imu(Node node, firmware::ImuSample& sample) {
    const auto place = place_of(node);
    firmware::ImuSample& last = last_sample_[static_cast<std::size_t>(place)];
    const Ailment& ailment = ailments_[static_cast<std::size_t>(place)];
    if (ailment.fault != World::SensorFault::none) return read_ailing(ailment, place, last, sample);
    if (!sensor_frozen_[static_cast<std::size_t>(place)]) {
      const ImuReading reading = plant_.read_imu(place);
      last = {static_cast<float>(reading.ax_m_s2),         static_cast<float>(reading.ay_m_s2),
              static_cast<float>(reading.az_m_s2),         static_cast<float>(reading.alpha_rate_rad_s),
              static_cast<float>(reading.beta_rate_rad_s), static_cast<float>(reading.yaw_rate_rad_s)};
    }
    sample = last;
    return true;
  }
  std::int32_t encoder_counts(Node node) {
    Encoder& encoder = encoders_[static_cast<std::size_t>(side_of(node))];
    const std::int32_t raw = plant_.encoder_counts(wheel_of(node));
    const auto moved = static_cast<std::uint32_t>(raw) - static_cast<std::uint32_t>(encoder.raw);
    encoder.raw = raw;
    if (encoder.fault != World::EncoderFault::lost && moved != 0) note_edges(encoder, static_cast<std::int32_t>(moved), node);
    const bool back = (encoder.fault == World::EncoderFault::reversed) != mirrored(node);
    if (encoder.fault != World::EncoderFault::lost) encoder.shown = back ? encoder.shown - moved : encoder.shown + moved;
    return static_cast<std::int32_t>(encoder.shown);
  }
  // The time between the last two edges, as a timer on the encoder's lines would show it.
  std::uint32_t edge_time_us(Node node) { return encoders_[static_cast<std::size_t>(side_of(node))].edge_us; }
  float motor_current_a(Node node) { return static_cast<float>(plant_.motor_current_a(wheel_of(node))) * (mirrored(node) ? -1.0F : 1.0F); }
  float supply_v() { return static_cast<float>(plant_.supply_v()); }
  void set_outputs(std::uint8_t outputs) { outputs_ = outputs; }
  // The relay's circuit reads the input node's output line.
  void step_relay_1ms() {
    namespace canopen = contract::canopen;
    plant_.open_relay(!relay_.step_1ms((outputs_ & canopen::kRelayFeed) != 0, (outputs_ & canopen::kRelayRelease) != 0));
  }
  [[nodiscard]] const MotorRelay& relay() const { return relay_; }
  [[nodiscard]] std::uint8_t outputs() const { return outputs_; }
  [[nodiscard]] bool sync_output() const { return (outputs_ & contract::canopen::kSyncOutput) != 0; }
  void set_bridge(Node node, bool enabled, float duty_norm) {
    plant_.set_bridge(wheel_of(node), enabled, static_cast<double>(mirrored(node) ? -duty_norm : duty_norm));
  }
  std::uint8_t bumpers() { return plant_.bumpers(); }
  std::uint8_t switches() { return plant_.switches(); }
  float battery_v(int battery) { return static_cast<float>(plant_.battery_v(battery)); }

  void freeze_sensor(Node node, bool frozen) { sensor_frozen_[static_cast<std::size_t>(place_of(node))] = frozen; }
  void break_sensor(Node node, World::SensorFault fault, double size) {
    ailments_[static_cast<std::size_t>(place_of(node))] = {fault, std::isfinite(size) ? std::clamp(size, 0.0, 1.0) : 0.0};
  }
  void break_encoder(Node node, World::EncoderFault fault) { encoders_[static_cast<std::size_t>(side_of(node))].fault = fault; }

 private:
  [[nodiscard]] Side wheel_of(Node node) const { return (side_of(node) == Side::left) != swapped_ ? Side::left : Side::right; }
  [[nodiscard]] bool mirrored(Node node) const { return mirrored_[static_cast<std::size_t>(side_of(node))]; }
  struct Encoder {
    std::int32_t raw{};
    std::uint32_t shown{};
    std::uint32_t edge_us{firmware::kEdgeTimeUnknown_us};
    std::int32_t last_step{};
    World::EncoderFault fault{World::EncoderFault::none};
  };
  struct Ailment {
    World::SensorFault fault{World::SensorFault::none};
    double size{};
  };
  bool read_ailing(const Ailment& ailment, Place place, firmware::ImuSample& last, firmware::ImuSample& sample) {
    if (ailment.fault == World::SensorFault::silent) return false;
    const ImuReading truth = plant_.read_imu(place);
    const auto changed = [&](double value, double range, float before) {
      switch (ailment.fault) {
        case World::SensorFault::offset:
          return static_cast<float>(value + kOffsetShare * ailment.size * range);
        case World::SensorFault::garbage:
          return static_cast<float>(noise_.uniform(-range, range));
        default:
          return before + (static_cast<float>(value) - before) * static_cast<float>(kSample_s / (kSample_s + ailment.size));
      }
    };
    sample = {changed(truth.ax_m_s2, kFullScale_m_s2, last.ax_m_s2),
              changed(truth.ay_m_s2, kFullScale_m_s2, last.ay_m_s2),
              changed(truth.az_m_s2, kFullScale_m_s2, last.az_m_s2),
              changed(truth.alpha_rate_rad_s, kFullScale_rad_s, last.alpha_rate_rad_s),
              changed(truth.beta_rate_rad_s, kFullScale_rad_s, last.beta_rate_rad_s),
              changed(truth.yaw_rate_rad_s, kFullScale_rad_s, last.yaw_rate_rad_s)};
    last = sample;
    return true;
  }
  // Ranges of the consumer parts: 2 g, 250 degrees a second.
  static constexpr double kFullScale_m_s2 = 19.6, kFullScale_rad_s = 4.36, kOffsetShare = 0.25, kSample_s = 0.01;
  // Edges of a perfect encoder: evenly spaced at the shaft's speed. After a change of direction one more is needed.
  void note_edges(Encoder& encoder, std::int32_t moved, Node node) {
    const PlantParams& params = plant_.params();
    const double shaft_rad_s = std::fabs(plant_.wheel_speed_m_s(wheel_of(node))) / params.wheel_radius_m * params.gear_ratio /
                               params.wheel_norm[static_cast<std::size_t>(wheel_of(node))];
    const double edge_us = 1e6 * kTurn_rad / (params.motor.counts_per_turn * shaft_rad_s);
    const bool turned = (moved > 0) != (encoder.last_step > 0);
    const bool known = (!turned || moved > 1 || moved < -1) && edge_us < 4e9;
    encoder.edge_us = known ? static_cast<std::uint32_t>(edge_us) : firmware::kEdgeTimeUnknown_us;
    encoder.last_step = moved;
  }

  Plant& plant_;
  MotorRelay relay_;
  std::uint8_t outputs_{};
  std::array<firmware::ImuSample, kPlaceCount> last_sample_{};
  std::array<bool, kPlaceCount> sensor_frozen_{};
  std::array<Ailment, kPlaceCount> ailments_{};
  Random noise_{0x6A09E667F3BCC908ULL};  // random readings
  std::array<Encoder, 2> encoders_{};
  bool swapped_{false};
  std::array<bool, 2> mirrored_{};
};

using TiltBoard = firmware::HostTiltBoard<Machine>;
using DriveBoard = firmware::HostDriveBoard<Machine>;
using IoBoard = firmware::HostIoBoard<Machine>;

template <class Board, class Application>
using Device = firmware::UpdatableNode<Board, Application>;

// A board with its node and the loader under it: what one box on the hoist is.
template <class Board, class Application>
struct Box {
  template <class... Args>
  explicit Box(Node node, Args&&... args) : board(std::forward<Args>(args)...), firmware(board, node) {}
  Box(const Box&) = delete;  // the firmware holds on to its board
  Box& operator=(const Box&) = delete;
  ~Box() = default;
  Board board;
  Device<Board, Application> firmware;
};
using DriveBox = Box<DriveBoard, firmware::DriveNode<DriveBoard>>;
using IoBox = Box<IoBoard, firmware::IoNode<IoBoard>>;
using TiltBox = Box<TiltBoard, firmware::TiltNode<TiltBoard>>;

constexpr bool fed_by_its_plug(Node node) { return node != Node::drive_left && node != Node::drive_right && node != Node::core; }

}  // namespace

struct World::Parts {
  explicit Parts(const WorldOptions& options)
      : plant(options.plant, options.seed),
        patient(options.patient, *options.scenario),
        slips(options.seed, options.scenario->slippery),
        bus({.bit_rate = 250'000, .worst_stuffing = options.worst_stuffing}),
        machine(plant),
        drive_left(Node::drive_left, bus, machine, Node::drive_left),
        drive_right(Node::drive_right, bus, machine, Node::drive_right),
        io(Node::io, bus, machine),
        tilt_left(Node::tilt_left, bus, machine, Node::tilt_left),
        tilt_right(Node::tilt_right, bus, machine, Node::tilt_right),
        tilt_base(Node::tilt_base, bus, machine, Node::tilt_base),
        gateway_board(bus),
        gateway(gateway_board),
        host_port(bus.add_port()),
        foreign_port(bus.add_port()) {
    const bool in_process = options.host_in_process;
    bus.set_connected(gateway_board.port(), !in_process);
    bus.set_connected(host_port, in_process);
    bus.set_connected(foreign_port, false);
    core_port = in_process ? host_port : gateway_board.port();
    for (std::size_t i = 0; options.numbered && i < contract::kRemoteNodeCount; ++i)
      power_on(static_cast<Node>(i), World::first_serial(static_cast<Node>(i)));
    set_out();
  }

  void set_out() {
    const contract::PathPose start = patient.path().pose(0.0);
    plant.place(start.x_m, start.y_m, start.psi_rad);
  }

  template <class Self, class What>
  static void with_box_of(Self& self, Node node, What&& what) {
    switch (node) {
      case Node::drive_left:
        what(self.drive_left);
        break;
      case Node::drive_right:
        what(self.drive_right);
        break;
      case Node::io:
        what(self.io);
        break;
      case Node::tilt_left:
        what(self.tilt_left);
        break;
      case Node::tilt_right:
        what(self.tilt_right);
        break;
      case Node::tilt_base:
        what(self.tilt_base);
        break;
      case Node::core:
        break;
    }
  }
  // Calls `what` with the firmware of a node of the bus.
  template <class What>
  void with_node(Node node, What&& what) {
    with_box_of(*this, node, [&what](auto& box) { what(box.firmware); });
  }
  [[nodiscard]] std::size_t port_of(Node node) const {
    std::size_t port = node == Node::core ? core_port : bus::kVirtualPortMax;
    with_box_of(*this, node, [&port](const auto& box) { port = box.board.port(); });
    return port;
  }
  void power_on(Node node, std::uint32_t serial) {
    with_box_of(*this, node, [serial](auto& box) {
      box.board.set_serial_number(serial);
      box.firmware.power_on();
    });
  }
  [[nodiscard]] bool runs(Node node) const { return !frozen[index(node)] && !(pulled[index(node)] && fed_by_its_plug(node)); }

  void deliver(std::size_t port, const CanFrame& frame) {
    if (port == host_port) {
      if (host_count < kHostQueueMax) host_queue[(host_first + host_count++) % kHostQueueMax] = frame;
      return;
    }
    if (port == gateway_board.port()) {
      gateway.on_frame(frame);
      return;
    }
    if (port == foreign_port) return;
    // Ports were given out in the order of the nodes.
    const auto node = static_cast<Node>(port);
    for (const Node drive : {Node::drive_left, Node::drive_right})
      if (node == drive && frame.id == contract::pdo_cob_id(contract::Pdo::drive_rx1, drive) && frame.flags == 0)
        witnesses[static_cast<std::size_t>(side_of(drive))].command(bus.now_ns());
    if (runs(node)) with_node(node, [&frame](auto& firmware) { firmware.on_frame(frame); });
  }

  void advance_1ms() {
    slips.step_1ms(plant);
    if (bar_held) {
      move_bar();
      plant.set_carried(0.0);
      plant.step(bar, 0.001);
    } else {
      patient.step_1ms({plant.platform(), plant.harness_force(patient.harness()),
                        plant.bridge_enabled(Side::left) && plant.bridge_enabled(Side::right), plant.holds_body()});
      plant.set_carried(plant.holds_body() ? patient.carried_n() : 0.0);
      plant.step(patient.harness(), 0.001);
    }
    for (std::size_t i = 0; i < kNodeCount; ++i) {
      const auto node = static_cast<Node>(i);
      if (runs(node)) with_node(node, [](auto& firmware) { firmware.tick_1ms(); });
    }
    // Without power the node's outputs are off.
    if (pulled[index(Node::io)]) machine.set_outputs(0);
    machine.step_relay_1ms();
    gateway.tick_1ms();
    bus.advance(kMillisecond_ns, [this](std::size_t port, const CanFrame& frame) { deliver(port, frame); });
    watch_stop(drive_left, Side::left);
    watch_stop(drive_right, Side::right);
  }

  void watch_stop(DriveBox& drive, Side side) {
    const bool obeys = drive.firmware.application().state() == contract::canopen::drive::State::operation_enabled;
    witnesses[static_cast<std::size_t>(side)].look(bus.now_ns(), obeys, plant.wheel_speed_m_s(side));
  }

  // An empty bar goes where the hand takes it, no faster than a hand does.
  void move_bar() {
    const auto follow = [](double& at, double& rate, double goal, double fastest) {
      const double before = at;
      at += std::clamp(goal - at, -fastest * 0.001, fastest * 0.001);
      rate = (at - before) / 0.001;
    };
    follow(bar.dx_m, bar.dx_rate_m_s, bar_goal.dx_m, 0.1);
    follow(bar.dy_m, bar.dy_rate_m_s, bar_goal.dy_m, 0.1);
    follow(bar.yaw_rad, bar.yaw_rate_rad_s, bar_goal.yaw_rad, 0.2);
  }

  Plant plant;
  Patient patient;
  HarnessMotion bar, bar_goal;
  bool bar_held{false};
  SlipBursts slips;
  bus::VirtualBus bus;
  Machine machine;
  DriveBox drive_left, drive_right;
  IoBox io;
  TiltBox tilt_left, tilt_right, tilt_base;
  firmware::HostGatewayBoard gateway_board;
  firmware::GatewayNode<firmware::HostGatewayBoard> gateway;
  std::size_t host_port;
  std::size_t foreign_port;
  std::size_t core_port{};
  std::array<StopWitness, 2> witnesses{};
  std::array<bool, kNodeCount> pulled{};
  std::array<bool, kNodeCount> frozen{};
  std::array<CanFrame, kHostQueueMax> host_queue{};
  std::size_t host_first{};
  std::size_t host_count{};
};

World::World(const WorldOptions& options) : parts_(std::make_unique<Parts>(options)) {}
World::~World() = default;

void World::advance_1ms() { parts_->advance_1ms(); }
std::uint64_t World::time_ns() const { return parts_->bus.now_ns(); }

bool World::host_send(const CanFrame& frame) { return parts_->bus.send(parts_->host_port, frame); }

std::size_t World::host_receive(std::span<CanFrame> out) {
  Parts& p = *parts_;
  std::size_t given = 0;
  for (; given < out.size() && p.host_count > 0; ++given, --p.host_count) {
    out[given] = p.host_queue[p.host_first];
    p.host_first = (p.host_first + 1) % kHostQueueMax;
  }
  return given;
}

std::size_t World::uart_write(std::span<const char> bytes) { return parts_->gateway_board.from_computer().write(bytes); }
std::size_t World::uart_read(std::span<char> bytes) { return parts_->gateway_board.to_computer().read(bytes); }
void World::uart_hang_up() {
  parts_->gateway_board.from_computer().clear();
  parts_->gateway_board.to_computer().clear();
}

void World::unplug(Node node, bool pulled) {
  Parts& p = *parts_;
  if (p.pulled[index(node)] == pulled) return;
  p.pulled[index(node)] = pulled;
  p.bus.set_connected(p.port_of(node), !pulled);
  if (!pulled && fed_by_its_plug(node)) p.with_node(node, [](auto& firmware) { firmware.power_on(); });
}
bool World::unplugged(Node node) const { return parts_->pulled[index(node)]; }

void World::exchange(Node node, std::uint32_t serial, Assembly how) {
  Parts& p = *parts_;
  const bool wrong = how != Assembly::right;
  switch (contract::kNodes[index(node)].kind) {
    case contract::NodeKind::tilt:
      if (how == Assembly::swapped && node != Node::tilt_base) {
        p.plant.screw_sensor(Place::left_strut, Place::right_strut, false);
        p.plant.screw_sensor(Place::right_strut, Place::left_strut, false);
      } else {
        for (const Node each : {Node::tilt_left, Node::tilt_right, Node::tilt_base})
          p.plant.screw_sensor(place_of(each), place_of(each), wrong && each == node);
      }
      break;
    case contract::NodeKind::drive:
      p.machine.wire_drives(how == Assembly::swapped, how == Assembly::reversed ? std::optional(side_of(node)) : std::nullopt);
      break;
    case contract::NodeKind::io:
      p.plant.wire_bumper(0, wrong ? 1 : 0);
      p.plant.wire_bumper(1, wrong ? 0 : 1);
      break;
    default:
      return;
  }
  p.power_on(node, serial);
}

void World::freeze(Node node, bool frozen) {
  Parts& p = *parts_;
  if (node == Node::core || p.frozen[index(node)] == frozen) return;
  p.frozen[index(node)] = frozen;
  if (!frozen) p.with_node(node, [](auto& firmware) { firmware.watchdog_reset(); });
}

void World::freeze_sensor(Node node, bool frozen) {
  if (contract::kNodes[index(node)].kind == contract::NodeKind::tilt) parts_->machine.freeze_sensor(node, frozen);
}
void World::break_sensor(Node node, SensorFault fault, double size) {
  if (contract::kNodes[index(node)].kind == contract::NodeKind::tilt) parts_->machine.break_sensor(node, fault, size);
}
void World::break_encoder(Node node, EncoderFault fault) {
  if (contract::kNodes[index(node)].kind == contract::NodeKind::drive) parts_->machine.break_encoder(node, fault);
}
void World::slip(const SlipBurst& burst) { parts_->slips.begin(burst); }
void World::set_frame_fault(bus::VirtualBus::FaultHook hook) { parts_->bus.set_fault_hook(std::move(hook)); }
bool World::foreign_send(const CanFrame& frame) {
  parts_->bus.set_connected(parts_->foreign_port, true);
  return parts_->bus.send(parts_->foreign_port, frame);
}
std::size_t World::port_of(Node node) const { return parts_->port_of(node); }

bool World::in_loader(Node node) const {
  bool in_loader = false;
  parts_->with_node(node, [&in_loader](auto& firmware) { in_loader = firmware.in_loader(); });
  return in_loader;
}
firmware::ProgramFlash* World::program_flash(Node node) {
  firmware::ProgramFlash* flash = nullptr;
  parts_->with_node(node, [&flash](auto& firmware) { flash = &firmware.loader_board().flash(); });
  return flash;
}

bool World::relay_closed() const { return parts_->machine.relay().closed(); }
std::uint8_t World::outputs() const { return parts_->machine.outputs(); }
bool World::sync_output() const { return parts_->machine.sync_output(); }
const StopWitness& World::witness(Side side) const { return parts_->witnesses[static_cast<std::size_t>(side)]; }

void World::hold_bar(double dx_m, double dy_m, double yaw_rad) {
  Parts& p = *parts_;
  if (!std::isfinite(dx_m) || !std::isfinite(dy_m) || !std::isfinite(yaw_rad)) return;
  if (!p.bar_held) p.bar = p.patient.harness();
  p.bar_held = true;
  p.bar_goal = {dx_m, dy_m, yaw_rad, 0.0, 0.0, 0.0};
}
void World::strap_in() {
  Parts& p = *parts_;
  if (!p.bar_held) return;
  p.bar_held = false;
  p.patient.restart(p.patient.scenario());
}
bool World::patient_in() const { return !parts_->bar_held; }

bool World::drives_enabled() const { return parts_->plant.bridge_enabled(Side::left) || parts_->plant.bridge_enabled(Side::right); }

bool World::restart(const Scenario& scenario) {
  if (drives_enabled() || std::fabs(parts_->plant.platform().speed_m_s) > kAtRest_m_s) return false;
  parts_->patient.restart(scenario);
  parts_->slips.set_at_random(scenario.slippery);
  parts_->set_out();
  return true;
}

Plant& World::plant() { return parts_->plant; }
const Plant& World::plant() const { return parts_->plant; }
Patient& World::patient() { return parts_->patient; }
const Patient& World::patient() const { return parts_->patient; }
const bus::VirtualBusCounters& World::bus_counters() const { return parts_->bus.counters(); }

std::uint64_t World::digest() const {
  // FNV-1a over the bits: not one of them may differ.
  std::uint64_t hash = 0xCBF29CE484222325ULL;
  const auto mix = [&hash](std::uint64_t bits) {
    for (int i = 0; i < 8; ++i) {
      hash ^= (bits >> (8 * i)) & 0xFF;
      hash *= 0x100000001B3ULL;
    }
  };
  const auto mix_real = [&mix](double value) { mix(std::bit_cast<std::uint64_t>(value)); };
  const PlatformMotion& at = parts_->plant.platform();
  const HarnessMotion& harness = parts_->patient.harness();
  for (const double value : {at.x_m, at.y_m, at.psi_rad, at.speed_m_s, at.yaw_rate_rad_s, harness.dx_m, harness.dy_m, harness.yaw_rad,
                             parts_->plant.motor_current_a(Side::left), parts_->plant.motor_current_a(Side::right),
                             parts_->plant.duty_norm(Side::left), parts_->plant.duty_norm(Side::right), parts_->plant.supply_v()})
    mix_real(value);
  mix(parts_->bus.counters().frames);
  mix(parts_->bus.counters().busy_ns);
  mix(parts_->bus.now_ns());
  return hash;
}

}  // namespace hoist::sim
