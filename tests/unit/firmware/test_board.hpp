// A board made of plain variables: what the node reads is set by the test, what it sends is kept.
#pragma once
#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "control/contract/can_dictionary.hpp"
#include "firmware/lib/board.hpp"

namespace hoist::firmware {

using contract::CanFrame;
namespace canopen = contract::canopen;

struct TestBoard {
  std::vector<CanFrame> sent;
  bool room = true;  // whether the controller takes frames
  bool is_simulated = true;

  ImuSample imu{0, 0, 9.80665F, 0, 0, 0};
  bool imu_fresh = true;
  int imu_reads = 0;

  std::int32_t counts = 0;
  float current_a = 0, supply_voltage_v = 24;
  bool bridge_on = false;
  float duty_norm = 0;

  std::uint8_t bumper_bits = 0, switch_bits = 0;
  float batteries_v[2] = {12.5F, 12.25F};

  std::string from_host, to_host;
  std::size_t uart_room = 1U << 20;

  bool send(const CanFrame& frame) {
    if (room) sent.push_back(frame);
    return room;
  }
  bool simulated() const { return is_simulated; }
  bool read_imu(ImuSample& sample) {
    ++imu_reads;
    if (imu_fresh) sample = imu;
    return imu_fresh;
  }
  std::int32_t encoder_counts() { return counts; }
  float motor_current_a() { return current_a; }
  float supply_v() { return supply_voltage_v; }
  void set_bridge(bool enabled, float duty) {
    bridge_on = enabled;
    duty_norm = duty;
  }
  std::uint8_t bumpers() { return bumper_bits; }
  std::uint8_t switches() { return switch_bits; }
  float battery_v(int battery) { return batteries_v[battery]; }
  std::size_t uart_read(std::span<char> in) {
    const std::size_t n = std::min(in.size(), from_host.size());
    std::copy_n(from_host.begin(), n, in.begin());
    from_host.erase(0, n);
    return n;
  }
  std::size_t uart_write(std::span<const char> out) {
    const std::size_t n = std::min(out.size(), uart_room);
    to_host.append(out.data(), n);
    uart_room -= n;
    return n;
  }

  std::vector<CanFrame> with_id(std::uint32_t id) const {
    std::vector<CanFrame> found;
    std::copy_if(sent.begin(), sent.end(), std::back_inserter(found), [id](const CanFrame& f) { return f.id == id; });
    return found;
  }
};

inline CanFrame frame_of(std::uint32_t id, std::initializer_list<int> bytes) {
  CanFrame frame{id, static_cast<std::uint8_t>(bytes.size()), 0, {}};
  std::transform(bytes.begin(), bytes.end(), frame.data.begin(), [](int b) { return static_cast<std::uint8_t>(b); });
  return frame;
}

template <class Node>
void tick(Node& node, int milliseconds) {
  for (int i = 0; i < milliseconds; ++i) node.tick_1ms();
}

// Boot-up, then operational, with an empty list of sent frames.
template <class Node>
void make_operational(Node& node, TestBoard& board) {
  node.tick_1ms();
  node.on_frame(canopen::nmt(canopen::NmtCommand::start, 0));
  board.sent.clear();
}

// The one answer to a request.
template <class Node>
CanFrame ask(Node& node, TestBoard& board, const CanFrame& request) {
  board.sent.clear();
  node.on_frame(request);
  return board.sent.size() == 1 ? board.sent[0] : CanFrame{0xFFFF, 0, 0, {}};
}

}  // namespace hoist::firmware
