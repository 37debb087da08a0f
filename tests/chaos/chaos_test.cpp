// A few sessions in every test run; `deploy/dev check` runs two thousand, `deploy/dev chaos` any number. Then the proof
// of their worth: the same seed is the same session, and each invariant is violated when the product is broken on
// purpose.
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <iostream>
#include <limits>
#include <optional>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/faults.hpp"
#include "control/core/serve/param_keeper.hpp"
#include "firmware/sim/patient_family.hpp"
#include "tests/chaos/session.hpp"
#include "tests/chaos/shrink.hpp"
#include "tests/support/seeds.hpp"

namespace hoist::chaos {
namespace {

using contract::Mode;

const auto kSessions = static_cast<std::uint64_t>(tests::seeds_for(40, 16, 6)),
           kUnmoved = static_cast<std::uint64_t>(tests::seeds_for(10, 5, 4));

std::string list(const SessionReport& report) {
  std::string text = "hoist-chaos --sessions 1 --story --seed " + std::to_string(report.seed) + " shows it:\n";
  for (const std::string& line : report.broken) text += line + "\n";
  return text;
}

TEST(Chaos, WhateverBreaksWhatMustHoldHolds) {
  int stops = 0;
  double walked_s = 0;
  for (std::uint64_t seed = 1; seed <= kSessions; ++seed) {
    const SessionReport report = run_session({.seed = seed});
    EXPECT_TRUE(report.broken.empty()) << list(report);
    stops += report.stops;
    walked_s += report.walked_s;
  }
  // The sessions prove nothing without walking and without events.
  EXPECT_GT(walked_s, 25.0 * static_cast<double>(kSessions));
  EXPECT_GT(stops, static_cast<int>(kSessions) / 2);
}

TEST(Chaos, WithoutFaultsOnlyTheTherapistStopsTheHoist) {
  for (std::uint64_t seed = 1; seed <= kSessions / 2; ++seed) {
    SessionOptions options{.seed = seed, .faults_max = 0, .patient = std::string(kEvenPatient)};
    const SessionReport report = run_session(options);
    EXPECT_TRUE(report.broken.empty()) << list(report);
    EXPECT_EQ(report.false_stops, 0);
    EXPECT_EQ(report.unasked[static_cast<std::size_t>(Mode::user)], 0);
  }
}

// A body that leans far, freezes or does not step ends its walk; nothing else does.
TEST(Chaos, UnevenPatientsAreStoppedOnlyForWhatTheyDo) {
  std::uint64_t seed = 1;
  double walked_s = 0;
  for (const sim::FamilyMember& member : sim::kPatientFamily) {
    const SessionReport report =
        run_session({.seed = seed++, .length_s = 60, .faults_max = 0, .patient = std::string(member.name), .storage = false});
    EXPECT_EQ(report.patient, member.name);
    EXPECT_TRUE(report.broken.empty()) << member.name << "\n" << list(report);
    walked_s += report.walked_s;
  }
  EXPECT_GT(walked_s, 25.0 * static_cast<double>(sim::kPatientFamily.size()));
}

// H21, H24, H26 (I12).
TEST(Chaos, WhoLeadsDoesNotFeelServerNetworkDiskOrClock) {
  int faults = 0;
  for (std::uint64_t seed = 1; seed <= kUnmoved; ++seed) {
    const SessionReport report = run_unmoved({.seed = seed, .length_s = 45.0});
    EXPECT_TRUE(report.broken.empty()) << list(report);
    EXPECT_GT(report.walked_s, 20.0);
    faults += static_cast<int>(report.faults.size());
  }
  EXPECT_GT(faults, 0);
}

// Sessions that once broke something.
TEST(Chaos, WhatOnceBrokeHoldsNow) {
  std::ifstream file(HOIST_SOURCE_DIR "/tests/chaos/kept_seeds.txt");
  ASSERT_TRUE(file.is_open());
  // Under sanitizers, which look for other mistakes, each fourth.
  const int each = tests::seeds_for(1, 1, 4);
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#' || number++ % each != 0) continue;
    const std::optional<SessionOptions> options = read_replay(line);
    if (!options) {
      ADD_FAILURE() << "no session: " << line;
      continue;
    }
    const SessionReport report = options->only_walk ? run_unmoved(*options) : run_session(*options);
    EXPECT_TRUE(report.broken.empty()) << line << "\n" << list(report);
  }
}

TEST(Chaos, TheSameSeedIsTheSameSessionSecondBySecond) {
  const SessionReport once = run_session({.seed = 77, .length_s = 40}), again = run_session({.seed = 77, .length_s = 40});
  ASSERT_GE(once.hashes.size(), 40U);
  EXPECT_EQ(once.hashes, again.hashes);
  EXPECT_EQ(once.digest, again.digest);
  EXPECT_EQ(once.motion, again.motion);
  EXPECT_NE(once.digest, run_session({.seed = 78, .length_s = 40}).digest);
}

TEST(Chaos, AFaultLeftOutChangesNothingBeforeIt) {
  const Fault late{Kind::bumper, contract::Node::io, 30.0, 31.0, 0.1};
  const SessionReport with = run_session({.seed = 5, .length_s = 40, .faults = std::vector<Fault>{late}});
  const SessionReport without = run_session({.seed = 5, .length_s = 40, .faults = std::vector<Fault>{}});
  ASSERT_GE(with.hashes.size(), 40U);
  EXPECT_TRUE(std::equal(with.hashes.begin(), with.hashes.begin() + 29, without.hashes.begin()));
  EXPECT_NE(with.digest, without.digest);
}

TEST(ChaosFaults, APlanIsReadAsItWasWritten) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const std::vector<Fault> plan = plan_faults(seed, 5, 120.0, false);
    const auto read = read_faults(faults_text(plan));
    ASSERT_TRUE(read.has_value());
    ASSERT_EQ(read->size(), plan.size());
    EXPECT_EQ(faults_text(*read), faults_text(plan));
    for (std::size_t i = 0; i < plan.size(); ++i) {
      EXPECT_EQ((*read)[i].kind, plan[i].kind);
      EXPECT_EQ((*read)[i].start_s, plan[i].start_s);
      EXPECT_EQ((*read)[i].end_s, plan[i].end_s);
      EXPECT_EQ((*read)[i].size, plan[i].size);
    }
  }
  for (const char* wrong : {"nonsense", "unplug:io:1:2", "unplug:nobody:1:2:0.5", "bumper::x:2:0.5", "bumper::1:2:nan"})
    EXPECT_FALSE(read_faults(wrong).has_value()) << wrong;
}

