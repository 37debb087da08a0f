// The boards of a simulated hoist: the same node sources as on the microcontrollers, with a model of the machine where the hardware is.
//
// Machine models the hardware (firmware/sim/world.cpp); a board sees only its own wires:
//   bool read_imu(contract::Node, firmware::ImuSample&)
//   std::int32_t encoder_counts(contract::Node)   std::uint32_t edge_time_us(contract::Node)   float motor_current_a(contract::Node)
//   float supply_v()
//   void set_bridge(contract::Node, bool enabled, float duty_norm)
//   std::uint8_t bumpers()   std::uint8_t switches()   float battery_v(int)
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/bus/virtual_bus.hpp"
#include "control/contract/can_dictionary.hpp"
#include "firmware/lib/board.hpp"
#include "firmware/lib/program_control.hpp"

namespace hoist::firmware {

/// The CAN controller every board has.
class HostCan {
 public:
  explicit HostCan(bus::VirtualBus& bus) : bus_(bus), port_(bus.add_port()) {}
  bool send(const contract::CanFrame& frame) { return bus_.send(port_, frame); }
  /// A part with a number is as a real one: hoist-control asks whether it was checked. Without one it says that it is simulated.
  [[nodiscard]] bool simulated() const { return serial_ == 0; }
  [[nodiscard]] std::uint32_t serial_number() const { return serial_; }
  void set_serial_number(std::uint32_t serial) { serial_ = serial; }
  /// True when no sent frame still waits for the bus.
  [[nodiscard]] bool sent_all() const { return bus_.waiting(port_) == 0; }
  // The bus in virtual time has no error counters: the health is what a test or a scenario says it is.
  [[nodiscard]] CanHealth can_health() const { return health_; }
  void can_restart() {
    if (health_.state == CanHealth::State::bus_off) health_ = {CanHealth::State::active, 0, 0, health_.lost};
  }
  void set_can_health(const CanHealth& health) { health_ = health; }
  [[nodiscard]] std::size_t port() const { return port_; }

 private:
  bus::VirtualBus& bus_;
  std::size_t port_;
  std::uint32_t serial_ = 0;
  CanHealth health_{};
};

/// Two pages of flash in memory, empty when the simulation begins, and the reason of the last start.
class HostStore {
 public:
  static constexpr std::size_t kPageBytes = 1024;
  [[nodiscard]] bool erase(int page) {
    if (page < 0 || page > 1) return false;
    pages_[static_cast<std::size_t>(page)].fill(std::byte{0xFF});
    return true;
  }
  [[nodiscard]] bool write(int page, std::size_t offset, std::span<const std::byte> bytes) {
    if (page < 0 || page > 1 || offset > kPageBytes || bytes.size() > kPageBytes - offset) return false;
    auto& target = pages_[static_cast<std::size_t>(page)];
    for (std::size_t i = 0; i < bytes.size(); ++i) target[offset + i] &= bytes[i];  // flash only clears bits
    return std::equal(bytes.begin(), bytes.end(), target.begin() + static_cast<std::ptrdiff_t>(offset));
  }
  [[nodiscard]] std::span<const std::byte> read(int page) const {
    return page < 0 || page > 1 ? std::span<const std::byte>{} : std::span<const std::byte>(pages_[static_cast<std::size_t>(page)]);
  }

 private:
  static constexpr std::array<std::byte, kPageBytes> erased() {
    std::array<std::byte, kPageBytes> bytes{};
    bytes.fill(std::byte{0xFF});
    return bytes;
  }
  std::array<std::array<std::byte, kPageBytes>, 2> pages_{erased(), erased()};
};

/// What every board with parameters has besides its CAN controller. A restart is only noted: the world that runs the node carries it out.
class HostStoringBoard : public HostCan {
 public:
  using HostCan::HostCan;
  HostStore& flash() { return flash_; }
  [[nodiscard]] ResetCause reset_cause() const { return cause_; }
  void set_reset_cause(ResetCause cause) { cause_ = cause; }
  void restart(bool into_loader) { restart_requested_ = true, loader_requested_ = into_loader; }
  [[nodiscard]] bool restart_requested() const { return restart_requested_; }
  [[nodiscard]] bool loader_requested() const { return loader_requested_; }
  void restart_done() { restart_requested_ = loader_requested_ = false; }
  /// What the loader of this board has found in its flash.
  [[nodiscard]] ProgramInfo program() const { return program_; }
  void set_program(const ProgramInfo& program) { program_ = program; }

