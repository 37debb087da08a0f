// The loader: the small program that runs first after every reset. It starts a complete application for this node, else it stays on the bus
// and accepts a new one over SDO (1F50h, 1F51h, 1F56h, 1F57h of CiA 302-3). The protocol is in README.md.
//
// After a power cut at any moment the node returns to the loader: the sector with the header is erased first, and the header's page is
// written last, after the CRC of everything else, read back, was right.
//
// One call of decide_start() per reset; then the application is started, or a Loader is called for every frame and millisecond.
#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/firmware_image.hpp"
#include "firmware/lib/mailbox.hpp"

namespace hoist::firmware {

// What the loader needs of a board.
//   kWritePage        bytes that are written at once, at a multiple of it; the header lies in the first page
//   kEraseUnit        bytes that are erased at once, a multiple of kWritePage
//   application()     the flash of the application as it can be read
//   erase(unit)       one unit to FFh; write(offset, bytes): one page, word-aligned. False on a flash error.
//                     Both may take 100 ms
//   send(frame)       as every board; sent_all(): no frame still waits for the bus
//   simulated()       as every board
//   kind(), chip()    of the programs it accepts
//   mailbox()         the four words of mailbox.hpp
//   restart()         resets the chip; returns only on boards of this computer
template <class B>
concept LoaderBoard = requires(B board, const B constant, const contract::CanFrame& frame, std::size_t place,
                               std::span<const std::uint8_t> bytes) {
  { B::kWritePage } -> std::convertible_to<std::size_t>;
  { B::kEraseUnit } -> std::convertible_to<std::size_t>;
  { constant.application() } -> std::convertible_to<std::span<const std::uint8_t>>;
  { board.erase(place) } -> std::same_as<bool>;
  { board.write(place, bytes) } -> std::same_as<bool>;
  { board.send(frame) } -> std::same_as<bool>;
  { board.sent_all() } -> std::same_as<bool>;
  { constant.simulated() } -> std::same_as<bool>;
  { constant.kind() } -> std::same_as<contract::ImageKind>;
  { constant.chip() } -> std::convertible_to<const contract::ImageChipInfo&>;
  { board.mailbox() } -> std::same_as<Mailbox&>;
  { board.restart() } -> std::same_as<void>;
};

// Why a node is in its loader; application: it is not.
enum class StartReason : std::uint8_t { application, asked, service_pin, failed_starts, no_program };

enum class LoaderReset : std::uint8_t { power_or_pin, watchdog, software };

// Which of the two runs after this reset. Counts the times that the application was ended by
// its watchdog or by a fault, and takes the request out of the mailbox: it counts for one start.
template <LoaderBoard Board>
[[nodiscard]] StartReason decide_start(Board& board, LoaderReset reset, bool service_pin) {
  Mailbox& mailbox = board.mailbox();
  const bool asked = reset != LoaderReset::power_or_pin && loader_requested(mailbox);
  const bool fell = reset == LoaderReset::watchdog || (reset == LoaderReset::software && application_fell(mailbox));
  forget_request(mailbox);
  if (reset == LoaderReset::power_or_pin) forget_failures(mailbox);
  if (fell) set_failures(mailbox, std::min(failures(mailbox), kFailedStartsMax) + 1);
  if (service_pin) return StartReason::service_pin;
  if (asked) return StartReason::asked;
  if (contract::check_flash(board.application(), board.kind(), board.chip()) != contract::ImageError::none) return StartReason::no_program;
  if (failures(mailbox) >= kFailedStartsMax) return StartReason::failed_starts;
  leave_request(mailbox, kApplicationRuns);
  return StartReason::application;
}

inline constexpr std::uint32_t kLoaderHeartbeat_ms = 100;
// After entering the loader on request, or after a new program, the application starts when no request came for so long.
inline constexpr std::uint32_t kLoaderPatience_ms = 60000;
// The answer to "start" must be on the bus before the reset; after this time the frame is given up.
inline constexpr std::uint32_t kLastAnswer_ms = 50;

// Timeout of a client within a transfer.
inline constexpr std::uint32_t kLoaderTransfer_ms = 1000;

// Own SDO server, because with sdo_server.hpp the loader does not fit into a sector (DECISIONS.md, 1). Expedited reads and writes of the
// few objects below, and one segmented download.
template <LoaderBoard Board>
class Loader {
 public:
  using FlashStatus = contract::FlashStatus;
  using ImageError = contract::ImageError;
  using SdoAbort = contract::canopen::SdoAbort;
  using CanFrame = contract::CanFrame;
  static_assert(Board::kWritePage >= contract::kImageMin && Board::kEraseUnit % Board::kWritePage == 0);

