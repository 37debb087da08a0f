// A node of a simulated hoist with its loader: flash, mailbox and the choice between loader and application around a node's firmware, so
// that an update can be tried without hardware. The application is always the compiled-in one; its reported version and CRC are those of
// the image.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/firmware_image.hpp"
#include "firmware/boot/host/program_flash.hpp"
#include "firmware/boot/loader.hpp"
#include "firmware/lib/board.hpp"
#include "firmware/lib/mailbox.hpp"
#include "firmware/lib/program_control.hpp"

namespace hoist::firmware {

inline constexpr std::uint32_t kFirstSimulatedVersion = contract::image_version(1, 0, 0);
inline constexpr std::size_t kFirstSimulatedBytes = 1024;

/// Fills in the header of an image whose bytes are all there.
inline void seal_image(std::span<std::uint8_t> image, contract::ImageKind kind, contract::ImageChip chip, std::uint32_t version) {
  contract::write_le(&image[contract::kImageHeaderAt], 4, contract::kImageMagic);
  contract::write_le(&image[contract::kImageHeaderAt + 4], 4, static_cast<std::uint32_t>(image.size()));
  contract::write_le(&image[contract::kImageHeaderAt + 12], 4, version);
  image[contract::kImageHeaderAt + 16] = static_cast<std::uint8_t>(kind);
  image[contract::kImageHeaderAt + 17] = static_cast<std::uint8_t>(chip);
  contract::write_le(&image[contract::kImageHeaderAt + 18], 2, 0);
  contract::write_le(&image[contract::kImageCrcAt], 4, contract::image_crc(image));
}

/// What the loader sees of a board: its bus, its program flash, the mailbox. A restart is noted and carried out by the owner.
template <class Board>
class HostLoaderBoard {
 public:
  static constexpr std::size_t kWritePage = ProgramFlash::kWritePage;
  static constexpr std::size_t kEraseUnit = ProgramFlash::kEraseUnit;

  HostLoaderBoard(Board& board, contract::Node node) : board_(board), node_(node) { forget_request(mailbox_); }
  [[nodiscard]] contract::ImageKind kind() const {
    return static_cast<contract::ImageKind>(contract::kNodes[static_cast<std::size_t>(node_)].kind);
  }
  [[nodiscard]] static const contract::ImageChipInfo& chip() {
    return *contract::find_image_chip(static_cast<std::uint8_t>(contract::ImageChip::simulated));
  }
  [[nodiscard]] std::span<const std::uint8_t> application() const { return flash_.read(); }
  bool erase(std::size_t unit) { return flash_.erase(unit); }
  bool write(std::size_t offset, std::span<const std::uint8_t> bytes) { return flash_.write(offset, bytes); }
  bool send(const contract::CanFrame& frame) { return board_.send(frame); }
  [[nodiscard]] bool sent_all() const { return board_.sent_all(); }
  [[nodiscard]] bool simulated() const { return board_.simulated(); }
  Mailbox& mailbox() { return mailbox_; }
  void restart() { restart_requested_ = true; }
  bool take_restart() {
    const bool asked = restart_requested_;
    restart_requested_ = false;
    return asked;
  }
  ProgramFlash& flash() { return flash_; }

 private:
  Board& board_;
  contract::Node node_;
  ProgramFlash flash_{};
  Mailbox mailbox_{};
  bool restart_requested_ = false;
};

template <class Board, class Firmware>
class UpdatableNode {
 public:
  UpdatableNode(Board& board, contract::Node node)
      : board_(board), loader_board_(board, node), node_(node), firmware_((announce_program(board, burn_first()), board), node) {}

  void on_frame(const contract::CanFrame& frame) {
    if (silent_ms_ > 0) return;
    loader_ ? loader_->on_frame(frame) : firmware_.on_frame(frame);
  }
  void tick_1ms() {
    if (silent_ms_ > 0) {
      if (--silent_ms_ == 0) start(LoaderReset::software);
      return;
    }
    if (loader_) {
      loader_->tick_1ms();
      if (loader_board_.take_restart()) silent_ms_ = kRestart_ms;
      return;
    }
    firmware_.tick_1ms();
    if (++alive_ms_ == kStartedWell_ms) forget_failures(loader_board_.mailbox());
    if (board_.restart_requested()) {
      forget_request(loader_board_.mailbox());
      if (board_.loader_requested()) request_loader(loader_board_.mailbox());
      board_.restart_done();
      silent_ms_ = kRestart_ms;
    }
  }
  void power_on() { start(LoaderReset::power_or_pin); }
  /// The watchdog has bitten.
  void watchdog_reset() { start(LoaderReset::watchdog); }

  [[nodiscard]] Firmware& application() { return firmware_; }
  [[nodiscard]] bool in_loader() const { return loader_.has_value(); }
  [[nodiscard]] HostLoaderBoard<Board>& loader_board() { return loader_board_; }

 private:
  // From the reset to the first frame: clock and controller of a real chip need a few milliseconds.
  static constexpr std::uint32_t kRestart_ms = 5;

  std::span<const std::uint8_t> burn_first() {
    std::array<std::uint8_t, kFirstSimulatedBytes> image{};
    seal_image(image, loader_board_.kind(), contract::ImageChip::simulated, kFirstSimulatedVersion);
    loader_board_.flash().burn(image);
    return loader_board_.application();
  }
  static void announce_program(Board& board, std::span<const std::uint8_t> flash) {
    const contract::ImageHeader header = contract::read_image_header(flash);
    board.set_program({header.version, header.crc});
  }

  void start(LoaderReset reset) {
    silent_ms_ = 0;
    alive_ms_ = 0;
    board_.restart_done();
    const StartReason reason = decide_start(loader_board_, reset, false);
    if (reason != StartReason::application) {
      loader_.emplace(loader_board_, contract::node_id(node_), reason);
      return;
    }
    loader_.reset();
    announce_program(board_, loader_board_.application());
    board_.set_reset_cause(reset == LoaderReset::watchdog   ? ResetCause::watchdog
                           : reset == LoaderReset::software ? ResetCause::software
                                                            : ResetCause::power);
    firmware_.power_on();
  }

  Board& board_;
  HostLoaderBoard<Board> loader_board_;
  contract::Node node_;
  Firmware firmware_;
  std::optional<Loader<HostLoaderBoard<Board>>> loader_{};
  std::uint32_t silent_ms_ = 0, alive_ms_ = 0;
};

}  // namespace hoist::firmware
