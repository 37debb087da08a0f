// Each violation of the chip model once, and the permitted sequence without a violation.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/machine/lpc11c24.hpp"
#include "tests/machine/probe.hpp"

namespace hoist::machine {
namespace {

constexpr std::uint32_t kSyscon = 0x40048000, kFlashcfg = 0x4003C010, kIocon = 0x40044000, kCan = 0x40050000, kAdc = 0x4001C000,
                        kWwdt = 0x40004000, kI2c = 0x40000000, kUart = 0x40008000, kSsp0 = 0x40040000, kTimer = 0x4000C000,
                        kGpio2 = 0x50020000;

class LpcProbe : public Probe<LpcProbe> {
 public:
  LpcProbe() : Probe(std::make_unique<Lpc11c24>("probe", flash_with_vectors(kFlashBytes, CortexM0::kRamBase)), CortexM0::kRamBase) {}
  /// Calls the ROM's flash routines; their status.
  std::uint32_t iap(const std::vector<std::uint32_t>& command) {
    constexpr std::uint32_t kTable = CortexM0::kRamBase + 0x100, kResult = CortexM0::kRamBase + 0x140;
    for (std::size_t i = 0; i < command.size(); ++i)
      EXPECT_TRUE(chip().core().poke(kTable + 4 * static_cast<std::uint32_t>(i), 4, command[i]));
    chip().core().set_reg(0, kTable);
    chip().core().set_reg(1, kResult);
    chip().core().set_reg(13, CortexM0::kRamBase + 0x1000);
    chip().core().set_reg(14, (CortexM0::kRamBase + 4) | 1U);
    chip().core().set_reg(15, 0x1FFF1FF0);
    chip().run_until(chip().now() + 4);
    std::uint32_t status = 0xFFFFFFFF;
    EXPECT_TRUE(chip().core().peek(kResult, 4, status));
    return status;
  }

