// The application's part of its header: node kind, chip and version, as compiled. The linker script puts .image_header at C0h behind the
// start of the application; `hoist firmware pack` adds length and CRC.
//
// The main source of each program places
//   [[gnu::section(".image_header"), gnu::used]] constinit const ImageHeaderWords kImageHeader = image_header(kind, chip);
// so that no program can carry the identity of another.
#pragma once
#include <array>
#include <cstdint>

#include "control/contract/firmware_image.hpp"
#include "firmware/lib/version.hpp"

namespace hoist::firmware {

using ImageHeaderWords = std::array<std::uint32_t, contract::kImageHeaderBytes / 4>;

consteval ImageHeaderWords image_header(contract::ImageKind kind, contract::ImageChip chip) {
  return {contract::kImageMagic, 0, 0, *contract::parse_version(kSoftwareVersion),
          static_cast<std::uint32_t>(kind) | (static_cast<std::uint32_t>(chip) << 8)};
}

}  // namespace hoist::firmware
