// What is asked over all sessions (changes of parameters, alarms, a patient's figures), what may be edited and for which state, and requests
// that are sent twice.
#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"
#include "control/contract/program_version.hpp"
#include "db/metrics/metric_list.hpp"
#include "db/report/batch.hpp"
#include "db/store/database.hpp"
#include "db/store/sqlite.hpp"
#include "server/api/idempotency.hpp"
#include "server/contract/routes.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using contract::Mode;

constexpr const char* kTuned = "lean_dead_band_norm";

class History : public ServerTest {
 protected:
  void set(const std::string& name, double value) { ASSERT_EQ(call("PUT", "/api/v1/parameters/" + name, {{"value", value}}).status, 200U); }
  double in_force(const std::string& name) { return get("/api/v1/parameters/" + name).json()["value"]; }
  json changes(const std::string& query = "") { return get("/api/v1/parameters/history?limit=200" + query).json()["items"]; }
  // Rows are written after the answers.
  json change_to(double value, const std::string& query = "") {
    json found;
    EXPECT_TRUE(until([&] {
      for (const json& row : changes(query))
        if (row["value"] == value) found = row;
      return !found.is_null();
    })) << value;
    return found;
  }
  void mode(Mode mode, bool simulated = true) {
    core_->set([=](contract::TickRecord& r) {
      r.mode = static_cast<std::uint8_t>(mode);
      r.simulated = simulated ? 1 : 0;
    });
  }
  json recorded() { return get("/api/v1/recording").json()["session"]; }
  // Standby with a patient may begin to be recorded only now: that is no walk yet.
  std::int64_t begin_walk(bool simulated = true) {
    mode(Mode::user, simulated);
    json now;
    EXPECT_TRUE(until([&] {
      now = get("/api/v1/recording").json();
      return !now["session"].is_null() && now["standby"] == false;
    }));
    return now["session"].get<std::int64_t>();
  }
  void end_walk() {
    const json walk = recorded();
    core_->skip(300);
    mode(Mode::standby, false);
    core_->skip(400);
    // The recorder reads faster than the network's thread.
    EXPECT_TRUE(until([&] { return recorded() != walk && get("/api/v1/mode").json()["mode"] == "standby"; }));
  }
  void choose(const json& patient) { ASSERT_EQ(call("PUT", "/api/v1/patient", {{"patient", patient}}).status, 200U); }
  json patient(const std::string& code) {
    const Answer made = call("POST", "/api/v1/patients", {{"code", code}});
    EXPECT_EQ(made.status, 201U) << made.body;
    return made.json();
  }
  void add_user(const char* name) {
    const json body{{"user", name}, {"display_name", "A"}, {"role", "engineer"}, {"password", kPassword}};
    ASSERT_EQ(call("POST", "/api/v1/users", body).status, 201U);
  }
  // Of an account, after signing in by its name.
  json add_token(const char* user) {
    Headers page{{"X-Hoist", "1"}, {"Content-Type", "application/json"}};
    const Answer in = http(port_, "POST", "/api/v1/session", page, json{{"user", user}, {"password", kPassword}}.dump());
    EXPECT_EQ(in.status, 200U) << in.body;
    page.emplace_back("Cookie", in.header("set-cookie").substr(0, in.header("set-cookie").find(';')));
    const Answer made = http(port_, "POST", "/api/v1/tokens", page, json{{"name", "notebook"}, {"scope", "viewer"}, {"days", 1}}.dump());
    EXPECT_EQ(made.status, 201U) << made.body;
    return made.json();
  }
  // A job's result.
  json done(const json& request) {
    const Answer started = call("POST", "/api/v1/jobs", request);
    EXPECT_EQ(started.status, 202U) << started.body;
    json info;
    EXPECT_TRUE(until([&] {
      info = get("/api/v1/jobs/" + started.json()["id"].dump()).json();
      return info["ended_utc_ms"] != nullptr;
    }));
    EXPECT_EQ(info["state"], "done") << info;
    return info["result"];
  }
  static constexpr const char* kPassword = "four words not together";
};

// The restored file has the parameters and the patients of its day.
TEST_F(History, ARestoredFileIsComparedWithWhatIsInForceAndEndsTheChoiceOfAPatient) {
  std::filesystem::create_directory(folder_ / "stick");
  const double first = in_force(kTuned);
  set(kTuned, first + 0.01);
  change_to(first + 0.01);
  const json backup = done({{"kind", "backup"}})["backup"];
  set(kTuned, first + 0.02);
  change_to(first + 0.02);
  const json chosen = patient("P-017");
  choose(chosen["id"]);
  done({{"kind", "restore"}, {"backup", backup}});
  EXPECT_EQ(patient("P-018")["id"], chosen["id"]) << "another one of the same number";
  EXPECT_TRUE(until([&] { return get("/api/v1/patient").json()["id"].is_null(); }));
  EXPECT_EQ(get("/api/v1/recording").json()["state"], "idle") << "nobody stands there who is known";
  const json row = change_to(first + 0.02);
  EXPECT_EQ(row["how"], "not_seen");
  EXPECT_EQ(row["before"], first + 0.01);
}

