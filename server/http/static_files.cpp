#include "server/http/static_files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <string>
#include <string_view>

#include "server/http/problem.hpp"

namespace hoist::server {

namespace {
// Larger than any file of the console; a guard against serving something that was put there by mistake.
constexpr off_t kFileLimit = 16 * 1024 * 1024;

std::string_view media_type(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 12> kTypes{{{".html", "text/html; charset=utf-8"},
                                                                                         {".js", "text/javascript; charset=utf-8"},
                                                                                         {".mjs", "text/javascript; charset=utf-8"},
                                                                                         {".css", "text/css; charset=utf-8"},
                                                                                         {".json", "application/json"},
                                                                                         {".svg", "image/svg+xml"},
                                                                                         {".png", "image/png"},
                                                                                         {".ico", "image/x-icon"},
                                                                                         {".webmanifest", "application/manifest+json"},
                                                                                         {".woff2", "font/woff2"},
                                                                                         {".txt", "text/plain; charset=utf-8"},
                                                                                         {".map", "application/json"}}};
  for (const auto& [end, type] : kTypes)
    if (name.ends_with(end)) return type;
  return {};
}

bool safe_segment(std::string_view segment) {
  if (segment.empty() || segment.front() == '.') return false;
  for (char c : segment)
    if (c == '\\' || c == '/' || static_cast<unsigned char>(c) < 0x20) return false;
  return true;
}

// Opens the file below `folder` one segment at a time without following links, so that nothing outside can be reached.
int open_below(const std::filesystem::path& folder, std::string_view path, struct stat& info) {
  int at = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  while (at >= 0) {
    const std::size_t slash = path.find('/');
    const std::string segment{path.substr(0, slash)};
    const bool last = slash == std::string_view::npos;
    const int next = safe_segment(segment)
                         ? ::openat(at, segment.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC | (last ? 0 : O_DIRECTORY))
                         : -1;
    ::close(at);
    at = next;
    if (last) break;
    path.remove_prefix(slash + 1);
  }
  if (at < 0) return -1;
  if (::fstat(at, &info) != 0 || !S_ISREG(info.st_mode) || info.st_size > kFileLimit) {
    ::close(at);
    return -1;
  }
  return at;
}

// vite's names: something-AbCd1234.js
bool hashed(std::string_view path) { return path.starts_with("assets/"); }

Response not_found(const Request& request) {
  return problem_response({.status = 404, .name = "not-found", .title = "There is nothing here", .detail = "Open the start page."},
                          request.path);
}
}  // namespace

Response serve_static(const std::filesystem::path& folder, const Request& request) {
  if (folder.empty()) return not_found(request);
  std::string path = request.path == "/" ? "index.html" : request.path.substr(1);
  const std::string_view type = media_type(path);
  if (type.empty()) return not_found(request);
  struct stat info {};
  const bool gzip = accepts_gzip(request.header("accept-encoding"));
  int fd = gzip ? open_below(folder, path + ".gz", info) : -1;
  const bool compressed = fd >= 0;
  if (fd < 0) fd = open_below(folder, path, info);
  if (fd < 0) return not_found(request);
  Response response;
  response.content_type = std::string{type};
  response.set("Vary", "Accept-Encoding");
  response.set("Cache-Control", hashed(path) ? "public, max-age=31536000, immutable" : "no-cache");
  const std::string etag = "\"" + std::to_string(info.st_size) + "-" + std::to_string(info.st_mtim.tv_sec) + "-" +
                           std::to_string(info.st_mtim.tv_nsec) + (compressed ? "-gz\"" : "\"");
  response.set("ETag", etag);
  if (names_etag(request.header("if-none-match"), etag)) {
    ::close(fd);
    response.status = 304;
    response.content_type.clear();
    return response;
  }
  if (compressed) response.set("Content-Encoding", "gzip");
  response.body.resize(static_cast<std::size_t>(info.st_size));
  std::size_t done = 0;
  while (done < response.body.size()) {
    const ssize_t got = ::read(fd, response.body.data() + done, response.body.size() - done);
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  ::close(fd);
  response.body.resize(done);
  return response;
}

}  // namespace hoist::server
