#include "server/http/listener.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <ctime>
#include <list>
#include <map>
#include <optional>
#include <utility>

#include "server/contract/status_phrase.hpp"
#include "server/http/problem.hpp"
#include "server/http/request_head.hpp"
#include "server/stream/stream.hpp"

namespace hoist::server {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using tcp = asio::ip::tcp;

class Connection;

struct Peer {
  std::string address;
  bool from_here = false;  // this computer itself
};

// What a connection may ask for.
enum class Seat : std::uint8_t { ordinary, signed_in, stop };

struct Listener::Shared {
  Shared(asio::io_context& io_in, Counters& counters_in, RequestHandler& handler_in, const TlsContext* tls_in)
      : io(io_in), counters(counters_in), handler(handler_in), tls(tls_in), acceptor(io_in), pause(io_in) {}
  asio::io_context& io;
  Counters& counters;
  RequestHandler& handler;
  const TlsContext* tls;
  tcp::acceptor acceptor;
  std::function<bool(const std::string& address)> from_here;
  asio::steady_timer pause;
  bool closing = false;
  // Open HTTP connections, and WebSockets (those in their handshake included).
  std::size_t open = 0;
  std::size_t live = 0;
  std::map<std::string, std::size_t> per_address;
  std::list<std::weak_ptr<Connection>> connections;
};

namespace {
// An IPv4 address as such, also where it came over an IPv6 socket.
asio::ip::address plain_address(const asio::ip::address& address) {
  if (!address.is_v6() || !address.to_v6().is_v4_mapped()) return address;
  return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
}

// One place in the limits; given back when the socket is gone, whoever holds it by then.
std::shared_ptr<void> take_seat(const std::shared_ptr<Listener::Shared>& shared, const std::string& address) {
  ++shared->open;
  ++shared->per_address[address];
  return std::shared_ptr<void>(nullptr, [shared, address](void*) {
    --shared->open;
    const auto at = shared->per_address.find(address);
    if (at != shared->per_address.end() && --at->second == 0) shared->per_address.erase(at);
  });
}

std::shared_ptr<void> take_live_seat(const std::shared_ptr<Listener::Shared>& shared) {
  ++shared->live;
  return std::shared_ptr<void>(nullptr, [shared](void*) { --shared->live; });
}

const Problem kNoSeat{.status = 503,
                      .name = "too-many-connections",
                      .title = "Too many connections are open",
                      .detail = "Close some, or wait a moment and try again."};

// Made once a second; the network thread's only.
const std::string& http_date() {
  static std::time_t made = -1;
  static std::string date;
  const std::time_t now = std::time(nullptr);
  if (now == made) return date;
  made = now;
  std::tm parts{};
  ::gmtime_r(&now, &parts);
  char text[64];
  date.assign(text, std::strftime(text, sizeof text, "%a, %d %b %Y %H:%M:%S GMT", &parts));
  return date;
}

// A body up to this size is sent together with its head.
constexpr std::size_t kCopied_bytes = 256 * 1024;
constexpr std::size_t kHeaderRead_bytes = 4096;
constexpr std::size_t kBodyRead_bytes = 16 * 1024;

void add_field(std::string& head, std::string_view name, std::string_view value) {
  head.append(name).append(": ");
  // No value may contain a line break, or it would become a header of its own.
  for (char c : value) head.push_back(static_cast<unsigned char>(c) < 0x20 ? ' ' : c);
  head.append("\r\n");
}

void add_status(std::string& head, unsigned status) {
  head.append("HTTP/1.1 ").append(std::to_string(status)).append(" ").append(reason_phrase(status)).append("\r\nServer: Hoist\r\n");
}

// The answer to WebSocket's handshake.
std::string upgrade_head(const Response& response) {
  std::string head;
  add_status(head, response.status);
  head.append("Connection: Upgrade\r\n");
  for (const auto& [name, value] : response.headers) add_field(head, name, value);
  return head + "\r\n";
}

std::string head_of(const Response& response, bool keep, bool chunked, std::optional<std::uint64_t> length) {
  std::string head;
  head.reserve(1024 + (length && *length < kCopied_bytes ? *length : 0));
  add_status(head, response.status);
  const auto add = [&head](std::string_view name, std::string_view value) { add_field(head, name, value); };
  add("Date", http_date());
  if (!response.content_type.empty()) add("Content-Type", response.content_type);
  for (const auto& [name, value] : response.headers) add(name, value);
  // A page with a policy of its own (a report) has none of the console's: two would both have to allow its style.
  if (std::ranges::none_of(response.headers, [](const auto& header) { return header.first == "Content-Security-Policy"; }))
    head.append(
        "Content-Security-Policy: default-src 'self'; connect-src 'self'; object-src 'none'; base-uri 'none'; "
        "form-action 'self'; frame-ancestors 'none'\r\n");
  head.append(
      "X-Content-Type-Options: nosniff\r\n"
      "Referrer-Policy: no-referrer\r\n"
      "Cross-Origin-Opener-Policy: same-origin\r\n"
      "Cross-Origin-Resource-Policy: same-origin\r\n");
  if (chunked) add("Transfer-Encoding", "chunked");
  if (length) add("Content-Length", std::to_string(*length));
  add("Connection", keep ? "keep-alive" : "close");
  head += "\r\n";
  return head;
}
}  // namespace

class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(std::shared_ptr<Listener::Shared> shared, std::unique_ptr<Stream> stream, Peer peer, std::shared_ptr<void> seat, Seat kind)
      : kind_(kind),
        reserved_(kind != Seat::ordinary),
        unjudged_(reserved_),
        shared_(std::move(shared)),
        stream_(std::move(stream)),
        deadline_(shared_->io),
        peer_(std::move(peer)),
        seat_(std::move(seat)) {}

