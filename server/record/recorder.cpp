#include "server/record/recorder.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "control/contract/faults.hpp"
#include "db/store/backup.hpp"
#include "db/store/database.hpp"
#include "db/store/deletion.hpp"
#include "db/store/patient_code.hpp"
#include "db/store/session_checks.hpp"
#include "db/store/session_writer.hpp"
#include "server/record/journal_feed.hpp"

namespace hoist::server {

using contract::BusRecord;
using contract::Event;
using contract::TickRecord;

namespace {
constexpr auto kPass = std::chrono::milliseconds(50);
// While the disk refuses, asked again this often.
constexpr std::uint64_t kRetry_ns = 1'000'000'000;
// Whole exports that are kept for further parts: the least used goes first, and each some time after its last use, or with its session.
constexpr std::size_t kSpooledKept = 4;
constexpr std::uint64_t kSpoolKept_ns = 600'000'000'000;
constexpr std::uint64_t kCommit_ns = 400'000'000;
// Pieces of folding follow each other no closer, however often a job brings a pass forward.
constexpr std::uint64_t kFold_ns = 50'000'000;
// Free on the disk of the recordings: below kLowSpace_bytes a notice stands until kEnoughSpace_bytes are, below kSessionSpace_bytes no session
// begins; one that runs goes on (H24).
constexpr std::uint64_t kLowSpace_bytes = 200'000'000, kEnoughSpace_bytes = 220'000'000, kSessionSpace_bytes = 50'000'000;
// The wall clock is compared with the steady one this often; a jump of more than this is noted in the recording.
constexpr std::uint64_t kAnchor_ns = 1'000'000'000;
constexpr std::int64_t kJump_ns = 50'000'000;
// Of what came just before a recording began: what belongs to its first step may have been read before the step itself.
constexpr std::size_t kKeptEvents = 64, kKeptFrames = 2560;
constexpr std::uint64_t kTick_ns = 10'000'000;
// A session that goes on from another waits this long for the parameters in force, which come with the network's next look at the core.
constexpr std::uint64_t kParametersWait_ns = 500'000'000;
constexpr std::size_t kReadTicks = 256, kReadEvents = 256, kReadFrames = 2048;
// One pass reads at most this often, so that jobs get their turn.
constexpr int kReadsPerPass = 16;

bool moving_mode(std::uint32_t mode) { return mode < contract::kModes.size() && contract::kModes[mode].moving; }
bool moving(const TickRecord& record) { return moving_mode(record.mode); }
bool begins_motion(const Event& event) {
  return event.kind == contract::EventKind::mode_changed && moving_mode(event.code) && !moving_mode(event.item);
}
// Neither at the start nor in a calibration the harness holds the patient who is chosen.
bool may_hold_patient(const TickRecord& record) {
  const auto mode = static_cast<contract::Mode>(record.mode);
  return mode != contract::Mode::init && mode != contract::Mode::calibrate;
}
// The newest values that belong to no session yet, of one life of the core: another life counts its steps anew.
template <typename T, std::size_t Most>
class Kept {
 public:
  void add(std::uint64_t life, std::span<const T> more) {
    if (more.empty()) return;
    if (std::exchange(life_, life) != life) values_.clear();
    values_.insert(values_.end(), more.begin(), more.end());
    while (values_.size() > Most) values_.pop_front();
  }
  [[nodiscard]] const std::deque<T>& of(std::uint64_t life) const { return life == life_ ? values_ : kNone; }
  void clear() { values_.clear(); }

 private:
  inline static const std::deque<T> kNone{};
  std::uint64_t life_ = 0;
  std::deque<T> values_;
};
// What a session is: a walk, or the time in standby before and after it while a patient is chosen, or begun by a person.
enum class Kind : std::uint8_t { walk, standby, by_hand };
}  // namespace

// Everything that only the recorder's thread touches.
class Recorder::Work final : public Records {
 public:
  Work(Recorder& owner, const publish::ServerLink& link)
      : owner_(owner),
        ticks_(link),
        events_(link),
        bus_(link),
        journal_(link),
        core_(link.shared_state()),
        old_(std::in_place, link),
        tick_buffer_(kReadTicks),
        event_buffer_(kReadEvents),
        bus_buffer_(kReadFrames) {}

  void hold_readers() {
    if (owner_.options_.setting_up) readers_held_ = owner_.options_.setting_up();
  }
  void open() {
    open_file();
    readers_held_.reset();
  }
  void open_file() {
    now_ns_ = owner_.options_.steady_ns();
    if (!writer_ && !open_writer()) return;
    if (!reading_) {
      auto reading = db::Database::attach(owner_.options_.file, {.vfs = owner_.options_.vfs});
      if (!reading) return fail(reading.error());
      reading_.emplace(std::move(*reading));
    }
    error_.clear();
    foreign_.clear();
    if (std::exchange(opened_, true)) return;
    if (owner_.options_.opened) owner_.options_.opened();
  }

  db::Status claim() {
    auto taken = db::WriteLock::take(owner_.options_.file);
    if (!taken) return taken.error();
    lock_ = std::move(*taken);
    return {};
  }

  bool open_writer() {
    // One that opened without a writer still holds the lock.
    writing_.reset();
    opened_ = false;
    auto writing = db::Database::open(
        owner_.options_.file, {.utc_now_ns = owner_.options_.utc_ns(), .vfs = owner_.options_.vfs, .lock = lock_, .damage = damage_});
    if (!writing) {
      fail(writing.error());
      return false;
    }
    damage_.clear();
    writing_.emplace(std::move(*writing));
    const db::OpenReport& report = writing_->report();
    if (!report.set_aside.empty())
      log("The database was damaged (" + report.set_aside_reason + "); it was set aside as " + report.set_aside.string() +
          " and a new one was begun.");
    erase_deleted();
    if (report.lost) log("Recordings are missing in the database: " + lost_text(*report.lost));
    notices_.clear();
    if (!report.kept_aside.empty()) notices_.push_back({NoticeName::recordings_set_aside, report.kept_aside.string()});
    if (report.lost) notices_.push_back({NoticeName::recordings_lost, lost_text(*report.lost)});
    auto writer = db::SessionWriter::create(*writing_);
    if (!writer) {
      fail(writer.error());
      // Nothing can be recorded into it, so the next try does without it.
      if (writer.error().kind == db::ErrorKind::corrupt) damage_ = writer.error().message;
      return false;
    }
    writer_.emplace(std::move(*writer));
    writer_->set_actor_of(owner_.options_.actor_of);
    return true;
  }

