#include "server/settings.hpp"

#include <arpa/inet.h>
#include <time.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>

namespace hoist::server {

namespace {
std::string set_system_clock(std::int64_t utc_ns) {
  timespec now{};
  now.tv_sec = utc_ns / 1'000'000'000;
  now.tv_nsec = utc_ns % 1'000'000'000;
  if (::clock_settime(CLOCK_REALTIME, &now) == 0) return {};
  return std::string("The operating system does not let this program set the clock: ") + std::strerror(errno) + ".";
}

bool is_ip_address(const std::string& text) {
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  return ::inet_pton(AF_INET, text.c_str(), bytes.data()) == 1 || ::inet_pton(AF_INET6, text.c_str(), bytes.data()) == 1;
}
}  // namespace

bool is_loopback(const std::string& address) { return address == "::1" || (address.starts_with("127.") && is_ip_address(address)); }

std::string usage() {
  return "hoist-server: console, REST and WebSocket for one hoist\n"
         "\n"
         "  --socket FILE      Unix socket of hoist-control (required)\n"
         "  --db FILE          database with all sessions (required; made when missing)\n"
         "  --web DIR          the built console; without it only the API is served\n"
         "  --port N           TCP port, 8080 when not given; 0 takes any free one\n"
         "  --bind ADDRESS     127.0.0.1 (when not given): only this computer. Another address of it, or 0.0.0.0 for all, lets other\n"
         "                     devices in: needs --tls-dir (or --tls-cert). They must sign in; until the first account is made they\n"
         "                     reach the set-up only\n"
         "  --host NAME        further name under which browsers may call; may be repeated\n"
         "  --scenario NAME    what the simulator plays: chooses the exercise offered first\n"
         "  --simulator FILE   socket on which hoist-sim takes requests (its --control): staff may rehearse\n"
         "  --token-file FILE  where the token for scripts is written, readable only by this user\n"
         "  --backup-root DIR  folder in which backups may be written, and from which they may be put back; may be repeated\n"
         "  --tls-cert FILE    certificate chain (PEM): HTTPS and WSS instead of plain; needs --tls-key\n"
         "  --tls-key FILE     its private key (PEM), readable only by this user\n"
         "  --tls-dir DIR      instead of both: HTTPS with an authority and certificates that are made in DIR and kept valid\n"
         "  --subnet NET       with --tls-dir: may also be called by its addresses in NET, e.g. 192.168.7.0/24; may be repeated\n"
         "  --http-port N      with --tls-dir: plain HTTP with the page that explains how to trust the authority, and nothing else\n"
         "  --tools on         Foxglove and rosbridge may connect in this run (else as an engineer has set it)\n"
         "  --set-clock on     engineers may set this computer's clock; without it the operating system keeps the time\n"
         "  --version          which source this program was built from\n"
         "  --help             this text\n";
}

bool parse_settings(const std::vector<std::string>& arguments, Settings& settings, std::string& error) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& option = arguments[i];
    if (option == "--help" || option == "-h") {
      settings.help = true;
      return true;
    }
    if (option == "--version") {
      settings.version = true;
      return true;
    }
    const bool known = option == "--socket" || option == "--db" || option == "--web" || option == "--port" || option == "--bind" ||
                       option == "--host" || option == "--scenario" || option == "--token-file" || option == "--tls-cert" ||
                       option == "--tls-key" || option == "--tls-dir" || option == "--subnet" || option == "--http-port" ||
                       option == "--backup-root" || option == "--simulator" || option == "--tools" || option == "--set-clock";
    if (!known) {
      error = "unknown option " + option + "; see --help";
      return false;
    }
    if (i + 1 >= arguments.size() || arguments[i + 1].empty()) {
      error = option + " needs a value";
      return false;
    }
    const std::string& value = arguments[++i];
    if (option == "--socket") settings.socket_path = value;
    if (option == "--db") settings.db_path = value;
    if (option == "--backup-root") settings.backup_roots.emplace_back(value);
    if (option == "--web") settings.web_dir = value;
    if (option == "--bind") settings.bind = value;
    if (option == "--host") settings.hosts.push_back(value);
    if (option == "--scenario") settings.scenario = value;
    if (option == "--simulator") settings.simulator = value;
    if (option == "--token-file") settings.token_file = value;
    if (option == "--tls-cert") settings.tls_cert = value;
    if (option == "--tls-key") settings.tls_key = value;
    if (option == "--tools" || option == "--set-clock") {
      if (value != "on") {
        error = option + " takes only: on";
        return false;
      }
      if (option == "--tools") settings.tools = true;
      if (option == "--set-clock") settings.set_clock = &set_system_clock;
    }
    if (option == "--tls-dir") settings.tls_dir = value;
    if (option == "--subnet") settings.subnets.push_back(value);
    if (option == "--port" || option == "--http-port") {
      unsigned port = 0;
      const auto [end, code] = std::from_chars(value.data(), value.data() + value.size(), port);
      if (code != std::errc{} || end != value.data() + value.size() || port > 65535) {
        error = option + " must be a number from 0 to 65535, not " + value;
        return false;
      }
      if (option == "--port") settings.port = static_cast<std::uint16_t>(port);
      if (option == "--http-port") settings.http_port = static_cast<std::uint16_t>(port);
    }
  }
  if (!is_ip_address(settings.bind)) {
    error = "--bind " + settings.bind + " is no address: give one of this computer, 0.0.0.0 for all of them, or leave it out (127.0.0.1)";
    return false;
  }
  if (!is_loopback(settings.bind) && settings.tls_dir.empty() && settings.tls_cert.empty()) {
    error =
        "--bind " + settings.bind +
        " lets other devices in, so it needs HTTPS: add --tls-dir DIR (the hoist makes its own certificates) or --tls-cert and --tls-key";
    return false;
  }
  if (!settings.tls_cert.empty() && settings.hosts.empty() && (settings.bind == "0.0.0.0" || settings.bind == "::")) {
    error = "--bind " + settings.bind + " with --tls-cert needs --host NAME: the name or address that stands in the certificate";
    return false;
  }
  if (settings.tls_cert.empty() != settings.tls_key.empty()) {
    error = "--tls-cert and --tls-key belong together: give both, or none for plain HTTP";
    return false;
  }
  if (!settings.tls_dir.empty() && !settings.tls_cert.empty()) {
    error = "--tls-dir makes its own certificates: leave --tls-cert and --tls-key out, or --tls-dir";
    return false;
  }
  if (settings.tls_dir.empty() && (settings.http_port || !settings.subnets.empty())) {
    error = "--http-port and --subnet need --tls-dir DIR";
    return false;
  }
  if (settings.socket_path.empty()) {
    error = "--socket FILE is required; see --help";
    return false;
  }
  if (settings.db_path.empty()) {
    error = "--db FILE is required; see --help";
    return false;
  }
  return true;
}

}  // namespace hoist::server
