// Exports that are whole files: made once, served in parts by their tag, and of many sessions by a job.
#include <array>
#include <map>

#include "db/store/session_writer.hpp"
#include "server/http/exchange.hpp"
#include "server/jobs/jobs.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using server::ByteRange;
using server::RangeWish;

TEST(Range, OnePartOfAFileAsRfc9110Says) {
  struct Case {
    const char* header;
    std::uint64_t size;
    RangeWish wish;
    std::uint64_t first, length;
  };
  constexpr auto kNone = RangeWish::none, kPart = RangeWish::part, kOutside = RangeWish::outside;
  for (const Case& c : std::initializer_list<Case>{
           {"", 100, kNone, 0, 0},
           {"bytes=0-0", 100, kPart, 0, 1},
           {"bytes=10-19", 100, kPart, 10, 10},
           {"bytes=90-", 100, kPart, 90, 10},
           {"bytes=99-", 100, kPart, 99, 1},
           {"bytes=99-99", 100, kPart, 99, 1},
           {"bytes=10-98", 100, kPart, 10, 89},
           {"bytes= 10 - 19 ", 100, kPart, 10, 10},
           {"bytes=-10", 100, kPart, 90, 10},
           {"bytes=-1", 100, kPart, 99, 1},
           {"bytes=-100", 100, kPart, 0, 100},
           {"bytes=0-", 1, kPart, 0, 1},
           {"bytes=-1000", 100, kPart, 0, 100},
           {"bytes=50-1000", 100, kPart, 50, 50},
           {"bytes=0-18446744073709551615", 100, kPart, 0, 100},
           {"bytes=0-99999999999999999999999", 100, kPart, 0, 100},
           {"bytes=100-", 100, kOutside, 0, 0},
           {"bytes=99999999999999999999999-", 100, kOutside, 0, 0},
           {"bytes=-0", 100, kOutside, 0, 0},
           {"bytes=0-", 0, kOutside, 0, 0},
           {"bytes=-5", 0, kOutside, 0, 0},
           {"bytes=100-200", 100, kOutside, 0, 0},
           // What may be ignored.
           {"bytes=19-10", 100, kNone, 0, 0},
           {"bytes=0-1,5-6", 100, kNone, 0, 0},
           {"bytes=-", 100, kNone, 0, 0},
           {"bytes=a-b", 100, kNone, 0, 0},
           {"bytes=a-5", 100, kNone, 0, 0},
           {"bytes=5-a", 100, kNone, 0, 0},
           {"bytes=a-", 100, kNone, 0, 0},
           {"bytes=-a", 100, kNone, 0, 0},
           {"bytes=5", 100, kNone, 0, 0},
           {"bytes=", 100, kNone, 0, 0},
           {"bytes", 100, kNone, 0, 0},
           {"bytes=+1-2", 100, kNone, 0, 0},
           {"bytes=1--2", 100, kNone, 0, 0},
           {"items=0-1", 100, kNone, 0, 0},
       }) {
    ByteRange part;
    EXPECT_EQ(server::read_range(c.header, c.size, part), c.wish) << c.header;
    if (c.wish != kPart) continue;
    EXPECT_EQ(part.first, c.first) << c.header;
    EXPECT_EQ(part.length, c.length) << c.header;
  }
}

class Exports : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    stop_server();
    record();
    start_server();
  }

  std::size_t samples_ = 2000;  // of each session

 private:
  void record() {
    auto database = db::Database::open(folder_ / "hoist.db");
    ASSERT_TRUE(database.ok());
    auto writer = db::SessionWriter::create(*database);
    ASSERT_TRUE(writer.ok());
    for (const char* patient : {"P-1", "P-2"}) {
      db::SessionStart start;
      start.subject = patient;
      start.started_utc_ns = 1'790'000'000'000'000'000;
      start.start_time_ns = 1;
      ASSERT_TRUE(writer->begin(start).ok());
      std::vector<contract::TickRecord> records(samples_);
      for (std::size_t i = 0; i < records.size(); ++i) {
        records[i].tick = i;
        records[i].time_ns = 1 + i * 10'000'000;
        records[i].x_m = static_cast<float>((i * 104729U) % 100000) * 1e-3F;
      }
      ASSERT_TRUE(writer->append_ticks(records).ok());
      ASSERT_TRUE(writer->end(db::CloseReason::finished, start.started_utc_ns).ok());
    }
  }
};

