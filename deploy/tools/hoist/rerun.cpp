#include "deploy/tools/hoist/rerun.hpp"

#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstddef>

#include "control/contract/param_set.hpp"
#include "control/contract/shared_memory.hpp"
#include "control/core/serve/param_keeper.hpp"
#include "control/core/tick.hpp"
#include "control/publish/journal.hpp"
#include "db/store/frame_chunks.hpp"
#include "db/store/session_writer.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::tool {
namespace {

using contract::BusRecord;
using contract::CanFrame;
using contract::Command;
using contract::CoreImage;
using contract::JournalStep;
using contract::kSignalCount;
using contract::TickRecord;

constexpr std::size_t kPieceSteps = 3000;
constexpr std::size_t kTick = *contract::find_signal("tick");
/// A piece takes some hundredths of a second; damaged memory of the core may never come to an end.
constexpr rlim_t kPieceLimit_s = 10;

/// Steps in a row with all that they were given; frames and commands lie one after the other.
struct Piece {
  std::vector<JournalStep> steps;
  std::vector<CanFrame> frames;
  std::vector<Command> commands;
  void clear() {
    steps.clear();
    frames.clear();
    commands.clear();
  }
};

/// From here on this process can only compute and end: any other system call kills it.
[[nodiscard]] bool give_up_system_calls() {
#ifdef HOIST_SANITIZED  // the sanitizers' libraries make system calls of their own
  return true;
#else
  std::array filter{
      sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit, 0, 1),
      sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
      sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
  };
  const sock_fprog program{static_cast<unsigned short>(filter.size()), filter.data()};
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1UL, 0UL, 0UL, 0UL) == 0 && ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
#endif
}

/// The core in a child process. An image comes from a file and may hold any bytes, also such as no core ever has. So the core runs where it can
/// do nothing but compute: no system call is left to it but to end, and its time is bounded. Its memory and the records lie in shared memory.
class ConfinedCore {
 public:
  ConfinedCore() {
    void* at = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (at == MAP_FAILED) throw std::bad_alloc();
    shared_ = new (at) Shared;
  }
  ~ConfinedCore() { ::munmap(static_cast<void*>(shared_), sizeof(Shared)); }
  ConfinedCore(const ConfinedCore&) = delete;
  ConfinedCore& operator=(const ConfinedCore&) = delete;

  /// Begins with this memory. False when it is not the size of the core's.
  [[nodiscard]] bool load(const CoreImage& image) { return publish::put_image(image, shared_->core); }

  /// Exit codes of the child. Any other one, or death by a signal, is `damaged`; sanitizers end with 1.
  enum class End : std::uint8_t { done = 0, refused_parameters = 100, not_confined = 101, damaged = 102 };
  /// Goes on with these steps (at most kPieceSteps), after setting the changed parameters.
  End run(const Piece& piece, std::span<const ParameterChange> changes) {
    const pid_t child = ::fork();
    if (child < 0) return End::not_confined;
    if (child == 0) compute(piece, changes);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (!WIFEXITED(status)) return End::damaged;
    const auto end_code = static_cast<End>(WEXITSTATUS(status));
    const bool own = end_code == End::done || end_code == End::refused_parameters || end_code == End::not_confined;
    return own ? end_code : End::damaged;
  }
  [[nodiscard]] const TickRecord& record(std::size_t i) const { return shared_->records[i]; }

 private:
  struct Shared {
    core::CoreState core;
    std::array<TickRecord, kPieceSteps> records;
  };

  [[noreturn]] void compute(const Piece& piece, std::span<const ParameterChange> changes) {
    const rlimit limit{kPieceLimit_s, kPieceLimit_s};
    ::setrlimit(RLIMIT_CPU, &limit);
    const rlimit no_dump{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_dump);
    if (!give_up_system_calls()) end(End::not_confined);
    bool good = true;
    if (!changes.empty()) {
      contract::Params params = shared_->core.params;
      for (const auto& [index, value] : changes) contract::set_param_unchecked(params, index, value);
      good = contract::check_param_set(params) == nullptr;
      if (good) core::install_params(shared_->core, params);
    }
    std::span<const CanFrame> frames(piece.frames);
    std::span<const Command> commands(piece.commands);
    for (std::size_t i = 0; good && i < piece.steps.size(); ++i) {
      const JournalStep& step = piece.steps[i];
      core::tick(shared_->core, publish::inputs_of(step, frames.first(step.frames), commands.first(step.commands)), core::kTick_s,
                 outputs_);
      frames = frames.subspan(step.frames);
      commands = commands.subspan(step.commands);
      shared_->records[i] = outputs_.record;
    }
    end(good ? End::done : End::refused_parameters);
  }
  /// Not _exit, whose system call is another one (it ends all threads).
  [[noreturn]] static void end(End how) {
    ::syscall(SYS_exit, static_cast<int>(how));
    __builtin_unreachable();
  }

