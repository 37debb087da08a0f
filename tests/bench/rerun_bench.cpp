// A recorded walk run again: how fast, and what its journal costs.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <stdexcept>
#include <vector>

#include "control/contract/shared_memory.hpp"
#include "control/publish/journal.hpp"
#include "control/publish/step_publisher.hpp"
#include "db/codec/journal_chunk.hpp"
#include "db/store/session_writer.hpp"
#include "deploy/tools/hoist/rerun.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/processes.hpp"
#include "tests/support/closed_loop.hpp"

namespace hoist::bench {
namespace {
constexpr double kWalk_s = 600;
constexpr const char* kProgram = "0.1.0+bench";

template <typename T>
T take(db::Result<T> result) {
  if (!result.ok()) throw std::runtime_error(result.error().message);
  return std::move(*result);
}
void must(const db::Status& status) {
  if (!status.ok()) throw std::runtime_error(status.error().message);
}

struct Recorded {
  std::vector<contract::JournalStep> steps;
  std::vector<contract::CoreImage> images;  // as stored: one a minute
  std::uint64_t frames = 0;
  db::SessionId session = 0;
};

// A figure of eight, stored as the recorder stores it.
Recorded record(db::Database& database) {
  tests::ClosedLoopOptions options;
  options.world.scenario = sim::find_scenario("figure-eight");
  tests::ClosedLoop loop(options);
  if (!loop.start(contract::Mode::user)) throw std::runtime_error("the walk did not start");
  db::SessionWriter writer = take(db::SessionWriter::create(database));
  db::SessionStart start;
  start.layout_hash = contract::layout_hash();
  start.core_version = kProgram;
  Recorded out;
  out.session = take(writer.begin(start));
  contract::CoreImage image;
  bool image_due = false;
  loop.on_inputs([&](const core::TickInputs& inputs) {
    image_due = out.steps.size() % publish::kImageSteps == 0;
    if (image_due) publish::take_image(loop.core(), out.steps.size(), inputs.tick, image);
  });
  loop.on_step([&](const core::TickInputs& inputs, const core::TickOutputs& outputs) {
    std::vector<contract::BusRecord> frames;
    for (const contract::CanFrame& frame : inputs.frames) {
      frames.push_back({inputs.time_ns, frame.id, frame.dlc, frame.flags, 0, 0, 0});
      std::memcpy(&frames.back().data, frame.data.data(), sizeof frames.back().data);
    }
    out.frames += frames.size();
    const contract::JournalStep step = publish::journal_of(inputs, out.steps.size(), publish::digest_of(outputs.record));
    std::vector<contract::JournalCommand> commands;
    for (const contract::Command& command : inputs.commands) commands.push_back({step.step, command});
    must(writer.append_ticks({&outputs.record, 1}));
    must(writer.append_bus(frames));
    must(writer.append_journal({&step, 1}, commands));
    if (image_due) must(writer.append_image(image));
    if (image_due && step.step % db::kImageTicks == 0) out.images.push_back(image);
    out.steps.push_back(step);
    if (out.steps.size() % 500 == 0) (void)take(writer.commit());
  });
  loop.run(kWalk_s);
  must(writer.end(db::CloseReason::finished, 0));
  return out;
}

// Bytes per step of the folded journal and its images. Virtual time knows neither lateness nor duration: both get the noise of a real loop
// (p50 60 us and 65 us, `hoist-bench --only loop`), because they are what costs most.
double journal_bytes(std::vector<contract::JournalStep> steps, const std::vector<contract::CoreImage>& images) {
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  const auto noise_ns = [&](double mean_ns, double sigma_ns) {
    return static_cast<std::uint64_t>(std::fabs(mean_ns + sigma_ns * normal(random)));
  };
  for (contract::JournalStep& step : steps) {
    const std::uint64_t late_ns = noise_ns(60e3, 15e3);
    step.time_ns += late_ns;
    step.wake_lateness_s = static_cast<float>(late_ns) * 1e-9F;
    step.previous_duration_s = static_cast<float>(noise_ns(65e3, 8e3)) * 1e-9F;
  }
  db::JournalEncoder encoder;
  db::Bytes blob;
  std::size_t bytes = 0;
  const std::span<const contract::JournalStep> all(steps);
  for (std::size_t at = 0; at < all.size(); at += db::kFoldedChunkSamples) {
    if (encoder.encode(all.subspan(at, std::min(db::kFoldedChunkSamples, all.size() - at)), {}, blob) != db::CodecError::none)
      throw std::runtime_error("the journal is not packed");
    bytes += blob.size();
  }
  for (const contract::CoreImage& image : images) bytes += db::pack_bytes(db::ByteView(image.memory).first(image.bytes)).size();
  return static_cast<double>(bytes) / static_cast<double>(steps.size());
}
}  // namespace

void measure_rerun(Report& report) {
  const TemporaryFolder folder;
  report.progress("recording ten minutes of walking with their journal");
  db::Database database = take(db::Database::open(folder.file("walk.db")));
  const Recorded recorded = record(database);
  report.progress("running them again");
  double least_s = 1e9;
  for (int round = 0; round < 3; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    const tool::Verification result = take(tool::verify_session(database, recorded.session, kProgram));
    least_s = std::min(least_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    if (!result.whole()) throw std::runtime_error("the walk run again is another one");
  }
  report.add({"rerun.speed", "recorded walk run again and compared", kWalk_s / least_s, "x", 0, "", {2000, Better::higher}});
  report.add({"rerun.journal",
              "bytes of journal and images kept per step",
              journal_bytes(recorded.steps, recorded.images),
              "B",
              0,
              "",
              {15},
              true,
              "noise of lateness and duration is made up"});
}

}  // namespace hoist::bench
