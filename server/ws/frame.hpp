// WebSocket frames (RFC 6455), the server's side: frames to send are built once and shared; frames from clients are small, so the reader
// is strict and bounded. Nothing here knows of sockets.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace hoist::server {

using SharedFrame = std::shared_ptr<const std::string>;

enum class Opcode : std::uint8_t { continuation = 0, text = 1, binary = 2, close = 8, ping = 9, pong = 10 };

// Close codes that we send.
enum class CloseCode : std::uint16_t {
  going_away = 1001,
  protocol = 1002,
  not_text = 1003,
  bad_utf8 = 1007,
  policy = 1008,
  too_big = 1009,
  internal = 1011,
  try_later = 1013
};

inline constexpr std::size_t kMessageLimit_bytes = 4096;

[[nodiscard]] SharedFrame make_frame(Opcode opcode, std::string_view payload);
// Appends the header of a frame whose payload of this size is appended next.
void begin_frame(std::string& frame, Opcode opcode, std::size_t payload_bytes);
[[nodiscard]] SharedFrame make_close_frame(CloseCode code, std::string_view reason);
[[nodiscard]] bool valid_utf8(std::string_view text);

struct Incoming {
  enum class Kind : std::uint8_t { text, binary, ping, pong, close };
  Kind kind = Kind::text;
  std::string payload;
};

// Takes bytes in any portions and gives whole messages. After a violation it stays in error and gives nothing more.
class FrameReader {
 public:
  // `takes_binary`: false refuses binary messages, for protocols that have none.
  explicit FrameReader(bool takes_binary = false) : takes_binary_(takes_binary) {}
  // Appends what is complete to `out`. False on a violation: close with `error()`.
  [[nodiscard]] bool feed(std::string_view bytes, std::vector<Incoming>& out);
  [[nodiscard]] CloseCode error() const { return error_; }

 private:
  bool fail(CloseCode code);
  bool take_frame(std::vector<Incoming>& out, bool& complete);

  bool takes_binary_;
  std::string buffer_;
  std::string message_;
  bool binary_ = false;  // of the message under way
  bool in_message_ = false;
  bool failed_ = false;
  CloseCode error_ = CloseCode::protocol;
};

}  // namespace hoist::server
