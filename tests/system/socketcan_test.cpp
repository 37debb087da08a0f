// The SocketCAN back end against a real kernel: runs inside the guest of vcan_vm.sh, as root. The port's own time is virtual; only what the
// kernel does in the background is waited for.
#include "control/bus/socketcan.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace hoist::bus {
namespace {
using contract::CanFrame;

constexpr int kSlcanDiscipline = 17;  // N_SLCAN
// The kernel may deliver a frame by its own thread: longest wait for an expected frame.
constexpr int kPatienceMs = 5000;

int run(const std::string& command) { return std::system((command + " >/dev/null 2>&1").c_str()); }

// A plain socket of another program on the same interface.
class Peer {
 public:
  explicit Peer(const std::string& interface) : fd_(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW)) {
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
    EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ~Peer() { ::close(fd_); }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  void write(canid_t id, std::vector<std::uint8_t> bytes) {
    can_frame frame{};
    frame.can_id = id;
    frame.can_dlc = static_cast<std::uint8_t>(bytes.size());
    for (std::size_t i = 0; i < 8; ++i) frame.data[i] = i < bytes.size() ? bytes[i] : std::uint8_t{0xEE};
    ASSERT_EQ(::write(fd_, &frame, sizeof frame), static_cast<ssize_t>(sizeof frame));
  }
  bool read(can_frame& frame) { return ::read(fd_, &frame, sizeof frame) == static_cast<ssize_t>(sizeof frame); }
  // As read(), but gives the kernel time to deliver.
  bool hears(can_frame& frame) {
    pollfd wait{fd_, POLLIN, 0};
    return ::poll(&wait, 1, kPatienceMs) == 1 && read(frame);
  }

 private:
  int fd_;
};

std::vector<std::uint8_t> error_bytes(std::uint8_t control, std::uint8_t tx = 0, std::uint8_t rx = 0) {
  return {0, control, 0, 0, 0, 0, tx, rx};
}

class SocketCan : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::getenv("IN_VCAN_VM") == nullptr) GTEST_SKIP() << "not in the guest of vcan_vm.sh, which has CAN interfaces to play with";
    make_interface();
  }
  void TearDown() override { run("ip link del hoist0"); }
  static void make_interface() {
    ASSERT_EQ(run("ip link add hoist0 type vcan"), 0);
    ASSERT_EQ(run("ip link set hoist0 up"), 0);
  }
  std::size_t receive() { return port.receive(frames, now_ns); }
  // Steps the port (its time stands still) until `done`. The absence of a frame needs no wait: it is checked after a later frame.
  template <typename Done>
  void receive_until(Done done) {
    for (int waited_ms = 0; receive(), !done() && waited_ms < kPatienceMs; ++waited_ms) ::poll(nullptr, 0, 1);
  }
  // Collects frames until `count`.
  std::size_t receive_all(std::size_t count) {
    std::vector<CanFrame> all;
    for (int waited_ms = 0; waited_ms < kPatienceMs; ++waited_ms) {
      const std::size_t got = receive();
      all.insert(all.end(), frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(got));
      if (all.size() >= count) break;
      ::poll(nullptr, 0, 1);
    }
    std::copy_n(all.begin(), std::min(all.size(), frames.size()), frames.begin());
    return all.size();
  }
  void open() {
    receive();
    ASSERT_TRUE(port.up()) << port.problem();
  }
  static constexpr std::array<CanFrame, 1> kCommand{CanFrame{0x201, 6, 0, {15, 0, 1, 2, 3, 4}}};

  SocketCanPort port{"hoist0", PortUse::core};
  std::array<CanFrame, 256> frames{};
  std::uint64_t now_ns = 1'000'000'000;
};

