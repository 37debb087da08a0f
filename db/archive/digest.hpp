// SHA-256 over rows, the same for the same session in every file and in the archive.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "db/archive/tables.hpp"

struct evp_md_ctx_st;

namespace hoist::db {

class RowDigest {
 public:
  RowDigest();
  void table(std::string_view name);
  /// NULL adds nothing, so that a column which older sessions lack does not change their digest.
  void row(std::span<const ArchiveColumn> columns, std::span<const Value> values);
  /// 64 lower-case hexadecimal digits; ends this digest.
  std::string text();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  void bytes(const void* data, std::size_t size);
  void number(std::uint64_t value);
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

/// A session's own number in every archive and file: made from the nanoseconds of both clocks and the core's start, so that a copy, a restored
/// backup and a session that was pulled have the same one. In the form of RFC 9562, version 8.
std::string session_uuid(std::span<const Value> session_row);

}  // namespace hoist::db
