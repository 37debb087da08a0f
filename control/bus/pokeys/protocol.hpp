// The packets of PoKeys57U and PoKeys57E: 64 bytes each way, the same over USB (HID reports) and UDP.
//
//   request  BBh, command, four parameters, request id, checksum, data from byte 8
//   reply    AAh, command, parameters, the same id, checksum, data from byte 8
// The checksum is the sum of the first seven bytes. From PoLabs' protocol description and the behaviour of its open library.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace hoist::bus::pokeys {

inline constexpr std::size_t kPacketBytes = 64;
using Packet = std::array<std::uint8_t, kPacketBytes>;

inline constexpr std::uint8_t kRequestMark = 0xBB, kReplyMark = 0xAA;
inline constexpr std::size_t kData = 8;  // first byte of the data
inline constexpr std::uint16_t kUdpPort = 20055;
inline constexpr std::uint16_t kUsbVendor = 0x1DC3, kUsbProduct = 0x1001;

enum class CommandCode : std::uint8_t {
  identity = 0x00,       // reply: "PKEx" or "PK58" at byte 8, serial number at 12, device type at 18
  pin_functions = 0xC0,  // parameter 0 reads: one byte for each pin
  // All digital pins, a bit each from byte 8. Parameter 0 reads; 1 first sets the outputs, the request's bits from byte 8, but for the pins
  // whose bit from byte 20 is set. Pins that are no outputs ignore it.
  inputs = 0xCC,
  analogue = 0x3A,  // parameter 1: pins 41 to 47, 16 bits each, high byte first
};

inline constexpr std::uint8_t kPins = 55;                               // numbered from 1
inline constexpr std::uint8_t kFirstAnalogue = 41, kLastAnalogue = 47;  // the pins with a converter
inline constexpr std::uint16_t kAnalogueFull = 4095;                    // 12 bits
// Bits of a pin's function.
inline constexpr std::uint8_t kDigitalInput = 0x02, kDigitalOutput = 0x04, kAnalogueInput = 0x08, kInverted = 0x80;

constexpr std::uint8_t checksum(const Packet& packet) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < 7; ++i) sum += packet[i];
  return static_cast<std::uint8_t>(sum);
}

constexpr Packet make_request(CommandCode command, std::uint8_t parameter, std::uint8_t id) {
  Packet packet{};
  packet[0] = kRequestMark;
  packet[1] = static_cast<std::uint8_t>(command);
  packet[2] = parameter;
  packet[6] = id;
  packet[7] = checksum(packet);
  return packet;
}

/// Reads the inputs and sets this one output.
constexpr Packet make_output_request(std::uint8_t pin, bool on, std::uint8_t id) {
  constexpr std::size_t kUntouched = 20, kPinBytes = 7;
  Packet packet = make_request(CommandCode::inputs, 1, id);
  const auto index = static_cast<std::size_t>(pin - 1);
  const auto bit = static_cast<std::uint8_t>(1U << (index % 8));
  for (std::size_t i = 0; i < kPinBytes; ++i) packet[kUntouched + i] = 0xFF;
  packet[kUntouched + index / 8] = static_cast<std::uint8_t>(0xFFU ^ bit);
  if (on) packet[kData + index / 8] = bit;
  return packet;
}

enum class ReplyCheck : std::uint8_t { good, no_reply, bad_checksum, other_command, other_id };
// Whether `packet` answers the request with this command and id.
constexpr ReplyCheck check_reply(const Packet& packet, CommandCode command, std::uint8_t id) {
  if (packet[0] != kReplyMark) return ReplyCheck::no_reply;
  if (packet[7] != checksum(packet)) return ReplyCheck::bad_checksum;
  if (packet[1] != static_cast<std::uint8_t>(command)) return ReplyCheck::other_command;
  return packet[6] == id ? ReplyCheck::good : ReplyCheck::other_id;
}

// The level of a pin (1 to kPins) in a reply to `inputs`.
constexpr bool pin_level(const Packet& reply, std::uint8_t pin) {
  const auto index = static_cast<std::size_t>(pin - 1);
  return ((reply[kData + index / 8] >> (index % 8)) & 1U) != 0;
}
// Counts of an analogue pin (41 to 47) in a reply to `analogue`.
constexpr std::uint16_t analogue_counts(const Packet& reply, std::uint8_t pin) {
  const std::size_t at = kData + 2U * static_cast<std::size_t>(pin - kFirstAnalogue);
  return static_cast<std::uint16_t>((reply[at] << 8) | reply[at + 1]);
}
constexpr bool is_pokeys(const Packet& identity) {
  const auto reads = [&identity](const char* text) {
    for (std::size_t i = 0; i < 4; ++i)
      if (identity[kData + i] != static_cast<std::uint8_t>(text[i])) return false;
    return true;
  };
  return reads("PKEx") || reads("PK58");
}

}  // namespace hoist::bus::pokeys
