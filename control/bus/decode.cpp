#include "control/bus/decode.hpp"

#include <bit>
#include <string_view>
#include <utility>

#include "control/bus/object_words.hpp"
#include "control/bus/sdo_client.hpp"
#include "control/contract/can_dictionary.hpp"
#include "control/contract/classify.hpp"
#include "control/contract/emergencies.hpp"

namespace hoist::bus {

using contract::CanFrame;
using contract::CobKind;
using contract::FrameClass;
namespace canopen = contract::canopen;

namespace {

std::string node_name(std::uint8_t id) {
  const auto node = contract::find_node(id);
  return node ? std::string(contract::kNodes[static_cast<std::size_t>(*node)].name) : std::string();
}

bool fits(const CanFrame& frame, const FrameClass& what, DecodedFrame& out) {
  if (!what.fits) out.problem = std::to_string(frame.dlc) + " bytes instead of " + std::to_string(what.bytes);
  return what.fits;
}

double object_value(const std::uint8_t* at, const contract::ObjectInfo& object) {
  const std::uint32_t raw = contract::read_le(at, contract::object_bytes(object.type));
  switch (object.type) {
    case contract::ObjectType::i8:
      return static_cast<std::int8_t>(raw) * object.scale;
    case contract::ObjectType::i16:
      return static_cast<std::int16_t>(raw) * object.scale;
    case contract::ObjectType::i32:
      return static_cast<std::int32_t>(raw) * object.scale;
    case contract::ObjectType::f32:
      return static_cast<double>(std::bit_cast<float>(raw)) * object.scale;
    default:
      return raw * object.scale;
  }
}

void decode_pdo(const CanFrame& frame, const FrameClass& what, DecodedFrame& out) {
  const contract::PdoInfo& pdo = contract::kPdos[what.pdo];
  // "drive_tx1" of the node drive_left is drive_left_tx1, as in the DBC.
  out.name = std::string(contract::kNodes[what.node].name) + std::string(pdo.name.substr(pdo.name.find('_')));
  if (!fits(frame, what, out)) return;
  std::size_t at = 0;
  for (const contract::PdoEntry& entry : contract::kPdoEntries) {
    if (entry.pdo != pdo.pdo) continue;
    const contract::ObjectInfo& object = contract::kObjects[contract::object_row(pdo.kind, entry.index, entry.sub)];
    const std::size_t bytes = contract::object_bytes(object.type);
    std::string words = object_words(pdo.kind, object.index, object.sub, contract::read_le(&frame.data[at], bytes));
    const bool bit_field = bytes == 2 && !words.empty();  // statusword, controlword, error code
    out.fields.push_back(
        {std::string(object.name), object_value(&frame.data[at], object), std::string(object.unit), std::move(words), bit_field});
    at += bytes;
  }
}

void decode_sdo(const CanFrame& frame, const FrameClass& what, DecodedFrame& out) {
  const contract::NodeInfo& info = contract::kNodes[what.node];
  const bool reply = what.kind == CobKind::sdo_reply;
  out.name = std::string(info.name) + (reply ? "_sdo_reply" : "_sdo_request");
  if (!fits(frame, what, out)) return;
  const std::uint32_t index = contract::read_le(&frame.data[1], 2);
  const std::uint8_t sub = frame.data[3];
  // Segments carry data where the others carry an index: no object may be named for them.
  const std::uint8_t command = frame.data[0] >> 5;
  const bool names_object = frame.data[0] == canopen::kSdoAbort || command == 1 || command == 2 || (reply && command == 3);
  const contract::ObjectInfo* object = names_object ? contract::find_object(info.kind, static_cast<std::uint16_t>(index), sub) : nullptr;
  const bool abort = frame.data[0] == canopen::kSdoAbort;
  out.fields.push_back({"command", static_cast<double>(frame.data[0]), {}, abort ? "abort" : "", true});
  out.fields.push_back({"index", static_cast<double>(index), {}, object != nullptr ? std::string(object->name) : std::string(), true});
  out.fields.push_back({"sub", static_cast<double>(sub), {}, {}, true});
  const std::uint32_t value = contract::read_le(&frame.data[4], 4);
  const bool carries_value = object != nullptr && command == (reply ? 2 : 1);  // upload answered, download asked for
  std::string words;
  if (abort)
    words = sdo_abort_text(value);
  else if (carries_value)
    words = object_words(info.kind, object->index, object->sub, value);
  out.fields.push_back({"value", static_cast<double>(value), {}, std::move(words), true});
}

void decode_nmt(const CanFrame& frame, const FrameClass& what, DecodedFrame& out) {
  out.name = "nmt";
  if (!fits(frame, what, out)) return;
  out.fields.push_back({"command", static_cast<double>(frame.data[0]), {}, std::string(nmt_command_words(frame.data[0])), false});
  out.fields.push_back({"node", static_cast<double>(frame.data[1]), {}, frame.data[1] == 0 ? "all" : node_name(frame.data[1]), false});
}

void decode_heartbeat(const CanFrame& frame, const FrameClass& what, DecodedFrame& out) {
  out.name = std::string(contract::kNodes[what.node].name) + "_heartbeat";
  if (fits(frame, what, out))
    out.fields.push_back({"state", static_cast<double>(frame.data[0]), {}, std::string(nmt_state_words(frame.data[0])), false});
}

void decode_emergency(const CanFrame& frame, const FrameClass& what, DecodedFrame& out) {
  const contract::NodeInfo& info = contract::kNodes[what.node];
  out.name = std::string(info.name) + "_emergency";
  if (!fits(frame, what, out)) return;
  std::uint64_t details = 0;
  for (std::size_t i = 5; i > 0; --i) details = (details << 8) | frame.data[2 + i];
  const auto code = static_cast<std::uint16_t>(contract::read_le(&frame.data[0], 2));
  out.fields.push_back({"code", static_cast<double>(code), {}, std::string(contract::emergency_info(code).text_en), true});
  out.fields.push_back({"error_register", static_cast<double>(frame.data[2]), {}, object_words(info.kind, 0x1001, 0, frame.data[2]), true});
  out.fields.push_back({"details", static_cast<double>(details), {}, {}, true});
}

}  // namespace

DecodedFrame decode_frame(const CanFrame& frame) {
  DecodedFrame out;
  if ((frame.flags & CanFrame::kError) != 0) {
    out.name = "error_frame";
    return out;
  }
  const FrameClass what = contract::classify(frame);
  if (what.bytes == contract::kNotPlanned) return out;
  switch (what.kind) {
    case CobKind::nmt:
      decode_nmt(frame, what, out);
      break;
    case CobKind::sync:
      out.name = "sync";
      static_cast<void>(fits(frame, what, out));
      break;
    case CobKind::heartbeat:
      decode_heartbeat(frame, what, out);
      break;
    case CobKind::emergency:
      decode_emergency(frame, what, out);
      break;
    case CobKind::sdo_reply:
    case CobKind::sdo_request:
      decode_sdo(frame, what, out);
      break;
    default:
      decode_pdo(frame, what, out);
  }
  return out;
}

}  // namespace hoist::bus
