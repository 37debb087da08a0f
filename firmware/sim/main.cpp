// hoist-sim: the simulated hoist as a program. It runs the world in lock-step with hoist-control, or in real time behind a pseudo terminal that
// speaks SLCAN like the real gateway, or with its nodes directly on a CAN interface of the kernel; hoist-control drives it unchanged.
#include <sched.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "control/bus/can_port.hpp"
#include "control/contract/program_version.hpp"
#include "firmware/sim/hidden_errors.hpp"
#include "firmware/sim/lock_step.hpp"
#include "firmware/sim/patient_family.hpp"
#include "firmware/sim/pokeys_device.hpp"
#include "firmware/sim/request_socket.hpp"
#include "firmware/sim/requests.hpp"
#include "firmware/sim/serial_line.hpp"
#include "firmware/sim/world.hpp"

namespace {

using namespace hoist::sim;

constexpr std::int64_t kStep_ns = 1'000'000;
/// Longest catch-up at once; beyond it simulated time did not pass, as on a suspended machine. Well below the drives' 45 ms deadline: the
/// steps of a catch-up see no new command, and a busy computer must not look like a dead controller.
constexpr std::int64_t kCatchUp_ns = 5 * kStep_ns;
/// In lock-step the core takes part in each step of a catch-up, so it may be longer. Bounded, because commands of a person at the screen
/// age by the wall clock and slow the hoist from 150 ms.
constexpr std::int64_t kLockStepCatchUp_ns = 50 * kStep_ns;
constexpr int kAnswerLook_ms = 20;  // how often a wait for the core looks after requests and signals
/// Below hoist-control's 49, so that the simulated machine never delays the controller; above everything ordinary, so that a busy computer
/// does not delay the simulated sensors.
constexpr int kRealTimePriority = 30;
/// A busy computer skips time many times a second: one line per interval reports how often and how much, and small amounts are not reported.
constexpr std::int64_t kReportLateEvery_ns = 10'000'000'000;
constexpr std::int64_t kReportLateFrom_ns = 20'000'000;
/// 1 Mbaud with ten bits a character.
constexpr std::size_t kUartBytesPerStep = 100;
constexpr std::uint64_t kServeEverySteps = 5;

volatile std::sig_atomic_t g_end = 0;
void on_signal(int) { g_end = 1; }

struct Options {
  WorldOptions world;
  std::string link;
  std::string control;
  std::string bus;
  std::string lock_step;         // socket; empty: real time
  std::uint16_t pokeys_port{0};  // 0: the input node is on the bus
  double virtual_s{0.0};
};

void print_usage() {
  std::puts(
      "hoist-sim: a simulated hoist with a walking patient, on a pseudo terminal that speaks SLCAN like the real gateway, or on a CAN\n"
      "interface.\n"
      "  --scenario NAME     what the patient does (default figure-eight; --list names them)\n"
      "  --patient NAME      who walks: a patient with the gait of an illness (--list names them); without, an even walk\n"
      "  --list              the scenarios and the patients, one a line\n"
      "  --lock-step PATH    step together with hoist-control --bus sim:PATH, no faster than real time: a busy computer slows the\n"
      "                      simulated time and stops no walk\n"
      "  --pty-link PATH     put a symbolic link to the pseudo terminal there\n"
      "  --bus ADDRESS       the simulated nodes on a CAN interface, socketcan:NAME, instead of the pseudo terminal\n"
      "  --pokeys-udp PORT   bumpers and batteries from a PoKeys57E at 127.0.0.1:PORT instead of the input node on the bus\n"
      "  --control PATH      answer requests (JSON lines) at this Unix socket; {\"op\":\"help\"} lists them\n"
      "  --seed N            seed of the sensors' noise and of the patient's uneven gait (default 1)\n"
      "  --speed WISH_M_S    speed the patient likes to walk, 0.05 to 0.8 (default 0.30)\n"
      "  --patient-mass KG   30 to 150 (default 75)\n"
      "  --machine-seed N    another machine: its lengths, its sensors' mounting and its wheels stray from the design, for calibration\n"
      "  --patient-seed N    another patient of an even walk: all parameters drawn from their usual ranges\n"
      "  --virtual SECONDS   run the world alone as fast as possible, say how fast, and end\n"
      "  --version           which source this program was built from");
}

std::optional<double> number(std::string_view text, double low, double high) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value) || value < low || value > high) return std::nullopt;
  return value;
}
std::optional<std::uint64_t> whole(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

[[noreturn]] void refuse(const std::string& why) {
  std::fprintf(stderr, "hoist-sim: %s\n", why.c_str());
  std::exit(2);
}

Options read_options(int argc, char** argv) {
  Options options;
  std::optional<double> wish_m_s, mass_kg;
  const FamilyMember* member = nullptr;
  std::optional<std::uint64_t> patient_seed;
  for (int i = 1; i < argc; ++i) {
    const std::string_view name = argv[i];
    if (name == "--help" || name == "-h") {
      print_usage();
      std::exit(0);
    }
    if (name == "--version") {
      std::printf("hoist-sim %s\n", std::string(hoist::contract::program_version()).c_str());
      std::exit(0);
    }
    if (name == "--list") {
      for (const Scenario& scenario : kScenarios)
        std::printf("%-14.*s %.*s\n", static_cast<int>(scenario.name.size()), scenario.name.data(), static_cast<int>(scenario.title.size()),
                    scenario.title.data());
      std::puts("patients, for --patient:");
      for (const FamilyMember& one : kPatientFamily)
        std::printf("%-14.*s %.*s\n", static_cast<int>(one.name.size()), one.name.data(), static_cast<int>(one.title.size()),
                    one.title.data());
      std::exit(0);
    }
    constexpr std::array<std::string_view, 13> kNames{"--scenario",  "--pty-link",     "--pokeys-udp",  "--bus",          "--control",
                                                      "--seed",      "--speed",        "--patient",     "--patient-mass", "--virtual",
                                                      "--lock-step", "--patient-seed", "--machine-seed"};
    bool known = false;
    for (const std::string_view one : kNames) known = known || one == name;
    if (!known) refuse("unknown option '" + std::string(name) + "'; --help lists them");
    if (i + 1 == argc) refuse(std::string(name) + " needs a value");
    const std::string_view value = argv[++i];
    if (name == "--scenario") {
      options.world.scenario = find_scenario(value);
      if (options.world.scenario == nullptr) refuse("--scenario: no '" + std::string(value) + "'; --list names them");
    } else if (name == "--pty-link") {
      options.link = value;
    } else if (name == "--bus") {
      options.bus = value;
      if (!value.starts_with("socketcan:")) refuse("--bus: socketcan:NAME, for example socketcan:vcan0");
    } else if (name == "--pokeys-udp") {
      const auto port = whole(value);
      if (!port || *port < 1 || *port > 65535) refuse("--pokeys-udp: a port from 1 to 65535");
      options.pokeys_port = static_cast<std::uint16_t>(*port);
    } else if (name == "--control") {
      options.control = value;
    } else if (name == "--lock-step") {
      options.lock_step = value;
    } else if (name == "--seed") {
      const auto seed = whole(value);
      if (!seed) refuse("--seed: a whole number from 0");
      options.world.seed = *seed;
    } else if (name == "--speed") {
      wish_m_s = number(value, 0.05, 0.8);
      if (!wish_m_s) refuse("--speed: 0.05 to 0.8 m/s");
    } else if (name == "--patient") {
      member = find_patient(value);
      if (member == nullptr) refuse("--patient: no '" + std::string(value) + "'; --list names them");
    } else if (name == "--patient-mass") {
      mass_kg = number(value, 30.0, 150.0);
      if (!mass_kg) refuse("--patient-mass: 30 to 150 kg");
    } else if (name == "--machine-seed") {
      const auto seed = whole(value);
      if (!seed) refuse("--machine-seed: a whole number from 0");
      options.world.plant = with_hidden_errors(options.world.plant, *seed);
    } else if (name == "--patient-seed") {
      const auto seed = whole(value);
      if (!seed) refuse("--patient-seed: a whole number from 0");
      patient_seed = *seed;
    } else {
      const auto seconds = number(value, 0.001, 1e7);
      if (!seconds) refuse("--virtual: 0.001 to 10000000 s");
      options.virtual_s = *seconds;
    }
  }
  if (member != nullptr && patient_seed) refuse("--patient and --patient-seed: one of them");
  if (patient_seed) options.world.patient = PatientParams::random(*patient_seed);
  if (member != nullptr) options.world.patient = member->params;
  options.world.patient.variation.seed = options.world.seed;
  if (wish_m_s) options.world.patient.wish_m_s = *wish_m_s;
  if (mass_kg) options.world.patient.mass_kg = *mass_kg;
  if (!options.bus.empty() && !options.link.empty()) refuse("--bus and --pty-link: one of them");
  if (!options.lock_step.empty() && !(options.bus.empty() && options.link.empty() && options.pokeys_port == 0))
    refuse("--lock-step: not with --bus, --pty-link or --pokeys-udp, whose other ends know real time only");
  options.world.host_in_process = !options.bus.empty();
  return options;
}

int run_virtual(const Options& options) {
  World world(options.world);
  const auto steps = static_cast<std::uint64_t>(std::llround(options.virtual_s * 1000.0));
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint64_t i = 0; i < steps && g_end == 0; ++i) world.advance_1ms();
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::printf("simulated %.3f s in %.3f s: %.0f times real time, no computer attached; digest %016llx\n", world.time_s(), took_s,
              world.time_s() / std::max(took_s, 1e-9), static_cast<unsigned long long>(world.digest()));
  return 0;
}

