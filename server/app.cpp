#include "server/app.hpp"

#include <unistd.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <filesystem>
#include <future>
#include <iostream>
#include <optional>
#include <utility>

#include "control/contract/program_version.hpp"
#include "db/store/retention.hpp"
#include "server/actions/actions.hpp"
#include "server/api/router.hpp"
#include "server/http/auth.hpp"
#include "server/http/listener.hpp"
#include "server/jobs/jobs.hpp"
#include "server/link/core_desk.hpp"
#include "server/link/firmware_desk.hpp"
#include "server/live/hub.hpp"
#include "server/record/recorder.hpp"
#include "server/services.hpp"
#include "server/state/hoist_state.hpp"

namespace hoist::server {

namespace asio = boost::asio;

namespace {
constexpr std::uint64_t kPoll_ns = 10'000'000;
// The core publishes within the first millisecond of its step; looking a little later finds every step at its freshest.
constexpr std::uint64_t kPhase_ns = 2'000'000;
constexpr int kGoodbye_ms = 300;

std::uint64_t steady_ns() {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count());
}
// Also of a database that an earlier version or a copy left readable for others: SQLite gives the two files beside it the same mode.
void make_private(const std::filesystem::path& database) {
  using std::filesystem::perms;
  std::error_code ignored;
  for (const char* suffix : {"", "-wal", "-shm"}) {
    const std::filesystem::path file = database.string() + suffix;
    if (std::filesystem::is_regular_file(file, ignored))
      std::filesystem::permissions(file, perms::owner_read | perms::owner_write, ignored);
  }
}

std::string host_name() {
  std::array<char, 65> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : std::string();
}

std::int64_t utc_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}
}  // namespace

struct App::Parts {
  explicit Parts(Settings settings_in)
      : settings(std::move(settings_in)),
        actors(static_cast<std::uint32_t>(std::stoul(random_hex(3), nullptr, 16)) << 6U),
        core(settings.socket_path, counters),
        firmware(core),
        jobs({.tools = {.file = settings.db_path,
                        .utc_ns = &utc_ns,
                        .backup_roots = settings.backup_roots,
                        .device = host_name(),
                        .program = std::string{contract::program_version()},
                        .other_databases = {std::filesystem::path(settings.db_path).replace_filename("accounts.db")},
                        .identity_key = settings.db_path.string() + ".key",
                        .replace_file = [this](const std::filesystem::path& prepared) { return replace_file(prepared); }},
              .on_damage = [this](const db::IntegrityReport& report) { recorder.set_aside(report.file_id, report.structure.front()); }}),
        recorder(core.link(), {.file = settings.db_path,
                               .version = std::string{contract::program_version()},
                               .utc_ns = &utc_ns,
                               .steady_ns = &steady_ns,
                               .actor_of = [this](std::uint32_t client) { return actors.find(client); },
                               // The start waits for no check; each file is checked once it is in use.
                               .opened =
                                   [this](db::Database& database) {
                                     (void)jobs.add(JobKind::integrity_check, {}, std::nullopt);
                                     if (const auto keeps = db::retention(database); keeps && keeps->months)
                                       (void)jobs.add(JobKind::retention, {}, std::nullopt);
                                   }}),
        records(recorder, [this](std::function<void()> work) { asio::post(io, std::move(work)); }),
        state(settings, core, recorder),
        timer(io),
        goodbye(io) {}

  // On the jobs' thread: waits for the recorder, whose file it is.
  db::Result<std::filesystem::path> replace_file(const std::filesystem::path& prepared) {
    const db::Error busy{db::ErrorKind::busy, "The recorder is busy or ends: try again later.", {}};
    auto promise = std::make_shared<std::promise<db::Result<std::filesystem::path>>>();
    auto answer = promise->get_future();
    if (!recorder.run([promise = std::move(promise), prepared, busy](Records& on) {
          promise->set_value(on.late() ? busy : on.replace_file(prepared));
        }))
      return busy;
    try {
      return answer.get();
    } catch (const std::future_error&) {
      return busy;
    }
  }

  void arm() {
    // An absolute raster, so that no delay adds up; its phase follows the core's when there is one. Each step while a client drives or waits
    // for an answer, else once per batch of samples.
    const std::uint64_t steps = core.urgent() || firmware.busy() ? 1 : hub.samples_missing();
    next_ns += steps * kPoll_ns;
    const std::uint64_t now = steady_ns();
    if (core.newest()) {
      const std::uint64_t tick_ns = core.newest()->time_ns;
      if (tick_ns <= now && now - tick_ns < 2 * kPoll_ns)
        next_ns = tick_ns + kPhase_ns + ((now - tick_ns + kPoll_ns - kPhase_ns) / kPoll_ns + steps - 1) * kPoll_ns;
    }
    if (next_ns <= now || next_ns > now + (steps + 1) * kPoll_ns) next_ns = now + kPoll_ns;
    timer.expires_at(std::chrono::steady_clock::time_point(std::chrono::nanoseconds(next_ns)));
    timer.async_wait([this](boost::system::error_code error) {
      if (error || ending) return;
      poll();
      arm();
    });
  }

  // Something was asked while the timer sleeps for a batch: the answer comes with the next step.
  void wake() {
    if (!ending && next_ns > steady_ns() + kPoll_ns) arm();
  }

  void poll() {
    const std::uint64_t now = steady_ns();
    core.poll(now);
    if (const std::string_view problem = core.problem(); problem != told_problem) {
      told_problem = problem;
      std::cerr << "hoist-server: " << (problem.empty() ? "the control core is connected" : problem) << std::endl;
    }
    firmware.poll(core.clock_ns());
    tell_recorder_of_nodes();
    hub.poll(now);
    if (core.lease_holder() != 0) free_silent_lease(now);
  }

