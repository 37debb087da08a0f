#include "server/tools/hub.hpp"

#include <algorithm>

#include "control/contract/params.hpp"
#include "server/actions/actions.hpp"
#include "server/state/views.hpp"
#include "server/tools/foxglove.hpp"
#include "server/tools/rosbridge.hpp"

namespace hoist::server {

ToolHub::ToolHub() : session_id_(random_hex(8)) {}
ToolHub::~ToolHub() = default;

void ToolHub::set_services(Services& services, Auth& auth) {
  services_ = &services;
  auth_ = &auth;
}

void ToolHub::use(Session& session) { auth_->use(session, clocks_of(services_->utc_ns(), services_->now_ns())); }

bool ToolHub::over(const Session& session) const { return Auth::over(session, clocks_of(services_->utc_ns(), services_->now_ns())); }

void ToolHub::open(Protocol protocol, std::unique_ptr<Stream> stream, std::shared_ptr<void> seat, SessionPtr session,
                   const std::string& address) {
  services_->counters.add(Count::ws_opened);
  const bool foxglove = protocol == Protocol::foxglove;
  const char* const origin = foxglove ? "foxglove" : "rosbridge";
  const std::uint32_t number = services_->actors.enter(
      {{session->user, std::string{access_role(session->role)}, origin, client_name(*session)}, session->display_name, address});
  std::shared_ptr<ToolClient> client;
  if (foxglove)
    client = std::make_shared<FoxgloveClient>(*this, std::move(stream), std::move(session), number, std::move(seat));
  else
    client = std::make_shared<RosbridgeClient>(*this, std::move(stream), std::move(session), number, std::move(seat));
  client->opened_ns = services_->now_ns();
  client->start();
  clients_.push_back(client);
  // Switched off, or ending, while its handshake was under way.
  if (ending_ || !services_->tools.on()) client->close(CloseCode::going_away, "");
}

void ToolHub::close_sockets(const std::function<bool(const Session&)>& of, std::string_view reason) {
  // A closing client may leave the list at once.
  const auto all = clients_;
  for (const auto& client : all)
    if (of(client->session())) client->close(CloseCode::policy, reason);
}

void ToolHub::remove(const ToolClient* client) {
  const auto at = std::find_if(clients_.begin(), clients_.end(), [client](const auto& c) { return c.get() == client; });
  if (at == clients_.end()) return;
  const std::shared_ptr<ToolClient> held = *at;
  clients_.erase(at);
  services_->actors.leave(held->number());
  // A client that is gone drives no more: the core stops remote motion and frees the lease.
  if (held->holds_lease())
    act_release_lease(
        *services_, {held->number(), services_->core.lease_epoch(), held->role()}, [](const Outcome&) {}, true);
}

void ToolHub::on_core(bool connected) {
  const std::uint64_t life = services_->core.link().life();
  if (!connected || life == core_life_) return;
  core_life_ = life;
  utc_offset_ns_.reset();
  path_.clear();
  session_id_ = random_hex(8);
  // The new core's time may begin before what the clients have seen: they must connect again.
  const auto all = clients_;
  for (const auto& client : all) client->close(CloseCode::going_away, "the control core has restarted");
}

std::int64_t ToolHub::utc_of(const contract::TickRecord& record) {
  const auto core_ns = static_cast<std::int64_t>(record.time_ns);
  if (!utc_offset_ns_) utc_offset_ns_ = services_->utc_ns() - core_ns;
  return core_ns + *utc_offset_ns_;
}

void ToolHub::on_ticks(std::span<const contract::TickRecord> records, std::uint64_t) {
  for (const contract::TickRecord& record : records) {
    if (record.start_mark != start_mark_) {
      start_mark_ = record.start_mark;
      path_.clear();
    }
    path_.add(static_cast<double>(record.x_m), static_cast<double>(record.y_m));
    if (clients_.empty()) continue;
    moment_.begin(record, utc_of(record), geometry_);
    const auto all = clients_;  // a client that is closed for being slow leaves the list
    for (const auto& client : all)
      if ((client->watched() & moment_.due()) != 0) client->show(moment_);
  }
}

void ToolHub::on_parameters(const contract::ParamsInForce& parameters) {
  for (std::size_t i = 0; i < contract::kParamCount; ++i)
    db::ros::set_parameter(geometry_, contract::kParams[i].name, parameters.values[i]);
  const auto all = clients_;
  for (const auto& client : all)
    if (client->greeted) client->show_parameters();
}

void ToolHub::poll(std::uint64_t now_ns) {
  const auto all = clients_;
  const bool visits = now_ns - visited_ns_ >= kPing_ns;
  if (visits) visited_ns_ = now_ns;
  const auto& newest = services_->core.newest();
  for (const auto& client : all) {
    if (visits) {
      client->visit(now_ns);
      const Session& session = client->session();
      if (over(session) && (session.ended || may_close(*services_, client->number()))) client->close(CloseCode::policy, "signed out");
    }
    if (!client->greeted && now_ns - client->opened_ns >= kGreeting_ns) {
      client->greeted = true;
      client->greet();
    }
    if (newest) client->watch(now_ns, newest->time_ns);
  }
  if (!services_->tools.on() && !all.empty()) {
    for (const auto& client : all) client->close(CloseCode::policy, "switched off");
  }
}

void ToolHub::close_all() {
  ending_ = true;
  const auto all = clients_;
  for (const auto& client : all) client->close(CloseCode::going_away, "the server ends");
}

}  // namespace hoist::server
