#include "server/jobs/jobs.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <exception>
#include <utility>

#include "server/record/reason.hpp"

namespace hoist::server {

namespace {
using Work = JobResult (*)(const JobTools&, const JobArguments&, const JobStep&);
constexpr std::array kWork{
#define HOIST_JOB(name, role, doc) Work{&job::name},
#include "server/contract/jobs.def"
#undef HOIST_JOB
};

// Told no more often than this: a check looks at thousands of pages a second.
constexpr double kTold = 0.01;

std::string damage_text(const db::IntegrityReport& report) {
  if (!report.structure.empty()) return report.structure.front();
  return report.sound() ? "" : std::to_string(report.damaged_blobs) + " stored blobs cannot be read";
}

// An exception ends the job that throws it, not the program.
JobResult attempt(JobKind kind, const JobTools& tools, const JobArguments& arguments, const JobStep& step) {
  try {
    return kWork[static_cast<std::size_t>(kind)](tools, arguments, step);
  } catch (const std::exception& thrown) {
    return db::Error{db::ErrorKind::internal, "the job broke off: " + std::string(thrown.what()), {}};
  }
}

// A choice of sessions is a value that is good in itself: what helps is another choice.
Reason job_reason(const db::Error& error) {
  if (error.kind == db::ErrorKind::bad_value && error.field == "sessions") return Reason::none_fits;
  if (error.kind == db::ErrorKind::bad_value && error.field == "reports") return Reason::too_many;
  return reason_of(error.kind);
}
}  // namespace

Jobs::Jobs(Options options) : options_(std::move(options)) {
  options_.tools.on_deletion = [this] { forget_recordings(); };
}
Jobs::~Jobs() { stop(); }

void Jobs::start() {
  thread_ = std::thread([this] { main(); });
}

void Jobs::stop() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void Jobs::main() {
  // Linux takes this for the calling thread only, and derives the priority of its disk accesses from it: recording and answers come first.
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), 19);
  while (true) {
    JobId id = 0;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return ending_ || next() != nullptr; });
      if (ending_) return;
      id = next()->info.id;
    }
    run(id);
  }
}

bool Jobs::work_here() {
  JobId id = 0;
  {
    const std::lock_guard lock(mutex_);
    const Entry* oldest = next();
    if (oldest == nullptr) return false;
    id = oldest->info.id;
  }
  run(id);
  return true;
}

Jobs::Entry* Jobs::next() {
  const auto waits = std::ranges::find_if(entries_, [](const Entry& e) { return e.info.state == JobState::waiting; });
  return holds_ > 0 || waits == entries_.end() ? nullptr : &*waits;
}

Jobs::Entry* Jobs::entry(JobId id) {
  const auto at = std::ranges::find_if(entries_, [id](const Entry& e) { return e.info.id == id; });
  return at == entries_.end() ? nullptr : &*at;
}

// Under the lock.
void Jobs::changed(Entry& entry) {
  entry.info.change = changes_.fetch_add(1, std::memory_order_release) + 1;
  if (entry.info.kind != JobKind::integrity_check) return;
  health_.progress = entry.info.progress;
  if (entry.info.state == JobState::running) health_.state = FileState::checking;
}

void Jobs::run(JobId id) {
  JobKind kind{};
  JobArguments arguments;
  {
    const std::lock_guard lock(mutex_);
    Entry* entry = this->entry(id);
    // Cancelled meanwhile.
    if (entry == nullptr || entry->info.state != JobState::waiting) return;
    entry->info.state = JobState::running;
    entry->deletions = deletions_;
    changed(*entry);
    kind = entry->info.kind;
    arguments = entry->arguments;
  }
  // The job's connection is closed before its end is told: the file may be set aside for it.
  end(id, attempt(kind, options_.tools, arguments, [this, id](double share) { return step(id, share); }));
}

bool Jobs::step(JobId id, double share) {
  std::optional<JobInfo> told;
  {
    const std::lock_guard lock(mutex_);
    Entry* entry = this->entry(id);
    if (share - entry->info.progress >= kTold) {
      entry->info.progress = share;
      changed(*entry);
    }
    if (options_.on_step) told = entry->info;
  }
  if (told) options_.on_step(*told);
  const std::lock_guard lock(mutex_);
  const Entry& running = *entry(id);
  return !ending_ && (holds_ == 0 || !gives_way_to_deletion(running.info.kind)) && !overtaken(running) && !running.cancelled;
}

// Under the lock. A session was deleted since the job began: what it has read may hold it.
bool Jobs::overtaken(const Entry& running) const { return running.deletions != deletions_ && keeps_recordings(running.info.kind); }

void Jobs::forget_recordings() {
  const std::lock_guard lock(mutex_);
  ++deletions_;
  for (Entry& e : entries_) {
    e.info.file.reset();
    if (e.info.kind == JobKind::recompute_metrics) e.info.result.reset();
  }
}