  // A lease taken over REST has no connection that could end: it is given back when its session falls silent.
  void free_silent_lease(std::uint64_t now) {
    auth->each_session([&](Session& session) {
      if (session.client != core.lease_holder()) return;
      // A client that watches its update need not ask all the time.
      if (session.client == firmware.client()) session.used_ns = now;
      if (now - session.used_ns < kRestLease_ns) return;
      session.used_ns = now;
      act_release_lease(*services, {session.client, core.lease_epoch(), session.role}, [](const Outcome&) {});
    });
  }

  void tell_recorder_of_nodes() {
    std::array<NodeSaid, contract::kRemoteNodeCount> said;
    for (std::size_t n = 0; n < said.size(); ++n) said[n] = firmware.said(static_cast<contract::Node>(n));
    if (said == told_nodes) return;
    told_nodes = said;
    std::vector<db::NodeProgram> nodes;
    for (std::size_t n = 0; n < said.size(); ++n)
      nodes.push_back({std::string{contract::kNodes[n].name}, said[n].product, said[n].revision, said[n].version, said[n].crc});
    recorder.set_nodes(std::move(nodes));
  }

  void end() {
    if (ending) return;
    ending = true;
    timer.cancel();
    hub.close_all();
    listener->close();
    goodbye.expires_after(std::chrono::milliseconds(kGoodbye_ms));
    goodbye.async_wait([this](boost::system::error_code) { io.stop(); });
  }

  Settings settings;
  Counters counters;
  std::unique_ptr<TlsContext> tls;  // null: plain
  asio::io_context io{1};
  ActorList actors;
  CoreDesk core;
  FirmwareDesk firmware;
  Jobs jobs;
  Recorder recorder;
  RecorderDesk records;
  HoistState state;
  Hub hub;
  std::unique_ptr<Auth> auth;
  std::unique_ptr<Services> services;
  std::unique_ptr<RestContext> rest;
  std::unique_ptr<Router> router;
  std::unique_ptr<Listener> listener;
  asio::steady_timer timer;
  asio::steady_timer goodbye;
  std::uint64_t next_ns = 0;
  std::optional<std::array<NodeSaid, contract::kRemoteNodeCount>> told_nodes;  // by the recorder's last list
  std::string told_problem;                                                    // why the core is not connected, as told last
  bool ending = false;
};

App::App(Settings settings) : parts_(std::make_unique<Parts>(std::move(settings))) {}

App::~App() {
  // The threads of jobs and recorder end first: then nothing posts any more. What waits is answered and every connection goes while all
  // that it uses is still there.
  Parts& p = *parts_;
  p.jobs.stop();
  p.recorder.stop();
  p.core.clear_listeners();
  p.core.close();
  if (p.listener) p.listener->drop();
  p.io.restart();
  p.io.poll();
}

bool App::start(std::string& error) {
  Parts& p = *parts_;
  if (!p.settings.tls_cert.empty()) {
    p.tls = TlsContext::load(p.settings.tls_cert, p.settings.tls_key, error);
    if (!p.tls) return false;
  }
  p.auth = Auth::create({.token_file = p.settings.token_file, .hosts = p.settings.hosts, .secure = p.tls != nullptr},
                        static_cast<std::uint64_t>(utc_ns() / 1'000'000'000), error);
  if (!p.auth) return false;
  p.services.reset(new Services{.settings = p.settings,
                                .counters = p.counters,
                                .core = p.core,
                                .firmware = p.firmware,
                                .state = p.state,
                                .recorder = p.recorder,
                                .records = p.records,
                                .jobs = p.jobs,
                                .now_ns = &steady_ns,
                                .utc_ns = &utc_ns,
                                .actors = p.actors,
                                .started_utc_ns = utc_ns(),
                                .started_ns = steady_ns()});
  p.hub.set_services(*p.services, *p.auth);
  p.core.add_listener(p.state);
  p.core.add_listener(p.hub);
  p.rest.reset(new RestContext{.services = *p.services,
                               .auth = *p.auth,
                               .open_live = [&p](std::unique_ptr<Stream> stream, std::shared_ptr<void> seat, SessionPtr session) {
                                 p.hub.open(std::move(stream), std::move(seat), std::move(session));
                               }});
  p.router = std::make_unique<Router>(*p.rest);
  p.core.set_wake([&p] { p.wake(); });
  std::error_code ignored;
  if (p.settings.db_path.has_parent_path()) std::filesystem::create_directories(p.settings.db_path.parent_path(), ignored);
  make_private(p.settings.db_path);
  if (const db::Status claimed = p.recorder.claim(); !claimed && claimed.error().kind == db::ErrorKind::busy) {
    error = claimed.error().message;
    return false;
  }
  p.listener = std::make_unique<Listener>(p.io, p.counters, *p.router, p.tls.get());
  const std::uint16_t port = p.listener->open(p.settings.bind, p.settings.port, error);
  if (port == 0) return false;
  p.settings.port = port;
  p.rest->base_url = (p.tls ? "https://" : "http://") +
                     (p.settings.bind.find(':') == std::string::npos ? p.settings.bind : "[" + p.settings.bind + "]") + ":" +
                     std::to_string(port);
  p.jobs.start();
  p.recorder.start();
  return true;
}

void App::run() {
  Parts& p = *parts_;
  p.next_ns = steady_ns();
  p.arm();
  p.io.run();
}

void App::stop() {
  asio::post(parts_->io, [p = parts_.get()] { p->end(); });
}

std::uint16_t App::port() const { return parts_->settings.port; }
std::string App::bearer_token() const { return parts_->auth->bearer_token(); }
std::string App::link() const { return parts_->rest->base_url + "/?token=" + parts_->auth->link_token(); }

}  // namespace hoist::server