  void start() { read_header(reserved_ ? kReservedHeaderTime_s : kHeaderTime_s); }

  // Unauthenticated connection on a reserved seat: evicted first.
  [[nodiscard]] bool unjudged(Seat kind) const { return kind_ == kind && unjudged_ && is_open(); }
  void leave() {
    drop();
    seat_.reset();
  }

  // At the end of the program: at once when nothing is under way.
  void end() {
    ending_ = true;
    if (!busy_) drop();
  }

  void drop() {
    deadline_.cancel();
    if (stream_) stream_->close();
  }

 private:
  using Parser = http::request_parser<http::string_body>;
  using Clock = asio::steady_timer::clock_type;

  // Not once it has become a WebSocket.
  [[nodiscard]] bool is_open() const { return stream_ && stream_->is_open(); }

  // The timer is set again only for an earlier limit. When it fires before the limit it waits on: a request costs no
  // timer.
  void limit_time(int seconds) {
    timed_out_ = false;
    limit_ = Clock::now() + std::chrono::seconds(seconds);
    if (!timing_ || limit_ < deadline_.expiry()) wait_for_limit();
  }

  void wait_for_limit() {
    timing_ = true;
    deadline_.expires_at(limit_);
    deadline_.async_wait([self = shared_from_this()](beast::error_code error) {
      if (error || self->deadline_.expiry() > Clock::now()) return;
      self->timing_ = false;
      if (self->limit_ > Clock::now()) {
        if (self->limit_ != Clock::time_point::max()) self->wait_for_limit();
        return;
      }
      if (!self->draining_) self->shared_->counters.add(Count::connections_timed_out);
      // A request that has begun is told why it is not answered; the reader ends with an error and says it.
      self->timed_out_ = self->reading_ && (self->buffer_.size() > 0 || self->parser_->got_some());
      if (self->timed_out_ && self->stream_)
        self->stream_->cancel();
      else
        self->drop();
    });
  }