  Shared* shared_;
  core::TickOutputs outputs_;
};

db::Error of_session(db::ErrorKind kind, db::SessionId session, const std::string& what) {
  return {kind, "session " + std::to_string(session) + " " + what, {}};
}

/// The received frames of a session, step by step.
class FrameCursor {
 public:
  FrameCursor(db::Database& database, db::SessionId session) : database_(database), reader_(database), session_(session) {}

  /// Appends those that the step of this time was given. False when they cannot be read, or are not as many.
  bool take(const JournalStep& step, std::vector<CanFrame>& out) {
    const std::size_t before = out.size();
    for (; const BusRecord* frame = current(); ++at_) {
      if (frame->time_ns > step.time_ns) break;
      if (frame->time_ns < step.time_ns || frame->sent != 0) continue;
      out.push_back({frame->id, frame->dlc, frame->flags, std::bit_cast<decltype(CanFrame::data)>(frame->data)});
    }
    if (out.size() - before == step.frames) return true;
    out.resize(before);
    return false;
  }

 private:
  const BusRecord* current() {
    if (at_ == frames_.size() && !ended_) {
      next_ += frames_.size();
      at_ = 0;
      auto chunk = reader_.bus_chunk(session_, next_);
      // A damaged chunk costs its own frames: the steps that were given those cannot be run, later ones can.
      for (auto end = db::bus_chunk_end(database_, session_, next_); !chunk && end && *end > next_;
           end = db::bus_chunk_end(database_, session_, next_)) {
        next_ = *end;
        chunk = reader_.bus_chunk(session_, next_);
      }
      frames_ = chunk ? std::move(*chunk) : std::vector<BusRecord>{};
      ended_ = frames_.empty();
    }
    return at_ < frames_.size() ? &frames_[at_] : nullptr;
  }

  db::Database& database_;
  db::SessionReader reader_;
  db::SessionId session_;
  std::vector<BusRecord> frames_;
  std::uint64_t next_ = 0;
  std::size_t at_ = 0;
  bool ended_ = false;
};

/// The stored samples, tick by tick.
class SampleCursor {
 public:
  SampleCursor(const db::SessionReader& reader, db::SessionId session) : reader_(reader), session_(session) {}

  /// Empty when there is none of this tick. Ticks are asked for in rising order.
  std::span<const std::int64_t> take(std::uint64_t tick) {
    const auto wanted = static_cast<std::int64_t>(tick);
    if (chunk_.values.empty() || chunk_.values[kTick].back() < wanted) {
      auto chunk = reader_.samples(session_, tick);
      chunk_ = chunk && chunk->values.size() == kSignalCount ? std::move(*chunk) : db::StoredSamples{};
      at_ = 0;
    }
    if (chunk_.values.empty()) return {};
    const std::vector<std::int64_t>& ticks = chunk_.values[kTick];
    while (at_ < ticks.size() && ticks[at_] < wanted) ++at_;
    if (at_ == ticks.size() || ticks[at_] != wanted) return {};
    for (std::size_t c = 0; c < kSignalCount; ++c) row_[c] = chunk_.values[c][at_];
    return row_;
  }

 private:
  const db::SessionReader& reader_;
  db::SessionId session_;
  db::StoredSamples chunk_;
  std::size_t at_ = 0;
  std::array<std::int64_t, kSignalCount> row_{};
};

class Rerun {
 public:
  Rerun(db::Database& database, db::SessionId session, std::span<const ParameterChange> changes,
        const std::function<void(const RerunStep&)>& see)
      : reader_(database), session_(session), changes_(changes), see_(see), frames_(database, session), samples_(reader_, session) {}

