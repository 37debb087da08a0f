// Two parameter pages in one flash sector. The program needs six of the eight sectors, the loader one. The last sector holds both copies
// and can only be erased as a whole, so it is erased as rarely as possible: it holds eight slots, even ones for page 0 and odd ones for
// page 1, and "erasing" a page moves on to its next slot. Only when a page has no fresh slot left, at every eighth save or so, is the
// sector erased. The other page is copied to RAM before and written back first.
//
// A power cut never loses the newest good copy, except within the 0.1 s of that erase. The node then starts with its defaults and reports
// it (EMCY, parameters lost).
#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace hoist::firmware::lpc11c24 {

inline constexpr std::size_t kSlotBytes = 512;
inline constexpr std::size_t kSlotWriteBytes = 256;  // the smallest piece that the factory's routine writes

// erase(): all of it to FFh. write(): 256 bytes at a multiple of 256, checked. bytes(): its content.
template <class S>
concept FlashSector = requires(S sector, const S constant, std::size_t offset,
                               const std::array<std::uint32_t, kSlotWriteBytes / 4>& words) {
  { S::kBytes } -> std::convertible_to<std::size_t>;
  { sector.erase() } -> std::same_as<bool>;
  { sector.write(offset, words) } -> std::same_as<bool>;
  { constant.bytes() } -> std::same_as<std::span<const std::byte>>;
};

// FlashPages of firmware/lib/board.hpp.
template <FlashSector Sector>
class ParameterPages {
 public:
  static constexpr std::size_t kPageBytes = kSlotBytes;
  static constexpr std::size_t kSlots = Sector::kBytes / kSlotBytes;
  static_assert(kSlots >= 4 && kSlots % 2 == 0);

  [[nodiscard]] Sector& sector() { return sector_; }

  bool erase(int page) {
    if (page != 0 && page != 1) return false;
    const std::size_t slot = slot_of(page);
    if (blank(slot)) return true;
    if (slot + 2 < kSlots) {
      fresh_[static_cast<std::size_t>(page)] = slot + 2;
      if (blank(slot + 2)) return true;
    }
    return start_anew(1 - page);
  }
  bool write(int page, std::size_t offset, std::span<const std::byte> bytes) {
    if ((page != 0 && page != 1) || offset % kSlotWriteBytes != 0 || bytes.size() % kSlotWriteBytes != 0 || offset > kSlotBytes ||
        bytes.size() > kSlotBytes - offset)
      return false;
    return write_slot(slot_of(page), offset, bytes);
  }
  [[nodiscard]] std::span<const std::byte> read(int page) const {
    if (page != 0 && page != 1) return {};
    return slot_bytes(slot_of(page));
  }

 private:
  [[nodiscard]] std::span<const std::byte> slot_bytes(std::size_t slot) const {
    return sector_.bytes().subspan(slot * kSlotBytes, kSlotBytes);
  }
  [[nodiscard]] bool blank(std::size_t slot) const {
    for (const std::byte b : slot_bytes(slot))
      if (b != std::byte{0xFF}) return false;
    return true;
  }
  // The newest slot of a page: the one that was made fresh for it, or its last one that is not blank; its first one when all are.
  [[nodiscard]] std::size_t slot_of(int page) const {
    const auto first = static_cast<std::size_t>(page);
    if (fresh_[first] != 0) return fresh_[first];
    for (std::size_t slot = first + kSlots - 2; slot > first; slot -= 2)
      if (!blank(slot)) return slot;
    return first;
  }
  bool write_slot(std::size_t slot, std::size_t offset, std::span<const std::byte> bytes) {
    std::array<std::uint32_t, kSlotWriteBytes / 4> piece{};  // whole words, and from RAM
    for (std::size_t at = 0; at < bytes.size(); at += kSlotWriteBytes) {
      std::memcpy(piece.data(), bytes.data() + at, kSlotWriteBytes);
      if (!sector_.write(slot * kSlotBytes + offset + at, piece)) return false;
    }
    return true;
  }
  // Erases the sector; the kept page returns to its first slot.
  bool start_anew(int keep) {
    const std::size_t from = slot_of(keep);
    const bool something = !blank(from);
    std::array<std::byte, kSlotBytes> copy{};
    std::memcpy(copy.data(), slot_bytes(from).data(), kSlotBytes);
    fresh_ = {};
    if (!sector_.erase()) return false;
    return !something || write_slot(static_cast<std::size_t>(keep), 0, copy);
  }

  Sector sector_{};
  std::array<std::size_t, 2> fresh_{};  // slot that an erase has moved a page to; 0: none, it is found by looking
};

}  // namespace hoist::firmware::lpc11c24
