// Untrusted programs for nodes: as files, as frames into a loader, and arbitrary answers of a node during an update.
#include <algorithm>
#include <array>
#include <optional>

#include "control/bus/firmware_update.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/unit/boot/boot_support.hpp"

namespace hoist::fuzz {
namespace {

using contract::CanFrame;
using contract::ImageError;
using firmware::LoaderBench;
namespace canopen = contract::canopen;

// As in node_targets.cpp: 0xxxxxxx: so many milliseconds pass; 1xxxxxxx: a frame follows (id in two bytes, DLC, data).
void append(Input& input, const CanFrame& frame) {
  input.insert(input.end(), {0x80, static_cast<std::uint8_t>(frame.id), static_cast<std::uint8_t>(frame.id >> 8), frame.dlc});
  input.insert(input.end(), frame.data.begin(), frame.data.begin() + frame.dlc);
}
CanFrame take_frame(Pieces& pieces) {
  CanFrame frame{static_cast<std::uint32_t>(pieces.number(2) & 0x7FFU), static_cast<std::uint8_t>(pieces.u8() % 9), 0, {}};
  const Bytes data = pieces.take(frame.dlc);
  std::copy(data.begin(), data.end(), frame.data.begin());
  return frame;
}
Input transfer(std::span<const std::uint8_t> image) {
  Input input;
  append(input, canopen::sdo(canopen::kSdoRequestBase + firmware::kTestNode, 0x21, contract::kProgramData, 1,
                             static_cast<std::uint32_t>(image.size())));
  bool toggle = false;
  for (std::size_t at = 0; at < image.size(); at += 7, toggle = !toggle) {
    const std::size_t bytes = std::min<std::size_t>(7, image.size() - at);
    CanFrame frame{canopen::kSdoRequestBase + firmware::kTestNode, 8, 0, {}};
    frame.data[0] = static_cast<std::uint8_t>((toggle ? 0x10U : 0U) | ((7U - bytes) << 1) | (at + bytes == image.size() ? 1U : 0U));
    std::copy_n(image.begin() + static_cast<std::ptrdiff_t>(at), bytes, frame.data.begin() + 1);
    append(input, frame);
  }
  append(input, canopen::sdo(canopen::kSdoRequestBase + firmware::kTestNode, 0x2F, contract::kProgramControl, 1, 1));
  input.push_back(5);
  return input;
}

}  // namespace

void fuzz_firmware_image(Bytes input) {
  const ImageError error = contract::check_image_file(input);
  must(error == ImageError::none || !contract::image_error_text(error).empty(), "every refusal has a sentence");
  if (error != ImageError::none) return;
  const contract::ImageHeader header = contract::read_image_header(input);
  must(header.length == input.size() && contract::find_image_kind(header.kind) != nullptr &&
           contract::find_image_chip(header.chip) != nullptr,
       "what is accepted says what it is");
}
std::vector<Input> seeds_firmware_image() {
  return {firmware::make_image(300, 1), firmware::make_image(212, 0xFFFFFFFF, 2, contract::ImageKind::tilt), Input(400, 0xFF)};
}

void fuzz_loader_frames(Bytes input) {
  LoaderBench bench;
  const auto before = firmware::make_image(700, contract::image_version(1, 0, 0));
  bench.board.flash.burn(before);
  firmware::request_loader(bench.board.box);
  must(bench.reset(firmware::LoaderReset::software) == firmware::StartReason::asked, "a loader that is asked for stays");
  Pieces pieces(input);
  while (!pieces.empty()) {
    const std::uint8_t what = pieces.u8();
    if ((what & 0x80U) == 0) {
      bench.run(what & 0x3F);
    } else {
      bench.board.sent.clear();
      bench.loader->on_frame(take_frame(pieces));
      must(bench.board.sent.size() <= 1, "a request has at most one answer");
    }
    must(bench.board.flash.misuses() == 0, "flash is only written where it was erased");
    if (bench.board.restarted) {
      const bool application = bench.reset(firmware::LoaderReset::software) == firmware::StartReason::application;
      must(!application ||
               contract::check_flash(bench.board.application(), contract::ImageKind::drive, firmware::simulated_chip()) == ImageError::none,
           "only a whole program is started");
      if (application) return;
    }
    if (bench.board.sent.size() > 1000) bench.board.sent.clear();
  }
}
std::vector<Input> seeds_loader_frames() {
  const auto image = firmware::make_image(600, contract::image_version(2, 0, 0), 3);
  Input clear;
  append(clear, canopen::sdo(canopen::kSdoRequestBase + firmware::kTestNode, 0x2F, contract::kProgramControl, 1, 3));
  clear.push_back(20);
  Input read;
  for (const std::uint16_t index : std::array<std::uint16_t, 5>{0x1000, 0x1018, 0x1F56, 0x1F57, 0x2F00})
    append(read, canopen::sdo(canopen::kSdoRequestBase + firmware::kTestNode, canopen::kSdoUploadRequest, index, 1, 0));
  return {transfer(image), clear, read};
}

// The computer's side: a node with arbitrary answers must never count as updated.
void fuzz_firmware_update(Bytes input) {
  static const auto image = firmware::make_image(300, contract::image_version(2, 0, 0), 3, contract::ImageKind::tilt);
  bus::FirmwareUpdate updating(image, contract::Node::tilt_left, {});
  Pieces pieces(input);
  std::uint64_t now_ns = 0;
  bool told_crc = false;
  for (int steps = 0; !updating.over() && steps < 20000; ++steps) {
    const std::uint8_t what = pieces.u8();  // zeros when the input is used up: then only time passes
    now_ns += (1 + (what & 0x3FU)) * 1'000'000ULL;
    if ((what & 0x80U) != 0) {
      CanFrame frame = take_frame(pieces);
      if ((what & 0x40U) != 0) frame.id = canopen::kSdoReplyBase + contract::node_id(contract::Node::tilt_left);
      const std::uint32_t crc = updating.header().crc;
      told_crc = told_crc || (frame.dlc == 8 && contract::read_le(&frame.data[4], 4) == crc);
      updating.on_frame(frame);
    }
    const auto frame = updating.step(now_ns);
    must(!frame || (frame->id <= 0x7FF && frame->dlc <= 8), "only frames that can exist are sent");
  }
  must(updating.over(), "an update always comes to an end");
  must(updating.failure() != bus::FirmwareUpdate::Failure::none || told_crc, "done only when the node told this very CRC");
}
std::vector<Input> seeds_firmware_update() {
  // First the listening phase, then a loader that identifies itself and accepts everything.
  Input input(7, 0x3F);
  const std::uint8_t id = contract::node_id(contract::Node::tilt_left);
  const auto answer = [&](std::uint8_t command, std::uint16_t index, std::uint8_t sub, std::uint32_t value) {
    append(input, canopen::sdo(canopen::kSdoReplyBase + id, command, index, sub, value));
  };
  answer(0x43, 0x1018, 2, 1U | contract::kLoaderProduct | canopen::kSimulatedProduct);
  answer(0x43, contract::kProgramVersion, 1, 0);
  answer(0x43, contract::kProgramId, 1, 0);
  answer(0x43, contract::kFlashStatus, 1, 2);
  answer(0x60, contract::kProgramData, 1, 0);
  return {input, Input(20, 0x3F)};
}

}  // namespace hoist::fuzz
