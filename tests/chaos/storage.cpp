#include "tests/chaos/storage.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "control/contract/program_version.hpp"
#include "db/store/database.hpp"
#include "db/store/integrity.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/session_writer.hpp"
#include "deploy/tools/hoist/rerun.hpp"

namespace hoist::chaos {
namespace {

constexpr const char* kFile = "/hoist.db";
constexpr std::int64_t kUtcStart_ns = 1'790'000'000'000'000'000;
constexpr std::uint64_t kPassTicks = 2;  // the recorder looks every 20 ms

}  // namespace

Storage::Storage(std::uint64_t seed) : disk_(static_cast<std::uint32_t>(seed ^ (seed >> 32))), utc_ns_(kUtcStart_ns) {}
Storage::~Storage() {
  // SQLite must close its files while their disk exists.
  recorder_.reset();
}

void Storage::core_started(std::uint64_t time_ns) {
  std::string error;
  life_ = time_ns;
  core_ = publish::CoreLink::create("", life_, static_cast<std::uint64_t>(utc_ns_), error);
  if (core_ == nullptr) std::abort();
  publisher_ = std::make_unique<publish::StepPublisher>(*core_);
  published_[life_].reserve(4096);
  attached_ = false;
}

void Storage::publish(const core::TickInputs& inputs, const core::TickOutputs& outputs) {
  const contract::TickRecord& record = outputs.record;
  publisher_->after(inputs, outputs, outputs.frames.size());
  published_[life_].push_back({record.tick, record.time_ns, record.x_m, record.left_alpha_rad});
}

void Storage::start_server() {
  if (recorder_ != nullptr) return;
  link_ = std::make_unique<publish::ServerLink>("");
  server::Recorder::Options options;
  options.file = kFile;
  options.version = "chaos";
  options.utc_ns = [this] { return utc_ns_ + static_cast<std::int64_t>(time_ns_); };
  options.steady_ns = [this] { return time_ns_; };
  options.vfs = tests::CrashDisk::vfs_name();
  // A file set aside was damaged, which must never happen.
  options.log = [this](const std::string& line) {
    if (line.find("damaged") != std::string::npos) damaged_.push_back("I9: " + line);
  };
  recorder_ = std::make_unique<server::Recorder>(*link_, std::move(options));
  attached_ = false;
  busy_until_ns_ = 0;
  recorder_->open_here();
}

void Storage::tick(std::uint64_t time_ns) {
  time_ns_ = time_ns;
  if (recorder_ == nullptr || hangs_ || ++ticks_ % kPassTicks != 0) return;
  if (!attached_ && core_ != nullptr) {
    std::string error;
    attached_ = link_->attach_directly(*core_, error);
  }
  if (time_ns_ < busy_until_ns_) return;
  const std::uint64_t before = disk_.operations();
  recorder_->pass_here();
  if (slow_s_ > 0) busy_until_ns_ = time_ns_ + static_cast<std::uint64_t>(slow_s_ * 1e9 * static_cast<double>(disk_.operations() - before));
  note_acknowledged();
}

void Storage::note_acknowledged() {
  const server::RecordingStatus status = recorder_->status();
  if (!status.session || !status.durable_tick) return;
  Acknowledged& known = acknowledged_.try_emplace(*status.session, Acknowledged{*status.durable_tick, *status.durable_tick}).first->second;
  known.last_tick = std::max(known.last_tick, *status.durable_tick);
}

void Storage::kill_server() {
  disk_.cut_now();
  recorder_.reset();
  link_.reset();
  disk_.restart_process();
}

void Storage::cut_power() {
  disk_.cut_now();
  recorder_.reset();
  link_.reset();
  disk_.restart();
}

std::vector<std::string> Storage::verify(bool killed, bool again) {
  disk_.fill(false);
  disk_.fail(0);
  if (killed) {
    cut_power();
  } else if (recorder_ != nullptr) {
    recorder_->pass_here();
    note_acknowledged();
    recorder_->finish_here();
    recorder_.reset();
  }
  std::vector<std::string> wrong = damaged_;
  db::OpenOptions options;
  options.vfs = tests::CrashDisk::vfs_name();
  options.utc_now_ns = utc_ns_;
  db::Result<db::Database> database = db::Database::open(kFile, options);
  if (!database) {
    wrong.push_back("I9: the database does not open: " + database.error().message);
    return wrong;
  }
  if (!database->report().set_aside.empty()) wrong.push_back("I9: the database is damaged: " + database->report().set_aside_reason);
  if (const auto checked = db::check_integrity(*database, [](double) { return true; }); !checked)
    wrong.push_back("I9: the database cannot be checked: " + checked.error().message);
  else if (!(*checked)->sound())
    wrong.push_back("I9: the database is damaged: " + ((*checked)->structure.empty() ? "a stored blob" : (*checked)->structure.front()));
  db::Result<db::SessionWriter> writer = db::SessionWriter::create(*database);
  if (!writer) wrong.push_back("I9: what was interrupted cannot be closed: " + writer.error().message);
  for (bool more = writer.ok(); more;) {
    const db::Result<bool> folded = writer->fold_piece();
    if (!folded) wrong.push_back("I9: what has ended cannot be folded: " + folded.error().message);
    more = folded && *folded;
  }
  for (const auto& [session, acknowledged] : acknowledged_) check_session(*database, session, acknowledged, wrong);
  if (again) run_again(*database, wrong);
  return wrong;
}

void Storage::run_again(db::Database& database, std::vector<std::string>& wrong) {
  const auto page = db::SessionReader(database).list({.limit = db::kMaxPage, .before = {}, .subject = {}});
  if (!page) return wrong.push_back("I15: the sessions cannot be listed: " + page.error().message);
  for (const db::SessionInfo& session : page->sessions) {
    if (session.sample_count == 0) continue;
    const auto result = tool::verify_session(database, session.id, contract::program_version());
    const std::string head = "I15: session " + std::to_string(session.id) + " ";
    // A crash or a slow disk may have kept the journal from the disk: said in words, and counted as not run.
    if (!result && result.error().kind == db::ErrorKind::wrong_state) {
      samples_not_run_ += session.sample_count;
      continue;
    }
    if (!result) {
      wrong.push_back(head + "cannot be run again: " + result.error().message);
      continue;
    }
    if (result->first)
      wrong.push_back(head + "run again is another one from tick " + std::to_string(result->first->tick) + " on, in " +
                      (result->first->signal.empty() ? "the last bits" : result->first->signal));
    // What cannot be run is told.
    if (result->run.samples_run != result->run.samples && result->run.not_run.empty())
      wrong.push_back(head + "has samples that were not run again, and nothing says why");
    samples_again_ += result->run.samples_run - std::min(result->different, result->run.samples_run);
    samples_not_run_ += result->run.samples - result->run.samples_run;
  }
}

void Storage::check_session(db::Database& database, std::int64_t session, const Acknowledged& acknowledged,
                            std::vector<std::string>& wrong) {
  const auto bad = [&](const std::string& what) { wrong.push_back("I9: session " + std::to_string(session) + ": " + what); };
  const db::SessionReader reader(database);
  const auto info = reader.get(session);
  if (!info) return bad("gone, though it was acknowledged");
  const auto published = published_.find(info->core_start_time_ns);
  if (published == published_.end()) return bad("of a core that never ran");
  const std::vector<std::string> names{"x_m", "left_alpha_rad"};
  const auto columns = reader.read_columns(session, names);
  const auto gaps = reader.gaps(session);
  if (!columns || !gaps) return bad("cannot be read");
  const auto in_gap = [&](std::uint64_t tick) {
    return std::any_of(gaps->begin(), gaps->end(),
                       [tick](const db::Gap& gap) { return gap.stream == "ticks" && gap.from_tick <= tick && tick <= gap.to_tick; });
  };
  const std::size_t count = columns->tick.size();
  if (count == 0 || columns->tick.back() < acknowledged.last_tick) {
    if (count == 0 || !in_gap(acknowledged.last_tick))
      return bad("lost ticks up to " + std::to_string(acknowledged.last_tick) + ", which were acknowledged");
  }
  // The recording begins with the tick that began it.
  const auto begin = std::find_if(published->second.begin(), published->second.end(),
                                  [&info](const Kept& kept) { return kept.time_ns == info->start_time_ns; });
  if (begin == published->second.end() || begin->tick > acknowledged.first_tick)
    return bad("begins behind tick " + std::to_string(acknowledged.first_tick) + ", which was acknowledged");
  if (count > 0 && columns->tick.front() < begin->tick) return bad("a tick before its begin");
  for (std::uint64_t missing = begin->tick; count > 0 && missing < columns->tick.front(); ++missing)
    if (!in_gap(missing)) return bad("tick " + std::to_string(missing) + " at its begin is missing and no gap says so");
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t tick = columns->tick[i];
    if (i > 0 && (tick <= columns->tick[i - 1] || columns->time_s[i] <= columns->time_s[i - 1])) return bad("time does not rise");
    if (i > 0)
      for (std::uint64_t missing = columns->tick[i - 1] + 1; missing < tick; ++missing)
        if (!in_gap(missing)) return bad("tick " + std::to_string(missing) + " is missing and no gap says so");
    // Rising, with holes where the core was held.
    const auto found = std::ranges::lower_bound(published->second, tick, {}, &Kept::tick);
    if (found == published->second.end() || found->tick != tick) return bad("a tick that never was");
    const Kept& kept = *found;
    // As rounded by the stored column.
    const double x_lsb = columns->info[0].lsb, alpha_lsb = columns->info[1].lsb;
    if (std::fabs(columns->values[0][i] - static_cast<double>(kept.x_m)) > x_lsb ||
        std::fabs(columns->values[1][i] - static_cast<double>(kept.alpha_rad)) > alpha_lsb)
      return bad("tick " + std::to_string(tick) + " holds something else than was measured");
  }
  samples_ += count;
}

}  // namespace hoist::chaos
