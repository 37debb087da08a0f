// Patients, visits and profiles over REST and hoist.v1: created, changed for what was seen, chosen before a walk, deleted with everything.
#include <fstream>
#include <iterator>

#include "control/contract/params.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using contract::Mode;

class People : public ServerTest {
 protected:
  json made(const std::string& code) {
    const Answer answer = call("POST", "/api/v1/patients", {{"code", code}});
    EXPECT_EQ(answer.status, 201U) << answer.body;
    EXPECT_EQ(answer.header("location"), "/api/v1/patients/" + answer.json()["id"].dump());
    return answer.json();
  }
  static std::string at(const json& patient) { return "/api/v1/patients/" + patient["id"].dump(); }
  static Headers seen(const json& row) { return {{"If-Match", "\"" + row["etag"].get<std::string>() + "\""}}; }
  void mode(Mode mode) {
    core_->set([mode](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(mode); });
  }
  json recording() { return get("/api/v1/recording").json(); }
  // A walk long enough to be a session, and its end.
  std::int64_t walk() {
    mode(Mode::user);
    EXPECT_TRUE(until([&] { return recording()["state"] == "recording" && recording()["standby"] == false; }));
    const auto session = recording()["session"].get<std::int64_t>();
    mode(Mode::standby);
    EXPECT_TRUE(until([&] { return recording()["session"] != session; }));
    return session;
  }
};

TEST_F(People, AChangeSaysWhatItWasMadeFor) {
  const json patient = made("P-017");
  EXPECT_EQ(call("POST", "/api/v1/patients", {{"code", " p-017 "}}).status, 409U) << "the same patient";
  for (const Answer& refused :
       {call("POST", "/api/v1/patients", {{"code", "Anna Novak"}}), call("PATCH", at(patient), {{"code", "P/1"}}, {{"If-Match", "*"}})}) {
    EXPECT_EQ(refused.status, 422U) << refused.body;
    EXPECT_EQ(refused.json()["errors"][0]["field"], "code");
    EXPECT_NE(refused.json()["errors"][0]["message"].get<std::string>().find("1 to 32 letters, digits"), std::string::npos);
  }
  for (const char* method : {"PATCH", "DELETE"}) {
    const json body = std::string(method) == "PATCH" ? json{{"archived", true}} : json();
    EXPECT_EQ(call(method, at(patient), body, {{"If-Match", ""}}).status, 428U) << method;
    EXPECT_EQ(call(method, at(patient), body, {{"If-Match", "\"0000000000000000\""}}).status, 412U) << method;
    EXPECT_EQ(call(method, "/api/v1/patients/99", body, {{"If-Match", "*"}}).status, 404U) << method;
  }
  EXPECT_EQ(get(at(patient)).header("etag"), "\"" + patient["etag"].get<std::string>() + "\"");
  const Answer archived = call("PATCH", at(patient), {{"archived", true}}, seen(patient));
  ASSERT_EQ(archived.status, 200U);
  EXPECT_EQ(archived.json()["archived"], true);
  EXPECT_EQ(call("PATCH", at(patient), {{"archived", false}}, seen(patient)).status, 412U);
  EXPECT_EQ(get("/api/v1/patients?archived=0").json()["items"].size(), 0U);
  EXPECT_EQ(get("/api/v1/patients?archived=1&q=017").json()["items"].size(), 1U);
  EXPECT_EQ(get("/api/v1/patients?archived=x").status, 422U);
  EXPECT_EQ(call("PUT", "/api/v1/patient", {{"patient", patient["id"]}}).status, 409U) << "archived";
}

