// Whose file it is, found out without changing it.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace hoist::db {

/// SQLite's application_id of our files: "Hois" in ASCII.
inline constexpr std::int64_t kApplicationId = 0x486F6973;

enum class FileIdentity : std::uint8_t {
  fresh,    // absent or without content: may be begun
  ours,     // as far as its first bytes tell
  damaged,  // ours once, or without content: zeros, cut in its header, or empty beside a full log
  foreign,  // of another program: it stays as it is
};
struct Identified {
  FileIdentity identity = FileIdentity::ours;
  std::string why;  // of damaged and foreign
};
/// What the header of a database says; nothing when the file is none, or cannot be read.
[[nodiscard]] std::optional<std::int64_t> application_id(const std::filesystem::path& file);
[[nodiscard]] Identified identify(const std::filesystem::path& file);

}  // namespace hoist::db
