// A loader around a flash in memory, and a client that speaks SDO to it byte by byte.
#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/firmware_image.hpp"
#include "firmware/boot/host/program_flash.hpp"
#include "firmware/boot/host/updatable_node.hpp"
#include "firmware/boot/loader.hpp"

namespace hoist::firmware {

namespace canopen = contract::canopen;
using contract::FlashStatus;
using contract::ImageChip;
using contract::ImageError;
using contract::ImageKind;

/// A program whose bytes depend on the seed, so that two always differ.
inline std::vector<std::uint8_t> make_image(std::size_t bytes, std::uint32_t version, std::uint32_t seed = 1,
                                            ImageKind kind = ImageKind::drive, ImageChip chip = ImageChip::simulated) {
  std::vector<std::uint8_t> image(bytes);
  std::uint32_t state = seed * 2654435761U + 1;
  for (std::uint8_t& byte : image) {
    state = state * 1664525U + 1013904223U;
    byte = static_cast<std::uint8_t>(state >> 24);
  }
  seal_image(image, kind, chip, version);
  return image;
}

struct BootBoard {
  static constexpr std::size_t kWritePage = ProgramFlash::kWritePage;
  static constexpr std::size_t kEraseUnit = ProgramFlash::kEraseUnit;
  ProgramFlash flash;
  Mailbox box;
  std::vector<contract::CanFrame> sent;
  bool restarted = false;
  bool bus_busy = false;  // what was sent still waits

  std::span<const std::uint8_t> application() const { return flash.read(); }
  bool erase(std::size_t unit) { return flash.erase(unit); }
  bool write(std::size_t offset, std::span<const std::uint8_t> bytes) { return flash.write(offset, bytes); }
  bool send(const contract::CanFrame& frame) {
    if (flash.powered()) sent.push_back(frame);
    return true;
  }
  bool sent_all() const { return !bus_busy; }
  bool simulated() const { return true; }
  ImageKind kind() const { return ImageKind::drive; }
  const contract::ImageChipInfo& chip() const { return *contract::find_image_chip("simulated"); }
  Mailbox& mailbox() { return box; }
  void restart() { restarted = true; }
};
static_assert(LoaderBoard<BootBoard>);

inline const contract::ImageChipInfo& simulated_chip() { return *contract::find_image_chip("simulated"); }
inline constexpr std::uint8_t kTestNode = 1;

class LoaderBench {
 public:
  BootBoard board;
  std::optional<Loader<BootBoard>> loader;

  StartReason reset(LoaderReset why, bool service_pin = false) {
    loader.reset();
    board.flash.power_up();
    board.restarted = false;
    board.sent.clear();
    const StartReason reason = decide_start(board, why, service_pin);
    if (reason != StartReason::application) {
      loader.emplace(board, kTestNode, reason);
      run(1);
    }
    return reason;
  }
  void run(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) loader->tick_1ms();
  }
  /// One request; the answer's eight bytes, or empty without an answer.
  std::optional<contract::CanFrame> ask(const contract::CanFrame& frame) {
    board.sent.clear();
    loader->on_frame(frame);
    run(1);
    for (const contract::CanFrame& answer : board.sent)
      if (answer.id == canopen::kSdoReplyBase + kTestNode) return answer;
    return std::nullopt;
  }
  std::optional<contract::CanFrame> ask(std::uint8_t command, std::uint16_t index, std::uint8_t sub, std::uint32_t value = 0) {
    return ask(canopen::sdo(canopen::kSdoRequestBase + kTestNode, command, index, sub, value));
  }
  /// The value of an object; the abort code when it was refused.
  struct Value {
    std::uint32_t raw = 0;
    std::uint32_t abort = 0;
    friend bool operator==(const Value&, const Value&) = default;
  };
  Value read(std::uint16_t index, std::uint8_t sub) { return value_of(ask(canopen::kSdoUploadRequest, index, sub)); }
  std::uint32_t write(std::uint16_t index, std::uint8_t sub, std::uint8_t value) {
    return value_of(ask(canopen::sdo_download_command(1), index, sub, value)).abort;
  }
  /// A whole program in segments; the abort code, 0 when the last segment was confirmed, empty without an answer (power cut).
  std::optional<std::uint32_t> download(std::span<const std::uint8_t> image, std::optional<std::size_t> stop_after_segments = {}) {
    auto answer = ask(0x21, contract::kProgramData, 1, static_cast<std::uint32_t>(image.size()));
    if (!answer) return std::nullopt;
    if (answer->data[0] == canopen::kSdoAbort) return contract::read_le(&answer->data[4], 4);
    bool toggle = false;
    std::size_t segments = 0;
    for (std::size_t at = 0; at < image.size(); at += 7, ++segments) {
      if (stop_after_segments && segments == *stop_after_segments) return std::nullopt;
      const std::size_t bytes = std::min<std::size_t>(7, image.size() - at);
      contract::CanFrame frame{canopen::kSdoRequestBase + kTestNode, 8, 0, {}};
      const bool last = at + bytes == image.size();
      frame.data[0] = static_cast<std::uint8_t>((toggle ? 0x10U : 0U) | ((7U - bytes) << 1) | (last ? 1U : 0U));
      std::copy_n(image.begin() + static_cast<std::ptrdiff_t>(at), bytes, frame.data.begin() + 1);
      answer = ask(frame);
      if (!answer) return std::nullopt;
      if (answer->data[0] == canopen::kSdoAbort) return contract::read_le(&answer->data[4], 4);
      toggle = !toggle;
    }
    return 0;
  }
  std::uint32_t status() { return read(contract::kFlashStatus, 1).raw; }

 private:
  static Value value_of(const std::optional<contract::CanFrame>& answer) {
    if (!answer) return {0, 0xFFFFFFFF};
    const std::uint32_t raw = contract::read_le(&answer->data[4], 4);
    return answer->data[0] == canopen::kSdoAbort ? Value{0, raw} : Value{raw, 0};
  }
};

}  // namespace hoist::firmware
