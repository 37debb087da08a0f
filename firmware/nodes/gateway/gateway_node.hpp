// The UART-CAN gateway: SLCAN on the serial line, frames on the bus. It knows no CANopen and keeps no stale frames: without the computer it
// sends nothing, and the drives stop by their own deadline; frames not sent in time are dropped, and all waiting frames at bus-off.
//
// Beyond plain SLCAN, enabled with E1 while closed (E0 ends it): state lines (s, a letter, two counters) when the state of the controller
// changes, and error lines (e, how many, letters o and O) when frames were lost towards the computer or towards the bus. Off by default:
// the kernel's driver never recovers from `sb`, and other programs do not know these lines.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "control/contract/slcan_codec.hpp"
#include "firmware/lib/board.hpp"

namespace hoist::firmware {

inline constexpr std::size_t kGatewayTxMax = 16;             // frames from the computer waiting for the bus; more are refused with BEL
inline constexpr std::size_t kGatewayRxMax = 32;             // frames kept for polling (X0)
inline constexpr std::size_t kGatewayUartMax = 1024;         // characters waiting for the serial line, 10 ms of it at 1 Mbaud
inline constexpr std::size_t kGatewayReplyRoom = 64;         // of these kept free for answers
inline constexpr std::size_t kGatewayReadsPerPoll = 8;       // pieces of 64 characters taken from the serial line at once
inline constexpr std::uint16_t kGatewayStale_ms = 50;        // older frames are stale commands; drives stop after 45 ms
inline constexpr std::uint32_t kGatewayBusOffWait_ms = 200;  // before each restart of a bus-off controller
inline constexpr std::uint32_t kGatewayStateLine_ms = 100;   // shortest distance of two state lines, and of two error lines
inline constexpr std::size_t kGatewayNewsRoom = kGatewayUartMax / 2;  // they leave only while so much of the line's queue is free

struct GatewayCounters {
  std::uint32_t to_bus = 0, to_uart = 0;
  std::uint32_t lost_to_uart = 0;  // the computer or the serial line was too slow
  std::uint32_t refused = 0;       // lines answered with BEL
  std::uint32_t lost_replies = 0;
  std::uint32_t stale = 0;         // frames dropped because the bus did not take them in time
  std::uint32_t bus_off = 0;       // times that the controller was bus-off
  std::uint32_t can_restarts = 0;  // restarts after bus-off
};

template <GatewayBoard Board>
class GatewayNode {
 public:
  using CanFrame = contract::CanFrame;

  explicit GatewayNode(Board& board) : board_(board) { power_on(); }

  // A frame from the bus.
  void on_frame(const CanFrame& frame) {
    if (!open_) return;
    if (auto_send_) {
      put_frame(frame);
      write_uart();
    } else if (rx_count_ == kGatewayRxMax) {
      lose_frame();
    } else {
      rx_[(rx_first_ + rx_count_++) % kGatewayRxMax] = Received{frame, now_ms_};
    }
  }

  void tick_1ms() {
    now_ms_ = static_cast<std::uint16_t>(now_ms_ + 1U == contract::kSlcanStampWrap_ms ? 0U : now_ms_ + 1U);
    watch_controller();
    poll();
    report_changes();
    write_uart();
  }

  // Moves what can be moved in both directions. May be called as often as the board likes; tick_1ms() does it too.
  void poll() {
    std::array<char, 64> piece{};
    for (std::size_t i = 0; i < kGatewayReadsPerPoll; ++i) {
      const std::size_t got = board_.uart_read(piece);
      if (got == 0) break;
      decoder_.feed(std::span<const char>(piece).first(got < piece.size() ? got : piece.size()),
                    [this](const contract::SlcanLine& line) { on_line(line); });
    }
    send_frames();
    write_uart();
  }

  void power_on() {
    open_ = listen_only_ = stamps_ = news_ = false;
    auto_send_ = true;
    bus_off_ = false;
    reported_state_ = CanHealth::State::active;
    lost_seen_ = board_.can_health().lost;
    uart_lost_seen_ = board_.uart_lost();
    lost_in_ = lost_out_ = 0;
    state_age_ms_ = error_age_ms_ = kGatewayStateLine_ms;
    flags_ = 0;
    now_ms_ = 0;
    decoder_ = {};
    counters_ = {};
    clear_queues();
    uart_first_ = uart_count_ = 0;
  }

