// A file without a name, readable by this program only: it is gone when the last user lets go of it, however the program ends. For exports that
// must be whole before their first byte leaves.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "db/store/result.hpp"

namespace hoist::db {

inline constexpr std::uint64_t kSpoolLimit_bytes = std::uint64_t{4} << 30;
/// Space that recording keeps on the disk.
inline constexpr std::uint64_t kSpoolKeepFree_bytes = std::uint64_t{256} << 20;

/// Whether a temporary file of an export may go on growing. Errors: disk_full, bad_value (`size` is above the limit).
Status room_for_export(int file, std::uint64_t size, std::uint64_t limit_bytes = kSpoolLimit_bytes);

class SpoolFile {
 public:
  /// In this folder. Errors: io, disk_full.
  static Result<std::shared_ptr<SpoolFile>> create(const std::filesystem::path& folder, std::uint64_t limit_bytes = kSpoolLimit_bytes);
  ~SpoolFile();
  SpoolFile(const SpoolFile&) = delete;
  SpoolFile& operator=(const SpoolFile&) = delete;

  /// Errors: disk_full (also: recording would be left with less than kSpoolKeepFree_bytes), bad_value (the limit), io.
  Status append(std::string_view bytes);
  /// From any thread, once nothing is appended any more. Shorter at the end. Errors: io.
  [[nodiscard]] Result<std::string> read(std::uint64_t offset, std::size_t length) const;
  [[nodiscard]] std::uint64_t size() const { return size_; }

 private:
  SpoolFile(int file, std::uint64_t limit_bytes) : file_(file), limit_bytes_(limit_bytes) {}
  int file_;
  std::uint64_t limit_bytes_, size_ = 0, judged_ = 0;
};

}  // namespace hoist::db
