#include "server/http/static_files.hpp"

#include <array>
#include <cstdio>
#include <fstream>
#include <functional>
#include <iostream>
#include <sstream>

#include "server/http/problem.hpp"

namespace hoist::server {

namespace files = std::filesystem;

namespace {
constexpr std::string_view kGzipEnding = ".gz";

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

// Calls `take` with each regular file below `folder` and its path below it. False when it has more bytes than allowed.
bool each_file(const files::path& folder, const std::function<void(const files::path&, std::string)>& take) {
  std::error_code error;
  std::uintmax_t total_bytes = 0;
  // Follows no links to folders.
  for (files::recursive_directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (at->path().filename().string().starts_with('.')) {
      at.disable_recursion_pending();
      continue;
    }
    if (at->symlink_status(error).type() != files::file_type::regular) continue;
    total_bytes += at->file_size(error);
    if (error || total_bytes > kPagesLimit_bytes) return false;
    take(at->path(), at->path().lexically_relative(folder).generic_string());
  }
  return true;
}

std::string content_of(const files::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return std::move(text).str();
}

// Of the content (FNV-1a), so that the same build has the same tags after each start, and gzip another tag than plain.
std::string etag_of(std::string_view bytes) {
  std::uint64_t hash = 14695981039346656037U;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211U;
  char text[24];
  return {text, static_cast<std::size_t>(std::snprintf(text, sizeof text, "\"%016llx\"", static_cast<unsigned long long>(hash)))};
}

// vite's names: something-AbCd1234.js
bool hashed(std::string_view path) { return path.starts_with("assets/"); }

Response not_found(const Request& request) {
  return problem_response({.status = 404, .name = "not-found", .title = "There is nothing here", .detail = "Open the start page."},
                          request.path);
}
}  // namespace

StaticFiles::StaticFiles(const files::path& folder) {
  std::map<std::string, Body> compressed;
  const bool whole = folder.empty() || each_file(folder, [&](const files::path& from, const std::string& path) {
                       const bool gzip = path.ends_with(kGzipEnding);
                       const std::string name = gzip ? path.substr(0, path.size() - kGzipEnding.size()) : path;
                       const std::string_view type = media_type(name);
                       if (type.empty()) return;
                       Body body{.bytes = content_of(from), .etag = {}};
                       body.etag = etag_of(body.bytes);
                       if (gzip)
                         compressed[name] = std::move(body);
                       else
                         files_[name] = {.media_type = type, .plain = std::move(body), .gzip = {}};
                     });
  for (auto& [name, body] : compressed)
    if (const auto at = files_.find(name); at != files_.end()) at->second.gzip = std::move(body);
  if (whole) return;
  files_.clear();
  std::cerr << "hoist-server: --web " << folder.string() << " cannot be the console: it holds more than " << (kPagesLimit_bytes >> 20)
            << " MiB. No page is served." << std::endl;
}

Response StaticFiles::serve(const Request& request) const {
  const std::string_view path = request.path == "/" ? std::string_view{"index.html"} : std::string_view{request.path}.substr(1);
  const auto found = files_.find(path);
  if (found == files_.end()) return not_found(request);
  const File& file = found->second;
  const bool gzip = file.gzip && accepts_gzip(request.header("accept-encoding"));
  const Body& body = gzip ? *file.gzip : file.plain;
  Response response;
  response.set("Vary", "Accept-Encoding");
  response.set("Cache-Control", hashed(path) ? "public, max-age=31536000, immutable" : "no-cache");
  response.set("ETag", body.etag);
  if (names_etag(request.header("if-none-match"), body.etag)) {
    response.status = 304;
    return response;
  }
  response.content_type = std::string{file.media_type};
  if (gzip) response.set("Content-Encoding", "gzip");
  response.body = body.bytes;
  return response;
}

}  // namespace hoist::server
