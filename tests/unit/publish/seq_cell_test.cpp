#include "control/publish/seq_cell.hpp"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "control/publish/ring.hpp"

namespace hoist::publish {
namespace {

struct Wide {
  std::array<std::uint64_t, 40> words{};
};
Wide wide(std::uint64_t k) {
  Wide value;
  for (std::size_t i = 0; i < value.words.size(); ++i) value.words[i] = k * 1000 + i;
  return value;
}
// The number the value was made from, or -1 when its words do not belong together.
std::int64_t whole(const Wide& value) {
  const std::uint64_t k = value.words[0] / 1000;
  for (std::size_t i = 0; i < value.words.size(); ++i)
    if (value.words[i] != k * 1000 + i) return -1;
  return static_cast<std::int64_t>(k);
}

TEST(SeqCell, GivesBackWhatWasWrittenAndNothingBeforeTheFirstWrite) {
  contract::SeqSlot<Wide> slot{};
  Wide value;
  EXPECT_EQ(seq_read(slot, value), 0U);
  seq_write(slot, 0, wide(7));
  EXPECT_EQ(seq_read(slot, value), 2U);
  EXPECT_EQ(whole(value), 7);
}

TEST(SeqCell, RefusesAValueThatIsBeingWritten) {
  contract::SeqSlot<Wide> slot{};
  seq_write(slot, 0, wide(7));
  slot.sequence.store(3);  // as a writer that was stopped in the middle leaves it
  Wide value;
  EXPECT_EQ(seq_read(slot, value), 0U);
  EXPECT_EQ(seq_read_retry(slot, value), 0U) << "a dead writer must not hang a reader";
}

// A yield beside other programs costs a slice of a millisecond or more.
constexpr std::uint64_t kYieldEach = 4096;

TEST(SeqCell, NeverGivesATornValueUnderAWriterThatRarelyPauses) {
  auto slot = std::make_unique<contract::SeqSlot<Wide>>();
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (std::uint64_t k = 0; k < 300'000; ++k) {
      seq_write(*slot, k, wide(k));
      if (k % kYieldEach == 0) std::this_thread::yield();
    }
    done = true;
  });
  std::int64_t last = -1;
  std::uint64_t good = 0;
  while (!done) {
    Wide value;
    if (seq_read(*slot, value) == 0) continue;
    const std::int64_t k = whole(value);
    ASSERT_GE(k, 0) << "torn";
    ASSERT_GE(k, last) << "time ran backwards";
    last = k;
    ++good;
  }
  writer.join();
  Wide value;
  ASSERT_NE(seq_read(*slot, value), 0U);
  EXPECT_EQ(whole(value), 299'999);
  EXPECT_GT(good, 0U);
}

TEST(Ring, GivesEveryValueInOrder) {
  auto ring = std::make_unique<contract::SeqRing<Wide, 8>>();
  std::uint64_t cursor = 0;
  std::array<Wide, 3> out;
  EXPECT_EQ(ring_read(*ring, cursor, std::span<Wide>(out)).count, 0U);
  for (std::uint64_t k = 0; k < 5; ++k) ring_write(*ring, wide(k));
  RingRead got = ring_read(*ring, cursor, std::span<Wide>(out));
  ASSERT_EQ(got.count, 3U);
  EXPECT_EQ(whole(out[0]), 0);
  EXPECT_EQ(whole(out[2]), 2);
  got = ring_read(*ring, cursor, std::span<Wide>(out));
  ASSERT_EQ(got.count, 2U);
  EXPECT_EQ(whole(out[1]), 4);
  EXPECT_EQ(got.lost, 0U);
}

TEST(Ring, SaysHowManyWereOverwritten) {
  auto ring = std::make_unique<contract::SeqRing<Wide, 8>>();
  for (std::uint64_t k = 0; k < 20; ++k) ring_write(*ring, wide(k));
  std::uint64_t cursor = 2;
  std::array<Wide, 16> out;
  const RingRead got = ring_read(*ring, cursor, std::span<Wide>(out));
  EXPECT_EQ(got.lost, 10U);  // 2 to 11 are gone, 12 to 19 are left
  ASSERT_EQ(got.count, 8U);
  EXPECT_EQ(whole(out[0]), 12);
  EXPECT_EQ(whole(out[7]), 19);
}

TEST(Ring, SurvivesACounterThatLies) {
  auto ring = std::make_unique<contract::SeqRing<Wide, 8>>();
  for (std::uint64_t k = 0; k < 4; ++k) ring_write(*ring, wide(k));
  std::array<Wide, 16> out;
  std::uint64_t cursor = 4;
  ring->written.store(~std::uint64_t{0});  // a leap: everything is lost, nothing is made up
  RingRead got = ring_read(*ring, cursor, std::span<Wide>(out));
  EXPECT_EQ(got.count, 0U);
  EXPECT_GT(got.lost, 0U);
  ring->written.store(1);  // and back
  got = ring_read(*ring, cursor, std::span<Wide>(out));
  EXPECT_EQ(got.count, 0U);
  EXPECT_EQ(cursor, 1U);
}

TEST(Ring, NewestIsTheLastWritten) {
  auto ring = std::make_unique<contract::SeqRing<Wide, 8>>();
  Wide value;
  EXPECT_FALSE(ring_newest(*ring, value));
  for (std::uint64_t k = 0; k < 11; ++k) ring_write(*ring, wide(k));
  ASSERT_TRUE(ring_newest(*ring, value));
  EXPECT_EQ(whole(value), 10);
}

TEST(Ring, ReadersAndWriterAtFullSpeedLoseNothingSilently) {
  auto ring = std::make_unique<contract::SeqRing<Wide, 64>>();
  constexpr std::uint64_t kCount = 200'000;
  std::thread writer([&] {
    for (std::uint64_t k = 0; k < kCount; ++k) {
      ring_write(*ring, wide(k));
      if (k % kYieldEach == 0) std::this_thread::yield();
    }
  });
  std::uint64_t cursor = 0, seen = 0, lost = 0;
  std::vector<Wide> out(32);
  while (seen + lost < kCount) {
    const std::uint64_t before = seen + lost;
    const RingRead got = ring_read(*ring, cursor, std::span<Wide>(out));
    lost += got.lost;
    for (std::size_t i = 0; i < got.count; ++i)
      ASSERT_EQ(whole(out[i]), static_cast<std::int64_t>(before + got.lost + i)) << "a value out of its place";
    seen += got.count;
  }
  writer.join();
  EXPECT_EQ(seen + lost, kCount);
}

}  // namespace
}  // namespace hoist::publish
