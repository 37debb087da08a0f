// What the server does while nothing happens, and for each step of the core, counted in virtual time; and how answers are printed and compressed.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <set>
#include <utility>

#include "control/publish/core_link.hpp"
#include "control/run/heap_watch.hpp"
#include "db/store/database.hpp"
#include "db/store/session_writer.hpp"
#include "server/actions/action_table.hpp"
#include "server/actions/actions.hpp"
#include "server/actions/lines.hpp"
#include "server/actions/patients.hpp"
#include "server/actions/records.hpp"
#include "server/api/handlers.hpp"
#include "server/http/compress.hpp"
#include "server/live/client.hpp"
#include "server/live/hub.hpp"
#include "server/text/json_writer.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/server/fake_core.hpp"

namespace hoist::server {
namespace {

using nlohmann::json;
constexpr std::uint64_t kTick_ns = 10'000'000;

// Core desk and hub without network and timer.
class Idle : public ::testing::Test {
 protected:
  Idle()
      : fake_((folder_ / "core.sock").string()),
        core_((folder_ / "core.sock").string(), counters_),
        firmware_(core_),
        recorder_(core_.link(), {.file = folder_ / "none.db",
                                 .version = "",
                                 .utc_ns = [] { return std::int64_t{0}; },
                                 .steady_ns = [this] { return now_ns_; }}),
        jobs_({.tools = {.file = folder_ / "none.db", .utc_ns = [] { return std::int64_t{0}; }}}),
        records_(recorder_, [this](std::function<void()> work) { posted_.push_back(std::move(work)); }),
        state_(settings_, core_, recorder_) {
    std::string error;
    auth_ = Auth::create({.token_file = "", .hosts = {}}, {1000, 1000}, error);
    services_.reset(new Services{.settings = settings_,
                                 .counters = counters_,
                                 .core = core_,
                                 .firmware = firmware_,
                                 .state = state_,
                                 .history = history_,
                                 .rehearsals = rehearsals_,
                                 .tools = tools_,
                                 .recorder = recorder_,
                                 .records = records_,
                                 .people = people_,
                                 .jobs = jobs_,
                                 .now_ns = [this] { return now_ns_; },
                                 .utc_ns = [this] { return static_cast<std::int64_t>(utc_s_) * 1'000'000'000; },
                                 .actors = actors_,
                                 .guard = guard_,
                                 .set_up = set_up_,
                                 .close_sockets = {}});
    hub_.set_services(*services_, *auth_);
    core_.add_listener(state_);
    core_.add_listener(hub_);
    // The core accepts in its own time.
    for (int i = 0; i < 500 && !core_.connected(); ++i) {
      fake_.skip(1);
      poll(1);
    }
  }
  ~Idle() override { core_.clear_listeners(); }
  // With as many steps of the core.
  void poll_steps(int times) {
    for (int i = 0; i < times; ++i) {
      fake_.skip(1);
      poll(1);
    }
  }
  void poll(int times) {
    for (int i = 0; i < times; ++i) {
      now_ns_ += kTick_ns;
      core_.poll(now_ns_);
      hub_.poll(now_ns_);
    }
  }

  boost::asio::io_context io_;  // outlives the hub, which keeps clients
  test::TemporaryFolder folder_;
  std::vector<std::function<void()>> posted_;  // by the recorder's thread, for the network's
  test::FakeCore fake_;
  Settings settings_;
  Counters counters_;
  CoreDesk core_;
  FirmwareDesk firmware_;
  Recorder recorder_;
  Jobs jobs_;
  RecorderDesk records_;
  HoistState state_;
  PeopleDesk people_{folder_ / "accounts.db", {.passes = 1, .memory_bytes = 8192}, [](std::function<void()>) {}};
  SignInGuard guard_;
  server::SetUp set_up_{[] { return std::string(); }, [](const std::string&) {}};
  ToolSwitch tools_{folder_ / "none.tools", false};
  ActorList actors_{0};
  ParameterHistory history_{core_, records_, actors_, [] { return std::int64_t{0}; }};
  RehearsalDesk rehearsals_{{.settings = settings_,
                             .core = core_,
                             .state = state_,
                             .recorder = recorder_,
                             .records = records_,
                             .actors = actors_,
                             .now_ns = [] { return std::uint64_t{0}; },
                             .utc_ns = [] { return std::int64_t{0}; }}};
  Hub hub_;
  std::unique_ptr<Auth> auth_;
  std::unique_ptr<Services> services_;
  std::uint64_t now_ns_ = 1'000'000'000'000;
  std::uint64_t utc_s_ = 0;
};

TEST_F(Idle, ParametersAreCopiedOnceForEachChange) {
  ASSERT_TRUE(core_.connected());
  ASSERT_TRUE(core_.has_parameters());
  const std::uint64_t before = core_.parameter_copies();
  EXPECT_LE(before, 2U);
  poll(40);
  EXPECT_EQ(core_.parameter_copies(), before);
}

// Each job of the recorder's thread reads a bounded part of the session, so that the job of another client comes next.
TEST_F(Idle, ALongRecordingIsReadInPieces) {
  constexpr std::size_t kSamples = 125'000, kPieces = 5;
  {
    auto database = db::Database::open(folder_ / "none.db");
    auto writer = db::SessionWriter::create(*database);
    std::vector<double> parameters;
    for (const contract::ParamInfo& info : contract::kParams) parameters.push_back(info.default_value);
    db::SessionStart start;
    start.started_utc_ns = 1'790'000'000'000'000'000;
    start.start_time_ns = 1;
    start.parameter_values = parameters;
    ASSERT_TRUE(writer->begin(start));
    std::vector<contract::TickRecord> records(1000);
    for (std::size_t tick = 0; tick < kSamples; tick += records.size()) {
      for (std::size_t i = 0; i < records.size(); ++i) {
        records[i].tick = tick + i;
        records[i].time_ns = 1 + (tick + i) * kTick_ns;
      }
      ASSERT_TRUE(writer->append_ticks(records));
    }
    ASSERT_TRUE(writer->end(db::CloseReason::finished, start.started_utc_ns));
  }
  recorder_.open_here();
  const RestContext rest{.services = *services_, .auth = *auth_, .open_live = {}, .open_foxglove = {}, .open_rosbridge = {}};
  for (const auto handler : {&api::get_metrics, &api::get_tuning_advice, &api::get_session_report}) {
    std::optional<Response> answer;
    auto call = std::make_shared<Call>(rest, Request{}, [&answer](Response response) { answer = std::move(response); });
    call->path_values = {"1"};
    handler(call);
    call.reset();
    std::size_t jobs = 0;
    for (; !answer && jobs < 100; ++jobs) {
      recorder_.pass_here();
      for (const auto& work : std::exchange(posted_, {})) work();
    }
    ASSERT_TRUE(answer.has_value());
    EXPECT_EQ(answer->status, 200U) << answer->body;
    EXPECT_GT(jobs, kPieces);
  }
  recorder_.finish_here();
}

TEST_F(Idle, AClientIsVisitedOnceASecond) {
  std::vector<std::shared_ptr<Client>> clients;
  const auto session = std::make_shared<Session>();
  for (std::uint32_t i = 0; i < 64; ++i) {
    clients.push_back(
        std::make_shared<Client>(hub_, std::make_unique<Stream>(boost::asio::ip::tcp::socket(io_), nullptr), session, i + 1, nullptr));
    clients.back()->start();  // its clock; the network is never run
    hub_.add(clients.back());
  }
  const std::uint64_t before = hub_.visits();
  poll(300);
  EXPECT_GE(hub_.visits() - before, 2U * 64U);
  EXPECT_LE(hub_.visits() - before, 4U * 64U);
}

// A client of the hub, and the browser's end of its socket.
class Browser {
 public:
  Browser(boost::asio::io_context& io, Hub& hub, const SessionPtr& session, std::uint32_t number) {
    std::array<int, 2> ends{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends.data()), 0);
    boost::asio::ip::tcp::socket socket(io);
    socket.assign(boost::asio::ip::tcp::v4(), ends[0]);
    fd_ = ends[1];
    client = std::make_shared<Client>(hub, std::make_unique<Stream>(std::move(socket), nullptr), session, number, nullptr);
    client->start();
    hub.add(client);
  }
  ~Browser() { ::close(fd_); }
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;
  // Takes what has come; how many bytes.
  std::size_t read() {
    std::size_t bytes = 0;
    for (ssize_t got = 0; (got = ::recv(fd_, buffer_.data(), buffer_.size(), 0)) > 0;) bytes += static_cast<std::size_t>(got);
    return bytes;
  }
  // The bytes that have come, frame heads included.
  std::string text() {
    std::string all;
    for (ssize_t got = 0; (got = ::recv(fd_, buffer_.data(), buffer_.size(), 0)) > 0;)
      all.append(buffer_.data(), static_cast<std::size_t>(got));
    return all;
  }
  // Whatever it has read: an unasked pong (RFC 6455 section 5.5.3) keeps the connection.
  void answer_pings() {
    constexpr std::array<unsigned char, 6> kPong{0x8A, 0x80, 0, 0, 0, 0};
    (void)::send(fd_, kPong.data(), kPong.size(), MSG_NOSIGNAL);
  }
  std::shared_ptr<Client> client;

