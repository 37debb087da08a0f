// A finished file as an answer, whole or in part (RFC 9110, 13 and 14: If-Match, then If-None-Match; one range; If-Range).
#pragma once
#include <memory>
#include <string>

#include "db/export/spool_file.hpp"
#include "server/api/call.hpp"

namespace hoist::server {

struct Download {
  std::shared_ptr<const db::SpoolFile> file;
  std::string content_type, file_name;
  std::string etag;  // with its quotes
};
void respond_file(const CallPtr& call, Download download);

}  // namespace hoist::server
