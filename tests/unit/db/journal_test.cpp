// The journal as it is stored: every bit comes back, what is damaged is told, and it is small.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <random>

#include "db/codec/bytes.hpp"
#include "db/codec/journal_chunk.hpp"
#include "db/store/sqlite.hpp"
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

// Also with a checksum that fits what is left, what was cut, grew or is of another version is not taken for a journal.
TEST(Journal, WhatWasCutGrewOrIsOfAnotherVersionIsRefused) {
  JournalEncoder encoder;
  Bytes blob;
  ASSERT_EQ(encoder.encode(walk(200), std::vector<JournalCommand>(2), blob), CodecError::none);
  blob.resize(blob.size() - 4);  // without its checksum
  const auto read = [](Bytes content) {
    put_u32(content, crc32(content));
    std::vector<JournalStep> steps;
    std::vector<JournalCommand> commands;
    const CodecError error = decode_journal(content, steps, commands);
    EXPECT_EQ(steps.empty(), error != CodecError::none) << "all or nothing";
    return error;
  };
  ASSERT_EQ(read(blob), CodecError::none);
  for (std::size_t size = 0; size < blob.size(); ++size)
    EXPECT_NE(read(Bytes(blob.begin(), blob.begin() + static_cast<std::ptrdiff_t>(size))), CodecError::none) << "cut to " << size;
  Bytes longer = blob;
  longer.push_back(0);
  EXPECT_NE(read(longer), CodecError::none);
  Bytes other = blob;
  ++other[1];
  EXPECT_EQ(read(other), CodecError::directory_unknown_version);
  std::vector<std::uint8_t> memory(100, 7);
  const Bytes packed = pack_bytes(memory);
  EXPECT_TRUE(unpack_bytes(packed, memory));
  std::vector<std::uint8_t> larger(101);
  EXPECT_FALSE(unpack_bytes(packed, larger)) << "an image of another size";
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

// Commands belong to their steps, across commits, stored runs and folding.
TEST_F(JournalStore, EachCommandStaysWithItsStep) {
  std::vector<JournalStep> steps(7000);
  std::vector<JournalCommand> commands;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    steps[i].step = steps[i].tick = 10 + i;
    steps[i].commands = i % 1000 == 999 ? 2 : i % 7 == 3 ? 1 : 0;
    for (std::uint32_t n = 0; n < steps[i].commands; ++n) {
      JournalCommand& command = commands.emplace_back();
      command.step = steps[i].step;
      command.command.sequence = commands.size();
    }
  }
  const std::span all(steps);
  for (std::size_t from = 0; from < 1000; from += 50) {
    ASSERT_TRUE(writer_->append_journal(all.subspan(from, 50), commands).ok());
    ASSERT_TRUE(writer_->commit().ok());
  }
  // More than one stored run in one commit.
  ASSERT_TRUE(writer_->append_journal(all.subspan(1000, 6000), commands).ok());
  const auto check = [&] {
    const SessionReader reader(*database_);
    std::size_t step = 0, command = 0;
    const auto extents = reader.journal(session_);
    for (const JournalExtent& extent : *extents) {
      const auto run = reader.journal_run(session_, extent.first_step);
      ASSERT_TRUE(run.ok()) << run.error().message;
      ASSERT_EQ(run->steps.size(), extent.steps);
      std::size_t due = 0;
      for (const JournalStep& one : run->steps) {
        ASSERT_LT(step, steps.size());
        ASSERT_EQ(one.step, steps[step++].step);
        due += one.commands;
      }
      ASSERT_EQ(run->commands.size(), due) << "of the run from step " << extent.first_step;
      for (const JournalCommand& one : run->commands) {
        EXPECT_EQ(one.step, commands[command].step);
        EXPECT_EQ(one.command.sequence, commands[command++].command.sequence);
      }
    }
    EXPECT_EQ(step, steps.size());
    EXPECT_EQ(command, commands.size());
  };
  ASSERT_TRUE(writer_->commit().ok());
  check();
  ASSERT_TRUE(writer_->end(CloseReason::finished, test::kStartUtc_ns).ok());
  check();
}

TEST_F(JournalStore, ADamagedRunIsLeftAsItIsWhenTheOthersAreJoined) {
  for (std::uint64_t from = 0; from < 400; from += 50) {
    append(from, from + 50);
    ASSERT_TRUE(writer_->commit().ok());
  }
  execute(database_->handle(), "UPDATE journal_chunks SET body = zeroblob(40) WHERE first_step = 200");
  ASSERT_TRUE(writer_->end(CloseReason::finished, test::kStartUtc_ns).ok());
  const SessionReader reader(*database_);
  std::vector<std::uint64_t> whole;
  const auto extents = reader.journal(session_);
  for (const JournalExtent& extent : *extents) {
    const auto run = reader.journal_run(session_, extent.first_step);
    EXPECT_EQ(run.ok(), extent.first_step != 200) << extent.first_step;
    if (run)
      for (const JournalStep& one : run->steps) whole.push_back(one.step);
  }
  EXPECT_EQ(extents->size(), 3U);
  EXPECT_EQ(whole.size(), 350U);
}

// Beyond a minute that waits, steps are left out. The image after them is kept, so that the rest can be run again.
TEST_F(JournalStore, WhatFindsNoRoomIsAHole) {
  append(0, kMaxPendingSamples);
  image(0);
  append(kMaxPendingSamples, kMaxPendingSamples + 100);
  image(kMaxPendingSamples + 50);  // of a step that was left out
  ASSERT_TRUE(writer_->commit().ok());
  append(kMaxPendingSamples + 100, kMaxPendingSamples + 200);
  image(kMaxPendingSamples + 150);
  ASSERT_TRUE(writer_->commit().ok());
  EXPECT_EQ(stored_images(), (std::vector<std::uint64_t>{0, kMaxPendingSamples + 150}));
  EXPECT_FALSE(writer_->append_journal(std::vector<JournalStep>(1), {}).ok()) << "steps must rise";
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
