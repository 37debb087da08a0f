#include "db/codec/journal_chunk.hpp"

#include <zstd.h>

#include <bit>
#include <cmath>
#include <cstring>

namespace hoist::db {
namespace {

using contract::Command;
using contract::JournalCommand;
using contract::JournalStep;

constexpr std::uint8_t kJournalMagic = 0x4A;  // 'J'
constexpr std::uint8_t kJournalVersion = 1;
constexpr int kLevel = 3;
constexpr std::uint64_t kTick_ns = 10'000'000;
// Longer times are stored bit for bit: beyond a second nothing is gained.
constexpr double kMostNanoseconds = 1e9;

// As the loop makes seconds of nanoseconds (control/run/control_loop.cpp).
float seconds_of(std::uint64_t ns) { return static_cast<float>(ns) * 1e-9F; }
std::uint64_t nearest_ns(float seconds) {
  const double ns = std::nearbyint(static_cast<double>(seconds) * 1e9);
  return ns >= 0 && ns <= kMostNanoseconds ? static_cast<std::uint64_t>(ns) : 0;
}

// What journal.def's types become: an integer each, and back.
#define HOIST_CODEC(type)                                                                                   \
  std::int64_t store_##type(contract::journal_cpp::type value) { return static_cast<std::int64_t>(value); } \
  contract::journal_cpp::type load_##type(std::int64_t stored) { return static_cast<contract::journal_cpp::type>(stored); }
HOIST_CODEC(u64)
HOIST_CODEC(u32)
HOIST_CODEC(u16)
HOIST_CODEC(u8)
#undef HOIST_CODEC
std::int64_t store_f64(double value) { return std::bit_cast<std::int64_t>(value); }
double load_f64(std::int64_t stored) { return std::bit_cast<double>(stored); }
// Whole nanoseconds need half the bits: even numbers are these, odd ones the float's own bits.
std::int64_t store_f32_s(float seconds) {
  const std::uint64_t ns = nearest_ns(seconds);
  const auto bits = std::bit_cast<std::uint32_t>(seconds);
  return static_cast<std::int64_t>(std::bit_cast<std::uint32_t>(seconds_of(ns)) == bits ? 2 * ns : 2 * std::uint64_t{bits} + 1);
}
float load_f32_s(std::int64_t stored) {
  const auto bits = static_cast<std::uint64_t>(stored);
  return (bits & 1U) == 0 ? seconds_of(bits >> 1) : std::bit_cast<float>(static_cast<std::uint32_t>(bits >> 1));
}

// Columns beside those of journal.def.
enum Own : std::size_t { kStep, kFrames, kCommands, kDigest, kOwnColumns };
constexpr std::size_t kJournalColumns = kOwnColumns
#define HOIST_JOURNAL(type, name, where) +1
#include "control/contract/journal.def"
#undef HOIST_JOURNAL
    ;
static_assert(kJournalColumns <= kMaxChunkColumns);

// When the step began, as its number and lateness say: what is stored of the time is how far it was off.
std::uint64_t expected_time_ns(const JournalStep& step) { return step.tick * kTick_ns + nearest_ns(step.wake_lateness_s); }

// What changes how the columns look, and nothing else: times become differences from what is expected, a driving command that was not fresh
// repeats the one before. Each is undone by the other with the row before as it was given.
JournalStep lean(const JournalStep& step, const JournalStep& before) {
  JournalStep out = step;
  out.time_ns = step.time_ns - expected_time_ns(step);
  out.drive_echo_time_ns = step.time_ns - step.drive_echo_time_ns;
  if (step.drive_fresh != 0) return out;
  out.drive_sequence = before.drive_sequence;
  out.drive_echo_time_ns = before.drive_echo_time_ns;
  out.drive_speed_norm = before.drive_speed_norm;
  out.drive_yaw_norm = before.drive_yaw_norm;
  out.drive_held = before.drive_held;
  out.drive_lease_epoch = before.drive_lease_epoch;
  out.drive_client = before.drive_client;
  return out;
}
void restore(JournalStep& step) {
  step.time_ns += expected_time_ns(step);
  if (step.drive_fresh != 0) {
    step.drive_echo_time_ns = step.time_ns - step.drive_echo_time_ns;
    return;
  }
  step.drive_sequence = step.drive_echo_time_ns = step.drive_held = 0;
  step.drive_speed_norm = step.drive_yaw_norm = 0;
  step.drive_lease_epoch = step.drive_client = 0;
}

void fill_columns(std::span<const JournalStep> steps, std::vector<std::vector<std::int64_t>>& columns) {
  columns.resize(kJournalColumns);
  for (auto& column : columns) column.resize(steps.size());
  JournalStep before{};
  std::int64_t digests = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const JournalStep row = lean(steps[i], before);
    columns[kStep][i] = static_cast<std::int64_t>(row.step);
    columns[kFrames][i] = row.frames;
    columns[kCommands][i] = row.commands;
    // Digests are noise: summed up, their differences (which is what a column stores) are the digests, in four bytes and not five.
    digests += static_cast<std::int32_t>(row.record_digest);
    columns[kDigest][i] = digests;
    std::size_t c = kOwnColumns;
#define HOIST_JOURNAL(type, name, where) columns[c++][i] = store_##type(row.name);
#include "control/contract/journal.def"
#undef HOIST_JOURNAL
    before = row;
  }
}

void read_columns(const std::vector<std::vector<std::int64_t>>& columns, std::vector<JournalStep>& steps) {
  const std::size_t count = columns[0].size();
  steps.reserve(steps.size() + count);
  std::int64_t digests = 0;
  for (std::size_t i = 0; i < count; ++i) {
    JournalStep& row = steps.emplace_back();
    row.step = static_cast<std::uint64_t>(columns[kStep][i]);
    row.frames = static_cast<std::uint32_t>(columns[kFrames][i]);
    row.commands = static_cast<std::uint32_t>(columns[kCommands][i]);
    row.record_digest = static_cast<std::uint32_t>(wrapping_difference(columns[kDigest][i], digests));
    digests = columns[kDigest][i];
    std::size_t c = kOwnColumns;
#define HOIST_JOURNAL(type, name, where) row.name = load_##type(columns[c++][i]);
#include "control/contract/journal.def"
#undef HOIST_JOURNAL
    restore(row);
  }
}

void put_section(ByteView section, Bytes& out) {
  put_varint(out, section.size());
  out.insert(out.end(), section.begin(), section.end());
}

}  // namespace