  Loader(Board& board, std::uint8_t node_id, StartReason reason) : board_(board), node_id_(node_id), reason_(reason) {
    examine();
    if (reason == StartReason::failed_starts) status_ = FlashStatus::failed_starts;
  }

  void on_frame(const CanFrame& frame) {
    if (frame.flags != 0) return;
    if (frame.id == contract::canopen::kNmt) {
      // The loader has one NMT state. It accepts reset commands only, and never becomes operational.
      if (frame.dlc != 2 || (frame.data[1] != 0 && frame.data[1] != node_id_)) return;
      const auto command = static_cast<contract::canopen::NmtCommand>(frame.data[0]);
      if (command == contract::canopen::NmtCommand::reset_node) leave(0);
      if (command == contract::canopen::NmtCommand::reset_communication) announced_ = false;
      return;
    }
    if (frame.id != contract::canopen::kSdoRequestBase + node_id_ || !announced_ || leaving_) return;
    quiet_ms_ = 0;
    on_request(frame);
    send_answer();
  }

  void tick_1ms() {
    send_answer();
    ++quiet_ms_;
    if (leaving_) {
      if ((answer_waiting_ || !board_.sent_all()) && quiet_ms_ < kLastAnswer_ms) return;
      leave_request(board_.mailbox(), after_reset_);
      return board_.restart();
    }
    if (++heartbeat_ms_ >= kLoaderHeartbeat_ms || !announced_) {
      const bool sent = board_.send(contract::canopen::heartbeat(
          node_id_, announced_ ? contract::canopen::NmtState::pre_operational : contract::canopen::NmtState::boot_up));
      if (sent) {
        announced_ = true;
        heartbeat_ms_ = 0;
      }
    }
    if (open_ && quiet_ms_ >= kLoaderTransfer_ms) abort(SdoAbort::time_out);
    if (status_ == FlashStatus::busy && !answer_waiting_ && board_.sent_all()) clear_next();
    if (reason_ == StartReason::asked && status_ == FlashStatus::good && quiet_ms_ >= kLoaderPatience_ms) leave(0);
  }

  [[nodiscard]] FlashStatus status() const { return status_; }
  [[nodiscard]] std::uint8_t node_id() const { return node_id_; }

 private:
  static constexpr std::size_t kPage = Board::kWritePage;
  static constexpr std::uint8_t kErased = 0xFF;
  static constexpr std::uint8_t kToggle = 0x10;
  static constexpr std::uint32_t kLoaderRevision = 0x00010000;

  // ---- the bus

  // Exactly one answer follows each request, except an abort. A waiting answer is dropped: its client has timed out.
  void on_request(const CanFrame& frame) {
    const std::uint8_t command = frame.data[0];
    if (frame.dlc != 8) return abort(SdoAbort::command);
    if (command == contract::canopen::kSdoAbort) return close();
    if ((command & 0xE0U) == 0) return open_ ? on_segment(frame) : abort(SdoAbort::command);
    close();
    // The answer names the object as the request does.
    answer_ = frame;
    answer_.id = contract::canopen::kSdoReplyBase + node_id_;
    const std::uint16_t index = static_cast<std::uint16_t>(contract::read_le(&frame.data[1], 2));
    const std::uint8_t sub = frame.data[3];
    SdoAbort code = SdoAbort::command;
    if (command == contract::canopen::kSdoUploadRequest) {
      code = read(index, sub);
    } else if ((command & 0xF0U) == 0x20U) {
      code = write(index, sub, command, contract::read_le(&frame.data[4], 4));
    }
    if (code != SdoAbort::none) return abort(code);
    answer_waiting_ = true;
  }
  void answer_value(std::size_t bytes, std::uint32_t value) {
    answer_.data[0] = contract::canopen::sdo_upload_reply_command(bytes);
    contract::write_le(&answer_.data[4], 4, value);
  }
  void abort(SdoAbort code) {
    close();
    answer_.id = contract::canopen::kSdoReplyBase + node_id_;
    answer_.dlc = 8;
    answer_.data[0] = contract::canopen::kSdoAbort;
    contract::write_le(&answer_.data[4], 4, static_cast<std::uint32_t>(code));
    answer_waiting_ = true;
  }
  void send_answer() {
    if (answer_waiting_ && board_.send(answer_)) answer_waiting_ = false;
  }

  // Highest sub-index of the objects that have several; 0: no such object.
  static constexpr std::uint8_t count_of(std::uint16_t index) {
    if (index == 0x1018) return 4;
    return (index >= contract::kProgramData && index <= contract::kProgramControl) ||
                   (index >= contract::kProgramId && index <= contract::kFlashStatus) || index == contract::kProgramVersion
               ? 1
               : 0;
  }
  // A word of the present program's header; 0 without a program.
  [[nodiscard]] std::uint32_t header_word(std::size_t at) const { return whole_ ? contract::image_word(board_.application(), at) : 0; }