  // The sequences of the manual.
  LpcProbe& start_crystal_and_pll() {
    return write(kSyscon + 0x238, 0xED50)
        .wait(600 * kMicrosecond)
        .write(kSyscon + 0x040, 1)
        .write(kSyscon + 0x044, 0)
        .write(kSyscon + 0x044, 1)
        .write(kSyscon + 0x008, 0x23)
        .wait(150 * kMicrosecond)
        .write(kSyscon + 0x070, 3)
        .write(kSyscon + 0x074, 0)
        .write(kSyscon + 0x074, 1);
  }
  LpcProbe& clock(unsigned bit) { return set_bits(kSyscon + 0x080, 1U << bit); }
  LpcProbe& can_ready() { return clock(17).write(kSyscon + 0x004, 8); }
};

struct Case {
  const char* name;
  void (*act)(LpcProbe&);
  const char* complaint;
};
class Complains : public testing::TestWithParam<Case> {};
TEST_P(Complains, AboutWhatTheManualForbids) {
  LpcProbe probe;
  GetParam().act(probe);
  EXPECT_TRUE(probe.complained(GetParam().complaint)) << "found only:\n" << probe.all();
}
INSTANTIATE_TEST_SUITE_P(
    Cases, Complains,
    testing::Values(
        Case{"timer_without_clock", [](LpcProbe& p) { p.write(kTimer + 4, 1); }, "CT16B0 touched without its clock"},
        Case{"adc_without_clock", [](LpcProbe& p) { (void)p.read(kAdc); }, "ADC touched without its clock"},
        Case{"can_in_reset", [](LpcProbe& p) { p.clock(17).write(kCan, 1); }, "C_CAN touched while held in reset"},
        Case{"bit_timing_without_cce", [](LpcProbe& p) { p.can_ready().write(kCan + 0x0C, 0x1C0B); }, "BT written without INIT and CCE"},
        Case{"wrong_bit_rate",
             [](LpcProbe& p) { p.can_ready().write(kCan, 0x41).write(kCan + 0x180, 0).write(kCan + 0x0C, 0x1C0B).write(kCan, 0); },
             "not 4 us"},  // right for 48 MHz; the clock is still 12 MHz
        Case{"interface_busy", [](LpcProbe& p) { p.can_ready().write(kCan + 0x20, 1).write(kCan + 0x24, 0xF0); }, "written while busy"},
        Case{"object_33", [](LpcProbe& p) { p.can_ready().write(kCan + 0x20, 33); }, "message object 33"},
        Case{"pll_out_of_range", [](LpcProbe& p) { p.write(kSyscon + 0x008, 0x03); }, "PLL: its oscillator at 96000000 Hz"},
        Case{"pll_not_locked",
             [](LpcProbe& p) {
               p.write(kSyscon + 0x238, 0xED70)
                   .write(kSyscon + 0x008, 0x23)
                   .write(kSyscon + 0x070, 3)
                   .write(kSyscon + 0x074, 0)
                   .write(kSyscon + 0x074, 1);
             },
             "before it has locked"},
        Case{"crystal_not_started",
             [](LpcProbe& p) {
               p.write(kSyscon + 0x238, 0xEDD0).write(kSyscon + 0x040, 1).write(kSyscon + 0x044, 0).write(kSyscon + 0x044, 1);
             },
             "before it is powered and has started"},
        Case{"flash_too_fast", [](LpcProbe& p) { p.write(kFlashcfg, p.read(kFlashcfg) & ~3U).start_crystal_and_pll(); },
             "0 wait states at 48000000 Hz"},
        Case{"flashcfg_reserved", [](LpcProbe& p) { p.write(kFlashcfg, 2); }, "FLASHCFG: reserved bits"},
        Case{"pdruncfg_reserved", [](LpcProbe& p) { p.write(kSyscon + 0x238, 0x50); }, "PDRUNCFG: reserved bits"},
        Case{"syscon_nothing_there", [](LpcProbe& p) { (void)p.read(kSyscon + 0x3A0); }, "SYSCON: read of register 3A0"},
        Case{"adc_powered_down", [](LpcProbe& p) { p.clock(13).write(kAdc, 0x01000201); }, "ADC: started while powered down"},
        Case{"adc_two_channels", [](LpcProbe& p) { p.clock(13).write(kSyscon + 0x238, 0xEDE0).write(kAdc, 0x01000203); },
             "exactly one channel"},
        Case{"adc_too_fast", [](LpcProbe& p) { p.clock(13).write(kSyscon + 0x238, 0xEDE0).write(kAdc, 0x01000001); },
             "4.5 MHz is the most"},
        Case{"adc_pin_digital", [](LpcProbe& p) { p.clock(13).write(kSyscon + 0x238, 0xEDE0).write(kAdc, 0x01000201).wait(kMillisecond); },
             "without its pin switched to it"},
        Case{"wrong_feed", [](LpcProbe& p) { p.clock(15).write(kWwdt + 8, 0x55); }, "wrong feed sequence"},
        Case{"feed_interrupted", [](LpcProbe& p) { (void)p.clock(15).write(kWwdt + 8, 0xAA).read(kWwdt + 0); },
             "between the two words of a feed"},
        Case{"i2c_without_pins", [](LpcProbe& p) { p.clock(5).write(kSyscon + 0x004, 2).write(kI2c, 0x60); }, "START without the pins"},
        Case{"uart_without_divider", [](LpcProbe& p) { p.clock(12).write(kUart + 0x0C, 0x83); }, "clock divider at 0"},
        Case{"uart_wrong_baud", [](LpcProbe& p) { p.clock(12).write(kSyscon + 0x098, 1).write(kUart + 0x0C, 3).write(kUart + 0x00, 'x'); },
             "baud, the line has 1000000"},
        Case{"ssp_empty", [](LpcProbe& p) { (void)p.write(kSyscon + 0x004, 1).read(kSsp0 + 8); }, "empty receive FIFO"},
        Case{"ssp_odd_prescaler", [](LpcProbe& p) { p.write(kSyscon + 0x004, 1).write(kSsp0 + 0x10, 3); }, "prescaler must be even"},
        Case{"gpio_nothing_there", [](LpcProbe& p) { p.write(kGpio2 + 0x8020, 0); }, "GPIO: write to register 8020"},
        Case{"output_against_output",
             [](LpcProbe& p) {
               p.chip().drive_pin({2, 5}, true);
               p.write(kGpio2 + 0x8000, 1U << 5);
             },
             "made an output against something that drives it"},
        Case{"debugger_locked_out", [](LpcProbe& p) { p.clock(16).write(kIocon + 0x68, 0xD1); }, "SWCLK switched away"},
        Case{"core_clock_off", [](LpcProbe& p) { p.write(kSyscon + 0x080, 0); }, "clock of core, ROM, RAM or flash switched off"},
        Case{"erase_with_interrupts",
             [](LpcProbe& p) {
               p.write(0xE000E100, 1U << 13);
               (void)p.iap({50, 7, 7});
               (void)p.iap({52, 7, 7, 12'000});
             },
             "with interrupts on"},
        Case{"iap_wrong_clock",
             [](LpcProbe& p) {
               (void)p.iap({50, 7, 7});
               (void)p.iap({52, 7, 7, 48'000});
             },
             "told a clock of 48000 kHz, it is 12000"},
        Case{"page_written_twice",
             [](LpcProbe& p) {
               for (int i = 0; i < 2; ++i) {
                 (void)p.iap({50, 7, 7});
                 (void)p.iap({51, 0x7000, CortexM0::kRamBase + 0x200, 256, 12'000});
               }
             },
             "page written twice"}),
    [](const testing::TestParamInfo<Case>& tested) { return std::string(tested.param.name); });

TEST(Allowed, TheManualsWaysPass) {
  LpcProbe probe;
  probe.start_crystal_and_pll();
  EXPECT_EQ(probe.chip().clock_hz(), 48'000'000U);
  probe.can_ready();
  probe.write(kCan, 0x41);
  probe.write(kCan + 0x180, 0);
  probe.write(kCan + 0x0C, 0x1C0B);
  probe.write(kCan, 0);
  EXPECT_EQ(probe.all(), "");
}

TEST(Allowed, FlashRoutinesKeepTheirOrder) {
  LpcProbe probe;
  EXPECT_EQ(probe.iap({52, 7, 7, 12'000}), 9U);  // not prepared
  EXPECT_EQ(probe.iap({50, 7, 7}), 0U);
  EXPECT_EQ(probe.iap({52, 7, 7, 12'000}), 0U);
  EXPECT_EQ(probe.iap({53, 7, 7}), 0U);
  EXPECT_EQ(probe.iap({51, 0x7000, CortexM0::kRamBase + 0x200, 256, 12'000}), 9U);  // each operation needs its own preparation
  EXPECT_EQ(probe.iap({50, 7, 7}), 0U);
  EXPECT_EQ(probe.iap({51, 0x7010, CortexM0::kRamBase + 0x200, 256, 12'000}), 3U);  // not the start of a page
  EXPECT_EQ(probe.iap({51, 0x7000, CortexM0::kRamBase + 0x200, 100, 12'000}), 6U);
  EXPECT_EQ(probe.iap({51, 0x7000, CortexM0::kRamBase + 0x200, 256, 12'000}), 0U);
  EXPECT_EQ(probe.iap({56, 0x7000, CortexM0::kRamBase + 0x200, 256}), 0U);
  EXPECT_EQ(probe.iap({53, 7, 7}), 8U);
  EXPECT_EQ(probe.iap({50, 7, 8}), 7U);
  EXPECT_EQ(probe.iap({99}), 1U);
  EXPECT_EQ(probe.all(), "");
}

TEST(Allowed, TheWatchdogResetsWhenItIsNotFedAndOnlyThen) {
  LpcProbe probe;
  probe.clock(15);
  probe.write(kSyscon + 0x0D0, 0);
  probe.write(kSyscon + 0x0D4, 0);
  probe.write(kSyscon + 0x0D4, 1);
  probe.write(kSyscon + 0x0D8, 1);
  probe.write(kWwdt + 4, 60'000);  // 20 ms at 12 MHz / 4
  probe.write(kWwdt + 0, 3);
  const auto feed = [&probe] {
    probe.write(kWwdt + 8, 0xAA);
    probe.write(kWwdt + 8, 0x55);
  };
  feed();
  for (int i = 0; i < 10; ++i) {
    probe.wait(15 * kMillisecond);
    feed();
  }
  EXPECT_EQ(probe.chip().resets(ResetCause::watchdog), 0U);
  probe.wait(21 * kMillisecond);
  EXPECT_EQ(probe.chip().resets(ResetCause::watchdog), 1U);
  EXPECT_EQ(probe.read(kSyscon + 0x030) & 4U, 4U);  // and says so
  EXPECT_EQ(probe.all(), "");
}

}  // namespace
}  // namespace hoist::machine