  // What a run that was killed had deleted and not yet overwritten.
  void erase_deleted() {
    auto more = db::erase_piece(*writing_);
    while (more && *more) more = db::erase_piece(*writing_);
    if (!more) log("recording: a deleted session is not overwritten yet: " + more.error().message);
  }

  // Closes the damaged file; the next open() sets it aside.
  void leave_damaged_file() {
    std::string file_id, damage;
    {
      const std::lock_guard lock(owner_.mutex_);
      if (owner_.damage_.empty() || !writing_) return;
      const bool stores = session_open() && kind_ != Kind::standby && (error_.empty() || error_kind_ != db::ErrorKind::corrupt);
      if (stores) return;
      file_id = std::exchange(owner_.damaged_file_, {});
      damage = std::exchange(owner_.damage_, {});
    }
    // Of a file that has been replaced since it was checked.
    if (const std::string own = writing_->file_id(); !own.empty() && own != file_id) return;
    if (session_open() && kind_ == Kind::standby) (void)try_end(db::CloseReason::finished);
    hold_readers();
    close_file();
    end_again_.reset();
    damage_ = std::move(damage);
    open();
  }

  void pass() {
    now_ns_ = owner_.options_.steady_ns();
    if (!writer_ || !reading_) {
      if (now_ns_ - tried_ns_ >= kRetry_ns) {
        tried_ns_ = now_ns_;
        open();
      }
    }
    leave_damaged_file();
    look_at_space();
    follow_chosen();
    for (int i = 0; i < kReadsPerPass && !end_again_ && join(); ++i) {
      const bool more = read_ticks();
      if (end_again_) break;
      // Which session an event or a frame is part of shows only once its step has been read.
      if (more) continue;
      const std::size_t events = read_events();
      const std::size_t frames = read_bus();
      read_journal();
      if (events < kReadEvents && frames < kReadFrames) break;
    }
    end_with_core();
    if (session_open() && now_ns_ - committed_ns_ >= kCommit_ns) commit();
    fold();
    drop_spooled();
    tell();
  }

  // Also those of a session that another connection has deleted.
  void drop_spooled() {
    std::erase_if(spooled_, [&](const Spooled& s) {
      if (now_ns_ - s.used_ns > kSpoolKept_ns) return true;
      const auto there = reading_ ? db::SessionReader(*reading_).has(s.session) : db::Result<bool>(true);
      return there && !*there;
    });
  }

  // One piece, however long the sessions are that have ended: what the core publishes meanwhile must not be overwritten unread.
  void fold() {
    if (!writer_ || now_ns_ - folded_ns_ < kFold_ns) return;
    folded_ns_ = now_ns_;
    if (const auto more = writer_->fold_piece(); !more) log("recording: a session is not folded yet: " + more.error().message);
  }

  // A core that died in motion makes no step that would end the session. Its last step says nothing of the hoist any more.
  void end_with_core() {
    if (owner_.attached_.load(std::memory_order_relaxed) || !last_) return;
    if (static_cast<double>(now_ns_ - heard_ns_) * 1e-9 < kAfterStop_s) return;
    if (session_open() && !end_again_) end(db::CloseReason::core_restarted);
    last_.reset();
  }

  // Before any job that comes after the choice.
  void follow_chosen() {
    {
      const std::lock_guard lock(owner_.mutex_);
      chosen_ = owner_.subject_;
    }
    if (waits_ && chosen_ != waits_for_) drop_waiting();
    if (session_open() && kind_ == Kind::standby && chosen_ != standby_for_ && !end_again_) end(db::CloseReason::finished);
  }

  // The patients of another file have other numbers.
  void forget_chosen() {
    const std::lock_guard lock(owner_.mutex_);
    ++owner_.file_;
    owner_.subject_.reset();
    chosen_.reset();
  }

  void finish() {
    pass();
    if (session_open()) end(end_again_.value_or(db::CloseReason::server_stopped));
    tell();
    // Here and not in the destructor, which runs on another thread.
    close_file();
  }

  void close_file() {
    exports_.clear();
    spooling_.clear();
    writer_.reset();
    reading_.reset();
    writing_.reset();
  }

  void close_exports(const std::vector<ExportId>& ids) {
    for (const ExportId id : ids) {
      exports_.erase(id);
      spooling_.erase(id);
    }
  }

