#include "server/ws/frame.hpp"

namespace hoist::server {

void begin_frame(std::string& frame, Opcode opcode, std::size_t payload_bytes) {
  frame.reserve(frame.size() + payload_bytes + 10);
  frame.push_back(static_cast<char>(0x80U | static_cast<unsigned>(opcode)));
  const int length_bytes = payload_bytes < 126 ? 0 : payload_bytes <= 0xFFFF ? 2 : 8;
  frame.push_back(static_cast<char>(length_bytes == 0 ? payload_bytes : length_bytes == 2 ? 126 : 127));
  for (int shift = 8 * (length_bytes - 1); shift >= 0; shift -= 8)
    frame.push_back(static_cast<char>((static_cast<std::uint64_t>(payload_bytes) >> shift) & 0xFF));
}

SharedFrame make_frame(Opcode opcode, std::string_view payload) {
  auto frame = std::make_shared<std::string>();
  begin_frame(*frame, opcode, payload.size());
  frame->append(payload);
  return frame;
}

SharedFrame make_close_frame(CloseCode code, std::string_view reason) {
  std::string payload;
  payload.push_back(static_cast<char>(static_cast<unsigned>(code) >> 8));
  payload.push_back(static_cast<char>(static_cast<unsigned>(code) & 0xFF));
  payload.append(reason.substr(0, 120));  // a control frame holds 125 bytes
  return make_frame(Opcode::close, payload);
}

bool valid_utf8(std::string_view text) {
  std::size_t i = 0;
  while (i < text.size()) {
    const auto c = static_cast<unsigned char>(text[i]);
    std::size_t more = 0;
    std::uint32_t point = 0;
    if (c < 0x80) {
      ++i;
      continue;
    } else if (c >= 0xC2 && c <= 0xDF) {
      more = 1;
      point = c & 0x1FU;
    } else if (c >= 0xE0 && c <= 0xEF) {
      more = 2;
      point = c & 0x0FU;
    } else if (c >= 0xF0 && c <= 0xF4) {
      more = 3;
      point = c & 0x07U;
    } else {
      return false;
    }
    if (i + more >= text.size()) return false;
    for (std::size_t k = 1; k <= more; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      if ((next & 0xC0U) != 0x80U) return false;
      point = (point << 6) | (next & 0x3FU);
    }
    const bool overlong = (more == 2 && point < 0x800) || (more == 3 && point < 0x10000);
    if (overlong || point > 0x10FFFF || (point >= 0xD800 && point <= 0xDFFF)) return false;
    i += more + 1;
  }
  return true;
}

bool FrameReader::fail(CloseCode code) {
  failed_ = true;
  error_ = code;
  buffer_.clear();
  message_.clear();
  return false;
}

bool FrameReader::feed(std::string_view bytes, std::vector<Incoming>& out) {
  if (failed_) return false;
  // Whatever arrives is taken apart at once, so what is left over is at most one unfinished frame.
  while (!bytes.empty()) {
    const std::size_t room = kMessageLimit_bytes + 14 - buffer_.size();
    const std::size_t part = bytes.size() < room ? bytes.size() : room;
    buffer_.append(bytes.substr(0, part));
    bytes.remove_prefix(part);
    bool complete = true;
    while (complete)
      if (!take_frame(out, complete)) return false;
  }
  return true;
}

bool FrameReader::take_frame(std::vector<Incoming>& out, bool& complete) {
  complete = false;
  if (buffer_.size() < 2) return true;
  const auto byte = [this](std::size_t i) { return static_cast<unsigned char>(buffer_[i]); };
  const bool final_part = (byte(0) & 0x80U) != 0;
  const unsigned opcode = byte(0) & 0x0FU;
  const bool control = opcode >= 8;
  std::uint64_t size = byte(1) & 0x7FU;
  // Reserved bits belong to extensions, and we agreed to none. A client's frame is always masked.
  if ((byte(0) & 0x70U) != 0 || (byte(1) & 0x80U) == 0) return fail(CloseCode::protocol);
  if (opcode > 10 || (opcode > 2 && opcode < 8)) return fail(CloseCode::protocol);
  if (control && (!final_part || size > 125)) return fail(CloseCode::protocol);
  std::size_t head = 2;
  const int length_bytes = size == 126 ? 2 : size == 127 ? 8 : 0;
  if (buffer_.size() < head + static_cast<std::size_t>(length_bytes)) return true;
  if (length_bytes != 0) {
    size = 0;
    for (int i = 0; i < length_bytes; ++i) size = (size << 8) | byte(head + static_cast<std::size_t>(i));
    head += static_cast<std::size_t>(length_bytes);
    // The shortest form is required.
    if ((length_bytes == 2 && size < 126) || (length_bytes == 8 && size <= 0xFFFF) || (size >> 63) != 0) return fail(CloseCode::protocol);
  }
  if (opcode == 2 && !takes_binary_) return fail(CloseCode::not_text);
  if (opcode == 0 && !in_message_) return fail(CloseCode::protocol);
  if ((opcode == 1 || opcode == 2) && in_message_) return fail(CloseCode::protocol);
  if (!control && size + message_.size() > kMessageLimit_bytes) return fail(CloseCode::too_big);
  if (buffer_.size() < head + 4 + size) return true;
  std::string payload = buffer_.substr(head + 4, size);
  for (std::size_t i = 0; i < payload.size(); ++i) payload[i] = static_cast<char>(payload[i] ^ buffer_[head + (i & 3U)]);
  buffer_.erase(0, head + 4 + size);
  complete = true;
  if (!control) {
    if (opcode != 0) binary_ = opcode == 2;
    in_message_ = !final_part;
    message_ += payload;
    if (!final_part) return true;
    if (!binary_ && !valid_utf8(message_)) return fail(CloseCode::bad_utf8);
    out.push_back({binary_ ? Incoming::Kind::binary : Incoming::Kind::text, std::move(message_)});
    message_.clear();
    return true;
  }
  if (opcode == static_cast<unsigned>(Opcode::close)) {
    if (payload.size() == 1) return fail(CloseCode::protocol);
    if (payload.size() >= 2) {
      const unsigned code = (static_cast<unsigned>(static_cast<unsigned char>(payload[0])) << 8) | static_cast<unsigned char>(payload[1]);
      const bool allowed = (code >= 1000 && code <= 1003) || (code >= 1007 && code <= 1014) || (code >= 3000 && code <= 4999);
      if (!allowed) return fail(CloseCode::protocol);
      if (!valid_utf8(std::string_view(payload).substr(2))) return fail(CloseCode::bad_utf8);
    }
    out.push_back({Incoming::Kind::close, std::move(payload)});
    return true;
  }
  out.push_back({opcode == static_cast<unsigned>(Opcode::ping) ? Incoming::Kind::ping : Incoming::Kind::pong, std::move(payload)});
  return true;
}

}  // namespace hoist::server
