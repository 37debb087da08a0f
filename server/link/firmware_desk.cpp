#include "server/link/firmware_desk.hpp"

#include <bit>
#include <utility>

namespace hoist::server {

using bus::FirmwareUpdate;
using contract::CanFrame;
using contract::Command;
using contract::CommandKind;
using Result = FirmwareUpdateState::Result;

namespace {
// A full bus has some 18 frames in 10 ms; what a hold-up left behind is worked off in a few polls.
constexpr std::size_t kFramesPerPoll = 1024;
// The core ends service after two seconds without a word, and a node may take longer to come back.
constexpr std::uint64_t kWordEvery_ns = 500'000'000;
constexpr const char* kInterrupted =
    "The update was broken off: STOP was pressed, somebody else took control, or the control core was away. If the node is in its loader "
    "now, send the program again.";
}  // namespace

FirmwareDesk::FirmwareDesk(CoreDesk& core) : core_(core), bus_(core.link(), publish::ReadFrom::oldest), buffer_(kFramesPerPoll) {}

void FirmwareDesk::begin(std::vector<std::uint8_t> image, contract::Node node, bool force, const Command& asker, CoreDesk::Done done) {
  if (busy()) {
    done({.kind = CoreAnswer::Kind::busy});
    return;
  }
  image_ = std::move(image);
  node_ = node;
  asker_ = asker;
  asked_ = true;
  ++run_;
  Command command = asker_;
  command.kind = CommandKind::begin_service;
  core_.ask(command, [this, force, done = std::move(done)](const CoreAnswer& answer) {
    asked_ = false;
    if (answer.done()) start(force);
    done(answer);
  });
}

void FirmwareDesk::start(bool force) {
  machine_.emplace(image_, node_, FirmwareUpdate::Options{.force = force, .guarded = true});
  frame_out_ = false;
  word_ns_ = now_ns_;
  sending_ns_ = 0;
  state_ = FirmwareUpdateState{};
  state_->node = node_;
  state_->version = machine_->header().version;
  state_->bytes_total = image_.size();
  ++changes_;
}

void FirmwareDesk::ask(CommandKind kind, const CanFrame* frame) {
  Command command = asker_;
  command.kind = kind;
  if (frame != nullptr) {
    frame_out_ = true;
    command.a = frame->id;
    command.b = 0;
    command.v0 = std::bit_cast<double>(frame->data);
    command.v1 = frame->dlc;
  }
  core_.ask(command, [this, run = run_, of_frame = frame != nullptr](const CoreAnswer& answer) {
    if (run != run_ || !machine_) return;
    if (of_frame) frame_out_ = false;
    if (!answer.done()) end(Result::interrupted, kInterrupted);
  });
}

void FirmwareDesk::end(Result result, std::string text) {
  state_->result = result;
  state_->text = std::move(text);
  tell();
  state_->seconds_left.reset();
  machine_.reset();
  image_.clear();
  ++run_;
  // Refused when service has ended by itself, which is as good.
  Command command = asker_;
  command.kind = CommandKind::end_service;
  core_.ask(command, [](const CoreAnswer&) {});
}

void FirmwareDesk::note(const CanFrame& frame) {
  const std::uint32_t service = frame.id & 0x780U;
  if (service != contract::canopen::kHeartbeatBase && service != contract::canopen::kSdoReplyBase) return;
  const auto node = contract::find_node(static_cast<std::uint8_t>(frame.id & 0x7FU));
  if (!node || *node == contract::Node::core) return;
  NodeSaid& said = said_[static_cast<std::size_t>(*node)];
  if (service == contract::canopen::kHeartbeatBase && frame.dlc == 1 && frame.data[0] == 0) said = {};  // it has restarted
  if (service != contract::canopen::kSdoReplyBase || frame.dlc != 8 || frame.data[0] != contract::canopen::sdo_upload_reply_command(4))
    return;
  const std::uint32_t object = contract::read_le(&frame.data[1], 3);
  const std::uint32_t value = contract::read_le(&frame.data[4], 4);
  if (object == 0x021018) said.product = value;
  if (object == 0x031018) said.revision = value;
  if (object == (contract::kProgramVersion | 0x010000U)) said.version = value;
  if (object == (contract::kProgramId | 0x010000U)) said.crc = value;
}

void FirmwareDesk::read_bus() {
  const auto got = bus_.read(buffer_);
  for (std::size_t i = 0; i < got.count; ++i) {
    const contract::BusRecord& record = buffer_[i];
    if (record.sent != 0 || record.flags != 0 || record.id > 0x7FF || record.dlc > 8) continue;
    CanFrame frame{record.id, record.dlc, 0, {}};
    frame.data = std::bit_cast<decltype(frame.data)>(record.data);
    note(frame);
    if (machine_) machine_->on_frame(frame);
  }
}

void FirmwareDesk::poll(std::uint64_t now_ns) {
  now_ns_ = now_ns;
  read_bus();
  if (!machine_) return;
  if (!frame_out_) {
    if (const auto frame = machine_->step(now_ns)) ask(CommandKind::service_frame, &*frame);
    if (!machine_) return;  // the core is away
  }
  if (machine_->over() && !frame_out_) {
    const bool done = machine_->phase() == FirmwareUpdate::Phase::done;
    const Result result = !done ? Result::failed : machine_->was_there() ? Result::unchanged : Result::done;
    end(result, std::string{result == Result::done        ? "The node runs the new program."
                            : result == Result::unchanged ? "The node had exactly this program already."
                                                          : bus::failure_text(machine_->failure())});
    return;
  }
  if (now_ns - word_ns_ >= kWordEvery_ns) {
    word_ns_ = now_ns;
    ask(CommandKind::begin_service, nullptr);
    if (!machine_) return;
  }
  tell();
}

void FirmwareDesk::tell() {
  FirmwareUpdateState& state = *state_;
  const std::size_t sent = machine_->bytes_sent();
  const auto phase = machine_->phase();
  const bool running = state.result == Result::running;
  if (running && phase == state.phase && sent == state.bytes_sent) return;
  if (phase == FirmwareUpdate::Phase::sending && (sending_ns_ == 0 || sent < state.bytes_sent)) sending_ns_ = now_ns_;
  state.phase = phase;
  state.bytes_sent = sent;
  state.seconds_left.reset();
  if (phase == FirmwareUpdate::Phase::sending && sent > 0)
    state.seconds_left =
        static_cast<double>(now_ns_ - sending_ns_) * 1e-9 * static_cast<double>(state.bytes_total - sent) / static_cast<double>(sent);
  ++changes_;
}

}  // namespace hoist::server
