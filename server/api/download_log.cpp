#include "server/api/download_log.hpp"

#include <algorithm>
#include <utility>

namespace hoist::server {

std::string download_text(std::uint64_t bytes, std::uint64_t of_bytes, std::uint64_t parts) {
  return std::to_string(bytes) + " of " + std::to_string(of_bytes) + " bytes in " + std::to_string(parts) +
         (parts == 1 ? " part" : " parts");
}

void DownloadLog::part(db::AuditEntry entry, const std::string& file, std::uint64_t bytes, std::uint64_t of_bytes, std::uint64_t now_ns) {
  tick(now_ns);
  // The result of the first part stands for all: only good answers come here.
  std::string key = entry.user + '\n' + entry.address + '\n' + entry.action + '\n' + entry.target + '\n' + file;
  auto at = open_.find(key);
  if (at == open_.end()) {
    if (open_.size() >= kMost) end(std::ranges::min_element(open_, {}, [](const auto& one) { return one.second.last_ns; }));
    at = open_.emplace(std::move(key), Open{.entry = std::move(entry), .first_ns = now_ns}).first;
  }
  Open& download = at->second;
  ++download.parts;
  download.bytes += bytes;
  download.of_bytes = of_bytes;
  download.last_ns = now_ns;
  // The whole file at once: nothing more is to come.
  if (download.parts == 1 && bytes >= of_bytes) end(at);
}

void DownloadLog::tick(std::uint64_t now_ns) {
  for (auto at = open_.begin(); at != open_.end();) {
    const auto next = std::next(at);
    if (now_ns - at->second.last_ns >= kIdle_ns || now_ns - at->second.first_ns >= kLongest_ns) end(at);
    at = next;
  }
}

void DownloadLog::flush() {
  while (!open_.empty()) end(open_.begin());
}

void DownloadLog::end(Downloads::iterator at) {
  Open download = std::move(at->second);
  open_.erase(at);
  download.entry.after = download_text(download.bytes, download.of_bytes, download.parts);
  write_(std::move(download.entry));
}

}  // namespace hoist::server
