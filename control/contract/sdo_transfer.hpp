// The client's side of SDO (CiA 301, 7.2.4), for the core and for the tools: without I/O, heap and clock. Frames in, at most one frame out per
// step(), time as nanoseconds. Expedited and segmented, both directions, one transfer at a time.
//
// A lost request or answer is repeated. A lost answer to a segment cannot be: its toggle bit would be wrong, so the
// transfer is aborted and begun again. Writes must be repeatable; for those that are not, the caller allows one try.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "control/contract/can_dictionary.hpp"

namespace hoist::contract {

struct SdoTiming {
  std::uint64_t answer_ns = 100'000'000;  // longer than the worst answer of the load plan (27 ms) and the host's own delays
  int tries = 3;                          // of a whole transfer
  std::uint64_t pace_ns = 4'300'000;      // between two requests: keeps service data within its 25 % of the bus
};

// `kUploadMost`: bytes; longer uploads are refused with 05040005h. A client of words (4) takes none in segments: a node sends a word expedited, so an
// answer that announces segments was damaged on the way.
template <std::size_t kUploadMost>
class SdoTransfer {
 public:
  using SdoAbort = canopen::SdoAbort;
  enum class Outcome : std::uint8_t {
    idle,
    busy,
    done,
    aborted,    // by the node: see abort_code()
    timed_out,  // the node did not answer, `tries` times
    confused,   // the node's answer was invalid: abort_code() is what it was sent
  };
  static constexpr std::size_t kUploadMax = kUploadMost;

  explicit SdoTransfer(SdoTiming timing = {}) : timing_(timing) {}

  // Both begin a transfer and drop one that is under way. A node id outside of 1 to 127 or an empty content is refused: false.
  [[nodiscard]] bool upload(std::uint8_t node_id, std::uint16_t index, std::uint8_t sub) {
    return begin(node_id, index, sub, Kind::upload, {});
  }
  // Up to four bytes travel expedited unless `segmented` is asked for. What travels segmented must live as long as the transfer.
  [[nodiscard]] bool download(std::uint8_t node_id, std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> content,
                              bool segmented = false) {
    if (content.empty()) return false;
    return begin(node_id, index, sub, content.size() <= 4 && !segmented ? Kind::expedited : Kind::segmented, content);
  }
  // Tells the node, if a transfer is under way, that the client does not continue.
  void cancel(SdoAbort why = SdoAbort::transfer) {
    if (outcome_ == Outcome::busy) give_up(Outcome::aborted, why);
  }
  void set_timing(const SdoTiming& timing) { timing_ = timing; }

  [[nodiscard]] Outcome outcome() const { return outcome_; }
  [[nodiscard]] std::uint32_t abort_code() const { return abort_code_; }
  [[nodiscard]] std::span<const std::uint8_t> uploaded() const { return std::span(buffer_).first(done_upload_); }
  // The first four bytes of what was uploaded, little endian, zero extended.
  [[nodiscard]] std::uint32_t value() const { return read_le(buffer_.data(), std::min<std::size_t>(4, done_upload_)); }
  [[nodiscard]] std::size_t confirmed() const { return confirmed_; }  // bytes that the node has acknowledged in this try

  // The frame to send now, if there is one.
  [[nodiscard]] std::optional<CanFrame> step(std::uint64_t now_ns) {
    if (outcome_ == Outcome::busy && !to_send_ && now_ns - sent_ns_ >= timing_.answer_ns) on_silence();
    if (!to_send_ || (sent_once_ && now_ns - sent_ns_ < timing_.pace_ns)) return std::nullopt;
    to_send_ = false;
    sent_once_ = true;
    sent_ns_ = now_ns;
    if (!then_begin_) return request_;
    // The abort that ended the last try leaves now; the next try begins a pace later.
    then_begin_ = false;
    const CanFrame abort = request_;
    make_first_request();
    return abort;
  }

