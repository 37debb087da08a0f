// The boards of a simulated hoist: the same node sources as on the microcontrollers, with a model of the machine where the hardware is.
//
// Machine is whatever plays the hardware (firmware/sim/world.cpp); a board never sees more of it than its own wires:
//   bool read_imu(contract::Node, firmware::ImuSample&)
//   std::int32_t encoder_counts(contract::Node)   float motor_current_a(contract::Node)   float supply_v()
//   void set_bridge(contract::Node, bool enabled, float duty_norm)
//   std::uint8_t bumpers()   std::uint8_t switches()   float battery_v(int)
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/bus/virtual_bus.hpp"
#include "control/contract/can_dictionary.hpp"
#include "firmware/lib/board.hpp"

namespace hoist::firmware {

/// The CAN controller every board has.
class HostCan {
 public:
  explicit HostCan(bus::VirtualBus& bus) : bus_(bus), port_(bus.add_port()) {}
  bool send(const contract::CanFrame& frame) { return bus_.send(port_, frame); }
  [[nodiscard]] bool simulated() const { return true; }
  [[nodiscard]] std::size_t port() const { return port_; }

 private:
  bus::VirtualBus& bus_;
  std::size_t port_;
};

template <class Machine>
class HostTiltBoard : public HostCan {
 public:
  HostTiltBoard(bus::VirtualBus& bus, Machine& machine, contract::Node node) : HostCan(bus), machine_(machine), node_(node) {}
  bool read_imu(ImuSample& sample) { return machine_.read_imu(node_, sample); }

 private:
  Machine& machine_;
  contract::Node node_;
};

template <class Machine>
class HostDriveBoard : public HostCan {
 public:
  HostDriveBoard(bus::VirtualBus& bus, Machine& machine, contract::Node node) : HostCan(bus), machine_(machine), node_(node) {}
  std::int32_t encoder_counts() { return machine_.encoder_counts(node_); }
  float motor_current_a() { return machine_.motor_current_a(node_); }
  float supply_v() { return machine_.supply_v(); }
  void set_bridge(bool enabled, float duty_norm) { machine_.set_bridge(node_, enabled, duty_norm); }

 private:
  Machine& machine_;
  contract::Node node_;
};

template <class Machine>
class HostIoBoard : public HostCan {
 public:
  HostIoBoard(bus::VirtualBus& bus, Machine& machine) : HostCan(bus), machine_(machine) {}
  std::uint8_t bumpers() { return machine_.bumpers(); }
  std::uint8_t switches() { return machine_.switches(); }
  float battery_v(int battery) { return machine_.battery_v(battery); }

 private:
  Machine& machine_;
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

  SerialFifo& from_computer() { return from_computer_; }
  SerialFifo& to_computer() { return to_computer_; }

 private:
  SerialFifo from_computer_;
  SerialFifo to_computer_;
};

}  // namespace hoist::firmware
