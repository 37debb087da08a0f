#include "control/publish/server_link.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <cerrno>
#include <chrono>
#include <cstring>

#include "control/publish/core_link.hpp"

namespace hoist::publish {

using contract::CommandSegment;
using contract::StateSegment;

namespace {
std::uint64_t steady_now_ns() {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count());
}
constexpr std::uint64_t kTryEachNs = 100'000'000;
constexpr const char* kSilent = "the core does not answer";
}  // namespace

ServerLink::ServerLink(std::string socket_path) : socket_path_(std::move(socket_path)) {}

bool ServerLink::fail(LinkProblem problem) {
  problem_ = problem;
  return false;
}

bool ServerLink::create_commands() {
  offered_ = create_segment("hoist-commands", sizeof(CommandSegment), error_);
  if (!offered_.mapping) return fail(LinkProblem::unreachable);
  write_header(offered_.mapping->as<CommandSegment>()->header, contract::kCommandMagic, sizeof(CommandSegment), steady_now_ns(), 0);
  return true;
}

void ServerLink::adopt(std::shared_ptr<Mapping> state) {
  command_ = std::move(offered_);
  sent_ = 0;
  driven_ = 0;
  const auto& header = state->as<const StateSegment>()->header;
  life_ = header.start_time_ns.load(std::memory_order_relaxed);
  start_utc_ns_ = static_cast<std::int64_t>(header.start_utc_ns.load(std::memory_order_relaxed));
  simulated_clock_ = is_simulated_clock(header);
  program_ = program_of(header);
  state_ = std::move(state);
  shared_->set(state_);
  error_.clear();
}

void ServerLink::lose() {
  peer_ = Descriptor();
  command_ = OwnedSegment();
  error_ = "the core has gone away";
  fail(LinkProblem::gone);
}

bool ServerLink::poll_connect() {
  if (peer_) {
    char byte;
    const ssize_t got = ::recv(peer_.get(), &byte, 1, MSG_DONTWAIT | MSG_PEEK);
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)) lose();
    if (peer_) return true;
  }
  if (!asked_) {
    const std::uint64_t now = steady_now_ns();
    if (now < next_try_ns_) return false;
    next_try_ns_ = now + kTryEachNs;
    if (!ask()) return false;
  }
  return take_answer();
}

bool ServerLink::ask() {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (socket_path_.size() >= sizeof address.sun_path) {
    error_ = "the socket path is too long: " + socket_path_;
    return fail(LinkProblem::unreachable);
  }
  std::memcpy(address.sun_path, socket_path_.data(), socket_path_.size());
  // Never blocks: beside a core that stands still its queue of connections fills up, and a blocking connect would wait for ever.
  Descriptor socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket || ::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    const bool silent = errno == EAGAIN;
    error_ = silent ? kSilent : "no core listens on " + socket_path_;
    return fail(silent ? LinkProblem::silent : LinkProblem::absent);
  }
  if (!create_commands()) return false;
  const Hello hello{contract::kCommandMagic, contract::layout_hash(), 0, {}};
  if (!send_hello(socket.get(), hello, offered_.descriptor.get(), error_)) return fail(LinkProblem::unreachable);
  asked_ = std::move(socket);
  asked_ns_ = steady_now_ns();
  return true;
}

bool ServerLink::take_answer() {
  pollfd wait{asked_.get(), POLLIN, 0};
  if (::poll(&wait, 1, 0) != 1) {
    // The sentence before stays while the answer may still come, so that a refusal that repeats is one.
    if (steady_now_ns() - asked_ns_ < kTryEachNs) return false;
    error_ = kSilent;
    return fail(LinkProblem::silent);
  }
  Descriptor socket = std::move(asked_);
  Hello answer;
  Descriptor state_fd;
  if (!receive_hello(socket.get(), answer, state_fd, 0, error_)) return fail(LinkProblem::unreachable);
  if (answer.accepted != 1) {
    error_ = std::string("the core refused: ") + answer.text;
    if (answer.layout_hash != contract::layout_hash()) return fail(LinkProblem::other_build);
    return fail(answer.accepted == kHelloTaken ? LinkProblem::taken : LinkProblem::refused);
  }
  std::shared_ptr<Mapping> state = map_segment(state_fd.get(), sizeof(StateSegment), error_);
  if (!state) return fail(LinkProblem::unreachable);
  error_ = check_header(state->as<const StateSegment>()->header, contract::kStateMagic, sizeof(StateSegment));
  if (!error_.empty()) return fail(LinkProblem::other_build);
  adopt(std::move(state));
  peer_ = std::move(socket);
  return true;
}

bool ServerLink::attach_directly(CoreLink& core, std::string& error) {
  if (!create_commands()) {
    error = error_;
    return false;
  }
  if (!core.attach(offered_.descriptor.get(), error)) return false;
  std::shared_ptr<Mapping> state = map_segment(core.state_descriptor(), sizeof(StateSegment), error);
  if (!state) return false;
  adopt(std::move(state));
  return true;
}

void ServerLink::beat() noexcept {
  if (command_.mapping) command_.mapping->as<CommandSegment>()->heartbeat.fetch_add(1, std::memory_order_relaxed);
}

std::uint64_t ServerLink::send(contract::Command& command) noexcept {
  if (!command_.mapping || !state_) return 0;
  const std::uint64_t taken = state_->as<const StateSegment>()->header.commands_taken.load(std::memory_order_acquire);
  const std::size_t kept = command.kind == contract::CommandKind::stop ? 0 : kSlotsForStop;
  if (sent_ - taken >= contract::kCommandSlots - kept) return 0;
  command.sequence = ++sent_;
  newest_stop_ = command.kind == contract::CommandKind::stop ? command.request_id : 0;
  ring_write(command_.mapping->as<CommandSegment>()->commands, command);
  return sent_;
}

std::uint32_t ServerLink::untaken_stop() const noexcept {
  if (!command_.mapping || !state_) return 0;
  const std::uint64_t taken = state_->as<const StateSegment>()->header.commands_taken.load(std::memory_order_acquire);
  return taken < sent_ ? newest_stop_ : 0;
}

void ServerLink::drive(const contract::DriveCommand& command) noexcept {
  if (command_.mapping) seq_write(command_.mapping->as<CommandSegment>()->drive, driven_++, command);
}

std::uint64_t ServerLink::params(contract::ParamsInForce& params) const {
  return state_ ? seq_read_retry(state_->as<const StateSegment>()->params, params) : 0;
}

std::uint64_t ServerLink::params_sequence() const { return state_ ? seq_newest(state_->as<const StateSegment>()->params) : 0; }

bool ServerLink::store(contract::StoreReport& report) const {
  return state_ && seq_read_retry(state_->as<const StateSegment>()->store, report) != 0;
}

contract::StoreProblem ServerLink::stops_problem() const {
  if (!state_) return contract::StoreProblem::none;
  return static_cast<contract::StoreProblem>(state_->as<const StateSegment>()->stops_problem.load(std::memory_order_relaxed));
}

bool ServerLink::newest(contract::TickRecord& record) const {
  return state_ && ring_newest(state_->as<const StateSegment>()->ticks, record);
}

bool ServerLink::loop(contract::LoopReport& report) const {
  return state_ && seq_read_retry(state_->as<const StateSegment>()->loop, report) != 0;
}

}  // namespace hoist::publish