  void on_frame(const CanFrame& frame) {
    if (outcome_ != Outcome::busy || to_send_ || frame.flags != 0 || frame.id != canopen::kSdoReplyBase + node_id_) return;
    if (frame.dlc != 8) return give_up(Outcome::confused, SdoAbort::command);
    const std::uint8_t command = frame.data[0];
    const bool names_it = read_le(&frame.data[1], 2) == index_ && frame.data[3] == sub_;
    if (command == canopen::kSdoAbort) {
      // A server that has lost its state aborts with the object 0:0. Any other object belongs to an earlier transfer.
      if (!names_it && read_le(&frame.data[1], 3) != 0) return;
      abort_code_ = read_le(&frame.data[4], 4);
      outcome_ = Outcome::aborted;
      return;
    }
    const bool begins = (command & 0xE0U) == 0x40U || (command & 0xE0U) == 0x60U;
    if (begins && (!names_it || in_segments_)) return;  // a late answer to a repeated request
    switch (kind_) {
      case Kind::upload:
        return in_segments_ ? on_upload_segment(frame) : on_upload_begun(frame);
      case Kind::expedited:
        if (command != canopen::kSdoDownloadReply) return give_up(Outcome::confused, SdoAbort::command);
        confirmed_ = bytes_;
        outcome_ = Outcome::done;
        return;
      case Kind::segmented:
        return on_download_answer(command);
    }
  }

 private:
  enum class Kind : std::uint8_t { upload, expedited, segmented };

  [[nodiscard]] bool begin(std::uint8_t node_id, std::uint16_t index, std::uint8_t sub, Kind kind, std::span<const std::uint8_t> content) {
    if (node_id < 1 || node_id > 127) return false;
    node_id_ = node_id;
    index_ = index;
    sub_ = sub;
    kind_ = kind;
    bytes_ = content.size();
    word_ = kind == Kind::expedited ? read_le(content.data(), content.size()) : 0;
    content_ = kind == Kind::segmented ? content : std::span<const std::uint8_t>{};
    tries_left_ = timing_.tries;
    outcome_ = Outcome::busy;
    abort_code_ = 0;
    then_begin_ = false;
    make_first_request();
    return true;
  }
  [[nodiscard]] std::uint32_t request_id() const { return canopen::kSdoRequestBase + node_id_; }
  void make_first_request() {
    --tries_left_;
    in_segments_ = toggle_ = false;
    confirmed_ = offered_ = done_upload_ = told_ = 0;
    buffer_[0] = buffer_[1] = buffer_[2] = buffer_[3] = 0;
    std::uint8_t command = canopen::kSdoUploadRequest;
    std::uint32_t value = 0;
    if (kind_ == Kind::expedited) {
      command = canopen::sdo_download_command(bytes_);
      value = word_;
    } else if (kind_ == Kind::segmented) {
      command = 0x21;
      value = static_cast<std::uint32_t>(bytes_);
    }
    request_ = canopen::sdo(request_id(), command, index_, sub_, value);
    to_send_ = true;
  }
  void make_abort(SdoAbort why) {
    request_ = canopen::sdo(request_id(), canopen::kSdoAbort, index_, sub_, static_cast<std::uint32_t>(why));
    to_send_ = true;
  }
  void give_up(Outcome outcome, SdoAbort why) {
    outcome_ = outcome;
    abort_code_ = static_cast<std::uint32_t>(why);
    make_abort(why);
  }
  void on_silence() {
    if (tries_left_ <= 0) {
      outcome_ = Outcome::timed_out;
      abort_code_ = static_cast<std::uint32_t>(SdoAbort::time_out);
      if (in_segments_ || kind_ == Kind::segmented) make_abort(SdoAbort::time_out);
      return;
    }
    if (!in_segments_ && kind_ != Kind::segmented) return make_first_request();
    make_abort(SdoAbort::time_out);
    then_begin_ = true;
  }