TEST_F(Exports, AnMcapIsServedWholeAndInPartsByItsTag) {
  const std::string target = "/api/v1/sessions/1/export?format=mcap";
  const Answer whole = get(target);
  ASSERT_EQ(whole.status, 200);
  ASSERT_GT(whole.body.size(), 10000U);
  EXPECT_EQ(whole.body.substr(0, 6), "\x89MCAP0");
  EXPECT_EQ(whole.header("content-length"), std::to_string(whole.body.size()));
  EXPECT_EQ(whole.header("accept-ranges"), "bytes");
  EXPECT_EQ(whole.header("transfer-encoding"), "");
  const std::string tag = whole.header("etag");
  ASSERT_GT(tag.size(), 2U);
  EXPECT_EQ(call("HEAD", target).header("content-length"), whole.header("content-length"));

  const Answer part = call("GET", target, nullptr, {{"Range", "bytes=100-1099"}, {"If-Range", tag}});
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.body, whole.body.substr(100, 1000));
  EXPECT_EQ(part.header("content-range"), "bytes 100-1099/" + std::to_string(whole.body.size()));
  EXPECT_EQ(part.header("content-length"), "1000");
  EXPECT_EQ(call("GET", target, nullptr, {{"Range", "bytes=-8"}}).body, whole.body.substr(whole.body.size() - 8));
  EXPECT_EQ(call("GET", target, nullptr, {{"Range", "bytes=100-1099"}, {"If-Range", "\"another\""}}).status, 200);
  const Answer outside = call("GET", target, nullptr, {{"Range", "bytes=999999999-"}});
  EXPECT_EQ(outside.status, 416);
  EXPECT_EQ(outside.header("content-range"), "bytes */" + std::to_string(whole.body.size()));
  EXPECT_EQ(call("GET", target, nullptr, {{"If-None-Match", tag}}).status, 304);
  // Foxglove Studio opens no address that does not end in .mcap.
  const std::string address = "/api/v1/sessions/1/session.mcap";
  const Answer named = get(address);
  EXPECT_EQ(named.status, 200);
  EXPECT_TRUE(named.body == whole.body);
  EXPECT_EQ(named.header("etag"), tag);
  EXPECT_EQ(call("GET", address, nullptr, {{"Range", "bytes=100-1099"}, {"If-Range", tag}}).body, part.body);
  EXPECT_EQ(get("/api/v1/sessions/77/session.mcap").status, 404);
  // Parts make up the whole.
  std::string joined;
  for (std::size_t from = 0; from < whole.body.size(); from += 7777)
    joined += call("GET", target, nullptr, {{"Range", "bytes=" + std::to_string(from) + "-" + std::to_string(from + 7776)}}).body;
  EXPECT_EQ(joined, whole.body);
  // What the file follows from changes its tag.
  EXPECT_NE(get(target + "&columns=x_m").header("etag"), tag);
  // In the audit log all parts are one row, with what was sent; whole files and refusals are a row each, as they come.
  const std::size_t parts = 2 + (whole.body.size() + 7776) / 7777;
  const std::string size = std::to_string(whole.body.size());
  stop_server();
  start_server();
  std::multimap<std::string, json> rows;
  const json all = get("/api/v1/audit?limit=200").json()["items"];
  for (const json& row : all)
    if (row["action"] == "export_session" || row["action"] == "export_mcap")
      rows.emplace(row["action"].get<std::string>() + " " + row["result"].get<std::string>(), row);
  ASSERT_EQ(rows.count("export_session 206"), 1U);
  const json& told = rows.find("export_session 206")->second;
  EXPECT_EQ(told["target"], target);
  EXPECT_EQ(told["after"], std::to_string(1008 + whole.body.size()) + " of " + size + " bytes in " + std::to_string(parts) + " parts");
  EXPECT_EQ(rows.count("export_mcap 206"), 1U);
  EXPECT_EQ(rows.find("export_mcap 206")->second["after"], "1000 of " + size + " bytes in 1 part");
  EXPECT_EQ(rows.find("export_mcap 200")->second["after"], size + " of " + size + " bytes in 1 part");
  EXPECT_EQ(rows.count("export_session 416"), 1U);
  EXPECT_EQ(rows.count("export_mcap 404"), 1U);
  ASSERT_EQ(call("PATCH", "/api/v1/sessions/1", {{"note", "seen"}}).status, 200);
  EXPECT_NE(get(target).header("etag"), tag);
}

