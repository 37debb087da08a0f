// The whole loop in virtual time: the real control step, the shipped node sources, the bus, the machine and the patient. There is no
// waiting, so a minute takes some hundredths of a second, and the same options give the same run bit for bit.
//
// The loop is the one hoist-control runs: wake every 10 ms, hand over the frames received, step, send the frames in their order.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "control/contract/commands.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/guided_path.hpp"
#include "control/contract/param_set.hpp"
#include "control/contract/params.hpp"
#include "control/contract/signals.hpp"
#include "control/contract/slcan_codec.hpp"
#include "control/core/tick.hpp"
#include "firmware/sim/world.hpp"

namespace hoist::loop {

struct ClosedLoopOptions {
  sim::WorldOptions world{};  ///< host_in_process is set by the loop
  contract::Params params{};
  bool through_gateway{false};  ///< frames go as SLCAN lines over the gateway's serial line at 1 Mbaud instead of straight to the bus
};

/// One driver with client number 1 sits at the console.
class ClosedLoop {
 public:
  explicit ClosedLoop(const ClosedLoopOptions& options);

  /// One control step and the ten milliseconds of the world that follow it.
  void step();
  void run(double seconds);
  /// Steps until `done` or for this long; whether it came to be.
  bool run_until(const std::function<bool()>& done, double at_most_s);

  // The driver's wishes, carried out in the next step. Each returns the number of the request; the answer is among the events.
  std::uint32_t ask(contract::CommandKind kind, std::uint32_t a = 0, double v0 = 0.0, double v1 = 0.0, double v2 = 0.0,
                    std::uint32_t b = 0);
  /// The same by another client of the server.
  std::uint32_t ask_as(std::uint32_t client, contract::CommandKind kind, std::uint32_t a = 0, double v0 = 0.0, double v1 = 0.0,
                       double v2 = 0.0, std::uint32_t b = 0);
  /// A command or a driving command, unchanged, as from a hostile or faulty sender.
  void put(const contract::Command& command) { commands_.push_back(command); }
  void put_drive(const contract::DriveCommand& command) { stranger_drive_ = command, stranger_drives_ = true; }
  /// Waits for standby, takes the lease and requests the mode. False when it is not in force within 10 s.
  bool start(contract::Mode mode);
  /// Waits for standby, takes the lease and begins this exercise; the hand is still off the button. False when it is not in force within 10 s.
  bool start_guided(const contract::GuidedPath& path);
  /// Holds the joystick there from now on, repeated every 40 ms; let_go ends with a release command, silence without one.
  void hold_stick(double speed_norm, double yaw_norm);
  void let_go();
  void fall_silent() { stick_held_ = false; }

  // The link from the stick to the server, in order as with TCP.
  /// All sent messages are lost.
  void cut_link(bool cut);
  /// Sent messages wait, and arrive in a burst when this ends.
  void stall_link(bool stalled) { link_stalled_ = stalled; }
  /// Each driving command takes as many steps more as this says; an empty one ends that.
  void delay_commands(std::function<std::uint32_t()> ticks) { link_delay_ = std::move(ticks); }

  // Faults of the computer itself.
  void kill_core() { core_runs_ = false; }
  /// The core continues after kill_core() as if suspended: same state, and it sees its lateness.
  void resume_core() { core_runs_ = true; }
  /// A new core, as after a crash, without the old state.
  void restart_core();
  void stop_server() { server_runs_ = false; }
  void resume_server() { server_runs_ = true; }
  /// A new server, as after a crash: its numbers restart.
  void restart_server();
  /// False: the computer's CAN interface is off the bus and reports it.
  void set_bus_up(bool up) { bus_up_ = up; }
  /// The next step begins this late, as seen by the core; the world continues meanwhile.
  void be_late(double seconds) { lateness_s_ = seconds; }

