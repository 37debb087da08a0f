#include "server/link/core_desk.hpp"

#include <utility>

#include "control/contract/param_set.hpp"

namespace hoist::server {

using contract::Command;
using contract::CommandKind;
using contract::Event;
using contract::EventKind;

namespace {
// Ticks in one copy.
constexpr std::size_t kTicksPerCopy = 128;
constexpr std::size_t kEventsPerPoll = 128;

// What the next start is to begin with.
constexpr bool changes_settings(CommandKind kind) {
  return kind == CommandKind::commit_parameters || kind == CommandKind::confirm_parameters || kind == CommandKind::set_neutral ||
         kind == CommandKind::use_calibration;
}
}  // namespace

CoreDesk::CoreDesk(std::string socket_path, Counters& counters)
    : link_(std::move(socket_path)),
      counters_(counters),
      ticks_(link_),
      events_(link_),
      tick_buffer_(kTicksPerCopy),
      event_buffer_(kEventsPerPoll) {}

std::uint32_t CoreDesk::next_request() {
  if (++last_request_ == 0) ++last_request_;  // 0 means "not asked by anyone"
  return last_request_;
}

bool CoreDesk::send(Command& command) {
  if (link_.send(command) == 0) return false;
  counters_.add(Count::commands_sent);
  return true;
}

std::uint32_t CoreDesk::ask(Command command, Done done) {
  if (!connected_) {
    done({.kind = CoreAnswer::Kind::no_core});
    return 0;
  }
  if (outbox_.size() >= kOutboxLimit) {
    done({.kind = CoreAnswer::Kind::busy});
    return 0;
  }
  command.request_id = next_request();
  const std::uint64_t limit_ns = command.kind == CommandKind::acknowledge ? kAcknowledgeLimit_ns : kAnswerLimit_ns;
  pending_.emplace(command.request_id, Pending{clock_ns_ + limit_ns, std::move(done), changes_settings(command.kind), std::nullopt});
  outbox_.push_back(command);
  flush_outbox();
  if (wake_) wake_();
  return command.request_id;
}

std::uint32_t CoreDesk::ask_parameters(const std::vector<std::pair<std::uint32_t, double>>& id_values, std::uint32_t version,
                                       Command commit, Done done) {
  if (!connected_) {
    done({.kind = CoreAnswer::Kind::no_core});
    return 0;
  }
  if (outbox_.size() + id_values.size() >= kOutboxLimit) {
    done({.kind = CoreAnswer::Kind::busy});
    return 0;
  }
  commit.kind = CommandKind::commit_parameters;
  commit.request_id = next_request();
  commit.a = static_cast<std::uint32_t>(id_values.size());
  std::uint32_t position = 0;
  contract::ParamSetSeal seal;
  for (const auto& [id, value] : id_values) {
    seal.add(id, value);
    Command stage = commit;
    stage.kind = CommandKind::stage_parameter;
    stage.request_id = next_request();
    stage.a = id;
    stage.b = position++;
    stage.v0 = value;
    stage.bits = 0;
    staged_[stage.request_id] = commit.request_id;
    outbox_.push_back(stage);
  }
  commit.bits = seal.value(version);
  pending_.emplace(commit.request_id, Pending{clock_ns_ + kAnswerLimit_ns, std::move(done), true, std::nullopt});
  outbox_.push_back(commit);
  flush_outbox();
  if (wake_) wake_();
  return commit.request_id;
}

bool CoreDesk::stop(std::uint32_t client, Done done) {
  // Sent even when the core has been silent for a while: whatever is at the other end of the segment should see it.
  if (!link_.attached()) {
    if (done) done({.kind = CoreAnswer::Kind::no_core});
    return false;
  }
  std::uint32_t request = waiting_stop();
  if (request == 0) {
    Command command;
    command.kind = CommandKind::stop;
    command.client = client;
    command.request_id = request = next_request();
    if (!send(command)) outbox_.push_front(command);
  }
  if (done) pending_.emplace(request, Pending{clock_ns_ + kAnswerLimit_ns, std::move(done), false, std::nullopt});
  if (wake_) wake_();
  return true;
}

// A STOP before another command does not count: that command may set the hoist in motion again.
std::uint32_t CoreDesk::waiting_stop() const {
  if (!outbox_.empty() && outbox_.front().kind == CommandKind::stop) return outbox_.front().request_id;
  return link_.untaken_stop();
}

bool CoreDesk::drive(const contract::DriveCommand& command) {
  if (!connected_) return false;
  link_.drive(command);
  hand_holds_ = command.held == 1;
  hand_ns_ = command.echo_time_ns;
  return true;
}

std::string_view CoreDesk::problem() const {
  if (connected_) return {};
  return link_.attached() ? "the control core is attached, but publishes nothing" : std::string_view{link_.last_error()};
}

std::optional<Reason> CoreDesk::reason() const {
  if (problem().empty()) return std::nullopt;
  if (link_.attached()) return Reason::core_silent;
  switch (link_.problem()) {
    case publish::LinkProblem::absent:
      return Reason::core_absent;
    case publish::LinkProblem::silent:
      return Reason::core_silent;
    case publish::LinkProblem::gone:
      return Reason::core_gone;
    case publish::LinkProblem::taken:
      return Reason::core_taken;
    case publish::LinkProblem::other_build:
      return Reason::core_build;
    case publish::LinkProblem::refused:
      return Reason::core_refused;
    default:
      return Reason::core_unreachable;
  }
}

bool CoreDesk::hand_holds(std::uint64_t within_ns) const {
  // On the core's clock, as the core judges it. An echo from the future is refused there, and so counts as no hand here.
  return hand_holds_ && newest_ && newest_->time_ns >= hand_ns_ && newest_->time_ns - hand_ns_ <= within_ns;
}

void CoreDesk::flush_outbox() {
  while (!outbox_.empty()) {
    if (!send(outbox_.front())) return;
    outbox_.pop_front();
  }
}

void CoreDesk::answer_all(CoreAnswer::Kind kind) {
  auto waiting = std::exchange(pending_, {});
  auto storing = std::exchange(storing_, {});
  staged_.clear();
  outbox_.clear();
  for (auto& [id, pending] : waiting)
    if (pending.done) pending.done({.kind = kind});
  for (Storing& one : storing) one.done({.kind = kind});
}

void CoreDesk::set_connected(bool connected) {
  if (connected == connected_) return;
  connected_ = connected;
  for (CoreListener* listener : listeners_) listener->on_core(connected);
}

void CoreDesk::set_lease(std::uint32_t epoch, std::uint32_t holder) {
  if (epoch == lease_epoch_ && holder == lease_holder_) return;
  lease_epoch_ = epoch;
  lease_holder_ = holder;
  for (CoreListener* listener : listeners_) listener->on_lease(epoch, holder);
}

void CoreDesk::poll(std::uint64_t now_ns) {
  now_ns_ = now_ns;
  const bool attached = link_.poll_connect();
  if (attached && link_.life() != life_) {
    // A new core knows nothing of what was asked of the old one.
    life_ = link_.life();
    answer_all(CoreAnswer::Kind::no_core);
    newest_.reset();
    parameters_ = {};
    parameters_sequence_ = 0;
    store_ = {};
    heard_ns_ = now_ns;
    set_connected(false);
  }
  if (attached) link_.beat();
  std::vector<Event> events;
  std::vector<Answered> answered;
  // Before the ticks, so that a client that gets an answer finds the step it came from in `newest()`.
  read_events(events, answered);
  read_ticks(now_ns);
  read_parameters();
  look_at_clock();
  const std::uint64_t silence_ns = link_.simulated_clock() ? kLockStepSilence_ns : kCoreSilence_ns;
  if (attached && newest_.has_value() && heard_ns_ + silence_ns > now_ns) {
    set_connected(true);
  } else if (!attached || heard_ns_ + silence_ns <= now_ns) {
    if (connected_) {
      set_connected(false);
      set_lease(lease_epoch_, 0);
      answer_all(CoreAnswer::Kind::no_core);
    }
  }
  for (const Event& event : events)
    for (CoreListener* listener : listeners_) listener->on_event(event);
  for (Answered& a : answered) answer(a);
  answer_stored();
  // Timed out: a late answer is dropped.
  std::vector<Done> late;
  for (auto it = pending_.begin(); it != pending_.end();) {
    if (it->second.deadline_ns > clock_ns_) {
      ++it;
      continue;
    }
    counters_.add(Count::commands_unanswered);
    late.push_back(std::move(it->second.done));
    std::erase_if(staged_, [id = it->first](const auto& row) { return row.second == id; });
    std::erase_if(outbox_, [id = it->first](const Command& c) { return c.request_id == id && c.kind != CommandKind::stop; });
    it = pending_.erase(it);
  }
  for (Done& done : late)
    if (done) done({.kind = CoreAnswer::Kind::unanswered});
  flush_outbox();
}

void CoreDesk::look_at_clock() {
  const bool simulated = link_.simulated_clock() && newest_.has_value();
  clock_ns_ = simulated ? newest_->time_ns : link_.simulated_clock() ? link_.life() : now_ns_;
  if (simulated && link_.attached())
    speed_.look(now_ns_, newest_->time_ns);
  else
    speed_.forget();
}

// All that there are, also after a stall: who is answered in this poll finds the answer's step in `newest()`. At most a ring of them, because a core
// that steps faster than this thread copies would hold it.
void CoreDesk::read_ticks(std::uint64_t now_ns) {
  for (std::size_t copied = 0; copied < contract::kTickSlots;) {
    const auto got = ticks_.read(tick_buffer_);
    if (got.lost != 0) counters_.add(Count::telemetry_ticks_lost, got.lost);
    if (got.count == 0) return;
    heard_ns_ = now_ns;
    const std::span<const contract::TickRecord> records(tick_buffer_.data(), got.count);
    newest_ = records.back();
    for (CoreListener* listener : listeners_) listener->on_ticks(records, got.lost);
    set_lease(newest_->lease_epoch, newest_->lease_holder);
    copied += got.count;
    if (got.count < tick_buffer_.size()) return;
  }
}

void CoreDesk::past(std::uint64_t from_tick, const std::function<void(const contract::TickRecord&)>& each) const {
  if (!newest_) return;
  publish::TickReader ring(link_, publish::ReadFrom::oldest);
  std::vector<contract::TickRecord> some(kTicksPerCopy);
  while (ring.life() == run()) {
    const auto got = ring.read(some);
    if (got.count == 0 || ring.life() != run()) return;
    for (std::size_t i = 0; i < got.count; ++i) {
      if (some[i].tick > newest_->tick) return;
      if (some[i].tick >= from_tick) each(some[i]);
    }
  }
}

// The core publishes parameters before the answer to what changed them, and the answers of this poll are read already: a client that is answered now
// finds here what is in force.
void CoreDesk::read_parameters() {
  if (contract::StoreReport report; link_.store(report)) store_ = report;
  if (link_.params_sequence() == parameters_sequence_) return;
  contract::ParamsInForce now{};
  const std::uint64_t sequence = link_.params(now);
  ++parameter_copies_;
  if (sequence == 0) return;
  if (sequence != parameters_sequence_) parameters_ns_ = now_ns_;
  parameters_sequence_ = sequence;
  if (now.version == 0 || (now.version == parameters_.version && now.values == parameters_.values)) return;
  parameters_ = now;
  for (CoreListener* listener : listeners_) listener->on_parameters(parameters_);
}

void CoreDesk::answer(Answered& answered) {
  if (!answered.done) return;
  if (answered.changes_settings && answered.answer.done())
    storing_.push_back({std::move(answered.done), answered.answer, parameters_sequence_, now_ns_ + kStoreLimit_ns});
  else
    answered.done(answered.answer);
}

void CoreDesk::answer_stored() {
  std::vector<Storing> ready;
  std::erase_if(storing_, [&](Storing& one) {
    const bool stored = store_.stored >= one.sequence;
    const bool refused = store_.tried >= one.sequence && store_.problem != contract::StoreProblem::none;
    if (!stored && !refused && now_ns_ < one.deadline_ns) return false;
    one.answer.stored = stored;
    ready.push_back(std::move(one));
    return true;
  });
  for (Storing& one : ready) one.done(one.answer);
}

std::optional<contract::StoreProblem> CoreDesk::store_problem() const {
  if (!connected_ || store_.stored >= parameters_sequence_) return std::nullopt;
  if (store_.problem != contract::StoreProblem::none) return store_.problem;
  if (now_ns_ - parameters_ns_ < kStoreLimit_ns) return std::nullopt;
  return contract::StoreProblem::failed;
}

std::optional<contract::StoreProblem> CoreDesk::stops_problem() const {
  const contract::StoreProblem problem = link_.stops_problem();
  if (!connected_ || problem == contract::StoreProblem::none) return std::nullopt;
  return problem;
}

void CoreDesk::read_events(std::vector<Event>& events, std::vector<Answered>& answered) {
  const auto got = events_.read(event_buffer_);
  for (std::size_t i = 0; i < got.count; ++i) {
    const Event& event = event_buffer_[i];
    events.push_back(event);
    if (event.kind != EventKind::command_done && event.kind != EventKind::command_refused) continue;
    const bool refused = event.kind == EventKind::command_refused;
    if (refused) counters_.add(Count::commands_refused);
    if (const auto staged = staged_.find(event.request_id); staged != staged_.end()) {
      const auto set = pending_.find(staged->second);
      if (refused && set != pending_.end() && !set->second.staging_refusal) set->second.staging_refusal = event;
      staged_.erase(staged);
      continue;
    }
    const auto [first, last] = pending_.equal_range(event.request_id);
    if (first == last) continue;
    // A set fails because of one of its rows: that row is what the person wants to hear about.
    const Event& reason = refused && first->second.staging_refusal ? *first->second.staging_refusal : event;
    const CoreAnswer told{.kind = refused ? CoreAnswer::Kind::refused : CoreAnswer::Kind::done,
                          .code = reason.code,
                          .bits = reason.bits != 0 || !refused ? reason.bits : 1U << (reason.code & 31U),
                          .item = reason.item,
                          .value = reason.value};
    for (auto one = first; one != last; ++one) answered.push_back({std::move(one->second.done), told, one->second.changes_settings});
    std::erase_if(staged_, [id = event.request_id](const auto& row) { return row.second == id; });
    pending_.erase(first, last);
  }
}

}  // namespace hoist::server
