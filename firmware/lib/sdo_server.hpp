// The server's side of SDO (CiA 301, 7.2.4): expedited and segmented transfers, one at a time, in a few bytes of memory. No block transfer.
// The objects belong to the dictionary that is passed to each call:
//   SdoAbort sdo_read(index, sub, SdoSource&)        what to upload: up to 4 bytes in `raw`, or a text with static storage
//   SdoAbort sdo_target(index, sub, SdoTarget&)      whether the object may be written now, and its length
//   SdoAbort sdo_write(index, sub, raw)              the value of an object of 1, 2 or 4 bytes, complete
//   SdoAbort sdo_domain_begin(index, sub, announced) start of a domain of `announced` bytes, 0 when the client gave no length
//   SdoAbort sdo_domain_data(std::span<const std::uint8_t>)   its next 1 to 7 bytes, in order
//   SdoAbort sdo_domain_end()                        end of the domain; its length is `announced`
//   void     sdo_domain_cancel()                     it will not be completed; follows every accepted begin without an end
// Whatever these return other than SdoAbort::none ends the transfer with that abort code. Flash may be written inside them: the answer
// leaves when they return.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "control/contract/can_dictionary.hpp"

namespace hoist::firmware {

using contract::CanFrame;
using contract::canopen::SdoAbort;

inline constexpr std::uint32_t kSdoTimeOut_ms = 1000;  // timeout of a client within a transfer
inline constexpr std::size_t kSdoSegmentBytes = 7;

struct SdoSource {
  std::uint32_t raw = 0;
  std::uint8_t raw_bytes = 0;  // 1, 2 or 4; 0 = use `text`
  std::string_view text{};
};
struct SdoTarget {
  std::uint8_t bytes = 0;  // 1, 2 or 4: a value, which the server collects; 0: a domain, which is passed on as it comes
};

// Exactly one answer follows each request, except an abort, which has none. The owner sends answer() when answer_waiting(), then calls
// answer_sent(). A new request drops a waiting answer, because its client no longer waits for it.
class SdoServer {
 public:
  constexpr explicit SdoServer(std::uint8_t node_id) : node_id_(node_id) {}

  [[nodiscard]] bool answer_waiting() const { return answer_waiting_; }
  [[nodiscard]] const CanFrame& answer() const { return answer_; }
  void answer_sent() { answer_waiting_ = false; }
  [[nodiscard]] bool transfer_open() const { return phase_ != Phase::idle; }
  [[nodiscard]] std::uint32_t aborts() const { return aborts_; }                // sent since power-on
  [[nodiscard]] std::uint32_t wrong_lengths() const { return wrong_lengths_; }  // requests that were not 8 bytes long
  [[nodiscard]] std::uint32_t unknown() const { return unknown_; }              // requests for a service that is not spoken

  // Ends the open transfer and drops the answer silently (NMT stopped, reset).
  template <class Dictionary>
  void reset(Dictionary& dictionary) {
    close(dictionary);
    answer_waiting_ = false;
  }
  // The same for a dictionary that has no domains, or that is being reset itself.
  void forget() {
    phase_ = Phase::idle;
    answer_waiting_ = false;
  }

  // One frame with the id 600h + node id.
  template <class Dictionary>
  void on_request(const CanFrame& frame, Dictionary& dictionary) {
    if (frame.dlc != 8) {
      ++wrong_lengths_;
      if (transfer_open()) return abort(SdoAbort::command, dictionary);
      return frame.dlc >= 4 ? refuse(index_of(frame), frame.data[3], SdoAbort::command) : refuse(0, 0, SdoAbort::command);
    }
    idle_ms_ = 0;
    const std::uint8_t command = frame.data[0];
    if (command == contract::canopen::kSdoAbort) return close(dictionary);
    if (command == contract::canopen::kSdoUploadRequest) return begin_upload(index_of(frame), frame.data[3], dictionary);
    if ((command & 0xF0U) == 0x20U) return begin_download(frame, dictionary);
    if ((command & 0xEFU) == 0x60U && phase_ == Phase::upload) return upload_segment((command & kToggleBit) != 0, dictionary);
    if ((command & 0xE0U) == 0x00U && (phase_ == Phase::value || phase_ == Phase::domain)) return download_segment(frame, dictionary);
    ++unknown_;
    if (transfer_open()) return abort(SdoAbort::command, dictionary);
    // The bytes of a segment name no object.
    return (command & 0xE0U) == 0x00U || (command & 0xE0U) == 0x60U ? refuse(0, 0, SdoAbort::command)
                                                                    : refuse(index_of(frame), frame.data[3], SdoAbort::command);
  }

