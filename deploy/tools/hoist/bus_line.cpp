#include "deploy/tools/hoist/bus_line.hpp"

#include <time.h>

#include <cstdio>

namespace hoist::tool {

namespace {

constexpr std::uint64_t kPatience_ns = 3'000'000'000;  // after this time the adapter counts as not plugged in
constexpr std::uint64_t kGone_ns = 1'000'000'000;      // timeout of a bus that is lost meanwhile

std::uint64_t steady_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(now.tv_nsec);
}

}  // namespace

std::string BusLine::open(const std::string& address) {
  std::string error;
  port_ = bus::open_port(address, error);
  if (!port_) return error;
  const std::uint64_t begin_ns = opened_ns_ = steady_ns();
  while (!port_->up()) {
    step({});
    if (steady_ns() - begin_ns > kPatience_ns) return address + " is not there, or nothing answers: " + port_->problem();
  }
  return {};
}

void BusLine::step(const std::function<void(const contract::CanFrame&)>& on_frame) {
  const std::size_t count = port_->receive(frames_, steady_ns());
  for (std::size_t i = 0; i < count; ++i) {
    client_.on_frame(frames_[i]);
    if (on_frame) on_frame(frames_[i]);
  }
  // One request at most; a port that does not take it leaves it to the client's time-out.
  if (const auto request = client_.step(steady_ns()))
    port_->send(std::span(&*request, 1), steady_ns());
  else
    port_->send({}, steady_ns());
  const timespec pause{0, 1'000'000};
  ::nanosleep(&pause, nullptr);
}

void BusLine::listen(double seconds, const std::function<void(const contract::CanFrame&)>& on_frame) {
  const double end_s = time_s() + seconds;
  while (time_s() < end_s) step(on_frame);
}
double BusLine::time_s() const { return static_cast<double>(steady_ns() - opened_ns_) * 1e-9; }
std::string BusLine::missing() const { return port_->up() ? std::string() : port_->problem(); }

bool BusLine::send(const contract::CanFrame& frame) { return port_->send(std::span(&frame, 1), steady_ns()) == 1; }

bool BusLine::run() {
  gone_ = false;
  std::uint64_t up_ns = steady_ns();
  while (client_.outcome() == bus::SdoClient::Outcome::busy) {
    step({});
    if (port_->up()) up_ns = steady_ns();
    if (steady_ns() - up_ns > kGone_ns) {
      gone_ = true;
      client_.cancel();
      return false;
    }
  }
  // An abort to the node leaves with the next step.
  const bool done = client_.outcome() == bus::SdoClient::Outcome::done;
  if (!done) {
    for (int i = 0; i < 6; ++i) step({});
  }
  return done;
}
bool BusLine::upload(std::uint8_t node_id, std::uint16_t index, std::uint8_t sub) { return client_.upload(node_id, index, sub) && run(); }
bool BusLine::download(std::uint8_t node_id, std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> content) {
  return client_.download(node_id, index, sub, content) && run();
}

std::string BusLine::problem() const {
  using Outcome = bus::SdoClient::Outcome;
  if (gone_) return std::string("the bus went away: ") + port_->problem();
  switch (client_.outcome()) {
    case Outcome::aborted: {
      char code[16];
      std::snprintf(code, sizeof code, "%08Xh", client_.abort_code());
      return std::string("refused by the node: ") + bus::sdo_abort_text(client_.abort_code()) + " (" + code + ")";
    }
    case Outcome::timed_out:
      return "the node does not answer";
    case Outcome::confused:
      return "the node answered with what no server may say";
    default:
      return "not asked";
  }
}

}  // namespace hoist::tool
