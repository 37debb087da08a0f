// One request and its answer, free of any network library: what the router, the API and the tests talk in.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/contract/method.hpp"

namespace hoist::server {

class Stream;

struct Request {
  Method method = Method::other;
  std::string path;                            // percent-decoded, without the query
  std::map<std::string, std::string> query;    // percent-decoded
  std::map<std::string, std::string> headers;  // names in lower case; equal names joined with ", "
  std::string body;
  std::string address;     // of the peer
  bool from_here = false;  // the peer is this computer itself
  bool wants_upgrade = false;
  std::uint64_t stamp = 0;   // RequestHandler::stamp() when its first byte was read
  bool sender_gone = false;  // of a POST: its sender had closed before it was handled

  // The value of a header (name in lower case), or nothing.
  [[nodiscard]] std::string_view header(std::string_view name) const;
};

// What makes a request ambiguous, in a sentence, or nothing: a field that may come once comes twice, a length that is no plain number, a
// transfer coding other than one "chunked" (what is unknown would end the body elsewhere than its sender means). Names in lower case.
using HeaderFields = std::vector<std::pair<std::string, std::string>>;
[[nodiscard]] std::string_view header_fault(const HeaderFields& fields, bool version_10);

// Takes scheme and authority off a target in absolute form, as clients of a proxy send it (RFC 9112, 3.2.2). The authority; nothing for another form.
[[nodiscard]] std::optional<std::string> take_authority(std::string& target);
// Splits a request target into path and query and decodes both. False: not an absolute path, a broken %-escape, a NUL, a query field that is
// named twice, or more than kQueryFieldLimit of them.
inline constexpr std::size_t kQueryFieldLimit = 32;
[[nodiscard]] bool parse_target(std::string_view target, Request& request);
[[nodiscard]] std::optional<std::string> percent_decode(std::string_view text, bool plus_is_space);

// A long answer comes in pieces: the source is called once per piece and answers once, now or later, on the network thread.
enum class PieceState : std::uint8_t { more, last, failed };
using PieceSource = std::function<void(std::function<void(PieceState, std::string)>)>;

// Takes a connection over once the answer to its handshake has left. `seat` is its place in the limits, held for as long as it is open.
using Upgrade = std::function<void(std::unique_ptr<Stream>, std::shared_ptr<void> seat)>;

struct Response {
  unsigned status = 200;
  std::string content_type;
  std::vector<std::pair<std::string, std::string>> headers;
  std::string body;
  PieceSource next_piece;               // set for long answers, instead of body
  std::optional<std::uint64_t> length;  // of all pieces together, when it is known before
  Upgrade upgrade;                      // set when this connection becomes a WebSocket: status 101 with the headers of the handshake

  void set(std::string name, std::string value) { headers.emplace_back(std::move(name), std::move(value)); }
};

// Whether an If-None-Match header (a list, weak ones too, or *) names this entity tag.
[[nodiscard]] bool names_etag(std::string_view header, std::string_view etag);
// The entity tags of an If-Match header without their quotes, with commas between; empty for *. Weak ones match nothing (RFC 9110, 13.1.1). A tag of
// the gzip form (compress.hpp) stands for the same row.
[[nodiscard]] std::string strong_tags(std::string_view header);
// One part of a file of `size` bytes as a Range header asks for it. `none`: no header, or one that may be ignored (another unit, several parts,
// broken): the whole file is the answer. `outside`: no byte of the file is asked for.
struct ByteRange {
  std::uint64_t first = 0, length = 0;
};
enum class RangeWish : std::uint8_t { none, part, outside };
[[nodiscard]] RangeWish read_range(std::string_view header, std::uint64_t size, ByteRange& part);
// Whether a Content-Type header names this type; its parameters do not count (RFC 9110, 8.3.1).
[[nodiscard]] bool is_media_type(std::string_view header, std::string_view lower_case);
// The token of an Authorization header of the scheme Bearer; empty for another scheme.
[[nodiscard]] std::string_view bearer_token(std::string_view authorization);
// Whether an Accept-Encoding header lets the answer be gzip.
[[nodiscard]] bool accepts_gzip(std::string_view header);

}  // namespace hoist::server