TEST_F(History, EachChangeOfAParameterSaysWhenByWhomInWhichSessionAndHow) {
  const double first = in_force(kTuned);
  set(kTuned, first + 0.01);
  const json row = change_to(first + 0.01);
  EXPECT_EQ(row["name"], kTuned);
  EXPECT_EQ(row["before"], first);
  EXPECT_EQ(row["how"], "set");
  EXPECT_EQ(row["actor"], (json{{"user", "local"}, {"role", "engineer"}, {"origin", "rest"}, {"client", "script"}}));
  EXPECT_TRUE(row["session"].is_null()) << "nothing was recorded then";
  EXPECT_TRUE(row["source"].is_null());
  EXPECT_EQ(changes().size(), 1U) << "what was there at the start is no change";

  // In a session, of a patient.
  const json person = patient("P-017");
  choose(person["id"]);
  const std::int64_t session = begin_walk();
  Live screen(port_, bearer_);
  ASSERT_EQ(screen.ask({{"type", "set"}, {"values", {{kTuned, first + 0.02}}}, {"revert_after_s", 20}})["ok"], true);
  end_walk();
  choose(nullptr);
  set(kTuned, first + 0.03);
  EXPECT_EQ(change_to(first + 0.02)["session"], session);
  EXPECT_EQ(change_to(first + 0.02)["how"], "trial");
  EXPECT_EQ(change_to(first + 0.02)["actor"]["origin"], "hoist.v1");
  EXPECT_TRUE(change_to(first + 0.03)["session"].is_null());
  const std::string of_patient = "&patient=" + person["id"].dump();
  EXPECT_EQ(change_to(first + 0.02, of_patient)["session"], session);
  EXPECT_EQ(changes(of_patient).size(), 1U);
  EXPECT_EQ(changes("&patient=99").size(), 0U);

  // Presets and profiles by their names; with who asked, or none.
  ASSERT_EQ(call("POST", "/api/v1/presets/paper/apply", json::object()).status, 200U);
  EXPECT_EQ(change_to(0.0086, "&name=speed_per_unit_m_s")["how"], "preset");
  EXPECT_EQ(change_to(0.0086, "&name=speed_per_unit_m_s")["source"], "paper");
  const Answer saved = call("POST", "/api/v1/patients/" + person["id"].dump() + "/profiles",
                            {{"name", "with brace"}, {"settings", {{kTuned, first + 0.04}}}});
  ASSERT_EQ(saved.status, 201U);
  const std::string profile = "/api/v1/profiles/" + saved.json()["id"].dump();
  ASSERT_EQ(call("POST", profile + "/apply", {{"version", get(profile + "/diff").json()["version"]}}).status, 200U);
  EXPECT_EQ(change_to(first + 0.04)["how"], "profile");
  EXPECT_EQ(change_to(first + 0.04)["source"], "with brace");
  contract::Event over;
  over.kind = contract::EventKind::parameter_changed;
  over.item = contract::kParams[*contract::find_param(kTuned)].id;
  over.value = first + 0.05;
  over.before = first + 0.04;
  core_->publish_event(over);
  EXPECT_EQ(change_to(first + 0.05)["how"], "trial_over");
  EXPECT_TRUE(change_to(first + 0.05)["actor"].is_null());
  EXPECT_EQ(get("/api/v1/parameters/history?name=nothing").status, 422U);
}

TEST_F(History, PagesHoldEachChangeOnceAndMomentsBoundThem) {
  const double first = in_force(kTuned);
  for (int i = 1; i <= 5; ++i) set(kTuned, first + 0.01 * i);
  (void)change_to(first + 0.05);
  std::vector<std::int64_t> seen;
  std::string cursor;
  do {
    const json page = get("/api/v1/parameters/history?limit=2&name=" + std::string(kTuned) + "&cursor=" + cursor).json();
    ASSERT_LE(page["items"].size(), 2U);
    for (const json& row : page["items"]) seen.push_back(row["id"]);
    cursor = page["next"].is_null() ? "" : page["next"].get<std::string>();
  } while (!cursor.empty());
  EXPECT_EQ(seen.size(), 5U);
  EXPECT_TRUE(std::ranges::is_sorted(seen, std::greater<>()));

  const json rows = changes();
  const auto third = rows[2]["utc_ms"].get<std::int64_t>();
  for (const json& row : changes("&from_utc_ms=" + std::to_string(third + 1))) EXPECT_GT(row["utc_ms"], third);
  for (const json& row : changes("&to_utc_ms=" + std::to_string(third))) EXPECT_LT(row["utc_ms"], third);
  // From before all of them until now: one difference.
  const auto begin = rows[4]["utc_ms"].get<std::int64_t>() - 1;
  const json diff = get("/api/v1/parameters/diff?from_utc_ms=" + std::to_string(begin)).json();
  ASSERT_EQ(diff["items"].size(), 1U) << diff;
  EXPECT_EQ(diff["items"][0], (json{{"name", kTuned}, {"from", first}, {"to", first + 0.05}}));
  EXPECT_EQ(get("/api/v1/parameters/diff?from_utc_ms=9000000000000").status, 422U) << "later than now";
  for (const char* bad : {"diff", "diff?from_utc_ms=x", "diff?from_utc_ms=5&to_utc_ms=4", "history?limit=0", "history?cursor=x",
                          "history?from_utc_ms=-1", "history?patient=x"})
    EXPECT_EQ(get(std::string("/api/v1/parameters/") + bad).status, 422U) << bad;
}

TEST_F(History, WhatChangedWhileNobodyListenedIsFound) {
  const double first = in_force(kTuned);
  set(kTuned, first + 0.01);
  (void)change_to(first + 0.01);
  stop_server();
  core_.reset();
  core_ = std::make_unique<FakeCore>((folder_ / "core.sock").string());  // has forgotten the change
  start_server();
  wait_for_core();
  const json row = change_to(first);
  EXPECT_EQ(row["how"], "not_seen");
  EXPECT_EQ(row["before"], first + 0.01);
  EXPECT_TRUE(row["actor"].is_null());
  EXPECT_EQ(changes().size(), 2U);
}

