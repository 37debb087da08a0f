// The bus for other people's tools: one DBC for every frame, one EDS per node.
// Node numbers are written out in the EDS: some readers (npm `canopen` among them) do not work out `$NODEID+...`.
#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/firmware_image.hpp"
#include "deploy/tools/gen/generate.hpp"

namespace hoist::gen {
namespace {

using namespace hoist::contract;

bool is_signed(ObjectType type) { return type == ObjectType::i8 || type == ObjectType::i16 || type == ObjectType::i32; }

constexpr std::string_view kHostName = "core";

// ---- DBC ----

struct DbcSignal {
  std::string name;
  std::size_t start_bit;
  std::size_t bits;
  bool is_signed;
  double scale;
  std::string unit;
};
struct DbcMessage {
  std::uint32_t id;
  std::string name;
  std::size_t bytes;
  std::string sender;
  std::string receivers;
  std::vector<DbcSignal> signals;
  std::string comment;
  int cycle_ms;  // 0 = not cyclic
};

// Everything the table says about process data, and the CANopen services with their fixed layouts (CiA 301).
std::vector<DbcMessage> dbc_messages() {
  std::vector<DbcMessage> messages;
  std::string all_but_core;
  for (const auto& node : kNodes) {
    if (node.name != kHostName) all_but_core += (all_but_core.empty() ? "" : ",") + std::string(node.name);
  }
  const std::string core(kHostName);
  messages.push_back({canopen::kNmt,
                      "nmt",
                      2,
                      core,
                      all_but_core,
                      {{"command", 0, 8, false, 1, ""}, {"node", 8, 8, false, 1, ""}},
                      "Network management: command and node, 0 = all",
                      0});
  messages.push_back({canopen::kSync, "sync", 0, core, all_but_core, {}, "Start of a control cycle", 10});
  for (const auto& node : kNodes) {
    const std::string name(node.name);
    messages.push_back({canopen::kHeartbeatBase + node.id,
                        name + "_heartbeat",
                        1,
                        name,
                        name == core ? all_but_core : core,
                        {{"state", 0, 8, false, 1, ""}},
                        "Node state",
                        100});
    if (name == core) continue;
    messages.push_back({canopen::kEmcyBase + node.id,
                        name + "_emergency",
                        8,
                        name,
                        core,
                        {{"code", 0, 16, false, 1, ""}, {"error_register", 16, 8, false, 1, ""}, {"details", 24, 40, false, 1, ""}},
                        "Emergency: error code, error register, maker's details",
                        0});
    const std::vector<DbcSignal> sdo = {
        {"command", 0, 8, false, 1, ""}, {"index", 8, 16, false, 1, ""}, {"sub", 24, 8, false, 1, ""}, {"value", 32, 32, false, 1, ""}};
    messages.push_back({canopen::kSdoRequestBase + node.id, name + "_sdo_request", 8, core, name, sdo, "Reading or writing one object", 0});
    messages.push_back({canopen::kSdoReplyBase + node.id, name + "_sdo_reply", 8, name, core, sdo, "Answer about one object", 0});
  }
  for (const auto& pdo : kPdos) {
    for (const auto& node : kNodes) {
      if (node.kind != pdo.kind) continue;
      const bool sent_by_node = pdo.direction == PdoDirection::tx;
      const std::string name(node.name);
      DbcMessage message{static_cast<std::uint32_t>(pdo.cob_base) + node.id,
                         name + (sent_by_node ? "_tx" : "_rx") + std::to_string(pdo.number),
                         pdo_bytes(pdo.pdo),
                         sent_by_node ? name : core,
                         sent_by_node ? core : name,
                         {},
                         std::string(pdo.title),
                         pdo.period_ms};
      std::size_t bit = 0;
      for (const auto& entry : kPdoEntries) {
        if (entry.pdo != pdo.pdo) continue;
        const auto& object = *find_object(pdo.kind, entry.index, entry.sub);
        const std::size_t bits = 8 * object_bytes(object.type);
        message.signals.push_back({std::string(object.name), bit, bits, is_signed(object.type), object.scale, std::string(object.unit)});
        bit += bits;
      }
      messages.push_back(std::move(message));
    }
  }
  std::sort(messages.begin(), messages.end(), [](const DbcMessage& a, const DbcMessage& b) { return a.id < b.id; });
  return messages;
}

std::string dbc_text() {
  const auto messages = dbc_messages();
  std::string out = "VERSION \"" + made_from("control/contract/can_dictionary.def") + "\"\n\nNS_ :\n\nBS_:\n\nBU_:";
  for (const auto& node : kNodes) out += " " + std::string(node.name);
  out += "\n\n";
  for (const auto& message : messages) {
    out += "BO_ " + std::to_string(message.id) + " " + message.name + ": " + std::to_string(message.bytes) + " " + message.sender + "\n";
    for (const auto& signal : message.signals) {
      const double steps = static_cast<double>(std::uint64_t{1} << (signal.bits - (signal.is_signed ? 1U : 0U)));
      out += " SG_ " + signal.name + " : " + std::to_string(signal.start_bit) + "|" + std::to_string(signal.bits) + "@1" +
             (signal.is_signed ? "-" : "+") + " (" + number_text(signal.scale) + ",0) [" +
             number_text(signal.is_signed ? -steps * signal.scale : 0.0) + "|" + number_text((steps - 1.0) * signal.scale) + "] \"" +
             signal.unit + "\" " + message.receivers + "\n";
    }
    out += "\n";
  }
  for (const auto& node : kNodes)
    out += "CM_ BU_ " + std::string(node.name) + " \"" + std::string(node.title) + ", node " + std::to_string(node.id) + "\";\n";
  for (const auto& message : messages) out += "CM_ BO_ " + std::to_string(message.id) + " \"" + message.comment + "\";\n";
  out += "BA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 65535;\nBA_DEF_DEF_ \"GenMsgCycleTime\" 0;\n";
  for (const auto& message : messages) {
    if (message.cycle_ms > 0)
      out += "BA_ \"GenMsgCycleTime\" BO_ " + std::to_string(message.id) + " " + std::to_string(message.cycle_ms) + ";\n";
  }
  // In descending order, as the format demands.
  for (const auto& node : kNodes) {
    out += "VAL_ " + std::to_string(canopen::kHeartbeatBase + node.id) +
           " state 127 \"pre-operational\" 5 \"operational\" 4 \"stopped\" 0 \"boot-up\" ;\n";
  }
  out += "VAL_ 0 command 130 \"reset communication\" 129 \"reset node\" 128 \"enter pre-operational\" 2 \"stop\" 1 \"start\" ;\n";
  return out;
}

// ---- EDS ----

struct EdsEntry {
  std::string title;
  std::optional<ObjectType> type;  // none = a text
  std::string access;
  std::string default_value;  // empty = not given
  std::string low, high;      // empty = the full range of the type
  bool mappable;
};
// (index, sub) in order.
using EdsObjects = std::map<std::pair<unsigned, unsigned>, EdsEntry>;

int data_type_code(std::optional<ObjectType> type) {
  if (!type) return 9;
  switch (*type) {  // CiA 301, table of static data types
    case ObjectType::i8:
      return 2;
    case ObjectType::i16:
      return 3;
    case ObjectType::i32:
      return 4;
    case ObjectType::u8:
      return 5;
    case ObjectType::u16:
      return 6;
    case ObjectType::u32:
      return 7;
    case ObjectType::f32:
      break;
  }
  return 8;
}

EdsObjects eds_objects(const NodeInfo& node) {
  EdsObjects objects;
  for (const auto& text : kTexts) objects[{text.index, 0}] = {std::string(text.title), std::nullopt, "const", "", "", "", false};
  for (const auto& object : kObjects) {
    if (!object_applies(object, node.kind)) continue;
    const bool mapped = std::any_of(kPdoEntries.begin(), kPdoEntries.end(), [&](const PdoEntry& e) {
      return pdo_info(e.pdo).kind == node.kind && e.index == object.index && e.sub == object.sub;
    });
    EdsEntry entry{std::string(object.title),
                   object.type,
                   object.access == Access::rw ? "rw" : "ro",
                   number_text(object.default_value),
                   number_text(object.min),
                   number_text(object.max),
                   mapped};
    const bool mapping = (object.index >= 0x1600 && object.index < 0x1800) || (object.index >= 0x1A00 && object.index < 0x1C00);
    if (mapping) entry.access = "const";
    // A process input: written by an RPDO, and whether an SDO may write it is up to the node's state.
    if (mapped && object.access == Access::rw) entry.access = "rww";
    // Identifiers and what they map are read in hexadecimal; the limits of an identifier are rules, not numbers.
    if (mapping || is_node_relative(object.index, object.sub)) {
      entry.default_value = hex_text(static_cast<unsigned>(object_default(object, *find_node(node.id))), mapping ? 8 : 3);
      entry.low.clear();
      entry.high.clear();
    }
    if (object.index == 0x1000 || object.index == 0x1018)
      entry.default_value = hex_text(static_cast<unsigned>(object_default(object, *find_node(node.id))), 8);
    // A value of the individual board or program: no common default exists.
    if ((object.index == 0x1018 && object.sub == 4) || object.index == kProgramId || object.index == kProgramVersion)
      entry.default_value.clear();
    objects[{object.index, object.sub}] = entry;
  }
  return objects;
}

std::string eds_entry(const std::string& section, const EdsEntry& entry) {
  std::string out = "[" + section + "]\nParameterName=" + entry.title +
                    "\nObjectType=0x7\nDataType=" + hex_text(static_cast<unsigned>(data_type_code(entry.type)), 4) +
                    "\nAccessType=" + entry.access + "\n";
  if (!entry.low.empty()) out += "LowLimit=" + entry.low + "\nHighLimit=" + entry.high + "\n";
  if (!entry.default_value.empty()) out += "DefaultValue=" + entry.default_value + "\n";
  return out + "PDOMapping=" + (entry.mappable ? "1" : "0") + "\n\n";
}

std::string record_title(unsigned index) {
  if (index == 0x1003) return "Pre-defined error field";
  if (index == 0x1010) return "Store parameters";
  if (index == 0x1011) return "Restore default parameters";
  if (index == 0x1016) return "Consumer heartbeat time";
  if (index == 0x1018) return "Identity object";
  if (index == 0x1029) return "Error behaviour";
  if (index == 0x1200) return "SDO server parameter";
  if (index >= 0x1400 && index < 0x1600) return "RPDO communication parameter";
  if (index >= 0x1600 && index < 0x1800) return "RPDO mapping parameter";
  if (index >= 0x1800 && index < 0x1A00) return "TPDO communication parameter";
  if (index >= 0x1A00 && index < 0x1C00) return "TPDO mapping parameter";
  return "Record " + hex_text(index, 4).substr(2) + "h";
}

std::string object_list(std::string_view name, const std::vector<unsigned>& indices) {
  std::string out = "[" + std::string(name) + "]\nSupportedObjects=" + std::to_string(indices.size()) + "\n";
  for (std::size_t i = 0; i < indices.size(); ++i) out += std::to_string(i + 1) + "=" + hex_text(indices[i], 4) + "\n";
  return out + "\n";
}

std::string eds_text(const NodeInfo& node) {
  const auto objects = eds_objects(node);
  const auto count = [&](PdoDirection direction) {
    return std::to_string(
        std::count_if(kPdos.begin(), kPdos.end(), [&](const PdoInfo& pdo) { return pdo.kind == node.kind && pdo.direction == direction; }));
  };
  const std::string file_name = std::string(node.name) + ".gen.eds";
  std::string out =
      "; " + made_from("control/contract/can_dictionary.def") + "\n[FileInfo]\nFileName=" + file_name +
      "\nFileVersion=1\nFileRevision=0\nEDSVersion=4.0\nDescription=" + std::string(node.title) + ", node " + std::to_string(node.id) +
      "\nCreationTime=12:00AM\nCreationDate=11-21-2026\nCreatedBy=hoist-gen\nModificationTime=12:00AM\nModificationDate=11-21-"
      "2026\nModifiedBy=hoist-gen\n\n"
      "[DeviceInfo]\nVendorName=Hoist\nVendorNumber=0\nProductName=" +
      std::string(node.title) + "\nProductNumber=" + hex_text(product_code(node.kind), 8) +
      "\nRevisionNumber=" + hex_text(static_cast<unsigned>(find_object(node.kind, 0x1018, 3)->default_value), 8) +
      "\n"
      "BaudRate_10=0\nBaudRate_20=0\nBaudRate_50=0\nBaudRate_125=0\nBaudRate_250=1\nBaudRate_500=0\nBaudRate_800=0\nBaudRate_1000=0\n"
      "SimpleBootUpMaster=0\nSimpleBootUpSlave=1\nGranularity=0\nDynamicChannelsSupported=0\nGroupMessaging=0\nNrOfRXPDO=" +
      count(PdoDirection::rx) + "\nNrOfTXPDO=" + count(PdoDirection::tx) +
      "\nLSS_Supported=0\n\n"
      "[DummyUsage]\nDummy0001=0\nDummy0002=0\nDummy0003=0\nDummy0004=0\nDummy0005=0\nDummy0006=0\nDummy0007=0\n\n"
      "[Comments]\nLines=2\nLine1=Process data map what they map; their identifiers and types may be set before the node is started."
      "\nLine2=This file is for node " +
      std::to_string(node.id) + " only.\n\n";
  std::vector<unsigned> mandatory, optional, manufacturer;
  for (const auto& [address, entry] : objects) {
    const unsigned index = address.first;
    auto& list = index == 0x1000 || index == 0x1001 || index == 0x1018 ? mandatory
                 : index >= 0x2000 && index < 0x6000                   ? manufacturer
                                                                       : optional;
    if (list.empty() || list.back() != index) list.push_back(index);
  }
  out += object_list("MandatoryObjects", mandatory) + object_list("OptionalObjects", optional) +
         object_list("ManufacturerObjects", manufacturer);
  for (auto at = objects.begin(); at != objects.end();) {
    const unsigned index = at->first.first;
    const std::string section = hex_text(index, 4).substr(2);
    const auto next = std::next(at);
    if (at->first.second == 0 && (next == objects.end() || next->first.first != index)) {
      out += eds_entry(section, at->second);
      ++at;
      continue;
    }
    auto end = at;
    unsigned members = 0;
    unsigned highest = 0;
    for (; end != objects.end() && end->first.first == index; ++end) {
      ++members;
      highest = end->first.second;
    }
    char sub[24];
    // Sub-index 0 follows from the others, unless it is an object of its own (1003h).
    const bool counted = at->first.second != 0;
    out += "[" + section + "]\nParameterName=" + record_title(index) +
           "\nObjectType=0x9\nSubNumber=" + hex_text(members + (counted ? 1 : 0), 1) + "\n\n";
    if (counted)
      out += eds_entry(section + "sub0", {"Highest sub-index supported", ObjectType::u8, "const", std::to_string(highest), "", "", false});
    for (; at != end; ++at) {
      std::snprintf(sub, sizeof sub, "sub%X", at->first.second);
      out += eds_entry(section + sub, at->second);
    }
  }
  out.pop_back();
  return out;
}

}  // namespace

GeneratedFile dbc_file() { return {"control/contract/hoist.gen.dbc", dbc_text()}; }

std::vector<GeneratedFile> eds_files() {
  std::vector<GeneratedFile> files;
  for (const auto& node : kNodes) {
    if (node.kind != NodeKind::host) files.push_back({"firmware/nodes/eds/" + std::string(node.name) + ".gen.eds", eds_text(node)});
  }
  return files;
}

}  // namespace hoist::gen