  // The first request's header must arrive within five seconds of connecting; later ones within five seconds of their first byte.
  void read_header(int seconds) {
    busy_ = false;
    if (ending_) {
      drop();
      return;
    }
    parser_.emplace();
    parser_->header_limit(static_cast<std::uint32_t>(kHeaderLimit_bytes));
    parser_->body_limit(kImageLimit_bytes);
    body_limit_ = kImageLimit_bytes;
    in_header_ = true;
    header_bytes_ = 0;
    limit_time(seconds);
    reading_ = true;
    read_on();
  }

  // Gives the parser what is there until it has the header, or the whole body; else waits for more.
  void read_on() {
    while (is_open()) {
      if (buffer_.size() > 0) {
        beast::error_code error;
        const std::size_t parsed = parser_->put(buffer_.cdata(), error);
        buffer_.consume(parsed);
        if (in_header_ && is_header_too_large(parsed, error)) error = http::error::header_limit;
        if (error && error != http::error::need_more) return end_reading(error);
        if (!error && (in_header_ ? parser_->is_header_done() : parser_->is_done())) return end_reading({});
        if (!error && buffer_.size() > 0) continue;
      }
      // A chunk's header that never ends.
      if (buffer_.size() + kBodyRead_bytes > buffer_.max_size()) return end_reading(http::error::buffer_overflow);
      const Stream::Taken taken = read_some(in_header_ ? kHeaderRead_bytes : kBodyRead_bytes);
      if (taken.ended) return end_reading(http::error::end_of_stream);
      if (taken.count > 0) continue;
      stream_->wait_readable([self = shared_from_this()](bool ready) {
        // Bytes that came in the same turn as the time limit: no timer runs any more.
        if (ready && !self->timed_out_)
          self->read_on();
        else
          self->end_reading(asio::error::operation_aborted);
      });
      return;
    }
  }

  // The parser's own limit holds for what it gets at once: of a header that comes in parts it forgets the fields that it has parsed.
  bool is_header_too_large(std::size_t parsed, beast::error_code error) {
    header_bytes_ += parsed;
    const bool goes_on = error == http::error::need_more;
    return (!error || goes_on) && header_bytes_ + (goes_on ? buffer_.size() : 0) > kHeaderLimit_bytes;
  }

  Stream::Taken read_some(std::size_t most) {
    const auto room = buffer_.prepare(most);
    const Stream::Taken taken = stream_->read({static_cast<char*>(room.data()), room.size()});
    buffer_.commit(taken.count);
    if (taken.count > 0 && !stamp_) stamp_ = shared_->handler.stamp();
    return taken;
  }

  void end_reading(beast::error_code error) {
    reading_ = false;
    if (in_header_)
      on_header(error);
    else if (error)
      refuse(error);
    else
      handle();
  }

  void wait_for_next() {
    busy_ = false;
    if (ending_) {
      drop();
      return;
    }
    if (buffer_.size() > 0) {
      // Not from here: requests that came together would each lie on the stack above the one before.
      asio::post(shared_->io, [self = shared_from_this()] { self->read_header(kHeaderTime_s); });
      return;
    }
    limit_time(kIdleTime_s);
    wait_for_first_byte();
  }

  void wait_for_first_byte() {
    stream_->wait_readable([self = shared_from_this()](bool ready) {
      const Stream::Taken taken = ready && self->is_open() ? self->read_some(kHeaderRead_bytes) : Stream::Taken{.ended = true};
      if (taken.ended)
        self->drop();
      else if (taken.count == 0)
        self->wait_for_first_byte();
      else
        self->read_header(kHeaderTime_s);
    });
  }

