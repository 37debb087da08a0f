#include "control/bus/pokeys/input_port.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <ctime>
#include <set>
#include <utility>

namespace hoist::bus::pokeys {

using contract::CanFrame;

namespace {

constexpr std::uint64_t kNsPerMs = 1'000'000;
constexpr int kLongestWait_ms = 50;
// A voltage in hundredths of a volt; full_v is at most 100 V.
constexpr unsigned kVoltBits = 14;
constexpr std::uint64_t kVoltMask = (1U << kVoltBits) - 1;
constexpr double kFullScaleMax_v = 100.0;
static_assert(kFullScaleMax_v * 100.0 <= static_cast<double>(kVoltMask));

std::uint64_t steady_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(now.tv_nsec);
}

template <std::size_t N>
std::string read_pins(std::string_view name, std::string_view text, std::uint8_t first, std::uint8_t last,
                      std::array<std::uint8_t, N>& pins) {
  std::size_t count = 0;
  const std::string refusal = std::string(name) + ": " + std::to_string(N) + " pins from " + std::to_string(first) + " to " +
                              std::to_string(last) + ", separated by commas, not \"" + std::string(text) + "\"";
  for (const char* at = text.data(); at != text.data() + text.size();) {
    unsigned pin = 0;
    const auto [end, problem] = std::from_chars(at, text.data() + text.size(), pin);
    if (problem != std::errc{} || pin < first || pin > last || count == N) return refusal;
    pins[count++] = static_cast<std::uint8_t>(pin);
    at = end;
    if (at == text.data() + text.size()) break;
    if (*at++ != ',' || at == text.data() + text.size()) return refusal;
  }
  return count == N ? std::string() : refusal;
}

std::string read_wiring(std::string_view text, Wiring& wiring) {
  while (!text.empty()) {
    const std::string_view item = text.substr(0, text.find('&'));
    text.remove_prefix(std::min(text.size(), item.size() + 1));
    const std::size_t equals = item.find('=');
    const std::string_view name = item.substr(0, equals), value = equals == std::string_view::npos ? "" : item.substr(equals + 1);
    std::string problem;
    if (name == "bumpers") {
      problem = read_pins(name, value, 1, kPins, wiring.bumper_pins);
    } else if (name == "switches") {
      problem = read_pins(name, value, 1, kPins, wiring.switch_pins);
    } else if (name == "batteries") {
      problem = read_pins(name, value, kFirstAnalogue, kLastAnalogue, wiring.battery_pins);
    } else if (name == "full_v") {
      const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), wiring.full_scale_v);
      if (error != std::errc{} || end != value.data() + value.size() ||
          !(wiring.full_scale_v >= 3.3 && wiring.full_scale_v <= kFullScaleMax_v))
        problem = "full_v: the battery voltage at the converter's end, 3.3 to 100, not \"" + std::string(value) + "\"";
    } else if (name == "sync") {
      std::array<std::uint8_t, 1> pin{};
      problem = read_pins(name, value, 1, kPins, pin);
      wiring.sync_pin = pin[0];
    } else {
      problem = "\"" + std::string(name) + "\" is none of bumpers, switches, batteries, full_v, sync";
    }
    if (!problem.empty()) return "pokeys: " + problem;
  }
  std::set<std::uint8_t> all;
  std::size_t count = 0;
  if (wiring.sync_pin != 0) count = all.insert(wiring.sync_pin).second ? 1 : 0;
  for (const std::span<const std::uint8_t> pins :
       {std::span<const std::uint8_t>(wiring.bumper_pins), std::span<const std::uint8_t>(wiring.switch_pins),
        std::span<const std::uint8_t>(wiring.battery_pins)}) {
    all.insert(pins.begin(), pins.end());
    count += pins.size();
  }
  return all.size() == count ? std::string() : "pokeys: a pin is used twice";
}

}  // namespace

std::string parse_inputs(std::string_view text, InputOptions& options) {
  constexpr std::string_view kName = "pokeys:", kUdp = "udp:";
  const std::string usage = "inputs: use can, pokeys:usb, pokeys:/dev/hidraw0 or pokeys:udp:HOST, not \"" + std::string(text) + "\"";
  if (!text.starts_with(kName)) return usage;
  std::string_view where = text.substr(kName.size(), text.find('?') - kName.size());
  if (const std::size_t question = text.find('?'); question != std::string_view::npos)
    if (const std::string problem = read_wiring(text.substr(question + 1), options.wiring); !problem.empty()) return problem;
  if (where == "usb") {
    options.transport = std::make_unique<HidrawTransport>("");
  } else if (where.starts_with("/")) {
    options.transport = std::make_unique<HidrawTransport>(std::string(where));
  } else if (where.starts_with(kUdp)) {
    where.remove_prefix(kUdp.size());
    std::uint16_t port = kUdpPort;
    std::string host(where);
    // One colon separates host and port; several mean an IPv6 address.
    if (const std::size_t colon = where.find(':'); colon != std::string_view::npos && where.rfind(':') == colon) {
      host = where.substr(0, colon);
      const std::string_view number = where.substr(colon + 1);
      const auto [end, problem] = std::from_chars(number.data(), number.data() + number.size(), port);
      if (problem != std::errc{} || end != number.data() + number.size() || port == 0)
        return "pokeys: the port is a number from 1 to 65535";
    }
    if (host.empty()) return usage;
    auto transport = std::make_unique<UdpTransport>();
    if (const std::string problem = transport->set_address(host, port); !problem.empty()) return "pokeys: " + problem;
    options.transport = std::move(transport);
  } else {
    return usage;
  }
  return {};
}

