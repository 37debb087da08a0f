// The live values of all clients that chose the same topics and rate: packed and framed once, shared by all of them. One thread.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "control/contract/signals.hpp"
#include "server/contract/topics.hpp"
#include "server/ws/connection.hpp"

namespace hoist::server {

// A message of samples, binary, little endian:
//   kind 1: u8 kind, u8 version, u16 samples, u32 bytes of one, u64 layout_hash(), then whole records as they lie in memory
//   kind 2: the same with topics_hash(), u32 topics (one bit each), then of each sample the blocks of its topics
inline constexpr std::size_t kRecordsHeader_bytes = 16;
inline constexpr std::size_t kTopicsHeader_bytes = 20;

struct StreamChoice {
  TopicMask topics = kUnaskedTopics;
  std::uint32_t every_ticks = 1;
  bool every_step = false;  // a message for each step, not one for each batch
  bool operator==(const StreamChoice&) const = default;
};

class Feed {
 public:
  explicit Feed(const StreamChoice& choice);

  // The next step of the core. `at_once`: it is a sample at any rate, because the state has changed.
  void take(const contract::TickRecord& record, bool at_once);
  struct Batch {
    SharedFrame frame;  // nothing: no sample is due
    Steps steps;
  };
  // What was taken since the last one.
  [[nodiscard]] Batch flush();
  // The next step belongs to another core.
  void restart();

  [[nodiscard]] const StreamChoice& choice() const { return choice_; }
  [[nodiscard]] std::size_t sample_bytes() const { return sample_bytes_; }
  // How many samples the steps from..to have, changes of state not counted.
  [[nodiscard]] std::uint64_t due(std::uint64_t from, std::uint64_t to) const;

 private:
  struct Piece {
    std::size_t offset, size;
  };
  [[nodiscard]] bool whole() const { return choice_.topics == topic_bit(Topic::all); }
  std::shared_ptr<std::string> free_frame();

  StreamChoice choice_;
  std::vector<Piece> pieces_;  // of a record, in the order of a sample
  std::size_t sample_bytes_ = 0;
  std::string samples_;
  Steps steps_;
  // The memory of a frame that every client has sent is used again, so that the steady stream asks the heap for nothing. Clients that are
  // behind hold the last few; when all are held, a frame of its own is made.
  std::array<std::shared_ptr<std::string>, 8> kept_;
};

// Whether something of the state differs that no rate may hold back.
[[nodiscard]] bool changes_at_once(const contract::TickRecord& before, const contract::TickRecord& now);

}  // namespace hoist::server
