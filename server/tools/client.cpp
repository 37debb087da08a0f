#include "server/tools/client.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "control/contract/params.hpp"
#include "server/text/json_text.hpp"

namespace hoist::server {

using contract::Role;
using nlohmann::json;

namespace {
constexpr std::uint64_t kTellEvery_ns = 1'000'000'000;
}

std::optional<ServiceId> find_tool_service(std::string_view name) {
  for (std::size_t i = 0; i < kToolServices.size(); ++i)
    if (kToolServices[i].name == name) return static_cast<ServiceId>(i);
  return std::nullopt;
}

const json& tool_field(const json& message, const char* name) {
  static const json kNull;
  if (!message.is_object()) return kNull;
  const auto at = message.find(name);
  return at == message.end() ? kNull : *at;
}

std::string sentence_of(const Outcome& outcome) {
  std::string text = outcome.detail;
  for (const FieldError& e : outcome.errors) text += (text.empty() ? "" : " ") + e.field + " " + e.message + ".";
  for (const std::string& name : outcome.refusals) text += (text.empty() ? "" : " ") + std::string{"["} + name + "]";
  return text;
}

ToolClient::ToolClient(ToolOwner& hub, std::unique_ptr<Stream> stream, SessionPtr session, std::uint32_t number, std::shared_ptr<void> seat)
    : SocketConnection(
          {.counters = hub.services().counters, .now_ns = hub.services().now_ns, .telemetry_queue = kToolQueue, .takes_binary = true},
          std::move(stream), std::move(seat)),
      hub_(hub),
      session_(std::move(session)),
      number_(number),
      allowance_ns_(hub.services().now_ns()) {}

Services& ToolClient::services() const { return hub_.services(); }
bool ToolClient::holds_lease() const { return services().core.lease_holder() == number_; }
Asker ToolClient::asker() const {
  return {
      .client = number_, .epoch = services().core.lease_epoch(), .role = session_->role, .over = hub_.over(*session_), .gone = has_ended()};
}
void ToolClient::on_leave() { hub_.remove(this); }

bool ToolClient::allow() {
  if (is_closing()) return false;
  counters().add(Count::ws_messages);
  hub_.use(*session_);
  const std::uint64_t now = now_ns();
  const std::uint64_t earned = (now - allowance_ns_) * kToolMessagesPerSecond / 1'000'000'000;
  if (earned > 0) {
    allowance_ = std::min(kToolMessagesPerSecond, allowance_ + earned);
    allowance_ns_ = now;
  }
  if (allowance_ > 0) {
    --allowance_;
    return true;
  }
  counters().add(Count::ws_refused);
  counters().add(Count::ws_refused_rate);
  close(CloseCode::policy, "too many messages");
  return false;
}

void ToolClient::on_text(std::string text) {
  JsonError error;
  const auto message = parse_json(text, error);
  if (message && message->is_object() && is_stop(*message)) {
    on_message(*message, std::nullopt);
    return;
  }
  if (!allow()) return;
  if (!message || !message->is_object()) {
    counters().add(Count::ws_refused);
    counters().add(Count::ws_refused_json);
    close(CloseCode::policy, "not a JSON object");
    return;
  }
  on_message(*message, repeated_name(text));
}

void ToolClient::on_pong(std::string_view payload) {
  std::uint64_t stamp_ns = 0;
  if (payload.size() != sizeof stamp_ns) return;
  std::memcpy(&stamp_ns, payload.data(), sizeof stamp_ns);
  const auto& newest = services().core.newest();
  if (newest && stamp_ns <= newest->time_ns) echo_ns_ = std::max(echo_ns_, stamp_ns);
}

void ToolClient::watch(std::uint64_t now_ns, std::uint64_t newest_ns) {
  if (!holds_lease()) {
    echo_ns_ = 0;  // of an earlier time in control
    return;
  }
  if (echo_ns_ > newest_ns) echo_ns_ = 0;  // of an earlier core
  std::string stamp(sizeof newest_ns, '\0');
  std::memcpy(stamp.data(), &newest_ns, sizeof newest_ns);
  ping(stamp);
  // Repeated while it is silent: the core takes the middle of the stick only from a hand that is fresh.
  if (twist_ns_ != 0 && now_ns - twist_ns_ >= kToolSilence_ns && now_ns - let_go_ns_ >= kToolSilence_ns) {
    let_go_ns_ = now_ns;
    let_go();
  }
}

void ToolClient::let_go() {
  const DriveWish wish{.sequence = hand_.sequence + 1, .echo_time_ns = echo_ns_, .speed_norm = 0, .yaw_norm = 0, .held = false};
  (void)act_drive(services(), asker(), wish, hand_);
}

std::optional<ToolClient::Twist> ToolClient::read_twist(const json& message) {
  const json& x = tool_field(tool_field(message, "linear"), "x");
  const json& z = tool_field(tool_field(message, "angular"), "z");
  if (!x.is_number() || !z.is_number()) return std::nullopt;
  return Twist{x.get<double>(), z.get<double>()};
}

void ToolClient::drive(const std::optional<Twist>& twist) {
  twist_ns_ = now_ns();
  const contract::ParamsInForce& in_force = services().core.parameters();
  const auto share = [&in_force](double value, double most, contract::ParamName limit) {
    const double full = in_force.values[contract::param_index(limit)];
    return full > 0 ? std::clamp(std::clamp(value, -most, most) / full, -1.0, 1.0) : 0.0;
  };
  DriveWish wish{.sequence = hand_.sequence + 1, .echo_time_ns = echo_ns_, .speed_norm = {}, .yaw_norm = {}, .held = false};
  if (twist && std::isfinite(twist->linear_x_m_s) && std::isfinite(twist->angular_z_rad_s)) {
    wish.speed_norm = share(twist->linear_x_m_s, kToolSpeed_m_s, contract::ParamName::remote_speed_m_s_max);
    wish.yaw_norm = share(twist->angular_z_rad_s, kToolTurn_rad_s, contract::ParamName::remote_yaw_rate_rad_s_max);
    // Zero is how most tools say that the button was released.
    wish.held = twist->linear_x_m_s != 0 || twist->angular_z_rad_s != 0;
  }
  const auto refused = act_drive(services(), asker(), wish, hand_);
  if (!refused) return;
  counters().add(Count::ws_refused);
  counters().add(Count::ws_refused_drive);
  const std::uint64_t now = now_ns();
  if (told_ns_ != 0 && now - told_ns_ < kTellEvery_ns) return;
  told_ns_ = now;
  tell(ToolLevel::warning, "/cmd_vel is refused: " + std::string{refused->text_en()});
}

void ToolClient::call(ServiceId service, OutcomeDone done) {
  static const json kNull, kDrive = "remote", kStandBy = "standby";
  switch (service) {
    case ServiceId::stop:
      return act_stop(services(), asker(), std::move(done));
    case ServiceId::take_control:
      return act_take_lease(services(), asker(), false, std::move(done));
    case ServiceId::release_control:
      return act_release_lease(services(), asker(), std::move(done));
    case ServiceId::drive: {
      Asker who = asker();
      who.echo_time_ns = echo_ns_;
      return act_mode(services(), who, {kDrive, kNull, kNull, kNull}, std::move(done));
    }
    case ServiceId::stand_by:
      return act_mode(services(), asker(), {kStandBy, kNull, kNull, kNull}, std::move(done));
  }
}

void ToolClient::set_parameters(const json& values, OutcomeDone done) {
  NumbersByName numbers;
  for (const auto& [name, value] : values.items()) {
    if (!value.is_number()) {
      Outcome outcome;
      outcome.kind = Outcome::Kind::invalid;
      outcome.reason = Reason::invalid;
      outcome.detail = "Nothing was changed.";
      outcome.errors = {{name, "must be a number"}};
      done(outcome);
      return;
    }
    numbers.emplace_back(name, value.get<double>());
  }
  act_set(services(), asker(), numbers, std::nullopt, version_, std::move(done));
}

void ToolClient::parameters_shown() { version_ = static_cast<std::uint32_t>(services().core.parameters().version); }

}  // namespace hoist::server
