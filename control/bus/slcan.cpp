#include "control/bus/slcan.hpp"

#include <fcntl.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace hoist::bus {

using contract::CanFrame;
using contract::SlcanKind;
using contract::SlcanLine;

namespace {
// Close, 250 kbit/s (canbus plan, section 5), state and error lines, open. A leading empty line ends a partial line in the adapter. E1 is
// our gateway's own. Most others refuse it; some (slcanpty) then drop the following lines too, so every second try omits it.
constexpr std::string_view kSetup = "\rC\rS5\rE1\rO\r", kPlainSetup = "\rC\rS5\rO\r";
// Only the answer to `O` counts; earlier ones may be BEL (nothing to close, rate set while open, E1 unknown).
constexpr std::uint32_t kSetupAnswers = 5, kPlainSetupAnswers = 4;
// Some adapters do not answer empty lines and unknown commands.
constexpr std::uint32_t kSetupAnswersLeast = 3;
constexpr const char* kGone = "the device has gone away";
constexpr const char* kBusOff = "the adapter's controller is off the bus (bus-off): check wiring and termination";

struct Baud {
  std::uint32_t bits_s;
  speed_t code;
};
// Serial rates that Linux names and that are fast enough for a CAN bus.
constexpr std::array kBauds{Baud{115200, B115200},   Baud{230400, B230400},   Baud{460800, B460800},   Baud{500000, B500000},
                            Baud{576000, B576000},   Baud{921600, B921600},   Baud{1000000, B1000000}, Baud{1152000, B1152000},
                            Baud{1500000, B1500000}, Baud{2000000, B2000000}, Baud{2500000, B2500000}, Baud{3000000, B3000000},
                            Baud{3500000, B3500000}, Baud{4000000, B4000000}};
const Baud* find_baud(std::uint32_t bits_s) {
  const auto found = std::find_if(kBauds.begin(), kBauds.end(), [bits_s](const Baud& row) { return row.bits_s == bits_s; });
  return found == kBauds.end() ? nullptr : &*found;
}

// A serial line of this computer.
class Tty final : public SerialDevice {
 public:
  Tty(std::string path, std::uint32_t baud) : path_(std::move(path)), baud_(baud) {}
  ~Tty() override { Tty::close(); }
  Tty(const Tty&) = delete;
  Tty& operator=(const Tty&) = delete;

  const char* open() noexcept override {
    fd_ = ::open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (fd_ < 0) return errno == EACCES ? "the device may not be opened by this user" : "the device is not there";
    // Two programs on one line would each lose the frames that the other reads.
    if (::flock(fd_, LOCK_EX | LOCK_NB) != 0) return "another program has the device open";
    if (!set_up_line()) return "the device is no serial line, or not at this rate";
    ::tcflush(fd_, TCIFLUSH);
    return nullptr;
  }
  void close() noexcept override {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }
  ssize_t read(std::span<char> text) noexcept override { return ::read(fd_, text.data(), text.size()); }
  ssize_t write(std::span<const char> text) noexcept override { return ::write(fd_, text.data(), text.size()); }
  void discard() noexcept override { ::tcflush(fd_, TCOFLUSH); }

 private:
  [[nodiscard]] bool set_up_line() const noexcept;

  std::string path_;
  std::uint32_t baud_;
  int fd_ = -1;
};

// Raw, eight bits, hardware handshake, the given rate. False when the line does not support it: tcsetattr() succeeds when any one setting
// was applied, so the settings are read back.
bool Tty::set_up_line() const noexcept {
  const Baud* baud = find_baud(baud_);
  termios wanted{}, got{};
  if (baud == nullptr || ::tcgetattr(fd_, &wanted) != 0) return false;
  ::cfmakeraw(&wanted);
  wanted.c_cflag |= CLOCAL | CREAD | CRTSCTS;  // a pty ignores the handshake; a real gateway needs it at 1 Mbaud
  wanted.c_cflag &= static_cast<tcflag_t>(~CSTOPB);
  wanted.c_iflag |= INPCK;  // a character with a wrong stop bit reads as NUL, which the decoder drops with its line (firmware DECISIONS 52)
  wanted.c_cc[VMIN] = 1;    // a read of zero bytes is then always a line that was hung up
  wanted.c_cc[VTIME] = 0;
  if (::cfsetspeed(&wanted, baud->code) != 0 || ::tcsetattr(fd_, TCSANOW, &wanted) != 0 || ::tcgetattr(fd_, &got) != 0) return false;
  if (::cfgetospeed(&got) != baud->code || (got.c_lflag & (ICANON | ECHO)) != 0) return false;
  // Converters of FTDI's kind delay bytes by 16 ms unless the port is set to low latency. Others do not support the request and do not need it.
  serial_struct serial{};
  if (::ioctl(fd_, TIOCGSERIAL, &serial) == 0) {
    serial.flags |= ASYNC_LOW_LATENCY;
    [[maybe_unused]] const int refused = ::ioctl(fd_, TIOCSSERIAL, &serial);
  }
  return true;
}
}  // namespace