  // Once per millisecond.
  template <class Dictionary>
  void tick_1ms(Dictionary& dictionary) {
    if (transfer_open() && ++idle_ms_ >= kSdoTimeOut_ms) abort(SdoAbort::time_out, dictionary);
  }

 private:
  enum class Phase : std::uint8_t { idle, upload, value, domain };
  static constexpr std::uint8_t kToggleBit = 0x10;

  static std::uint16_t index_of(const CanFrame& frame) { return static_cast<std::uint16_t>(contract::read_le(&frame.data[1], 2)); }

  void answer_with(std::uint8_t command, std::uint16_t index, std::uint8_t sub, std::uint32_t value) {
    answer_ = contract::canopen::sdo(contract::canopen::kSdoReplyBase + node_id_, command, index, sub, value);
    answer_waiting_ = true;
  }
  void refuse(std::uint16_t index, std::uint8_t sub, SdoAbort code) {
    ++aborts_;
    answer_with(contract::canopen::kSdoAbort, index, sub, static_cast<std::uint32_t>(code));
  }
  template <class Dictionary>
  void close(Dictionary& dictionary) {
    const bool domain = phase_ == Phase::domain;
    phase_ = Phase::idle;
    if (domain) dictionary.sdo_domain_cancel();
  }
  template <class Dictionary>
  void abort(SdoAbort code, Dictionary& dictionary) {
    close(dictionary);
    refuse(index_, sub_, code);
  }
  void open(Phase phase, std::uint16_t index, std::uint8_t sub, std::uint32_t announced) {
    phase_ = phase;
    index_ = index;
    sub_ = sub;
    announced_ = announced;
    done_ = 0;
    toggle_ = false;
    idle_ms_ = 0;
  }

  template <class Dictionary>
  void begin_upload(std::uint16_t index, std::uint8_t sub, Dictionary& dictionary) {
    close(dictionary);  // a new request replaces the open transfer: its client has given that up
    SdoSource source;
    if (const SdoAbort code = dictionary.sdo_read(index, sub, source); code != SdoAbort::none) return refuse(index, sub, code);
    if (source.raw_bytes != 0) return answer_with(contract::canopen::sdo_upload_reply_command(source.raw_bytes), index, sub, source.raw);
    text_ = source.text;
    open(Phase::upload, index, sub, static_cast<std::uint32_t>(text_.size()));
    answer_with(kUploadSegmented, index, sub, announced_);
  }
  template <class Dictionary>
  void upload_segment(bool toggle, Dictionary& dictionary) {
    if (toggle != toggle_) return abort(SdoAbort::toggle, dictionary);
    const std::size_t left = text_.size() - done_;
    const std::size_t bytes = left < kSdoSegmentBytes ? left : kSdoSegmentBytes;
    CanFrame frame{contract::canopen::kSdoReplyBase + node_id_, 8, 0, {}};
    frame.data[0] = static_cast<std::uint8_t>((toggle ? kToggleBit : 0U) | ((kSdoSegmentBytes - bytes) << 1) | (bytes == left ? 1U : 0U));
    for (std::size_t i = 0; i < bytes; ++i) frame.data[1 + i] = static_cast<std::uint8_t>(text_[done_ + i]);
    done_ += static_cast<std::uint32_t>(bytes);
    toggle_ = !toggle_;
    if (bytes == left) phase_ = Phase::idle;
    answer_ = frame;
    answer_waiting_ = true;
  }

