// hoist bus scan, read, write, dump, restore, save, load-defaults, emcy: access to nodes over SDO, with names, units and ranges of the table.
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "control/bus/object_words.hpp"
#include "control/contract/firmware_image.hpp"
#include "deploy/tools/hoist/bus_line.hpp"
#include "deploy/tools/hoist/bus_request.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/node_objects.hpp"

namespace hoist::tool {

namespace {

using contract::CanFrame;
using contract::Node;
using contract::NodeInfo;
using contract::ObjectInfo;
using nlohmann::ordered_json;
namespace canopen = contract::canopen;

constexpr std::size_t kDumpBytesMax = 1U << 20U;

std::array<std::uint8_t, 4> bytes_of(std::uint32_t raw) {
  std::array<std::uint8_t, 4> bytes{};
  contract::write_le(bytes.data(), 4, raw);
  return bytes;
}
bool write_object(BusLine& line, Node node, const ObjectInfo& object, std::uint32_t raw) {
  const auto bytes = bytes_of(raw);
  return line.download(info_of(node).id, object.index, object.sub, std::span(bytes).first(contract::object_bytes(object.type)));
}
std::optional<std::uint32_t> read_object(BusLine& line, Node node, const ObjectInfo& object) {
  if (!line.upload(info_of(node).id, object.index, object.sub)) return std::nullopt;
  if (line.client().uploaded().size() != contract::object_bytes(object.type)) return std::nullopt;
  return line.client().value();
}
std::string read_text(BusLine& line, std::uint8_t node_id, std::uint16_t index) {
  if (!line.upload(node_id, index, 0)) return {};
  std::string text;
  for (const std::uint8_t byte : line.client().uploaded()) text += byte >= 0x20 && byte < 0x7F ? static_cast<char>(byte) : '?';
  return text;
}

std::string words_of(Node node, const ObjectInfo& object, std::uint32_t raw) {
  return bus::object_words(info_of(node).kind, object.index, object.sub, raw);
}
// "1591 (0x637): operation enabled, supply".
std::string value_and_words(Node node, const ObjectInfo& object, std::uint32_t raw) {
  const std::string words = words_of(node, object, raw);
  return value_text(object, raw) + (words.empty() ? "" : ": " + words);
}
ordered_json object_json(Node node, const ObjectInfo& object, std::uint32_t raw) {
  const double value = physical_value(object, raw);
  ordered_json entry{{"index", object.index},
                     {"sub", object.sub},
                     {"name", object.name},
                     {"raw", raw},
                     {"value", std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr)},
                     {"unit", object.unit}};
  if (const std::string words = words_of(node, object, raw); !words.empty()) entry["words"] = words;
  return entry;
}

// A text of the table by its name or index, as an object may be written: "device_name", "1008", "0x1008:0", "1008h".
const contract::TextInfo* parse_text(std::string_view word) {
  std::string_view index = word.substr(0, word.find(':'));
  if (index.size() != word.size() && word.substr(index.size()) != ":0") return nullptr;
  if (index.starts_with("0x")) index.remove_prefix(2);
  if (index.ends_with('h')) index.remove_suffix(1);
  for (const contract::TextInfo& text : contract::kTexts) {
    char known[8];
    std::snprintf(known, sizeof known, "%04X", text.index);
    char same[8] = {};
    for (std::size_t i = 0; i < index.size() && i < 4; ++i) same[i] = static_cast<char>(std::toupper(static_cast<unsigned char>(index[i])));
    if (text.name == word || (index.size() == 4 && std::string_view(known) == same)) return &text;
  }
  return nullptr;
}

}  // namespace

int run_bus_scan(std::span<const std::string_view> arguments) {
  if (wants_help(arguments)) return bus_usage("scan", "", stdout);
  const auto request = parse_bus_request(arguments, 0);
  if (!request) return bus_usage("scan", "", stderr);
  BusLine line;
  std::optional<Node> none;
  if (const auto end = begin_bus("scan", *request, line, none)) return *end;
  auto states = listen_for_states(line);
  for (std::size_t i = 0; i < contract::kRemoteNodeCount; ++i) states.try_emplace(contract::kNodes[i].id, -1);
  ordered_json list = ordered_json::array();
  if (!request->json) std::printf("  id  %-12s %-16s %-22s %-12s %-10s\n", "node", "state", "device", "hardware", "software");
  for (const auto& [id, state] : states) {
    const auto known = contract::find_node(static_cast<std::uint8_t>(id));
    const std::string name = known ? std::string(contract::kNodes[static_cast<std::size_t>(*known)].name) : "not ours";
    const bool is_host = known && info_of(*known).kind == contract::NodeKind::host;
    const auto node_id = static_cast<std::uint8_t>(id);
    std::string device, hardware, software;
    bool answers = false;
    if (!is_host) {
      answers = line.upload(node_id, 0x1000, 0);
      if (answers) {
        device = read_text(line, node_id, 0x1008);
        hardware = read_text(line, node_id, 0x1009);
        software = read_text(line, node_id, 0x100A);
        // A node without a program has its loader's few objects, and no names.
        if (device.empty() && line.upload(node_id, 0x1018, 2) && (line.client().value() & contract::kLoaderProduct) != 0)
          device = "boot loader";
      }
    }
    if (request->json)
      list.push_back({{"id", id},
                      {"node", name},
                      {"state", node_state_text(state)},
                      {"answers", answers},
                      {"device", device},
                      {"hardware", hardware},
                      {"software", software}});
    else
      std::printf(" %02Xh  %-12s %-16s %-22s %-12s %-10s\n", id, name.c_str(), node_state_text(state).c_str(),
                  answers || is_host ? device.c_str() : "does not answer", hardware.c_str(), software.c_str());
  }
  if (request->json) std::printf("%s\n", list.dump(2).c_str());
  return kDone;
}