TEST_F(History, AlarmsOfAllSessionsAreFoundByFaultSessionAndTime) {
  const auto fault = [&](contract::EventKind kind, const char* name) {
    contract::Event event;
    event.kind = kind;
    event.code = contract::find_fault(name)->bit;
    core_->publish_event(event);
    core_->skip(20);
  };
  std::vector<std::int64_t> sessions;
  for (int i = 0; i < 2; ++i) {
    sessions.push_back(begin_walk(i == 0));
    fault(contract::EventKind::fault_raised, "stop_pressed");
    fault(contract::EventKind::fault_cleared, "stop_pressed");
    fault(contract::EventKind::fault_raised, "tilt_left_lost");
    end_walk();
  }
  const auto alarms = [&](const std::string& query) { return get("/api/v1/alarms" + query).json(); };
  const json all = alarms("")["items"];
  ASSERT_EQ(all.size(), 4U) << all;
  EXPECT_EQ(all[0]["session"], sessions[1]);
  EXPECT_EQ(all[0]["fault"], "tilt_left_lost");
  EXPECT_TRUE(all[0]["lasted_s"].is_null()) << "never over";
  EXPECT_GT(all[1]["lasted_s"].get<double>(), 0.15);
  EXPECT_LT(all[1]["lasted_s"].get<double>(), 10.0) << "until it was cleared, not until the end";
  EXPECT_EQ(all[1]["simulated"], false);
  EXPECT_EQ(all[3]["simulated"], true);
  EXPECT_EQ(alarms("?fault=stop_pressed")["items"].size(), 2U);
  EXPECT_EQ(alarms("?session=" + std::to_string(sessions[0]))["items"].size(), 2U);
  std::set<std::string> seen;
  std::string cursor;
  do {
    const json page = alarms("?limit=1&cursor=" + cursor);
    ASSERT_EQ(page["items"].size(), 1U);
    seen.insert(page["items"][0].dump());
    cursor = page["next"].is_null() ? "" : page["next"].get<std::string>();
  } while (!cursor.empty());
  EXPECT_EQ(seen.size(), 4U);
  const std::string moment = all[2]["utc_ms"].dump();
  const json until = alarms("?to_utc_ms=" + moment);  // A range-for does not keep the whole answer alive.
  for (const json& row : until["items"]) EXPECT_EQ(row["session"], sessions[0]);
  for (const char* bad : {"?fault=none_such", "?limit=0", "?cursor=5", "?cursor=x-1", "?session=x", "?from_utc_ms=x"})
    EXPECT_EQ(get(std::string("/api/v1/alarms") + bad).status, 422U) << bad;
}

TEST_F(History, ATrendHoldsNoSimulatedWalk) {
  const json person = patient("P-017");
  choose(person["id"]);
  std::vector<std::int64_t> real;
  for (const bool simulated : {false, true, false}) {
    const std::int64_t session = begin_walk(simulated);
    if (!simulated) real.push_back(session);
    end_walk();
  }
  const std::string path = "/api/v1/patients/" + person["id"].dump() + "/trend";
  const json trend = get(path).json();
  ASSERT_EQ(trend["items"].size(), 2U) << trend;
  EXPECT_EQ(trend["simulated_left_out"], 1);
  EXPECT_EQ(trend["items"][0]["session"], real[1]);
  EXPECT_EQ(trend["items"][1]["session"], real[0]);
  // The same figures as the session's own page has, and the same reason why some are missing.
  const json metrics = get("/api/v1/sessions/" + std::to_string(real[0]) + "/metrics").json();
  for (const db::MetricInfo& figure : db::kMetrics)
    EXPECT_EQ(trend["items"][1]["figures"][std::string{figure.key}], metrics[std::string{figure.key}]) << figure.key;
  EXPECT_EQ(trend["items"][1]["reason_code"], metrics["reason_code"]);
  for (const db::MetricInfo& figure : db::kMetrics) {
    const std::string key(figure.key);
    EXPECT_EQ(trend["items"][1]["reasons"].value(key, json(nullptr)), metrics["computed"][key]["reason_code"]) << key;
  }
  const auto walked = std::ranges::find_if(trend["changes"], [](const json& change) { return change["figure"] == "walked_m"; });
  ASSERT_NE(walked, trend["changes"].end());
  EXPECT_EQ((*walked)["first"], trend["items"][1]["figures"]["walked_m"]);
  EXPECT_EQ((*walked)["last"], trend["items"][0]["figures"]["walked_m"]);
  EXPECT_EQ((*walked)["first_session"], real[0]);
  EXPECT_EQ((*walked)["reason_code"], "one_visit") << "both of one day";
  EXPECT_EQ((*walked)["retention"], nullptr);
  EXPECT_EQ((*walked)["learning"], json({{"walks", 2}, {"visits", 1}, {"slope", nullptr}, {"reason_code", "few_walks"}}));
  const json page = get(path + "?limit=1").json();
  EXPECT_EQ(page["items"].size(), 1U);
  ASSERT_EQ(page["firsts"].size(), 1U) << "the first one of all, beyond the page";
  EXPECT_EQ(page["firsts"][0], trend["items"][1]);
  EXPECT_EQ(page["changes"], trend["changes"]);
  EXPECT_EQ(trend["firsts"], json::array());
  EXPECT_EQ(get(path + "?comparable_to=" + std::to_string(real[0])).json(), trend);
  EXPECT_EQ(get(path + "?comparable_to=99").status, 404U);
  EXPECT_EQ(get(path + "?limit=1&cursor=" + page["next"].get<std::string>()).json()["items"][0]["session"], real[0]);
  EXPECT_EQ(get(path + "?limit=51").status, 422U);
  EXPECT_EQ(get("/api/v1/patients/99/trend").status, 404U);
}

