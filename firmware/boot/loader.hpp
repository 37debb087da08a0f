// The loader: the small program that runs first after every reset. It starts the application when there is a whole one for this node, and
// otherwise stays on the bus and takes a new one over SDO (1F50h, 1F51h, 1F56h, 1F57h of CiA 302-3). README.md tells the protocol.
//
// A cut of the power at any moment leaves a node that comes back into the loader: the first erased place holds the header, and the page
// with the header is written last, after everything else has been read back and its CRC was right.
//
// One call of decide_start() per reset; then either the application is started or a Loader gets every frame and every millisecond.
#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/firmware_image.hpp"
#include "firmware/boot/mailbox.hpp"
#include "firmware/lib/board.hpp"
#include "firmware/lib/sdo_server.hpp"

namespace hoist::firmware {

// What the loader needs of a board.
//   kWritePage        bytes that are written at once, at a multiple of it; the header lies in the first page
//   kEraseUnit        bytes that are erased at once, a multiple of kWritePage
//   application()     the flash of the application as it can be read
//   erase(unit)       one unit to FFh; write(offset, bytes): one page. False when the flash says so. Both may take 100 ms
//   send(frame)       as every board; sent_all(): nothing that was sent still waits for the bus
//   simulated()       as every board
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
  { board.mailbox() } -> std::same_as<Mailbox&>;
  { board.restart() } -> std::same_as<void>;
};

// Why a node is in its loader; application: it is not.
enum class StartReason : std::uint8_t { application, asked, service_pin, failed_starts, no_program };

enum class LoaderReset : std::uint8_t { power_or_pin, watchdog, software };

// Which of the two runs after this reset. Counts watchdog resets, and takes the request out of the mailbox: it counts for one start.
template <LoaderBoard Board>
[[nodiscard]] StartReason decide_start(Board& board, LoaderReset reset, bool service_pin, contract::ImageKind kind,
                                       const contract::ImageChipInfo& chip) {
  Mailbox& mailbox = board.mailbox();
  const bool asked = reset != LoaderReset::power_or_pin && loader_asked(mailbox);
  forget_request(mailbox);
  if (reset == LoaderReset::power_or_pin) forget_failures(mailbox);
  if (reset == LoaderReset::watchdog) set_failures(mailbox, std::min(failures(mailbox), kFailedStartsMax) + 1);
  if (service_pin) return StartReason::service_pin;
  if (asked) return StartReason::asked;
  if (contract::check_flash(board.application(), kind, chip) != contract::ImageError::none) return StartReason::no_program;
  return failures(mailbox) >= kFailedStartsMax ? StartReason::failed_starts : StartReason::application;
}

inline constexpr std::uint32_t kLoaderHeartbeat_ms = 100;
// A node that was asked into its loader, has a whole program and hears nothing for so long goes back to work.
inline constexpr std::uint32_t kLoaderPatience_ms = 60000;
// The answer to "start" must be on the bus before the reset; a bus that does not take it for so long will not take it at all.
inline constexpr std::uint32_t kLastAnswer_ms = 50;

template <LoaderBoard Board>
class Loader {
 public:
  using FlashStatus = contract::FlashStatus;
  using ImageError = contract::ImageError;
  static_assert(Board::kWritePage >= contract::kImageMin && Board::kEraseUnit % Board::kWritePage == 0);

  Loader(Board& board, std::uint8_t node_id, contract::ImageKind kind, const contract::ImageChipInfo& chip, StartReason reason)
      : board_(board), chip_(chip), kind_(kind), node_id_(node_id), reason_(reason), sdo_(node_id) {
    examine();
    if (reason == StartReason::failed_starts) status_ = FlashStatus::failed_starts;
  }

  void on_frame(const CanFrame& frame) {
    if (frame.flags != 0) return;
    if (frame.id == contract::canopen::kNmt && frame.dlc == 2 && (frame.data[1] == 0 || frame.data[1] == node_id_)) {
      // A loader knows one state. It can be told to start anew, nothing else: least of all to become operational.
      const auto command = static_cast<contract::canopen::NmtCommand>(frame.data[0]);
      if (command == contract::canopen::NmtCommand::reset_node) leave(false);
      if (command == contract::canopen::NmtCommand::reset_communication) announced_ = false;
      return;
    }
    if (frame.id != contract::canopen::kSdoRequestBase + node_id_ || !announced_ || leaving_) return;
    quiet_ms_ = 0;
    sdo_.on_request(frame, *this);
    send_answer();
  }

  void tick_1ms() {
    if (leaving_) {
      send_answer();
      if ((sdo_.answer_waiting() || !board_.sent_all()) && ++leaving_ms_ < kLastAnswer_ms) return;
      if (stay_) ask_for_loader(board_.mailbox());
      return board_.restart();
    }
    if (!announced_) {
      announced_ = board_.send(contract::canopen::heartbeat(node_id_, contract::canopen::NmtState::boot_up));
      heartbeat_ms_ = 0;
      return;
    }
    if (++heartbeat_ms_ >= kLoaderHeartbeat_ms &&
        board_.send(contract::canopen::heartbeat(node_id_, contract::canopen::NmtState::pre_operational)))
      heartbeat_ms_ = 0;
    send_answer();
    sdo_.tick_1ms(*this);
    if (status_ == FlashStatus::busy && !sdo_.answer_waiting() && board_.sent_all()) clear_next();
    if (reason_ == StartReason::asked && status_ == FlashStatus::good && ++quiet_ms_ >= kLoaderPatience_ms) leave(false);
  }

