// hoist-control: the 100 Hz core on a real bus.
//
// Its threads are the rows of threads.def. The control thread sleeps until an absolute time, runs one step, sleeps again: one sleep and the
// bus are its only system calls. The watchdog thread notifies the service manager while steps continue. The storing thread writes changed
// parameters. The main thread accepts the server, counts page faults and waits for signals.
#include <sys/prctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <iostream>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "control/bus/can_port.hpp"
#include "control/bus/capture.hpp"
#include "control/bus/pokeys/input_port.hpp"
#include "control/bus/slcan.hpp"
#include "control/bus/step_line.hpp"
#include "control/contract/program_version.hpp"
#include "control/publish/core_link.hpp"
#include "control/run/control_loop.hpp"
#include "control/run/heap_watch.hpp"
#include "control/run/parameter_file.hpp"
#include "control/run/real_time.hpp"
#include "control/run/step_clock.hpp"
#include "control/run/stop_file.hpp"
#include "control/run/watchdog.hpp"

namespace {
using namespace hoist;

constexpr std::uint64_t kStopWithinNs = 3'000'000'000;  // from 0.65 m/s at 0.5 m/s2 takes 1.3 s; then end even if something still turns

std::atomic<bool> stop_requested{false};
void on_signal(int) { stop_requested.store(true); }

std::uint64_t now_ns(clockid_t clock) {
  timespec t{};
  ::clock_gettime(clock, &t);
  return static_cast<std::uint64_t>(t.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(t.tv_nsec);
}

// The only bus with a foreign clock; no option sets one for another bus.
constexpr std::string_view kLockStep = "sim:";
bool is_lock_step(std::string_view bus) { return bus.starts_with(kLockStep); }

struct Options {
  std::string bus = "slcan:/dev/ttyUSB0";
  std::string socket = "/run/hoist/core.sock";
  std::string params;
  std::string capture;
  std::string inputs = "can";
  std::vector<std::string> set;
  std::string cpu = "auto";
  bool real_time = true;
  bool version = false;
};

void print_help() {
  std::cout
      << "hoist-control: the 100 Hz control core of Hoist\n\n"
         "  --bus ADDRESS      socketcan:NAME, slcan:DEVICE[@BAUD], replay:FILE (default slcan:/dev/ttyUSB0), or sim:SOCKET: hoist-sim\n"
         "                     --lock-step SOCKET, whose time is then this program's; for the simulator only\n"
         "  --inputs WHERE     bumpers, switches and batteries from: can (the input node, default), pokeys:usb, pokeys:/dev/hidraw0 or\n"
         "                     pokeys:udp:HOST; pins in control/bus/README.md\n"
         "  --capture FILE     appends every frame to FILE, in candump's log format\n"
         "  --socket PATH      where hoist-server attaches (default /run/hoist/core.sock)\n"
         "  --params FILE      stored parameters; created at the first change (default: nothing is stored). FILE.stops beside it keeps\n"
         "                     how often the machine's own faults have stopped the hoist\n"
         "  --set NAME=VALUE   starts with this value (SI units) instead of the stored one; may be repeated\n"
         "  --cpu WHICH        core for the control thread: auto (one that the kernel keeps free, else the last; default), none or a "
         "number\n"
         "  --no-realtime      no real-time priority, no locked memory\n"
         "  --version          which source this program was built from\n"
         "  --help             this page\n\n"
         "Ends with a controlled stop on SIGINT or SIGTERM.\n";
}

// Empty when these options fit lock-step, which needs no priority: a busy computer slows simulated time, and no step is late.
std::string take_lock_step(Options& options) {
  if (!bus::StepLine::valid_path(options.bus.substr(kLockStep.size())))
    return "--bus sim: needs the socket of hoist-sim --lock-step, 1 to 107 characters";
  if (options.inputs != "can") return "--inputs " + options.inputs + ": a device of its own knows real time only; not with --bus sim:";
  options.real_time = false;
  return {};
}

// Empty when the arguments are fine, otherwise the sentence for people.
std::string parse(int argc, char** argv, Options& options, bool& help) {
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument == "--help" || argument == "-h") {
      help = true;
      return {};
    }
    if (argument == "--version") {
      options.version = true;
      return {};
    }
    if (argument == "--no-realtime") {
      options.real_time = false;
      continue;
    }
    std::string* text = argument == "--bus"       ? &options.bus
                        : argument == "--socket"  ? &options.socket
                        : argument == "--params"  ? &options.params
                        : argument == "--capture" ? &options.capture
                        : argument == "--inputs"  ? &options.inputs
                        : argument == "--cpu"     ? &options.cpu
                                                  : nullptr;
    if (text == nullptr && argument != "--set") return "unknown argument " + std::string(argument) + "; --help lists them";
    if (++i == argc) return std::string(argument) + " needs a value";
    if (text != nullptr)
      *text = argv[i];
    else
      options.set.emplace_back(argv[i]);
  }
  return is_lock_step(options.bus) ? take_lock_step(options) : std::string();
}

