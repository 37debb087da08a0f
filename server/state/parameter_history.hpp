// Writes down every change of a parameter in force, by every actor and whether or not a session is recorded (db/store/parameter_log.hpp).
#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "db/store/parameter_log.hpp"
#include "server/link/core_desk.hpp"
#include "server/record/actor_list.hpp"
#include "server/record/recorder_desk.hpp"

namespace hoist::server {

// Why parameters change: one of db::kChangeReasons, and the name of the preset or profile.
struct ChangeOrigin {
  std::string_view reason = "set";
  std::optional<std::string> source = {};
};

class ParameterHistory final : public CoreListener {
 public:
  // Requests whose changes have not been heard of; the oldest is forgotten.
  static constexpr std::size_t kExpectedMost = 64;
  // Changes that wait for the disk; the oldest go first. A preset has some 20.
  static constexpr std::size_t kWaitingMost = 4096;
  // While the disk refuses, asked again this often.
  static constexpr std::uint64_t kRetry_ns = 1'000'000'000;

  ParameterHistory(const CoreDesk& core, RecorderDesk& records, const ActorList& actors, std::function<std::int64_t()> utc_ns)
      : core_(core), records_(records), actors_(actors), utc_ns_(std::move(utc_ns)) {}

  // Another file of recordings is in use: its newest values are compared with what is in force.
  void compare_file();
  // What the core changes for this request is told with this origin; 0 = the core was not asked.
  void expect(std::uint32_t request_id, ChangeOrigin origin);

  void on_core(bool) override {}
  void on_ticks(std::span<const contract::TickRecord>, std::uint64_t) override {}
  void on_lease(std::uint32_t, std::uint32_t) override {}
  void on_parameters(const contract::ParamsInForce& parameters) override;
  void on_event(const contract::Event& event) override;

  // After each look at the core: what has come goes to the recorder's thread, one piece at a time.
  void poll(std::uint64_t now_ns);
  [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }

 private:
  void compare(const contract::ParamsInForce& parameters);
  enum class Written : std::uint8_t { nothing, changes, all };

  const CoreDesk& core_;
  RecorderDesk& records_;
  const ActorList& actors_;
  std::function<std::int64_t()> utc_ns_;
  std::deque<std::pair<std::uint32_t, ChangeOrigin>> expected_;
  std::deque<db::ParameterChange> waiting_;
  std::uint64_t life_ = 0;                     // of the core whose parameters were compared with the log
  std::vector<db::ParameterChange> in_force_;  // to be compared with the file that is in use
  std::uint64_t comparison_ = 0;               // counts up with each new in_force_
  bool writing_ = false;
  std::uint64_t retry_ns_ = 0;
};

}  // namespace hoist::server
