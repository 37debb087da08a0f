// Own lines over REST: saved, changed for what was seen, deleted, walked; a session keeps the line that it walked.
#include <cmath>

#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using contract::Mode;
using contract::TickRecord;

class Lines : public ServerTest {
 protected:
  static json drawn() {
    return {{"shape", "own"}, {"closed", true}, {"x_m", {0.0, 3.0, 3.0}}, {"y_m", {0.0, 0.0, 2.0}}, {"corner_radius_m", 0.4}};
  }
  static Headers seen(const json& row) { return {{"If-Match", "\"" + row["etag"].get<std::string>() + "\""}}; }
};

TEST_F(Lines, AreSavedChangedForWhatWasSeenAndDeleted) {
  const Answer saved = call("POST", "/api/v1/lines", {{"name", "Hall"}, {"exercise", drawn()}});
  ASSERT_EQ(saved.status, 201U) << saved.body;
  const json line = saved.json();
  const std::string path = "/api/v1/lines/" + line["id"].dump();
  EXPECT_EQ(saved.header("location"), path);
  EXPECT_EQ(line["exercise"], drawn());
  EXPECT_LT(line["length_m"].get<double>(), 5 + std::sqrt(13.0)) << "round corners are shorter";
  EXPECT_EQ(get(path).json(), line);
  EXPECT_EQ(get(path).header("etag"), "\"" + line["etag"].get<std::string>() + "\"");
  const Answer taken = call("POST", "/api/v1/lines", {{"name", "Hall"}, {"exercise", drawn()}});
  EXPECT_EQ(taken.status, 409U);
  EXPECT_EQ(taken.json()["errors"][0]["field"], "name");

  for (const char* method : {"PATCH", "DELETE"}) {
    const json body = std::string(method) == "PATCH" ? json{{"name", "x"}} : json();
    EXPECT_EQ(call(method, path, body, {{"If-Match", ""}}).status, 428U) << method;
    EXPECT_EQ(call(method, path, body, {{"If-Match", "\"0000000000000000\""}}).status, 412U) << method;
    EXPECT_EQ(call(method, "/api/v1/lines/99", body, {{"If-Match", "*"}}).status, 404U) << method;
  }
  json open = drawn();
  open["closed"] = false;
  const Answer changed = call("PATCH", path, {{"name", "Corridor"}, {"exercise", open}}, seen(line));
  ASSERT_EQ(changed.status, 200U) << changed.body;
  EXPECT_EQ(changed.json()["version"], 2);
  EXPECT_EQ(get("/api/v1/lines").json()["items"], json::array({changed.json()}));
  EXPECT_EQ(call("DELETE", path, nullptr, seen(changed.json())).status, 204U);
  EXPECT_EQ(get(path).status, 404U);
  // Who did it is in the log.
  EXPECT_TRUE(until([&] {
    const std::string log = get("/api/v1/audit").body;
    return log.find("\"create_line\"") != std::string::npos && log.find("\"delete_line\"") != std::string::npos;
  }));
}

TEST_F(Lines, ARefusalNamesFieldAndRangeAndSavesNothing) {
  const auto refused = [&](const json& patch) {
    json body{{"name", "Hall"}, {"exercise", drawn()}};
    body.merge_patch(patch);
    const Answer answer = call("POST", "/api/v1/lines", body);
    EXPECT_EQ(answer.status, 422U) << body;
    return answer.json()["errors"][0];
  };
  EXPECT_EQ(refused({{"name", ""}})["field"], "name");
  EXPECT_EQ(refused({{"name", std::string(33, '\n')}})["field"], "name");
  const json far = refused({{"exercise", {{"x_m", {0, 3, 51}}}}});
  EXPECT_EQ(far["field"].get<std::string>().rfind("exercise", 0), 0U) << far;
  const json near = refused({{"exercise", {{"x_m", {0, 3, 3.1}}, {"y_m", {0, 0, 0}}}}});
  EXPECT_EQ(near["field"], "exercise.x_m.2");
  EXPECT_EQ(near["min"], 0.2);
  const json many = refused({{"exercise", {{"x_m", std::vector<double>(25, 1)}}}});
  EXPECT_EQ(many["field"].get<std::string>().rfind("exercise", 0), 0U) << many;
  const Answer square = call("POST", "/api/v1/lines", {{"name", "Hall"}, {"exercise", {{"shape", "square"}, {"side_m", 3}}}});
  EXPECT_EQ(square.status, 422U);
  EXPECT_EQ(square.json()["errors"][0]["field"], "exercise.shape");
  EXPECT_TRUE(get("/api/v1/lines").json()["items"].empty());
  // The hoist does not drive it by itself.
  json path = drawn();
  path["speed_m_s"] = 0.3;
  EXPECT_EQ(call("POST", "/api/v1/mode", {{"mode", "guided"}, {"path", path}}).status, 422U);
}

TEST_F(Lines, AreWalkedAsATaskAndTheSessionKeepsWhatItWalked) {
  json straight = drawn();
  straight["closed"] = false;
  straight["x_m"] = {0.0, 1.0};
  straight["y_m"] = {0.0, 0.0};
  const json line = call("POST", "/api/v1/lines", {{"name", "Hall"}, {"exercise", straight}}).json();
  const json wish{{"task", "own_line"}, {"line", {{"name", line["name"]}, {"exercise", line["exercise"]}}}};
  ASSERT_EQ(call("PUT", "/api/v1/task", wish).status, 200);
  EXPECT_EQ(get("/api/v1/walk").json()["task"]["line"], "Hall");
  EXPECT_EQ(get("/api/v1/walk").json()["exercise"], straight);
  core_->set([](TickRecord& r) { r.standing_still = 0; });
  Live live(port_, bearer_);
  ASSERT_EQ(live.ask({{"type", "lease_take"}})["ok"], true);
  ASSERT_EQ(live.ask({{"type", "mode"}, {"mode", "user"}, {"exercise", straight}})["ok"], true);
  ASSERT_TRUE(until([&] { return get("/api/v1/recording").json()["state"] == "recording"; }));
  core_->skip(1050);
  EXPECT_TRUE(until([&] { return core_->mode() == Mode::standby; })) << "the end of the line ends the motion";
  core_->skip(400);
  json session;
  ASSERT_TRUE(until([&] {
    const json listed = get("/api/v1/sessions").json();
    for (const json& one : listed["items"])
      if (one["recording"] == false && one["task"].is_object()) session = one;
    return session.is_object();
  }));
  EXPECT_EQ(call("DELETE", "/api/v1/lines/" + line["id"].dump(), nullptr, {{"If-Match", "*"}}).status, 204U);
  const std::string path = "/api/v1/sessions/" + session["id"].dump();
  EXPECT_EQ(get(path).json()["exercise"], straight);
  EXPECT_EQ(get(path).json()["task"]["line"], "Hall");
  EXPECT_NEAR(get(path + "/metrics").json()["reference_length_m"].get<double>(), 1.0, 0.01);
  EXPECT_NE(get(path + "/report").body.find("Hall"), std::string::npos);
}

}  // namespace
}  // namespace hoist::test
