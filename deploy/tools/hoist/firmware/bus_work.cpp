#include "deploy/tools/hoist/firmware/bus_work.hpp"

#include <time.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "control/bus/can_port.hpp"
#include "control/bus/firmware_update.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/firmware/image_file.hpp"

namespace hoist::tool {

namespace {

using bus::FirmwareUpdate;
using contract::CanFrame;
using contract::Node;

constexpr std::uint64_t kStep_ns = 1'000'000;
constexpr std::uint64_t kBusUp_ns = 3'000'000'000;  // after this time the adapter counts as not plugged in
constexpr std::uint64_t kLost_ns = 2'000'000'000;   // timeout of a bus that is lost meanwhile

std::uint64_t steady_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(now.tv_nsec);
}

// A bus that a person has named: reads and writes it once a millisecond.
class Bus {
 public:
  /// Empty when it is there.
  [[nodiscard]] std::string open(const std::string& address) {
    std::string error;
    port_ = bus::open_port(address, error);
    if (!port_) return error;
    const std::uint64_t begin_ns = steady_ns();
    while (!port_->up()) {
      step([](const CanFrame&) {});
      if (steady_ns() - begin_ns > kBusUp_ns) return address + " is not there, or nothing answers: " + port_->problem();
    }
    return {};
  }
  /// What has come goes to on_frame; then a millisecond passes. False when the bus has been away for too long.
  template <class OnFrame>
  bool step(OnFrame&& on_frame) {
    const std::uint64_t now_ns = steady_ns();
    const std::size_t count = port_->receive(frames_, now_ns);
    for (std::size_t i = 0; i < count; ++i) on_frame(frames_[i]);
    if (port_->up()) up_ns_ = now_ns;
    // The port writes in send(), also what it could not write before.
    if (to_send_.dlc != kNothing) {
      if (port_->send(std::span<const CanFrame>(&to_send_, 1), now_ns) == 1 || !port_->up()) to_send_.dlc = kNothing;
    } else {
      port_->send({}, now_ns);
    }
    const timespec pause{0, kStep_ns};
    ::nanosleep(&pause, nullptr);
    return now_ns - up_ns_ < kLost_ns;
  }
  void send(const CanFrame& frame) { to_send_ = frame; }

 private:
  static constexpr std::uint8_t kNothing = 0xFF;
  std::unique_ptr<bus::CanPort> port_;
  std::array<CanFrame, 256> frames_{};
  CanFrame to_send_{0, kNothing, 0, {}};
  std::uint64_t up_ns_ = steady_ns();
};

int refused(const std::string& why) {
  std::fprintf(stderr, "hoist firmware: %s\n", why.c_str());
  return kRefused;
}

std::string program_text(const bus::NodeProgram& program) {
  if (program.crc == 0) return program.in_loader ? "none" : "unpacked";
  return version_text(program.version);
}

// One line that is written over on a terminal, and a line every tenth in a file.
class ProgressLine {
 public:
  void tell(const FirmwareUpdate& updating, std::uint64_t now_ns) {
    if (updating.phase() != phase_) {
      phase_ = updating.phase();
      begin_ns_ = now_ns;
      told_ = -1;
      if (phase_ == FirmwareUpdate::Phase::sending) tries_ = updating.tries();
      if (!updating.over() && phase_ != FirmwareUpdate::Phase::sending) line(std::string(bus::phase_text(phase_)));
    }
    if (phase_ != FirmwareUpdate::Phase::sending) return;
    if (updating.tries() != tries_) {
      tries_ = updating.tries();
      begin_ns_ = now_ns;
      line("a frame was lost: sending again from the beginning");
      told_ = -1;
    }
    const int percent = static_cast<int>(updating.bytes_sent() * 100 / updating.header().length);
    if (percent / (terminal_ ? 1 : 10) == told_) return;
    told_ = percent / (terminal_ ? 1 : 10);
    std::string text = "sending " + std::to_string(percent) + " %";
    if (percent > 0) {
      const double gone_s = static_cast<double>(now_ns - begin_ns_) * 1e-9;
      text += ", about " + std::to_string(static_cast<int>(std::lround(gone_s * (100 - percent) / percent))) + " s left";
    }
    line(text);
  }
  void end() {
    if (open_) std::putchar('\n');
    open_ = false;
  }

 private:
  void line(const std::string& text) {
    if (terminal_)
      std::printf("\r\033[K%s", text.c_str());
    else
      std::printf("%s\n", text.c_str());
    open_ = terminal_;
    std::fflush(stdout);
  }
  bool terminal_ = ::isatty(STDOUT_FILENO) != 0;
  bool open_ = false;
  FirmwareUpdate::Phase phase_ = FirmwareUpdate::Phase::done;
  int told_ = -1, tries_ = 0;
  std::uint64_t begin_ns_ = 0;
};

}  // namespace

