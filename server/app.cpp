#include "server/app.hpp"

#include <unistd.h>

#include <array>
#include <atomic>
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
#include "server/actions/actions.hpp"
#include "server/api/router.hpp"
#include "server/api/trust.hpp"
#include "server/contract/audit.hpp"
#include "server/http/auth.hpp"
#include "server/http/listener.hpp"
#include "server/jobs/jobs.hpp"
#include "server/link/core_desk.hpp"
#include "server/link/firmware_desk.hpp"
#include "server/live/hub.hpp"
#include "server/people/people_desk.hpp"
#include "server/people/sessions.hpp"
#include "server/people/set_up.hpp"
#include "server/people/sign_in_guard.hpp"
#include "server/record/recorder.hpp"
#include "server/services.hpp"
#include "server/state/hoist_state.hpp"
#include "server/stream/tls_keeper.hpp"
#include "server/tools/hub.hpp"

namespace hoist::server {

namespace asio = boost::asio;

namespace {
constexpr std::uint64_t kPoll_ns = 10'000'000;
// The core publishes within the first millisecond of its step; polling a little later finds each step when it is
// newest.
constexpr std::uint64_t kPhase_ns = 2'000'000;
constexpr int kGoodbye_ms = 300;
constexpr std::uint64_t kSweep_ns = 1'000'000'000;
constexpr std::size_t kSetUpDigits = 8;
// Sessions that are too old are looked for this often.
constexpr std::uint64_t kRetentionEvery_ns = 86'400'000'000'000;
// Bit of the live value `switches`.
constexpr unsigned kSetUpSwitch = 2;

// Random digits, each as likely as the others.
std::string digits(std::size_t count) {
  std::string out;
  while (out.size() < count)
    for (const char c : random_hex(count))
      if (c >= '0' && c <= '9' && out.size() < count) out.push_back(c);
  return out;
}

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

// A program that was installed with this one.
std::filesystem::path beside_this(const char* name) {
  std::error_code ignored;
  return std::filesystem::read_symlink("/proc/self/exe", ignored).replace_filename(name);
}

std::int64_t utc_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}
Clocks clocks() { return clocks_of(utc_ns(), steady_ns()); }

bool is_every_address(const std::string& address) { return address == "0.0.0.0" || address == "::"; }
std::string in_url(const std::string& address) { return address.find(':') == std::string::npos ? address : "[" + address + "]"; }

// By which multicast DNS finds this computer.
std::string local_name() {
  std::array<char, 64> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0 || name[0] == '\0') return "hoist.local";
  std::string text = name.data();
  text = text.substr(0, text.find('.'));
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text + ".local";
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
                        .replace_file = [this](const std::filesystem::path& prepared) { return replace_file(prepared); },
                        .log_deletion = [this](const std::string& what) { asio::post(io, [this, what] { log_deletion(what); }); },
                        .study_program = settings.study_program.empty() ? beside_this("hoist") : settings.study_program,
                        .moving = [this] { return moving.load(std::memory_order_relaxed); }},
              .on_damage = [this](const db::IntegrityReport& report) { recorder.set_aside(report.file_id, report.structure.front()); }}),
        recorder(core.link(), {.file = settings.db_path,
                               .version = std::string{contract::program_version()},
                               .utc_ns = &utc_ns,
                               .steady_ns = &steady_ns,
                               .actor_of = [this](std::uint32_t client) { return actors.find(client); },
                               // The start waits for no check; each file is checked once it is in use.
                               .opened =
                                   [this] {
                                     (void)jobs.add(JobKind::integrity_check, {}, std::nullopt);
                                     asio::post(io, [this] {
                                       begin_retention();
                                       read_device();
                                       history.compare_file();
                                     });
                                   },
                               .setting_up = [this] { return jobs.hold(); }}),
        records(recorder, [this](std::function<void()> work) { asio::post(io, std::move(work)); }),
        people(settings.accounts_path.empty() ? settings.db_path.parent_path() / "accounts.db" : settings.accounts_path,
               settings.hash_limits, [this](std::function<void()> work) { asio::post(io, std::move(work)); }),
        set_up([] { return digits(kSetUpDigits); },
               [this](const std::string& code) {
                 if (settings.show_set_up_code) return settings.show_set_up_code(code);
                 std::cout << "Set-up code: " << code << " (10 minutes; the configuration switch is on)" << std::endl;
               }),
        state(settings, core, recorder),
        history(core, records, actors, &utc_ns),
        rehearsals({.settings = settings,
                    .core = core,
                    .state = state,
                    .recorder = recorder,
                    .records = records,
                    .actors = actors,
                    .now_ns = &steady_ns,
                    .utc_ns = &utc_ns}),
        tools(settings.db_path.string() + ".tools", settings.tools),
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

  // A job only where a rule is set.
  void begin_retention() {
    retention_ns = steady_ns();
    const auto is_on = [](Records& on) {
      db::Database* database = on.database();
      const auto rule = database == nullptr ? db::RetentionRule{} : db::retention_rule(*database);
      return rule && rule->on();
    };
    (void)records.ask<bool>(is_on, [this](bool on) {
      if (on) (void)jobs.add(JobKind::retention, {}, std::nullopt);
    });
  }

  // No person did it at that moment: the rule did.
  void log_deletion(const std::string& what) {
    std::cerr << "hoist-server: retention has deleted " << what << std::endl;
    people.log({.utc_ms = utc_ns() / 1'000'000,
                .steady_ns = steady_ns(),
                .user = "hoist-server",
                .role = "server",
                .address = "-",
                .action = std::string{AuditName("retention").text},
                .target = "/api/v1/sessions",
                .before = {},
                .after = what,
                .result = "done"});
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
    state.poll(now);
    recorder.set_attached(core.link().attached());
    moving.store(core.newest() && core.newest()->mode < contract::kModes.size() && contract::kModes[core.newest()->mode].moving,
                 std::memory_order_relaxed);
    history.poll(now);
    if (const std::string_view problem = core.problem(); problem != told_problem) {
      told_problem = problem;
      std::cerr << "hoist-server: " << (problem.empty() ? "the control core is connected" : problem) << std::endl;
    }
    set_up.poll(now, core.newest() ? std::optional((core.newest()->switches & kSetUpSwitch) != 0) : std::nullopt);
    firmware.poll(core.clock_ns());
    tell_recorder_of_nodes();
    hub.poll(now);
    tool_hub.poll(now);
    router->tell_downloads(now);
    if (now - retention_ns >= kRetentionEvery_ns) begin_retention();
    if (core.lease_holder() != 0) free_silent_lease(now);
    if (now - swept_ns >= kSweep_ns) {
      swept_ns = now;
      auth->each_session([&](Session& session) { give_back_number(session); });
      look_for_engineer();
    }
  }

  // Those from before this start, oldest first, so that the newest are found first on their devices.
  void know(const KnownPeople& known) {
    for (auto row = known.sign_ins.rbegin(); row != known.sign_ins.rend(); ++row) auth->add_account(session_of(*row), clocks());
    for (const db::Token& row : known.tokens) auth->add_token(session_of(row));
    services->needs_set_up = !known.has_engineer;
  }

  // `hoist user` on this computer may have made the first engineer's account.
  void look_for_engineer() {
    if (!services->needs_set_up || looking || !people.problem().empty()) return;
    looking = people.ask<bool>(
        [](PeopleRoom& room) {
          const auto found = room.accounts.has_engineer();
          return found && *found;
        },
        [this](bool found) {
          looking = false;
          if (found) services->needs_set_up = false;
        });
  }

  // A lease taken over REST has no connection that could end: it is given back when its session falls silent.
  void free_silent_lease(std::uint64_t now) {
    auth->each_session([&](Session& session) {
      if (session.client != core.lease_holder()) return;
      // A client that watches its update need not ask all the time.
      if (session.client == firmware.client()) session.used_ns = now;
      if (now - session.used_ns < kRestLease_ns) return;
      session.used_ns = now;
      release_lease_of(session);
    });
  }

  void release_lease_of(const Session& session) {
    if (session.client != 0 && session.client == core.lease_holder())
      act_release_lease(
          *services, {session.client, core.lease_epoch(), session.role}, [](const Outcome&) {}, true);
  }

  // A sign-in or token that has ended is no client any more. Its STOP is one with a new number.
  void give_back_number(Session& session) {
    if (session.client == 0 || session.client == core.lease_holder() || !Auth::over(session, clocks())) return;
    state.asks().remove(session.client);
    session.client = 0;
    session.number.reset();
  }

  // Of these sessions: their WebSockets close, and what they hold over REST is given back.
  void close_sockets(const std::function<bool(const Session&)>& of, std::string_view reason) {
    hub.close_sockets(of, reason);
    tool_hub.close_sockets(of, reason);
    auth->each_session([&](Session& session) {
      if (of(session)) release_lease_of(session);
    });
  }

  // A rehearsal of a lost link: the client's stream ends and does not come back for so long. One that has no stream loses its control.
  void cut(std::uint32_t client, double seconds) {
    if (hub.cut(client, steady_ns() + static_cast<std::uint64_t>(seconds * 1e9))) return;
    auth->each_session([&](Session& session) {
      if (session.client == client) release_lease_of(session);
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

  // The hoist's own authority and certificate: made at the first start, read afterwards.
  bool open_authority(std::string& error) {
    DeviceNames names{.names = {}, .addresses = {}, .subnets = settings.subnets};
    for (const std::string& host : settings.hosts) (is_address(host) ? names.addresses : names.names).push_back(host);
    if (names.names.empty()) names.names.push_back(local_name());
    const auto now_s = [] { return utc_ns() / 1'000'000'000; };
    auto ca = DeviceCa::open(settings.tls_dir, names, now_s(), error);
    if (!ca) return false;
    trust = {.name = names.names.front(), .fingerprint = ca->fingerprint(), .certificate = ca->authority_der(), .port = 0};
    keeper =
        std::make_unique<TlsKeeper>(std::move(ca), now_s, [this](std::unique_ptr<TlsContext> fresh, std::vector<std::string> signed_now) {
          // A function object must be copyable.
          auto shared = std::make_shared<TlsContext>(std::move(*fresh));
          asio::post(io, [this, shared, hosts = hosts_of(signed_now)]() mutable {
            tls->take(std::move(*shared));
            auth->set_hosts(std::move(hosts));
            std::cerr << "hoist-server: a new certificate is in use" << std::endl;
          });
        });
    tls = keeper->first(error);
    return tls != nullptr;
  }

  // What a Host field may say, besides the loopback names that are always allowed.
  [[nodiscard]] std::vector<std::string> hosts_of(const std::vector<std::string>& signed_now) const {
    std::vector<std::string> hosts;
    hosts.reserve(signed_now.size());
    for (const std::string& name : signed_now) hosts.push_back(in_url(name));
    return hosts;
  }

  bool open_plain_door(std::string& error) {
    trust.port = settings.port;
    rest->trust = &trust;
    std::cout << "Certificate authority of this hoist, SHA-256: " << trust.fingerprint << std::endl;
    if (!settings.http_port) return true;
    plain_door = std::make_unique<PlainDoor>(trust, *auth, counters);
    plain_listener = std::make_unique<Listener>(io, counters, *plain_door, nullptr);
    const std::uint16_t port = plain_listener->open(settings.bind, *settings.http_port, error);
    if (port == 0) return false;
    std::cout << "How to trust it: http://" << trust.name << (port == 80 ? "" : ":" + std::to_string(port)) << "/" << std::endl;
    return true;
  }

  // Name, language and id of this hoist, also for those who are not signed in yet. A file that cannot be read now leaves both empty.
  void read_device() {
    const auto work = [](Records& on) {
      auto read = on.database() == nullptr ? db::Result<db::DeviceSettings>(db::Error{}) : db::device_settings(*on.database());
      return read ? std::move(*read) : db::DeviceSettings{};
    };
    (void)records.ask<db::DeviceSettings>(work, [this](db::DeviceSettings device) { state.set_device(std::move(device)); });
  }

  void tell_other_devices() const {
    const std::string name = keeper ? trust.name : settings.hosts.front();
    std::cout << "From other devices: https://" << in_url(name) << (settings.port == 443 ? "" : ":" + std::to_string(settings.port)) << "/"
              << (services->needs_set_up ? " (the set-up only, until there is an account: turn the configuration switch on)" : "")
              << std::endl;
  }

  OpenSocket open_tool(ToolHub::Protocol protocol) {
    return [this, protocol](std::unique_ptr<Stream> stream, std::shared_ptr<void> seat, SessionPtr session, const std::string& address) {
      tool_hub.open(protocol, std::move(stream), std::move(seat), std::move(session), address);
    };
  }

  void end() {
    if (ending) return;
    ending = true;
    timer.cancel();
    hub.close_all();
    tool_hub.close_all();
    listener->close();
    if (plain_listener) plain_listener->close();
    goodbye.expires_after(std::chrono::milliseconds(kGoodbye_ms));
    goodbye.async_wait([this](boost::system::error_code) { io.stop(); });
  }

  Settings settings;
  Counters counters;
  // Of the hoist's own authority, else null.
  TrustPage trust;
  std::unique_ptr<TlsContext> tls;  // null: plain
  ActorList actors;                 // outlives what a waiting handler keeps
  asio::io_context io{1};
  CoreDesk core;
  FirmwareDesk firmware;
  std::atomic<bool> moving = false;  // for the jobs' thread
  Jobs jobs;
  Recorder recorder;
  RecorderDesk records;
  PeopleDesk people;
  SignInGuard guard;
  SetUp set_up;
  HoistState state;
  ParameterHistory history;
  RehearsalDesk rehearsals;
  ToolSwitch tools;
  Hub hub;
  ToolHub tool_hub;
  std::unique_ptr<Auth> auth;
  std::unique_ptr<Services> services;
  std::unique_ptr<RestContext> rest;
  std::unique_ptr<Router> router;
  std::unique_ptr<Listener> listener;
  std::unique_ptr<PlainDoor> plain_door;
  std::unique_ptr<Listener> plain_listener;
  std::unique_ptr<TlsKeeper> keeper;
  asio::steady_timer timer;
  asio::steady_timer goodbye;
  std::uint64_t next_ns = 0, swept_ns = 0;
  std::uint64_t retention_ns = steady_ns();                                    // when a rule was looked for last
  std::optional<std::array<NodeSaid, contract::kRemoteNodeCount>> told_nodes;  // by the recorder's last list
  std::string told_problem;                                                    // why the core is not connected, as told last
  bool looking = false;                                                        // for the first engineer's account
  bool ending = false;
};

App::App(Settings settings) : parts_(std::make_unique<Parts>(std::move(settings))) {}

App::~App() {
  // The threads of certificates, jobs and recorder end first: then nothing posts any more. What waits is answered and every connection goes while all
  // that it uses is still there.
  Parts& p = *parts_;
  if (p.keeper) p.keeper->stop();
  p.jobs.stop();
  p.recorder.stop();
  if (p.router) p.router->tell_all_downloads();
  p.people.stop();
  p.core.clear_listeners();
  p.core.close();
  if (p.listener) p.listener->drop();
  if (p.plain_listener) p.plain_listener->drop();
  p.io.restart();
  p.io.poll();
}

bool App::start(std::string& error) {
  Parts& p = *parts_;
  // An address of this computer's own is a name of it, too.
  if (const std::string& bind = p.settings.bind; !is_every_address(bind) && !is_loopback(bind)) p.settings.hosts.push_back(bind);
  if (!p.settings.tls_cert.empty()) {
    p.tls = TlsContext::load(p.settings.tls_cert, p.settings.tls_key, error);
    if (!p.tls) return false;
  }
  if (!p.settings.tls_dir.empty() && !p.open_authority(error)) return false;
  std::error_code ignored;
  if (p.settings.db_path.has_parent_path()) std::filesystem::create_directories(p.settings.db_path.parent_path(), ignored);
  // Before the accounts, which may be read without their lock.
  make_private(p.settings.db_path);
  if (const db::Status claimed = p.recorder.claim(); !claimed && claimed.error().kind == db::ErrorKind::busy) {
    error = claimed.error().message;
    return false;
  }
  // Without its accounts the server still runs: patients can walk, and a person at this computer can put it right.
  const std::optional<KnownPeople> known = p.people.open();
  p.auth = Auth::create(
      {.token_file = p.settings.token_file,
       .hosts = p.settings.hosts,
       .secure = p.tls != nullptr,
       .used =
           [&p](const Session& session) {
             const auto used_s = static_cast<std::int64_t>(session.used_utc_s);
             p.people.tell([digest = session.digest, used_s](PeopleRoom& room) { (void)room.accounts.use_sign_in(digest, used_s); });
           }},
      clocks(), error);
  if (!p.auth) return false;
  if (!error.empty()) std::cerr << "hoist-server: " << std::exchange(error, {}) << std::endl;
  p.services.reset(new Services{.settings = p.settings,
                                .counters = p.counters,
                                .core = p.core,
                                .firmware = p.firmware,
                                .state = p.state,
                                .history = p.history,
                                .rehearsals = p.rehearsals,
                                .tools = p.tools,
                                .recorder = p.recorder,
                                .records = p.records,
                                .people = p.people,
                                .jobs = p.jobs,
                                .now_ns = &steady_ns,
                                .utc_ns = &utc_ns,
                                .actors = p.actors,
                                .guard = p.guard,
                                .set_up = p.set_up,
                                .close_sockets = [&p](const auto& of, std::string_view reason) { p.close_sockets(of, reason); },
                                .computer_name = host_name(),
                                .started_utc_ns = utc_ns(),
                                .started_ns = steady_ns()});
  if (known) p.know(*known);
  p.people.set_on_known([&p](const KnownPeople& people) { p.know(people); });
  if (p.keeper) p.auth->set_hosts(p.hosts_of(p.keeper->ca().signed_names()));
  p.hub.set_services(*p.services, *p.auth);
  p.state.set_on_task_end([&services = *p.services] { end_task(services); });
  p.core.add_listener(p.state);
  p.core.add_listener(p.hub);
  p.core.add_listener(p.history);
  p.core.add_listener(p.rehearsals);
  p.rehearsals.set_cut([&p](std::uint32_t client, double seconds) { p.cut(client, seconds); });
  p.tool_hub.set_services(*p.services, *p.auth);
  p.core.add_listener(p.tool_hub);
  p.rest.reset(new RestContext{
      .services = *p.services,
      .auth = *p.auth,
      .open_live = [&p](std::unique_ptr<Stream> stream, std::shared_ptr<void> seat, SessionPtr session,
                        const std::string& address) { p.hub.open(std::move(stream), std::move(seat), std::move(session), address); },
      .open_foxglove = p.open_tool(ToolHub::Protocol::foxglove),
      .open_rosbridge = p.open_tool(ToolHub::Protocol::rosbridge)});
  p.router = std::make_unique<Router>(*p.rest);
  p.core.set_wake([&p] { p.wake(); });
  p.listener = std::make_unique<Listener>(p.io, p.counters, *p.router, p.tls.get());
  p.listener->set_from_here(p.settings.from_here);
  const std::uint16_t port = p.listener->open(p.settings.bind, p.settings.port, error);
  if (port == 0) return false;
  p.settings.port = port;
  // The link is for this computer only.
  const std::string here = is_every_address(p.settings.bind) ? "127.0.0.1" : in_url(p.settings.bind);
  p.rest->base_url = (p.tls ? "https://" : "http://") + here + ":" + std::to_string(port);
  if (p.keeper && !p.open_plain_door(error)) return false;
  if (!is_loopback(p.settings.bind)) p.tell_other_devices();
  p.people.start();
  // Before the jobs, which wait until it has set the file up.
  p.recorder.start();
  p.jobs.start();
  if (p.keeper) p.keeper->start();
  return true;
}

void App::run() {
  Parts& p = *parts_;
  p.next_ns = steady_ns();
  p.arm();
  p.io.run();
}

void App::look_at_certificate() {
  if (parts_->keeper) parts_->keeper->look();
}

void App::stop() {
  asio::post(parts_->io, [p = parts_.get()] { p->end(); });
}

std::uint16_t App::port() const { return parts_->settings.port; }
std::string App::bearer_token() const { return parts_->auth->bearer_token(); }
std::string App::link() const { return parts_->rest->base_url + "/?token=" + parts_->auth->link_token(); }

}  // namespace hoist::server
