// What the server does while nothing happens, and for each step of the core, counted in virtual time; and how answers are printed and compressed.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "control/run/heap_watch.hpp"
#include "server/actions/actions.hpp"
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
        recorder_(core_.link(), {.file = folder_ / "none.db", .version = "", .utc_ns = [] { return std::int64_t{0}; }, .steady_ns = {}}),
        jobs_({.tools = {.file = folder_ / "none.db", .utc_ns = [] { return std::int64_t{0}; }}}),
        records_(recorder_, [](std::function<void()>) {}),
        state_(settings_, core_, recorder_) {
    std::string error;
    auth_ = Auth::create({.token_file = "", .hosts = {}}, 1000, error);
    services_.reset(new Services{.settings = settings_,
                                 .counters = counters_,
                                 .core = core_,
                                 .firmware = firmware_,
                                 .state = state_,
                                 .tools = tools_,
                                 .recorder = recorder_,
                                 .records = records_,
                                 .people = people_,
                                 .jobs = jobs_,
                                 .now_ns = [this] { return now_ns_; },
                                 .utc_ns = [] { return std::int64_t{0}; },
                                 .actors = actors_,
                                 .guard = guard_,
                                 .has_engineer = false,
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
  void poll(int times) {
    for (int i = 0; i < times; ++i) {
      now_ns_ += kTick_ns;
      core_.poll(now_ns_);
      hub_.poll(now_ns_);
    }
  }

  boost::asio::io_context io_;  // outlives the hub, which keeps clients
  test::TemporaryFolder folder_;
  test::FakeCore fake_;
  Settings settings_;
  Counters counters_;
  CoreDesk core_;
  FirmwareDesk firmware_;
  Recorder recorder_;
  Jobs jobs_;
  RecorderDesk records_;
  HoistState state_;
  PeopleDesk people_{folder_ / "accounts.db", HashLimits(), [](std::function<void()>) {}};
  SignInGuard guard_;
  server::SetUp set_up_{[] { return std::string(); }, [](const std::string&) {}};
  ToolSwitch tools_{folder_ / "none.tools", false};
  ActorList actors_{0};
  Hub hub_;
  std::unique_ptr<Auth> auth_;
  std::unique_ptr<Services> services_;
  std::uint64_t now_ns_ = 1'000'000'000'000;
};

TEST_F(Idle, ParametersAreCopiedOnceForEachChange) {
  ASSERT_TRUE(core_.connected());
  ASSERT_TRUE(core_.has_parameters());
  const std::uint64_t before = core_.parameter_copies();
  EXPECT_LE(before, 2U);
  poll(40);
  EXPECT_EQ(core_.parameter_copies(), before);
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
  std::shared_ptr<Client> client;

 private:
  int fd_ = -1;
  std::array<char, 65536> buffer_{};
};

TEST_F(Idle, TheSteadyStreamAsksNothingOfTheHeap) {
  const auto session = std::make_shared<Session>();
  std::vector<std::unique_ptr<Browser>> browsers;
  for (std::uint32_t i = 0; i < 20; ++i) browsers.push_back(std::make_unique<Browser>(io_, hub_, session, i + 1));
  hub_.set_every_tick(*browsers[0]->client, true);
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
  EXPECT_GT(bytes, 20U * 3000U * sizeof(contract::TickRecord)) << "every client has got every step";
}

TEST_F(Idle, AFrameThatAClientStillSendsIsNotWrittenAgain) {
  std::vector<contract::TickRecord> records(1);
  TelemetryFrames frames;
  std::vector<SharedFrame> held;
  std::vector<std::string> was;
  for (std::uint64_t i = 0; i < 20; ++i) {
    records[0].tick = i;
    held.push_back(frames.encode(records));
    was.push_back(*held.back());
  }
  for (std::size_t i = 0; i < held.size(); ++i) EXPECT_EQ(*held[i], was[i]) << i;
}

// The action itself refuses too low a role, independent of the protocol's table; the core receives nothing.
TEST_F(Idle, ActionsAskForTheRoleThemselves_H28) {
  ASSERT_TRUE(core_.connected());
  const Asker viewer{.client = 7, .epoch = 0, .role = contract::Role::viewer};
  Asker therapist = viewer;
  therapist.role = contract::Role::therapist;
  const json none, empty = json::object();
  int refused = 0, asked = 0;
  const OutcomeDone done = [&refused](const Outcome& outcome) {
    EXPECT_EQ(outcome.kind, Outcome::Kind::refused);
    EXPECT_EQ(outcome.refusals, std::vector<std::string>{"not_allowed"});
    ++refused;
  };
  const auto one = [&](auto act, const Asker& asker, const auto&... wish) {
    ++asked;
    act(*services_, asker, wish..., done);
  };
  one(act_take_lease, viewer, true);
  one(act_ask_lease, viewer, false);
  one(act_hand_over, viewer, HandOverWish{.client = 8, .user = {}});
  one(act_keep_lease, viewer);
  one(act_mode, viewer, ModeWish{json("user"), none, none, none});
  one(act_mode, viewer, ModeWish{json("standby"), none, none, none});
  one(act_acknowledge, viewer, none);
  one(act_choose, viewer, empty);
  one(act_calibrate, viewer, CalibrateWish{});
  one(act_measure, viewer, MeasureWish{});
  one(act_use_calibration, viewer);
  one(act_cancel_calibration, viewer);
  one(act_neutral, viewer);
  one(act_pose, viewer, StartPose{});
  one(act_set, viewer, NumbersByName{{"v_max_m_s", 0.1}}, std::nullopt, 0U);
  one(act_keep_trial, viewer, 0U);
  one(act_undo_trial, viewer);
  one(act_preset, viewer, std::string{"walk"}, 0U);
  one(act_mark, viewer, std::optional<db::SessionId>{}, json("here"));
  one(act_record, viewer, RecordWish{.starts = true, .subject = {}, .note = {}});
  one(act_delete_session, viewer, db::SessionId{1});
  one(act_start_job, viewer, JobKind::integrity_check, JobArguments{});
  one(act_cancel_job, viewer, JobId{1});
  one(act_update_firmware, therapist, std::vector<std::uint8_t>{}, contract::Node::tilt_base, false);
  EXPECT_EQ(refused, asked);
  std::uint64_t sequence = 0;
  const DriveWish push{.sequence = 1, .echo_time_ns = 1, .speed_norm = 1.0, .yaw_norm = 0.0, .held = true};
  EXPECT_EQ(act_drive(*services_, viewer, push, sequence), contract::Refusal::not_allowed);
  fake_.skip(2);
  EXPECT_TRUE(fake_.commands().empty());
  EXPECT_EQ(fake_.drive().held, 0U);
  EXPECT_TRUE(jobs_.list().empty());
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
