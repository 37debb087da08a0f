// A ZIP archive written in one pass (APPNOTE 6.3): deflate, sizes behind each file, zip64 where a file or the archive may pass 4 GB.
// Memory: zlib's state, and about 100 B per file that was written.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

struct z_stream_s;

namespace hoist::db {

class ZipFile {
 public:
  ZipFile();
  ~ZipFile();
  ZipFile(const ZipFile&) = delete;
  ZipFile& operator=(const ZipFile&) = delete;

  /// `large`: the file may pass 4 GB. The name is UTF-8, its folders separated by '/'.
  void begin_file(std::string& out, std::string_view name, std::int64_t utc_ns, bool large);
  void write(std::string& out, std::string_view bytes);
  void end_file(std::string& out);
  /// The directory. Nothing may follow.
  void end(std::string& out);

 private:
  struct Entry {
    std::string name;
    std::uint64_t offset = 0, packed = 0, size = 0;
    std::uint32_t crc = 0, dos_time = 0;
    bool large = false;
  };
  void put(std::string& out, std::string_view bytes);
  void deflate_into(std::string& out, std::string_view bytes, int flush);

  std::unique_ptr<z_stream_s> stream_;
  std::vector<Entry> entries_;
  std::uint64_t position_ = 0;
};

}  // namespace hoist::db
