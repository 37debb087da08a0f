#include "server/state/rehearsal_desk.hpp"

#include <iostream>
#include <nlohmann/json.hpp>
#include <utility>

#include "db/store/markers.hpp"

namespace hoist::server {

using nlohmann::json;

namespace {
// A second therapist who was handed control drives nothing and gives it back after this.
constexpr std::uint64_t kKeepsControl_ns = 3'000'000'000;
constexpr const char* kRehearsalUser = "rehearsal";

constexpr const char* phase_name(Rehearsal::Phase phase) {
  switch (phase) {
    case Rehearsal::Phase::waiting:
      return "waiting";
    case Rehearsal::Phase::happening:
      return "happening";
    case Rehearsal::Phase::lost:
      return "lost";
    case Rehearsal::Phase::over:
      break;
  }
  return "over";
}

json kinds_json() {
  json kinds = json::array();
  for (std::size_t i = 0; i < kRehearsals.size(); ++i) {
    json looks = json::array();
    for (const RehearsalLook& look : kRehearsalLooks)
      if (static_cast<std::size_t>(look.rehearsal) == i)
        looks.push_back({{"check", rehearsal_check_name(look.check)}, {"limit_s", look.limit_s > 0 ? json(look.limit_s) : json(nullptr)}});
    kinds.push_back({{"rehearsal", kRehearsals[i].name}, {"looks", std::move(looks)}});
  }
  return kinds;
}
}  // namespace

std::optional<Reason> RehearsalDesk::problem() const {
  const auto& newest = parts_.core.newest();
  if (!newest || newest->simulated == 0) return Reason::not_simulated;
  if (parts_.settings.simulator.empty()) return Reason::no_simulator;
  return std::nullopt;
}

std::optional<Reason> RehearsalDesk::choose(RehearsalKind kind, std::uint64_t seed, std::uint32_t client) {
  if (const auto why = problem()) return why;
  if (rehearsal_ && rehearsal_->phase() == Rehearsal::Phase::happening) return Reason::rehearsal_runs;
  if (!simulator_.open(parts_.settings.simulator)) return Reason::no_simulator;
  rehearsal_.emplace(kind, seed);
  actor_ = parts_.actors.find(client);
  session_.reset();
  return std::nullopt;
}

void RehearsalDesk::cancel() {
  end();
  rehearsal_.reset();
  simulator_.close();
}

void RehearsalDesk::did(std::uint32_t client, std::string_view action, std::string_view result) {
  if (rehearsal_ && (client == 0 || client != second_)) rehearsal_->did(action, result);
}

void RehearsalDesk::on_core(bool connected) {
  if (connected || !under_way()) return;
  end();
  simulator_.close();
  rehearsal_->lose();
}

void RehearsalDesk::on_ticks(std::span<const contract::TickRecord> records, std::uint64_t) {
  if (!rehearsal_) return;
  for (const contract::TickRecord& record : records) {
    if (second_until_ns_ != 0 && record.time_ns >= second_until_ns_) give_back();
    const Rehearsal::Due due = rehearsal_->take(record);
    if (due.happens) happen(record);
    if (due.ends) end();
    if (due.over) store();
  }
  for (std::string answer = simulator_.answer(); !answer.empty(); answer = simulator_.answer())
    if (answer.find("\"error\"") != std::string::npos)
      std::cerr << "hoist-server: the simulator refuses a rehearsal: " << answer << std::endl;
}

void RehearsalDesk::on_lease(std::uint32_t, std::uint32_t holder) {
  if (!rehearsal_) return;
  const bool second = second_ != 0 && holder == second_;
  if (second && parts_.core.newest()) second_until_ns_ = parts_.core.newest()->time_ns + kKeepsControl_ns;
  rehearsal_->lease(holder != 0 && !second);
}

void RehearsalDesk::happen(const contract::TickRecord& record) {
  session_ = parts_.recorder.status().session;
  tick_ = record.tick;
  utc_ns_ = parts_.utc_ns();
  const RehearsalInfo& info = rehearsal_info(rehearsal_->kind());
  if (!info.happens.empty()) simulator_.send(info.happens);
  if (rehearsal_->kind() == RehearsalKind::second_therapist) {
    second_ = parts_.actors.enter({{kRehearsalUser, "therapist", "rehearsal", "rehearsal"}, "Rehearsal", {}});
    (void)parts_.state.asks().add(second_, parts_.now_ns());
  }
  const std::uint32_t holder = parts_.core.lease_holder();
  rehearsal_->lease(holder != 0);
  if (rehearsal_->kind() == RehearsalKind::link_loss && cut_ && holder != 0) cut_(holder, info.ends_after_s);
}

bool RehearsalDesk::under_way() const {
  return rehearsal_ && (rehearsal_->phase() == Rehearsal::Phase::waiting || rehearsal_->phase() == Rehearsal::Phase::happening);
}

void RehearsalDesk::end() {
  if (!rehearsal_ || rehearsal_->phase() == Rehearsal::Phase::waiting || rehearsal_->phase() == Rehearsal::Phase::lost) return;
  const RehearsalInfo& info = rehearsal_info(rehearsal_->kind());
  if (!info.ends.empty()) simulator_.send(info.ends);
  if (second_ == 0) return;
  parts_.state.asks().remove(second_);
  give_back();
  parts_.actors.leave(std::exchange(second_, 0));
}

void RehearsalDesk::give_back() {
  second_until_ns_ = 0;
  if (second_ == 0 || parts_.core.lease_holder() != second_) return;
  contract::Command command;
  command.kind = contract::CommandKind::release_lease;
  command.client = second_;
  command.lease_epoch = parts_.core.lease_epoch();
  parts_.core.ask(command, [](const CoreAnswer&) {});
}

// With the session that was recorded when it happened. That may have ended: a walk's recording ends soon after its motion.
void RehearsalDesk::store() {
  if (!session_) return;
  const db::Marker marker{.tick = tick_, .utc_ns = utc_ns_, .text = rehearsal_text(rehearsal_->result()), .actor = actor_};
  const auto work = [session = *session_, marker](Records& records) -> std::string {
    db::Database* database = records.database();
    if (database == nullptr) return records.why();
    const db::Status stored = records.status().session == session ? records.marker(session, {.text = marker.text}, marker.actor)
                                                                  : db::MarkerStore(*database).add(session, marker);
    return stored ? std::string() : stored.error().message;
  };
  const auto then = [](const std::string& why) {
    if (!why.empty()) std::cerr << "hoist-server: the result of a rehearsal is not stored: " << why << std::endl;
  };
  if (!parts_.records.ask<std::string>(work, then)) then("too much waits for the recorder");
}

json RehearsalDesk::told() const {
  const auto why = problem();
  json told{{"reason_code", why ? json(reason_name(*why)) : json(nullptr)},
            {"kinds", kinds_json()},
            {"phase", rehearsal_ ? phase_name(rehearsal_->phase()) : "none"},
            {"rehearsal", nullptr},
            {"seed", nullptr},
            {"session", session_ && rehearsal_ ? json(*session_) : json(nullptr)},
            {"result", nullptr}};
  if (!rehearsal_) return told;
  told["rehearsal"] = rehearsal_info(rehearsal_->kind()).name;
  told["seed"] = rehearsal_->seed();
  if (rehearsal_->phase() == Rehearsal::Phase::over) told["result"] = rehearsal_json(rehearsal_->result());
  return told;
}

}  // namespace hoist::server