int update_node(const std::string& address, Node node, const std::vector<std::uint8_t>& image, bool force) {
  Bus bus;
  if (const std::string why = bus.open(address); !why.empty()) return refused(why);
  FirmwareUpdate updating(image, node, {.force = force});
  ProgressLine progress;
  while (!updating.over()) {
    if (!bus.step([&updating](const CanFrame& frame) { updating.on_frame(frame); })) {
      progress.end();
      return refused("the bus has gone away; run the same command again when it is back");
    }
    const std::uint64_t now_ns = steady_ns();
    if (const auto frame = updating.step(now_ns)) bus.send(*frame);
    progress.tell(updating, now_ns);
  }
  // The last frame, an abort after a timeout, still has to leave.
  bus.step([](const CanFrame&) {});
  progress.end();
  const std::string name(contract::kNodes[static_cast<std::size_t>(node)].name);
  if (updating.failure() != FirmwareUpdate::Failure::none) {
    std::string why = name + ": " + std::string(bus::failure_text(updating.failure()));
    if (updating.failure() == FirmwareUpdate::Failure::older) why += " (it runs " + program_text(updating.before()) + ")";
    if (updating.abort_code() != 0) {
      std::array<char, 32> code{};
      (void)std::snprintf(code.data(), code.size(), " (abort code %08Xh)", static_cast<unsigned>(updating.abort_code()));
      why += code.data();
    }
    return refused(why);
  }
  if (updating.was_there())
    std::printf("%s has run %s already, nothing was changed\n", name.c_str(), version_text(updating.header().version).c_str());
  else
    std::printf("%s runs %s now (before: %s)\n", name.c_str(), version_text(updating.header().version).c_str(),
                program_text(updating.before()).c_str());
  return kDone;
}

int list_nodes(const std::string& address, bool json) {
  Bus bus;
  if (const std::string why = bus.open(address); !why.empty()) return refused(why);
  std::array<bool, contract::kRemoteNodeCount> heard{};
  bool computer = false;
  const auto listen = [&](const CanFrame& frame) {
    computer = computer || frame.id == contract::canopen::kHeartbeatBase + contract::node_id(Node::core);
    for (std::size_t i = 0; i < heard.size(); ++i)
      heard[i] = heard[i] || frame.id == contract::canopen::kHeartbeatBase + contract::node_id(static_cast<Node>(i));
  };
  const std::uint64_t begin_ns = steady_ns();
  while (steady_ns() - begin_ns < FirmwareUpdate::kListen_ns)
    if (!bus.step(listen)) return refused("the bus has gone away");
  // Two SDO clients of one node get each other's answers.
  if (computer) return refused(std::string(bus::failure_text(FirmwareUpdate::Failure::computer_active)));

  if (!json) std::printf("%-12s  %-10s  %-8s  %s\n", "node", "program", "crc", "state");
  for (std::size_t i = 0; i < heard.size(); ++i) {
    bus::NodeProgram program;
    if (heard[i]) {
      bus::ProgramQuery query;
      query.begin(contract::node_id(static_cast<Node>(i)));
      while (query.busy()) {
        if (!bus.step([&query](const CanFrame& frame) { query.on_frame(frame); })) return refused("the bus has gone away");
        if (const auto frame = query.step(steady_ns())) bus.send(*frame);
      }
      program = query.result();
    }
    std::string state = !heard[i]            ? "not on the bus"
                        : !program.answered  ? "on the bus, but does not answer"
                        : !program.in_loader ? "running"
                                             : "in its loader: " + std::string(contract::flash_status_text(program.flash_status));
    if (program.simulated) state += " (simulated)";
    const std::string name(contract::kNodes[i].name);
    const std::string version = program.crc != 0 ? version_text(program.version) : "-";
    if (json) {
      std::printf(R"({"node":"%s","present":%s,"in_loader":%s,"simulated":%s,"version":%s%s%s,"crc":"%08x","state":"%s"})"
                  "\n",
                  name.c_str(), heard[i] ? "true" : "false", program.in_loader ? "true" : "false", program.simulated ? "true" : "false",
                  program.crc != 0 ? "\"" : "", program.crc != 0 ? version.c_str() : "null", program.crc != 0 ? "\"" : "",
                  static_cast<unsigned>(program.crc), state.c_str());
    } else {
      std::array<char, 16> crc{"-"};
      if (program.crc != 0) (void)std::snprintf(crc.data(), crc.size(), "%08x", static_cast<unsigned>(program.crc));
      std::printf("%-12s  %-10s  %-8s  %s\n", name.c_str(), version.c_str(), crc.data(), state.c_str());
    }
  }
  return kDone;
}

}  // namespace hoist::tool
