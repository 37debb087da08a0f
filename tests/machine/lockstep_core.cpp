#include "tests/machine/lockstep_core.hpp"

#include <cstring>

namespace hoist::machine {

LockstepCore::LockstepCore(const Image& image, unsigned flash_waits)
    : flash_(image.flash), ram_(kRamBytes, 0xA5), core_(flash_, ram_, *this) {
  const auto at = image.symbols.find("state");
  if (at == image.symbols.end()) trouble_ = "no symbol `state`";
  state_ = at == image.symbols.end() ? 0 : at->second;
  std::memcpy(&stack_top_, flash_.data(), 4);
  core_.reset();
  core_.set_flash_waits(flash_waits);
  (void)on();
}

std::uint32_t LockstepCore::field(unsigned number) const {
  std::uint32_t value = 0;
  (void)core_.peek(state_ + 4 * number, 4, value);
  return value;
}

bool LockstepCore::on() {
  core_.wake();
  (void)core_.run(kTickMax_cycles);
  if (!core_.asleep() && trouble_.empty()) trouble_ = "does not come to its end";
  return trouble_.empty();
}

// The program sleeps before and behind the work of each tick; it starts this one asleep before it, and writes the digest of a tick on the way
// to the next one.
bool LockstepCore::tick() {
  if (!trouble_.empty()) return false;
  const std::uint64_t cycles = core_.busy_cycles(), instructions = core_.instructions();
  if (!on()) return false;
  cycles_ = core_.busy_cycles() - cycles;
  instructions_ = core_.instructions() - instructions;
  return on();
}

}  // namespace hoist::machine
