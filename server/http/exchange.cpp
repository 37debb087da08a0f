#include "server/http/exchange.hpp"

#include <algorithm>
#include <array>
#include <charconv>

namespace hoist::server {

std::string_view Request::header(std::string_view name) const {
  const auto found = headers.find(std::string{name});
  return found == headers.end() ? std::string_view{} : std::string_view{found->second};
}

namespace {
bool equal_ignoring_case(std::string_view text, std::string_view lower_case) {
  return std::ranges::equal(text, lower_case, [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; });
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}
}  // namespace

std::optional<std::string> percent_decode(std::string_view text, bool plus_is_space) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (c == '%') {
      if (i + 2 >= text.size()) return std::nullopt;
      const int high = hex_digit(text[i + 1]);
      const int low = hex_digit(text[i + 2]);
      if (high < 0 || low < 0) return std::nullopt;
      c = static_cast<char>(high * 16 + low);
      i += 2;
    } else if (c == '+' && plus_is_space) {
      c = ' ';
    }
    if (c == '\0') return std::nullopt;
    out.push_back(c);
  }
  return out;
}

std::optional<std::string> take_authority(std::string& target) {
  for (const std::string_view scheme : {std::string_view("http://"), std::string_view("https://")}) {
    if (!equal_ignoring_case(std::string_view(target).substr(0, scheme.size()), scheme)) continue;
    const std::size_t end = std::min(target.find_first_of("/?#", scheme.size()), target.size());
    std::string authority = target.substr(scheme.size(), end - scheme.size());
    target.erase(0, end);
    if (!target.starts_with('/')) target.insert(target.begin(), '/');
    return authority;
  }
  return std::nullopt;
}

bool parse_target(std::string_view target, Request& request) {
  if (target.empty() || target.front() != '/') return false;
  target = target.substr(0, target.find('#'));
  const std::size_t mark = target.find('?');
  auto path = percent_decode(target.substr(0, mark), false);
  if (!path) return false;
  request.path = std::move(*path);
  request.query.clear();
  if (mark == std::string_view::npos) return true;
  std::string_view rest = target.substr(mark + 1);
  for (std::size_t fields = 0; !rest.empty(); ++fields) {
    if (fields >= kQueryFieldLimit) return false;
    const std::size_t end = rest.find('&');
    const std::string_view field = rest.substr(0, end);
    rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
    if (field.empty()) continue;
    const std::size_t equals = field.find('=');
    auto name = percent_decode(field.substr(0, equals), true);
    auto value =
        equals == std::string_view::npos ? std::optional<std::string>{std::string{}} : percent_decode(field.substr(equals + 1), true);
    if (!name || !value) return false;
    if (!request.query.try_emplace(std::move(*name), std::move(*value)).second) return false;
  }
  return true;
}

std::string_view header_fault(const HeaderFields& fields, bool version_10) {
  // Fields of which two readers of a request could believe different ones if they came twice.
  static constexpr auto kOnce = std::to_array<std::string_view>({"authorization", "content-encoding", "content-length", "content-type",
                                                                 "cookie", "expect", "host", "origin", "sec-websocket-key",
                                                                 "sec-websocket-version", "transfer-encoding", "x-hoist", "x-hoist-lease"});
  std::uint32_t seen = 0;
  static_assert(kOnce.size() <= 32);
  for (const auto& [name, value] : fields) {
    const auto once = std::ranges::find(kOnce, name);
    if (once == kOnce.end()) continue;
    const std::uint32_t bit = 1U << static_cast<unsigned>(once - kOnce.begin());
    if ((seen & bit) != 0) return "A header field that may come once comes twice.";
    seen |= bit;
    if (name == "content-length" && (value.empty() || value.find_first_not_of("0123456789") != std::string::npos))
      return "Content-Length must be one plain number.";
    if (name == "transfer-encoding" && (version_10 || !equal_ignoring_case(value, "chunked")))
      return "Transfer-Encoding can only be chunked, once, in HTTP/1.1.";
  }
  return {};
}

