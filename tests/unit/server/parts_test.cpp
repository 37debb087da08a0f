// The parts that need no network: command line, host and origin lists, targets, JSON limits, exercises, tables.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "db/store/exercise_json.hpp"
#include "db/summary/session_json.hpp"
#include "server/contract/fields.hpp"
#include "server/contract/openapi.hpp"
#include "server/contract/routes.hpp"
#include "server/http/auth.hpp"
#include "server/http/exchange.hpp"
#include "server/link/clock_speed.hpp"
#include "server/settings.hpp"
#include "server/state/exercise.hpp"
#include "server/text/json_text.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hoist::server {
namespace {

using nlohmann::json;

TEST(Settings, ReadsAllOptions) {
  Settings s;
  std::string error;
  ASSERT_TRUE(parse_settings({"--socket", "a", "--db", "b", "--port", "0", "--web", "w", "--host", "x", "--host", "y", "--scenario",
                              "square", "--token-file", "t", "--bind", "::1"},
                             s, error))
      << error;
  EXPECT_EQ(s.port, 0);
  EXPECT_EQ(s.hosts, (std::vector<std::string>{"x", "y"}));
  EXPECT_EQ(s.scenario, "square");
}

TEST(Settings, OtherDevicesComeByHttpsOnly) {
  const auto accepted = [](std::vector<std::string> more, std::string& error) {
    std::vector<std::string> all{"--socket", "a", "--db", "b"};
    all.insert(all.end(), more.begin(), more.end());
    Settings s;
    return parse_settings(all, s, error);
  };
  std::string error;
  for (const char* address : {"0.0.0.0", "192.168.1.5", "::", "fd00::5", "::ffff:127.0.0.1"}) {
    EXPECT_FALSE(accepted({"--bind", address}, error)) << address;
    EXPECT_NE(error.find("add --tls-dir"), std::string::npos) << error;
    EXPECT_TRUE(accepted({"--bind", address, "--tls-dir", "t"}, error)) << error;
    EXPECT_TRUE(accepted({"--bind", address, "--tls-cert", "c", "--tls-key", "k", "--host", "h"}, error)) << error;
  }
  EXPECT_FALSE(accepted({"--bind", "0.0.0.0", "--tls-cert", "c", "--tls-key", "k"}, error)) << "nobody elsewhere could call it by a name";
  EXPECT_NE(error.find("--host"), std::string::npos) << error;
  for (const char* address : {"127.0.0.1", "::1", "127.0.0.2"}) EXPECT_TRUE(accepted({"--bind", address}, error)) << error;
  for (const char* address : {"hoist.local", "127.1", "1.2.3.4.5", "127.evil.example", "0x7f000001", "*"}) {
    EXPECT_FALSE(accepted({"--bind", address, "--tls-dir", "t"}, error)) << address;
    EXPECT_NE(error.find("no address"), std::string::npos) << error;
  }
}

TEST(Settings, RefusesWhatItDoesNotKnow) {
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"--db", "b"},
                                                    {"--socket", "a"},
                                                    {"--socket", "a", "--db", "b", "--port", "65536"},
                                                    {"--socket", "a", "--db", "b", "--port", "1x"},
                                                    {"--socket", "a", "--db", "b", "--port"},
                                                    {"--socket", "a", "--db", "b", "--tls-cert", "c"},
                                                    {"--socket", "a", "--db", "b", "--tls-key", "k"},
                                                    {"--socket", "a", "--db", "b", "--what", "x"}}) {
    Settings s;
    std::string error;
    EXPECT_FALSE(parse_settings(arguments, s, error));
    EXPECT_FALSE(error.empty());
  }
}

// Both clocks show this time.
Clocks at(std::int64_t s) { return {static_cast<std::uint64_t>(s), s}; }