 private:
  int fd_ = -1;
  std::array<char, 65536> buffer_{};
};

TEST_F(Idle, TheSteadyStreamAsksNothingOfTheHeap) {
  const auto session = std::make_shared<Session>();
  std::vector<std::unique_ptr<Browser>> browsers;
  for (std::uint32_t i = 0; i < 20; ++i) browsers.push_back(std::make_unique<Browser>(io_, hub_, session, i + 1));
  // Whole records for most, chosen topics for the rest.
  for (std::size_t i = 0; i < browsers.size(); ++i)
    hub_.choose(*browsers[i]->client, {.topics = topic_bit(i < 15 ? Topic::all : Topic::motion)}, {});
  for (const auto& browser : browsers) browser->read();
  std::vector<contract::TickRecord> step(1);
  std::size_t bytes = 0;
  const auto walk = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      ++step[0].tick;
      step[0].time_ns += kTick_ns;
      step[0].fused_x_m += 0.03F;  // a new point of the path each time
      state_.on_ticks(step, 0);
      hub_.on_ticks(step, 0);
      if (i % 5 == 4)
        for (const auto& browser : browsers) bytes += browser->read();
    }
  };
  walk(20);
  const std::uint64_t before = run::heap_requests();
  bytes = 0;
  walk(3000);
  EXPECT_EQ(run::heap_requests() - before, 0U);
  EXPECT_GT(bytes, 15U * 3000U * sizeof(contract::TickRecord)) << "every client has got every step";
}

