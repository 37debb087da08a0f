// The loader in virtual time: what it starts, what it takes, and what is left after the power was cut anywhere.
#include "firmware/boot/loader.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "tests/unit/boot/boot_support.hpp"

namespace hoist::firmware {
namespace {

constexpr std::uint32_t kOld = contract::image_version(1, 0, 0), kNew = contract::image_version(1, 1, 0);
constexpr std::uint32_t kRange = 0x06090030, kTooLong = 0x06070012, kTooShort = 0x06070013, kState = 0x08000022, kTransfer = 0x08000020,
                        kHardware = 0x06060000;

struct Bench : LoaderBench, testing::Test {
  void burn_old() { board.flash.burn(make_image(9000, kOld, 1)); }
  void enter() {
    request_loader(board.box);
    ASSERT_EQ(reset(LoaderReset::software), StartReason::asked);
  }
};
using Start = Bench;
using Transfer = Bench;
using PowerCut = Bench;

TEST_F(Start, AWholeProgramIsStarted) {
  burn_old();
  EXPECT_EQ(reset(LoaderReset::power_or_pin), StartReason::application);
}

TEST_F(Start, AnEmptyOrDamagedOneIsNot) {
  EXPECT_EQ(reset(LoaderReset::power_or_pin), StartReason::no_program);
  auto image = make_image(9000, kOld);
  image[5000] ^= 1;
  board.flash.burn(image);
  EXPECT_EQ(reset(LoaderReset::power_or_pin), StartReason::no_program);
  EXPECT_EQ(status(), static_cast<std::uint32_t>(FlashStatus::damaged));
}

TEST_F(Start, AProgramForAnotherNodeIsNot) {
  board.flash.burn(make_image(9000, kOld, 1, ImageKind::tilt));
  EXPECT_EQ(reset(LoaderReset::power_or_pin), StartReason::no_program);
  EXPECT_EQ(status(), static_cast<std::uint32_t>(FlashStatus::unknown_format));
}

TEST_F(Start, ARequestCountsForOneStartOnly) {
  burn_old();
  request_loader(board.box);
  EXPECT_EQ(reset(LoaderReset::software), StartReason::asked);
  EXPECT_EQ(reset(LoaderReset::software), StartReason::application);
  EXPECT_EQ(failures(board.box), 0U);
}

// After power-on the mailbox is random, perhaps even valid words; the node must still start.
TEST_F(Start, AMailboxAfterPowerOnAsksNothing) {
  burn_old();
  request_loader(board.box);
  EXPECT_EQ(reset(LoaderReset::power_or_pin), StartReason::application);
  board.box = {kEnterLoader, 0, 77, 77};
  EXPECT_EQ(reset(LoaderReset::software), StartReason::application);
}

TEST_F(Start, ThreeWatchdogResetsInARowKeepTheNode) {
  burn_old();
  EXPECT_EQ(reset(LoaderReset::power_or_pin), StartReason::application);
  EXPECT_EQ(reset(LoaderReset::watchdog), StartReason::application);
  EXPECT_EQ(reset(LoaderReset::watchdog), StartReason::application);
  forget_failures(board.box);  // it ran for ten seconds
  EXPECT_EQ(reset(LoaderReset::watchdog), StartReason::application);
  EXPECT_EQ(reset(LoaderReset::watchdog), StartReason::application);
  EXPECT_EQ(reset(LoaderReset::watchdog), StartReason::failed_starts);
  EXPECT_EQ(status(), static_cast<std::uint32_t>(FlashStatus::failed_starts));
  EXPECT_EQ(reset(LoaderReset::software), StartReason::failed_starts);  // not forgotten by a restart of the loader
  EXPECT_EQ(write(contract::kProgramControl, 1, 1), 0U);                // but a person may try again
  run(3);
  EXPECT_TRUE(board.restarted);
  EXPECT_EQ(reset(LoaderReset::software), StartReason::application);
}

// A fault resets the chip as a restart does; only the orderly one takes its mark away.
TEST_F(Start, ThreeFaultsInARowKeepTheNodeAndRestartsDoNot) {
  burn_old();
  EXPECT_EQ(reset(LoaderReset::power_or_pin), StartReason::application);
  for (int i = 0; i < 10; ++i) {
    forget_request(board.box);
    EXPECT_EQ(reset(LoaderReset::software), StartReason::application) << i;
  }
  EXPECT_EQ(reset(LoaderReset::software), StartReason::application);
  EXPECT_EQ(reset(LoaderReset::watchdog), StartReason::application);
  EXPECT_EQ(reset(LoaderReset::software), StartReason::failed_starts);
  EXPECT_EQ(reset(LoaderReset::power_or_pin), StartReason::application);  // switched off and on: it may try again
}

TEST_F(Start, TheServicePinAlwaysWins) {
  burn_old();
  EXPECT_EQ(reset(LoaderReset::power_or_pin, true), StartReason::service_pin);
}

TEST_F(Start, ALoaderSaysThatItIsOne) {
  burn_old();
  enter();
  ASSERT_EQ(board.sent.size(), 1U);
  EXPECT_EQ(board.sent[0], canopen::heartbeat(kTestNode, canopen::NmtState::boot_up));
  board.sent.clear();
  run(250);
  ASSERT_EQ(board.sent.size(), 2U);
  EXPECT_EQ(board.sent[0], canopen::heartbeat(kTestNode, canopen::NmtState::pre_operational));
  EXPECT_EQ(read(0x1018, 2).raw, 2U | contract::kLoaderProduct | canopen::kSimulatedProduct);
  EXPECT_EQ(read(0x1018, 0).raw & 0xFFU, 4U);
  EXPECT_EQ(read(contract::kProgramVersion, 1).raw, kOld);
  EXPECT_EQ(read(contract::kProgramId, 1).raw, contract::read_image_header(board.application()).crc);
  EXPECT_EQ(status(), 0U);
  EXPECT_EQ(read(0x6041, 0).abort, 0x06020000U);
  EXPECT_EQ(read(0x1018, 5).abort, 0x06090011U);
  EXPECT_EQ(read(contract::kProgramData, 1).abort, 0x06010001U);
  EXPECT_EQ(write(contract::kFlashStatus, 1, 0), 0x06010002U);
}

// NMT start makes a node operational: a loader must never be.
TEST_F(Start, ALoaderNeverBecomesOperational) {
  enter();
  loader->on_frame(canopen::nmt(canopen::NmtCommand::start, 0));
  board.sent.clear();
  run(1000);
  ASSERT_EQ(board.sent.size(), 10U);
  for (const auto& frame : board.sent) EXPECT_EQ(frame, canopen::heartbeat(kTestNode, canopen::NmtState::pre_operational));
}

TEST_F(Start, AForgottenLoaderGoesBackToWork) {
  burn_old();
  enter();
  run(static_cast<int>(kLoaderPatience_ms) - 2);
  EXPECT_FALSE(board.restarted);
  run(5);
  EXPECT_TRUE(board.restarted);
  EXPECT_FALSE(loader_requested(board.box));
  board.flash.burn({});
  enter();
  run(2 * static_cast<int>(kLoaderPatience_ms));
  EXPECT_FALSE(board.restarted);  // without a program there is nothing to start
}

// The computer that sent it died before it said "start".
TEST_F(Transfer, ANewProgramThatNobodyStartsStartsByItself) {
  ASSERT_EQ(reset(LoaderReset::power_or_pin), StartReason::no_program);
  ASSERT_EQ(download(make_image(2000, kNew)), 0U);
  run(static_cast<int>(kLoaderPatience_ms) - 10);
  EXPECT_FALSE(board.restarted);
  run(20);
  EXPECT_TRUE(board.restarted);
  EXPECT_EQ(reset(LoaderReset::software), StartReason::application);
}

TEST_F(Transfer, ANewProgramIsTakenAndStarted) {
  burn_old();
  enter();
  const auto image = make_image(10001, kNew, 2);
  EXPECT_EQ(download(image), 0U);
  EXPECT_EQ(status(), 0U);
  EXPECT_EQ(read(contract::kProgramVersion, 1).raw, kNew);
  EXPECT_EQ(read(contract::kProgramId, 1).raw, contract::read_image_header(image).crc);
  EXPECT_TRUE(std::equal(image.begin(), image.end(), board.application().begin()));
  EXPECT_EQ(board.flash.misuses(), 0U);
  // The answer leaves before the reset.
  board.bus_busy = true;
  EXPECT_EQ(write(contract::kProgramControl, 1, 1), 0U);
  run(10);
  EXPECT_FALSE(board.restarted);
  board.bus_busy = false;
  run(1);
  EXPECT_TRUE(board.restarted);
  EXPECT_EQ(reset(LoaderReset::software), StartReason::application);
}

TEST_F(Transfer, EveryLengthAroundPagesAndSectorsFits) {
  for (const std::size_t bytes : {212U, 213U, 255U, 256U, 257U, 511U, 512U, 513U, 4095U, 4096U, 4097U, 8192U, 0x5000U}) {
    board.flash.burn({});
    enter();
    const auto image = make_image(bytes, kNew, 3);
    ASSERT_EQ(download(image), 0U) << bytes;
    ASSERT_EQ(contract::check_flash(board.application(), ImageKind::drive, simulated_chip()), ImageError::none) << bytes;
    ASSERT_EQ(board.flash.misuses(), 0U) << bytes;
  }
}

// A file for something else is refused before anything is erased: the old program stays.
TEST_F(Transfer, AWrongFileCostsNothing) {
  burn_old();
  enter();
  EXPECT_EQ(download(make_image(9000, kNew, 2, ImageKind::tilt)), kRange);
  EXPECT_EQ(download(make_image(9000, kNew, 2, ImageKind::drive, ImageChip::lpc11c24)), kRange);
  EXPECT_EQ(download(std::vector<std::uint8_t>(9000, 0x55)), kRange);
  EXPECT_EQ(download(make_image(0x5001, kNew)), kTooLong);
  EXPECT_EQ(download(std::vector<std::uint8_t>(211, 0)), kTooShort);
  auto lying = make_image(9000, kNew);
  lying.resize(8999);
  EXPECT_EQ(download(lying), 0x06070010U);
  EXPECT_EQ(board.flash.erases(), 0U);
  EXPECT_EQ(status(), 0U);
  EXPECT_EQ(reset(LoaderReset::software), StartReason::application);
}

TEST_F(Transfer, ADamagedFileIsNeverStarted) {
  burn_old();
  enter();
  auto image = make_image(9000, kNew);
  image[8000] ^= 0x10;
  EXPECT_EQ(download(image), kTransfer);
  EXPECT_EQ(status(), static_cast<std::uint32_t>(FlashStatus::damaged));
  EXPECT_EQ(read(contract::kProgramId, 1).raw, 0U);
  EXPECT_EQ(write(contract::kProgramControl, 1, 1), kState);
  EXPECT_EQ(reset(LoaderReset::software), StartReason::no_program);
  EXPECT_EQ(download(make_image(9000, kNew)), 0U);
}

TEST_F(Transfer, AWornFlashIsTold) {
  enter();
  board.flash.set_worn(true);
  EXPECT_EQ(download(make_image(9000, kNew)), kHardware);
  EXPECT_EQ(status(), static_cast<std::uint32_t>(FlashStatus::write_failed));
  EXPECT_EQ(write(contract::kProgramControl, 1, 1), kState);
}

// Flash that reports success and stores something else: the CRC is computed from flash.
TEST_F(Transfer, WhatReadsBackCounts) {
  enter();
  const auto image = make_image(2000, kNew);
  ASSERT_EQ(download(image, 200U), std::nullopt);
  auto content = std::vector<std::uint8_t>(board.application().begin(), board.application().end());
  content[600] ^= 0x04;
  board.flash.burn(content);
  bool toggle = false;
  std::optional<contract::CanFrame> answer;
  for (std::size_t at = 200U * 7; at < image.size(); at += 7) {
    const std::size_t bytes = std::min<std::size_t>(7, image.size() - at);
    contract::CanFrame frame{canopen::kSdoRequestBase + kTestNode, 8, 0, {}};
    frame.data[0] = static_cast<std::uint8_t>((toggle ? 0x10U : 0U) | ((7U - bytes) << 1) | (at + bytes == image.size() ? 1U : 0U));
    std::copy_n(image.begin() + static_cast<std::ptrdiff_t>(at), bytes, frame.data.begin() + 1);
    answer = ask(frame);
    ASSERT_TRUE(answer);
    toggle = !toggle;
  }
  EXPECT_EQ(answer->data[0], canopen::kSdoAbort);
  EXPECT_EQ(contract::read_le(&answer->data[4], 4), kTransfer);
}

TEST_F(Transfer, ClearErasesAllAndSaysWhenItIsDone) {
  burn_old();
  enter();
  board.bus_busy = true;  // the answer first
  EXPECT_EQ(write(contract::kProgramControl, 1, 3), 0U);
  EXPECT_EQ(status(), static_cast<std::uint32_t>(FlashStatus::busy));
  EXPECT_EQ(write(contract::kProgramControl, 1, 1), kState);
  EXPECT_EQ(download(make_image(9000, kNew)), kState);
  EXPECT_EQ(board.flash.erases(), 0U);
  board.bus_busy = false;
  run(10);
  EXPECT_EQ(status(), static_cast<std::uint32_t>(FlashStatus::no_program));
  EXPECT_EQ(board.flash.erases(), 5U);
  EXPECT_EQ(download(make_image(9000, kNew)), 0U);
  EXPECT_EQ(write(contract::kProgramControl, 1, 4), kRange);
}

// A client that dies in the middle: the loader times out after a second and accepts the next one.
TEST_F(Transfer, AnAbandonedTransferIsForgotten) {
  burn_old();
  enter();
  const auto image = make_image(9000, kNew);
  ASSERT_EQ(download(image, 100U), std::nullopt);
  board.sent.clear();
  run(1100);
  bool aborted = false;
  for (const auto& frame : board.sent)
    aborted = aborted || (frame.data[0] == canopen::kSdoAbort && frame.data[7] == 0x05 && frame.data[6] == 0x04);
  EXPECT_TRUE(aborted);
  EXPECT_EQ(status(), static_cast<std::uint32_t>(FlashStatus::no_program));
  EXPECT_EQ(download(image), 0U);
}

// A protocol error ends the transfer with the code of CiA 301, without other effects.
TEST_F(Transfer, AWrongDialogueIsRefused) {
  burn_old();
  enter();
  const auto segment = [&](std::uint8_t command) {
    contract::CanFrame frame{canopen::kSdoRequestBase + kTestNode, 8, 0, {}};
    frame.data[0] = command;
    const auto answer = ask(frame);
    return answer && answer->data[0] == canopen::kSdoAbort ? contract::read_le(&answer->data[4], 4) : 0U;
  };
  EXPECT_EQ(segment(0x00), 0x05040001U);  // no transfer is open
  EXPECT_EQ(ask(0x21, contract::kProgramData, 1, 9000)->data[0], canopen::kSdoDownloadReply);
  EXPECT_EQ(segment(0x10), 0x05030000U);  // the first segment has toggle 0
  EXPECT_EQ(segment(0x00), 0x05040001U);  // and that was its end
  EXPECT_EQ(ask(0x21, contract::kProgramData, 1, 9000)->data[0], canopen::kSdoDownloadReply);
  EXPECT_EQ(segment(0x00), 0U);
  EXPECT_EQ(segment(0x00), 0x05030000U);
  // Another request takes the place of a transfer, and an abort ends it without an answer.
  EXPECT_EQ(ask(0x21, contract::kProgramData, 1, 9000)->data[0], canopen::kSdoDownloadReply);
  EXPECT_EQ(status(), 0U);
  EXPECT_EQ(segment(0x00), 0x05040001U);
  EXPECT_EQ(ask(0x21, contract::kProgramData, 1, 9000)->data[0], canopen::kSdoDownloadReply);
  EXPECT_FALSE(ask(canopen::kSdoAbort, contract::kProgramData, 1, 0x08000000));
  EXPECT_EQ(segment(0x00), 0x05040001U);
  // Short frames, expedited programs, long commands, unknown services.
  contract::CanFrame cut{canopen::kSdoRequestBase + kTestNode, 7, 0, {}};
  cut.data[0] = canopen::kSdoUploadRequest;
  EXPECT_EQ(ask(cut)->data[0], canopen::kSdoAbort);
  EXPECT_EQ(ask(0x23, contract::kProgramData, 1, 1)->data[0], canopen::kSdoAbort);
  EXPECT_EQ(contract::read_le(&ask(0x23, contract::kProgramControl, 1, 1)->data[4], 4), 0x06070010U);
  EXPECT_EQ(contract::read_le(&ask(0xA0, contract::kProgramData, 1, 1)->data[4], 4), 0x05040001U);
  EXPECT_EQ(contract::read_le(&ask(0x60, 0, 0, 0)->data[4], 4), 0x05040001U);
  EXPECT_EQ(board.flash.erases(), 0U);
  EXPECT_FALSE(board.restarted);
  EXPECT_EQ(reset(LoaderReset::software), StartReason::application);
}

// Arbitrary frames: the loader never changes flash without a valid header for this node, and starts only a complete program.
TEST_F(Transfer, AnyFramesDoNoHarm) {
  std::uint32_t state = 12345;
  const auto random = [&state] { return (state = state * 1664525U + 1013904223U) >> 16; };
  burn_old();
  enter();
  int restarts = 0, clears = 0;
  for (int i = 0; i < 200000; ++i) {
    contract::CanFrame frame{};
    const std::uint32_t kind = random() % 8;
    frame.id = kind == 0 ? random() & 0x7FFU : kind == 1 ? canopen::kNmt : canopen::kSdoRequestBase + kTestNode;
    frame.dlc = random() % 8 == 0 ? static_cast<std::uint8_t>(random() % 9) : 8;
    for (auto& byte : frame.data) byte = static_cast<std::uint8_t>(random());
    if (random() % 2 == 0) {  // sensible objects, so that the deeper places are reached
      constexpr std::array<std::uint8_t, 8> kCommands{0x21, 0x2F, 0x40, 0x80, 0x00, 0x10, 0x01, 0x23};
      frame.data[0] = kCommands[random() % kCommands.size()];
      contract::write_le(&frame.data[1], 2, 0x1F50 + random() % 8);
      frame.data[3] = static_cast<std::uint8_t>(random() % 2);
      if (random() % 2 == 0) contract::write_le(&frame.data[4], 4, random() % 16);
    }
    const bool clear = frame.dlc == 8 && (frame.data[0] & 0xF2U) == 0x22U && contract::read_le(&frame.data[1], 3) == 0x011F51U;
    loader->on_frame(frame);
    run(static_cast<int>(random() % 3));
    board.sent.clear();
    if (clear && loader->status() == FlashStatus::busy) ++clears;
    if (board.restarted) {
      ++restarts;
      const StartReason reason = reset(LoaderReset::software);
      if (reason == StartReason::application) {
        ASSERT_EQ(contract::check_flash(board.application(), ImageKind::drive, simulated_chip()), ImageError::none);
        enter();
      }
    }
    if (clears == 0) {
      ASSERT_EQ(board.flash.erases(), 0U) << i;
    }
    if (clears > 0 && random() % 256 == 0) {
      burn_old();
      enter();
    }
  }
  EXPECT_GT(restarts, 20);
  EXPECT_GT(clears, 5);
  EXPECT_EQ(board.flash.writes(), 0U);
  EXPECT_EQ(board.flash.misuses(), 0U);
}

// The loader's guarantee. Power cuts after every erased or written byte (every eleventh in the long middle), so within every erase, every
// page and the header's page; each time the node must return to its loader or run the complete new program, never a partial one, and accept
// the update again.
TEST_F(PowerCut, AtEveryFlashOperationLeavesAnUpdatableNode) {
  const auto before = make_image(9000, kOld, 1), image = make_image(8500, kNew, 2);
  board.flash.burn(before);
  enter();
  const std::uint64_t used_before = board.flash.used();
  ASSERT_EQ(download(image), 0U);
  const std::uint64_t total = board.flash.used() - used_before;
  ASSERT_GT(total, image.size() + 2 * 4096);
  int in_loader = 0, with_new = 0;
  for (std::uint64_t cut = 1; cut <= total; cut += (cut < 600 || cut + 600 > total) ? 1 : 11) {
    board.flash.burn(before);
    enter();
    board.flash.cut_after(cut);
    ASSERT_FALSE(download(image).has_value() && cut < total) << cut;
    const StartReason reason = reset(LoaderReset::power_or_pin);
    if (reason == StartReason::application) {
      // Only the last byte of the last page makes a program, and then it is the new one.
      ASSERT_TRUE(std::equal(image.begin(), image.end(), board.application().begin())) << cut;
      ++with_new;
      continue;
    }
    ASSERT_EQ(reason, StartReason::no_program) << cut;
    ++in_loader;
    ASSERT_EQ(download(image), 0U) << cut;
    ASSERT_EQ(reset(LoaderReset::software), StartReason::application) << cut;
    ASSERT_EQ(board.flash.misuses(), 0U) << cut;
  }
  EXPECT_GT(in_loader, 2000);
  EXPECT_GE(with_new, 1);
}

// The same for the bus: power cut, or death of the client, after every segment.
TEST_F(PowerCut, AfterEverySegmentLeavesAnUpdatableNode) {
  const auto before = make_image(3000, kOld, 1), image = make_image(5000, kNew, 2);
  const std::size_t segments = (image.size() + 6) / 7;
  for (std::size_t stop = 0; stop < segments; ++stop) {
    board.flash.burn(before);
    enter();
    ASSERT_FALSE(download(image, stop)) << stop;
    const StartReason reason = reset(LoaderReset::power_or_pin);
    // 30 segments are 210 bytes: the header is not checked yet and the old program is still intact.
    ASSERT_EQ(reason, stop <= 30 ? StartReason::application : StartReason::no_program) << stop;
    if (reason == StartReason::application) enter();
    ASSERT_EQ(download(image), 0U) << stop;
    ASSERT_EQ(reset(LoaderReset::software), StartReason::application) << stop;
  }
}

}  // namespace
}  // namespace hoist::firmware