  void on_header(beast::error_code error) {
    if (error) {
      refuse(error);
      return;
    }
    busy_ = true;
    if (const std::string_view fault = read_head(); !fault.empty()) {
      refuse_as_malformed(std::string{fault});
      return;
    }
    if (reserved_ && !may_enter()) {
      shared_->counters.add(Count::connections_refused_address_limit);
      send_refusal(kNoSeat);
      return;
    }
    unjudged_ = false;
    // STOP looks at no body, so a slow one does not hold its seat.
    if (kind_ == Seat::stop) {
      handle();
      return;
    }
    if (!beast::iequals(parser_->get()[http::field::content_type], "application/octet-stream")) {
      body_limit_ = kBodyLimit_bytes;
      parser_->body_limit(kBodyLimit_bytes);
      if (const auto length = parser_->content_length(); length && *length > kBodyLimit_bytes) {
        refuse(http::error::body_limit);
        return;
      }
    }
    if (beast::iequals(parser_->get()[http::field::expect], "100-continue")) {
      outgoing_ = "HTTP/1.1 100 Continue\r\n\r\n";
      write([](Connection& self) { self.read_body(); });
      return;
    }
    read_body();
  }

  void read_body() {
    if (parser_->is_done()) {
      handle();
      return;
    }
    in_header_ = false;
    parser_->eager(true);
    limit_time(kBodyTime_s);
    reading_ = true;
    read_on();
  }

  // A request that could not be read: say why when that helps, then close.
  void refuse(beast::error_code error) {
    Counters& counters = shared_->counters;
    if (timed_out_) {
      send_refusal({.status = 408,
                    .name = "too-slow",
                    .title = "The request did not arrive in time",
                    .detail = "A header has " + std::to_string(reserved_ ? kReservedHeaderTime_s : kHeaderTime_s) + " s, a body " +
                              std::to_string(kBodyTime_s) + " s."});
      return;
    }
    if (error == http::error::end_of_stream || error == asio::error::operation_aborted || error == asio::error::eof ||
        error == asio::error::connection_reset || error == http::error::partial_message || error == asio::error::bad_descriptor) {
      drop();
      return;
    }
    Problem problem;
    if (error == http::error::header_limit) {
      counters.add(Count::http_refused_header_too_large);
      problem = {.status = 431,
                 .name = "header-too-large",
                 .title = "The header is too large",
                 .detail = "At most " + std::to_string(kHeaderLimit_bytes) + " bytes."};
    } else if (error == http::error::body_limit) {
      counters.add(Count::http_refused_body_too_large);
      problem = {.status = 413,
                 .name = "body-too-large",
                 .title = "The body is too large",
                 .detail = "At most " + std::to_string(body_limit_) + " bytes."};
    } else {
      refuse_as_malformed(error.message());
      return;
    }
    send_refusal(problem);
  }

  void refuse_as_malformed(std::string detail) {
    shared_->counters.add(Count::http_refused_malformed);
    send_refusal({.status = 400, .name = "bad-request", .title = "The request cannot be read", .detail = std::move(detail)});
  }

  // Answers a request that has no handler, then closes.
  void send_refusal(const Problem& problem) {
    shared_->counters.add(Count::http_requests);
    head_only_ = false;
    busy_ = true;
    close_with(problem);
  }

  void close_with(const Problem& problem) {
    shared_->counters.add(Count::http_refused);
    keep_ = false;
    Response response = problem_response(problem, "");
    if (problem.status == 503) response.set("Retry-After", "2");
    send(std::move(response));
  }

  // Whether a reserved seat is for this request: of a client that is signed in, or with a fresh link; the last ones only for STOP.
  bool may_enter() {
    if (!readable_) return false;
    if (kind_ == Seat::stop && (request_.method != Method::post || request_.path != "/api/v1/stop")) return false;
    return shared_->handler.may_enter(request_);
  }

  // Takes over the header before the body comes, since Beast adds the fields of a trailer to it, which must not sign a client in. What is wrong
  // with it, or nothing.
  std::string_view read_head() {
    RequestHead head = take_head(parser_->get().base(), parser_->is_done());
    version_10_ = head.version_10;
    // A reserved seat is for one request, so that there is always one soon.
    keep_ = parser_->get().keep_alive() && !reserved_;
    request_ = std::move(head.request);
    request_.address = peer_.address;
    request_.from_here = peer_.from_here;
    head_only_ = request_.method == Method::head;
    readable_ = head.readable;
    return head.fault;
  }

