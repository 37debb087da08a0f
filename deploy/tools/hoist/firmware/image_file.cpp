#include "deploy/tools/hoist/firmware/image_file.hpp"

#include <cstdio>
#include <memory>

#include "control/contract/can_dictionary.hpp"
#include "deploy/tools/hoist/open_file.hpp"

namespace hoist::tool {

Refusal read_file(const std::string& path, std::vector<std::uint8_t>& content) {
  const File file(std::fopen(path.c_str(), "rb"));
  if (!file) return "cannot read " + path;
  content.resize(contract::kImageMax + 1);
  content.resize(std::fread(content.data(), 1, content.size(), file.get()));
  if (std::ferror(file.get()) != 0) return "cannot read " + path;
  if (content.size() > contract::kImageMax)
    return path + " is longer than any chip's flash (" + std::to_string(contract::kImageMax) + " bytes)";
  return {};
}

Refusal pack_image(std::vector<std::uint8_t>& image, bool simulated) {
  if (image.size() < contract::kImageMin) return Refusal(contract::image_error_text(contract::ImageError::too_short));
  const contract::ImageHeader header = contract::read_image_header(image);
  if (header.magic != contract::kImageMagic) return "at C0h is no header: the program was not linked for a loader";
  if (contract::find_image_kind(header.kind) == nullptr || contract::find_image_chip(header.chip) == nullptr)
    return "the header at C0h does not say for which kind of node and which chip the program was compiled";
  if (simulated) image[contract::kImageHeaderAt + 17] = static_cast<std::uint8_t>(contract::ImageChip::simulated);
  while (image.size() % 4 != 0) image.push_back(0xFF);
  contract::write_le(&image[contract::kImageHeaderAt + 4], 4, static_cast<std::uint32_t>(image.size()));
  contract::write_le(&image[contract::kImageCrcAt], 4, contract::image_crc(image));
  return Refusal(contract::image_error_text(contract::check_image_file(image)));
}

std::string version_text(std::uint32_t version) {
  return std::to_string(version >> 16) + '.' + std::to_string((version >> 8) & 0xFFU) + '.' + std::to_string(version & 0xFFU);
}

}  // namespace hoist::tool
