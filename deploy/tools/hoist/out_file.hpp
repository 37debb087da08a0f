// A file that a command writes at the user's wish (--out FILE).
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

#include "db/store/result.hpp"
#include "deploy/tools/hoist/open_file.hpp"

namespace hoist::tool {

/// Written under a name of its own beside FILE (mode 0600); finish() gives it the name FILE. Until then, and after a failure, an earlier FILE is as
/// it was. A device or a pipe is written directly.
class OutFile {
 public:
  OutFile() = default;
  OutFile(const OutFile&) = delete;
  OutFile& operator=(const OutFile&) = delete;
  ~OutFile();
  /// Errors: bad_value (a database of Hoist, or a file that belongs to one), io.
  [[nodiscard]] db::Status open(const std::filesystem::path& file);
  [[nodiscard]] std::FILE* stream() const { return stream_.get(); }
  /// Error: io, also for what an earlier write could not.
  [[nodiscard]] db::Status finish();

 private:
  std::filesystem::path file_;
  std::string part_;  // empty: FILE is written directly
  File stream_;
};

/// All of a file at once. Errors as above.
[[nodiscard]] db::Status write_file(const std::filesystem::path& file, std::string_view content);

}  // namespace hoist::tool
