// Images of a microcontroller as the linker wrote them.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace hoist::machine {

struct Image {
  std::vector<std::uint8_t> flash;  ///< from the flash's first address; 0xFF for gaps in the file
  std::uint32_t lowest{};           ///< lowest address in flash that the file fills: where its vectors are
  std::map<std::string, std::uint32_t> symbols;
};

/// Reads a 32-bit little-endian ARM ELF file; empty for another format or one larger than `flash_bytes`.
[[nodiscard]] std::optional<Image> load_elf(const std::string& path, std::size_t flash_bytes, std::uint32_t flash_base = 0);

/// The directory with the images, if it exists: $HOIST_FIRMWARE_DIR, or the one this test was built with.
[[nodiscard]] std::optional<std::string> firmware_directory();

}  // namespace hoist::machine
