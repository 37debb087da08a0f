#include "db/store/seal.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cinttypes>
#include <cstdio>
#include <fstream>
#include <span>

#include "control/contract/crc32.hpp"

namespace hoist::db {
namespace {

// One sector at most, always the same length: overwritten in place, it needs no room on a full disk.
constexpr std::size_t kBytes = 128;
using Line = std::array<char, kBytes>;
constexpr int kIdDigits = 16;

std::uint32_t checksum(const char* text, std::size_t size) {
  contract::Crc32 crc;
  crc.add(std::span(reinterpret_cast<const std::uint8_t*>(text), size));
  return crc.value();
}

}  // namespace

std::optional<Seal::Content> Seal::read(const std::filesystem::path& file) {
  Line line{};
  std::ifstream stream(beside(file), std::ios::binary);
  if (!stream.read(line.data(), kBytes - 1)) return std::nullopt;
  std::array<char, kIdDigits + 1> id{};
  Content content;
  std::uint32_t sum = 0;
  int summed = 0;
  if (std::sscanf(line.data(), "hoist-seal %16[0-9a-f] %" SCNu64 " %" SCNd64 " %" SCNu64 "%n %8" SCNx32, id.data(), &content.commits,
                  &content.session, &content.last_tick, &summed, &sum) != 5 ||
      sum != checksum(line.data(), static_cast<std::size_t>(summed)))
    return std::nullopt;
  content.file_id = id.data();
  return content;
}

Seal::Seal(const std::filesystem::path& file) : descriptor_(::open(beside(file).c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600)) {}
Seal::~Seal() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void Seal::write(const Content& content) noexcept {
  Line line{};
  line.fill(' ');
  const int summed = std::snprintf(line.data(), kBytes, "hoist-seal %s %" PRIu64 " %" PRId64 " %" PRIu64, content.file_id.c_str(),
                                   content.commits, content.session, content.last_tick);
  if (descriptor_ < 0 || summed < 0 || static_cast<std::size_t>(summed) + 10 > kBytes) return;
  const auto end = static_cast<std::size_t>(summed);
  std::snprintf(line.data() + end, kBytes - end, " %08" PRIx32, checksum(line.data(), end));
  line[end + 9] = ' ';
  line[kBytes - 1] = '\n';
  [[maybe_unused]] const ssize_t written = ::pwrite(descriptor_, line.data(), kBytes, 0);
}

}  // namespace hoist::db
