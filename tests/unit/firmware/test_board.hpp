// A board made of plain variables: the test sets what the node reads; sent frames are stored.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
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

// Two pages of flash. Each byte written and each page erased costs one of `power_left`; what comes after the last is not carried out, as
// when the supply is cut there.
struct TestFlash {
  static constexpr std::size_t kPageBytes = 1024;
  std::array<std::vector<std::byte>, 2> pages{std::vector<std::byte>(kPageBytes, std::byte{0xFF}),
                                              std::vector<std::byte>(kPageBytes, std::byte{0xFF})};
  std::size_t power_left = static_cast<std::size_t>(-1);
  bool refuses = false;

  bool erase(int page) {
    if (refuses || power_left == 0) return false;
    --power_left;
    std::fill(pages.at(static_cast<std::size_t>(page)).begin(), pages.at(static_cast<std::size_t>(page)).end(), std::byte{0xFF});
    return true;
  }
  bool write(int page, std::size_t offset, std::span<const std::byte> bytes) {
    if (refuses) return false;
    std::vector<std::byte>& target = pages.at(static_cast<std::size_t>(page));
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (power_left == 0) return false;
      --power_left;
      target.at(offset + i) &= bytes[i];
      if (target[offset + i] != bytes[i]) return false;
    }
    return true;
  }
  std::span<const std::byte> read(int page) const { return pages.at(static_cast<std::size_t>(page)); }
};

struct TestBoard {
  std::vector<CanFrame> sent;
  bool room = true;  // whether the controller takes frames
  bool is_simulated = true;
  CanHealth health{};
  int can_restarts = 0;

  TestFlash pages{};
  ResetCause cause = ResetCause::power;
  int restarts = 0, loader_restarts = 0;

  ImuSample imu{0, 0, 9.80665F, 0, 0, 0};
  bool imu_fresh = true;
  int imu_reads = 0;
  ImuReport report{true, false, false, 0x68};

  std::int32_t counts = 0;
  float current_a = 0, supply_voltage_v = 24;
  bool bridge_on = false;
  float duty_norm = 0;
  std::uint32_t edge_us = kEdgeTimeUnknown_us, illegal_steps = 0;
  bool driver_good = true;

  std::uint8_t bumper_bits = 0, switch_bits = 0;
  float batteries_v[2] = {12.5F, 12.25F};
  std::uint8_t output_bits = 0;

  std::string from_host, to_host;
  std::size_t uart_room = 1U << 20;
  std::uint32_t uart_lost_count = 0;

  bool send(const CanFrame& frame) {
    if (room) sent.push_back(frame);
    return room;
  }
  bool simulated() const { return is_simulated; }
  CanHealth can_health() const { return health; }
  void can_restart() { ++can_restarts; }
  TestFlash& flash() { return pages; }
  ResetCause reset_cause() const { return cause; }
  void restart(bool into_loader) { ++(into_loader ? loader_restarts : restarts); }
  ImuReport imu_report() const { return report; }
  bool read_imu(ImuSample& sample) {
    ++imu_reads;
    if (imu_fresh) sample = imu;
    return imu_fresh;
  }
  std::int32_t encoder_counts() { return counts; }
  float motor_current_a() { return current_a; }
  float supply_v() { return supply_voltage_v; }
  std::uint32_t edge_time_us() { return edge_us; }
  std::uint32_t illegal_encoder_steps() { return illegal_steps; }
  bool driver_ok() { return driver_good; }
  void set_bridge(bool enabled, float duty) {
    bridge_on = enabled;
    duty_norm = duty;
  }
  std::uint8_t bumpers() { return bumper_bits; }
  std::uint8_t switches() { return switch_bits; }
  float battery_v(int battery) { return batteries_v[battery]; }
  void set_outputs(std::uint8_t outputs) { output_bits = outputs; }
  std::uint32_t uart_lost() const { return uart_lost_count; }
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
