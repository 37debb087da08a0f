#include "db/store/restore_remains.hpp"

#include <string>
#include <system_error>

namespace hoist::db {

namespace fs = std::filesystem;

void tidy_after_restore(const fs::path& file) {
  std::error_code error;
  fs::remove(file.string() + std::string(kPrepared), error);
  // Two names of one file would be two logs of one file.
  if (const auto names = fs::hard_link_count(file, error); error || names < 2) return;
  const std::string prefix = file.filename().string() + std::string(kReplacedInfix);
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code other;
    const fs::path name = entry->path();
    if (!name.filename().string().starts_with(prefix) || !fs::equivalent(name, file, other)) continue;
    for (const char* suffix : kKeptWith)
      if (!fs::exists(file.string() + suffix, other)) fs::rename(name.string() + suffix, file.string() + suffix, other);
    fs::remove(name, other);
    return;
  }
}

}  // namespace hoist::db