  // ---- Records
  db::Database* database() override { return reading_ ? &*reading_ : nullptr; }
  std::string why() override { return error_; }
  bool late() const override { return late_; }
  void run(const Waiting& waiting) {
    late_ = owner_.options_.steady_ns() - waiting.since_ns > kJobWait_ns;
    waiting.job(*this);
  }
  RecordingStatus status() override {
    tell();
    return owner_.status();
  }
  db::Status begin_manual(std::optional<std::string> subject, std::string note) override {
    if (!writer_) return db::Error{db::ErrorKind::io, error_, ""};
    if (session_open() && kind_ == Kind::by_hand) return db::Error{db::ErrorKind::wrong_state, "A recording is already running.", ""};
    // Before anything ends for it: a mistyped code is its writer's matter, not the recording's.
    if (subject) {
      auto code = db::code_to_record(writing_->handle(), *subject, "subject");
      if (!code) return code.error();
      subject = std::move(*code);
    }
    if (db::Status checked = db::check_note(note); !checked) return checked;
    if (!last_) return db::Error{db::ErrorKind::wrong_state, "The control core is not connected: there is nothing to record.", ""};
    if (db::Status room = room_for_session(); !room) return room;
    // Not end(): what is refused here must not end the session at a later commit.
    if (session_open())
      if (db::Status ended = try_end(db::CloseReason::finished); !ended) return ended;
    return begin(*last_, std::move(subject), std::move(note), Kind::by_hand);
  }
  db::Status end_manual() override {
    if (!session_open()) return db::Error{db::ErrorKind::wrong_state, "Nothing is being recorded.", ""};
    if (last_ && moving(*last_)) return db::Error{db::ErrorKind::wrong_state, "The recording goes on while the hoist moves.", ""};
    if (kind_ == Kind::standby) return db::Error{db::ErrorKind::wrong_state, "Standby is recorded as long as a patient is chosen.", ""};
    return try_end(db::CloseReason::finished);
  }
  db::Status marker(db::SessionId session, const MarkerWish& wish, std::optional<db::Actor> actor) override {
    if (!session_open() || writer_->session() != session)
      return db::Error{db::ErrorKind::wrong_state, "This session is not being recorded.", ""};
    return writer_->store_marker(last_tick_, owner_.options_.utc_ns(), wish.text, std::move(actor), wish.kind);
  }
  db::Result<std::filesystem::path> replace_file(const std::filesystem::path& prepared) override {
    if ((session_open() && kind_ != Kind::standby) || (last_ && moving(*last_)))
      return db::Error{db::ErrorKind::wrong_state, "A session is being recorded: restore after its end.", ""};
    if (session_open())
      if (db::Status ended = try_end(db::CloseReason::finished); !ended) return ended.error();
    close_file();
    auto aside = db::finish_restore(prepared, owner_.options_.file, owner_.options_.utc_ns());
    if (aside) {
      log("The recordings were replaced by a backup; those before are in " + aside->string() + ".");
      forget_chosen();
    }
    open();
    return aside;
  }
  db::Result<OpenedExport> open_export(db::SessionId session, const db::ExportOptions& options) override {
    if (!reading_) return db::Error{db::ErrorKind::io, error_, ""};
    auto opened = db::SessionExport::open(*reading_, session, options);
    if (!opened) return opened.error();
    const ExportId id = ++last_export_;
    const auto& [at, fresh] = exports_.emplace(id, std::move(*opened));
    return OpenedExport{
        .id = id, .content_type = at->second.content_type(), .file_name = at->second.file_name(), .etag = at->second.etag()};
  }
  db::Result<bool> export_piece(ExportId id, std::string& out) override {
    const auto at = exports_.find(id);
    if (at == exports_.end()) return db::Error{db::ErrorKind::wrong_state, "This export is closed.", ""};
    return at->second.next_chunk(out);
  }
  db::Result<std::shared_ptr<const db::SpoolFile>> export_file(ExportId id) override {
    using File = std::shared_ptr<const db::SpoolFile>;
    const auto at = exports_.find(id);
    if (at == exports_.end()) return db::Error{db::ErrorKind::wrong_state, "This export is closed.", ""};
    const std::string etag = at->second.etag();
    const auto known = std::ranges::find(spooled_, etag, &Spooled::etag);
    if (known != spooled_.end()) {
      known->used_ns = now_ns_;
      return known->file;
    }
    std::shared_ptr<db::SpoolFile>& file = spooling_[id];
    if (!file) {
      auto created = db::SpoolFile::create(owner_.options_.file.parent_path());
      if (!created) return created.error();
      file = std::move(*created);
    }
    std::string piece;
    const auto more = at->second.next_chunk(piece);
    if (!more) return more.error();
    if (db::Status written = file->append(piece); !written) return written.error();
    if (*more) return File{};
    const File whole = std::move(file);
    spooling_.erase(id);
    if (spooled_.size() >= kSpooledKept) spooled_.erase(std::ranges::min_element(spooled_, {}, &Spooled::used_ns));
    spooled_.push_back({at->second.session(), etag, now_ns_, whole});
    return whole;
  }

 private:
  [[nodiscard]] bool session_open() const { return writer_ && writer_->recording(); }
  [[nodiscard]] bool takes_ticks() const { return session_open() && ticks_.life() == life_; }

  void log(const std::string& line) {
    if (owner_.options_.log)
      owner_.options_.log(line);
    else
      std::fprintf(stderr, "%s\n", line.c_str());
  }
  static std::string lost_text(const db::LostCommits& lost) {
    return std::to_string(lost.commits) + " commits that were acknowledged, the last of session " + std::to_string(lost.session);
  }
  void fail(const db::Error& error) {
    if (error.kind == db::ErrorKind::foreign) foreign_ = error.message;
    if (error.message != error_) log("recording: " + error.message);
    error_ = error.message.empty() ? db::error_kind_name(error.kind) : error.message;
    error_kind_ = error.kind;
  }
  void check(const db::Status& status) {
    if (!status) fail(status.error());
  }

  // Whether reading has begun. The first core that is found may have been walking before this server came: when a session of its present life
  // broke off with another server, reading begins with the oldest that the core still holds (20 s) instead of with now.
  bool join() {
    if (joined_) return true;
    if (core_->get() == nullptr) return false;
    if (attached_ns_ == 0) attached_ns_ = now_ns_;
    (void)old_->ticks.read(std::span<TickRecord>{});
    const std::uint64_t life = old_->ticks.life();
    if (reading_) {
      auto broken_off = db::SessionReader(*reading_).broken_off(life);
      if (!broken_off) {
        log("recording: where the last one broke off cannot be read: " + broken_off.error().message);
      } else if (*broken_off) {
        if (now_ns_ - attached_ns_ < kParametersWait_ns) {
          const std::lock_guard lock(owner_.mutex_);
          if (owner_.parameters_.version == 0) return false;
        }
        adopt_old();
        known_.emplace(Known{.life = life, .until = **broken_off});
        going_on_ = true;
      }
    }
    if (!going_on_) take_over_walk();
    joined_ = true;
    heard_ns_ = now_ns_;
    old_.reset();
    return true;
  }

