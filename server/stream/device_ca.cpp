#include "server/stream/device_ca.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <ifaddrs.h>
#include <netinet/in.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

namespace hoist::server {

namespace {
template <auto Free>
struct Freed {
  void operator()(auto* thing) const { Free(thing); }
};
using Bio = std::unique_ptr<BIO, Freed<BIO_free_all>>;
using Certificate = std::unique_ptr<X509, Freed<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;
using Extension = std::unique_ptr<X509_EXTENSION, Freed<X509_EXTENSION_free>>;
using Constraints = std::unique_ptr<NAME_CONSTRAINTS, Freed<NAME_CONSTRAINTS_free>>;
using Names = std::unique_ptr<GENERAL_NAMES, Freed<GENERAL_NAMES_free>>;

constexpr long kAuthorityDays = 20L * 365;
constexpr std::int64_t kBackdate_s = 3600;  // for tablets whose clock is behind
// On this computer itself; in both families, since a family without any permitted address would be unrestricted.
constexpr std::array<std::string_view, 3> kOwn{"localhost", "127.0.0.1", "::1"};

std::string openssl_reason() {
  std::array<char, 256> text{};
  ERR_error_string_n(ERR_peek_last_error(), text.data(), text.size());
  ERR_clear_error();
  return text.data();
}

// They end up in OpenSSL's configuration syntax: nothing but letters of names.
bool is_name(const std::string& text) {
  return !text.empty() && text.size() <= 253 && text.front() != '.' && text.front() != '-' &&
         std::ranges::all_of(text, [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '.'; });
}

// "192.168.7.0/24" as OpenSSL wants it: address/mask.
std::optional<std::string> network(const std::string& subnet) {
  const std::size_t slash = subnet.find('/');
  if (slash == std::string::npos) return std::nullopt;
  const std::string address = subnet.substr(0, slash);
  std::array<unsigned char, 16> bytes{};
  const int family = address.find(':') == std::string::npos ? AF_INET : AF_INET6;
  if (::inet_pton(family, address.c_str(), bytes.data()) != 1) return std::nullopt;
  const unsigned size_bits = family == AF_INET ? 32 : 128;
  unsigned bits = 0;
  const auto [end, code] = std::from_chars(subnet.data() + slash + 1, subnet.data() + subnet.size(), bits);
  if (code != std::errc{} || end != subnet.data() + subnet.size() || bits == 0 || bits > size_bits) return std::nullopt;
  std::array<unsigned char, 16> mask{};
  for (unsigned i = 0; i < bits; ++i) mask[i / 8] = static_cast<unsigned char>(mask[i / 8] | (0x80U >> (i % 8)));
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<unsigned char>(bytes[i] & mask[i]);
  std::array<char, INET6_ADDRSTRLEN> text{}, mask_text{};
  ::inet_ntop(family, bytes.data(), text.data(), text.size());
  ::inet_ntop(family, mask.data(), mask_text.data(), mask_text.size());
  return std::string{text.data()} + "/" + mask_text.data();
}

std::string permitted(const DeviceNames& names) {
  std::string text = "critical";
  const auto add = [&text](const std::string& kind, const std::string& value) { text += ",permitted;" + kind + ":" + value; };
  const auto add_host = [&add](const std::string& host) {
    if (is_address(host))
      add("IP", network(host + (host.find(':') == std::string::npos ? "/32" : "/128")).value_or(host));
    else
      add("DNS", host);
  };
  for (const std::string_view own : kOwn) add_host(std::string{own});
  for (const auto* list : {&names.names, &names.addresses})
    for (const std::string& host : *list) add_host(host);
  for (const std::string& subnet : names.subnets) add("IP", network(subnet).value_or(subnet));
  return text;
}

std::string alternative_names(const std::vector<std::string>& hosts) {
  std::string text;
  for (const std::string& host : hosts) text += (text.empty() ? "" : ",") + std::string{is_address(host) ? "IP:" : "DNS:"} + host;
  return text;
}

bool extend(X509* certificate, X509* issuer, int kind, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  const Extension extension(X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str()));
  return extension && X509_add_ext(certificate, extension.get(), -1) == 1;
}

// With a random serial number, valid from now; the caller adds the extensions and signs.
Certificate begin_certificate(EVP_PKEY* key, const std::string& name, std::int64_t from_utc_s, std::int64_t life_s) {
  Certificate certificate(X509_new());
  std::array<unsigned char, 16> serial{};
  if (!certificate || RAND_bytes(serial.data(), static_cast<int>(serial.size())) != 1) return nullptr;
  serial[0] = static_cast<unsigned char>((serial[0] & 0x7FU) | 0x40U);  // positive, and always as long
  const std::unique_ptr<BIGNUM, Freed<BN_free>> number(BN_bin2bn(serial.data(), static_cast<int>(serial.size()), nullptr));
  BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(certificate.get()));
  X509_set_version(certificate.get(), X509_VERSION_3);
  ASN1_TIME_set(X509_getm_notBefore(certificate.get()), from_utc_s);
  ASN1_TIME_set(X509_getm_notAfter(certificate.get()), from_utc_s + life_s);
  X509_NAME* subject = X509_get_subject_name(certificate.get());
  const auto add = [subject](const char* field, const std::string& text) {
    return X509_NAME_add_entry_by_txt(subject, field, MBSTRING_UTF8, reinterpret_cast<const unsigned char*>(text.data()),
                                      static_cast<int>(text.size()), -1, 0) == 1;
  };
  if (!add("O", "Hoist") || !add("CN", name.substr(0, 64)) || X509_set_pubkey(certificate.get(), key) != 1) return nullptr;
  return certificate;
}

