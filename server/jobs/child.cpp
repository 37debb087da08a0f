#include "server/jobs/child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstring>
#include <utility>

namespace hoist::server {

namespace {
// A longer line is cut: nothing that a job reads is as long.
constexpr std::size_t kLongestLine = 4096;

db::Error failed(const std::string& program, int code) {
  return {db::ErrorKind::io, program + " cannot be started: " + std::strerror(code), {}};
}

// What the child begins with: only its output, signals as a shell gives them, a process group of its own.
struct Beginning {
  posix_spawn_file_actions_t files{};
  posix_spawnattr_t attributes{};
  explicit Beginning(int output) {
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&files, output, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&files, output, STDERR_FILENO);
    posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
    posix_spawnattr_init(&attributes);
    sigset_t none{}, all{};
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  }
  Beginning(const Beginning&) = delete;
  Beginning& operator=(const Beginning&) = delete;
  ~Beginning() {
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
  }
};
}  // namespace

db::Result<Child> Child::start(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = arguments;
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  std::array<int, 2> pipe{};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0) return failed(arguments.front(), errno);
  pid_t pid = -1;
  const Beginning beginning(pipe[1]);
  const int code = ::posix_spawn(&pid, words.front().c_str(), &beginning.files, &beginning.attributes, pointers.data(), environ);
  ::close(pipe[1]);
  if (code != 0) {
    ::close(pipe[0]);
    return failed(arguments.front(), code);
  }
  return Child(pid, pipe[0]);
}

Child::Child(Child&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      output_(std::exchange(other.output_, -1)),
      read_(std::move(other.read_)),
      ended_(other.ended_),
      paused_(other.paused_) {}

Child::~Child() {
  if (pid_ > 0) {
    ::kill(-pid_, SIGKILL);
    (void)exit_code();
  }
  if (output_ >= 0) ::close(output_);
}

std::optional<std::string> Child::taken_line() {
  const std::size_t end = read_.find('\n');
  if (end == std::string::npos && !ended_ && read_.size() < kLongestLine) return {};
  if (read_.empty()) return {};
  std::string line = read_.substr(0, std::min(end, kLongestLine));
  read_.erase(0, end == std::string::npos ? read_.size() : end + 1);
  return line;
}

std::optional<std::string> Child::line(int wait_ms) {
  if (auto line = taken_line()) return line;
  if (ended_) return {};
  pollfd watched{.fd = output_, .events = POLLIN, .revents = 0};
  if (::poll(&watched, 1, wait_ms) <= 0) return {};
  std::array<char, 4096> piece{};
  const ssize_t count = ::read(output_, piece.data(), piece.size());
  if (count > 0)
    read_.append(piece.data(), static_cast<std::size_t>(count));
  else if (count == 0 || errno != EINTR)
    ended_ = true;
  return taken_line();
}

int Child::exit_code() {
  int status = 0;
  while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

void Child::pause(bool paused) {
  if (paused == paused_ || pid_ <= 0) return;
  paused_ = paused;
  ::kill(-pid_, paused ? SIGSTOP : SIGCONT);
}

}  // namespace hoist::server
