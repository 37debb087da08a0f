#include "server/api/alarms.hpp"

#include <string>

#include "control/contract/emergencies.hpp"
#include "control/contract/faults.hpp"

namespace hoist::server {

using contract::Fault;

namespace {

std::uint16_t code_of(const contract::TickRecord& record, Fault fault) {
  switch (fault) {
    case Fault::drive_left_fault:
      return record.drive_left_fault_code;
    case Fault::drive_right_fault:
      return record.drive_right_fault_code;
    case Fault::tilt_implausible:
      return record.tilt_implausible_code;
    case Fault::overspeed:
      return record.overspeed_code;
    default:
      return 0;
  }
}

void write_words(JsonWriter& out, std::string_view name, std::string_view en, std::string_view de) {
  out.key(name).begin('{').key("en").table_text(en).key("de").table_text(de).end('}');
}

void write_alarm(JsonWriter& out, const contract::TickRecord& record, Fault fault, std::string_view consequence_of) {
  const contract::FaultInfo& info = contract::fault_info(fault);
  const std::uint16_t code = code_of(record, fault);
  const contract::DetailInfo* detail = contract::find_detail(fault, code);
  out.begin('{').field("name", info.name).field("code", code);
  if (detail != nullptr) {
    write_words(out, "text", detail->text_en, detail->text_de);
    write_words(out, "action", detail->action_en, detail->action_de);
  } else {
    std::string en{info.text_en}, de{info.text_de};
    if (code != 0 && (fault == Fault::drive_left_fault || fault == Fault::drive_right_fault)) {
      const contract::EmergencyInfo& emergency = contract::emergency_info(code);
      en.append(": ").append(emergency.text_en);
      de.append(": ").append(emergency.text_de);
    }
    write_words(out, "text", en, de);
    write_words(out, "action", info.action_en, info.action_de);
  }
  if (consequence_of.empty())
    out.field("consequence_of", nullptr);
  else
    out.field("consequence_of", consequence_of);
  out.end('}');
}

}  // namespace

std::vector<std::string> fault_names(contract::FaultBits bits) {
  std::vector<std::string> names;
  for (const contract::FaultInfo& info : contract::kFaults)
    if ((bits & contract::fault_bit(info)) != 0) names.emplace_back(info.name);
  return names;
}

void write_alarms(JsonWriter& out, const contract::TickRecord& record) {
  out.begin('[');
  contract::FaultBits left = record.fault_bits;
  // A bit that no row has would never be taken.
  contract::FaultBits known = 0;
  for (const contract::FaultInfo& info : contract::kFaults) known |= contract::fault_bit(info);
  left &= known;
  while (left != 0) {
    const Fault cause = contract::headline(left, record.stop_cause);
    write_alarm(out, record, cause, {});
    left &= ~contract::fault_bit(cause);
    for (const contract::Explanation& row : contract::kExplanations) {
      if (row.cause != cause || (left & contract::fault_bit(row.effect)) == 0) continue;
      write_alarm(out, record, row.effect, contract::fault_info(cause).name);
      left &= ~contract::fault_bit(row.effect);
    }
  }
  out.end(']');
}

}  // namespace hoist::server