TEST_F(Idle, AFrameThatAClientStillSendsIsNotWrittenAgain) {
  std::vector<contract::TickRecord> records(1);
  Feed feed({});
  std::vector<SharedFrame> held;
  std::vector<std::string> was;
  for (std::uint64_t i = 0; i < 20; ++i) {
    records[0].tick = i;
    feed.take(records[0], false);
    held.push_back(feed.flush().frame);
    was.push_back(*held.back());
  }
  for (std::size_t i = 0; i < held.size(); ++i) EXPECT_EQ(*held[i], was[i]) << i;
}

// A client that keeps account of every step: it was shown, or named as missing.
class Account {
 public:
  Account(const StreamChoice& choice, std::set<std::string>& reasons) : choice_(choice), reasons_(reasons) {}
  // Changes of state come at any rate.
  static constexpr std::uint64_t kChangeEvery = 37;
  [[nodiscard]] bool expected(std::uint64_t tick) const { return tick % choice_.every_ticks == 0 || tick % kChangeEvery == 0; }
  [[nodiscard]] std::uint64_t last() const { return last_; }
  // What came before the answer belongs to the connection's first choice.
  void connect() {
    bytes_.clear();
    answered_ = false;
  }
  void take(std::string_view more) {
    bytes_.append(more);
    while (take_message()) {
    }
  }
  void check(std::uint64_t newest) const {
    ASSERT_GT(newest, first_ + 5000);
    for (std::uint64_t tick = first_; tick <= newest; ++tick) {
      const auto at = times_.find(tick);
      const int times = at == times_.end() ? 0 : at->second;
      // The step after a gap may show a state that has changed in it.
      if (!expected(tick) && after_gap_.contains(tick)) {
        ASSERT_LE(times, 1);
        continue;
      }
      ASSERT_EQ(times, expected(tick) ? 1 : 0) << tick << " of " << first_ << ".." << newest;
    }
  }

 private:
  bool take_message() {
    const auto byte = [this](std::size_t i) { return static_cast<unsigned char>(bytes_[i]); };
    if (bytes_.size() < 2) return false;
    std::size_t head = 2, size = byte(1);
    if (size == 126) {
      if (bytes_.size() < 4) return false;
      head = 4;
      size = std::size_t{byte(2)} << 8U | byte(3);
    }
    EXPECT_NE(size, 127U);
    if (bytes_.size() < head + size) return false;
    const std::string payload = bytes_.substr(head, size);
    const auto opcode = static_cast<Opcode>(byte(0) & 0x0FU);
    bytes_.erase(0, head + size);
    if (opcode == Opcode::text) take_text(json::parse(payload));
    if (opcode == Opcode::binary && answered_) take_samples(payload);
    return true;
  }
  void take_text(const json& message) {
    if (message["type"] == "streaming") answered_ = true;
    if (message["type"] != "gap" || !answered_) return;
    reasons_.insert(message["reason"].get<std::string>());
    const auto from = message["from_tick"].get<std::uint64_t>(), to = message["to_tick"].get<std::uint64_t>();
    ASSERT_GT(from, last_);
    ASSERT_GE(to, from);
    std::uint64_t due = 0;
    for (std::uint64_t tick = from; tick <= to; ++tick) {
      if (expected(tick)) ++times_[tick];
      due += tick % choice_.every_ticks == 0 ? 1 : 0;
    }
    EXPECT_GE(message["count"].get<std::uint64_t>(), due);
    last_ = to;
    after_gap_.insert(to + 1);
  }
  void take_samples(const std::string& payload) {
    const std::size_t head = payload[0] == 1 ? 16 : 20;
    std::uint32_t sample_bytes = 0;
    std::memcpy(&sample_bytes, payload.data() + 4, 4);
    for (std::size_t at = head; at < payload.size(); at += sample_bytes) {
      std::uint64_t tick = 0;  // the first value of a record and of the topic `state`
      std::memcpy(&tick, payload.data() + at, 8);
      if (first_ == 0) first_ = tick;
      EXPECT_GT(tick, last_);
      ++times_[tick];
      last_ = tick;
    }
  }

