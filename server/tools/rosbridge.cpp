#include "server/tools/rosbridge.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "control/contract/params.hpp"
#include "server/text/json_text.hpp"

namespace hoist::server {

using contract::Role;
using nlohmann::json;

namespace {
constexpr std::string_view kRosApi = "rosapi/";
constexpr double kThrottle_ms_max = 60'000;

std::string_view text_of(const json& value) { return value.is_string() ? std::string_view{value.get_ref<const std::string&>()} : ""; }

// Services are named with and without the leading slash.
std::string service_name(const json& message) {
  const std::string_view name = text_of(tool_field(message, "service"));
  return name.starts_with('/') ? std::string{name} : "/" + std::string{name};
}
// Parameters are named "name", "/name" or "/hoist:name".
std::optional<std::size_t> find_parameter(std::string_view name) {
  if (const std::size_t colon = name.find(':'); colon != std::string_view::npos) name.remove_prefix(colon + 1);
  if (name.starts_with('/')) name.remove_prefix(1);
  return contract::find_param(name);
}
}  // namespace

void RosbridgeClient::send_json(const json& message) { send(make_frame(Opcode::text, dump_json(message))); }

void RosbridgeClient::tell(ToolLevel level, const std::string& text) {
  constexpr std::array<const char*, 3> kLevels{"info", "warning", "error"};
  send_json({{"op", "status"}, {"level", kLevels[static_cast<std::size_t>(level)]}, {"msg", text}});
}

bool RosbridgeClient::is_stop(const json& message) const {
  return text_of(tool_field(message, "op")) == "call_service" && find_tool_service(service_name(message)) == ServiceId::stop;
}

void RosbridgeClient::on_message(const json& message, const std::optional<std::string>& repeated) {
  const std::string_view op = text_of(tool_field(message, "op"));
  if (op == "publish") return publish(message, repeated.has_value());
  if (repeated) {
    counters().add(Count::ws_refused);
    return tell(ToolLevel::error, *repeated + " is given twice");
  }
  if (op == "subscribe") return subscribe(message);
  if (op == "unsubscribe") {
    if (const auto topic = find_tool_topic(text_of(tool_field(message, "topic")))) watched_ &= ~(TopicMask{1} << *topic);
    return;
  }
  if (op == "call_service") return call_service(message);
  // Any topic may be announced; only /cmd_vel does something.
  if (op == "advertise" || op == "unadvertise") return;
  counters().add(Count::ws_refused);
  counters().add(Count::ws_refused_type);
  tell(ToolLevel::error, "There is no such operation here.");
}

void RosbridgeClient::subscribe(const json& message) {
  const std::string name{text_of(tool_field(message, "topic"))};
  const auto topic = find_tool_topic(name);
  if (!topic) return tell(ToolLevel::error, "There is no topic " + name);
  const std::string_view compression = text_of(tool_field(message, "compression"));
  if (!compression.empty() && compression != "none") return tell(ToolLevel::error, "Messages are sent without compression only.");
  const json& throttle = tool_field(message, "throttle_rate");
  const double throttle_ms = throttle.is_number() ? std::clamp(throttle.get<double>(), 0.0, kThrottle_ms_max) : 0.0;
  topics_[*topic] = {.throttle_ns = static_cast<std::int64_t>(throttle_ms * 1e6)};
  watched_ |= TopicMask{1} << *topic;
}

void RosbridgeClient::show(Moment& moment) {
  const TopicMask due = watched_ & moment.due();
  for (std::size_t topic = 0; topic < kToolTopics; ++topic) {
    Watched& watched = topics_[topic];
    if ((due >> topic & 1U) == 0 || moment.utc_ns() - watched.sent_ns < watched.throttle_ns) continue;
    watched.sent_ns = moment.utc_ns();
    std::string text = R"({"op":"publish","topic":")" + std::string{tool_topics()[topic].name} + R"(","msg":)";
    text += moment.json(topic);
    text += '}';
    send_telemetry(make_frame(Opcode::text, text));
  }
}

void RosbridgeClient::publish(const json& message, bool repeated) {
  if (text_of(tool_field(message, "topic")) != "/cmd_vel") return;
  drive(repeated ? std::nullopt : read_twist(tool_field(message, "msg")));
}

void RosbridgeClient::respond(const json& request, const json& values, bool result) {
  json answer{{"op", "service_response"}, {"service", tool_field(request, "service")}, {"values", values}, {"result", result}};
  if (const json& id = tool_field(request, "id"); id.is_string()) answer["id"] = id;
  send_json(answer);
}

void RosbridgeClient::call_service(const json& message) {
  const std::string name = service_name(message);
  if (const auto service = find_tool_service(name)) {
    call(*service, later<RosbridgeClient>([message](RosbridgeClient& self, const Outcome& outcome) {
      self.respond(message, {{"success", outcome.done()}, {"message", outcome.done() ? "" : sentence_of(outcome)}}, true);
    }));
    return;
  }
  const std::string_view plain = std::string_view{name}.substr(1);
  if (plain.starts_with(kRosApi)) {
    const std::string_view what = plain.substr(kRosApi.size());
    const json& arguments = tool_field(message, "args");
    if (what == "set_param") return set_param(message, arguments);
    if (const json values = rosapi(what, arguments); !values.is_null()) return respond(message, values, true);
  }
  respond(message, "There is no service " + name, false);
}

void RosbridgeClient::set_param(const json& message, const json& arguments) {
  const std::string name{text_of(tool_field(arguments, "name"))};
  const auto index = find_parameter(name);
  JsonError error;
  const auto value = parse_json(text_of(tool_field(arguments, "value")), error);
  json values = json::object();
  values[index ? std::string{contract::kParams[*index].name} : name] = value.value_or(json());
  set_parameters(values, later<RosbridgeClient>([message](RosbridgeClient& self, const Outcome& outcome) {
                   if (outcome.done()) self.parameters_shown();
                   self.respond(message, {{"successful", outcome.done()}, {"reason", outcome.done() ? "" : sentence_of(outcome)}}, true);
                 }));
}

json RosbridgeClient::rosapi(std::string_view name, const json& arguments) {
  json names = json::array(), types = json::array(), texts = json::array();
  if (name == "topics" || name == "topics_and_raw_types") {
    for (const ToolTopic& topic : tool_topics()) {
      names.push_back(topic.name);
      types.push_back(db::ros::short_type(topic.type));
      texts.push_back(topic.cdr ? topic.schema : "");
    }
    if (name == "topics") return {{"topics", names}, {"types", types}};
    return {{"topics", names}, {"types", types}, {"typedefs_full_text", texts}};
  }
  if (name == "topic_type") {
    const auto topic = find_tool_topic(text_of(tool_field(arguments, "topic")));
    return {{"type", topic ? db::ros::short_type(tool_topics()[*topic].type) : ""}};
  }
  if (name == "services") {
    for (const ToolService& service : kToolServices)
      if (role() >= service.role) names.push_back(service.name);
    return {{"services", names}};
  }
  if (name == "service_type") {
    const bool known = find_tool_service(text_of(tool_field(arguments, "service"))).has_value();
    return {{"type", known ? "std_srvs/Trigger" : ""}};
  }
  if (name == "nodes") return {{"nodes", {"/hoist"}}};
  if (name == "get_param_names") {
    for (const contract::ParamInfo& p : contract::kParams) names.push_back(p.name);
    return {{"names", names}};
  }
  if (name == "get_param" || name == "has_param") {
    const auto index = find_parameter(text_of(tool_field(arguments, "name")));
    if (name == "has_param") return {{"exists", index.has_value()}};
    if (!index) return {{"value", "null"}, {"successful", false}, {"reason", "There is no such parameter."}};
    if (!services().core.has_parameters())
      return {{"value", "null"}, {"successful", false}, {"reason", "The control core is not connected."}};
    parameters_shown();
    return {{"value", dump_json(services().core.parameters().values[*index])}, {"successful", true}, {"reason", ""}};
  }
  return nullptr;
}

}  // namespace hoist::server
