#include "db/archive/digest.hpp"

#include <openssl/evp.h>

#include <bit>
#include <new>

#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

[[noreturn]] void no_digest() { throw SqlFailure{Error{ErrorKind::internal, "SHA-256 is not available", {}}}; }

}  // namespace

void RowDigest::Free::operator()(evp_md_ctx_st* context) const { EVP_MD_CTX_free(context); }

RowDigest::RowDigest() : context_(EVP_MD_CTX_new()) {
  if (context_ == nullptr) throw std::bad_alloc();
  if (EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1) no_digest();
}

void RowDigest::bytes(const void* data, std::size_t size) {
  number(size);
  if (EVP_DigestUpdate(context_.get(), data, size) != 1) no_digest();
}
void RowDigest::number(std::uint64_t value) {
  std::array<std::uint8_t, 8> little{};
  for (std::size_t i = 0; i < little.size(); ++i) little[i] = static_cast<std::uint8_t>(value >> (8 * i));
  if (EVP_DigestUpdate(context_.get(), little.data(), little.size()) != 1) no_digest();
}

void RowDigest::table(std::string_view name) {
  number('T');
  bytes(name.data(), name.size());
}

void RowDigest::row(std::span<const ArchiveColumn> columns, std::span<const Value> values) {
  number('R');
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Value& value = values[i];
    if (std::holds_alternative<std::monostate>(value)) continue;
    bytes(columns[i].name.data(), columns[i].name.size());
    if (const auto* integer = std::get_if<std::int64_t>(&value)) number(static_cast<std::uint64_t>(*integer));
    if (const auto* real = std::get_if<double>(&value)) number(std::bit_cast<std::uint64_t>(*real));
    if (const auto* text = std::get_if<std::string>(&value)) bytes(text->data(), text->size());
    if (const auto* blob = std::get_if<Bytes>(&value)) bytes(blob->data(), blob->size());
  }
}

std::string RowDigest::text() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (EVP_DigestFinal_ex(context_.get(), digest.data(), &size) != 1) no_digest();
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string out;
  for (unsigned i = 0; i < size; ++i) {
    out.push_back(kDigits[digest[i] >> 4]);
    out.push_back(kDigits[digest[i] & 15]);
  }
  return out;
}

std::string session_uuid(std::span<const Value> session_row) {
  // started_utc_ns, start_time_ns, core_start_time_ns: the first columns of kSession.
  constexpr std::size_t kIdentity = 3;
  RowDigest digest;
  digest.table("sessions");
  digest.row(std::span(archive_columns::kSession).first(kIdentity), session_row.first(kIdentity));
  std::string uuid = digest.text().substr(0, 32);
  uuid[12] = '8';  // version: made in a way of our own
  uuid[16] = "89ab"[static_cast<std::size_t>(uuid[16] <= '9' ? uuid[16] - '0' : uuid[16] - 'a' + 10) & 3];  // variant of RFC 9562
  for (const std::size_t dash : {20U, 16U, 12U, 8U}) uuid.insert(dash, 1, '-');
  return uuid;
}

}  // namespace hoist::db
