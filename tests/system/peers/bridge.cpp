// A CAN bus made of two pipes: our side of the tests with an independent CANopen stack. One JSON object a line, both ways.
//   peers_bridge node NAME    one of our nodes with a board made of variables, running in real time
//   peers_bridge client       our SDO client
// Frames:   {"id":385,"data":"0011223344556677"} To a node: {"set":"bumpers","value":1}, {"set":"silent","value":1} (stops sending, as if
// switched off) To the client: {"upload":[node,index,sub]}, {"download":[node,index,sub],"data":"0102","segmented":true} From the client:
// {"result":"done","data":"...","code":0}
#include <poll.h>
#include <time.h>
#include <unistd.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "control/bus/sdo_client.hpp"
#include "firmware/nodes/drive/drive_node.hpp"
#include "firmware/nodes/io/io_node.hpp"
#include "firmware/nodes/tilt/tilt_node.hpp"
#include "tests/unit/firmware/test_board.hpp"

namespace {

using hoist::bus::SdoClient;
using hoist::contract::CanFrame;
using nlohmann::json;
using namespace hoist;

constexpr std::uint64_t kMs_ns = 1'000'000;
constexpr std::size_t kLineMax = 4096;

std::uint64_t now_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(now.tv_nsec);
}

std::string hex(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    char two[3];
    std::snprintf(two, sizeof two, "%02x", byte);
    text += two;
  }
  return text;
}
std::vector<std::uint8_t> bytes_of(const std::string& text) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(text.substr(i, 2), nullptr, 16)));
  return bytes;
}
void put(const json& line) {
  std::printf("%s\n", line.dump().c_str());
  std::fflush(stdout);
}
void put_frame(const CanFrame& frame) { put({{"id", frame.id}, {"data", hex(std::span(frame.data).first(frame.dlc))}}); }

// Complete lines of the standard input, waiting at most `wait_ms`. False at its end.
class Lines {
 public:
  template <class OnLine>
  bool poll(int wait_ms, OnLine&& on_line) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (::poll(&input, 1, wait_ms) <= 0) return true;
    char part[kLineMax];
    const ssize_t count = ::read(STDIN_FILENO, part, sizeof part);
    if (count <= 0) return false;
    text_.append(part, static_cast<std::size_t>(count));
    for (std::size_t end = text_.find('\n'); end != std::string::npos; end = text_.find('\n')) {
      on_line(json::parse(text_.substr(0, end)));
      text_.erase(0, end + 1);
    }
    return text_.size() < kLineMax;
  }

 private:
  std::string text_;
};

CanFrame frame_of(const json& line) {
  CanFrame frame;
  frame.id = line.at("id").get<std::uint32_t>();
  const auto bytes = bytes_of(line.at("data").get<std::string>());
  frame.dlc = static_cast<std::uint8_t>(std::min<std::size_t>(8, bytes.size()));
  std::copy_n(bytes.begin(), frame.dlc, frame.data.begin());
  return frame;
}

template <template <class> class NodeOf>
int run_node(contract::Node which) {
  firmware::TestBoard board;
  NodeOf<firmware::TestBoard> node(board, which);
  bool silent = false;
  const auto send = [&] {
    for (const CanFrame& frame : board.sent)
      if (!silent) put_frame(frame);
    board.sent.clear();
  };
  Lines lines;
  std::uint64_t next_ns = now_ns();
  for (;;) {
    const bool more = lines.poll(1, [&](const json& line) {
      if (line.contains("set")) {
        if (line["set"] == "bumpers") board.bumper_bits = line["value"].get<std::uint8_t>();
        if (line["set"] == "silent") silent = line["value"].get<int>() != 0;
      } else if (!silent) {
        node.on_frame(frame_of(line));
      }
      send();
    });
    if (!more) return 0;
    // A computer that was busy makes the node's clock slow, not fast.
    if (now_ns() - next_ns > 20 * kMs_ns) next_ns = now_ns();
    for (; next_ns <= now_ns(); next_ns += kMs_ns) {
      node.tick_1ms();
      send();
    }
  }
}

int run_client() {
  // The peer is another process on a busy computer: longer timeouts than on a bus.
  SdoClient client({.answer_ns = 3'000'000'000, .tries = 1, .pace_ns = 4'300'000});
  std::vector<std::uint8_t> content;
  bool waiting = false;
  Lines lines;
  for (;;) {
    const bool more = lines.poll(1, [&](const json& line) {
      if (line.contains("id")) return client.on_frame(frame_of(line));
      const bool upload = line.contains("upload");
      const json& where = line.at(upload ? "upload" : "download");
      const auto node = where.at(0).get<std::uint8_t>();
      const auto index = where.at(1).get<std::uint16_t>();
      const auto sub = where.at(2).get<std::uint8_t>();
      content = bytes_of(line.value("data", ""));
      waiting = upload ? client.upload(node, index, sub) : client.download(node, index, sub, content, line.value("segmented", false));
      if (!waiting) put({{"result", "refused"}});
    });
    if (!more) return 0;
    if (const auto frame = client.step(now_ns())) put_frame(*frame);
    if (!waiting || client.outcome() == SdoClient::Outcome::busy) continue;
    waiting = false;
    constexpr const char* kNames[] = {"idle", "busy", "done", "aborted", "timed_out", "confused"};
    put({{"result", kNames[static_cast<std::size_t>(client.outcome())]}, {"data", hex(client.uploaded())}, {"code", client.abort_code()}});
  }
}

}  // namespace

int main(int count, char** words) {
  const std::string mode = count > 1 ? words[1] : "";
  if (mode == "client") return run_client();
  if (mode == "node" && count == 3) {
    for (std::size_t i = 0; i < contract::kRemoteNodeCount; ++i) {
      if (contract::kNodes[i].name != words[2]) continue;
      const auto node = static_cast<contract::Node>(i);
      switch (contract::kNodes[i].kind) {
        case contract::NodeKind::drive:
          return run_node<firmware::DriveNode>(node);
        case contract::NodeKind::tilt:
          return run_node<firmware::TiltNode>(node);
        default:
          return run_node<firmware::IoNode>(node);
      }
    }
  }
  std::fputs("usage: peers_bridge node NAME | peers_bridge client\n", stderr);
  return 2;
}
