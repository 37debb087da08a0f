#include "server/http/compress.hpp"

#include <zlib.h>

namespace hoist::server {

namespace {
constexpr int kLevel = 1;             // twice as fast as the default, a tenth larger
constexpr int kGzipWindow = 15 + 16;  // zlib: + 16 writes the gzip format
constexpr int kMemoryLevel = 8;

// Empty when zlib has no memory.
std::string gzip(std::string_view text) {
  z_stream stream{};
  if (::deflateInit2(&stream, kLevel, Z_DEFLATED, kGzipWindow, kMemoryLevel, Z_DEFAULT_STRATEGY) != Z_OK) return {};
  std::string out(::deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const bool whole = ::deflate(&stream, Z_FINISH) == Z_STREAM_END;
  out.resize(whole ? stream.total_out : 0);
  ::deflateEnd(&stream);
  return out;
}
}  // namespace

void compress_json(const Request& request, Response& response) {
  if (response.status != 200 || response.content_type != "application/json" || response.next_piece ||
      response.body.size() < kCompressFrom_bytes)
    return;
  response.set("Vary", "Accept-Encoding");
  if (!accepts_gzip(request.header("accept-encoding"))) return;
  std::string small = gzip(response.body);
  if (small.empty() || small.size() >= response.body.size()) return;
  response.body = std::move(small);
  response.set("Content-Encoding", "gzip");
}

}  // namespace hoist::server
