// The hoist's own certificates: an authority made once on the device, which can sign nothing but the hoist's names and
// addresses, and a certificate of the server that is renewed by itself.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace hoist::server {

// What browsers may call the hoist by.
struct DeviceNames {
  std::vector<std::string> names;      // hoist.local
  std::vector<std::string> addresses;  // 192.168.7.2
  std::vector<std::string> subnets;    // 192.168.7.0/24: the authority may also sign addresses of these
};

// Blocking files: the start, or a thread of its own (tls_keeper.hpp). One thread.
class DeviceCa {
 public:
  static constexpr std::int64_t kDay_s = 86'400;
  // Browsers refuse more than 398 days.
  static constexpr std::int64_t kLeaf_s = 397 * kDay_s;
  static constexpr std::int64_t kRenew_s = 30 * kDay_s;
  // A clock before this is not set yet (2026-01-01): a certificate with its date would not be valid later.
  static constexpr std::int64_t kEarliest_utc_s = 1'767'225'600;

  // Reads the authority of `folder`, or makes folder and authority. Null with a sentence when that cannot be, when others could read a key, or
  // when the authority may not sign one of the names.
  static std::unique_ptr<DeviceCa> open(std::filesystem::path folder, const DeviceNames& names, std::int64_t utc_s, std::string& error);
  ~DeviceCa();
  DeviceCa(const DeviceCa&) = delete;
  DeviceCa& operator=(const DeviceCa&) = delete;

  enum class Issued : std::uint8_t { still_good, renewed, failed };
  // A certificate for the names and, of `addresses`, those that the authority may sign; only when the one at hand is of other names, ends
  // within kRenew_s or is not valid by this clock. Failed, with a sentence: the one at hand is as before, if it is of this authority at all.
  [[nodiscard]] Issued issue(const std::vector<std::string>& addresses, std::int64_t utc_s, std::string& error);

  // The key and the certificates up to the authority, in one file so that they cannot be of different issues.
  [[nodiscard]] std::filesystem::path server_file() const { return folder_ / "server.pem"; }
  [[nodiscard]] const std::string& authority_der() const { return der_; }
  // SHA-256, pairs of hexadecimal digits with colons, as browsers and openssl show it.
  [[nodiscard]] const std::string& fingerprint() const { return fingerprint_; }
  // The names and addresses in the certificate at hand; empty without one of this authority.
  [[nodiscard]] const std::vector<std::string>& signed_names() const { return signed_; }

 private:
  struct Parts;
  DeviceCa(std::filesystem::path folder, DeviceNames names);
  [[nodiscard]] std::filesystem::path authority_file() const { return folder_ / "authority.pem"; }
  bool make_authority(std::int64_t utc_s, std::string& error);
  bool read_authority(std::string& error);
  [[nodiscard]] bool may_sign(const std::string& name) const;
  [[nodiscard]] bool is_good(const std::vector<std::string>& wanted, std::int64_t utc_s) const;
  bool make_leaf(const std::vector<std::string>& wanted, std::int64_t utc_s, std::string& error);

  std::filesystem::path folder_;
  DeviceNames names_;
  std::unique_ptr<Parts> parts_;
  std::string der_, fingerprint_;
  std::vector<std::string> signed_;
};

// Addresses of this computer's interfaces now, loopback excluded.
[[nodiscard]] std::vector<std::string> own_addresses();
// Whether it is an IPv4 or IPv6 address, without brackets.
[[nodiscard]] bool is_address(const std::string& text);

}  // namespace hoist::server
