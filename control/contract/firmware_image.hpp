// The program of a node, as a file and in its flash: the bytes of the flash from the vectors on, with a header behind
// the vectors. The node's loader, the tool that packs and sends images and the application use these functions, so that
// all accept the same images.
//
//   offset 00h   vectors: 48 words, the first two are the initial stack pointer and the entry
//          C0h   magic "HOIS"
//          C4h   length of the whole image in bytes, header and vectors included
//          C8h   CRC-32 of the whole image without these four bytes
//          CCh   version, major << 16 | minor << 8 | patch
//          D0h   kind of node, D1h chip, D2h two bytes that are 0
//   All words little endian. Magic, version, kind and chip are compiled in (firmware/lib/image_header.hpp); `hoist firmware pack` fills
//   in length and CRC.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "control/contract/crc32.hpp"
#include "control/contract/params.hpp"

namespace hoist::contract {

inline constexpr std::size_t kImageHeaderAt = 0xC0;
inline constexpr std::size_t kImageHeaderBytes = 20;
inline constexpr std::size_t kImageCrcAt = kImageHeaderAt + 8;
inline constexpr std::size_t kImageMin = kImageHeaderAt + kImageHeaderBytes;
inline constexpr std::size_t kImageMax = 128U << 10;       // the largest flash of any chip; nothing longer is ever read into memory
inline constexpr std::uint32_t kImageMagic = 0x53494F48U;  // "HOIS" in the order of the bytes

// Numbers of the header, never reused. The first three are those of NodeKind.
enum class ImageKind : std::uint8_t { tilt = 0, drive = 1, io = 2, gateway = 3 };
enum class ImageChip : std::uint8_t { lpc11c24 = 1, stm32f072 = 2, simulated = 0x7F };
static_assert(static_cast<int>(ImageKind::tilt) == static_cast<int>(NodeKind::tilt) &&
              static_cast<int>(ImageKind::drive) == static_cast<int>(NodeKind::drive) &&
              static_cast<int>(ImageKind::io) == static_cast<int>(NodeKind::io));

struct ImageKindInfo {
  ImageKind kind;
  std::string_view name;
};
inline constexpr std::array kImageKinds{ImageKindInfo{ImageKind::tilt, "tilt"}, ImageKindInfo{ImageKind::drive, "drive"},
                                        ImageKindInfo{ImageKind::io, "io"}, ImageKindInfo{ImageKind::gateway, "gateway"}};

// Where an application lies and what its first two vectors may be. ram_bytes 0: a simulated chip, whose vectors mean nothing.
struct ImageChipInfo {
  ImageChip chip;
  std::string_view name;
  std::uint32_t application_at, application_max;
  std::uint32_t ram_at, ram_bytes;
};
// Flash and RAM: UM10398 table 2 (32 KB and 8 KB) and RM0091 section 2.2 (128 KB and 16 KB); the division is firmware/boot/README.md's.
inline constexpr std::array kImageChips{ImageChipInfo{ImageChip::lpc11c24, "lpc11c24", 0x1000, 0x6000, 0x10000000, 0x2000},
                                        ImageChipInfo{ImageChip::stm32f072, "stm32f072", 0x08002000, 0x1D000, 0x20000000, 0x4000},
                                        ImageChipInfo{ImageChip::simulated, "simulated", 0, 0x5000, 0, 0}};

constexpr const ImageChipInfo* find_image_chip(std::uint8_t number) {
  for (const ImageChipInfo& info : kImageChips)
    if (static_cast<std::uint8_t>(info.chip) == number) return &info;
  return nullptr;
}
constexpr const ImageChipInfo* find_image_chip(std::string_view name) {
  for (const ImageChipInfo& info : kImageChips)
    if (info.name == name) return &info;
  return nullptr;
}
constexpr const ImageKindInfo* find_image_kind(std::uint8_t number) {
  for (const ImageKindInfo& info : kImageKinds)
    if (static_cast<std::uint8_t>(info.kind) == number) return &info;
  return nullptr;
}
constexpr const ImageKindInfo* find_image_kind(std::string_view name) {
  for (const ImageKindInfo& info : kImageKinds)
    if (info.name == name) return &info;
  return nullptr;
}

struct ImageHeader {
  std::uint32_t magic = 0, length = 0, crc = 0, version = 0;
  std::uint8_t kind = 0, chip = 0;
  std::uint16_t reserved = 0;
  friend constexpr bool operator==(const ImageHeader&, const ImageHeader&) = default;
};

enum class ImageError : std::uint8_t {
  none,
  too_short,  // no room for vectors and header
  too_long,   // longer than the chip's room for an application
  magic,      // no header at C0h
  length,     // the header speaks of another length
  reserved,   // bytes that must be 0 are not
  kind,       // unknown, or not the wanted kind of node
  chip,       // unknown, or not the wanted chip
  vectors,    // stack pointer outside the RAM, or the entry outside the image or not of Thumb code
  crc,        // the content is not what was packed
};
constexpr std::string_view image_error_text(ImageError error) {
  switch (error) {
    case ImageError::none:
      return "";
    case ImageError::too_short:
      return "length: too short for vectors and header (212 bytes at least)";
    case ImageError::too_long:
      return "length: longer than the chip's room for a program";
    case ImageError::magic:
      return "magic: there is no header \"HOIS\" at C0h; this is no packed program";
    case ImageError::length:
      return "length: the header tells another length than the file has";
    case ImageError::reserved:
      return "reserved: bytes D2h and D3h must be 0";
    case ImageError::kind:
      return "kind: the program is for another kind of node";
    case ImageError::chip:
      return "chip: the program is for another chip";
    case ImageError::vectors:
      return "vectors: stack pointer or entry lie outside of the chip's memory";
    case ImageError::crc:
      return "crc: the content is not what was packed";
  }
  return "";
}

constexpr std::uint32_t image_word(std::span<const std::uint8_t> image, std::size_t at) {
  return static_cast<std::uint32_t>(image[at]) | (static_cast<std::uint32_t>(image[at + 1]) << 8) |
         (static_cast<std::uint32_t>(image[at + 2]) << 16) | (static_cast<std::uint32_t>(image[at + 3]) << 24);
}

// `image` must hold at least kImageMin bytes.
constexpr ImageHeader read_image_header(std::span<const std::uint8_t> image) {
  ImageHeader header;
  header.magic = image_word(image, kImageHeaderAt);
  header.length = image_word(image, kImageHeaderAt + 4);
  header.crc = image_word(image, kImageCrcAt);
  header.version = image_word(image, kImageHeaderAt + 12);
  header.kind = image[kImageHeaderAt + 16];
  header.chip = image[kImageHeaderAt + 17];
  header.reserved = static_cast<std::uint16_t>(image[kImageHeaderAt + 18] | (image[kImageHeaderAt + 19] << 8));
  return header;
}

// Everything that can be said from the first kImageMin bytes, before the rest has come. `kind` and `chip`: what is wanted.
constexpr ImageError check_image_start(std::span<const std::uint8_t> start, ImageKind kind, const ImageChipInfo& chip) {
  if (start.size() < kImageMin) return ImageError::too_short;
  if (image_word(start, kImageHeaderAt) != kImageMagic) return ImageError::magic;
  const std::uint32_t length = image_word(start, kImageHeaderAt + 4);
  const std::uint32_t for_whom = image_word(start, kImageHeaderAt + 16);
  if ((for_whom >> 16) != 0) return ImageError::reserved;
  if ((for_whom & 0xFFU) != static_cast<std::uint32_t>(kind)) return ImageError::kind;
  if ((for_whom >> 8) != static_cast<std::uint32_t>(chip.chip)) return ImageError::chip;
  if (length < kImageMin) return ImageError::too_short;
  if (length > chip.application_max) return ImageError::too_long;
  if (chip.ram_bytes != 0) {
    const std::uint32_t stack = image_word(start, 0), entry = image_word(start, 4);
    const bool stack_fits = stack > chip.ram_at && stack <= chip.ram_at + chip.ram_bytes && (stack & 3U) == 0;
    // Bit 0 is the mark of Thumb code; a Cortex-M0 has no other.
    const bool entry_fits = (entry & 1U) != 0 && entry >= chip.application_at + kImageMin && entry < chip.application_at + length;
    if (!stack_fits || !entry_fits) return ImageError::vectors;
  }
  return ImageError::none;
}

// CRC of an image that begins with `start` (at least up to the CRC field) and goes on with `rest`.
constexpr std::uint32_t image_crc(std::span<const std::uint8_t> start, std::span<const std::uint8_t> rest = {}) {
  Crc32 crc;
  crc.add(start.first(kImageCrcAt));
  crc.add(start.subspan(kImageCrcAt + 4));
  crc.add(rest);
  return crc.value();
}

// A whole image: as long as its header says, and with the right CRC.
constexpr ImageError check_image(std::span<const std::uint8_t> image, ImageKind kind, const ImageChipInfo& chip) {
  if (const ImageError error = check_image_start(image, kind, chip); error != ImageError::none) return error;
  if (image_word(image, kImageHeaderAt + 4) != image.size()) return ImageError::length;
  return image_crc(image) == image_word(image, kImageCrcAt) ? ImageError::none : ImageError::crc;
}

// The same for a file, for the kind and chip that its header names.
constexpr ImageError check_image_file(std::span<const std::uint8_t> image) {
  if (image.size() < kImageMin) return ImageError::too_short;
  if (image.size() > kImageMax) return ImageError::too_long;
  const ImageHeader header = read_image_header(image);
  if (header.magic != kImageMagic) return ImageError::magic;
  const ImageKindInfo* kind = find_image_kind(header.kind);
  if (kind == nullptr) return ImageError::kind;
  const ImageChipInfo* chip = find_image_chip(header.chip);
  if (chip == nullptr) return ImageError::chip;
  return check_image(image, kind->kind, *chip);
}

// What lies in flash, which is longer than the image: the program if there is a whole one, or why there is none.
constexpr ImageError check_flash(std::span<const std::uint8_t> flash, ImageKind kind, const ImageChipInfo& chip) {
  if (const ImageError error = check_image_start(flash, kind, chip); error != ImageError::none) return error;
  const std::uint32_t length = image_word(flash, kImageHeaderAt + 4);
  if (length > flash.size()) return ImageError::too_long;
  return image_crc(flash.first(length)) == image_word(flash, kImageCrcAt) ? ImageError::none : ImageError::crc;
}

inline constexpr std::uint32_t kVersionMax = 0xFFFFFFFFU;
constexpr std::uint32_t image_version(std::uint32_t major, std::uint32_t minor, std::uint32_t patch) {
  return (major << 16) | (minor << 8) | patch;
}
// "1.2.3": three decimal numbers, 0 to 65535, 0 to 255 and 0 to 255, nothing else. Nothing when it is not.
constexpr std::optional<std::uint32_t> parse_version(std::string_view text) {
  constexpr std::array<std::uint32_t, 3> kMax{0xFFFF, 0xFF, 0xFF};
  std::array<std::uint32_t, 3> parts{};
  std::size_t at = 0;
  for (std::size_t part = 0; part < parts.size(); ++part) {
    const std::size_t first = at;
    for (; at < text.size() && text[at] >= '0' && text[at] <= '9'; ++at) {
      parts[part] = parts[part] * 10 + static_cast<std::uint32_t>(text[at] - '0');
      if (parts[part] > kMax[part]) return std::nullopt;
    }
    if (at == first || (at - first > 1 && text[first] == '0')) return std::nullopt;
    if (part < 2) {
      if (at == text.size() || text[at] != '.') return std::nullopt;
      ++at;
    }
  }
  if (at != text.size()) return std::nullopt;
  return image_version(parts[0], parts[1], parts[2]);
}

// Objects of the update, as CiA 302-3 numbers them; all with sub-index 1 (the one program of a node).
inline constexpr std::uint16_t kProgramData = 0x1F50, kProgramControl = 0x1F51, kProgramId = 0x1F56, kFlashStatus = 0x1F57;
// Manufacturer-specific: the version of the program, major << 16 | minor << 8 | patch; 0 when there is none.
inline constexpr std::uint16_t kProgramVersion = 0x2F00;
// 1018h:2 of a node that is in its loader has this bit, so that it is not taken for the running node.
inline constexpr std::uint32_t kLoaderProduct = 0x40000000U;
// Values of 1F51h:1.
enum class ProgramCommand : std::uint8_t { stop = 0, start = 1, reset = 2, clear = 3 };
// Values of 1F57h:1 (bit 0: busy; error numbers from bit 1 on).
enum class FlashStatus : std::uint32_t {
  good = 0,
  busy = 1,
  no_program = 1U << 1,
  unknown_format = 2U << 1,  // no header, or another kind of node or chip
  damaged = 3U << 1,         // CRC or length
  write_failed = 5U << 1,
  failed_starts = 63U << 1,  // a whole program that did not stay alive (unspecified error)
};
constexpr std::string_view flash_status_text(std::uint32_t status) {
  switch (static_cast<FlashStatus>(status)) {
    case FlashStatus::good:
      return "good";
    case FlashStatus::busy:
      return "busy";
    case FlashStatus::no_program:
      return "there is no program";
    case FlashStatus::unknown_format:
      return "what was sent is no program for this node";
    case FlashStatus::damaged:
      return "the program is damaged";
    case FlashStatus::write_failed:
      return "the flash could not be written";
    case FlashStatus::failed_starts:
      return "the program did not stay alive";
  }
  return "unknown";
}

}  // namespace hoist::contract
