// A chip whose core does only what a test says: one load or store from RAM at a time.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/machine/chip.hpp"

namespace hoist::machine {

/// What it does can be said in one line: probe.write(…).wait(…).
template <class Self>
class Probe {
 public:
  Probe(std::unique_ptr<Chip> chip, std::uint32_t ram_base) : chip_(std::move(chip)), ram_(ram_base) { begin(); }
  /// After power-on or a reset: copies the small program into RAM again.
  void begin() {
    chip_->reset(ResetCause::power_on);
    chip_->forget_violations();
    half(0, 0x6008);  // STR r0, [r1]
    half(2, 0x6808);  // LDR r0, [r1]
    half(4, 0xE7FE);  // B .
    half(6, 0x8008);  // STRH r0, [r1]
    half(8, 0x7008);  // STRB r0, [r1]
  }
  Self& write(std::uint32_t address, std::uint32_t value) {
    chip_->core().set_reg(0, value);
    run_at(0, address);
    return self();
  }
  Self& write_half(std::uint32_t address, std::uint32_t value) {
    chip_->core().set_reg(0, value);
    run_at(6, address);
    return self();
  }
  Self& write_byte(std::uint32_t address, std::uint32_t value) {
    chip_->core().set_reg(0, value);
    run_at(8, address);
    return self();
  }
  std::uint32_t read(std::uint32_t address) {
    run_at(2, address);
    return chip_->core().reg(0);
  }
  /// Idles (the core stays in its endless loop).
  Self& wait(Time time) {
    chip_->core().set_reg(15, ram_ + 4);
    chip_->run_until(chip_->now() + time);
    return self();
  }
  Self& set_bits(std::uint32_t address, std::uint32_t bits) { return write(address, read(address) | bits); }
  [[nodiscard]] bool complained(const std::string& part) const {
    for (const auto& [what, count] : chip_->violations())
      if (what.find(part) != std::string::npos) return true;
    return false;
  }
  [[nodiscard]] std::string all() const {
    std::string out;
    for (const auto& [what, count] : chip_->violations()) out += what + "\n";
    return out;
  }
  Chip& chip() { return *chip_; }

 protected:
  Self& self() { return static_cast<Self&>(*this); }
  /// A flash whose vectors lead into the endless loop in RAM.
  static std::vector<std::uint8_t> flash_with_vectors(std::size_t bytes, std::uint32_t ram_base) {
    std::vector<std::uint8_t> flash(bytes, 0xFF);
    const auto put = [&flash](std::size_t at, std::uint32_t word) {
      for (unsigned i = 0; i < 4; ++i) flash[at + i] = static_cast<std::uint8_t>(word >> (8 * i));
    };
    for (std::size_t i = 0; i < 8; ++i) put(4 * i, 0);
    put(0, ram_base + 0x1000);
    put(4, ram_base + 5);
    put(28, ~(2 * ram_base + 0x1005) + 1);  // the checksum for the LPC11C24's ROM
    return flash;
  }

 private:
  void half(std::uint32_t at, std::uint16_t op) { EXPECT_TRUE(chip_->core().poke(ram_ + at, 2, op)); }
  void run_at(std::uint32_t at, std::uint32_t address) {
    chip_->core().set_reg(1, address);
    chip_->core().set_reg(15, ram_ + at);
    chip_->run_until(chip_->now() + 2);
  }
  std::unique_ptr<Chip> chip_;
  std::uint32_t ram_;
};

}  // namespace hoist::machine