TEST_F(SocketCan, CarriesFramesBothWaysAndNotItsOwn) {
  open();
  Peer peer("hoist0");
  EXPECT_EQ(port.send(kCommand, now_ns), 1U);
  can_frame heard{};
  ASSERT_TRUE(peer.hears(heard));
  EXPECT_EQ(heard.can_id, 0x201U);
  EXPECT_EQ(heard.can_dlc, 6);
  EXPECT_EQ(heard.data[5], 4);
  EXPECT_EQ(receive(), 0U) << "the port hears itself";

  peer.write(0x181, {1, 2, 3});
  peer.write(0x080, {});
  ASSERT_EQ(receive_all(2), 2U);
  EXPECT_EQ(frames[0], (CanFrame{0x181, 3, 0, {1, 2, 3}})) << "bytes behind the length are not part of a frame";
  EXPECT_EQ(frames[1], (CanFrame{0x080, 0, 0, {}}));
  EXPECT_EQ(port.counters().received, 2U);
  EXPECT_EQ(port.counters().sent, 1U);
  EXPECT_EQ(port.counters().refused, 0U);
}

TEST_F(SocketCan, TheCoreHearsElevenBitDataFramesOnlyAToolHearsAll) {
  open();
  SocketCanPort tool("hoist0", PortUse::tool);
  std::array<CanFrame, 16> heard{};
  tool.receive(heard, now_ns);
  Peer peer("hoist0");
  peer.write(0x1ABCDEF0U | CAN_EFF_FLAG, {1});
  peer.write(0x181U | CAN_EFF_FLAG, {1});  // the id of a drive, but a long one: not a drive
  peer.write(0x181U | CAN_RTR_FLAG, {});
  peer.write(0x182, {7});
  ASSERT_EQ(receive_all(1), 1U);
  EXPECT_EQ(frames[0].id, 0x182U);
  // The last of the four has arrived at the core's socket, so all are at the tool's.
  ASSERT_EQ(tool.receive(heard, now_ns), 4U);
  EXPECT_EQ(heard[0], (CanFrame{0x1ABCDEF0, 1, CanFrame::kExtended, {1}}));
  EXPECT_EQ(heard[2].flags, CanFrame::kRemote);
}

TEST_F(SocketCan, ALinkThatGoesDownAndUpNeedsNoNewSocket) {
  open();
  ASSERT_EQ(run("ip link set hoist0 down"), 0);
  receive();
  EXPECT_FALSE(port.up());
  EXPECT_STREQ(port.problem(), "the interface is down");
  EXPECT_EQ(port.send(kCommand, now_ns), 0U);
  EXPECT_EQ(port.counters().send_refused, 1U);
  now_ns += SocketCanPort::kRetryNs;
  receive();
  EXPECT_FALSE(port.up()) << "still down";
  ASSERT_EQ(run("ip link set hoist0 up"), 0);
  now_ns += SocketCanPort::kRetryNs - 1;
  receive();
  EXPECT_FALSE(port.up()) << "asked for every 200 ms, not more often";
  now_ns += 1;
  receive();
  EXPECT_TRUE(port.up());
  EXPECT_STREQ(port.problem(), "");
  EXPECT_EQ(port.counters().reopened, 0U);
  Peer peer("hoist0");
  peer.write(0x181, {1});
  EXPECT_EQ(receive_all(1), 1U);
  EXPECT_EQ(port.send(kCommand, now_ns), 1U);
  can_frame heard{};
  EXPECT_TRUE(peer.hears(heard));
}

TEST_F(SocketCan, SeesALinkThatGoesDownFirstWhenItSends) {
  open();
  ASSERT_EQ(run("ip link set hoist0 down"), 0);
  EXPECT_EQ(port.send(kCommand, now_ns), 0U);
  EXPECT_FALSE(port.up());
}

TEST_F(SocketCan, AnInterfaceThatIsRemovedIsOpenedAgainByName) {
  open();
  ASSERT_EQ(run("ip link del hoist0"), 0);
  receive();
  EXPECT_FALSE(port.up());
  now_ns += SocketCanPort::kRetryNs;
  receive();
  EXPECT_FALSE(port.up());
  EXPECT_STREQ(port.problem(), "there is no such interface");
  EXPECT_EQ(port.send(kCommand, now_ns), 0U);
  make_interface();
  now_ns += SocketCanPort::kRetryNs;
  receive();
  EXPECT_TRUE(port.up());
  EXPECT_EQ(port.counters().reopened, 1U);
  Peer peer("hoist0");
  peer.write(0x181, {1});
  EXPECT_EQ(receive_all(1), 1U);
}