  [[nodiscard]] std::filesystem::path folder() const {
    const std::filesystem::path folder = owner_.options_.file.parent_path();
    return folder.empty() ? "." : folder;
  }
  // Nothing when that is not known.
  [[nodiscard]] std::optional<std::uint64_t> free_bytes() const {
    std::error_code unknown;
    const auto space = std::filesystem::space(folder(), unknown);
    return unknown ? std::nullopt : std::optional<std::uint64_t>(space.available);
  }
  [[nodiscard]] db::Status room_for_session() const {
    const auto free = free_bytes();
    if (!free || *free >= kSessionSpace_bytes) return {};
    const auto megabytes = [](std::uint64_t bytes) { return std::to_string(bytes / 1'000'000) + " MB"; };
    return db::Error{
        db::ErrorKind::disk_full,
        megabytes(*free) + " are free on the disk of the recordings, and a new session needs " + megabytes(kSessionSpace_bytes) + ".", ""};
  }
  void look_at_space() {
    if (now_ns_ - space_ns_ < kRetry_ns) return;
    space_ns_ = now_ns_;
    const auto free = free_bytes();
    low_space_ = free && *free < (low_space_ ? kEnoughSpace_bytes : kLowSpace_bytes);
    if (no_room_.empty() || !room_for_session()) return;
    if (error_ == no_room_) error_.clear();
    no_room_.clear();
  }

  // What the broken-off session has; it is not recorded twice.
  [[nodiscard]] bool known(const TickRecord& record) const {
    return known_ && ticks_.life() == known_->life && record.time_ns <= known_->until.last_time_ns;
  }
  [[nodiscard]] bool known(const Event& event) const {
    if (!known_ || events_.life() != known_->life) return false;
    const db::BrokenOff& until = known_->until;
    return until.last_event_tick ? event.tick <= *until.last_event_tick : event.time_ns < until.start_time_ns;
  }
  [[nodiscard]] bool known(const BusRecord& frame) const {
    if (!known_ || bus_.life() != known_->life) return false;
    const db::BrokenOff& until = known_->until;
    return until.last_frame_time_ns ? frame.time_ns <= *until.last_frame_time_ns : frame.time_ns < until.start_time_ns;
  }
  // Of a stream's first values: they should begin with some that are known. Otherwise those before them are overwritten.
  template <typename T>
  void note_overwritten(const char* stream, const T& first, bool kept, std::uint64_t first_tick) {
    if (!kept || known(first) || life_ != known_->life || !known_->until.last_tick) return;
    const std::uint64_t from = *known_->until.last_tick;
    check(writer_->append_gap(stream, from, std::max(from, first_tick), "server_absent"));
  }

  // The gap between the broken-off session and this one, which goes on from it with `first`.
  void note_absence(const TickRecord& first) {
    const db::BrokenOff& until = known_->until;
    going_on_ = false;
    first_tick_ = 0;  // events that were not stored are part of it also when their steps are the other session's, or lost
    if (!until.last_tick) return;
    if (const std::uint64_t from = *until.last_tick + 1; from < known_->heard_tick)
      check(writer_->append_gap("ticks", from, known_->heard_tick - 1,
                                db::missing_reason(known_->heard_tick - from, known_->heard_missed - until.missed_ticks, "server_absent")));
    // Heard, but the session could not be begun.
    if (known_->heard_tick < first.tick) check(writer_->append_gap("ticks", known_->heard_tick, first.tick - 1, "storage"));
  }

  // The walk began before this session could.
  void note_lost_begin(const TickRecord& first, bool events_dropped) {
    check(writer_->append_gap("ticks", walk_from_, first.tick - 1, begin_lost_));
    check(writer_->append_gap("bus", walk_from_, first.tick - 1, begin_lost_));
    if (events_dropped) check(writer_->append_gap("events", walk_from_, first.tick - 1, begin_lost_));
  }

  // A core that walks already when this server finds it: the walk is recorded from its beginning, as far as the core still holds it.
  void take_over_walk() {
    publish::TickReader ticks = old_->ticks;
    TickRecord first{};  // of the motion that lasts
    std::optional<TickRecord> newest;
    for (auto got = ticks.read(tick_buffer_); got.count > 0; got = ticks.read(tick_buffer_))
      for (const TickRecord& record : std::span(tick_buffer_).first(got.count)) {
        if (moving(record) && !(newest && moving(*newest))) first = record;
        newest = record;
      }
    if (!newest || !moving(*newest)) {
      // Reading begins with the next step, and a recording by hand that was asked for meanwhile need not wait for it.
      last_ = newest;
      last_life_ = ticks.life();
      return;
    }
    walk_began_ = began_by(first.tick);
    adopt_old();
    db::BrokenOff until;
    until.start_time_ns = first.time_ns;
    until.last_time_ns = first.time_ns - 1;
    until.last_event_tick = first.tick - 1;
    until.last_frame_time_ns = first.time_ns - kTick_ns;
    known_.emplace(Known{.life = ticks.life(), .until = until});
  }
  // The step in which the motion began that a step is part of: the core holds its events for longer than its steps.
  std::uint64_t began_by(std::uint64_t tick) {
    std::uint64_t began = tick;
    publish::EventReader events = old_->events;
    for (auto got = events.read(event_buffer_); got.count > 0; got = events.read(event_buffer_))
      for (const Event& event : std::span(event_buffer_).first(got.count))
        if (begins_motion(event) && event.tick <= tick) began = event.tick;
    return began;
  }
  // The same of a step before which others were overwritten unread; without its event the motion may have begun with any of them.
  std::uint64_t began_unread(std::uint64_t tick) {
    while (read_events() == kReadEvents) {
    }
    std::uint64_t began = last_ && last_life_ == ticks_.life() ? last_->tick + 1 : tick;
    for (const Event& event : kept_events_.of(ticks_.life()))
      if (begins_motion(event) && event.tick <= tick) began = event.tick;
    return began;
  }
  void adopt_old() {
    ticks_ = old_->ticks;
    events_ = old_->events;
    bus_ = old_->bus;
  }

  // UTC now minus the core's time now, which in lock-step is the newest record's.
  [[nodiscard]] std::int64_t offset_ns(std::uint64_t newest_ns) const {
    return owner_.options_.utc_ns() - static_cast<std::int64_t>(ticks_.simulated_clock() ? newest_ns : owner_.options_.steady_ns());
  }

  // Time of the newest step that is published: a session may begin with one of the past, and in lock-step that is not now.
  [[nodiscard]] std::uint64_t newest_step_ns(const TickRecord& first) const {
    std::uint64_t newest_ns = std::max(first.time_ns, read_time_ns_);
    if (!ticks_.simulated_clock()) return newest_ns;
    publish::TickReader ahead = ticks_;
    std::vector<TickRecord> records(kReadTicks);
    for (auto got = ahead.read(records); got.count > 0 && ahead.life() == ticks_.life(); got = ahead.read(records))
      newest_ns = records[got.count - 1].time_ns;
    return newest_ns;
  }