TEST_F(People, WhoIsChosenIsRecordedAndToldToAllScreens) {
  const json patient = made("P-017"), other = made("P-018");
  Live screen(port_, bearer_);
  EXPECT_TRUE(screen.wait("patient")["id"].is_null());
  EXPECT_EQ(call("PUT", "/api/v1/patient", {{"patient", 99}}).status, 404U);
  EXPECT_EQ(call("PUT", "/api/v1/patient", {{"patient", patient["id"]}}).json(), (json{{"id", patient["id"]}, {"code", "P-017"}}));
  EXPECT_EQ(screen.wait("patient")["code"], "P-017");
  EXPECT_EQ(call("PATCH", at(patient), {{"code", "P-1"}}, seen(patient)).status, 409U) << "a walk would get the old code";
  EXPECT_EQ(call("DELETE", at(patient), nullptr, seen(patient)).status, 409U);
  mode(Mode::user);
  ASSERT_TRUE(until([&] { return get("/api/v1/status").json()["core"]["mode"] == "user"; }));
  EXPECT_EQ(call("PUT", "/api/v1/patient", {{"patient", other["id"]}}).status, 409U) << "while the hoist is led";
  const std::int64_t session = walk();
  EXPECT_EQ(get("/api/v1/sessions/" + std::to_string(session)).json()["subject"], "P-017");
  EXPECT_EQ(get(at(patient)).json()["sessions"], 1);
  const json reply = screen.ask({{"type", "choose_patient"}, {"patient", other["id"]}});
  EXPECT_EQ(reply["ok"], true) << reply;
  EXPECT_EQ(screen.wait("patient")["code"], "P-018");
  EXPECT_EQ(call("PUT", "/api/v1/patient", {{"patient", nullptr}}).json()["id"], nullptr);

  // The visit has a note; the patient goes with everything.
  const json visit = get("/api/v1/visits?patient=" + patient["id"].dump()).json()["items"].at(0);
  const std::string visit_at = "/api/v1/visits/" + visit["id"].dump();
  EXPECT_EQ(call("PATCH", visit_at, {{"note", "tired"}}, {{"If-Match", ""}}).status, 428U);
  EXPECT_EQ(call("PATCH", visit_at, {{"note", "tired"}}, seen(visit)).json()["note"], "tired");
  EXPECT_EQ(call("PATCH", visit_at, {{"note", "fresh"}}, seen(visit)).status, 412U);
  EXPECT_EQ(get(visit_at).json()["note"], "tired");
  EXPECT_EQ(get("/api/v1/visits?day=1999-01-01").json()["items"].size(), 0U);
  EXPECT_EQ(call("DELETE", at(patient), nullptr, {{"If-Match", "*"}}).status, 204U);
  EXPECT_EQ(get(at(patient)).status, 404U);
  EXPECT_EQ(get("/api/v1/sessions/" + std::to_string(session)).status, 404U);
  EXPECT_EQ(get(visit_at).status, 404U);
}

TEST_F(People, AnIdentityIsTheTherapistsAndInNoFile) {
  const json patient = made("P-017");
  const json who{{"name", "Zdenka Marolt-Quux"}, {"birth_date", "1948-02-29"}, {"note", "allergic to Heftpflaster"}};
  EXPECT_EQ(get(at(patient) + "/identity").json()["state"], "none");
  EXPECT_EQ(call("PUT", at(patient) + "/identity", who, {{"If-Match", ""}}).status, 428U);
  const Answer stored = call("PUT", at(patient) + "/identity", who, seen(patient));
  ASSERT_EQ(stored.status, 200U) << stored.body;
  EXPECT_EQ(stored.json()["has_identity"], true);
  EXPECT_EQ(get(at(patient) + "/identity").json()["identity"], who);
  const Answer refused = call("PUT", at(patient) + "/identity", {{"name", "Marolt"}, {"birth_date", "1948-02-30"}}, {{"If-Match", "*"}});
  EXPECT_EQ(refused.status, 422U);
  EXPECT_EQ(refused.json()["errors"][0]["field"], "birth_date");
  EXPECT_EQ(refused.body.find("1948"), std::string::npos);
  std::filesystem::rename(folder_ / "hoist.db.key", folder_ / "away");
  const json hidden = get(at(patient) + "/identity").json();
  EXPECT_EQ(hidden["state"], "key_missing");
  EXPECT_TRUE(hidden["identity"].is_null());
  EXPECT_EQ(get(at(patient)).json()["code"], "P-017") << "codes go on working";
  const Answer keyless = call("PUT", at(made("P-018")) + "/identity", who, {{"If-Match", "*"}});
  EXPECT_EQ(keyless.status, 409U);
  EXPECT_TRUE(keyless.json()["type"].get<std::string>().ends_with("identity-key"));
  std::filesystem::rename(folder_ / "away", folder_ / "hoist.db.key");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_.path())) {
    if (!entry.is_regular_file()) continue;
    std::ifstream in(entry.path(), std::ios::binary);
    const std::string all{std::istreambuf_iterator<char>(in), {}};
    for (const auto& [name, value] : who.items()) EXPECT_EQ(all.find(value.get<std::string>()), std::string::npos) << entry.path();
  }
  for (const char* path : {"/api/v1/patients", "/api/v1/visits", "/api/v1/sessions", "/api/v1/status"})
    EXPECT_EQ(get(path).body.find("Marolt"), std::string::npos) << path;
  EXPECT_EQ(call("DELETE", at(patient) + "/identity", nullptr, {{"If-Match", "*"}}).json()["has_identity"], false);
  EXPECT_EQ(get(at(patient) + "/identity").json()["state"], "none");
}