TEST(Host, OnlyOurNames) {
  std::string error;
  const auto auth = Auth::create({.token_file = "", .hosts = {"hoist.local"}}, at(1000), error);
  ASSERT_TRUE(auth) << error;
  for (const char* good : {"127.0.0.1", "127.0.0.1:8080", "localhost:1", "LOCALHOST", "[::1]", "[::1]:80", "hoist.local:443"})
    EXPECT_TRUE(auth->host_allowed(good)) << good;
  for (const char* bad : {"", "evil.example", "127.0.0.1.evil.example", "localhost.", "[::1", "[::1]x", "127.0.0.1:80x", "127.0.0.1@evil",
                          "hoist.local.evil", "127.0.0.1:1234567", "::1"})
    EXPECT_FALSE(auth->host_allowed(bad)) << bad;
}

TEST(Origin, ExactlyTheHostAsked) {
  std::string error;
  const auto auth = Auth::create({.token_file = "", .hosts = {}}, at(1000), error);
  ASSERT_TRUE(auth) << error;
  EXPECT_TRUE(auth->origin_matches("http://127.0.0.1:8080", "127.0.0.1:8080"));
  for (const char* bad : {"", "null", "https://127.0.0.1:8080", "http://127.0.0.1:80801", "http://127.0.0.1:808", "http://127.0.0.1",
                          "http://localhost:8080", "http://127.0.0.1:8080/", "http://evil.example"})
    EXPECT_FALSE(auth->origin_matches(bad, "127.0.0.1:8080")) << bad;
  const auto secure = Auth::create({.token_file = "", .hosts = {}, .secure = true}, at(1000), error);
  ASSERT_TRUE(secure) << error;
  EXPECT_TRUE(secure->origin_matches("https://127.0.0.1:8080", "127.0.0.1:8080"));
  EXPECT_FALSE(secure->origin_matches("http://127.0.0.1:8080", "127.0.0.1:8080")) << "a plain page beside a secure one";
}

