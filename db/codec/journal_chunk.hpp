// A run of the journal as one blob: the steps as columns (column_chunk.hpp), the commands as they are, a checksum. Exact: every bit comes back.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "control/contract/journal.hpp"
#include "db/codec/bytes.hpp"
#include "db/codec/column_chunk.hpp"

namespace hoist::db {

/// Commands of one chunk. More is refused: no server of ours sends that many.
inline constexpr std::size_t kMaxJournalCommands = 65536;

/// Keeps its zstd state between calls.
class JournalEncoder {
 public:
  /// `out` gets one blob with its own checksum. 1 to kMaxChunkSamples steps.
  [[nodiscard]] CodecError encode(std::span<const contract::JournalStep> steps, std::span<const contract::JournalCommand> commands,
                                  Bytes& out);

 private:
  ChunkEncoder columns_;
  EncodedChunk encoded_;
  std::vector<std::vector<std::int64_t>> values_;
};

/// Appends the steps and commands of one blob. Any blob is safe to give: lengths, counts and checksum are checked.
[[nodiscard]] CodecError decode_journal(ByteView blob, std::vector<contract::JournalStep>& steps,
                                        std::vector<contract::JournalCommand>& commands);

/// Plain bytes with zstd and a checksum, for what is stored once a minute. `pack_bytes` is empty when zstd fails.
[[nodiscard]] Bytes pack_bytes(ByteView plain);
/// The way back; false unless the blob is whole and holds exactly `plain.size()` bytes.
[[nodiscard]] bool unpack_bytes(ByteView blob, std::span<std::uint8_t> plain);

}  // namespace hoist::db