bool SlcanPort::valid_baud(std::uint32_t baud) noexcept { return find_baud(baud) != nullptr; }
std::string SlcanPort::baud_list() {
  std::string list;
  for (const Baud& row : kBauds) list += (list.empty() ? "" : ", ") + std::to_string(row.bits_s);
  return list;
}

SlcanPort::SlcanPort(std::string path, std::uint32_t baud) : SlcanPort(std::make_shared<Tty>(std::move(path), baud)) {}
SlcanPort::SlcanPort(std::shared_ptr<SerialDevice> device) : device_(std::move(device)) {}

SlcanPort::~SlcanPort() {
  if (state_ == State::closed) return;
  // Best effort: close the channel of the adapter.
  constexpr std::string_view kClose = "C\r";
  static_cast<void>(device_->write(kClose));
  device_->close();
}

void SlcanPort::open_device(std::uint64_t now_ns) noexcept {
  if (const char* why = device_->open(); why != nullptr) return close_device(now_ns, why);
  decoder_.restart();
  if (ever_open_) ++counters_.reopened;
  ever_open_ = true;
  begin_setup(now_ns);
}

void SlcanPort::close_device(std::uint64_t now_ns, const char* why) noexcept {
  device_->close();
  state_ = State::closed;
  pending_size_ = 0;
  problem_ = why;
  deadline_ns_ = now_ns + kRetryNs;
}

void SlcanPort::begin_setup(std::uint64_t now_ns) noexcept {
  state_ = State::setting_up;
  deadline_ns_ = now_ns + kSetupNs;
  setup_answers_ = 0;
  expect_nothing();
  silences_ = refusals_ = 0;
  device_->discard();  // commands that a halted line still holds are old
  // A reopened adapter has left bus-off; if not, it reports it again.
  counters_.state = BusState::active;
  problem_ = "the adapter does not answer";
  const std::string_view lines = plain_setup_ ? kPlainSetup : kSetup;
  std::memcpy(pending_.data(), lines.data(), lines.size());
  pending_size_ = lines.size();
  if (!flush()) close_device(now_ns, kGone);
}

// Writes what is pending; false when the device is gone.
bool SlcanPort::flush() noexcept {
  if (pending_size_ == 0) return true;
  const ssize_t written = device_->write(std::span<const char>(pending_).first(pending_size_));
  if (written < 0) return errno == EAGAIN || errno == EINTR;
  pending_size_ -= static_cast<std::size_t>(written);
  std::memmove(pending_.data(), pending_.data() + written, pending_size_);
  return true;
}

void SlcanPort::expect_nothing() noexcept {
  unanswered_ = 0;
  waiting_since_ns_ = left_out_ns_ = 0;
}

void SlcanPort::on_answer(bool accepted, std::uint64_t now_ns) noexcept {
  waiting_since_ns_ = left_out_ns_ = 0;
  silences_ = 0;
  if (state_ == State::setting_up) {
    // Adapters differ in whether they answer an empty line; so the set-up is over when the answer to `O` is the last one owed, or when
    // frames arrive. An adapter that skips one answer is caught by frames or by the deadline.
    last_accepted_ = accepted;
    if (++setup_answers_ < (plain_setup_ ? kPlainSetupAnswers : kSetupAnswers)) return;
    if (accepted)
      become_up();
    else
      deadline_ns_ = now_ns;  // refused: set up again at the next look
    return;
  }
  if (unanswered_ > 0) --unanswered_;
  if (accepted) {
    refusals_ = 0;
  } else {
    ++refusals_;
    ++counters_.send_refused;
  }
}

void SlcanPort::become_up() noexcept {
  state_ = State::up;
  problem_ = counters_.state == BusState::off ? kBusOff : "";
}

// "s" and a letter with the two error counters: the controller's state has changed.
void SlcanPort::on_state(const SlcanLine& line, std::uint64_t now_ns) noexcept {
  const BusState before = counters_.state;
  counters_.state = line.state == 'a'   ? BusState::active
                    : line.state == 'w' ? BusState::warning
                    : line.state == 'p' ? BusState::passive
                                        : BusState::off;
  counters_.rx_errors = line.rx_errors;
  counters_.tx_errors = line.tx_errors;
  if (counters_.state == BusState::off && before != BusState::off) {
    ++counters_.bus_offs;
    off_since_ns_ = now_ns;
    expect_nothing();  // unanswered lines are lost with the bus
  }
  if (state_ == State::up) become_up();
}