  [[nodiscard]] bool open() const { return open_; }
  [[nodiscard]] const GatewayCounters& counters() const { return counters_; }
  [[nodiscard]] const contract::SlcanCounters& line_counters() const { return decoder_.counters(); }

 private:
  static constexpr std::uint8_t kRxFull = 0x01, kTxFull = 0x02, kWarning = 0x04, kOverrun = 0x08, kPassive = 0x20, kBusError = 0x80;
  static constexpr std::string_view kOk = "\r", kBell = "\a";

  struct Received {
    CanFrame frame{};
    std::uint16_t at_ms = 0;
  };
  struct Waiting {
    CanFrame frame{};
    std::uint16_t age_ms = 0;
  };

  void on_line(const contract::SlcanLine& line) {
    switch (line.kind) {
      case contract::SlcanKind::frame:
        return on_tx_line(line);
      case contract::SlcanKind::command:
        return on_command(line.text);
      case contract::SlcanKind::ack:
        if (!line.text.empty()) refuse();  // an empty line only clears the line before it
        return;
      case contract::SlcanKind::bel:
        return;
      default:
        refuse();
    }
  }

  void on_tx_line(const contract::SlcanLine& line) {
    // A stamp belongs to received frames.
    if (!open_ || listen_only_ || line.stamp_ms) return refuse();
    if (tx_count_ == kGatewayTxMax || bus_off_) {
      flags_ |= kTxFull;
      lose_to_bus();
      return refuse();
    }
    // By id, so that a SYNC never waits behind a queue of SDOs; equal ids keep their order.
    std::size_t at = tx_count_++;
    for (; at > 0 && tx_[at - 1].frame.id > line.frame.id; --at) tx_[at] = tx_[at - 1];
    tx_[at] = Waiting{line.frame, 0};
    if (auto_send_)
      reply((line.frame.flags & CanFrame::kExtended) != 0 ? "Z\r" : "z\r");
    else
      reply(kOk);
  }

  void on_command(std::string_view text) {
    switch (text[0]) {
      case 'O':
      case 'L':
        return open_channel(text);
      case 'C':
        return close_channel(text);
      case 'P':
      case 'A':
        return send_polled(text);
      case 'F':
        return send_flags(text);
      case 'V':
      case 'v':
      case 'N':
        return identify(text);
      default:
        return set_up(text);
    }
  }

  void open_channel(std::string_view text) {
    // A second one is refused without effect: some programs send it twice.
    if (text.size() != 1 || open_) return refuse();
    open_ = true;
    listen_only_ = text[0] == 'L';
    clear_queues();
    // Earlier states and losses do not concern this computer; a controller that is not error-active now is reported to it.
    reported_state_ = CanHealth::State::active;
    lost_in_ = lost_out_ = 0;
    reply(kOk);
  }

  void close_channel(std::string_view text) {
    if (text.size() != 1) return refuse();
    open_ = listen_only_ = false;
    clear_queues();
    reply(kOk);
  }

  // Settings. All but X are refused while the channel is open.
  void set_up(std::string_view text) {
    const char argument = text.size() == 2 ? text[1] : '\0';
    const bool zero_or_one = argument == '0' || argument == '1';
    if (open_ && text[0] != 'X') return refuse();
    switch (text[0]) {
      case 'S':  // the bus has one rate
        return accept(argument == '5');
      case 'X':
        return set_switch(auto_send_, zero_or_one, argument);
      case 'Z':
        return set_switch(stamps_, zero_or_one, argument);
      case 'E':
        return set_switch(news_, zero_or_one, argument);
      case 'M':  // no filter: only the code and mask that let everything through
        return accept(text == "M00000000");
      case 'm':
        return accept(text == "mFFFFFFFF");
      default:
        return refuse();
    }
  }
  void set_switch(bool& setting, bool valid, char argument) {
    if (valid) setting = argument == '1';
    accept(valid);
  }

  // P: the oldest received frame. A: all of them.
  void send_polled(std::string_view text) {
    if (text.size() != 1 || !open_ || auto_send_) return refuse();
    if (text[0] == 'A') {
      while (rx_count_ > 0) put_polled();
      return reply("A\r");
    }
    if (rx_count_ == 0) return reply(kOk);
    put_polled();
  }