// As an archive brings it: with a later number than the walks of this hoist.
TEST_F(History, ATrendIsReadInTheOrderOfDaysPageByPage) {
  const json person = patient("P-017");
  choose(person["id"]);
  std::vector<std::int64_t> walks;
  for (int i = 0; i < 3; ++i) {
    walks.push_back(begin_walk(false));
    end_walk();
  }
  stop_server();
  {
    auto database = db::Database::open(db_path_);
    ASSERT_TRUE(database.ok());
    db::execute(database->handle(), ("INSERT INTO visits (patient_id, day) VALUES (" + person["id"].dump() +
                                     ", '2020-11-10'); UPDATE sessions SET visit_id = last_insert_rowid(), started_utc_ns = "
                                     "1605000000000000000 WHERE id = " +
                                     std::to_string(walks.back()))
                                        .c_str());
  }
  start_server();
  wait_for_core();
  const std::string path = "/api/v1/patients/" + person["id"].dump() + "/trend";
  ASSERT_TRUE(until([&] { return get(path).status == 200; }));
  const std::vector<std::int64_t> newest_first{walks[1], walks[0], walks[2]};
  std::vector<std::int64_t> read;
  std::string cursor;
  do {
    const json page = get(path + "?limit=1&cursor=" + cursor).json();
    ASSERT_EQ(page["items"].size(), 1U);
    read.push_back(page["items"][0]["session"]);
    cursor = page["next"].is_null() ? "" : page["next"].get<std::string>();
    if (read.size() < 3) {
      ASSERT_EQ(page["firsts"].size(), 1U);
      EXPECT_EQ(page["firsts"][0]["session"], walks[2]);
    }
  } while (!cursor.empty() && read.size() < 3);
  EXPECT_EQ(read, newest_first);
  for (const char* bad : {"5", "20201110", "20201110-5", "20201110-5-", "20201110--5", "2020-11-10-5-6", "20201110-5-6-", "2020111a-5-6",
                          "020201110-5-6", "20201110-05-6", "-", "--"})
    EXPECT_EQ(get(path + "?cursor=" + bad).status, 422U) << bad;
  EXPECT_EQ(get(path + "?cursor=20201110-1605000000000000000-1").json()["items"], json::array());
}

// What REST gives is what db/report makes, may run nothing, and stands in the audit log.
TEST_F(History, AReportIsThePageOfItsSessionAndIsLogged) {
  const json person = patient("P-017");
  choose(person["id"]);
  const std::int64_t session = begin_walk(false);
  const std::string path = "/api/v1/sessions/" + std::to_string(session) + "/report";
  EXPECT_EQ(get(path).status, 409U) << "still being recorded";
  end_walk();
  for (const auto& [query, kind, language] : {std::tuple{"", db::ReportKind::full, db::Language::en},
                                              std::tuple{"?kind=patient&language=de", db::ReportKind::patient, db::Language::de}}) {
    const Answer page = get(path + query);
    ASSERT_EQ(page.status, 200U) << page.body;
    EXPECT_EQ(page.header("content-type"), "text/html; charset=utf-8");
    EXPECT_EQ(page.header("content-security-policy"), db::kReportPolicy) << "and no second one";
    EXPECT_EQ(page.body.find("<script"), std::string::npos);
    auto database = db::Database::attach(db_path_);
    ASSERT_TRUE(database.ok());
    EXPECT_EQ(page.body, *db::session_report(*database, session, {kind, language, std::string(contract::program_version())}));
  }
  EXPECT_NE(get("/api/v1/status").header("content-security-policy").find("default-src 'self'"), std::string::npos);
  for (const char* bad : {"?kind=short", "?language=fr"}) EXPECT_EQ(get(path + bad).status, 422U) << bad;
  EXPECT_EQ(get("/api/v1/sessions/99/report").status, 404U);
  const std::string visit = get("/api/v1/sessions/" + std::to_string(session)).json()["visit"]["id"].dump();
  const Answer group = get("/api/v1/visits/" + visit + "/report?language=de");
  EXPECT_EQ(group.status, 200U);
  EXPECT_NE(group.body.find("<td>P-017</td>"), std::string::npos);
  EXPECT_EQ(get("/api/v1/visits/99/report").status, 404U);
  // Rows are written after their answers.
  std::map<std::string, int> rows;
  EXPECT_TRUE(until([&] {
    rows.clear();
    const json all = get("/api/v1/audit?limit=200").json()["items"];
    for (const json& row : all) ++rows[row["action"].get<std::string>() + " " + row["result"].get<std::string>()];
    return rows["get_visit_report 404"] > 0;
  }));
  EXPECT_EQ(rows["get_session_report 200"], 2);
  EXPECT_EQ(rows["get_session_report 409"], 1);
  EXPECT_EQ(rows["get_visit_report 200"], 1);
}

