// The CAN cable with its bits: arbitration among all pending senders when the wire is free, true frame lengths with stuff bits,
// acknowledge, error frames. All participants receive each frame; an unacknowledged one is repeated.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "control/contract/can_frame.hpp"
#include "tests/machine/time.hpp"

namespace hoist::machine {

/// Bits of this very frame from its start bit to the end of frame, stuff bits included, without the intermission.
[[nodiscard]] unsigned wire_bits(const contract::CanFrame& frame);

/// Errors as a controller sees them; the numbers are the LEC codes of a C_CAN.
enum class CanError : std::uint8_t { none = 0, stuff = 1, form = 2, acknowledge = 3, bit1 = 4, bit0 = 5, crc = 6 };

/// A participant on the wire.
class CanStation {
 public:
  virtual ~CanStation() = default;
  /// Participates: receives, acknowledges, may send.
  [[nodiscard]] virtual bool on_bus() const = 0;
  /// The frame it would send next, if any. Called when the wire is free, before arbitration.
  [[nodiscard]] virtual bool offer(contract::CanFrame& frame) = 0;
  /// It has won arbitration: the frame's first bit is on the wire.
  virtual void began() = 0;
  /// The frame that it began is through, or was destroyed.
  virtual void sent(CanError error) = 0;
  /// The frame of another participant is complete, or was destroyed.
  virtual void heard(const contract::CanFrame& frame, CanError error) = 0;
  /// This many bit times without anything on the wire have passed.
  virtual void idle(std::uint64_t bits) = 0;
};

/// A controller's error counters (ISO 11898-1, fault confinement), which are the same in every chip.
class CanController : public CanStation {
 public:
  /// Increments on every change of the wire that concerns the chip.
  [[nodiscard]] std::uint64_t changes() const { return changes_; }
  [[nodiscard]] unsigned transmit_errors() const { return tec_; }
  [[nodiscard]] unsigned receive_errors() const { return rec_; }
  [[nodiscard]] bool bus_off() const { return bus_off_; }
  [[nodiscard]] std::uint64_t messages_lost() const { return lost_; }
  /// As if it had been disturbed so often while sending: the next disturbance switches it off the bus.
  void set_errors(unsigned transmit, unsigned receive) {
    tec_ = transmit;
    rec_ = receive;
    update_states();
  }

 protected:
  static constexpr std::uint64_t kIntegrationBits = 11, kRecoveryBits = 128 * 11;
  /// The counters have changed.
  virtual void update_states() = 0;
  void count_sent(CanError error) {
    if (error == CanError::none)
      tec_ -= tec_ > 0 ? 1 : 0;
    else if (error != CanError::acknowledge || tec_ < 128)
      // An error-passive sender whose frames get no acknowledge does not count further: a lone node does not leave the bus.
      tec_ += 8;
  }
  void count_heard(CanError error) {
    if (error != CanError::none)
      rec_ = rec_ < 255 ? rec_ + 1 : 255;
    else
      rec_ = rec_ > 127 ? 127 : (rec_ > 0 ? rec_ - 1 : 0);
  }

  std::uint64_t changes_{}, lost_{};
  unsigned tec_{}, rec_{};
  bool bus_off_{};
  std::uint64_t integrated_bits_{};  // recessive bits seen since the controller began to take part
  std::uint64_t recovery_bits_{};    // still to be seen after bus-off
};

class CanWire {
 public:
  static constexpr Time kBit = 192;  ///< 250 kbit/s
  static constexpr unsigned kErrorBits = 20;
  static constexpr unsigned kIntermissionBits = 3;

  /// Effect of a fault hook on the winning frame: none, destroy it, or drop it after the sender's acknowledge.
  enum class Mischief : std::uint8_t { none, corrupt, unheard, unacknowledged };
  using Hook = std::function<Mischief(std::size_t from, const contract::CanFrame&, Time now)>;

  [[nodiscard]] std::size_t connect(CanStation& station) {
    stations_.push_back(&station);
    plugged_.push_back(true);
    return stations_.size() - 1;
  }
  void plug(std::size_t station, bool in) { plugged_[station] = in; }
  [[nodiscard]] bool plugged(std::size_t station) const { return plugged_[station]; }
  void set_hook(Hook hook) { hook_ = std::move(hook); }
  /// Sees each frame that came through.
  void on_frame(std::function<void(const contract::CanFrame&, Time)> see) { see_ = std::move(see); }

  /// The next time of an event on the wire.
  [[nodiscard]] Time next() const { return busy_ ? until_ : kNever; }
  /// Advances to `now`: completes the present frame if due, and starts the next one if the wire is free.
  void advance(Time now);

  [[nodiscard]] std::uint64_t frames() const { return frames_; }
  [[nodiscard]] std::uint64_t errors() const { return errors_; }
  [[nodiscard]] Time busy_time() const { return busy_time_; }

 private:
  void begin(Time now);
  void finish();

  std::vector<CanStation*> stations_;
  std::vector<bool> plugged_;
  Hook hook_;
  std::function<void(const contract::CanFrame&, Time)> see_;
  bool busy_{};
  Time until_{};       // end of what is on the wire
  Time free_since_{};  // or since when it is free
  std::size_t sender_{};
  contract::CanFrame frame_{};
  CanError error_{CanError::none};
  bool heard_by_others_{true};
  std::uint64_t frames_{}, errors_{};
  Time busy_time_{};
};

/// The computer's end of the wire: sends its lowest id first, stores received frames.
class HostStation : public CanStation {
 public:
  void send(const contract::CanFrame& frame);
  [[nodiscard]] std::size_t waiting() const { return out_.size(); }
  std::deque<contract::CanFrame> received;
  void set_on_bus(bool on) { on_ = on; }

  [[nodiscard]] bool on_bus() const override { return on_; }
  [[nodiscard]] bool offer(contract::CanFrame& frame) override;
  void began() override {}
  void sent(CanError error) override;
  void heard(const contract::CanFrame& frame, CanError error) override {
    if (error == CanError::none) received.push_back(frame);
  }
  void idle(std::uint64_t) override {}

 private:
  std::deque<contract::CanFrame> out_;
  bool on_{true};
};

}  // namespace hoist::machine
