// Typed view of can_dictionary.def, and the wire format of the CANopen services that nodes and core share.
// Encode and decode of process data are compiled from the same rows on both sides of the wire.
#pragma once
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>

#include "control/contract/can_frame.hpp"
#include "control/contract/check.hpp"
#include "control/contract/params.hpp"

namespace hoist::contract {

#define HOIST_NODE(...)
#define HOIST_OBJECT(...)
#define HOIST_PDO(...)
#define HOIST_PDO_ENTRY(...)
#define HOIST_PDO_OFF(...)
#define HOIST_PDO_ON_CHANGE(...)
#define HOIST_KEPT(...)
#define HOIST_TEXT(...)

enum class Node : std::uint8_t {
#undef HOIST_NODE
#define HOIST_NODE(name, id, kind, title) name,
#include "control/contract/can_dictionary.def"
#undef HOIST_NODE
#define HOIST_NODE(...)
};
struct NodeInfo {
  std::string_view name;
  std::uint8_t id;
  NodeKind kind;
  std::string_view title;
};
inline constexpr std::array kNodes{
#undef HOIST_NODE
#define HOIST_NODE(name, id, kind, title) NodeInfo{#name, id, NodeKind::kind, title},
#include "control/contract/can_dictionary.def"
#undef HOIST_NODE
#define HOIST_NODE(...)
};
constexpr std::uint8_t node_id(Node node) { return kNodes[static_cast<std::size_t>(node)].id; }
constexpr std::optional<Node> find_node(std::uint8_t id) {
  for (std::size_t i = 0; i < kNodes.size(); ++i)
    if (kNodes[i].id == id) return static_cast<Node>(i);
  return std::nullopt;
}
inline constexpr std::size_t kRemoteNodeCount = kNodes.size() - 1;  // all but the core itself, which is the last row

enum class ObjectType : std::uint8_t { u8, i8, u16, i16, u32, i32, f32 };
enum class Access : std::uint8_t { ro, rw };
constexpr std::size_t object_bytes(ObjectType type) {
  switch (type) {
    case ObjectType::u8:
    case ObjectType::i8:
      return 1;
    case ObjectType::u16:
    case ObjectType::i16:
      return 2;
    default:
      return 4;
  }
}
enum class ObjectOwner : std::uint8_t { tilt, drive, io, host, all };  // the first four in the order of NodeKind
enum class Pdo : std::uint8_t {
#undef HOIST_PDO
#define HOIST_PDO(name, ...) name,
#include "control/contract/can_dictionary.def"
#undef HOIST_PDO
#define HOIST_PDO(...)
};
enum class PdoDirection : std::uint8_t { tx, rx };
struct PdoInfo {
  Pdo pdo;
  std::string_view name;
  NodeKind kind;
  PdoDirection direction;
  std::uint8_t number;
  std::uint16_t cob_base;
  std::uint8_t type;
  std::uint16_t period_ms;
  std::string_view title;
};
inline constexpr std::array kPdos{
#undef HOIST_PDO
#define HOIST_PDO(name, kind, dir, number, base, type, period, title) \
  PdoInfo{Pdo::name, #name, NodeKind::kind, PdoDirection::dir, number, base, type, period, title},
#include "control/contract/can_dictionary.def"
#undef HOIST_PDO
#define HOIST_PDO(...)
};
struct PdoEntry {
  Pdo pdo;
  std::uint16_t index;
  std::uint8_t sub;
};
inline constexpr std::array kPdoEntries{
#undef HOIST_PDO_ENTRY
#define HOIST_PDO_ENTRY(pdo, index, sub) PdoEntry{Pdo::pdo, index, sub},
#include "control/contract/can_dictionary.def"
#undef HOIST_PDO_ENTRY
#define HOIST_PDO_ENTRY(...)
};
constexpr const PdoInfo& pdo_info(Pdo pdo) { return kPdos[static_cast<std::size_t>(pdo)]; }

struct PdoOff {
  Pdo pdo;
  Node node;
};
inline constexpr std::array kPdosOff{
#undef HOIST_PDO_OFF
#define HOIST_PDO_OFF(pdo, node) PdoOff{Pdo::pdo, Node::node},
#include "control/contract/can_dictionary.def"
#undef HOIST_PDO_OFF
#define HOIST_PDO_OFF(...)
};
// Whether a node sends or takes a PDO by default.
constexpr bool pdo_on_by_default(Pdo pdo, Node node) {
  for (const PdoOff& off : kPdosOff)
    if (off.pdo == pdo && off.node == node) return false;
  return true;
}

struct PdoOnChange {
  Pdo pdo;
  std::uint16_t inhibit_100us;
};
inline constexpr std::array kPdosOnChange{
#undef HOIST_PDO_ON_CHANGE
#define HOIST_PDO_ON_CHANGE(pdo, inhibit) PdoOnChange{Pdo::pdo, inhibit},
#include "control/contract/can_dictionary.def"
#undef HOIST_PDO_ON_CHANGE
#define HOIST_PDO_ON_CHANGE(...)
};
// Minimum interval of a PDO that is sent on change; 0 for one that only its timer or the SYNC sends.
constexpr std::uint16_t pdo_on_change_100us(Pdo pdo) {
  for (const PdoOnChange& row : kPdosOnChange)
    if (row.pdo == pdo) return row.inhibit_100us;
  return 0;
}

struct TextInfo {
  std::uint16_t index;
  std::string_view name, title;
};
inline constexpr std::array kTexts{
#undef HOIST_TEXT
#define HOIST_TEXT(index, name, title) TextInfo{index, #name, title},
#include "control/contract/can_dictionary.def"
#undef HOIST_TEXT
#define HOIST_TEXT(...)
};

struct ObjectInfo {
  ObjectOwner owner;
  std::uint16_t index;
  std::uint8_t sub;
  std::string_view name;
  ObjectType type;
  Access access;
  double default_value, min, max;
  std::string_view unit;
  double scale;
  std::string_view title;
};
// The rows as they are written; kObjects below has those that follow from the PDOs, too.
inline constexpr std::array kTableObjects{
#undef HOIST_OBJECT
#define HOIST_OBJECT(kind, index, sub, name, type, access, def, lo, hi, unit, scale, title) \
  ObjectInfo{ObjectOwner::kind,                                                             \
             index,                                                                         \
             sub,                                                                           \
             #name,                                                                         \
             ObjectType::type,                                                              \
             Access::access,                                                                \
             static_cast<double>(def),                                                      \
             static_cast<double>(lo),                                                       \
             static_cast<double>(hi),                                                       \
             unit,                                                                          \
             static_cast<double>(scale),                                                    \
             title},
#include "control/contract/can_dictionary.def"
#undef HOIST_OBJECT
#define HOIST_OBJECT(...)
};

// CiA 301: where the records of a PDO are.
constexpr std::uint16_t pdo_communication_index(const PdoInfo& pdo) {
  return static_cast<std::uint16_t>((pdo.direction == PdoDirection::rx ? 0x1400 : 0x1800) + pdo.number - 1);
}
constexpr std::uint16_t pdo_mapping_index(const PdoInfo& pdo) {
  return static_cast<std::uint16_t>((pdo.direction == PdoDirection::rx ? 0x1600 : 0x1A00) + pdo.number - 1);
}
inline constexpr std::uint32_t kPdoOffBit = 0x80000000U;       // of a PDO's COB-ID: it does not exist
inline constexpr std::uint32_t kPdoNoRemoteBit = 0x40000000U;  // of a TPDO's COB-ID: not to be asked for by remote frames

namespace detail {
struct PdoTexts {
  std::string_view id_name, id_title, type_name, type_title, inhibit_name, inhibit_title, event_name, event_title;
};
inline constexpr std::array kPdoTexts{
#undef HOIST_PDO
#define HOIST_PDO(name, kind, dir, number, base, type, period, title)                                           \
  PdoTexts{#name "_cob_id",  title ": COB-ID, bit 31 = off", #name "_type",        title ": transmission type", \
           #name "_inhibit", title ": inhibit time",         #name "_event_timer", title ": event timer"},
#include "control/contract/can_dictionary.def"
#undef HOIST_PDO
#define HOIST_PDO(...)
};
struct EntryTexts {
  std::string_view name, title;
};
inline constexpr std::array kEntryTexts{
#undef HOIST_PDO_ENTRY
#define HOIST_PDO_ENTRY(pdo, index, sub) EntryTexts{#pdo "_maps_" #index "_" #sub, "Mapped: " #index ":" #sub " in " #pdo},
#include "control/contract/can_dictionary.def"
#undef HOIST_PDO_ENTRY
#define HOIST_PDO_ENTRY(...)
};
constexpr std::size_t derived_count() {
  std::size_t count = kPdoEntries.size();
  for (const PdoInfo& p : kPdos) count += p.direction == PdoDirection::tx ? 4U : 2U;
  return count;
}
constexpr ObjectType table_type(NodeKind kind, std::uint16_t index, std::uint8_t sub) {
  for (const ObjectInfo& o : kTableObjects)
    if (o.index == index && o.sub == sub && (o.owner == ObjectOwner::all || static_cast<int>(o.owner) == static_cast<int>(kind)))
      return o.type;
  return ObjectType::u8;  // a mapping without an object is refused by a check at the end of this file
}
consteval auto all_objects() {
  std::array<ObjectInfo, kTableObjects.size() + derived_count()> all{};
  std::size_t at = 0;
  for (const ObjectInfo& o : kTableObjects) all[at++] = o;
  for (std::size_t i = 0; i < kPdos.size(); ++i) {
    const PdoInfo& p = kPdos[i];
    const PdoTexts& texts = kPdoTexts[i];
    const ObjectOwner owner = static_cast<ObjectOwner>(p.kind);
    const std::uint16_t index = pdo_communication_index(p);
    const bool timed = p.type > 240;
    // No node answers remote frames; CiA 301 wants that said in bit 30 of what it sends. In an RPDO's COB-ID the bit means nothing.
    const std::uint32_t cob_id = p.cob_base | (p.direction == PdoDirection::tx ? kPdoNoRemoteBit : 0U);
    all[at++] = {owner,        index, 1, texts.id_name, ObjectType::u32, Access::rw, static_cast<double>(cob_id), 0x180,
                 4294967295.0, "",    1, texts.id_title};
    all[at++] = {owner, index, 2, texts.type_name, ObjectType::u8, Access::rw, static_cast<double>(p.type), 0,
                 255,   "",    1, texts.type_title};
    if (p.direction == PdoDirection::rx) continue;
    all[at++] = {owner, index, 3,   texts.inhibit_name, ObjectType::u16, Access::rw, static_cast<double>(pdo_on_change_100us(p.pdo)), 0,
                 65535, "ms",  0.1, texts.inhibit_title};
    all[at++] = {owner, index, 5, texts.event_name, ObjectType::u16, Access::rw, timed ? static_cast<double>(p.period_ms) : 0.0, 0,
                 65535, "ms",  1, texts.event_title};
  }
  for (const PdoInfo& p : kPdos) {
    std::uint8_t sub = 0;
    for (std::size_t e = 0; e < kPdoEntries.size(); ++e) {
      const PdoEntry& entry = kPdoEntries[e];
      if (entry.pdo != p.pdo) continue;
      const std::uint32_t value = (static_cast<std::uint32_t>(entry.index) << 16) | (static_cast<std::uint32_t>(entry.sub) << 8) |
                                  static_cast<std::uint32_t>(8 * object_bytes(table_type(p.kind, entry.index, entry.sub)));
      all[at++] = {static_cast<ObjectOwner>(p.kind),
                   pdo_mapping_index(p),
                   ++sub,
                   kEntryTexts[e].name,
                   ObjectType::u32,
                   Access::ro,
                   static_cast<double>(value),
                   0,
                   4294967295.0,
                   "",
                   1,
                   kEntryTexts[e].title};
    }
  }
  return all;
}
}  // namespace detail

// Every object of every kind: the rows of the table and the PDOs' records.
inline constexpr auto kObjects = detail::all_objects();

constexpr bool object_applies(const ObjectInfo& object, NodeKind kind) {
  return object.owner == ObjectOwner::all || static_cast<int>(object.owner) == static_cast<int>(kind);
}
// Row of an object in kObjects, or kObjects.size() when this kind of node has none. As a number, because comparing addresses of table
// rows is no constant expression under the undefined-behaviour sanitizer of g++ 12.
constexpr std::size_t object_row(NodeKind kind, std::uint16_t index, std::uint8_t sub) {
  for (std::size_t i = 0; i < kObjects.size(); ++i)
    if (kObjects[i].index == index && kObjects[i].sub == sub && object_applies(kObjects[i], kind)) return i;
  return kObjects.size();
}
// Device type 1000h of a kind: CiA 410 with two axes; CiA 402, servo; CiA 401 with digital inputs, digital outputs, analogue inputs.
constexpr std::uint32_t device_type(NodeKind kind) {
  return kind == NodeKind::tilt ? 0x0002019AU : kind == NodeKind::drive ? 0x00020192U : 0x00070191U;
}
// Product code 1018h:2 of a kind, without the bits of simulator and loader: 1 tilt, 2 drive, 3 input board.
constexpr std::uint32_t product_code(NodeKind kind) { return static_cast<std::uint32_t>(kind) + 1; }

// Whether the default of an object is meant "plus node id" (COB-IDs of the predefined connection set).
constexpr bool is_node_relative(std::uint16_t index, std::uint8_t sub) {
  return index == 0x1014 || (index == 0x1200 && (sub == 1 || sub == 2)) ||
         (sub == 1 && ((index >= 0x1400 && index < 0x1600) || (index >= 0x1800 && index < 0x1A00)));
}
// The default of an object in a given node.
constexpr double object_default(const ObjectInfo& object, Node node) {
  const NodeKind kind = kNodes[static_cast<std::size_t>(node)].kind;
  if (object.index == 0x1000) return device_type(kind);
  if (object.index == 0x1018 && object.sub == 2) return product_code(kind);
  if (!is_node_relative(object.index, object.sub)) return object.default_value;
  double value = object.default_value + node_id(node);
  for (const PdoOff& off : kPdosOff)
    if (off.node == node && object.sub == 1 && object.index == pdo_communication_index(pdo_info(off.pdo))) value += kPdoOffBit;
  return value;
}
// Parameters are what may be written and is kept by 1010h: not commands (1003h, 1010h, 1011h, program control 1F50h and up) and not process
// inputs, which are the objects of RPDOs.
constexpr bool is_stored(const ObjectInfo& object) {
  if (object.access != Access::rw || object.index == 0x1003 || object.index == 0x1010 || object.index == 0x1011 ||
      (object.index >= 0x1F50 && object.index < 0x1F60))
    return false;
  for (const PdoEntry& e : kPdoEntries)
    if (pdo_info(e.pdo).direction == PdoDirection::rx && static_cast<int>(pdo_info(e.pdo).kind) == static_cast<int>(object.owner) &&
        e.index == object.index && e.sub == object.sub)
      return false;
  return true;
}
constexpr const ObjectInfo* find_object(NodeKind kind, std::uint16_t index, std::uint8_t sub) {
  const std::size_t row = object_row(kind, index, sub);
  return row < kObjects.size() ? &kObjects[row] : nullptr;
}

// Objects that hold their default in every node that the core has started.
inline constexpr std::array kKeptObjects{
#undef HOIST_KEPT
#define HOIST_KEPT(kind, index, sub) find_object(NodeKind::kind, index, sub),
#include "control/contract/can_dictionary.def"
#undef HOIST_KEPT
};

#undef HOIST_NODE
#undef HOIST_OBJECT
#undef HOIST_PDO
#undef HOIST_PDO_ENTRY
#undef HOIST_PDO_OFF
#undef HOIST_PDO_ON_CHANGE
#undef HOIST_TEXT

// Sums and look-ups over the tables are done by the compiler once; asking at run time is one load.
inline constexpr auto kPdoBytes = [] {
  std::array<std::uint8_t, kPdos.size()> bytes{};
  for (const PdoEntry& e : kPdoEntries)
    bytes[static_cast<std::size_t>(e.pdo)] = static_cast<std::uint8_t>(
        bytes[static_cast<std::size_t>(e.pdo)] + object_bytes(kObjects[object_row(pdo_info(e.pdo).kind, e.index, e.sub)].type));
  return bytes;
}();
constexpr std::size_t pdo_bytes(Pdo pdo) { return kPdoBytes[static_cast<std::size_t>(pdo)]; }
constexpr std::uint32_t pdo_cob_id(Pdo pdo, Node node) { return static_cast<std::uint32_t>(pdo_info(pdo).cob_base) + node_id(node); }

// Where one object lies inside one PDO; the compiler refuses an object that is not mapped there.
struct PdoSlot {
  std::size_t offset;
  ObjectType type;
  double scale;
};
// Declared only: a call during compilation is the error message. No throw, which the firmware's compiler options refuse.
void this_object_is_not_mapped_in_this_pdo();
consteval PdoSlot pdo_slot(Pdo pdo, std::uint16_t index, std::uint8_t sub = 0) {
  std::size_t offset = 0;
  for (const PdoEntry& e : kPdoEntries) {
    if (e.pdo != pdo) continue;
    const ObjectInfo& o = kObjects[object_row(pdo_info(pdo).kind, e.index, e.sub)];
    if (e.index == index && e.sub == sub) return PdoSlot{offset, o.type, o.scale};
    offset += object_bytes(o.type);
  }
  this_object_is_not_mapped_in_this_pdo();
  return {};
}

constexpr std::uint32_t read_le(const std::uint8_t* at, std::size_t bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value |= static_cast<std::uint32_t>(at[i]) << (8 * i);
  return value;
}
constexpr void write_le(std::uint8_t* at, std::size_t bytes, std::uint32_t value) {
  for (std::size_t i = 0; i < bytes; ++i) at[i] = static_cast<std::uint8_t>(value >> (8 * i));
}
// The raw word of a value of the table. Types below 32 bits are zero extended, so that two equal values have equal words.
constexpr std::uint32_t raw_word(ObjectType type, double value) {
  switch (type) {
    case ObjectType::f32:
      return std::bit_cast<std::uint32_t>(static_cast<float>(value));
    case ObjectType::i8:
      return static_cast<std::uint8_t>(static_cast<std::int8_t>(value));
    case ObjectType::i16:
      return static_cast<std::uint16_t>(static_cast<std::int16_t>(value));
    case ObjectType::i32:
      return static_cast<std::uint32_t>(static_cast<std::int32_t>(value));
    default:
      return static_cast<std::uint32_t>(value);
  }
}
// The word that travels for a parameter's value, and back: rounded where its object is an integer.
constexpr std::uint32_t param_word(const ParamObject& object, double value) {
  if (kObjects[object_row(object.kind, object.index, object.sub)].type == ObjectType::f32)
    return std::bit_cast<std::uint32_t>(static_cast<float>(value));
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(value < 0 ? value - 0.5 : value + 0.5));
}
constexpr double param_value(const ParamObject& object, std::uint32_t word) {
  switch (kObjects[object_row(object.kind, object.index, object.sub)].type) {
    case ObjectType::f32:
      return static_cast<double>(std::bit_cast<float>(word));
    case ObjectType::i32:
      return static_cast<std::int32_t>(word);
    default:
      return word;
  }
}

// The raw integer of a slot, sign extended.
constexpr std::int64_t read_slot(const CanFrame& frame, PdoSlot slot) {
  const std::uint32_t raw = read_le(frame.data.data() + slot.offset, object_bytes(slot.type));
  switch (slot.type) {
    case ObjectType::i8:
      return static_cast<std::int8_t>(raw);
    case ObjectType::i16:
      return static_cast<std::int16_t>(raw);
    case ObjectType::i32:
      return static_cast<std::int32_t>(raw);
    default:
      return raw;
  }
}
constexpr void write_slot(CanFrame& frame, PdoSlot slot, std::int64_t value) {
  write_le(frame.data.data() + slot.offset, object_bytes(slot.type), static_cast<std::uint32_t>(value));
}

// Fixed identifiers and bytes of CiA 301.
namespace canopen {
inline constexpr std::uint32_t kNmt = 0x000, kSync = 0x080, kEmcyBase = 0x080, kSdoReplyBase = 0x580, kSdoRequestBase = 0x600,
                               kHeartbeatBase = 0x700;
// The computer's own heartbeat. Drives wait 250 ms for it, so four of five may be lost before a drive stops.
inline constexpr std::uint32_t kCoreHeartbeat_ms = 50;
enum class NmtCommand : std::uint8_t { start = 1, stop = 2, pre_operational = 128, reset_node = 129, reset_communication = 130 };
enum class NmtState : std::uint8_t { boot_up = 0, stopped = 4, operational = 5, pre_operational = 127 };
enum class SdoAbort : std::uint32_t {
  none = 0,
  toggle = 0x05030000,
  time_out = 0x05040000,
  command = 0x05040001,
  no_memory = 0x05040005,
  write_only = 0x06010001,
  read_only = 0x06010002,
  no_object = 0x06020000,
  hardware = 0x06060000,
  length = 0x06070010,
  too_long = 0x06070012,
  too_short = 0x06070013,
  no_sub = 0x06090011,
  range = 0x06090030,
  too_high = 0x06090031,
  too_low = 0x06090032,
  transfer = 0x08000020,
  local_control = 0x08000021,
  device_state = 0x08000022,
  no_data = 0x08000024,
};
inline constexpr std::uint32_t kSave = 0x65766173, kLoad = 0x64616F6C;  // written to 1010h and 1011h: "save" and "load" in ASCII
inline constexpr std::uint32_t kSimulatedProduct = 0x80000000U;         // bit of 1018h:2 set by builds for a simulator

constexpr CanFrame nmt(NmtCommand command, std::uint8_t node) {
  CanFrame f{kNmt, 2, 0, {}};
  f.data[0] = static_cast<std::uint8_t>(command);
  f.data[1] = node;
  return f;
}
/// Bit of the input node's outputs (6200h:1) that feeds the relay in the motors' supply by changing (control/core/output/relay_feed.hpp).
inline constexpr std::uint8_t kRelayFeed = 0x01;
/// Bit of the same outputs that opens that relay at once, by its level.
inline constexpr std::uint8_t kRelayRelease = 0x02;
/// Bit of the same outputs with the pulses for other recording systems (control/core/output/sync_pulses.hpp).
inline constexpr std::uint8_t kSyncOutput = 0x04;
/// Bits of the outputs that the input node itself switches, by the alarm that it is told (2400h:1): buzzer and lights.
inline constexpr std::uint8_t kBuzzer = 0x08, kRedLight = 0x10, kYellowLight = 0x20, kCyanLight = 0x40;
/// Bit of the input node's switches (6000h:2) that another recording system sets, such as its "recording" line.
inline constexpr std::uint8_t kSyncInput = 0x04;

constexpr CanFrame sync() { return CanFrame{kSync, 0, 0, {}}; }
constexpr CanFrame heartbeat(std::uint8_t node, NmtState state) {
  CanFrame f{kHeartbeatBase + node, 1, 0, {}};
  f.data[0] = static_cast<std::uint8_t>(state);
  return f;
}
// Expedited download of 1, 2 or 4 bytes; upload request; abort. Reply side is built by the node with the same helpers.
constexpr CanFrame sdo(std::uint32_t cob_id, std::uint8_t command, std::uint16_t index, std::uint8_t sub, std::uint32_t value) {
  CanFrame f{cob_id, 8, 0, {}};
  f.data[0] = command;
  write_le(&f.data[1], 2, index);
  f.data[3] = sub;
  write_le(&f.data[4], 4, value);
  return f;
}
constexpr std::uint8_t sdo_download_command(std::size_t bytes) { return static_cast<std::uint8_t>(0x23 | ((4 - bytes) << 2)); }
constexpr std::uint8_t sdo_upload_reply_command(std::size_t bytes) { return static_cast<std::uint8_t>(0x43 | ((4 - bytes) << 2)); }
inline constexpr std::uint8_t kSdoUploadRequest = 0x40, kSdoDownloadReply = 0x60, kSdoAbort = 0x80;

// CiA 402.
namespace drive {
inline constexpr float kOverVoltageFold_v = 2.0F;  // so far below 2231h:1 a drive begins to brake less
inline constexpr std::uint16_t kShutdown = 0x06, kSwitchOn = 0x07, kEnable = 0x0F, kDisableVoltage = 0x00, kQuickStop = 0x02,
                               kFaultReset = 0x80;
enum class State : std::uint8_t {
  not_ready,
  switch_on_disabled,
  ready,
  switched_on,
  operation_enabled,
  quick_stop_active,
  fault_reaction,
  fault
};
constexpr State state(std::uint16_t status) {
  if ((status & 0x4F) == 0x00) return State::not_ready;
  if ((status & 0x4F) == 0x40) return State::switch_on_disabled;
  if ((status & 0x6F) == 0x21) return State::ready;
  if ((status & 0x6F) == 0x23) return State::switched_on;
  if ((status & 0x6F) == 0x27) return State::operation_enabled;
  if ((status & 0x6F) == 0x07) return State::quick_stop_active;
  if ((status & 0x4F) == 0x0F) return State::fault_reaction;
  return State::fault;
}
}  // namespace drive
}  // namespace canopen

static_assert(unique_by(kNodes, [](const NodeInfo& n) { return n.id; }), "can_dictionary.def: a node id is used twice");
static_assert(kNodes.back().kind == NodeKind::host, "can_dictionary.def: the core is the last node");
static_assert(unique_by(kObjects, [](const ObjectInfo& o) { return (static_cast<std::uint64_t>(o.owner) << 32) | (o.index << 8) | o.sub; }),
              "can_dictionary.def: an object is listed twice");
static_assert(all_rows(kObjects,
                       [](const ObjectInfo& o) { return o.min <= o.default_value && o.default_value <= o.max && !o.title.empty(); }),
              "can_dictionary.def: a default lies outside its range");
static_assert(all_rows(kPdoEntries, [](const PdoEntry& e) { return object_row(pdo_info(e.pdo).kind, e.index, e.sub) < kObjects.size(); }),
              "can_dictionary.def: a PDO maps an object that does not exist");
static_assert(all_rows(kPdos,
                       [](const PdoInfo& p) {
                         return p.direction == PdoDirection::tx || object_row(p.kind, pdo_communication_index(p), 5) < kObjects.size();
                       }),
              "can_dictionary.def: an RPDO has no row for its deadline (sub-index 5 of 1400h and up)");
static_assert(all_rows(kPdos, [](const PdoInfo& p) { return pdo_bytes(p.pdo) <= 8 && pdo_bytes(p.pdo) > 0; }),
              "can_dictionary.def: a PDO holds 1 to 8 bytes");
static_assert(all_rows(kParamObjects,
                       [](const ParamObject& o) {
                         const std::size_t row = object_row(o.kind, o.index, o.sub);
                         return row < kObjects.size() && object_bytes(kObjects[row].type) == 4 && kObjects[row].access == Access::rw;
                       }),
              "params.def: a parameter's object does not exist or is not a writable value of 32 bits");
static_assert(all_rows(kKeptObjects,
                       [](const ObjectInfo* o) { return o != nullptr && is_stored(*o) && !is_node_relative(o->index, o->sub); }),
              "can_dictionary.def: a kept object does not exist, is no parameter of its node, or differs from node to node");

}  // namespace hoist::contract