TEST_F(History, MarkersAreListedChangedAndDeletedForWhatWasSeen) {
  const std::int64_t session = begin_walk();
  const std::string path = "/api/v1/sessions/" + std::to_string(session) + "/markers";
  for (const char* text : {"Stumbled", "Zdenka helped"}) ASSERT_EQ(call("POST", path, {{"text", text}}).status, 201U);
  end_walk();
  const json items = get(path).json()["items"];
  ASSERT_EQ(items.size(), 2U);
  const std::string second = path + "/" + items[1]["number"].dump();
  const Answer changed = call("PATCH", second, {{"text", "Helped"}}, {{"If-Match", "\"" + items[1]["etag"].get<std::string>() + "\""}});
  ASSERT_EQ(changed.status, 200U) << changed.body;
  EXPECT_EQ(changed.json()["text"], "Helped");
  EXPECT_EQ(changed.json()["utc_ms"], items[1]["utc_ms"]) << "what is not named stays";
  EXPECT_EQ(changed.json()["kind"], "note");
  EXPECT_EQ(changed.json()["actor"], items[1]["actor"]);
  EXPECT_EQ(call("PATCH", second, {{"text", std::string(501, 'x')}}, {{"If-Match", "*"}}).status, 422U);
  EXPECT_EQ(call("PATCH", path + "/99", {{"text", "x"}}, {{"If-Match", "*"}}).status, 404U);
  EXPECT_EQ(call("DELETE", path + "/" + items[0]["number"].dump(), nullptr, {{"If-Match", "*"}}).status, 204U);
  EXPECT_EQ(get(path).json()["items"], json::array({changed.json()}));
  // Its kind and its time: to a moment of the session only.
  const Headers seen{{"If-Match", changed.header("etag")}};
  const Answer moved = call("PATCH", second, {{"kind", "help"}, {"time_s", 0.05}}, seen);
  ASSERT_EQ(moved.status, 200U) << moved.body;
  EXPECT_EQ(moved.json()["kind"], "help");
  EXPECT_EQ(moved.json()["text"], "Helped");
  EXPECT_DOUBLE_EQ(moved.json()["time_s"].get<double>(), 0.05);
  const json samples = get("/api/v1/sessions/" + std::to_string(session) + "/samples?columns=tick&from_s=0.05&to_s=0.06").json();
  EXPECT_EQ(moved.json()["tick"].get<double>(), samples["columns"][0]["min"][0].get<double>()) << samples;
  EXPECT_EQ(call("PATCH", second, {{"kind", "rest"}}, seen).status, 412U) << "made for what was there before";
  const double end_s = get("/api/v1/sessions/" + std::to_string(session)).json()["duration_s"];
  const Answer outside = call("PATCH", second, {{"time_s", end_s + 100}}, {{"If-Match", "*"}});
  EXPECT_EQ(outside.status, 422U);
  EXPECT_EQ(outside.json()["errors"][0]["field"], "time_s");
  EXPECT_NE(outside.json()["errors"][0]["message"].get<std::string>().find("0 to "), std::string::npos) << outside.body;
  for (const json& bad : {json{{"kind", "joke"}}, json{{"time_s", -1}}, json{{"utc_ms", 5}}, json::object()})
    EXPECT_EQ(call("PATCH", second, bad, {{"If-Match", "*"}}).status, 422U) << bad;
  EXPECT_EQ(get(path).json()["items"], json::array({moved.json()}));
  EXPECT_EQ(get("/api/v1/sessions/99/markers").status, 404U);
  // What was overwritten and deleted is in no file.
  stop_server();
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
    if (!entry.is_regular_file()) continue;
    std::ifstream in(entry.path(), std::ios::binary);
    const std::string all{std::istreambuf_iterator<char>(in), {}};
    for (const char* gone : {"Stumbled", "Zdenka"}) EXPECT_EQ(all.find(gone), std::string::npos) << gone << " " << entry.path();
  }
}

