// What a client may ask of the hoist, the same for REST and WebSocket: checked here, asked of the core, answered once.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/faults.hpp"
#include "db/store/retention.hpp"
#include "server/actions/outcome.hpp"
#include "server/actions/wishes.hpp"
#include "server/services.hpp"
#include "server/state/exercise.hpp"

namespace hoist::server {

void act_take_lease(Services& services, const Asker& asker, bool take_over, OutcomeDone done);
/// `gone`: not asked for by the client, whose connection has ended: the hoist misses it if it is led (console_lost).
void act_release_lease(Services& services, const Asker& asker, OutcomeDone done, bool gone = false);
/// The alarms in force stop sounding for two minutes, or sound again.
void act_pause_alarm(Services& services, const Asker& asker, bool paused, OutcomeDone done);
// Asks the holder for the lease, and tells it who asks; refused when it is free. `withdraw`: takes the request back.
void act_ask_lease(Services& services, const Asker& asker, bool withdraw, OutcomeDone done);
// The holder gives the lease away; the core refuses while the hoist moves.
void act_hand_over(Services& services, const Asker& asker, const HandOverWish& wish, OutcomeDone done);
// The holder keeps the lease: those who ask for it are told.
void act_keep_lease(Services& services, const Asker& asker, OutcomeDone done);
// Sets the pose to the start of the exercise, then asks for the mode; `exercise` is what gets recorded. For the mode "guided", `path` says what
// the hoist drives and is the exercise.
struct ModeWish {
  const nlohmann::json& mode;
  const nlohmann::json& exercise;
  const nlohmann::json& path;
  const nlohmann::json& start_again;
};
void act_mode(Services& services, const Asker& asker, const ModeWish& wish, OutcomeDone done);
// The exercise of the next walk, for all screens; refused while the hoist moves or a motion is under way.
void act_choose(Services& services, const Asker& asker, const nlohmann::json& exercise, OutcomeDone done);
// The task of the next walks (db/tasks), which is also their exercise, for all screens; {"task": null} for none. Refused as act_choose.
void act_choose_task(Services& services, const Asker& asker, const nlohmann::json& wish, OutcomeDone done);
// A rehearsal of staff, chosen by its name in "rehearsal"; null for none. Only on a simulated hoist.
void act_choose_rehearsal(Services& services, const Asker& asker, const nlohmann::json& wish, OutcomeDone done);
// The end of the chosen task is reached: its motion ends as if a person had ended it.
void end_task(Services& services);
// A driving command as a protocol read it; a missing value: the message had none.
struct DriveWish {
  std::optional<std::uint64_t> sequence, echo_time_ns;
  std::optional<double> speed_norm, yaw_norm;
  std::optional<bool> held;
};
// Of one client: its newest driving command that the core has.
struct Hand {
  std::uint64_t sequence = 0;
  bool held = false;
};
struct DriveRefusal {
  contract::Refusal refusal = contract::Refusal::out_of_range;
  std::optional<Reason> reason = {};  // where the refusal does not say it all
  bool operator==(const DriveRefusal&) const = default;
  [[nodiscard]] std::string_view text_en() const;
};
// Passes the wish on at once; nothing when the core has it, else why not. Letting go is passed on even from an otherwise invalid message, since it
// can only stop. A sign-in that runs out takes no held stick out of a hand, but the next press is refused.
[[nodiscard]] std::optional<DriveRefusal> act_drive(Services& services, const Asker& asker, const DriveWish& wish, Hand& hand);
// Whether the connection of a client whose sign-in has run out may be closed now: not while the hoist moves under its lease.
[[nodiscard]] bool may_close(const Services& services, std::uint32_t client);
// Never refused. `done` may be empty.
void act_stop(Services& services, const Asker& asker, OutcomeDone done);
/// `seen`: names of the faults that were shown when the hand went down, or null; when another has come since, the core refuses.
void act_acknowledge(Services& services, const Asker& asker, const nlohmann::json& seen, OutcomeDone done);
// Begins a step of the calibration table; `harness_empty` is true where the table asks for it.
void act_calibrate(Services& services, const Asker& asker, const CalibrateWish& wish, OutcomeDone done);
// What the operator measured; x_m, y_m and turning belong to a driven square.
void act_measure(Services& services, const Asker& asker, const MeasureWish& measured, OutcomeDone done);
// The result becomes parameters, with today's date.
void act_use_calibration(Services& services, const Asker& asker, OutcomeDone done);
void act_cancel_calibration(Services& services, const Asker& asker, OutcomeDone done);
void act_neutral(Services& services, const Asker& asker, OutcomeDone done);
void act_pose(Services& services, const Asker& asker, const StartPose& pose, OutcomeDone done);
// All or nothing.
// `revert_after_s`: nothing, or the seconds after which the values before come back unless confirmed. `version`: of the parameters the change was
// made for, 0 = whichever are in force; the core refuses it when they are others by then (H27).
void act_set(Services& services, const Asker& asker, const NumbersByName& values, std::optional<double> revert_after_s,
             std::uint32_t version, OutcomeDone done);
// Keeps the values on trial. `version`: the one that was shown, or 0; the core refuses when another client has changed
// the parameters since (H27).
void act_keep_trial(Services& services, const Asker& asker, std::uint32_t version, OutcomeDone done);
// Reverts the values on trial at once.
void act_undo_trial(Services& services, const Asker& asker, OutcomeDone done);
// Puts a checked program into a node; done when the core lets it begin.
void act_update_firmware(Services& services, const Asker& asker, std::vector<std::uint8_t> image, contract::Node node, bool force,
                         OutcomeDone done);
void act_preset(Services& services, const Asker& asker, const std::string& name, std::uint32_t version, OutcomeDone done);

// A marker now, into the session with this id, or without one into the session that is being recorded.
void act_mark(Services& services, const Asker& asker, std::optional<db::SessionId> session, MarkerWish wish, OutcomeDone done);
// Begins or ends a recording by hand.
struct RecordWish {
  bool starts = false;
  std::optional<std::string> subject;
  std::string note;
};
void act_record(Services& services, const Asker& asker, RecordWish wish, OutcomeDone done);
// `tag` of what was looked at, empty = any. Jobs give way until it is done: the log that still holds the deleted data can be truncated only while
// no connection reads.
void act_delete_session(Services& services, const Asker& asker, db::SessionId session, std::string tag, OutcomeDone done);
// How long sessions are kept; `tag` of the rule that was looked at, empty = any.
void act_set_retention(Services& services, const Asker& asker, const db::RetentionRule& rule, std::string tag, OutcomeDone done);
// Long work; `Outcome::job` is its number. Refused as busy when too many wait.
void act_start_job(Services& services, const Asker& asker, JobKind kind, JobArguments arguments, OutcomeDone done);
// Opens or closes /foxglove and /rosbridge; connections that are open are closed. Done when it is stored.
void act_set_tools(Services& services, const Asker& asker, bool on, const std::string& expected, OutcomeDone done);
void act_cancel_job(Services& services, const Asker& asker, JobId job, OutcomeDone done);

[[nodiscard]] std::vector<std::string> refusal_names(std::uint32_t bits);

}  // namespace hoist::server
