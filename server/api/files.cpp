#include "server/api/files.hpp"

#include <algorithm>
#include <utility>

#include "db/store/edit_tag.hpp"

namespace hoist::server {

namespace {
constexpr std::size_t kPiece_bytes = 256 * 1024;

// Read on the recorder's thread, as everything from the disk.
PieceSource pieces_of(RecorderDesk& records, std::shared_ptr<const db::SpoolFile> file, ByteRange range) {
  auto rest = std::make_shared<ByteRange>(range);
  return [&records, file = std::move(file), rest](std::function<void(PieceState, std::string)> done) {
    using Piece = std::pair<PieceState, std::string>;
    const auto length = static_cast<std::size_t>(std::min<std::uint64_t>(rest->length, kPiece_bytes));
    const auto read = [file, offset = rest->first, length, last = length == rest->length](Records&) -> Piece {
      auto bytes = file->read(offset, length);
      if (!bytes || bytes->size() != length) return {PieceState::failed, ""};
      return {last ? PieceState::last : PieceState::more, std::move(*bytes)};
    };
    rest->first += length;
    rest->length -= length;
    if (!records.ask<Piece>(read, [done](Piece piece) { done(piece.first, std::move(piece.second)); })) done(PieceState::failed, "");
  };
}
}  // namespace

void respond_file(const CallPtr& call, Download download) {
  const std::uint64_t size = download.file->size();
  const std::string_view expected = call->request.header("if-match"), tag = download.etag;
  if (!expected.empty() && !db::check_tag(strong_tags(expected), tag.substr(1, tag.size() - 2)))
    return call->fail({.status = 412,
                       .name = "changed-meanwhile",
                       .title = "This was changed meanwhile",
                       .detail = "The file has the ETag " + download.etag + " now: fetch it from its beginning."});
  Response response;
  response.set("ETag", download.etag);
  response.set("Accept-Ranges", "bytes");
  if (names_etag(call->request.header("if-none-match"), download.etag)) {
    response.status = 304;
    return call->respond(std::move(response));
  }
  ByteRange part{0, size};
  const std::string_view condition = call->request.header("if-range");
  // A part of an answer to HEAD is not defined (RFC 9110, 14.2).
  const bool takes_part = call->request.method == Method::get && (condition.empty() || condition == download.etag);
  const std::string_view asked = takes_part ? call->request.header("range") : std::string_view{};
  switch (const RangeWish wish = read_range(asked, size, part); wish) {
    case RangeWish::none:
      break;
    case RangeWish::part:
      response.status = 206;
      response.set("Content-Range",
                   "bytes " + std::to_string(part.first) + "-" + std::to_string(part.first + part.length - 1) + "/" + std::to_string(size));
      break;
    case RangeWish::outside: {
      Response refused = problem_response(
          {.status = 416, .name = "range", .title = "This part is not there", .detail = "The file has " + std::to_string(size) + " bytes."},
          call->request.path);
      refused.set("Content-Range", "bytes */" + std::to_string(size));
      return call->respond(std::move(refused));
    }
  }
  response.content_type = std::move(download.content_type);
  response.set("Content-Disposition", "attachment; filename=\"" + download.file_name + "\"");
  response.length = part.length;
  if (part.length > 0) response.next_piece = pieces_of(call->services.records, std::move(download.file), part);
  call->respond(std::move(response));
}

}  // namespace hoist::server
