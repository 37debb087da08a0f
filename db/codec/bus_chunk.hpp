// Raw CAN frames in columns per identifier: the order of the streams, the times, and each stream's data as four 16-bit differences in byte planes.
// Exact and in order: frames come back as they were recorded.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "control/contract/commands.hpp"
#include "db/codec/bytes.hpp"
#include "db/codec/column_chunk.hpp"

namespace hoist::db {

/// Frames of one chunk, and different (id, length, flags, direction) among them.
inline constexpr std::size_t kMaxBusChunkFrames = 65536, kMaxBusStreams = 65535;

/// `out` gets one blob with its own checksum. `frames` holds 1 to kMaxBusChunkFrames.
[[nodiscard]] CodecError encode_bus(std::span<const contract::BusRecord> frames, Bytes& out);
/// Appends the frames of one blob.
[[nodiscard]] CodecError decode_bus(ByteView blob, std::vector<contract::BusRecord>& frames);

}  // namespace hoist::db
