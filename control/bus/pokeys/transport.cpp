#include "control/bus/pokeys/transport.hpp"

#include <fcntl.h>
#include <linux/hidraw.h>
#include <linux/input.h>
#include <netdb.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace hoist::bus::pokeys {

namespace {

// Reads one message into a buffer larger than a packet, so that a longer one is detected.
Received read_packet(int fd, Packet& packet) {
  std::array<std::uint8_t, 2 * kPacketBytes> buffer;
  const ssize_t got = ::read(fd, buffer.data(), buffer.size());
  // A missing UDP peer answers by ICMP; it may appear later, so the socket stays open.
  if (got < 0) return errno == EAGAIN || errno == EINTR || errno == ECONNREFUSED ? Received::nothing : Received::gone;
  if (static_cast<std::size_t>(got) != kPacketBytes) return Received::wrong_size;
  std::memcpy(packet.data(), buffer.data(), kPacketBytes);
  return Received::packet;
}
bool may_go_on(ssize_t written) { return written >= 0 || errno == EAGAIN || errno == EINTR || errno == ENOBUFS || errno == ECONNREFUSED; }

}  // namespace

bool DescriptorTransport::send(const Packet& packet) {
  return may_go_on(::send(fd_, packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL));
}
Received DescriptorTransport::receive(Packet& packet) {
  std::array<std::uint8_t, 2 * kPacketBytes> buffer;
  const ssize_t got = ::recv(fd_, buffer.data(), buffer.size(), MSG_DONTWAIT);
  if (got < 0) return errno == EAGAIN || errno == EINTR ? Received::nothing : Received::gone;
  if (got == 0) return Received::gone;
  if (static_cast<std::size_t>(got) != kPacketBytes) return Received::wrong_size;
  std::memcpy(packet.data(), buffer.data(), kPacketBytes);
  return Received::packet;
}

std::string UdpTransport::set_address(const std::string& host, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const int problem = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found);
  if (problem != 0 || found == nullptr) return host + ": " + ::gai_strerror(problem);
  std::memcpy(&address_, found->ai_addr, found->ai_addrlen);
  address_size_ = found->ai_addrlen;
  ::freeaddrinfo(found);
  return {};
}
const char* UdpTransport::open() {
  close();
  const int fd = ::socket(address_.ss_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0) return "no network socket can be made";
  // Connected: packets of other hosts never arrive.
  if (::connect(fd, reinterpret_cast<const sockaddr*>(&address_), address_size_) != 0) {
    ::close(fd);
    return "there is no way to its network address";
  }
  fd_ = fd;
  return nullptr;
}
void UdpTransport::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}
bool UdpTransport::send(const Packet& packet) { return may_go_on(::send(fd_, packet.data(), packet.size(), MSG_NOSIGNAL)); }
Received UdpTransport::receive(Packet& packet) { return read_packet(fd_, packet); }

// Of the three HID interfaces (keyboard, communication, joystick) only the second speaks this protocol; its physical path ends in /input1.
const char* HidrawTransport::try_path(const char* path) {
  const int fd = ::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return errno == EACCES ? "the device may not be opened by this user" : "the device is not there";
  hidraw_devinfo info{};
  std::array<char, 256> where{};
  const char* problem = nullptr;
  if (::ioctl(fd, HIDIOCGRAWINFO, &info) != 0) {
    problem = "the device is no HID device";
  } else if (static_cast<std::uint16_t>(info.vendor) != kUsbVendor || static_cast<std::uint16_t>(info.product) != kUsbProduct) {
    problem = "the device is no PoKeys";
  } else if (::ioctl(fd, HIDIOCGRAWPHYS(where.size() - 1), where.data()) > 0) {
    const std::string_view physical = where.data();
    const std::size_t at = physical.rfind("/input");
    if (at != std::string_view::npos && physical.substr(at) != "/input1") problem = "this is the keyboard or joystick part of a PoKeys";
  }
  if (problem != nullptr) {
    ::close(fd);
    return problem;
  }
  fd_ = fd;
  return nullptr;
}
const char* HidrawTransport::open() {
  close();
  if (!path_.empty()) return try_path(path_.c_str());
  for (int i = 0; i < kSearchedDevices; ++i) {
    std::array<char, 32> path{};
    std::snprintf(path.data(), path.size(), "/dev/hidraw%d", i);
    if (try_path(path.data()) == nullptr) return nullptr;
  }
  return "there is no PoKeys on USB";
}
void HidrawTransport::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}
bool HidrawTransport::send(const Packet& packet) {
  std::array<std::uint8_t, kPacketBytes + 1> report{};  // report number 0 goes in front
  std::memcpy(report.data() + 1, packet.data(), packet.size());
  return may_go_on(::write(fd_, report.data(), report.size()));
}
Received HidrawTransport::receive(Packet& packet) { return read_packet(fd_, packet); }

}  // namespace hoist::bus::pokeys
