// All programs that are connected through /foxglove and /rosbridge: hears what the core says, makes each message once, shares it.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/auth.hpp"
#include "server/link/core_desk.hpp"
#include "server/services.hpp"
#include "server/stream/stream.hpp"
#include "server/tools/client.hpp"
#include "server/tools/topics.hpp"

namespace hoist::server {

class ToolHub final : public CoreListener, public ToolOwner {
 public:
  // Simple clients attach their listeners some time after the handshake; what comes before is lost to them (seen: mcap-record).
  static constexpr std::uint64_t kGreeting_ns = 50'000'000;

  ToolHub();
  ~ToolHub() override;
  void set_services(Services& services, Auth& auth);

  void on_core(bool connected) override;
  void on_ticks(std::span<const contract::TickRecord> records, std::uint64_t lost) override;
  void on_parameters(const contract::ParamsInForce& parameters) override;
  void on_lease(std::uint32_t, std::uint32_t) override {}
  void on_event(const contract::Event&) override {}

  void poll(std::uint64_t now_ns);
  void close_all();
  // As Hub::close_sockets.
  void close_sockets(const std::function<bool(const Session&)>& of, std::string_view reason);

  enum class Protocol : std::uint8_t { foxglove, rosbridge };
  void open(Protocol protocol, std::unique_ptr<Stream> stream, std::shared_ptr<void> seat, SessionPtr session, const std::string& address);
  void remove(const ToolClient* client) override;
  void use(Session& session) override;
  [[nodiscard]] bool over(const Session& session) const override;
  [[nodiscard]] Services& services() const override { return *services_; }
  [[nodiscard]] const std::string& session_id() const override { return session_id_; }

 private:
  [[nodiscard]] std::int64_t utc_of(const contract::TickRecord& record);

  Services* services_ = nullptr;
  Auth* auth_ = nullptr;
  std::vector<std::shared_ptr<ToolClient>> clients_;
  bool ending_ = false;
  std::string session_id_;
  std::uint64_t core_life_ = 0;                // of the core that all of this is of
  std::optional<std::int64_t> utc_offset_ns_;  // of the core's clock
  PathTrace path_;
  std::uint32_t start_mark_ = 0;
  db::ros::Geometry geometry_;
  Moment moment_{path_};
  std::uint64_t visited_ns_ = 0;
};

}  // namespace hoist::server
