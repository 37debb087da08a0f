// The input board: bumpers and switches on change and every 10 ms, battery voltages every 100 ms; eight outputs, set by RPDO1, with error
// values (6206h, 6207h) after its deadline or outside operational. CiA 401. Four of the outputs are the node's own: buzzer and lights
// (alarm_player.hpp), which go on when the computer is gone.
#pragma once
#include <cstdint>

#include "firmware/lib/canopen_node.hpp"
#include "firmware/lib/convert.hpp"
#include "firmware/nodes/io/alarm_player.hpp"

namespace hoist::firmware {

template <IoBoard Board>
class IoNode {
 public:
  using Stack = CanopenNode<Board, contract::NodeKind::io>;

  IoNode(Board& board, contract::Node node) : board_(board), stack_(board, node) { on_power_on(); }

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
    write_outputs();
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
  void on_rpdo() { alarm_.command(stack_.values().template get<0x2400, 1>()); }
  void on_rpdo_deadline() {
    outputs_to_error_values();
    alarm_.lose_computer();
  }
  void on_heartbeat_lost() { alarm_.lose_computer(); }
  void on_nmt(NmtState, NmtState) {
    outputs_to_error_values();
    alarm_.forget();
  }
  void on_power_on() {
    pressed_ = 0;
    alarm_ = {};
    // Off, not the error values: those apply after a computer was lost.
    stack_.values().template set<0x6200, 1>(0);
    board_.set_outputs(0);
    stack_.values().template set<0x2221>(static_cast<std::uint8_t>(board_.reset_cause()));
  }
  // Only an RPDO has a deadline, so only an RPDO may switch something on.
  SdoAbort check_write(std::uint16_t index, std::uint8_t, std::uint32_t) {
    return index == 0x6200 || index == 0x2400 ? SdoAbort::device_state : SdoAbort::none;
  }
  void write_outputs() {
    namespace canopen = contract::canopen;
    constexpr unsigned kOwn = canopen::kBuzzer | canopen::kRedLight | canopen::kYellowLight | canopen::kCyanLight;
    board_.set_outputs(static_cast<std::uint8_t>((stack_.values().template get<0x6200, 1>() & ~kOwn) | alarm_.step_1ms()));
  }
  void outputs_to_error_values() {
    auto& values = stack_.values();
    const unsigned mode = values.template get<0x6206, 1>(), value = values.template get<0x6207, 1>(),
                   now = values.template get<0x6200, 1>();
    values.template set<0x6200, 1>(static_cast<std::uint8_t>((now & ~mode) | (value & mode)));
  }

  std::int16_t battery_10mv(int battery) {
    const std::int16_t value = to_integer<std::int16_t>(100.0F * board_.battery_v(battery));
    return value < 0 ? std::int16_t{0} : value;
  }

  Board& board_;
  Stack stack_;
  AlarmPlayer alarm_;
  std::uint8_t pressed_ = 0;  // pressed now or since the last frame
};

}  // namespace hoist::firmware