std::string apply_set(contract::Params& params, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos) return "--set needs NAME=VALUE, not " + assignment;
  const std::string name = assignment.substr(0, equals);
  const auto index = contract::find_param(name);
  if (!index) return "there is no parameter " + name;
  double value = 0;
  const char* end = assignment.data() + assignment.size();
  const auto [at, error] = std::from_chars(assignment.data() + equals + 1, end, value);
  const contract::ParamInfo& info = contract::kParams[*index];
  if (error != std::errc() || at != end || contract::check_param(*index, value) != contract::ParamCheck::ok) {
    char text[200];
    std::snprintf(text, sizeof text, "%s must be a number from %g to %g %s", name.c_str(), info.min, info.max,
                  std::string(info.unit).c_str());
    return text;
  }
  contract::set_param_unchecked(params, *index, value);
  return {};
}

// The stops of earlier runs; reports an unreadable file.
core::StopHistory earlier_stops(const std::string& path, const std::string& boot_id) {
  const run::LoadedStops loaded = run::load_stop_file(path, boot_id, now_ns(CLOCK_MONOTONIC));
  if (!loaded.problem.empty())
    std::cerr << "hoist-control: " << loaded.problem
              << "\n  How often the hoist has stopped is not known, so it starts out of service until an engineer releases it.\n";
  return loaded.history;
}

// Stores what has changed of the stops since the last call; what could not be stored is tried again with the next one.
class StopKeeper {
 public:
  StopKeeper(std::string path, std::string boot_id) : path_(std::move(path)), boot_id_(std::move(boot_id)) {}

  void serve(const run::ControlLoop& loop) {
    if (path_.empty()) return;
    waiting_ = loop.read_stops(history_, seen_) || waiting_;
    if (!waiting_) return;
    const std::string problem = run::save_stop_file(path_, boot_id_, history_);
    waiting_ = !problem.empty();
    if (waiting_ && problem != told_) std::cerr << "hoist-control: stops not stored: " << problem << std::endl;
    told_ = problem;
  }

 private:
  std::string path_, boot_id_, told_;
  core::StopHistory history_;
  std::uint64_t seen_ = 0;
  bool waiting_ = false;
};

struct ThreadWishes {
  bool real_time = true;
  std::uint8_t cpu = run::kNoCpu;
  bool memory_locked = false;
};

// What the control thread shares with the others.
struct LoopThread {
  std::atomic<bool> ready{false};  // `granted` and `id` are filled
  std::atomic<std::uint64_t> steps{0};
  std::atomic<bool> ended{false};
  run::Granted granted;
  int id = 0;
};

