#include "db/export/mcap_file.hpp"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

constexpr std::size_t kChunk_bytes = 1'000'000;
// Rows of the summary that are kept in memory before they go to the file.
constexpr std::size_t kKept_bytes = 32 * 1024;
// The decoder's memory stays small, and an hour is written in seconds.
constexpr int kZstdLevel = 3;
constexpr std::string_view kMcapMagic{"\x89MCAP0\r\n", 8};
constexpr std::string_view kCompression = "zstd";
enum Opcode : std::uint8_t {
  kHeader = 1,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunk,
  kMessageIndex,
  kChunkIndex,
  kAttachment,
  kAttachmentIndex,
  kStatistics,
  kMetadata,
  kMetadataIndex,
  kSummaryOffset,
  kDataEnd
};

static_assert(std::endian::native == std::endian::little);
template <typename Value>
void number(std::string& out, Value value) {
  std::array<char, sizeof value> bytes;
  std::memcpy(bytes.data(), &value, sizeof value);
  out.append(bytes.data(), bytes.size());
}
void text(std::string& out, std::string_view value) {
  number(out, static_cast<std::uint32_t>(value.size()));
  out += value;
}
// With a length of 64 bits in front, as records have it.
void text64(std::string& out, std::string_view value) {
  number(out, static_cast<std::uint64_t>(value.size()));
  out += value;
}
std::uint32_t crc_of(std::uint32_t crc, std::string_view bytes) {
  return static_cast<std::uint32_t>(crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}
// A list of pairs, with its length in bytes in front.
template <typename Pairs>
void pairs(std::string& out, const Pairs& rows) {
  std::string content;
  for (const auto& [key, value] : rows) {
    number(content, key);
    number(content, value);
  }
  text(out, content);
}

}  // namespace

void McapFile::put(std::string& out, std::string_view bytes) {
  out += bytes;
  position_ += bytes.size();
  crc_ = crc_of(crc_, bytes);
}

void McapFile::record(std::string& out, std::uint8_t opcode, std::string_view content) {
  std::string head(1, static_cast<char>(opcode));
  number(head, static_cast<std::uint64_t>(content.size()));
  put(out, head);
  put(out, content);
}

void McapFile::begin(std::string& out, std::string_view profile, std::string_view library) {
  put(out, kMcapMagic);
  std::string content;
  text(content, profile);
  text(content, library);
  record(out, kHeader, content);
}

std::uint16_t McapFile::add_schema(std::string_view name, std::string_view encoding, std::string_view data) {
  const auto id = static_cast<std::uint16_t>(schemas_.size() + 1);
  std::string content;
  number(content, id);
  text(content, name);
  text(content, encoding);
  text(content, data);
  schemas_.push_back(std::move(content));
  return id;
}

std::uint16_t McapFile::add_channel(std::uint16_t schema, std::string_view topic, std::string_view encoding) {
  const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
  std::string content;
  number(content, id);
  number(content, schema);
  text(content, topic);
  text(content, encoding);
  text(content, "");  // no metadata
  channels_.push_back(std::move(content));
  return id;
}

void McapFile::attachment(std::string& out, std::uint64_t time_ns, std::string_view name, std::string_view media_type,
                          std::string_view data) {
  std::string content, index;
  number(content, time_ns);
  number(content, time_ns);
  text(content, name);
  text(content, media_type);
  number(content, static_cast<std::uint64_t>(data.size()));
  content += data;
  number(content, crc_of(0, content));
  number(index, position_);
  record(out, kAttachment, content);
  number(index, static_cast<std::uint64_t>(9 + content.size()));
  number(index, time_ns);
  number(index, time_ns);
  number(index, static_cast<std::uint64_t>(data.size()));
  text(index, name);
  text(index, media_type);
  attachment_indexes_.push_back(std::move(index));
}

void McapFile::metadata(std::string& out, std::string_view name, const Texts& texts) {
  std::string content, rows, index;
  text(content, name);
  for (const auto& [key, value] : texts) {
    text(rows, key);
    text(rows, value);
  }
  text(content, rows);
  number(index, position_);
  record(out, kMetadata, content);
  number(index, static_cast<std::uint64_t>(9 + content.size()));
  text(index, name);
  metadata_indexes_.push_back(std::move(index));
}

void McapFile::message(std::string& out, std::uint16_t channel, std::uint64_t time_ns, std::string_view data) {
  const auto append = [this](std::uint8_t opcode, std::string_view content) {
    chunk_ += static_cast<char>(opcode);
    number(chunk_, static_cast<std::uint64_t>(content.size()));
    chunk_ += content;
  };
  // Schemas and channels stand in the first chunk, before their first message.
  for (; schemas_told_ < schemas_.size(); ++schemas_told_) append(kSchema, schemas_[schemas_told_]);
  for (; channels_told_ < channels_.size(); ++channels_told_) append(kChannel, channels_[channels_told_]);
  if (index_.empty()) chunk_from_ns_ = chunk_to_ns_ = time_ns;
  chunk_from_ns_ = std::min(chunk_from_ns_, time_ns);
  chunk_to_ns_ = std::max(chunk_to_ns_, time_ns);
  index_[channel].emplace_back(time_ns, chunk_.size());
  ++counts_[channel];
  chunk_ += static_cast<char>(kMessage);
  number(chunk_, static_cast<std::uint64_t>(22 + data.size()));
  number(chunk_, channel);
  number(chunk_, sequences_[channel]++);
  number(chunk_, time_ns);
  number(chunk_, time_ns);
  chunk_ += data;
  if (chunk_.size() >= kChunk_bytes) flush(out);
}