  template <class Dictionary>
  void begin_download(const CanFrame& frame, Dictionary& dictionary) {
    close(dictionary);
    const std::uint16_t index = index_of(frame);
    const std::uint8_t sub = frame.data[3], command = frame.data[0];
    const bool expedited = (command & 2U) != 0, size_given = (command & 1U) != 0;
    SdoTarget target;
    if (const SdoAbort code = dictionary.sdo_target(index, sub, target); code != SdoAbort::none) return refuse(index, sub, code);
    // Expedited without a size means as many of the four bytes as the object has.
    const std::uint32_t announced = !size_given ? 0U
                                    : expedited ? 4U - ((static_cast<std::uint32_t>(command) >> 2) & 3U)
                                                : contract::read_le(&frame.data[4], 4);
    if (target.bytes != 0) {
      if (size_given && announced != target.bytes)
        return refuse(index, sub, announced > target.bytes ? SdoAbort::too_long : SdoAbort::too_short);
      if (expedited) {
        const std::uint32_t raw = contract::read_le(&frame.data[4], target.bytes);
        if (const SdoAbort code = dictionary.sdo_write(index, sub, raw); code != SdoAbort::none) return refuse(index, sub, code);
        return answer_with(contract::canopen::kSdoDownloadReply, index, sub, 0);
      }
      open(Phase::value, index, sub, target.bytes);
      collected_ = 0;
      return answer_with(contract::canopen::kSdoDownloadReply, index, sub, 0);
    }
    if (expedited && !size_given) return refuse(index, sub, SdoAbort::length);  // a domain of unknown length
    if (const SdoAbort code = dictionary.sdo_domain_begin(index, sub, announced); code != SdoAbort::none) return refuse(index, sub, code);
    open(Phase::domain, index, sub, announced);
    if (expedited) {
      if (!take(std::span(frame.data).subspan(4, announced), dictionary) || !complete(dictionary)) return;
    }
    answer_with(contract::canopen::kSdoDownloadReply, index, sub, 0);
  }

  // Both say false when they have answered with an abort.
  template <class Dictionary>
  [[nodiscard]] bool take(std::span<const std::uint8_t> bytes, Dictionary& dictionary) {
    // A value never exceeds its announced length; the dictionary limits a domain of unknown length.
    if (announced_ != 0 && bytes.size() > announced_ - done_) {
      abort(SdoAbort::too_long, dictionary);
      return false;
    }
    if (phase_ == Phase::value) {
      for (std::size_t i = 0; i < bytes.size(); ++i) collected_ |= static_cast<std::uint32_t>(bytes[i]) << (8U * (done_ + i));
    } else if (!bytes.empty()) {
      if (const SdoAbort code = dictionary.sdo_domain_data(bytes); code != SdoAbort::none) {
        abort(code, dictionary);
        return false;
      }
    }
    done_ += static_cast<std::uint32_t>(bytes.size());
    return true;
  }
  template <class Dictionary>
  [[nodiscard]] bool complete(Dictionary& dictionary) {
    if (announced_ != 0 && done_ < announced_) {
      abort(SdoAbort::too_short, dictionary);
      return false;
    }
    const SdoAbort code = phase_ == Phase::value ? dictionary.sdo_write(index_, sub_, collected_) : dictionary.sdo_domain_end();
    if (code != SdoAbort::none) {
      abort(code, dictionary);
      return false;
    }
    phase_ = Phase::idle;
    return true;
  }

  template <class Dictionary>
  void download_segment(const CanFrame& frame, Dictionary& dictionary) {
    const std::uint8_t command = frame.data[0];
    const bool toggle = (command & kToggleBit) != 0;
    if (toggle != toggle_) return abort(SdoAbort::toggle, dictionary);
    const std::size_t bytes = kSdoSegmentBytes - ((static_cast<std::size_t>(command) >> 1) & 7U);
    if (!take(std::span(frame.data).subspan(1, bytes), dictionary)) return;
    toggle_ = !toggle_;
    if ((command & 1U) != 0 && !complete(dictionary)) return;
    answer_with(static_cast<std::uint8_t>(0x20U | (toggle ? kToggleBit : 0U)), 0, 0, 0);
  }

  static constexpr std::uint8_t kUploadSegmented = 0x41;

  std::uint8_t node_id_;
  Phase phase_ = Phase::idle;
  bool toggle_ = false, answer_waiting_ = false;
  std::uint8_t sub_ = 0;
  std::uint16_t index_ = 0;
  std::uint32_t announced_ = 0, done_ = 0, collected_ = 0, idle_ms_ = 0;
  std::uint32_t aborts_ = 0, wrong_lengths_ = 0, unknown_ = 0;
  std::string_view text_{};
  CanFrame answer_{};
};

}  // namespace hoist::firmware