  void handle() {
    if (ending_) keep_ = false;
    request_.stamp = stamp_.value_or(0);
    // Bytes of a next request may be as old as this one.
    if (buffer_.size() == 0) stamp_.reset();
    if (!readable_) {
      shared_->counters.add(Count::http_refused_malformed);
      send(problem_response({.status = 400,
                             .name = "bad-target",
                             .title = "The address cannot be read",
                             .detail = "It must be a path with valid %-escapes, and name no query field twice."},
                            ""));
      return;
    }
    request_.body = std::move(parser_->get().body());
    if (request_.method == Method::post && kind_ != Seat::stop) request_.sender_gone = read_some(kHeaderRead_bytes).ended;
    // The core's answer is bounded at half a second and the recorder's by its queue; the time limit is for the client's side.
    limit_time(kIdleTime_s);
    shared_->handler.handle(std::move(request_), [self = shared_from_this()](Response response) { self->send(std::move(response)); });
  }

  void send(Response response) {
    if (!is_open()) return;
    if (response.upgrade) {
      upgrade(std::move(response));
      return;
    }
    limit_time(kWriteTime_s);
    const bool no_body = response.status == 204 || response.status == 304;
    if (response.next_piece && head_only_) {
      outgoing_ = head_of(response, keep_, !version_10_ && !response.length, response.length);
      write([](Connection& self) { self.finish(); });
      return;
    }
    if (response.next_piece) {
      pieces_ = std::move(response.next_piece);
      chunked_ = !version_10_ && !response.length;
      if (!chunked_ && !response.length) keep_ = false;
      outgoing_ = head_of(response, keep_, chunked_, response.length);
      write([](Connection& self) { self.next_piece(); });
      return;
    }
    outgoing_ = head_of(response, keep_, false, no_body ? std::nullopt : std::optional<std::uint64_t>{response.body.size()});
    if (!head_only_ && !no_body) outgoing_ += response.body;
    write([](Connection& self) { self.finish(); });
  }

  void write(void (*then)(Connection&)) {
    then_ = then;
    written_ = 0;
    write_on();
  }

  void write_on() {
    while (is_open() && written_ < outgoing_.size()) {
      const Stream::Taken taken = stream_->write(std::string_view(outgoing_).substr(written_));
      if (taken.ended) return drop();
      written_ += taken.count;
      if (taken.count > 0) continue;
      stream_->wait_writable([self = shared_from_this()](bool ready) {
        if (ready)
          self->write_on();
        else
          self->drop();
      });
      return;
    }
    if (is_open()) then_(*this);
  }

  // A long answer, piece by piece: the next one is asked for only when the last one has left, so memory stays small.
  void next_piece() {
    limit_ = Clock::time_point::max();
    pieces_([self = shared_from_this()](PieceState state, std::string piece) {
      if (!self->is_open()) return;
      if (state == PieceState::failed) {
        // The answer has begun, so the only honest way to say that it is not whole is to break it off.
        self->drop();
        return;
      }
      self->limit_time(kWriteTime_s);
      self->outgoing_.clear();
      if (!piece.empty() && self->chunked_) {
        char size[20];
        std::snprintf(size, sizeof size, "%zx\r\n", piece.size());
        self->outgoing_ = size;
        self->outgoing_ += piece;
        self->outgoing_ += "\r\n";
      } else {
        self->outgoing_ = std::move(piece);
      }
      if (state == PieceState::last) {
        if (self->chunked_) self->outgoing_ += "0\r\n\r\n";
        self->write([](Connection& c) { c.finish(); });
      } else {
        self->write([](Connection& c) { c.next_piece(); });
      }
    });
  }

  void finish() {
    pieces_ = nullptr;
    if (keep_ && !ending_) {
      wait_for_next();
      return;
    }
    // Our answer must not be lost to a reset because the client is still sending: say that we are done, then read on for a moment.
    stream_->shutdown_send();
    draining_ = true;
    limit_time(2);
    drain(0);
  }

