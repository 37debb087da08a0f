// The records of an MCAP file (mcap.dev/spec), appended to a text that is taken away piece by piece. Messages gather in chunks of about 1 MB,
// each compressed with zstd and followed by its indexes; the summary at the end finds them all. Memory: one chunk; the rows of the summary about the
// chunks wait in a file without a name, so that a long session takes no more memory than a short one.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "db/export/spool_file.hpp"

namespace hoist::db {

class McapFile {
 public:
  using Texts = std::vector<std::pair<std::string, std::string>>;
  /// `folder`: for the rows that wait. Where they cannot be written they wait in memory, about 250 B for each chunk.
  explicit McapFile(std::filesystem::path folder) : folder_(std::move(folder)) {}
  /// Appends the head to `out`. Every later call appends to the text it is given, in the order of the file.
  void begin(std::string& out, std::string_view profile, std::string_view library);
  std::uint16_t add_schema(std::string_view name, std::string_view encoding, std::string_view data);
  std::uint16_t add_channel(std::uint16_t schema, std::string_view topic, std::string_view encoding);
  void attachment(std::string& out, std::uint64_t time_ns, std::string_view name, std::string_view media_type, std::string_view data);
  void metadata(std::string& out, std::string_view name, const Texts& texts);
  /// Into the chunk under way; the chunk goes to `out` once it is full.
  void message(std::string& out, std::uint16_t channel, std::uint64_t time_ns, std::string_view data);
  /// The last chunk, the summary and the end, piece by piece; false with the last one.
  bool end(std::string& out);

 private:
  using Entries = std::vector<std::pair<std::uint64_t, std::uint64_t>>;  // time and offset in the chunk
  void put(std::string& out, std::string_view bytes);
  void record(std::string& out, std::uint8_t opcode, std::string_view content);
  void flush(std::string& out);
  void group(std::string& out, std::uint8_t opcode, const std::vector<std::string>& contents);
  void add_offset(std::uint8_t opcode, std::uint64_t begin);
  void keep_chunk_index(std::string_view content);
  void begin_summary(std::string& out);
  bool chunk_indexes(std::string& out);
  void end_summary(std::string& out);

  std::uint64_t position_ = 0;
  std::uint32_t crc_ = 0;                             // of everything so far
  std::vector<std::string> schemas_, channels_;       // contents of their records
  std::size_t schemas_told_ = 0, channels_told_ = 0;  // those that a chunk holds already
  std::string chunk_;
  std::uint64_t chunk_from_ns_ = 0, chunk_to_ns_ = 0, from_ns_ = 0, to_ns_ = 0;
  std::map<std::uint16_t, Entries> index_;  // of the chunk
  std::map<std::uint16_t, std::uint64_t> counts_;
  std::map<std::uint16_t, std::uint32_t> sequences_;
  std::vector<std::string> attachment_indexes_, metadata_indexes_;
  // Records of the summary about chunks: in the file, then in the text.
  std::filesystem::path folder_;
  std::shared_ptr<SpoolFile> spool_;
  bool spool_over_ = false;               // it takes no more
  std::uint64_t spooled_ = 0, told_ = 0;  // bytes in the file, and those of them that are in the summary
  std::string kept_;
  std::uint32_t chunks_ = 0;
  enum class Ending : std::uint8_t { data, chunk_indexes, over };
  Ending ending_ = Ending::data;
  std::uint64_t summary_begin_ = 0, indexes_begin_ = 0;
  std::string offsets_;
};

}  // namespace hoist::db
