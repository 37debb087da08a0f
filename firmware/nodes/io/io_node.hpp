// The input board: bumpers and switches at once when they change and every 20 ms anyway, battery voltages every 100 ms. CiA 401.
#pragma once
#include <cstdint>

#include "firmware/lib/canopen_node.hpp"
#include "firmware/lib/convert.hpp"

namespace hoist::firmware {

template <IoBoard Board>
class IoNode {
 public:
  using Stack = CanopenNode<Board, contract::NodeKind::io>;

  IoNode(Board& board, contract::Node node) : board_(board), stack_(board, node) {}

  void on_frame(const CanFrame& frame) { stack_.on_frame(frame, *this); }

  void tick_1ms() {
    auto& values = stack_.values();
    const std::uint8_t bumpers = board_.bumpers(), switches = board_.switches();
    // No debouncing: a bumper that touches for one millisecond has touched. The inhibit time bounds the traffic of a chattering one, and
    // a press shorter than that is held until it has been sent.
    const std::uint8_t shown = values.template get<0x6000, 1>();
    if (bumpers != shown || switches != values.template get<0x6000, 2>()) stack_.request_pdo(contract::Pdo::io_tx1);
    pressed_ = static_cast<std::uint8_t>(pressed_ | bumpers);
    values.template set<0x6000, 1>(pressed_);
    values.template set<0x6000, 2>(switches);
    // In hundredths of a volt. What is not a number reads as 0 V, which stops the hoist.
    values.template set<0x6401, 1>(battery_10mv(0));
    values.template set<0x6401, 2>(battery_10mv(1));
    const std::uint32_t sent_before = stack_.sent(contract::Pdo::io_tx1);
    stack_.tick_1ms(*this);
    if (stack_.sent(contract::Pdo::io_tx1) != sent_before || !stack_.operational()) pressed_ = bumpers;
  }

  void power_on() {
    stack_.power_on();
    on_power_on();
  }
  [[nodiscard]] const Stack& stack() const { return stack_; }

 private:
  friend Stack;
  void on_sync() {}
  void on_rpdo() {}
  void on_rpdo_deadline() {}
  void on_heartbeat_lost() {}
  void on_nmt(NmtState, NmtState) {}
  void on_power_on() { pressed_ = 0; }
  SdoAbort check_write(std::uint16_t, std::uint8_t, std::uint32_t) { return SdoAbort::none; }

  std::int16_t battery_10mv(int battery) {
    const std::int16_t value = to_integer<std::int16_t>(100.0F * board_.battery_v(battery));
    return value < 0 ? std::int16_t{0} : value;
  }

  Board& board_;
  Stack stack_;
  std::uint8_t pressed_ = 0;  // pressed now or since the last frame
};

}  // namespace hoist::firmware
