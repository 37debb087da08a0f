// Lines and frames: the SLCAN codec and the gateway behind a serial line.
#include <algorithm>
#include <array>
#include <string>

#include "control/contract/slcan_codec.hpp"
#include "firmware/nodes/gateway/gateway_node.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/unit/firmware/test_board.hpp"

namespace hoist::fuzz {
namespace {

std::string decoded(std::string_view text, std::size_t piece) {
  contract::SlcanDecoder decoder;
  std::string seen;
  for (std::size_t at = 0; at < text.size(); at += piece) {
    const std::string_view part = text.substr(at, piece);
    decoder.feed(std::span<const char>(part.data(), part.size()), [&seen](const contract::SlcanLine& line) {
      seen += static_cast<char>('0' + static_cast<int>(line.kind));
      if (line.kind != contract::SlcanKind::frame) return;
      std::array<char, contract::kSlcanLineMax> out{};
      const std::size_t length = contract::slcan_encode(line.frame, out, line.stamp_ms);
      must(length > 0, "a frame that was read can be written");
      const contract::SlcanLine again = contract::slcan_parse({out.data(), length - 1});
      must(again.kind == contract::SlcanKind::frame && again.frame == line.frame && again.stamp_ms == line.stamp_ms,
           "a frame that was written is read as the same frame");
      seen.append(out.data(), length);
    });
  }
  return seen;
}

}  // namespace

void fuzz_slcan_lines(Bytes input) {
  const std::string text(input.begin(), input.end());
  const std::string whole = decoded(text, text.size() + 1);
  must(whole == decoded(text, 1), "how the stream is cut does not matter (1)");
  must(whole == decoded(text, 7), "how the stream is cut does not matter (7)");
}
std::vector<Input> seeds_slcan_lines() {
  return {input_of("t1818AABBCCDDEEFF0011\rt0800\rT1234567881122334455667788\rr0800\rR000000010\r"), input_of("t1912ABCD1234\r\r\az\rZ\r"),
          input_of("sb256007\re1a\rV1013\rC\rS5\rO\rF\rN1234\rM00000000\r"), input_of("t1238112233\rt12391122\rt12\r")};
}

void fuzz_gateway_serial(Bytes input) {
  firmware::TestBoard board;
  firmware::GatewayNode<firmware::TestBoard> gateway(board);
  Pieces pieces(input);
  while (!pieces.empty()) {
    const std::uint8_t what = pieces.u8();
    if ((what & 0x80U) != 0) {  // a frame from the bus
      contract::CanFrame frame{static_cast<std::uint32_t>(pieces.number(2)), pieces.u8(), 0, {}};
      const Bytes data = pieces.take(8);
      std::copy(data.begin(), data.end(), frame.data.begin());
      if (frame.id <= 0x7FF && frame.dlc <= 8) gateway.on_frame(frame);
    } else {
      const Bytes text = pieces.take(what & 0x3FU);
      board.from_host.append(text.begin(), text.end());
    }
    gateway.tick_1ms();
    for (const contract::CanFrame& frame : board.sent)
      must(frame.dlc <= 8 && frame.id <= ((frame.flags & contract::CanFrame::kExtended) != 0 ? 0x1FFFFFFFU : 0x7FFU),
           "only frames that can exist reach the bus");
    board.sent.clear();
    contract::SlcanDecoder decoder;
    decoder.feed(std::span<const char>(board.to_host.data(), board.to_host.size()), [](const contract::SlcanLine& line) {
      must(line.kind != contract::SlcanKind::refused, "the gateway never answers nonsense");
    });
    if (board.to_host.empty() || board.to_host.back() == '\r' || board.to_host.back() == '\a') board.to_host.clear();
  }
}
std::vector<Input> seeds_gateway_serial() {
  const auto host = [](std::string_view text) {
    Input input{static_cast<std::uint8_t>(text.size())};
    input.insert(input.end(), text.begin(), text.end());
    return input;
  };
  Input session = host("\rC\rS5\rO\r");
  for (const Input& part :
       {host("t0800\rt20160F0010270000\r"), Input{0x80, 0x81, 0x01, 8, 1, 2, 3, 4, 5, 6, 7, 8}, host("F\rV\rN\rO\rC\r")})
    session.insert(session.end(), part.begin(), part.end());
  return {session, host("S9\rO\rt0809\rU1\rZ1\rX1\rP\rA\rL\r")};
}

}  // namespace hoist::fuzz