std::int64_t steady_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}
void wait_until(std::int64_t when_ns) {
  const timespec when{static_cast<time_t>(when_ns / 1'000'000'000), static_cast<long>(when_ns % 1'000'000'000)};
  ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &when, nullptr);  // a signal ends it early; the loop looks
}

// One line per event, none for continuing states.
class Reporter {
 public:
  Reporter(const char* attached, const char* detached) : attached_text_(attached), detached_text_(detached) {}
  void report(const World& world, const ProgramState& program) {
    if (program.computer_attached != attached_) say(world, program.computer_attached ? attached_text_ : detached_text_);
    if (world.drives_enabled() != enabled_) say(world, world.drives_enabled() ? "drives enabled" : "drives disabled");
    if (world.patient().state() != patient_) say(world, "patient is " + std::string(patient_state_name(world.patient().state())));
    attached_ = program.computer_attached;
    enabled_ = world.drives_enabled();
    patient_ = world.patient().state();
  }

  /// Time was skipped. It is reported with the next line.
  void let_go(const World& world, std::int64_t now_ns, std::int64_t gone_ns) {
    ++late_times_;
    late_ns_ += gone_ns;
    if (late_ns_ < kReportLateFrom_ns || now_ns - reported_late_ns_ < kReportLateEvery_ns) return;
    say(world, "was late " + std::to_string(late_times_) + " times and let " + std::to_string(late_ns_ / 1'000'000) + " ms go");
    reported_late_ns_ = now_ns;
    late_times_ = 0;
    late_ns_ = 0;
  }

