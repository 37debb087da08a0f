#include "server/http/compress.hpp"

#include <zlib.h>

namespace hoist::server {

namespace {
constexpr int kLevel = 1;             // twice as fast as the default, a tenth larger
constexpr int kGzipWindow = 15 + 16;  // zlib: + 16 writes the gzip format
constexpr int kMemoryLevel = 8;

// zlib's tables are 260 kB, which the heap gives back to the kernel each time: kept from answer to answer.
class Deflater {
 public:
  Deflater() : ready_(::deflateInit2(&stream_, kLevel, Z_DEFLATED, kGzipWindow, kMemoryLevel, Z_DEFAULT_STRATEGY) == Z_OK) {}
  ~Deflater() {
    if (ready_) ::deflateEnd(&stream_);
  }
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;
  // Empty when zlib has no memory.
  std::string gzip(std::string_view text) {
    if (!ready_ || ::deflateReset(&stream_) != Z_OK) return {};
    std::string out(::deflateBound(&stream_, text.size()), '\0');
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    stream_.avail_in = static_cast<uInt>(text.size());
    stream_.next_out = reinterpret_cast<Bytef*>(out.data());
    stream_.avail_out = static_cast<uInt>(out.size());
    out.resize(::deflate(&stream_, Z_FINISH) == Z_STREAM_END ? stream_.total_out : 0);
    return out;
  }

 private:
  z_stream stream_{};
  bool ready_;
};
}  // namespace

void compress_json(const Request& request, Response& response) {
  if (response.status != 200 || response.content_type != "application/json" || response.next_piece ||
      response.body.size() < kCompressFrom_bytes)
    return;
  response.set("Vary", "Accept-Encoding");
  if (!accepts_gzip(request.header("accept-encoding"))) return;
  static Deflater deflater;
  std::string small = deflater.gzip(response.body);
  if (small.empty() || small.size() >= response.body.size()) return;
  response.body = std::move(small);
  response.set("Content-Encoding", "gzip");
  for (auto& [name, value] : response.headers)
    if (name == "ETag") value = gzip_etag(value);
}

std::string gzip_etag(std::string_view etag) {
  std::string out{etag};
  out.insert(out.size() - 1, "-gzip");
  return out;
}

}  // namespace hoist::server