  // What is known when a session begins with this step. It refers to `parameters`.
  db::SessionStart start_at(const TickRecord& first, std::optional<std::string> subject, Kind kind, contract::ParamsInForce& parameters) {
    const bool walk = kind == Kind::walk;
    db::SessionStart start;
    start.subject = std::move(subject);
    start.start_time_ns = first.time_ns;
    start.core_start_time_ns = ticks_.life();
    offset_ns_ = offset_ns(newest_step_ns(first));
    anchored_ns_ = now_ns_;
    start.started_utc_ns = static_cast<std::int64_t>(first.time_ns) + offset_ns_;
    start.simulated = first.simulated != 0;
    start.standby = kind == Kind::standby;
    start.layout_hash = contract::layout_hash();
    start.software_version = owner_.options_.version;
    {
      const std::lock_guard lock(owner_.mutex_);
      if (walk) start.exercise_json = owner_.exercise_;
      if (!start.subject) start.subject = owner_.subject_;
      if (walk && going_on_) {
        start.exercise_json = known_->until.exercise_json;
        start.subject = known_->until.subject;
      }
      parameters = owner_.parameters_;
      start.nodes = owner_.nodes_;
    }
    if (!ticks_.program().empty()) start.core_version = ticks_.program();
    if (parameters.version != 0) start.parameter_values = parameters.values;
    return start;
  }

  db::Status begin(const TickRecord& first, std::optional<std::string> subject, std::string note, Kind kind) {
    if (db::Status room = room_for_session(); !room) {
      fail(room.error());
      no_room_ = error_;
      return room;
    }
    const bool walk = kind == Kind::walk;
    contract::ParamsInForce parameters;
    db::SessionStart start = start_at(first, std::move(subject), kind, parameters);
    start.note = std::move(note);
    standby_for_ = start.subject;
    const auto begun = writer_->begin(start);
    if (!begun) {
      fail(begun.error());
      return begun.error();
    }
    error_.clear();
    kind_ = kind;
    life_ = ticks_.life();
    samples_ = 0;
    started_utc_ms_ = start.started_utc_ns / 1'000'000;
    started_time_ns_ = first.time_ns;
    last_tick_ = journal_from_ = first.tick;
    fresh_ = true;
    committed_ns_ = now_ns_;
    std::vector<Event> events;
    // Also those of a beginning that could not be stored, as far as they are kept.
    first_tick_ = walk ? std::min(walk_from_, first.tick) : first.tick;
    for (const Event& event : kept_events_.of(life_))
      if (event.tick >= first_tick_) events.push_back(event);
    std::vector<BusRecord> frames;
    frames_from_ns_ = !going_on_ && first.time_ns > kTick_ns ? first.time_ns - kTick_ns : 0;
    // What is no walk begins at any step. Its journal begins with the newest image, so that all of it can be run again.
    if (const auto image = walk ? std::nullopt : journal_.image_before(life_, first.tick);
        image && !kept_frames_.of(life_).empty() && kept_frames_.of(life_).front().time_ns < image->time_ns) {
      journal_from_ = image->tick;
      frames_from_ns_ = std::min(frames_from_ns_, image->time_ns);
    }
    for (const BusRecord& frame : kept_frames_.of(life_))
      if (frame.time_ns >= frames_from_ns_) frames.push_back(frame);
    const auto& all = kept_events_.of(life_);
    const bool events_dropped = all.size() == kKeptEvents && all.front().tick > walk_from_;
    kept_events_.clear();
    kept_frames_.clear();
    if (going_on_)
      note_absence(first);
    else if (walk && walk_from_ < first.tick)
      note_lost_begin(first, events_dropped);
    if (!events.empty()) check(writer_->append_events(events));
    if (!frames.empty()) check(writer_->append_bus(frames));
    return {};
  }

  // What goes wrong is told and tried again with the next commit. Until then nothing more is read, because all that comes is a later session's: the
  // core holds 20 s of it.
  void end(db::CloseReason reason) {
    if (try_end(reason)) return;
    end_again_ = reason;
    if (!std::exchange(waits_, true)) waits_for_ = chosen_;
  }
  // What waits was said while another patient was chosen. It is in no session: a gap, if motion has begun in it.
  void drop_waiting() {
    waits_ = false;
    rest_ = {};
    for (auto got = ticks_.read(tick_buffer_); got.count > 0; got = ticks_.read(tick_buffer_))
      for (const TickRecord& record : std::span(tick_buffer_).first(got.count))
        if (!moving(record)) {
          last_ = record;
          last_life_ = ticks_.life();
        }
    unread_ = true;
    begin_lost_ = "storage";
    read_to_the_end();
  }
  // Events and frames as far as the open session's last step.
  void read_to_the_end() {
    while (read_events(last_tick_) == kReadEvents) {
    }
    while (read_bus(last_time_ns_) == kReadFrames) {
    }
  }

  db::Status try_end(db::CloseReason reason) {
    // Events, frames and journal of a step are published before its record: of the newest steps they are here, and not read yet.
    if (!end_again_) read_to_the_end();
    read_journal();
    // With its last step: a core that is gone is noticed later, and a full disk may take the end hours later. A simulator's steps may be ahead.
    const std::int64_t last_utc_ns = static_cast<std::int64_t>(fresh_ ? started_time_ns_ : last_time_ns_) + offset_ns_;
    db::Status ended = writer_->close(reason, std::min(last_utc_ns, owner_.options_.utc_ns()));
    if (!ended) {
      fail(ended.error());
      return ended;
    }
    end_again_.reset();
    error_.clear();
    quiet_since_ns_ = 0;
    return {};
  }

  void commit() {
    committed_ns_ = now_ns_;
    if (end_again_) {
      end(*end_again_);
      return;
    }
    const auto durable = writer_->commit();
    if (!durable)
      fail(durable.error());
    else
      error_.clear();
    if (now_ns_ - anchored_ns_ >= kAnchor_ns) {
      anchored_ns_ = now_ns_;
      const std::int64_t now = offset_ns(last_time_ns_);
      if (now - offset_ns_ > kJump_ns || offset_ns_ - now > kJump_ns) {
        offset_ns_ = now;
        check(writer_->append_utc_anchor(last_time_ns_, static_cast<std::int64_t>(last_time_ns_) + now));
      }
    }
  }