TEST_F(SocketCan, AnInterfaceThatIsReplacedBetweenTwoStepsIsNotMistakenForTheOld) {
  open();
  ASSERT_EQ(run("ip link del hoist0"), 0);
  make_interface();
  EXPECT_EQ(port.send(kCommand, now_ns), 0U);
  EXPECT_FALSE(port.up());
  now_ns += SocketCanPort::kRetryNs;
  receive();
  EXPECT_TRUE(port.up());
  EXPECT_EQ(port.counters().reopened, 1U);
}

TEST_F(SocketCan, AnInterfaceThatComesLaterIsFound) {
  ASSERT_EQ(run("ip link del hoist0"), 0);
  receive();
  EXPECT_FALSE(port.up());
  ASSERT_EQ(run("ip link add hoist0 type vcan"), 0);
  now_ns += SocketCanPort::kRetryNs;
  receive();
  EXPECT_FALSE(port.up()) << "there, but down";
  ASSERT_EQ(run("ip link set hoist0 up"), 0);
  now_ns += SocketCanPort::kRetryNs;
  receive();
  EXPECT_TRUE(port.up());
  EXPECT_EQ(port.counters().reopened, 0U) << "the first time is no second time";
}

TEST_F(SocketCan, AnInterfaceThatIsNoCanInterfaceIsNotUsed) {
  SocketCanPort lo("lo", PortUse::core);
  lo.receive(frames, now_ns);
  EXPECT_FALSE(lo.up());
  EXPECT_STREQ(lo.problem(), "the interface cannot be used as a CAN interface");
}

TEST_F(SocketCan, BusOffStopsSendingUntilTheControllerWasRestarted) {
  open();
  Peer peer("hoist0");
  peer.write(CAN_ERR_FLAG | CAN_ERR_BUSOFF, error_bytes(0));
  receive_until([&] { return !port.up(); });
  EXPECT_EQ(port.counters().received, 0U) << "an error report is no frame for the core";
  EXPECT_FALSE(port.up());
  EXPECT_EQ(port.counters().state, BusState::off);
  EXPECT_EQ(port.counters().bus_offs, 1U);
  EXPECT_EQ(port.send(kCommand, now_ns), 0U);
  can_frame heard{};
  while (peer.read(heard)) EXPECT_NE(heard.can_id, 0x201U) << "a command went out while bus-off";
  // Frames that still arrive do not prove that we may speak, and a state report between is none of "restarted".
  peer.write(0x181, {1});
  peer.write(CAN_ERR_FLAG | CAN_ERR_CRTL, error_bytes(CAN_ERR_CRTL_TX_PASSIVE));
  EXPECT_EQ(receive_all(1), 1U);
  EXPECT_FALSE(port.up());

  peer.write(CAN_ERR_FLAG | CAN_ERR_RESTARTED, error_bytes(0));
  receive_until([&] { return port.up(); });
  EXPECT_TRUE(port.up());
  EXPECT_EQ(port.counters().state, BusState::active);
  EXPECT_STREQ(port.problem(), "");
  EXPECT_EQ(port.send(kCommand, now_ns), 1U);
}

TEST_F(SocketCan, BusOffEndsWhenTheLinkWasDownAndUp) {
  open();
  Peer peer("hoist0");
  peer.write(CAN_ERR_FLAG | CAN_ERR_BUSOFF, error_bytes(0));
  receive_until([&] { return !port.up(); });
  EXPECT_FALSE(port.up());
  ASSERT_EQ(run("ip link set hoist0 down"), 0);
  receive();
  ASSERT_EQ(run("ip link set hoist0 up"), 0);
  now_ns += SocketCanPort::kRetryNs;
  receive();
  EXPECT_TRUE(port.up());
}

