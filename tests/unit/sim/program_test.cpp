// What surrounds the world in hoist-sim: requests, their socket, the pseudo terminal.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "firmware/sim/request_socket.hpp"
#include "firmware/sim/requests.hpp"
#include "firmware/sim/serial_line.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hoist::sim {
namespace {

using nlohmann::json;

json ask(World& world, const std::string& line) { return json::parse(answer_request(world, {}, line)); }

TEST(Requests, TellTheTrueState) {
  World world(WorldOptions{});
  for (int i = 0; i < 100; ++i) world.advance_1ms();
  const json state = ask(world, R"({"op":"state"})");
  EXPECT_DOUBLE_EQ(state.at("time_s").get<double>(), 0.1);
  EXPECT_EQ(state.at("simulated"), true);
  EXPECT_EQ(state.at("enabled"), false);
  EXPECT_EQ(state.at("patient"), "standing");
  EXPECT_EQ(state.at("scenario"), "figure-eight");
  EXPECT_NEAR(state.at("psi_rad").get<double>(), std::asin(0.8), 1e-12);
}

TEST(Requests, DoWhatTheySay) {
  World world(WorldOptions{});
  EXPECT_EQ(ask(world, R"({"op":"bumper","which":"rear","pressed":true})").at("ok"), true);
  EXPECT_EQ(world.plant().bumpers(), 0x02);
  EXPECT_EQ(ask(world, R"({"op":"battery","volts":21.5})").at("ok"), true);
  EXPECT_NEAR(world.plant().supply_v(), 21.5, 1e-9);
  EXPECT_EQ(ask(world, R"({"op":"battery","volts":null})").at("ok"), true);
  EXPECT_GT(world.plant().supply_v(), 24.0);
  EXPECT_EQ(ask(world, R"({"op":"unplug","node":"tilt_left"})").at("ok"), true);
  EXPECT_EQ(ask(world, R"({"op":"state"})").at("unplugged"), json::array({"tilt_left"}));
  EXPECT_EQ(ask(world, R"({"op":"replug","node":"tilt_left"})").at("ok"), true);
  EXPECT_FALSE(world.unplugged(contract::Node::tilt_left));
  EXPECT_EQ(ask(world, R"({"op":"trip"})").at("ok"), true);
  EXPECT_EQ(world.patient().state(), PatientState::tripping);
  EXPECT_EQ(ask(world, R"({"op":"scenario","name":"square"})").at("ok"), true);
  EXPECT_EQ(world.patient().scenario().name, "square");
  EXPECT_DOUBLE_EQ(world.plant().platform().x_m, -1.6);
  EXPECT_EQ(ask(world, R"({"op":"wish","speed_m_s":0.4})").at("ok"), true);
  EXPECT_DOUBLE_EQ(world.patient().params().wish_m_s, 0.4);
  EXPECT_TRUE(ask(world, R"({"op":"help"})").contains("reset"));
}

TEST(Requests, LetSomebodyPushTheHoistAndHoldTheBar) {
  World world(WorldOptions{});
  const double from_rad = world.plant().platform().psi_rad;
  const std::int32_t left = world.plant().encoder_counts(Side::left);
  EXPECT_EQ(ask(world, R"({"op":"push","way_m":1.0,"turn_rad":0.5})").at("ok"), true);
  EXPECT_EQ(ask(world, R"({"op":"bar","dx_m":0.1,"yaw_rad":0.0})").at("ok"), true);
  EXPECT_EQ(ask(world, R"({"op":"state"})").at("patient_in"), false);
  for (const char* of_a_patient : {R"({"op":"trip"})", R"({"op":"collapse"})", R"({"op":"hang"})", R"({"op":"freeze_feet","seconds":1})"})
    EXPECT_TRUE(ask(world, of_a_patient).contains("error")) << of_a_patient;
  for (int i = 0; i < 4000; ++i) world.advance_1ms();
  EXPECT_FALSE(world.plant().pushed());
  EXPECT_NEAR(world.plant().platform().psi_rad - from_rad, 0.5, 1e-3);
  EXPECT_GT(world.plant().encoder_counts(Side::left) - left, 60000) << "a turn and more: the encoders count a push";
  EXPECT_NEAR(world.plant().strut_alpha_rad(Side::left), std::atan(0.1 / 0.8), 1e-9);
  EXPECT_EQ(ask(world, R"({"op":"strap"})").at("ok"), true);
  EXPECT_TRUE(world.patient_in());
  EXPECT_EQ(ask(world, R"({"op":"wire_bumper","strip":0,"bit":1})").at("ok"), true);
  EXPECT_EQ(ask(world, R"({"op":"bumper","which":"front","pressed":true})").at("ok"), true);
  EXPECT_EQ(world.plant().bumpers(), 0x02);
  EXPECT_TRUE(ask(world, R"({"op":"wire_bumper","strip":0,"bit":255})").contains("ok"));
  EXPECT_TRUE(ask(world, R"({"op":"wire_bumper","strip":0,"bit":8})").contains("error")) << "the input node has eight";
  EXPECT_TRUE(ask(world, R"({"op":"wire_bumper","strip":0,"bit":254})").contains("error"));
  EXPECT_TRUE(ask(world, R"({"op":"bar","dx_m":0.9,"yaw_rad":0.0})").contains("error"));
  EXPECT_TRUE(ask(world, R"({"op":"push","way_m":"far","turn_rad":0.0})").contains("error"));
}

TEST(Requests, TheFloorIsCleared) {
  World world(WorldOptions{});
  const PlatformMotion at = world.plant().platform();
  const double ahead_m = world.plant().params().bumper_middle_m;
  ASSERT_TRUE(world.plant().add_obstacle({at.x_m + ahead_m * std::cos(at.psi_rad), at.y_m + ahead_m * std::sin(at.psi_rad), 0.3}));
  EXPECT_TRUE(ask(world, R"({"op":"sill","which":"both","height_m":0.01})").contains("ok"));
  world.advance_1ms();
  EXPECT_NE(world.plant().bumpers(), 0);
  EXPECT_EQ(ask(world, R"({"op":"clear_floor"})").at("ok"), true);
  for (int i = 0; i < 100; ++i) world.advance_1ms();
  EXPECT_EQ(world.plant().bumpers(), 0);
}

TEST(Requests, RefuseByNameAndChangeNothing) {
  World world(WorldOptions{});
  const std::uint64_t before = world.digest();
  const std::pair<const char*, const char*> kBad[] = {
      {"", "line"},
      {"nonsense", "line"},
      {"[]", "line"},
      {"{}", "op"},
      {R"({"op":7})", "op"},
      {R"({"op":"fly"})", "op"},
      {R"({"op":"bumper","pressed":true})", "which"},
      {R"({"op":"bumper","which":"top","pressed":true})", "which"},
      {R"({"op":"bumper","which":"front","pressed":1})", "pressed"},
      {R"({"op":"battery"})", "volts"},
      {R"({"op":"battery","volts":-1})", "volts"},
      {R"({"op":"battery","volts":1e999})", "line"},
      {R"({"op":"unplug","node":"tail"})", "node"},
      {R"({"op":"freeze","node":"core","frozen":true})", "node"},
      {R"({"op":"freeze_sensor","node":"io","frozen":true})", "node"},
      {R"({"op":"scenario","name":"moon"})", "name"},
      {R"({"op":"wish","speed_m_s":9})", "speed_m_s"},
      {R"({"op":"obstacle","x_m":1,"y_m":"a","radius_m":1})", "x_m"},
      {"{\"op\":\"\xff\xfe\"}", "line"},
  };
  for (const auto& [line, field] : kBad) {
    const json answer = ask(world, line);
    ASSERT_TRUE(answer.contains("error")) << line;
    EXPECT_EQ(answer.at("error").get<std::string>().rfind(field, 0), 0U) << line << " -> " << answer;
  }
  EXPECT_TRUE(ask(world, std::string(kRequestMax + 1, ' ')).contains("error"));
  EXPECT_EQ(world.digest(), before);
}

// A client of the socket with the test's timeout.
class Client {
 public:
  explicit Client(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path.c_str(), path.size());
    fd_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0);
    connected = ::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  }
  ~Client() { ::close(fd_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  void say(const std::string& text) { EXPECT_EQ(::send(fd_, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size())); }
  void end() { EXPECT_EQ(::shutdown(fd_, SHUT_WR), 0); }
  std::string hear() {
    std::array<char, 4096> piece{};
    const ssize_t got = ::recv(fd_, piece.data(), piece.size(), 0);
    closed = got == 0;
    return got > 0 ? std::string(piece.data(), static_cast<std::size_t>(got)) : std::string();
  }
  bool connected{false};
  bool closed{false};

 private:
  int fd_;
};

std::string echo(std::string_view line) { return "<" + std::string(line.substr(0, 10)) + ">"; }

TEST(RequestSocket, AnswersLinesHoweverTheyArrive) {
  const hoist::test::TemporaryFolder folder;
  RequestSocket socket;
  ASSERT_EQ(socket.open(folder.file("s")), "");
  Client client(folder.file("s"));
  ASSERT_TRUE(client.connected);
  socket.serve(echo);
  client.say("one\ntw");
  socket.serve(echo);
  EXPECT_EQ(client.hear(), "<one>\n");
  client.say("o\n\nthree\n");
  socket.serve(echo);
  EXPECT_EQ(client.hear(), "<two>\n<three>\n");
  // The last line of a client that has said all needs no end.
  Client brief(folder.file("s"));
  brief.say("four");
  brief.end();
  socket.serve(echo);
  socket.serve(echo);
  EXPECT_EQ(brief.hear(), "<four>\n");
  // A line without end is refused and the client closed.
  client.say(std::string(3000, 'x'));
  socket.serve(echo);
  client.say(std::string(3000, 'x'));
  socket.serve(echo);
  EXPECT_NE(client.hear(), "");
  (void)client.hear();
  EXPECT_TRUE(client.closed);
}

TEST(RequestSocket, TakesOverADeadSocketAndNothingElse) {
  const hoist::test::TemporaryFolder folder;
  {
    RequestSocket socket;
    ASSERT_EQ(socket.open(folder.file("s")), "");
    RequestSocket second;
    EXPECT_NE(second.open(folder.file("s")), "");  // alive
  }
  EXPECT_FALSE(std::filesystem::exists(folder.file("s")));
  // What a killed program leaves behind.
  const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, folder.file("s").c_str(), folder.file("s").size());
  ASSERT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  ::close(fd);
  RequestSocket socket;
  EXPECT_EQ(socket.open(folder.file("s")), "");
  std::ofstream(folder.file("note")) << "mine";
  RequestSocket third;
  EXPECT_NE(third.open(folder.file("note")), "");
  EXPECT_TRUE(std::filesystem::is_regular_file(folder.file("note")));
  EXPECT_NE(third.open(std::string(200, 'x')), "");
}

