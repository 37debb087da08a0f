// The records of an MCAP file (mcap.dev/spec), appended to a text that is taken away piece by piece. Messages gather in chunks of about 1 MB,
// each compressed with zstd and followed by its indexes; the summary at the end finds them all. Memory: one chunk, and about 100 B per chunk
// that was written.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hoist::db {

class McapFile {
 public:
  using Texts = std::vector<std::pair<std::string, std::string>>;
  /// Appends the head to `out`. Every later call appends to the text it is given, in the order of the file.
  void begin(std::string& out, std::string_view profile, std::string_view library);
  std::uint16_t add_schema(std::string_view name, std::string_view encoding, std::string_view data);
  std::uint16_t add_channel(std::uint16_t schema, std::string_view topic, std::string_view encoding);
  void attachment(std::string& out, std::uint64_t time_ns, std::string_view name, std::string_view media_type, std::string_view data);
  void metadata(std::string& out, std::string_view name, const Texts& texts);
  /// Into the chunk under way; the chunk goes to `out` once it is full.
  void message(std::string& out, std::uint16_t channel, std::uint64_t time_ns, std::string_view data);
  /// The last chunk, the summary and the end.
  void end(std::string& out);

 private:
  using Entries = std::vector<std::pair<std::uint64_t, std::uint64_t>>;  // time and offset in the chunk
  void put(std::string& out, std::string_view bytes);
  void record(std::string& out, std::uint8_t opcode, std::string_view content);
  void flush(std::string& out);
  void group(std::string& out, std::string& offsets, std::uint8_t opcode, const std::vector<std::string>& contents);

  std::uint64_t position_ = 0;
  std::uint32_t crc_ = 0;                             // of everything so far
  std::vector<std::string> schemas_, channels_;       // contents of their records
  std::size_t schemas_told_ = 0, channels_told_ = 0;  // those that a chunk holds already
  std::string chunk_;
  std::uint64_t chunk_from_ns_ = 0, chunk_to_ns_ = 0, from_ns_ = 0, to_ns_ = 0;
  std::map<std::uint16_t, Entries> index_;  // of the chunk
  std::map<std::uint16_t, std::uint64_t> counts_;
  std::map<std::uint16_t, std::uint32_t> sequences_;
  std::vector<std::string> chunk_indexes_, attachment_indexes_, metadata_indexes_;
};

}  // namespace hoist::db
