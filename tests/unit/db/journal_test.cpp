// The journal as it is stored: every bit comes back, what is damaged is told, and it is small.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <random>

#include "db/codec/journal_chunk.hpp"
#include "tests/unit/db/db_support.hpp"

namespace hoist::db {
namespace {

using contract::JournalCommand;
using contract::JournalStep;

bool same(const JournalStep& a, const JournalStep& b) {
  bool all = a.step == b.step && a.frames == b.frames && a.commands == b.commands && a.record_digest == b.record_digest;
#define HOIST_JOURNAL(type, name, where) all = all && std::memcmp(&a.name, &b.name, sizeof a.name) == 0;
#include "control/contract/journal.def"
#undef HOIST_JOURNAL
  return all;
}

/// Any bits in any field; without a fresh driving command there is none.
JournalStep random_step(std::mt19937_64& random, std::uint64_t number) {
  JournalStep step;
  const auto fill = [&random](auto& field) {
    const std::uint64_t bits = random() % 8 == 0 ? std::numeric_limits<std::uint64_t>::max() : random();
    std::memcpy(&field, &bits, sizeof field);
  };
  fill(step.frames), fill(step.commands), fill(step.record_digest);
#define HOIST_JOURNAL(type, name, where) fill(step.name);
#include "control/contract/journal.def"
#undef HOIST_JOURNAL
  step.step = number;
  if (step.drive_fresh % 2 == 0) {
    step.drive_fresh = 0;
    step.drive_sequence = step.drive_echo_time_ns = step.drive_held = 0;
    step.drive_speed_norm = step.drive_yaw_norm = 0;
    step.drive_lease_epoch = step.drive_client = 0;
  }
  return step;
}

/// A walk as hoist-control sees it on a quiet computer, driven by stick in its second half.
std::vector<JournalStep> walk(std::size_t count) {
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  std::vector<JournalStep> steps(count);
  for (std::size_t i = 0; i < count; ++i) {
    JournalStep& step = steps[i];
    const auto noise_ns = [&](double mean, double sigma) {
      return static_cast<float>(static_cast<std::uint64_t>(std::fabs(mean + sigma * normal(random))));
    };
    const float lateness_ns = noise_ns(60e3, 15e3);
    step.step = 5000 + i;
    step.tick = 5000 + i;
    step.wake_lateness_s = lateness_ns * 1e-9F;
    step.previous_duration_s = noise_ns(65e3, 8e3) * 1e-9F;
    step.time_ns = 77'000'000'123 + i * 10'000'000 + static_cast<std::uint64_t>(lateness_ns);
    step.frames = 9 + (i % 10 == 0 ? 1 : 0) + (random() % 16 == 0 ? 1 : 0);
    step.record_digest = static_cast<std::uint32_t>(random());
    step.server_heartbeat = 100 + i;
    step.server_life = 1;
    step.bus_up = 1;
    step.lateness_p50_s = step.lateness_p99_s = 7e-5F;
    if (i < count / 2 || i % 4 != 0) continue;
    step.drive_fresh = 1;
    step.drive_sequence = i;
    step.drive_echo_time_ns = step.time_ns - 50'000'000 - random() % 10'000'000;
    step.drive_speed_norm = std::round(600 + 20 * std::sin(static_cast<double>(i) * 0.01)) / 1000;
    step.drive_yaw_norm = std::round(100 * std::sin(static_cast<double>(i) * 0.02)) / 1000;
    step.drive_held = 1;
    step.drive_lease_epoch = step.drive_client = 3;
  }
  return steps;
}

TEST(Journal, EveryBitComesBack) {
  std::mt19937_64 random(7);
  JournalEncoder encoder;
  for (const std::size_t count : {1U, 2U, 100U, 3000U}) {
    std::vector<JournalStep> steps, back;
    std::vector<JournalCommand> commands(count % 7), commands_back;
    for (std::size_t i = 0; i < count; ++i) steps.push_back(random_step(random, i * i));
    for (JournalCommand& command : commands)
      command.step = random(), command.command.v0 = std::nan("7"), command.command.sequence = random();
    Bytes blob;
    ASSERT_EQ(encoder.encode(steps, commands, blob), CodecError::none);
    ASSERT_EQ(decode_journal(blob, back, commands_back), CodecError::none);
    ASSERT_EQ(back.size(), count);
    for (std::size_t i = 0; i < count; ++i) ASSERT_TRUE(same(steps[i], back[i])) << "step " << i << " of " << count;
    ASSERT_EQ(commands_back.size(), commands.size());
    if (!commands.empty()) {
      EXPECT_EQ(std::memcmp(commands.data(), commands_back.data(), commands.size() * sizeof(JournalCommand)), 0);
    }
  }
}

TEST(Journal, AnyDamagedByteIsTold) {
  JournalEncoder encoder;
  const std::vector<JournalCommand> commands(2);
  Bytes blob;
  ASSERT_EQ(encoder.encode(walk(200), commands, blob), CodecError::none);
  for (std::size_t at = 0; at < blob.size(); ++at) {
    Bytes damaged = blob;
    damaged[at] ^= 0x10U;
    std::vector<JournalStep> steps;
    std::vector<JournalCommand> back;
    EXPECT_NE(decode_journal(damaged, steps, back), CodecError::none) << "byte " << at;
    // Also with a checksum that fits the damage: any answer, but no crash.
    const std::uint32_t sum = crc32(ByteView(damaged).first(damaged.size() - 4));
    for (std::size_t i = 0; i < 4; ++i) damaged[damaged.size() - 4 + i] = static_cast<std::uint8_t>(sum >> (8 * i));
    (void)decode_journal(damaged, steps, back);
  }
}

TEST(Journal, AStepCostsAtMost15Bytes) {
  JournalEncoder encoder;
  Bytes blob;
  ASSERT_EQ(encoder.encode(walk(3000), {}, blob), CodecError::none);
  RecordProperty("bytes_per_step", std::to_string(static_cast<double>(blob.size()) / 3000));
  std::printf("%.1f bytes per step\n", static_cast<double>(blob.size()) / 3000);
  EXPECT_LE(blob.size(), 15U * 3000U);
}

class JournalStore : public ::testing::Test {
 protected:
  void SetUp() override {
    auto opened = Database::open(folder_ / "a.db", {.utc_now_ns = test::kStartUtc_ns});
    ASSERT_TRUE(opened.ok());
    database_.emplace(std::move(*opened));
    auto writer = SessionWriter::create(*database_);
    ASSERT_TRUE(writer.ok());
    writer_.emplace(std::move(*writer));
    SessionStart start;
    start.started_utc_ns = test::kStartUtc_ns;
    start.start_time_ns = test::kStart_ns;
    auto begun = writer_->begin(start);
    ASSERT_TRUE(begun.ok());
    session_ = *begun;
  }
  void append(std::uint64_t from, std::uint64_t to) {
    std::vector<JournalStep> steps(to - from);
    for (std::uint64_t i = from; i < to; ++i) steps[i - from].step = steps[i - from].tick = i;
    ASSERT_TRUE(writer_->append_journal(steps, {}).ok());
  }
  void image(std::uint64_t step) {
    contract::CoreImage image;
    image.step = image.tick = step;
    image.bytes = 100;
    image.memory[99] = static_cast<std::uint8_t>(step);
    ASSERT_TRUE(writer_->append_image(image).ok());
  }
  std::vector<std::uint64_t> stored_images() {
    std::vector<std::uint64_t> steps;
    const auto places = SessionReader(*database_).images(session_);
    for (const ImagePlace& place : *places) steps.push_back(place.step);
    return steps;
  }

