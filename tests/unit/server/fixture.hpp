// A server on a free port of this machine, with a fake core, a small console folder and a fresh database.
#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "server/app.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/server/client.hpp"
#include "tests/unit/server/fake_core.hpp"
#include "tests/unit/server/schema.hpp"

namespace hoist::test {

using nlohmann::json;

class ServerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_ / "web" / "assets");
    std::ofstream(folder_ / "web" / "index.html") << "<!doctype html><title>console</title>";
    std::ofstream(folder_ / "web" / "assets" / "app-12ab.js") << "plain";
    std::ofstream(folder_ / "web" / "assets" / "app-12ab.js.gz") << "squeezed";
    std::ofstream(folder_ / "secret.html") << "not for browsers";
    std::filesystem::create_symlink(folder_ / "secret.html", folder_ / "web" / "link.html");
    core_ = std::make_unique<FakeCore>((folder_ / "core.sock").string());
    start_server();
    wait_for_core();
  }
  void TearDown() override {
    stop_server();
    core_.reset();
  }

  void start_server() {
    server::Settings settings;
    settings.socket_path = (folder_ / "core.sock").string();
    settings.port = 0;
    settings.web_dir = folder_ / "web";
    settings.db_path = db_path_;
    settings.scenario = "figure-eight";
    settings.token_file = folder_ / "token";
    settings.hosts = {"hoist.local"};
    settings.backup_roots = {folder_ / "stick"};
    settings.hash_limits = {.passes = 1, .memory_bytes = 8192};
    settings.from_here = [this](const std::string&) { return !elsewhere_; };
    settings.show_set_up_code = [this](const std::string& code) {
      const std::lock_guard lock(code_mutex_);
      code_ = code;
    };
    if (adjust_) adjust_(settings);
    app_ = std::make_unique<server::App>(settings);
    std::string error;
    ASSERT_TRUE(app_->start(error)) << error;
    port_ = app_->port();
    bearer_ = {{"Authorization", "Bearer " + app_->bearer_token()}};
    link_ = app_->link();
    thread_ = std::thread([this] { app_->run(); });
  }
  void stop_server() {
    if (!app_) return;
    app_->stop();
    thread_.join();
    app_.reset();
  }
  // Asks until the server sees the core, or until the limit.
  void wait_for_core(bool connected = true) {
    ASSERT_TRUE(until([&] { return get("/api/v1/status").json()["core"]["connected"] == connected; }));
  }
  // Repeats a question until it is true, with pauses: a job has nice 19 and would get hardly any processor beside a test that asks without one.
  // On a busy machine it waits long all the same.
  template <typename Question>
  bool until(Question question) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(5);
    while (std::chrono::steady_clock::now() < end) {
      if (question()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  // A call with the token; the answer is checked against /api/openapi.json. A change is made for any state unless `more` names one.
  Answer call(const std::string& method, const std::string& target, const json& body = nullptr, Headers more = {}) {
    Headers headers = bearer_;
    add_any_tag(headers, method, more);
    if (!body.is_null()) headers.emplace_back("Content-Type", "application/json");
    headers.insert(headers.end(), more.begin(), more.end());
    Answer answer = http(port_, method, target, headers, body.is_null() ? "" : body.dump());
    check_described(method, target, answer);
    return answer;
  }
  Answer get(const std::string& target) { return call("GET", target); }

  // Whether OpenAPI names this status for this route, and the body fits its schema.
  void check_described(const std::string& method, const std::string& target, const Answer& answer) {
    if (document_.is_null()) document_ = http(port_, "GET", "/api/openapi.json").json();
    const std::string path = target.substr(0, target.find('?'));
    for (const auto& [pattern, methods] : document_["paths"].items()) {
      if (!fits(pattern, path)) continue;
      std::string name = method == "HEAD" ? "get" : method;
      for (char& c : name) c = static_cast<char>(std::tolower(c));
      if (!methods.contains(name)) continue;
      const json& responses = methods[name]["responses"];
      const std::string status = std::to_string(answer.status);
      ASSERT_TRUE(responses.contains(status)) << method << " " << target << " answered " << status
                                              << ", which OpenAPI does not name: " << answer.body;
      const json tag = responses[status].value("headers", json::object()).value("ETag", json());
      const bool has_tag = !tag.is_null() && tag["required"] == true;
      if (answer.status < 300 && (!answer.header("etag").empty() || has_tag)) {
        EXPECT_EQ(answer.header("etag").empty(), tag.is_null()) << method << " " << target << ": its ETag is not as OpenAPI tells";
      }
      const json content = responses[status].value("content", json::object());
      const std::string type = answer.header("content-type").substr(0, answer.header("content-type").find(';'));
      if (content.empty() || method == "HEAD") return;
      ASSERT_TRUE(content.contains(type)) << method << " " << target << " answered " << type;
      if (type.ends_with("json")) {
        EXPECT_EQ(mismatch(document_, content[type]["schema"], answer.json()), "") << method << " " << target;
      }
      return;
    }
  }
  static bool fits(const std::string& pattern, const std::string& path) {
    std::size_t i = 0, k = 0;
    while (i < pattern.size() && k < path.size()) {
      if (pattern[i] == '{') {
        while (i < pattern.size() && pattern[i] != '}') ++i;
        ++i;
        while (k < path.size() && path[k] != '/') ++k;
      } else if (pattern[i++] != path[k++]) {
        return false;
      }
    }
    return i == pattern.size() && k == path.size();
  }

  // Opens the one-time link as a browser does; the cookie.
  std::string log_in() {
    const Answer answer = http(port_, "GET", link_.substr(link_.find("/?")));
    EXPECT_EQ(answer.status, 303);
    const std::string cookie = answer.header("set-cookie");
    return cookie.substr(0, cookie.find(';'));
  }
  std::string origin() const { return "http://127.0.0.1:" + std::to_string(port_); }

  TemporaryFolder folder_;
  std::filesystem::path db_path_ = folder_ / "hoist.db";
  std::function<void(server::Settings&)> adjust_;  // before each start
  std::unique_ptr<FakeCore> core_;
  std::unique_ptr<server::App> app_;
  std::thread thread_;
  std::uint16_t port_ = 0;
  Headers bearer_;
  std::string link_;
  std::atomic<bool> elsewhere_{false};  // clients count as other devices
  std::mutex code_mutex_;
  std::string code_;  // of the set-up, as the hoist shows it
  json document_;
};

}  // namespace hoist::test