// What people may edit, for what they were shown only.
TEST_F(History, EverythingThatIsEditedCarriesItsTagAndRefusesAnOldOne) {
  const json person = patient("P-017");
  const std::string people = "/api/v1/patients/" + person["id"].dump();
  choose(person["id"]);
  const std::string session = "/api/v1/sessions/" + std::to_string(begin_walk());
  ASSERT_EQ(call("POST", session + "/markers", {{"text", "Rest"}}).status, 201U);
  end_walk();
  choose(nullptr);
  const std::string visit = "/api/v1/visits/" + get("/api/v1/visits").json()["items"][0]["id"].dump();
  const std::string marker = session + "/markers/" + get(session + "/markers").json()["items"][0]["number"].dump();
  const std::string profile = "/api/v1/profiles/" + call("POST", people + "/profiles", {{"name", "usual"}}).json()["id"].dump();
  const json own{{"shape", "own"}, {"closed", false}, {"x_m", {0, 2}}, {"y_m", {0, 1}}};
  const std::string line = "/api/v1/lines/" + call("POST", "/api/v1/lines", {{"name", "Hall"}, {"exercise", own}}).json()["id"].dump();
  add_user("anna");
  const json token = add_token("anna");

  struct Edit {
    const char* operation;
    std::string method, path;
    json body;
    std::string shown;  // where its tag is read; empty: its list only
  };
  const std::vector<Edit> edits{
      {"change_patient", "PATCH", people, {{"archived", true}}, people},
      {"put_identity", "PUT", people + "/identity", {{"name", "N"}}, people},
      {"delete_identity", "DELETE", people + "/identity", nullptr, people},
      {"change_visit", "PATCH", visit, {{"note", "tired"}}, visit},
      {"change_profile", "PATCH", profile, {{"name", "other"}}, profile},
      {"delete_profile", "DELETE", profile, nullptr, profile},
      {"change_line", "PATCH", line, {{"name", "Yard"}}, line},
      {"delete_line", "DELETE", line, nullptr, line},
      {"change_session", "PATCH", session, {{"note", "calm"}}, session},
      {"change_marker", "PATCH", marker, {{"text", "Helped"}}, ""},
      {"delete_marker", "DELETE", marker, nullptr, ""},
      {"change_settings", "PATCH", "/api/v1/settings", {{"device_name", "Room 3"}}, "/api/v1/settings"},
      {"set_retention",
       "PUT",
       "/api/v1/retention",
       {{"days", 400}, {"disk_percent", nullptr}, {"needs_backup", true}},
       "/api/v1/retention"},
      {"set_tools", "PUT", "/api/v1/tools", {{"enabled", true}}, "/api/v1/tools"},
      {"change_user", "PATCH", "/api/v1/users/anna", {{"display_name", "Anna"}}, ""},
      {"put_parameter", "PUT", "/api/v1/parameters/lean_dead_band_norm", {{"value", 0.11}}, "/api/v1/parameters/lean_dead_band_norm"},
      {"change_parameters", "PATCH", "/api/v1/parameters", {{"lean_dead_band_norm", 0.12}}, "/api/v1/parameters"},
      {"remove_token", "DELETE", "/api/v1/tokens/" + token["id"].dump(), nullptr, ""},
      {"delete_session", "DELETE", session, nullptr, session},
      {"delete_patient", "DELETE", people, nullptr, people},
  };
  const auto tag_of = [&](const Edit& edit) {
    if (!edit.shown.empty()) return get(edit.shown).header("etag");
    const json items = get(edit.path.substr(0, edit.path.rfind('/'))).json()["items"];
    return items.empty() ? std::string() : "\"" + items.back()["etag"].get<std::string>() + "\"";
  };
  std::set<std::string> tried;
  for (const Edit& edit : edits) {
    const std::string tag = tag_of(edit);
    const auto with = [&](const std::string& match) { return call(edit.method, edit.path, edit.body, Headers{{"If-Match", match}}); };
    ASSERT_EQ(tag.front(), '"') << edit.operation;
    EXPECT_EQ(with("\"0000000000000000\"").status, 412U) << edit.operation;
    EXPECT_EQ(tag_of(edit), tag) << edit.operation << " has changed something";
    for (const std::string& none : {"W/" + tag, std::string("\"a\", \"b\""), std::string("no tag")})
      EXPECT_EQ(with(none).status, 412U) << edit.operation << " " << none;
    EXPECT_EQ(with("").status, 428U) << edit.operation;
    EXPECT_EQ(tag_of(edit), tag) << edit.operation << " has changed something";
    const Answer changed = with("\"0000000000000000\", " + tag);
    EXPECT_LT(changed.status, 300U) << edit.operation << " " << changed.body;
    const bool gone = edit.method == "DELETE" && changed.status == 204;
    if (!gone) {
      EXPECT_NE(changed.header("etag"), tag) << edit.operation;
      EXPECT_EQ(changed.header("etag"), tag_of(edit)) << edit.operation;
      EXPECT_EQ(with(tag).status, 412U) << edit.operation << " a second time for what was there before";
      EXPECT_LT(with("*").status, 300U) << edit.operation;
    }
    tried.insert(edit.operation);
  }
  // No route that edits a part of something is left out.
  for (const server::Route& route : server::kRoutes) {
    bool takes_tag = false;
    for (const server::RouteInput& input : server::kRouteInputs)
      takes_tag = takes_tag || (input.operation == route.operation && input.name == "If-Match");
    EXPECT_EQ(tried.contains(std::string{route.operation}), takes_tag) << route.operation;
  }
}

// A list that can grow is read in pages, which make up the whole; what is a table of the program, or is bounded, is one answer.
TEST_F(History, EveryListThatCanGrowIsReadInPages) {
  for (const char* name : {"anna", "bert", "cleo"}) add_user(name);
  for (int i = 0; i < 3; ++i) add_token("anna");
  patient("P-016");
  const json person = patient("P-017");
  const std::string people = "/api/v1/patients/" + person["id"].dump();
  choose(person["id"]);
  const std::string session = "/api/v1/sessions/" + std::to_string(begin_walk(false));
  for (const char* text : {"Rest", "Help", "Good"}) ASSERT_EQ(call("POST", session + "/markers", {{"text", text}}).status, 201U);
  for (int gap = 1; gap <= 3; ++gap) {
    contract::Event event;
    event.kind = contract::EventKind::fault_raised;
    core_->publish_event(event);
    core_->set([](contract::TickRecord& r) { r.tick += 7; });
    core_->skip(20);
    ASSERT_TRUE(until([&] { return get(session).json()["gaps"] == gap; }));
  }
  end_walk();
  begin_walk(false);
  end_walk();
  choose(nullptr);
  const std::string profile = "/api/v1/profiles/" + call("POST", people + "/profiles", {{"name", "usual"}}).json()["id"].dump();
  ASSERT_EQ(call("POST", people + "/profiles", {{"name", "brace"}}).status, 201U);
  for (const double value : {0.11, 0.12}) set(kTuned, value);
  change_to(0.12);
  // Nothing more changes in the list of jobs.
  EXPECT_TRUE(until([&] { return get("/api/v1/health").json()["recordings"]["state"] == "sound"; }));
  // Its rows are written after the answers, too.
  EXPECT_TRUE(until([&] { return get("/api/v1/audit?limit=1").body.find("0.12") != std::string::npos; }));

  // What is asked for, and how many rows there are at least.
  const std::map<std::string, std::pair<std::string, std::size_t>> lists{{"list_users", {"/api/v1/users", 3}},
                                                                         {"list_tokens", {"/api/v1/tokens", 3}},
                                                                         {"get_audit", {"/api/v1/audit", 10}},
                                                                         {"list_alarms", {"/api/v1/alarms", 0}},
                                                                         {"list_parameter_history", {"/api/v1/parameters/history", 2}},
                                                                         {"list_sessions", {"/api/v1/sessions", 2}},
                                                                         {"list_visits", {"/api/v1/visits", 1}},
                                                                         {"list_patients", {"/api/v1/patients", 2}},
                                                                         {"get_trend", {people + "/trend", 2}},
                                                                         {"list_lines", {"/api/v1/lines", 0}},
                                                                         {"list_profiles", {people + "/profiles", 2}},
                                                                         {"list_profile_versions", {profile + "/versions", 1}},
                                                                         {"list_events", {session + "/events", 3}},
                                                                         {"list_gaps", {session + "/gaps", 3}},
                                                                         {"list_markers", {session + "/markers", 3}},
                                                                         {"list_jobs", {"/api/v1/jobs", 1}},
                                                                         {"list_studies", {"/api/v1/studies", 0}}};
  // Every answer is checked against OpenAPI.
  const auto page_at = [&](const std::string& path) {
    json page = get(path).json();
    // Recordings are folded meanwhile.
    for (json& item : page["items"]) item.erase("stored_bytes");
    return page;
  };
  for (const auto& [operation, list] : lists) {
    const auto& [path, least] = list;
    const json whole = page_at(path + "?limit=50");
    EXPECT_TRUE(whole["next"].is_null()) << operation;
    EXPECT_GE(whole["items"].size(), least) << operation;
    for (const std::size_t limit : {1U, 2U}) {
      json joined = json::array();
      std::string cursor;
      do {
        const json page = page_at(path + "?limit=" + std::to_string(limit) + "&cursor=" + cursor);
        EXPECT_LE(page["items"].size(), limit) << operation;
        for (const json& item : page["items"]) joined.push_back(item);
        cursor = page["next"].is_null() ? "" : page["next"].get<std::string>();
      } while (!cursor.empty() && joined.size() <= whole["items"].size());
      EXPECT_EQ(joined, whole["items"]) << operation << " by " << limit;
    }
    for (const char* bad : {"?limit=0", "?limit=201", "?limit=x", "?cursor=%21"})
      EXPECT_EQ(get(path + bad).status, 422U) << operation << bad;
  }
  const std::set<std::string_view> one_answer{"list_signals",    "list_faults",       "list_modes",     "list_presets",
                                              "list_parameters", "list_tasks",        "list_exercises", "diff_profile",
                                              "diff_parameters", "get_tuning_advice", "get_calibration"};
  for (const server::Route& route : server::kRoutes) {
    const bool in_pages = std::ranges::any_of(server::kRouteInputs, [&](const server::RouteInput& input) {
      return input.operation == route.operation && input.name == "cursor";
    });
    EXPECT_EQ(in_pages, lists.contains(std::string{route.operation})) << route.operation;
    // Whatever it is called: an answer with `items`.
    if (const json schema = document_["components"]["schemas"].value(std::string{route.response}, json::object());
        route.method == server::Method::get && schema.value("properties", json::object()).contains("items")) {
      EXPECT_NE(in_pages, one_answer.contains(route.operation)) << route.operation;
    }
  }
}