TEST(RequestSocket, TheNinthClientIsToldSo) {
  const hoist::test::TemporaryFolder folder;
  RequestSocket socket;
  ASSERT_EQ(socket.open(folder.file("s")), "");
  std::vector<std::unique_ptr<Client>> clients;
  for (int i = 0; i < 8; ++i) {
    clients.push_back(std::make_unique<Client>(folder.file("s")));
    socket.serve(echo);
  }
  Client ninth(folder.file("s"));
  socket.serve(echo);
  EXPECT_NE(ninth.hear().find("too many"), std::string::npos);
  clients.front().reset();
  socket.serve(echo);
  Client next(folder.file("s"));
  socket.serve(echo);
  next.say("hello\n");
  socket.serve(echo);
  EXPECT_EQ(next.hear(), "<hello>\n");
}

TEST(SerialLine, IsARawTerminalBehindALinkThatGoesAgain) {
  const hoist::test::TemporaryFolder folder;
  const std::string link = folder.file("can");
  {
    SerialLine line;
    ASSERT_EQ(line.open(link), "");
    ASSERT_TRUE(std::filesystem::is_symlink(link));
    EXPECT_FALSE(line.presence().there);
    const int fd = ::open(link.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    ASSERT_GE(fd, 0);
    const SerialLine::Presence opened = line.presence();
    EXPECT_TRUE(opened.there);
    EXPECT_TRUE(opened.changed);
    EXPECT_FALSE(line.presence().changed);
    termios settings{};
    ASSERT_EQ(::tcgetattr(fd, &settings), 0);
    EXPECT_EQ(settings.c_lflag & (ECHO | ICANON), 0U);
    // Both ways, byte for byte.
    const std::string text = "t18820100\r\a\n";
    ASSERT_EQ(line.write(text), text.size());
    pollfd wait{fd, POLLIN, 0};
    ASSERT_EQ(::poll(&wait, 1, 1000), 1);
    std::array<char, 64> piece{};
    EXPECT_EQ(::read(fd, piece.data(), piece.size()), static_cast<ssize_t>(text.size()));
    EXPECT_EQ(std::string(piece.data(), text.size()), text);
    ASSERT_EQ(::write(fd, "O\r", 2), 2);
    EXPECT_EQ(line.read(piece), 2U);
    EXPECT_EQ(line.read(piece), 0U);
    // What the user leaves unread does not greet the next one.
    ASSERT_EQ(line.write(std::string("stale")), 5U);
    ::close(fd);
    const SerialLine::Presence closed = line.presence();
    EXPECT_FALSE(closed.there);
    EXPECT_TRUE(closed.changed);
    const int again = ::open(link.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    ASSERT_GE(again, 0);
    EXPECT_TRUE(line.presence().there);
    EXPECT_LT(::read(again, piece.data(), piece.size()), 0);
    ASSERT_EQ(::tcgetattr(again, &settings), 0);
    EXPECT_EQ(settings.c_lflag & (ECHO | ICANON), 0U);
    ::close(again);
  }
  EXPECT_FALSE(std::filesystem::is_symlink(link));
}

TEST(SerialLine, ReplacesALinkButNeverAFile) {
  const hoist::test::TemporaryFolder folder;
  std::filesystem::create_symlink("/nowhere", folder.file("can"));
  {
    SerialLine line;
    EXPECT_EQ(line.open(folder.file("can")), "");
    EXPECT_EQ(std::filesystem::read_symlink(folder.file("can")).string(), line.path());
    // Another process has replaced the link: it stays when we exit.
    std::filesystem::remove(folder.file("can"));
    std::filesystem::create_symlink("/elsewhere", folder.file("can"));
  }
  EXPECT_EQ(std::filesystem::read_symlink(folder.file("can")).string(), "/elsewhere");
  std::ofstream(folder.file("note")) << "mine";
  SerialLine line;
  EXPECT_NE(line.open(folder.file("note")), "");
  EXPECT_TRUE(std::filesystem::is_regular_file(folder.file("note")));
}

}  // namespace
}  // namespace hoist::sim