  // Reading the flags clears them.
  void send_flags(std::string_view text) {
    if (text.size() != 1) return refuse();
    const CanHealth::State state = board_.can_health().state;
    if (state == CanHealth::State::warning) flags_ |= kWarning;
    if (state == CanHealth::State::passive) flags_ |= kPassive;
    if (state == CanHealth::State::bus_off) flags_ |= kBusError;
    const char answer[4] = {'F', contract::slcan_detail::hex_digit(flags_ >> 4), contract::slcan_detail::hex_digit(flags_), '\r'};
    flags_ = 0;
    reply(std::string_view(answer, 4));
  }

  void identify(std::string_view text) {
    if (text.size() != 1) return refuse();
    if (text[0] == 'V') return reply("V1010\r");
    if (text[0] == 'v') return reply("v0001\r");
    reply(board_.simulated() ? "NSIM1\r" : "N0001\r");
  }

  void accept(bool good) {
    if (good)
      reply(kOk);
    else
      refuse();
  }
  void refuse() {
    ++counters_.refused;
    reply(kBell);
  }
  void reply(std::string_view text) {
    if (!put(text)) ++counters_.lost_replies;
  }

  void clear_queues() {
    tx_count_ = 0;
    rx_first_ = rx_count_ = 0;
  }

  void send_frames() {
    std::size_t sent = 0;
    while (sent < tx_count_ && !bus_off_ && board_.send(tx_[sent].frame)) ++sent;
    counters_.to_bus += static_cast<std::uint32_t>(sent);
    for (std::size_t i = sent; i < tx_count_; ++i) tx_[i - sent] = tx_[i];
    tx_count_ -= sent;
  }
  void lose_to_bus() {
    if (lost_out_ < kNewsMax) ++lost_out_;
  }

  // Each millisecond: lost frames, bus-off, and frames that have waited too long.
  void watch_controller() {
    const CanHealth health = board_.can_health();
    count_losses(health.lost);
    restart_after_bus_off(health.state == CanHealth::State::bus_off);
    drop_stale();
    if constexpr (requires { board_.drop_unsent(); }) drop_unsent();
  }

  void count_losses(std::uint32_t total) {
    if (total != lost_seen_) {
      const std::uint32_t lost = total - lost_seen_;
      lost_seen_ = total;
      flags_ |= kRxFull | kOverrun;
      lost_in_ = lost >= kNewsMax ? kNewsMax : static_cast<std::uint8_t>(lost_in_ > kNewsMax - lost ? kNewsMax : lost_in_ + lost);
    }
    if (board_.uart_lost() != uart_lost_seen_) {
      uart_lost_seen_ = board_.uart_lost();
      flags_ |= kOverrun;
      lose_to_bus();  // a line to the bus is dropped whole: a character is missing or damaged (uart.hpp)
    }
  }

  void restart_after_bus_off(bool off) {
    if (off && !bus_off_) {
      ++counters_.bus_off;
      bus_off_ms_ = 0;
      counters_.stale += static_cast<std::uint32_t>(tx_count_);
      for (; tx_count_ > 0; --tx_count_) lose_to_bus();
    }
    bus_off_ = off;
    if (off && ++bus_off_ms_ >= kGatewayBusOffWait_ms) {
      bus_off_ms_ = 0;
      ++counters_.can_restarts;
      board_.can_restart();
    }
  }

  void drop_stale() {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < tx_count_; ++i) {
      if (++tx_[i].age_ms >= kGatewayStale_ms)
        lose_stale();
      else
        tx_[kept++] = tx_[i];
    }
    tx_count_ = kept;
  }

  // A controller that cannot send (no acknowledge: passive, never bus-off) keeps the frames of its own queue.
  void drop_unsent() {
    if (board_.all_sent()) {
      unsent_ms_ = 0;
    } else if (++unsent_ms_ >= kGatewayStale_ms) {
      unsent_ms_ = 0;
      board_.drop_unsent();
      lose_stale();
    }
  }
  void lose_stale() {
    ++counters_.stale;
    flags_ |= kTxFull;
    lose_to_bus();
  }

