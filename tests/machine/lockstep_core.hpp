// A bare core that runs a lockstep program (programs/lockstep.cpp) tick by tick, and counts the clocks of the node's own work.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/machine/cortex_m0.hpp"
#include "tests/machine/image.hpp"
#include "tests/machine/lpc11c24.hpp"

namespace hoist::machine {

class LockstepCore : private PeripheralBus {
 public:
  explicit LockstepCore(const Image& image, unsigned flash_waits = 0);

  /// One tick. False when the program does not come to its end: trouble() says why.
  [[nodiscard]] bool tick();
  [[nodiscard]] std::uint32_t digest() const { return field(1); }
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  /// Clocks and instructions of the node's work in the last tick.
  [[nodiscard]] std::uint64_t cycles() const { return cycles_; }
  [[nodiscard]] std::uint64_t instructions() const { return instructions_; }
  [[nodiscard]] CortexM0& core() { return core_; }
  /// Bytes of stack used so far.
  [[nodiscard]] std::uint32_t stack_bytes() const { return stack_top_ - core_.lowest_sp(); }

 private:
  bool read(std::uint32_t, unsigned, std::uint32_t&) override { return false; }
  bool write(std::uint32_t, unsigned, std::uint32_t) override { return false; }
  bool call_rom(std::uint32_t) override { return false; }
  void request_reset() override {}
  void violation(const std::string& what) override { trouble_ = what; }
  [[nodiscard]] std::uint32_t field(unsigned number) const;
  /// On to the next place where the program sleeps.
  [[nodiscard]] bool on();

  static constexpr std::uint64_t kTickMax_cycles = 10'000'000;
  std::vector<std::uint8_t> flash_, ram_;
  CortexM0 core_;
  std::uint32_t state_{}, stack_top_{};
  std::string trouble_;
  std::uint64_t cycles_{}, instructions_{};
};

}  // namespace hoist::machine
