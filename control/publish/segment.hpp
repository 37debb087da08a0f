// Sealed shared memory between two processes of this machine, and the Unix socket over which it changes hands.
//
// A segment is a memfd of fixed size. Its writer maps it, then seals it against shrinking, growing, new writable mappings and further
// sealing. So the other side can neither alter it nor be killed by it (a shrunk file would raise SIGBUS in its reader).
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "control/contract/shared_memory.hpp"

namespace hoist::publish {

// An open file descriptor, closed when it goes.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(other.release()) {}
  Descriptor& operator=(Descriptor&& other) noexcept;
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor();
  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] explicit operator bool() const { return fd_ >= 0; }
  int release() {
    const int fd = fd_;
    fd_ = -1;
    return fd;
  }

 private:
  int fd_ = -1;
};

// A mapping of a whole segment; unmapped when the last user lets go.
class Mapping {
 public:
  Mapping(void* address, std::size_t bytes) : address_(address), bytes_(bytes) {}
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  ~Mapping();
  template <typename Segment>
  [[nodiscard]] Segment* as() const {
    return static_cast<Segment*>(address_);
  }

 private:
  void* address_;
  std::size_t bytes_;
};

struct OwnedSegment {
  Descriptor descriptor;  // to hand over
  std::shared_ptr<Mapping> mapping;
};
// Creates, maps writable and seals a zeroed segment. On failure `mapping` is null and `error` says why.
OwnedSegment create_segment(const char* name, std::size_t bytes, std::string& error);
// Maps another program's segment read-only, after checking its size and seals. Null on refusal, with the reason in `error`.
std::shared_ptr<Mapping> map_segment(int fd, std::size_t bytes, std::string& error);

// Fills the header; the magic goes last, so that a reader that sees it sees all.
void write_header(contract::SegmentHeader& header, std::uint64_t magic, std::size_t bytes, std::uint64_t start_time_ns,
                  std::uint64_t start_utc_ns);
// The writer's program_version(); empty when it is no plain text.
std::string program_of(const contract::SegmentHeader& header);
// Empty when the header is of this build, otherwise the reason for people.
std::string check_header(const contract::SegmentHeader& header, std::uint64_t magic, std::size_t bytes);

inline bool is_simulated_clock(const contract::SegmentHeader& header) {
  return header.clock.load(std::memory_order_relaxed) == static_cast<std::uint64_t>(contract::ClockKind::simulated);
}

// The hand-over: one message each way with one descriptor attached.
inline constexpr std::uint64_t kHelloTaken = 2;
struct Hello {
  std::uint64_t magic = 0;
  std::uint64_t layout_hash = 0;
  std::uint64_t accepted = 0;  // in the answer: 1, else the reason is in `text`; kHelloTaken: another server is attached
  char text[104] = {};
};
static_assert(sizeof(Hello) == 128);
bool send_hello(int socket, const Hello& hello, int fd, std::string& error);
// Waits at most `timeout_ms`. Returns false on a closed, silent or malformed peer.
bool receive_hello(int socket, Hello& hello, Descriptor& fd, int timeout_ms, std::string& error);

}  // namespace hoist::publish