// "e", how many letters, and a letter for each error: o and O are frames lost by full buffers, the others bus errors. Any other line is
// refused.
void SlcanPort::on_errors(std::string_view text) noexcept {
  const std::size_t letters = text.size() >= 2 && text[1] >= '1' && text[1] <= '9' ? static_cast<std::size_t>(text[1] - '0') : 0;
  constexpr std::string_view kKnown = "abBcfoOs";
  const std::string_view errors = text.size() >= 2 ? text.substr(2) : std::string_view{};
  if (letters == 0 || errors.size() != letters || errors.find_first_not_of(kKnown) != std::string_view::npos) {
    ++counters_.refused;
    return;
  }
  for (const char error : errors) {
    if (error == 'o' || error == 'O') ++counters_.overflows;
    ++counters_.bus_errors;
  }
}

std::size_t SlcanPort::receive(std::span<CanFrame> out, std::uint64_t now_ns) noexcept {
  if (state_ == State::closed) {
    if (now_ns >= deadline_ns_) open_device(now_ns);
    if (state_ == State::closed) return 0;
  }
  std::size_t count = 0;
  for (int i = 0; i < kReadsPerStep; ++i) {
    const ssize_t got = device_->read(read_buffer_);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) break;
    if (got <= 0) {  // the other end closed, or the adapter was pulled out
      close_device(now_ns, kGone);
      return count;
    }
    decoder_.feed(std::span<const char>(read_buffer_.data(), static_cast<std::size_t>(got)), [&](const SlcanLine& line) {
      switch (line.kind) {
        case SlcanKind::frame:
          if (state_ == State::setting_up) become_up();
          refusals_ = 0;
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
          ++counters_.refused;
          break;
        case SlcanKind::error:
          on_errors(line.text);
          break;
        case SlcanKind::state:
          on_state(line, now_ns);
          break;
        case SlcanKind::command:
          break;
      }
    });
    if (static_cast<std::size_t>(got) < read_buffer_.size()) break;
  }
  if (state_ == State::setting_up && now_ns >= deadline_ns_) {
    if (setup_answers_ >= kSetupAnswersLeast && last_accepted_)
      become_up();
    else {
      plain_setup_ = !plain_setup_;
      begin_setup(now_ns);
    }
  }
  if (state_ == State::up && waiting_since_ns_ != 0 && now_ns - waiting_since_ns_ > kAnswerNs) {
    counters_.send_refused += unanswered_;
    expect_nothing();
    if (++silences_ >= kSilencesBeforeSetup) begin_setup(now_ns);
  }
  // The line is halted: what it has not taken by now must not be sent any more.
  if (state_ == State::up && pending_size_ > 0 && now_ns - pending_since_ns_ > kAnswerNs) begin_setup(now_ns);
  // Every line is refused and nothing is received: one flipped character was a `C`, which closed the bus. At bus-off lines are refused too,
  // but that ends by itself.
  if (state_ == State::up && refusals_ >= kRefusalsBeforeSetup && counters_.state != BusState::off) begin_setup(now_ns);
  if (state_ == State::up && counters_.state == BusState::off && now_ns - off_since_ns_ >= kBusOffNs) begin_setup(now_ns);
  return count;
}

// Whether the window has room for so many lines. Noise also damages answers, and a lost one would narrow the window for good: after a step was
// left out, a working adapter that has answered since its last lines and then is silent owes nothing more.
bool SlcanPort::has_room(std::size_t lines, std::uint64_t now_ns) noexcept {
  if (left_out_ns_ != 0 && now_ns - left_out_ns_ >= kLostNs) {
    counters_.send_refused += unanswered_;
    expect_nothing();
  }
  if (unanswered_ + lines <= kWindow) return true;
  if (left_out_ns_ == 0 && waiting_since_ns_ == 0) left_out_ns_ = now_ns;
  return false;
}

// All frames of a step or none: of two drive commands, one alone would turn the hoist.
std::size_t SlcanPort::send(std::span<const CanFrame> frames, std::uint64_t now_ns) noexcept {
  const std::span<const CanFrame> step = frames.first(std::min<std::size_t>(frames.size(), kWindow));
  std::size_t taken = 0;
  if (up() && pending_size_ == 0 && has_room(step.size(), now_ns)) {
    for (const CanFrame& frame : step) {
      const std::size_t length =
          contract::slcan_encode(frame, std::span<char>(pending_.data() + pending_size_, pending_.size() - pending_size_));
      if (length == 0) break;
      pending_size_ += length;
      ++taken;
    }
    unanswered_ += static_cast<std::uint32_t>(taken);
    pending_since_ns_ = now_ns;
    if (taken > 0) left_out_ns_ = 0;
    if (taken > 0 && waiting_since_ns_ == 0) waiting_since_ns_ = now_ns;
  }
  counters_.sent += static_cast<std::uint32_t>(taken);
  counters_.send_refused += static_cast<std::uint32_t>(frames.size() - taken);
  if (state_ != State::closed && !flush()) close_device(now_ns, kGone);
  return taken;
}

}  // namespace hoist::bus
