#include "firmware/sim/pokeys_device.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

namespace hoist::sim {

PokeysDevice::~PokeysDevice() {
  if (fd_ >= 0) ::close(fd_);
}

bool PokeysDevice::answer(std::span<const std::uint8_t, kPacket> request, const Pins& pins, std::span<std::uint8_t, kPacket> reply) {
  std::uint8_t sum = 0;
  for (std::size_t i = 0; i < 7; ++i) sum = static_cast<std::uint8_t>(sum + request[i]);
  if (request[0] != 0xBB || request[7] != sum) return false;
  std::fill(reply.begin(), reply.end(), std::uint8_t{0});
  std::copy_n(request.begin(), 7, reply.begin());
  reply[0] = 0xAA;
  switch (request[1]) {
    case 0x00: {  // who are you
      constexpr std::uint8_t kIdentity[] = {'P', 'K', 'E', 'x', 0xD2, 0x04, 0, 0, 0, 0, 31};
      reply[4] = 0x37;
      reply[5] = 0x05;
      std::copy(std::begin(kIdentity), std::end(kIdentity), reply.begin() + 8);
      break;
    }
    case 0xC0:  // pin functions: two digital inputs of four, an output, two analogue ones
      if (request[2] != 0) return false;
      std::fill_n(reply.begin() + 8, 8, std::uint8_t{2});
      reply[8 + 8] = 4;
      reply[8 + 40] = reply[8 + 41] = 8;
      break;
    case 0xCC:
      if (request[2] > 1) return false;
      // Pin 9 is bit 0 of the second byte; the bytes from 20 on say which pins stay as they are.
      if (request[2] == 1 && (request[21] & 1U) == 0) output_ = (request[9] & 1U) != 0;
      reply[8] = static_cast<std::uint8_t>((pins.bumpers & 0x0FU) | (static_cast<unsigned>(pins.switches) << 4));
      break;
    case 0x3A:
      for (std::size_t i = 0; i < pins.battery_v.size(); ++i) {
        const double counts = std::clamp(std::round(pins.battery_v[i] / kFullScale_v * 4095.0), 0.0, 4095.0);
        const auto raw = static_cast<unsigned>(counts);
        reply[8 + 2 * i] = static_cast<std::uint8_t>(raw >> 8);
        reply[9 + 2 * i] = static_cast<std::uint8_t>(raw);
      }
      break;
    default:
      return false;
  }
  sum = 0;
  for (std::size_t i = 0; i < 7; ++i) sum = static_cast<std::uint8_t>(sum + reply[i]);
  reply[7] = sum;
  return true;
}

std::string PokeysDevice::open(std::uint16_t port) {
  fd_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (fd_ < 0 || ::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return "--pokeys-udp: " + std::string(std::strerror(errno));
  return {};
}

void PokeysDevice::serve(const Pins& pins) {
  if (fd_ < 0) return;
  for (int i = 0; i < kPacketsPerCall; ++i) {
    std::array<std::uint8_t, 2 * kPacket> request{};
    sockaddr_storage from{};
    socklen_t from_size = sizeof from;
    const ssize_t got = ::recvfrom(fd_, request.data(), request.size(), 0, reinterpret_cast<sockaddr*>(&from), &from_size);
    if (got < 0) return;
    std::array<std::uint8_t, kPacket> reply{};
    if (silent_ || got != static_cast<ssize_t>(kPacket)) continue;
    if (answer(std::span<const std::uint8_t, kPacket>(request.data(), kPacket), pins, reply)) [[maybe_unused]]
      const ssize_t sent = ::sendto(fd_, reply.data(), reply.size(), 0, reinterpret_cast<const sockaddr*>(&from), from_size);
  }
}

}  // namespace hoist::sim