  // False when there is none.
  bool next_ticks() {
    if (rest_.from < rest_.to) return true;
    auto got = ticks_.read(tick_buffer_);
    // All of these at once: the session has to be open before the events and frames that follow them are read.
    while (got.count > 0 && known(tick_buffer_[got.count - 1])) got = ticks_.read(tick_buffer_);
    rest_ = {0, got.count};
    more_ = got.count == kReadTicks;
    if (got.lost > 0 && !takes_ticks()) {
      unread_ = true;
      begin_lost_ = waits_ ? "storage" : "recorder_late";
    }
    if (!more_) waits_ = false;
    if (got.count == 0) return false;
    heard_ns_ = now_ns_;
    read_time_ns_ = tick_buffer_[got.count - 1].time_ns;
    if (takes_ticks() && !fresh_ && got.lost > 0 && tick_buffer_[0].tick > last_tick_ + 1)
      check(writer_->append_gap("ticks", last_tick_ + 1, tick_buffer_[0].tick - 1, "recorder_late"));
    return true;
  }

  // Whether there are more.
  bool read_ticks() {
    if (!next_ticks()) return false;
    const std::size_t to = rest_.to;
    std::size_t from = rest_.from;
    // What an end that is refused has not taken is read once it is stored.
    const auto ended = [&](std::size_t at, db::CloseReason reason) {
      append(from, at);
      from = at;
      end(reason);
      if (!end_again_) return true;
      rest_ = {at, to};
      more_ = true;
      return false;
    };
    // The old core is gone; what it said is stored. What follows is another session, and the time between belongs to neither.
    if (session_open() && ticks_.life() != life_ && !ended(from, db::CloseReason::core_restarted)) return true;
    for (std::size_t i = from; i < to; ++i) {
      const TickRecord& record = tick_buffer_[i];
      if (known(record)) {
        from = i + 1;
        continue;
      }
      if (going_on_) go_on_with(record);
      const bool was_moving = last_ && ticks_.life() == last_life_ && moving(*last_);
      const bool starts = moving(record) && !was_moving;
      if (starts && takes_ticks() && kind_ != Kind::by_hand && !ended(i, db::CloseReason::finished)) return true;
      if (starts) note_begin(record);
      if (starts && takes_ticks() && kind_ == Kind::by_hand) name_exercise();
      if (takes_ticks() && kind_ == Kind::standby && standby_over(record) && !ended(i, db::CloseReason::finished)) return true;
      // Also when the disk refused at the start: asked again while motion lasts, so that the rest is recorded.
      if (moving(record) && writer_ && !session_open() && (starts || now_ns_ - begin_tried_ns_ >= kRetry_ns)) {
        begin_tried_ns_ = now_ns_;
        from = i;
        check(begin(record, std::nullopt, "", Kind::walk));
      } else if (chosen_ && !moving(record) && may_hold_patient(record) && writer_ && !session_open() &&
                 now_ns_ - begin_tried_ns_ >= kRetry_ns) {
        begin_tried_ns_ = now_ns_;
        from = i;
        check(begin(record, chosen_, "", Kind::standby));
      }
      if (!session_open()) from = i + 1;
      unread_ = false;
      last_ = record;
      last_life_ = ticks_.life();
      if (takes_ticks() && kind_ == Kind::walk && over(record) && !ended(i + 1, db::CloseReason::finished)) return true;
    }
    append(from, to);
    rest_ = {};
    return more_;
  }

  // Where the motion began that is seen first with this step, and why what came before is not there.
  void note_begin(const TickRecord& record) {
    walk_from_ = record.tick;
    if (walk_began_) {
      walk_from_ = *std::exchange(walk_began_, std::nullopt);
      begin_lost_ = "server_absent";
    } else if (unread_) {
      walk_from_ = began_unread(record.tick);
    }
    if (walk_from_ >= record.tick) begin_lost_ = "storage";
  }

  // The walk that broke off either goes on with the first record after it, or it is over.
  void go_on_with(const TickRecord& record) {
    if (!moving(record) || ticks_.life() != known_->life) {
      going_on_ = false;
    } else if (known_->heard_tick == 0) {
      known_->heard_tick = record.tick;
      known_->heard_missed = record.missed_ticks;
    }
  }

  void append(std::size_t from, std::size_t to) {
    if (!takes_ticks() || from >= to) return;
    fresh_ = false;
    samples_ += to - from;
    last_tick_ = tick_buffer_[to - 1].tick;
    last_time_ns_ = tick_buffer_[to - 1].time_ns;
    check(writer_->append_ticks(std::span(tick_buffer_).subspan(from, to - from)));
  }

  // Motion has ended for good.
  bool over(const TickRecord& record) {
    if (moving(record)) {
      quiet_since_ns_ = 0;
      return false;
    }
    const bool stopped = record.mode == static_cast<std::uint8_t>(contract::Mode::protective_stop);
    if (stopped && record.standing_still == 0) {
      quiet_since_ns_ = 0;
      return false;
    }
    if (quiet_since_ns_ == 0 || quiet_mode_ != record.mode) {
      quiet_since_ns_ = record.time_ns;
      quiet_mode_ = record.mode;
    }
    const double limit_s = stopped ? kAfterStop_s : kAfterStandby_s;
    return static_cast<double>(record.time_ns - quiet_since_ns_) * 1e-9 >= limit_s;
  }

  // Sessions of bounded length: what is read of one at once stays short.
  [[nodiscard]] bool standby_over(const TickRecord& record) const {
    return !may_hold_patient(record) || static_cast<double>(record.time_ns - started_time_ns_) * 1e-9 >= kStandbySession_s;
  }

  // A recording that was begun by hand learns what is walked in it.
  void name_exercise() {
    std::optional<std::string> exercise;
    {
      const std::lock_guard lock(owner_.mutex_);
      exercise = owner_.exercise_;
    }
    if (!exercise || !reading_) return;
    db::SessionPatch patch;
    patch.exercise_json = exercise;
    check(db::SessionEditor(*reading_).patch(writer_->session(), patch));
  }

