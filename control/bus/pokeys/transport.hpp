// How 64-byte packets reach a PoKeys device: a HID device of the kernel, a UDP socket, or any descriptor (tests: one end of a socketpair).
// Never blocks.
#pragma once
#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "control/bus/pokeys/protocol.hpp"

namespace hoist::bus::pokeys {

enum class Received : std::uint8_t { nothing, packet, wrong_size, gone };

class Transport {
 public:
  virtual ~Transport() = default;
  // Opens or reopens. Null on success, otherwise a static text, half a sentence.
  virtual const char* open() = 0;
  virtual void close() = 0;
  // False when the device is gone. A packet that cannot be queued is lost; its answer then times out.
  virtual bool send(const Packet& packet) = 0;
  virtual Received receive(Packet& packet) = 0;
  // To wait on; -1 while closed.
  [[nodiscard]] virtual int descriptor() const = 0;
};

// A descriptor owned by the caller, with message boundaries; close() leaves it open.
class DescriptorTransport final : public Transport {
 public:
  explicit DescriptorTransport(int fd) : fd_(fd) {}
  const char* open() override { return fd_ >= 0 ? nullptr : "no descriptor"; }
  void close() override {}
  bool send(const Packet& packet) override;
  Received receive(Packet& packet) override;
  [[nodiscard]] int descriptor() const override { return fd_; }

 private:
  int fd_;
};

class UdpTransport final : public Transport {
 public:
  // Resolves HOST once. Empty when that worked, otherwise the reason.
  std::string set_address(const std::string& host, std::uint16_t port);
  UdpTransport() = default;
  ~UdpTransport() override { close(); }
  UdpTransport(const UdpTransport&) = delete;
  UdpTransport& operator=(const UdpTransport&) = delete;
  const char* open() override;
  void close() override;
  bool send(const Packet& packet) override;
  Received receive(Packet& packet) override;
  [[nodiscard]] int descriptor() const override { return fd_; }

 private:
  sockaddr_storage address_{};
  socklen_t address_size_ = 0;
  int fd_ = -1;
};

class HidrawTransport final : public Transport {
 public:
  // "/dev/hidraw0", or empty: the first HID device with PoKeys' vendor and product number and its communication interface.
  explicit HidrawTransport(std::string path) : path_(std::move(path)) {}
  ~HidrawTransport() override { close(); }
  HidrawTransport(const HidrawTransport&) = delete;
  HidrawTransport& operator=(const HidrawTransport&) = delete;
  const char* open() override;
  void close() override;
  bool send(const Packet& packet) override;
  Received receive(Packet& packet) override;
  [[nodiscard]] int descriptor() const override { return fd_; }

 private:
  const char* try_path(const char* path);
  static constexpr int kSearchedDevices = 32;  // hidraw0 to hidraw31
  std::string path_;
  int fd_ = -1;
};

}  // namespace hoist::bus::pokeys