  [[nodiscard]] const contract::TickRecord& record() const { return outputs_->record; }
  [[nodiscard]] contract::Mode mode() const { return static_cast<contract::Mode>(record().mode); }
  [[nodiscard]] bool fault(contract::Fault which) const;
  [[nodiscard]] const std::vector<contract::Event>& events() const { return events_; }
  /// Whether a fault has been raised at any time.
  [[nodiscard]] bool ever_raised(contract::Fault which) const;
  [[nodiscard]] sim::World& world() { return world_; }
  [[nodiscard]] const core::CoreState& core() const { return *core_; }
  /// Whether the core was run by the latest step.
  [[nodiscard]] bool core_runs() const { return core_runs_; }
  [[nodiscard]] double time_s() const { return world_.time_s(); }
  [[nodiscard]] std::uint64_t ticks() const { return ticks_; }
  /// Digest of the world and of every record so far.
  [[nodiscard]] std::uint64_t digest() const;
  /// Sees each frame the core sends, after the step.
  void on_sent(std::function<void(const contract::CanFrame&)> see) { see_ = std::move(see); }
  /// Sees what each step is given, before the step; its spans live only during the call.
  void on_inputs(std::function<void(const core::TickInputs&)> see) { see_inputs_ = std::move(see); }
  /// After every millisecond of the world.
  void on_millisecond(std::function<void()> see) { see_millisecond_ = std::move(see); }
  /// Observer of each step's inputs and outputs, before they leave.
  void on_step(std::function<void(const core::TickInputs&, const core::TickOutputs&)> see) { see_step_ = std::move(see); }
  /// Fault injection, to show that a test fails: may change the core's state and outputs before they leave.
  void break_core(std::function<void(core::CoreState&, core::TickOutputs&)> how) { break_ = std::move(how); }
  /// Noise on the gateway's serial line: sees each character and may change it.
  void set_serial_noise(std::function<void(char&)> noise) { noise_ = std::move(noise); }

 private:
  static constexpr std::uint32_t kClient = 1;
  static constexpr std::uint64_t kClockStart_ns = 1'000'000'000;
  static constexpr std::size_t kFramesMax = 256;

  /// Waits for standby, takes the lease, waits until a start is allowed.
  bool may_start();
  void send(const contract::CanFrame& frame);
  void drive_with_stick(core::TickInputs& inputs);
  std::size_t receive();
  void move_serial_line();

  sim::World world_;
  contract::Params params_;
  bool through_gateway_;
  std::string to_gateway_;  // characters waiting for the serial line
  contract::SlcanDecoder decoder_;
  std::uint32_t gateway_refusals_ = 0;  // lines refused in a row, with no frame in between
  std::size_t frames_count_{};          // received through the gateway since the last step
  std::unique_ptr<core::CoreState> core_;
  std::unique_ptr<core::TickOutputs> outputs_;
  std::array<contract::CanFrame, kFramesMax> frames_{};
  std::vector<contract::Command> commands_;
  std::vector<contract::Event> events_;
  std::function<void(const contract::CanFrame&)> see_;
  std::function<void(const core::TickInputs&)> see_inputs_;
  std::function<void()> see_millisecond_;
  std::function<void(core::CoreState&, core::TickOutputs&)> break_;
  std::function<void(const core::TickInputs&, const core::TickOutputs&)> see_step_;
  std::function<void(char&)> noise_;
  std::function<std::uint32_t()> link_delay_;
  struct UnderWay {
    std::uint64_t due_tick;
    contract::DriveCommand command;
  };
  std::deque<UnderWay> link_;  // driving commands in transit
  contract::DriveCommand stranger_drive_{};
  std::uint64_t ticks_{};
  contract::ParamSetSeal seal_;  // over what was staged
  std::uint64_t sequence_{};
  std::uint32_t requests_{};
  std::uint64_t drive_sequence_{};
  std::uint64_t heartbeat_{};
  std::uint64_t record_hash_{};
  double speed_norm_{};
  double yaw_norm_{};
  double lateness_s_{};
  std::uint64_t server_life_{};
  bool link_cut_{false};
  bool link_stalled_{false};
  bool stranger_drives_{false};
  bool bus_up_{true};
  bool stick_held_{false};
  bool last_command_{false};
  bool core_runs_{true};
  bool server_runs_{true};
};

/// Speed of the whole closed loop (core, six nodes, plant, patient walking a figure of eight): simulated seconds for
/// each second of one core.
[[nodiscard]] double simulated_seconds_per_second(double virtual_s);

}  // namespace hoist::loop