void control_thread(run::ControlLoop& loop, run::StepClock& clock, LoopThread& shared, const ThreadWishes& wishes) {
  ::prctl(PR_SET_TIMERSLACK, 1UL);  // without it an ordinary thread wakes 50 us late (measured)
  run::touch_stack();
  shared.granted = run::take_row(run::ThreadId::control, wishes.real_time, wishes.cpu);
  shared.id = ::gettid();
  loop.set_granted(shared.granted.priority, shared.granted.cpu, wishes.memory_locked);
  shared.ready.store(true);
  std::uint64_t stop_since_ns = 0;  // 0: not stopping
  const std::uint64_t heap_at_start = run::heap_requests();
  for (;;) {
    run::ControlLoop::Step step;
    clock.begin(step, stop_requested);
    step.stop = stop_since_ns == 0 && stop_requested.load(std::memory_order_relaxed);
    if (step.stop) stop_since_ns = step.time_ns;
    loop.note_allocations(static_cast<std::uint32_t>(run::heap_requests() - heap_at_start));
    loop.step(step);
    clock.end();
    shared.steps.store(shared.steps.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    if (stop_since_ns != 0 && (loop.standing_still() || step.time_ns - stop_since_ns > kStopWithinNs)) break;
  }
  shared.ended.store(true);
}

// Feeds the service manager's watchdog while steps continue.
void watchdog_thread(LoopThread& shared, run::Notifier& notifier, bool real_time) {
  static_cast<void>(run::take_row(run::ThreadId::watchdog, real_time, run::kNoCpu));
  const timespec pause{0, static_cast<long>(notifier.period_ns())};
  while (!shared.ended.load()) {
    ::clock_nanosleep(CLOCK_MONOTONIC, 0, &pause, nullptr);
    notifier.look(shared.steps.load(std::memory_order_relaxed));
  }
  notifier.tell("STOPPING=1");
}

// Counts the control thread's page faults once a second: from its second second on, because the first steps touch pages for the first time.
class PageFaultCount {
 public:
  void serve(run::ControlLoop& loop, int thread) {
    const std::uint64_t now = now_ns(CLOCK_MONOTONIC);
    if (now < next_ns_) return;
    next_ns_ = now + 1'000'000'000;
    const std::optional<std::uint64_t> faults = run::page_faults_of(thread);
    if (!faults) return;
    if (!settled_) settled_count_ = *faults;
    settled_ = true;
    loop.note_page_faults(static_cast<std::uint32_t>(*faults - settled_count_));
  }

 private:
  bool settled_ = false;
  std::uint64_t settled_count_ = 0;
  std::uint64_t next_ns_ = now_ns(CLOCK_MONOTONIC) + 1'000'000'000;
};

// Stores changed parameters and publishes the stored sequence for the server. A change waits at most one poll; the last poll comes after
// the last step.
void store_thread(publish::CoreLink& link, LoopThread& shared, run::ParameterStore store, bool real_time) {
  static_cast<void>(run::take_row(run::ThreadId::store, real_time, run::kNoCpu));
  constexpr timespec kLook{0, 50'000'000};
  std::string told;
  std::uint64_t stored = 0;  // sequence that needs no further look
  for (bool last = false;; ::clock_nanosleep(CLOCK_MONOTONIC, 0, &kLook, nullptr)) {
    last = shared.ended.load();
    if (!last && link.params_sequence() == stored) continue;
    contract::ParamsInForce in_force;
    if (const std::uint64_t sequence = link.params(in_force); sequence != 0) {
      const contract::StoreReport& report = store.look(in_force, sequence, now_ns(CLOCK_MONOTONIC));
      link.publish_store(report);
      stored = report.stored;
    }
    if (store.problem() != told) {
      told = store.problem();
      std::cerr << "hoist-control: " << (told.empty() ? "parameters are stored again" : "parameters not stored: " + told) << std::endl;
    }
    if (last) return;
  }
}

// One line for people: requested and granted real-time settings.
std::string describe(const run::Granted& granted, const std::string& lock_problem) {
  std::string text = granted.priority > 0 ? "real-time priority " + std::to_string(granted.priority) + " (SCHED_FIFO)" : granted.problem;
  text += granted.cpu == run::kNoCpu ? ", any processor core" : ", bound to processor core " + std::to_string(granted.cpu);
  if (granted.priority > 0 && !granted.problem.empty()) text += " (" + granted.problem + ")";
  text += lock_problem.empty() ? ", memory locked" : ", memory not locked (" + lock_problem + ")";
  if (granted.priority == 0 || !lock_problem.empty()) text += ": steps may be late when this computer is busy";
  return text;
}
}  // namespace