TEST(ChaosFaults, EveryKindComesUp) {
  std::array<int, kKinds.size()> seen{};
  for (std::uint64_t seed = 1; seed <= 2000; ++seed)
    for (const Fault& fault : plan_faults(seed, 5, 120.0, false)) ++seen[static_cast<std::size_t>(fault.kind)];
  for (const KindInfo& kind : kKinds) {
    if (kind.kind == Kind::skid) continue;
    EXPECT_GT(seen[static_cast<std::size_t>(kind.kind)], 30) << kind.name;
  }
}

// ---- each invariant bites

// Whether a session of this broken product violates the invariant, and one of the intact product does not.
bool bites(const SessionOptions& broken_product, const std::string& promise) {
  SessionOptions whole = broken_product;
  whole.sabotage = {};
  whole.lying_disk = false;
  whole.spoof.reset();
  const SessionReport good = run_session(whole);
  EXPECT_TRUE(good.broken.empty()) << list(good);
  const SessionReport report = run_session(broken_product);
  for (const std::string& line : report.broken)
    if (line.find(promise + ":") != std::string::npos) return true;
  EXPECT_FALSE(report.broken.empty()) << "nothing is broken";
  std::cout << "only this is broken: " << list(report);
  return false;
}
SessionOptions quiet(Sabotage sabotage) {
  return {.seed = 3, .length_s = 40, .faults = std::vector<Fault>{}, .sabotage = std::move(sabotage)};
}
bool moving(const core::CoreState& core) { return contract::kModes[static_cast<std::size_t>(core.mode)].moving; }

// Replaces the commands of both drives, with their state.
void command_wheels(core::TickOutputs& out, double left_mrad_s, double right_mrad_s) {
  for (std::size_t i = 0; i < 2 && i < out.frames.size(); ++i)
    contract::write_slot(out.frames[i], contract::pdo_slot(contract::Pdo::drive_rx1, 0x60FF),
                         static_cast<std::int32_t>(i == 0 ? left_mrad_s : right_mrad_s));
}

void tell_change(core::TickOutputs& out, Mode from, Mode to) {
  contract::Event event;
  event.kind = contract::EventKind::mode_changed;
  event.code = static_cast<std::uint32_t>(to);
  event.item = static_cast<std::uint32_t>(from);
  (void)out.events.push_back(event);
}