  StreamChoice choice_;
  std::set<std::string>& reasons_;
  std::map<std::uint64_t, int> times_;
  std::set<std::uint64_t> after_gap_;
  std::string bytes_;
  bool answered_ = false;
  std::uint64_t first_ = 0, last_ = 0;
};

// Random steps, stalls of client and server, lost connections.
TEST_F(Idle, EachStepIsShownOrNamedAsMissingExactlyOnce) {
  fake_.set_each([](contract::TickRecord& record) { record.bumpers = static_cast<std::uint8_t>(record.tick / Account::kChangeEvery % 2); });
  const auto session = std::make_shared<Session>();
  const std::array choices{StreamChoice{.topics = topic_bit(Topic::all)}, StreamChoice{.topics = topic_bit(Topic::state)},
                           StreamChoice{.topics = topic_bit(Topic::motion) | topic_bit(Topic::pose), .every_ticks = 5},
                           StreamChoice{.every_ticks = 20}};
  std::mt19937 random(15);  // NOLINT(cert-msc32-c,cert-msc51-cpp): the same each time
  const auto one_of = [&random](unsigned n) { return random() % n == 0; };
  std::uint32_t number = 0;
  std::set<std::string> reasons;
  for (const StreamChoice& choice : choices) {
    Account account(choice, reasons);
    std::unique_ptr<Browser> browser;
    const auto pass = [&](std::size_t steps) {
      fake_.skip(steps);
      for (std::uint64_t tick = 0; core_.newest()->tick != tick;) {
        tick = core_.newest()->tick;
        if (browser) browser->answer_pings();
        poll(1);
        io_.restart();
        io_.poll();
      }
    };
    const auto connect = [&](const std::optional<Resume>& resume) {
      browser = std::make_unique<Browser>(io_, hub_, session, ++number);
      account.connect();
      if (one_of(2)) pass(random() % 30);
      hub_.choose(*browser->client, choice, resume);
    };
    connect({});
    bool reads = true;
    for (int round = 0; round < 160 || !reads; ++round) {
      pass(one_of(60) ? 2600 : random() % 40);
      if (one_of(20)) reads = !reads;
      if (reads) account.take(browser->text());
      if (account.last() == 0 || !one_of(16)) continue;
      browser.reset();
      pass(one_of(4) ? random() % 2600 : random() % 200);
      connect(Resume{account.last(), std::to_string(core_.run())});
    }
    for (int i = 0; i < 10; ++i) {
      pass(choice.every_ticks);
      account.take(browser->text());
    }
    account.check(account.last());
  }
  EXPECT_EQ(reasons, (std::set<std::string>{"server_late", "slow_client", "too_old"})) << "each kind has happened";
}