int main(int argc, char** argv) {
  ::umask(077);  // what this program writes is about patients or decides how hard they may be pushed: for its own user only
  Options options;
  bool help = false;
  if (const std::string problem = parse(argc, argv, options, help); !problem.empty()) {
    std::cerr << "hoist-control: " << problem << "\n";
    return 2;
  }
  if (help) {
    print_help();
    return 0;
  }
  if (options.version) {
    std::cout << "hoist-control " << contract::program_version() << "\n";
    return 0;
  }

  contract::Params params;
  if (!options.params.empty()) {
    const run::LoadedParams loaded = run::load_parameter_file(options.params);
    for (const std::string& remark : loaded.remarks) std::cerr << "hoist-control: " << remark << "\n";
    if (!loaded.usable) {
      std::cerr << "hoist-control: " << loaded.problem
                << "\n  Parameters decide how hard this machine may push a patient, so it does not start on guesses.\n"
                << "  Move the file away to start from the defaults.\n";
      return 1;
    }
    params = loaded.params;
  }
  const contract::Params stored = params;
  for (const std::string& assignment : options.set)
    if (const std::string problem = apply_set(params, assignment); !problem.empty()) {
      std::cerr << "hoist-control: " << problem << "\n";
      return 2;
    }
  if (const char* conflict = contract::check_param_set(params)) {
    std::cerr << "hoist-control: " << conflict << "\n";
    return 2;
  }

  std::string error;
  const std::optional<std::uint8_t> cpu = run::choose_cpu(options.cpu, run::isolated_cpus(), run::allowed_cpus(), error);
  if (!cpu) {
    std::cerr << "hoist-control: --cpu: " << error << "\n";
    return 2;
  }
  // Before any other thread is born, so that none inherits more than its row.
  run::Notifier notifier = run::Notifier::from_environment();
  static_cast<void>(run::take_row(run::ThreadId::main, options.real_time, run::kNoCpu));
  std::shared_ptr<bus::StepLine> lock_step;
  std::unique_ptr<bus::CanPort> port;
  if (is_lock_step(options.bus)) {
    lock_step = std::make_shared<bus::StepLine>(options.bus.substr(kLockStep.size()));
    port = std::make_unique<bus::SlcanPort>(lock_step);
  } else {
    port = bus::open_port(options.bus, error, bus::PortUse::core);
  }
  if (!port) {
    std::cerr << "hoist-control: " << error << "\n";
    return 2;
  }
  const bus::pokeys::InputPort* pokeys = nullptr;
  if (options.inputs != "can") {
    bus::pokeys::InputOptions inputs;
    if (const std::string problem = bus::pokeys::parse_inputs(options.inputs, inputs); !problem.empty()) {
      std::cerr << "hoist-control: --inputs: " << problem << "\n";
      return 2;
    }
    inputs.at_thread_start = [&options] { static_cast<void>(run::take_row(run::ThreadId::inputs, options.real_time, run::kNoCpu)); };
    auto with_inputs = std::make_unique<bus::pokeys::InputPort>(std::move(port), std::move(inputs));
    pokeys = with_inputs.get();
    port = std::move(with_inputs);
  }
  const bus::Capture* capture = nullptr;
  if (!options.capture.empty()) {
    const auto utc_offset_ns = static_cast<std::int64_t>(now_ns(CLOCK_REALTIME)) - static_cast<std::int64_t>(now_ns(CLOCK_MONOTONIC));
    constexpr std::string_view kSocketCan = "socketcan:";
    const std::string interface = options.bus.starts_with(kSocketCan) ? options.bus.substr(kSocketCan.size()) : "can0";
    std::unique_ptr<bus::Capture> opened = bus::Capture::open(options.capture, interface, utc_offset_ns, error);
    if (!opened) {
      std::cerr << "hoist-control: --capture: " << error << "\n";
      return 1;
    }
    capture = opened.get();
    port = std::make_unique<bus::CapturePort>(std::move(port), std::move(opened));
  }
  const std::uint64_t start_ns = now_ns(CLOCK_MONOTONIC);
  std::unique_ptr<publish::CoreLink> link = publish::CoreLink::create(
      options.socket, start_ns, now_ns(CLOCK_REALTIME), error, lock_step ? contract::ClockKind::simulated : contract::ClockKind::steady);
  if (!link) {
    std::cerr << "hoist-control: " << error << "\n";
    return 1;
  }

  struct sigaction action {};
  action.sa_handler = on_signal;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);

  const std::string stops_path = options.params.empty() ? std::string() : options.params + ".stops", boot_id = run::boot_id();
  run::ControlLoop loop(*port, *link, params, stops_path.empty() ? core::StopHistory{} : earlier_stops(stops_path, boot_id));
  StopKeeper stops(stops_path, boot_id);
  std::cout << "hoist-control: 100 Hz on " << options.bus << (lock_step ? " in the simulator's time" : "") << ", server socket "
            << options.socket << std::endl;
  const std::string lock_problem = options.real_time ? run::lock_memory() : std::string("not asked for");
  LoopThread shared;
  std::unique_ptr<run::StepClock> clock;
  if (lock_step)
    clock = std::make_unique<run::SimulatorClock>(*lock_step, start_ns);
  else
    clock = std::make_unique<run::SteadyClock>();
  const ThreadWishes wishes{options.real_time, *cpu, lock_problem.empty()};
  std::thread thread(control_thread, std::ref(loop), std::ref(*clock), std::ref(shared), std::cref(wishes));
  while (!shared.ready.load()) std::this_thread::yield();
  // Without a service manager the thread would only wake the processor.
  std::thread watchdog;
  if (notifier.listened_to()) watchdog = std::thread(watchdog_thread, std::ref(shared), std::ref(notifier), options.real_time);
  // A value given by --set holds for this run only: the file changes with the first changed parameter.
  std::thread store(store_thread, std::ref(*link), std::ref(shared), run::ParameterStore(options.params, params, stored),
                    options.real_time);
  if (options.real_time) std::cout << "hoist-control: " << describe(shared.granted, lock_problem) << std::endl;

  std::string_view bus_problem = port->problem();
  if (!bus_problem.empty()) std::cout << "hoist-control: bus: " << bus_problem << std::endl;
  PageFaultCount page_faults;
  bool capture_failed = false;
  std::optional<std::string_view> input_problem;  // nothing reported yet, so that a device that answers at once is reported too
  while (!shared.ended.load()) {
    if (const std::string_view now = port->problem(); now != bus_problem) {
      bus_problem = now;
      std::cout << "hoist-control: bus: " << (now.empty() ? "up" : now) << std::endl;
    }
    if (pokeys != nullptr)
      if (const std::string_view now = pokeys->input_problem(); now != input_problem) {
        input_problem = now;
        std::cout << "hoist-control: inputs: " << (now.empty() ? "come from the PoKeys" : now) << std::endl;
      }
    if (capture != nullptr && capture->failure() != 0 && !capture_failed) {
      capture_failed = true;
      std::cerr << "hoist-control: " << options.capture << ": " << std::strerror(capture->failure()) << "; nothing more is captured"
                << std::endl;
    }
    if (const std::string news = link->serve(100); !news.empty()) std::cout << "hoist-control: " << news << std::endl;
    stops.serve(loop);
    page_faults.serve(loop, shared.id);
  }
  thread.join();
  if (watchdog.joinable()) watchdog.join();
  store.join();
  stops.serve(loop);
  if (capture != nullptr && capture->dropped() > 0)
    std::cerr << "hoist-control: " << capture->dropped() << " frames are missing in " << options.capture << std::endl;
  std::cout << "hoist-control: stopped" << std::endl;
  return 0;
}