TEST_F(People, AProfileIsSavedFromWhatIsInForceComparedAndAppliedWhole) {
  const json patient = made("P-017");
  const Answer saved = call("POST", at(patient) + "/profiles", {{"name", "usual"}});
  ASSERT_EQ(saved.status, 201U) << saved.body;
  json profile = saved.json();
  const std::string path = "/api/v1/profiles/" + profile["id"].dump();
  for (const contract::ParamInfo& p : contract::kParams)
    EXPECT_EQ(profile["settings"].contains(std::string{p.name}), p.role <= contract::Role::therapist) << p.name;
  EXPECT_EQ(profile["actor"]["client"], "script");
  EXPECT_EQ(get(path + "/diff").json()["items"], json::array()) << "nothing has changed since";
  EXPECT_EQ(call("POST", at(patient) + "/profiles", {{"name", "usual"}}).status, 409U);

  // Another value in force is the one difference; applying brings it back, for the version that was looked at only.
  const double before = profile["settings"]["lean_dead_band_norm"];
  ASSERT_EQ(call("PUT", "/api/v1/parameters/lean_dead_band_norm", {{"value", before + 0.01}}).status, 200U);
  const json diff = get(path + "/diff").json();
  ASSERT_EQ(diff["items"].size(), 1U) << diff;
  EXPECT_EQ(diff["items"][0]["name"], "lean_dead_band_norm");
  EXPECT_EQ(diff["items"][0]["profile"], before);
  EXPECT_EQ(diff["items"][0]["in_force"], before + 0.01);
  const auto version = diff["version"].get<std::uint32_t>();
  EXPECT_EQ(call("POST", path + "/apply", {{"version", version + 7}}).status, 412U);
  EXPECT_EQ(get("/api/v1/parameters/lean_dead_band_norm").json()["value"], before + 0.01) << "nothing was changed";
  const Answer applied = call("POST", path + "/apply", {{"version", version}});
  ASSERT_EQ(applied.status, 200U) << applied.body;
  EXPECT_EQ(applied.json()["values"]["lean_dead_band_norm"], before);

  // A change is the next version; what a profile may hold is judged field by field.
  EXPECT_EQ(call("PATCH", path, {{"settings", {{"lean_dead_band_norm", 0.2}}}}, {{"If-Match", ""}}).status, 428U);
  const Answer changed = call("PATCH", path, {{"settings", {{"lean_dead_band_norm", 0.2}}}}, seen(profile));
  ASSERT_EQ(changed.status, 200U) << changed.body;
  EXPECT_EQ(changed.json()["version"], 2);
  EXPECT_EQ(call("PATCH", path, {{"name", "x"}}, seen(profile)).status, 412U);
  EXPECT_EQ(get(path + "/versions").json()["items"].size(), 2U);
  for (const char* name : {"track_width_m", "nothing_m"}) {
    const Answer refused = call("PATCH", path, {{"settings", {{name, 0.5}}}}, {{"If-Match", "*"}});
    EXPECT_EQ(refused.status, 422U) << name;
    EXPECT_EQ(refused.json()["errors"][0]["field"], name);
  }
  const Answer range = call("PATCH", path, {{"settings", {{"lean_dead_band_norm", 9}}}}, {{"If-Match", "*"}});
  EXPECT_EQ(range.json()["errors"][0]["max"], 0.5);
  EXPECT_EQ(get(at(patient) + "/profiles").json()["items"][0]["version"], 2);

  mode(Mode::user);
  ASSERT_TRUE(until([&] { return get("/api/v1/status").json()["core"]["mode"] == "user"; }));
  EXPECT_EQ(call("POST", path + "/apply", {{"version", version + 1}}).status, 409U) << "only at standstill";
  EXPECT_EQ(call("DELETE", path, nullptr, {{"If-Match", "*"}}).status, 204U);
  EXPECT_EQ(get(path).status, 404U);
}

}  // namespace
}  // namespace hoist::test
