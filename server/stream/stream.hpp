// The bytes of one client, plain or under TLS. Nothing here waits: reading and writing take what there is now, and the caller asks to be
// called when there may be more. The handshake of TLS is part of the first reading, so it has the same time limit as the first request.
#pragma once
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include "server/stream/tls.hpp"

namespace hoist::server {

class Stream {
 public:
  // `tls` null: plain. It must outlive the stream.
  Stream(boost::asio::ip::tcp::socket socket, const TlsContext* tls);
  ~Stream();
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  // 0 and not ended: nothing now. Ended: the peer has closed, the connection broke, or TLS was violated.
  struct Taken {
    std::size_t count = 0;
    bool ended = false;
  };
  [[nodiscard]] Taken read(std::span<char> into);
  // After less than all of it, go on with exactly what is left, and with nothing else: TLS may have begun a record with it.
  [[nodiscard]] Taken write(std::string_view bytes);

  // Calls `then(true)` once when a read or write may go on, `then(false)` when the stream was cancelled or closed; from the event loop.
  template <typename Then>
  void wait_readable(Then then) {
    if (holds_decrypted()) {
      boost::asio::post(socket_.get_executor(), [then = std::move(then)]() mutable { then(true); });
      return;
    }
    wait(read_wants_write_, std::move(then));
  }
  template <typename Then>
  void wait_writable(Then then) {
    wait(!write_wants_read_, std::move(then));
  }

  // Says that nothing more is sent.
  void shutdown_send();
  // Both directions end; a pending wait finds out.
  void abort();
  // Pending waits end with false; the stream stays open.
  void cancel();
  void close();
  [[nodiscard]] bool is_open() const { return socket_.is_open(); }
  void set_send_buffer(int bytes);
  [[nodiscard]] auto executor() { return socket_.get_executor(); }

 private:
  template <typename Then>
  void wait(bool writable, Then then) {
    using boost::asio::ip::tcp;
    socket_.async_wait(writable ? tcp::socket::wait_write : tcp::socket::wait_read,
                       [then = std::move(then)](const boost::system::error_code& error) mutable { then(!error); });
  }
  [[nodiscard]] bool holds_decrypted() const;
  Taken tls_result(int result, bool& wants_other, int other);

  struct Free {
    void operator()(ssl_st* ssl) const;
  };
  boost::asio::ip::tcp::socket socket_;
  std::unique_ptr<ssl_st, Free> tls_;
  bool read_wants_write_ = false;  // TLS must send before it can read on
  bool write_wants_read_ = false;  // TLS must read before it can write on
  bool broken_ = false;            // OpenSSL allows no further call
};

}  // namespace hoist::server
