#include "control/publish/core_link.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <thread>

#include "control/publish/ring.hpp"

namespace hoist::publish {

using contract::CommandSegment;
using contract::StateSegment;

std::unique_ptr<CoreLink> CoreLink::create(const std::string& socket_path, std::uint64_t start_time_ns, std::uint64_t start_utc_ns,
                                           std::string& error, contract::ClockKind clock) {
  std::unique_ptr<CoreLink> link(new CoreLink);
  link->state_ = create_segment("hoist-state", sizeof(StateSegment), error);
  if (!link->state_.mapping) return nullptr;
  link->state().header.clock.store(static_cast<std::uint64_t>(clock), std::memory_order_relaxed);
  write_header(link->state().header, contract::kStateMagic, sizeof(StateSegment), start_time_ns, start_utc_ns);
  if (socket_path.empty()) return link;

  link->socket_path_ = socket_path;
  if (!link->listen(error)) return nullptr;
  return link;
}

bool CoreLink::listen(std::string& error) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (socket_path_.size() >= sizeof address.sun_path) {
    error = "the socket path is longer than " + std::to_string(sizeof address.sun_path - 1) + " characters: " + socket_path_;
    return false;
  }
  std::memcpy(address.sun_path, socket_path_.data(), socket_path_.size());
  const auto* name = reinterpret_cast<const sockaddr*>(&address);
  struct stat there {};
  if (::lstat(socket_path_.c_str(), &there) == 0 && !S_ISSOCK(there.st_mode)) {
    error = socket_path_ + " exists and is no socket: it stays, choose another path";
    return false;
  }
  // A left-over socket of a core that died is taken over; one where a core still listens is not, also when it stands still and its queue is full.
  Descriptor probe(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (probe && (::connect(probe.get(), name, sizeof address) == 0 || errno == EAGAIN)) {
    error = "another hoist-control already listens on " + socket_path_;
    return false;
  }
  ::unlink(socket_path_.c_str());
  Descriptor listener(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  // Only programs of this user attach (serve).
  if (!listener || ::bind(listener.get(), name, sizeof address) != 0 || ::chmod(socket_path_.c_str(), 0600) != 0 ||
      ::lstat(socket_path_.c_str(), &there) != 0 || ::listen(listener.get(), 2) != 0) {
    error = "cannot listen on " + socket_path_ + ": " + std::strerror(errno);
    return false;
  }
  socket_device_ = there.st_dev;
  socket_inode_ = there.st_ino;
  listener_ = std::move(listener);
  return true;
}

bool CoreLink::owns_path() const {
  struct stat there {};
  return ::lstat(socket_path_.c_str(), &there) == 0 && there.st_dev == socket_device_ && there.st_ino == socket_inode_;
}

std::string CoreLink::mend_socket() {
  if (socket_path_.empty() || owns_path()) return {};
  std::string problem;
  if (listen(problem)) {
    socket_problem_.clear();
    return socket_path_ + " was deleted and is there again";
  }
  if (problem == socket_problem_) return {};
  socket_problem_ = problem;
  return "no server can attach: " + problem;
}

CoreLink::~CoreLink() {
  detach();
  if (!socket_path_.empty() && owns_path()) ::unlink(socket_path_.c_str());
}

void CoreLink::publish_tick(const contract::TickRecord& record) noexcept { ring_write(state().ticks, record); }
void CoreLink::publish_event(const contract::Event& event) noexcept { ring_write(state().events, event); }
void CoreLink::publish_bus(const contract::BusRecord& record) noexcept { ring_write(state().bus, record); }
void CoreLink::publish_journal(const contract::JournalStep& step) noexcept { ring_write(state().journal, step); }
void CoreLink::publish_journal(const contract::JournalCommand& command) noexcept { ring_write(state().journal_commands, command); }
void CoreLink::publish_image(const contract::CoreImage& image) noexcept { ring_write(state().images, image); }
void CoreLink::publish_params(const contract::ParamsInForce& params) noexcept { seq_write(state().params, params_number_++, params); }
void CoreLink::publish_loop(const contract::LoopReport& report) noexcept { seq_write(state().loop, loop_number_++, report); }

bool CoreLink::begin() noexcept {
  // Sequentially consistent on both sides: either the helper sees `inside_` before it unmaps, or we see its null pointer.
  inside_.store(true);
  const CommandSegment* offered = offered_.load();
  if (offered == nullptr) {
    current_ = nullptr;
    inside_.store(false);
    return false;
  }
  const std::uint64_t life = offered_life_.load();
  if (life != life_) {
    life_ = life;
    cursor_ = 0;
    drive_sequence_ = 0;
    state().header.commands_taken.store(0, std::memory_order_relaxed);
  }
  current_ = offered;
  return true;
}
void CoreLink::end() noexcept {
  current_ = nullptr;
  inside_.store(false);
}
std::uint64_t CoreLink::heartbeat() const noexcept { return current_ == nullptr ? 0 : current_->heartbeat.load(std::memory_order_relaxed); }
std::size_t CoreLink::read_commands(std::span<contract::Command> out, std::uint64_t& lost) noexcept {
  lost = 0;
  if (current_ == nullptr) return 0;
  const RingRead result = ring_read(current_->commands, cursor_, out);
  lost = result.lost;
  state().header.commands_taken.store(cursor_, std::memory_order_release);
  return result.count;
}
bool CoreLink::read_drive(contract::DriveCommand& command) noexcept {
  if (current_ == nullptr) return false;
  const std::uint64_t sequence = seq_read_retry(current_->drive, command);
  if (sequence == 0 || sequence == drive_sequence_) return false;
  drive_sequence_ = sequence;
  return true;
}

std::uint64_t CoreLink::params(contract::ParamsInForce& params) const { return seq_read_retry(state().params, params); }
void CoreLink::publish_store(const contract::StoreReport& report) noexcept { seq_write(state().store, store_number_++, report); }

void CoreLink::publish_stops_problem(contract::StoreProblem problem) noexcept {
  state().stops_problem.store(static_cast<std::uint64_t>(problem), std::memory_order_relaxed);
}

bool CoreLink::attach(int command_fd, std::string& error) {
  std::shared_ptr<Mapping> mapping = map_segment(command_fd, sizeof(CommandSegment), error);
  if (!mapping) return false;
  error = check_header(mapping->as<CommandSegment>()->header, contract::kCommandMagic, sizeof(CommandSegment));
  if (!error.empty()) return false;
  detach();
  command_ = std::move(mapping);
  offered_life_.fetch_add(1);
  offered_.store(command_->as<CommandSegment>());
  return true;
}

void CoreLink::detach() {
  offered_.store(nullptr);
  // begin()..end() takes microseconds; the control thread never waits for us, we wait for it.
  while (inside_.load()) std::this_thread::yield();
  command_.reset();
}

// A server tries ten times a second: the same refusal is told once.
std::string CoreLink::refused(const std::string& why) {
  if (why == refusal_) return {};
  refusal_ = why;
  return "server refused: " + why;
}

std::string CoreLink::serve(int timeout_ms) {
  if (std::string news = mend_socket(); !news.empty()) return news;
  pollfd wait[2] = {{listener_.get(), POLLIN, 0}, {peer_.get(), POLLIN, 0}};
  if (::poll(wait, peer_ ? 2 : 1, timeout_ms) <= 0) return {};
  if (peer_ && wait[1].revents != 0) {
    // The server sends nothing after the hand-over: any data, and a hang-up, ends the connection.
    detach();
    peer_ = Descriptor();
    return "server detached";
  }
  if ((wait[0].revents & POLLIN) == 0) return {};
  Descriptor peer(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
  if (!peer) return {};
  ucred who{};
  socklen_t size = sizeof who;
  std::string error;
  Hello hello;
  Descriptor command_fd;
  Hello answer{contract::kStateMagic, contract::layout_hash(), 0, {}};
  if (::getsockopt(peer.get(), SOL_SOCKET, SO_PEERCRED, &who, &size) != 0 || (who.uid != ::getuid() && who.uid != 0)) {
    error = "the server runs as another user";
  } else if (!receive_hello(peer.get(), hello, command_fd, 500, error)) {
    // error is set; a core that only probes whether we are alive closes at once and ends here too
    return error == "the other side closed the connection" ? std::string() : refused(error);
  } else if (hello.magic != contract::kCommandMagic || hello.layout_hash != contract::layout_hash()) {
    error = "core and server are different builds: restart both from the same build";
  } else if (peer_) {
    error = "another server is attached";
    answer.accepted = kHelloTaken;
  } else if (attach(command_fd.get(), error)) {
    answer.accepted = 1;
    if (!send_hello(peer.get(), answer, state_.descriptor.get(), error)) {
      detach();
      return refused(error);
    }
    peer_ = std::move(peer);
    refusal_.clear();
    return "server attached";
  }
  std::strncpy(answer.text, error.c_str(), sizeof answer.text - 1);
  std::string ignored;
  send_hello(peer.get(), answer, -1, ignored);
  return refused(error);
}

}  // namespace hoist::publish
