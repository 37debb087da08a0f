// The inertial chips behind a model of their registers, written from their data sheets: what they answer, how long they take, what the
// self-test does, and how they break.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <random>

#include "firmware/lib/imu/icm42688p.hpp"
#include "firmware/lib/imu/lsm6dso.hpp"
#include "firmware/lib/imu/mpu6050.hpp"
#include "firmware/lib/watchdog_gate.hpp"

namespace hoist::firmware {
namespace {

enum class Part { mpu6050, lsm6dso, icm42688p };

// One chip. True values in g and deg/s in its own axes.
struct FakeChip {
  Part part;
  explicit FakeChip(Part which) : part(which) { reset(); }

  std::array<std::array<std::uint8_t, 128>, 3> regs{};
  std::array<double, 3> acceleration_g{0.1, -0.2, 0.97}, rate_deg_s{1.5, -2.5, 3.5};
  bool silent = false, frozen = false, moving = false;
  double self_test_strength = 1.0;  // 1: as the factory measured it
  int self_tests_spoiled = 0;       // so many self-tests see a moving strut
  int transfers = 0, ready_after_ms = 0, writes_to_wrong_bank = 0;
  std::mt19937 random{7};
  std::array<std::uint8_t, 6> codes{12, 13, 14, 15, 16, 17};  // acceleration, rate

  std::uint8_t& reg(std::uint8_t at) { return regs[0][at]; }
  void reset() {
    regs = {};
    switch (part) {
      case Part::mpu6050:
        reg(0x75) = 0x68;
        reg(0x6B) = 0x40;  // asleep
        reg(0x0D) = static_cast<std::uint8_t>(((codes[0] >> 2) << 5) | codes[3]);
        reg(0x0E) = static_cast<std::uint8_t>(((codes[1] >> 2) << 5) | codes[4]);
        reg(0x0F) = static_cast<std::uint8_t>(((codes[2] >> 2) << 5) | codes[5]);
        reg(0x10) = static_cast<std::uint8_t>(((codes[0] & 3) << 4) | ((codes[1] & 3) << 2) | (codes[2] & 3));
        break;
      case Part::lsm6dso:
        reg(0x0F) = 0x6C;
        reg(0x12) = 0x04;
        break;
      case Part::icm42688p:
        reg(0x75) = 0x47;
        reg(0x4F) = reg(0x50) = 0x06;
        reg(0x52) = 0x11;
        for (std::size_t i = 0; i < 3; ++i) {
          regs[2][0x3B + i] = codes[i];
          regs[1][0x5F + i] = codes[3 + i];
        }
        break;
    }
  }
  bool awake() { return part == Part::mpu6050 ? (reg(0x6B) & 0x40) == 0 : part == Part::lsm6dso ? true : reg(0x4E) == 0x0F; }
  std::size_t bank() { return part == Part::icm42688p ? reg(0x76) % 3U : 0U; }

  bool write(std::uint8_t at, std::uint8_t value) {
    ++transfers;
    if (silent) return false;
    const bool resets = (part == Part::mpu6050 && at == 0x6B && (value & 0x80) != 0) ||
                        (part == Part::lsm6dso && at == 0x12 && (value & 1) != 0) ||
                        (part == Part::icm42688p && at == 0x11 && (value & 1) != 0);
    if (resets) {
      reset();
      return true;
    }
    if (at == 0x76) {
      reg(0x76) = value;
      return true;
    }
    if (bank() != 0) ++writes_to_wrong_bank;
    if (spoils(at, value) && self_tests_spoiled > 0) --self_tests_spoiled, moving = true;
    if (!stimulates(at, value)) moving = false;
    regs[bank()][at] = value;
    return true;
  }
  bool stimulates(std::uint8_t at, std::uint8_t value) const {
    return (part == Part::mpu6050 && (at == 0x1B || at == 0x1C) && (value & 0xE0) != 0) ||
           (part == Part::lsm6dso && at == 0x14 && value != 0) || (part == Part::icm42688p && at == 0x70 && value != 0);
  }
  bool spoils(std::uint8_t at, std::uint8_t value) const { return stimulates(at, value) && at != 0x1C; }
  bool read(std::uint8_t at, std::span<std::uint8_t> out) {
    ++transfers;
    if (silent) return false;
    if (bank() == 0 && out.size() > 4) {
      sample(at, out);
      return true;
    }
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = regs[bank()].at(at + i);
    return true;
  }

