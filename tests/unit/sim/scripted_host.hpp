// A computer on the bus with CANopen only: starts the nodes, sends heartbeat, SYNC and drive commands. No control laws.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "control/contract/can_dictionary.hpp"
#include "firmware/sim/world.hpp"

namespace hoist::sim {

class ScriptedHost {
 public:
  explicit ScriptedHost(World& world) : world_(world) {}

  /// Ten milliseconds of the world with the commands in force.
  void cycle() {
    receive();
    if (cycles_ % 50 == 0) send(contract::canopen::nmt(contract::canopen::NmtCommand::start, 0));
    if (cycles_ % 10 == 0)
      send(contract::canopen::heartbeat(contract::node_id(contract::Node::core), contract::canopen::NmtState::operational));
    if (commands) {
      command(contract::Node::drive_left, left_rad_s);
      command(contract::Node::drive_right, right_rad_s);
    }
    if (syncs) send(contract::canopen::sync());
    for (int i = 0; i < 10; ++i) world_.advance_1ms();
    ++cycles_;
  }
  void run(double seconds) {
    for (long left = std::lround(seconds * 100.0); left > 0; --left) cycle();
  }
  /// Through the CiA 402 states to operation enabled.
  void enable() {
    for (const std::uint16_t word : {std::uint16_t{0x06}, std::uint16_t{0x07}, std::uint16_t{0x0F}}) {
      control_word = word;
      run(0.05);
    }
  }
  void drive(double wheels_m_s) { left_rad_s = right_rad_s = wheels_m_s / 0.10 * 30.0; }

  bool commands{true};
  bool syncs{true};
  std::uint16_t control_word{0x06};
  double left_rad_s{};
  double right_rad_s{};
  std::array<std::uint16_t, 2> status_word{};
  std::vector<contract::CanFrame> seen;  ///< all frames, when keep is set
  bool keep{false};
  std::array<std::uint32_t, 2048> count_by_id{};

 private:
  void send(const contract::CanFrame& frame) { (void)world_.host_send(frame); }
  void command(contract::Node node, double motor_rad_s) {
    contract::CanFrame frame{contract::pdo_cob_id(contract::Pdo::drive_rx1, node), 6, 0, {}};
    contract::write_slot(frame, contract::pdo_slot(contract::Pdo::drive_rx1, 0x6040), control_word);
    contract::write_slot(frame, contract::pdo_slot(contract::Pdo::drive_rx1, 0x60FF), static_cast<std::int64_t>(motor_rad_s * 1000.0));
    send(frame);
  }
  void receive() {
    std::array<contract::CanFrame, 64> frames;
    for (std::size_t got = world_.host_receive(frames); got > 0; got = world_.host_receive(frames)) {
      for (std::size_t i = 0; i < got; ++i) {
        ++count_by_id[frames[i].id & 0x7FF];
        for (const contract::Node node : {contract::Node::drive_left, contract::Node::drive_right})
          if (frames[i].id == contract::pdo_cob_id(contract::Pdo::drive_tx1, node))
            status_word[static_cast<std::size_t>(node)] = static_cast<std::uint16_t>(contract::read_le(frames[i].data.data(), 2));
        if (keep) seen.push_back(frames[i]);
      }
    }
  }

  World& world_;
  int cycles_{};
};

}  // namespace hoist::sim