// Each action of the table once, as a protocol calls it. An action without its function here does not compile.
namespace calls {
#define CALL(name, ...) \
  void name(Services& services, const Asker& asker, OutcomeDone done) { __VA_ARGS__; }
const json kNone, kEmpty = json::object(), kUser = "user", kStandby = "standby", kPatient = 7U, kTask{{"task", "circle"}},
                  kRehearsal{{"rehearsal", "trip"}}, kOwn = exercise_json(contract::usual_exercise(contract::ExerciseShape::own));
CALL(take_lease, act_take_lease(services, asker, true, done))
CALL(release_lease, act_release_lease(services, asker, done))
CALL(ask_lease, act_ask_lease(services, asker, false, done))
CALL(withdraw_lease, act_ask_lease(services, asker, true, done))
CALL(keep_lease, act_keep_lease(services, asker, done))
CALL(hand_over, act_hand_over(services, asker, HandOverWish{.client = 8, .user = {}}, done))
CALL(start_motion, act_mode(services, asker, {kUser, kNone, kNone, kNone}, done))
CALL(end_motion, act_mode(services, asker, {kStandby, kNone, kNone, kNone}, done))
CALL(choose_exercise, act_choose(services, asker, kEmpty, done))
CALL(choose_task, act_choose_task(services, asker, kTask, done))
CALL(choose_rehearsal, act_choose_rehearsal(services, asker, kRehearsal, done))
CALL(stop, act_stop(services, asker, done))
CALL(acknowledge, act_acknowledge(services, asker, kNone, done))
CALL(pause_alarm, act_pause_alarm(services, asker, true, done))
CALL(begin_calibration, act_calibrate(services, asker, CalibrateWish{}, done))
CALL(measure_calibration, act_measure(services, asker, MeasureWish{}, done))
CALL(use_calibration, act_use_calibration(services, asker, done))
CALL(cancel_calibration, act_cancel_calibration(services, asker, done))
CALL(set_neutral, act_neutral(services, asker, done))
CALL(set_pose, act_pose(services, asker, StartPose{}, done))
CALL(change_parameters, act_set(services, asker, {{"v_max_m_s", 0.1}}, std::nullopt, 0U, done))
CALL(keep_parameters, act_keep_trial(services, asker, 0U, done))
CALL(undo_parameters, act_undo_trial(services, asker, done))
CALL(apply_preset, act_preset(services, asker, "walk", 0U, done))
CALL(update_firmware, act_update_firmware(services, asker, {}, contract::Node::tilt_base, false, done))
CALL(add_marker, act_mark(services, asker, std::nullopt, {.text = "here"}, done))
CALL(begin_recording, act_record(services, asker, {.starts = true, .subject = {}, .note = {}}, done))
CALL(end_recording, act_record(services, asker, {.starts = false, .subject = {}, .note = {}}, done))
CALL(change_session, act_change_session(services, asker, db::SessionId{1}, db::SessionPatch{}, {}, done))
CALL(delete_session, act_delete_session(services, asker, db::SessionId{1}, {}, done))
CALL(change_marker, act_change_marker(services, asker, MarkerPlace{}, db::MarkerPatch{}, {}, done))
CALL(delete_marker, act_delete_marker(services, asker, MarkerPlace{}, {}, done))
CALL(set_retention, act_set_retention(services, asker, db::RetentionRule{}, {}, done))
CALL(change_settings, act_change_device(services, asker, db::DeviceSettingsPatch{}, {}, done))
CALL(set_time, act_set_clock(services, asker, 0, done))
CALL(start_job, act_start_job(services, asker, JobKind::integrity_check, {}, done))
CALL(cancel_job, act_cancel_job(services, asker, JobId{1}, done))
CALL(set_tools, act_set_tools(services, asker, true, "", done))
CALL(create_patient, act_create_patient(services, asker, "P-1", done))
CALL(change_patient, act_change_patient(services, asker, 7, {.code = "P-2", .archived = {}}, "", done))
CALL(delete_patient, act_delete_patient(services, asker, 7, "", done))
CALL(set_identity, act_set_identity(services, asker, 7, db::Identity{.name = "A", .birth_date = {}, .note = {}}, "", done))
CALL(delete_identity, act_set_identity(services, asker, 7, std::nullopt, "", done))
CALL(change_visit, act_note_visit(services, asker, 7, "note", "", done))
CALL(choose_patient, act_choose_patient(services, asker, kPatient, done))
CALL(create_profile, act_create_profile(services, asker, 7, "mornings", kNone, done))
CALL(change_profile, act_change_profile(services, asker, 7, {.name = "evenings", .settings = kNone}, "", done))
CALL(delete_profile, act_delete_profile(services, asker, 7, "", done))
CALL(apply_profile, act_apply_profile(services, asker, 7, 0U, done))
CALL(create_line, act_create_line(services, asker, {.name = "Hall", .exercise = kOwn}, done))
CALL(change_line, act_change_line(services, asker, 7, {.name = "Yard", .exercise = kNone}, "", done))
CALL(delete_line, act_delete_line(services, asker, 7, "", done))
#undef CALL
}  // namespace calls

struct ActionRow {
  ActionInfo info;
  void (*call)(Services&, const Asker&, OutcomeDone);
};
constexpr std::array kActionRows{
#define HOIST_ACTION(name, role, ends) ActionRow{{#name, contract::Role::role, (ends) != 0}, &calls::name},
#include "server/actions/actions.def"
#undef HOIST_ACTION
};