 private:
  static void say(const World& world, const std::string& what) {
    std::printf("hoist-sim %8.2f s: %s\n", world.time_s(), what.c_str());
    std::fflush(stdout);
  }
  std::string attached_text_, detached_text_;
  bool attached_{false};
  bool enabled_{false};
  PatientState patient_{PatientState::standing};
  std::uint64_t late_times_{};  // since the last line about it
  std::int64_t late_ns_{};
  std::int64_t reported_late_ns_{-kReportLateEvery_ns};
};

// Moves characters between the terminal and the gateway, no faster than the real line.
class Pump {
 public:
  /// Where a request cuts the line.
  [[nodiscard]] bool* cut() { return &cut_; }
  template <class Line>  // SerialLine, LockStep
  void run(Line& line, World& world, ProgramState& program) {
    const SerialLine::Presence presence = line.presence();
    if (presence.changed) {
      world.uart_hang_up();
      in_size_ = out_size_ = 0;
    }
    program.computer_attached = presence.there;
    if (cut_) {
      // Both ends keep sending, and nothing arrives.
      std::array<char, kUartBytesPerStep> lost{};
      static_cast<void>(line.read(lost));
      static_cast<void>(world.uart_read(lost));
      in_size_ = out_size_ = 0;
      return;
    }
    if (in_size_ == 0) in_size_ = line.read(in_);
    const std::size_t taken = world.uart_write(std::span<const char>(in_).first(in_size_));
    std::memmove(in_.data(), in_.data() + taken, in_size_ - taken);
    in_size_ -= taken;

    out_size_ += world.uart_read(std::span<char>(out_).subspan(out_size_));
    if (!presence.there) out_size_ = 0;  // into an open end
    if (out_size_ == 0) return;
    const std::size_t put = line.write(std::span<const char>(out_).first(out_size_));
    std::memmove(out_.data(), out_.data() + put, out_size_ - put);
    out_size_ -= put;
  }