InputPort::InputPort(std::unique_ptr<CanPort> port, InputOptions options)
    : port_(std::move(port)), transport_(std::move(options.transport)), device_(*transport_, options.wiring) {
  input_problem_ = device_.problem();
  wake_fd_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  thread_ = std::thread([this, begin = std::move(options.at_thread_start)] {
    if (begin) begin();
    run();
  });
}

InputPort::~InputPort() {
  ending_ = true;
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(wake_fd_, &one, sizeof one);
  thread_.join();
  ::close(wake_fd_);
}

void InputPort::run() {
  while (!ending_.load()) {
    device_.set_sync(sync_.load(std::memory_order_relaxed));
    device_.step(steady_ns());
    publish();
    const std::uint64_t now_ns = steady_ns();
    const std::uint64_t wait_ms = device_.next_ns() > now_ns ? (device_.next_ns() - now_ns + kNsPerMs - 1) / kNsPerMs : 0;
    std::array<pollfd, 2> waits{pollfd{wake_fd_, POLLIN, 0}, pollfd{transport_->descriptor(), POLLIN, 0}};
    ::poll(waits.data(), waits.size(), static_cast<int>(std::min<std::uint64_t>(wait_ms, kLongestWait_ms)));
  }
}

void InputPort::publish() {
  const Readings& now = device_.readings();
  // "Pressed" is stored first: a reader of the newer word sees at least the presses before it.
  pressed_.fetch_or(now.bumpers, std::memory_order_relaxed);
  inputs_word_.store((now.inputs_ns / kNsPerMs) << 16 | static_cast<std::uint64_t>(now.bumpers) << 8 | now.switches,
                     std::memory_order_release);
  batteries_word_.store(
      (now.batteries_ns / kNsPerMs) << (2 * kVoltBits) | static_cast<std::uint64_t>(now.battery_10mv[0]) << kVoltBits | now.battery_10mv[1],
      std::memory_order_release);
  input_problem_.store(device_.problem(), std::memory_order_relaxed);
}

Readings InputPort::latest(std::uint8_t& pressed) noexcept {
  Readings readings;
  const std::uint64_t inputs = inputs_word_.load(std::memory_order_acquire), batteries = batteries_word_.load(std::memory_order_acquire);
  pressed = pressed_.exchange(0, std::memory_order_relaxed);
  readings.inputs_ns = (inputs >> 16) * kNsPerMs;
  readings.bumpers = static_cast<std::uint8_t>(inputs >> 8);
  readings.switches = static_cast<std::uint8_t>(inputs);
  readings.batteries_ns = (batteries >> (2 * kVoltBits)) * kNsPerMs;
  readings.battery_10mv = {static_cast<std::uint16_t>((batteries >> kVoltBits) & kVoltMask),
                           static_cast<std::uint16_t>(batteries & kVoltMask)};
  return readings;
}

void InputPort::copy_counters() noexcept {
  counters_ = port_->counters();
  counters_.refused += doubles_;
  counters_.received -= std::min(counters_.received, doubles_);
}

std::size_t InputPort::receive(std::span<CanFrame> out, std::uint64_t now_ns) noexcept {
  // Space for the stand-in's own frames is reserved.
  const std::size_t room = out.size() > IoStandIn::kFramesMax ? out.size() - IoStandIn::kFramesMax : 0;
  const std::size_t heard = port_->receive(out.first(room), now_ns);
  const auto kept = std::remove_if(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(heard), IoStandIn::is_from_node);
  const auto count = static_cast<std::size_t>(kept - out.begin());
  doubles_ += static_cast<std::uint32_t>(heard - count);
  copy_counters();
  std::uint8_t pressed = 0;
  const Readings readings = latest(pressed);
  return count + stand_in_.step(readings, pressed, now_ns, out.subspan(count));
}

std::size_t InputPort::send(std::span<const CanFrame> frames, std::uint64_t now_ns) noexcept {
  for (const CanFrame& frame : frames) {
    stand_in_.on_frame(frame);
    if (frame.flags == 0 && frame.dlc == contract::pdo_bytes(contract::Pdo::io_rx1) &&
        frame.id == contract::pdo_cob_id(contract::Pdo::io_rx1, IoStandIn::kNode))
      sync_.store((frame.data[0] & contract::canopen::kSyncOutput) != 0, std::memory_order_relaxed);
  }
  // Everything is also sent: requests to the input node do no harm there, and the recording stays complete.
  const std::size_t taken = port_->send(frames, now_ns);
  copy_counters();
  return taken;
}

}  // namespace hoist::bus::pokeys