  // A change is reported once; frequent changes are limited to the newest state per interval.
  void report_changes() {
    if (state_age_ms_ < kGatewayStateLine_ms) ++state_age_ms_;
    if (error_age_ms_ < kGatewayStateLine_ms) ++error_age_ms_;
    if (!open_ || !news_ || kGatewayUartMax - uart_count_ < kGatewayNewsRoom) return;
    if (state_age_ms_ >= kGatewayStateLine_ms) report_state();
    if (error_age_ms_ >= kGatewayStateLine_ms) report_losses();
  }
  void report_state() {
    const CanHealth health = board_.can_health();
    if (health.state == reported_state_) return;
    std::array<char, 9> line{'s', "awpb"[static_cast<std::size_t>(health.state)], 0, 0, 0, 0, 0, 0, '\r'};
    put_decimal3(&line[2], health.rx_errors);
    put_decimal3(&line[5], health.tx_errors);
    if (!put(std::string_view(line.data(), line.size()))) return;
    reported_state_ = health.state;
    state_age_ms_ = 0;
  }
  // One letter each: `o` lost on the way to the computer, `O` on the way to the bus; the digit counts the letters, as the kernel reads it.
  void report_losses() {
    if (lost_in_ == 0 && lost_out_ == 0) return;
    std::array<char, 5> line{'e', lost_in_ != 0 && lost_out_ != 0 ? '2' : '1'};
    std::size_t length = 2;
    if (lost_in_ != 0) line[length++] = 'o';
    if (lost_out_ != 0) line[length++] = 'O';
    line[length++] = '\r';
    if (!put(std::string_view(line.data(), length))) return;
    lost_in_ = lost_out_ = 0;
    error_age_ms_ = 0;
  }
  static void put_decimal3(char* at, std::uint8_t value) {
    at[0] = static_cast<char>('0' + value / 100);
    at[1] = static_cast<char>('0' + value / 10 % 10);
    at[2] = static_cast<char>('0' + value % 10);
  }

  void put_polled() {
    const Received received = rx_[rx_first_];
    rx_first_ = (rx_first_ + 1) % kGatewayRxMax;
    --rx_count_;
    put_frame(received.frame, received.at_ms);
  }
  void put_frame(const CanFrame& frame) { put_frame(frame, now_ms_); }
  void put_frame(const CanFrame& frame, std::uint16_t at_ms) {
    std::array<char, contract::kSlcanLineMax + 1> line{};
    const std::size_t length = contract::slcan_encode(frame, line, stamps_ ? std::optional<std::uint16_t>(at_ms) : std::nullopt);
    if (length == 0 || kGatewayUartMax - uart_count_ < length + kGatewayReplyRoom) return lose_frame();
    if (put(std::string_view(line.data(), length))) ++counters_.to_uart;
  }
  void lose_frame() {
    ++counters_.lost_to_uart;
    flags_ |= kRxFull | kOverrun;
    if (lost_in_ < kNewsMax) ++lost_in_;
  }

  // A complete line or nothing.
  [[nodiscard]] bool put(std::string_view text) {
    if (kGatewayUartMax - uart_count_ < text.size()) return false;
    for (const char c : text) uart_[(uart_first_ + uart_count_++) % kGatewayUartMax] = c;
    return true;
  }
  void write_uart() {
    while (uart_count_ > 0) {
      const std::size_t to_end = kGatewayUartMax - uart_first_;
      const std::size_t piece = uart_count_ < to_end ? uart_count_ : to_end;
      const std::size_t taken = board_.uart_write(std::span<const char>(uart_).subspan(uart_first_, piece));
      if (taken == 0 || taken > piece) return;
      uart_first_ = (uart_first_ + taken) % kGatewayUartMax;
      uart_count_ -= taken;
    }
  }

  static constexpr std::uint8_t kNewsMax = 255;

  Board& board_;
  bool open_ = false, listen_only_ = false, stamps_ = false, news_ = false, bus_off_ = false;
  CanHealth::State reported_state_ = CanHealth::State::active;
  std::uint32_t unsent_ms_ = 0, bus_off_ms_ = 0, state_age_ms_ = 0, error_age_ms_ = 0;
  std::uint32_t lost_seen_ = 0, uart_lost_seen_ = 0;
  std::uint8_t lost_in_ = 0, lost_out_ = 0;  // since the last error line
  bool auto_send_ = true;
  std::uint32_t flags_ = 0;
  std::uint16_t now_ms_ = 0;
  contract::SlcanDecoder decoder_{};
  GatewayCounters counters_{};
  std::size_t tx_count_ = 0;
  std::array<Waiting, kGatewayTxMax> tx_{};
  std::size_t rx_first_ = 0, rx_count_ = 0;
  std::array<Received, kGatewayRxMax> rx_{};
  std::size_t uart_first_ = 0, uart_count_ = 0;
  std::array<char, kGatewayUartMax> uart_{};
};

}  // namespace hoist::firmware
