// A small stand-in for the control core: owns the shared segments, answers commands by simple rules, publishes what the test wants.
#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "control/contract/can_frame.hpp"
#include "control/contract/shared_memory.hpp"
#include "control/publish/core_link.hpp"

namespace hoist::test {

class FakeCore {
 public:
  explicit FakeCore(const std::string& socket_path);
  ~FakeCore();

  // Changes what the next records say.
  void set(const std::function<void(contract::TickRecord&)>& change);
  // Called for each step before it is published.
  void set_each(std::function<void(contract::TickRecord&)> each);
  // While muted it reads commands and answers none, but goes on publishing.
  void mute(bool on);
  void publish_event(contract::Event event);
  void publish_bus(contract::BusRecord record);
  void publish_loop(const contract::LoopReport& report);
  // While held, changed parameters are in force and not stored; with a problem the disk has refused them.
  void hold_store(bool on, contract::StoreProblem problem = contract::StoreProblem::none);
  void refuse_stops(contract::StoreProblem problem);
  // The bus behind it: each step gives the frames of service that were accepted and takes what nodes say.
  using Bus = std::function<std::vector<contract::CanFrame>(const std::vector<contract::CanFrame>&)>;
  void set_bus(Bus bus);
  // Publishes `count` steps at once, as if their time had passed: 10 ms each. Returns when they are published.
  void skip(std::size_t count);

  [[nodiscard]] std::vector<contract::Command> commands();
  [[nodiscard]] contract::DriveCommand drive();
  [[nodiscard]] std::vector<contract::TickRecord> published();
  [[nodiscard]] contract::Mode mode();

 private:
  void main();
  void step();
  void take(const contract::Command& command);
  void answer(const contract::Command& command, std::uint32_t refusal_bits, std::uint32_t item = 0);
  void publish_tick();
  void store();

  std::unique_ptr<publish::CoreLink> link_;
  std::mutex mutex_;
  contract::TickRecord record_{};
  contract::ParamsInForce params_{};
  double trial_s_ = 0;
  std::uint32_t mark_exercise_ = 0;
  std::vector<std::pair<std::size_t, double>> staged_;
  bool staging_broken_ = false;
  std::vector<contract::Command> commands_;
  std::vector<contract::TickRecord> published_;
  std::vector<contract::Event> events_;
  std::vector<contract::BusRecord> frames_;
  contract::DriveCommand drive_{};
  std::size_t skip_ = 0;
  std::condition_variable skipped_;
  bool muted_ = false;
  bool store_held_ = false;
  contract::StoreReport store_{};
  bool service_ = false;
  Bus bus_;
  std::vector<contract::CanFrame> service_frames_;
  std::function<void(contract::TickRecord&)> each_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace hoist::test
