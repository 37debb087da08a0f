// Programs of nodes as files: read, packed, written.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "control/contract/firmware_image.hpp"

namespace hoist::tool {

/// The error as a sentence that names the field or the file; empty on success.
using Refusal = std::string;

/// Reads at most contract::kImageMax bytes.
[[nodiscard]] Refusal read_file(const std::string& path, std::vector<std::uint8_t>& content);

/// Fills in length and CRC of a linked program, and pads it to whole words. Node kind, chip and version are the program's own; `simulated`
/// makes it a program for the simulated node of its kind, which no chip accepts.
[[nodiscard]] Refusal pack_image(std::vector<std::uint8_t>& image, bool simulated);

[[nodiscard]] std::string version_text(std::uint32_t version);

}  // namespace hoist::tool
