#include "server/actions/records.hpp"

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "control/contract/faults.hpp"
#include "server/actions/common.hpp"
#include "server/state/views.hpp"

namespace hoist::server {

namespace {
std::string place_text(const MarkerPlace& place) {
  return "session " + std::to_string(place.session) + " marker " + std::to_string(place.number);
}
}  // namespace

void act_change_session(Services& services, const Asker& asker, db::SessionId session, db::SessionPatch patch, std::string tag,
                        OutcomeDone done) {
  if (!begin_action(services, asker, Action::change_session, {"session " + std::to_string(session)}, done)) return;
  const auto work = [session, patch = std::move(patch), tag = std::move(tag)](Records&, db::Database& database) {
    return db::SessionEditor(database).patch(session, patch, tag);
  };
  ask_store(services, work, std::move(done));
}

void act_change_marker(Services& services, const Asker& asker, const MarkerPlace& place, db::MarkerPatch patch, std::string tag,
                       OutcomeDone done) {
  if (!begin_action(services, asker, Action::change_marker, {place_text(place)}, done)) return;
  const auto work = [place, patch = std::move(patch), tag = std::move(tag)](Records&, db::Database& database) {
    const auto changed = db::MarkerStore(database).change(place.session, place.number, patch, tag);
    if (!changed) return store_outcome(changed.error());
    Outcome outcome;
    outcome.row = marker_json(place.session, *changed).dump();
    return outcome;
  };
  ask_store_for(services, work, std::move(done));
}

void act_delete_marker(Services& services, const Asker& asker, const MarkerPlace& place, std::string tag, OutcomeDone done) {
  if (!begin_action(services, asker, Action::delete_marker, {place_text(place)}, done)) return;
  const auto work = [place, tag = std::move(tag)](Records&, db::Database& database) {
    return db::MarkerStore(database).remove(place.session, place.number, tag);
  };
  ask_store(services, work, std::move(done));
}

void act_change_device(Services& services, const Asker& asker, db::DeviceSettingsPatch patch, std::string tag, OutcomeDone done) {
  if (!begin_action(services, asker, Action::change_settings, {}, done)) return;
  auto changed = std::make_shared<db::DeviceSettings>();
  const auto work = [patch = std::move(patch), tag = std::move(tag), changed](Records&, db::Database& database) -> db::Status {
    auto after = db::change_device_settings(database, patch, tag);
    if (!after) return after.error();
    *changed = std::move(*after);
    return {};
  };
  ask_store(services, work, [&services, changed, done = std::move(done)](const Outcome& outcome) {
    if (outcome.done()) services.state.set_device(*changed);
    done(outcome);
  });
}

void act_set_clock(Services& services, const Asker& asker, std::int64_t utc_ms, OutcomeDone done) {
  if (!begin_action(services, asker, Action::set_time, {{}, {}, std::to_string(utc_ms)}, done)) return;
  const auto refuse = [&done](Reason reason, std::string detail) {
    Outcome outcome;
    outcome.kind = Outcome::Kind::refused;
    outcome.reason = reason;
    outcome.detail = std::move(detail);
    done(outcome);
  };
  const auto& newest = services.core.newest();
  const bool led = newest && newest->mode < contract::kModes.size() && contract::kModes[newest->mode].moving;
  if (!services.settings.set_clock)
    return refuse(Reason::system_clock,
                  "The operating system keeps the time of this computer: set it there, for example with timedatectl.");
  if (led || services.recorder.status().session)
    return refuse(Reason::not_now, "Only between two sessions: a jump would be in the recording.");
  if (const std::string why = services.settings.set_clock(utc_ms * 1'000'000); !why.empty()) return refuse(Reason::system_clock, why);
  done({});
}

}  // namespace hoist::server
