#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <random>

#include "db/codec/bus_chunk.hpp"
#include "db/codec/column_chunk.hpp"

namespace hoist::db {
namespace {

using contract::BusRecord;
using Table = std::vector<std::vector<std::int64_t>>;

// Columns of every kind: constant, steady step, noise of every width, steps, the ends of the range.
Table random_table(std::mt19937_64& random, std::size_t columns, std::size_t samples) {
  Table table(columns);
  for (auto& column : table) {
    const auto temper = random() % 6;
    const unsigned width = static_cast<unsigned>(random() % 63) + 1;
    const auto first = static_cast<std::int64_t>(random()) >> (random() % 64);
    const auto step = static_cast<std::int64_t>(random() % 1000) - 500;
    for (std::size_t i = 0; i < samples; ++i) {
      switch (temper) {
        case 0:
          column.push_back(first);
          break;
        case 1:
          column.push_back(wrapping_sum(first / 4, step * static_cast<std::int64_t>(i)));
          break;
        case 2:
          column.push_back(static_cast<std::int64_t>(random()) >> (64 - width));
          break;
        case 3:
          column.push_back(random() % 50 == 0 ? step : 0);
          break;
        case 4:
          column.push_back(random() % 2 == 0 ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max());
          break;
        default:
          column.push_back((column.empty() ? 0 : column.back()) + static_cast<std::int64_t>(random() % 7) - 3);
          break;
      }
    }
  }
  return table;
}

std::vector<std::size_t> all_of(const Table& table) {
  std::vector<std::size_t> which(table.size());
  for (std::size_t i = 0; i < which.size(); ++i) which[i] = i;
  return which;
}

// The check value of CRC-32/ISO-HDLC, and a plain bitwise reader for every length around a word.
TEST(Crc, IsTheStandardOneForAnyLength) {
  constexpr std::array<std::uint8_t, 9> kCheck{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  static_assert(crc32(kCheck) == 0xCBF43926U);
  Bytes bytes;
  for (std::size_t n = 0; n < 40; ++n) {
    std::uint32_t expected = 0xFFFFFFFFU;
    for (const std::uint8_t b : bytes) {
      expected ^= b;
      for (int bit = 0; bit < 8; ++bit) expected = (expected >> 1) ^ ((expected & 1U) != 0 ? 0xEDB88320U : 0U);
    }
    EXPECT_EQ(crc32(bytes), expected ^ 0xFFFFFFFFU) << n;
    bytes.push_back(static_cast<std::uint8_t>(37 * n + 201));
  }
}

TEST(Codec, every_integer_comes_back_in_both_layouts) {
  std::mt19937_64 random(1);
  ChunkEncoder encoder;
  ChunkDecoder decoder;
  for (int round = 0; round < 200; ++round) {
    const std::size_t samples = round == 0 ? 1 : round == 1 ? 2 : round == 2 ? kMaxChunkSamples : random() % 1300 + 1;
    const Table table = random_table(random, random() % 9 + 1, samples);
    for (const ChunkLayout layout : {ChunkLayout::one_frame, ChunkLayout::frame_per_column}) {
      EncodedChunk chunk;
      ASSERT_EQ(encoder.encode(table, samples, layout, chunk), CodecError::none);
      ChunkDirectory directory;
      ASSERT_EQ(parse_directory(chunk.directory, directory), CodecError::none);
      ASSERT_EQ(directory.samples, samples);
      Table back;
      ASSERT_EQ(decoder.columns(directory, all_of(table), chunk.body, back), CodecError::none);
      ASSERT_EQ(back, table);
      // One column alone gives the same.
      const std::size_t one = random() % table.size();
      const ChunkColumn& column = directory.columns[one];
      const ByteView payload =
          layout == ChunkLayout::one_frame ? ByteView(chunk.body) : ByteView(chunk.body).subspan(column.offset, column.bytes);
      std::vector<std::int64_t> alone;
      ASSERT_EQ(decoder.column(directory, one, payload, alone), CodecError::none);
      ASSERT_EQ(alone, table[one]);
    }
  }
}

TEST(Codec, the_directory_knows_the_extremes_of_every_block) {
  std::mt19937_64 random(2);
  ChunkEncoder encoder;
  for (int round = 0; round < 50; ++round) {
    const std::size_t samples = random() % 3000 + 1;
    const Table table = random_table(random, 8, samples);
    EncodedChunk chunk;
    ASSERT_EQ(encoder.encode(table, samples, ChunkLayout::frame_per_column, chunk), CodecError::none);
    ChunkDirectory directory;
    ASSERT_EQ(parse_directory(chunk.directory, directory), CodecError::none);
    for (std::size_t c = 0; c < table.size(); ++c) {
      const auto [low, high] = std::ranges::minmax(table[c]);
      EXPECT_EQ(directory.columns[c].range.min, low);
      EXPECT_EQ(directory.columns[c].range.max, high);
      ASSERT_EQ(directory.blocks.size(), table.size() * directory.block_count());
      for (std::size_t b = 0; b < directory.block_count(); ++b) {
        const auto begin = table[c].begin() + static_cast<std::ptrdiff_t>(b * kBlockSamples);
        const auto [block_low, block_high] = std::minmax_element(begin, begin + static_cast<std::ptrdiff_t>(directory.block_samples(b)));
        EXPECT_EQ(directory.block(c, b).min, *block_low);
        EXPECT_EQ(directory.block(c, b).max, *block_high);
      }
    }
  }
}

TEST(Codec, constant_and_steady_columns_take_no_body) {
  Table table{std::vector<std::int64_t>(3000, 42), {}};
  for (std::int64_t i = 0; i < 3000; ++i) table[1].push_back(1000 + i);
  ChunkEncoder encoder;
  EncodedChunk chunk;
  ASSERT_EQ(encoder.encode(table, 3000, ChunkLayout::frame_per_column, chunk), CodecError::none);
  EXPECT_TRUE(chunk.body.empty());
  EXPECT_LT(chunk.directory.size(), 30U);
}

TEST(Codec, any_damaged_byte_is_noticed_and_none_crashes) {
  std::mt19937_64 random(3);
  ChunkEncoder encoder;
  ChunkDecoder decoder;
  Table table = random_table(random, 6, 700);
  table.push_back({});
  for (int i = 0; i < 700; ++i) table.back().push_back(static_cast<std::int64_t>(random() % 1000));
  for (const ChunkLayout layout : {ChunkLayout::one_frame, ChunkLayout::frame_per_column}) {
    EncodedChunk chunk;
    ASSERT_EQ(encoder.encode(table, 700, layout, chunk), CodecError::none);
    ASSERT_FALSE(chunk.body.empty());
    ChunkDirectory directory;
    Table back;
    for (std::size_t i = 0; i < chunk.directory.size(); ++i) {
      Bytes damaged = chunk.directory;
      damaged[i] ^= static_cast<std::uint8_t>(1U << (random() % 8));
      EXPECT_EQ(parse_directory(damaged, directory), CodecError::directory_damaged) << "byte " << i;
      damaged.resize(i);
      EXPECT_EQ(parse_directory(damaged, directory), CodecError::directory_damaged) << "cut at " << i;
    }
    for (int round = 0; round < 2000; ++round) {
      ASSERT_EQ(parse_directory(chunk.directory, directory), CodecError::none);
      Bytes damaged = chunk.body;
      const std::size_t at = random() % damaged.size();
      damaged[at] ^= static_cast<std::uint8_t>(1U << (random() % 8));
      const CodecError error = decoder.columns(directory, all_of(table), damaged, back);
      // zstd's frame header has bits that change nothing (its unused bit, the window of a single segment): then the values must be unchanged.
      if (error == CodecError::none) {
        EXPECT_EQ(back, table) << "byte " << at;
      }
      damaged.resize(at);
      EXPECT_EQ(decoder.columns(directory, all_of(table), damaged, back), CodecError::body_damaged);
    }
  }
}

TEST(Codec, random_bytes_are_refused_even_with_a_right_checksum) {
  std::mt19937_64 random(4);
  ChunkDirectory directory;
  std::vector<BusRecord> frames;
  int refused = 0;
  for (int round = 0; round < 20000; ++round) {
    Bytes blob{0x48, 1, static_cast<std::uint8_t>(random() % 3)};
    const std::size_t length = random() % 60;
    for (std::size_t i = 0; i < length; ++i) blob.push_back(static_cast<std::uint8_t>(random() >> (random() % 56)));
    put_u32(blob, crc32(blob));
    if (parse_directory(blob, directory) == CodecError::none) {
      // What passes is at least consistent with itself.
      EXPECT_LE(directory.columns.size(), kMaxChunkColumns);
      EXPECT_LE(directory.samples, kMaxChunkSamples);
    } else {
      ++refused;
    }
    blob[0] = 0x43;
    blob.resize(blob.size() - 4);
    put_u32(blob, crc32(blob));
    frames.clear();
    EXPECT_NE(decode_bus(blob, frames), CodecError::none);
  }
  EXPECT_GT(refused, 19000);
}

TEST(Codec, too_much_or_nothing_is_refused) {
  ChunkEncoder encoder;
  EncodedChunk chunk;
  EXPECT_NE(encoder.encode({}, 1, ChunkLayout::one_frame, chunk), CodecError::none);
  const Table table(1, std::vector<std::int64_t>(kMaxChunkSamples + 1));
  EXPECT_NE(encoder.encode(table, 0, ChunkLayout::one_frame, chunk), CodecError::none);
  EXPECT_NE(encoder.encode(table, kMaxChunkSamples + 1, ChunkLayout::one_frame, chunk), CodecError::none);
  const Table short_one(1, std::vector<std::int64_t>(5));
  EXPECT_NE(encoder.encode(short_one, 6, ChunkLayout::one_frame, chunk), CodecError::none);
}

TEST(Codec, varints_refuse_overlong_numbers) {
  Bytes most;
  put_varint(most, std::numeric_limits<std::uint64_t>::max());
  ByteReader in(most);
  EXPECT_EQ(in.varint(), std::numeric_limits<std::uint64_t>::max());
  EXPECT_TRUE(in.ok());
  most.back() = 2;
  ByteReader over(most);
  EXPECT_EQ(over.varint(), 0U);
  EXPECT_FALSE(over.ok());
  for (const std::int64_t value :
       {std::int64_t{0}, std::int64_t{-1}, std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()})
    EXPECT_EQ(unzigzag(zigzag(value)), value);
}

std::vector<BusRecord> random_frames(std::mt19937_64& random, std::size_t count, std::size_t streams) {
  std::vector<BusRecord> frames;
  std::uint64_t time = random() % 1000000;
  for (std::size_t i = 0; i < count; ++i) {
    BusRecord f;
    time += random() % 300000;
    f.time_ns = time;
    f.id = static_cast<std::uint32_t>(random() % streams) * 0x11U;
    f.dlc = static_cast<std::uint8_t>(f.id % 9);
    f.flags = static_cast<std::uint8_t>(random() % 50 == 0 ? 4 : 0);
    f.sent = static_cast<std::uint8_t>(f.id % 2);
    f.data = random() % 3 == 0 ? random() : i;
    frames.push_back(f);
  }
  return frames;
}

bool same(const BusRecord& a, const BusRecord& b) {
  return a.time_ns == b.time_ns && a.id == b.id && a.dlc == b.dlc && a.flags == b.flags && a.sent == b.sent && a.data == b.data;
}

TEST(BusCodec, frames_come_back_in_their_order) {
  std::mt19937_64 random(5);
  for (const std::size_t count : {std::size_t{1}, std::size_t{2}, std::size_t{999}, std::size_t{20000}}) {
    for (const std::size_t streams : {std::size_t{1}, std::size_t{13}, std::size_t{700}}) {
      const std::vector<BusRecord> frames = random_frames(random, count, streams);
      Bytes blob;
      ASSERT_EQ(encode_bus(frames, blob), CodecError::none);
      std::vector<BusRecord> back;
      ASSERT_EQ(decode_bus(blob, back), CodecError::none);
      ASSERT_EQ(back.size(), frames.size());
      EXPECT_TRUE(std::ranges::equal(back, frames, same));
    }
  }
}

TEST(BusCodec, damage_is_noticed) {
  std::mt19937_64 random(6);
  const std::vector<BusRecord> frames = random_frames(random, 200, 5);
  Bytes blob;
  ASSERT_EQ(encode_bus(frames, blob), CodecError::none);
  std::vector<BusRecord> back;
  for (std::size_t i = 0; i < blob.size(); ++i) {
    Bytes damaged = blob;
    damaged[i] ^= 0x10;
    EXPECT_NE(decode_bus(damaged, back), CodecError::none);
    damaged.resize(i);
    EXPECT_NE(decode_bus(damaged, back), CodecError::none);
  }
  EXPECT_TRUE(back.empty()) << "a refused blob must not leave frames behind";
}

}  // namespace
}  // namespace hoist::db
