// Recordings that are incomplete, foreign or forged: what can be run is run, the rest is told, and nothing does any harm.
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <optional>
#include <random>

#include "control/contract/shared_memory.hpp"
#include "control/publish/journal.hpp"
#include "db/store/session_writer.hpp"
#include "deploy/tools/hoist/rerun.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hoist::tool {
namespace {

using contract::CoreImage;

constexpr const char* kProgram = "0.1.0+test";

/// Four seconds of a hoist that comes to standby, recorded step by step, with an image each second.
class ForgedRecording : public ::testing::Test {
 protected:
  void SetUp() override {
    auto opened = db::Database::open(folder_ / "a.db", {});
    ASSERT_TRUE(opened.ok());
    database_.emplace(std::move(*opened));
  }

  struct Forgery {
    std::function<void(CoreImage&)> image = [](CoreImage&) {};
    std::uint64_t no_frames_at = ~std::uint64_t{0}, no_journal_at = ~std::uint64_t{0};
    std::uint64_t also_no_journal_at = ~std::uint64_t{0};
    bool journal = true, ends = true;
    std::string program = kProgram;
  };
  db::SessionId record(const Forgery& forgery) {
    auto writer = db::SessionWriter::create(*database_);
    db::SessionStart start;
    start.layout_hash = contract::layout_hash();
    start.core_version = forgery.program;
    const db::SessionId session = *writer->begin(start);
    tests::ClosedLoop loop({});
    std::uint64_t step = 0;
    loop.on_inputs([&](const core::TickInputs& inputs) {
      if (step % 100 != 0) return;
      CoreImage image;
      publish::take_image(loop.core(), step, inputs.tick, image);
      forgery.image(image);
      images_.push_back(image);
    });
    loop.on_step([&](const core::TickInputs& inputs, const core::TickOutputs& outputs) {
      std::vector<contract::BusRecord> frames;
      for (const contract::CanFrame& frame : inputs.frames) {
        frames.push_back({inputs.time_ns, frame.id, frame.dlc, frame.flags, 0, 0, 0});
        std::memcpy(&frames.back().data, frame.data.data(), 8);
      }
      EXPECT_TRUE(writer->append_ticks({&outputs.record, 1}).ok());
      if (step != forgery.no_frames_at) {
        EXPECT_TRUE(writer->append_bus(frames).ok());
      }
      const contract::JournalStep row = publish::journal_of(inputs, step, publish::digest_of(outputs.record));
      if (forgery.journal && step != forgery.no_journal_at && step != forgery.also_no_journal_at) {
        EXPECT_TRUE(writer->append_journal({&row, 1}, {}).ok());
      }
      if (forgery.journal && !images_.empty()) {
        // The writer stores the first one, and the first after a loss.
        EXPECT_TRUE(writer->append_image(images_.back()).ok());
        images_.clear();
      }
      ++step;
    });
    loop.run(4.0);
    EXPECT_TRUE(forgery.ends ? writer->end(db::CloseReason::finished, 0).ok() : writer->commit().ok());
    return session;
  }
  db::Result<Verification> verify(db::SessionId session) { return verify_session(*database_, session, kProgram); }

