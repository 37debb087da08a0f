// What every action and protocol may use. Owned by App; all of it is touched by the network thread only.
#pragma once
#include <cstdint>
#include <functional>
#include <string_view>

#include "server/counters.hpp"
#include "server/jobs/jobs.hpp"
#include "server/link/core_desk.hpp"
#include "server/link/firmware_desk.hpp"
#include "server/people/people_desk.hpp"
#include "server/people/set_up.hpp"
#include "server/people/sign_in_guard.hpp"
#include "server/record/actor_list.hpp"
#include "server/record/recorder.hpp"
#include "server/record/recorder_desk.hpp"
#include "server/settings.hpp"
#include "server/state/hoist_state.hpp"
#include "server/state/parameter_history.hpp"
#include "server/state/rehearsal_desk.hpp"
#include "server/state/tool_switch.hpp"

namespace hoist::server {

struct Session;

struct Services {
  const Settings& settings;
  Counters& counters;
  CoreDesk& core;
  FirmwareDesk& firmware;
  HoistState& state;
  ParameterHistory& history;              // every change of a parameter
  RehearsalDesk& rehearsals;              // of staff, on a simulated hoist
  ToolSwitch& tools;                      // whether /foxglove and /rosbridge are open
  Recorder& recorder;                     // its state
  RecorderDesk& records;                  // work for its thread
  PeopleDesk& people;                     // accounts, and the audit log
  Jobs& jobs;                             // long work, on a thread of its own
  std::function<std::uint64_t()> now_ns;  // steady
  std::function<std::int64_t()> utc_ns;   // wall
  ActorList& actors;                      // numbers of connections and REST sessions, and who is behind them
  SignInGuard& guard;                     // slows guessing of passwords down
  bool needs_set_up = false;              // the file of accounts was read and holds no engineer
  SetUp& set_up;                          // the switch and the code of the first set-up
  // Closes the WebSockets of these sessions; the reason is for people.
  std::function<void(const std::function<bool(const Session&)>&, std::string_view)> close_sockets;
  std::string computer_name = {};  // as the operating system calls it
  std::int64_t started_utc_ns = 0;
  std::uint64_t started_ns = 0;
  std::size_t live_clients = 0;  // open WebSockets
  std::uint64_t ends_asked = 0;  // requests to end motion so far: a start that was asked for before one of them is over
};

}  // namespace hoist::server
