// The rehearsal that is chosen: lets it happen on the simulated hoist, hears what the staff do, and keeps the result with the session.
#pragma once
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string_view>

#include "server/link/core_desk.hpp"
#include "server/link/simulator_line.hpp"
#include "server/record/actor_list.hpp"
#include "server/record/recorder_desk.hpp"
#include "server/settings.hpp"
#include "server/state/hoist_state.hpp"
#include "server/state/rehearsal.hpp"

namespace hoist::server {

class RehearsalDesk final : public CoreListener {
 public:
  struct Parts {
    const Settings& settings;
    CoreDesk& core;
    HoistState& state;
    Recorder& recorder;
    RecorderDesk& records;
    ActorList& actors;
    std::function<std::uint64_t()> now_ns;  // steady
    std::function<std::int64_t()> utc_ns;
  };
  explicit RehearsalDesk(Parts parts) : parts_(std::move(parts)) {}
  ~RehearsalDesk() override { end(); }
  RehearsalDesk(const RehearsalDesk&) = delete;
  RehearsalDesk& operator=(const RehearsalDesk&) = delete;

  // Cuts the stream of a client for so long; set by the owner of the streams.
  void set_cut(std::function<void(std::uint32_t client, double seconds)> cut) { cut_ = std::move(cut); }

  // Why there can be no rehearsal here and now; nothing when there can.
  [[nodiscard]] std::optional<Reason> problem() const;
  // `client`: who chose it. Why not, or nothing.
  std::optional<Reason> choose(RehearsalKind kind, std::uint64_t seed, std::uint32_t client);
  // Ends the one under way, without a result.
  void cancel();
  // A row of the audit log.
  void did(std::uint32_t client, std::string_view action, std::string_view result);
  // RehearsalState of the contract.
  [[nodiscard]] nlohmann::json told() const;

  void on_core(bool connected) override;
  void on_ticks(std::span<const contract::TickRecord> records, std::uint64_t lost) override;
  void on_parameters(const contract::ParamsInForce&) override {}
  void on_lease(std::uint32_t epoch, std::uint32_t holder) override;
  void on_event(const contract::Event&) override {}

 private:
  void happen(const contract::TickRecord& record);
  [[nodiscard]] bool under_way() const;
  // What happened goes again.
  void end();
  void store();
  void give_back();

  Parts parts_;
  std::function<void(std::uint32_t, double)> cut_;
  SimulatorLine simulator_;
  std::optional<Rehearsal> rehearsal_;
  std::optional<db::Actor> actor_;        // who chose it
  std::optional<db::SessionId> session_;  // recorded when it happened
  std::uint64_t tick_ = 0;
  std::int64_t utc_ns_ = 0;
  std::uint32_t second_ = 0;           // the second therapist's client number; 0: none
  std::uint64_t second_until_ns_ = 0;  // has been handed control, and gives it back then
};

}  // namespace hoist::server
