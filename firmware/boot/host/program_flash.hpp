// The flash of an application in memory, as strict as silicon: erased by units, written by pages that must be erased, bits can only be
// cleared. The power can be cut within any operation: that one is then half done, and later ones do nothing.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace hoist::firmware {

class ProgramFlash {
 public:
  static constexpr std::size_t kWritePage = 256;
  static constexpr std::size_t kEraseUnit = 4096;
  static constexpr std::size_t kBytes = 0x5000;
  static constexpr std::uint64_t kNever = std::numeric_limits<std::uint64_t>::max();

  ProgramFlash() { bytes_.fill(kErased); }

  [[nodiscard]] std::span<const std::uint8_t> read() const { return bytes_; }

  bool erase(std::size_t unit) {
    if (unit >= kBytes / kEraseUnit) return ++misuses_, false;
    const auto place = std::span(bytes_).subspan(unit * kEraseUnit, kEraseUnit);
    for (std::size_t i = 0; i < place.size(); ++i) {
      if (!step(1)) {
        // An interrupted erase leaves cells between levels: here every other remaining byte reads as a wrong value.
        for (; i < place.size(); i += 2) place[i] = static_cast<std::uint8_t>(place[i] | (0x5AU + i));
        return false;
      }
      place[i] = kErased;
    }
    ++erases_;
    return !worn_;
  }
  bool write(std::size_t offset, std::span<const std::uint8_t> bytes) {
    if (offset % kWritePage != 0 || bytes.size() != kWritePage || offset > kBytes - kWritePage) return ++misuses_, false;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (!step(1)) return false;
      if (bytes_[offset + i] != kErased) ++misuses_;
      bytes_[offset + i] = static_cast<std::uint8_t>(bytes_[offset + i] & bytes[i]);
    }
    ++writes_;
    return !worn_;
  }
  /// As a programmer would: any content at any place.
  void burn(std::span<const std::uint8_t> content) {
    bytes_.fill(kErased);
    std::copy_n(content.begin(), std::min(content.size(), kBytes), bytes_.begin());
  }

  /// Bytes that may still be erased or written before the power goes; it stays off until power_up().
  void cut_after(std::uint64_t bytes) { left_ = bytes; }
  [[nodiscard]] bool powered() const { return left_ != 0; }
  void power_up() { left_ = kNever; }
  /// Every operation does its work and reports that it failed.
  void set_worn(bool worn) { worn_ = worn; }

  [[nodiscard]] std::uint64_t used() const { return used_; }        // bytes erased or written so far
  [[nodiscard]] std::uint32_t misuses() const { return misuses_; }  // places that were not there, or written without being erased
  [[nodiscard]] std::uint32_t erases() const { return erases_; }
  [[nodiscard]] std::uint32_t writes() const { return writes_; }

 private:
  static constexpr std::uint8_t kErased = 0xFF;
  bool step(std::uint64_t bytes) {
    if (left_ < bytes) {
      left_ = 0;
      return false;
    }
    if (left_ != kNever) left_ -= bytes;
    used_ += bytes;
    return true;
  }
  std::array<std::uint8_t, kBytes> bytes_{};
  std::uint64_t left_ = kNever;
  std::uint64_t used_ = 0;
  std::uint32_t misuses_ = 0, erases_ = 0, writes_ = 0;
  bool worn_ = false;
};

}  // namespace hoist::firmware