std::string pem_of(EVP_PKEY* key, const std::vector<X509*>& certificates) {
  const Bio out(BIO_new(BIO_s_mem()));
  PEM_write_bio_PKCS8PrivateKey(out.get(), key, nullptr, nullptr, 0, nullptr, nullptr);
  for (X509* certificate : certificates) PEM_write_bio_X509(out.get(), certificate);
  char* data = nullptr;
  const long size = BIO_get_mem_data(out.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

// Beside the target, on the disk, then renamed: whole or not there. Mode 0600.
bool write_private(const std::filesystem::path& file, std::string_view text, std::string& error) {
  const std::string fresh = file.string() + ".new";
  ::unlink(fresh.c_str());
  const int fd = ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  const bool written = fd >= 0 && ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size()) && ::fsync(fd) == 0;
  const bool done = written && ::rename(fresh.c_str(), file.c_str()) == 0;
  if (!done) error = "cannot write " + file.string() + ": " + std::strerror(errno);
  if (fd >= 0) ::close(fd);
  const int folder = ::open(file.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0) {
    ::fsync(folder);
    ::close(folder);
  }
  return done;
}

struct KeyAndCertificate {
  Key key;
  Certificate certificate;
};
// Both null when the file cannot be read or they do not belong together.
KeyAndCertificate read_pem(const std::filesystem::path& file) {
  KeyAndCertificate read;
  const Bio in(BIO_new_file(file.c_str(), "r"));
  if (!in) return {};
  read.key.reset(PEM_read_bio_PrivateKey(in.get(), nullptr, nullptr, nullptr));
  read.certificate.reset(PEM_read_bio_X509(in.get(), nullptr, nullptr, nullptr));
  ERR_clear_error();
  if (!read.key || !read.certificate || X509_check_private_key(read.certificate.get(), read.key.get()) != 1) return {};
  return read;
}

std::int64_t utc_of(const ASN1_TIME* time) {
  std::tm parts{};
  return ASN1_TIME_to_tm(time, &parts) == 1 ? static_cast<std::int64_t>(::timegm(&parts)) : 0;
}

// The names of the certificate, in its order.
std::vector<std::string> hosts_of(X509* certificate) {
  std::vector<std::string> hosts;
  const Names names(static_cast<GENERAL_NAMES*>(X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr)));
  for (int i = 0; i < sk_GENERAL_NAME_num(names.get()); ++i) {
    const GENERAL_NAME* name = sk_GENERAL_NAME_value(names.get(), i);
    const ASN1_STRING* value = name->type == GEN_DNS ? name->d.dNSName : name->d.iPAddress;
    const auto* bytes = ASN1_STRING_get0_data(value);
    const auto size = static_cast<std::size_t>(ASN1_STRING_length(value));
    if (name->type == GEN_DNS) hosts.emplace_back(reinterpret_cast<const char*>(bytes), size);
    if (name->type != GEN_IPADD || (size != 4 && size != 16)) continue;
    std::array<char, INET6_ADDRSTRLEN> text{};
    ::inet_ntop(size == 4 ? AF_INET : AF_INET6, bytes, text.data(), text.size());
    hosts.emplace_back(text.data());
  }
  return hosts;
}
}  // namespace

namespace {
// The one way to write it, as a certificate's is read back.
std::string plain_address(const std::string& address) {
  const int family = address.find(':') == std::string::npos ? AF_INET : AF_INET6;
  std::array<unsigned char, 16> bytes{};
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (::inet_pton(family, address.c_str(), bytes.data()) != 1) return address;
  ::inet_ntop(family, bytes.data(), text.data(), text.size());
  return text.data();
}
}  // namespace

bool is_address(const std::string& text) {
  std::array<unsigned char, 16> bytes{};
  return ::inet_pton(text.find(':') == std::string::npos ? AF_INET : AF_INET6, text.c_str(), bytes.data()) == 1;
}

