// Files that we write and others read: whatever is recorded, the records of an MCAP file fit together.
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "db/export/mcap_file.hpp"
#include "tests/fuzz/targets.hpp"

namespace hoist::fuzz {
namespace {

// The records of mcap.dev/spec that the check needs.
enum Opcode : std::uint8_t {
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kChunkIndex = 8,
  kDataEnd = 15
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}
  [[nodiscard]] bool at_end() const { return at_ == bytes_.size(); }
  [[nodiscard]] std::size_t at() const { return at_; }
  std::uint64_t number(std::size_t size) {
    const std::string_view raw = take(size);
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) value |= std::uint64_t{static_cast<std::uint8_t>(raw[i])} << (8 * i);
    return value;
  }
  std::string_view take(std::uint64_t size) {
    must(size <= bytes_.size() - at_, "a length stays within its file");
    const std::string_view part = bytes_.substr(at_, size);
    at_ += size;
    return part;
  }
  std::string_view text() { return take(number(4)); }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
};

std::uint32_t crc_of(std::string_view bytes) {
  return static_cast<std::uint32_t>(::crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

struct Read {
  std::vector<std::string> messages;              // channel, time and data, in the order of the file
  std::map<std::uint64_t, std::uint64_t> chunks;  // place and length of each
};

void read_chunk(Reader content, Read& read) {
  content.take(16);  // first and last time
  const std::uint64_t size = content.number(8);
  const auto crc = static_cast<std::uint32_t>(content.number(4));
  const std::string_view compression = content.text();
  const std::string_view packed = content.take(content.number(8));
  must(content.at_end() && compression == "zstd", "a chunk holds its records and nothing else");
  std::string records(size, '\0');
  must(::ZSTD_decompress(records.data(), size, packed.data(), packed.size()) == size && crc_of(records) == crc, "a chunk can be unpacked");
  for (Reader inside(records); !inside.at_end();) {
    const std::uint64_t opcode = inside.number(1);
    Reader record(inside.take(inside.number(8)));
    if (opcode != kMessage) continue;
    std::string told = std::to_string(record.number(2));
    record.number(4);  // sequence
    told += ' ' + std::to_string(record.number(8)) + ' ';
    record.number(8);  // publish time
    while (!record.at_end()) told += static_cast<char>(record.number(1));
    read.messages.push_back(std::move(told));
  }
}

Read read_mcap(std::string_view bytes) {
  constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
  must(bytes.starts_with(kMagic) && bytes.ends_with(kMagic), "the file says what it is");
  Reader file(bytes.substr(0, bytes.size() - kMagic.size()));
  file.take(kMagic.size());
  Read read;
  std::size_t told_chunks = 0;
  bool footer = false;
  while (!file.at_end()) {
    must(!footer, "nothing follows the footer");
    const std::uint64_t place = file.at(), opcode = file.number(1), length = file.number(8);
    Reader content(file.take(length));
    if (opcode == kChunk) {
      read.chunks[place] = length + 9;
      read_chunk(content, read);
    }
    if (opcode == kDataEnd)
      if (const auto crc = static_cast<std::uint32_t>(content.number(4)); crc != 0)
        must(crc == crc_of(bytes.substr(0, place)), "the data's checksum");
    if (opcode == kChunkIndex) {
      content.take(16);
      const std::uint64_t at = content.number(8), size = content.number(8);
      must(read.chunks.contains(at) && read.chunks[at] == size, "an index names a chunk");
      ++told_chunks;
    }
    footer = opcode == kFooter;
  }
  must(footer && told_chunks == read.chunks.size(), "the summary names every chunk");
  return read;
}

}  // namespace

// The input says what is recorded: channel, time and length of each message, and where the text that is given out is taken away.
void fuzz_mcap_file(Bytes input) {
  Pieces pieces(input);
  db::McapFile file(".");
  std::string out, all;
  file.begin(out, "ros2", "fuzz");
  const std::uint16_t schema = file.add_schema("a.B", "jsonschema", "{}");
  std::vector<std::uint16_t> channels;
  for (int i = 0; i < 3; ++i) channels.push_back(file.add_channel(schema, "/topic" + std::to_string(i), "json"));
  std::vector<std::string> sent;
  bool long_one = false;
  while (!pieces.empty()) {
    const std::uint8_t what = pieces.u8();
    const std::uint16_t channel = channels[what % channels.size()];
    const std::uint64_t time_ns = pieces.number(8);
    const Bytes taken = pieces.take(pieces.u8());
    std::string data(taken.begin(), taken.end());
    // Once a long one, which fills a chunk; more would only cost time.
    if (what == 0x80 && !std::exchange(long_one, true)) data.append(1'200'000, 'x');
    if ((what & 0x40U) != 0)
      file.attachment(out, time_ns, "note", "text/plain", data);
    else {
      file.message(out, channel, time_ns, data);
      sent.push_back(std::to_string(channel) + ' ' + std::to_string(time_ns) + ' ' + data);
    }
    if ((what & 0x20U) != 0) all += std::exchange(out, {});
  }
  while (file.end(out)) all += std::exchange(out, {});
  all += out;
  must(read_mcap(all).messages == sent, "what is read is what was recorded, in this order");
}
std::vector<Input> seeds_mcap_file() {
  Input several;
  for (std::uint8_t i = 0; i < 12; ++i) {
    several.push_back(static_cast<std::uint8_t>(i * 37));
    for (int byte = 0; byte < 8; ++byte) several.push_back(byte == 1 ? i : 0);
    several.push_back(3);
    several.insert(several.end(), {'a', 'b', i});
  }
  return {several, Input{0x01, 9, 0, 0, 0, 0, 0, 0, 0, 0}};
}

}  // namespace hoist::fuzz
