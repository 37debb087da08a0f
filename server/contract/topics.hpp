// The rows of topics.def: which live values a client may choose to see, and at which rates.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "control/contract/check.hpp"
#include "control/contract/signals.hpp"

namespace hoist::server {

enum class Topic : std::uint8_t {
#define HOIST_TOPIC(name, doc) name,
#define HOIST_TOPIC_VALUE(...)
#include "server/contract/topics.def"
#undef HOIST_TOPIC
#undef HOIST_TOPIC_VALUE
};

struct TopicInfo {
  std::string_view name, doc;
};
inline constexpr std::array kTopics{
#define HOIST_TOPIC(name, doc) TopicInfo{#name, doc},
#define HOIST_TOPIC_VALUE(...)
#include "server/contract/topics.def"
#undef HOIST_TOPIC
#undef HOIST_TOPIC_VALUE
};

struct TopicValue {
  Topic topic;
  std::string_view name;
  std::size_t offset, size;  // in a TickRecord
  bool at_once;
};
inline constexpr std::array kTopicValues{
#define HOIST_TOPIC(...)
#define HOIST_TOPIC_VALUE(topic, signal, at_once) \
  TopicValue{Topic::topic, #signal, offsetof(contract::TickRecord, signal), sizeof(contract::TickRecord::signal), (at_once) != 0},
#include "server/contract/topics.def"
#undef HOIST_TOPIC
#undef HOIST_TOPIC_VALUE
};
static_assert(contract::unique_by(kTopicValues, [](const TopicValue& value) { return value.name; }),
              "topics.def: a value is in two topics");

// One bit per topic.
using TopicMask = std::uint32_t;
constexpr TopicMask topic_bit(Topic topic) { return TopicMask{1} << static_cast<unsigned>(topic); }

// What a client gets that has chosen nothing: how hoist and patient move and lean, a third of a whole record.
inline constexpr TopicMask kUnaskedTopics =
    topic_bit(Topic::state) | topic_bit(Topic::motion) | topic_bit(Topic::pose) | topic_bit(Topic::posture) | topic_bit(Topic::intent);

constexpr std::optional<Topic> find_topic(std::string_view name) {
  for (std::size_t i = 0; i < kTopics.size(); ++i)
    if (kTopics[i].name == name) return static_cast<Topic>(i);
  return std::nullopt;
}

// Samples per second that divide the core's 100 steps evenly.
inline constexpr std::array<std::uint32_t, 7> kStreamRates_hz{1, 2, 5, 10, 20, 50, 100};

// What both sides must agree on to read a sample of chosen topics.
constexpr std::uint64_t topics_hash() {
  std::uint64_t hash = contract::signals_hash();
  for (const TopicInfo& topic : kTopics) hash = contract::hash_bytes(hash, topic.name);
  for (const TopicValue& value : kTopicValues)
    hash = contract::hash_bytes(contract::hash_number(hash, static_cast<std::uint64_t>(value.topic)), value.name);
  return hash;
}

}  // namespace hoist::server
