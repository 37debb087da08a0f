// The violations that the model of the STM32F072 reports, and what its blocks do when used as RM0091 says.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/machine/probe.hpp"
#include "tests/machine/stm32f072.hpp"

namespace hoist::machine {
namespace {

using contract::CanFrame;

constexpr std::uint32_t kRcc = 0x40021000, kFlashIf = 0x40022000, kCan = 0x40006400, kAdc = 0x40012400, kIwdg = 0x40003000,
                        kTim1 = 0x40012C00, kTim2 = 0x40000000, kTim3 = 0x40000400, kI2c = 0x40005400, kUsart = 0x40013800,
                        kSpi = 0x40013000, kPortA = 0x48000000, kPortB = 0x48000400, kPage = 0x0801F000;

class StmProbe : public Probe<StmProbe> {
 public:
  StmProbe()
      : Probe(std::make_unique<Stm32f072>("probe", flash_with_vectors(Stm32f072::kFlashSize, Stm32f072::kSramBase)), Stm32f072::kSramBase) {
  }
  Stm32f072& stm() { return static_cast<Stm32f072&>(chip()); }

  // The ways the manual gives.
  StmProbe& start_crystal_and_pll() {
    return write(kFlashIf, 0x11)
        .set_bits(kRcc, 1U << 16)
        .wait(3 * kMillisecond)
        .write(kRcc + 4, (2U << 15) | (4U << 18))
        .set_bits(kRcc, 1U << 24)
        .wait(kMillisecond)
        .set_bits(kRcc + 4, 2);
  }
  StmProbe& ports() { return set_bits(kRcc + 0x14, 3U << 17); }
  StmProbe& can_initialisation() {
    return ports().set_bits(kRcc + 0x1C, 1U << 25).write(kPortB + 0x24, 0x44).write(kPortB, 0xA0000).write(kCan, 1).wait(kMicrosecond);
  }
  StmProbe& can_accept_all() {
    return write(kCan + 0x200, 0x2A1C0E01).write(kCan + 0x20C, 1).write(kCan + 0x21C, 1).write(kCan + 0x200, 0x2A1C0E00);
  }
  StmProbe& can_run() {
    return start_crystal_and_pll().can_initialisation().write(kCan + 0x1C, 0x001C000B).can_accept_all().write(kCan, 0);
  }
  StmProbe& unlock_flash() { return write(kFlashIf + 4, 0x45670123).write(kFlashIf + 4, 0xCDEF89AB); }
  // PA5 clocks, PA7 sends. A pin whose speed stays as after reset follows 2 MHz.
  StmProbe& spi_byte_at_4_mhz(std::uint32_t fast_pins) {
    return ports()
        .set_bits(kRcc + 0x18, 1U << 12)
        .set_bits(kPortA + 8, fast_pins)
        .write(kPortA, 0x2800A800)
        .write(kSpi + 4, 0x1700)
        .write(kSpi, 0x347)  // master, 8 MHz / 2
        .write_byte(kSpi + 0x0C, 0);
  }
  StmProbe& adc_on() {
    set_bits(kRcc + 0x18, 1U << 9).write(kAdc + 0x10, 2U << 30).write(kAdc + 8, 1U << 31).wait(100 * kMicrosecond);
    return write(kAdc + 8, 1).wait(10 * kMicrosecond);
  }
};

// A probe's controller and a computer on one wire.
struct OnWire {
  OnWire() {
    (void)wire.connect(host);
    port = wire.connect(probe.stm().can());
    probe.can_run();
  }
  void run(Time time) {
    for (const Time end = probe.chip().now() + time; probe.chip().now() < end;) {
      probe.wait(4 * kMicrosecond);
      wire.advance(probe.chip().now());
    }
  }
  void mailbox(unsigned box, std::uint32_t id_word, std::uint32_t low) {
    const std::uint32_t base = kCan + 0x180 + 16 * box;
    probe.write(base + 4, 1);
    probe.write(base + 8, low);
    probe.write(base, id_word | 1U);
  }
  StmProbe probe;
  HostStation host;
  CanWire wire;
  std::size_t port{};
};

CanFrame frame(std::uint32_t id, std::uint8_t byte) {
  CanFrame out;
  out.id = id;
  out.dlc = 1;
  out.data[0] = byte;
  return out;
}

struct Case {
  const char* name;
  void (*act)(StmProbe&);
  const char* complaint;
};
class StmComplains : public testing::TestWithParam<Case> {};
TEST_P(StmComplains, AboutWhatTheManualForbids) {
  StmProbe probe;
  GetParam().act(probe);
  EXPECT_TRUE(probe.complained(GetParam().complaint)) << "found only:\n" << probe.all();
}
INSTANTIATE_TEST_SUITE_P(
    Cases, StmComplains,
    testing::Values(
        Case{"timer_without_clock", [](StmProbe& p) { p.write(kTim3, 1); }, "TIM3 touched without its clock"},
        Case{"port_without_clock", [](StmProbe& p) { (void)p.read(kPortB); }, "port B touched without its clock"},
        Case{"block_not_there", [](StmProbe& p) { (void)p.read(0x40007400); }, "block that does not exist or is not modelled"},
        Case{"rcc_nothing_there", [](StmProbe& p) { (void)p.read(kRcc + 0x38); }, "RCC: read of register 38"},
        Case{"rcc_reserved", [](StmProbe& p) { p.write(kRcc + 0x1C, 1U << 3); }, "reserved bits of APB1ENR"},
        Case{"flash_too_fast",
             [](StmProbe& p) {
               p.write(kFlashIf, 0x10)
                   .set_bits(kRcc, 1U << 16)
                   .wait(3 * kMillisecond)
                   .write(kRcc + 4, (2U << 15) | (4U << 18))
                   .set_bits(kRcc, 1U << 24)
                   .wait(kMillisecond)
                   .set_bits(kRcc + 4, 2);
             },
             "0 wait states at 48000000 Hz"},
        Case{"pll_not_locked",
             [](StmProbe& p) { p.write(kFlashIf, 0x11).write(kRcc + 4, 10U << 18).set_bits(kRcc, 1U << 24).set_bits(kRcc + 4, 2); },
             "before it has locked"},
        Case{"pll_changed_while_on", [](StmProbe& p) { p.start_crystal_and_pll().write(kRcc + 4, (2U << 15) | (3U << 18) | 2U); },
             "PLL changed while it is switched on"},
        Case{"bit_timing_outside_initialisation", [](StmProbe& p) { p.set_bits(kRcc + 0x1C, 1U << 25).write(kCan + 0x1C, 0x001C000B); },
             "BTR written outside initialisation mode"},
        Case{"wrong_bit_rate", [](StmProbe& p) { p.can_initialisation().write(kCan + 0x1C, 0x001C000B).write(kCan, 0); },
             "is not 4 us"},  // right for 48 MHz; the clock is still 8 MHz
        Case{"initialisation_taken_back_too_early",
             [](StmProbe& p) {
               p.can_run();
               p.wait(kMillisecond);
               p.write(kCan, 2);  // sleep is entered at once on an idle bus; INRQ then has to be confirmed
               p.write(kCan, 0);
             },
             "woken from sleep without having been initialised"},
        Case{"filter_without_finit", [](StmProbe& p) { p.can_initialisation().can_accept_all().write(kCan + 0x204, 1); },
             "register 204 written without FINIT"},
        Case{"active_filter_changed", [](StmProbe& p) { p.can_initialisation().can_accept_all().write(kCan + 0x240, 1); },
             "active filter bank written"},
        Case{"pending_mailbox_changed",
             [](StmProbe& p) {
               p.can_initialisation().write(kCan + 0x184, 0).write(kCan + 0x180, (0x123U << 21) | 1U).write(kCan + 0x188, 5);
             },
             "mailbox 0 written while it is pending"},
        Case{"empty_fifo_read", [](StmProbe& p) { (void)p.can_initialisation().read(kCan + 0x1B0); }, "empty FIFO 0 read"},
        Case{"can_filter_bank_15", [](StmProbe& p) { p.can_initialisation().write(kCan + 0x21C, 1U << 14); },
             "filter bank that does not exist"},
        Case{"flash_without_key", [](StmProbe& p) { p.write(kFlashIf + 0x10, 2); }, "CR written while it is locked"},
        Case{"flash_wrong_key", [](StmProbe& p) { p.write(kFlashIf + 4, 0xCDEF89AB); }, "wrong key"},
        Case{"flash_without_pg", [](StmProbe& p) { p.unlock_flash().write_half(kPage, 1); }, "without PG"},
        Case{"flash_by_words", [](StmProbe& p) { p.unlock_flash().write(kFlashIf + 0x10, 1).write(kPage, 1); },
             "something else than half-words"},
        Case{"flash_over_flash",
             [](StmProbe& p) { p.unlock_flash().write(kFlashIf + 0x10, 1).write_half(kPage, 0x1234).write_half(kPage, 0x1230); }, "PGERR"},
        Case{"iwdg_without_key", [](StmProbe& p) { p.write(kIwdg + 8, 100); }, "register 8 written without its key"},
        Case{"iwdg_while_updating", [](StmProbe& p) { p.write(kIwdg, 0x5555).write(kIwdg + 8, 100).write(kIwdg + 8, 200); },
             "register 8 written while it is being updated"},
        Case{"adc_before_ready", [](StmProbe& p) { p.set_bits(kRcc + 0x18, 1U << 9).write(kAdc + 0x28, 1).write(kAdc + 8, 4); },
             "started before it is ready"},
        Case{"adc_calibrated_while_on", [](StmProbe& p) { p.adc_on().write(kAdc + 8, 1U << 31); }, "calibrated while it is on"},
        Case{"adc_configured_while_started", [](StmProbe& p) { p.adc_on().write(kAdc + 0x28, 1).write(kAdc + 8, 4).write(kAdc + 0x28, 2); },
             "written while ADSTART is set"},
        Case{"adc_pin_digital", [](StmProbe& p) { p.ports().adc_on().write(kAdc + 0x28, 1).write(kAdc + 8, 4).wait(kMillisecond); },
             "outside analog mode"},
        Case{"encoder_without_inputs", [](StmProbe& p) { p.set_bits(kRcc + 0x1C, 2).write(kTim3 + 8, 3).write(kTim3, 1); },
             "without both channels switched to their inputs"},
        Case{"timer_channel_interrupt", [](StmProbe& p) { p.set_bits(kRcc + 0x1C, 1).write(kTim2 + 0x0C, 2); }, "interrupts of channels"},
        Case{"i2c_without_pins",
             [](StmProbe& p) { p.set_bits(kRcc + 0x1C, 1U << 21).write(kI2c, 1).write(kI2c + 4, (1U << 16) | (1U << 13)); },
             "START without the pins"},
        Case{"i2c_too_fast", [](StmProbe& p) { p.set_bits(kRcc + 0x1C, 1U << 21).write(kI2c + 0x10, 0x00000000); },
             "fast mode ends at 400 kHz"},
        Case{"usart_wrong_baud", [](StmProbe& p) { p.set_bits(kRcc + 0x18, 1U << 14).write(kUsart + 0x0C, 48).write(kUsart, 0x0D); },
             "baud, the line has 1000000"},
        Case{"spi_word_is_two_bytes",
             [](StmProbe& p) {
               p.ports();
               p.set_bits(kRcc + 0x18, 1U << 12);
               p.write(kPortA, 0x2800A800);
               p.write(kSpi + 4, 0x1700);
               p.write(kSpi, 0x347);
               for (int i = 0; i < 3; ++i) p.write(kSpi + 0x0C, 0);
               p.wait(kMillisecond);
             },
             "full transmit FIFO written"},
        Case{"spi_data_pin_too_slow", [](StmProbe& p) { p.spi_byte_at_4_mhz(3U << 10); }, "faster than its pins (OSPEEDR)"},
        Case{"spi_clock_pin_too_slow", [](StmProbe& p) { p.spi_byte_at_4_mhz(3U << 14); }, "faster than its pins (OSPEEDR)"},
        Case{"gpio_nothing_there", [](StmProbe& p) { p.ports().write(kPortA + 0x2C, 0); }, "GPIO: write to register 2C"},
        Case{"output_against_output",
             [](StmProbe& p) {
               p.ports();
               p.chip().drive_pin({0, 5}, true);
               p.write(kPortA, 0x28000400);
             },
             "made an output against something that drives it"},
        Case{"debugger_locked_out", [](StmProbe& p) { p.ports().write(kPortA, 0); }, "switched away from the debugger"}),
    [](const testing::TestParamInfo<Case>& tested) { return std::string(tested.param.name); });

TEST(StmAllowed, TheManualsWayToTheClockPasses) {
  StmProbe probe;
  EXPECT_EQ(probe.chip().clock_hz(), 8'000'000U);
  probe.start_crystal_and_pll();
  EXPECT_EQ(probe.chip().clock_hz(), 48'000'000U);
  EXPECT_EQ(probe.all(), "");
}

TEST(StmAllowed, FlashIsErasedByPagesAndProgrammedByHalfWords) {
  StmProbe probe;
  probe.unlock_flash();
  probe.write(kFlashIf + 0x10, 1);
  probe.write_half(kPage, 0x1234);
  probe.write_half(kPage, 0);  // zeros over anything
  EXPECT_EQ(probe.read(kPage), 0xFFFF0000U);
  EXPECT_EQ(probe.read(kFlashIf + 0x0C), 0x20U);  // EOP
  probe.write(kFlashIf + 0x10, 2);
  probe.write(kFlashIf + 0x14, kPage + 0x10);
  const Time before = probe.chip().now();
  probe.write(kFlashIf + 0x10, 0x42);
  EXPECT_GE(probe.chip().now() - before, 40 * kMillisecond);
  EXPECT_EQ(probe.read(kPage), 0xFFFFFFFFU);
  probe.write(kFlashIf + 0x10, 0x80);
  EXPECT_EQ(probe.all(), "");
}

TEST(StmAllowed, TheWatchdogResetsWhenItIsNotFedAndSaysSo) {
  StmProbe probe;
  probe.write(kIwdg, 0xCCCC);
  probe.write(kIwdg, 0x5555);
  probe.write(kIwdg + 8, 199);  // 200 times 4 / 40 kHz = 20 ms
  EXPECT_EQ(probe.read(kIwdg + 0x0C), 2U);
  probe.wait(kMillisecond);
  EXPECT_EQ(probe.read(kIwdg + 0x0C), 0U);
  for (int i = 0; i < 10; ++i) {
    probe.write(kIwdg, 0xAAAA);
    probe.wait(15 * kMillisecond);
  }
  EXPECT_EQ(probe.chip().resets(ResetCause::watchdog), 0U);
  probe.wait(21 * kMillisecond);
  EXPECT_EQ(probe.chip().resets(ResetCause::watchdog), 1U);
  EXPECT_EQ(probe.read(kRcc + 0x24) & 0xFC000000U, 0x2C000000U);  // watchdog, pin, and the power-on that nothing has taken back
  probe.set_bits(kRcc + 0x24, 1U << 24);
  EXPECT_EQ(probe.read(kRcc + 0x24) & 0xFC000000U, 0U);
  EXPECT_EQ(probe.all(), "");
}

TEST(StmAllowed, FastPinsFollowAnSpiClockOf4Mhz) {
  StmProbe probe;
  probe.spi_byte_at_4_mhz(3U << 10 | 3U << 14);
  EXPECT_EQ(probe.all(), "");
}

// RM0091, "Counting direction versus encoder signals": A before B counts up, four counts a line.
TEST(StmAllowed, TheEncoderModeCountsBothEdgesOfBothLines) {
  StmProbe probe;
  probe.ports();
  probe.set_bits(kRcc + 0x1C, 2);
  probe.chip().drive_pin({0, 6}, false);
  probe.chip().drive_pin({0, 7}, false);
  probe.write(kPortA + 0x20, 0x11000000);
  probe.write(kPortA, 0x2800A000);
  probe.write(kTim3 + 0x18, 0x0101);
  probe.write(kTim3 + 0x08, 3);
  probe.write(kTim3, 1);
  constexpr std::array<unsigned, 4> kForward{1, 3, 2, 0};  // bit 0: A
  for (unsigned i = 0; i < 6; ++i) {
    probe.chip().drive_pin({0, 6}, (kForward[i % 4] & 1U) != 0);
    probe.chip().drive_pin({0, 7}, (kForward[i % 4] & 2U) != 0);
    probe.wait(10 * kMicrosecond);
  }
  EXPECT_EQ(probe.read(kTim3 + 0x24), 6U);
  constexpr std::array<unsigned, 8> kBack{1, 0, 2, 3, 1, 0, 2, 3};
  for (const unsigned lines : kBack) {
    probe.chip().drive_pin({0, 6}, (lines & 1U) != 0);
    probe.chip().drive_pin({0, 7}, (lines & 2U) != 0);
    probe.wait(10 * kMicrosecond);
  }
  EXPECT_EQ(probe.read(kTim3 + 0x24), 0xFFFEU);  // through zero downwards, to the top
  EXPECT_EQ(probe.all(), "");
}

TEST(StmAllowed, PwmChangesAtTheEndOfThePeriodAndOnlyWithTheMainOutputOn) {
  StmProbe probe;
  probe.start_crystal_and_pll();
  probe.ports();
  probe.set_bits(kRcc + 0x18, 1U << 11);
  probe.write(kPortA + 0x24, 2);
  probe.write(kPortA, 0x28020000);
  probe.write(kTim1 + 0x2C, 2399);
  probe.write(kTim1 + 0x18, 0x78);  // PWM mode 2, preload
  probe.write(kTim1 + 0x34, 1800);
  probe.write(kTim1 + 0x14, 1);
  probe.write(kTim1 + 0x20, 1);
  probe.write(kTim1, 0x81);
  EXPECT_FALSE(probe.chip().pin_driven_by_chip({0, 8}));
  probe.write(kTim1 + 0x44, 0x8000);
  EXPECT_TRUE(probe.chip().pin_driven_by_chip({0, 8}));
  EXPECT_NEAR(probe.chip().pin_high_share({0, 8}), 0.25, 1e-9);
  probe.write(kTim1 + 0x34, 600);
  EXPECT_NEAR(probe.chip().pin_high_share({0, 8}), 0.25, 1e-9);
  probe.wait(60 * kMicrosecond);
  EXPECT_NEAR(probe.chip().pin_high_share({0, 8}), 0.75, 1e-9);
  EXPECT_EQ(probe.all(), "");
}

TEST(StmAllowed, TheConverterMeasuresWhatStandsAtItsPin) {
  StmProbe probe;
  probe.start_crystal_and_pll();
  probe.ports();
  probe.chip().set_analog([](unsigned channel, Time) { return channel == 4 ? 1.65 : 0.0; });
  probe.write(kPortA, 0x28000300);
  probe.adc_on();
  EXPECT_EQ(probe.read(kAdc) & 1U, 1U);
  probe.write(kAdc + 0x14, 3);
  probe.write(kAdc + 0x28, 1U << 4);
  probe.write(kAdc + 8, 4);
  EXPECT_EQ(probe.read(kAdc) & 4U, 0U);
  probe.wait(4 * kMicrosecond);  // 41 clocks of 12 MHz
  EXPECT_EQ(probe.read(kAdc) & 4U, 4U);
  EXPECT_EQ(probe.read(kAdc + 0x40), 2048U);
  EXPECT_EQ(probe.read(kAdc) & 4U, 0U);
  EXPECT_EQ(probe.read(kAdc + 8) & 4U, 0U);
  EXPECT_EQ(probe.all(), "");
}

// ---- bxCAN

TEST(BxCan, ItTakesPartAfterElevenRecessiveBits) {
  OnWire on;
  EXPECT_EQ(on.probe.read(kCan + 4) & 1U, 1U);  // INAK until then
  on.run(kMillisecond);
  EXPECT_EQ(on.probe.read(kCan + 4) & 3U, 0U);
  on.host.send(frame(0x123, 7));
  on.run(kMillisecond);
  EXPECT_EQ(on.probe.read(kCan + 0x0C) & 3U, 1U);
  EXPECT_EQ(on.probe.read(kCan + 0x1B0), 0x123U << 21);
  EXPECT_EQ(on.probe.read(kCan + 0x1B8) & 0xFFU, 7U);
  on.probe.write(kCan + 0x0C, 0x20);
  on.run(kMicrosecond);
  EXPECT_EQ(on.probe.read(kCan + 0x0C) & 0x23U, 0U);
  EXPECT_EQ(on.probe.all(), "");
}

TEST(BxCan, TheLowestIdentifierLeavesFirstAndOfEqualOnesTheLowestMailbox) {
  OnWire on;
  on.run(kMillisecond);
  on.mailbox(0, 0x300U << 21, 1);
  on.mailbox(1, 0x100U << 21, 2);
  on.mailbox(2, 0x100U << 21, 3);
  EXPECT_EQ(on.probe.read(kCan + 8) >> 26 & 7U, 0U);
  EXPECT_EQ(on.probe.read(kCan + 8) >> 24 & 3U, 0U);  // all pending: the one of the lowest priority
  on.run(2 * kMillisecond);
  ASSERT_EQ(on.host.received.size(), 3U);
  EXPECT_EQ(on.host.received[0].data[0], 2U);
  EXPECT_EQ(on.host.received[1].data[0], 3U);
  EXPECT_EQ(on.host.received[2].data[0], 1U);
  EXPECT_EQ(on.probe.read(kCan + 8) & 0x030303U, 0x030303U);  // done, and well
  on.probe.write(kCan + 8, 0x010101U);
  EXPECT_EQ(on.probe.read(kCan + 8) & 0x0F0F0FU, 0U);
  EXPECT_EQ(on.probe.all(), "");
}

TEST(BxCan, FiltersOfBothWidthsAndModesAssignTheirFifo) {
  OnWire on;
  StmProbe& probe = on.probe;
  probe.write(kCan + 0x200, 0x2A1C0E01);
  probe.write(kCan + 0x21C, 0);
  probe.write(kCan + 0x204, 0b0110);  // banks 1 and 2 are lists
  probe.write(kCan + 0x20C, 0b0011);  // banks 0 and 1 are of 32 bit
  probe.write(kCan + 0x214, 0b0101);  // banks 0 and 2 go into FIFO 1
  probe.write(kCan + 0x240, 0x100U << 21);
  probe.write(kCan + 0x244, (0x7F0U << 21) | 4U);  // 100h to 10Fh, standard
  probe.write(kCan + 0x248, (0x12345U << 3) | 4U);
  probe.write(kCan + 0x24C, (0x200U << 21) | 2U);  // a remote frame
  probe.write(kCan + 0x250, (0x301U << 21) | (0x300U << 5));
  probe.write(kCan + 0x254, (0x303U << 21) | (0x302U << 5));
  probe.write(kCan + 0x258, (0xFFE0U << 16) | (0x400U << 5));  // 16 bit mask: 400h of any kind
  probe.write(kCan + 0x25C, 0xFFFFFFFF);                       // nothing: a reserved pattern
  probe.write(kCan + 0x21C, 0b1111);
  probe.write(kCan + 0x200, 0x2A1C0E00);
  on.run(kMillisecond);
  const auto levels = [&] { return std::pair(probe.read(kCan + 0x0C) & 3U, probe.read(kCan + 0x10) & 3U); };
  const auto send = [&](std::uint32_t id, std::uint8_t flags) {
    CanFrame out = frame(id, 0);
    out.flags = flags;
    on.host.send(out);
    on.run(kMillisecond);
  };
  send(0x10A, 0);
  EXPECT_EQ(levels(), std::pair(0U, 1U));
  send(0x110, 0);
  EXPECT_EQ(levels(), std::pair(0U, 1U));
  send(0x12345, CanFrame::kExtended);
  EXPECT_EQ(levels(), std::pair(1U, 1U));
  send(0x200, 0);
  EXPECT_EQ(levels(), std::pair(1U, 1U));
  send(0x200, CanFrame::kRemote);
  EXPECT_EQ(levels(), std::pair(2U, 1U));
  send(0x303, 0);
  EXPECT_EQ(levels(), std::pair(2U, 2U));
  send(0x400, 0);
  EXPECT_EQ(levels(), std::pair(3U, 2U));
  EXPECT_EQ(probe.read(kCan + 0x0C) & 8U, 8U);  // full
  send(0x400, 0);
  EXPECT_EQ(probe.read(kCan + 0x0C) & 0x10U, 0x10U);  // overrun
  EXPECT_EQ(probe.all(), "");
}

// RM0091: without ABOM the way back from bus-off leads through initialisation mode, and takes 128 times 11 recessive bits.
TEST(BxCan, BusOffEndsOnlyThroughInitialisationMode) {
  OnWire on;
  on.run(kMillisecond);
  on.wire.set_hook(
      [&on](std::size_t from, const CanFrame&, Time) { return from == on.port ? CanWire::Mischief::corrupt : CanWire::Mischief::none; });
  on.mailbox(0, 0x100U << 21, 1);
  on.run(30 * kMillisecond);
  EXPECT_EQ(on.probe.read(kCan + 0x18) & 7U, 7U);  // warning, passive, off
  on.wire.set_hook({});
  on.run(100 * kMillisecond);
  EXPECT_EQ(on.probe.read(kCan + 0x18) & 4U, 4U);
  EXPECT_TRUE(on.host.received.empty());
  on.probe.write(kCan + 8, 0x80);  // the frame from before is taken back
  EXPECT_EQ(on.probe.read(kCan + 8) >> 26 & 7U, 7U);
  on.probe.write(kCan, 1);
  on.run(kMicrosecond);
  EXPECT_EQ(on.probe.read(kCan + 4) & 1U, 1U);
  on.probe.write(kCan, 0);
  on.run(5 * kMillisecond);
  EXPECT_EQ(on.probe.read(kCan + 0x18) & 4U, 4U);  // 1408 bits are 5.6 ms
  on.run(2 * kMillisecond);
  EXPECT_EQ(on.probe.read(kCan + 0x18) & 0xFFFF0007U, 0U);
  on.mailbox(0, 0x101U << 21, 2);
  on.run(kMillisecond);
  ASSERT_EQ(on.host.received.size(), 1U);
  EXPECT_EQ(on.host.received[0].id, 0x101U);
  EXPECT_EQ(on.probe.all(), "");
}

}  // namespace
}  // namespace hoist::machine