 private:
  HostStore flash_{};
  ResetCause cause_ = ResetCause::power;
  bool restart_requested_ = false, loader_requested_ = false;
  ProgramInfo program_{};
};

template <class Machine>
class HostTiltBoard : public HostStoringBoard {
 public:
  HostTiltBoard(bus::VirtualBus& bus, Machine& machine, contract::Node node) : HostStoringBoard(bus), machine_(machine), node_(node) {}
  bool read_imu(ImuSample& sample) { return machine_.read_imu(node_, sample); }
  [[nodiscard]] ImuReport imu_report() const { return report_; }
  void set_imu_report(const ImuReport& report) { report_ = report; }

 private:
  Machine& machine_;
  contract::Node node_;
  ImuReport report_{true, false, false, 0};
};

template <class Machine>
class HostDriveBoard : public HostStoringBoard {
 public:
  HostDriveBoard(bus::VirtualBus& bus, Machine& machine, contract::Node node) : HostStoringBoard(bus), machine_(machine), node_(node) {}
  std::int32_t encoder_counts() { return machine_.encoder_counts(node_); }
  std::uint32_t edge_time_us() { return machine_.edge_time_us(node_); }
  std::uint32_t illegal_encoder_steps() { return illegal_encoder_steps_; }
  bool driver_ok() { return driver_ok_; }
  void add_illegal_encoder_step() { ++illegal_encoder_steps_; }
  void set_driver_ok(bool ok) { driver_ok_ = ok; }
  float motor_current_a() { return machine_.motor_current_a(node_); }
  float supply_v() { return machine_.supply_v(); }
  void set_bridge(bool enabled, float duty_norm) { machine_.set_bridge(node_, enabled, duty_norm); }

 private:
  Machine& machine_;
  contract::Node node_;
  std::uint32_t illegal_encoder_steps_ = 0;
  bool driver_ok_ = true;
};

template <class Machine>
class HostIoBoard : public HostStoringBoard {
 public:
  HostIoBoard(bus::VirtualBus& bus, Machine& machine) : HostStoringBoard(bus), machine_(machine) {}
  std::uint8_t bumpers() { return machine_.bumpers(); }
  std::uint8_t switches() { return machine_.switches(); }
  float battery_v(int battery) { return machine_.battery_v(battery); }
  void set_outputs(std::uint8_t outputs) {
    outputs_ = outputs;
    if constexpr (requires { machine_.set_outputs(outputs); }) machine_.set_outputs(outputs);
  }
  [[nodiscard]] std::uint8_t outputs() const { return outputs_; }

 private:
  Machine& machine_;
  std::uint8_t outputs_ = 0;
};

/// One direction of the serial line: bytes that have been written and not yet read. What does not fit is refused to the writer, as by a
/// hardware handshake.
class SerialFifo {
 public:
  std::size_t write(std::span<const char> bytes) {
    std::size_t taken = 0;
    for (; taken < bytes.size() && count_ < bytes_.size(); ++taken) bytes_[(first_ + count_++) % bytes_.size()] = bytes[taken];
    return taken;
  }
  std::size_t read(std::span<char> bytes) {
    std::size_t given = 0;
    for (; given < bytes.size() && count_ > 0; ++given, --count_) {
      bytes[given] = bytes_[first_];
      first_ = (first_ + 1) % bytes_.size();
    }
    return given;
  }
  void clear() { count_ = 0; }
  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] std::size_t room() const { return bytes_.size() - count_; }

 private:
  std::array<char, 4096> bytes_{};
  std::size_t first_{};
  std::size_t count_{};
};

class HostGatewayBoard : public HostCan {
 public:
  explicit HostGatewayBoard(bus::VirtualBus& bus) : HostCan(bus) {}
  std::size_t uart_read(std::span<char> in) { return from_computer_.read(in); }
  std::size_t uart_write(std::span<const char> out) { return to_computer_.write(out); }
  [[nodiscard]] std::uint32_t uart_lost() const { return 0; }  // the line inside this process loses nothing

  SerialFifo& from_computer() { return from_computer_; }
  SerialFifo& to_computer() { return to_computer_; }

 private:
  SerialFifo from_computer_;
  SerialFifo to_computer_;
};

}  // namespace hoist::firmware