  [[nodiscard]] FlashStatus status() const { return status_; }
  [[nodiscard]] std::uint8_t node_id() const { return node_id_; }

  // The dictionary, as the SDO server asks it.
  SdoAbort sdo_read(std::uint16_t index, std::uint8_t sub, SdoSource& source) {
    source.raw_bytes = 4;
    if (sub == 0 && count_of(index) != 0) {
      source.raw_bytes = 1;
      source.raw = count_of(index);
      return SdoAbort::none;
    }
    switch ((static_cast<std::uint32_t>(index) << 8) | sub) {
      case 0x100000:  // no device profile
      case 0x101801:
      case 0x101804:
      case 0x1F5101:  // the program is stopped
        return SdoAbort::none;
      case 0x100100:
        source.raw_bytes = 1;
        source.raw = status_ == FlashStatus::good || status_ == FlashStatus::busy ? 0 : 1;
        return SdoAbort::none;
      case 0x101802:
        source.raw = (static_cast<std::uint32_t>(kind_) + 1) | contract::kLoaderProduct |
                     (board_.simulated() ? contract::canopen::kSimulatedProduct : 0U);
        return SdoAbort::none;
      case 0x101803:
        source.raw = kLoaderRevision;
        return SdoAbort::none;
      case 0x1F5601:
        source.raw = whole_ ? contract::read_image_header(board_.application()).crc : 0;
        return SdoAbort::none;
      case 0x1F5701:
        source.raw = static_cast<std::uint32_t>(status_);
        return SdoAbort::none;
      case 0x2F0001:
        source.raw = whole_ ? contract::read_image_header(board_.application()).version : 0;
        return SdoAbort::none;
      case 0x1F5001:
        return SdoAbort::write_only;
      default:
        return count_of(index) != 0 ? SdoAbort::no_sub : SdoAbort::no_object;
    }
  }
  SdoAbort sdo_target(std::uint16_t index, std::uint8_t sub, SdoTarget& target) {
    if (count_of(index) == 0) return index == 0x1000 || index == 0x1001 ? SdoAbort::read_only : SdoAbort::no_object;
    if (sub > count_of(index)) return SdoAbort::no_sub;
    if (sub == 0 || (index != contract::kProgramData && index != contract::kProgramControl)) return SdoAbort::read_only;
    if (status_ == FlashStatus::busy) return SdoAbort::device_state;
    target.bytes = index == contract::kProgramControl ? 1 : 0;
    return SdoAbort::none;
  }
  SdoAbort sdo_write(std::uint16_t, std::uint8_t, std::uint32_t raw) {
    switch (static_cast<contract::ProgramCommand>(raw)) {
      case contract::ProgramCommand::stop:
        return SdoAbort::none;
      case contract::ProgramCommand::start:
        if (!whole_) return SdoAbort::device_state;
        forget_failures(board_.mailbox());
        leave(false);
        return SdoAbort::none;
      case contract::ProgramCommand::reset:
        leave(true);
        return SdoAbort::none;
      case contract::ProgramCommand::clear:
        status_ = FlashStatus::busy;
        whole_ = false;
        clear_at_ = 0;
        return SdoAbort::none;
    }
    return SdoAbort::range;
  }
  SdoAbort sdo_domain_begin(std::uint16_t, std::uint8_t, std::uint32_t told) {
    if (told != 0 && told < contract::kImageMin) return SdoAbort::too_short;
    if (told > chip_.application_max) return SdoAbort::too_long;
    told_ = told;
    received_ = 0;
    touched_ = false;
    return SdoAbort::none;
  }
  SdoAbort sdo_domain_data(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) {
      // Until the header has been judged nothing in flash is touched; a wrong file costs the node nothing.
      if (received_ >= contract::kImageMin && received_ == length_) return SdoAbort::too_long;
      if (received_ < kPage) {
        first_[received_] = byte;
      } else {
        page_[received_ % kPage] = byte;
      }
      ++received_;
      if (received_ == contract::kImageMin)
        if (const SdoAbort code = judge_start(); code != SdoAbort::none) return code;
      if (received_ > kPage && received_ % kPage == 0)
        if (!write_page(received_ - kPage)) return failed(FlashStatus::write_failed);
    }
    return SdoAbort::none;
  }
  SdoAbort sdo_domain_end() {
    if (received_ < contract::kImageMin || received_ != length_) return SdoAbort::too_short;
    // What is not written stays erased: the rest of the last page is filled with FFh.
    if (const std::size_t rest = received_ % kPage; received_ > kPage && rest != 0) {
      std::fill(page_.begin() + static_cast<std::ptrdiff_t>(rest), page_.end(), kErased);
      if (!write_page(received_ - rest)) return failed(FlashStatus::write_failed);
    }
    const std::size_t in_first = std::min<std::size_t>(received_, kPage);
    const std::span<const std::uint8_t> start = std::span<const std::uint8_t>(first_).first(in_first);
    const std::span<const std::uint8_t> rest = board_.application().subspan(in_first, received_ - in_first);
    if (contract::image_crc(start, rest) != contract::read_image_header(start).crc) return failed(FlashStatus::damaged);
    std::fill(first_.begin() + static_cast<std::ptrdiff_t>(in_first), first_.end(), kErased);
    touched_ = false;  // from here on nothing is half done any more
    const bool written = board_.write(0, first_);
    examine();
    if (!written || !whole_) return failed(FlashStatus::write_failed);
    forget_failures(board_.mailbox());
    return SdoAbort::none;
  }
  void sdo_domain_cancel() {
    if (!touched_) return;  // refused before anything was erased, or its end has already said what is there
    touched_ = false;
    if (status_ != FlashStatus::write_failed && status_ != FlashStatus::damaged) status_ = FlashStatus::no_program;
  }

 private:
  static constexpr std::size_t kPage = Board::kWritePage;
  static constexpr std::uint8_t kErased = 0xFF;
  static constexpr std::uint32_t kLoaderRevision = 0x00010000;

  // Highest sub-index of the objects that have several; 0: no such object.
  static constexpr std::uint8_t count_of(std::uint16_t index) {
    switch (index) {
      case 0x1018:
        return 4;
      case contract::kProgramData:
      case contract::kProgramControl:
      case contract::kProgramId:
      case contract::kFlashStatus:
      case contract::kProgramVersion:
        return 1;
      default:
        return 0;
    }
  }

  // What lies in flash now.
  void examine() {
    const ImageError error = contract::check_flash(board_.application(), kind_, chip_);
    whole_ = error == ImageError::none;
    switch (error) {
      case ImageError::none:
        status_ = FlashStatus::good;
        break;
      case ImageError::crc:
      case ImageError::vectors:
        status_ = FlashStatus::damaged;
        break;
      case ImageError::kind:
      case ImageError::chip:
        status_ = FlashStatus::unknown_format;
        break;
      default:
        status_ = FlashStatus::no_program;
        break;
    }
  }

  // The header has come. Right: the unit that holds the old header goes first, so that from now on there is no program.
  [[nodiscard]] SdoAbort judge_start() {
    const std::span<const std::uint8_t> start = std::span<const std::uint8_t>(first_).first(contract::kImageMin);
    switch (contract::check_image_start(start, kind_, chip_)) {
      case ImageError::none:
        break;
      case ImageError::too_short:
        return SdoAbort::too_short;
      case ImageError::too_long:
        return SdoAbort::too_long;
      default:
        return SdoAbort::range;
    }
    length_ = contract::read_image_header(start).length;
    if (told_ != 0 && length_ != told_) return SdoAbort::length;
    whole_ = false;
    touched_ = true;
    status_ = FlashStatus::no_program;
    return board_.erase(0) ? SdoAbort::none : failed(FlashStatus::write_failed);
  }

  // A page behind the first one; the unit it begins is erased before.
  [[nodiscard]] bool write_page(std::size_t offset) {
    if (offset % Board::kEraseUnit == 0 && !board_.erase(offset / Board::kEraseUnit)) return false;
    return board_.write(offset, page_);
  }
  [[nodiscard]] SdoAbort failed(FlashStatus why) {
    status_ = why;
    whole_ = false;
    return why == FlashStatus::damaged ? SdoAbort::transfer : SdoAbort::hardware;
  }

  void clear_next() {
    if (!board_.erase(clear_at_)) {
      status_ = FlashStatus::write_failed;
    } else if (++clear_at_ * Board::kEraseUnit >= board_.application().size()) {
      status_ = FlashStatus::no_program;
    }
  }

  void leave(bool stay) {
    leaving_ = true;
    stay_ = stay;
    leaving_ms_ = 0;
  }
  void send_answer() {
    if (sdo_.answer_waiting() && board_.send(sdo_.answer())) sdo_.answer_sent();
  }

  Board& board_;
  const contract::ImageChipInfo& chip_;
  contract::ImageKind kind_;
  std::uint8_t node_id_;
  StartReason reason_;
  SdoServer sdo_;
  FlashStatus status_ = FlashStatus::no_program;
  bool whole_ = false;    // there is a program that may be started
  bool touched_ = false;  // a transfer has begun to change the flash
  bool announced_ = false, leaving_ = false, stay_ = false;
  std::uint32_t heartbeat_ms_ = 0, quiet_ms_ = 0, leaving_ms_ = 0;
  std::uint32_t told_ = 0, received_ = 0, length_ = 0;
  std::size_t clear_at_ = 0;
  std::array<std::uint8_t, kPage> first_{};
  std::array<std::uint8_t, kPage> page_{};
};

}  // namespace hoist::firmware