std::vector<std::string> own_addresses() {
  std::vector<std::string> found;
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return found;
  for (const ifaddrs* at = list; at != nullptr; at = at->ifa_next) {
    if (at->ifa_addr == nullptr) continue;
    const int family = at->ifa_addr->sa_family;
    const void* bytes = family == AF_INET    ? static_cast<const void*>(&reinterpret_cast<const sockaddr_in*>(at->ifa_addr)->sin_addr)
                        : family == AF_INET6 ? static_cast<const void*>(&reinterpret_cast<const sockaddr_in6*>(at->ifa_addr)->sin6_addr)
                                             : nullptr;
    std::array<char, INET6_ADDRSTRLEN> text{};
    if (bytes == nullptr || ::inet_ntop(family, bytes, text.data(), text.size()) == nullptr) continue;
    const std::string address = text.data();
    if (address != "127.0.0.1" && address != "::1") found.push_back(address);
  }
  ::freeifaddrs(list);
  std::ranges::sort(found);
  return found;
}

struct DeviceCa::Parts {
  Key key;
  Certificate certificate;
  Constraints constraints;
};

DeviceCa::DeviceCa(std::filesystem::path folder, DeviceNames names)
    : folder_(std::move(folder)), names_(std::move(names)), parts_(std::make_unique<Parts>()) {}
DeviceCa::~DeviceCa() = default;

