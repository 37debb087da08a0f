// What clients of the network send: whole HTTP requests, the bodies of REST, the messages of hoist.v1.
// As in the programs, which are built without assertions: one of Beast 1.81 (parse_chunk_header, n >= 5) does not hold for a last chunk "0" whose
// trailer comes byte by byte.
#define BOOST_DISABLE_ASSERTS
#include <algorithm>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>

#include "server/actions/wishes.hpp"
#include "server/contract/fields.hpp"
#include "server/contract/routes.hpp"
#include "server/contract/schemas.hpp"
#include "server/http/listener.hpp"
#include "server/http/request_head.hpp"
#include "server/text/json_text.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/unit/server/schema.hpp"

namespace hoist::fuzz {
namespace {

using nlohmann::json;
using server::FieldError;

// ----- HTTP -----

// One request as server/http/listener.cpp reads it: what came of it, as a text, and how many bytes it took; none for one that is refused or not
// whole (Beast refuses some before their end, depending on how they are cut).
struct ReadRequest {
  std::string told;
  std::size_t bytes = 0;
};
ReadRequest read_request(std::string_view input, std::size_t piece) {
  namespace http = boost::beast::http;
  http::request_parser<http::string_body> parser;
  parser.header_limit(static_cast<std::uint32_t>(server::kHeaderLimit_bytes));
  parser.body_limit(server::kBodyLimit_bytes);
  ReadRequest read;
  std::optional<server::RequestHead> head;
  std::size_t there = 0;
  while (!parser.is_done()) {
    boost::beast::error_code error;
    const std::size_t taken = there > read.bytes ? parser.put({input.data() + read.bytes, there - read.bytes}, error) : 0;
    read.bytes += taken;
    if (error && error != http::error::need_more) return {};
    if (parser.is_header_done() && !head) {
      head = server::take_head(parser.get().base(), parser.is_done());
      if (!head->fault.empty()) return {};
      parser.eager(true);
      continue;
    }
    if (parser.is_done() || (taken > 0 && !error)) continue;
    if (there == input.size()) return {};
    there = std::min(input.size(), there + piece);
  }
  if (!head) head = server::take_head(parser.get().base(), true);
  if (!head->fault.empty()) return {};
  must(!head->readable || head->request.path.starts_with('/'), "a path is absolute");
  must(parser.get().body().size() <= server::kBodyLimit_bytes, "a body keeps its limit");
  if (head->request.headers.contains("transfer-encoding")) must(!head->request.headers.contains("content-length"), "a body has one end");
  read.told = std::to_string(static_cast<int>(head->request.method)) + ' ' + head->request.path;
  for (const auto& [name, value] : head->request.query) read.told += '?' + name + '=' + value;
  for (const auto& [name, value] : head->request.headers) {
    must(name.find_first_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ\r\n") == std::string::npos, "names are in lower case and on one line");
    must(value.find_first_of("\r\n") == std::string::npos, "no value holds a line of its own");
    read.told += '\n' + name + ':' + value;
  }
  read.told += '\n' + parser.get().body();
  return read;
}

// ----- JSON -----

// A value that fits a schema, with what is required and, where `all`, everything else.
json sample_of(const json& schema, bool all) {
  if (const auto at = schema.find("$ref"); at != schema.end()) {
    const auto& path = at->get_ref<const std::string&>();
    return sample_of(server::schemas().at(path.substr(path.rfind('/') + 1)), all);
  }
  if (schema.contains("const")) return schema["const"];
  if (schema.contains("enum")) return schema["enum"].front();
  if (schema.contains("anyOf")) return sample_of(all ? schema["anyOf"].back() : schema["anyOf"].front(), all);
  const json type = schema.contains("type") && schema["type"].is_array() ? schema["type"].front() : schema.value("type", json("object"));
  if (type == "string") return std::string(std::max<std::size_t>(schema.value("minLength", std::size_t{1}), 1), 'x');
  if (type == "boolean") return all;
  if (type == "integer" || type == "number") return schema.value("minimum", json(0));
  if (type == "null") return nullptr;
  if (type == "array") {
    json items = json::array();
    if (schema.contains("items") && (all || schema.value("minItems", 0) > 0)) items.push_back(sample_of(schema["items"], all));
    return items;
  }
  json object = json::object();
  const json required = schema.value("required", json::array()), properties = schema.value("properties", json::object());
  for (const auto& [name, property] : properties.items())
    if (all || std::find(required.begin(), required.end(), name) != required.end()) object[name] = sample_of(property, all);
  return object;
}

const json& document() {
  static const json kDocument{{"components", {{"schemas", server::schemas()}}}};
  return kDocument;
}

void check_errors(const std::vector<FieldError>& errors) {
  for (const FieldError& error : errors) {
    must(!error.field.empty() && !error.message.empty(), "a refusal names its field and says why");
    must(!error.min || !error.max || *error.min <= *error.max, "a range has two ends");
  }
  (void)server::dump_json(server::to_json(errors));
}

// What a handler takes out of a body that its schema allows.
void take_wishes(std::string_view schema, const json& body) {
  if (!body.is_object()) return;
  std::vector<FieldError> errors;
  if (schema == "HandOverRequest") (void)server::hand_over_wish(body);
  if (schema == "CalibrationRequest") (void)server::calibrate_wish(body);
  if (schema == "CalibrationMeasure") (void)server::measure_wish(body);
  if (schema == "Pose") (void)server::pose_wish(body);
  if (schema == "SetRequest") (void)server::numbers_wish(body.at("values"));
  if (schema == "SetRequest" || schema == "KeepRequest" || schema == "PresetRequest") (void)server::version_wish(body);
  if (schema == "SetRequest") (void)server::number_wish(body, "revert_after_s");
  if (schema == "ModeRequest") {
    if (body.contains("exercise")) (void)server::read_exercise(body["exercise"], errors);
    if (body.contains("path")) (void)server::read_guided(body["path"], contract::GuidedLimits{}, errors);
  }
  check_errors(errors);
}

// The server's check beside an independent one: what it accepts fits the schema, and what it refuses does not.
void check_body(std::string_view schema, const json& body) {
  const std::vector<FieldError> errors = server::wrong_fields(schema, body);
  check_errors(errors);
  const std::string why = test::mismatch(document(), document()["components"]["schemas"].at(std::string(schema)), body);
  if (errors.empty()) {
    must(why.empty(), "a body that is accepted fits its schema");
    take_wishes(schema, body);
  }
}

std::optional<json> parsed(Bytes input) {
  server::JsonError error;
  const std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  std::optional<json> value = server::parse_json(text, error);
  if (value) (void)server::repeated_name(text);
  return value;
}

const std::vector<std::string>& body_schemas() {
  static const std::vector<std::string> kNames = [] {
    std::set<std::string> names;
    for (const server::Route& route : server::kRoutes)
      if (server::takes_body(route) && server::schemas().contains(std::string(route.request))) names.emplace(route.request);
    return std::vector<std::string>(names.begin(), names.end());
  }();
  return kNames;
}

const std::map<std::string, std::string>& message_schemas() {
  static const std::map<std::string, std::string> kNames{
#define HOIST_IN(type, answered, role, schema, doc) {#type, #schema},
#define HOIST_OUT(...)
#define HOIST_FIELD(...)
#include "server/contract/messages.def"
#undef HOIST_IN
#undef HOIST_OUT
#undef HOIST_FIELD
  };
  return kNames;
}

}  // namespace

// Requests one after the other on a connection: each is the same however the network cuts it, and the next begins where it ends.
void fuzz_http_request(Bytes input) {
  std::string_view rest(reinterpret_cast<const char*>(input.data()), input.size());
  for (int request = 0; request < 4 && !rest.empty(); ++request) {
    const ReadRequest whole = read_request(rest, rest.size()), cut = read_request(rest, 1);
    must(whole.told == cut.told && whole.bytes == cut.bytes, "how a request is cut does not matter");
    if (whole.bytes == 0) return;
    rest.remove_prefix(whole.bytes);
  }
}
std::vector<Input> seeds_http_request() {
  return {input_of("GET /api/v1/sessions?limit=5 HTTP/1.1\r\nHost: 127.0.0.1\r\nCookie: a=b\r\n\r\nGET / HTTP/1.0\r\n\r\n"),
          input_of("POST /api/v1/stop HTTP/1.1\r\nHost: a\r\nContent-Length: 2\r\nContent-Type: application/json\r\n\r\n{}"),
          input_of("PATCH /api/v1/sessions/1 HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n3\r\n{} \r\n0\r\nX: y\r\n\r\n"),
          input_of("GET /ws HTTP/1.1\r\nHost: a\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                   "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: hoist.v1\r\nExpect: 100-continue\r\n\r\n")};
}

// The first byte names the schema.
void fuzz_json_body(Bytes input) {
  if (input.empty()) return;
  if (const auto body = parsed(input.subspan(1))) check_body(body_schemas()[input[0] % body_schemas().size()], *body);
}
std::vector<Input> seeds_json_body() {
  std::vector<Input> seeds;
  for (std::size_t i = 0; i < body_schemas().size(); ++i)
    for (const bool all : {false, true}) {
      Input seed = input_of(sample_of(server::schemas().at(body_schemas()[i]), all).dump());
      seed.insert(seed.begin(), static_cast<std::uint8_t>(i));
      seeds.push_back(std::move(seed));
    }
  return seeds;
}

void fuzz_socket_message(Bytes input) {
  const auto message = parsed(input);
  if (!message || !message->is_object()) return;
  const json type = message->value("type", json());
  const auto schema = type.is_string() ? message_schemas().find(type.get<std::string>()) : message_schemas().end();
  if (schema == message_schemas().end()) return;
  json fields = *message;
  fields.erase("type");
  fields.erase("request");
  check_body(schema->second, fields);
}
std::vector<Input> seeds_socket_message() {
  std::vector<Input> seeds;
  for (const auto& [type, schema] : message_schemas())
    for (const bool all : {false, true}) {
      json message = sample_of(server::schemas().at(schema), all);
      message["type"] = type;
      message["request"] = 7;
      seeds.push_back(input_of(message.dump()));
    }
  return seeds;
}

}  // namespace hoist::fuzz
