// Input of the bus back ends: PoKeys packets, lines of a recording, the kernel's error frames, command line arguments.
#include <array>
#include <cstring>
#include <deque>
#include <memory>
#include <string>

#include "control/bus/candump_log.hpp"
#include "control/bus/decode.hpp"
#include "control/bus/pokeys/input_port.hpp"
#include "control/bus/socketcan.hpp"
#include "tests/fuzz/targets.hpp"

namespace hoist::fuzz {
namespace {
namespace pokeys = bus::pokeys;

// A device that answers with the packets of the input, independent of the request.
class Babbler final : public pokeys::Transport {
 public:
  const char* open() override { return nullptr; }
  void close() override {}
  bool send(const pokeys::Packet& packet) override {
    asked = packet;
    return true;
  }
  pokeys::Received receive(pokeys::Packet& packet) override {
    if (waiting.empty()) return pokeys::Received::nothing;
    packet = waiting.front();
    waiting.pop_front();
    return pokeys::Received::packet;
  }
  [[nodiscard]] int descriptor() const override { return -1; }
  pokeys::Packet asked{};
  std::deque<pokeys::Packet> waiting;
};

}  // namespace

void fuzz_pokeys_packets(Bytes input) {
  constexpr std::uint64_t kMs = 1'000'000;
  Babbler line;
  pokeys::Device device(line, {});
  pokeys::IoStandIn node;
  std::uint64_t now_ns = 1000 * kMs;
  for (Pieces pieces(input); !pieces.empty();) {
    // One byte selects how much time passes, and whether the packet answers the present request.
    const std::uint8_t how = pieces.u8();
    now_ns += (how & 0x3FU) * kMs;
    const Bytes bytes = pieces.take(pokeys::kPacketBytes);
    pokeys::Packet packet{};
    std::copy(bytes.begin(), bytes.end(), packet.begin());
    if ((how & 0x40U) != 0) {
      packet[0] = pokeys::kReplyMark;
      packet[1] = line.asked[1];
      packet[6] = line.asked[6];
      packet[7] = pokeys::checksum(packet);
    }
    line.waiting.push_back(packet);
    device.step(now_ns);
    const pokeys::Readings& readings = device.readings();
    must(readings.bumpers <= 0x0F && readings.switches <= 0x0F, "four bumpers and four switches");
    must(readings.inputs_ns <= now_ns && readings.batteries_ns <= now_ns, "no reading comes from the future");
    must(readings.battery_10mv[0] <= 2000 && readings.battery_10mv[1] <= 2000, "no voltage beyond the full scale");
    std::array<contract::CanFrame, pokeys::IoStandIn::kFramesMax> frames{};
    if ((how & 0x80U) != 0) node.on_frame(contract::canopen::nmt(contract::canopen::NmtCommand::start, 8));
    const std::size_t count = node.step(readings, readings.bumpers, now_ns, frames);
    for (std::size_t i = 0; i < count; ++i) {
      must(pokeys::IoStandIn::is_from_node(frames[i]), "the stand-in speaks for its own node only");
      const bool stale = now_ns - readings.inputs_ns >= pokeys::IoStandIn::kStaleNs;
      must(!(stale && frames[i].id == 0x188) || frames[i].data[0] == pokeys::IoStandIn::kAllPressed, "an old answer reads as pressed");
    }
  }
}
std::vector<Input> seeds_pokeys_packets() {
  // Identity, pins as they should be, inputs, analogue values: a device that runs.
  Input good;
  const auto say = [&good](std::uint8_t how, const std::vector<std::pair<std::size_t, std::uint8_t>>& bytes) {
    Input packet(1 + pokeys::kPacketBytes);
    packet[0] = how;
    for (const auto& [at, value] : bytes) packet[1 + at] = value;
    good.insert(good.end(), packet.begin(), packet.end());
  };
  say(0xC1, {});
  say(0xC1, {{8, 'P'}, {9, 'K'}, {10, 'E'}, {11, 'x'}});
  say(0xC1, {{8, 2}, {9, 2}, {10, 2}, {11, 2}, {12, 2}, {13, 2}, {14, 2}, {15, 2}, {48, 8}, {49, 8}});
  say(0xC1, {{8, 0x05}});
  say(0xC1, {{8, 0x0A}, {9, 0x00}, {10, 0x0A}, {11, 0x10}});
  return {good};
}

void fuzz_candump_log(Bytes input) {
  const std::string_view all(reinterpret_cast<const char*>(input.data()), input.size());
  for (std::size_t at = 0; at <= all.size();) {
    const std::size_t end = std::min(all.find('\n', at), all.size());
    bus::LogEntry entry;
    if (bus::parse_log_line(all.substr(at, end - at), entry) == nullptr) {
      must(entry.frame.dlc <= 8, "a frame has at most eight bytes");
      std::array<char, bus::kLogLineMax> line{};
      const std::size_t size = bus::format_log_line(entry, line);
      must(size > 1, "what was read can be written");
      bus::LogEntry again;
      must(bus::parse_log_line({line.data(), size - 1}, again) == nullptr && again == entry, "and reads the same");
      static_cast<void>(bus::decode_frame(entry.frame));
    }
    at = end + 1;
  }
}
std::vector<Input> seeds_candump_log() {
  return {input_of("(1436509052.249713) can0 191#E80318FC032A R\n(1436509052.250000) can0 201#0F00E8030000 T\n"),
          input_of("(1.000000) can0 12345678#R4\n(1.000001) can0 20000040#0004000000000000\n(1.000002) can0 080#\n"),
          input_of("(1.000000) can0 601#4018100200000000\n(1.000000) can0 581#4318100203000080\n(1.000000) can0 000#0108")};
}

void fuzz_can_errors(Bytes input) {
  bus::SocketCanPort port("none", bus::PortUse::core);
  std::uint32_t offs = 0, overflows = 0, errors = 0, number = 0;
  for (Pieces pieces(input); !pieces.empty(); ++number) {
    can_frame frame{};
    frame.can_id = static_cast<canid_t>(pieces.number(4)) | CAN_ERR_FLAG;
    frame.can_dlc = pieces.u8() % 9;
    const Bytes bytes = pieces.take(8);
    std::copy(bytes.begin(), bytes.end(), frame.data);
    port.on_error_frame(frame);
    const bus::PortCounters& now = port.counters();
    must(now.bus_offs - offs <= 1 && now.overflows - overflows <= 1 && now.bus_errors - errors <= 1, "one report counts once");
    must(now.tx_errors <= 255 && now.rx_errors <= 255, "the controller's counters have eight bits");
    must(!port.up(), "an error report opens no port");
    offs = now.bus_offs;
    overflows = now.overflows;
    errors = now.bus_errors;
  }
}
std::vector<Input> seeds_can_errors() {
  return {Input{0x40, 0, 0, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0x00, 1, 0, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0},
          Input{0x04, 2, 0, 0, 8, 0, 0x20, 0, 0, 0, 0, 130, 1}, Input{0x04, 0, 0, 0, 8, 0, 0x40, 0, 0, 0, 0, 0, 0}};
}

void fuzz_bus_words(Bytes input) {
  const std::string text(reinterpret_cast<const char*>(input.data()), input.size());
  // Names are looked up by the system's resolver, which is not under test here.
  if (text.find("udp") != std::string::npos) return;
  pokeys::InputOptions options;
  const bool good = pokeys::parse_inputs(text, options).empty();
  must(good == (options.transport != nullptr), "a way to the device exactly when the words are good");
  if (!good) return;
  for (const std::uint8_t pin : options.wiring.bumper_pins) must(pin >= 1 && pin <= pokeys::kPins, "a pin that exists");
  must(options.wiring.full_scale_v >= 3.3 && options.wiring.full_scale_v <= 100.0, "a voltage within its range");
}
std::vector<Input> seeds_bus_words() {
  return {input_of("pokeys:usb"), input_of("pokeys:/dev/hidraw0?bumpers=1,2,3,4&switches=5,6,7,8&batteries=41,42&full_v=20"),
          input_of("pokeys:usb?batteries=43,44&full_v=33.5")};
}

}  // namespace hoist::fuzz
