// Downloads in the audit log. A reader of a large file asks for it in many parts (Range), some of them twice; all of them are one row, written when
// no part was asked for half a minute, after an hour, or when the server ends.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "db/accounts/accounts.hpp"

namespace hoist::server {

class DownloadLog {
 public:
  using Write = std::function<void(db::AuditEntry)>;
  static constexpr std::uint64_t kIdle_ns = 30'000'000'000, kLongest_ns = 3'600'000'000'000;
  static constexpr std::size_t kMost = 64;

  explicit DownloadLog(Write write) : write_(std::move(write)) {}
  ~DownloadLog() { flush(); }
  DownloadLog(const DownloadLog&) = delete;
  DownloadLog& operator=(const DownloadLog&) = delete;

  // One part was answered. `file`: what tells this file from another, for example its ETag; `of_bytes`: the size of the whole file.
  void part(db::AuditEntry entry, const std::string& file, std::uint64_t bytes, std::uint64_t of_bytes, std::uint64_t now_ns);
  // Writes what is over.
  void tick(std::uint64_t now_ns);
  // Writes everything that is open.
  void flush();

 private:
  struct Open {
    db::AuditEntry entry;  // of the first part
    std::uint64_t parts = 0, bytes = 0, of_bytes = 0, first_ns = 0, last_ns = 0;
  };
  using Downloads = std::map<std::string, Open>;
  void end(Downloads::iterator at);

  Write write_;
  Downloads open_;
};

// What the row says beside who and what: "123456 of 400000 bytes in 3 parts".
[[nodiscard]] std::string download_text(std::uint64_t bytes, std::uint64_t of_bytes, std::uint64_t parts);

}  // namespace hoist::server