  [[nodiscard]] SdoAbort read(std::uint16_t index, std::uint8_t sub) {
    const std::uint8_t count = count_of(index);
    if (count == 0 && index != 0x1000) return SdoAbort::no_object;
    if (sub > count) return SdoAbort::no_sub;
    std::uint32_t value = 0;  // 1000h: no device profile; 1018h:1 and 4: no numbers; 1F51h: stopped
    if (sub == 0 && count != 0) {
      answer_value(1, count);
      return SdoAbort::none;
    }
    switch (index) {
      case contract::kProgramData:
        return SdoAbort::write_only;
      case 0x1018:
        if (sub == 2)
          value = (static_cast<std::uint32_t>(board_.kind()) + 1) | contract::kLoaderProduct |
                  (board_.simulated() ? contract::canopen::kSimulatedProduct : 0U);
        if (sub == 3) value = kLoaderRevision;
        break;
      case contract::kProgramId:
        value = header_word(contract::kImageCrcAt);
        break;
      case contract::kFlashStatus:
        value = static_cast<std::uint32_t>(status_);
        break;
      case contract::kProgramVersion:
        value = header_word(contract::kImageHeaderAt + 12);
        break;
      default:
        break;
    }
    answer_value(index == contract::kProgramControl ? 1 : 4, value);
    return SdoAbort::none;
  }

  // A write of 1F51h:1 in one frame, or the announcement of a program for 1F50h:1. `value`: the last four bytes of the request.
  [[nodiscard]] SdoAbort write(std::uint16_t index, std::uint8_t sub, std::uint8_t command, std::uint32_t value) {
    const std::uint8_t count = count_of(index);
    if (count == 0) return index == 0x1000 ? SdoAbort::read_only : SdoAbort::no_object;
    if (sub > count) return SdoAbort::no_sub;
    if (sub == 0 || index > contract::kProgramControl || index < contract::kProgramData) return SdoAbort::read_only;
    if (status_ == FlashStatus::busy) return SdoAbort::device_state;
    const bool expedited = (command & 2U) != 0;
    answer_.data[0] = contract::canopen::kSdoDownloadReply;
    contract::write_le(&answer_.data[4], 4, 0);
    if (index == contract::kProgramControl) {
      // One byte, or as many of the four as the object has.
      if (!expedited || ((command & 1U) != 0 && (command & 0x0CU) != 0x0CU)) return SdoAbort::length;
      return control(value & 0xFFU);
    }
    if (expedited) return SdoAbort::too_short;
    const std::uint32_t announced = (command & 1U) != 0 ? value : 0;
    if (announced > board_.chip().application_max) return SdoAbort::too_long;
    announced_length_ = announced;
    received_ = 0;
    toggle_ = false;
    open_ = true;
    return SdoAbort::none;
  }
  [[nodiscard]] SdoAbort control(std::uint32_t what) {
    if (what > static_cast<std::uint32_t>(contract::ProgramCommand::clear)) return SdoAbort::range;
    if (what == static_cast<std::uint32_t>(contract::ProgramCommand::start)) {
      if (!whole_) return SdoAbort::device_state;
      forget_failures(board_.mailbox());
      leave(0);
    } else if (what == static_cast<std::uint32_t>(contract::ProgramCommand::reset)) {
      leave(kEnterLoader);
    } else if (what == static_cast<std::uint32_t>(contract::ProgramCommand::clear)) {
      status_ = FlashStatus::busy;
      whole_ = false;
      clear_at_ = 0;
    }
    return SdoAbort::none;
  }
  void leave(std::uint32_t request) {
    leaving_ = true;
    after_reset_ = request;
    quiet_ms_ = 0;
  }

  // ---- receiving a program

  void on_segment(const CanFrame& frame) {
    const std::uint8_t command = frame.data[0];
    SdoAbort code = SdoAbort::toggle;
    if (((command & kToggle) != 0) == toggle_) {
      const std::size_t bytes = 7U - ((static_cast<std::size_t>(command) >> 1) & 7U);
      code = SdoAbort::none;
      for (std::size_t i = 1; i <= bytes && code == SdoAbort::none; ++i) code = take(frame.data[i]);
      if (code == SdoAbort::none && (command & 1U) != 0) code = finish();
    }
    if (code != SdoAbort::none) {
      // A segment names no object; its answer does.
      contract::write_le(&answer_.data[0], 4, (static_cast<std::uint32_t>(contract::kProgramData) << 8) | (1U << 24));
      return abort(code);
    }
    contract::write_le(&answer_.data[0], 4, 0x20U | (command & kToggle));
    contract::write_le(&answer_.data[4], 4, 0);
    toggle_ = !toggle_;
    answer_waiting_ = true;
  }