  test::TemporaryFolder folder_;
  std::optional<Database> database_;
  std::optional<SessionWriter> writer_;
  SessionId session_ = 0;
};

TEST_F(JournalStore, IsReadBackWhileRecordingAndAfterFolding) {
  for (std::uint64_t from = 10; from < 6010; from += 40) {
    append(from, from + 40);
    ASSERT_TRUE(writer_->commit().ok());
  }
  const SessionReader reader(*database_);
  EXPECT_EQ(reader.journal(session_)->size(), 150U);
  ASSERT_TRUE(writer_->end(CloseReason::finished, test::kStartUtc_ns).ok());
  const auto extents = reader.journal(session_);
  EXPECT_EQ(extents->size(), 2U) << "folded";
  std::uint64_t next = 10;
  for (const JournalExtent& extent : *extents) {
    const auto run = reader.journal_run(session_, extent.first_step);
    for (const JournalStep& step : run->steps) ASSERT_EQ(step.step, next++);
  }
  EXPECT_EQ(next, 6010U);
}

TEST_F(JournalStore, KeepsTheFirstImageOneAMinuteAndTheFirstAfterAHole) {
  append(100, 200);
  image(50);   // before the first step: of no use
  image(100);  // kept
  image(150);
  append(250, 400);  // 50 steps are missing
  image(300);        // kept
  image(350);
  ASSERT_TRUE(writer_->append_gap("bus", 400, 410, "recorder_late").ok());
  image(400);  // frames are missing; where they resume is not known yet
  append(400, 500);
  image(450);  // kept
  append(500, 6000);
  ASSERT_TRUE(writer_->commit().ok());
  append(6000, 7000);
  image(6449);
  image(6450);  // kept
  ASSERT_TRUE(writer_->commit().ok());
  EXPECT_EQ(stored_images(), (std::vector<std::uint64_t>{100, 300, 450, 6450}));
  EXPECT_EQ(SessionReader(*database_).image(session_, 300)->memory[99], 300 % 256);
}

}  // namespace
}  // namespace hoist::db