// The error frame came before this program was started: only the carrier tells.
TEST_F(SocketCan, AControllerThatIsOffTheBusIsNotTakenForOneThatIsUp) {
  ASSERT_EQ(run("ip link set hoist0 state dormant"), 0);  // as a carrier that is off, which vcan cannot have
  receive();
  EXPECT_FALSE(port.up());
  EXPECT_EQ(port.counters().state, BusState::off);
  EXPECT_EQ(port.counters().bus_offs, 1U);
  EXPECT_NE(std::string(port.problem()).find("bus-off"), std::string::npos);
  EXPECT_EQ(port.send(kCommand, now_ns), 0U);
  now_ns += SocketCanPort::kRetryNs;
  receive();
  EXPECT_EQ(port.counters().bus_offs, 1U) << "still the same";
  ASSERT_EQ(run("ip link set hoist0 state up"), 0);
  now_ns += SocketCanPort::kRetryNs;
  receive();
  EXPECT_TRUE(port.up());
  EXPECT_EQ(port.counters().state, BusState::active);
  EXPECT_STREQ(port.problem(), "");
}

TEST_F(SocketCan, AQueueOfOldCommandsIsTold) {
  EXPECT_STREQ(port.remark(), "");
  open();
  EXPECT_NE(std::string(port.remark()).find("txqueuelen 12"), std::string::npos) << "vcan may hold 1000 frames";
  ASSERT_EQ(run("ip link set hoist0 txqueuelen " + std::to_string(SocketCanPort::kQueueFrames)), 0);
  SocketCanPort again("hoist0", PortUse::core);
  again.receive(frames, now_ns);
  EXPECT_TRUE(again.up());
  EXPECT_STREQ(again.remark(), "");
}

TEST_F(SocketCan, ErrorReportsAreCountedAndStatesFollowed) {
  open();
  Peer peer("hoist0");
  peer.write(CAN_ERR_FLAG | CAN_ERR_CRTL | 0x200U, error_bytes(CAN_ERR_CRTL_RX_WARNING, 12, 97));
  receive_until([&] { return port.counters().state == BusState::warning; });
  EXPECT_EQ(port.counters().state, BusState::warning);
  EXPECT_EQ(port.counters().tx_errors, 12U);
  EXPECT_EQ(port.counters().rx_errors, 97U);
  peer.write(CAN_ERR_FLAG | CAN_ERR_CRTL, error_bytes(CAN_ERR_CRTL_TX_PASSIVE));
  receive_until([&] { return port.counters().state == BusState::passive; });
  EXPECT_EQ(port.counters().state, BusState::passive);
  EXPECT_TRUE(port.up()) << "passive still speaks";
  peer.write(CAN_ERR_FLAG | CAN_ERR_ACK, error_bytes(0));
  peer.write(CAN_ERR_FLAG | CAN_ERR_PROT | CAN_ERR_BUSERROR, error_bytes(0));
  receive_until([&] { return port.counters().bus_errors >= 4; });
  const std::uint32_t errors = port.counters().bus_errors;
  EXPECT_EQ(errors, 4U);
  peer.write(CAN_ERR_FLAG | CAN_ERR_CRTL, error_bytes(CAN_ERR_CRTL_ACTIVE));
  peer.write(CAN_ERR_FLAG | 0x200U, error_bytes(0, 3, 4));  // counters alone
  peer.write(CAN_ERR_FLAG | 0x8000U, error_bytes(0xFF));    // a class that does not exist yet
  peer.write(0x181, {1});                                   // behind them all
  EXPECT_EQ(receive_all(1), 1U);
  EXPECT_EQ(port.counters().state, BusState::active);
  EXPECT_EQ(port.counters().bus_errors, errors) << "good news is no error";
  EXPECT_EQ(port.counters().tx_errors, 3U);
  peer.write(CAN_ERR_FLAG | CAN_ERR_CRTL, error_bytes(CAN_ERR_CRTL_RX_OVERFLOW));
  receive_until([&] { return port.counters().overflows > 0; });
  EXPECT_EQ(port.counters().overflows, 1U);
}

TEST_F(SocketCan, FramesTheKernelHadNoRoomForAreCounted) {
  open();
  Peer peer("hoist0");
  constexpr std::uint32_t kSent = 6000;
  for (std::uint32_t i = 0; i < kSent; ++i) peer.write(0x181, {static_cast<std::uint8_t>(i)});
  // Until the newest queued frame has been read and nothing more comes.
  std::uint32_t steps = 0;
  for (int quiet_ms = 0; quiet_ms < 100; ++steps) {
    ASSERT_LT(steps, 10000U);
    if (receive() > 0) {
      quiet_ms = 0;
    } else {
      ::poll(nullptr, 0, 1);
      ++quiet_ms;
    }
  }
  EXPECT_GT(port.counters().received, 1000U) << "the larger buffer was not taken";
  // The kernel reports the number with the next queued frame.
  peer.write(0x182, {1});
  EXPECT_EQ(receive_all(1), 1U);
  const PortCounters& counters = port.counters();
  EXPECT_GT(counters.overflows, 0U);
  EXPECT_EQ(counters.received + counters.refused + counters.overflows, kSent + 1);
  EXPECT_TRUE(port.up());
}