void Jobs::end(JobId id, JobResult result) {
  std::optional<db::IntegrityReport> damage;
  {
    const std::lock_guard lock(mutex_);
    Entry& ended = *entry(id);
    JobInfo& info = ended.info;
    const bool check = info.kind == JobKind::integrity_check;
    const bool stopped = (result && !*result) || overtaken(ended);
    if (stopped && !ended.cancelled && !ending_) {
      // A hold is in force, or a session was deleted: it starts again.
      info.state = JobState::waiting;
      info.progress = 0;
      changed(ended);
      return;
    }
    info.ended_utc_ms = options_.tools.utc_ns() / 1'000'000;
    if (!result) {
      info.state = JobState::failed;
      info.reason = job_reason(result.error());
      info.detail = result.error().message;
    } else if (stopped) {
      info.state = JobState::cancelled;
    } else {
      info.state = JobState::done;
      info.progress = 1;
      info.result = std::make_shared<const std::string>(std::move((*result)->result));
      info.file = std::move((*result)->file);
    }
    if (check) {
      health_ = {};
      health_.detail = info.detail;
    }
    if (info.state == JobState::done && (*result)->check) {
      const db::IntegrityReport& report = *(*result)->check;
      health_ = {.state = report.sound() ? FileState::sound : FileState::damaged,
                 .progress = 1,
                 .checked_utc_ms = info.ended_utc_ms,
                 .detail = damage_text(report),
                 .damaged_blobs = report.damaged_blobs,
                 .damaged_sessions = report.damaged_sessions};
      if (!report.structure.empty()) damage = report;
    }
    changed(ended);
    forget_oldest();
  }
  if (damage && options_.on_damage) options_.on_damage(*damage);
}

// Under the lock. The one that ended first goes first: nothing changes after its end.
void Jobs::forget_oldest() {
  std::vector<Entry*> with_file;
  for (Entry& e : entries_)
    if (e.info.file) with_file.push_back(&e);
  std::ranges::sort(with_file, std::ranges::greater{}, [](const Entry* e) { return e->info.change; });
  for (std::size_t i = kJobFiles; i < with_file.size(); ++i) with_file[i]->info.file.reset();
  const auto ended = [](const Entry& e) { return has_ended(e.info.state); };
  while (std::ranges::count_if(entries_, ended) > static_cast<int>(kJobsKept))
    entries_.erase(std::ranges::min_element(entries_, {}, [&](const Entry& e) { return ended(e) ? e.info.change : UINT64_MAX; }));
}

std::optional<JobId> Jobs::add(JobKind kind, JobArguments arguments, std::optional<db::Actor> actor) {
  JobId id = 0;
  {
    const std::lock_guard lock(mutex_);
    const auto waiting = std::ranges::count_if(entries_, [](const Entry& e) { return e.info.state == JobState::waiting; });
    if (ending_ || waiting >= static_cast<int>(kJobsWaiting)) return std::nullopt;
    Entry& entry = entries_.emplace_back();
    id = entry.info.id = ++last_id_;
    entry.info.kind = kind;
    entry.info.actor = std::move(actor);
    entry.info.asked_utc_ms = options_.tools.utc_ns() / 1'000'000;
    entry.arguments = std::move(arguments);
    changed(entry);
  }
  wake_.notify_one();
  return id;
}

std::optional<JobInfo> Jobs::find(JobId id) const {
  const std::lock_guard lock(mutex_);
  const auto at = std::ranges::find_if(entries_, [id](const Entry& e) { return e.info.id == id; });
  return at == entries_.end() ? std::nullopt : std::optional(at->info);
}

std::vector<JobInfo> Jobs::list() const {
  const std::lock_guard lock(mutex_);
  std::vector<JobInfo> all;
  for (const Entry& entry : entries_) all.push_back(entry.info);
  return all;
}

bool Jobs::cancel(JobId id) {
  const std::lock_guard lock(mutex_);
  Entry* entry = this->entry(id);
  if (entry == nullptr || has_ended(entry->info.state)) return false;
  entry->cancelled = true;
  if (entry->info.state == JobState::waiting) {
    entry->info.state = JobState::cancelled;
    entry->info.ended_utc_ms = options_.tools.utc_ns() / 1'000'000;
    changed(*entry);
    forget_oldest();
  }
  return true;
}

FileHealth Jobs::file_health() const {
  const std::lock_guard lock(mutex_);
  return health_;
}

std::shared_ptr<void> Jobs::hold() {
  {
    const std::lock_guard lock(mutex_);
    ++holds_;
  }
  return {this, [this](void*) {
            {
              const std::lock_guard lock(mutex_);
              --holds_;
            }
            wake_.notify_one();
          }};
}

}  // namespace hoist::server
