// The WebSocket messages as types of the console: subprotocol hoist.v1, from server/contract/messages.def.
#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/commands.hpp"
#include "control/contract/shared_memory.hpp"
#include "deploy/tools/gen/generate.hpp"
#include "server/contract/reasons.hpp"

namespace hoist::gen {
namespace {

struct MessageRow {
  std::string_view type;
  bool incoming;  // from the client to the server
  bool answered;
  std::string_view schema;  // of its fields, from the client
  std::string_view doc;
};
struct FieldRow {
  std::string_view message, name, kind;
  bool required;
  std::string_view doc;
};

#define HOIST_IN(type, answered, role, schema, doc) MessageRow{#type, true, (answered) != 0, #schema, doc},
#define HOIST_OUT(type, doc) MessageRow{#type, false, false, "", doc},
#define HOIST_FIELD(...)
constexpr std::array kMessages{
#include "server/contract/messages.def"
};
#undef HOIST_IN
#undef HOIST_OUT
#undef HOIST_FIELD
#define HOIST_IN(...)
#define HOIST_OUT(...)
#define HOIST_FIELD(type, name, kind, required, doc) FieldRow{#type, name, kind, (required) != 0, doc},
constexpr std::array kFields{
#include "server/contract/messages.def"
};
#undef HOIST_IN
#undef HOIST_OUT
#undef HOIST_FIELD

// lease_take -> LeaseTake
std::string type_name(std::string_view snake) {
  std::string out;
  bool upper = true;
  for (const char c : snake) {
    if (c == '_') {
      upper = true;
      continue;
    }
    out += upper && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    upper = false;
  }
  return out;
}

std::string doc_line(std::string_view indent, std::string_view doc) {
  return doc.empty() ? std::string() : std::string(indent) + "/** " + std::string(doc) + " */\n";
}

std::string message_types(bool incoming) {
  const std::string suffix = incoming ? "Request" : "Message";
  std::string out, all;
  for (const auto& message : kMessages) {
    if (message.incoming != incoming) continue;
    const std::string name = type_name(message.type) + suffix;
    all += "\n  | " + name;
    out += doc_line("", message.doc);
    if (message.incoming) {
      out += "export type " + name + " = { type: '" + std::string(message.type) + "'" + (message.answered ? "; request: number }" : " }") +
             (message.schema == "Empty" ? "" : " & rest." + std::string(message.schema)) + ";\n\n";
      continue;
    }
    out += "export interface " + name + " {\n  type: '" + std::string(message.type) + "';\n";
    for (const auto& field : kFields) {
      if (field.message != message.type) continue;
      out += doc_line("  ", field.doc) + "  " + std::string(field.name) + (field.required ? ": " : "?: ") + std::string(field.kind) + ";\n";
    }
    out += "}\n\n";
  }
  out += std::string(incoming ? "/** What the console may send. */\nexport type ClientMessage ="
                              : "/** What the server sends as text. */\nexport type ServerMessage =");
  return out + all + ";\n\n";
}

// The reasons with their words, which the console shows by name.
std::string reason_rows() {
  std::string out =
      "/** Why something was not done, or is not there. */\n"
      "export const reasons: Readonly<Record<ReasonCode, { en: string; de: string }>> = {\n";
  for (const auto& reason : server::kReasons) out += "  " + std::string(reason.name) + ": " + words(reason.text_en, reason.text_de) + ",\n";
  return out + "};\n\n";
}

}  // namespace

GeneratedFile messages_file() {
  using namespace hoist::contract;
  std::string out =
      "// " + made_from("server/contract/messages.def and reasons.def, control/contract/commands.hpp and can_dictionary.def") + "\n\n";
  out += "import type * as rest from './rest.gen';\n";
  out +=
      "import type { Actor, Exercise, FieldError, GuidedPath, JobKind, LeaseAsk, Pose, ReasonCode, StandingNotice, TaskState, TopicName } "
      "from "
      "'./rest.gen';\n\n";
  out += reason_rows() + message_types(true) + message_types(false);
  out += "/** What the core reports. */\nexport const eventKinds = [";
  // Numbers without a name are gaps.
  constexpr std::uint32_t kKindsMost = 64;
  for (std::uint32_t kind = 0; kind < kKindsMost; ++kind) {
    const auto name = event_name(static_cast<EventKind>(kind));
    if (kind > 0 && name == event_name(EventKind::none)) continue;
    out += "\n  '" + std::string(name) + "',";
  }
  out += "\n] as const;\nexport type EventKind = (typeof eventKinds)[number];\n\nexport type NodeName =";
  for (const auto& node : kNodes) out += "\n  | '" + std::string(node.name) + "'";
  out +=
      ";\n\nexport interface NodeInfo {\n  name: NodeName;\n  id: number;\n  title: string;\n}\n\n"
      "/** The nodes of the bus, in the order of their numbers in events. */\nexport const nodes: readonly NodeInfo[] = [\n";
  for (const auto& node : kNodes) {
    out += "  { name: '" + std::string(node.name) + "', id: " + std::to_string(node.id) + ", title: '" + std::string(node.title) + "' },\n";
  }
  out += "];\n\n/** Two programs with different hashes do not understand each other. */\nexport const layoutHash = '";
  out += hex64(layout_hash());
  return {"web/src/contract/messages.gen.ts", out + "';\n"};
}

}  // namespace hoist::gen