  void drain(std::size_t seen) {
    constexpr std::size_t kDrainLimit = 1024 * 1024;
    scrap_.resize(8192);
    for (Stream::Taken taken = stream_->read(scrap_); taken.count > 0 || taken.ended; taken = stream_->read(scrap_)) {
      seen += taken.count;
      if (taken.ended || seen > kDrainLimit) return drop();
    }
    stream_->wait_readable([self = shared_from_this(), seen](bool ready) {
      if (ready && self->is_open())
        self->drain(seen);
      else
        self->drop();
    });
  }

  void upgrade(Response response) {
    if (shared_->live >= kLiveLimit) {
      shared_->counters.add(Count::connections_refused_total_limit);
      close_with(kNoSeat);
      return;
    }
    // Bytes that came after the request belong to the WebSocket; no client of ours sends any before our answer.
    if (buffer_.size() > 0) {
      drop();
      return;
    }
    limit_time(kHeaderTime_s);
    upgrade_ = std::move(response.upgrade);
    live_seat_ = take_live_seat(shared_);
    outgoing_ = upgrade_head(response);
    write([](Connection& self) { self.hand_over(); });
  }

  // From here the stream is the WebSocket's; this connection goes with its last handler.
  void hand_over() {
    limit_ = Clock::time_point::max();
    deadline_.cancel();
    std::exchange(upgrade_, nullptr)(std::move(stream_), std::move(live_seat_));
    seat_.reset();
  }

  Seat kind_;
  bool reserved_;
  bool unjudged_;
  bool reading_ = false;
  bool timed_out_ = false;
  bool draining_ = false;  // the last answer is out
  std::shared_ptr<Listener::Shared> shared_;
  std::unique_ptr<Stream> stream_;
  asio::steady_timer deadline_;
  Clock::time_point limit_ = Clock::time_point::max();
  bool timing_ = false;  // the timer runs
  Peer peer_;
  std::shared_ptr<void> seat_;
  std::size_t body_limit_ = kImageLimit_bytes;  // of the request that is being read
  beast::flat_buffer buffer_{kHeaderLimit_bytes + kBodyLimit_bytes};
  std::optional<Parser> parser_;
  Request request_;                     // what its header says; the body follows
  bool readable_ = false;               // its target
  bool in_header_ = true;               // being read; else the body
  std::optional<std::uint64_t> stamp_;  // of the request whose bytes are being read
  std::size_t header_bytes_ = 0;
  std::string outgoing_;
  std::size_t written_ = 0;              // of it
  void (*then_)(Connection&) = nullptr;  // when all of it is
  Upgrade upgrade_;
  std::shared_ptr<void> live_seat_;
  std::string scrap_;
  PieceSource pieces_;
  bool keep_ = false;
  bool version_10_ = false;
  bool head_only_ = false;
  bool chunked_ = false;
  bool busy_ = false;
  bool ending_ = false;
};

namespace {
// The earliest connection of this kind that has said nothing yet leaves, so that silence keeps no client out.
bool make_room(Listener::Shared& shared, Seat kind) {
  for (const auto& weak : shared.connections) {
    const auto held = weak.lock();
    if (!held || !held->unjudged(kind)) continue;
    shared.counters.add(Count::connections_refused_total_limit);
    held->leave();
    return true;
  }
  return false;
}

// The seat of a new connection; nothing when all are taken.
std::optional<Seat> find_seat(Listener::Shared& shared, const std::string& address) {
  shared.connections.remove_if([](const auto& weak) { return weak.expired(); });
  const auto at = shared.per_address.find(address);
  const bool greedy = at != shared.per_address.end() && at->second >= kAddressLimit;
  if (!greedy && shared.open < kConnectionLimit - kReservedSeats) return Seat::ordinary;
  if (shared.open < kConnectionLimit - kStopSeats || make_room(shared, Seat::signed_in)) return Seat::signed_in;
  if (shared.open < kConnectionLimit || make_room(shared, Seat::stop)) return Seat::stop;
  return std::nullopt;
}

// Says that there is no seat, as far as that goes at once: under TLS it does not, since the handshake would need a seat itself.
void refuse(Stream& stream) {
  Response response = problem_response(kNoSeat, "");
  response.set("Retry-After", "2");
  const std::string full = head_of(response, false, false, response.body.size()) + response.body;
  // What the client has sent is taken first: closing over unread bytes would take our answer away from it.
  std::array<char, 4096> scrap{};
  (void)stream.read(scrap);
  (void)stream.write(full);
  stream.abort();
}
}  // namespace