// The action itself refuses too low a role and a sign-in that has run out, independent of the protocol; the core receives nothing. Each refusal
// is one row of the audit log, by name.
TEST_F(Idle, ActionsAskForRoleAndSignInThemselvesAndWriteTheAuditLog_H28) {
  ASSERT_TRUE(core_.connected());
  ASSERT_TRUE(people_.open()) << people_.problem();
  people_.start();
  const std::uint32_t anna = actors_.enter({{"anna", "therapist", "hoist.v1", "device-1"}, "Anna Weber", "10.0.0.7"});
  std::vector<std::pair<std::string, std::string>> expected;  // action, result
  const auto refuses = [&](const ActionRow& row, const Asker& asker, Reason why) {
    int answers = 0;
    row.call(*services_, asker, [&](const Outcome& outcome) {
      ++answers;
      EXPECT_EQ(outcome.kind, Outcome::Kind::refused) << row.info.name;
      EXPECT_EQ(outcome.refusals, why == Reason::role ? std::vector<std::string>{"not_allowed"} : std::vector<std::string>{})
          << row.info.name;
      EXPECT_EQ(outcome.reason, why) << row.info.name;
    });
    EXPECT_EQ(answers, 1) << row.info.name;
    expected.emplace_back(row.info.name, why == Reason::role ? "not_allowed" : "sign_in_over");
  };
  for (const ActionRow& row : kActionRows) {
    if (row.info.role > contract::Role::viewer)
      refuses(row, {.client = anna, .epoch = 0, .role = static_cast<contract::Role>(static_cast<int>(row.info.role) - 1)}, Reason::role);
    if (!row.info.ends) refuses(row, {.client = anna, .epoch = 0, .role = contract::Role::engineer, .over = true}, Reason::sign_in_over);
  }
  Hand hand;
  const DriveWish push{.sequence = 1, .echo_time_ns = 1, .speed_norm = 1.0, .yaw_norm = 0.0, .held = true};
  EXPECT_EQ(act_drive(*services_, {.client = anna, .epoch = 0, .role = contract::Role::viewer}, push, hand),
            DriveRefusal{contract::Refusal::not_allowed});
  fake_.skip(2);
  EXPECT_TRUE(fake_.commands().empty());
  EXPECT_EQ(fake_.drive().held, 0U);
  EXPECT_TRUE(jobs_.list().empty());
  // STOP is taken from everybody, also with a request that nobody waits for.
  act_stop(*services_, {.client = anna, .epoch = 0, .role = contract::Role::viewer, .over = true}, nullptr);
  expected.emplace_back("stop", "done");
  people_.stop();
  const auto accounts = db::Accounts::attach(folder_ / "accounts.db");
  ASSERT_TRUE(accounts.ok());
  const auto rows = accounts->audit(std::nullopt, 1000);
  ASSERT_TRUE(rows.ok());
  std::vector<std::pair<std::string, std::string>> found;
  for (auto row = rows->rbegin(); row != rows->rend(); ++row) {
    found.emplace_back(row->entry.action, row->entry.result);
    EXPECT_EQ(row->entry.user + " " + row->entry.role + " " + row->entry.address, "anna therapist 10.0.0.7");
    EXPECT_TRUE(row->entry.target.starts_with("hoist.v1")) << row->entry.target;
  }
  EXPECT_EQ(found, expected);
}

