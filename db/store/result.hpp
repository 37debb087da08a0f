// What a call to the store gives back: the value, or one typed error with a sentence. No exceptions leave this folder.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace hoist::db {

enum class ErrorKind : std::uint8_t {
  not_found,     // no such session
  bad_value,     // the caller's value is refused; `field` names it and the message gives the allowed range
  wrong_state,   // not now: no session open, session still recording …
  changed,       // the row is not what the change was made for (edit_tag.hpp)
  taken,         // another row has this name already
  busy,          // another connection held the lock longer than the busy timeout
  disk_full,     // nothing was stored by this call; trying again later is fine
  read_only,     // the disk, or the folder, may not be written
  io,            // the disk reported an error
  corrupt,       // a stored blob does not match its checksum or shape; the message names session and chunk
  newer_schema,  // the file was written by a newer Hoist
  foreign,       // the file belongs to another program, and stays as it is
  internal,      // SQLite refused a statement of ours
};
constexpr const char* error_kind_name(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::not_found:
      return "not_found";
    case ErrorKind::bad_value:
      return "bad_value";
    case ErrorKind::wrong_state:
      return "wrong_state";
    case ErrorKind::changed:
      return "changed";
    case ErrorKind::taken:
      return "taken";
    case ErrorKind::busy:
      return "busy";
    case ErrorKind::disk_full:
      return "disk_full";
    case ErrorKind::read_only:
      return "read_only";
    case ErrorKind::io:
      return "io";
    case ErrorKind::corrupt:
      return "corrupt";
    case ErrorKind::newer_schema:
      return "newer_schema";
    case ErrorKind::foreign:
      return "foreign";
    case ErrorKind::internal:
      break;
  }
  return "internal";
}

struct Error {
  ErrorKind kind = ErrorKind::internal;
  std::string message;
  std::string field;  // only for bad_value
};

template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : value_(std::in_place_index<1>, std::move(error)) {}
  [[nodiscard]] bool ok() const { return value_.index() == 0; }
  explicit operator bool() const { return ok(); }
  T& value() { return std::get<0>(value_); }
  const T& value() const { return std::get<0>(value_); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  [[nodiscard]] const Error& error() const { return std::get<1>(value_); }

 private:
  std::variant<T, Error> value_;
};

class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(Error error) : error_(std::move(error)) {}
  [[nodiscard]] bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  [[nodiscard]] const Error& error() const { return *error_; }

 private:
  std::optional<Error> error_;
};

}  // namespace hoist::db