Listener::Listener(asio::io_context& io, Counters& counters, RequestHandler& handler, const TlsContext* tls)
    : shared_(std::make_shared<Shared>(io, counters, handler, tls)) {}
Listener::~Listener() { close(); }

std::uint16_t Listener::open(const std::string& address, std::uint16_t port, std::string& error) {
  beast::error_code code;
  const auto ip = asio::ip::make_address(address, code);
  if (code) {
    error = address + " is not an address";
    return 0;
  }
  tcp::acceptor& acceptor = shared_->acceptor;
  const tcp::endpoint endpoint(ip, port);
  acceptor.open(endpoint.protocol(), code);
  if (!code) acceptor.set_option(tcp::acceptor::reuse_address(true), code);
  if (!code) acceptor.bind(endpoint, code);
  if (!code) acceptor.listen(asio::socket_base::max_listen_connections, code);
  if (code) {
    error = "cannot listen on " + address + " port " + std::to_string(port) + ": " + code.message();
    if (code == boost::system::errc::address_not_available)
      error += "; `ip address` lists this computer's addresses, 0.0.0.0 stands for all of them";
    return 0;
  }
  accept();
  return acceptor.local_endpoint().port();
}

void Listener::accept() {
  shared_->acceptor.async_accept([shared = shared_, this](beast::error_code error, tcp::socket socket) {
    if (shared->closing || error == asio::error::operation_aborted) return;
    if (error) {
      // Out of descriptors, most likely: a short pause instead of a busy loop.
      shared->pause.expires_after(std::chrono::milliseconds(100));
      shared->pause.async_wait([shared, this](beast::error_code stopped) {
        if (!stopped && !shared->closing) accept();
      });
      return;
    }
    Counters& counters = shared->counters;
    beast::error_code ignored;
    const asio::ip::address peer = plain_address(socket.remote_endpoint(ignored).address());
    const std::string address = peer.to_string();
    // Linux takes no packet from outside that names an address of its own as the sender.
    const bool from_here = shared->from_here
                               ? shared->from_here(address)
                               : peer.is_loopback() || (!ignored && peer == plain_address(socket.local_endpoint(ignored).address()));
    const std::optional<Seat> kind = find_seat(*shared, address);
    if (!kind) {
      counters.add(Count::connections_refused_total_limit);
      Stream stream(std::move(socket), shared->tls);
      refuse(stream);
    } else {
      counters.add(Count::connections_accepted);
      auto seat = take_seat(shared, address);
      auto connection = std::make_shared<Connection>(shared, std::make_unique<Stream>(std::move(socket), shared->tls),
                                                     Peer{address, from_here}, std::move(seat), *kind);
      shared->connections.push_back(connection);
      connection->start();
    }
    accept();
  });
}

void Listener::close() {
  if (shared_->closing) return;
  shared_->closing = true;
  beast::error_code ignored;
  shared_->acceptor.close(ignored);
  shared_->pause.cancel();
  for (const auto& weak : shared_->connections)
    if (const auto connection = weak.lock()) connection->end();
}

void Listener::drop() {
  close();
  for (const auto& weak : shared_->connections)
    if (const auto connection = weak.lock()) connection->drop();
}

void Listener::set_from_here(std::function<bool(const std::string&)> from_here) { shared_->from_here = std::move(from_here); }

std::size_t Listener::connections() const { return shared_->open; }

}  // namespace hoist::server
