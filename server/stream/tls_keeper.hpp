// Keeps the server's certificate valid: once a minute it looks at the clock and this computer's addresses, and issues a new one when that is due.
#pragma once
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/stream/device_ca.hpp"
#include "server/stream/tls.hpp"

namespace hoist::server {

class TlsKeeper {
 public:
  static constexpr int kEvery_s = 60;
  using Utc = std::function<std::int64_t()>;  // seconds
  // From the keeper's thread: what new connections are to get, and the names in it.
  using OnNew = std::function<void(std::unique_ptr<TlsContext>, std::vector<std::string>)>;

  TlsKeeper(std::unique_ptr<DeviceCa> ca, Utc utc_s, OnNew on_new)
      : ca_(std::move(ca)), utc_s_(std::move(utc_s)), on_new_(std::move(on_new)) {}
  ~TlsKeeper() { stop(); }
  TlsKeeper(const TlsKeeper&) = delete;
  TlsKeeper& operator=(const TlsKeeper&) = delete;

  // Before start(), on the caller's thread: the certificate to begin with. Null with a sentence.
  [[nodiscard]] std::unique_ptr<TlsContext> first(std::string& error);
  void start();
  void stop();
  // Looks now, any thread.
  void look();
  [[nodiscard]] const DeviceCa& ca() const { return *ca_; }

 private:
  void main();

  std::unique_ptr<DeviceCa> ca_;
  Utc utc_s_;
  OnNew on_new_;
  std::string told_error_;
  std::mutex mutex_;
  std::condition_variable woken_;
  bool look_ = false, ending_ = false;
  std::thread thread_;
};

}  // namespace hoist::server
