#include "control/publish/segment.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "control/contract/program_version.hpp"

namespace hoist::publish {
namespace {
std::string last_error(const char* what) { return std::string(what) + ": " + std::strerror(errno); }
constexpr int kSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;
constexpr std::size_t kProgramWords = sizeof(contract::SegmentHeader::program) / sizeof(std::uint64_t);
}  // namespace

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  if (this != &other) {
    if (fd_ >= 0) ::close(fd_);
    fd_ = other.release();
  }
  return *this;
}
Descriptor::~Descriptor() {
  if (fd_ >= 0) ::close(fd_);
}
Mapping::~Mapping() { ::munmap(address_, bytes_); }

OwnedSegment create_segment(const char* name, std::size_t bytes, std::string& error) {
  OwnedSegment segment;
  Descriptor fd(::memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!fd || ::ftruncate(fd.get(), static_cast<off_t>(bytes)) != 0) {
    error = last_error("cannot create shared memory");
    return segment;
  }
  // Populated at once, so that the control loop never takes a page fault here.
  void* address = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, fd.get(), 0);
  if (address == MAP_FAILED) {
    error = last_error("cannot map shared memory");
    return segment;
  }
  auto mapping = std::make_shared<Mapping>(address, bytes);
  if (::fcntl(fd.get(), F_ADD_SEALS, kSeals) != 0) {
    error = last_error("cannot seal shared memory");
    return segment;
  }
  segment.descriptor = std::move(fd);
  segment.mapping = std::move(mapping);
  return segment;
}

std::shared_ptr<Mapping> map_segment(int fd, std::size_t bytes, std::string& error) {
  const int seals = ::fcntl(fd, F_GET_SEALS);
  if (seals < 0 || (seals & kSeals) != kSeals) {
    error = "the other side's memory is not sealed";
    return nullptr;
  }
  struct stat status {};
  if (::fstat(fd, &status) != 0 || static_cast<std::size_t>(status.st_size) != bytes) {
    error = "the other side's memory has another size: core and server are different builds";
    return nullptr;
  }
  void* address = ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED | MAP_POPULATE, fd, 0);
  if (address == MAP_FAILED) {
    error = last_error("cannot map the other side's memory");
    return nullptr;
  }
  return std::make_shared<Mapping>(address, bytes);
}

void write_header(contract::SegmentHeader& header, std::uint64_t magic, std::size_t bytes, std::uint64_t start_time_ns,
                  std::uint64_t start_utc_ns) {
  header.layout_hash.store(contract::layout_hash(), std::memory_order_relaxed);
  header.bytes.store(bytes, std::memory_order_relaxed);
  header.writer_pid.store(static_cast<std::uint64_t>(::getpid()), std::memory_order_relaxed);
  header.start_time_ns.store(start_time_ns, std::memory_order_relaxed);
  header.start_utc_ns.store(start_utc_ns, std::memory_order_relaxed);
  std::array<std::uint64_t, kProgramWords> program{};
  const std::string_view version = contract::program_version();
  std::memcpy(program.data(), version.data(), std::min(version.size(), sizeof program));
  for (std::size_t i = 0; i < kProgramWords; ++i) header.program[i].store(program[i], std::memory_order_relaxed);
  header.magic.store(magic, std::memory_order_release);
}
std::string program_of(const contract::SegmentHeader& header) {
  std::array<std::uint64_t, kProgramWords> words{};
  for (std::size_t i = 0; i < kProgramWords; ++i) words[i] = header.program[i].load(std::memory_order_relaxed);
  std::array<char, sizeof words> text{};
  std::memcpy(text.data(), words.data(), text.size());
  const std::string program(text.begin(), std::ranges::find(text, '\0'));
  return std::ranges::all_of(program, [](char c) { return c > ' ' && c <= '~'; }) ? program : std::string();
}

std::string check_header(const contract::SegmentHeader& header, std::uint64_t magic, std::size_t bytes) {
  if (header.magic.load(std::memory_order_acquire) != magic) return "the other side's memory is not a segment of this product";
  if (header.layout_hash.load(std::memory_order_relaxed) != contract::layout_hash() ||
      header.bytes.load(std::memory_order_relaxed) != bytes)
    return "core and server are different builds: restart both from the same build";
  return {};
}

bool send_hello(int socket, const Hello& hello, int fd, std::string& error) {
  Hello copy = hello;
  iovec part{&copy, sizeof copy};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  if (fd >= 0) {
    message.msg_control = control;
    message.msg_controllen = sizeof control;
    cmsghdr* header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(header), &fd, sizeof fd);
  }
  if (::sendmsg(socket, &message, MSG_NOSIGNAL) != static_cast<ssize_t>(sizeof copy)) {
    error = last_error("cannot send the hand-over");
    return false;
  }
  return true;
}

bool receive_hello(int socket, Hello& hello, Descriptor& fd, int timeout_ms, std::string& error) {
  pollfd wait{socket, POLLIN, 0};
  if (::poll(&wait, 1, timeout_ms) != 1) {
    error = "the other side is silent";
    return false;
  }
  iovec part{&hello, sizeof hello};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int) * 4)] = {};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const ssize_t size = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
  for (cmsghdr* header = CMSG_FIRSTHDR(&message); header != nullptr; header = CMSG_NXTHDR(&message, header)) {
    if (header->cmsg_level != SOL_SOCKET || header->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t count = (header->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < count; ++i) {
      int received;
      std::memcpy(&received, CMSG_DATA(header) + i * sizeof(int), sizeof received);
      fd = Descriptor(received);  // a surplus descriptor is closed by the next assignment
    }
  }
  if (size != static_cast<ssize_t>(sizeof hello)) {
    error = size == 0 ? "the other side closed the connection" : "the hand-over has the wrong size: different builds";
    return false;
  }
  hello.text[sizeof hello.text - 1] = '\0';
  return true;
}

}  // namespace hoist::publish