 private:
  std::array<char, kUartBytesPerStep> in_{};
  std::array<char, kUartBytesPerStep> out_{};
  std::size_t in_size_{};
  std::size_t out_size_{};
  bool cut_{false};
};

// Moves frames between a CAN interface and the simulated bus. The simulated bus has bit times and arbitration, so it delivers in one
// millisecond what 250 kbit/s carry in one; and a frame from the interface waits for arbitration on the simulated wire.
class Bridge {
 public:
  void run(hoist::bus::CanPort& port, World& world, ProgramState& program, std::uint64_t now_ns) {
    const std::size_t heard = port.receive(frames_, now_ns);
    // What the simulated port has no room for is refused and counted there.
    for (std::size_t i = 0; i < heard; ++i) static_cast<void>(world.host_send(frames_[i]));
    program.computer_attached = port.up();
    port.send(std::span<const hoist::contract::CanFrame>(frames_).first(world.host_receive(frames_)), now_ns);
  }

 private:
  std::array<hoist::contract::CanFrame, 256> frames_{};
};

void introduce(const Options& options, const std::string& where) {
  const Scenario& scenario = *options.world.scenario;
  std::printf("hoist-sim: SIMULATION, no real hoist. Scenario %.*s: the patient (%.0f kg, %.2f m/s) %.*s. %s\n",
              static_cast<int>(scenario.name.size()), scenario.name.data(), options.world.patient.mass_kg, options.world.patient.wish_m_s,
              static_cast<int>(scenario.title.size()), scenario.title.data(), where.c_str());
  std::fflush(stdout);
}

