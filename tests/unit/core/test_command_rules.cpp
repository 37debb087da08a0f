// Who may drive, which driving commands act, and whether the server lives: the rules of control/core/command, written a second time from
// their descriptions (control/DECISIONS.md, 2, 3, 5 and 57; hazards H17 to H21). Each step must be judged alike.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <utility>

#include "control/core/command/remote_drive.hpp"
#include "control/core/command/server_watch.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

// H21: lost after 250 ms without a beat; each server begins without a driver, also one whose count begins where the last one's ended.
class ServerRule {
 public:
  ServerWatch::News news(std::uint64_t beats, std::uint64_t life) {
    const std::optional<std::uint64_t> last = std::exchange(beats_, beats);
    const bool another = life_ && *life_ != life;
    if (!last || *last != beats) life_ = life;
    if (!last || *last == beats) {
      if (last && lives && ++still_steps_ * 10 == 250) {
        lives = false;
        return ServerWatch::News::lost;
      }
      return ServerWatch::News::none;
    }
    const bool new_server = another || (lives && beats < *last);
    still_steps_ = 0;
    lives = ever = true;
    return new_server ? ServerWatch::News::restarted : ServerWatch::News::none;
  }
  bool lives = false, ever = false;

 private:
  std::optional<std::uint64_t> beats_;
  std::optional<std::uint64_t> life_;  // of the server that beat last
  int still_steps_ = 0;
};

TEST(CommandRules, H21TheServerLivesWhileItsCounterMovesAtLeastEach250Ms) {
  std::array<int, 3> told{};
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    ServerWatch watch;
    ServerRule rule;
    std::uint64_t beats = seed % 3 * 1000, life = seed % 2;
    for (int pause = 0; pause < 60; ++pause) {
      constexpr std::array kStill{0, 0, 1, 5, 20, 23, 24, 25, 26, 27, 60};  // steps without a beat, after the step with one
      const int still = kStill[random() % kStill.size()];
      for (int i = 0; i <= still; ++i) {
        const ServerWatch::News news = watch.update(beats, life);
        ASSERT_EQ(news, rule.news(beats, life)) << "pause " << pause << ", step " << i << " of " << still;
        ASSERT_EQ(watch.alive(), rule.lives);
        ASSERT_EQ(watch.seen(), rule.ever);
        ++told[static_cast<std::size_t>(news)];
      }
      if (random() % 8 == 0) life = 1 + random() % 3;
      if (random() % 10 == 0) continue;  // no beat for another while, perhaps of another server
      const std::uint64_t less = 1 + random() % 5;
      beats = random() % 6 == 0 && beats > less ? beats - less : beats + 1 + random() % 2;
    }
  }
  EXPECT_GT(told[static_cast<std::size_t>(ServerWatch::News::lost)], 300);
  EXPECT_GT(told[static_cast<std::size_t>(ServerWatch::News::restarted)], 300);
}

// The hand of the driver as the core knows it.
class HandRule {
 public:
  bool take(const contract::DriveCommand& command, const Lease& lease, std::uint64_t now_ns, double most_s) {
    if (command.client == 0 || command.client != lease.holder || command.lease_epoch != lease.epoch) return false;
    if (command.sequence <= newest_) return false;
    const bool future = command.echo_time_ns > now_ns;
    const bool fresh = !future && static_cast<double>(now_ns - command.echo_time_ns) / 1e9 <= most_s;
    const auto share = [](double value) { return !std::isnan(value) && value >= -1 && value <= 1; };
    const bool release = command.held != 1;
    if (!release && !(fresh && share(command.speed_norm) && share(command.yaw_norm))) return false;
    newest_ = command.sequence;
    seen_ns_ = std::max(seen_ns_.value_or(0), future ? now_ns : command.echo_time_ns);
    stick = release ? Stick{} : Stick{true, command.speed_norm, command.yaw_norm};
    if (fresh && !stick.pushed()) waits = false;
    return true;
  }
  void begin(std::uint64_t now_ns, double stop_s) {
    if (stick.pushed()) waits = true;
    if (age_s(now_ns) > stop_s) stick = {};
  }
  void lose() {
    stick = {};
    waits = true;
  }
  [[nodiscard]] double age_s(std::uint64_t now_ns) const {
    return seen_ns_ ? std::min(static_cast<double>(now_ns - *seen_ns_) / 1e9, 9.999) : 9.999;
  }

  struct Stick {
    bool held = false;
    double speed = 0, yaw = 0;
    [[nodiscard]] bool pushed() const { return held && std::max(std::fabs(speed), std::fabs(yaw)) > 0.02; }
  };
  Stick stick;
  bool waits = false;  // for a neutral stick

 private:
  std::uint64_t newest_ = 0;
  std::optional<std::uint64_t> seen_ns_;
};

