#include "tests/machine/cortex_m0.hpp"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>

namespace hoist::machine {
namespace {

constexpr std::uint32_t kExcReturnMask = 0xF0000000;
constexpr int kThreadPriority = 256;  // below every configurable one

std::string hex(std::uint32_t value) {
  std::array<char, 12> text{};
  std::snprintf(text.data(), text.size(), "%08X", value);
  return text.data();
}
constexpr std::uint32_t bits(std::uint32_t value, unsigned from, unsigned count) { return (value >> from) & ((1U << count) - 1U); }
constexpr std::uint32_t sign_extend(std::uint32_t value, unsigned width) {
  const std::uint32_t sign = 1U << (width - 1);
  return (value ^ sign) - sign;
}

}  // namespace

void CortexM0::reset() {
  r_.fill(0xDEADBEEF);  // unknown after a reset: firmware that relies on them shows
  n_ = z_ = c_ = v_ = false;
  primask_ = asleep_ = locked_up_ = false;
  exception_ = 0;
  active_count_ = 0;
  pending_ = 0;
  enabled_ = 0;
  lines_ = 0;
  irq_priority_.fill(0);
  svc_priority_ = pendsv_priority_ = systick_priority_ = 0;
  scr_ = systick_csr_ = systick_reload_ = 0;
  systick_stopped_ = 0;
  systick_zero_at_ = UINT64_MAX;
  attention_ = false;
  last_word_ = kNoWord;
  lowest_sp_ = 0xFFFFFFFF;
  r_[14] = 0xFFFFFFFF;
  std::uint32_t sp = 0, pc = 0;
  if (!peek(0, 4, sp) || !peek(4, 4, pc)) {
    locked_up_ = true;
    return;
  }
  set_sp(sp);
  if ((pc & 1U) == 0) {
    bus_.violation("reset vector without the Thumb bit");
    locked_up_ = true;
  }
  r_[15] = pc & ~1U;
}

std::uint8_t* CortexM0::memory(std::uint32_t address, unsigned size) const {
  const auto within = [size](std::span<std::uint8_t> memory, std::uint32_t at) { return at < memory.size() && size <= memory.size() - at; };
  if (within(at_zero_, address)) return &at_zero_[address];
  if (within(flash_, address - map_.flash_base)) return &flash_[address - map_.flash_base];
  if (within(ram_, address - map_.ram_base)) return &ram_[address - map_.ram_base];
  return nullptr;
}

bool CortexM0::peek(std::uint32_t address, unsigned size, std::uint32_t& value) const {
  const std::uint8_t* at = memory(address, size);
  if (at == nullptr) return false;
  value = 0;
  std::memcpy(&value, at, size);
  return true;
}
bool CortexM0::poke(std::uint32_t address, unsigned size, std::uint32_t value) {
  std::uint8_t* at = memory(address, size);
  if (at == nullptr) return false;
  std::memcpy(at, &value, size);
  return true;
}

std::uint32_t CortexM0::load(std::uint32_t address, unsigned size) {
  if ((address & (size - 1)) != 0) throw Fault{"unaligned read", address};
  std::uint32_t value = 0;
  if (const std::uint8_t* at = memory(address, size); at != nullptr) {
    if (in_flash(at)) waits_ += flash_waits_;
    switch (size) {
      case 1:
        return *at;
      case 2:
        std::memcpy(&value, at, 2);
        return value;
      default:
        std::memcpy(&value, at, 4);
        return value;
    }
  }
  if (address >= kSystemBase && address < kSystemBase + 0x1000) {
    if (size != 4) throw Fault{"system register read that is not a word", address};
    return read_system(address);
  }
  if (!bus_.read(address, size, value)) throw Fault{"read of nothing", address};
  return size == 4 ? value : value & ((1U << (8 * size)) - 1U);
}

void CortexM0::store(std::uint32_t address, unsigned size, std::uint32_t value) {
  if ((address & (size - 1)) != 0) throw Fault{"unaligned write", address};
  if (std::uint8_t* at = memory(address, size); at != nullptr && !in_flash(at)) {
    std::memcpy(at, &value, size);
    return;
  }
  if (address >= kSystemBase && address < kSystemBase + 0x1000) {
    if (size != 4) throw Fault{"system register write that is not a word", address};
    write_system(address, value);
    return;
  }
  if (!bus_.write(address, size, value)) throw Fault{"write to nothing", address};
}

std::uint16_t CortexM0::fetch(std::uint32_t address) {
  const std::uint8_t* at = memory(address, 2);
  if (at == nullptr) throw Fault{"fetch from nothing", address};
  const std::uint32_t word = address >> 2;
  if (word != last_word_) {
    last_word_ = word;
    if (in_flash(at)) {
      ++flash_words_;
      waits_ += flash_waits_;
    }
  }
  std::uint16_t op = 0;
  std::memcpy(&op, at, 2);
  return op;
}

std::uint32_t CortexM0::flags() const {
  return (n_ ? 0x80000000U : 0U) | (z_ ? 0x40000000U : 0U) | (c_ ? 0x20000000U : 0U) | (v_ ? 0x10000000U : 0U);
}
void CortexM0::set_flags(std::uint32_t apsr) {
  n_ = (apsr & 0x80000000U) != 0;
  z_ = (apsr & 0x40000000U) != 0;
  c_ = (apsr & 0x20000000U) != 0;
  v_ = (apsr & 0x10000000U) != 0;
}

std::uint32_t CortexM0::add_with_carry(std::uint32_t a, std::uint32_t b, std::uint32_t carry, bool set) {
  const std::uint64_t sum = static_cast<std::uint64_t>(a) + b + carry;
  const auto result = static_cast<std::uint32_t>(sum);
  if (set) {
    set_nz(result);
    c_ = (sum >> 32) != 0;
    v_ = ((~(a ^ b) & (a ^ result)) >> 31) != 0;
  }
  return result;
}

bool CortexM0::condition(unsigned cond) const {
  bool met = false;
  switch (cond >> 1) {
    case 0:
      met = z_;
      break;
    case 1:
      met = c_;
      break;
    case 2:
      met = n_;
      break;
    case 3:
      met = v_;
      break;
    case 4:
      met = c_ && !z_;
      break;
    case 5:
      met = n_ == v_;
      break;
    case 6:
      met = n_ == v_ && !z_;
      break;
    default:
      met = true;
      break;
  }
  return (cond & 1U) != 0 ? !met : met;
}

void CortexM0::branch_exchange(std::uint32_t target) {
  if ((target & kExcReturnMask) == kExcReturnMask && exception_ != 0) {
    leave(target);
    return;
  }
  if ((target & 1U) == 0) throw Fault{"jump into ARM state", target};
  jump(target);
}

// One instruction at r_[15]; next_pc_ is already the one behind it.
unsigned CortexM0::execute(std::uint16_t op) {
  const unsigned rd = op & 7U, rn = (op >> 3) & 7U, rm = (op >> 6) & 7U;
  const unsigned r8 = (op >> 8) & 7U;
  const std::uint32_t imm8 = op & 0xFFU, imm5 = (op >> 6) & 0x1FU;
  switch (op >> 11) {
    case 0x00: {  // LSLS, MOVS
      std::uint32_t value = r_[rn];
      if (imm5 != 0) {
        c_ = ((value >> (32 - imm5)) & 1U) != 0;
        value <<= imm5;
      }
      set_nz(r_[rd] = value);
      return 1;
    }
    case 0x01: {  // LSRS
      const std::uint32_t value = r_[rn];
      c_ = ((imm5 == 0 ? value >> 31 : value >> (imm5 - 1)) & 1U) != 0;
      set_nz(r_[rd] = imm5 == 0 ? 0 : value >> imm5);
      return 1;
    }
    case 0x02: {  // ASRS
      const auto value = static_cast<std::int32_t>(r_[rn]);
      c_ = ((imm5 == 0 ? value >> 31 : value >> (imm5 - 1)) & 1) != 0;
      set_nz(r_[rd] = static_cast<std::uint32_t>(imm5 == 0 ? value >> 31 : value >> imm5));
      return 1;
    }
    case 0x03: {  // ADDS, SUBS, register or three bits
      const std::uint32_t other = (op & 0x0400U) != 0 ? rm : r_[rm];
      r_[rd] = (op & 0x0200U) != 0 ? add_with_carry(r_[rn], ~other, 1, true) : add_with_carry(r_[rn], other, 0, true);
      return 1;
    }
    case 0x04:
      set_nz(r_[r8] = imm8);
      return 1;
    case 0x05:
      add_with_carry(r_[r8], ~imm8, 1, true);
      return 1;
    case 0x06:
      r_[r8] = add_with_carry(r_[r8], imm8, 0, true);
      return 1;
    case 0x07:
      r_[r8] = add_with_carry(r_[r8], ~imm8, 1, true);
      return 1;
    case 0x08: {
      if ((op & 0x0400U) == 0) {  // data processing
        std::uint32_t& d = r_[rd];
        const std::uint32_t m = r_[rn];
        const unsigned shift = m & 0xFFU;
        switch ((op >> 6) & 0xFU) {
          case 0x0:
            set_nz(d &= m);
            return 1;
          case 0x1:
            set_nz(d ^= m);
            return 1;
          case 0x2:
            if (shift != 0) {
              c_ = shift <= 32 && ((d >> (32 - shift)) & 1U) != 0;
              d = shift < 32 ? d << shift : 0;
            }
            set_nz(d);
            return 1;
          case 0x3:
            if (shift != 0) {
              c_ = shift < 32 ? ((d >> (shift - 1)) & 1U) != 0 : (shift == 32 && (d >> 31) != 0);
              d = shift < 32 ? d >> shift : 0;
            }
            set_nz(d);
            return 1;
          case 0x4:
            if (shift != 0) {
              const auto value = static_cast<std::int32_t>(d);
              c_ = ((shift < 32 ? value >> (shift - 1) : value >> 31) & 1) != 0;
              d = static_cast<std::uint32_t>(shift < 32 ? value >> shift : value >> 31);
            }
            set_nz(d);
            return 1;
          case 0x5:
            d = add_with_carry(d, m, c_ ? 1 : 0, true);
            return 1;
          case 0x6:
            d = add_with_carry(d, ~m, c_ ? 1 : 0, true);
            return 1;
          case 0x7:
            if (shift != 0) {
              d = std::rotr(d, static_cast<int>(shift & 31U));
              c_ = (d >> 31) != 0;
            }
            set_nz(d);
            return 1;
          case 0x8:
            set_nz(d & m);
            return 1;
          case 0x9:
            d = add_with_carry(~m, 0, 1, true);
            return 1;
          case 0xA:
            add_with_carry(d, ~m, 1, true);
            return 1;
          case 0xB:
            add_with_carry(d, m, 0, true);
            return 1;
          case 0xC:
            set_nz(d |= m);
            return 1;
          case 0xD:
            set_nz(d *= m);
            return 1;
          case 0xE:
            set_nz(d &= ~m);
            return 1;
          default:
            set_nz(d = ~m);
            return 1;
        }
      }
      // Special data and branch: high registers.
      const unsigned high_d = rd | ((op >> 4) & 8U), high_m = (op >> 3) & 0xFU;
      const std::uint32_t m = high_m == 15 ? r_[15] + 4 : r_[high_m];
      switch ((op >> 8) & 3U) {
        case 0: {
          const std::uint32_t d = high_d == 15 ? r_[15] + 4 : r_[high_d];
          if (high_d == 15) {
            jump(d + m);
            return 3;
          }
          if (high_d == 13)
            set_sp(d + m);
          else
            r_[high_d] = d + m;
          return 1;
        }
        case 1:
          if (high_d < 8 && high_m < 8) throw Fault{"CMP of two low registers in the high form", r_[15]};
          add_with_carry(r_[high_d], ~m, 1, true);
          return 1;
        case 2:
          if (high_d == 15) {
            jump(m);
            return 3;
          }
          if (high_d == 13)
            set_sp(m);
          else
            r_[high_d] = m;
          return 1;
        default:
          if ((op & 7U) != 0) throw Fault{"instruction this core does not have", r_[15]};
          if ((op & 0x80U) != 0) r_[14] = next_pc_ | 1U;
          branch_exchange(m);
          return 3;
      }
    }
    case 0x09:
      r_[r8] = load(((r_[15] + 4) & ~3U) + imm8 * 4, 4);
      return 2;
    case 0x0A:
    case 0x0B: {  // register offset
      const std::uint32_t address = r_[rn] + r_[rm];
      switch ((op >> 9) & 7U) {
        case 0:
          store(address, 4, r_[rd]);
          break;
        case 1:
          store(address, 2, r_[rd]);
          break;
        case 2:
          store(address, 1, r_[rd]);
          break;
        case 3:
          r_[rd] = sign_extend(load(address, 1), 8);
          break;
        case 4:
          r_[rd] = load(address, 4);
          break;
        case 5:
          r_[rd] = load(address, 2);
          break;
        case 6:
          r_[rd] = load(address, 1);
          break;
        default:
          r_[rd] = sign_extend(load(address, 2), 16);
          break;
      }
      return 2;
    }
    case 0x0C:
      store(r_[rn] + imm5 * 4, 4, r_[rd]);
      return 2;
    case 0x0D:
      r_[rd] = load(r_[rn] + imm5 * 4, 4);
      return 2;
    case 0x0E:
      store(r_[rn] + imm5, 1, r_[rd]);
      return 2;
    case 0x0F:
      r_[rd] = load(r_[rn] + imm5, 1);
      return 2;
    case 0x10:
      store(r_[rn] + imm5 * 2, 2, r_[rd]);
      return 2;
    case 0x11:
      r_[rd] = load(r_[rn] + imm5 * 2, 2);
      return 2;
    case 0x12:
      store(r_[13] + imm8 * 4, 4, r_[r8]);
      return 2;
    case 0x13:
      r_[r8] = load(r_[13] + imm8 * 4, 4);
      return 2;
    case 0x14:
      r_[r8] = ((r_[15] + 4) & ~3U) + imm8 * 4;
      return 1;
    case 0x15:
      r_[r8] = r_[13] + imm8 * 4;
      return 1;
    case 0x16:
    case 0x17:
      return execute_misc(op);
    case 0x18: {  // STMIA
      std::uint32_t address = r_[r8];
      unsigned count = 0;
      for (unsigned i = 0; i < 8; ++i)
        if ((imm8 & (1U << i)) != 0) {
          store(address, 4, r_[i]);
          address += 4;
          ++count;
        }
      if (count == 0) throw Fault{"store of no registers", r_[15]};
      r_[r8] = address;
      return 1 + count;
    }
    case 0x19: {  // LDMIA
      std::uint32_t address = r_[r8];
      unsigned count = 0;
      for (unsigned i = 0; i < 8; ++i)
        if ((imm8 & (1U << i)) != 0) {
          r_[i] = load(address, 4);
          address += 4;
          ++count;
        }
      if (count == 0) throw Fault{"load of no registers", r_[15]};
      if ((imm8 & (1U << r8)) == 0) r_[r8] = address;
      return 1 + count;
    }
    case 0x1A:
    case 0x1B: {
      const unsigned cond = (op >> 8) & 0xFU;
      if (cond == 0xE) throw Fault{"undefined instruction", r_[15]};
      if (cond == 0xF) {
        pending_ |= 1ULL << kSvCall;
        attention_ = true;
        return 1;
      }
      if (!condition(cond)) return 1;
      jump(r_[15] + 4 + sign_extend(imm8 << 1, 9));
      return 3;
    }
    case 0x1C:
      jump(r_[15] + 4 + sign_extend((op & 0x7FFU) << 1, 12));
      return 3;
    default: {
      const std::uint16_t second = fetch(r_[15] + 2);
      next_pc_ = r_[15] + 4;
      return execute_wide(op, second);
    }
  }
}

unsigned CortexM0::execute_misc(std::uint16_t op) {
  const unsigned rd = op & 7U, rm = (op >> 3) & 7U;
  switch ((op >> 8) & 0xFU) {
    case 0x0: {
      const std::uint32_t offset = (op & 0x7FU) * 4;
      set_sp((op & 0x80U) != 0 ? r_[13] - offset : r_[13] + offset);
      return 1;
    }
    case 0x2:
      switch ((op >> 6) & 3U) {
        case 0:
          r_[rd] = sign_extend(r_[rm] & 0xFFFFU, 16);
          return 1;
        case 1:
          r_[rd] = sign_extend(r_[rm] & 0xFFU, 8);
          return 1;
        case 2:
          r_[rd] = r_[rm] & 0xFFFFU;
          return 1;
        default:
          r_[rd] = r_[rm] & 0xFFU;
          return 1;
      }
    case 0x4:
    case 0x5: {  // PUSH
      const unsigned count = static_cast<unsigned>(std::popcount(op & 0x1FFU));
      if (count == 0) break;
      std::uint32_t address = r_[13] - 4 * count;
      const std::uint32_t low = address;
      for (unsigned i = 0; i < 8; ++i)
        if ((op & (1U << i)) != 0) {
          store(address, 4, r_[i]);
          address += 4;
        }
      if ((op & 0x100U) != 0) store(address, 4, r_[14]);
      set_sp(low);
      return 1 + count;
    }
    case 0xC:
    case 0xD: {  // POP
      const unsigned count = static_cast<unsigned>(std::popcount(op & 0x1FFU));
      if (count == 0) break;
      std::uint32_t address = r_[13];
      for (unsigned i = 0; i < 8; ++i)
        if ((op & (1U << i)) != 0) {
          r_[i] = load(address, 4);
          address += 4;
        }
      if ((op & 0x100U) == 0) {
        set_sp(address);
        return 1 + count;
      }
      const std::uint32_t target = load(address, 4);
      set_sp(address + 4);
      branch_exchange(target);
      return 3 + count;
    }
    case 0x6:  // CPS
      if ((op & 0xFFEFU) != 0xB662U) break;
      primask_ = (op & 0x10U) != 0;
      attention_ = true;
      return 1;
    case 0xA:
      switch ((op >> 6) & 3U) {
        case 0: {
          const std::uint32_t x = r_[rm];
          r_[rd] = (x >> 24) | ((x >> 8) & 0xFF00U) | ((x << 8) & 0xFF0000U) | (x << 24);
          return 1;
        }
        case 1: {
          const std::uint32_t x = r_[rm];
          r_[rd] = ((x >> 8) & 0x00FF00FFU) | ((x << 8) & 0xFF00FF00U);
          return 1;
        }
        case 3: {
          const std::uint32_t x = r_[rm];
          r_[rd] = sign_extend(((x >> 8) & 0xFFU) | ((x << 8) & 0xFF00U), 16);
          return 1;
        }
        default:
          break;
      }
      break;
    case 0xE:
      throw Fault{"breakpoint", r_[15]};
    case 0xF:
      if ((op & 0xFU) != 0) break;  // IT: not in this core
      switch ((op >> 4) & 0xFU) {
        case 0:
        case 1:
        case 2:
        case 4:
          return 1;  // NOP, YIELD, WFE (never sleeps here), SEV
        case 3:
          // With a pending exception the core does not sleep, even if PRIMASK masks it.
          asleep_ = true;
          attention_ = true;
          return 2;
        default:
          break;
      }
      break;
    default:
      break;
  }
  throw Fault{"instruction this core does not have", r_[15]};
}

// The six 32-bit instructions of ARMv6-M: BL, MSR, MRS, DSB, DMB, ISB. Everything else belongs to larger cores.
unsigned CortexM0::execute_wide(std::uint16_t first, std::uint16_t second) {
  if ((first & 0xF800U) == 0xF000U && (second & 0xD000U) == 0xD000U) {
    const std::uint32_t s = (first >> 10) & 1U, j1 = (second >> 13) & 1U, j2 = (second >> 11) & 1U;
    const std::uint32_t i1 = (j1 ^ s) ^ 1U, i2 = (j2 ^ s) ^ 1U;
    const std::uint32_t offset = sign_extend((s << 24) | (i1 << 23) | (i2 << 22) | ((first & 0x3FFU) << 12) | ((second & 0x7FFU) << 1), 25);
    r_[14] = next_pc_ | 1U;
    jump(r_[15] + 4 + offset);
    return 4;
  }
  if ((first & 0xFFF0U) == 0xF380U && (second & 0xFF00U) == 0x8800U) {
    write_msr(second & 0xFFU, r_[first & 0xFU]);
    return 4;
  }
  if (first == 0xF3EFU && (second & 0xF000U) == 0x8000U) {
    r_[(second >> 8) & 0xFU] = read_mrs(second & 0xFFU);
    return 4;
  }
  if (first == 0xF3BFU && ((second & 0xFFF0U) == 0x8F40U || (second & 0xFFF0U) == 0x8F50U || (second & 0xFFF0U) == 0x8F60U)) return 4;
  throw Fault{"instruction this core does not have", r_[15]};
}

void CortexM0::write_msr(unsigned which, std::uint32_t value) {
  switch (which) {
    case 0:
    case 1:
    case 2:
    case 3:
      set_flags(value);
      break;
    case 8:
      set_sp(value);
      break;
    case 16:
      primask_ = (value & 1U) != 0;
      attention_ = true;
      break;
    case 20:
      if (value != 0) bus_.violation("CONTROL written: this bench has one stack and no unprivileged code");
      break;
    default:
      bus_.violation("MSR to a register that is not modelled");
      break;
  }
}
std::uint32_t CortexM0::read_mrs(unsigned which) const {
  switch (which) {
    case 0:
    case 1:
    case 2:
    case 3:
      return flags() | ((which & 1U) != 0 ? static_cast<std::uint32_t>(exception_) : 0U);
    case 5:
      return static_cast<std::uint32_t>(exception_);
    case 8:
      return r_[13];
    case 16:
      return primask_ ? 1 : 0;
    default:
      return 0;
  }
}

int CortexM0::priority_of(int exception) const {
  switch (exception) {
    case kHardFault:
      return -1;
    case kSvCall:
      return svc_priority_;
    case kPendSv:
      return pendsv_priority_;
    case kSysTick:
      return systick_priority_;
    default:
      return irq_priority_[static_cast<std::size_t>(exception - kFirstIrq)];
  }
}

int CortexM0::current_priority() const {
  int lowest = kThreadPriority;
  for (std::size_t i = 0; i < active_count_; ++i) lowest = std::min(lowest, priority_of(active_[i]));
  return lowest;
}

// Takes the most urgent pending exception if it may interrupt what runs. Whether to look again after the next instruction.
bool CortexM0::take_exception() {
  const std::uint64_t askable = pending_ & ((static_cast<std::uint64_t>(enabled_) << kFirstIrq) | 0xFFFFU);
  if (askable == 0) return false;
  int best = 0, best_priority = kThreadPriority;
  for (std::uint64_t rest = askable; rest != 0; rest &= rest - 1) {
    const int number = std::countr_zero(rest);
    const int priority = priority_of(number);
    if (priority < best_priority) {
      best = number;
      best_priority = priority;
    }
  }
  if (best_priority >= current_priority()) return false;
  asleep_ = false;  // WFI ends even when PRIMASK masks the exception
  if (primask_ && best_priority >= 0) return false;
  enter(best, r_[15]);
  return true;
}

void CortexM0::enter(int exception, std::uint32_t return_address) {
  const std::uint32_t aligned = r_[13] & 4U;
  const std::uint32_t frame = (r_[13] - 32) & ~7U;
  const std::uint32_t xpsr = flags() | 0x01000000U | static_cast<std::uint32_t>(exception_) | (aligned != 0 ? 0x200U : 0U);
  store(frame, 4, r_[0]);
  store(frame + 4, 4, r_[1]);
  store(frame + 8, 4, r_[2]);
  store(frame + 12, 4, r_[3]);
  store(frame + 16, 4, r_[12]);
  store(frame + 20, 4, r_[14]);
  store(frame + 24, 4, return_address);
  store(frame + 28, 4, xpsr);
  set_sp(frame);
  r_[14] = exception_ == 0 ? 0xFFFFFFF9U : 0xFFFFFFF1U;
  pending_ &= ~(1ULL << exception);
  active_[active_count_++] = exception;
  exception_ = exception;
  ++exception_counts_[static_cast<std::size_t>(exception)];
  if (exception == kSysTick) note_tick();
  const std::uint32_t vector = load(static_cast<std::uint32_t>(exception) * 4, 4);
  if ((vector & 1U) == 0) throw Fault{"vector without the Thumb bit", vector};
  r_[15] = vector & ~1U;
  last_word_ = kNoWord;
}

void CortexM0::leave(std::uint32_t exc_return) {
  if (exc_return != 0xFFFFFFF9U && exc_return != 0xFFFFFFF1U) throw Fault{"return from an exception by a value that is none", exc_return};
  if ((exc_return == 0xFFFFFFF1U) != (active_count_ > 1)) throw Fault{"return from an exception to the wrong level", exc_return};
  const int left = exception_;
  --active_count_;
  const std::uint32_t frame = r_[13];
  const std::uint32_t xpsr = load(frame + 28, 4);
  r_[0] = load(frame, 4);
  r_[1] = load(frame + 4, 4);
  r_[2] = load(frame + 8, 4);
  r_[3] = load(frame + 12, 4);
  r_[12] = load(frame + 16, 4);
  r_[14] = load(frame + 20, 4);
  jump(load(frame + 24, 4));
  set_sp((frame + 32) | ((xpsr & 0x200U) != 0 ? 4U : 0U));
  set_flags(xpsr);
  exception_ = active_count_ == 0 ? 0 : active_[active_count_ - 1];
  if (left >= kFirstIrq && ((lines_ >> (left - kFirstIrq)) & 1U) != 0) pending_ |= 1ULL << left;
  attention_ = true;
  waits_ += kExceptionExit_cycles - 3;  // in addition to the jump
}

void CortexM0::hard_fault(const Fault& fault) {
  bus_.violation(std::string("HardFault: ") + fault.why + " at " + hex(fault.address) + ", pc " + hex(r_[15]) + ", lr " + hex(r_[14]));
  if (current_priority() <= -1) {
    locked_up_ = true;
    return;
  }
  try {
    enter(kHardFault, r_[15]);
  } catch (const Fault&) {
    locked_up_ = true;
  }
}

std::uint64_t CortexM0::run(std::uint64_t clocks) {
  const std::uint64_t begin = cycles_, end = begin + clocks;
  stop_ = false;
  while (cycles_ < end && !locked_up_) {
    unsigned cost = 0;
    waits_ = 0;
    const auto account = [this, &cost] {
      all_waits_ += waits_;
      cycles_ += cost + waits_;
      busy_cycles_ += cost + waits_;
      if (cycles_ >= systick_zero_at_) systick_is_zero();
    };
    try {
      while (cycles_ < end && !stop_) {
        waits_ = 0;
        if (attention_) {
          attention_ = false;
          cost = 0;
          if (take_exception()) {
            attention_ = true;  // something more urgent may have come
            cost = kExceptionEntry_cycles;
            account();
            continue;
          }
        }
        if (asleep_) return cycles_ - begin;
        const std::uint32_t pc = r_[15];
        if (pc >= map_.rom_base && pc < map_.rom_end) {
          if (!bus_.call_rom(pc | 1U)) throw Fault{"call into the ROM at an address that is no routine", pc};
          next_pc_ = r_[15];
          branch_exchange(r_[14]);
          r_[15] = next_pc_;
          cost = 4;
        } else {
          const std::uint16_t op = fetch(pc);
          next_pc_ = pc + 2;
          if (see_) see_(pc, op);
          cost = execute(op);
          r_[15] = next_pc_;
        }
        ++instructions_;
        account();
      }
      break;
    } catch (const Fault& fault) {
      hard_fault(fault);
      cost += kExceptionEntry_cycles;
      account();
      if (stop_) break;
    }
  }
  return cycles_ - begin;
}

void CortexM0::sleep(std::uint64_t cycles) {
  cycles_ += cycles;
  while (cycles_ >= systick_zero_at_) systick_is_zero();
}

void CortexM0::note_tick() {
  const std::uint64_t busy = busy_cycles_ - work_busy_, waits = all_waits_ - work_waits_;
  work_busy_ = busy_cycles_;
  work_waits_ = all_waits_;
  work_.instructions += instructions_ - work_instructions_;
  work_instructions_ = instructions_;
  ++work_.ticks;
  work_.total_cycles += busy;
  work_.total_without_waits += busy - waits;
  work_.worst_cycles = std::max(work_.worst_cycles, busy);
  work_.worst_without_waits = std::max(work_.worst_without_waits, busy - waits);
}
void CortexM0::reset_work() {
  work_ = {};
  work_busy_ = busy_cycles_;
  work_waits_ = all_waits_;
  work_instructions_ = instructions_;
}

void CortexM0::set_lines(std::uint32_t lines) {
  const std::uint32_t risen = lines & ~lines_;
  lines_ = lines;
  if (risen != 0) {
    pending_ |= static_cast<std::uint64_t>(risen) << kFirstIrq;
    attention_ = true;
  }
}

// SysTick counts from its reload value down to 0; reaching 0 sets COUNTFLAG and pends; the clock after that reloads.
void CortexM0::systick_is_zero() {
  systick_csr_ |= 0x10000U;
  if ((systick_csr_ & 2U) != 0) {
    pending_ |= 1ULL << kSysTick;
    attention_ = true;
  }
  systick_zero_at_ = systick_reload_ == 0 ? UINT64_MAX : systick_zero_at_ + systick_reload_ + 1ULL;
}
std::uint64_t CortexM0::systick_left() const {
  if (systick_zero_at_ == UINT64_MAX) return systick_stopped_;
  const std::uint64_t left = systick_zero_at_ - cycles_;
  return left > systick_reload_ ? 0 : left;  // the clock in which it reloads
}
std::uint64_t CortexM0::cycles_to_systick() const {
  if ((systick_csr_ & 3U) != 3U || systick_zero_at_ == UINT64_MAX) return UINT64_MAX;
  return systick_zero_at_ - cycles_;
}

std::uint32_t CortexM0::read_system(std::uint32_t address) {
  switch (address) {
    case 0xE000E010: {
      const std::uint32_t value = systick_csr_;
      systick_csr_ &= ~0x10000U;
      return value;
    }
    case 0xE000E014:
      return systick_reload_;
    case 0xE000E018:
      return static_cast<std::uint32_t>(systick_left());
    case 0xE000E01C:
      return 0x80000000U;  // no reference clock to speak of
    case 0xE000E100:
    case 0xE000E180:
      return enabled_;
    case 0xE000E200:
    case 0xE000E280:
      return static_cast<std::uint32_t>(pending_ >> kFirstIrq);
    case 0xE000ED00:
      return 0x410CC200U;  // CPUID of a Cortex-M0 r0p0
    case 0xE000ED04:
      return static_cast<std::uint32_t>(exception_) | ((pending_ >> kSysTick & 1U) != 0 ? 0x04000000U : 0U) |
             ((pending_ >> kPendSv & 1U) != 0 ? 0x10000000U : 0U) | ((pending_ >> kFirstIrq) != 0 ? 0x00400000U : 0U);
    case 0xE000ED0C:
      return 0xFA050000U;
    case 0xE000ED10:
      return scr_;
    case 0xE000ED14:
      return 0x00000208U;
    case 0xE000ED1C:
      return static_cast<std::uint32_t>(svc_priority_) << 24;
    case 0xE000ED20:
      return (static_cast<std::uint32_t>(systick_priority_) << 24) | (static_cast<std::uint32_t>(pendsv_priority_) << 16);
    default:
      break;
  }
  if (address >= 0xE000E400 && address < 0xE000E420) {
    std::uint32_t value = 0;
    for (unsigned i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(irq_priority_[address - 0xE000E400 + i]) << (8 * i);
    return value;
  }
  bus_.violation("read of a system register this core does not have: " + hex(address));
  return 0;
}

void CortexM0::write_system(std::uint32_t address, std::uint32_t value) {
  constexpr std::uint32_t kPriorityBits = 0xC0C0C0C0;
  attention_ = true;
  switch (address) {
    case 0xE000E010:
      if ((value & 1U) != 0 && (value & 4U) == 0) bus_.violation("SysTick on its reference clock: not modelled");
      if ((value & 1U) == 0) {
        systick_stopped_ = systick_left();
        systick_zero_at_ = UINT64_MAX;
      } else if ((systick_csr_ & 1U) == 0 && (systick_stopped_ != 0 || systick_reload_ != 0)) {
        systick_zero_at_ = cycles_ + (systick_stopped_ != 0 ? systick_stopped_ : systick_reload_ + 1ULL);
      }
      systick_csr_ = (systick_csr_ & 0x10000U) | (value & 7U);
      return;
    case 0xE000E014:
      if ((value >> 24) != 0) bus_.violation("SysTick reload beyond 24 bit");
      systick_reload_ = value & 0xFFFFFFU;
      return;
    case 0xE000E018:
      systick_stopped_ = 0;
      if (systick_zero_at_ != UINT64_MAX) systick_zero_at_ = cycles_ + systick_reload_ + 1ULL;
      systick_csr_ &= ~0x10000U;
      return;
    case 0xE000E100:
      enabled_ |= value;
      return;
    case 0xE000E180:
      enabled_ &= ~value;
      return;
    case 0xE000E200:
      pending_ |= static_cast<std::uint64_t>(value) << kFirstIrq;
      return;
    case 0xE000E280:
      pending_ &= ~(static_cast<std::uint64_t>(value & ~lines_) << kFirstIrq);
      return;
    case 0xE000ED04:
      if ((value & 0x10000000U) != 0) pending_ |= 1ULL << kPendSv;
      if ((value & 0x08000000U) != 0) pending_ &= ~(1ULL << kPendSv);
      if ((value & 0x04000000U) != 0) pending_ |= 1ULL << kSysTick;
      if ((value & 0x02000000U) != 0) pending_ &= ~(1ULL << kSysTick);
      return;
    case 0xE000ED0C:
      if ((value >> 16) != 0x05FAU)
        bus_.violation("AIRCR written without its key");
      else if ((value & 4U) != 0)
        bus_.request_reset();
      return;
    case 0xE000ED10:
      if ((value & 4U) != 0) bus_.violation("deep sleep asked for: not modelled");
      scr_ = value & 0x16U;
      return;
    case 0xE000ED1C:
      svc_priority_ = static_cast<std::uint8_t>((value & kPriorityBits) >> 24);
      return;
    case 0xE000ED20:
      systick_priority_ = static_cast<std::uint8_t>((value & kPriorityBits) >> 24);
      pendsv_priority_ = static_cast<std::uint8_t>((value & kPriorityBits) >> 16);
      return;
    default:
      break;
  }
  if (address >= 0xE000E400 && address < 0xE000E420) {
    for (unsigned i = 0; i < 4; ++i)
      irq_priority_[address - 0xE000E400 + i] = static_cast<std::uint8_t>(((value & kPriorityBits) >> (8 * i)) & 0xFFU);
    return;
  }
  bus_.violation("write to a system register this core does not have: " + hex(address));
}

}  // namespace hoist::machine
