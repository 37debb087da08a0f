// Brings a new program into a node over the bus, without I/O and without a clock: frames in, at most one frame out per step, time as
// nanoseconds. Used by the tool, by the server and by tests in virtual time.
//
// Sequence: refuse if a control computer is on the bus; refuse if a drive is enabled; read the node's identity and program; enter the
// loader; send the program in segments; compare flash status and CRC; start it; read the running program's CRC and version. Nothing is
// erased before the last refusal.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "control/bus/sdo_client.hpp"
#include "control/contract/can_dictionary.hpp"
#include "control/contract/firmware_image.hpp"

namespace hoist::bus {

// The bus is otherwise idle during an update, so requests need no pacing.
inline constexpr SdoTiming kQuestionTiming{.answer_ns = 200'000'000, .tries = 3, .pace_ns = 0};
// Not repeatable: a running program refuses a second start.
inline constexpr SdoTiming kOnceTiming{.answer_ns = 1'000'000'000, .tries = 1, .pace_ns = 0};
// A loader answers the segment that begins a new erase unit when the unit is erased: 100 ms on the LPC11C24 (data sheet table 10).
inline constexpr SdoTiming kProgramTiming{.answer_ns = 1'000'000'000, .tries = 1, .pace_ns = 0};

// Identity and program of one node.
struct NodeProgram {
  bool present = false;   // a frame of it was received
  bool answered = false;  // it said who it is
  bool in_loader = false;
  bool simulated = false;
  std::uint32_t product = 0, version = 0, crc = 0, flash_status = 0;
};

// Reads them from one node: identity, version and CRC of its program and, in the loader, its flash status. 0 for a program without a
// version.
class ProgramQuery {
 public:
  void begin(std::uint8_t node_id) {
    *this = ProgramQuery();
    node_id_ = node_id;
    busy_ = true;
    ask(node_id_, 0x1018, 2);
  }
  [[nodiscard]] bool busy() const { return busy_; }
  [[nodiscard]] const NodeProgram& result() const { return result_; }
  void on_frame(const contract::CanFrame& frame) { exchange_.on_frame(frame); }
  std::optional<contract::CanFrame> step(std::uint64_t now_ns) {
    if (!busy_) return std::nullopt;
    if (const auto frame = exchange_.step(now_ns)) return frame;
    if (exchange_.outcome() == SdoClient::Outcome::busy) return std::nullopt;
    const bool done = exchange_.outcome() == SdoClient::Outcome::done;
    const std::uint32_t value = done ? exchange_.value() : 0;
    switch (question_++) {
      case 0:
        result_.present = result_.answered = done;
        result_.product = value;
        result_.in_loader = (value & contract::kLoaderProduct) != 0;
        result_.simulated = (value & contract::canopen::kSimulatedProduct) != 0;
        if (!done) {
          busy_ = false;
          return std::nullopt;
        }
        ask(node_id_, contract::kProgramVersion, 1);
        break;
      case 1:
        result_.version = value;
        ask(node_id_, contract::kProgramId, 1);
        break;
      case 2:
        result_.crc = value;
        if (!result_.in_loader) {
          busy_ = false;
          return std::nullopt;
        }
        ask(node_id_, contract::kFlashStatus, 1);
        break;
      default:
        result_.flash_status = value;
        busy_ = false;
        return std::nullopt;
    }
    return exchange_.step(now_ns);
  }

 private:
  void ask(std::uint8_t node_id, std::uint16_t index, std::uint8_t sub) {
    if (!exchange_.upload(node_id, index, sub)) busy_ = false;
  }
  std::uint8_t node_id_ = 0;
  bool busy_ = false;
  int question_ = 0;
  NodeProgram result_{};
  SdoClient exchange_{kQuestionTiming};
};

class FirmwareUpdate {
 public:
  enum class Phase : std::uint8_t { listening, asking_drives, asking_node, entering_loader, sending, checking, starting, done, failed };
  enum class Failure : std::uint8_t {
    none,
    bad_image,        // not a program, or not for this kind of node
    computer_active,  // a control computer is on the bus
    drive_enabled,    // a drive holds or moves its wheel, or does not say
    absent,           // the node does not answer
    wrong_chip,       // a program for silicon and a simulated node, or vice versa
    older,            // the node runs a newer program
    not_ready,        // the node refuses to end its program
    no_loader,        // it did not restart in its loader
    refused,          // the loader refused the program
    broken_off,       // three transfers were begun and none came to its end
    not_whole,        // the loader's CRC differs from what was sent
    did_not_start,    // after the start it does not run a program with this CRC
  };
  struct Options {
    bool force = false;  // also an older or the same program
    // The frames pass through the control computer, which keeps the drives off and sends no SDO itself: its frames are no reason to refuse.
    bool guarded = false;
  };

  // `image` must outlive this.
  FirmwareUpdate(std::span<const std::uint8_t> image, contract::Node node, Options options)
      : image_(image), node_(node), node_id_(contract::node_id(node)), options_(options) {
    if (contract::check_image_file(image) != contract::ImageError::none) {
      fail(Failure::bad_image);
      return;
    }
    header_ = contract::read_image_header(image);
    if (node == contract::Node::core || header_.kind != static_cast<std::uint8_t>(contract::kNodes[static_cast<std::size_t>(node)].kind))
      fail(Failure::bad_image);
  }

  [[nodiscard]] Phase phase() const { return phase_; }
  [[nodiscard]] bool over() const { return phase_ == Phase::done || phase_ == Phase::failed; }
  [[nodiscard]] Failure failure() const { return failure_; }
  // The node had exactly this program already, and was left alone.
  [[nodiscard]] bool was_there() const { return was_there_; }
  // The last abort code that the node gave; 0 when it gave none.
  [[nodiscard]] std::uint32_t abort_code() const { return abort_code_; }
  [[nodiscard]] const contract::ImageHeader& header() const { return header_; }
  [[nodiscard]] const NodeProgram& before() const { return before_; }  // valid from entering_loader on
  [[nodiscard]] std::size_t bytes_sent() const {
    return phase_ == Phase::sending ? exchange_.confirmed() : (phase_ > Phase::sending && phase_ != Phase::failed ? image_.size() : 0);
  }
  [[nodiscard]] int tries() const { return tries_; }

  void on_frame(const contract::CanFrame& frame) {
    namespace canopen = contract::canopen;
    if (over() || frame.flags != 0) return;
    const std::uint32_t service = frame.id & 0x780U;
    if (phase_ <= Phase::entering_loader) {
      if (!options_.guarded &&
          (frame.id == canopen::kHeartbeatBase + contract::node_id(contract::Node::core) || frame.id == canopen::kSync ||
           frame.id == contract::pdo_cob_id(contract::Pdo::drive_rx1, contract::Node::drive_left) ||
           frame.id == contract::pdo_cob_id(contract::Pdo::drive_rx1, contract::Node::drive_right)))
        return fail(Failure::computer_active);
      for (std::size_t i = 0; i < kDrives.size(); ++i)
        if (frame.id == canopen::kHeartbeatBase + contract::node_id(kDrives[i])) drive_heard_[i] = true;
    }
    if (service == canopen::kHeartbeatBase && frame.id == canopen::kHeartbeatBase + node_id_ && frame.dlc == 1) {
      // Boot-up: the node has restarted. A loader entered earlier only sends "pre-operational".
      if (frame.data[0] == static_cast<std::uint8_t>(canopen::NmtState::boot_up)) booted_ = true;
    }
    exchange_.on_frame(frame);
    query_.on_frame(frame);
  }

  // At least once per millisecond; at most one frame comes back.
  std::optional<contract::CanFrame> step(std::uint64_t now_ns) {
    now_ns_ = now_ns;
    if (!entered_) {
      entered_ = true;
      phase_ns_ = now_ns;
    }
    switch (phase_) {
      case Phase::listening:
        if (now_ns - phase_ns_ < kListen_ns) return std::nullopt;
        enter(Phase::asking_drives);
        return ask_next_drive();
      case Phase::asking_drives:
        return ask_drives();
      case Phase::asking_node:
        return ask_node();
      case Phase::entering_loader:
        return enter_loader();
      case Phase::sending:
        return send_program();
      case Phase::checking:
        return check_program();
      case Phase::starting:
        return start_program();
      case Phase::done:
      case Phase::failed:
        break;
    }
    return std::nullopt;
  }

  // Time limits.
  static constexpr std::uint64_t kListen_ns = 350'000'000;    // three heartbeats of 100 ms of any node
  static constexpr std::uint64_t kReboot_ns = 3'000'000'000;  // from the end of a program to the loader's first frame, and back
  static constexpr int kTriesMax = 3;                         // transfers restarted after a timeout or a lost segment

 private:
  using Outcome = SdoClient::Outcome;
  static constexpr std::array kDrives{contract::Node::drive_left, contract::Node::drive_right};

  void enter(Phase phase) {
    phase_ = phase;
    phase_ns_ = now_ns_;
    stage_ = 0;
  }
  void fail(Failure why) {
    phase_ = Phase::failed;
    failure_ = why;
  }
  void ask(std::uint8_t node_id, std::uint16_t index, std::uint8_t sub) {
    exchange_.set_timing(kQuestionTiming);
    if (!exchange_.upload(node_id, index, sub)) fail(Failure::absent);
  }
  // What is sent must live as long as the transfer: the numbers 0 to 3, at their own places.
  static constexpr std::array<std::uint8_t, 4> kCommandBytes{0, 1, 2, 3};
  void command(contract::ProgramCommand what, const SdoTiming& timing) {
    exchange_.set_timing(timing);
    if (!exchange_.download(node_id_, contract::kProgramControl, 1, std::span(kCommandBytes).subspan(static_cast<std::size_t>(what), 1)))
      fail(Failure::absent);
  }
  // The next frame of the exchange, or its end: then over is true, with outcome().
  std::optional<contract::CanFrame> pump(bool& over) {
    const auto frame = exchange_.step(now_ns_);
    over = exchange_.outcome() != Outcome::busy;
    if (exchange_.outcome() == Outcome::aborted) abort_code_ = exchange_.abort_code();
    return frame;
  }

  std::optional<contract::CanFrame> ask_next_drive() {
    while (drive_ < kDrives.size() && !drive_heard_[drive_]) ++drive_;
    if (drive_ == kDrives.size()) {
      enter(Phase::asking_node);
      query_.begin(node_id_);
      return query_.step(now_ns_);
    }
    ask(contract::node_id(kDrives[drive_]), 0x6041, 0);
    return exchange_.step(now_ns_);
  }
  std::optional<contract::CanFrame> ask_drives() {
    namespace drive = contract::canopen::drive;
    bool over = false;
    const auto frame = pump(over);
    if (!over) return frame;
    if (exchange_.outcome() == Outcome::done) {
      const drive::State state = drive::state(static_cast<std::uint16_t>(exchange_.value()));
      if (state == drive::State::operation_enabled || state == drive::State::quick_stop_active || state == drive::State::fault_reaction) {
        fail(Failure::drive_enabled);
        return std::nullopt;
      }
    } else if (exchange_.outcome() != Outcome::aborted ||
               exchange_.abort_code() != static_cast<std::uint32_t>(contract::canopen::SdoAbort::no_object)) {
      // A drive in its loader has no such object, and its bridge is off. A drive without an answer may be enabled.
      fail(Failure::drive_enabled);
      return frame;
    }
    ++drive_;
    return ask_next_drive();
  }

  std::optional<contract::CanFrame> ask_node() {
    const auto frame = query_.step(now_ns_);
    if (query_.busy() || frame) return frame;
    before_ = query_.result();
    const bool for_simulator = header_.chip == static_cast<std::uint8_t>(contract::ImageChip::simulated);
    if (!before_.answered) {
      fail(Failure::absent);
    } else if (before_.simulated != for_simulator) {
      fail(Failure::wrong_chip);
    } else if (!options_.force && before_.version > header_.version) {
      fail(Failure::older);
    } else if (!options_.force && !before_.in_loader && before_.version == header_.version && before_.crc == header_.crc) {
      was_there_ = true;
      phase_ = Phase::done;
    } else {
      enter(before_.in_loader ? Phase::sending : Phase::entering_loader);
      if (phase_ == Phase::sending) begin_sending();
    }
    return std::nullopt;
  }

  std::optional<contract::CanFrame> enter_loader() {
    namespace canopen = contract::canopen;
    switch (stage_) {
      case 0:  // pre-operational first: the only state in which a node may be ended
        stage_ = 1;
        return canopen::nmt(canopen::NmtCommand::pre_operational, node_id_);
      case 1:
        stage_ = 2;
        booted_ = false;
        command(contract::ProgramCommand::stop, kQuestionTiming);
        return exchange_.step(now_ns_);
      case 2: {
        bool over = false;
        const auto frame = pump(over);
        if (!over) return frame;
        if (exchange_.outcome() == Outcome::aborted) {
          fail(Failure::not_ready);
          return std::nullopt;
        }
        phase_ns_ = now_ns_;
        stage_ = 3;
        return frame;
      }
      default:
        return wait_for_boot(Failure::no_loader);
    }
  }
  // After a reset: its boot-up message, then its identity. Without one within kReboot_ns the reset has failed.
  std::optional<contract::CanFrame> wait_for_boot(Failure otherwise) {
    if (stage_ == 3) {
      if (booted_) {
        stage_ = 4;
        query_.begin(node_id_);
        return query_.step(now_ns_);
      }
      if (now_ns_ - phase_ns_ >= kReboot_ns) fail(otherwise);
      return std::nullopt;
    }
    const auto frame = query_.step(now_ns_);
    if (query_.busy() || frame) return frame;
    const NodeProgram& now = query_.result();
    if (phase_ == Phase::entering_loader) {
      if (!now.answered || !now.in_loader) {
        fail(otherwise);
      } else {
        enter(Phase::sending);
        begin_sending();
      }
      return std::nullopt;
    }
    if (!now.answered || now.in_loader || now.crc != header_.crc || now.version != header_.version) {
      fail(otherwise);
    } else {
      phase_ = Phase::done;
    }
    return std::nullopt;
  }

  void begin_sending() {
    ++tries_;
    exchange_.set_timing(kProgramTiming);
    if (!exchange_.download(node_id_, contract::kProgramData, 1, image_, true)) fail(Failure::bad_image);
  }
  std::optional<contract::CanFrame> send_program() {
    bool over = false;
    const auto frame = pump(over);
    if (!over) return frame;
    if (exchange_.outcome() == Outcome::done) {
      enter(Phase::checking);
      ask(node_id_, contract::kFlashStatus, 1);
      return exchange_.step(now_ns_);
    }
    // A lost frame causes a timeout here, or a timeout or wrong toggle in the loader; any other abort is the loader's verdict on this program.
    using contract::canopen::SdoAbort;
    const auto code = static_cast<SdoAbort>(abort_code_);
    const bool lost = exchange_.outcome() != Outcome::aborted || code == SdoAbort::toggle || code == SdoAbort::time_out ||
                      code == SdoAbort::command || code == SdoAbort::transfer;
    if (!lost) {
      fail(Failure::refused);
    } else if (tries_ >= kTriesMax) {
      fail(Failure::broken_off);
    } else {
      begin_sending();
    }
    return frame;
  }

  std::optional<contract::CanFrame> check_program() {
    bool over = false;
    const auto frame = pump(over);
    if (!over) return frame;
    const std::uint32_t wanted = stage_ == 0 ? static_cast<std::uint32_t>(contract::FlashStatus::good) : header_.crc;
    if (exchange_.outcome() != Outcome::done || exchange_.value() != wanted) {
      fail(Failure::not_whole);
      return frame;
    }
    if (stage_ == 0) {
      stage_ = 1;
      ask(node_id_, contract::kProgramId, 1);
      return exchange_.step(now_ns_);
    }
    enter(Phase::starting);
    booted_ = false;
    command(contract::ProgramCommand::start, kOnceTiming);
    return exchange_.step(now_ns_);
  }

  std::optional<contract::CanFrame> start_program() {
    if (stage_ >= 3) return wait_for_boot(Failure::did_not_start);
    bool over = false;
    const auto frame = pump(over);
    if (!over) return frame;
    if (exchange_.outcome() == Outcome::aborted) {
      fail(Failure::did_not_start);
    } else {
      stage_ = 3;
      phase_ns_ = now_ns_;
    }
    return frame;
  }

  std::span<const std::uint8_t> image_;
  contract::Node node_;
  std::uint8_t node_id_;
  Options options_;
  contract::ImageHeader header_{};
  Phase phase_ = Phase::listening;
  Failure failure_ = Failure::none;
  bool was_there_ = false, booted_ = false, entered_ = false;
  int stage_ = 0, tries_ = 0;
  std::uint64_t now_ns_ = 0, phase_ns_ = 0;
  std::uint32_t abort_code_ = 0;
  std::array<bool, 2> drive_heard_{};
  std::size_t drive_ = 0;
  NodeProgram before_{};
  SdoClient exchange_{kQuestionTiming};
  ProgramQuery query_{};
};

constexpr std::string_view phase_text(FirmwareUpdate::Phase phase) {
  switch (phase) {
    case FirmwareUpdate::Phase::listening:
      return "listening on the bus";
    case FirmwareUpdate::Phase::asking_drives:
      return "asking the drives";
    case FirmwareUpdate::Phase::asking_node:
      return "asking the node";
    case FirmwareUpdate::Phase::entering_loader:
      return "waiting for the loader";
    case FirmwareUpdate::Phase::sending:
      return "sending";
    case FirmwareUpdate::Phase::checking:
      return "checking";
    case FirmwareUpdate::Phase::starting:
      return "starting the program";
    case FirmwareUpdate::Phase::done:
      return "done";
    case FirmwareUpdate::Phase::failed:
      return "failed";
  }
  return "";
}
// What happened and what to do next.
constexpr std::string_view failure_text(FirmwareUpdate::Failure failure) {
  using Failure = FirmwareUpdate::Failure;
  switch (failure) {
    case Failure::none:
      return "";
    case Failure::bad_image:
      return "the file is no program for this kind of node; look at it with `hoist firmware show`";
    case Failure::computer_active:
      return "a control computer is at work on this bus; end hoist-control first";
    case Failure::drive_enabled:
      return "a drive is enabled, or does not say that it is not; switch the drives off first";
    case Failure::absent:
      return "the node does not answer; look at its plug and supply, then try again";
    case Failure::wrong_chip:
      return "the file is for another chip (a simulated node takes only programs for `simulated`, and no other node takes those)";
    case Failure::older:
      return "the node runs a newer program; --force puts the older one in all the same";
    case Failure::not_ready:
      return "the node refuses to end its program: it must be pre-operational, and a drive must stand with its bridge off";
    case Failure::no_loader:
      return "the node did not come back in its loader; switch its supply off and on and try again";
    case Failure::refused:
      return "the loader refused the program; the one before is still there unless the flash is broken";
    case Failure::broken_off:
      return "three transfers were broken off; the node waits in its loader: look at the cable and run the same command again";
    case Failure::not_whole:
      return "the loader does not have what was sent; run the same command again";
    case Failure::did_not_start:
      return "the program was stored but does not run; send another one";
  }
  return "";
}

}  // namespace hoist::bus