// A file is sent in pieces of 256 KiB; a part begins and ends anywhere.
class LongExports : public Exports {
 protected:
  LongExports() { samples_ = 8000; }
};
TEST_F(LongExports, PartsOfAFileAreItsBytes) {
  const std::string target = "/api/v1/sessions/2/export?format=mcap";
  constexpr std::size_t kPiece = 256 * 1024;
  const std::string whole = get(target).body;
  ASSERT_GT(whole.size(), 2 * kPiece + 1000) << "three pieces";
  for (const auto& [first, last] : {std::pair<std::size_t, std::size_t>{0, kPiece - 1},
                                    {0, kPiece},
                                    {kPiece - 1, kPiece},
                                    {1, 2 * kPiece + 5},
                                    {kPiece, whole.size() - 1},
                                    {whole.size() - 1, whole.size() + 7}}) {
    const Answer part = call("GET", target, nullptr, {{"Range", "bytes=" + std::to_string(first) + "-" + std::to_string(last)}});
    const std::size_t length = std::min(last, whole.size() - 1) - first + 1;
    EXPECT_EQ(part.status, 206) << first;
    EXPECT_EQ(part.header("content-length"), std::to_string(length)) << first;
    EXPECT_TRUE(part.body == whole.substr(first, length)) << first << " to " << last;
  }
}

// RFC 9110: a part is defined for GET only (14.2), of the file that If-Range names by its strong tag (13.1.5); 304 and 412 come before (13.2.2).
TEST_F(Exports, APartIsAskedForByGetAndOfThisFile) {
  const std::string target = "/api/v1/sessions/1/session.mcap";
  const Answer whole = get(target);
  const std::string size = std::to_string(whole.body.size()), tag = whole.header("etag");
  const Answer head = call("HEAD", target, nullptr, {{"Range", "bytes=0-9"}});
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.header("content-length"), size);
  EXPECT_EQ(head.header("content-range"), "");
  EXPECT_EQ(call("HEAD", target, nullptr, {{"Range", "bytes=999999999-"}}).status, 200);
  for (const std::string& other : {"W/" + tag, std::string("Wed, 21 Oct 2026 07:28:00 GMT")})
    EXPECT_EQ(call("GET", target, nullptr, {{"Range", "bytes=0-9"}, {"If-Range", other}}).status, 200) << other;
  EXPECT_EQ(call("GET", target, nullptr, {{"Range", "bytes=0-9"}, {"If-None-Match", tag}}).status, 304);
  // If-Match comes before all (13.2.2): a client that fetches the rest of another file learns it. Weak tags match nothing (13.1.1).
  for (const std::string& other : {std::string("\"another\""), "W/" + tag})
    EXPECT_EQ(call("GET", target, nullptr, {{"Range", "bytes=0-9"}, {"If-None-Match", tag}, {"If-Match", other}}).status, 412) << other;
  for (const std::string& same : {"\"another\", " + tag, std::string("*")})
    EXPECT_EQ(call("GET", target, nullptr, {{"Range", "bytes=0-9"}, {"If-Match", same}}).status, 206) << same;
  const Answer part = call("GET", target, nullptr, {{"Range", "bytes=0-9"}});
  EXPECT_EQ(part.header("etag"), tag);
  EXPECT_EQ(part.header("accept-ranges"), "bytes");
  EXPECT_EQ(part.header("content-type"), whole.header("content-type"));
  EXPECT_EQ(part.header("content-disposition"), whole.header("content-disposition"));
  EXPECT_EQ(call("GET", target, nullptr, {{"Range", "bytes=0-0"}}).header("content-range"), "bytes 0-0/" + size);
}

// What was made of a session goes with it: the file of a job at once, figures that a job has computed, and the copy for further parts.
TEST_F(Exports, WhatIsDeletedIsNotServedFromWhatWasMadeOfIt) {
  const auto finished = [this](const json& wish) {
    const std::string place = call("POST", "/api/v1/jobs", wish).header("location");
    EXPECT_TRUE(until([&] { return get(place).json()["ended_utc_ms"] != nullptr; }));
    EXPECT_EQ(get(place).json()["state"], "done") << get(place).body;
    return place;
  };
  std::string file, figures;
  const auto make = [&] {
    file = finished({{"kind", "export_sessions"}}) + "/file";
    figures = finished({{"kind", "recompute_metrics"}});
  };
  const auto expect_there = [&](bool there) {
    EXPECT_EQ(get(file).status, there ? 200 : 404);
    EXPECT_EQ(get(figures).json()["result"].is_object(), there);
    EXPECT_EQ(get(figures).json()["state"], "done");
  };
  make();
  EXPECT_EQ(call("DELETE", "/api/v1/sessions/1", nullptr, {{"If-Match", "\"another\""}}).status, 412);
  expect_there(true);
  ASSERT_EQ(call("DELETE", "/api/v1/sessions/1").status, 204);
  expect_there(false);
  make();
  expect_there(true);
  ASSERT_EQ(call("DELETE", "/api/v1/patients/" + get("/api/v1/patients").json()["items"][0]["id"].dump()).status, 204);
  expect_there(false);
}