  void on_upload_begun(const CanFrame& frame) {
    const std::uint8_t command = frame.data[0];
    if ((command & 0xE0U) != 0x40U) return give_up(Outcome::confused, SdoAbort::command);
    const bool size_given = (command & 1U) != 0;
    if ((command & 2U) != 0) {
      done_upload_ = size_given ? 4U - ((command >> 2) & 3U) : 4U;
      std::copy_n(frame.data.begin() + 4, done_upload_, buffer_.begin());
      outcome_ = Outcome::done;
      return;
    }
    if constexpr (kUploadMax <= 4) return give_up(Outcome::confused, SdoAbort::command);
    told_ = size_given ? read_le(&frame.data[4], 4) : 0;
    size_told_ = size_given;
    if (told_ > kUploadMax) return give_up(Outcome::confused, SdoAbort::no_memory);
    in_segments_ = true;
    ask_segment();
  }
  void ask_segment() {
    request_ = CanFrame{request_id(), 8, 0, {}};
    request_.data[0] = toggle_ ? 0x70 : 0x60;
    to_send_ = true;
  }
  void on_upload_segment(const CanFrame& frame) {
    const std::uint8_t command = frame.data[0];
    if ((command & 0xE0U) != 0) return give_up(Outcome::confused, SdoAbort::command);
    if (((command & 0x10U) != 0) != toggle_) return give_up(Outcome::confused, SdoAbort::toggle);
    const std::size_t bytes = 7U - ((command >> 1) & 7U);
    if (done_upload_ + bytes > (size_told_ ? told_ : kUploadMax))
      return give_up(Outcome::confused, size_told_ ? SdoAbort::too_long : SdoAbort::no_memory);
    std::copy_n(frame.data.begin() + 1, bytes, buffer_.begin() + static_cast<std::ptrdiff_t>(done_upload_));
    done_upload_ += bytes;
    toggle_ = !toggle_;
    if ((command & 1U) == 0) return ask_segment();
    if (size_told_ && done_upload_ != told_) return give_up(Outcome::confused, SdoAbort::too_short);
    outcome_ = Outcome::done;
  }

  void on_download_answer(std::uint8_t command) {
    if (!in_segments_) {
      if (command != canopen::kSdoDownloadReply) return give_up(Outcome::confused, SdoAbort::command);
      in_segments_ = true;
      return offer_segment();
    }
    if ((command & 0xE0U) != 0x20U) return give_up(Outcome::confused, SdoAbort::command);
    if (((command & 0x10U) != 0) != toggle_) return give_up(Outcome::confused, SdoAbort::toggle);
    confirmed_ = offered_;
    toggle_ = !toggle_;
    if (confirmed_ < content_.size()) return offer_segment();
    outcome_ = Outcome::done;
  }
  void offer_segment() {
    const std::size_t bytes = std::min<std::size_t>(7, content_.size() - confirmed_);
    offered_ = confirmed_ + bytes;
    request_ = CanFrame{request_id(), 8, 0, {}};
    request_.data[0] = static_cast<std::uint8_t>((toggle_ ? 0x10U : 0U) | ((7U - bytes) << 1) | (offered_ == content_.size() ? 1U : 0U));
    std::copy_n(content_.begin() + static_cast<std::ptrdiff_t>(confirmed_), bytes, request_.data.begin() + 1);
    to_send_ = true;
  }

  SdoTiming timing_;
  std::uint8_t node_id_ = 0, sub_ = 0;
  std::uint16_t index_ = 0;
  Kind kind_ = Kind::upload;
  Outcome outcome_ = Outcome::idle;
  bool to_send_ = false, then_begin_ = false, sent_once_ = false, in_segments_ = false, toggle_ = false, size_told_ = false;
  int tries_left_ = 0;
  std::uint64_t sent_ns_ = 0;
  std::uint32_t abort_code_ = 0, word_ = 0;
  std::size_t bytes_ = 0, offered_ = 0, confirmed_ = 0, done_upload_ = 0, told_ = 0;
  std::span<const std::uint8_t> content_{};
  CanFrame request_{};
  std::array<std::uint8_t, kUploadMax> buffer_{};
};

}  // namespace hoist::contract