Bytes pack_bytes(ByteView plain) {
  Bytes out(ZSTD_compressBound(plain.size()));
  const std::size_t n = ZSTD_compress(out.data(), out.size(), plain.data(), plain.size(), kLevel);
  if (ZSTD_isError(n) != 0) return {};
  out.resize(n);
  put_u32(out, crc32(out));
  return out;
}

bool unpack_bytes(ByteView blob, std::span<std::uint8_t> plain) {
  const auto content = without_checksum(blob);
  if (!content) return false;
  const std::size_t n = ZSTD_decompress(plain.data(), plain.size(), content->data(), content->size());
  return ZSTD_isError(n) == 0 && n == plain.size();
}

CodecError JournalEncoder::encode(std::span<const JournalStep> steps, std::span<const JournalCommand> commands, Bytes& out) {
  out.clear();
  if (steps.empty() || steps.size() > kMaxChunkSamples || commands.size() > kMaxJournalCommands) return CodecError::body_damaged;
  fill_columns(steps, values_);
  if (const CodecError error = columns_.encode(values_, steps.size(), ChunkLayout::one_frame, encoded_); error != CodecError::none)
    return error;
  out.push_back(kJournalMagic);
  out.push_back(kJournalVersion);
  put_section(encoded_.directory, out);
  put_section(encoded_.body, out);
  put_varint(out, commands.size());
  if (!commands.empty()) {
    Bytes plain(commands.size() * sizeof(JournalCommand));
    std::memcpy(plain.data(), commands.data(), plain.size());
    const Bytes packed = pack_bytes(plain);
    if (packed.empty()) return CodecError::zstd_failed;
    put_section(packed, out);
  }
  put_u32(out, crc32(out));
  return CodecError::none;
}

CodecError decode_journal(ByteView blob, std::vector<JournalStep>& steps, std::vector<JournalCommand>& commands) {
  const auto content = without_checksum(blob);
  if (!content) return CodecError::body_damaged;
  ByteReader in(*content);
  if (in.u8() != kJournalMagic) return CodecError::body_damaged;
  if (in.u8() != kJournalVersion) return CodecError::directory_unknown_version;
  const auto section = [&](ByteView& out) {
    out = in.take(in.varint());
    return in.ok();
  };
  ByteView directory_blob, body;
  if (!section(directory_blob) || !section(body)) return CodecError::body_damaged;
  ChunkDirectory directory;
  if (const CodecError error = parse_directory(directory_blob, directory); error != CodecError::none) return error;
  // Another build's columns: its journal cannot be run by this one anyway.
  if (directory.columns.size() != kJournalColumns) return CodecError::directory_unknown_version;
  std::vector<std::size_t> which(kJournalColumns);
  for (std::size_t c = 0; c < kJournalColumns; ++c) which[c] = c;
  std::vector<std::vector<std::int64_t>> values;
  ChunkDecoder decoder;
  if (const CodecError error = decoder.columns(directory, which, body, values); error != CodecError::none) return error;
  const std::uint64_t count = in.varint();
  if (!in.ok() || count > kMaxJournalCommands) return CodecError::body_damaged;
  Bytes plain(count * sizeof(JournalCommand));
  if (count > 0) {
    ByteView packed;
    if (!section(packed) || !unpack_bytes(packed, plain)) return CodecError::body_damaged;
  }
  if (in.left() != 0) return CodecError::body_damaged;
  read_columns(values, steps);
  const std::size_t before = commands.size();
  commands.resize(before + count);
  if (count > 0) std::memcpy(commands.data() + before, plain.data(), plain.size());
  return CodecError::none;
}

}  // namespace hoist::db
