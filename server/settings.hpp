// What the command line says.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/people/passwords.hpp"

namespace hoist::server {

// Of the IPv4 or IPv6 loopback.
[[nodiscard]] bool is_loopback(const std::string& address);

struct Settings {
  std::string socket_path;
  std::string bind = "127.0.0.1";
  std::uint16_t port = 8080;  // 0 = any free one
  std::filesystem::path web_dir;
  std::filesystem::path db_path;
  std::optional<std::string> scenario;
  std::string simulator;                                     // socket for requests to it; empty: none, or a real hoist
  std::filesystem::path accounts_path;                       // empty: "accounts.db" beside the recordings
  HashLimits hash_limits;                                    // of passwords; tests take cheaper ones
  std::function<void(const std::string&)> show_set_up_code;  // empty: printed on standard output
  // Whether a peer counts as this computer itself. Empty: as the listener sees it; tests have loopback addresses only.
  std::function<bool(const std::string& address)> from_here;
  std::filesystem::path token_file;
  std::vector<std::string> hosts;
  std::filesystem::path tls_cert, tls_key;  // both or none
  std::filesystem::path tls_dir;            // of the hoist's own authority, instead of those; neither = plain HTTP
  std::vector<std::string> subnets;         // whose addresses the authority may sign besides `hosts`
  std::optional<std::uint16_t> http_port;   // the page that explains how to trust the authority
  std::vector<std::filesystem::path> backup_roots;
  std::filesystem::path study_program;  // `hoist`, which walks a study; empty: the one beside this program
  // Sets the clock of this computer; empty, or why not. Without it the operating system keeps the time.
  std::function<std::string(std::int64_t utc_ns)> set_clock;
  bool tools = false;  // /foxglove and /rosbridge are open in this run
  bool help = false, version = false;
};

[[nodiscard]] std::string usage();
// Reads the arguments after the program's name. False with a sentence in `error` for anything unknown, incomplete or not allowed.
[[nodiscard]] bool parse_settings(const std::vector<std::string>& arguments, Settings& settings, std::string& error);

}  // namespace hoist::server