int run_bus_read(std::span<const std::string_view> arguments) {
  if (wants_help(arguments)) return bus_usage("read", "NODE OBJECT", stdout);
  const auto request = parse_bus_request(arguments, 2);
  if (!request) return bus_usage("read", "NODE OBJECT", stderr);
  BusLine line;
  std::optional<Node> node;
  std::string error;
  // The object is checked before the bus is touched.
  node = parse_node(request->words[0], error);
  if (!node) return bus_refused("read", error);
  if (const contract::TextInfo* text = parse_text(request->words[1]); text != nullptr) {
    if (const auto end = begin_bus("read", *request, line, node)) return *end;
    const std::string words = read_text(line, info_of(*node).id, text->index);
    if (words.empty()) return bus_refused("read", line.problem());
    if (request->json)
      std::printf("%s\n", ordered_json{{"index", text->index}, {"sub", 0}, {"name", text->name}, {"text", words}}.dump().c_str());
    else
      std::printf("%04Xh:0 %s = %s\n", text->index, std::string(text->name).c_str(), words.c_str());
    return kDone;
  }
  const ObjectInfo* object = parse_object(*node, request->words[1], error);
  if (object == nullptr) return bus_refused("read", error);
  if (const auto end = begin_bus("read", *request, line, node)) return *end;
  const auto raw = read_object(line, *node, *object);
  if (!raw) return bus_refused("read", object_text(*object) + ": " + line.problem());
  if (request->json)
    std::printf("%s\n", object_json(*node, *object, *raw).dump().c_str());
  else
    std::printf("%s = %s   (%s; %s)\n", object_text(*object).c_str(), value_and_words(*node, *object, *raw).c_str(),
                std::string(object->title).c_str(), object->access == contract::Access::rw ? range_text(*object).c_str() : "read only");
  return kDone;
}

int run_bus_write(std::span<const std::string_view> arguments) {
  constexpr char kArguments[] = "NODE OBJECT VALUE [--force]";
  constexpr char kMore[] =
      "VALUE is in the unit of the table, or hexadecimal (0x...) as it travels. It lasts until the node is switched off; see save.\n";
  if (wants_help(arguments)) return bus_usage("write", kArguments, stdout, kMore);
  const auto request = parse_bus_request(arguments, 3);
  if (!request) return bus_usage("write", kArguments, stderr, kMore);
  BusLine line;
  std::optional<Node> node;
  std::string error;
  node = parse_node(request->words[0], error);
  if (!node) return bus_refused("write", error);
  const ObjectInfo* object = parse_object(*node, request->words[1], error);
  if (object == nullptr) return bus_refused("write", error);
  const auto raw = parse_value(*object, request->words[2], error);
  if (!raw) return bus_refused("write", error);
  if (const auto end = begin_bus("write", *request, line, node)) return *end;
  if (error = why_not_write(line, request->force); !error.empty()) return bus_refused("write", error);
  if (!write_object(line, *node, *object, *raw)) return bus_refused("write", object_text(*object) + ": " + line.problem());
  const auto now = read_object(line, *node, *object);
  if (!now) return bus_refused("write", object_text(*object) + " was written but cannot be read back: " + line.problem());
  if (request->json)
    std::printf("%s\n", object_json(*node, *object, *now).dump().c_str());
  else
    std::printf("%s = %s\n", object_text(*object).c_str(), value_and_words(*node, *object, *now).c_str());
  return kDone;
}