TEST(ChaosBites, I1WheelsThatGoOnAfterAStop) {
  EXPECT_TRUE(bites(quiet([](double, core::CoreState& core, core::TickOutputs& out) {
                      if (core.mode != Mode::user && core.mode != Mode::remote && core.mode != Mode::protective_stop) return;
                      if (core.mode == Mode::protective_stop || core.in_mode.leaving) command_wheels(out, 90'000, 90'000);
                    }),
                    "I1"));
}
TEST(ChaosBites, I11AFaultThatIsNotTold) {
  SessionOptions options = quiet([](double, core::CoreState& core, core::TickOutputs& out) {
    core.latched &= ~contract::fault_bit(contract::Fault::io_lost);
    out.record.fault_bits &= ~contract::fault_bit(contract::Fault::io_lost);
  });
  options.faults = std::vector<Fault>{{Kind::unplug, contract::Node::io, 20.0, 22.0, 0.5}};
  EXPECT_TRUE(bites(options, "I11"));
}
TEST(ChaosBites, I2ASpeedBeyondTheLimit) {
  EXPECT_TRUE(bites(quiet([](double time_s, core::CoreState& core, core::TickOutputs& out) {
                      if (moving(core) && time_s > 20.0) out.record.speed_command_m_s = 0.7F;
                    }),
                    "I2"));
}
TEST(ChaosBites, I2AStartThatIsTooSudden) {
  EXPECT_TRUE(bites(quiet([](double, core::CoreState& core, core::TickOutputs& out) {
                      if (moving(core)) out.record.speed_command_m_s *= static_cast<float>(1 + out.record.tick % 2);
                    }),
                    "I2"));
}
TEST(ChaosBites, I3DrivingWithoutADriver) {
  EXPECT_TRUE(bites(quiet([](double time_s, core::CoreState& core, core::TickOutputs& out) {
                      if (core.mode == Mode::remote && time_s > 15.0) out.record.lease_holder = 0;
                    }),
                    "I3"));
}
TEST(ChaosBites, I4WheelsCommandedInStandby) {
  EXPECT_TRUE(bites(quiet([](double, core::CoreState& core, core::TickOutputs& out) {
                      if (core.mode == Mode::standby) out.record.wheel_left_command_m_s = 0.01F;
                    }),
                    "I4"));
}
TEST(ChaosBites, I5AStopThatEndsByItself) {
  SessionOptions options = quiet([](double, core::CoreState& core, core::TickOutputs& out) {
    if (core.mode != Mode::protective_stop || core.still.ticks < 50) return;
    core.mode = Mode::standby;
    tell_change(out, Mode::protective_stop, Mode::standby);
  });
  options.faults = std::vector<Fault>{{Kind::bumper, contract::Node::io, 20.0, 20.5, 0.1}};
  EXPECT_TRUE(bites(options, "I5"));
}
TEST(ChaosBites, I6AStickThatActsLongAfterItsLastCommand) {
  // The core takes the age of every command for zero.
  SessionOptions options = quiet([](double, core::CoreState& core, core::TickOutputs& out) {
    if (core.mode == Mode::remote && core.remote.held()) out.record.speed_wish_m_s = 0.1F, out.record.remote_age_s = 0.0F;
    if (core.mode == Mode::remote && !core.remote.held()) out.record.speed_wish_m_s = 0.1F;
  });
  EXPECT_TRUE(bites(options, "I6"));
}
TEST(ChaosBites, I7AStartWithAPatientWhoLeans) {
  SessionOptions options = quiet([](double, core::CoreState& core, core::TickOutputs&) {
    contract::Params lenient = core.params;
    lenient.neutral_start_tolerance_norm = 10.0;
    install_params(core, lenient);
  });
  options.faults = std::vector<Fault>{{Kind::pelvis_turned, contract::Node::io, 6.5, 38.0, 0.95}};
  EXPECT_TRUE(bites(options, "I7"));
}
TEST(ChaosBites, I7AStartWhileAWheelTurns) {
  bool started = false;
  EXPECT_TRUE(bites(quiet([&started](double time_s, core::CoreState& core, core::TickOutputs& out) {
                      if (started || time_s < 20.5 || core.mode != Mode::remote) return;  // its right wheel turns at 0.2 m/s
                      started = true;
                      tell_change(out, Mode::remote, Mode::standby);
                      tell_change(out, Mode::standby, Mode::remote);
                    }),
                    "I7"));
}
// A core that starts two seconds after the fault has begun, whatever bars it.
TEST(ChaosBites, I7AStartThatSomethingBars) {
  struct Row {
    Fault fault;
    const char* why;
  };
  const Row rows[] = {
      {{Kind::bumper, contract::Node::io, 20.0, 24.0, 0.1}, "a pressed bumper"},
      {{Kind::emergency_stop, contract::Node::io, 20.0, 24.0, 0.5}, "the emergency stop pressed"},
      {{Kind::unplug, contract::Node::tilt_left, 20.0, 24.0, 0.5}, "without one of the nodes"},
      {{Kind::sensor_silent, contract::Node::tilt_base, 20.0, 24.0, 0.5}, "a sensor that knows nothing"},
      {{Kind::battery, contract::Node::io, 20.0, 24.0, 0.1}, "empty batteries"},
      {{Kind::wrong_part, contract::Node::io, 20.0, 24.0, 0.1}, "never checked"},
  };
  for (const Row& row : rows) {
    SessionOptions options = quiet({});
    options.faults = std::vector<Fault>{row.fault};
    EXPECT_TRUE(run_session(options).broken.empty()) << row.why;
    bool started = false;
    options.sabotage = [&started, &row](double time_s, core::CoreState& core, core::TickOutputs& out) {
      if (started || time_s < row.fault.start_s + 2.0) return;
      started = true;
      core.mode = Mode::user;
      tell_change(out, Mode::standby, Mode::user);
    };
    const SessionReport report = run_session(options);
    EXPECT_TRUE(std::any_of(
        report.broken.begin(), report.broken.end(),
        [&row](const std::string& line) { return line.find("I7") != std::string::npos && line.find(row.why) != std::string::npos; }))
        << row.why << "\n"
        << list(report);
  }
}
TEST(ChaosBites, I8DrivesThatGoOnWithoutTheCore) {
  // A foreign device keeps commanding the left drive after the core has stopped sending.
  contract::CanFrame frame{contract::pdo_cob_id(contract::Pdo::drive_rx1, contract::Node::drive_left),
                           static_cast<std::uint8_t>(contract::pdo_bytes(contract::Pdo::drive_rx1)),
                           0,
                           {}};
  contract::write_slot(frame, contract::pdo_slot(contract::Pdo::drive_rx1, 0x6040), contract::canopen::drive::kEnable);
  contract::write_slot(frame, contract::pdo_slot(contract::Pdo::drive_rx1, 0x60FF), 90'000);
  int bitten = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SessionOptions options{
        .seed = seed, .length_s = 40, .faults = std::vector<Fault>{{Kind::core_stall, contract::Node::io, 22.0, 26.0, 0.5}}};
    options.spoof = frame;
    bitten += bites(options, "I8") ? 1 : 0;
  }
  EXPECT_GT(bitten, 0);
}
TEST(ChaosBites, I9ADiskThatOnlySaysItHasStored) {
  int bitten = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SessionOptions options{
        .seed = seed, .length_s = 40, .faults = std::vector<Fault>{{Kind::disk_power_cut, contract::Node::io, 22.0, 24.0, 0.5}}};
    options.lying_disk = true;
    bitten += bites(options, "I9") ? 1 : 0;
  }
  EXPECT_GT(bitten, 0);
}
TEST(ChaosBites, I9WhatWasStoredIsFoundAgain) {
  const SessionReport report =
      run_session({.seed = 3, .length_s = 40, .faults = std::vector<Fault>{{Kind::server_crash, contract::Node::io, 22.0, 24.0, 0.5}}});
  EXPECT_TRUE(report.broken.empty()) << list(report);
  EXPECT_GT(report.samples, 500U);
}
TEST(ChaosBites, I10AParameterThatChangesByItself) {
  EXPECT_TRUE(bites(quiet([](double time_s, core::CoreState& core, core::TickOutputs&) {
                      if (time_s > 20.0) core.params.speed_cap_norm = 0.5123;
                    }),
                    "I10"));
}
TEST(ChaosBites, I11AFaultToldTwice) {
  SessionOptions options = quiet([](double, core::CoreState&, core::TickOutputs& out) {
    for (std::size_t i = 0; i < out.events.size(); ++i)
      if (out.events[i].kind == contract::EventKind::fault_raised) {
        const contract::Event again = out.events[i];
        (void)out.events.push_back(again);
        return;
      }
  });
  options.faults = std::vector<Fault>{{Kind::bumper, contract::Node::io, 20.0, 20.5, 0.1}};
  EXPECT_TRUE(bites(options, "I11"));
}
TEST(ChaosBites, I11AFaultThatIsInForceAndNotTold) {
  SessionOptions options = quiet([](double, core::CoreState&, core::TickOutputs& out) { out.events.clear(); });
  options.faults = std::vector<Fault>{{Kind::bumper, contract::Node::io, 20.0, 20.5, 0.1}};
  EXPECT_TRUE(bites(options, "I11"));
}
TEST(ChaosBites, I12AWalkThatEndsWithTheServer) {
  SessionOptions options{.seed = 2, .length_s = 45.0};
  options.faults = std::vector<Fault>{{Kind::server_hang, contract::Node::io, 25.0, 35.0, 0.5}};
  EXPECT_TRUE(run_unmoved(options).broken.empty());
  options.sabotage = [](double, core::CoreState& core, core::TickOutputs&) {
    if (moving(core) && core.server.seen() && !core.server.alive()) core.in_mode.leaving = true;
  };
  EXPECT_FALSE(run_unmoved(options).broken.empty());
}
TEST(ChaosBites, I13ANumberThatIsNone) {
  EXPECT_TRUE(bites(quiet([](double time_s, core::CoreState&, core::TickOutputs& out) {
                      if (time_s > 20.0) out.record.speed_m_s = std::numeric_limits<float>::quiet_NaN();
                    }),
                    "I13"));
}
TEST(ChaosBites, I14AnAcknowledgementThatDoesNothing) {
  SessionOptions options = quiet([](double, core::CoreState& core, core::TickOutputs&) {
    if (core.mode == Mode::protective_stop) core.still.ticks = 0;
  });
  options.faults = std::vector<Fault>{{Kind::bumper, contract::Node::io, 20.0, 20.5, 0.1}};
  EXPECT_TRUE(bites(options, "I14"));
}

