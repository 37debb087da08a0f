#include "tests/machine/image.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace hoist::machine {
namespace {

// ELF32, the fields that are needed (System V ABI, chapter 4 and 5).
constexpr std::uint16_t kMachineArm = 40;
constexpr std::uint32_t kLoadable = 1, kSymbolTable = 2;

class Reader {
 public:
  explicit Reader(const std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}
  [[nodiscard]] std::uint32_t word(std::size_t at) const { return get(at, 4); }
  [[nodiscard]] std::uint16_t half(std::size_t at) const { return static_cast<std::uint16_t>(get(at, 2)); }
  [[nodiscard]] std::string text(std::size_t at) const {
    std::string out;
    while (at < bytes_.size() && bytes_[at] != 0) out.push_back(static_cast<char>(bytes_[at++]));
    return out;
  }

 private:
  [[nodiscard]] std::uint32_t get(std::size_t at, std::size_t size) const {
    std::uint32_t value = 0;
    if (at + size <= bytes_.size()) std::memcpy(&value, &bytes_[at], size);
    return value;
  }
  const std::vector<std::uint8_t>& bytes_;
};

}  // namespace

std::optional<Image> load_elf(const std::string& path, std::size_t flash_bytes, std::uint32_t flash_base) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  const std::vector<std::uint8_t> bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const Reader elf(bytes);
  if (bytes.size() < 52 || elf.word(0) != 0x464C457F || bytes[4] != 1 || bytes[5] != 1 || elf.half(18) != kMachineArm) return std::nullopt;
  Image image;
  image.flash.assign(flash_bytes, 0xFF);
  image.lowest = 0xFFFFFFFF;
  const std::uint32_t programs = elf.word(28), sections = elf.word(32);
  for (std::uint32_t i = 0; i < elf.half(44); ++i) {
    const std::size_t at = programs + static_cast<std::size_t>(i) * elf.half(42);
    if (elf.word(at) != kLoadable) continue;
    const std::uint32_t from = elf.word(at + 4), to = elf.word(at + 12), size = elf.word(at + 16);
    if (size == 0) continue;
    const std::uint32_t at_flash = to - flash_base;
    if (at_flash >= flash_bytes || size > flash_bytes - at_flash || from > bytes.size() || size > bytes.size() - from) return std::nullopt;
    std::copy_n(bytes.begin() + from, size, image.flash.begin() + at_flash);
    image.lowest = std::min(image.lowest, to);
  }
  if (image.lowest == 0xFFFFFFFF) return std::nullopt;
  for (std::uint32_t i = 0; i < elf.half(48); ++i) {
    const std::size_t at = sections + static_cast<std::size_t>(i) * elf.half(46);
    if (elf.word(at + 4) != kSymbolTable) continue;
    const std::uint32_t offset = elf.word(at + 16), size = elf.word(at + 20), link = elf.word(at + 24);
    const std::uint32_t names = elf.word(sections + static_cast<std::size_t>(link) * elf.half(46) + 16);
    for (std::uint32_t s = 0; s + 16 <= size; s += 16) {
      const std::string name = elf.text(names + elf.word(offset + s));
      if (!name.empty() && name[0] != '$') image.symbols.emplace(name, elf.word(offset + s + 4));
    }
  }
  return image;
}

std::optional<std::string> firmware_directory() {
  namespace fs = std::filesystem;
  if (const char* given = std::getenv("HOIST_FIRMWARE_DIR"); given != nullptr && fs::is_directory(given)) return std::string(given);
  if (fs::is_directory(HOIST_FIRMWARE_DIR)) return std::string(HOIST_FIRMWARE_DIR);
  return std::nullopt;
}

}  // namespace hoist::machine