  db::Result<RerunReport> run(const std::vector<db::JournalExtent>& extents, std::vector<db::ImagePlace> images) {
    images_ = std::move(images);
    const auto first = sample_range(0);
    if (!first) return std::move(report_);  // nothing to compare with
    last_tick_ = first->first - 1;          // wraps at tick 0, and back with each + 1
    for (const db::JournalExtent& extent : extents) {
      const auto run = reader_.journal_run(session_, extent.first_step);
      if (!run) {
        hole(last_tick_ + 1, last_tick_ + extent.steps, run.error().message);
        continue;
      }
      std::span<const contract::JournalCommand> commands(run->commands);
      for (const JournalStep& step : run->steps) {
        if (db::Status taken = take(step, commands); !taken) return taken.error();
        last_tick_ = step.tick;
      }
      if (db::Status flushed = flush(); !flushed) return flushed.error();
    }
    // Samples behind the end of the journal.
    for (auto more = sample_range(last_tick_ + 1); more && more->second > last_tick_; more = sample_range(last_tick_ + 1)) {
      hole(last_tick_ + 1, more->second, kNoJournal);
      last_tick_ = more->second;
    }
    return std::move(report_);
  }

 private:
  static constexpr const char* kNoJournal = "their journal is missing";

  /// First and last tick of the stored chunk that holds this tick or comes next.
  std::optional<std::pair<std::uint64_t, std::uint64_t>> sample_range(std::uint64_t tick) const {
    const auto chunk = reader_.samples(session_, tick);
    if (!chunk || chunk->values.size() != kSignalCount || chunk->values[kTick].empty()) return std::nullopt;
    return std::pair(static_cast<std::uint64_t>(chunk->values[kTick].front()), static_cast<std::uint64_t>(chunk->values[kTick].back()));
  }

  /// One step joins the piece, or is noted as one that cannot be run.
  db::Status take(const JournalStep& step, std::span<const contract::JournalCommand>& commands) {
    // Before the first step nothing is missing unless a sample says so.
    if (next_ ? *next_ != step.step : step.tick > last_tick_ + 1) {
      if (db::Status flushed = flush(); !flushed) return flushed;
      hole(last_tick_ + 1, std::max(last_tick_ + 1, step.tick - 1), kNoJournal);
    }
    next_ = step.step + 1;
    load_image(step);
    while (!commands.empty() && commands.front().step < step.step) commands = commands.subspan(1);
    const std::size_t given = piece_.commands.size();
    for (; !commands.empty() && commands.front().step == step.step; commands = commands.subspan(1))
      piece_.commands.push_back(commands.front().command);
    const bool frames = frames_.take(step, piece_.frames);
    if (!running_ || !frames || piece_.commands.size() - given != step.commands) {
      if (frames) piece_.frames.resize(piece_.frames.size() - step.frames);
      piece_.commands.resize(given);
      if (db::Status flushed = flush(); !flushed) return flushed;
      hole(step.tick, step.tick,
           !running_ ? "no image of the core before them"
           : frames  ? "their commands are missing"
                     : "their frames are missing");
      return {};
    }
    piece_.steps.push_back(step);
    return piece_.steps.size() == kPieceSteps ? flush() : db::Status{};
  }

  /// Begins with the image that stands at this step, if there is one and nothing runs. A core that runs goes on with its own memory: a
  /// difference that does not show yet is carried on until it does.
  void load_image(const JournalStep& step) {
    while (next_image_ < images_.size() && images_[next_image_].step < step.step) ++next_image_;
    if (running_ || next_image_ == images_.size() || images_[next_image_].step != step.step) return;
    const auto image = reader_.image(session_, step.step);
    if (image && core_.load(*image))
      running_ = changed_ = true;
    else
      hole(step.tick, step.tick, image ? "the image of the core has another size" : image.error().message);
  }

  /// Runs what waits.
  db::Status flush() {
    if (piece_.steps.empty()) return {};
    const auto end = core_.run(piece_, changed_ ? changes_ : std::span<const ParameterChange>{});
    changed_ = false;
    if (end == ConfinedCore::End::refused_parameters)
      return db::Error{db::ErrorKind::bad_value, "with these values the parameters contradict each other", "set"};
    if (end == ConfinedCore::End::not_confined)
      return db::Error{
          db::ErrorKind::io, "no child process without system calls (fork, seccomp) could be made, and the core runs in no other", {}};
    if (end == ConfinedCore::End::damaged) {
      const std::uint64_t from = piece_.steps.front().tick, to = piece_.steps.back().tick;
      piece_.clear();
      hole(from, to, "the stored image of the core is damaged: the core could not go on with it");
      return {};
    }
    report_.steps += piece_.steps.size();
    std::array<std::int64_t, kSignalCount> row{};
    for (std::size_t i = 0; i < piece_.steps.size(); ++i) {
      const TickRecord& record = core_.record(i);
      const bool fits = db::stored_row(record, row);
      const std::span<const std::int64_t> recorded = samples_.take(record.tick);
      if (!recorded.empty()) ++report_.samples_run;
      see_({.tick = record.tick,
            .time_ns = record.time_ns,
            .same_bits = publish::digest_of(record) == piece_.steps[i].record_digest,
            .row = fits ? std::span<const std::int64_t>(row) : std::span<const std::int64_t>{},
            .recorded = recorded});
    }
    piece_.clear();
    return {};
  }

