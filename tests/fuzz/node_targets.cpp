// Frames into the nodes of the bus: SDO, NMT, RPDOs, heartbeats and any others.
#include <algorithm>
#include <array>
#include <cmath>

#include "firmware/nodes/drive/drive_node.hpp"
#include "firmware/nodes/io/io_node.hpp"
#include "firmware/nodes/tilt/tilt_node.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/unit/firmware/test_board.hpp"

namespace hoist::fuzz {
namespace {

using contract::CanFrame;
using contract::Node;

// 0xxxxxxx: so many milliseconds pass; 1xxxxxxx: a frame follows (id in two bytes, DLC, data).
template <class N, class Check>
void feed(N& node, firmware::TestBoard& board, Bytes input, Check&& check) {
  Pieces pieces(input);
  while (!pieces.empty()) {
    const std::uint8_t what = pieces.u8();
    if ((what & 0x80U) == 0) {
      for (int i = 0; i < (what & 0x3F); ++i) {
        node.tick_1ms();
        check();
      }
      continue;
    }
    CanFrame frame{static_cast<std::uint32_t>(pieces.number(2) & 0x7FFU), static_cast<std::uint8_t>(pieces.u8() % 9), 0, {}};
    const Bytes data = pieces.take(frame.dlc);
    std::copy(data.begin(), data.end(), frame.data.begin());
    const std::size_t before = board.sent.size();
    node.on_frame(frame);
    const bool sdo = frame.id == contract::canopen::kSdoRequestBase + node.stack().node_id();
    must(!sdo || board.sent.size() <= before + 1, "a request has at most one answer");
    for (std::size_t i = before; i < board.sent.size(); ++i)
      must(board.sent[i].dlc <= 8 && board.sent[i].id <= 0x7FF, "only frames that can exist are sent");
    check();
    if (board.sent.size() > 1000) board.sent.clear();
  }
}

void append(Input& input, const CanFrame& frame) {
  input.insert(input.end(), {0x80, static_cast<std::uint8_t>(frame.id), static_cast<std::uint8_t>(frame.id >> 8), frame.dlc});
  input.insert(input.end(), frame.data.begin(), frame.data.begin() + frame.dlc);
}

CanFrame sdo(std::uint32_t node, std::initializer_list<int> bytes) { return firmware::frame_of(0x600 + node, bytes); }

}  // namespace

void fuzz_node_frames(Bytes input) {
  if (input.empty()) return;
  firmware::TestBoard board;
  const Bytes rest = input.subspan(1);
  switch (input[0] % 3) {
    case 0: {
      firmware::DriveNode<firmware::TestBoard> node(board, Node::drive_left);
      feed(node, board, rest, [&] {
        must(std::isfinite(board.duty_norm) && std::abs(board.duty_norm) <= 1.0F, "the duty is a share of the supply");
        must(!board.bridge_on || node.stack().state() != contract::canopen::NmtState::boot_up, "a starting drive moves nothing");
      });
      break;
    }
    case 1: {
      firmware::TiltNode<firmware::TestBoard> node(board, Node::tilt_base);
      feed(node, board, rest, [] {});
      break;
    }
    default: {
      firmware::IoNode<firmware::TestBoard> node(board, Node::io);
      feed(node, board, rest, [] {});
    }
  }
}
std::vector<Input> seeds_node_frames() {
  std::vector<Input> seeds;
  const std::array<std::uint32_t, 3> ids{0x01, 0x13, 0x08};
  for (std::uint8_t kind = 0; kind < 3; ++kind) {
    const std::uint32_t id = ids[kind];
    Input input{kind, 0x05};
    append(input, sdo(id, {0x40, 0x18, 0x10, 0x02, 0, 0, 0, 0}));
    append(input, sdo(id, {0x40, 0x08, 0x10, 0x00, 0, 0, 0, 0}));
    append(input, sdo(id, {0x60, 0, 0, 0, 0, 0, 0, 0}));
    append(input, sdo(id, {0x70, 0, 0, 0, 0, 0, 0, 0}));
    append(input, sdo(id, {0x2B, 0x17, 0x10, 0x00, 200, 0, 0, 0}));
    append(input, sdo(id, {0x21, 0x10, 0x10, 0x01, 9, 0, 0, 0}));
    append(input, sdo(id, {0x00, 1, 2, 3, 4, 5, 6, 7}));
    append(input, sdo(id, {0x23, 0x10, 0x10, 0x01, 's', 'a', 'v', 'e'}));
    append(input, sdo(id, {0x80, 0, 0, 0, 0, 0, 0, 8}));
    append(input, contract::canopen::nmt(contract::canopen::NmtCommand::start, 0));
    append(input, firmware::frame_of(0x080, {}));
    append(input, firmware::frame_of(0x77F, {5}));
    input.push_back(0x0A);
    append(input, firmware::frame_of(0x201, {0x06, 0, 0, 0, 0, 0}));
    append(input, firmware::frame_of(0x201, {0x07, 0, 0, 0, 0, 0}));
    append(input, firmware::frame_of(0x201, {0x0F, 0, 0x10, 0x27, 0, 0}));
    input.push_back(0x3F);
    append(input, contract::canopen::nmt(contract::canopen::NmtCommand::reset_node, 0));
    input.push_back(0x10);
    seeds.push_back(input);
  }
  return seeds;
}

}  // namespace hoist::fuzz
