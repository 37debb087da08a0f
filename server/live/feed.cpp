#include "server/live/feed.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "control/contract/shared_memory.hpp"

namespace hoist::server {

namespace {
constexpr std::uint8_t kRecords = 1, kTopicBlocks = 2, kVersion = 1;

void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<char>((value >> (8 * i)) & 0xFF));
}
}  // namespace

Feed::Feed(const StreamChoice& choice) : choice_(choice) {
  if ((choice_.topics & topic_bit(Topic::all)) != 0) {
    choice_.topics = topic_bit(Topic::all);
    pieces_.push_back({0, sizeof(contract::TickRecord)});
  } else {
    choice_.topics |= topic_bit(Topic::state);
    for (std::size_t topic = 0; topic < kTopics.size(); ++topic)
      for (const TopicValue& value : kTopicValues) {
        if (value.topic != static_cast<Topic>(topic) || (choice_.topics & topic_bit(value.topic)) == 0) continue;
        if (!pieces_.empty() && pieces_.back().offset + pieces_.back().size == value.offset)
          pieces_.back().size += value.size;
        else
          pieces_.push_back({value.offset, value.size});
      }
  }
  for (const Piece& piece : pieces_) sample_bytes_ += piece.size;
}

void Feed::take(const contract::TickRecord& record, bool at_once) {
  if (steps_.from == 0) steps_.from = record.tick;
  steps_.to = record.tick;
  if (!at_once && record.tick % choice_.every_ticks != 0) return;
  // Little endian in memory as on the wire: every machine this runs on is.
  static_assert(std::endian::native == std::endian::little);
  const auto* bytes = reinterpret_cast<const char*>(&record);
  for (const Piece& piece : pieces_) samples_.append(bytes + piece.offset, piece.size);
  ++steps_.samples;
}

std::shared_ptr<std::string> Feed::free_frame() {
  const auto free = std::ranges::find_if(kept_, [](const auto& kept) { return kept.use_count() <= 1; });
  auto frame = free != kept_.end() && *free ? *free : std::make_shared<std::string>();
  if (free != kept_.end()) *free = frame;
  frame->clear();
  return frame;
}

Feed::Batch Feed::flush() {
  if (steps_.samples == 0) return {};
  const auto frame = free_frame();
  begin_frame(*frame, Opcode::binary, (whole() ? kRecordsHeader_bytes : kTopicsHeader_bytes) + samples_.size());
  put(*frame, whole() ? kRecords : kTopicBlocks, 1);
  put(*frame, kVersion, 1);
  put(*frame, steps_.samples, 2);
  put(*frame, sample_bytes_, 4);
  put(*frame, whole() ? contract::layout_hash() : topics_hash(), 8);
  if (!whole()) put(*frame, choice_.topics, 4);
  frame->append(samples_);
  Batch batch{frame, steps_};
  samples_.clear();
  steps_ = {.from = steps_.to + 1, .to = steps_.to, .samples = 0};
  return batch;
}

void Feed::restart() {
  samples_.clear();
  steps_ = {};
}

std::uint64_t Feed::due(std::uint64_t from, std::uint64_t to) const {
  return from == 0 ? to / choice_.every_ticks + 1 : to / choice_.every_ticks - (from - 1) / choice_.every_ticks;
}

bool changes_at_once(const contract::TickRecord& before, const contract::TickRecord& now) {
  const auto* a = reinterpret_cast<const char*>(&before);
  const auto* b = reinterpret_cast<const char*>(&now);
  return std::ranges::any_of(kTopicValues, [a, b](const TopicValue& value) {
    return value.at_once && std::memcmp(a + value.offset, b + value.offset, value.size) != 0;
  });
}

}  // namespace hoist::server
