// A bus that a person has named, and one SDO client on it: what the sub-commands of `hoist bus` that talk to nodes share.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "control/bus/can_port.hpp"
#include "control/bus/sdo_client.hpp"

namespace hoist::tool {

class BusLine {
 public:
  /// Empty when the bus is up, otherwise the reason.
  [[nodiscard]] std::string open(const std::string& address);
  /// Passes on what comes during this time.
  void listen(double seconds, const std::function<void(const contract::CanFrame&)>& on_frame);
  /// Since the bus was opened.
  [[nodiscard]] double time_s() const;
  /// Why no frame can pass now; empty while the bus is up.
  [[nodiscard]] std::string missing() const;
  /// One frame of our own; false when the bus did not take it.
  [[nodiscard]] bool send(const contract::CanFrame& frame);
  /// The result of one transfer; read it in client(). `what` is for the sentence in problem().
  [[nodiscard]] bool upload(std::uint8_t node_id, std::uint16_t index, std::uint8_t sub);
  [[nodiscard]] bool download(std::uint8_t node_id, std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> content);
  [[nodiscard]] const bus::SdoClient& client() const { return client_; }
  /// Why the last transfer failed, as half a sentence.
  [[nodiscard]] std::string problem() const;

 private:
  void step(const std::function<void(const contract::CanFrame&)>& on_frame);
  [[nodiscard]] bool run();

  std::unique_ptr<bus::CanPort> port_;
  // A person waits, and not all computers are idle: five times the patience of the control core, whose steps a late answer must not hold up.
  bus::SdoClient client_{contract::SdoTiming{.answer_ns = 500'000'000}};
  std::array<contract::CanFrame, 256> frames_{};
  bool gone_ = false;
  std::uint64_t opened_ns_ = 0;
};

}  // namespace hoist::tool