  [[nodiscard]] SdoAbort take(std::uint8_t byte) {
    // Nothing in flash changes until the header has been checked; a wrong file does no harm.
    if (received_ >= contract::kImageMin && received_ == length_) return SdoAbort::too_long;
    const std::size_t at = received_++ % kPage;
    (received_ <= kPage ? first_ : page_)[at] = byte;
    if (received_ == contract::kImageMin) return judge_start();
    if (received_ > kPage && at == kPage - 1 && !write_page(received_ - kPage)) return failed(FlashStatus::write_failed);
    return SdoAbort::none;
  }

  // The header is complete and valid: the unit with the old header is erased first, so that from now on there is no program.
  [[nodiscard]] SdoAbort judge_start() {
    const std::span<const std::uint8_t> start = std::span<const std::uint8_t>(first_).first(contract::kImageMin);
    const ImageError error = contract::check_image_start(start, board_.kind(), board_.chip());
    if (error == ImageError::too_long) return SdoAbort::too_long;
    if (error != ImageError::none) return SdoAbort::range;
    length_ = contract::image_word(start, contract::kImageHeaderAt + 4);
    if (announced_length_ != 0 && length_ != announced_length_) return SdoAbort::length;
    whole_ = false;
    status_ = FlashStatus::no_program;
    return board_.erase(0) ? SdoAbort::none : failed(FlashStatus::write_failed);
  }

  // A page behind the first one; the unit it begins is erased before.
  [[nodiscard]] bool write_page(std::size_t offset) {
    if (offset % Board::kEraseUnit == 0 && !board_.erase(offset / Board::kEraseUnit)) return false;
    return board_.write(offset, page_);
  }

  [[nodiscard]] SdoAbort finish() {
    if (received_ < contract::kImageMin || received_ != length_) return SdoAbort::too_short;
    // The rest of the last page is filled with FFh, as erased.
    const std::size_t end = received_;
    for (std::size_t at = end % kPage; at != 0; at = (at + 1) % kPage) (end <= kPage ? first_ : page_)[at] = kErased;
    if (end > kPage && end % kPage != 0 && !write_page(end - end % kPage)) return failed(FlashStatus::write_failed);
    const std::size_t in_first = end < kPage ? end : kPage;
    const std::span<const std::uint8_t> start = std::span<const std::uint8_t>(first_).first(in_first);
    if (contract::image_crc(start, board_.application().subspan(in_first, end - in_first)) !=
        contract::image_word(start, contract::kImageCrcAt))
      return failed(FlashStatus::damaged);
    const bool written = board_.write(0, first_);
    examine();
    if (!written || !whole_) return failed(FlashStatus::write_failed);
    open_ = false;
    reason_ = StartReason::asked;  // a program can be started again, also without a request
    forget_failures(board_.mailbox());
    return SdoAbort::none;
  }
  [[nodiscard]] SdoAbort failed(FlashStatus why) {
    status_ = why;
    whole_ = false;
    return why == FlashStatus::damaged ? SdoAbort::transfer : SdoAbort::hardware;
  }
  // The transfer is over, or another request has taken its place.
  void close() { open_ = false; }

  // ---- the flash

  // What lies there now.
  void examine() {
    const ImageError error = contract::check_flash(board_.application(), board_.kind(), board_.chip());
    whole_ = error == ImageError::none;
    status_ = whole_                                                     ? FlashStatus::good
              : error == ImageError::crc || error == ImageError::vectors ? FlashStatus::damaged
              : error == ImageError::kind || error == ImageError::chip   ? FlashStatus::unknown_format
                                                                         : FlashStatus::no_program;
  }
  void clear_next() {
    if (!board_.erase(clear_at_)) {
      status_ = FlashStatus::write_failed;
    } else if (++clear_at_ * Board::kEraseUnit >= board_.application().size()) {
      status_ = FlashStatus::no_program;
    }
  }

  Board& board_;
  std::uint8_t node_id_;
  StartReason reason_;
  FlashStatus status_ = FlashStatus::no_program;
  bool whole_ = false;  // a valid program may be started
  bool announced_ = false, leaving_ = false, open_ = false, toggle_ = false, answer_waiting_ = false;
  std::uint32_t after_reset_ = 0;  // what the mailbox says then
  std::uint32_t heartbeat_ms_ = 0, quiet_ms_ = 0;
  std::uint32_t announced_length_ = 0, received_ = 0, length_ = 0;
  std::size_t clear_at_ = 0;
  CanFrame answer_{};
  // Written before they are read; on purpose without an initial value, which would only cost flash.
  alignas(std::uint32_t) std::array<std::uint8_t, kPage> first_;
  alignas(std::uint32_t) std::array<std::uint8_t, kPage> page_;
};

}  // namespace hoist::firmware