TEST(Auth, ALinkWorksOnceAndSessionsOutliveTheServer) {
  const test::TemporaryFolder folder;
  std::string error;
  std::string secret;
  std::string token;
  {
    const auto auth = Auth::create({.token_file = folder / "token", .hosts = {}}, at(1000), error);
    ASSERT_TRUE(auth) << error;
    token = auth->bearer_token();
    EXPECT_EQ(token.size(), 64U);
    const std::string link = auth->link_token();
    EXPECT_FALSE(auth->use_link("", at(1000)));
    EXPECT_FALSE(auth->use_link(link.substr(1), at(1000)));
    const auto session = auth->use_link(link, at(1000));
    ASSERT_TRUE(session);
    secret = session->secret;
    EXPECT_FALSE(auth->use_link(link, at(1000))) << "a link must not work twice";
    EXPECT_NE(auth->link_token(), link);
  }
  struct stat info {};
  ASSERT_EQ(::stat((folder / "token").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777U, 0600U);
  ASSERT_EQ(::stat((folder / "token.sessions").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777U, 0600U);
  const auto again = Auth::create({.token_file = folder / "token", .hosts = {}}, at(1010), error);
  ASSERT_TRUE(again) << error;
  EXPECT_EQ(again->bearer_token(), token);
  Request request;
  request.headers["cookie"] = "other=1; hoist_session=" + secret;
  EXPECT_FALSE(again->find(request, at(1010))) << "the link's cookie is this computer's";
  EXPECT_TRUE(again->find_for_stop(request, at(1010))) << "but for STOP";
  request.from_here = true;
  EXPECT_TRUE(again->find(request, at(1010)));
  EXPECT_TRUE(again->find(request, at(1010 + kSessionLife_s))) << "in use";
  const std::int64_t late_s = 1010 + 2 * kSessionLife_s + 1;
  EXPECT_FALSE(again->find(request, at(late_s))) << "a session ends half a day after its last use";
  EXPECT_TRUE(again->find_for_stop(request, at(late_s))) << "but may still say STOP";
  EXPECT_FALSE(again->find(request, at(1011))) << "and stays ended";
  {
    const auto later = Auth::create({.token_file = folder / "token", .hosts = {}}, at(late_s), error);
    ASSERT_TRUE(later) << error;
    EXPECT_FALSE(later->find(request, at(late_s)));
    EXPECT_TRUE(later->find_for_stop(request, at(late_s))) << "also after a restart";
    for (std::size_t i = 0; i < kSessionLimit + kPastLimit; ++i) ASSERT_TRUE(later->use_link(later->link_token(), at(late_s)));
    EXPECT_FALSE(later->find_for_stop(request, at(late_s))) << "not for ever: only so many are remembered";
  }
  request.headers["cookie"] = "hoist_session=" + secret.substr(1);
  EXPECT_FALSE(again->find(request, at(1010)));
  request.headers = {{"authorization", "Bearer " + token}};
  EXPECT_TRUE(again->find(request, at(1010)));
  request.headers = {{"authorization", "Bearer " + token + "0"}};
  EXPECT_FALSE(again->find(request, at(1010)));
  // A file that others may read is not believed.
  ::chmod((folder / "token.sessions").c_str(), 0644);
  const auto wary = Auth::create({.token_file = folder / "token", .hosts = {}}, at(1010), error);
  request.headers = {{"cookie", "hoist_session=" + secret}};
  EXPECT_FALSE(wary->find(request, at(1010)));
}

TEST(Auth, ATokenFileThatIsNoneStaysAsItIs) {
  const test::TemporaryFolder folder;
  const auto file = folder / "notes";
  std::ofstream(file) << "what the therapist wrote\n";
  std::string error;
  EXPECT_FALSE(Auth::create({.token_file = file, .hosts = {}}, at(1000), error));
  EXPECT_NE(error.find("stays as it is"), std::string::npos) << error;
  std::string text;
  std::getline(std::ifstream(file) >> std::ws, text);
  EXPECT_EQ(text, "what the therapist wrote");
  std::ofstream(file).close();
  EXPECT_TRUE(Auth::create({.token_file = file, .hosts = {}}, at(1000), error)) << "an empty file is nobody's: " << error;
}

TEST(Header, WhatMayComeOnceComesOnce) {
  EXPECT_EQ(header_fault({{"host", "a"}, {"accept", "a"}, {"accept", "b"}, {"content-length", "12"}}, false), "");
  EXPECT_EQ(header_fault({{"transfer-encoding", "Chunked"}}, false), "");
  EXPECT_NE(header_fault({{"transfer-encoding", "chunked"}}, true), "") << "HTTP/1.0 does not know it";
  for (const char* name : {"authorization", "content-encoding", "content-type", "cookie", "expect", "host", "origin", "sec-websocket-key",
                           "sec-websocket-version", "x-hoist", "x-hoist-lease"})
    EXPECT_NE(header_fault({{name, "1"}, {"accept", "a"}, {name, "1"}}, false), "") << name;
  for (const char* bad : {"", "+1", "-1", "1, 1", "0x1", "1 1"}) EXPECT_NE(header_fault({{"content-length", bad}}, false), "") << bad;
  for (const char* bad : {"", "gzip", "gzip, chunked", "chunked, chunked", "chunked;q=1", "identity"})
    EXPECT_NE(header_fault({{"transfer-encoding", bad}}, false), "") << bad;
}

TEST(Header, EntityTagsAndCodings) {
  for (const char* yes : {"\"1\"", "W/\"1\"", "\"0\", \"1\"", "\"0\",W/\"1\"", "*"}) EXPECT_TRUE(names_etag(yes, "\"1\"")) << yes;
  for (const char* no : {"", "\"2\"", "1", "\"11\"", "W/\"2\", \"3\""}) EXPECT_FALSE(names_etag(no, "\"1\"")) << no;
  for (const char* yes : {"gzip", "deflate, gzip", "gzip;q=0.5", "gzip; q=1", "*", "br;q=0, *;q=0.1"})
    EXPECT_TRUE(accepts_gzip(yes)) << yes;
  for (const char* no : {"", "br", "gzip;q=0", "gzip; q=0.000", "*, gzip;q=0", "*;q=0", "xgzip"}) EXPECT_FALSE(accepts_gzip(no)) << no;
}

TEST(Target, DecodesAndRefuses) {
  Request r;
  ASSERT_TRUE(parse_target("/a%20b/c?x=1%2C2&y=a+b&z", r));
  EXPECT_EQ(r.path, "/a b/c");
  EXPECT_EQ(r.query["x"], "1,2");
  EXPECT_EQ(r.query["y"], "a b");
  EXPECT_TRUE(r.query.contains("z"));
  for (const char* bad : {"", "a", "http://x/", "/%", "/%4", "/%zz", "/%00", "*", "/?a=1&a=1", "/?a&%61=2"})
    EXPECT_FALSE(parse_target(bad, r)) << bad;
  EXPECT_TRUE(parse_target("/?a=1&A=2&", r));
  std::string many = "/?";
  for (int i = 0; i < 40; ++i) many += "a" + std::to_string(i) + "=1&";
  EXPECT_FALSE(parse_target(many, r));
}

TEST(Json, BoundedInDepth) {
  JsonError error;
  EXPECT_FALSE(parse_json(std::string(100000, '['), error));
  EXPECT_EQ(error.position, kJsonDepthLimit + 1);
  EXPECT_TRUE(parse_json("[[[[[[[[1]]]]]]]]", error));
  EXPECT_FALSE(parse_json("[[[[[[[[[1]]]]]]]]]", error));
  EXPECT_TRUE(parse_json(R"({"a": "[[[[[[[[[[[[[[\"{{{{{{{{{"})", error)) << "brackets in a text are no depth";
}

TEST(Json, RefusesWhatIsNoJson) {
  for (const char* bad : {"", "NaN", "{\"a\": NaN}", "{\"a\": Infinity}", "{\"a\": 1e999}", "{a: 1}", "{\"a\": 1,}", "{\"a\": 1} x",
                          "\"\xff\"", "{\"a\": 01}"}) {
    JsonError error;
    EXPECT_FALSE(parse_json(bad, error)) << bad;
    EXPECT_FALSE(error.message.empty());
  }
}

TEST(Json, NothingFollowsIt) {
  JsonError error;
  for (const std::string& tail : {std::string(1, '\0'), std::string("\0{}", 3), std::string("}"), std::string("\xff"), std::string("//")}) {
    EXPECT_FALSE(parse_json("{\"a\": 1}" + tail, error)) << testing::PrintToString(tail);
  }
  EXPECT_FALSE(parse_json(std::string("{\"a\": \"\0\"}", 10), error));
  EXPECT_TRUE(parse_json("{\"a\": \"\\u0000\"} \t\r\n", error));
}

TEST(Exercise, ReadsTheFourShapes) {
  std::vector<FieldError> errors;
  const auto eight = read_exercise(json::parse(R"({"shape": "eight", "c_m": 1.0, "radius_m": 0.8})"), errors);
  ASSERT_TRUE(eight);
  EXPECT_NEAR(start_pose(*eight).psi_rad, 0.9272952180016122, 1e-12);  // asin 0.8
  EXPECT_EQ(db::exercise_as_told(stored_exercise(*eight)), exercise_json(*eight));
  const auto square = read_exercise(json::parse(R"({"shape": "square", "side_m": 3.2})"), errors);
  ASSERT_TRUE(square);
  EXPECT_DOUBLE_EQ(start_pose(*square).x_m, -1.6);
  EXPECT_TRUE(read_exercise(json::parse(R"({"shape": "straight", "length_m": 10})"), errors));
  EXPECT_TRUE(read_exercise(nullptr, errors));
  EXPECT_TRUE(errors.empty());
  EXPECT_FALSE(stored_exercise(*read_exercise(nullptr, errors)));
}

TEST(Exercise, RefusesSizesAndNamesTheField) {
  for (const char* bad :
       {R"({"shape": "circle"})", R"({})", R"(5)", R"({"shape": "eight", "c_m": 1})", R"({"shape": "eight", "c_m": 1, "radius_m": 1.1})",
        R"({"shape": "square", "side_m": 0})", R"({"shape": "square", "side_m": 1000})", R"({"shape": "straight", "length_m": "10"})",
        R"({"shape": "own", "x_m": [0, 1], "y_m": [0, 1]})", R"({"shape": "own", "closed": false, "x_m": [0], "y_m": [0]})",
        R"({"shape": "own", "closed": true, "x_m": [0, 1], "y_m": [0, 1]})",
        R"({"shape": "own", "closed": false, "x_m": [0, 1], "y_m": [0]})",
        R"({"shape": "own", "closed": false, "x_m": [0, 51], "y_m": [0, 1]})",
        R"({"shape": "own", "closed": false, "x_m": [0, 0.1], "y_m": [0, 0]})",
        R"({"shape": "own", "closed": false, "x_m": [0, "1"], "y_m": [0, 1]})",
        R"({"shape": "own", "closed": false, "x_m": [0, 1], "y_m": [0, 1], "clockwise": true})",
        R"({"shape": "own", "closed": false, "x_m": [0, 1], "y_m": [0, 1], "corner_radius_m": 0.1})"}) {
    std::vector<FieldError> errors;
    EXPECT_FALSE(read_exercise(json::parse(bad), errors)) << bad;
    ASSERT_EQ(errors.size(), 1U) << bad;
    EXPECT_TRUE(errors[0].field.starts_with("exercise.")) << bad;
  }
}

// Every row of the table, as REST reads it, the recording stores it and the core drives it.
TEST(Exercise, EachOfTheTableIsReadStoredToldAndDrivenAlike) {
  const contract::GuidedLimits limits{0.65, 0.5, 200.0};
  for (const contract::ExerciseInfo& row : contract::kExercises) {
    const Exercise usual = contract::usual_exercise(row.shape);
    const json told = exercise_json(usual);
    std::vector<FieldError> errors;
    const auto read = read_exercise(told, errors);
    ASSERT_TRUE(read) << told;
    EXPECT_EQ(std::tuple(read->shape, read->size_m, read->radius_m), std::tuple(usual.shape, usual.size_m, usual.radius_m));
    EXPECT_TRUE(wrong_fields("Exercise", told).empty()) << told;
    if (row.shape == Exercise::Shape::free) continue;
    const std::string stored = *stored_exercise(usual);
    EXPECT_TRUE(db::check_exercise(stored).ok()) << stored;
    EXPECT_EQ(db::exercise_as_told(stored), told);
    ASSERT_TRUE(contract::figure_of(usual).valid());
    EXPECT_EQ(db::figure_of_stored(stored).length_m(), contract::figure_of(usual).length_m());
    if (!contract::drivable(row.shape)) continue;
    json driven = told;
    driven["speed_m_s"] = 0.3;
    EXPECT_TRUE(wrong_fields("GuidedPath", driven).empty()) << driven;
    EXPECT_TRUE(read_guided(driven, limits, errors)) << driven;
    EXPECT_TRUE(errors.empty());
    // Beyond each end of each size, all three refuse and name it.
    for (const contract::ExerciseSize& size : contract::kExerciseSizes) {
      if (size.shape != row.shape) continue;
      for (const double wrong_m : {contract::kExerciseLeast_m / 2, contract::kExerciseMost_m + 1}) {
        json bad = told;
        bad[std::string{size.name}] = wrong_m;
        errors.clear();
        EXPECT_FALSE(read_exercise(bad, errors)) << bad;
        ASSERT_FALSE(errors.empty());
        EXPECT_EQ(errors[0].field, "exercise." + std::string{size.name});
        json kept = json::parse(stored);
        kept[std::string{size.stored}] = wrong_m;
        EXPECT_FALSE(db::check_exercise(kept.dump()).ok()) << kept;
        contract::GuidedPath path;
        static_cast<contract::SizedExercise&>(path) = usual;
        contract::size_of(path, size.role) = size.driven_most_m + 1;
        EXPECT_GT(contract::check_guided(path, limits).count, 0U) << size.name;
      }
    }
  }
}

TEST(Exercise, ComesFromTheScenario) {
  EXPECT_EQ(exercise_of_scenario("figure-eight").shape, Exercise::Shape::eight);
  EXPECT_EQ(exercise_of_scenario("square").shape, Exercise::Shape::square);
  EXPECT_EQ(exercise_of_scenario("straight").shape, Exercise::Shape::straight);
  EXPECT_EQ(exercise_of_scenario("bumper").shape, Exercise::Shape::free);
}

TEST(ClockSpeed, TellsSimulatedTimeThatRunsSlow) {
  ClockSpeed speed;
  std::uint64_t steady_ns = 5'000'000'000, core_ns = 1'000'000'000;
  const auto run = [&](double seconds, double ratio) {
    for (int i = 0; i < static_cast<int>(seconds * 100); ++i) {
      steady_ns += 10'000'000;
      core_ns += static_cast<std::uint64_t>(10'000'000 * ratio);
      speed.look(steady_ns, core_ns);
    }
  };
  run(5, 0.97);
  EXPECT_EQ(speed.slow_percent(), std::nullopt);
  run(4.5, 0.6);
  EXPECT_EQ(speed.slow_percent(), 60);
  run(4.5, 0.92);
  EXPECT_EQ(speed.slow_percent(), 90) << "no flicker at the bound";
  run(4.5, 1.0);
  EXPECT_EQ(speed.slow_percent(), std::nullopt);
  run(4.5, 0.0);
  EXPECT_EQ(speed.slow_percent(), 0) << "a simulator that stands still";
  speed.forget();
  EXPECT_EQ(speed.slow_percent(), std::nullopt);
}

TEST(OpenApi, NamesEveryRouteAndOnlyKnownSchemas) {
  const json document = openapi_document();
  EXPECT_EQ(document["openapi"], "3.1.0");
  std::set<std::string> operations;
  for (const Route& route : kRoutes) {
    std::string method{method_name(route.method)};
    for (char& c : method) c = static_cast<char>(std::tolower(c));
    ASSERT_TRUE(document["paths"][std::string{route.path}].contains(method)) << route.path;
    operations.insert(document["paths"][std::string{route.path}][method]["operationId"]);
  }
  EXPECT_EQ(operations.size(), kRoutes.size());
  const auto schema_of = [&](const char* path, const std::string& name) {
    for (const json& input : document["paths"][path]["get"]["parameters"])
      if (input["name"] == name) return input["schema"];
    return json();
  };
  EXPECT_EQ(schema_of("/api/v1/sessions", "limit"), (json{{"type", "integer"}, {"minimum", 1}, {"maximum", 200}}));
  json formats = json::array();
  for (const db::ExportFormatInfo& format : db::kExportFormats) formats.push_back(format.name);
  EXPECT_EQ(schema_of("/api/v1/sessions/{id}/export", "format")["enum"], formats);
  EXPECT_FALSE(document["paths"]["/api/v1/stop"]["post"].contains("requestBody")) << "nothing of it is looked at";
  // Every reference leads somewhere.
  const std::string text = document.dump();
  const std::string mark = "#/components/schemas/";
  std::size_t references = 0;
  for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + 1)) {
    const std::size_t end = text.find('"', at);
    EXPECT_TRUE(document["components"]["schemas"].contains(text.substr(at + mark.size(), end - at - mark.size())));
    ++references;
  }
  EXPECT_GT(references, 50U);
}

TEST(OpenApi, EveryReasonForAMissingFigureIsToldWithItsWords) {
  json codes = json::array();
  const auto row = [&codes](db::NoFigure why, const char* code, const char* text) {
    db::SessionMetrics metrics;
    metrics.why_absent = why;
    const json told = db::metrics_json(metrics, {});
    EXPECT_EQ(told["reason_code"], code);
    EXPECT_EQ(told["reason_if_none"], text);
    codes.push_back(code);
  };
#define HOIST_NO_FIGURE(name, text_en, text_de) row(db::NoFigure::name, #name, text_en);
#include "db/metrics/no_figure.def"
#undef HOIST_NO_FIGURE
  EXPECT_EQ(openapi_document()["components"]["schemas"]["NoFigure"]["enum"], codes);
}

}  // namespace
}  // namespace hoist::server
