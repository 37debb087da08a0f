// A client of rosbridge v2: JSON texts, no sub-protocol.
#pragma once
#include "server/tools/client.hpp"

namespace hoist::server {

class RosbridgeClient final : public ToolClient {
 public:
  using ToolClient::ToolClient;

  [[nodiscard]] TopicMask watched() const override { return watched_; }
  void show(Moment& moment) override;
  void show_parameters() override {}

 protected:
  void on_message(const nlohmann::json& message, const std::optional<std::string>& repeated) override;
  void on_binary(std::string) override { close(CloseCode::not_text, "text only"); }
  void tell(ToolLevel level, const std::string& text) override;
  [[nodiscard]] bool is_stop(const nlohmann::json& message) const override;

 private:
  void send_json(const nlohmann::json& message);
  void subscribe(const nlohmann::json& message);
  void publish(const nlohmann::json& message, bool repeated);
  void call_service(const nlohmann::json& message);
  void set_param(const nlohmann::json& message, const nlohmann::json& arguments);
  // What rosapi/NAME answers; null: there is no such service.
  [[nodiscard]] nlohmann::json rosapi(std::string_view name, const nlohmann::json& arguments);
  void respond(const nlohmann::json& request, const nlohmann::json& values, bool result);

  struct Watched {
    std::int64_t throttle_ns = 0, sent_ns = 0;
  };
  std::array<Watched, kToolTopics> topics_{};
  TopicMask watched_ = 0;
};

}  // namespace hoist::server
