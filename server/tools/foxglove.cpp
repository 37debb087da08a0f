#include "server/tools/foxglove.hpp"

#include <cstring>
#include <nlohmann/json.hpp>

#include "control/contract/params.hpp"
#include "db/export/ros/encode.hpp"
#include "server/text/json_text.hpp"

namespace hoist::server {

using contract::Role;
using nlohmann::json;

namespace {
constexpr char kMessageData = 1, kServiceCall = 2, kServiceResponse = 3;

std::optional<std::uint32_t> read_u32(std::string_view& bytes) {
  std::uint32_t value = 0;
  if (bytes.size() < sizeof value) return std::nullopt;
  std::memcpy(&value, bytes.data(), sizeof value);
  bytes.remove_prefix(sizeof value);
  return value;
}
template <typename Value>
void put(std::string& out, Value value) {
  std::array<char, sizeof value> bytes;
  std::memcpy(bytes.data(), &value, sizeof value);
  out.append(bytes.data(), bytes.size());
}
std::optional<std::uint32_t> number_of(const json& value) {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > 0xFFFF'FFFF) return std::nullopt;
  return value.get<std::uint32_t>();
}
std::string_view text_of(const json& value) { return value.is_string() ? std::string_view{value.get_ref<const std::string&>()} : ""; }

constexpr std::string_view kTriggerRequest = R"({"type":"object","properties":{}})";
constexpr std::string_view kTriggerResponse =
    R"({"type":"object","properties":{"success":{"type":"boolean"},"message":{"type":"string"}}})";

json schema_of(std::string_view name, std::string_view schema) {
  return {{"encoding", "json"}, {"schemaName", name}, {"schemaEncoding", "jsonschema"}, {"schema", schema}};
}
}  // namespace

void FoxgloveClient::send_json(const json& message) { send(make_frame(Opcode::text, dump_json(message))); }

void FoxgloveClient::tell(ToolLevel level, const std::string& text) {
  send_json({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", text}});
}

void FoxgloveClient::greet() {
  json capabilities{"parameters", "parametersSubscribe", "services"};
  if (role() >= Role::therapist) capabilities.push_back("clientPublish");
  send_json({{"op", "serverInfo"},
             {"name", "Hoist"},
             {"capabilities", std::move(capabilities)},
             {"supportedEncodings", {"json", "cdr"}},
             {"sessionId", hub().session_id()}});
  json channels = json::array();
  for (std::size_t i = 0; i < kToolTopics; ++i) {
    const ToolTopic& topic = tool_topics()[i];
    channels.push_back({{"id", i},
                        {"topic", topic.name},
                        {"encoding", topic.cdr ? "cdr" : "json"},
                        {"schemaName", topic.type},
                        {"schema", topic.schema},
                        {"schemaEncoding", topic.cdr ? "ros2msg" : "jsonschema"}});
  }
  send_json({{"op", "advertise"}, {"channels", std::move(channels)}});
  json offered = json::array();
  for (std::size_t i = 0; i < kToolServices.size(); ++i) {
    if (role() < kToolServices[i].role) continue;
    // Both forms of the schemas. The older clients know only the second, and read it in the first of our encodings.
    offered.push_back({{"id", i},
                       {"name", kToolServices[i].name},
                       {"type", "std_srvs/srv/Trigger"},
                       {"request", schema_of("std_srvs/srv/Trigger_Request", kTriggerRequest)},
                       {"response", schema_of("std_srvs/srv/Trigger_Response", kTriggerResponse)},
                       {"requestSchema", kTriggerRequest},
                       {"responseSchema", kTriggerResponse}});
  }
  send_json({{"op", "advertiseServices"}, {"services", std::move(offered)}});
}

void FoxgloveClient::look() noexcept {
  watched_ = 0;
  for (const auto& [id, topic] : subscriptions_) watched_ |= TopicMask{1} << topic;
}

void FoxgloveClient::subscribe(const json& message) {
  const json& list = tool_field(message, "subscriptions");
  if (!list.is_array()) return tell(ToolLevel::error, "subscriptions must be a list");
  for (const json& item : list) {
    const auto id = number_of(tool_field(item, "id"));
    const auto channel = number_of(tool_field(item, "channelId"));
    if (!id || !channel || *channel >= kToolTopics)
      tell(ToolLevel::error, "there is no such channel");
    else if (subscriptions_.size() >= kSubscriptions)
      tell(ToolLevel::error, "at most 64 subscriptions");
    else
      subscriptions_.insert_or_assign(*id, *channel);
  }
  look();
}

void FoxgloveClient::unsubscribe(const json& message) {
  for (const json& item : tool_field(message, "subscriptionIds"))
    if (const auto id = number_of(item)) subscriptions_.erase(*id);
  look();
}

void FoxgloveClient::advertise(const json& message) {
  // Tools announce further topics (goal pose, clicked point): they are taken and ignored.
  for (const json& item : tool_field(message, "channels")) {
    const auto id = number_of(tool_field(item, "id"));
    if (!id || text_of(tool_field(item, "topic")) != "/cmd_vel") continue;
    const std::string_view encoding = text_of(tool_field(item, "encoding"));
    if (encoding != "json" && encoding != "cdr")
      tell(ToolLevel::error, "/cmd_vel must be json or cdr");
    else if (role() < Role::therapist)
      tell(ToolLevel::error, "Your role may not drive.");
    else if (channels_.size() < kChannels)
      channels_.insert_or_assign(*id, std::string{encoding});
  }
}

void FoxgloveClient::show(Moment& moment) {
  for (const auto& [id, topic] : subscriptions_) {
    if ((moment.due() >> topic & 1U) == 0) continue;
    const std::string& payload = moment.cdr(topic);
    constexpr std::size_t kHead_bytes = 13;
    auto frame = std::make_shared<std::string>();
    begin_frame(*frame, Opcode::binary, kHead_bytes + payload.size());
    frame->push_back(kMessageData);
    put(*frame, id);
    put(*frame, static_cast<std::uint64_t>(moment.utc_ns()));
    *frame += payload;
    send_telemetry(frame);
  }
}

void FoxgloveClient::answer_parameters(const json& names, const json& id) {
  if (!services().core.has_parameters()) return tell(ToolLevel::warning, "The control core is not connected.");
  json list = json::array();
  const auto add = [&](std::size_t index) {
    // The type keeps a tool from turning 0.6 into an integer when it writes 1.
    list.push_back({{"name", contract::kParams[index].name}, {"value", services().core.parameters().values[index]}, {"type", "float64"}});
  };
  if (!names.is_array() || names.empty())
    for (std::size_t i = 0; i < contract::kParamCount; ++i) add(i);
  else
    for (const json& name : names)
      if (const auto index = contract::find_param(text_of(name))) add(*index);
  json answer{{"op", "parameterValues"}, {"parameters", std::move(list)}};
  if (id.is_string()) answer["id"] = id;
  send_json(answer);
  parameters_shown();
}

void FoxgloveClient::show_parameters() {
  if (follows_parameters_) answer_parameters(json(), json());
}

void FoxgloveClient::set(const json& message) {
  json values = json::object(), names = json::array();
  for (const json& item : tool_field(message, "parameters")) {
    const std::string name{text_of(tool_field(item, "name"))};
    values[name] = tool_field(item, "value");
    names.push_back(name);
  }
  set_parameters(values, later<FoxgloveClient>(
                             [names = std::move(names), id = tool_field(message, "id")](FoxgloveClient& self, const Outcome& outcome) {
                               if (!outcome.done()) self.tell(ToolLevel::warning, sentence_of(outcome));
                               self.answer_parameters(names, id);
                             }));
}

void FoxgloveClient::on_message(const json& message, const std::optional<std::string>& repeated) {
  const std::string_view op = text_of(tool_field(message, "op"));
  if (repeated) {
    counters().add(Count::ws_refused);
    return tell(ToolLevel::error, *repeated + " is given twice");
  }
  if (op == "subscribe") return subscribe(message);
  if (op == "unsubscribe") return unsubscribe(message);
  if (op == "advertise") return advertise(message);
  if (op == "unadvertise") {
    for (const json& item : tool_field(message, "channelIds"))
      if (const auto id = number_of(item)) channels_.erase(*id);
    return;
  }
  if (op == "getParameters") return answer_parameters(tool_field(message, "parameterNames"), tool_field(message, "id"));
  if (op == "setParameters") return set(message);
  // All or none: the few names of a subscription would save little.
  if (op == "subscribeParameterUpdates") {
    follows_parameters_ = true;
    return;
  }
  if (op == "unsubscribeParameterUpdates") {
    follows_parameters_ = false;
    return;
  }
  counters().add(Count::ws_refused);
  counters().add(Count::ws_refused_type);
  tell(ToolLevel::warning, "There is no such message.");
}

void FoxgloveClient::on_binary(std::string payload) {
  std::string_view rest = payload;
  const char opcode = rest.empty() ? '\0' : rest.front();
  if (!rest.empty()) rest.remove_prefix(1);
  if (opcode == kServiceCall) return on_service(rest);
  if (!allow()) return;
  if (opcode == kMessageData) return on_publish(rest);
  counters().add(Count::ws_refused);
  counters().add(Count::ws_refused_type);
}

void FoxgloveClient::on_publish(std::string_view rest) {
  const auto id = read_u32(rest);
  const auto channel = id ? channels_.find(*id) : channels_.end();
  if (channel == channels_.end()) return;
  if (channel->second == "json") {
    JsonError error;
    const auto message = parse_json(rest, error);
    return drive(message && !repeated_name(rest) ? read_twist(*message) : std::nullopt);
  }
  // CDR: four bytes of head, then six doubles.
  std::array<double, 6> twist{};
  constexpr std::size_t kHead_bytes = 4;
  if (rest.size() != kHead_bytes + sizeof twist || rest[0] != 0 || rest[1] != 1) return drive(std::nullopt);
  std::memcpy(twist.data(), rest.data() + kHead_bytes, sizeof twist);
  drive(Twist{twist[0], twist[5]});
}

void FoxgloveClient::on_service(std::string_view rest) {
  const auto service = read_u32(rest), number = read_u32(rest), size = read_u32(rest);
  const bool whole = service && number && size && *size <= rest.size();
  const bool known = whole && *service < kToolServices.size();
  // STOP does not count against the allowance.
  const bool stops = known && static_cast<ServiceId>(*service) == ServiceId::stop;
  if (!stops && !allow()) return;
  if (!known) {
    counters().add(Count::ws_refused);
    if (whole)
      send_json({{"op", "serviceCallFailure"}, {"serviceId", *service}, {"callId", *number}, {"message", "There is no such service."}});
    return;
  }
  // Requests carry nothing, so their encoding only says how to answer.
  const std::string encoding = rest.substr(0, *size) == "cdr" ? "cdr" : "json";
  call(static_cast<ServiceId>(*service),
       later<FoxgloveClient>([service = *service, number = *number, encoding](FoxgloveClient& self, const Outcome& outcome) {
         std::string answer{kServiceResponse};
         put(answer, service);
         put(answer, number);
         put(answer, static_cast<std::uint32_t>(encoding.size()));
         answer += encoding;
         const std::string text = outcome.done() ? "" : sentence_of(outcome);
         if (encoding == "cdr") {
           std::string body;
           db::ros::CdrWriter writer(body);
           writer.truth("success", outcome.done());
           writer.text("message", text);
           answer += body;
         } else {
           answer += dump_json({{"success", outcome.done()}, {"message", text}});
         }
         self.send(make_frame(Opcode::binary, answer));
       }));
}

}  // namespace hoist::server
