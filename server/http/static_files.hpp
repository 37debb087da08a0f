// The built console. Names that carry a hash never change and are kept by the browser; everything else is asked for again.
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "server/http/exchange.hpp"

namespace hoist::server {

// Larger than any console; a guard against a --web folder that was named by mistake.
inline constexpr std::uintmax_t kPagesLimit_bytes = std::uintmax_t{32} * 1024 * 1024;

// Reads the folder once, so that no request waits for a disk or reaches another file, and all pages are of one build.
class StaticFiles {
 public:
  // Takes every file with a known ending; no links, and nothing whose name begins with a dot. NAME.gz belongs to the NAME beside it.
  // When the files are more than kPagesLimit_bytes, none is served, and the error output says so.
  explicit StaticFiles(const std::filesystem::path& folder);
  // 200, 304 or 404; NAME.gz when the browser takes gzip.
  [[nodiscard]] Response serve(const Request& request) const;

 private:
  struct Body {
    std::string bytes, etag;
  };
  struct File {
    std::string_view media_type;
    Body plain;
    std::optional<Body> gzip;
  };
  std::map<std::string, File, std::less<>> files_;  // by path below the folder
};

}  // namespace hoist::server