  test::TemporaryFolder folder_;
  std::optional<db::Database> database_;
  std::vector<CoreImage> images_;
};

TEST_F(ForgedRecording, AWholeOneIsTheSame) {
  const auto result = verify(record({}));
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_FALSE(result->first.has_value());
  EXPECT_EQ(result->run.steps, 400U);
  EXPECT_TRUE(result->whole());
}

TEST_F(ForgedRecording, AStepWithoutItsFramesOrJournalEndsWhatCanBeRunUntilTheNextImage) {
  for (const bool frames : {true, false}) {
    Forgery forgery;
    (frames ? forgery.no_frames_at : forgery.no_journal_at) = 250;
    const auto result = verify(record(forgery));
    ASSERT_TRUE(result.ok()) << result.error().message;
    EXPECT_FALSE(result->first.has_value());
    EXPECT_FALSE(result->whole());
    ASSERT_EQ(result->run.not_run.size(), 1U);
    EXPECT_EQ(result->run.not_run[0].from_tick, 250U);
    EXPECT_EQ(result->run.not_run[0].reason, frames ? "their frames are missing" : "their journal is missing");
    // The missing journal is noticed while recording, so the next image is stored; missing frames are not.
    EXPECT_EQ(result->run.not_run[0].to_tick, frames ? 399U : 299U);
    EXPECT_EQ(result->run.samples_run, frames ? 250U : 350U);
  }
}

// A damaged chunk of frames ends the run at its first step; the next image begins a new one.
TEST_F(ForgedRecording, ADamagedChunkOfFramesCostsTheStepsUntilTheNextImage) {
  Forgery forgery;
  // Holes make the writer store images: at steps 0, 100 and 300. Not ended, so that frames stay in chunks of about a second.
  forgery.no_journal_at = 50;
  forgery.also_no_journal_at = 250;
  forgery.ends = false;
  const db::SessionId session = record(forgery);
  ASSERT_EQ(sqlite3_exec(database_->handle(),
                         "UPDATE bus_chunks SET body = zeroblob(length(body)) WHERE id = (SELECT id FROM bus_chunks ORDER BY first_frame "
                         "LIMIT 1 OFFSET 1)",
                         nullptr, nullptr, nullptr),
            SQLITE_OK);
  const auto result = verify(session);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_FALSE(result->first.has_value());
  ASSERT_EQ(result->run.not_run.size(), 2U);
  EXPECT_EQ(result->run.not_run[0].to_tick, 99U);
  EXPECT_GT(result->run.not_run[1].from_tick, 100U);
  EXPECT_LT(result->run.not_run[1].from_tick, 200U);
  EXPECT_EQ(result->run.not_run[1].reason, "their frames are missing");
  EXPECT_EQ(result->run.not_run[1].to_tick, 299U) << "from the image on, the frames behind the damage are used";
}

TEST_F(ForgedRecording, AnotherBuildOrNoJournalIsRefusedInWords) {
  Forgery other;
  other.program = "0.1.0+other";
  const auto foreign = verify(record(other));
  ASSERT_FALSE(foreign.ok());
  EXPECT_EQ(foreign.error().kind, db::ErrorKind::wrong_state);
  EXPECT_NE(foreign.error().message.find("0.1.0+other"), std::string::npos);
  Forgery old;
  old.journal = false;
  const auto without = verify(record(old));
  ASSERT_FALSE(without.ok());
  EXPECT_NE(without.error().message.find("without a journal"), std::string::npos);
  EXPECT_EQ(verify(4711).error().kind, db::ErrorKind::not_found);
}

// Bytes that no core ever had, with a right checksum: the core may crash, hang or compute nonsense, in its own process.
TEST_F(ForgedRecording, AForgedImageDoesNoHarm) {
  std::mt19937_64 random(1);
  for (int round = 0; round < 20; ++round) {
    Forgery forgery;
    forgery.image = [&](CoreImage& image) {
      for (int i = 0; i < (round < 10 ? 3 : 3000); ++i) image.memory[random() % image.bytes] = static_cast<std::uint8_t>(random());
    };
    const auto result = verify(record(forgery));
    ASSERT_TRUE(result.ok()) << result.error().message;
    if (round >= 10) {
      EXPECT_FALSE(result->whole());
    }
  }
  Forgery shorter;
  shorter.image = [](CoreImage& image) { image.bytes -= 8; };
  const auto result = verify(record(shorter));
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->run.steps, 0U);
}

// The server folds a session piece by piece after its end; who reads it meanwhile sees one state.
TEST_F(ForgedRecording, OneThatIsFoldedMeanwhileIsRunWhole) {
  Forgery open;
  open.ends = false;
  const db::SessionId session = record(open);
  auto writer = db::SessionWriter::create(*database_);  // closes it
  ASSERT_TRUE(writer.ok());
  auto reader = db::Database::attach(folder_ / "a.db");
  ASSERT_TRUE(reader.ok());
  int pieces = -1;
  const auto report = rerun(*reader, session, kProgram, {}, [&](const RerunStep&) {
    if (pieces >= 0) return;
    for (pieces = 0; *writer->fold_piece(); ++pieces) continue;
  });
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_GT(pieces, 0);
  EXPECT_EQ(report->steps, 400U);
  EXPECT_TRUE(report->not_run.empty());
}

TEST_F(ForgedRecording, AnotherParameterGivesAnotherRun) {
  const db::SessionId session = record({});
  constexpr std::size_t kAlpha = *contract::find_signal("left_alpha_rad");
  const std::vector<ParameterChange> tilted{{contract::param_index(contract::ParamName::left_alpha_zero_rad), 0.02}};
  double most_rad = 0;
  const auto report = rerun(*database_, session, kProgram, tilted, [&most_rad](const RerunStep& step) {
    most_rad = std::max(most_rad, static_cast<double>(std::abs(step.row[kAlpha] - step.recorded[kAlpha])) * contract::kSignals[kAlpha].lsb);
  });
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->steps, 400U);
  EXPECT_NEAR(most_rad, 0.02, 0.001);
}

}  // namespace
}  // namespace hoist::tool
