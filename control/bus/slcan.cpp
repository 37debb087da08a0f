#include "control/bus/slcan.hpp"

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace hoist::bus {

using contract::CanFrame;
using contract::SlcanKind;
using contract::SlcanLine;

namespace {
// Close, 250 kbit/s (canbus plan, section 5), open. A leading empty line ends whatever half line the adapter still holds.
constexpr std::string_view kSetup = "\rC\rS5\rO\r";
// The answer that counts is the one to `O`; the ones before it may be BEL (nothing to close, rate set while open).
constexpr std::uint32_t kSetupAnswers = 4;
}  // namespace

SlcanPort::SlcanPort(std::string path) : path_(std::move(path)) {}

SlcanPort::~SlcanPort() {
  if (fd_ < 0) return;
  // Best effort: tell the adapter that nobody listens any more.
  [[maybe_unused]] const ssize_t written = ::write(fd_, "C\r", 2);
  ::close(fd_);
}

void SlcanPort::open_device(std::uint64_t now_ns) noexcept {
  fd_ = ::open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) {
    deadline_ns_ = now_ns + kRetryNs;
    return;
  }
  termios settings{};
  if (::tcgetattr(fd_, &settings) == 0) {
    ::cfmakeraw(&settings);
    settings.c_cflag |= CLOCAL | CREAD | CRTSCTS;  // a pty ignores the handshake; a real gateway needs it at 1 Mbaud
    ::cfsetspeed(&settings, B1000000);
    ::tcsetattr(fd_, TCSANOW, &settings);
  }
  ::tcflush(fd_, TCIOFLUSH);
  decoder_.restart();
  if (ever_open_) ++counters_.reopened;
  ever_open_ = true;
  begin_setup(now_ns);
}

void SlcanPort::close_device(std::uint64_t now_ns) noexcept {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  state_ = State::closed;
  pending_size_ = 0;
  deadline_ns_ = now_ns + kRetryNs;
}

void SlcanPort::begin_setup(std::uint64_t now_ns) noexcept {
  state_ = State::setting_up;
  deadline_ns_ = now_ns + kSetupNs;
  setup_answers_ = 0;
  unanswered_ = 0;
  silences_ = 0;
  std::memcpy(pending_.data(), kSetup.data(), kSetup.size());
  pending_size_ = kSetup.size();
  if (!flush()) close_device(now_ns);
}

// Writes what is pending; false when the device is gone.
bool SlcanPort::flush() noexcept {
  if (pending_size_ == 0) return true;
  const ssize_t written = ::write(fd_, pending_.data(), pending_size_);
  if (written < 0) return errno == EAGAIN || errno == EINTR;
  pending_size_ -= static_cast<std::size_t>(written);
  std::memmove(pending_.data(), pending_.data() + written, pending_size_);
  return true;
}

void SlcanPort::on_answer(bool accepted, std::uint64_t now_ns) noexcept {
  last_answer_ns_ = now_ns;
  silences_ = 0;
  if (state_ == State::setting_up) {
    // Adapters differ in whether they answer an empty line; so the set-up is over when the answer to `O` is the last one owed, or when
    // frames arrive. An adapter that skips one answer is caught by frames or by the deadline.
    if (++setup_answers_ < kSetupAnswers) return;
    if (accepted)
      state_ = State::up;
    else
      deadline_ns_ = now_ns;  // refused: set up again at the next look
    return;
  }
  if (unanswered_ > 0) --unanswered_;
  if (!accepted) ++counters_.send_refused;
}

std::size_t SlcanPort::receive(std::span<CanFrame> out, std::uint64_t now_ns) noexcept {
  if (fd_ < 0) {
    if (now_ns >= deadline_ns_) open_device(now_ns);
    if (fd_ < 0) return 0;
  }
  std::size_t count = 0;
  for (int i = 0; i < kReadsPerStep; ++i) {
    const ssize_t got = ::read(fd_, read_buffer_.data(), read_buffer_.size());
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) break;
    if (got <= 0) {  // the other end closed, or the adapter was pulled out
      close_device(now_ns);
      return count;
    }
    decoder_.feed(std::span<const char>(read_buffer_.data(), static_cast<std::size_t>(got)), [&](const SlcanLine& line) {
      switch (line.kind) {
        case SlcanKind::frame:
          if (state_ == State::setting_up) state_ = State::up;
          if (count < out.size()) {
            out[count++] = line.frame;
            ++counters_.received;
          } else {
            ++counters_.refused;
          }
          break;
        case SlcanKind::ack:
          on_answer(true, now_ns);
          break;
        case SlcanKind::bel:
          on_answer(false, now_ns);
          break;
        case SlcanKind::refused:
        case SlcanKind::error:
          ++counters_.refused;
          break;
        case SlcanKind::state:
        case SlcanKind::command:
          break;
      }
    });
    if (static_cast<std::size_t>(got) < read_buffer_.size()) break;
  }
  if (state_ == State::setting_up && now_ns >= deadline_ns_) {
    // Some adapters do not answer the empty line: three answers with the last accepted are a set-up adapter too.
    if (setup_answers_ == kSetupAnswers - 1)
      state_ = State::up;
    else
      begin_setup(now_ns);
  }
  if (state_ == State::up && unanswered_ > 0 && now_ns - last_answer_ns_ > kAnswerNs) {
    counters_.send_refused += unanswered_;
    unanswered_ = 0;
    if (++silences_ >= kSilencesBeforeSetup) begin_setup(now_ns);
  }
  return count;
}

std::size_t SlcanPort::send(std::span<const CanFrame> frames, std::uint64_t now_ns) noexcept {
  std::size_t taken = 0;
  if (state_ == State::up && pending_size_ == 0) {
    for (const CanFrame& frame : frames) {
      if (unanswered_ >= kWindow) break;
      const std::size_t length =
          contract::slcan_encode(frame, std::span<char>(pending_.data() + pending_size_, pending_.size() - pending_size_));
      if (length == 0) break;
      if (unanswered_ == 0) last_answer_ns_ = now_ns;
      pending_size_ += length;
      ++unanswered_;
      ++taken;
    }
  }
  counters_.sent += static_cast<std::uint32_t>(taken);
  counters_.send_refused += static_cast<std::uint32_t>(frames.size() - taken);
  if (fd_ >= 0 && !flush()) close_device(now_ns);
  return taken;
}

std::unique_ptr<CanPort> open_port(std::string_view address, std::string& error) {
  constexpr std::string_view kSlcan = "slcan:";
  if (address.starts_with(kSlcan) && address.size() > kSlcan.size())
    return std::make_unique<SlcanPort>(std::string(address.substr(kSlcan.size())));
  error = "unknown bus \"" + std::string(address) + "\": use slcan:PATH, for example slcan:/dev/ttyUSB0";
  return nullptr;
}

}  // namespace hoist::bus