  // With `until_tick`, what is later waits for the next session.
  std::size_t read_events(std::uint64_t until_tick = std::numeric_limits<std::uint64_t>::max()) {
    const auto got = events_.read(event_buffer_);
    std::size_t from = 0;
    if (session_open() && events_.life() == life_) {
      if (got.lost > 0) {
        const std::uint64_t to = got.count > 0 ? event_buffer_[0].tick : last_tick_;
        check(writer_->append_gap("events", std::min(std::max(event_tick_, first_tick_), to), to, "recorder_late"));
      }
      if (got.count > 0 && !events_seen_)
        note_overwritten("events", event_buffer_[0], known_ && known_->until.last_event_tick, event_buffer_[0].tick);
      // A record of an earlier step than the session's first is not part of it.
      while (from < got.count && (event_buffer_[from].tick < first_tick_ || known(event_buffer_[from]))) ++from;
      std::size_t to = got.count;
      while (to > from && event_buffer_[to - 1].tick > until_tick) --to;
      if (from < to) check(writer_->append_events(std::span(event_buffer_).subspan(from, to - from)));
      kept_events_.add(events_.life(), std::span(event_buffer_).subspan(to, got.count - to));
    } else {
      kept_events_.add(events_.life(), std::span(event_buffer_).first(got.count));
    }
    events_seen_ = events_seen_ || got.count > 0;
    if (got.count > 0) event_tick_ = event_buffer_[got.count - 1].tick;
    return got.count;
  }

  // With `until_ns`, what is later waits for the next session.
  std::size_t read_bus(std::uint64_t until_ns = std::numeric_limits<std::uint64_t>::max()) {
    const auto got = bus_.read(bus_buffer_);
    if (session_open() && bus_.life() == life_) {
      // Steps are read before frames: the newest step may be long after the frames that are missing.
      if (got.lost > 0) {
        const std::uint64_t to = got.count > 0 ? tick_at(bus_buffer_[0].time_ns) : last_tick_;
        check(writer_->append_gap("bus", std::min(std::max(tick_at(frame_time_ns_), first_tick_), to), to, "recorder_late"));
      }
      if (got.count > 0 && !frames_seen_)
        note_overwritten("bus", bus_buffer_[0], known_ && known_->until.last_frame_time_ns, tick_at(bus_buffer_[0].time_ns));
      std::size_t from = 0;
      while (from < got.count && (bus_buffer_[from].time_ns < frames_from_ns_ || known(bus_buffer_[from]))) ++from;
      std::size_t to = got.count;
      while (to > from && bus_buffer_[to - 1].time_ns > until_ns) --to;
      if (from < to) check(writer_->append_bus(std::span(bus_buffer_).subspan(from, to - from)));
      kept_frames_.add(bus_.life(), std::span(bus_buffer_).subspan(to, got.count - to));
    } else {
      kept_frames_.add(bus_.life(), std::span(bus_buffer_).first(got.count));
    }
    frames_seen_ = frames_seen_ || got.count > 0;
    if (got.count > 0) frame_time_ns_ = bus_buffer_[got.count - 1].time_ns;
    return got.count;
  }

  void read_journal() {
    journal_.read();
    if (session_open() && !fresh_) check(journal_.give(*writer_, life_, journal_from_, last_tick_));
  }
  // The step of a moment, counted from the newest step read: steps follow the clock also where some were left out.
  [[nodiscard]] std::uint64_t tick_at(std::uint64_t time_ns) const {
    if (time_ns >= last_time_ns_) return last_tick_ + (time_ns - last_time_ns_) / kTick_ns;
    const std::uint64_t ago = (last_time_ns_ - time_ns) / kTick_ns;
    return last_tick_ > ago ? last_tick_ - ago : 0;
  }

  void tell() {
    RecordingStatus status;
    status.detail = error_;
    if (!error_.empty()) status.error = error_kind_;
    status.notices = notices_;
    if (low_space_) status.notices.push_back({NoticeName::recordings_low_space, "less than 200 MB are free in " + folder().string()});
    if (!foreign_.empty()) status.notices.push_back({NoticeName::recordings_foreign, foreign_});
    if (session_open()) {
      status.state = error_.empty() ? RecordingState::recording : RecordingState::failed;
      status.session = writer_->session();
      status.standby = kind_ == Kind::standby;
      status.started_utc_ms = started_utc_ms_;
      status.samples = samples_;
      status.durable_tick = writer_->durable().last_tick;
    } else {
      status.state = error_.empty() ? RecordingState::idle : RecordingState::failed;
    }
    const std::lock_guard lock(owner_.mutex_);
    // Samples count up with every pass; the status changes with every commit, so that clients are not told fifty times
    // a second.
    if (status.session == owner_.status_.session && status.state == owner_.status_.state && status.detail == owner_.status_.detail &&
        status.error == owner_.status_.error && status.durable_tick == owner_.status_.durable_tick &&
        status.notices == owner_.status_.notices)
      return;
    owner_.status_ = std::move(status);
    owner_.changes_.fetch_add(1, std::memory_order_release);
  }

