// Staff rehearsals from end to end in virtual time: the closed loop, what happens as the simulator is told it, a scripted therapist who does it
// right and one who does not, and what is told of both.
#include "server/state/rehearsal.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "firmware/sim/requests.hpp"
#include "tests/support/closed_loop.hpp"

namespace hoist::tests {
namespace {

using contract::CommandKind;
using contract::Mode;
using server::Rehearsal;
using server::RehearsalCheck;
using server::RehearsalKind;
using server::RehearsalResult;
using server::Seen;

// The hoist with a patient who walks the eight, and the server's part of a rehearsal around it.
class Stage {
 public:
  Stage(RehearsalKind kind, std::uint64_t seed) : loop_(ClosedLoopOptions{}), rehearsal_(kind, seed) {}

  // Walks until it happens.
  [[nodiscard]] bool walk() {
    if (!loop_.start(Mode::user)) return false;
    for (int i = 0; i < 6000 && rehearsal_.phase() == Rehearsal::Phase::waiting; ++i) step();
    return rehearsal_.phase() == Rehearsal::Phase::happening;
  }
  void wait(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 100) && rehearsal_.phase() != Rehearsal::Phase::over; ++i) step();
  }
  bool wait_until(const std::function<bool()>& done, double at_most_s) {
    for (int i = 0; i < static_cast<int>(at_most_s * 100); ++i) {
      if (done()) return true;
      step();
    }
    return done();
  }
  // As a client of the server asks the core, with the row of the audit log that follows.
  std::string ask(const char* action, CommandKind kind, std::uint32_t a = 0, std::uint32_t client = 1, double v0 = 0) {
    const std::uint32_t request = loop_.ask_as(client, kind, a, v0, 0, 0, static_cast<std::uint32_t>(contract::Role::therapist));
    std::string result;
    wait_until(
        [&] {
          for (const contract::Event& event : loop_.events()) {
            if (event.request_id != request || event.client != client) continue;
            if (event.kind == contract::EventKind::command_done) result = "done";
            if (event.kind == contract::EventKind::command_refused)
              for (const contract::RefusalInfo& row : contract::kRefusals)
                if (row.bit == event.code) result = row.name;
          }
          return !result.empty();
        },
        2);
    rehearsal_.did(action, result);
    return result;
  }
  std::string stop() { return ask("stop", CommandKind::stop); }
  std::string acknowledge() { return ask("acknowledge", CommandKind::acknowledge); }
  std::string zero() { return ask("set_neutral", CommandKind::set_neutral, 0, 1, 1'790'000'000.0); }
  std::string start() {
    wait_until([&] { return loop_.record().blocked_bits == 0; }, 20);
    return ask("start_motion", CommandKind::request_mode, static_cast<std::uint32_t>(Mode::user));
  }
  std::string end_motion() { return ask("end_motion", CommandKind::request_mode, static_cast<std::uint32_t>(Mode::standby)); }

  // To its end; its result, which is the same when it is read back from the marker.
  RehearsalResult finish() {
    wait(Rehearsal::kLongest_s + 1);
    EXPECT_EQ(rehearsal_.phase(), Rehearsal::Phase::over);
    const RehearsalResult result = rehearsal_.result();
    const std::string text = server::rehearsal_text(result);
    EXPECT_LE(text.size(), 500U);
    EXPECT_EQ(server::read_rehearsal(text), result) << text;
    return result;
  }
  ClosedLoop& loop() { return loop_; }
  Rehearsal& rehearsal() { return rehearsal_; }

 private:
  void step() {
    loop_.step();
    const Rehearsal::Due due = rehearsal_.take(loop_.record());
    const server::RehearsalInfo& info = server::rehearsal_info(rehearsal_.kind());
    if (due.happens) tell(info.happens);
    if (due.ends) tell(info.ends);
    if (const bool held = loop_.record().lease_holder != 0; held != held_) rehearsal_.lease(held_ = held);
  }
  void tell(std::string_view request) {
    if (request.empty()) return;
    EXPECT_EQ(sim::answer_request(loop_.world(), {}, request), R"({"ok":true})") << request;
  }

  ClosedLoop loop_;
  Rehearsal rehearsal_;
  bool held_ = false;
};

Seen seen(const RehearsalResult& result, RehearsalCheck check) {
  for (const server::RehearsalItem& item : result.items)
    if (item.check == check) return item.seen;
  ADD_FAILURE() << server::rehearsal_check_name(check) << " is not looked at";
  return Seen::missing;
}
double after_s(const RehearsalResult& result, RehearsalCheck check) {
  for (const server::RehearsalItem& item : result.items)
    if (item.check == check && item.after_s) return *item.after_s;
  return -1;
}
void expect_all_good(const RehearsalResult& result) {
  EXPECT_FALSE(result.items.empty());
  for (const server::RehearsalItem& item : result.items)
    EXPECT_EQ(item.seen, Seen::good) << server::rehearsal_text(result) << ": " << server::rehearsal_check_name(item.check);
}

// Stop, look until patient and machine are safe, release, take the posture as upright, go on.
RehearsalResult in_order(RehearsalKind kind, double look_s) {
  Stage stage(kind, 7);
  EXPECT_TRUE(stage.walk());
  stage.wait(1.5);
  EXPECT_EQ(stage.stop(), "done");
  stage.wait(look_s);
  EXPECT_EQ(stage.acknowledge(), "done");
  stage.wait(2);
  EXPECT_EQ(stage.zero(), "done");
  stage.wait(2);
  EXPECT_EQ(stage.start(), "done");
  return stage.finish();
}

TEST(Rehearsals, InOrderAllIsGood) {
  expect_all_good(in_order(RehearsalKind::trip, 12));
  expect_all_good(in_order(RehearsalKind::freeze, 8));
  expect_all_good(in_order(RehearsalKind::bumper, 10));
}

// Waits for the hoist to stop by itself, releases again and again until it works, and drives off.
RehearsalResult in_haste(RehearsalKind kind) {
  Stage stage(kind, 7);
  EXPECT_TRUE(stage.walk());
  EXPECT_TRUE(stage.wait_until([&] { return stage.loop().mode() == Mode::protective_stop; }, 10));
  stage.wait(0.5);
  EXPECT_EQ(stage.acknowledge(), "moving");
  EXPECT_TRUE(stage.wait_until([&] { return stage.acknowledge() == "done"; }, 30));
  EXPECT_EQ(stage.start(), "done");
  return stage.finish();
}

TEST(Rehearsals, HasteIsTold) {
  for (const RehearsalKind kind : {RehearsalKind::trip, RehearsalKind::bumper}) {
    const RehearsalResult result = in_haste(kind);
    SCOPED_TRACE(server::rehearsal_text(result));
    EXPECT_EQ(seen(result, RehearsalCheck::stop), Seen::missing);
    EXPECT_EQ(seen(result, RehearsalCheck::look), Seen::wrong);
    EXPECT_EQ(seen(result, RehearsalCheck::cause_gone), Seen::wrong);
    EXPECT_EQ(seen(result, RehearsalCheck::acknowledge), Seen::good);
    EXPECT_EQ(seen(result, RehearsalCheck::zero), Seen::missing);
    EXPECT_EQ(seen(result, RehearsalCheck::go_on), Seen::good);
  }
}

TEST(Rehearsals, FrozenFeetThatNobodyStopsForAreTold) {
  Stage stage(RehearsalKind::freeze, 3);
  ASSERT_TRUE(stage.walk());
  EXPECT_TRUE(stage.wait_until([&] { return stage.loop().world().patient().frozen(); }, 1)) << "what the simulator was told happens";
  stage.wait(10);
  stage.stop();
  const RehearsalResult result = stage.finish();
  EXPECT_EQ(seen(result, RehearsalCheck::stop), Seen::wrong) << "later than its limit";
  EXPECT_NEAR(after_s(result, RehearsalCheck::stop), 10, 0.3);
  EXPECT_EQ(seen(result, RehearsalCheck::acknowledge), Seen::missing);
  EXPECT_EQ(seen(result, RehearsalCheck::go_on), Seen::missing);
}

TEST(Rehearsals, ALostLinkNeedsSomebodyInControlAgain) {
  for (const double away_s : {5.0, 50.0}) {
    Stage stage(RehearsalKind::link_loss, 5);
    ASSERT_TRUE(stage.walk());
    stage.loop().ask(CommandKind::release_lease, contract::kConsoleGone);
    EXPECT_TRUE(stage.wait_until([&] { return stage.loop().fault(contract::Fault::console_lost); }, 2));
    EXPECT_EQ(stage.loop().mode(), Mode::user) << "the patient walks on";
    stage.wait(away_s);
    EXPECT_EQ(stage.ask("take_lease", CommandKind::take_lease, 0, 2), "done");
    const RehearsalResult result = stage.finish();
    EXPECT_EQ(seen(result, RehearsalCheck::regain), away_s < 30 ? Seen::good : Seen::wrong);
    EXPECT_NEAR(after_s(result, RehearsalCheck::regain), away_s, 0.5);
  }
  Stage nobody(RehearsalKind::link_loss, 5);
  ASSERT_TRUE(nobody.walk());
  nobody.loop().ask(CommandKind::release_lease, contract::kConsoleGone);
  EXPECT_EQ(seen(nobody.finish(), RehearsalCheck::regain), Seen::missing);
}

TEST(Rehearsals, LowBatteriesEndTheWalk) {
  Stage right(RehearsalKind::low_battery, 11);
  ASSERT_TRUE(right.walk());
  EXPECT_TRUE(right.wait_until([&] { return right.loop().fault(contract::Fault::battery_low); }, 5));
  EXPECT_EQ(right.loop().mode(), Mode::user) << "low, not empty: nothing stops by itself";
  EXPECT_EQ(right.end_motion(), "done");
  expect_all_good(right.finish());
  EXPECT_TRUE(right.wait_until([&] { return !right.loop().fault(contract::Fault::battery_low); }, 5)) << "afterwards they are full again";

  Stage wrong(RehearsalKind::low_battery, 11);
  ASSERT_TRUE(wrong.walk());
  wrong.wait(5);
  EXPECT_EQ(wrong.end_motion(), "done");
  wrong.wait(4);
  EXPECT_EQ(wrong.start(), "done");
  const RehearsalResult result = wrong.finish();
  EXPECT_EQ(seen(result, RehearsalCheck::end), Seen::good);
  EXPECT_EQ(seen(result, RehearsalCheck::stay_ended), Seen::wrong);
}

TEST(Rehearsals, ASecondTherapistGetsAnAnswerAndTheHoistStanding) {
  Stage keeps(RehearsalKind::second_therapist, 2);
  ASSERT_TRUE(keeps.walk());
  keeps.wait(4);
  keeps.rehearsal().did("keep_lease", "done");  // the core is not asked
  expect_all_good(keeps.finish());

  // Says yes while the patient walks, which the core refuses, then stands first.
  Stage gives(RehearsalKind::second_therapist, 2);
  ASSERT_TRUE(gives.walk());
  gives.wait(2);
  EXPECT_EQ(gives.ask("hand_over", CommandKind::take_lease, contract::kHandOver, 9), "moving");
  EXPECT_EQ(gives.end_motion(), "done");
  gives.wait(4);
  EXPECT_EQ(gives.ask("hand_over", CommandKind::take_lease, contract::kHandOver, 9), "done");
  const RehearsalResult result = gives.finish();
  EXPECT_EQ(seen(result, RehearsalCheck::answer), Seen::good);
  EXPECT_EQ(seen(result, RehearsalCheck::standing), Seen::wrong);

  Stage silent(RehearsalKind::second_therapist, 2);
  ASSERT_TRUE(silent.walk());
  EXPECT_EQ(seen(silent.finish(), RehearsalCheck::answer), Seen::missing);
}

TEST(Rehearsals, TheMomentIsDrawnBySeedAndTextThatIsNoResultIsNone) {
  const auto moment_s = [](std::uint64_t seed) { return Rehearsal(RehearsalKind::trip, seed).result().after_s; };
  EXPECT_EQ(moment_s(1), moment_s(1));
  double least_s = 100, most_s = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    least_s = std::min(least_s, moment_s(seed));
    most_s = std::max(most_s, moment_s(seed));
  }
  EXPECT_GE(least_s, Rehearsal::kEarliest_s);
  EXPECT_LE(most_s, Rehearsal::kLatest_s);
  EXPECT_GT(most_s - least_s, 14);
  const std::string text = server::rehearsal_text(Rehearsal(RehearsalKind::bumper, 4).result());
  ASSERT_TRUE(server::read_rehearsal(text));
  for (std::size_t cut = 0; cut < text.size(); ++cut) EXPECT_FALSE(server::read_rehearsal(text.substr(0, cut))) << cut;
  for (const std::string& other :
       {text + " ", text + "; more", std::string("note"), std::string("Rehearsal, simulated hoist: dance, seed 1, after 9.0 s")})
    EXPECT_FALSE(server::read_rehearsal(other)) << other;
}

}  // namespace
}  // namespace hoist::tests