void McapFile::flush(std::string& out) {
  if (index_.empty()) return;
  std::string packed(ZSTD_compressBound(chunk_.size()), '\0');
  const std::size_t size = ZSTD_compress(packed.data(), packed.size(), chunk_.data(), chunk_.size(), kZstdLevel);
  if (ZSTD_isError(size) != 0) throw SqlFailure{Error{ErrorKind::internal, "zstd failed", {}}};
  packed.resize(size);

  const bool first = chunks_ == 0;
  from_ns_ = first ? chunk_from_ns_ : std::min(from_ns_, chunk_from_ns_);
  to_ns_ = first ? chunk_to_ns_ : std::max(to_ns_, chunk_to_ns_);
  std::string content, index;
  number(content, chunk_from_ns_);
  number(content, chunk_to_ns_);
  index = content;
  number(content, static_cast<std::uint64_t>(chunk_.size()));
  number(content, crc_of(0, chunk_));
  text(content, kCompression);
  number(content, static_cast<std::uint64_t>(packed.size()));
  content += packed;
  number(index, position_);
  number(index, static_cast<std::uint64_t>(9 + content.size()));
  record(out, kChunk, content);
  std::map<std::uint16_t, std::uint64_t> places;
  const std::uint64_t indexes_begin = position_;
  for (const auto& [channel, entries] : index_) {
    places[channel] = position_;
    std::string rows;
    number(rows, channel);
    pairs(rows, entries);
    record(out, kMessageIndex, rows);
  }
  pairs(index, places);
  number(index, position_ - indexes_begin);
  text(index, kCompression);
  number(index, static_cast<std::uint64_t>(packed.size()));
  number(index, static_cast<std::uint64_t>(chunk_.size()));
  keep_chunk_index(index);
  chunk_.clear();
  index_.clear();
}

// A disk that takes nothing is no reason to fail: the rows stay in memory then.
void McapFile::keep_chunk_index(std::string_view content) {
  ++chunks_;
  kept_ += static_cast<char>(kChunkIndex);
  text64(kept_, content);
  if (kept_.size() < kKept_bytes || spool_over_) return;
  std::error_code none;
  for (const std::filesystem::path& folder : {folder_, std::filesystem::temp_directory_path(none)})
    if (!spool_)
      if (auto made = SpoolFile::create(folder)) spool_ = std::move(*made);
  spool_over_ = !spool_ || !spool_->append(kept_);
  if (spool_over_) return;
  spooled_ += kept_.size();
  kept_.clear();
}

void McapFile::add_offset(std::uint8_t opcode, std::uint64_t begin) {
  if (position_ == begin) return;
  std::string offset(1, static_cast<char>(opcode));
  number(offset, begin);
  number(offset, position_ - begin);
  offsets_ += static_cast<char>(kSummaryOffset);
  text64(offsets_, offset);
}

void McapFile::group(std::string& out, std::uint8_t opcode, const std::vector<std::string>& contents) {
  const std::uint64_t begin = position_;
  for (const std::string& content : contents) record(out, opcode, content);
  add_offset(opcode, begin);
}

bool McapFile::end(std::string& out) {
  switch (ending_) {
    case Ending::data:
      begin_summary(out);
      ending_ = Ending::chunk_indexes;
      return true;
    case Ending::chunk_indexes:
      if (chunk_indexes(out)) return true;
      end_summary(out);
      ending_ = Ending::over;
      break;
    case Ending::over:
      break;
  }
  return false;
}

void McapFile::begin_summary(std::string& out) {
  flush(out);
  std::string content;
  number(content, crc_);
  record(out, kDataEnd, content);

  summary_begin_ = position_;
  crc_ = 0;
  std::string statistics;
  std::uint64_t messages = 0;
  for (const auto& [channel, count] : counts_) messages += count;
  number(statistics, messages);
  number(statistics, static_cast<std::uint16_t>(schemas_.size()));
  for (const std::size_t count : {channels_.size(), attachment_indexes_.size(), metadata_indexes_.size(), std::size_t{chunks_}})
    number(statistics, static_cast<std::uint32_t>(count));
  number(statistics, from_ns_);
  number(statistics, to_ns_);
  pairs(statistics, counts_);
  group(out, kSchema, schemas_);
  group(out, kChannel, channels_);
  group(out, kStatistics, {statistics});
  indexes_begin_ = position_;
}

bool McapFile::chunk_indexes(std::string& out) {
  if (told_ < spooled_) {
    const Result<std::string> some = spool_->read(told_, std::min<std::uint64_t>(kKept_bytes, spooled_ - told_));
    if (!some) throw SqlFailure{some.error()};
    if (some->empty()) throw SqlFailure{Error{ErrorKind::io, "the export's summary could not be read back", {}}};
    told_ += some->size();
    put(out, *some);
    return true;
  }
  put(out, kept_);
  add_offset(kChunkIndex, indexes_begin_);
  return false;
}

void McapFile::end_summary(std::string& out) {
  group(out, kAttachmentIndex, attachment_indexes_);
  group(out, kMetadataIndex, metadata_indexes_);
  const std::uint64_t offsets_begin = position_;
  put(out, offsets_);
  // The checksum of the summary covers the footer up to itself.
  std::string footer(1, static_cast<char>(kFooter));
  number(footer, std::uint64_t{20});
  number(footer, summary_begin_);
  number(footer, offsets_begin);
  put(out, footer);
  std::string last;
  number(last, crc_);
  put(out, last);
  put(out, kMcapMagic);
}

}  // namespace hoist::db
