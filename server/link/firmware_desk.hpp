// New programs for nodes through the running core: puts it into service, passes the update's frames as commands and reads the answers from
// the recorded bus. One update at a time. One thread, told the time, like the CoreDesk it works with.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "control/bus/firmware_update.hpp"
#include "server/link/core_desk.hpp"

namespace hoist::server {

// What the running update has come to, or the last one.
struct FirmwareUpdateState {
  enum class Result : std::uint8_t { running, done, unchanged, failed, interrupted };
  contract::Node node = contract::Node::core;
  std::uint32_t version = 0;  // of the program that was sent
  bus::FirmwareUpdate::Phase phase = bus::FirmwareUpdate::Phase::listening;
  Result result = Result::running;
  std::size_t bytes_sent = 0, bytes_total = 0;
  std::optional<double> seconds_left;  // of the sending
  std::string text;                    // what happened and what to do next
};

// What a node has last said of its program on the bus, in answer to any client.
struct NodeSaid {
  std::optional<std::uint32_t> product, revision, version, crc;
  bool operator==(const NodeSaid&) const = default;
};

class FirmwareDesk {
 public:
  explicit FirmwareDesk(CoreDesk& core);

  // `image` has been checked and is for this kind of node; `asker` carries client, lease epoch and, in `b`, the role. `done` is called once,
  // when the core is in service or has refused; kind busy: another update is under way.
  void begin(std::vector<std::uint8_t> image, contract::Node node, bool force, const contract::Command& asker, CoreDesk::Done done);
  // After the CoreDesk's poll.
  void poll(std::uint64_t now_ns);

  [[nodiscard]] bool busy() const { return asked_ || machine_.has_value(); }
  // Whose update it is, 0 when there is none: this client's lease must stay meanwhile.
  [[nodiscard]] std::uint32_t client() const { return busy() ? asker_.client : 0; }
  [[nodiscard]] const std::optional<FirmwareUpdateState>& state() const { return state_; }
  [[nodiscard]] const NodeSaid& said(contract::Node node) const { return said_[static_cast<std::size_t>(node)]; }
  // Counts up whenever state() is another.
  [[nodiscard]] std::uint64_t changes() const { return changes_; }

 private:
  void start(bool force);
  void read_bus();
  void note(const contract::CanFrame& frame);
  void ask(contract::CommandKind kind, const contract::CanFrame* frame);
  void end(FirmwareUpdateState::Result result, std::string text);
  void tell();

  CoreDesk& core_;
  publish::BusReader bus_;  // from the oldest frame on: what the nodes said to the core before this server came counts, too
  std::vector<contract::BusRecord> buffer_;
  std::array<NodeSaid, contract::kRemoteNodeCount> said_{};
  std::vector<std::uint8_t> image_;
  contract::Command asker_{};
  contract::Node node_ = contract::Node::core;
  std::optional<bus::FirmwareUpdate> machine_;
  std::optional<FirmwareUpdateState> state_;
  std::uint64_t now_ns_ = 0, word_ns_ = 0, sending_ns_ = 0, changes_ = 0;
  std::uint32_t run_ = 0;   // an answer to an earlier update is not one to this
  bool asked_ = false;      // the core has not answered yet whether it is in service
  bool frame_out_ = false;  // a frame waits for the core's answer
};

}  // namespace hoist::server