  // Range in steps per g and per deg/s, from the registers.
  double steps_per_g() {
    if (part == Part::mpu6050) return 16384.0 / (1 << ((reg(0x1C) >> 3) & 3));
    if (part == Part::lsm6dso) return ((reg(0x10) >> 2) & 3) == 2 ? 1 / 0.000122 : 1 / 0.000061;  // 2 means +-4 g in this chip
    return 2048.0 * (1 << (reg(0x50) >> 5));
  }
  double steps_per_deg_s() {
    if (part == Part::mpu6050) return 131.0 / (1 << ((reg(0x1B) >> 3) & 3));
    if (part == Part::lsm6dso) return ((reg(0x11) >> 2) & 3) == 3 ? 1 / 0.070 : 1 / 0.00875;
    return 16.4 * (1 << (reg(0x4F) >> 5)) * (131.0 / 131.2);
  }
  // What the self-test adds, in steps of the ranges it is made for.
  double stimulus(std::size_t axis) {
    const bool rate = axis >= 3;
    switch (part) {
      case Part::mpu6050:
        if ((reg(rate ? 0x1B : 0x1C) & 0xE0) != 0xE0) return 0;
        if (!rate) return self_test_strength * 4096 * 0.34 * std::pow(0.92 / 0.34, (codes[axis] - 1) / 30.0);
        return self_test_strength * (axis == 4 ? -1 : 1) * 25 * 131 * std::pow(1.046, codes[axis] - 1);
      case Part::lsm6dso:
        if (!rate) return (reg(0x14) & 3) == 1 ? self_test_strength * 400 / 0.122 : 0;
        return (reg(0x14) & 0x0C) == 4 ? self_test_strength * -400 / 0.070 : 0;
      default:
        if ((reg(0x70) & (rate ? 0x07 : 0x78)) != (rate ? 0x07 : 0x78)) return 0;
        return self_test_strength * 2620 * std::pow(1.01, codes[axis] - 1);
    }
  }
  void sample(std::uint8_t at, std::span<std::uint8_t> out) {
    std::array<std::int16_t, 6> raw{};
    std::normal_distribution<double> noise(0, 3);
    for (std::size_t i = 0; i < 6; ++i) {
      const double truth = i < 3 ? acceleration_g[i] * steps_per_g() : rate_deg_s[i - 3] * steps_per_deg_s();
      const double moved = moving ? (i < 3 ? 0.5 * steps_per_g() : 150 * steps_per_deg_s()) : 0;
      raw[i] =
          static_cast<std::int16_t>(std::lround(std::clamp(truth + stimulus(i) + moved + (frozen ? 0 : noise(random)), -32768.0, 32767.0)));
    }
    const bool fresh = awake();
    std::fill(out.begin(), out.end(), std::uint8_t{0});
    const auto big = [&](std::size_t to, std::size_t i) {
      out[to] = static_cast<std::uint8_t>(static_cast<std::uint16_t>(raw[i]) >> 8);
      out[to + 1] = static_cast<std::uint8_t>(raw[i]);
    };
    const auto little = [&](std::size_t to, std::size_t i) {
      out[to] = static_cast<std::uint8_t>(raw[i]);
      out[to + 1] = static_cast<std::uint8_t>(static_cast<std::uint16_t>(raw[i]) >> 8);
    };
    switch (part) {
      case Part::mpu6050:
        ASSERT_EQ(at, 0x3A);
        ASSERT_EQ(out.size(), 15U);
        out[0] = fresh ? 1 : 0;
        for (std::size_t i = 0; i < 3; ++i) big(1 + 2 * i, i), big(9 + 2 * i, 3 + i);
        break;
      case Part::lsm6dso:
        ASSERT_EQ(at, 0x1E);
        ASSERT_EQ(out.size(), 16U);
        out[0] = static_cast<std::uint8_t>(((reg(0x10) >> 4) != 0 ? 1 : 0) | ((reg(0x11) >> 4) != 0 ? 2 : 0));
        for (std::size_t i = 0; i < 3; ++i) little(10 + 2 * i, i), little(4 + 2 * i, 3 + i);
        break;
      case Part::icm42688p:
        ASSERT_EQ(at, 0x1D);
        ASSERT_EQ(out.size(), 17U);
        out[16] = fresh ? 8 : 0;
        for (std::size_t i = 0; i < 3; ++i) big(2 + 2 * i, i), big(8 + 2 * i, 3 + i);
        break;
    }
  }
};

// The three drivers behind one face, so that each test runs on each of them.
struct Driver {
  std::function<void()> step, restart;
  std::function<bool(ImuSample&)> read;
  std::function<ImuReport()> report;
  std::function<bool()> running;
};
template <class Chip>
Driver drive(Chip& chip) {
  return {[&chip] { chip.step_1ms(); }, [&chip] { chip.restart(); }, [&chip](ImuSample& s) { return chip.read(s); },
          [&chip] { return chip.report(); }, [&chip] { return chip.running(); }};
}

class ImuTest : public ::testing::TestWithParam<Part> {
 protected:
  ImuTest() : chip_(GetParam()), mpu_(chip_), lsm_(chip_), icm_(chip_) {
    driver_ = GetParam() == Part::mpu6050 ? drive(mpu_) : GetParam() == Part::lsm6dso ? drive(lsm_) : drive(icm_);
  }
  // Milliseconds until it runs; -1 after the limit.
  int start(int limit_ms = 3000) {
    for (int i = 0; i < limit_ms; ++i) {
      driver_.step();
      if (driver_.running()) return i;
    }
    return -1;
  }
  int readings(int cycles) {
    int given = 0;
    for (int i = 0; i < cycles; ++i) {
      for (int k = 0; k < 10; ++k) driver_.step();
      ImuSample sample;
      given += driver_.read(sample) ? 1 : 0;
    }
    return given;
  }
  FakeChip chip_;
  Mpu6050<FakeChip> mpu_;
  Lsm6dso<FakeChip> lsm_;
  Icm42688p<FakeChip> icm_;
  Driver driver_;
};

TEST_P(ImuTest, StartsPassesItsSelfTestAndReads) {
  const int took_ms = start();
  ASSERT_GT(took_ms, 200);
  ASSERT_LT(took_ms, 1200);
  EXPECT_TRUE(driver_.report().found);
  EXPECT_FALSE(driver_.report().wrong_part || driver_.report().self_test_failed);
  EXPECT_EQ(chip_.writes_to_wrong_bank, 0);
  EXPECT_FALSE(chip_.reg(0x70) != 0 && GetParam() == Part::icm42688p);  // the stimulus is off again
  ImuSample s;
  ASSERT_TRUE(driver_.read(s));
  EXPECT_NEAR(s.ax_m_s2, 0.1 * 9.80665, 0.02);
  EXPECT_NEAR(s.ay_m_s2, -0.2 * 9.80665, 0.02);
  EXPECT_NEAR(s.az_m_s2, 0.97 * 9.80665, 0.02);
  EXPECT_NEAR(s.beta_rate_rad_s, 1.5 * 0.0174533, 0.003);    // about x: leans right
  EXPECT_NEAR(s.alpha_rate_rad_s, -2.5 * 0.0174533, 0.003);  // about y: leans forward
  EXPECT_NEAR(s.yaw_rate_rad_s, 3.5 * 0.0174533, 0.003);
  EXPECT_EQ(readings(500), 500);
}

TEST_P(ImuTest, NothingIsReadBeforeTheSelfTestHasPassed) {
  ImuSample s;
  for (int i = 0; i < 200; ++i) {
    ASSERT_FALSE(driver_.read(s)) << i;
    driver_.step();
  }
}

TEST_P(ImuTest, AForeignPartIsNamedAndNeverUsed) {
  chip_.codes[0] = 12;
  const std::uint8_t at = GetParam() == Part::lsm6dso ? 0x0F : 0x75;
  bool wrong = false;
  for (int i = 0; i < 4000; ++i) {
    chip_.reg(at) = 0x6A;  // an LSM6DS3's, or none
    driver_.step();
    ASSERT_FALSE(driver_.running());
    wrong = wrong || driver_.report().wrong_part;
  }
  EXPECT_TRUE(wrong);
  EXPECT_FALSE(driver_.report().found);
  EXPECT_EQ(driver_.report().who_am_i, 0x6A);
}

TEST_P(ImuTest, ABusWithoutAnswerIsNotFoundAndIsAskedAgain) {
  chip_.silent = true;
  EXPECT_EQ(start(3000), -1);
  EXPECT_FALSE(driver_.report().found || driver_.report().wrong_part || driver_.report().self_test_failed);
  EXPECT_LT(chip_.transfers, 10);  // once a second, not in every millisecond
  chip_.silent = false;
  EXPECT_GT(start(3000), 0);
  EXPECT_TRUE(driver_.report().found);
}

TEST_P(ImuTest, H6_ADeadElementFailsTheSelfTestForGood) {
  for (const double strength : {0.0, 0.1, 5.0}) {
    SCOPED_TRACE(strength);
    chip_.reset();
    chip_.self_test_strength = strength;
    driver_.restart();
    EXPECT_EQ(start(8000), -1);
    EXPECT_TRUE(driver_.report().found && driver_.report().self_test_failed);
    chip_.self_test_strength = 1.0;
    EXPECT_EQ(start(3000), -1);
    EXPECT_EQ(readings(100), 0);
    driver_.restart();  // switched off and on
    EXPECT_GT(start(), 0);
  }
}

TEST_P(ImuTest, SomebodyMovingTheStrutDuringTheSelfTestIsNoBrokenChip) {
  chip_.self_tests_spoiled = 2;
  EXPECT_GT(start(5000), 0);
  EXPECT_FALSE(driver_.report().self_test_failed);
}

TEST_P(ImuTest, H6_FrozenWordsStopTheReadings) {
  ASSERT_GT(start(), 0);
  EXPECT_EQ(readings(50), 50);
  chip_.frozen = true;
  EXPECT_LE(readings(200), 21);  // 200 ms at 100 Hz
  chip_.frozen = false;
  EXPECT_EQ(readings(50), 50);
}

TEST_P(ImuTest, AChipThatLosesItsSettingsIsNotTrustedAnyMore) {
  ASSERT_GT(start(), 0);
  chip_.reset();  // its supply sagged
  readings(100);
  EXPECT_FALSE(driver_.running());
  EXPECT_TRUE(driver_.report().self_test_failed);
  EXPECT_EQ(readings(100), 0);
}

// For every start of the samples within the 100 ms between two checks.
TEST_P(ImuTest, ChecksOfRegistersKeepAwayFromSamples) {
  ASSERT_GT(start(), 0);
  for (int phase_ms = 0; phase_ms < 10; ++phase_ms) {
    ASSERT_TRUE(driver_.running());
    driver_.step();
    ImuSample sample;
    EXPECT_TRUE(driver_.read(sample));
    int checks = 0;
    for (int ms = 1; ms <= 2000; ++ms) {
      const int before = chip_.transfers;
      driver_.step();
      if (chip_.transfers != before) {
        ++checks;
        EXPECT_EQ(ms % 10, 5) << phase_ms;
      }
      if (ms % 10 == 0) {
        EXPECT_TRUE(driver_.read(sample));
      }
    }
    EXPECT_NEAR(checks, 20, 1);
    driver_.step();  // the next round's samples begin a millisecond later
  }
}

TEST_P(ImuTest, ALostBusBeginsAnewWithTheSelfTest) {
  ASSERT_GT(start(), 0);
  chip_.silent = true;
  EXPECT_EQ(readings(20), 0);
  EXPECT_FALSE(driver_.report().found);
  chip_.silent = false;
  chip_.reset();
  EXPECT_GT(start(4000), 500);
  EXPECT_EQ(readings(20), 20);
}

TEST_P(ImuTest, RandomAnswersNeverGiveANumberThatIsNone) {
  ASSERT_GT(start(), 0);
  std::mt19937 random(3);
  for (int i = 0; i < 20000; ++i) {
    chip_.acceleration_g = {std::ldexp(static_cast<double>(random()), -28) - 8, 0, 1};
    chip_.rate_deg_s = {0, std::ldexp(static_cast<double>(random()), -21) - 1000, 0};
    chip_.silent = random() % 8 == 0;
    ImuSample s;
    if (driver_.read(s)) {
      ASSERT_LE(std::fabs(s.ax_m_s2), 2.001 * 9.80665);
      ASSERT_LE(std::fabs(s.alpha_rate_rad_s), 287 * 0.0174533);  // 32768 steps of 8.75 mdeg/s
    }
    driver_.step();
  }
}

std::string part_name(const ::testing::TestParamInfo<Part>& part) {
  return part.param == Part::mpu6050 ? "Mpu6050" : part.param == Part::lsm6dso ? "Lsm6dso" : "Icm42688p";
}
INSTANTIATE_TEST_SUITE_P(Chips, ImuTest, ::testing::Values(Part::mpu6050, Part::lsm6dso, Part::icm42688p), part_name);

TEST(ImuSelfTest, FactoryPowersAreThoseOfTheDataSheets) {
  for (int code = 1; code < 32; ++code) {
    EXPECT_NEAR(1392.64 * self_test_power(1.0337376F, static_cast<std::uint8_t>(code)),
                4096 * 0.34 * std::pow(0.92 / 0.34, (code - 1) / 30.0), 0.2);
    EXPECT_NEAR(self_test_power(1.046F, static_cast<std::uint8_t>(code)), std::pow(1.046, code - 1), 1e-4);
  }
  EXPECT_EQ(self_test_power(1.046F, 0), 0.0F);
}

TEST(ImuSelfTest, AnMpu6050WithoutFactoryCodesIsNotTrusted) {
  SelfTestCodes codes{};
  SelfTestResult result;
  result.shift = {1500, 1500, 1500, 3500, -3500, 3500};
  EXPECT_FALSE(Mpu6050Chip::passed(0, codes, result));
}

TEST(WatchdogGate, FeedsOnlyWhenAllThreeHaveMoved) {
  WatchdogGate gate;
  EXPECT_FALSE(gate.should_feed(0, 0, 0));
  EXPECT_TRUE(gate.should_feed(1, 1, 1));
  EXPECT_FALSE(gate.should_feed(1, 1, 1));
  EXPECT_FALSE(gate.should_feed(100, 50, 1));  // the CAN service hangs
  EXPECT_FALSE(gate.should_feed(100, 1, 9));   // the tick hangs
  EXPECT_FALSE(gate.should_feed(1, 50, 9));    // the loop hangs
  EXPECT_TRUE(gate.should_feed(100, 50, 9));
  EXPECT_TRUE(gate.should_feed(0, 0, 0));  // wrapped
}

TEST(WatchdogGate, OneOfThreeHangingIsNeverFedWhateverTheOthersDo) {
  std::mt19937 random(11);
  for (int hung = 0; hung < 3; ++hung) {
    WatchdogGate gate;
    std::array<std::uint32_t, 3> counts{5, 5, 5};
    ASSERT_TRUE(gate.should_feed(counts[0], counts[1], counts[2]));
    for (int i = 0; i < 10000; ++i) {
      for (int k = 0; k < 3; ++k)
        if (k != hung) counts[static_cast<std::size_t>(k)] += random() % 3U;
      ASSERT_FALSE(gate.should_feed(counts[0], counts[1], counts[2]));
    }
  }
}

}  // namespace
}  // namespace hoist::firmware