std::unique_ptr<DeviceCa> DeviceCa::open(std::filesystem::path folder, const DeviceNames& names, std::int64_t utc_s, std::string& error) {
  for (const std::string& name : names.names)
    if (!is_name(name)) return error = name + " is not a name in small letters, digits, dots and hyphens", nullptr;
  for (const std::string& address : names.addresses)
    if (!is_address(address)) return error = address + " is not an address", nullptr;
  for (const std::string& subnet : names.subnets)
    if (!network(subnet)) return error = subnet + " is not a subnet such as 192.168.7.0/24", nullptr;
  if (names.names.empty()) return error = "the hoist has no name to certify", nullptr;
  std::unique_ptr<DeviceCa> ca(new DeviceCa(std::move(folder), names));
  for (std::string& address : ca->names_.addresses) address = plain_address(address);
  std::error_code failed;
  if (std::filesystem::create_directories(ca->folder_, failed)) ::chmod(ca->folder_.c_str(), 0700);
  struct stat info {};
  const bool there = ::stat(ca->authority_file().c_str(), &info) == 0;
  if (there && (info.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    error = "the key in " + ca->authority_file().string() + " is open to other users of this computer: chmod 600 " +
            ca->authority_file().string();
    return nullptr;
  }
  if (!there && !ca->make_authority(utc_s, error)) return nullptr;
  if (!ca->read_authority(error)) return nullptr;
  for (const auto* list : {&names.names, &names.addresses})
    for (const std::string& host : *list)
      if (!ca->may_sign(host)) {
        error = host + " is not among the names that " + ca->authority_file().string() +
                " may sign. Move that folder away for a new authority; every tablet must then trust the new one";
        return nullptr;
      }
  return ca;
}

bool DeviceCa::make_authority(std::int64_t utc_s, std::string& error) {
  if (utc_s < kEarliest_utc_s) {
    error = "the clock of this computer is not set: no certificate authority is made before it is";
    return false;
  }
  const Key key(EVP_EC_gen("P-256"));
  const Certificate made = key ? begin_certificate(key.get(), names_.names.front() + " authority", kEarliest_utc_s,
                                                   utc_s - kEarliest_utc_s + kAuthorityDays * kDay_s)
                               : nullptr;
  X509* authority = made.get();
  // What it may sign is fixed for good: who steals its key gets no other name, and no further authority.
  if (authority == nullptr || X509_set_issuer_name(authority, X509_get_subject_name(authority)) != 1 ||
      !extend(authority, authority, NID_basic_constraints, "critical,CA:TRUE,pathlen:0") ||
      !extend(authority, authority, NID_key_usage, "critical,keyCertSign") ||
      !extend(authority, authority, NID_ext_key_usage, "serverAuth") ||
      !extend(authority, authority, NID_name_constraints, permitted(names_)) ||
      !extend(authority, authority, NID_subject_key_identifier, "hash") || X509_sign(authority, key.get(), EVP_sha256()) == 0) {
    error = "no certificate authority can be made: " + openssl_reason();
    return false;
  }
  return write_private(authority_file(), pem_of(key.get(), {authority}), error);
}

bool DeviceCa::read_authority(std::string& error) {
  auto [key, certificate] = read_pem(authority_file());
  if (!certificate) {
    error = authority_file().string() + " holds no key with its certificate";
    return false;
  }
  parts_->constraints.reset(static_cast<NAME_CONSTRAINTS*>(X509_get_ext_d2i(certificate.get(), NID_name_constraints, nullptr, nullptr)));
  unsigned char* der = nullptr;
  const int size = i2d_X509(certificate.get(), &der);
  der_.assign(reinterpret_cast<const char*>(der), static_cast<std::size_t>(std::max(size, 0)));
  OPENSSL_free(der);
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned length = 0;
  X509_digest(certificate.get(), EVP_sha256(), digest.data(), &length);
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  for (unsigned i = 0; i < length; ++i) {
    if (i > 0) fingerprint_ += ':';
    fingerprint_ += kDigits[digest[i] >> 4U];
    fingerprint_ += kDigits[digest[i] & 15U];
  }
  parts_->key = std::move(key);
  parts_->certificate = std::move(certificate);
  return true;
}

bool DeviceCa::may_sign(const std::string& name) const {
  const Certificate probe = begin_certificate(parts_->key.get(), name, 0, kLeaf_s);
  // OpenSSL looks at the names that it has read out of a finished certificate: the purpose check does that.
  return probe && parts_->constraints && extend(probe.get(), probe.get(), NID_subject_alt_name, alternative_names({name})) &&
         X509_sign(probe.get(), parts_->key.get(), EVP_sha256()) != 0 && X509_check_purpose(probe.get(), -1, 0) == 1 &&
         NAME_CONSTRAINTS_check(probe.get(), parts_->constraints.get()) == X509_V_OK;
}

bool DeviceCa::is_good(const std::vector<std::string>& wanted, std::int64_t utc_s) const {
  const KeyAndCertificate now = read_pem(server_file());
  struct stat info {};
  if (!now.certificate || ::stat(server_file().c_str(), &info) != 0 || (info.st_mode & (S_IRWXG | S_IRWXO)) != 0) return false;
  if (X509_verify(now.certificate.get(), parts_->key.get()) != 1 || hosts_of(now.certificate.get()) != wanted) return false;
  const std::int64_t from_utc_s = utc_of(X509_get0_notBefore(now.certificate.get()));
  const std::int64_t to_utc_s = utc_of(X509_get0_notAfter(now.certificate.get()));
  return utc_s >= from_utc_s && utc_s < to_utc_s - kRenew_s && to_utc_s - from_utc_s <= kLeaf_s;
}

bool DeviceCa::make_leaf(const std::vector<std::string>& wanted, std::int64_t utc_s, std::string& error) {
  const Key key(EVP_EC_gen("P-256"));
  const Certificate made = key ? begin_certificate(key.get(), names_.names.front(), utc_s - kBackdate_s, kLeaf_s) : nullptr;
  X509 *leaf = made.get(), *authority = parts_->certificate.get();
  if (leaf == nullptr || X509_set_issuer_name(leaf, X509_get_subject_name(authority)) != 1 ||
      !extend(leaf, authority, NID_basic_constraints, "critical,CA:FALSE") ||
      !extend(leaf, authority, NID_key_usage, "critical,digitalSignature") || !extend(leaf, authority, NID_ext_key_usage, "serverAuth") ||
      !extend(leaf, authority, NID_subject_alt_name, alternative_names(wanted)) ||
      !extend(leaf, authority, NID_subject_key_identifier, "hash") ||
      !extend(leaf, authority, NID_authority_key_identifier, "keyid:always") || X509_sign(leaf, parts_->key.get(), EVP_sha256()) == 0) {
    error = "no certificate can be issued: " + openssl_reason();
    return false;
  }
  return write_private(server_file(), pem_of(key.get(), {leaf, authority}), error);
}

DeviceCa::Issued DeviceCa::issue(const std::vector<std::string>& addresses, std::int64_t utc_s, std::string& error) {
  std::vector<std::string> wanted = names_.names;
  for (const std::string_view own : kOwn) wanted.emplace_back(own);
  std::vector<std::string> all = names_.addresses;
  all.insert(all.end(), addresses.begin(), addresses.end());
  for (const std::string& address : all)
    if (std::ranges::find(wanted, address) == wanted.end() && may_sign(address)) wanted.push_back(address);
  const bool good = is_good(wanted, utc_s), clock_set = utc_s >= kEarliest_utc_s;
  if (!good && !clock_set) error = "the clock of this computer is not set: no certificate is issued before it is";
  if (!good && (!clock_set || !make_leaf(wanted, utc_s, error))) {
    const Certificate before = read_pem(server_file()).certificate;
    const bool ours = before && X509_verify(before.get(), parts_->key.get()) == 1;
    signed_ = ours ? hosts_of(before.get()) : std::vector<std::string>{};
    return Issued::failed;
  }
  signed_ = std::move(wanted);
  return good ? Issued::still_good : Issued::renewed;
}

}  // namespace hoist::server