  void hole(std::uint64_t from_tick, std::uint64_t to_tick, const std::string& reason) {
    running_ = false;
    std::vector<NotRun>& holes = report_.not_run;
    // Until the next image nothing can be run: that belongs to the hole before.
    const bool goes_on = !holes.empty() && from_tick <= holes.back().to_tick + 1;
    if (goes_on)
      holes.back().to_tick = std::max(holes.back().to_tick, to_tick);
    else
      holes.push_back({from_tick, to_tick, reason});
  }

  db::SessionReader reader_;
  db::SessionId session_;
  std::span<const ParameterChange> changes_;
  const std::function<void(const RerunStep&)>& see_;
  FrameCursor frames_;
  SampleCursor samples_;
  std::vector<db::ImagePlace> images_;
  std::size_t next_image_ = 0;
  ConfinedCore core_;
  Piece piece_;
  RerunReport report_;
  std::optional<std::uint64_t> next_;
  std::uint64_t last_tick_ = 0;
  bool running_ = false;  // core_ holds the memory before the step that comes next
  bool changed_ = false;  // the parameters are to be set before the next step
};

db::Result<RerunReport> rerun_as_it_is(db::Database& database, db::SessionId session, std::string_view program,
                                       std::span<const ParameterChange> changes, const std::function<void(const RerunStep&)>& see) {
  const db::SessionReader reader(database);
  const auto info = reader.get(session);
  if (!info) return info.error();
  const auto extents = reader.journal(session);
  if (!extents) return extents.error();
  auto images = reader.images(session);
  if (!images) return images.error();
  if (extents->empty() || images->empty())
    return of_session(db::ErrorKind::wrong_state, session, "was recorded without a journal: it cannot be run again");
  if (info->core_version != program || info->layout_hash != contract::layout_hash())
    return of_session(db::ErrorKind::wrong_state, session,
                      "was recorded with hoist-control " + info->core_version.value_or("of an unknown version") +
                          "; only a hoist of the same build can run it again, and this one is " + std::string(program));
  auto report = Rerun(database, session, changes, see).run(*extents, std::move(*images));
  if (report) report->samples = info->sample_count;
  return report;
}

}  // namespace

db::Result<RerunReport> rerun(db::Database& database, db::SessionId session, std::string_view program,
                              std::span<const ParameterChange> changes, const std::function<void(const RerunStep&)>& see) {
  return db::guarded([&]() -> db::Result<RerunReport> {
    // One state for all reads: a session that is folded meanwhile has its pieces replaced.
    db::Transaction snapshot(database.handle(), db::Transaction::Kind::read);
    return rerun_as_it_is(database, session, program, changes, see);
  });
}

db::Result<Verification> verify_session(db::Database& database, db::SessionId session, std::string_view program) {
  Verification result;
  auto run = rerun(database, session, program, {}, [&result](const RerunStep& step) {
    const bool same_row = step.recorded.empty() || std::ranges::equal(step.row, step.recorded);
    if (step.same_bits && same_row) return;
    ++result.different;
    if (result.first) return;
    Difference& first = result.first.emplace(Difference{.tick = step.tick, .time_ns = step.time_ns, .signal = {}});
    for (std::size_t c = 0; c < std::min(step.row.size(), step.recorded.size()); ++c) {
      if (step.row[c] == step.recorded[c]) continue;
      first.signal = contract::kSignals[c].name;
      first.recorded = static_cast<double>(step.recorded[c]) * contract::kSignals[c].lsb;
      first.again = static_cast<double>(step.row[c]) * contract::kSignals[c].lsb;
      break;
    }
  });
  if (!run) return run.error();
  result.run = std::move(*run);
  return result;
}

}  // namespace hoist::tool
