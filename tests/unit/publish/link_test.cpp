#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "control/publish/core_link.hpp"
#include "control/publish/server_link.hpp"

namespace hoist::publish {
namespace {

std::string temporary_socket() {
  static std::atomic<int> number{0};
  return ::testing::TempDir() + "hoist-link-" + std::to_string(::getpid()) + "-" + std::to_string(number++) + ".sock";
}

// A core whose helper thread serves until the end of the test.
class ServedCore {
 public:
  explicit ServedCore(const std::string& path, std::uint64_t life = 1000) {
    std::string error;
    link = CoreLink::create(path, life, 5, error);
    if (!link) throw std::runtime_error(error);
    thread_ = std::thread([this] {
      while (!ended_) link->serve(5);
    });
  }
  ~ServedCore() {
    ended_ = true;
    thread_.join();
  }
  std::unique_ptr<CoreLink> link;

 private:
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

bool attach(ServerLink& server) {
  for (int i = 0; i < 200'000'000; ++i)
    if (server.poll_connect()) return true;
  return false;
}

contract::TickRecord record(std::uint64_t tick) {
  contract::TickRecord r;
  r.tick = tick;
  r.time_ns = tick * 10'000'000;
  r.x_m = static_cast<float>(tick) * 0.25F;
  return r;
}

TEST(Link, CarriesTicksAndCommands) {
  const std::string path = temporary_socket();
  ServedCore core(path);
  ServerLink server(path);
  ASSERT_TRUE(attach(server)) << server.last_error();
  EXPECT_EQ(server.life(), 1000U);
  TickReader reader(server);
  core.link->publish_tick(record(1));
  core.link->publish_tick(record(2));
  std::array<contract::TickRecord, 4> out;
  const auto got = reader.read(out);
  ASSERT_EQ(got.count, 2U);
  EXPECT_EQ(out[1].tick, 2U);
  EXPECT_FLOAT_EQ(out[1].x_m, 0.5F);

  contract::Command command;
  command.kind = contract::CommandKind::stop;
  EXPECT_EQ(server.send(command), 1U);
  EXPECT_EQ(server.send(command), 2U);
  server.beat();
  ASSERT_TRUE(core.link->begin());
  EXPECT_EQ(core.link->server_life(), 1U);
  std::array<contract::Command, 8> commands;
  std::uint64_t lost = 9;
  EXPECT_EQ(core.link->read_commands(commands, lost), 2U);
  EXPECT_EQ(lost, 0U);
  EXPECT_EQ(commands[1].sequence, 2U);
  EXPECT_EQ(core.link->heartbeat(), 1U);
  core.link->end();
}

TEST(Link, DriveIsReadOncePerWrite) {
  const std::string path = temporary_socket();
  ServedCore core(path);
  ServerLink server(path);
  ASSERT_TRUE(attach(server));
  contract::DriveCommand command;
  ASSERT_TRUE(core.link->begin());
  EXPECT_FALSE(core.link->read_drive(command));
  core.link->end();
  command.speed_norm = 0.5;
  server.drive(command);
  command.speed_norm = 0.75;
  server.drive(command);
  ASSERT_TRUE(core.link->begin());
  contract::DriveCommand got;
  EXPECT_TRUE(core.link->read_drive(got));
  EXPECT_EQ(got.speed_norm, 0.75) << "only the newest counts";
  EXPECT_FALSE(core.link->read_drive(got));
  core.link->end();
}

TEST(Link, AFullCommandRingIsRefusedUntilTheCoreReads) {
  const std::string path = temporary_socket();
  ServedCore core(path);
  ServerLink server(path);
  ASSERT_TRUE(attach(server));
  contract::Command command;
  command.kind = contract::CommandKind::stage_parameter;
  for (std::size_t i = 0; i < contract::kCommandSlots - ServerLink::kSlotsForStop; ++i) ASSERT_NE(server.send(command), 0U);
  EXPECT_EQ(server.send(command), 0U);
  command.kind = contract::CommandKind::stop;
  for (std::size_t i = 0; i < ServerLink::kSlotsForStop; ++i) ASSERT_NE(server.send(command), 0U) << "a STOP finds a slot";
  EXPECT_EQ(server.send(command), 0U);
  std::array<contract::Command, contract::kCommandSlots> commands;
  std::uint64_t lost = 0;
  ASSERT_TRUE(core.link->begin());
  EXPECT_EQ(core.link->read_commands(commands, lost), contract::kCommandSlots);
  core.link->end();
  EXPECT_NE(server.send(command), 0U);
}

TEST(Link, ASecondServerIsRefusedWithAReason) {
  const std::string path = temporary_socket();
  ServedCore core(path);
  ServerLink first(path), second(path);
  ASSERT_TRUE(attach(first));
  while (second.last_error().find("another server") == std::string::npos) ASSERT_FALSE(second.poll_connect());
  EXPECT_NE(second.last_error().find("another server"), std::string::npos) << second.last_error();
  EXPECT_EQ(second.problem(), LinkProblem::taken);
  EXPECT_EQ(first.problem(), LinkProblem::none);
  EXPECT_TRUE(first.poll_connect());
}

// It asks ten times a second; a log of the same line hides what matters.
TEST(Link, ARefusalIsToldOnceUntilAServerIsAttached) {
  const std::string path = temporary_socket();
  std::string error;
  const auto core = CoreLink::create(path, 1, 5, error);
  ASSERT_TRUE(core) << error;
  std::vector<std::string> told;
  const auto meet = [&](ServerLink& server, std::size_t lines) {
    server.poll_connect();
    for (std::size_t i = 0; told.size() < lines && i < 3; ++i)
      if (const std::string news = core->serve(5); !news.empty()) told.push_back(news);
    server.poll_connect();
  };
  ServerLink first(path);
  meet(first, 1);
  ASSERT_TRUE(first.attached());
  for (int i = 0; i < 3; ++i) {
    ServerLink second(path);  // a new one each time, because one asks only every 100 ms
    meet(second, 9);
    EXPECT_EQ(second.problem(), LinkProblem::taken);
  }
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[1], "server refused: another server is attached");
  first = ServerLink("");
  core->serve(5);
  ServerLink third(path), fourth(path);
  meet(third, 3);
  ASSERT_TRUE(third.attached());
  meet(fourth, 4);
  EXPECT_EQ(told.back(), "server refused: another server is attached") << "after a change it is news again";
  EXPECT_EQ(told.size(), 4U);
}

// The core lives on and is found again by a server that comes later.
TEST(Link, ASocketThatWasDeletedIsMadeAnew) {
  const std::string path = temporary_socket();
  ServedCore core(path);
  {
    ServerLink first(path);
    ASSERT_TRUE(attach(first));
    std::filesystem::remove(path);
    EXPECT_TRUE(first.poll_connect()) << "who is attached stays so";
  }
  ServerLink second(path);
  EXPECT_TRUE(attach(second)) << second.last_error();
  EXPECT_EQ(std::filesystem::status(path).permissions(), std::filesystem::perms(0600));
}

TEST(Link, ASocketOfAnotherCoreIsLeftAloneAndNamed) {
  const std::string path = temporary_socket();
  std::string error;
  auto first = CoreLink::create(path, 1000, 5, error);
  ASSERT_NE(first, nullptr) << error;
  std::filesystem::remove(path);
  auto second = CoreLink::create(path, 1001, 5, error);
  ASSERT_NE(second, nullptr) << error;
  EXPECT_NE(first->serve(0).find("another hoist-control already listens on " + path), std::string::npos);
  EXPECT_EQ(first->serve(0), "") << "said once";
  first.reset();
  EXPECT_TRUE(std::filesystem::exists(path)) << "it is the other one's";
  second.reset();
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(Link, AFileThatIsNoSocketStays) {
  const std::string path = temporary_socket();
  std::ofstream(path) << "precious";
  std::string error;
  EXPECT_EQ(CoreLink::create(path, 1000, 5, error), nullptr);
  EXPECT_NE(error.find("no socket"), std::string::npos) << error;
  std::string kept;
  std::ifstream(path) >> kept;
  EXPECT_EQ(kept, "precious");
  ::unlink(path.c_str());
}

// A core that is stopped accepts no connection, and soon its queue of connections is full.
TEST(Link, ACoreThatStandsStillHoldsNobodyUp) {
  const std::string path = temporary_socket();
  std::string error;
  const std::unique_ptr<CoreLink> core = CoreLink::create(path, 1000, 5, error);
  ASSERT_NE(core, nullptr) << error;
  ::alarm(60);  // a blocking connect would wait for ever
  std::vector<std::unique_ptr<ServerLink>> servers;
  for (int i = 0; i < 8; ++i) {
    servers.push_back(std::make_unique<ServerLink>(path));
    for (int k = 0; k < 100 || servers.back()->last_error().empty(); ++k) ASSERT_FALSE(servers.back()->poll_connect());
    EXPECT_EQ(servers.back()->last_error(), "the core does not answer");
    EXPECT_EQ(servers.back()->problem(), LinkProblem::silent);
  }
  ::alarm(0);
  EXPECT_EQ(CoreLink::create(path, 2000, 5, error), nullptr) << "it is not dead";
  EXPECT_NE(error.find("another hoist-control"), std::string::npos) << error;
  // It goes on, and finds the first one's question.
  std::atomic<bool> ended{false};
  std::thread goes_on([&] {
    while (!ended) core->serve(5);
  });
  EXPECT_TRUE(attach(*servers.front()));
  ended = true;
  goes_on.join();
}

TEST(Link, TheServerComesBackAfterItsDeathAndBeginsANewLife) {
  const std::string path = temporary_socket();
  ServedCore core(path);
  {
    ServerLink server(path);
    ASSERT_TRUE(attach(server));
    contract::Command command;
    server.send(command);
    ASSERT_TRUE(core.link->begin());
    std::array<contract::Command, 8> commands;
    std::uint64_t lost;
    core.link->read_commands(commands, lost);
    core.link->end();
  }
  ServerLink server(path);
  ASSERT_TRUE(attach(server)) << server.last_error();
  contract::Command command;
  ASSERT_TRUE(core.link->begin());
  EXPECT_EQ(core.link->server_life(), 2U);
  core.link->end();
  EXPECT_EQ(server.send(command), 1U);
}

TEST(Link, ReadersDrainADeadCoreThenFollowTheNewOne) {
  const std::string path = temporary_socket();
  auto core = std::make_unique<ServedCore>(path, 1000);
  ServerLink server(path);
  ASSERT_TRUE(attach(server));
  TickReader reader(server);
  std::array<contract::TickRecord, 4> out;
  EXPECT_EQ(reader.read(out).count, 0U);
  core->link->publish_tick(record(1));
  core.reset();
  core = std::make_unique<ServedCore>(path, 2000);
  while (server.life() != 2000U) server.poll_connect();
  core->link->publish_tick(record(100));
  ASSERT_EQ(reader.read(out).count, 1U);
  EXPECT_EQ(out[0].tick, 1U);
  EXPECT_EQ(reader.life(), 1000U);
  ASSERT_EQ(reader.read(out).count, 1U);
  EXPECT_EQ(out[0].tick, 100U);
  EXPECT_EQ(reader.life(), 2000U);
}

TEST(Link, ASecondCoreOnTheSameSocketIsRefused) {
  const std::string path = temporary_socket();
  ServedCore core(path);
  std::string error;
  EXPECT_EQ(CoreLink::create(path, 1, 1, error), nullptr);
  EXPECT_NE(error.find("another hoist-control"), std::string::npos) << error;
}

TEST(Link, ATakenOverServerCanNeitherWriteNorShrinkTheState) {
  const std::string path = temporary_socket();
  std::string error;
  auto core = CoreLink::create("", 1, 1, error);
  ASSERT_NE(core, nullptr);
  const int fd = core->state_descriptor();
  EXPECT_EQ(::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0), MAP_FAILED);
  EXPECT_NE(::ftruncate(fd, 0), 0);
  EXPECT_NE(::fcntl(fd, F_ADD_SEALS, F_SEAL_WRITE), 0);
}

TEST(Link, AnUnsealedOrForeignSegmentIsRefused) {
  std::string error;
  auto core = CoreLink::create("", 1, 1, error);
  ASSERT_NE(core, nullptr);
  const int plain = ::memfd_create("plain", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  ASSERT_EQ(::ftruncate(plain, sizeof(contract::CommandSegment)), 0);
  EXPECT_FALSE(core->attach(plain, error));
  EXPECT_NE(error.find("not sealed"), std::string::npos) << error;
  ::close(plain);
  OwnedSegment foreign = create_segment("foreign", sizeof(contract::CommandSegment), error);
  EXPECT_FALSE(core->attach(foreign.descriptor.get(), error));
  EXPECT_NE(error.find("not a segment"), std::string::npos) << error;
  OwnedSegment small = create_segment("small", 4096, error);
  EXPECT_FALSE(core->attach(small.descriptor.get(), error));
  EXPECT_NE(error.find("another size"), std::string::npos) << error;
  EXPECT_FALSE(core->begin()) << "nothing was attached";
}

TEST(Link, GarbageInTheCommandSegmentHarmsNobody) {
  std::string error;
  auto core = CoreLink::create("", 1, 1, error);
  OwnedSegment hostile = create_segment("hostile", sizeof(contract::CommandSegment), error);
  auto* segment = hostile.mapping->as<contract::CommandSegment>();
  std::uint64_t seed = 88172645463325252ULL;
  for (int round = 0; round < 200; ++round) {
    auto* words = reinterpret_cast<contract::Word*>(segment);
    for (std::size_t i = 0; i < sizeof(contract::CommandSegment) / 8; ++i) {
      seed ^= seed << 13;
      seed ^= seed >> 7;
      seed ^= seed << 17;
      words[i].store(seed, std::memory_order_relaxed);
    }
    write_header(segment->header, contract::kCommandMagic, sizeof(contract::CommandSegment), 1, 1);
    if (round == 0) {
      ASSERT_TRUE(core->attach(hostile.descriptor.get(), error)) << error;
    }
    ASSERT_TRUE(core->begin());
    std::array<contract::Command, contract::kCommandSlots> commands;
    std::uint64_t lost = 0;
    EXPECT_LE(core->read_commands(commands, lost), contract::kCommandSlots);
    contract::DriveCommand drive;
    core->read_drive(drive);
    core->end();
  }
}

TEST(Link, ParametersInForceComeBack) {
  std::string error;
  auto core = CoreLink::create("", 1, 1, error);
  contract::ParamsInForce params;
  EXPECT_FALSE(core->params(params));
  params.version = 3;
  params.values[2] = 0.7;
  core->publish_params(params);
  ServerLink server("");
  ASSERT_TRUE(server.attach_directly(*core, error)) << error;
  contract::ParamsInForce got;
  ASSERT_TRUE(server.params(got));
  EXPECT_EQ(got.version, 3U);
  EXPECT_EQ(got.values[2], 0.7);
}

}  // namespace
}  // namespace hoist::publish