TEST(CommandRules, H17EachDrivingCommandIsJudgedByTheRule) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kEndless = std::numeric_limits<double>::infinity();
  constexpr std::uint64_t kMs_ns = 1'000'000, kNever = ~std::uint64_t{0};
  constexpr std::array kShares{0.0,   0.0,  0.015, -0.015, 0.019, -0.019, 0.021, -0.021,   0.03,
                               -0.03, 0.05, 0.5,   -0.7,   1.0,   -1.0,   kNan,  1.000001, -kEndless};
  int taken = 0, refused = 0, waited = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto one_of = [&random](const auto& all) { return all[random() % all.size()]; };
    RemoteDrive drive;
    HandRule rule;
    Lease lease{1, 7};
    // Less than the age limit, as just after the core's start: an echo that wraps round would look fresh.
    std::uint64_t now_ns = 20 * kMs_ns, sequence = 0;
    const double most_s = seed % 3 == 0 ? 0.1 : 0.25;
    for (int i = 0; i < 300; ++i) {
      now_ns += kMs_ns * one_of(std::array{0U, 10U, 10U, 10U, 10U, 10U, 40U, 90U, 149U, 160U, 247U, 260U, 5100U, 10'100U, 25'000U});
      switch (random() % 40) {
        case 0:  // another driver, or none
          lease = {lease.epoch + 1, one_of(std::array{0U, 7U, 8U})};
          drive.reset();
          rule = {};
          sequence = 0;
          break;
        case 1:
        case 2:
        case 3:
          drive.begin(now_ns, most_s);
          rule.begin(now_ns, most_s);
          break;
        case 4:
          drive.lose();
          rule.lose();
          break;
        default:
          break;
      }
      const bool usual = random() % 8 != 0;  // only values, age and release vary
      contract::DriveCommand command{lease.epoch, lease.holder, sequence + 1, now_ns, one_of(kShares), one_of(kShares), 1};
      if (usual && !(std::fabs(command.yaw_norm) <= 1)) command.yaw_norm = 0;
      switch (random() % (usual ? 3 : 6)) {
        case 0:
          command.held = one_of(std::array<std::uint64_t, 7>{0, 1, 1, 1, 1, 2, kNever});
          break;
        case 1: {
          const std::uint64_t ago_ns = kMs_ns * one_of(std::array{1U, 40U, 99U, 101U, 150U, 249U, 251U, 300U, 20'000U});
          command.echo_time_ns = ago_ns < now_ns ? now_ns - ago_ns : 0;
          break;
        }
        case 2:
          break;
        case 3:
          command.echo_time_ns = one_of(std::array{now_ns + 1, now_ns + 50 * kMs_ns, kNever, kNever - kMs_ns});
          command.held = random() % 2;
          break;
        case 4:
          command.client = one_of(std::array{0U, 7U, 8U});
          command.lease_epoch = lease.epoch - random() % 2;
          break;
        default:
          command.sequence = one_of(std::array{sequence, sequence / 2, sequence + 5, std::uint64_t{0}});
          break;
      }
      const bool took = drive.take(command, lease, now_ns, most_s);
      ASSERT_EQ(took, rule.take(command, lease, now_ns, most_s)) << i;
      if (took) sequence = command.sequence;
      ASSERT_EQ(drive.held(), rule.stick.held) << i;
      ASSERT_EQ(drive.neutral(), !rule.stick.pushed()) << i;
      ASSERT_EQ(drive.speed_norm(), rule.stick.speed) << i;
      ASSERT_EQ(drive.yaw_norm(), rule.stick.yaw) << i;
      ASSERT_EQ(drive.awaits_neutral(), rule.waits) << i;
      for (const std::uint64_t later_ns : {0U, 10U, 3000U, 7000U, 30'000U})
        ASSERT_NEAR(drive.age_s(now_ns + later_ns * kMs_ns), rule.age_s(now_ns + later_ns * kMs_ns), 1e-9) << i;
      ++(took ? taken : refused);
      waited += rule.waits ? 1 : 0;
    }
  }
  EXPECT_GT(taken, 20'000);
  EXPECT_GT(refused, 10'000);
  EXPECT_GT(waited, 2000);
}

// The answer ends the wait, whether the drive has left its fault or the time is up.
TEST(CommandRules, APressThatWaitedForADriveIsAnsweredOnce) {
  for (const bool leaves_its_fault : {true, false}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::user));
    hoist.drive_left.fault = true;
    hoist.drive_left.ignores_reset = !leaves_its_fault;
    ASSERT_TRUE(hoist.reach(Mode::protective_stop, 5));
    hoist.step(150);
    const std::uint32_t id = hoist.send(CommandKind::acknowledge);
    hoist.step(2);
    ASSERT_TRUE(hoist.state.acknowledgement.waits());
    hoist.step(100);
    EXPECT_FALSE(hoist.state.acknowledgement.waits());
    const auto answers = std::count_if(hoist.events.begin(), hoist.events.end(), [id](const contract::Event& event) {
      return event.request_id == id && (event.kind == EventKind::command_done || event.kind == EventKind::command_refused);
    });
    EXPECT_EQ(answers, 1);
    EXPECT_EQ(hoist.answer(id) == 0, leaves_its_fault);
  }
}

}  // namespace
}  // namespace hoist::core::test
