#include "deploy/tools/hoist/firmware/image_file.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "control/contract/can_dictionary.hpp"

namespace hoist::tool {

namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { (void)std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

}  // namespace

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

Refusal write_file(const std::string& path, std::span<const std::uint8_t> content) {
  const std::string beside = path + ".part";
  {
    const File file(std::fopen(beside.c_str(), "wb"));
    if (!file) return "cannot write " + path;
    if (std::fwrite(content.data(), 1, content.size(), file.get()) != content.size() || std::fflush(file.get()) != 0) {
      (void)std::remove(beside.c_str());
      return "cannot write " + path;
    }
  }
  std::error_code error;
  std::filesystem::rename(beside, path, error);
  return error ? "cannot write " + path + ": " + error.message() : Refusal{};
}

Refusal pack_image(std::vector<std::uint8_t>& image, contract::ImageKind kind, const contract::ImageChipInfo& chip, std::uint32_t version) {
  if (image.size() < contract::kImageMin) return Refusal(contract::image_error_text(contract::ImageError::too_short));
  const auto place = std::span(image).subspan(contract::kImageHeaderAt, contract::kImageHeaderBytes);
  const bool marked = contract::image_word(image, contract::kImageHeaderAt) == contract::kImageMagic;
  const auto all = [&](std::uint8_t value) {
    return std::all_of(place.begin(), place.end(), [value](std::uint8_t b) { return b == value; });
  };
  if (!marked && !(chip.chip == contract::ImageChip::simulated && (all(0) || all(0xFF))))
    return "at C0h is no place for a header: the program was not linked for a loader";
  while (image.size() % 4 != 0) image.push_back(0xFF);
  contract::write_le(&image[contract::kImageHeaderAt], 4, contract::kImageMagic);
  contract::write_le(&image[contract::kImageHeaderAt + 4], 4, static_cast<std::uint32_t>(image.size()));
  contract::write_le(&image[contract::kImageHeaderAt + 12], 4, version);
  image[contract::kImageHeaderAt + 16] = static_cast<std::uint8_t>(kind);
  image[contract::kImageHeaderAt + 17] = static_cast<std::uint8_t>(chip.chip);
  contract::write_le(&image[contract::kImageHeaderAt + 18], 2, 0);
  contract::write_le(&image[contract::kImageCrcAt], 4, contract::image_crc(image));
  return Refusal(contract::image_error_text(contract::check_image_file(image)));
}

std::string version_text(std::uint32_t version) {
  return std::to_string(version >> 16) + '.' + std::to_string((version >> 8) & 0xFFU) + '.' + std::to_string(version & 0xFFU);
}

}  // namespace hoist::tool
