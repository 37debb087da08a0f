// The UART-CAN gateway: SLCAN on the serial line, frames on the bus. It understands no CANopen and holds no state that could go stale:
// when the computer falls silent it sends nothing, and the drives stop by their own deadline.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "control/contract/slcan_codec.hpp"
#include "firmware/lib/board.hpp"

namespace hoist::firmware {

inline constexpr std::size_t kGatewayTxMax = 16;        // frames from the computer waiting for the bus; more are refused with BEL
inline constexpr std::size_t kGatewayRxMax = 32;        // frames kept for polling (X0)
inline constexpr std::size_t kGatewayUartMax = 1024;    // characters waiting for the serial line, 10 ms of it at 1 Mbaud
inline constexpr std::size_t kGatewayReplyRoom = 64;    // of these kept free for answers
inline constexpr std::size_t kGatewayReadsPerPoll = 8;  // pieces of 64 characters taken from the serial line at once

struct GatewayCounters {
  std::uint32_t to_bus = 0, to_uart = 0;
  std::uint32_t lost_to_uart = 0;  // the computer or the serial line was too slow
  std::uint32_t refused = 0;       // lines answered with BEL
  std::uint32_t lost_replies = 0;
};

template <GatewayBoard Board>
class GatewayNode {
 public:
  using CanFrame = contract::CanFrame;

  explicit GatewayNode(Board& board) : board_(board) {}

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
    poll();
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
    open_ = listen_only_ = stamps_ = false;
    auto_send_ = true;
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
  static constexpr std::uint8_t kRxFull = 0x01, kTxFull = 0x02, kOverrun = 0x08;
  static constexpr std::string_view kOk = "\r", kBell = "\a";

  struct Received {
    CanFrame frame{};
    std::uint16_t at_ms = 0;
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
    if (tx_count_ == kGatewayTxMax) {
      flags_ |= kTxFull;
      return refuse();
    }
    // By id, so that a SYNC never waits behind a queue of SDOs; equal ids keep their order.
    std::size_t at = tx_count_++;
    for (; at > 0 && tx_[at - 1].id > line.frame.id; --at) tx_[at] = tx_[at - 1];
    tx_[at] = line.frame;
    if (auto_send_)
      reply((line.frame.flags & CanFrame::kExtended) != 0 ? "Z\r" : "z\r");
    else
      reply(kOk);
  }

  void on_command(std::string_view text) {
    const char argument = text.size() == 2 ? text[1] : '\0';
    switch (text[0]) {
      case 'S':  // the bus has one rate
        return accept(!open_ && argument == '5');
      case 'O':
      case 'L':
        // A second one is refused and changes nothing: some programs send it twice.
        if (text.size() != 1 || open_) return refuse();
        open_ = true;
        listen_only_ = text[0] == 'L';
        clear_queues();
        return accept(true);
      case 'C':
        if (text.size() != 1) return refuse();
        open_ = listen_only_ = false;
        clear_queues();
        return accept(true);
      case 'X':
        if (argument != '0' && argument != '1') return refuse();
        auto_send_ = argument == '1';
        return accept(true);
      case 'Z':
        if (open_ || (argument != '0' && argument != '1')) return refuse();
        stamps_ = argument == '1';
        return accept(true);
      case 'P':
        if (text.size() != 1 || !open_ || auto_send_) return refuse();
        if (rx_count_ == 0) return reply(kOk);
        put_polled();
        return;
      case 'A':
        if (text.size() != 1 || !open_ || auto_send_) return refuse();
        while (rx_count_ > 0) put_polled();
        return reply("A\r");
      case 'F': {
        if (text.size() != 1) return refuse();
        const char answer[4] = {'F', contract::slcan_detail::hex_digit(flags_ >> 4), contract::slcan_detail::hex_digit(flags_), '\r'};
        flags_ = 0;
        return reply(std::string_view(answer, 4));
      }
      case 'V':
        return text.size() == 1 ? reply("V1010\r") : refuse();
      case 'v':
        return text.size() == 1 ? reply("v0001\r") : refuse();
      case 'N':
        return text.size() == 1 ? reply(board_.simulated() ? "NSIM1\r" : "N0001\r") : refuse();
      case 'M':  // no filter: only the code and mask that let everything through
        return accept(!open_ && text == "M00000000");
      case 'm':
        return accept(!open_ && text == "mFFFFFFFF");
      default:
        return refuse();
    }
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
    while (sent < tx_count_ && board_.send(tx_[sent])) ++sent;
    counters_.to_bus += static_cast<std::uint32_t>(sent);
    for (std::size_t i = sent; i < tx_count_; ++i) tx_[i - sent] = tx_[i];
    tx_count_ -= sent;
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
  }

  // A whole line or nothing of it.
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

  Board& board_;
  bool open_ = false, listen_only_ = false, stamps_ = false;
  bool auto_send_ = true;
  std::uint32_t flags_ = 0;
  std::uint16_t now_ms_ = 0;
  contract::SlcanDecoder decoder_{};
  GatewayCounters counters_{};
  std::size_t tx_count_ = 0;
  std::array<CanFrame, kGatewayTxMax> tx_{};
  std::size_t rx_first_ = 0, rx_count_ = 0;
  std::array<Received, kGatewayRxMax> rx_{};
  std::size_t uart_first_ = 0, uart_count_ = 0;
  std::array<char, kGatewayUartMax> uart_{};
};

}  // namespace hoist::firmware
