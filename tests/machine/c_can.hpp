// The CAN controller of the LPC11C24: a Bosch C_CAN (user's manual revision 1.2) with 32 message objects, its registers
// as in UM10398, chapter 16. Strict: registers that need INIT and CCE, interface registers touched while busy, objects
// that do not exist and wrong bit rates are violations.
//
// Not modelled: test modes, disabled automatic retransmission (both are violations), the time a receiving object needs
// to be found.
#pragma once

#include <array>
#include <cstdint>

#include "tests/machine/can_wire.hpp"
#include "tests/machine/time.hpp"

namespace hoist::machine {

class CCan : public CanController {
 public:
  explicit CCan(Complain complain) : complain_(std::move(complain)) { reset(); }

  void reset();
  /// `cycles` counts the chip's system clock, for the busy bit; `clock_hz` is its rate.
  [[nodiscard]] std::uint32_t read(std::uint32_t offset, std::uint64_t cycles);
  void write(std::uint32_t offset, std::uint32_t value, std::uint64_t cycles, std::uint32_t clock_hz);
  [[nodiscard]] bool line() const { return (control_ & 2U) != 0 && interrupt_id() != 0; }

  // The wire's side.
  [[nodiscard]] bool on_bus() const override { return (control_ & 1U) == 0 && integrated_bits_ >= 11 && recovery_bits_ == 0 && rate_good_; }
  [[nodiscard]] bool offer(contract::CanFrame& frame) override;
  void began() override;
  void sent(CanError error) override;
  void heard(const contract::CanFrame& frame, CanError error) override;
  void idle(std::uint64_t bits) override;

 private:
  static constexpr unsigned kObjects = 32;
  static constexpr std::uint64_t kBusyCycles = 6;  // C_CAN: 3 to 6 clocks for a transfer
  struct Object {
    std::uint32_t mask1{}, mask2{}, arb1{}, arb2{}, control{};
    std::array<std::uint16_t, 4> data{};
  };
  struct Interface {
    std::uint32_t command_mask{}, request{1}, mask1{0xFFFF}, mask2{0xFFFF}, arb1{}, arb2{}, control{};
    std::array<std::uint16_t, 4> data{};
    std::uint64_t busy_until{};
  };
  [[nodiscard]] std::uint32_t interrupt_id() const;
  [[nodiscard]] std::uint32_t gather(std::uint32_t bit_of_control, unsigned half) const;
  void transfer(Interface& through, unsigned number);
  void look();
  [[nodiscard]] bool accepts(const Object& object, const contract::CanFrame& frame) const;
  void update_states() override;
  void note_status(bool is_error_state);

  Complain complain_;
  std::uint32_t control_{1}, status_{}, timing_{0x2301}, prescaler_{}, clock_divider_{};
  std::array<Object, kObjects> objects_{};
  std::array<Interface, 2> interfaces_{};
  std::uint32_t wants_{}, pending_{};  // objects with a transmit request, with an interrupt request; updated by look()
  int sending_{-1};
  bool status_pending_{};
  bool rate_good_{};
};

}  // namespace hoist::machine