TEST_F(History, ARequestThatIsSentAgainUnderItsKeyMakesNothingTwice) {
  const Headers key{{"Idempotency-Key", "\"8e03978e-40d5-43e8-bc93-6894a57f9324\""}};
  const Answer first = call("POST", "/api/v1/patients", {{"code", "P-017"}}, key);
  ASSERT_EQ(first.status, 201U) << first.body;
  const Answer again = call("POST", "/api/v1/patients", {{"code", "P-017"}}, key);
  EXPECT_EQ(again.status, 201U) << "and not that the code is taken: " << again.body;
  EXPECT_EQ(again.body, first.body);
  EXPECT_EQ(again.header("location"), first.header("location"));
  EXPECT_EQ(again.header("etag"), first.header("etag"));
  EXPECT_EQ(get("/api/v1/patients").json()["items"].size(), 1U);
  const Answer other = call("POST", "/api/v1/patients", {{"code", "P-018"}}, key);
  EXPECT_EQ(other.status, 422U);
  EXPECT_TRUE(other.json()["type"].get<std::string>().ends_with("idempotency-key-used"));
  EXPECT_EQ(call("POST", "/api/v1/jobs", {{"kind", "integrity_check"}}, key).status, 422U) << "another route";
  // A refusal is not kept: the same key goes on once its cause has gone.
  const Headers later{{"Idempotency-Key", "\"later\""}};
  EXPECT_EQ(call("POST", "/api/v1/patients/99/profiles", {{"name", "x"}}, later).status, 404U);
  EXPECT_EQ(call("POST", "/api/v1/patients/1/profiles", {{"name", "x"}}, later).status, 201U);
  for (const char* bad : {"8e03978e", "\"\"", "\"a", "\"a\"b\"", "\"\\n\""})
    EXPECT_EQ(call("POST", "/api/v1/patients", {{"code", "P-019"}}, {{"Idempotency-Key", bad}}).status, 400U) << bad;
  EXPECT_EQ(get("/api/v1/patients").json()["items"].size(), 1U);
  // Another person's key of the same name is another key.
  ASSERT_EQ(http(port_, "POST", "/api/v1/patients",
                 {{"Cookie", log_in()}, {"X-Hoist", "1"}, {"Content-Type", "application/json"}, key.front()}, R"({"code": "P-020"})")
                .status,
            201U);
}