namespace {
std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

// Takes the part before `separator` off a list.
std::string_view next_part(std::string_view& rest, char separator) {
  const std::size_t end = rest.find(separator);
  const std::string_view part = trimmed(rest.substr(0, end));
  rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
  return part;
}
}  // namespace

bool names_etag(std::string_view header, std::string_view etag) {
  // Our own tags hold no comma.
  while (!header.empty()) {
    std::string_view tag = next_part(header, ',');
    if (tag == "*") return true;
    if (tag.starts_with("W/")) tag.remove_prefix(2);
    if (tag == etag) return true;
  }
  return false;
}

std::string strong_tags(std::string_view header) {
  constexpr std::string_view kGzip = "-gzip";
  std::string tags;
  while (!header.empty()) {
    std::string_view tag = next_part(header, ',');
    if (tag == "*") return {};
    if (tag.size() < 2 || tag.front() != '"' || tag.back() != '"') continue;
    tag = tag.substr(1, tag.size() - 2);
    if (tag.ends_with(kGzip)) tag.remove_suffix(kGzip.size());
    tags.append(tags.empty() ? "" : ",").append(tag);
  }
  // What names no tag at all matches nothing.
  return tags.empty() ? "-" : tags;
}

RangeWish read_range(std::string_view header, std::uint64_t size, ByteRange& part) {
  constexpr std::string_view kUnit = "bytes=";
  if (!header.starts_with(kUnit)) return RangeWish::none;
  header.remove_prefix(kUnit.size());
  const std::size_t dash = header.find('-');
  if (dash == std::string_view::npos || header.find(',') != std::string_view::npos) return RangeWish::none;
  // Digits only; what does not fit 64 bits is beyond every file.
  const auto number = [](std::string_view text) -> std::optional<std::uint64_t> {
    if (text.empty() || text.find_first_not_of("0123456789") != std::string_view::npos) return std::nullopt;
    std::uint64_t value = 0;
    if (std::from_chars(text.data(), text.data() + text.size(), value).ec != std::errc{}) return UINT64_MAX;
    return value;
  };
  const std::string_view from = trimmed(header.substr(0, dash)), to = trimmed(header.substr(dash + 1));
  const auto first = number(from), last = number(to);
  if ((!from.empty() && !first) || (!to.empty() && !last) || (!first && !last)) return RangeWish::none;
  if (first && last && *last < *first) return RangeWish::none;
  if (!first) {
    const std::uint64_t length = std::min(*last, size);
    part = {size - length, length};
    return length == 0 ? RangeWish::outside : RangeWish::part;
  }
  if (*first >= size) return RangeWish::outside;
  part = {*first, std::min(last.value_or(UINT64_MAX), size - 1) - *first + 1};
  return RangeWish::part;
}

bool is_media_type(std::string_view header, std::string_view lower_case) { return equal_ignoring_case(next_part(header, ';'), lower_case); }

std::string_view bearer_token(std::string_view authorization) {
  constexpr std::string_view kScheme = "bearer ";
  if (!equal_ignoring_case(authorization.substr(0, kScheme.size()), kScheme)) return {};
  return trimmed(authorization.substr(kScheme.size()));
}

bool accepts_gzip(std::string_view header) {
  bool any = false;
  while (!header.empty()) {
    std::string_view row = next_part(header, ',');
    const std::string_view coding = next_part(row, ';');
    if (coding != "gzip" && coding != "*") continue;
    bool refused = false;
    while (!row.empty()) {
      const std::string_view parameter = next_part(row, ';');
      refused = refused || (parameter.starts_with("q=") && parameter.find_first_not_of("0.", 2) == std::string_view::npos);
    }
    if (coding == "gzip") return !refused;
    any = !refused;
  }
  return any;
}

}  // namespace hoist::server
