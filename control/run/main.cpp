// hoist-control: the 100 Hz core on a real bus. Its threads are the rows of threads.def (threads.hpp). The main thread accepts the server,
// stores stops, counts page faults and waits for signals.
#include <sys/stat.h>

#include <atomic>
#include <csignal>
#include <ctime>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "control/contract/program_version.hpp"
#include "control/publish/core_link.hpp"
#include "control/run/control_loop.hpp"
#include "control/run/options.hpp"
#include "control/run/ports.hpp"
#include "control/run/real_time.hpp"
#include "control/run/step_clock.hpp"
#include "control/run/stop_file.hpp"
#include "control/run/threads.hpp"
#include "control/run/watchdog.hpp"

namespace {
using namespace hoist;
using run::Failure;
using run::Options;

std::atomic<bool> stop_requested{false};
void on_signal(int) { stop_requested.store(true); }

void stop_on_signals() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
}

std::uint64_t utc_ns() {
  timespec t{};
  ::clock_gettime(CLOCK_REALTIME, &t);
  return static_cast<std::uint64_t>(t.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(t.tv_nsec);
}

// Loads the stops of earlier runs, stores new ones, and tells the server and the journal when that fails.
class StopKeeper {
 public:
  // `path` empty: nothing is kept.
  explicit StopKeeper(std::string path) : store_(std::move(path)) {}

  core::StopHistory load() const {
    if (!store_.keeps_times())
      std::cerr << "hoist-control: the boot id is unknown: each restart of this program counts earlier stops as new\n";
    const run::LoadedStops loaded = store_.load(run::steady_ns());
    if (!loaded.problem.empty())
      std::cerr << "hoist-control: " << loaded.problem
                << "\n  How often the hoist has stopped is not known, so it starts out of service until an engineer releases it.\n";
    return loaded.history;
  }

  void serve(const run::ControlLoop& loop, publish::CoreLink& link) {
    link.publish_stops_problem(store_.look(loop.read_stops(history_, seen_) ? &history_ : nullptr));
    if (store_.problem() == told_) return;
    told_ = store_.problem();
    std::cerr << "hoist-control: " << (told_.empty() ? "stops are stored again" : "stops not stored: " + told_) << std::endl;
  }

 private:
  run::StopStore store_;
  std::string told_;
  core::StopHistory history_;
  std::uint64_t seen_ = 0;
};

// Counts the control thread's page faults once a second: from its second second on, because the first steps touch pages for the first time.
class PageFaultCount {
 public:
  void serve(run::ControlLoop& loop, int thread) {
    const std::uint64_t now = run::steady_ns();
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
  std::uint64_t next_ns_ = run::steady_ns() + 1'000'000'000;
};

// One line for people: requested and granted real-time settings.
std::string describe(const run::Granted& granted, const std::string& lock_problem) {
  std::string text = granted.priority > 0 ? "real-time priority " + std::to_string(granted.priority) + " (SCHED_FIFO)" : granted.problem;
  text += granted.cpu == run::kNoCpu ? ", any processor core" : ", bound to processor core " + std::to_string(granted.cpu);
  if (granted.priority > 0 && !granted.problem.empty()) text += " (" + granted.problem + ")";
  text += lock_problem.empty() ? ", memory locked" : ", memory not locked (" + lock_problem + ")";
  if (granted.priority == 0 || !lock_problem.empty()) text += ": steps may be late when this computer is busy";
  return text;
}

// What one run needs before its first step.
struct Prepared {
  run::StartParams params;
  std::uint8_t cpu = run::kNoCpu;
  run::Ports ports;
  std::uint64_t start_ns = 0;
  std::unique_ptr<publish::CoreLink> link;
};

// Everything that can refuse the start.
Failure prepare(const Options& options, Prepared& prepared) {
  if (Failure failure = run::load_start_params(options, prepared.params)) return failure;
  std::string error;
  const std::optional<std::uint8_t> cpu = run::choose_cpu(options.cpu, run::isolated_cpus(), run::allowed_cpus(), error);
  if (!cpu) return {run::kBadArguments, "--cpu: " + error};
  prepared.cpu = *cpu;
  // Before any other thread starts, so that none inherits more than its row.
  static_cast<void>(run::take_row(run::ThreadId::main, options.real_time, run::kNoCpu));
  const auto utc_offset_ns = static_cast<std::int64_t>(utc_ns()) - static_cast<std::int64_t>(run::steady_ns());
  if (Failure failure = run::open_ports(options, utc_offset_ns, prepared.ports)) return failure;
  prepared.start_ns = run::steady_ns();
  prepared.link = publish::CoreLink::create(options.socket, prepared.start_ns, utc_ns(), error,
                                            prepared.ports.lock_step ? contract::ClockKind::simulated : contract::ClockKind::steady);
  return prepared.link ? Failure{} : Failure{run::kBadComputer, error};
}

std::unique_ptr<run::StepClock> step_clock(const Prepared& prepared) {
  if (prepared.ports.lock_step) return std::make_unique<run::SimulatorClock>(*prepared.ports.lock_step, prepared.start_ns);
  return std::make_unique<run::SteadyClock>();
}

// Steps until a signal has stopped the hoist.
void run_until_stopped(const Options& options, Prepared& prepared, run::Notifier& notifier) {
  publish::CoreLink& link = *prepared.link;
  StopKeeper stops(options.params.empty() ? std::string() : options.params + ".stops");
  run::ControlLoop loop(*prepared.ports.port, link, prepared.params.in_force, stops.load());
  std::cout << "hoist-control: 100 Hz on " << options.bus << (prepared.ports.lock_step ? " in the simulator's time" : "")
            << ", server socket " << options.socket << std::endl;
  const std::string lock_problem = options.real_time ? run::lock_memory() : std::string("not asked for");
  run::LoopThread shared;
  const std::unique_ptr<run::StepClock> clock = step_clock(prepared);
  const run::ThreadWishes wishes{options.real_time, prepared.cpu, lock_problem.empty()};
  std::thread control(run::control_thread, std::ref(loop), std::ref(*clock), std::ref(shared), std::cref(wishes),
                      std::cref(stop_requested));
  while (!shared.ready.load()) std::this_thread::yield();
  // Without a service manager the thread would only wake the processor.
  std::thread watchdog;
  if (notifier.listened_to()) watchdog = std::thread(run::watchdog_thread, std::ref(shared), std::ref(notifier), options.real_time);
  // A value given by --set holds for this run only: the file changes with the first changed parameter.
  std::thread store(run::store_thread, std::ref(link), std::ref(shared),
                    run::ParameterStore(options.params, prepared.params.in_force, prepared.params.stored), options.real_time);
  if (options.real_time) std::cout << "hoist-control: " << describe(shared.granted, lock_problem) << std::endl;

  run::PortReporter ports(prepared.ports, options);
  PageFaultCount page_faults;
  while (!shared.ended.load()) {
    ports.serve();
    if (const std::string news = link.serve(100); !news.empty()) std::cout << "hoist-control: " << news << std::endl;
    stops.serve(loop, link);
    page_faults.serve(loop, shared.id);
  }
  control.join();
  if (watchdog.joinable()) watchdog.join();
  store.join();
  stops.serve(loop, link);
  ports.report_dropped();
}
}  // namespace

int main(int argc, char** argv) {
  ::umask(077);  // what this program writes is about patients or decides how hard they may be pushed: for its own user only
  Options options;
  Failure failure = run::parse_options(argc, argv, options);
  if (options.help) {
    std::cout << run::help_text();
    return 0;
  }
  if (options.version) {
    std::cout << "hoist-control " << contract::program_version() << "\n";
    return 0;
  }
  Prepared prepared;
  if (!failure) failure = prepare(options, prepared);
  if (failure) {
    std::cerr << "hoist-control: " << failure.text << "\n";
    return failure.exit_code;
  }
  run::Notifier notifier = run::Notifier::from_environment();
  stop_on_signals();
  run_until_stopped(options, prepared, notifier);
  std::cout << "hoist-control: stopped" << std::endl;
  return 0;
}
