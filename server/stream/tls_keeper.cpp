#include "server/stream/tls_keeper.hpp"

#include <chrono>
#include <iostream>
#include <utility>

namespace hoist::server {

std::unique_ptr<TlsContext> TlsKeeper::first(std::string& error) {
  if (ca_->issue(own_addresses(), utc_s_(), error) == DeviceCa::Issued::failed) {
    if (ca_->signed_names().empty()) return nullptr;
    // A disk that takes no data, or a clock that is not set, must not keep STOP from the tablets. main() tries again.
    std::cerr << "hoist-server: the certificate of before stays in use: " << error << std::endl;
    told_error_ = std::exchange(error, {});
  }
  return TlsContext::load(ca_->server_file(), ca_->server_file(), error);
}

void TlsKeeper::start() {
  thread_ = std::thread([this] { main(); });
}

void TlsKeeper::stop() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  woken_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void TlsKeeper::look() {
  {
    const std::lock_guard lock(mutex_);
    look_ = true;
  }
  woken_.notify_all();
}

void TlsKeeper::main() {
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      woken_.wait_for(lock, std::chrono::seconds(kEvery_s), [this] { return look_ || ending_; });
      if (ending_) return;
      look_ = false;
    }
    std::string error;
    const DeviceCa::Issued issued = ca_->issue(own_addresses(), utc_s_(), error);
    if (issued == DeviceCa::Issued::renewed)
      if (auto fresh = TlsContext::load(ca_->server_file(), ca_->server_file(), error)) on_new_(std::move(fresh), ca_->signed_names());
    // The certificate in use stays; each reason is told once.
    if (error != std::exchange(told_error_, error) && !error.empty()) std::cerr << "hoist-server: " << error << std::endl;
  }
}

}  // namespace hoist::server
