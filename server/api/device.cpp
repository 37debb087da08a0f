// What this hoist is called, its clock, and the addresses under which it is reached.
#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/timex.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>

#include "db/store/device_settings.hpp"
#include "server/actions/records.hpp"
#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"
#include "server/api/lists.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
json settings_json(const Services& services, const db::DeviceSettings& device) {
  return {{"hoist_id", device.hoist_id},
          {"device_name", device.name},
          {"computer_name", services.computer_name},
          {"language", device.language ? json(*device.language) : json(nullptr)},
          {"etag", device.tag}};
}
}  // namespace

void get_settings(const CallPtr& call) {
  using Read = db::Result<db::DeviceSettings>;
  const auto read = [](Records& records) -> Read {
    db::Database* database = records.late() ? nullptr : records.database();
    if (database == nullptr) return db::Error{db::ErrorKind::io, records.why(), {}};
    return db::device_settings(*database);
  };
  ask_recorder<Read>(call, read, [call](Read device) {
    if (!device) return call->respond(store_error(device.error(), call->request.path));
    call->services.state.set_device(*device);
    call->respond(row_response(settings_json(call->services, *device)));
  });
}

void change_settings(const CallPtr& call) {
  db::DeviceSettingsPatch patch;
  if (const json& name = field(*call, "device_name"); name.is_string()) patch.name = name.get<std::string>();
  if (const auto language = call->body->find("language"); language != call->body->end())
    patch.language = language->is_null() ? std::optional<std::string>() : std::optional(language->get<std::string>());
  act_change_device(call->services, asker_of(*call), std::move(patch), given_tag(*call), answer_with(call, [call](const Outcome&) {
                      call->respond(row_response(settings_json(call->services, call->services.state.device())));
                    }));
}

namespace {
// Read only; null when the operating system does not say.
json clock_synchronised() {
  timex clock{};
  const int state = ::adjtimex(&clock);
  if (state < 0) return nullptr;
  return state != TIME_ERROR && (clock.status & STA_UNSYNC) == 0;
}

json time_json(const Services& services, std::optional<std::int64_t> client_utc_ns) {
  const std::int64_t utc_ns = services.utc_ns();
  return {{"utc_ms", utc_ns / 1'000'000},
          {"steady_ns", services.now_ns()},
          {"kept_by", services.settings.set_clock ? "engineers" : "operating_system"},
          {"synchronised", clock_synchronised()},
          {"client_behind_s", client_utc_ns ? json(static_cast<double>(utc_ns - *client_utc_ns) / 1e9) : json(nullptr)}};
}
}  // namespace

void get_time(const CallPtr& call) {
  std::optional<std::int64_t> client_utc_ns;
  if (read_moment(call, "client_utc_ms", client_utc_ns)) call->respond(time_json(call->services, client_utc_ns));
}

void set_time(const CallPtr& call) {
  act_set_clock(call->services, asker_of(*call), field(*call, "utc_ms").get<std::int64_t>(),
                answer_with(call, [call](const Outcome&) { call->respond(time_json(call->services, std::nullopt)); }));
}

namespace {
// An IPv4 or IPv6 address as text; empty for other kinds.
std::string address_text(const sockaddr* address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (address == nullptr) return {};
  const void* bytes = nullptr;
  if (address->sa_family == AF_INET) bytes = &reinterpret_cast<const sockaddr_in*>(address)->sin_addr;
  if (address->sa_family == AF_INET6) bytes = &reinterpret_cast<const sockaddr_in6*>(address)->sin6_addr;
  if (bytes == nullptr || ::inet_ntop(address->sa_family, bytes, text.data(), text.size()) == nullptr) return {};
  return text.data();
}

json interfaces_json() {
  ifaddrs* first = nullptr;
  if (::getifaddrs(&first) != 0) return json::array();
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> list(first, &::freeifaddrs);
  json all = json::array();
  for (const ifaddrs* one = list.get(); one != nullptr; one = one->ifa_next) {
    const auto known = std::ranges::find_if(all, [&](const json& row) { return row["name"] == one->ifa_name; });
    json& row = known != all.end() ? *known
                                   : all.emplace_back(json{{"name", one->ifa_name},
                                                           {"up", (one->ifa_flags & IFF_RUNNING) != 0},
                                                           {"loopback", (one->ifa_flags & IFF_LOOPBACK) != 0},
                                                           {"addresses", json::array()}});
    if (std::string text = address_text(one->ifa_addr); !text.empty()) row["addresses"].push_back(std::move(text));
  }
  return all;
}
}  // namespace

void get_network(const CallPtr& call) {
  const Settings& settings = call->services.settings;
  const TrustPage* trust = call->rest.trust;
  json names = settings.hosts;
  if (trust != nullptr && std::ranges::find(settings.hosts, trust->name) == settings.hosts.end()) names.push_back(trust->name);
  call->respond(json{{"computer_name", call->services.computer_name},
                     {"port", settings.port},
                     {"interfaces", interfaces_json()},
                     {"tls",
                      {{"on", call->rest.base_url.starts_with("https:")},
                       {"names", std::move(names)},
                       {"fingerprint", trust != nullptr ? json(trust->fingerprint) : json(nullptr)},
                       {"trust_page", trust != nullptr ? json("/trust") : json(nullptr)}}}});
}

}  // namespace hoist::server::api