TEST(IdempotencyKeys, RunningOnesAreToldEndedOnesForgottenInTime) {
  using server::IdempotencyKeys;
  using State = IdempotencyKeys::State;
  IdempotencyKeys keys;
  server::Response made;
  made.status = 201;
  made.body = "made";
  const auto running = keys.begin("anna", "k", "request", 0);
  ASSERT_EQ(running.state, State::fresh);
  EXPECT_EQ(keys.begin("anna", "k", "request", 1).state, State::running);
  EXPECT_EQ(keys.begin("anna", "k", "other", 1).state, State::other_request);
  EXPECT_EQ(keys.begin("bert", "k", "request", 1).state, State::fresh) << "his own";
  EXPECT_EQ(keys.begin("anna", "k", "request", IdempotencyKeys::kLife_ns * 2).state, State::running) << "however long it takes";
  keys.end(running.ticket, made);
  EXPECT_EQ(keys.begin("anna", "k", "request", 2).answer.body, "made");
  EXPECT_EQ(keys.begin("anna", "k", "request", IdempotencyKeys::kLife_ns + 1).state, State::fresh) << "after its life";
  // The oldest answers go first, those that run never; memory has an end.
  for (std::size_t i = 0; i < 3 * IdempotencyKeys::kMost; ++i) {
    const auto one = keys.begin("flood", std::to_string(i), "request", 5);
    ASSERT_EQ(one.state, State::fresh);
    keys.end(one.ticket, made);
    ASSERT_LE(keys.size(), IdempotencyKeys::kMost);
  }
  EXPECT_EQ(keys.begin("bert", "k", "request", 6).state, State::running);
  EXPECT_EQ(keys.begin("flood", "0", "request", 6).state, State::fresh);
  made.body.assign(IdempotencyKeys::kAnswerMost_bytes + 1, 'x');
  const auto large = keys.begin("anna", "large", "request", 7);
  keys.end(large.ticket, made);
  EXPECT_EQ(keys.begin("anna", "large", "request", 8).state, State::fresh) << "too large to keep";
}

class Device : public ServerTest {
 protected:
  Device() {
    adjust_ = [this](server::Settings& settings) {
      if (!may_set_) return;
      settings.set_clock = [this](std::int64_t utc_ns) {
        set_to_ns_ = utc_ns;
        return std::string();
      };
    };
  }
  std::atomic<bool> may_set_ = false;
  std::atomic<std::int64_t> set_to_ns_ = 0;
};

TEST_F(Device, ItsNameAndLanguageAreToldBeforeSigningInAndStay) {
  const json before = get("/api/v1/settings").json();
  EXPECT_EQ(before["device_name"], "");
  EXPECT_TRUE(before["language"].is_null());
  const auto told = [&] { return http(port_, "GET", "/api/v1/session").json()["device"]; };
  EXPECT_EQ(told()["name"], before["computer_name"]);
  const Headers any{{"If-Match", "*"}};
  const std::string id = before["hoist_id"];
  EXPECT_EQ(id.size(), 36U);
  EXPECT_EQ(get("/api/v1/status").json()["hoist_id"], id);
  EXPECT_EQ(call("PATCH", "/api/v1/settings", {{"hoist_id", "mine"}}, any).status, 422U) << "nobody changes it";
  ASSERT_EQ(call("PATCH", "/api/v1/settings", {{"device_name", "Room 3"}, {"language", "de"}}, any).status, 200U);
  EXPECT_EQ(told(), (json{{"name", "Room 3"}, {"language", "de"}}));
  for (const json& bad : {json{{"device_name", "two\nlines"}}, json{{"language", "fr"}}, json::object()})
    EXPECT_EQ(call("PATCH", "/api/v1/settings", bad, any).status, 422U) << bad;
  stop_server();
  start_server();
  EXPECT_TRUE(until([&] { return told()["name"] == "Room 3"; }));
  EXPECT_EQ(get("/api/v1/status").json()["hoist_id"], id) << "known from the start, before anyone asks for the settings";
  ASSERT_EQ(call("PATCH", "/api/v1/settings", {{"device_name", ""}, {"language", nullptr}}, any).status, 200U);
  EXPECT_EQ(told()["name"], before["computer_name"]);
}

TEST_F(Device, TheOperatingSystemKeepsTheTimeUnlessItIsGivenAway) {
  const json time = get("/api/v1/time").json();
  EXPECT_EQ(time["kept_by"], "operating_system");
  EXPECT_TRUE(time["client_behind_s"].is_null());
  const json asked = get("/api/v1/time?client_utc_ms=" + std::to_string(time["utc_ms"].get<std::int64_t>() - 60000)).json();
  EXPECT_NEAR(asked["client_behind_s"].get<double>(), 60.0, 20.0);
  EXPECT_GE(asked["client_behind_s"].get<double>(), 60.0);
  EXPECT_EQ(get("/api/v1/time?client_utc_ms=x").status, 422U);
  const json wish{{"utc_ms", 1900000000000}};
  const Answer refused = call("PUT", "/api/v1/time", wish);
  EXPECT_EQ(refused.status, 409U);
  EXPECT_TRUE(refused.json()["type"].get<std::string>().ends_with("system-clock"));
  stop_server();
  may_set_ = true;
  start_server();
  wait_for_core();
  EXPECT_EQ(call("PUT", "/api/v1/time", wish).json()["kept_by"], "engineers");
  EXPECT_EQ(set_to_ns_, 1900000000000 * 1'000'000);
  core_->set([](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(Mode::user); });
  ASSERT_TRUE(until([&] { return get("/api/v1/recording").json()["state"] == "recording"; }));
  EXPECT_EQ(call("PUT", "/api/v1/time", {{"utc_ms", 1800000000000}}).status, 409U) << "a jump would be in the recording";
  EXPECT_EQ(set_to_ns_, 1900000000000 * 1'000'000);
}

TEST_F(Device, ItsAddressesAreThoseOfThisComputer) {
  const json network = get("/api/v1/network").json();
  EXPECT_EQ(network["port"], port_);
  EXPECT_EQ(network["tls"]["on"], false);
  EXPECT_TRUE(network["tls"]["trust_page"].is_null());
  bool found = false;
  for (const json& one : network["interfaces"])
    if (one["loopback"] == true)
      for (const json& address : one["addresses"]) found = found || address == "127.0.0.1";
  EXPECT_TRUE(found) << network;
}

}  // namespace
}  // namespace hoist::test