TEST_F(Exports, ManySessionsAreAJobWithAFile) {
  const auto finished = [this](const json& wish) {
    const Answer started = call("POST", "/api/v1/jobs", wish);
    EXPECT_EQ(started.status, 202) << started.body;
    const std::string place = started.header("location");
    EXPECT_TRUE(until([&] { return get(place).json()["ended_utc_ms"] != nullptr; }));
    return place;
  };
  const std::string place = finished({{"kind", "export_sessions"}});
  const json result = get(place).json()["result"];
  EXPECT_EQ(result["sessions"], 2);
  const Answer file = get(place + "/file");
  ASSERT_EQ(file.status, 200);
  EXPECT_EQ(file.body.size(), result["bytes"]);
  EXPECT_EQ(file.body.substr(0, 4), "PK\3\4");
  EXPECT_EQ(file.header("content-disposition"), "attachment; filename=\"hoist_sessions.zip\"");
  const Answer part = call("GET", place + "/file", nullptr, {{"Range", "bytes=-22"}, {"If-Range", file.header("etag")}});
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.body, file.body.substr(file.body.size() - 22));

  const std::string one = finished({{"kind", "export_sessions"}, {"layout", "bids"}, {"subject", "P-2"}});
  EXPECT_EQ(get(one).json()["result"]["sessions"], 1);
  EXPECT_NE(get(one + "/file").body.find("sub-P2/"), std::string::npos);
  const std::string tables = finished({{"kind", "export_sessions"}, {"layout", "sqlite"}});
  const Answer plain = get(tables + "/file");
  EXPECT_EQ(plain.header("content-type"), "application/vnd.sqlite3");
  EXPECT_EQ(plain.header("content-disposition"), "attachment; filename=\"hoist_sessions.sqlite\"");
  EXPECT_EQ(plain.body.substr(0, 16), std::string("SQLite format 3\0", 16));
  const std::string pages = finished({{"kind", "export_sessions"}, {"layout", "reports"}, {"report", "patient"}, {"language", "de"}});
  const Answer reports = get(pages + "/file");
  EXPECT_EQ(reports.header("content-disposition"), "attachment; filename=\"hoist_reports.zip\"");
  for (const char* word : {"session-1.html", "session-2.html", "group.html"}) EXPECT_NE(reports.body.find(word), std::string::npos) << word;
  const std::string english = finished({{"kind", "export_sessions"}, {"layout", "reports"}, {"report", "patient"}});
  EXPECT_NE(get(english + "/file").body, reports.body);
  const std::string none = finished({{"kind", "export_sessions"}, {"subject", "P-3"}});
  EXPECT_EQ(get(none).json()["state"], "failed");
  EXPECT_EQ(get(none).json()["detail"], "no session fits");
  for (const json& content :
       {json{{"layout", "files"}}, json{{"layout", "bids"}}, json{{"layout", "sqlite"}}, json{{"layout", "reports"}}}) {
    json asked{{"kind", "export_sessions"}, {"subject", "P-3"}};
    asked.update(content);
    EXPECT_EQ(get(finished(asked)).json()["reason_code"], "none_fits") << content;
  }
  EXPECT_EQ(get(none + "/file").status, 404);
  finished({{"kind", "export_sessions"}});
  EXPECT_EQ(get(place + "/file").status, 404) << "only the newest files are kept";
  EXPECT_EQ(get(place).json()["state"], "done");
  EXPECT_EQ(call("POST", "/api/v1/jobs", {{"kind", "export_sessions"}, {"layout", "xls"}}).status, 422);
  EXPECT_EQ(call("POST", "/api/v1/jobs", {{"kind", "export_sessions"}, {"layout", "reports"}, {"language", "fr"}}).status, 422);
  EXPECT_EQ(call("POST", "/api/v1/jobs", {{"kind", "export_sessions"}, {"from_day", "1.9.2026"}}).status, 422);
}

}  // namespace
}  // namespace hoist::test
