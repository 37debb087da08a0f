#include "server/stream/stream.hpp"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <limits>

namespace hoist::server {

using boost::asio::ip::tcp;

namespace {
Stream::Taken plain_result(ssize_t count) {
  if (count >= 0) return {.count = static_cast<std::size_t>(count)};
  return {.ended = errno != EAGAIN && errno != EWOULDBLOCK};
}

int bounded(std::size_t size) { return static_cast<int>(std::min<std::size_t>(size, std::numeric_limits<int>::max())); }
}  // namespace

void Stream::Free::operator()(ssl_st* ssl) const { SSL_free(ssl); }

Stream::Stream(tcp::socket socket, const TlsContext* tls) : socket_(std::move(socket)) {
  boost::system::error_code ignored;
  socket_.set_option(tcp::no_delay(true), ignored);
  socket_.non_blocking(true, ignored);
  if (tls == nullptr) return;
  tls_.reset(tls->accept(socket_.native_handle()));
  broken_ = tls_ == nullptr;
}
Stream::~Stream() = default;

Stream::Taken Stream::read(std::span<char> into) {
  if (broken_) return {.ended = true};
  if (tls_) {
    ERR_clear_error();
    return tls_result(SSL_read(tls_.get(), into.data(), bounded(into.size())), read_wants_write_, SSL_ERROR_WANT_WRITE);
  }
  ssize_t count = 0;
  do count = ::recv(socket_.native_handle(), into.data(), into.size(), MSG_DONTWAIT);
  while (count < 0 && errno == EINTR);
  Taken taken = plain_result(count);
  taken.ended = taken.ended || count == 0;
  return taken;
}

Stream::Taken Stream::write(std::string_view bytes) {
  if (broken_) return {.ended = true};
  if (tls_) {
    if (bytes.empty()) return {};
    ERR_clear_error();
    return tls_result(SSL_write(tls_.get(), bytes.data(), bounded(bytes.size())), write_wants_read_, SSL_ERROR_WANT_READ);
  }
  ssize_t count = 0;
  do count = ::send(socket_.native_handle(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  while (count < 0 && errno == EINTR);
  return plain_result(count);
}

Stream::Taken Stream::tls_result(int result, bool& wants_other, int other) {
  wants_other = false;
  if (result > 0) return {.count = static_cast<std::size_t>(result)};
  const int error = SSL_get_error(tls_.get(), result);
  if (error == SSL_ERROR_WANT_READ || error == SSL_ERROR_WANT_WRITE) {
    wants_other = error == other;
    return {};
  }
  // After these no call is allowed but SSL_free; a peer that has only said its farewell may still be written to.
  broken_ = error == SSL_ERROR_SSL || error == SSL_ERROR_SYSCALL;
  return {.ended = true};
}

bool Stream::holds_decrypted() const { return tls_ && !broken_ && SSL_pending(tls_.get()) > 0; }

void Stream::shutdown_send() {
  boost::system::error_code ignored;
  if (tls_ && !broken_ && SSL_is_init_finished(tls_.get()) != 0) {
    ERR_clear_error();
    (void)SSL_shutdown(tls_.get());  // one record; when the kernel has no room for it, the connection is slow beyond help
  }
  socket_.shutdown(tcp::socket::shutdown_send, ignored);
}

void Stream::abort() {
  boost::system::error_code ignored;
  socket_.shutdown(tcp::socket::shutdown_both, ignored);
}

void Stream::cancel() {
  boost::system::error_code ignored;
  socket_.cancel(ignored);
}

void Stream::close() {
  boost::system::error_code ignored;
  socket_.close(ignored);
  // OpenSSL keeps the number of the descriptor, which may soon be another connection's.
  broken_ = true;
}

void Stream::set_send_buffer(int bytes) {
  boost::system::error_code ignored;
  socket_.set_option(boost::asio::socket_base::send_buffer_size(bytes), ignored);
}

}  // namespace hoist::server
