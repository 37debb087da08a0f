// A CAN port whose input node is a PoKeys: the real port carries all other frames. Frames with the input node's ids from the bus are
// refused, so that bumpers have one source.
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

#include "control/bus/can_port.hpp"
#include "control/bus/pokeys/io_stand_in.hpp"

namespace hoist::bus::pokeys {

struct InputOptions {
  Wiring wiring;
  std::unique_ptr<Transport> transport;
  std::function<void()> at_thread_start;  // called by the asking thread before anything else; may be empty
};
// "pokeys:udp:HOST[:PORT]", "pokeys:/dev/hidraw0" or "pokeys:usb", then optionally
// "?bumpers=1,2,3,4&switches=5,6,7,8&batteries=41,42&full_v=20&sync=9".
// Empty when it was understood, otherwise the refusal.
[[nodiscard]] std::string parse_inputs(std::string_view text, InputOptions& options);

class InputPort final : public CanPort {
 public:
  // Starts polling the device, in its own thread.
  InputPort(std::unique_ptr<CanPort> port, InputOptions options);
  ~InputPort() override;
  InputPort(const InputPort&) = delete;
  InputPort& operator=(const InputPort&) = delete;

  std::size_t receive(std::span<contract::CanFrame> out, std::uint64_t now_ns) noexcept override;
  std::size_t send(std::span<const contract::CanFrame> frames, std::uint64_t now_ns) noexcept override;
  [[nodiscard]] bool up() const noexcept override { return port_->up(); }
  [[nodiscard]] const PortCounters& counters() const noexcept override { return counters_; }
  [[nodiscard]] const char* problem() const noexcept override { return port_->problem(); }
  [[nodiscard]] const char* remark() const noexcept override { return port_->remark(); }
  // The error of the inputs; empty while they work. Any thread may call this.
  [[nodiscard]] const char* input_problem() const noexcept { return input_problem_.load(std::memory_order_relaxed); }
  // Frames of a second input node on the bus that were refused.
  [[nodiscard]] std::uint32_t doubles() const noexcept { return doubles_; }

 private:
  void run();
  void publish();
  [[nodiscard]] Readings latest(std::uint8_t& pressed) noexcept;
  void copy_counters() noexcept;

  std::unique_ptr<CanPort> port_;
  std::unique_ptr<Transport> transport_;
  Device device_;
  IoStandIn stand_in_;
  PortCounters counters_;
  std::uint32_t doubles_ = 0;
  // From the polling thread to the control thread: each word is atomic and holds its time, so a reading never seems newer than it is.
  std::atomic<std::uint64_t> inputs_word_{0};     // 40 bits of time in ms, bumpers, switches
  std::atomic<std::uint64_t> batteries_word_{0};  // 36 bits of time in ms (two years), two voltages of 14 bits
  std::atomic<std::uint8_t> pressed_{0};          // touched since the control thread last looked
  std::atomic<bool> sync_{false};                 // the other way: level of the synchronisation output
  std::atomic<const char*> input_problem_{""};
  std::atomic<bool> ending_{false};
  int wake_fd_ = -1;
  std::thread thread_;
};

}  // namespace hoist::bus::pokeys
