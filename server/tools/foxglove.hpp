// A client of Foxglove's WebSocket protocol (sub-protocols foxglove.websocket.v1 and foxglove.sdk.v1: the same framing).
#pragma once
#include <map>

#include "server/tools/client.hpp"

namespace hoist::server {

class FoxgloveClient final : public ToolClient {
 public:
  // Subscriptions and announced topics of one client.
  static constexpr std::size_t kSubscriptions = 64, kChannels = 32;
  using ToolClient::ToolClient;

  void greet() override;
  [[nodiscard]] TopicMask watched() const override { return watched_; }
  void show(Moment& moment) override;
  void show_parameters() override;

 protected:
  void on_message(const nlohmann::json& message, const std::optional<std::string>& repeated) override;
  void on_binary(std::string payload) override;
  void tell(ToolLevel level, const std::string& text) override;
  // STOP is a service, and services are called by binary messages.
  [[nodiscard]] bool is_stop(const nlohmann::json&) const override { return false; }

 private:
  void send_json(const nlohmann::json& message);
  void subscribe(const nlohmann::json& message);
  void unsubscribe(const nlohmann::json& message);
  void advertise(const nlohmann::json& message);
  void set(const nlohmann::json& message);
  void answer_parameters(const nlohmann::json& names, const nlohmann::json& id);
  void on_service(std::string_view request);
  void on_publish(std::string_view publish);
  void look() noexcept;

  std::map<std::uint32_t, std::size_t> subscriptions_;  // its number -> topic
  std::map<std::uint32_t, std::string> channels_;       // its number of /cmd_vel -> encoding
  TopicMask watched_ = 0;
  bool follows_parameters_ = false;
};

}  // namespace hoist::server