TEST_F(SocketCan, AFloodIsBoundedInEachStep) {
  open();
  Peer peer("hoist0"), listener("hoist0");
  can_frame heard{};
  for (int i = 0; i < 1000; ++i) {
    peer.write(0x181, {1});
    ASSERT_TRUE(listener.hears(heard)) << "frame " << i << " was not delivered";
  }
  EXPECT_EQ(receive(), frames.size());
  const std::uint32_t handled = port.counters().received + port.counters().refused;
  EXPECT_LE(handled, SocketCanPort::kBatch * SocketCanPort::kBatchesPerStep);
  EXPECT_EQ(port.counters().received, frames.size());
}

TEST_F(SocketCan, AFrameThatCannotExistIsNotSentNorAnythingAfterIt) {
  open();
  Peer peer("hoist0");
  const std::array bad{CanFrame{0x201, 1, 0, {1}}, CanFrame{0x801, 1, 0, {1}}, CanFrame{0x202, 1, 0, {1}}};
  EXPECT_EQ(port.send(bad, now_ns), 1U);
  EXPECT_EQ(port.counters().send_refused, 2U);
  const std::array error{CanFrame{0x20, 8, CanFrame::kError, {}}};
  EXPECT_EQ(port.send(error, now_ns), 0U) << "error frames are told by controllers, never written";
}

// A driver whose device is stuck: the kernel's slcan on a pty without a reader.
TEST_F(SocketCan, AFullQueueIsNoReasonToSpinOrToGoDown) {
  const int master = ::posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_GE(master, 0);
  ASSERT_EQ(::grantpt(master) + ::unlockpt(master), 0);
  const int slave = ::open(::ptsname(master), O_RDWR | O_NOCTTY);
  ASSERT_GE(slave, 0);
  termios settings{};
  ASSERT_EQ(::tcgetattr(slave, &settings), 0);
  ::cfmakeraw(&settings);
  ASSERT_EQ(::tcsetattr(slave, TCSANOW, &settings), 0);
  ASSERT_EQ(::ioctl(slave, TIOCSETD, &kSlcanDiscipline), 0);
  ifreq request{};
  ASSERT_EQ(::ioctl(slave, SIOCGIFNAME, &request), 0);
  const std::string name = request.ifr_name;
  ASSERT_EQ(run("ip link set " + name + " txqueuelen 10 up"), 0);

  SocketCanPort slcan(name, PortUse::core);
  slcan.receive(frames, now_ns);
  ASSERT_TRUE(slcan.up()) << slcan.problem();
  constexpr std::uint32_t kTries = 20000;
  for (std::uint32_t i = 0; i < kTries && slcan.counters().send_refused < 100; ++i) slcan.send(kCommand, now_ns);
  EXPECT_GE(slcan.counters().send_refused, 100U) << "the queue never filled";
  EXPECT_GT(slcan.counters().sent, 0U);
  EXPECT_TRUE(slcan.up()) << "a full queue is not a bus that is down";
  // Once the device takes frames again, so does the port.
  std::array<char, 4096> drain{};
  std::uint32_t sent = slcan.counters().sent;
  bool again = false;
  for (int i = 0; i < 1000 && !again; ++i) {
    pollfd wait{master, POLLIN, 0};
    if (::poll(&wait, 1, 10) == 1) {
      ASSERT_GT(::read(master, drain.data(), drain.size()), 0);
    }
    slcan.send(kCommand, now_ns);
    again = slcan.counters().sent > sent + 20;
  }
  EXPECT_TRUE(again);
  ::close(slave);
  ::close(master);
}

}  // namespace
}  // namespace hoist::bus