int run_bus_dump(std::span<const std::string_view> arguments) {
  constexpr char kMore[] = "With --json the output is what restore reads.\n";
  if (wants_help(arguments)) return bus_usage("dump", "NODE", stdout, kMore);
  const auto request = parse_bus_request(arguments, 1);
  if (!request) return bus_usage("dump", "NODE", stderr, kMore);
  BusLine line;
  std::optional<Node> node;
  if (const auto end = begin_bus("dump", *request, line, node)) return *end;
  ordered_json file{{"node", info_of(*node).name},
                    {"kind", static_cast<int>(info_of(*node).kind)},
                    {"texts", ordered_json::object()},
                    {"objects", ordered_json::array()}};
  for (const contract::TextInfo& text : contract::kTexts) {
    const std::string words = read_text(line, info_of(*node).id, text.index);
    if (words.empty()) return bus_refused("dump", std::string(text.name) + ": " + line.problem());
    if (request->json)
      file["texts"][std::string(text.name)] = words;
    else
      std::printf("%04Xh:0 %-28s %-28s %s\n", text.index, std::string(text.name).c_str(), words.c_str(), std::string(text.title).c_str());
  }
  for (const ObjectInfo& object : contract::kObjects) {
    if (!contract::object_applies(object, info_of(*node).kind)) continue;
    const auto raw = read_object(line, *node, object);
    if (!raw) {
      // Empty entries of the error memory abort with their own code; any other missing object is reported.
      if (line.client().outcome() == bus::SdoClient::Outcome::aborted &&
          line.client().abort_code() == static_cast<std::uint32_t>(canopen::SdoAbort::no_data))
        continue;
      return bus_refused("dump", object_text(object) + ": " + line.problem());
    }
    if (request->json) {
      ordered_json entry = object_json(*node, object, *raw);
      entry["parameter"] = is_parameter(object);
      file["objects"].push_back(std::move(entry));
    } else {
      std::printf("%-36s %-28s %s\n", object_text(object).c_str(), value_and_words(*node, object, *raw).c_str(),
                  std::string(object.title).c_str());
    }
  }
  if (request->json) std::printf("%s\n", file.dump(1).c_str());
  return kDone;
}

int run_bus_restore(std::span<const std::string_view> arguments) {
  constexpr char kArguments[] = "NODE FILE [--force]";
  constexpr char kMore[] =
      "Writes the parameters of a dump (--json) into a node of the same kind; all of them are checked before the first is written.\n"
      "They last until the node is switched off; see save.\n";
  if (wants_help(arguments)) return bus_usage("restore", kArguments, stdout, kMore);
  const auto request = parse_bus_request(arguments, 2);
  if (!request) return bus_usage("restore", kArguments, stderr, kMore);
  std::string error;
  const auto target = parse_node(request->words[0], error);
  if (!target) return bus_refused("restore", error);
  const NodeInfo& info = info_of(*target);
  std::ifstream in(std::string(request->words[1]), std::ios::binary);
  if (!in) return bus_refused("restore", std::string(request->words[1]) + " cannot be read");
  std::string content(kDumpBytesMax + 1, '\0');
  in.read(content.data(), static_cast<std::streamsize>(content.size()));
  content.resize(static_cast<std::size_t>(in.gcount()));
  if (content.size() > kDumpBytesMax) return bus_refused("restore", "the file is longer than 1 MiB");
  const auto file = nlohmann::json::parse(content, nullptr, false);
  if (!file.is_object() || !file.contains("kind") || !file["kind"].is_number_integer() || !file.contains("objects") ||
      !file["objects"].is_array())
    return bus_refused("restore", "the file is no dump");
  if (file["kind"].get<int>() != static_cast<int>(info.kind)) return bus_refused("restore", "the dump is of another kind of node");
  std::vector<std::pair<const ObjectInfo*, std::uint32_t>> values;
  for (const auto& entry : file["objects"]) {
    if (!entry.is_object() || !entry.contains("index") || !entry.contains("sub") || !entry.contains("raw") ||
        !entry["index"].is_number_unsigned() || !entry["sub"].is_number_unsigned() || !entry["raw"].is_number_unsigned())
      return bus_refused("restore", "an entry of the dump has no index, sub or raw");
    const auto index = entry["index"].get<std::uint64_t>(), sub = entry["sub"].get<std::uint64_t>(),
               raw = entry["raw"].get<std::uint64_t>();
    if (index > 0xFFFF || sub > 0xFF || raw > 0xFFFFFFFFU) return bus_refused("restore", "an entry of the dump is out of range");
    const ObjectInfo* object = contract::find_object(info.kind, static_cast<std::uint16_t>(index), static_cast<std::uint8_t>(sub));
    // COB-IDs hold the number of the node that was dumped, and belong to it.
    if (object == nullptr || !is_parameter(*object) || contract::is_node_relative(object->index, object->sub)) continue;
    char hexadecimal[16];
    std::snprintf(hexadecimal, sizeof hexadecimal, "0x%X", static_cast<unsigned>(raw));
    const auto checked = parse_value(*object, hexadecimal, error);
    if (!checked) return bus_refused("restore", error);
    values.emplace_back(object, *checked);
  }
  BusLine line;
  std::optional<Node> node;
  if (const auto end = begin_bus("restore", *request, line, node)) return *end;
  if (error = why_not_write(line, request->force); !error.empty()) return bus_refused("restore", error);
  std::size_t written = 0;
  for (const auto& [object, raw] : values) {
    const auto now = read_object(line, *node, *object);
    if (!now) return bus_refused("restore", object_text(*object) + ": " + line.problem());
    if (*now == raw) continue;
    if (!write_object(line, *node, *object, raw))
      return bus_refused("restore",
                         object_text(*object) + ": " + line.problem() + "; " + std::to_string(written) + " were written before it");
    ++written;
    if (!request->json)
      std::printf("%s: %s -> %s\n", object_text(*object).c_str(), value_text(*object, *now).c_str(), value_text(*object, raw).c_str());
  }
  if (request->json)
    std::printf("%s\n", ordered_json{{"node", info.name}, {"parameters", values.size()}, {"written", written}}.dump().c_str());
  else
    std::printf("%zu parameters, %zu of them were different\n", values.size(), written);
  return kDone;
}

