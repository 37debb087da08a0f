// The CAN controller of the STM32F072: a bxCAN (RM0091, chapter 29) with three transmit mailboxes, two FIFOs of three and 14 filter banks.
// Strict: registers that need initialisation mode, mailboxes touched while they are pending, filters changed while they are active and
// wrong bit rates are violations.
//
// Not modelled, and a violation: time-triggered mode, no automatic retransmission, loop-back and silent mode, FIFO lock.
#pragma once

#include <array>
#include <cstdint>

#include "tests/machine/can_wire.hpp"
#include "tests/machine/time.hpp"

namespace hoist::machine {

class BxCan : public CanController {
 public:
  explicit BxCan(Complain complain) : complain_(std::move(complain)) { reset(); }

  void reset();
  /// Whether the pins are switched to the block.
  void set_pins(bool connected) { pins_ = connected; }
  [[nodiscard]] std::uint32_t read(std::uint32_t offset, std::uint64_t cycles);
  void write(std::uint32_t offset, std::uint32_t value, std::uint64_t cycles, std::uint32_t clock_hz);
  [[nodiscard]] bool line() const;

  // The wire's side.
  [[nodiscard]] bool on_bus() const override {
    return pins_ && mode_ == Mode::normal && integrated_bits_ >= kIntegrationBits && recovery_bits_ == 0 && !bus_off_ && rate_good_;
  }
  [[nodiscard]] bool offer(contract::CanFrame& frame) override;
  void began() override { sending_ = offered_; }
  void sent(CanError error) override;
  void heard(const contract::CanFrame& frame, CanError error) override;
  void idle(std::uint64_t bits) override;

 private:
  static constexpr unsigned kMailboxes = 3, kFifoDepth = 3, kFifos = 2, kBanks = 14;
  static constexpr std::uint64_t kReleaseCycles = 4;  // the manual: RFOM is cleared when the mailbox has been released
  enum class Mode : std::uint8_t { sleep, initialisation, normal };
  struct Message {
    std::uint32_t id{}, length{}, low{}, high{};
  };
  struct Mailbox {
    Message message{};
    bool abort{};
  };
  struct Fifo {
    std::array<Message, kFifoDepth> messages{};
    unsigned count{};
    bool full{}, overrun{};
    std::uint64_t released_at{};
  };

  [[nodiscard]] bool pending(unsigned box) const { return (boxes_[box].message.id & 1U) != 0; }
  [[nodiscard]] std::uint32_t transmit_status() const;
  [[nodiscard]] unsigned weakest() const;
  [[nodiscard]] std::uint32_t read_filter(std::uint32_t offset) const;
  [[nodiscard]] std::uint32_t read_fifo(unsigned fifo, unsigned word, std::uint64_t cycles);
  void write_control(std::uint32_t value, std::uint32_t clock_hz);
  void write_transmit(std::uint32_t value);
  void write_receive(unsigned fifo, std::uint32_t value, std::uint64_t cycles);
  void write_mailbox(unsigned box, unsigned word, std::uint32_t value);
  void write_filter(std::uint32_t offset, std::uint32_t value);
  void settle_mode();
  void finish(unsigned box, bool good, bool error);
  /// The FIFO that a filter assigns the frame to; -1: no filter lets it in.
  [[nodiscard]] int filtered(std::uint32_t id_word) const;
  void update_states() override;

  Complain complain_;
  bool pins_{};
  Mode mode_{Mode::sleep};
  std::uint32_t control_{}, status_{}, done_{}, interrupts_{}, last_error_{}, timing_{};
  std::array<Mailbox, kMailboxes> boxes_{};
  std::array<Fifo, kFifos> fifos_{};
  bool filter_init_{true};
  std::uint32_t filter_mode_{}, filter_scale_{}, filter_fifo_{}, filter_active_{};
  std::array<std::array<std::uint32_t, 2>, kBanks> banks_{};
  int offered_{-1}, sending_{-1};  // mailbox in arbitration, or being sent
  bool rate_good_{};
};

}  // namespace hoist::machine
