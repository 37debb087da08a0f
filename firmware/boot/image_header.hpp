// What an application leaves in its flash for its header: the magic, and zeros that `hoist firmware pack` fills in. A board places
//   [[gnu::section(".image_header"), gnu::used]] constinit const ImageHeaderWords kImageHeaderPlace = kEmptyImageHeader;
// with a linker script that puts .image_header at C0h behind the start of the application.
#pragma once
#include <array>
#include <cstdint>

#include "control/contract/firmware_image.hpp"

namespace hoist::firmware {

using ImageHeaderWords = std::array<std::uint32_t, contract::kImageHeaderBytes / 4>;
inline constexpr ImageHeaderWords kEmptyImageHeader{contract::kImageMagic, 0, 0, 0, 0};

}  // namespace hoist::firmware