namespace {

int keep(const char* command, std::span<const std::string_view> arguments, std::uint16_t index, std::uint32_t word, const char* done) {
  if (wants_help(arguments))
    return bus_usage(command, "NODE [--force]", stdout, "The node must be pre-operational, a drive also at rest.\n");
  const auto request = parse_bus_request(arguments, 1);
  if (!request) return bus_usage(command, "NODE [--force]", stderr, "The node must be pre-operational, a drive also at rest.\n");
  BusLine line;
  std::optional<Node> node;
  if (const auto end = begin_bus(command, *request, line, node)) return *end;
  if (const std::string why = why_not_write(line, request->force); !why.empty()) return bus_refused(command, why);
  const auto bytes = bytes_of(word);
  if (!line.download(info_of(*node).id, index, 1, bytes)) return bus_refused(command, line.problem());
  if (request->json)
    std::printf("%s\n", ordered_json{{"node", info_of(*node).name}, {"done", command}}.dump().c_str());
  else
    std::printf("%s: %s\n", std::string(info_of(*node).title).c_str(), done);
  return kDone;
}

}  // namespace

int run_bus_save(std::span<const std::string_view> arguments) {
  return keep("save", arguments, 0x1010, canopen::kSave, "all parameters are stored");
}
int run_bus_load_defaults(std::span<const std::string_view> arguments) {
  return keep("load-defaults", arguments, 0x1011, canopen::kLoad, "starts with defaults when it is switched on the next time");
}

int run_bus_emcy(std::span<const std::string_view> arguments) {
  if (wants_help(arguments)) return bus_usage("emcy", "NODE [--clear]", stdout, "The errors that a node remembers, newest first.\n");
  const auto request = parse_bus_request(arguments, 1);
  if (!request) return bus_usage("emcy", "NODE [--clear]", stderr, "The errors that a node remembers, newest first.\n");
  BusLine line;
  std::optional<Node> node;
  if (const auto end = begin_bus("emcy", *request, line, node)) return *end;
  const std::uint8_t id = info_of(*node).id;
  if (!line.upload(id, 0x1001, 0)) return bus_refused("emcy", line.problem());
  const std::uint32_t now = line.client().value();
  if (!line.upload(id, 0x1003, 0)) return bus_refused("emcy", line.problem());
  const std::uint32_t count = line.client().value();
  ordered_json list = ordered_json::array();
  const auto register_words = [](std::uint32_t bits) { return bus::object_words(contract::NodeKind::host, 0x1001, 0, bits); };
  if (!request->json) std::printf("error register %02Xh (%s), %u remembered\n", now, register_words(now).c_str(), count);
  for (std::uint32_t sub = 1; sub <= count; ++sub) {
    if (!line.upload(id, 0x1003, static_cast<std::uint8_t>(sub))) break;  // cleared in between
    const std::uint32_t entry = line.client().value();
    const std::string words = bus::object_words(info_of(*node).kind, 0x1003, 1, entry);
    if (request->json)
      list.push_back({{"code", entry & 0xFFFFU}, {"words", words}, {"error_register", (entry >> 16) & 0xFFU}});
    else
      std::printf("%2u  %04Xh  %s  (error register then: %s)\n", sub, entry & 0xFFFFU, words.c_str(),
                  register_words((entry >> 16) & 0xFFU).c_str());
  }
  if (request->json) std::printf("%s\n", ordered_json{{"error_register", now}, {"errors", list}}.dump(1).c_str());
  if (!request->clear) return kDone;
  constexpr std::array<std::uint8_t, 1> kZero = {0};
  return line.download(id, 0x1003, 0, kZero) ? kDone : bus_refused("emcy", line.problem());
}

}  // namespace hoist::tool
