// What the recorder remembers beside the database, in FILE.seal: how many commits of recordings were acknowledged. SQLite's log cannot tell
// that its end is missing: a cut log is the log of an earlier moment. The seal is written after COMMIT has returned, so a file that holds fewer
// commits than its seal has lost some. It is not synced: after a power cut it may be older than the file, never newer.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace hoist::db {

class Seal {
 public:
  struct Content {
    std::string file_id;  // of the database it belongs to: 16 hexadecimal digits
    std::uint64_t commits = 0;
    std::int64_t session = 0;     // the newest that was recorded
    std::uint64_t last_tick = 0;  // its newest durable one; 0 = none
  };
  static std::filesystem::path beside(const std::filesystem::path& file) { return file.string() + ".seal"; }
  // Nothing when there is none, or none that is whole.
  static std::optional<Content> read(const std::filesystem::path& file);

  // A seal that cannot be written misses a loss; recording goes on.
  explicit Seal(const std::filesystem::path& file);
  ~Seal();
  Seal(const Seal&) = delete;
  Seal& operator=(const Seal&) = delete;
  void write(const Content& content) noexcept;

 private:
  int descriptor_;
};

}  // namespace hoist::db