  Recorder& owner_;
  publish::TickReader ticks_;
  publish::EventReader events_;
  publish::BusReader bus_;
  JournalFeed journal_;
  // Until the first core is found; see join().
  std::shared_ptr<publish::SharedState> core_;
  struct OldReaders {
    explicit OldReaders(const publish::ServerLink& link)
        : ticks(link, publish::ReadFrom::oldest), events(link, publish::ReadFrom::oldest), bus(link, publish::ReadFrom::oldest) {}
    publish::TickReader ticks;
    publish::EventReader events;
    publish::BusReader bus;
  };
  std::optional<OldReaders> old_;
  bool joined_ = false;
  std::uint64_t attached_ns_ = 0;
  struct Known {
    std::uint64_t life = 0;
    db::BrokenOff until;
    std::uint64_t heard_tick = 0;  // the first step after it that came; 0 = none yet
    std::uint32_t heard_missed = 0;
  };
  std::optional<Known> known_;
  bool going_on_ = false;  // the next session is that one's continuation
  bool events_seen_ = false, frames_seen_ = false;
  std::uint64_t event_tick_ = 0, frame_time_ns_ = 0;  // of the newest one read
  std::vector<TickRecord> tick_buffer_;
  std::vector<Event> event_buffer_;
  std::vector<BusRecord> bus_buffer_;
  Kept<Event, kKeptEvents> kept_events_;
  Kept<BusRecord, kKeptFrames> kept_frames_;
  std::shared_ptr<db::WriteLock> lock_;
  std::optional<db::Database> writing_;
  std::optional<db::Database> reading_;
  std::optional<db::SessionWriter> writer_;
  std::map<ExportId, db::SessionExport> exports_;  // after reading_, whose statements they hold
  ExportId last_export_ = 0;
  std::map<ExportId, std::shared_ptr<db::SpoolFile>> spooling_;  // being written
  struct Spooled {
    db::SessionId session = 0;
    std::string etag;
    std::uint64_t used_ns = 0;
    std::shared_ptr<const db::SpoolFile> file;
  };
  std::vector<Spooled> spooled_;  // whole
  std::string error_;
  db::ErrorKind error_kind_{};  // of error_
  bool opened_ = false;         // this file was told as opened
  std::shared_ptr<void> readers_held_;
  std::string damage_;   // why the file is to be set aside; empty when it is not
  std::string foreign_;  // why the file cannot be ours; empty when it is
  std::vector<StandingNotice> notices_;
  bool low_space_ = false;
  std::string no_room_;  // error_ of a session that was refused, as long as there is no room for one
  std::optional<TickRecord> last_;
  std::uint64_t last_life_ = 0;
  std::uint64_t heard_ns_ = 0;      // steady time at which the newest step came
  std::uint64_t read_time_ns_ = 0;  // its own time
  std::optional<db::CloseReason> end_again_;
  bool waits_ = false;                               // since an end was refused, steps may lie in the ring that were made then
  std::optional<std::string> waits_for_;             // the patient whom they were made for
  Kind kind_ = Kind::walk;                           // of the session that is open
  std::optional<std::string> chosen_, standby_for_;  // the patient, and the one whom the open session is for
  std::uint64_t started_time_ns_ = 0;
  bool fresh_ = true;
  std::uint64_t life_ = 0;
  std::uint64_t samples_ = 0;
  std::int64_t started_utc_ms_ = 0;
  std::int64_t offset_ns_ = 0;
  std::uint64_t anchored_ns_ = 0;
  std::uint64_t walk_from_ = 0;              // step with which the newest motion began
  std::optional<std::uint64_t> walk_began_;  // of a walk that was found under way
  const char* begin_lost_ = "storage";       // why no session began with that step
  bool unread_ = false;                      // the steps before the next one were overwritten, and belong to no session
  struct Rest {
    std::size_t from = 0, to = 0;
  } rest_;                                             // of tick_buffer_: read, and not taken yet
  bool more_ = false;                                  // the ring may hold more than these
  std::uint64_t first_tick_ = 0, frames_from_ns_ = 0;  // what is earlier is no part of the session
  std::uint64_t journal_from_ = 0;                     // tick of the session's first sample
  std::uint64_t last_tick_ = 0;
  std::uint64_t last_time_ns_ = 0;
  std::uint64_t quiet_since_ns_ = 0;
  std::uint8_t quiet_mode_ = 0;
  std::uint64_t committed_ns_ = 0;
  std::uint64_t folded_ns_ = 0;
  std::uint64_t tried_ns_ = 0;
  std::uint64_t space_ns_ = 0;
  std::uint64_t begin_tried_ns_ = 0;
  std::uint64_t now_ns_ = 0;
  bool late_ = false;
};

Recorder::Recorder(const publish::ServerLink& link, Options options)
    : options_(std::move(options)), work_(std::make_unique<Work>(*this, link)) {}
Recorder::~Recorder() { stop(); }

void Recorder::start() {
  work_->hold_readers();
  thread_ = std::thread([this] { main(); });
}

void Recorder::stop() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

db::Status Recorder::claim() { return work_->claim(); }
void Recorder::open_here() { work_->open(); }
void Recorder::pass_here() {
  work_->pass();
  std::unique_lock lock(mutex_);
  const Waiting next = take_job();
  lock.unlock();
  if (next.job) work_->run(next);
}
void Recorder::finish_here() { work_->finish(); }

void Recorder::set_parameters(const contract::ParamsInForce& parameters) {
  const std::lock_guard lock(mutex_);
  parameters_ = parameters;
}

void Recorder::set_nodes(std::vector<db::NodeProgram> nodes) {
  const std::lock_guard lock(mutex_);
  nodes_ = std::move(nodes);
}

void Recorder::set_exercise(std::optional<std::string> exercise_json) {
  const std::lock_guard lock(mutex_);
  exercise_ = std::move(exercise_json);
}

void Recorder::set_subject(std::optional<std::string> code, std::uint64_t file) {
  const std::lock_guard lock(mutex_);
  if (file != file_) code.reset();
  subject_ = std::move(code);
}

void Recorder::set_aside(std::string file_id, std::string damage) {
  const std::lock_guard lock(mutex_);
  damaged_file_ = std::move(file_id);
  damage_ = std::move(damage);
}

RecordingStatus Recorder::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

bool Recorder::run(Job job) {
  {
    const std::lock_guard lock(mutex_);
    if (ending_ || jobs_.size() >= kJobLimit) return false;
    jobs_.push_back({std::move(job), options_.steady_ns()});
  }
  wake_.notify_one();
  return true;
}

void Recorder::close_export(ExportId id) {
  const std::lock_guard lock(mutex_);
  closed_exports_.push_back(id);
}

Recorder::Waiting Recorder::take_job() {
  if (jobs_.empty()) return {};
  Waiting next = std::move(jobs_.front());
  jobs_.pop_front();
  return next;
}

void Recorder::main() {
  work_->open();
  while (true) {
    Waiting next;
    std::vector<ExportId> closed;
    bool ending = false;
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, kPass, [this] { return ending_ || !jobs_.empty(); });
      next = take_job();
      closed.swap(closed_exports_);
      ending = ending_ && !next.job;
    }
    if (ending) break;
    work_->close_exports(closed);
    work_->pass();
    if (next.job) work_->run(next);
  }
  work_->finish();
}

}  // namespace hoist::server