TEST(ChaosShrink, FindsTheOneFaultThatMatters) {
  SessionOptions options = quiet([](double, core::CoreState& core, core::TickOutputs&) {
    if (core.mode == Mode::protective_stop) core.still.ticks = 0;
  });
  options.length_s = 60;
  options.seed = 8;
  options.faults = std::vector<Fault>{{Kind::clock_jump, contract::Node::io, 10.0, 12.0, 0.5},
                                      {Kind::battery, contract::Node::io, 14.0, 15.0, 0.99},
                                      {Kind::bumper, contract::Node::io, 20.0, 20.5, 0.1},
                                      {Kind::second_client, contract::Node::io, 22.0, 23.0, 0.1}};
  const SessionReport report = run_session(options);
  ASSERT_FALSE(report.broken.empty());
  const SessionOptions small = shrink(options, report);
  EXPECT_FALSE(run_session(small).broken.empty());
  EXPECT_LE(small.faults->size(), 1U);
  EXPECT_LE(small.length_s, options.length_s);
  EXPECT_NE(replay_words(small).find("--seed 8"), std::string::npos);
}

TEST(ChaosShrink, WhatIsPrintedIsTheSessionAgain) {
  SessionOptions options;
  options.seed = 123456789;
  options.length_s = 31;
  options.frame_loss = 0.0125;
  options.link_jitter_s = 0.3;
  options.faults = std::vector<Fault>{{Kind::bumper, contract::Node::io, 20.0, 20.5, 0.1}};
  for (const bool unmoved : {false, true}) {
    options.only_walk = options.outside_only = unmoved;
    options.patient = unmoved ? "stroke" : kEvenPatient;
    const auto read = read_replay(replay_words(options));
    ASSERT_TRUE(read.has_value());
    EXPECT_EQ(read->seed, options.seed);
    EXPECT_EQ(read->length_s, options.length_s);
    EXPECT_EQ(read->frame_loss, options.frame_loss);
    EXPECT_EQ(read->link_jitter_s, options.link_jitter_s);
    EXPECT_EQ(read->only_walk, unmoved);
    EXPECT_EQ(read->outside_only, unmoved);
    EXPECT_EQ(patient_of(*read), *options.patient);
    EXPECT_EQ(faults_text(*read->faults), faults_text(*options.faults));
  }
  for (const char* wrong : {"", "--seed 1", "--seed 1 --faults nonsense", "--seed x --faults bumper::1:2:0.5", "--lost 0.1 --seed 1",
                            "--seed", "--patient nobody --faults -"})
    EXPECT_FALSE(read_replay(wrong).has_value()) << wrong;
}

}  // namespace
}  // namespace hoist::chaos