// The world advances by one period of the core, then waits for its answer. Without a core time follows the wall clock, and the drives stop
// by themselves.
int run_lock_step(const Options& options) {
  constexpr auto kPeriod_ns = static_cast<std::int64_t>(hoist::contract::kStepPeriod_ns);
  World world(options.world);
  LockStep line;
  if (const std::string why = line.open(options.lock_step); !why.empty()) refuse("--lock-step: " + why);
  RequestSocket requests;
  if (!options.control.empty())
    if (const std::string why = requests.open(options.control); !why.empty()) refuse(why);
  introduce(options, "In lock-step with hoist-control at " + options.lock_step);

  Pump pump;
  ProgramState program;
  program.line_cut = pump.cut();
  Reporter reporter("hoist-control takes the steps", "no hoist-control; time goes by the wall clock");
  const auto serve = [&] { requests.serve([&](std::string_view request) { return answer_request(world, program, request); }); };
  std::int64_t due_ns = steady_ns() + kPeriod_ns;
  while (g_end == 0) {
    wait_until(due_ns);
    const std::int64_t now_ns = steady_ns();
    if (now_ns - due_ns > kLockStepCatchUp_ns) {
      ++program.late;
      reporter.let_go(world, now_ns, now_ns - due_ns);
      due_ns = now_ns;
    }
    due_ns += kPeriod_ns;
    for (std::int64_t i = 0; i < kPeriod_ns / kStep_ns; ++i) {
      pump.run(line, world, program);
      world.advance_1ms();
    }
    serve();
    reporter.report(world, program);
    line.give();
    LockStep::Answer answer = line.take(kAnswerLook_ms);
    for (; answer == LockStep::Answer::waiting && g_end == 0; answer = line.take(kAnswerLook_ms)) serve();
    if (answer == LockStep::Answer::lost) std::printf("hoist-sim %8.2f s: hoist-control %s\n", world.time_s(), line.why());
  }
  std::puts("hoist-sim: ended");
  return 0;
}

int run_real_time(const Options& options) {
  World world(options.world);
  SerialLine line;
  std::unique_ptr<hoist::bus::CanPort> port;
  if (!options.bus.empty()) {
    std::string error;
    port = hoist::bus::open_port(options.bus, error);
    if (!port) refuse(error);
  } else if (const std::string why = line.open(options.link); !why.empty()) {
    refuse(why);
  }
  PokeysDevice pokeys;
  if (options.pokeys_port != 0) {
    if (const std::string why = pokeys.open(options.pokeys_port); !why.empty()) refuse(why);
    world.unplug(hoist::contract::Node::io, true);
  }
  RequestSocket requests;
  if (!options.control.empty())
    if (const std::string why = requests.open(options.control); !why.empty()) refuse(why);
  ::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
  const sched_param priority{kRealTimePriority};
  if (::sched_setscheduler(0, SCHED_FIFO, &priority) != 0)
    std::puts("hoist-sim: no real-time priority: on a busy computer simulated time will lag");

  introduce(options, port ? "Nodes on " + options.bus : "SLCAN at " + (options.link.empty() ? line.path() : options.link));

  ProgramState program;
  if (options.pokeys_port != 0) program.pokeys = &pokeys;
  Reporter reporter(port ? "the interface is up" : "a computer has opened the line", port ? "the interface is down" : "the line is closed");
  Pump pump;
  if (!port) program.line_cut = pump.cut();
  Bridge bridge;
  std::uint64_t steps = 0;
  std::int64_t due_ns = steady_ns() + kStep_ns;
  while (g_end == 0) {
    wait_until(due_ns);
    const std::int64_t now_ns = steady_ns();
    if (now_ns - due_ns > kCatchUp_ns) {
      ++program.late;
      reporter.let_go(world, now_ns, now_ns - due_ns);
      due_ns = now_ns;
    }
    while (due_ns <= now_ns) {
      if (port)
        bridge.run(*port, world, program, static_cast<std::uint64_t>(now_ns));
      else
        pump.run(line, world, program);
      world.advance_1ms();
      pokeys.serve({world.plant().bumpers(), world.plant().switches(), {world.plant().battery_v(0), world.plant().battery_v(1)}});
      due_ns += kStep_ns;
      if (++steps % kServeEverySteps == 0)
        requests.serve([&world, &program](std::string_view request) { return answer_request(world, program, request); });
      reporter.report(world, program);
    }
  }
  std::puts("hoist-sim: ended");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  ::umask(077);  // as all programs that write: its sockets are for its own user only
  struct sigaction action {};
  action.sa_handler = on_signal;
  ::sigaction(SIGTERM, &action, nullptr);
  ::sigaction(SIGINT, &action, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
  const Options options = read_options(argc, argv);
  if (options.virtual_s > 0.0) return run_virtual(options);
  return options.lock_step.empty() ? run_real_time(options) : run_lock_step(options);
}