// A working day ends while a hand drives: it goes on, and may let go; the next press is refused, and when the hoist stands the socket closes.
TEST_F(Idle, ASignInThatRunsOutTakesNoStickOutOfAHandAndNoNewPress_H28) {
  ASSERT_TRUE(core_.connected());
  utc_s_ = 1'800'000'000;
  const auto session = std::make_shared<Session>();
  session->account = true;
  session->user = "anna";
  session->role = contract::Role::therapist;
  session->begun_s = session->used_s = static_cast<std::int64_t>(now_ns_ / 1'000'000'000);
  const std::uint32_t number = actors_.enter({{"anna", "therapist", "hoist.v1", "device-1"}});
  Browser browser(io_, hub_, session, number);
  int request = 0;
  std::uint64_t sequence = 0;
  const auto say = [&](json message) {
    message["request"] = ++request;
    (void)browser.text();
    handle_message(*browser.client, message, std::nullopt);
    poll_steps(3);
    return browser.text();
  };
  const auto drive = [&](bool held) {
    return say({{"type", "drive"}, {"sequence", ++sequence}, {"echo", 1}, {"speed", held ? 0.5 : 0.0}, {"yaw", 0.0}, {"held", held}});
  };
  const auto refused = [](const std::string& told) { return told.find("sign_in_over") != std::string::npos; };
  ASSERT_NE(say({{"type", "lease_take"}}).find("\"ok\":true"), std::string::npos);
  fake_.set([](contract::TickRecord& record) {
    record.mode = static_cast<std::uint8_t>(contract::Mode::remote);
    record.standing_still = 0;
  });
  drive(true);
  ASSERT_EQ(fake_.drive().sequence, sequence);
  // Longer than from one look at the clients to the next; what comes is read, since nobody waits here for room in the socket.
  const auto a_second_passes = [&] {
    std::string told;
    for (int i = 0; i < 12; ++i) {
      poll_steps(10);
      told += browser.text();
    }
    return told;
  };
  session->begun_s -= kAccountLife_s;
  a_second_passes();
  EXPECT_EQ(hub_.clients(), 1U) << "closed while it drives";
  EXPECT_FALSE(refused(drive(true)));
  EXPECT_EQ(fake_.drive().sequence, sequence) << "the held stick goes on";
  EXPECT_EQ(fake_.drive().held, 1U);
  EXPECT_TRUE(refused(say({{"type", "set"}, {"values", {{"lean_tau_normal_s", 0.2}}}}))) << "nothing new";
  EXPECT_FALSE(refused(drive(false)));
  EXPECT_EQ(fake_.drive().held, 0U) << "letting go counts";
  EXPECT_TRUE(refused(drive(true))) << "a new press";
  EXPECT_EQ(fake_.drive().held, 0U);
  EXPECT_NE(say({{"type", "mode"}, {"mode", "standby"}}).find("\"ok\":true"), std::string::npos) << "ending is taken";
  const auto stops = [&] { return std::ranges::count(fake_.commands(), contract::CommandKind::stop, &contract::Command::kind); };
  const auto before = stops();
  say({{"type", "stop"}});
  EXPECT_EQ(stops(), before + 1);
  fake_.set([](contract::TickRecord& record) { record.standing_still = 1; });
  EXPECT_NE(a_second_passes().find("signed out"), std::string::npos) << "closed as soon as it stands";
}

TEST_F(Idle, TheNextStepMattersOnlyWhileAnAnswerIsDueOrTheLeaseIsHeld) {
  ASSERT_TRUE(core_.connected());
  EXPECT_FALSE(core_.urgent());
  bool woken = false;
  core_.set_wake([&] { woken = true; });
  fake_.mute(true);
  contract::Command command;
  command.kind = contract::CommandKind::take_lease;
  core_.ask(command, [](const CoreAnswer&) {});
  EXPECT_TRUE(woken);
  EXPECT_TRUE(core_.urgent());
}

// Decision 201. The next patient's walk must not get the code of the one before, also when the core was off in between.
TEST_F(Idle, TheChoiceOfAPatientEndsHalfAnHourAfterItOrAfterTheLastMotion) {
  ASSERT_TRUE(core_.connected());
  constexpr std::uint64_t kMinute_ns = 60'000'000'000;
  HoistState state(settings_, core_, recorder_);
  int told = 0;
  state.set_on_patient([&] { ++told; });
  std::uint64_t now_ns = kMinute_ns;
  state.choose_patient(ChosenPatient{.id = 7, .code = "P-7"});
  state.poll(now_ns);
  state.poll(now_ns += 29 * kMinute_ns);
  EXPECT_TRUE(state.patient());
  state.on_core(true);  // a core that this state has not met yet
  state.poll(now_ns += kMinute_ns);
  EXPECT_FALSE(state.patient()) << "without a step of the core";
  EXPECT_EQ(told, 2);

  state.choose_patient(ChosenPatient{.id = 7, .code = "P-7"});
  state.poll(now_ns += kMinute_ns);
  std::array<contract::TickRecord, 2> steps{};
  steps[0].mode = static_cast<std::uint8_t>(contract::Mode::user);
  steps[1].mode = static_cast<std::uint8_t>(contract::Mode::standby);
  state.on_ticks(steps, 0);
  state.poll(now_ns += 29 * kMinute_ns);
  state.on_ticks({&steps[1], 1}, 0);
  state.poll(now_ns += 29 * kMinute_ns);
  EXPECT_TRUE(state.patient()) << "counted from the last step in motion";
  state.poll(now_ns += kMinute_ns);
  EXPECT_FALSE(state.patient());
}

// STOP has no limit of its own, so a client can send it faster than the core takes commands.
TEST_F(Idle, AFloodOfStopsTakesTheRoomOfOneAndHoldsNothingUp_H31) {
  ASSERT_TRUE(core_.connected());
  int stopped = 0;
  bool taken = false;
  const auto flood = [&] {
    for (int i = 0; i < 10'000; ++i) core_.stop(7, [&](const CoreAnswer& answer) { stopped += answer.done() ? 1 : 0; });
  };
  contract::Command lease;
  lease.kind = contract::CommandKind::take_lease;
  lease.client = 7;
  // Within the call the core takes nothing.
  fake_.set([&](contract::TickRecord&) {
    flood();
    core_.ask(lease, [&](const CoreAnswer& answer) { taken = answer.done(); });
    flood();
  });
  poll_steps(5);
  EXPECT_EQ(stopped, 20'000);
  EXPECT_TRUE(taken);
  std::vector<contract::CommandKind> kinds;
  for (const contract::Command& command : fake_.commands()) kinds.push_back(command.kind);
  using Kind = contract::CommandKind;
  EXPECT_EQ(kinds, (std::vector{Kind::stop, Kind::take_lease, Kind::stop})) << "the second STOP comes after what could begin a motion";
}

// A core that has not met this server yet has no room in its ring.
TEST(CoreDesk, StopsThatFindNoRoomWaitAsOne_H31) {
  const test::TemporaryFolder folder;
  const std::string path = (folder / "core.sock").string();
  std::string error;
  const auto core = publish::CoreLink::create(path, 1000, 5, error);
  ASSERT_TRUE(core) << error;
  std::uint64_t now_ns = 1'000'000'000'000;
  const auto attach = [&](CoreDesk& desk) {
    for (int i = 0; i < 1000 && !desk.link().attached(); ++i) {
      core->serve(1);
      desk.poll(now_ns += kTick_ns);
    }
    return desk.link().attached();
  };
  const auto take = [&] {
    std::array<contract::Command, contract::kCommandSlots> commands;
    std::uint64_t lost = 0;
    EXPECT_TRUE(core->begin());
    const std::size_t count = core->read_commands(commands, lost);
    core->end();
    return std::vector<contract::Command>(commands.begin(), commands.begin() + static_cast<std::ptrdiff_t>(count));
  };
  Counters counters;
  {
    CoreDesk first(path, counters);
    ASSERT_TRUE(attach(first));
    first.stop(1, nullptr);
    ASSERT_EQ(take().size(), 1U);
  }
  CoreDesk second(path, counters);
  ASSERT_TRUE(attach(second));
  int stopped = 0;
  for (int i = 0; i < 1000; ++i) second.stop(2, [&](const CoreAnswer& answer) { stopped += answer.done() ? 1 : 0; });
  EXPECT_TRUE(take().empty());
  second.poll(now_ns += kTick_ns);
  const auto commands = take();
  ASSERT_EQ(commands.size(), 1U);
  EXPECT_EQ(commands[0].kind, contract::CommandKind::stop);
  contract::Event done;
  done.kind = contract::EventKind::command_done;
  done.request_id = commands[0].request_id;
  core->publish_event(done);
  second.poll(now_ns += kTick_ns);
  EXPECT_EQ(stopped, 1000);
}

TEST(JsonWriter, PrintsWhatAReaderReads) {
  JsonWriter out(64);
  const std::string odd = "a\"b\\c\n\x01 \xC3\xBC \xFF";
  out.begin('{').field("text", "plain").field("odd", std::string_view{odd}).field("yes", true).field("none", nullptr);
  out.field("quote", "say \"go\"").key("table").table_text("\"Gerät\"");
  out.field("whole", std::uint64_t{18446744073709551615U}).field("tenth", 0.1).field("nan", std::nan(""));
  out.field("infinite", -std::numeric_limits<double>::infinity()).field("tree", json{{"k", {1, 2}}}).key("list").begin('[');
  for (int i = 0; i < 3; ++i) out.value(i - 1);
  out.begin('{').end('}').end(']').key("empty").begin('[').end(']').end('}');
  const json read = json::parse(out.take());
  const json expected = json::parse(
      R"({"text": "plain", "odd": "a\"b\\c\n\u0001 ü \uFFFD", "yes": true, "none": null, "quote": "say \"go\"", "table": "\"Gerät\"", "whole": 18446744073709551615,
          "tenth": 0.1, "nan": null, "infinite": null, "tree": {"k": [1, 2]}, "list": [-1, 0, 1, {}], "empty": []})");
  EXPECT_EQ(read, expected);
}

std::string unzipped(const std::string& text) {
  z_stream stream{};
  EXPECT_EQ(::inflateInit2(&stream, 15 + 16), Z_OK);
  std::string out(1 << 20, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(::inflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  ::inflateEnd(&stream);
  return out;
}

Response answered(unsigned status, const std::string& body, const char* accept) {
  Request request;
  if (accept != nullptr) request.headers["accept-encoding"] = accept;
  Response response;
  response.status = status;
  response.content_type = status == 200 ? "application/json" : "application/problem+json";
  response.body = body;
  compress_json(request, response);
  return response;
}

TEST(Compress, OnlyWhereItIsAcceptedAndWorthIt) {
  const std::string body = "[" + std::string(5000, '1') + "]";
  const auto coded = [](const Response& r) {
    return std::ranges::find(r.headers, std::pair<std::string, std::string>{"Content-Encoding", "gzip"}) != r.headers.end();
  };
  const Response small = answered(200, body, "br, gzip;q=0.5");
  EXPECT_TRUE(coded(small));
  EXPECT_LT(small.body.size(), 100U);
  EXPECT_EQ(unzipped(small.body), body);
  for (const char* no : {"", "br", "gzip;q=0", "identity", "*;q=0"}) {
    const Response whole = answered(200, body, no);
    EXPECT_FALSE(coded(whole)) << no;
    EXPECT_EQ(whole.body, body);
    EXPECT_EQ(whole.headers.at(0), (std::pair<std::string, std::string>{"Vary", "Accept-Encoding"}));
  }
  EXPECT_FALSE(coded(answered(200, "[1]", "gzip"))) << "too short";
  EXPECT_FALSE(coded(answered(422, body, "gzip"))) << "a problem repeats what the request says";
  const std::string other = "[" + std::string(4000, '2') + "]";
  EXPECT_EQ(unzipped(answered(200, other, "gzip").body), other) << "nothing of the answer before is left";
}

}  // namespace
}  // namespace hoist::server
